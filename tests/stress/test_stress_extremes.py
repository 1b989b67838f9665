"""Extreme numbers and awkward starts: each run ends right, or with a status that says why, and never hangs."""

import math
import tracemalloc

import numpy as np
import pytest
import sympy as sp

import symfric as sf

BOUNDED = sf.Taylor(max_steps=3_000_000, max_events=300_000)
X, U = sp.symbols("x u", real=True)
WANTED = {"end": sf.End(), "high": sf.Max(X), "rest": sf.StopTime()}
ONSET = 0.39579028879783  # belt speed at which the cycle first sticks


@pytest.fixture(scope="module")
def belts():
    """Return the program at a coarse and at a fine tolerance."""
    return [sf.prepare(sf.scenes.mass_on_belt(v_b=0.2).wanting(WANTED), tol, BOUNDED) for tol in (1e-9, 1e-13)]


def ended(run):
    """Every run must end either well or with advice, in finite numbers."""
    assert (run.status == sf.Status.OK) == (run.advice == "")
    return run.status == sf.Status.OK


@pytest.mark.parametrize("beta", [0.0, 10.0])
@pytest.mark.parametrize("v_b", [1e-9, 1e-6, 1e-3, 0.1, 1.0, 10.0, 1e3])
def test_belt_speed_over_twelve_decades(belts, v_b, beta):
    values = {"v_b": v_b, "beta": beta}
    coarse, fine = (belt.run(values) for belt in belts)
    assert ended(coarse)
    assert ended(fine)
    assert coarse.stats["events"] == fine.stats["events"]
    assert np.max(np.abs(coarse.final - fine.final)) < 1e-8 * max(1.0, np.max(np.abs(fine.final)))
    if v_b <= 1e-6:  # x = v_b t - delta while it sticks; it is caught after about v_b / gamma2 mu_s
        assert fine.final[1] == v_b
        assert fine.final[0] == pytest.approx(100 * v_b, rel=1e-4)


@pytest.mark.parametrize("gamma2", [1e-6, 1e-3, 1e3, 1e6])
def test_friction_over_twelve_decades(belts, gamma2):
    coarse, fine = (belt.run({"gamma2": gamma2}) for belt in belts)
    assert ended(coarse)
    assert coarse.final == pytest.approx(fine.final, rel=1e-7, abs=1e-8 * min(gamma2, 1))
    if gamma2 >= 1e3:  # the belt carries it the whole time
        assert fine.final[1] == 0.2
    if gamma2 <= 1e-3:  # linear: x' is too small to change the friction, x = F (1 - e^(-beta t) ...) with F = gamma2 mu
        mu = 0.4 - 0.225 * (0.4 - 0.4**3 / 3)
        damped = math.sqrt(1 - 0.05**2)
        swing = math.exp(-0.05 * 100) * (math.cos(damped * 100) + 0.05 / damped * math.sin(damped * 100))
        assert fine.final[0] == pytest.approx(gamma2 * mu * (1 - swing), rel=0.05)


@pytest.mark.one_in(4)
@pytest.mark.parametrize("Omega", [1e2, 1e3, 1e4])
def test_fast_excitation_tends_to_the_effective_law(Omega):
    values, scene = {"a": 0.5 / Omega, "Omega": Omega}, sf.scenes.mass_on_belt(v_b=0.2, horizon=20 * math.pi)
    coarse = sf.simulate(scene.where(values).wanting(WANTED), 1e-9, BOUNDED)
    assert ended(coarse)
    assert coarse.final[0] == pytest.approx(0.06459190434756, abs=0.01 / Omega + 40 / Omega**2)
    fine = sf.simulate(scene.where(values).wanting(WANTED), 1e-12, BOUNDED)
    assert np.max(np.abs(coarse.final - fine.final)) < 1e-6
    assert coarse.stats["events"] == fine.stats["events"]


@pytest.mark.long(beside="test_event_budget_ends_the_run_with_advice")
def test_excitation_of_1e5_over_ten_periods_ends_within_its_budget():
    scene = sf.scenes.mass_on_belt(v_b=0.2, a=0.5e-5, Omega=1e5, horizon=20 * math.pi).wanting(WANTED)
    short = sf.simulate(scene, 1e-9, sf.Taylor(max_events=50_000))
    assert short.status == sf.Status.EVENT_BUDGET
    assert "max_events" in short.advice
    assert short.t_final == pytest.approx(50_000 * math.pi / 1e5, rel=0.1)  # two crossings a period
    full = sf.simulate(scene, 1e-9, sf.Taylor(max_steps=10_000_000, max_events=3_000_000))
    assert ended(full)
    assert full.final[0] == pytest.approx(0.06459190434756, abs=1e-6)


def _kept(program):
    """Bytes of the arrays that the program keeps for its next run."""
    workspace = program._model.workspace()
    size = sum(a.nbytes for _, a in workspace.arrays.items())
    program._model.give_back(workspace)
    return size


@pytest.mark.long(beside="test_a_motion_that_explodes_ends_with_a_status")
def test_long_horizon_takes_no_memory_when_only_scalars_are_wanted():
    program = sf.prepare(sf.scenes.mass_on_belt(v_b=0.2, horizon=1e6).wanting(WANTED), 1e-9)
    size = _kept(program)
    program.run({"v_b": 1.0})
    peaks = []
    for _ in range(3):  # other threads of the test run may allocate meanwhile
        tracemalloc.start()
        try:
            run = program.run()
            peaks.append(tracemalloc.get_traced_memory()[1])
        finally:
            tracemalloc.stop()
        assert ended(run)
    assert min(peaks) < 200_000
    assert _kept(program) == size
    assert run.stats["events"] == pytest.approx(2 * 1e6 / 6.79942144447216, abs=2)  # two a period
    assert run.outputs["high"] == pytest.approx(0.56646946672378879, abs=1e-7)


@pytest.mark.one_in(6)
@pytest.mark.parametrize("x", [-0.5, -0.42, -0.4, 0.0, 0.38, 0.38 + 1e-15, 0.4, 0.42, 0.5])
def test_start_exactly_on_the_switching_surface(x):
    initial = {"x": x, "u": 0.2}
    scene = sf.scenes.mass_on_belt(v_b=0.2, horizon=10.0).starting(initial)
    coarse, fine = sf.simulate(scene, 1e-6), sf.simulate(scene, 1e-12)
    other = sf.simulate(scene, 1e-9, route="integrators").checked()
    assert ended(coarse)
    assert coarse.final == pytest.approx(fine.final, abs=1e-5)
    assert other.final == pytest.approx(fine.final, abs=1e-7)
    held = -0.42 - 1e-12 < x < 0.38 - 1e-12  # |x + 2 beta v_b| <= mu_s; at its upper end the belt carries it out
    assert (fine.mode[0, 0] == 0) == held
    if not held:
        assert fine.mode[0, 0] == -np.sign(x)


@pytest.mark.parametrize("x0", [0.3, -0.3, 0.5, -0.5, 0.0, 1e-300])
def test_start_at_rest_inside_the_stick_band(x0):
    run = sf.simulate(sf.scenes.coulomb_oscillator(0.5, x0=x0), 1e-9)
    assert ended(run)
    assert run.final.tolist() == [x0, 0.0]
    assert run.outputs["stop_time"] == 0
    assert run.events == ()


def test_start_at_rest_just_outside_the_stick_band():
    run = sf.simulate(sf.scenes.coulomb_oscillator(0.5, x0=0.5 + 1e-9), 1e-12)
    assert run.final[0] == pytest.approx(0.5 - 1e-9, abs=1e-14)
    assert run.outputs["stop_time"] == pytest.approx(math.pi, abs=1e-6)


@pytest.mark.parametrize("initial", [{"x": 1.0}, {"x": 1.0, "u": 0.2}])
def test_zero_normal_load_is_a_free_oscillator(initial):
    scene = sf.scenes.mass_on_belt(v_b=0.2, gamma2=0.0, beta=0.0, horizon=10.0).starting(initial)
    run, u = sf.simulate(scene, 1e-11), initial.get("u", 0.0)
    assert ended(run)
    free = [math.cos(10) + u * math.sin(10), -math.sin(10) + u * math.cos(10)]
    assert run.final == pytest.approx(free, abs=1e-9)


def test_equal_static_and_kinetic_friction_from_rest_on_the_belt():
    # Coulomb: sticks to x = mu, then rests there in a circle of radius v_b about mu
    run = sf.simulate(sf.scenes.mass_on_belt(sf.laws.coulomb(0.3), v_b=0.2, beta=0.0), 1e-12)
    assert ended(run)
    released = run.events[1]
    phase = 100 - released.t
    assert released.after == -1
    assert run.final == pytest.approx([0.3 + 0.2 * math.sin(phase), 0.2 * math.cos(phase)], abs=1e-10)


@pytest.mark.one_in(3)
@pytest.mark.parametrize(
    ("delta", "half_cycles", "stop"),
    [
        (1 / 3, 1, -1 / 3),
        (0.2, 2, 0.2),
        (1 / 7, 3, -1 / 7),
        (1 / 9, 4, 1 / 9),
        (0.1, 5, 0.0),
        (0.25, 2, 0.0),
        (0.125, 4, 0.0),
        (0.03, 17, 0.02),
        (0.001, 500, 0.0),
    ],
)
@pytest.mark.parametrize("tolerance", [1e-6, 1e-9, 1e-13])
def test_ties_of_the_coulomb_oscillator(delta, half_cycles, stop, tolerance):
    run = sf.simulate(sf.scenes.coulomb_oscillator(delta), tolerance)
    assert ended(run)
    assert run.final == pytest.approx([stop, 0], abs=10 * tolerance)
    assert run.stats["events"] == half_cycles
    assert run.outputs["stop_time"] == pytest.approx(half_cycles * math.pi, rel=10 * tolerance, abs=10 * tolerance)


@pytest.mark.one_in(12)
@pytest.mark.parametrize("shift", [-1e-3, -1e-5, -1e-7, -1e-9, -1e-11, 0.0, 1e-11, 1e-9, 1e-7, 1e-5, 1e-3])
def test_the_graze_from_both_sides(shift):
    # below the onset the cycle sticks, above it slips; nearer than its own error no run can tell
    scene = sf.scenes.mass_on_belt(v_b=ONSET + shift, horizon=400.0)
    fine = sf.simulate(scene, 1e-14)
    assert ended(fine)
    if abs(shift) >= 1e-7:
        assert (fine.stats["events"] > 20) == (shift < 0)
    for tolerance in (1e-6, 1e-8, 1e-10, 1e-12):
        run = sf.simulate(scene, tolerance)
        assert ended(run)
        assert np.max(np.abs(run.final - fine.final)) < 100 * tolerance
        if tolerance < 0.01 * abs(shift):
            assert run.stats["events"] == fine.stats["events"]


def test_a_start_that_grazes_exactly():
    # frictionless slip at unit frequency: u = v_b sin touches the belt's speed in one point
    scene = sf.scenes.mass_on_belt(sf.laws.coulomb(0), v_b=0.2, beta=0.0, horizon=20.0).starting({"x": 0.2})
    run = sf.simulate(scene, 1e-12)
    assert ended(run)
    assert run.final == pytest.approx([0.2 * math.cos(20), -0.2 * math.sin(20)], abs=1e-11)


@pytest.mark.parametrize("budget", [1, 2, 7, 29])
def test_event_budget_ends_the_run_with_advice(budget):
    run = sf.simulate(sf.scenes.mass_on_belt(v_b=0.2), 1e-9, sf.Taylor(max_events=budget))
    assert run.status == sf.Status.EVENT_BUDGET
    assert "max_events" in run.advice
    assert 0 < run.t_final < 100
    assert run.stats["events"] <= budget + 1
    assert run(run.t_final) == pytest.approx(run.final, abs=1e-12)


@pytest.mark.parametrize("budget", [1, 11, 100])
def test_step_budget_ends_the_run_with_advice(budget):
    run = sf.simulate(sf.scenes.mass_on_belt(v_b=0.2), 1e-9, sf.Taylor(max_steps=budget))
    assert run.status == sf.Status.STEP_BUDGET
    assert "max_steps" in run.advice
    assert run.stats["steps"] == budget
    assert run.t.size == budget + 1


@pytest.mark.long(beside="test_a_motion_that_explodes_ends_with_a_status")
@pytest.mark.parametrize("tolerance", [1e-6, 1e-9, 1e-13])
def test_a_singular_force_ends_with_a_status(tolerance):
    contact = [sf.Contact("floor", U, sp.Rational(1, 10), sf.laws.coulomb(1))]
    system = sf.System(q=[X], u=[U], mass=[[1]], force=[-1 / X**2])
    scene = sf.Scene(system=system, contacts=contact, initial={X: 1.0, U: 0.0}, horizon=30.0)
    run = sf.simulate(scene, tolerance, BOUNDED)
    assert not ended(run)
    # falls as x'' = -1/x^2 + .1: arrives after int_0^1 dx / sqrt(2/x - 2 - (1 - x)/5)
    arrival = float(sp.Integral(1 / sp.sqrt(2 / X - 2 - (1 - X) / 5), (X, 0, 1)).evalf(12))
    assert run.t_final == pytest.approx(arrival, abs=1e-6)


def test_a_motion_that_explodes_ends_with_a_status():
    system = sf.System(q=[X], u=[U], mass=[[1]], force=[2 * X**3])
    scene = sf.Scene(system=system, initial={X: 1.0, U: 1.0}, horizon=2.0)  # x = 1/(1 - t)
    run = sf.simulate(scene.wanting({"end": sf.End()}), 1e-9, BOUNDED)
    assert not ended(run)
    assert run.t_final == pytest.approx(1.0, abs=1e-6)


def test_static_friction_below_kinetic_friction_is_refused_or_undecided():
    scene = sf.scenes.coulomb_oscillator(0.3)
    with pytest.raises(sf.SceneError, match="static coefficient"):
        scene.where({"delta_s": 0.1})
    with pytest.raises(sf.SceneError, match="static coefficient"):
        sf.prepare(scene, 1e-9).run({"delta_s": 0.1})
    mu_s = sp.Symbol("mu_s")
    belt = sf.scenes.mass_on_belt(sf.laws.custom(0.3, mu_s), v_b=0.2).where({mu_s: 0.4})
    run = sf.prepare(belt, 1e-9).run({"mu_s": 0.1})
    assert run.status == sf.Status.UNDECIDED
    assert "static" in run.advice


@pytest.mark.one_in(4)
@pytest.mark.parametrize("zero", [{"v_b": 0.0}, {"gamma2": 0.0}, {"beta": 0.0}, {"v_b": 0.0, "beta": 0.0}])
def test_parameters_that_become_zero_or_leave_it(zero):
    scene = sf.scenes.mass_on_belt(v_b=0.2).starting({"x": 1.0})
    other = dict.fromkeys(zero, 0.11)
    from_zero = sf.prepare(scene.where(zero), 1e-11)
    assert np.array_equal(from_zero.run().final, sf.simulate(scene.where(zero), 1e-11).final)
    assert from_zero.run(other).final == pytest.approx(sf.simulate(scene.where(other), 1e-11).final, abs=1e-10)
    to_zero = sf.prepare(scene, 1e-11).run(zero)
    assert to_zero.final == pytest.approx(from_zero.run().final, abs=1e-10)


@pytest.mark.parametrize("half_cycles", [1, 2, 3, 4, 10, 50])
@pytest.mark.parametrize("tolerance", [1e-6, 1e-9, 1e-13])
def test_a_stop_exactly_at_the_static_bound_is_a_stop(half_cycles, tolerance):
    run = sf.simulate(sf.scenes.coulomb_oscillator(1 / (2 * half_cycles + 1)), tolerance)
    assert run.outputs["stop_time"] == pytest.approx(half_cycles * math.pi, rel=10 * tolerance)
    assert run.stats["events"] == half_cycles


@pytest.mark.parametrize("half_cycles", [1, 4, 20])
@pytest.mark.parametrize("beyond", [-1e-3, -1e-4, 1e-4, 1e-3])
def test_a_stop_near_the_static_bound_is_decided(half_cycles, beyond):
    delta = (1 + beyond) / (2 * half_cycles + 1)  # the last turn lies just inside or just outside the bound
    run = sf.simulate(sf.scenes.coulomb_oscillator(delta), 1e-7)
    assert run.stats["events"] == half_cycles + (beyond < 0)
