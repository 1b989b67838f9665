"""The route `taylor` against closed forms, reference numbers, its own order, and the independent route."""

import itertools
import math

import numpy as np
import pytest
import sympy as sp

import symfric as sf
from symfric.solve.taylor.program import order_for
from symfric_evidence.bench.problems import named
from tests.longer import longer

L = sf.laws
X, U = sp.symbols("x u", real=True)
LAWS = {
    "coulomb": L.coulomb(0.4, 0.3),
    "coulomb, equal": L.coulomb(0.3),
    "lorentz": L.lorentz(0.3, 0.5, mu_s=0.4),
    "gauss": L.gauss(0.3, 0.5, mu_s=0.4, b=0.05),
    "square root": L.square_root(0.4, -0.1),
    "square root, jump": L.square_root(0.3, -0.1, mu_s=0.4, b=0.1),
    "stribeck": L.stribeck(0.4, 0.25, 0.2),
    "cubic": L.cubic(0.4, 0.25, 0.5),
    "exponential": L.exponential(0.4, 0.8),
    "piecewise linear": L.piecewise_linear(0.4, [0, 0.2, 0.5], [0.35, 0.25, 0.3]),
    "custom": L.custom(0.3 / (1 + sf.SPEED), 0.35),
    "coulomb, averaged": L.coulomb(0.4).averaged(0.3),
    "cubic, averaged": L.cubic(0.4, 0.25, 0.5).averaged(0.3),
    "regularised": L.cubic(0.4, 0.25, 0.5).regularised(1e-3),
    "regularised, jump": L.coulomb(0.4, 0.3).regularised(1e-3),
    "regularised, arctan": L.stribeck(0.4, 0.25, 0.2).regularised(1e-3, "arctan"),
    "regularised, tanh": L.cubic(0.4, 0.25, 0.5).regularised(1e-3, "tanh"),
}
EXCITED = {"still": (0.0, 0.0), "excited": (0.01, 20.0)}


def error(run, problem):
    return max(abs(v - float(true)) for v, true in zip(run.checked().final, problem.reference, strict=True))


@pytest.mark.one_in(21)
@pytest.mark.parametrize(
    ("name", "tolerance"),
    [
        *itertools.product(("P1", "P2", "P3", "P4"), (1e-6, 1e-7, 1e-8, 1e-9, 1e-10, 1e-11, 1e-12, 1e-13)),
        *itertools.product(("P7", "P8", "P9"), (1e-6, 1e-12)),
        ("P6", 1e-9),
    ],
)
def test_benchmark_problems_are_right_within_the_tolerance(name, tolerance):
    problem = named(name)
    run = sf.simulate(problem.scene, tolerance, route="taylor")
    assert error(run, problem) < 10 * tolerance
    if problem.events is not None:
        assert run.stats["events"] == problem.events


@pytest.mark.one_in(8)
@pytest.mark.parametrize("name", ["P1", "P2", "P3", "P4", "P7", "P8", "P9"])
def test_energies_of_the_benchmark_problems_balance(name):
    for tolerance in (1e-6, 1e-9, 1e-12):
        assert sf.simulate(named(name).scene, tolerance).energy_residual() < 100 * tolerance


def test_the_price_of_smoothing_is_a_distance_linear_in_the_regularisation():
    exact = sf.simulate(sf.scenes.mass_on_belt(v_b=0.2), 1e-12).final
    law = L.cubic(0.4, 0.25, 0.5)
    distance = [
        np.max(np.abs(sf.simulate(sf.scenes.mass_on_belt(law.regularised(v_s), v_b=0.2), 1e-11).final - exact))
        for v_s in (4e-4, 2e-4, 1e-4)
    ]
    assert distance[2] == pytest.approx(3.9e-4, rel=0.01)
    assert np.diff(np.log2(distance)) == pytest.approx([-1, -1], abs=0.05)


@pytest.mark.one_in(24)
@pytest.mark.parametrize("how", EXCITED)
@pytest.mark.parametrize("name", LAWS)
def test_every_law_on_the_belt(name, how):
    a, Omega = EXCITED[how]
    scene = sf.scenes.mass_on_belt(LAWS[name], v_b=0.2, a=a, Omega=Omega, horizon=30.0)
    coarse, fine = sf.simulate(scene, 1e-7).checked(), sf.simulate(scene, 1e-13).checked()
    assert np.max(np.abs(coarse.final - fine.final)) < 1e-6
    assert coarse.stats["events"] == fine.stats["events"]
    assert coarse.energy_residual() < 1e-5
    assert fine.energy_residual() < (1e-8 if "square root" in name else 1e-10)  # quadrature of a singular slope


INDEPENDENT = [(n, h) for n in LAWS for h in EXCITED if "averaged" not in n and "root" not in n and "tanh" not in n]
OTHERS = [(n, h) for n, h in INDEPENDENT if h == "excited" and n not in ("coulomb", "stribeck", "cubic", "exponential")]


@pytest.mark.one_in(16)
@pytest.mark.parametrize("case", longer(INDEPENDENT, OTHERS), ids=" ".join)
def test_every_law_agrees_with_the_independent_route(case):
    name, how = case
    a, Omega = EXCITED[how]
    scene = sf.scenes.mass_on_belt(LAWS[name], v_b=0.2, a=a, Omega=Omega, horizon=12.0)
    scene = scene.wanting({"end": sf.End(), "events": sf.Events()})
    run, other = sf.simulate(scene, 1e-11).checked(), sf.simulate(scene, 1e-7, route="integrators")
    assert np.max(np.abs(run.final - other.checked().final)) < 1e-6
    assert [(e.before, e.after) for e in run.events] == [(e.before, e.after) for e in other.events]


def test_the_square_root_law_agrees_with_a_regular_time():
    # with s^2 = speed the equation of the slip is regular: s' = w'/(2 s); the whole first slip by SciPy in arc form
    from scipy import integrate

    law, v_b = L.square_root(0.4, -0.1), 0.2
    scene = sf.scenes.mass_on_belt(law, v_b=v_b, beta=0.05, horizon=10.0).starting({"x": 0.0, "u": -0.3})
    run = sf.simulate(scene, 1e-12).checked()
    rate = lambda t, y: (y[1], -0.1 * y[1] - y[0] + 0.4 - 0.1 * np.sqrt(v_b - y[1]))  # noqa: E731
    stop = lambda t, y: v_b - 1e-3 - y[1]  # noqa: E731
    stop.terminal = True
    slide = integrate.solve_ivp(rate, (0, 10), [0.0, -0.3], method="DOP853", rtol=1e-12, atol=1e-14, events=stop)

    def by_speed(s, y):  # independent variable s = sqrt(v_b - u), falling to zero
        u = v_b - s * s
        slope = -0.1 * u - y[0] + 0.4 - 0.1 * s
        return np.array([u, 1.0]) * (-2 * s / slope)

    end = integrate.solve_ivp(
        by_speed, (math.sqrt(1e-3), 0), [slide.y[0, -1], slide.t[-1]], method="DOP853", rtol=1e-12, atol=1e-14
    )
    assert run.events[0].t == pytest.approx(end.y[1, -1], abs=1e-10)
    assert run(run.events[0].t)[0] == pytest.approx(end.y[0, -1], abs=1e-10)


def pendulum():
    system = sf.System(q=[X], u=[U], mass=[[1]], force=[-sp.sin(X)])
    return sf.Scene(system=system, initial={X: 1.0, U: 0.5}, horizon=30.0)


@pytest.mark.one_in(4)
@pytest.mark.parametrize("order", [4, 6, 8, 12])
def test_observed_order_of_the_step(order):
    # the error of a run falls like h^order, and h is the horizon over the steps
    exact = sf.simulate(pendulum(), 1e-14).final
    tolerances = np.logspace(-3, -9, 7) if order < 12 else np.logspace(-4, -11, 7)
    runs = [sf.simulate(pendulum(), tolerance, sf.Taylor(order=order)) for tolerance in tolerances]
    errors = np.array([np.max(np.abs(run.final - exact)) for run in runs])
    steps = np.array([run.stats["steps"] for run in runs])
    observed = -np.polyfit(np.log(steps), np.log(errors), 1)[0]
    assert observed == pytest.approx(order, abs=0.2 * order)


def test_higher_orders_need_fewer_steps_for_the_same_error():
    exact = sf.simulate(pendulum(), 1e-14).final
    steps = []
    for order in (6, 10, 16, 24):
        run = sf.simulate(pendulum(), 1e-9, sf.Taylor(order=order))
        assert np.max(np.abs(run.final - exact)) < 1e-7
        steps.append(run.stats["steps"])
    assert steps == sorted(steps, reverse=True)
    assert steps[0] > 5 * steps[-1]


@pytest.mark.parametrize("tolerance", [1e-6, 1e-9, 1e-12])
@pytest.mark.parametrize("name", ["P2", "P3"])
def test_no_step_is_a_sliver_before_an_event(name, tolerance):
    """What is left of a mode, or of the run, after a step is more than a twentieth of it, or part of it."""
    path = sf.simulate(named(name).scene.wanting({"path": sf.Trajectory()}), tolerance, route="taylor").path
    within = path.mode[1:, 0] == path.mode[:-1, 0]
    assert within.sum() > 50
    assert np.all(path.h[1:][within] > 0.049 * path.h[:-1][within])


def test_coefficients_are_those_of_the_closed_form():
    system = sf.System(q=[X], u=[U], mass=[[1]], force=[-X])
    run = sf.simulate(sf.Scene(system=system, initial={X: 1.0, U: 0.0}, horizon=0.1), 1e-12)
    x, u = run.raw.path.coefficients[0]
    for k in range(x.size):
        assert x[k] == pytest.approx(math.cos(k * math.pi / 2) / math.factorial(k), rel=1e-13, abs=1e-16)
        assert u[k] == pytest.approx(-math.sin(k * math.pi / 2) / math.factorial(k), rel=1e-13, abs=1e-16)


def test_the_order_grows_with_the_logarithm_of_the_tolerance():
    orders = [sf.simulate(pendulum(), tolerance).stats["order"] for tolerance in (1e-4, 1e-8, 1e-12, 1e-16)]
    assert orders == [order_for(tolerance, 2) for tolerance in (1e-4, 1e-8, 1e-12, 1e-16)]
    assert orders == sorted(orders)


def test_the_order_is_higher_only_where_a_root_of_the_speed_is_taken():
    laws = sf.laws.square_root(0.4, -0.1), sf.laws.stribeck(0.4, 0.25, 0.5)
    runs = [sf.simulate(sf.scenes.mass_on_belt(law, v_b=0.2, horizon=1.0), 1e-9) for law in laws]
    assert [run.stats["order"] for run in runs] == [order_for(1e-9, 2, branching=True), order_for(1e-9, 2)]
    assert order_for(1e-9, 2, branching=True) > order_for(1e-9, 2)


def test_error_of_a_smooth_system_follows_the_tolerance_down_to_rounding():
    exact = sf.simulate(pendulum(), 1e-16).final
    for tolerance in np.logspace(-2, -14, 13):
        assert np.max(np.abs(sf.simulate(pendulum(), tolerance).final - exact)) < 20 * tolerance


@pytest.mark.parametrize("bad", [0, 1.0, -1e-9, 1e-17, math.nan, math.inf, "tight", True, None])
def test_tolerance_is_checked(bad):
    with pytest.raises(sf.SceneError, match="tolerance"):
        sf.simulate(pendulum(), bad)


@pytest.mark.parametrize(
    "settings", [{"order": 2}, {"order": 61}, {"max_steps": 0}, {"max_events": 0}], ids=lambda s: next(iter(s))
)
def test_settings_are_checked(settings):
    with pytest.raises(sf.SceneError, match=f"{next(iter(settings))} is .*; give a whole number"):
        sf.Taylor(**settings)


def test_phase_portrait_of_one_swing_has_the_closed_form():
    # Coulomb friction of 3 percent: circles about +-delta
    run = sf.simulate(named("P1").scene.wanting({"path": sf.Trajectory()}), 1e-13)
    t = np.linspace(0, math.pi, 50)[1:-1]
    assert run(t)[0] == pytest.approx(0.03 + 0.97 * np.cos(t), abs=1e-13)
    assert run(math.pi + t)[0] == pytest.approx(-0.03 - 0.91 * np.cos(t), abs=1e-12)
    assert [e.t for e in run.events] == pytest.approx(np.arange(1, 18) * math.pi, abs=1e-11)


@pytest.mark.one_in(3)
@pytest.mark.parametrize("name", ["stribeck", "exponential", "custom"])
def test_the_independent_route_reaches_the_end_of_an_excited_run(name):
    scene = sf.scenes.mass_on_belt(LAWS[name], v_b=0.2, a=0.01, Omega=20.0, horizon=12.0)
    assert sf.simulate(scene.wanting({"events": sf.Events()}), 1e-7, route="integrators").status == sf.Status.OK
