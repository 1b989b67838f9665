"""The route `integrators` against the benchmark's references, and against the route it is meant to check."""

import os
import subprocess
import sys

import numpy as np
import pytest
import sympy as sp

import symfric as sf
from symfric.solve.integrators import program
from symfric.solve.integrators.dense_output.hermite import first_fall
from symfric.solve.integrators.route import Integrators
from symfric.solve.integrators.sizes import first_sizes
from symfric_evidence.bench.problems import named
from tests.longer import longer

COMPARED = {"path": sf.Trajectory(), "rest": sf.StopTime()}


def error(run, problem) -> float:
    return max(abs(v - float(true)) for v, true in zip(run.checked().final, problem.reference, strict=True))


@pytest.mark.one_in(6)
@pytest.mark.parametrize("plugin", ["erk", "rosenbrock"])
@pytest.mark.parametrize(
    ("name", "tolerance"),
    [
        ("P1", 1e-6),
        ("P1", 1e-9),
        ("P2", 1e-6),
        ("P2", 1e-9),
        pytest.param("P3", 1e-6, marks=pytest.mark.long),
        pytest.param("P3", 1e-9, marks=pytest.mark.long),
    ],
)
def test_the_exact_law_is_right_within_the_tolerance(plugin, name, tolerance):
    problem = named(name)
    run = sf.prepare(problem.scene, tolerance, Integrators(plugin)).run()
    assert error(run, problem) < 10 * tolerance
    assert run.stats["events"] == problem.events


SMOOTH = [("erk", 1e-7), ("rosenbrock", 1e-7), ("cvodes", 1e-6), ("cvodes", 1e-9), ("idas", 1e-6), ("idas", 1e-9)]


@pytest.mark.parametrize(
    "case", longer(SMOOTH, [case for case in SMOOTH if case not in (("cvodes", 1e-6), ("idas", 1e-9))])
)
def test_the_regularised_law_is_right_within_the_tolerance(case):
    plugin, tolerance = case
    problem = named("P4")
    run = sf.prepare(problem.scene, tolerance, Integrators(plugin)).run()
    assert error(run, problem) < 10 * tolerance


def test_collocation_doubles_its_elements_until_the_result_stays():
    problem = named("P4")
    assert error(sf.prepare(problem.scene, 1e-4, Integrators("collocation")).run(), problem) < 1e-4
    hopeless = sf.prepare(problem.scene, 1e-9, Integrators("collocation", elements=4000)).run()
    assert hopeless.status == sf.Status.INTEGRATOR


@pytest.mark.one_in(2)
@pytest.mark.parametrize("name", ["P1", "P2"])
def test_motion_events_and_outputs_agree_with_the_taylor_route(name):
    scene = named(name).scene
    (x,), (u,) = scene.system.q, scene.system.u
    contact = scene.contacts[0].name
    outputs = {"high": sf.Max(x), "low": sf.Min(u), "half": sf.HalfRange(x)}
    outputs["work"] = sf.Integral(sf.friction_force(contact) * sf.slip(contact))
    scene = scene.wanting({**COMPARED, **outputs})
    exact, run = sf.simulate(scene, tolerance=1e-13), sf.prepare(scene, 1e-8, Integrators()).run()
    t = np.linspace(0, scene.horizon, 2001)
    assert np.max(np.abs(exact(t) - run(t))) < 1e-6
    assert [(e.before, e.after) for e in exact.events] == [(e.before, e.after) for e in run.events]
    assert np.max(np.abs(np.subtract([e.t for e in exact.events], [e.t for e in run.events]))) < 1e-6
    for wanted in outputs:
        assert run.outputs[wanted] == pytest.approx(exact.outputs[wanted], abs=1e-7)
    assert run.outputs["rest"] == pytest.approx(exact.outputs["rest"], abs=1e-6, nan_ok=True)
    assert run.energy_residual() < 1e-6


def chain(n: int, loads) -> sf.Scene:
    q, u = sp.symbols(f"q:{n}", real=True), sp.symbols(f"u:{n}", real=True)
    force = [-q[i] / 2 - sp.Rational(1, 20) * u[i] for i in range(n)]
    for i in range(n - 1):
        force[i] += q[i + 1] - q[i]
        force[i + 1] += q[i] - q[i + 1]
    law = sf.laws.cubic(0.4, 0.25, 0.5)
    contacts = [sf.Contact(f"c{i}", slip=u[i] - 0.2, normal=loads[i], law=law) for i in range(n)]
    system = sf.System(q=q, u=u, mass=sp.eye(n), force=force)
    return sf.Scene(system=system, contacts=contacts, initial=dict.fromkeys([*q, *u], 0.0), horizon=20.0)


def rubbing() -> sf.Scene:
    """Two bodies that rub on each other, one of them on the ground; a slip with two velocities."""
    a, b, ua, ub = sp.symbols("a b ua ub", real=True)
    force = [-a + sp.sin(sp.Rational(7, 10) * sf.TIME), -b - (b - a) / 2]
    contacts = [
        sf.Contact("between", slip=ua - ub, normal=1, law=sf.laws.coulomb(0.3, 0.2)),
        sf.Contact("ground", slip=ub, normal=1, law=sf.laws.stribeck(0.25, 0.1, 0.3)),
    ]
    system = sf.System(q=[a, b], u=[ua, ub], mass=[[1, 0], [0, 2]], force=force)
    return sf.Scene(system=system, contacts=contacts, initial={a: 1.0, b: 0.0, ua: 0.0, ub: 0.0}, horizon=20.0)


def shaken() -> sf.Scene:
    """Many reversals are followed by a stop within one step of the integrator: events it would step over."""
    x, u, ground = sp.symbols("x u ground", real=True)
    signal = sf.Signal(1.5 * np.random.default_rng(1).normal(size=200), 0.05)
    return sf.Scene(
        system=sf.System(q=[x], u=[u], mass=[[1]], force=[-4 * x - ground]),
        contacts=[sf.Contact("floor", slip=u, normal=1, law=sf.laws.coulomb(0.5, 0.3))],
        inputs={ground: signal},
        initial={x: 0.0, u: 0.0},
        horizon=10.0,
    )


@pytest.mark.one_in(4)
@pytest.mark.parametrize(
    "scene",
    [
        pytest.param(chain(3, (1, 1.1, 1.2)), id="chain"),
        pytest.param(chain(3, (1, 1, 1)), id="events at once"),
        pytest.param(rubbing(), id="rubbing"),
        pytest.param(shaken(), id="shaken"),
    ],
)
def test_several_contacts_and_sampled_inputs_agree_with_the_taylor_route(scene):
    scene = scene.wanting({"events": sf.Events()})
    exact, run = sf.simulate(scene, tolerance=1e-13), sf.prepare(scene, 1e-9, Integrators()).run().checked()
    assert np.max(np.abs(exact.final - run.final)) < 1e-7
    assert sorted((e.contact, e.before, e.after) for e in exact.events) == sorted(
        (e.contact, e.before, e.after) for e in run.events
    )


def test_other_values_and_another_start_of_a_prepared_program():
    scene = named("P2").scene.until(20.0)
    program = sf.prepare(scene, 1e-9, Integrators())
    values, initial = {"v_b": 0.3, "a": 0.01, "Omega": 5.0}, {"x": 0.1}
    expected = sf.prepare(scene.where(values).starting(initial), 1e-9, Integrators()).run()
    assert np.max(np.abs(program.run(values, initial).final - expected.final)) < 1e-8


def test_it_declines_what_it_cannot_do_and_says_why():
    with pytest.raises(sf.NoRoute, match="regularised"):
        sf.prepare(named("P2").scene, 1e-6, Integrators("cvodes"))
    with pytest.raises(sf.NoRoute, match="kinks"):
        sf.prepare(named("P4").scene.wanting(COMPARED), 1e-6, Integrators("idas"))
    with pytest.raises(sf.SceneError, match="no integrator 'euler'"):
        Integrators("euler")
    with pytest.raises(sf.SceneError, match="tolerance"):
        sf.prepare(named("P2").scene, 1e-20, Integrators())


def test_a_budget_of_events_ends_the_run_with_a_status():
    run = sf.prepare(named("P2").scene, 1e-6, Integrators(max_events=5)).run()
    assert run.status == sf.Status.EVENT_BUDGET
    assert run.t_final < named("P2").scene.horizon


def test_a_budget_of_steps_ends_the_run_with_a_status():
    run = sf.prepare(named("P2").scene, 1e-6, Integrators(max_steps=500)).run()
    assert run.status == sf.Status.STEP_BUDGET
    assert 0 < run.t_final < named("P2").scene.horizon
    assert run.stats["steps"] < 5000  # the budget and one piece


@pytest.mark.parametrize(("longest", "status"), [(1e-11, "INTEGRATOR"), (1e-3, "OK")])
def test_a_run_that_stands_still_ends_with_a_status(longest, status, monkeypatch):
    """As many pieces as are looked at together advance by far less than a millionth of the run, or by more."""
    monkeypatch.setattr(program, "_PIECES", 50)
    scene = named("P2").scene
    run = sf.prepare(scene, 1e-6, Integrators(max_step=longest * scene.horizon)).run()
    assert run.status == sf.Status[status]
    assert run.stats["pieces"] == 50 or status == "OK"
    assert run.stats["pieces"] >= 50


SLIPS = {  # of a slip that begins at zero and may be shorter than a step; continued beyond zero, laws may be singular
    "stribeck": (sf.laws.stribeck(0.4, 0.25, 0.2), 0.2, 0.01, 20.0),
    "a law that explodes": (sf.laws.stribeck(0.45, 0.2, 0.03), 0.1, 0.02, 20.0),
    "a law with a pole": (sf.laws.custom(0.3 / (1 + sf.SPEED), 0.35), 0.2, 0.01, 20.0),
    "a pole nearby": (sf.laws.custom(0.3 / (1 + 20 * sf.SPEED), 0.35), 0.05, 0.01, 20.0),
    "slow": (sf.laws.exponential(0.4, 0.8), 0.15, 0.005, 40.0),
    "strong": (sf.laws.gauss(0.3, 0.1, mu_s=0.4, b=0.05), 0.2, 0.05, 10.0),
    "kinks": (sf.laws.piecewise_linear(0.4, [0, 0.02, 0.5], [0.35, 0.25, 0.3]), 0.05, 0.01, 20.0),
}


@pytest.mark.long(beside="test_motion_events_and_outputs_agree_with_the_taylor_route")
@pytest.mark.parametrize("tolerance", [1e-6, 1e-8])
@pytest.mark.parametrize("name", SLIPS)
def test_short_slips_of_an_excited_belt_are_found(name, tolerance):
    law, v_b, a, Omega = SLIPS[name]
    scene = sf.scenes.mass_on_belt(law, v_b=v_b, a=a, Omega=Omega, horizon=6.0)
    scene = scene.wanting({"end": sf.End(), "events": sf.Events()})
    exact, run = sf.simulate(scene, 1e-13), sf.simulate(scene, tolerance, route="integrators").checked()
    assert [(e.before, e.after) for e in exact.events] == [(e.before, e.after) for e in run.events]
    assert np.max(np.abs(exact.final - run.final)) < 5 * tolerance
    assert np.max(np.abs(np.subtract([e.t for e in exact.events], [e.t for e in run.events]))) < 100 * tolerance


@pytest.mark.long(beside="test_a_motion_that_ends_in_infinity_is_a_status_in_bounded_time")
def test_a_law_with_a_pole_beyond_rest_ends_in_bounded_time():
    code = """
import symfric as sf
law = sf.laws.custom(0.3 / (1 + sf.SPEED), 0.35)
scene = sf.scenes.mass_on_belt(law, v_b=0.2, a=0.01, Omega=20.0, horizon=12.0).wanting({"events": sf.Events()})
print(sf.simulate(scene, 1e-6, route="integrators").status.name)
"""
    quiet = {**os.environ, "SYMFRIC_PROGRESS": "0"}  # on a busy machine the run takes long enough to show its progress
    out = subprocess.run(
        [sys.executable, "-c", code], capture_output=True, text=True, timeout=120, check=True, env=quiet
    )
    assert out.stdout.strip() == "OK"
    assert out.stderr == ""


@pytest.mark.one_in(2)
@pytest.mark.parametrize(
    "force", [sp.Symbol("x", real=True) ** 3, -1 / sp.Symbol("x", real=True)], ids=["grows", "pole"]
)
def test_a_motion_that_ends_in_infinity_is_a_status_in_bounded_time(force):
    x, u = sp.symbols("x u", real=True)
    system = sf.System(q=[x], u=[u], mass=[[1]], force=[force])
    run = sf.simulate(sf.Scene(system=system, initial={x: 1.0, u: 0.0}, horizon=10.0), 1e-8, route="integrators")
    assert run.status == sf.Status.INTEGRATOR
    assert "loosen the tolerance" in run.advice
    assert run.stats["steps"] < 20_000


def test_a_slope_that_is_infinite_at_rest_is_a_status_in_bounded_time():
    scene = sf.scenes.mass_on_belt(sf.laws.square_root(0.4, -0.1), v_b=0.2, horizon=12.0)
    run = sf.simulate(scene, 1e-7, route="integrators")
    assert run.status == sf.Status.INTEGRATOR
    assert run.stats["steps"] < 50_000


@pytest.mark.one_in(3)
@pytest.mark.parametrize("tolerance", [1e-5, 1e-6, 1e-8])
def test_a_stiff_motion_crosses_a_kink_slowly(tolerance):
    # the noise of the state decides the sign of the slope at the kink, on both of its sides
    scene = named("P4").scene.until(20.0)
    run = sf.simulate(scene, tolerance, route="integrators").checked()
    assert np.max(np.abs(run.final - sf.simulate(scene, 1e-13).final)) < 10 * tolerance


@pytest.mark.parametrize("Omega", [3.0, 40.0, 300.0])
def test_a_body_that_is_shaken_is_as_fast_as_the_force_and_its_frequency_make_it(Omega):
    """Under F sin(Omega t) a nearly free mass m has a velocity of amplitude F/(m Omega), however soft its spring."""
    x, u = sp.symbols("x u", real=True)
    system = sf.System(q=[x], u=[u], mass=[[4]], force=[2 * sp.sin(Omega * sf.TIME) - x / 10_000])
    scene = sf.Scene(system=system, initial={x: 0.0, u: 0.0}, horizon=100.0)
    program = sf.prepare(scene, 1e-8, Integrators("rosenbrock"))
    none = np.zeros(0)
    assert first_sizes(program._sizing, np.zeros(2), 0.0, none, none)[1] == pytest.approx(0.5 / Omega, rel=0.05)


def polynomial_rows(t, *coefficients):
    rows = [np.polynomial.Polynomial(c) for c in coefficients]
    return [np.array([p.deriv(k)(t) for p in rows]) for k in range(3)]


def test_the_first_fall_of_a_guard_is_found_between_nodes_and_from_zero():
    t, below = np.linspace(0, 3, 4), np.full(1, 1e-9)
    dip = [0.25 - 1e-6, -1, 1]  # (t - 1/2)^2 - 1e-6
    assert first_fall(t, *polynomial_rows(t, dip), below) == (0, pytest.approx(0.499, abs=1e-12))
    assert first_fall(t, *polynomial_rows(t, dip), np.full(1, 2e-6)) is None
    hop = [0, 1e-3, -1]  # up from zero and down again within a thousandth
    assert first_fall(t, *polynomial_rows(t, hop), below) == (0, pytest.approx(1e-3, abs=1e-12))
    down = [0, 0, 0, -1e-3]  # not positive at all: where it is more than noise
    assert first_fall(t, *polynomial_rows(t, down), below) == (0, pytest.approx(1e-2, rel=1e-6))
    assert first_fall(t, *polynomial_rows(t, [-1.0]), below) == (0, 0.0)
    assert first_fall(t, *polynomial_rows(t, [0, 0, 1]), below) is None
    both = polynomial_rows(t, [1.7, -1], [1.6, -1], [1])
    assert first_fall(t, *both, np.full(3, 1e-9)) == (1, pytest.approx(1.6, abs=1e-12))
