"""Values at many times: an output of several numbers on every route, with derivatives, in sweeps and functions."""

import casadi as ca
import numpy as np
import pytest
import sympy as sp

import symfric as sf
from symfric.scenefile import read_scene_text as read

X, U = sp.symbols("x u", real=True)
TIMES = np.sort(np.random.default_rng(3).uniform(0, 12, 200))


def belt(**outputs):
    scene = sf.scenes.mass_on_belt(v_b=0.2, horizon=12.0)
    x, u = (*scene.system.q, *scene.system.u)
    return scene.wanting({"x": sf.Samples(x, TIMES), "path": sf.Trajectory(), "late": sf.At(u, 11.0)})


def test_they_are_those_of_the_dense_motion():
    run = sf.simulate(belt(), 1e-12)
    assert run["x"] == pytest.approx(run(TIMES)[0], abs=1e-13)
    assert run["late"] == pytest.approx(run(np.array([11.0]))[1, 0], abs=1e-13)
    again = sf.simulate(belt(), 1e-8, route="integrators")
    assert again["x"] == pytest.approx(run["x"], abs=1e-6)


@pytest.mark.parametrize("route", ["exact", "taylor", "integrators"])
def test_the_ends_and_an_event_are_among_the_times(route):
    scene = sf.scenes.coulomb_oscillator(0.1, x0=1.0, horizon=5.0)
    (x,) = scene.system.q
    beside = 5.0 * (1 + 4e-16)  # of a sum of steps
    run = sf.simulate(
        scene.wanting({"x": sf.Samples(x, [0.0, np.pi, beside]), "end": sf.At(x, beside)}),
        1e-9 if route == "integrators" else 1e-12,
        route,
    )
    assert run["x"][:2] == pytest.approx([1.0, -0.8], abs=1e-7 if route == "integrators" else 1e-12)
    assert run["x"][2] == run["end"] == pytest.approx(run.final[0], abs=1e-7)


@pytest.mark.parametrize("late", [sf.At(X, 50.0), sf.Samples(X, [1.0, 50.0]), sf.At(X, 10.0001)], ids=str)
def test_a_time_after_the_horizon_is_refused_wherever_it_enters(late):
    plain = sf.Scene(sf.System([X], [U], [[1]], [-X]), [], {}, {X: 1.0, U: 0.0}, 10.0)
    told = rf"output 'late' takes a value at t = {late.latest:g}, and the run ends at the horizon 10"
    with pytest.raises(sf.SceneError, match=told):
        sf.Scene(plain.system, [], {}, plain.initial, 10.0, {"late": late})
    with pytest.raises(sf.SceneError, match=told):
        plain.wanting({"late": late})
    longer = plain.until(60.0, {"late": late})
    with pytest.raises(sf.SceneError, match=told):
        longer.until(10.0)
    assert longer.until(10.0, {"end": sf.End()}).horizon == 10.0
    assert np.all(np.isfinite(sf.simulate(longer)["late"]))


def test_a_file_with_a_time_after_its_horizon_is_refused():
    text = '[scene]\nmodel = "mass_on_belt"\nhorizon = 10\n[values]\nv_b = 0.2\n[outputs]\nlate = "at(x, 50)"\n'
    with pytest.raises(sf.SceneError, match=r"late.* t = 50.* horizon 10"):
        read(text)


@pytest.mark.parametrize("route", ["taylor", "integrators"])
def test_times_that_a_failed_run_does_not_reach_are_nan(route):
    blows = sf.Scene(sf.System([X], [U], [[1]], [X**3]), [], {}, {X: 3.0, U: 0.0}, 10.0)
    run = sf.simulate(
        blows.wanting({"x": sf.Samples(X, [0.1, 5.0]), "at": sf.At(X, 5.0), "end": sf.At(X)}), route=route
    )
    assert run.status != sf.Status.OK
    assert np.isfinite(run["x"][0])
    assert np.isnan([run["x"][1], run["at"], run["end"]]).all()


def test_a_record_shorter_than_the_scene_ends_where_it_ends():
    """The residual at the end of a record is left out of a run that ends before it."""
    motion = sf.motions.sine_burst(1.0, 2.0, cycles=5, dt=0.01)
    kept = {"C": 0.05, "m": 1.0, "motion": motion, "profile": 0.02}
    assert "residual_end_of_record" in sf.scenes.rolling_isolator(**kept).outputs
    assert "residual_end_of_record" not in sf.scenes.rolling_isolator(**kept, horizon=2.0).outputs


def test_under_a_record():
    motion = sf.motions.sine_burst(1.0, 2.0, cycles=5, dt=0.01)
    scene = sf.scenes.rolling_isolator(C=0.05, m=1.0, motion=motion, profile=0.02, horizon=2.0)
    (u,) = scene.system.q
    times = np.sort(np.random.default_rng(1).uniform(0, 2, 150))
    wanted = scene.wanting({"u": sf.Samples(u, times), "largest": sf.Max(sp.Abs(u))})
    exact, series = (sf.simulate(wanted, 1e-11, route) for route in ("exact", "taylor"))
    assert exact["u"] == pytest.approx(series["u"], abs=1e-11)
    assert exact["largest"] == pytest.approx(series["largest"], abs=1e-11)
    program = sf.prepare(wanted, 1e-11, "exact")
    assert np.array_equal(program.run({"C": 0.2})["u"], sf.simulate(wanted.where({"C": 0.2}), 1e-11, "exact")["u"])
    assert np.array_equal(program.run()["u"], exact["u"])


def test_derivatives_are_those_of_neighbouring_motions():
    scene, step = belt(), 1e-5
    program = sf.prepare(scene, 1e-13, sensitivities=["v_b", "x"])
    run = program.run()
    found = run.output_sensitivities["x"]
    assert found["v_b"].shape == TIMES.shape
    sides = [program.run({"v_b": 0.2 + way * step})["x"] for way in (1, -1)]
    differences = (sides[0] - sides[1]) / (2 * step)
    assert np.median(np.abs(found["v_b"] - differences)) < 1e-7
    assert np.mean(np.abs(found["v_b"] - differences) < 1e-5) > 0.97  # a sample between two events is no difference
    assert run.output_sensitivities["late"]["v_b"] == pytest.approx(
        (program.run({"v_b": 0.2 + step})["late"] - program.run({"v_b": 0.2 - step})["late"]) / (2 * step), abs=1e-5
    )


def test_second_derivatives_of_a_smooth_motion():
    x, u, k = *sp.symbols("x u", real=True), sp.Symbol("k", positive=True)
    system = sf.System(q=[x], u=[u], mass=[[1]], force=[-k * x])
    scene = sf.Scene(system, [], {k: 4.0}, {x: 1.0, u: 0.0}, 2.0, {"x": sf.Samples(x, [0.5, 1.0, 2.0])})
    run = sf.prepare(scene, 1e-13, sensitivities=["k"], order=2).run()
    t = sp.Symbol("t", positive=True)
    motion = sp.cos(sp.sqrt(k) * t)
    for order, given in ((1, run.output_sensitivities["x"]["k"]), (2, run.second_output_sensitivities["x"]["k", "k"])):
        exact = [float(motion.diff(k, order).subs({k: 4, t: time})) for time in (0.5, 1.0, 2.0)]
        assert given == pytest.approx(exact, abs=1e-12)


def test_in_a_sweep_and_as_a_function():
    scene = belt().wanting({"x": belt().outputs["x"], "late": belt().outputs["late"]})
    grid = sf.sweep(scene, {"v_b": [0.2, 0.3]})
    assert grid["x"].dims == ("v_b", "time_of_x")
    assert np.array_equal(grid["time_of_x"].values, TIMES)
    assert np.array_equal(grid["x"].values[0], sf.simulate(scene)["x"])
    function = sf.as_function(scene, ["v_b"], ["x", "late"])
    v = ca.MX.sym("v")
    x, _ = function(v)
    slopes = ca.Function("f", [v], [x, ca.jacobian(x, v)])
    value, slope = (np.array(e).ravel() for e in slopes(0.3))
    run = sf.simulate(scene.where({"v_b": 0.3}), 1e-12, sensitivities=["v_b"])
    assert value == pytest.approx(run["x"], abs=1e-13)
    assert slope == pytest.approx(run.output_sensitivities["x"]["v_b"], abs=1e-12)


FILE = """
[scene]
coordinates = "x"
velocities = "u"
mass = 1
force = "-x"
horizon = 3
initial = {{x = 1, u = 0}}
[outputs]
wanted = "{}"
"""


def test_in_a_scene_file():
    scene = read(FILE.format("samples(max(x, 0), 0.5, 1)")).scene
    assert sf.simulate(scene)["wanted"] == pytest.approx(np.cos([0.5, 1.0]), abs=1e-9)
    assert sf.simulate(read(FILE.format("at(x, 2)")).scene)["wanted"] == pytest.approx(np.cos(2), abs=1e-9)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("samples(x)", "empty"),
        ("samples(x, 2, 1)", "increase"),
        ("samples(x, -1)", "not be negative"),
        ("samples(x, soon)", "numbers after commas"),
        ("at(x, 1, 2)", "takes one time"),
        ("max(x, 1)", "takes one expression"),
        ("integral(x, 1)", "takes one expression"),
    ],
)
def test_bad_words_in_a_scene_file(text, message):
    with pytest.raises(sf.SceneError, match=message):
        read(FILE.format(text))


@pytest.mark.parametrize(
    ("times", "message"),
    [
        ([], "empty"),
        ([1.0, 1.0], "increase"),
        ([-1.0], "negative"),
        ([np.nan], "finite"),
        ("soon", "sequence of numbers"),
    ],
)
def test_bad_times(times, message):
    with pytest.raises(sf.SceneError, match=message):
        sf.Samples(X, times)
