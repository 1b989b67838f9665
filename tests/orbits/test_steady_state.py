"""The one service that lets motions settle and measures them, and that nothing else does so."""

import ast
from itertools import islice
from pathlib import Path

import numpy as np
import pytest
import sympy as sp

import symfric as sf
from symfric.ensemble.cases import Listed
from symfric.orbits.guess import Fades
from symfric.orbits.steady_state import (
    END,
    Schedule,
    Settling,
    measuring,
    schedule,
    settling,
    stick_fraction,
    stick_intervals,
    still_changes,
    vibration,
)
from symfric.report.study.measurement import vibrations
from symfric.scenefile import SweepPlan

ROOT = Path(sf.__file__).parent
X, U = sp.symbols("x u", real=True)
C, W, F = sp.symbols("c w f", positive=True)
T = sf.TIME


def oscillator(force, values, horizon=20.0, start=(1.0, 0.0)):
    system = sf.System([X], [U], [[1]], [-X - C * U + force])
    return sf.Scene(system, (), {C: 0.3, **values}, dict(zip((X, U), start, strict=True)), horizon)


HARMONIC = oscillator(F * sp.cos(W * T), {F: 1.5, W: 1.7})


def amplitude(f, w, c=0.3):
    return f / np.hypot(1 - w**2, c * w)


def test_times_are_whole_periods_and_long_enough_to_see_some():
    period = 2 * np.pi / 1.7
    times = schedule(HARMONIC)
    assert times.forcing == pytest.approx(period)
    assert times.settle / period == pytest.approx(round(20 * 20.0 / period))
    assert times.window / period == pytest.approx(32)
    assert schedule(HARMONIC.where({F: 0.0})) == Schedule(400.0, 20.0)
    later_on = schedule(HARMONIC.where({F: 0.0}), varied=frozenset({"f"}))
    assert (later_on.settle, later_on.window) == (times.settle, times.window)
    slow = schedule(HARMONIC.where({W: 0.01}))
    assert "repeats itself after" in slow.note
    assert np.isnan(slow.forcing)


def test_a_window_begins_at_the_phase_at_which_settling_ends():
    start = {"x": 0.3, "u": -0.2}
    times = Schedule(7.3, 4.1, note="no whole periods")
    outputs = {"high": sf.Max(X), "path": sf.Trajectory()}
    runs = list(Settling(HARMONIC, times, outputs).windows({"w": 1.1}, start))
    assert len(runs) == 1  # the next window would begin at another phase
    whole = HARMONIC.where({W: 1.1}).starting(start).until(7.3 + 4.1).wanting({"path": sf.Trajectory()})
    run = sf.simulate(whole)
    t = np.linspace(0.0, 4.1, 50)
    assert runs[0](t) == pytest.approx(run(7.3 + t), abs=1e-7)


def test_settling_and_measuring_share_their_equations_where_the_phase_is_the_same():
    period = 2 * np.pi / 1.7
    for periods in (0, 1, 7, 123_457):
        times = Schedule(periods * period, period, period)
        assert measuring(HARMONIC, times, {}).system is HARMONIC.system
    for times in (Schedule(7.5 * period, period, period), Schedule(7.001 * period, period), Schedule(1.0, 2.0, np.nan)):
        moved = measuring(HARMONIC, times, {}).system.force[0]
        assert (
            float((moved - HARMONIC.system.force[0].subs(T, T + times.settle)).subs({**HARMONIC.values, T: 0.3})) == 0
        )


@pytest.mark.parametrize("settle", [0.0, 30 * np.pi])
def test_windows_follow_one_another(settle):
    given = HARMONIC.where({W: 2.0})
    follow = Settling(given, Schedule(settle, 2 * np.pi, np.pi), {"half": sf.HalfRange(X)})
    runs = list(islice(follow.windows(), 3))
    ends = [sf.simulate(given.until(settle + k * 2 * np.pi).wanting({"end": sf.End()})).final for k in (1, 2, 3)]
    for run, end in zip(runs, ends, strict=True):
        assert run.final == pytest.approx(end, abs=1e-7)


def test_a_run_that_fails_is_the_last():
    given = oscillator(X**3, {}, start=(2.0, 0.0))  # runs away
    for settle in (0.0, 50.0):
        (run,) = Settling(given, Schedule(settle, 50.0), {"high": sf.Max(X)}).windows()
        assert run.status != sf.Status.OK
        with pytest.raises(sf.RunFailed):
            Settling(given, Schedule(settle, 50.0), {"high": sf.Max(X)}).measured()


@pytest.mark.parametrize("unit", [1e-6, 1.0, 1e7])
def test_a_forced_vibration_is_the_closed_form_in_any_unit_of_length(unit):
    found = vibration(HARMONIC.where({F: 1.5 * unit}).starting({X: unit}), "x")
    assert found.settled
    assert found.half_range == pytest.approx(amplitude(1.5, 1.7) * unit, rel=1e-6)
    assert found.period == pytest.approx(2 * np.pi / 1.7, rel=1e-9)


@pytest.mark.one_in(2)
@pytest.mark.parametrize(("parameter", "values"), [("w", [0.6, 1.0, 1.9]), ("f", [0.5, 1.0, 3.0]), ("c", [0.2, 0.5])])
def test_a_sweep_is_the_closed_form_whatever_is_swept(parameter, values):
    found = vibrations(
        HARMONIC, parameter, np.array(values), SweepPlan(parameter, 0, 1, 3, "x"), lambda _fraction: None
    )
    at = [{"f": 1.5, "w": 1.7, "c": 0.3} | {parameter: v} for v in values]
    assert [v.half_range for v in found] == pytest.approx([amplitude(**e) for e in at], rel=1e-5)
    assert all(v.settled for v in found)


def test_a_sweep_from_an_excitation_of_zero_keeps_its_phase():
    values = np.array([0.0, 1.0, 2.0])
    plan = SweepPlan("f", 0, 1, 3, "x", 100.0, 3.0)
    found = vibrations(HARMONIC.where({F: 0.0}), "f", values, plan, lambda _fraction: None)
    assert all(v.settled for v in found)
    assert [v.half_range for v in found[1:]] == pytest.approx([amplitude(1.0, 1.7), amplitude(2.0, 1.7)], rel=1e-5)


def test_a_sweep_says_what_has_not_settled_and_what_failed():
    given = oscillator(F * X**3, {F: 1e-3}, horizon=5.0)
    plan = SweepPlan("c", 0, 1, 3, "x", 5.0, 5.0)
    slow, still = vibrations(given, "c", np.array([0.02, 8.0]), plan, lambda _fraction: None)
    assert "still changes" in slow.note
    assert slow.half_range > 0
    assert still.half_range < slow.half_range
    told = []
    ran_away, fine = vibrations(given, "f", np.array([30.0, 0.0]), plan, told.append)
    assert np.isnan(ran_away.half_range)
    assert np.isfinite(fine.half_range)
    assert told == sorted(told)
    assert told[-1] == 1.0


def test_listed_cases_are_the_runs_one_by_one():
    rng = np.random.default_rng(2)
    c, starts = rng.uniform(0.1, 0.5, 6), rng.normal(size=(2, 6))
    given = HARMONIC.wanting({END: sf.End(), "high": sf.Max(X)})
    program = sf.prepare(given)
    for jobs in (1, 3):
        status, found = Listed(given, ("c",)).run({"c": c}, starts, jobs=jobs)
        assert not np.any(status)
        for k in range(6):
            run = program.run({"c": c[k]}, dict(zip("xu", starts[:, k], strict=True)))
            assert run["high"] == found["high"][k]
            assert np.array_equal(run.final, found[END][:, k])
    starts[0, 2] = np.nan
    status, found = Listed(given, ("c",)).run({"c": c}, starts)
    assert status.tolist() == [0, 0, -1, 0, 0, 0]
    assert np.isnan(found["high"][2])


def test_scenes_of_both_stages_make_one_motion():
    times = Schedule(11.0, 3.0, note="no whole periods")
    end = sf.simulate(settling(HARMONIC, times)).final
    run = sf.simulate(measuring(HARMONIC, times, {"high": sf.Max(X)}, end))
    assert run.final == pytest.approx(sf.simulate(HARMONIC.until(14.0).wanting({"end": sf.End()})).final, abs=1e-8)


def test_the_share_of_sticking_is_that_of_its_intervals():
    run = sf.simulate(sf.scenes.mass_on_belt(v_b=0.2, horizon=40.0))
    for after in (0.0, 3.3, 20.0):
        (intervals,) = stick_intervals(run).values()
        time = sum(max(0.0, b - max(a, after)) for a, b in intervals)
        assert stick_fraction(run, after) == pytest.approx(time / (40.0 - after), rel=1e-12)


def test_windows_that_differ_have_not_settled():
    assert not still_changes((1.0, -1.0), (1.0 + 1e-4, -1.0))
    assert still_changes((1.0, -1.0), (0.99, -0.99))
    assert still_changes((100.001, 100.0), (100.002, 100.0))
    assert not still_changes((100.0 + 1e-9, 100.0), (100.0, 100.0))
    assert not still_changes((1e-5, -1e-5), (1e-6, -1e-6), reach=1.0)  # it comes to rest
    assert still_changes((1e-6, -1e-6), (1e-5, -1e-5), reach=1.0)  # it grows


@pytest.mark.one_in(3)
@pytest.mark.parametrize("size", [1e-2, 1e-3, 1e-4])
def test_a_small_cycle_far_from_the_start_is_no_rest(size):
    system = sf.System([X], [U], [[1]], [-X + 0.3 * (size**2 - X**2) / (size**2 + X**2 / 10) * U])
    given = sf.Scene(system, (), {}, {X: 1.0, U: 0.0}, 60.0)
    one = sf.limit_cycle(given)
    near = sf.limit_cycle(given.starting({X: 2 * size, U: 0.0}))
    assert one.half_range == pytest.approx(near.half_range, rel=1e-8)
    assert size < one.half_range[0] < 5 * size


@pytest.mark.parametrize("damping", [0.2, 0.02])
def test_what_fades_is_no_cycle(damping):
    with pytest.raises(Fades, match="settles"):
        sf.limit_cycle(oscillator(0, {C: damping}))


def called(node):
    return getattr(node.func, "attr", getattr(node.func, "id", "")) if isinstance(node, ast.Call) else ""


def restarts(tree):
    """Whether a module starts a run from the final state of another."""
    text = [ast.unparse(node) for node in ast.walk(tree) if isinstance(node, ast.Call)]
    return any(".run(" in call and "initial=" in call and ".final" in call for call in text)


def test_nothing_else_lets_motions_settle():
    """Excitations are moved on, and scenes restarted where a run ended, by the service alone."""
    moved, restarted, guessed = set(), set(), set()
    for path in ROOT.rglob("*.py"):
        text, name = path.read_text(), path.relative_to(ROOT).as_posix()
        if not any(word in text for word in ("later", ".final", "period_of", "nearest_return", "passages")):
            continue
        tree = ast.parse(text)
        calls = {called(node) for node in ast.walk(tree)}
        moved |= {name} if "later" in calls and "symfric.model.excitation import" in text else set()
        restarted |= {name} if ".final" in text and restarts(tree) else set()
        guessed |= {name} if calls & {"period_of", "nearest_return", "passages"} else set()
    assert moved == {"orbits/steady_state.py"}
    assert restarted == set()
    assert guessed == {"orbits/steady_state.py", "orbits/guess.py"}
