"""Hopf points: value and cubic coefficient against closed forms and against the motion itself."""

import numpy as np
import pytest
import sympy as sp
from scipy import integrate

import symfric as sf
from symfric.theory.equilibrium import solve
from symfric.theory.hopf import hopf, multilinear
from symfric.theory.sliding import field_of
from symfric.theory.stability import linearise


def two_masses(law, mass=((1.0, 0.0), (0.0, 2.0))):
    """Two masses in series, the first on a belt; `mass` may depend on the first coordinate."""
    x, y, u, w = sp.symbols("x y u w", real=True)
    v_b = sp.Symbol("v_b", positive=True)
    force = [-x - sp.Rational(1, 2) * (x - y) - 0.1 * u - 0.3 * x**3, -2 * y - sp.Rational(1, 2) * (y - x) - 0.8 * w]
    system = sf.System(q=[x, y], u=[u, w], mass=sp.Matrix(mass), force=force)
    return sf.Scene(
        system=system,
        contacts=[sf.Contact("belt", slip=u - v_b, normal=1, law=law)],
        values={v_b: 0.4},
        initial=dict.fromkeys((x, y, u, w), 0.0),
        horizon=1.0,
    )


def amplitude_drift(field, p, x, kick, cycles):
    """Coefficient a from a simulation at the Hopf point, where 1/r^2 falls with slope 2 a."""
    s = field.directions(x, p)

    def rate(_t, state):
        n = field.n
        return np.concatenate([state[n:], np.linalg.solve(field.mass(state, p, s), field.value(state, p, s))])

    def turn(_t, state):
        return state[field.n]

    start = x + kick
    run = integrate.solve_ivp(
        rate, (0, cycles * 2 * np.pi), start, events=turn, method="DOP853", rtol=1e-11, atol=1e-14
    )
    t, q = run.t_events[0], run.y_events[0][:, 0]
    r = np.abs(np.diff(q)) / 2
    keep = slice(len(r) // 3, None)
    return -0.5 * np.polyfit((t[1:] + t[:-1])[keep] / 2, 1 / r[keep] ** 2, 1)[0]


def brute_force(scene, point, size, cycles=16):
    """Extrapolate the drift to small amplitudes along the critical eigenvector; other modes need more cycles to decay."""
    symbol = scene.parameter("v_b")
    at = scene.where({symbol: point.value})
    field = field_of(at)
    p = field.vector(at.values)
    x = solve(field, p, np.zeros(len(field.states)))
    values, vectors = np.linalg.eig(linearise(field, p, x)[3])
    k = int(np.argmax(values.real))
    mode = (vectors[:, k] / vectors[0, k]).real
    drifts = [amplitude_drift(field, p, x, r * mode, cycles) for r in (size, size / 2)]
    return (4 * drifts[1] - drifts[0]) / 3


def test_cubic_belt_has_the_closed_form_coefficient():
    for mu_m, beta in ((0.25, 0.05), (0.35, 0.01)):
        scene = sf.scenes.mass_on_belt(sf.laws.cubic(0.4, mu_m, 0.5), v_b=0.2, beta=beta)
        point = hopf(scene, "v_b", (0.3, 0.6))
        eta = 1.5 * (0.4 - mu_m) / 0.5
        assert point.first_lyapunov == pytest.approx(-eta / (8 * 0.25), rel=1e-12)
        assert point.value == pytest.approx(0.5 * np.sqrt(1 - 2 * beta / eta), rel=1e-12)
        assert point.omega == pytest.approx(1.0, rel=1e-12)
        assert point.kind == "supercritical"


def test_exponential_belt_is_subcritical():
    scene = sf.scenes.mass_on_belt(sf.laws.stribeck(0.4, 0.25, 0.3), v_b=0.2)
    point = hopf(scene, "v_b", (0.1, 0.9))
    assert point.value == pytest.approx(0.3 * np.log(0.15 / 0.3 / 0.1), rel=1e-12)
    third = -0.1 / 0.3**2  # mu''' at that speed, from mu' = -2 beta
    assert point.first_lyapunov == pytest.approx(-3 / 8 * third / 6, rel=1e-11)
    assert point.kind == "subcritical"
    assert brute_force(scene, point, 0.02) == pytest.approx(point.first_lyapunov, rel=1e-4)


STRIBECK, CUBIC = sf.laws.stribeck(0.4, 0.25, 0.3), sf.laws.cubic(0.4, 0.25, 0.5)


@pytest.mark.long(beside="test_exponential_belt_is_subcritical")
@pytest.mark.parametrize("law", [STRIBECK, CUBIC])
def test_two_masses_against_the_motion(law):
    scene = two_masses(law)
    point = hopf(scene, "v_b", (0.1, 0.9))
    assert brute_force(scene, point, 0.02, 40) == pytest.approx(point.first_lyapunov, rel=2e-4)


@pytest.mark.long(beside="test_exponential_belt_is_subcritical")
def test_position_dependent_mass_against_the_motion():
    x = sp.Symbol("x", real=True)
    mass = [[1 + x / 2, x / 5], [x / 5, 2 + x**2]]
    scene = two_masses(sf.laws.stribeck(0.4, 0.25, 0.3), mass)
    point = hopf(scene, "v_b", (0.1, 0.9))
    assert brute_force(scene, point, 0.02, 40) == pytest.approx(point.first_lyapunov, rel=2e-4)


@pytest.mark.long(beside="test_exponential_belt_is_subcritical")
def test_multilinear_forms_are_the_derivatives_of_the_rate():
    x = sp.Symbol("x", real=True)
    scene = two_masses(sf.laws.stribeck(0.4, 0.25, 0.3), [[1 + x / 2, x / 5], [x / 5, 2 + x**2]])
    field = field_of(scene)
    p = field.vector(scene.values)
    at = solve(field, p, np.zeros(4))
    s = field.directions(at, p)
    M, _, _, A = linearise(field, p, at)
    B, C = multilinear(field, p, at, M, A)
    put = {**scene.values, **dict(zip(field.signs, s, strict=True))}
    accelerations = (field.system.mass.inv() * sp.Matrix(field.parts)).subs(put)
    rate = sp.Matrix([*field.states[2:], *accelerations])
    rng = np.random.default_rng(5)
    e = sp.symbols("e1:4")
    d = rng.standard_normal((3, 4))
    moved = {state: float(at[i]) + sum(e[k] * float(d[k, i]) for k in range(3)) for i, state in enumerate(field.states)}
    along = rate.subs(moved)
    zero = dict.fromkeys(e, 0)
    second = np.array(along.diff(e[0]).diff(e[1]).subs(zero), dtype=float).ravel()
    third = np.array(along.diff(e[0]).diff(e[1]).diff(e[2]).subs(zero), dtype=float).ravel()
    assert B(d[0], d[1]).real == pytest.approx(second, rel=1e-9, abs=1e-11)
    assert C(d[0], d[1], d[2]).real == pytest.approx(third, rel=1e-9, abs=1e-11)


def test_other_parameters_and_names():
    scene = sf.scenes.mass_on_belt(v_b=0.2)
    point = hopf(scene, "beta", (0.0, 1.0))
    assert point.value == pytest.approx(0.45 / 2 * (1 - 0.16), rel=1e-12)
    assert point.to_dict()["parameter"] == "beta"
    assert hopf(scene, scene.parameter("beta"), (0.0, 1.0)).value == point.value
    unknown = scene.where({"v_b": None})
    assert hopf(unknown, "v_b", (0.3, 0.6)).value == pytest.approx(0.44095855184409843, rel=1e-12)


def test_linear_law_is_degenerate():
    law = sf.laws.piecewise_linear(0.4, [0, 0.5], [0.4, 0.3], last_slope=0.1)
    scene = sf.scenes.mass_on_belt(law, v_b=0.2)
    point = hopf(scene, "beta", (0.0, 1.0))
    assert point.value == pytest.approx(0.1, rel=1e-12)
    assert point.kind == "degenerate"


def test_pairs_that_cross_together_are_degenerate():
    q, u = sp.symbols("q0:3", real=True), sp.symbols("u0:3", real=True)
    v_b = sp.Symbol("v_b", positive=True)
    force = [-2 * q[0] + q[1] - 0.1 * u[0], -2 * q[1] + q[0] + q[2] - 0.1 * u[1], -2 * q[2] + q[1] - 0.1 * u[2]]
    law = sf.laws.cubic(0.4, 0.25, 0.5)
    scene = sf.Scene(
        system=sf.System(q=q, u=u, mass=sp.eye(3), force=force),
        contacts=[sf.Contact(f"belt {i}", slip=u[i] - v_b, normal=1, law=law) for i in range(3)],
        values={v_b: 0.3},
        initial=dict.fromkeys((*q, *u), 0.0),
        horizon=1.0,
    )
    point = hopf(scene, "v_b", (0.3, 0.6))
    assert point.value == pytest.approx(0.44095855184409843, rel=1e-12)
    assert point.kind == "degenerate"


def test_refusals():
    scene = sf.scenes.mass_on_belt(v_b=0.2)
    with pytest.raises(sf.NotFound, match="unstable at both ends"):
        hopf(scene, "v_b", (0.1, 0.2))
    with pytest.raises(sf.SceneError, match="did you mean v_b"):
        hopf(scene, "vb", (0.1, 0.5))
    with pytest.raises(sf.SceneError, match="low < high"):
        hopf(scene, "v_b", (0.5, 0.1))
    with pytest.raises(sf.SceneError, match="depends on time"):
        hopf(scene.where({"Omega": 50.0}), "a", (0.0, 0.1))
    law = sf.laws.piecewise_linear(0.4, [0, 0.5], [0.4, 0.2], last_slope=0.1)
    with pytest.raises(sf.NotFound, match=r"jumps at v_b = 0\.5"):
        hopf(sf.scenes.mass_on_belt(law, v_b=0.2), "v_b", (0.3, 0.6))
    averaged = sf.scenes.mass_on_belt(sf.laws.cubic(0.4, 0.25, 0.5).averaged(0.2), v_b=0.2)
    with pytest.raises(sf.NotFound, match=r"jumps at v_b = 0\.2"):
        hopf(averaged, "v_b", (0.15, 0.3))


def test_real_eigenvalue_is_no_hopf_point():
    x, u = sp.symbols("x u", real=True)
    k = sp.Symbol("k", real=True)
    system = sf.System(q=[x], u=[u], mass=[[1]], force=[-k * x - x**3 - 0.2 * u])
    scene = sf.Scene(system=system, values={k: 1.0}, initial={x: 0.0, u: 0.0}, horizon=1.0)
    with pytest.raises(sf.NotFound, match="real eigenvalue crosses zero.*a branch point"):
        hopf(scene, "k", (-1.0, 1.3))


def damped(damping, p=0.2, stiffness=1.0, slip=None):
    """A mass that slides with constant friction: eigenvalues -damping/2 +- i sqrt(stiffness - damping^2/4)."""
    x, u = sp.symbols("x u", real=True)
    contact = sf.Contact("belt", u - 1 if slip is None else slip(u), 1, sf.laws.coulomb(0.3))
    system = sf.System([x], [u], [[1]], [-stiffness * x - damping * u])
    return sf.Scene(system, [contact], {"p": p}, {x: 0.0, u: 0.0}, 10.0)


P = sp.Symbol("p", real=True)
C = sp.Rational(3, 10)


@pytest.mark.one_in(3)
@pytest.mark.parametrize(
    ("damping", "bracket", "value"),
    [
        (P - C, (0.1, 0.5), 0.3),
        (C - P, (0.1, 0.5), 0.3),
        (P - sp.Float(0.1), (0.1, 0.5), 0.1),  # at an end
        (P - sp.Float(0.5), (0.1, 0.5), 0.5),
        (P, (0.0, 0.5), 0.0),
        (P, (-0.5, 0.0), 0.0),
        ((P - C) ** 3, (0.1, 0.45), 0.3),
        (sp.Float(1e-9) * (P - C), (0.1, 0.5), 0.3),
        ((P - sp.Float(0.1)) * (P - C), (0.1, 0.2), 0.1),
        ((P - 0.2) * (P - C) * (P - 0.4), (0.25, 0.35), 0.3),
    ],
    ids=str,
)
def test_points_inside_and_at_the_ends_of_a_bracket(damping, bracket, value):
    point = hopf(damped(damping), "p", bracket)
    assert point.value == pytest.approx(value, abs=1e-5 if damping.has(sp.Pow) else 1e-9)  # the cube root of rounding
    assert point.omega == pytest.approx(1.0, abs=1e-6)


@pytest.mark.parametrize("scale", [1e-10, 1.0, 1e10])
def test_points_of_slow_and_fast_systems(scale):
    point = hopf(damped((P - C) * np.sqrt(scale), stiffness=scale), "p", (0.1, 0.5))
    assert (point.value, point.omega) == pytest.approx((0.3, np.sqrt(scale)), rel=1e-9)


@pytest.mark.one_in(3)
@pytest.mark.parametrize(
    ("damping", "bracket", "words"),
    [
        (0 * P, (0.1, 0.5), "neutral"),
        (sp.Max(0, P - C), (0.1, 0.5), "neutral"),
        (-sp.Max(0, P - C), (0.1, 0.5), "neutral"),
        (sp.Max(0, P - C) + sp.Min(0, P - 0.2), (0.1, 0.5), "neutral"),
        ((P - sp.Float(0.1)) ** 2, (0.1, 0.5), "touches zero at p = 0.1 and is negative on both sides"),
        (-((P - sp.Float(0.5)) ** 2), (0.1, 0.5), "touches zero at p = 0.5 and is positive on both sides"),
        ((P - C) ** 2, (0.1, 0.5), "stable at both ends .* widen or move"),
        ((P - 0.2) * (P - 0.4), (0.1, 0.5), r"stable at both ends .* between them, at 0\.2\d*, it is not: end"),
    ],
    ids=str,
)
def test_growth_that_does_not_cross_zero_is_no_hopf_point(damping, bracket, words):
    with pytest.raises(sf.NotFound, match=words):
        hopf(damped(damping, slip=lambda u: u - 1 - P), "p", bracket)


@pytest.mark.long(beside="test_growth_that_does_not_cross_zero_is_no_hopf_point")
@pytest.mark.parametrize("way", [1, -1])
def test_a_fold_of_equilibria_is_no_hopf_point(way):
    """x = -1 is the last equilibrium below, and x = 2, which vibrates, takes over; or mirrored."""
    x, u = sp.symbols("x u", real=True)
    k = sp.Symbol("k", real=True)
    system = sf.System(q=[x], u=[u], mass=[[1]], force=[way * k + 3 * x - x**3 - (0.5 - way * x) * u / 5])
    scene = sf.Scene(system=system, values={k: 1.0}, initial={x: -2.0 * way, u: 0.0}, horizon=1.0)
    with pytest.raises(sf.NotFound, match=r"ends at a fold at k = (2,|2.0000|1.9999)"):
        hopf(scene, "k", (1.0, 2.5))
