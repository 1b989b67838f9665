"""Jumps of states in dense output and in pictures."""

import dataclasses

import numpy as np
import pytest
import sympy as sp

import symfric as sf
from symfric.report.study.measurement import motion
from symfric.report.study.sections.motion import plot_held, plot_phase_portrait, plot_time_history
from symfric.solve.plotting import acting
from symfric.solve.routes import simulate

X, U = sp.symbols("x u", real=True)
CMD = sf.Held("cmd", 1 - X - U, every=0.5, delay=0.2)
LOG = sf.Held("log", X, every=0.5)


def scene(horizon=6.0, **more):
    rail = sf.Contact("rail", U, 1, sf.laws.coulomb(0.2))
    kick = sf.Reset(every=2, offset=1, set={U: U + 1, X: X - 0.1})
    system = sf.System([X], [U], [[1]], [CMD.symbol - X / 4])
    return sf.Scene(system, [rail], {}, {X: 0.0, U: 0.0}, horizon, held=[CMD, LOG], resets=[kick], **more)


def jumps_of(line):
    """Return the largest jump of a line between points of different abscissas."""
    t, y = (np.asarray(e, dtype=float) for e in line.get_data())
    return np.max(np.abs(np.diff(y))[np.diff(t) > 0])


@pytest.fixture(scope="module")
def run():
    return simulate(scene())


def test_dense_output_is_the_state_after_a_jump_and_before_the_one_before(run):
    kicks = np.array([1.0, 3.0, 5.0])
    after, before = run(kicks), run.before(kicks)
    assert after[1] - before[1] == pytest.approx(1.0, abs=1e-12)
    assert after[0] - before[0] == pytest.approx(-0.1, abs=1e-12)
    assert np.all(np.isin(kicks, run.jumps))
    assert np.array_equal(run.jumps_of("u"), kicks)
    acted = run.jumps_of(CMD.symbol)
    assert np.max(np.abs(np.round((acted - 0.2) / 0.5) * 0.5 + 0.2 - acted)) < 1e-14
    assert set(kicks) & {event.t for event in run.events if event.kind != "stick"}
    with pytest.raises(sf.SceneError, match="is no state"):
        run.jumps_of("v")
    assert np.array_equal(run.x[:, :-1], run(run.t[:-1]))
    between = np.setdiff1d(np.linspace(0.01, 5.99, 37), run.jumps)
    assert np.max(np.abs(run(between) - run.before(between))) < 1e-14
    assert np.array_equal(run.before(0.0), run(0.0))
    acts = 0.7  # of the sample at 0.5
    sampled = float(1 - run(0.5)[0] - run(0.5)[1])
    assert run(acts)[run.names.index("cmd")] == pytest.approx(sampled, abs=1e-12)
    assert run.before(acts)[run.names.index("cmd")] == pytest.approx(float(1 - run(0.0)[0] - run(0.0)[1]), abs=1e-12)
    with pytest.raises(sf.SceneError, match="the run covers"):
        run.before(7.0)


def test_scenes_without_jumps_have_none():
    belt = simulate(sf.scenes.mass_on_belt(v_b=0.2))
    assert belt.jumps.size == 0
    assert belt.stats["events"] > 10
    floor = simulate(sf.scenes.mass_on_belt(v_b=0.2).regularised(1e-3), 1e-6, "integrators")
    assert floor.jumps.size == 0


def test_samples_at_a_jump_are_those_after_it():
    asked = scene(outputs={"u": sf.Samples(U, [1.0, 2.0, 3.0])})
    run = simulate(asked)
    whole = simulate(asked.wanting({"path": sf.Trajectory()}))
    assert np.max(np.abs(run["u"] - whole([1.0, 2.0, 3.0])[1])) < 1e-12


def test_what_acts_is_drawn_in_steps(run):
    assert [h.name for h in acting(run.base)] == ["cmd"]
    ax = run.plot()
    (right,) = (a for a in ax.figure.axes if a is not ax)
    (held,) = right.get_lines()
    assert jumps_of(held) < 1e-12
    assert jumps_of(ax.get_lines()[0]) < 0.05
    assert [t.get_text() for t in ax.get_legend().get_texts()] == ["x", "a contact sticks", "cmd"]


def test_an_orbit_has_vertical_kicks():
    plain = dataclasses.replace(scene(200.0), resets=[sf.Reset(every=2, offset=1, set={U: U + 1})])
    orbit = sf.limit_cycle(plain)
    ax = orbit.plot()
    assert jumps_of(ax.get_lines()[0]) < 0.05


def test_the_study_draws_steps():
    found = motion(scene())
    assert np.count_nonzero(np.diff(found.t) == 0) >= 3 + 10
    lines = [plot_time_history(found, ["x"], {}), plot_held(found, ["cmd"], {})]
    assert max(jumps_of(ax.get_lines()[-1]) for ax in lines) < 0.05
    assert jumps_of(lines[1].get_lines()[0]) < 1e-12
    phase = plot_phase_portrait(dataclasses.replace(found), "x", "u", ["rail"], {})
    assert phase.get_lines()
    page = scene().study()
    assert "Held variables." in page.html()
