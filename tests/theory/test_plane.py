"""Closed forms of sliding in the plane: against mpmath, quadrature of the friction itself, and integrated motions."""

import math
from functools import partial

import casadi as ca
import mpmath as mp
import numpy as np
import pytest
import sympy as sp
from scipy.integrate import solve_ivp

import symfric as sf
from symfric.lower.printer import Printer, Switches
from tests.longer import longer
from tests.reference_cases import values_of

plane = sf.theory.plane
RATIOS = [0.0, 1e-300, 1e-160, 1e-9, 1e-4, 0.03, 0.5, 0.99, 1.0, 1.01, 2.0, 5.0, 30.0, 1e4, 1e9, 1e100, 1e200]
LAWS = {
    "cubic": (sf.laws.cubic(0.4, 0.25, 0.5), lambda s: 0.4 - 0.225 * (s / 0.5 - (s / 0.5) ** 3 / 3)),
    "polynomial": (sf.laws.custom(0.4 - 0.3 * sf.SPEED + 0.2 * sf.SPEED**2 + 0.1 * sf.SPEED**4, 0.4), None),
    "stribeck": (sf.laws.stribeck(0.4, 0.25, 0.2, b=0.02), lambda s: 0.25 + 0.15 * mp.exp(-s / 0.2) + 0.02 * s),
    "lines": (
        sf.laws.piecewise_linear(0.4, [0, 0.2, 0.5], [0.35, 0.25, 0.3]),
        lambda s: 0.35 - 0.5 * s if s < 0.2 else 0.25 + (s - 0.2) / 6,
    ),
}
LAWS["polynomial"] = (LAWS["polynomial"][0], lambda s: 0.4 - 0.3 * s + 0.2 * s**2 + 0.1 * s**4)


def means_across(mu, breaks, v, q):
    """Return drag and power by quadrature over theta, split where the integrand is narrow or breaks."""
    v, q = mp.mpf(v), mp.mpf(q)
    levels = [*breaks, *(mp.hypot(v, k * v) for k in (1, 10, 100, 1000))]
    splits = sorted({mp.asin(mp.sqrt(b**2 - v**2) / q) for b in levels if v < b < mp.hypot(v, q)})
    slip = lambda a: mp.hypot(v, q * mp.sin(a))  # noqa: E731
    edges = [0, *splits, mp.pi / 2]
    drag = mp.quad(lambda a: mu(slip(a)) * v / slip(a), edges)
    return 2 * drag / mp.pi, 2 * mp.quad(lambda a: mu(slip(a)) * (q * mp.sin(a)) ** 2 / slip(a), edges) / mp.pi


# -- vibration


@pytest.mark.one_in(2)
@pytest.mark.parametrize(("word", "speed"), [("r=.5", 2.0), ("1", 1.0), ("2", 0.5), ("5", 0.2)])
def test_drag_under_lateral_vibration_is_the_known_one(word, speed):
    known = values_of("lateral_vibration_drag")[word]
    assert plane.lateral_vibration_drag(speed, 1.0) == pytest.approx(known, rel=1e-13)
    assert sf.laws.coulomb(1.0).averaged_across(1.0)(speed) == pytest.approx(known, rel=1e-13)


@pytest.mark.parametrize("scale", [1e-3, 1.0, 1e5])
def test_coulomb_drag_and_power_on_every_scale(scale):
    ratios = np.array(RATIOS[1:])  # speed over intensity
    drag = plane.lateral_vibration_drag(ratios * scale, scale)
    power = plane.lateral_vibration_power(ratios * scale, scale) / scale
    with mp.workdps(700):
        for r, d, p in zip(ratios, drag, power, strict=True):
            total, r = mp.hypot(mp.mpf(float(r)), 1), mp.mpf(float(r))
            K, E = mp.ellipk(1 / total**2), mp.ellipe(1 / total**2)
            assert d == pytest.approx(float(2 / mp.pi * r / total * K), rel=1e-13)
            assert p == pytest.approx(float(2 / mp.pi * (total * E - r**2 / total * K)), rel=1e-13)
    assert plane.lateral_vibration_drag(0.0, scale) == 0.0
    assert plane.lateral_vibration_drag(1.0, 0.0) == 1.0
    assert plane.lateral_vibration_power(0.0, scale) == pytest.approx(2 * scale / np.pi, rel=1e-14)
    assert plane.lateral_vibration_power(1.0, 0.0) == 0.0


@pytest.mark.one_in(12)
@pytest.mark.parametrize("q", [0.07, 0.4, 3.0])
@pytest.mark.parametrize("name", LAWS)
def test_drag_and_power_of_laws_of_the_speed(name, q):
    law, mu = LAWS[name]
    effective = law.averaged_across(q)
    breaks = [float(b) for b in law.breaks]
    with mp.workdps(20):
        for v in (1e-5, 0.19, 1.1):
            drag, power = (float(e) for e in means_across(mu, breaks, v, q))
            assert effective(v) == pytest.approx(drag, rel=3e-13, abs=1e-15)
            assert effective(-v) == -effective(v)
            assert plane.lateral_vibration_drag(v, q, law) == pytest.approx(drag, rel=1e-13)
            assert plane.lateral_vibration_power(v, q, law) == pytest.approx(power, rel=1e-13)


@pytest.mark.one_in(4)
@pytest.mark.parametrize("name", LAWS)
def test_dissipation_is_shared_between_sliding_and_vibration(name):
    law, mu = LAWS[name]
    for v, q in ((0.1, 0.3), (0.3, 0.1), (0.2, 0.9)):
        levels = [0, *(s * float(b) for b in law.breaks for s in (-1, 1))]
        splits = sorted(mp.acos((w - v) / q) for w in levels if abs(w - v) < q)
        along = mp.quad(lambda a, v=v, q=q: mu(abs(v + q * mp.cos(a))) * abs(v + q * mp.cos(a)), [0, *splits, mp.pi])
        taken = plane.longitudinal_vibration_drag(v, q, law) * v + plane.longitudinal_vibration_power(v, q, law)
        assert taken == pytest.approx(float(along / mp.pi), rel=2e-12)


def test_coulomb_law_along_is_the_averaged_one_and_its_power_closed():
    v, q = np.array([0.0, 0.3, 0.999, 1.0, 2.0]), 1.0
    expected = np.where(v < q, 2 / np.pi * np.arcsin(np.minimum(v, 1)), 1.0)
    assert plane.longitudinal_vibration_drag(v, q) == pytest.approx(expected, rel=1e-14)
    for a in (0.0, 0.3, 0.999, 2.0):
        quadrature = plane.longitudinal_vibration_power(a, q, sf.laws.coulomb(1.0))
        assert plane.longitudinal_vibration_power(a, q) == pytest.approx(quadrature, rel=1e-12, abs=1e-15)


@pytest.mark.one_in(2)
@pytest.mark.parametrize("name", LAWS)
def test_drag_along_is_that_of_the_averaged_law(name):
    """A quadrature over the phase, and the law that is averaged as an expression: also where the slip just stops."""
    law, _ = LAWS[name]
    for q in (1e-3, 0.199999, 0.2, 0.3, 2.5):
        averaged = law.averaged(q)
        for v in (0.01, 0.2, 0.5, 3.0):
            assert plane.longitudinal_vibration_drag(v, q, law) == pytest.approx(float(averaged(v)), abs=1e-12)


def test_lowered_law_is_the_same_to_rounding_with_its_derivative():
    q = sp.Symbol("q", positive=True)
    v, a = ca.SX.sym("v"), ca.SX.sym("q")
    for law in (sf.laws.coulomb(1.0), sf.laws.cubic(0.4, 0.25, 0.5)):
        value = Printer({sf.SPEED: v, q: a}, set(), Switches())(law.averaged_across(q).kinetic)
        evaluate = ca.Function("drag", [v, a], [value, ca.jacobian(value, v), ca.jacobian(value, a)])
        for speed, intensity in ((2e-9, 1.0), (1e-3, 0.7), (0.4, 0.4), (3.0, 0.2), (1e4, 1e-3)):
            drag = partial(plane.lateral_vibration_drag, law=None if law.kinetic.is_number else law)
            found, slope, by_q = (float(e) for e in evaluate(speed, intensity))
            assert found == pytest.approx(drag(speed, intensity), rel=2e-15 if law.kinetic.is_number else 1e-13)
            h = 1e-4
            for derivative, change in ((slope, (h, 0)), (by_q, (0, h))):
                pairs = [(speed * (1 + s * change[0]), intensity * (1 + s * change[1])) for s in (-2, -1, 1, 2)]
                f = [drag(*p) for p in pairs]
                x = (f[0] - 8 * f[1] + 8 * f[2] - f[3]) / (12 * h) / (speed if change[0] else intensity)
                assert derivative == pytest.approx(x, rel=1e-8, abs=1e-10 * abs(found) / h / intensity)


def forced_sliding(frequency, law, q=0.6):
    """Return a mass on a spring that slides under imposed vibration across, velocity and place after a fixed time."""

    def rates(t, y):
        slip = math.hypot(y[1], q * math.cos(frequency * t))
        return [y[1], 1.0 - 0.2 * y[0] - law(slip) * y[1] / slip if slip else 0.0]

    return solve_ivp(rates, (0, 4), [0.0, 0.3], "DOP853", rtol=1e-9, atol=1e-10).y[:, -1]


@pytest.mark.long(beside="test_mass_swings_through_zero_speed_under_vibration_across")
def test_slow_motion_tends_to_that_with_the_averaged_law():
    law = sf.laws.cubic(0.5, 0.3, 0.8)
    x, u = sp.symbols("x u", real=True)
    system = sf.System([x], [u], [[1]], [1 - 0.2 * x])
    contact = sf.Contact("table", u, 1, law.averaged_across(0.6))
    slow = sf.simulate(sf.Scene(system, [contact], {}, {x: 0.0, u: 0.3}, 4.0), tolerance=1e-11).checked().final
    mu = lambda s: 0.5 - 0.3 * (s / 0.8 - (s / 0.8) ** 3 / 3)  # noqa: E731
    errors = [np.max(np.abs(forced_sliding(w * np.pi, mu) - slow)) for w in (8, 16, 32)]
    assert errors[0] < 0.02
    assert all(1.7 < a / b for a, b in zip(errors, errors[1:], strict=False))  # at least first order in 1/frequency


@pytest.mark.parametrize("horizon", longer([4.0, 12.0], [12.0]))
def test_mass_swings_through_zero_speed_under_vibration_across(horizon):
    law = sf.laws.coulomb(0.4).averaged_across(0.3)
    x, u = sp.symbols("x u", real=True)
    scene = sf.Scene(sf.System([x], [u], [[1]], [-x]), [sf.Contact("floor", u, 1, law)], {}, {x: 1.0, u: 0.0}, horizon)
    run = sf.simulate(scene, tolerance=1e-11).checked()

    def rates(_, y):
        a, b = math.hypot(y[1], 0.3), abs(y[1])
        for _ in range(9):
            a, b = (a + b) / 2, math.sqrt(a * b)
        return [y[1], -y[0] - 0.4 * y[1] / a]

    other = solve_ivp(rates, (0, horizon), [1, 0], "DOP853", rtol=1e-11, atol=1e-13)
    assert run.final == pytest.approx(other.y[:, -1], abs=1e-10)


def test_which_direction_is_better():
    found = plane.compare_vibration(np.geomspace(0.01, 1e3, 16))
    ratio = plane.equal_drag_ratio()
    assert found.better == tuple("across" if q < ratio else "along" for q in found.intensity)
    assert set(found.better_for_power) == {"along"}
    power = plane.longitudinal_vibration_power(1.0, found.same_power_intensity)
    assert power == pytest.approx(found.lateral_power, rel=1e-12)
    r = mp.findroot(
        lambda r: mp.ellipk(r**2 / (1 + r**2)) / mp.sqrt(1 + r**2) - mp.asin(1 / r), (1.01, 1.2), solver="anderson"
    )
    assert ratio == pytest.approx(float(r), rel=1e-13)
    other = plane.compare_vibration(np.geomspace(0.01, 1e3, 16) * 0.3, 0.3, sf.laws.coulomb(1.0))
    assert other.same_power_drag == pytest.approx(found.same_power_drag, rel=1e-9)
    assert plane.equal_drag_ratio(0.3, sf.laws.coulomb(0.2)) == pytest.approx(ratio, rel=1e-10)


def test_vibration_along_feeds_on_friction_that_falls():
    law = sf.laws.stribeck(0.5, 0.2, 0.3)
    found = plane.compare_vibration([0.1, 0.5, 2.0], 0.4, law)
    assert found.longitudinal_power[0] < 0 < found.lateral_power[0]
    known = np.isfinite(found.same_power_intensity)
    again = plane.longitudinal_vibration_power(0.4, found.same_power_intensity[known], law)
    assert again == pytest.approx(found.lateral_power[known], rel=1e-10)


@pytest.mark.long(beside="test_least_intensity_for_other_laws")
@pytest.mark.parametrize("v", [0.1, 0.2, 0.3, 0.38, 0.42])
def test_least_intensity_that_quenches(v):
    law, belt = sf.laws.cubic(0.4, 0.25, 0.5), sf.scenes.mass_on_belt(v_b=v)
    found = plane.compare_quenching(law, v, damping=2 * 0.05)
    assert found.along == pytest.approx(sf.theory.belt.quench_intensity_at(belt, v), rel=1e-10)
    margins = []
    for q in (0.99 * found.across, 1.01 * found.across):
        margins.append(sf.stability(sf.scenes.mass_on_belt(law.averaged_across(q), v_b=v)).margin)
    assert margins[0] < 0 < margins[1]
    assert found.across < found.along
    assert found.power_along < found.power_across


@pytest.mark.parametrize("name", ["stribeck", "lines"])
def test_least_intensity_for_other_laws(name):
    law = LAWS[name][0]
    found = plane.compare_quenching(law, 0.15)
    for q, drag in ((found.across, plane.lateral_vibration_drag), (found.along, plane.longitudinal_vibration_drag)):
        if q != 0.15:  # where the slope jumps
            low, high = (drag(0.15 + h, q, law) for h in (-1e-6, 1e-6))
            assert (high - low) / 2e-6 == pytest.approx(0, abs=1e-8)
    assert plane.compare_quenching(law, 0.15, damping=5.0).across == 0.0


# -- damping


@pytest.mark.parametrize("name", LAWS)
def test_damping_across_is_the_slope_of_the_friction(name):
    law, mu = LAWS[name]
    for v in (0.05, 0.35, 2.0):
        across = lambda w, v=v: mu(mp.hypot(v, w)) * w / mp.hypot(v, w)  # noqa: E731
        assert plane.transverse_damping(law, v, 3.0) == pytest.approx(3 * float(mp.diff(across, 0)), rel=1e-12)
        assert plane.steady_power(law, v, 3.0) == pytest.approx(3 * v * float(mu(v)), rel=1e-14)
        q = 1e-3 * v
        little = plane.lateral_vibration_power(v, q, law)
        assert little == pytest.approx(plane.transverse_damping(law, v) * q**2 / 2, rel=1e-5)
        fall = law(v) - plane.lateral_vibration_drag(v, q, law)
        assert fall == pytest.approx(float(mu(v) - v * mp.diff(mu, v)) * q**2 / (4 * v**2), rel=1e-3)


# -- disc


def disc_by_quadrature(eps):
    """Return force and torque over the disc about its instantaneous centre, in units of mu N and mu N R."""
    eps = mp.mpf(eps)

    def over(weight):
        def ring(phi):
            reach = [r for r in _crossings(eps, phi) if r > 0]
            inside = [0] if eps < 1 else []
            edges = inside + reach
            return sum(mp.quad(lambda r: weight(r, phi), edges[k : k + 2]) for k in range(0, len(edges) - 1, 2))

        top = mp.pi if eps < 1 else mp.asin(1 / eps)
        angles = [0, mp.pi / 2, mp.pi] if eps < 1 else [0, top]
        return 2 * mp.quad(ring, angles) / mp.pi

    # polar coordinates (r, phi) about the instantaneous centre, at the distance eps from the middle: the friction of an
    # element is perpendicular to r, of size 1/pi per area r dr dphi
    force = over(lambda r, phi: mp.cos(phi) * r)
    torque = over(lambda r, phi: (r - eps * mp.cos(phi)) * r)
    return force, torque


def _crossings(eps, phi):
    root = mp.sqrt(max(mp.mpf(0), 1 - (eps * mp.sin(phi)) ** 2))
    return [eps * mp.cos(phi) - root, eps * mp.cos(phi) + root]


@pytest.mark.one_in(6)
@pytest.mark.parametrize("eps", [0.05, 0.6, 0.97, 1.04, 3.0])
def test_disc_friction_is_the_integral_over_the_disc(eps):
    with mp.workdps(15):
        force, torque = (float(e) for e in disc_by_quadrature(eps))
    found = plane.spinning_disc_friction(2 * 0.7 * eps, 0.7, R=2.0, load=3.0)
    assert found.force == pytest.approx(3 * force, rel=1e-11)
    assert found.torque == pytest.approx(6 * torque, rel=1e-11)


def disc_closed(eps):
    """Return force and torque by the elliptic integrals in 60 digits, also for eps above 1."""
    with mp.workdps(60):
        eps = mp.mpf(eps)
        if eps == 1:
            return mp.mpf(8) / (3 * mp.pi), mp.mpf(8) / (9 * mp.pi)
        if eps < 1:
            K, E = mp.ellipk(eps**2), mp.ellipe(eps**2)
        else:
            K1, E1 = mp.ellipk(1 / eps**2), mp.ellipe(1 / eps**2)
            K, E = K1 / eps, eps * E1 - (eps - 1 / eps) * K1
        e2 = eps**2
        return 4 / (3 * mp.pi * eps) * ((e2 + 1) * E + (e2 - 1) * K), 4 / (9 * mp.pi) * (
            (4 - 2 * e2) * E + (e2 - 1) * K
        )


NEAR_ONE = [1 - 1e-3, 1 - 1e-9, 1 - 2**-53, 1.0, 1 + 2**-52, 1 + 1e-9, 1 + 1e-3]


def test_disc_friction_on_every_scale():
    for eps in [*NEAR_ONE, *np.geomspace(1e-12, 1e12, 49)]:
        force, torque = (float(e) for e in disc_closed(float(eps)))
        found = plane.spinning_disc_friction(eps, 1.0)
        assert found.force == pytest.approx(force, rel=5e-15)
        assert found.torque == pytest.approx(torque, rel=5e-15)
        assert plane.spinning_disc_friction(-eps, -1.0) == (-found.force, -found.torque)
    assert plane.spinning_disc_friction(2.0, 0.0) == (1.0, 0.0)
    assert plane.spinning_disc_friction(0.0, 2.0, R=3.0, load=2.0) == pytest.approx((0.0, 4.0), rel=1e-15)
    assert plane.spinning_disc_friction(0.0, 0.0) == (0.0, 0.0)
    grid = plane.spinning_disc_friction(np.ones((3, 1)), np.ones(4))
    assert grid.force.shape == grid.torque.shape == (3, 4)


def test_disc_expressions_are_the_same_in_sympy_and_casadi():
    u, w, om, R = sp.symbols("u w omega R", real=True)
    symbols = {s: ca.SX.sym(s.name) for s in (u, w, om, R)}
    printer = Printer(symbols, set(), Switches())
    forces = plane.disc_expressions(u, w, om, R)
    evaluate = ca.Function("disc", list(symbols.values()), [printer(f) for f in forces])
    slope = ca.Function("slope", list(symbols.values()), [ca.jacobian(printer(forces[0]), symbols[u])])
    for speed in [*NEAR_ONE, 0.0, 1e-12, 1e-5, 0.3, 4.0, 1e5, 1e12]:
        for angle, spin, radius in ((0.4, 0.5, 2.0), (2.5, -3.0, 0.1)):
            v = speed * abs(spin) * radius
            found = [float(e) for e in evaluate(v * math.cos(angle), v * math.sin(angle), spin, radius)]
            force, torque = plane.spinning_disc_friction(v, spin, radius)
            expected = [-force * math.cos(angle), -force * math.sin(angle), -torque]
            bridged = abs(speed - 1) < 1e-6  # as the docstring says
            assert found == pytest.approx(expected, rel=1e-8 if bridged else 1e-13, abs=1e-15 * radius)
    assert float(slope(1e-9, 0.0, 1.0, 1.0)) == pytest.approx(-1.0, rel=1e-12)  # a damper at little sliding
    assert np.isfinite(float(slope(0.5, 0.0, 0.0, 1.0)))


def test_disc_stops_sliding_and_spinning_at_once():
    time, distance = values_of("disc_stops_both_at_once")
    found = plane.disc_stop(0.5, 1.0, R=1.0, m=1.0, mu=1.0, g=1.0)
    assert found.time == pytest.approx(time, rel=1e-10)
    assert found.distance == pytest.approx(distance, rel=1e-10)
    assert found.ratio == pytest.approx(0.6530017892, rel=1e-10)


@pytest.mark.one_in(4)
@pytest.mark.parametrize(
    ("v", "omega", "inertia"), [(0.5, 1.0, 0.5), (3.0, 0.2, 0.5), (0.1, 5.0, 0.8), (1.0, 1.0, 0.2)]
)
def test_disc_loses_its_energy_in_plain_time(v, omega, inertia):
    R, mu, g = 0.3, 0.4, 9.81
    found = plane.disc_stop(v, omega, R=R, m=2.0, mu=mu, g=g, inertia=inertia)
    share = 0.999

    def rates(_, y):
        force, torque = plane.spinning_disc_friction(y[0], y[1], R, mu * g)
        return [-force, -torque / (inertia * R**2), y[0], y[1]]

    run = solve_ivp(rates, (0, share * found.time), [v, omega, 0, 0], "DOP853", rtol=1e-12, atol=1e-15)
    left = plane.disc_stop(run.y[0, -1], run.y[1, -1], R=R, m=2.0, mu=mu, g=g, inertia=inertia)
    assert share * found.time + left.time == pytest.approx(found.time, rel=1e-11)
    assert run.y[2, -1] + left.distance == pytest.approx(found.distance, rel=1e-10)
    assert run.y[3, -1] + left.angle == pytest.approx(found.angle, rel=1e-10)


@pytest.mark.long(beside="test_disc_loses_its_energy_in_plain_time")
@pytest.mark.parametrize(
    "start", longer([(0.3, 0.4, 1.0), (1.2, -0.5, 0.3)], [(0.3, 0.4, 1.0)])
)  # one passes v = R omega
def test_disc_in_a_scene_moves_towards_its_stop(start):
    q, u = sp.symbols("x y phi", real=True), sp.symbols("u w omega", real=True)
    system = sf.System(q, u, [[1, 0, 0], [0, 1, 0], [0, 0, 0.5]], list(plane.disc_expressions(*u, 1.0)))
    known = partial(plane.disc_stop, R=1.0, m=1.0, mu=1.0, g=1.0)
    stop = known(math.hypot(*start[:2]), start[2])
    initial = dict(zip([*q, *u], [0.0, 0.0, 0.0, *start], strict=True))
    final = sf.simulate(sf.Scene(system, [], {}, initial, 0.9 * stop.time), tolerance=1e-11).checked().final
    left = known(math.hypot(*final[3:5]), final[5])
    assert 0.9 * stop.time + left.time == pytest.approx(stop.time, abs=1e-11)
    assert math.hypot(*final[:2]) + left.distance == pytest.approx(stop.distance, abs=1e-11)


@pytest.mark.one_in(2)
@pytest.mark.parametrize("tolerance", longer([1e-3, 1e-4, 1e-5, 1e-6, 1e-7], [1e-4, 1e-5, 1e-6, 1e-7]))
def test_a_disc_passes_its_corner_at_loose_tolerances(tolerance):
    """At v = R omega the last terms of a series may bring the switch between the formulas back in every step."""
    q, u, start = sp.symbols("x y phi", real=True), sp.symbols("u w omega", real=True), (1.0, 0.0, 0.4)
    system = sf.System(q, u, [[1, 0, 0], [0, 1, 0], [0, 0, 0.5]], list(plane.disc_expressions(*u, 1.0)))
    known = partial(plane.disc_stop, R=1.0, m=1.0, mu=1.0, g=1.0)
    stop = known(start[0], start[2])
    scene = sf.Scene(system, [], {}, dict(zip([*q, *u], [0.0, 0.0, 0.0, *start], strict=True)), 0.99 * stop.time)
    run = sf.simulate(scene, tolerance, sf.Taylor(max_steps=2000)).checked()
    final, left = run.final, known(math.hypot(*run.final[3:5]), run.final[5])
    assert math.hypot(*final[:2]) + left.distance == pytest.approx(stop.distance, abs=20 * tolerance)


@pytest.mark.parametrize("inertia", [0.2501, 0.3, 0.5, 0.6, 0.6665])
def test_ratio_at_the_stop_is_kept_by_the_motion(inertia):
    ratio = plane.disc_stop_ratio(inertia)
    force, torque = plane.spinning_disc_friction(ratio, 1.0)
    assert force * inertia == pytest.approx(ratio * torque, rel=1e-13)


def test_disc_that_only_slides_or_only_spins():
    slides = plane.disc_stop(2.0, 0.0, R=0.3, m=1.0, mu=0.4, g=10.0)
    assert (slides.time, slides.distance, slides.angle, slides.ratio) == pytest.approx((0.5, 0.5, 0.0, math.inf))
    spins = plane.disc_stop(0.0, 6.0, R=0.3, m=1.0, mu=0.4, g=10.0)
    little = plane.disc_stop(1e-9, 6.0, R=0.3, m=1.0, mu=0.4, g=10.0)
    assert (spins.time, spins.angle) == pytest.approx((little.time, little.angle), rel=1e-5)
    assert plane.disc_stop_ratio(0.7) == 0.0
    assert plane.disc_stop_ratio(0.2) == math.inf


# -- ball


@pytest.mark.parametrize("inertia", [0.4, 2 / 3])
def test_ball_slides_then_rolls(inertia):
    rng = np.random.default_rng(7)
    for _ in range(5):
        (vx, vy, ox, oy), r, mu, g = rng.normal(size=4), rng.uniform(0.05, 2), rng.uniform(0.1, 0.6), 9.81
        found = plane.ball_rolls((vx, vy), (ox, oy), r=r, mu=mu, g=g, inertia=inertia)

        def rates(_, y, r=r, mu=mu, g=g):
            slip = np.array([y[0] - r * y[3], y[1] + r * y[2]])
            force = -mu * g * slip / np.hypot(*slip)
            spin = np.array([r * force[1], -r * force[0]]) / (inertia * r**2)
            return [*force, *spin, y[0], y[1], np.hypot(y[0], y[1])]

        run = solve_ivp(rates, (0, found.time * (1 - 1e-9)), [vx, vy, ox, oy, 0, 0, 0], rtol=1e-12, atol=1e-14)
        end = run.y[:, -1]
        assert [end[0] - r * end[3], end[1] + r * end[2]] == pytest.approx([0, 0], abs=1e-8)
        assert (*found.velocity, *found.place, found.distance) == pytest.approx(
            (*end[:2], *end[4:]), rel=1e-7, abs=1e-8
        )


def test_ball_that_rolls_already():
    assert plane.ball_rolls((1.0, 0.0), (0.0, 2.0), r=0.5, mu=0.3) == plane.BallRolls(0.0, (0.0, 0.0), (1.0, 0.0), 0.0)


# -- incline


def test_block_stops_on_the_incline_where_it_is_known_to():
    slope, known = math.radians(20), values_of("incline_planar")
    rest = plane.incline_stop(slope, 1.5 * math.tan(slope), 1.0)
    assert (rest.time, rest.downslope, rest.cross) == pytest.approx(
        (known["stop_time"], known["downslope"], known["cross"]), rel=1e-13
    )
    ratio = plane.incline_motion(slope, math.tan(slope), 1.0, math.pi / 2, 1e-9).speed
    assert ratio == pytest.approx(known["k1_final_speed_ratio"], rel=1e-12)


def by_quadrature(p, d, v, start, end):
    """Return speed, time, place by the equations over theta in 25 digits."""
    speed = lambda a: v * mp.exp(-mp.quad(lambda s: (mp.cos(s) - d / p) / mp.sin(s), [start, a]))  # noqa: E731
    way = lambda weight: mp.quad(lambda a: -weight(a) * speed(a) / (p * mp.sin(a)), [start, end])  # noqa: E731
    place = [way(lambda a: speed(a) * mp.cos(a)), way(lambda a: speed(a) * mp.sin(a))]
    return speed(end), way(lambda _: 1), *place


@pytest.mark.one_in(6)
@pytest.mark.parametrize(("start", "end"), [(1.2, 1.0), pytest.param(2.9, 0.3, marks=pytest.mark.long)])
@pytest.mark.parametrize("k", [0.0, 0.4, 0.5, 1.0, 2.3])
def test_motion_on_the_incline_by_the_equations_over_the_direction(k, start, end):
    slope, v, g = 0.35, 0.7, 9.81
    mu = k * math.tan(slope)
    with mp.workdps(15):
        p, d = g * mp.sin(slope), mu * g * mp.cos(slope)
        found = plane.incline_motion(slope, mu, v, start, end, g)
        expected = [float(e) for e in by_quadrature(p, d, mp.mpf(v), mp.mpf(start), mp.mpf(end))]
        assert [found.speed, found.time, found.downslope, found.cross] == pytest.approx(expected, rel=1e-11)


@pytest.mark.parametrize("direction", [0.0, 1e-9, 0.4, 1.6, 3.0, math.pi - 1e-9, math.pi])
@pytest.mark.parametrize("slope", [0.0, 1e-7, 0.3, 0.8])
def test_stop_is_the_end_of_the_motion(slope, direction):
    mu = 0.2 + 1.1 * math.tan(slope)
    rest = plane.incline_stop(slope, mu, 1.3, direction)
    cartesian = [-1.3, 0, 0] if direction == math.pi else None
    if slope and cartesian is None and direction:
        z = direction * 1e-8
        end = plane.incline_motion(slope, mu, 1.3, direction, z)
        left = plane.incline_stop(slope, mu, end.speed, z)
        assert rest.time == pytest.approx(end.time + left.time, rel=1e-12)
        assert rest.downslope == pytest.approx(end.downslope + left.downslope, rel=1e-11, abs=1e-13)
        assert rest.cross == pytest.approx(end.cross, rel=1e-11, abs=1e-15)
    else:
        d, p = mu * 9.81 * math.cos(slope), 9.81 * math.sin(slope) * math.cos(direction)
        assert rest.time == pytest.approx(1.3 / (d - p), rel=1e-12)
        assert math.hypot(rest.downslope, rest.cross) == pytest.approx(1.3**2 / (2 * (d - p)), rel=1e-12)


@pytest.mark.parametrize("k", [0.2, 0.5, 0.9])
def test_fast_turn_has_the_stated_order(k):
    slope = 0.4
    angles = [1e-2, 1e-3, 1e-4]
    least = [plane.incline_least_speed(slope, k * math.tan(slope), 1.0, math.pi - a) for a in angles]
    orders = [math.log10(a / b) for a, b in zip(least, least[1:], strict=False)]
    assert orders == pytest.approx([1 + k, 1 + k], abs=1e-4)
    around = plane.incline_motion(slope, k * math.tan(slope), 1.0, math.pi - 1e-2, math.acos(k) + 1e-3).speed
    assert around > least[0]


# -- refusals


REFUSED = {
    "speed is -1": lambda: plane.lateral_vibration_drag(-1.0, 1.0),
    "intensity is nan": lambda: plane.longitudinal_vibration_power(1.0, math.nan),
    "shapes that broadcast": lambda: plane.lateral_vibration_power([1.0, 2.0], [1.0, 2.0, 3.0]),
    "law is 0.4": lambda: plane.lateral_vibration_drag(1.0, 1.0, 0.4),
    "no number for mu": lambda: plane.lateral_vibration_drag(1.0, 1.0, sf.laws.coulomb(sp.Symbol("mu"))),
    "has memory": lambda: plane.transverse_damping(sf.laws.dahl(0.3, 10.0), 1.0),
    "average across": lambda: sf.laws.stribeck(0.4, 0.3, 0.1).averaged_across(sp.Symbol("q")),
    "must not be negative": lambda: sf.laws.coulomb(0.4).averaged_across(-1.0),
    "a mean over fast": lambda: sf.laws.stribeck(0.4, 0.3, 0.1).averaged_across(0.1).averaged(0.1),
    "speed is 0": lambda: plane.transverse_damping(sf.laws.coulomb(0.3), 0.0),
    "R is -1": lambda: plane.spinning_disc_friction(1.0, 1.0, R=-1.0),
    "slope is 2": lambda: plane.incline_stop(2.0, 1.0, 1.0),
    "direction is 4": lambda: plane.incline_stop(0.2, 1.0, 1.0, 4.0),
    "later <= direction": lambda: plane.incline_motion(0.2, 1.0, 1.0, 1.0, 1.5),
    "inertia is 0": lambda: plane.disc_stop(1.0, 1.0, R=1.0, m=1.0, mu=0.1, inertia=0.0),
    "velocity": lambda: plane.ball_rolls(1.0, r=1.0, mu=0.3),
}


@pytest.mark.one_in(3)
@pytest.mark.parametrize("words", REFUSED)
def test_bad_input_is_one_line(words):
    with pytest.raises(sf.SceneError, match=words) as refused:
        REFUSED[words]()
    assert "\n" not in str(refused.value)


def test_what_does_not_exist_is_not_found():
    with pytest.raises(sf.NotFound, match="does not stop"):
        plane.incline_stop(0.3, 0.1, 1.0)
    with pytest.raises(sf.NotFound, match="falls to zero"):
        plane.incline_least_speed(0.3, 0.5, 1.0, 1.0)
    with pytest.raises(sf.NotFound, match="less drag at every intensity"):
        plane.equal_drag_ratio(1.0, sf.laws.custom(sf.SPEED**2, 0.0))
