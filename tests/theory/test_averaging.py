"""Averaged amplitudes against quadrature written out here, closed forms, and simulated cycles."""

import itertools

import numpy as np
import pytest
import sympy as sp
from scipy import integrate

import symfric as sf
from symfric.theory import belt
from symfric.theory.averaging import average
from symfric.theory.separation import separate
from tests.longer import longer

LAWS = {
    "cubic": sf.laws.cubic(0.4, 0.25, 0.5),
    "coulomb": sf.laws.coulomb(0.4, 0.3),
    "stribeck": sf.laws.stribeck(0.4, 0.25, 0.3, b=0.1),
    "gauss": sf.laws.gauss(0.4, 0.3, b=0.2),
    "lorentz": sf.laws.lorentz(0.4, 0.3, b=0.2),
    "square_root": sf.laws.square_root(0.4, -0.2, b=0.2),
    "flat": sf.laws.piecewise_linear(0.4, [0, 0.15, 0.45], [0.4, 0.25, 0.25], last_slope=0),
    "piecewise_linear": sf.laws.piecewise_linear(0.4, [0, 0.15, 0.45], [0.4, 0.25, 0.2], last_slope=0.3),
    "averaged": sf.laws.cubic(0.4, 0.25, 0.5).averaged(0.1),
    "averaged stribeck": sf.laws.stribeck(0.4, 0.25, 0.3).averaged(0.1),
}


def rate(law, v_b, A, beta=0.05):
    """A' = -<h cos> with h = 2 beta u + mu(u - v_b), split at every turn of the law."""
    turns = [0.0, *(s * float(b) for b in law.breaks for s in (-1, 1))]
    inside = [np.arccos((t + v_b) / A) for t in turns if abs(t + v_b) < A]
    edges = [0.0, *sorted(inside), np.pi]

    def integrand(psi):
        u = A * np.cos(psi)
        return (2 * beta * u + law(u - v_b)) * np.cos(psi)

    parts = [integrate.quad(integrand, a, b, epsabs=1e-11, limit=200)[0] for a, b in itertools.pairwise(edges)]
    return -sum(parts) / np.pi


@pytest.mark.one_in(8)
@pytest.mark.parametrize("name", longer(LAWS, ("averaged stribeck",)))
def test_rate_is_the_mean_in_pure_slip_and_beyond(name):
    law = LAWS[name]
    flow = average(sf.scenes.mass_on_belt(law, v_b=0.2))
    for A in (0.19, 0.5) if name == "averaged stribeck" else (0.03, 0.19, 0.21, 0.5):
        assert flow(A) == pytest.approx(rate(law, 0.2, A), abs=1e-9)
    assert flow.frequency_at(0.3) == pytest.approx(1.0, rel=1e-14)


def test_cubic_flow_is_closed_and_symbolic():
    law = sf.laws.cubic(*sp.symbols("mu_s mu_m v_m", positive=True))
    numbers = {"mu_s": 0.4, "mu_m": 0.25, "v_m": 0.5}
    flow = average(sf.scenes.mass_on_belt(law, v_b=0.42).where(numbers))
    assert not flow.rate.has(sp.Integral)
    h1, _, h3 = belt.damping_polynomial(symbolic=True)
    A = flow.amplitude
    pure = sp.piecewise_fold(flow.rate).args[0].expr
    expected = -A / 2 * (h1 + sp.Rational(3, 4) * h3 * A**2)  # Thomsen (15)
    assert sp.simplify(pure - expected) == 0
    assert flow(np.array([0.1, 0.2])).shape == (2,)
    assert flow(0.1, {"v_b": 0.3}) == pytest.approx(rate(LAWS["cubic"], 0.3, 0.1), abs=1e-12)


def test_stationary_amplitudes_are_those_of_the_closed_form():
    scene = sf.scenes.mass_on_belt(v_b=0.42)
    flow = average(scene)
    assert flow.amplitudes == pytest.approx([belt.pure_slip_amplitude(scene)], rel=1e-12)
    assert flow.stable.tolist() == [True]
    assert average(scene.where({"v_b": 0.45})).amplitudes.size == 0
    sticking = average(scene.where({"v_b": 0.2}))
    assert 0.2 < sticking.amplitudes[0] < 0.203
    assert "stable" in repr(flow)
    assert flow.to_dict()["stable"] == [True]


def test_all_stationary_amplitudes_are_found():
    """Subcritical: an unstable cycle inside the one that overhauls the belt."""
    law = sf.laws.stribeck(0.4, 0.25, 0.3)
    flow = average(sf.scenes.mass_on_belt(law, v_b=0.6))
    assert flow.stable.tolist() == [False, True]
    for A in flow.amplitudes:
        assert rate(law, 0.6, A) == pytest.approx(0.0, abs=1e-9)
    assert flow.amplitudes[0] < 0.6 < flow.amplitudes[1]


def test_free_coulomb_oscillator():
    delta, omega_n = 0.1, 2.0
    flow = average(sf.scenes.coulomb_oscillator(delta, omega_n=omega_n))
    assert flow(0.7) == pytest.approx(-2 * delta * omega_n / np.pi, rel=1e-14)
    assert flow.amplitudes.size == 0


def test_nonlinear_stiffness_shifts_the_frequency():
    x, u = sp.symbols("x u", real=True)
    k, m, c = sp.symbols("k m c", positive=True)
    system = sf.System(q=[x], u=[u], mass=[[m]], force=[-k * x - c * x**3 + 0.1 * u - 0.3 * u**3])
    scene = sf.Scene(system=system, values={k: 4.0, m: 2.0, c: 0.05}, initial={x: 0.0, u: 0.0}, horizon=1.0)
    flow = average(scene)
    omega = np.sqrt(2)
    A = flow.amplitudes[0]
    assert pytest.approx(np.sqrt(4 / 3 * 0.1 / 0.3) / omega, rel=1e-12) == A
    assert flow.frequency_at(A) == pytest.approx(omega + 3 * 0.05 * A**2 / (8 * omega * 2), rel=1e-13)
    assert sp.simplify(flow.frequency - sp.sqrt(k / m) - 3 * c * flow.amplitude**2 / (8 * m * sp.sqrt(k / m))) == 0


def simulated(h, omega, guess):
    """Half range and frequency of the stable cycle of x'' + omega^2 x + h(x, x') = 0."""

    def turn(_t, y):
        return y[1]

    def field(_t, y):
        return y[1], -(omega**2) * y[0] - h(y[0], y[1])

    run = integrate.solve_ivp(field, (0, 300), [guess, 0.0], events=turn, method="DOP853", rtol=1e-10, atol=1e-12)
    t, q = run.t_events[0], run.y_events[0][:, 0]
    return abs(q[-1] - q[-2]) / 2, 2 * np.pi / (t[-1] - t[-3])


@pytest.mark.long(beside="test_order_two_takes_pure_slip_only")
def test_second_order_for_other_polynomials():
    x, u = sp.symbols("x u", real=True)
    e = sp.Symbol("e", positive=True)
    small = -u + 3 * u**3 + x * u / 2 + x**2 / 3 + 2 * u**5 + u**2
    system = sf.System(q=[x], u=[u], mass=[[2]], force=[-3 * x - e * small])
    errors = []
    for value in (0.2, 0.1):
        scene = sf.Scene(system=system, values={e: value}, initial={x: 0.0, u: 0.0}, horizon=1.0)
        flow = average(scene, order=2)
        h = sp.lambdify((x, u), value * small / 2)
        half_range, frequency = simulated(h, np.sqrt(1.5), flow.amplitudes[0])
        errors.append((flow.amplitudes[0] / half_range - 1, average(scene).amplitudes[0] / half_range - 1))
        assert flow.frequency_at(flow.amplitudes[0]) == pytest.approx(frequency, rel=2 * value**3)
    second = np.log2(abs(errors[0][0] / errors[1][0]))
    assert second > 2.6
    assert abs(errors[1][0]) < 0.1 * abs(errors[1][1])


def test_order_two_takes_pure_slip_only():
    assert average(sf.scenes.mass_on_belt(v_b=0.3), order=2).amplitudes.size == 0
    with pytest.raises(sf.SceneError, match="no polynomial"):
        average(sf.scenes.mass_on_belt(LAWS["stribeck"], v_b=0.3), order=2)
    with pytest.raises(sf.SceneError, match="branches"):
        average(sf.scenes.mass_on_belt(LAWS["piecewise_linear"], v_b=0.3), order=2)
    with pytest.raises(sf.SceneError, match="no sliding speed"):
        average(sf.scenes.coulomb_oscillator(0.1), order=2)


def test_slow_scene_under_excitation():
    scene = sf.scenes.mass_on_belt(v_b=0.3, a=0.01, Omega=20.0)
    flow = average(separate(scene))
    high = belt.unstable_speeds(scene)[1]
    # pure slip with the cubic coefficient unchanged, as long as the amplitude stays below v_b - a Omega
    near = average(separate(scene.where({"v_b": 0.999 * high})))
    assert near.amplitudes == pytest.approx([2 * high * np.sqrt(1 - 0.999**2)], rel=1e-9)
    assert flow.stable.tolist() == [True]


def test_refusals():
    with pytest.raises(sf.SceneError, match="order is 3"):
        average(sf.scenes.mass_on_belt(v_b=0.3), order=3)
    with pytest.raises(sf.SceneError, match="depends on time"):
        average(sf.scenes.mass_on_belt(v_b=0.3, a=0.01, Omega=20.0))
    x, u = sp.symbols("x u", real=True)

    def one(force, contacts=()):
        system = sf.System(q=[x], u=[u], mass=[[1]], force=[force])
        return sf.Scene(system=system, contacts=contacts, initial={x: 0.0, u: 0.0}, horizon=1.0)

    with pytest.raises(sf.SceneError, match="without kinks"):
        average(one(-x - sp.Abs(x)))
    with pytest.raises(sf.NotFound, match="restoring"):
        average(one(x - x**3))
    with pytest.raises(sf.SceneError, match="depend on u only"):
        average(one(-x, [sf.Contact("disc", slip=u - 1 - x, normal=1, law=LAWS["cubic"])]))
    flow = average(sf.scenes.mass_on_belt(v_b=0.42))
    with pytest.raises(sf.SceneError, match="vb is no parameter"):
        flow(0.1, {"vb": 0.2})
    with pytest.raises(sf.SceneError, match="not positive"):
        flow(0.1, {"v_b": -0.2})
