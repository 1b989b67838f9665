"""The contract of programs and runs: names, shapes, immutability, reading, and errors at the door."""

import dataclasses
import json
import pickle

import numpy as np
import pytest
import sympy as sp

import symfric as sf
from symfric.solve.status import ADVICE

X, U = sp.symbols("x u", real=True)
BELT = sf.scenes.mass_on_belt(v_b=0.2, horizon=30.0)
WANTED = {"path": sf.Trajectory(), "x_max": sf.Max(X), "end": sf.End(), "rest": sf.StopTime()}
ROUTES = ("exact", "taylor", "integrators")
LINES = sf.scenes.mass_on_belt(sf.laws.piecewise_linear(0.4, [0, 0.3], [0.4, 0.25], 0.1), v_b=0.2, horizon=30.0)


def belt(route):
    return LINES if route == "exact" else BELT


@pytest.fixture(scope="module", params=ROUTES)
def run(request):
    return sf.simulate(belt(request.param).wanting(WANTED), 1e-8, route=request.param)


def test_names_and_shapes(run):
    n = run.t.size
    assert run.names == ("x", "u")
    assert run.x.shape == (2, n)
    assert run.mode.shape == (1, n)
    assert run.final.shape == (2,)
    assert run.t[0] == 0
    assert run.t[-1] == run.t_final == 30
    assert np.issubdtype(run.mode.dtype, np.integer)
    assert set(run.mode.ravel()) <= {-1, 0, 1}
    assert isinstance(run.status, sf.Status)
    assert run.status == sf.Status.OK == 0
    assert run.route in ROUTES
    assert run.tolerance == 1e-8


@pytest.mark.parametrize("shape", [(), (1,), (5,), (3, 4), (0,)])
def test_dense_output_has_the_shape_of_its_times(run, shape):
    t = np.linspace(0, 30, int(np.prod(shape))).reshape(shape)
    assert run(t).shape == (2, *shape)


def test_dense_output_at_the_nodes_is_the_state(run):
    assert run(run.t[:-1]) == pytest.approx(run.x[:, :-1], abs=0)
    assert run(run.t_final) == pytest.approx(run.final, abs=1e-7)
    assert run(3.0).tolist() == run(np.array([3.0]))[:, 0].tolist()


@pytest.mark.parametrize("t", [-1e-9, 30.001, [1, 2, 31]])
def test_times_outside_the_run_are_refused(run, t):
    with pytest.raises(sf.SceneError, match="the run covers 0 to 30"):
        run(t)


def test_not_a_number_is_no_time(run):
    with pytest.raises(sf.SceneError, match="nan"):
        run(np.nan)


def test_reading_by_name(run):
    assert run["x"].tolist() == run.x[0].tolist()
    assert run["u"].tolist() == run.x[1].tolist()
    assert run["x_max"] == run.outputs["x_max"] >= run["x"].max()
    assert set(run.outputs) == set(WANTED)
    with pytest.raises(sf.SceneError, match=r"'x_mx' is neither an output nor a state; did you mean x_max\?"):
        run["x_mx"]
    with pytest.raises(sf.SceneError, match="known: end, path, rest, u, x, x_max"):
        run["qqq"]


def test_results_are_frozen(run):
    for name in ("final", "status", "t_final"):
        with pytest.raises(dataclasses.FrozenInstanceError):
            setattr(run, name, 0)
    with pytest.raises(dataclasses.FrozenInstanceError):
        run.events[0].t = 3.0


def test_repr_is_short_and_says_how_it_went(run):
    assert len(repr(run)) < 100
    assert repr(run) == f"Run(OK, {run.route}, t_final=30, {len(run.events)} events)"


def test_to_dict_is_json(run):
    data = json.loads(json.dumps(run.to_dict()))
    assert data["status"] == "OK"
    assert data["final"] == {"x": run.final[0], "u": run.final[1]}
    assert data["outputs"]["x_max"] == run["x_max"]
    assert data["stats"]["events"] == len(run.events)
    assert data["route"] == run.route


def test_to_xarray(run):
    data = run.to_xarray()
    assert set(data.data_vars) == {"x", "u", "mode_belt"}
    assert data.x.values.tolist() == run.x[0].tolist()
    assert data.mode_belt.values.tolist() == run.mode[0].tolist()
    assert data.t.values.tolist() == run.t.tolist()
    assert data.attrs["status"] == "OK"


def test_plot_returns_axes_with_a_line_for_each_coordinate(run):
    matplotlib = pytest.importorskip("matplotlib")
    matplotlib.use("Agg")
    import matplotlib.pyplot as plt

    _figure, ax = plt.subplots()
    assert run.plot(ax) is ax
    assert ax.lines[0].get_ydata().max() == pytest.approx(run["x_max"], abs=1e-3)


def test_checked_returns_itself_or_raises_with_advice(run):
    assert run.checked() is run
    broken = sf.simulate(BELT, 1e-8, sf.Taylor(max_events=2))
    with pytest.raises(sf.RunFailed, match=r"EVENT_BUDGET at t = [\d.]+: more events .* raise max_events"):
        broken.checked()


def test_every_status_but_ok_has_advice():
    assert ADVICE[sf.Status.OK] == ""
    assert all(len(ADVICE[s]) > 30 for s in sf.Status if s != sf.Status.OK)
    assert set(ADVICE) == set(sf.Status)


@pytest.mark.one_in(4)
@pytest.mark.parametrize("route", ROUTES)
def test_a_program_repeats_simulate(route):
    program = sf.prepare(belt(route), 1e-9, route)
    for values, initial in (({}, {}), ({"v_b": 0.3}, {}), ({"beta": 0.2, "gamma2": 1.5}, {"x": 0.1}), ({}, {"u": 0.4})):
        scene = belt(route).where(values) if values else belt(route)
        expected = sf.simulate(scene.starting(initial) if initial else scene, 1e-9, route)
        run = program.run(values, initial)
        assert run.final == pytest.approx(expected.final, abs=1e-9)
        assert run.values == values
        assert run.initial == initial
        assert run.scene.values == expected.scene.values
        assert run.scene.initial == expected.scene.initial


def test_taylor_programs_are_bit_for_bit_repeatable():
    program = sf.prepare(BELT, 1e-9)
    first = program.run()
    kept = first.x.copy()
    program.run({"v_b": 0.31}, {"x": 0.2})
    again = program.run()
    assert np.array_equal(first.x, kept)  # a later run does not write into an earlier one
    assert np.array_equal(again.x, kept)
    assert again.events == first.events
    assert np.array_equal(sf.simulate(BELT, 1e-9).x, kept)


def test_symbols_and_names_are_the_same_keys():
    program = sf.prepare(BELT, 1e-9)
    v_b = BELT.parameter("v_b")
    assert np.array_equal(program.run({v_b: 0.3}, {X: 0.1}).final, program.run({"v_b": 0.3}, {"x": 0.1}).final)


@pytest.mark.one_in(12)
@pytest.mark.parametrize("names", [["a", "Omega"], ["a"], ["Omega"], ["beta"], ["gamma2"]])
@pytest.mark.parametrize("route", ROUTES)
def test_parameters_that_were_zero_may_change(route, names):
    numbers = {"a": 0.01, "Omega": 7.0, "beta": 0.1, "gamma2": 0.8}
    scene = belt(route).until(8.0).where(dict.fromkeys(names, 0.0))
    program, changed = sf.prepare(scene, 1e-9, route), {n: numbers[n] for n in names}
    expected = sf.simulate(scene.where(changed), 1e-9, route)
    for _ in range(2):
        assert program.run(changed).final == pytest.approx(expected.final, abs=1e-8)
        assert program.run().final == pytest.approx(sf.simulate(scene, 1e-9, route).final, abs=1e-8)


def test_starts_that_depend_on_parameters_follow_them():
    scene = sf.scenes.coulomb_oscillator(0.03)
    program = sf.prepare(scene, 1e-11)
    run = program.run({"x0": 0.5})
    assert run.x[0, 0] == 0.5
    assert run.final[0] == pytest.approx(0.02, abs=1e-10)  # N = 8: (0.5 - 16 * .03)
    assert program.run({"x0": 0.5}, {"x": -0.7}).x[0, 0] == -0.7


@pytest.mark.one_in(3)
@pytest.mark.parametrize("route", ROUTES)
@pytest.mark.parametrize(
    ("values", "initial", "message"),
    [
        ({"vb": 0.3}, {}, r"vb is no parameter.*did you mean v_b\?"),
        ({"v_b": "0.3"}, {}, r"value of v_b is '0.3', not a number"),
        ({"v_b": float("nan")}, {}, "value of v_b is nan; it must be finite"),
        ({"v_b": None}, {}, "v_b"),
        ({}, {"y": 0.3}, "y .*no state"),
        ({}, {"x": float("inf")}, "initial value of x is inf"),
        ({3: 1.0}, {}, "3 is no name"),
        ({"x": 1.0}, {}, "x is no parameter"),
    ],
)
def test_bad_changes_of_a_run_are_refused_by_name(route, values, initial, message):
    program = sf.prepare(belt(route), 1e-6, route)
    with pytest.raises(sf.SceneError, match=message):
        program.run(values, initial)


def test_changes_are_checked_like_the_scene_itself():
    program = sf.prepare(sf.scenes.coulomb_oscillator(0.03), 1e-9)
    with pytest.raises(sf.SceneError, match="static coefficient"):
        program.run({"delta": 0.5})
    run = sf.prepare(BELT, 1e-9).run({"gamma2": -1.0})
    assert run.status == sf.Status.LOST_CONTACT  # or refused: but never a motion with a negative load


def test_routes_refuse_what_they_do_not_know():
    with pytest.raises(sf.SceneError, match=r"no route 'tailor'; did you mean taylor\?"):
        sf.prepare(BELT, route="tailor")
    with pytest.raises(sf.SceneError, match="not a scene; give a sf.Scene"):
        sf.simulate(BELT.system)
    with pytest.raises(sf.SceneError, match="no value for mu_s"):
        sf.simulate(sf.scenes.mass_on_belt(sf.laws.coulomb(sp.Symbol("mu_s")), v_b=0.2))


@pytest.mark.parametrize("route", ["taylor", "integrators"])
def test_programs_pickle_as_what_they_were_prepared_from(route):
    program = sf.prepare(BELT, 1e-9, route=route)
    again = pickle.loads(pickle.dumps(program))
    assert (type(again), again.tolerance, again.settings) == (type(program), 1e-9, program.settings)
    assert np.array_equal(again.run({"v_b": 0.3}).final, program.run({"v_b": 0.3}).final)


def test_runs_pickle(run):
    again = pickle.loads(pickle.dumps(run))
    assert np.array_equal(again.x, run.x)
    assert again.events == run.events
    assert np.array_equal(again(np.linspace(0, 30, 99)), run(np.linspace(0, 30, 99)))


def test_progress_is_reported_in_order():
    fractions = []
    scene = sf.scenes.mass_on_belt(v_b=0.2, horizon=2e6).wanting({"end": sf.End()})
    sf.simulate(scene, 1e-9, progress=fractions.append)
    assert fractions == sorted(fractions)
    assert fractions
    assert 0 < fractions[0] <= fractions[-1] <= 1


def test_explain_names_the_route_and_what_is_skipped():
    told = sf.explain(sf.scenes.mass_on_belt(v_b=0.2).wanting({"m": sf.Max(X)}))
    assert told.route == "taylor"
    assert set(told.answers) == set(ROUTES)
    assert told.answers["integrators"].startswith("slower here")
    assert "a, Omega" in " ".join(told.skipped) or "Omega, a" in " ".join(told.skipped)
    assert any("trajectory" in s for s in told.skipped)
    assert json.loads(json.dumps(told.to_dict()))["facts"]["contacts"] == 1
    excited = sf.explain(sf.scenes.mass_on_belt(v_b=0.2, a=0.01, Omega=3.0))
    assert not any("autonomous" in s or "trajectory" in s for s in excited.skipped)
    smooth = sf.explain(sf.scenes.mass_on_belt(sf.laws.coulomb(0.3), v_b=0.2).regularised(1e-3, "tanh"))
    assert any("no contact can stick" in s for s in smooth.skipped)
