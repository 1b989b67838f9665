"""Bifurcation diagrams and basins against orbits found by Newton's method, closed forms, and single runs."""

import numpy as np
import pytest
import sympy as sp

import symfric as sf
from symfric.ensemble.worker import REFUSED

X, U = sp.symbols("x u", real=True)
C, F, W = sp.symbols("c f w", positive=True)
HOPF, FOLD = np.log(4), 1.7448752079391  # between them the belt slides steadily or drags the mass along


def belt(**changes):
    """Steady sliding and a large cycle coexist; an unstable cycle lies between them."""
    return sf.scenes.mass_on_belt(
        sf.laws.exponential(0.4, 1.0), **{"v_b": 1.6, "beta": 0.05, "horizon": 800, **changes}
    )


def oscillator(force, values=None, **changes):
    start = {"initial": {X: 1.0, U: 0.0}, "horizon": 100.0, **changes}
    return sf.Scene(sf.System(q=[X], u=[U], mass=[[1]], force=[force]), (), values or {}, **start)


@pytest.fixture(scope="module")
def bistable():
    return sf.basins(belt(), {"x": np.linspace(-3, 3, 61)})


def test_hysteresis_of_the_belt():
    speeds = np.linspace(1.2, 1.8, 13)
    rules = {"section": "u", "direction": -1, "transient": 1400.0, "carry": True}
    scene = belt(horizon=1500)
    up = sf.bifurcation_diagram(scene.starting({"x": 2.0}), "v_b", speeds, **rules)
    down = sf.bifurcation_diagram(scene, "v_b", speeds[::-1], **rules)
    high = np.array([np.max(up.points(k)[0]) for k in range(speeds.size)])
    low = np.array([np.max(down.points(k)[0]) for k in range(speeds.size)])[::-1]
    assert np.array_equal(high > 1, speeds < FOLD)
    apart = np.abs(speeds - HOPF) > 0.05  # nearer, the vibration takes longer to grow
    assert np.array_equal(low[apart] > 1, speeds[apart] < HOPF)
    assert high[6] == pytest.approx(sf.limit_cycle(belt(v_b=1.5).starting({"x": 2.0})).x_max[0], rel=1e-9)
    assert low[12] == pytest.approx(0.4 * np.exp(-1.8), abs=1e-4)  # steady sliding
    assert np.all(np.diff(up.points(6)[0]) < 1e-8)
    assert np.all(up.times >= 1400)


def test_forced_diagram_is_the_resonance_curve():
    """x'' + x/5 + x = cos wt: one point for each frequency, on threads the same, and carried on too."""
    scene = oscillator(-X - C * U + F * sp.cos(W * sf.TIME), {C: 0.2, F: 1.0, W: 1.0}, horizon=400.0)
    w = np.linspace(0.6, 1.4, 9)
    found = sf.bifurcation_diagram(scene, W, w, transient=300.0, tolerance=1e-12)
    assert np.allclose(found.states[0], (1 / (1 - w**2 + 0.2j * w)).real[found.case], rtol=0, atol=1e-9)
    assert np.array_equal(np.bincount(found.case), [np.sum(found.case == k) for k in range(9)])
    assert np.array_equal(np.bincount(found.case), np.floor(400 * w / (2 * np.pi)) - np.ceil(300 * w / (2 * np.pi)) + 1)
    threads = sf.bifurcation_diagram(scene, W, w, transient=300.0, tolerance=1e-12, jobs=2)
    assert np.array_equal(threads.states, found.states)
    carried = sf.bifurcation_diagram(scene, W, w, transient=300.0, tolerance=1e-12, carry=True)
    assert np.allclose(carried.states, found.states, rtol=0, atol=1e-9)
    table = found.to_xarray()
    assert np.array_equal(table.w.values, w[found.case])
    assert found.to_dict()["points"][0]["x"] == found.points(0)[0].tolist()


def test_values_with_one_period_run_at_once_and_give_the_points_of_single_runs():
    """The speed does not change the period; one value fails, and leaves the others alone."""
    scene = sf.scenes.mass_on_belt(v_b=0.2, a=0.5, Omega=1.3, horizon=60.0)
    speeds = [0.1, 0.25, 0.4]
    found = sf.bifurcation_diagram(scene, "v_b", speeds, phase=0.25, transient=20.0)
    threads = sf.bifurcation_diagram(scene, "v_b", speeds[::-1], phase=0.25, transient=20.0, jobs=2)
    for k, v in enumerate(speeds):
        own = sf.poincare(scene.where({"v_b": v}), phase=0.25, after=20.0)
        assert np.array_equal(found.times[found.case == k], own.times)
        assert np.allclose(found.points(k), own.states, rtol=0, atol=1e-8)
        assert np.array_equal(found.points(k), threads.points(2 - k))
    soft = oscillator(-X + C * X**3 + F * sp.cos(sf.TIME), {C: 0.1, F: 0.01})
    found = sf.bifurcation_diagram(soft, "c", [0.1, 1.5, 0.2])  # beyond c = 1 it escapes
    assert found.status[[0, 2]].tolist() == [0, 0]
    assert found.status[1] > 0
    assert np.array_equal(np.unique(found.case), [0, 2])


def test_carried_values_go_on_at_the_phase_of_the_excitation():
    """At a horizon of no whole number of periods, the start of the second value is the state at the last whole one."""
    scene = oscillator(-X + sp.cos(W * sf.TIME), {W: 0.5}, horizon=30.0)  # undamped: nothing is forgotten
    found = sf.bifurcation_diagram(scene, "w", [0.5, 0.8], transient=0.0, carry=True, tolerance=1e-13)
    last = found.points(0)[:, -1]
    assert np.allclose(found.points(1)[:, 0], last, rtol=0, atol=1e-12)
    again = sf.poincare(scene.where({"w": 0.8}).starting(dict(zip("xu", last.tolist(), strict=True))), tolerance=1e-13)
    assert np.allclose(found.points(1), again.states, rtol=0, atol=1e-10)


def test_values_that_fail_are_a_status():
    soft = oscillator(-X + C * X**3, {C: 0.5})
    found = sf.bifurcation_diagram(soft, "c", [0.5, 1.5], "u")  # beyond c = 1 it escapes
    assert found.status[0] == 0
    assert found.status[1] > 0
    assert np.all(found.case == 0)
    resting = sf.scenes.coulomb_oscillator(0.03, horizon=100.0)
    found = sf.bifurcation_diagram(resting, "delta", [0.02, 0.03, 0.5], "u", transient=95.0)
    assert found.status.tolist() == [0, 0, REFUSED]  # kinetic above static friction
    assert np.array_equal(found.case, [0, 1])
    assert found.states[0, 1] == pytest.approx(sf.simulate(resting).final[0], abs=1e-12)


def test_border_of_the_basins_is_the_unstable_cycle(bistable):
    cycle, sliding = (
        next(k for k, a in enumerate(bistable.attractors) if a.kind == kind) for kind in ("cycle", "equilibrium")
    )
    branch = sf.continue_cycle(belt(), "v_b", (1.3, 1.6), sf.hopf(belt(), "v_b", (1.0, 2.0)))
    border = branch.orbits[-1]
    assert branch.values[-1] == 1.6
    assert not border.stable
    turns = np.sort(sf.poincare(border.run, "u", direction=0)["x"])  # where it meets the line u = 0
    x = bistable.axes["x"]
    inside = (x > turns[0]) & (x < turns[1])
    assert np.array_equal(bistable.label, np.where(inside, sliding, cycle))
    assert np.min(np.abs(np.subtract.outer(turns, x))) > 1e-3  # no start is on the border by accident
    assert bistable.attractors[sliding].points[0, 0] == pytest.approx(0.4 * np.exp(-1.6), abs=1e-4)
    assert bistable.attractors[cycle].orbit.stable
    assert np.all(bistable.status == 0)


def test_labels_are_what_single_runs_do(bistable):
    late = sf.prepare(belt(horizon=2000).wanting({"end": sf.End(), "path": sf.Trajectory()}))
    for k in (5, 20, 30, 44, 45, 55):
        run = late.run(initial={"x": bistable.axes["x"][k]})
        swings = np.max(np.abs(run(np.linspace(1900, 2000, 500))[0]))
        assert (swings > 1) == (bistable.attractors[bistable.label[k]].kind == "cycle")


def test_two_wells_with_damping():
    """The basins are each other's mirror image, and the saddle keeps what starts on it."""
    scene = oscillator(X - X**3 - U / 4)
    row = np.linspace(-2, 2, 11)
    found = sf.basins(scene, {X: row, U: row})
    left, right = (next(k for k, a in enumerate(found.attractors) if abs(a.points[0, 0] - x) < 1e-4) for x in (-1, 1))
    assert np.array_equal(found.label == left, (found.label == right)[::-1, ::-1])
    saddle = found.label[5, 5]
    assert saddle not in (left, right)
    assert np.allclose(found.attractors[saddle].points, 0)
    assert np.sum(found.label == saddle) == 1
    assert np.sum(found.shares) == pytest.approx(1)
    table = found.to_xarray()
    assert table.attractor.sel(x=0, u=0) == saddle
    assert found.plot().get_xlabel() == "x"


@pytest.mark.long(beside="test_forced_diagram_is_the_resonance_curve")
def test_forced_wells_hold_a_cycle_each_or_one_chaotic_motion():
    force = X - X**3 - C * U + F * sp.cos(sf.TIME)
    row = {"x": [-1.5, -0.5, 0.5, 1.5]}
    small = sf.basins(oscillator(force, {C: 0.25, F: 0.2}, horizon=200.0), row)
    assert [a.kind for a in small.attractors] == ["cycle", "cycle"]
    assert all(a.orbit.period == pytest.approx(2 * np.pi) for a in small.attractors)
    one, other = (np.mean([a.orbit.x_max[0], a.orbit.x_min[0]]) for a in small.attractors)
    assert one == pytest.approx(-other)
    large = sf.basins(oscillator(force, {C: 0.25, F: 0.4}, horizon=300.0), {"x": [-1.5, 0.5]})
    assert [a.kind for a in large.attractors] == ["irregular"]
    assert np.all(large.label == 0)


def test_rest_is_one_attractor_and_escape_is_a_status():
    found = sf.basins(sf.scenes.coulomb_oscillator(0.03), {"x": np.linspace(-1, 1, 5)})
    assert [a.kind for a in found.attractors] == ["rest"]
    assert found.shares == [1.0]
    soft = sf.basins(oscillator(-X + X**3 - U / 4), {"x": [-1.5, -0.5, 0.5, 1.5]})
    assert soft.label.tolist() == [-1, 0, 0, -1]
    assert np.array_equal(soft.status > 0, [True, False, False, True])


@pytest.mark.parametrize(
    ("ask", "message"),
    [
        (lambda: sf.basins(belt(), {"y": [0.0]}), "y in starts is no state"),
        (lambda: sf.basins(belt(), {"x": [np.inf]}), "not finite"),
        (lambda: sf.basins(belt(), {}), "give a mapping of states"),
        (lambda: sf.basins(belt(), {"x": [0.0]}, near=0), "near is 0"),
        (lambda: sf.basins(belt(), {"x": [0.0]}, jobs=0), "jobs is 0"),
        (lambda: sf.basins("belt", {"x": [0.0]}), "not a scene"),
        (lambda: sf.bifurcation_diagram(belt(), "v", [1.0], "u"), "v is no parameter"),
        (lambda: sf.bifurcation_diagram(belt(), "v_b", [], "u"), "give a sequence of at least one"),
        (lambda: sf.bifurcation_diagram(belt(), "v_b", [1.0]), "nothing depends on time; give a section"),
        (lambda: sf.bifurcation_diagram(belt(), "v_b", [1.0], "u", transient=1e4), "transient is 10000"),
    ],
)
def test_wrong_input_is_one_line(ask, message):
    with pytest.raises(sf.SceneError, match=message):
        ask()
