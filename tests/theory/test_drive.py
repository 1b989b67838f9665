"""Thresholds, positioning errors and slope limits: the source's cases, and SciPy's DOP853 on the raw equations."""

import math
import time

import mpmath
import numpy as np
import pytest
import sympy as sp
from scipy import integrate, optimize

import symfric as sf
from symfric.theory import drive
from symfric.theory.drive.excursion import FreeResponse, excursion

TIGHT = {"rtol": 3e-14, "atol": 1e-15, "method": "DOP853"}
FINITE = [
    (-0.1, 0.5, -0.1),
    (-0.3, 0.3, -0.2),
    (-0.6, 0.2, -0.5),
    (-0.9, 0.5, -0.4),
    (0.0, 0.4, -0.3),
    (0.2, 0.4, -0.3),
    (-1.0, 0.6, -0.7),
    (-2.0, 0.7, -0.8),
    (1.0, 0.3, -0.5),
    (1.7, 0.3, -0.5),
    (0.0, 1.5, 0.95),  # a corner above the drive's speed has a threshold beyond mu2 = 1
    (0.0, 1.0, 0.8),
    (-0.2, 0.5, 0.0),
]
ZERO = [(-0.5, 0.1, -0.1), (-0.5, 0.0, -0.9), (-1.0, 0.5, -0.1), (-1.5, 0.4, -0.3), (-0.2, 0.5, 1.0), (-1.0, 0.6, 0.0)]
STOPS = [
    (-0.1, 0.5, 0.5),
    (-0.5, 1.5, 2.0),
    (-0.5, 0.8, 4.0),
    (-1.5, 2.0, 5.0),
    (-0.5, 1.0, 2.0),
    (-1.0, 0.7, 0.1),
    (-1.0, 1.0, 3.0),
    (-1.0, 1.4, 0.1),
    (0.0, 0.3, 3.0),
    (0.4, 0.2, 3.0),
    (2.5, 0.5, 30.0),
    (-3.0, 0.1, 0.01),
    (-0.7, 12.0, 30.0),
]


def force(speed, mu1, mu2, corner):
    """Kinetic force less its value at rest."""
    return 2 * mu1 * min(speed, corner) + 2 * mu2 * max(speed - corner, 0.0)


def slowest_speed(motion, start):
    """Integrate from the end of a stick to the first minimum of the speed, or until it is far below the start."""

    def slowest(t, y):
        return motion(t, y)[1]

    def far(_t, y):
        return y[1] - start[1] + 10

    slowest.terminal, slowest.direction, far.terminal = True, 1, True
    return integrate.solve_ivp(motion, (0, 400), start, events=(slowest, far), max_step=0.1, **TIGHT).y[1, -1]


def sticks_again(mu1, mu2, p_star, eps1, f1c=0.7):
    """Whether the motion x'' + f1(x' + 1) + x = 0 comes back to x' = -1 after the release."""

    def motion(_t, y):
        return y[1], -y[0] - f1c - force(1 + y[1], mu1, mu2, 1 + p_star)

    return slowest_speed(motion, [-f1c - eps1, -1.0]) < -1


def stopping_distance(mu1, mu2, lam, speed=0.0):
    """Integrate y'' + f(y') - f_c + y = 0 from y = -lam until the slide rests."""

    def motion(_t, y):
        return y[1], -y[0] - force(y[1], mu1, mu2, 1.0)

    def rest(_t, y):
        return y[1]

    rest.terminal, rest.direction = True, -1
    run = integrate.solve_ivp(motion, (0, 400), [-lam, speed], events=rest, max_step=0.05, **TIGHT)
    return run.y_events[0][0][0] + lam


@pytest.mark.parametrize(
    ("case", "value"),
    [*zip(FINITE[:4], (6.3940747605571819, 1.8590993575312826, 1.8350164158298183, 7.5763089731579039), strict=True)],
)
def test_thresholds_of_the_maps(case, value):
    assert drive.threshold(*case) == pytest.approx(value, rel=4e-15)


@pytest.mark.one_in(3)
@pytest.mark.parametrize("case", FINITE)
def test_the_slide_sticks_again_above_the_threshold_and_not_below(case):
    eps1 = drive.threshold(*case) * (1 + case[2])
    assert 0 < eps1 < math.inf
    assert not sticks_again(*case, eps1 * (1 - 1e-8))
    assert sticks_again(*case, eps1 * (1 + 1e-8))


@pytest.mark.parametrize("case", ZERO)
def test_threshold_zero_where_the_orbit_turns_back(case):
    assert drive.threshold(*case) == 0
    assert sticks_again(*case, 1e-9)


@pytest.mark.one_in(3)
@pytest.mark.parametrize(
    "case", [(-0.3, 1.0, -0.2), (-0.9, 1.7, -0.8), (-2.0, 1.2, -0.5), (0.5, 3.0, -0.5), (-1.0, 1.0, 0.0)]
)
def test_threshold_infinite_on_a_steep_second_section(case):
    assert drive.threshold(*case) == math.inf
    assert not sticks_again(*case, 1e6)


def test_threshold_in_both_scalings_from_a_slide_in_newtons():
    m, k, v, v_star, tan1, tan2 = 3.0, 48.0, 0.5, 0.2, -1.3, 0.7
    omega = math.sqrt(k / m)
    epsilon = drive.threshold(tan1 / 2, tan2 / 2, v_star / v - 1)
    slope1, slope2 = m * omega * tan1, m * omega * tan2

    def returns(jump, f_ac=5.0):
        def motion(t, y):
            friction = f_ac + slope1 * min(y[1], v_star) + slope2 * max(y[1] - v_star, 0.0)
            return y[1], (-k * (y[0] - v * t) - friction) / m

        return slowest_speed(motion, [-(f_ac + jump) / k, 0.0]) < 0

    critical = epsilon * m * omega * v_star
    assert not returns(critical * (1 - 1e-8))
    assert returns(critical * (1 + 1e-8))
    eps1 = epsilon * (1 + (v_star / v - 1))
    assert critical == pytest.approx(eps1 * m * omega * v, rel=1e-14)


def test_threshold_grows_with_the_second_slope_and_falls_with_the_first():
    rising = [drive.threshold(-0.3, mu2, -0.3) for mu2 in np.linspace(0.05, 0.999, 40)]
    assert np.all(np.diff(rising) >= 0)
    falling = [drive.threshold(mu1, 0.5, -0.3) for mu1 in np.linspace(0.0, -1.2, 40)]
    assert np.all(np.diff(falling) <= 0)


def high_precision(mu1, mu2, p_star):
    """The grazing orbit with 50 digits from the eigenvalues, underdamped below and above the corner."""

    def leg(mu, w, v, s):
        a = mpmath.sqrt(mpmath.mpc(mu**2 - 1))
        e1, e2 = mpmath.exp((mu + a) * s), mpmath.exp((mu - a) * s)
        c = (v - (mu - a) * w) / (2 * a)
        return mpmath.re(c * e1 + (w - c) * e2), mpmath.re(c * (mu + a) * e1 + (w - c) * (mu - a) * e2)

    with mpmath.workdps(50):
        mu1, mu2, p = mpmath.mpf(mu1), mpmath.mpf(mu2), mpmath.mpf(p_star)
        half = mpmath.pi / mpmath.sqrt(1 - mu1**2)
        s = mpmath.findroot(lambda s: leg(mu1, -1, 0, s)[0] - p, (0, half), solver="anderson", tol=1e-80)
        up = leg(mu1, -1, 0, s)[1]
        omega = mpmath.sqrt(1 - mu2**2)
        top = mpmath.atan2(up * omega, p - mu2 * up) / omega  # of the time-reversed motion, whose damping is -mu2
        low, high = top, top + mpmath.pi / omega
        for _ in range(220):
            middle = (low + high) / 2
            low, high = (middle, high) if leg(mu2, p, up, middle)[0] > p else (low, middle)
        down = leg(mu2, p, up, low)[1]
        low, high = (
            mpmath.mpf(0),
            mpmath.atan2(-down * mpmath.sqrt(1 - mu1**2), -p + mu1 * down) / mpmath.sqrt(1 - mu1**2),
        )
        for _ in range(220):
            middle = (low + high) / 2
            low, high = (middle, high) if leg(mu1, p, down, middle)[0] > -1 else (low, middle)
        return -leg(mu1, p, down, low)[1] / (1 + p)


@pytest.mark.parametrize(
    "case",
    [(-0.3, 0.3, -0.2), (-0.1, 0.99, -0.5), (-0.9, 0.9999, -0.01), (-0.6, 0.4, -1e-9), (-0.3, 0.5, -1 + 1e-6)],
)
def test_threshold_to_twelve_digits(case):
    assert drive.threshold(*case) == pytest.approx(float(high_precision(*case)), rel=1e-12)


@pytest.mark.parametrize("mu", [-1.0, 1.0])
def test_critical_damping_joins_its_neighbours(mu):
    at = drive.threshold(mu, 0.6, -0.7), excursion(0.0, 0.3, 1.0, mu, 0.6)[0]
    for near in (mu * (1 - 1e-13), mu * (1 + 1e-13)):
        assert drive.threshold(near, 0.6, -0.7) == pytest.approx(at[0], rel=1e-11)
        assert excursion(0.0, 0.3, 1.0, near, 0.6)[0] == pytest.approx(at[1], rel=1e-11)
    at = drive.positioning_error(-0.4, abs(mu), 2.0).value
    for near in (1 - 1e-13, 1 + 1e-13):
        assert drive.positioning_error(-0.4, near, 2.0).value == pytest.approx(at, rel=1e-11)


def test_threshold_near_the_steep_section_overflows_to_infinity_only_late():
    assert 1e300 < drive.threshold(-0.3, 0.99999, -0.2) < math.inf
    assert drive.threshold(-0.3, 0.999999, -0.2) == math.inf


def test_a_map_of_480_points_takes_a_moment():
    start = time.perf_counter()
    for mu2 in np.linspace(0.05, 1.0, 60):
        for p_star in np.linspace(-0.8, -0.1, 8):
            drive.threshold(-0.6, mu2, p_star)
    assert time.perf_counter() - start < 2.0


@pytest.mark.parametrize("mu", [-3.0, -1.0 - 1e-9, -1.0, -0.4, 0.0, 0.7, 1.0, 1.0 + 1e-9, 1.2, 40.0])
@pytest.mark.parametrize("s", [1e-9, 0.02, 0.3, 4.0])
def test_responses_with_any_damping(mu, s):
    with mpmath.workdps(50):
        a = mpmath.sqrt(mpmath.mpc(mpmath.mpf(mu) ** 2 - 1))
        if a == 0:
            S, slope = s * mpmath.exp(-mu * s), (1 - mu * s) * mpmath.exp(-mu * s)
        else:
            low, high = -mpmath.mpf(mu) - a, -mpmath.mpf(mu) + a
            e1, e2 = mpmath.exp(low * s), mpmath.exp(high * s)
            S, slope = (e2 - e1) / (2 * a), (high * e2 - low * e1) / (2 * a)
        A = slope + 2 * mpmath.mpf(mu) * S
        exact = [float(mpmath.re(e)) for e in (S, A, 1 - A, slope)]
    *found, scale = FreeResponse(mu).responses(s)
    assert [e / scale for e in found] == pytest.approx(exact, rel=1e-11, abs=1e-14)


@pytest.mark.parametrize("scale", [1e-6, 0.3, 7.0])
def test_an_excursion_scales_with_its_lengths(scale):
    speed, crossed = excursion(-1.0, 0.2, -0.3, 0.4, -0.5)
    assert crossed
    assert excursion(-scale, 0.2 * scale, -0.3 * scale, 0.4, -0.5)[0] == pytest.approx(speed * scale, rel=1e-13)


@pytest.mark.parametrize(
    ("case", "value", "kind"),
    [
        (STOPS[0], 1.1856381703605572, "a"),
        (STOPS[1], 3.9314073871663000, "b"),
        (STOPS[2], 6.2873911205662231, "c"),
        (STOPS[3], 8.7229673927621434, "b"),
    ],
)
def test_positioning_errors_of_the_diagrams(case, value, kind):
    found = drive.positioning_error(*case)
    assert found.value == pytest.approx(value, rel=4e-15)
    assert found.type == kind
    assert found.to_dict() == {"value": found.value, "type": kind}
    assert repr(found) == f"PositioningError({value:.6g}, type {kind})"


@pytest.mark.parametrize("case", STOPS)
def test_positioning_error_is_where_the_slide_stops(case):
    assert drive.positioning_error(*case).value == pytest.approx(stopping_distance(*case), rel=1e-11)


@pytest.mark.parametrize(("mu1", "lam"), [(1.0, 2.0), (2.5, 0.7), (3.0, 5.0)])
def test_an_overdamped_slide_creeps_to_the_kinetic_equilibrium(mu1, lam):
    assert drive.positioning_error(mu1, 0.5, lam).value == lam


def test_static_friction_holds_the_slide():
    assert drive.positioning_error(-0.5, 0.8, 4.0, epsilon=4.0) == drive.PositioningError(0.0, "none")
    assert drive.positioning_error(-0.5, 0.8, -1.0).type == "none"
    assert drive.positioning_error(-0.5, 0.8, 0.0).type == "none"
    moved = drive.positioning_error(-0.5, 0.8, 4.0, epsilon=4.0 - 1e-12)
    assert moved == drive.positioning_error(-0.5, 0.8, 4.0)


def test_type_a_ends_where_the_orbit_touches_the_corner():
    for mu1 in (-0.9, -0.25, 0.0, 0.5, 1.0, 1.6):
        limit = drive.type_limit(mu1)
        assert drive.positioning_error(mu1, 0.3, limit * (1 - 1e-9)).type == "a"
        assert drive.positioning_error(mu1, 0.3, limit * (1 + 1e-9)).type == "c"
        assert drive.positioning_error(mu1, 1.0, limit * (1 + 1e-9)).type == "b"
    assert drive.type_limit(-1.0) == drive.type_limit(-4.0) == 0
    assert drive.type_limit(-0.5) == pytest.approx(math.exp(-0.5 * math.acos(-0.5) / math.sqrt(0.75)), rel=1e-15)


def test_closed_forms_of_the_source_meet_the_exact_error():
    assert drive.single_section_error(-0.1, 0.5) == pytest.approx(
        drive.positioning_error(-0.1, 0.5, 0.5).value, rel=1e-15
    )
    errors = [
        drive.positioning_error(-0.5, mu2, 2.0).value / drive.steep_error(-0.5, 2.0) - 1 for mu2 in (1e2, 2e2, 4e2)
    ]
    assert np.log2(np.divide(errors[:-1], errors[1:])) == pytest.approx(2.0, abs=0.05)
    mu1, lam = sorted(drive.steep_error(symbolic=True).free_symbols, key=str)[::-1]
    assert float(drive.steep_error(symbolic=True).subs({mu1: -0.5, lam: 2})) == pytest.approx(
        drive.steep_error(-0.5, 2.0)
    )
    assert drive.single_section_error(symbolic=True).has(sp.exp)


def test_error_falls_with_the_second_slope_at_fixed_lambda_and_rises_at_fixed_speed():
    slopes = np.linspace(0.3, 3.0, 12)
    fixed = [drive.positioning_error(-0.5, mu2, 6.0).value for mu2 in slopes]
    assert np.all(np.diff(fixed) < 0)
    driven = [drive.positioning_error(-0.5, mu2, drive.excess(-0.5, mu2, 6.0)).value for mu2 in slopes]
    assert np.all(np.diff(driven) > 0)


@pytest.mark.parametrize(
    ("mu1", "mu2", "speed", "sigma"),
    [(-0.5, 0.8, 3.0, 0.0), (-0.5, 0.8, 3.0, 0.3), (-1.2, 1.6, 2.5, 0.4), (0.2, 0.4, 0.6, 0.1), (0.2, 0.4, 1.5, 0.1)],
)
@pytest.mark.parametrize("damper", ["ground", "support"])
def test_a_moving_slide_keeps_the_speed_of_the_drive(mu1, mu2, speed, sigma, damper):
    lam = drive.excess(mu1, mu2, speed, damper=damper, sigma=sigma)
    carried = sigma if damper == "support" else 0.0
    assert lam == pytest.approx(force(speed, mu1 - carried, mu2 - carried, 1.0), rel=1e-14)
    found = drive.positioning_error(mu1, mu2, lam, slide="moving", damper=damper, sigma=sigma)
    assert found.value == pytest.approx(stopping_distance(mu1, mu2, lam, speed), rel=1e-11)
    assert found.type == ("a" if speed < 1 else "b" if mu2 >= 1 else "c")


def test_the_damper_s_place_leaves_a_slide_at_rest_alone():
    rest = [drive.positioning_error(-0.5, 0.8, 4.0, damper=d, sigma=0.2) for d in ("ground", "support")]
    assert rest[0] == rest[1] == drive.positioning_error(-0.5, 0.8, 4.0)
    assert drive.excess(-0.3, 0.3, 5.0, damper="support", sigma=0.2) == pytest.approx(-1.0 + 0.2 * 4)


def test_a_damper_cannot_prevent_both_stick_slip_and_the_error():
    # to ground; tan(alpha1) = -1, tan(alpha2) = .2, eps = 1, speeds from 1.25 to 5 v*
    def spare(sigma, speed):
        return drive.threshold(-0.5 + sigma, 0.1 + sigma, 1 / speed - 1) - 1

    least = optimize.brentq(spare, 0.0, 0.5, args=(1.25,), xtol=1e-15)
    assert least == pytest.approx(0.154719279062684, rel=1e-12)
    assert all(spare(least, speed) > 0 for speed in np.linspace(1.26, 5.0, 20))
    assert drive.excess(-0.5 + 0.12, 0.1 + 0.12, 5.0) == pytest.approx(1.0, rel=1e-14)
    assert drive.positioning_error(-0.38, 0.22, drive.excess(-0.38, 0.22, 4.999), epsilon=1.0).type == "none"
    lam = drive.excess(-0.5 + least, 0.1 + least, 5.0)
    assert drive.positioning_error(-0.5 + least, 0.1 + least, lam, epsilon=1.0).value > 1


def test_slope_limits_of_two_slides():
    given = {"r": 0.5, "zeta": 2, "s1": 0.2, "s2": 0.3}
    found = drive.slope_limits(**given)
    assert (found.definite, found.exact) == pytest.approx((-0.15, -0.17993804875), rel=1e-10)
    assert found.to_dict() == {"definite": found.definite, "exact": found.exact}
    assert repr(found) == "SlopeLimits(definite -0.15, exact -0.179938)"
    other = drive.slope_limits(**given, damping="omega2")
    assert (other.definite, other.exact) == pytest.approx((-0.12, -0.19173927953), rel=1e-10)
    same = drive.slope_limits(**{**given, "zeta": 1})
    assert same.exact == pytest.approx(same.definite, rel=1e-14)


@pytest.mark.parametrize(
    ("r", "zeta", "s1", "d2"), [(0.5, 2, 0.2, 0.3), (0.5, 2, 0.2, 0.15), (3, 0.4, 1.5, 0.05), (1, 1, 0.3, 0.3)]
)
def test_eigenvalues_change_sides_at_the_exact_limit(r, zeta, s1, d2):
    limit = drive.slope_limits(r=r, zeta=zeta, s1=s1, s2=d2).exact

    def growth(mu):
        B = np.array([[2 * (s1 + mu), -2 * mu], [-2 * r * mu, 2 * (d2 + r * mu)]])
        K = np.diag([1, 1 / zeta**2])
        return np.linalg.eigvals(np.block([[np.zeros((2, 2)), np.eye(2)], [-K, -B]])).real.max()

    assert growth(limit * (1 - 1e-6)) < 0 < growth(limit * (1 + 1e-6))
    assert all(growth(limit * f) < 0 for f in np.linspace(0, 0.999, 50))


def test_first_two_hurwitz_conditions_are_both_needed():
    T, U, last = (e.subs(dict(zip(drive.SYMBOLS, (1, 2, 76, 1, -26), strict=True))) for e in drive.hurwitz_conditions())
    assert T > 0
    assert last > 0
    assert U < 0
    B = np.array([[100.0, 52.0], [52.0, -50.0]])
    matrix = np.block([[np.zeros((2, 2)), np.eye(2)], [-np.diag([1, 0.25]), -B]])
    assert np.linalg.eigvals(matrix).real.max() > 0


BAD = [
    (lambda: drive.threshold("a", 0.5, -0.1), "mu1 is 'a'"),
    (lambda: drive.threshold(-0.1, math.nan, -0.1), "mu2 is nan"),
    (lambda: drive.threshold(-0.1, 0.5, -1.0), "p_star is -1"),
    (lambda: drive.threshold(-1e13, 0.5, -0.5), r"mu1 is -1e\+13"),
    (lambda: drive.threshold(-0.1, 0.5, sp.Symbol("p")), "p_star is the expression p"),
    (lambda: drive.threshold(-0.1, np.array([0.5, 0.6]), -0.1), "mu2 is array"),
    (lambda: drive.positioning_error(-0.1, 0.5, math.inf), "lam is inf"),
    (lambda: drive.positioning_error(True, 0.5, 1.0), "mu1 is True"),
    (lambda: drive.positioning_error(-0.1, 0.5, 1.0, epsilon=-0.1), "epsilon is -0.1"),
    (lambda: drive.positioning_error(-0.1, 0.5, 1.0, slide="sliding"), "slide is 'sliding'"),
    (lambda: drive.positioning_error(-0.1, 0.5, 1.0, damper="wall"), "damper is 'wall'"),
    (lambda: drive.positioning_error(-0.1, 0.5, 1.0, sigma=-1), "sigma is -1"),
    (lambda: drive.positioning_error(-0.5, 0.5, -2.0, slide="moving"), "lam is -2: no speed"),
    (lambda: drive.positioning_error(-0.5, 0.2, 1.0, slide="moving", damper="support", sigma=0.3), "no speed"),
    (lambda: drive.excess(-0.5, 0.5, 0.0), "speed is 0"),
    (lambda: drive.single_section_error(-1.0, 0.5), "mu1 is -1"),
    (lambda: drive.steep_error(-0.5, -1.0), "lam -1"),
    (lambda: drive.type_limit(None), "mu1 is None"),
    (lambda: drive.slope_limits(r=0, zeta=2, s1=0.2, s2=0.3), "r is 0"),
    (lambda: drive.slope_limits(r=0.5, zeta=2, s1=0.2, s2=0.3, damping="omega"), "damping is 'omega'"),
]


@pytest.mark.parametrize(("ask", "message"), BAD)
def test_bad_input_is_named(ask, message):
    with pytest.raises(sf.SceneError, match=message):
        ask()
