"""Cases in lanes of vectors end at the bits of single runs, whatever their neighbours and the width of the vectors."""

import numpy as np
import pytest
import sympy as sp
from longer import longer

import symfric as sf
from symfric.solve.lanes import step
from symfric.solve.lanes.cases import run_in_lanes
from symfric.solve.lanes.model import LaneModel, lane_width
from symfric.solve.loop import event_loop, step_acceptance, step_size
from symfric.solve.loop.cases import run_cases
from symfric.solve.taylor import route

X, U = sp.symbols("x u", real=True)
P = sp.Symbol("p", positive=True)
BELT = sf.scenes.mass_on_belt(v_b=0.2)
HALF = {"half": sf.HalfRange(X)}
ALL = {
    **HALF,
    "work": sf.Integral(X * U),
    "size": sf.Max(sp.Abs(X)),
    "stop": sf.StopTime(),
    "least": sf.Min(sf.friction_force("belt")),
    "end": sf.End(),
}


def scene(force, contacts, outputs, horizon=40.0):
    return sf.Scene(sf.System([X], [U], [[1]], [force]), contacts, {P: 1.0}, {X: 1.0, U: 0.0}, horizon, outputs)


FLOOR = [sf.Contact("floor", U, 1, sf.laws.coulomb(0.3, 0.2))]
SCENES = {
    "belt": (BELT.wanting(HALF), "v_b", (0.02, 0.45)),
    "belt, all outputs": (BELT.wanting(ALL), "v_b", (0.02, 0.45)),
    "dry belt": (sf.scenes.mass_on_belt(sf.laws.coulomb(0.4, 0.3), v_b=0.2).wanting(HALF), "v_b", (0.02, 0.45)),
    "law with a bend": (sf.scenes.mass_on_belt(sf.laws.stribeck(0.4, 0.3, 0.1, 0.01), v_b=0.2).wanting(HALF), "v_b", (0.02, 0.6)),
    "exponential law": (sf.scenes.mass_on_belt(sf.laws.exponential(0.4), v_b=0.2).wanting(HALF), "v_b", (0.02, 1.8)),
    "infinite slope": (sf.scenes.mass_on_belt(sf.laws.square_root(0.3, 0.1, 0.4), v_b=0.2, horizon=20.0).wanting(HALF), "v_b", (0.02, 0.5)),
    "shaken belt": (sf.scenes.mass_on_belt(v_b=0.2, a=0.01, Omega=20.0, horizon=10.0).wanting(HALF), "Omega", (9, 30)),
    "driven over a floor": (
        scene(-X - U / 50 - X**3 / 5 + P * sp.cos(1.3 * sf.TIME), FLOOR, {**HALF, "f": sf.Max(sf.friction_force("floor"))}),
        "p",
        (0.1, 2.0),
    ),
    "coming to rest": (scene(-P * X - X**3, FLOOR, {**HALF, "stop": sf.StopTime()}), "p", (0.5, 2.0)),
    "no contact": (scene(-X + P * (1 - X**2) * U, [], {**HALF, "work": sf.Integral(U * U)}), "p", (0.1, 2.0)),
    "infinite": (scene(P * X**3, [], HALF), "p", (0.1, 2.0)),
    "load that vanishes": (scene(-P * X, [sf.Contact("floor", U, 1 + 0 * P, sf.laws.coulomb(0.0))], HALF), "p", (0.1, 2.0)),
}  # fmt: skip
LONG = ("dry belt", "shaken belt", "load that vanishes", "exponential law", "infinite slope")


def cases(name, n, tolerance=1e-9):
    made, parameter, (low, high) = SCENES[name]
    program = sf.prepare(made, tolerance, route="taylor")
    start, p = program._numbers.start
    rows = np.tile(p, (n, 1))
    rows[:, program._numbers._place[parameter]] = np.random.default_rng(7).uniform(low, high, n)
    return program, np.tile(start, (n, 1)), rows


def same(a, b):
    for field in ("status", "counted", "y", "rest"):
        np.testing.assert_array_equal(getattr(a, field), getattr(b, field), err_msg=field)
    np.testing.assert_array_equal(a.total[..., :3], b.total[..., :3])


def some(arrays, chosen):
    from dataclasses import fields, replace

    rows = {f.name: getattr(arrays, f.name)[chosen] for f in fields(arrays) if f.name != "place"}
    return replace(arrays, **rows)


@pytest.mark.parametrize("name", longer(SCENES, LONG))
def test_a_case_in_a_lane_has_the_bits_of_the_event_loop(name):
    program, y, p = cases(name, 211)
    lanes = program._lanes()
    single, batch = run_cases(program._model, y, p, 1, None), run_in_lanes(lanes, y, p, 1, None)
    same(batch, single)
    order = np.random.default_rng(1).permutation(211)[:190]
    for threads in (1, 2):
        same(run_in_lanes(lanes, y[order], p[order], threads, None), some(batch, order))
    for n in (1, 2, lane_width() + 1):
        same(run_in_lanes(lanes, y[-n:], p[-n:], 1, None), some(batch, slice(211 - n, 211)))
    assert run_in_lanes(lanes, y[:0], p[:0], 1, None).status.size == 0


@pytest.mark.parametrize("width", [2, 4, 8, 16])
def test_the_width_of_the_vectors_does_not_change_a_bit(width):
    program, y, p = cases("belt, all outputs", 60)
    lanes = LaneModel(program._lanes().plan, program._model, width)
    same(run_in_lanes(lanes, y, p, 1, None), run_cases(program._model, y, p, 1, None))


@pytest.mark.parametrize("tolerance", longer((1e-3, 1e-6, 1e-12), (1e-6,)))
def test_grazes_are_found_in_lanes_too(tolerance):
    program = sf.prepare(BELT.wanting(HALF), tolerance)
    n = 400
    y, p = np.tile(program._numbers.start[0], (n, 1)), np.tile(program._numbers.start[1], (n, 1))
    p[:, program._numbers._place["v_b"]] = np.linspace(0.366, 0.397, n)  # many of these cycles only touch
    batch = run_in_lanes(program._lanes(), y, p, 1, None)
    same(batch, run_cases(program._model, y, p, 1, None))
    if tolerance < 1e-5:
        fine = sf.prepare(BELT.wanting(HALF), 1e-13).map({"v_b": p[:, program._numbers._place["v_b"]]})
        assert np.mean(fine.stats["events"] == batch.counted[:, 1]) > 0.99


def test_lanes_follow_the_rules_of_the_event_loop():
    assert (step.SLACK, step.NOTHING) == (step_acceptance._SLACK, step_acceptance._NOTHING)
    assert (step.STRETCH, step.TINY, step.ONE, step.CUT) == (
        event_loop._STRETCH,
        step_size._TINY,
        step_size._ONE,
        step_size._CUT,
    )
    assert (step.INFINITE, step.MOST, step.PART) == (step_size._INFINITE, step_size._MOST, step_size._PART)


def test_budgets_end_a_case_in_a_lane():
    for settings in (sf.Taylor(max_steps=50), sf.Taylor(max_events=9)):
        program = sf.prepare(BELT.wanting(HALF), route=settings)
        n = 20
        y, p = np.tile(program._numbers.start[0], (n, 1)), np.tile(program._numbers.start[1], (n, 1))
        p[:, program._numbers._place["v_b"]] = np.linspace(0.05, 0.45, n)
        batch = run_in_lanes(program._lanes(), y, p, 1, None)
        same(batch, run_cases(program._model, y, p, 1, None))
        assert np.any(batch.status != sf.Status.OK)


def test_map_takes_lanes_for_many_cases(monkeypatch):
    program = sf.prepare(BELT.until(20.0).wanting({**HALF, "end": sf.End()}))
    values = {"v_b": np.linspace(0.05, 0.45, 100)}
    few = program.map(values)
    assert not program._lane_models
    monkeypatch.setattr(route, "LEAST", 1)
    told = []
    many = program.map(values, threads=2, progress=told.append)
    assert isinstance(program._lane_models[0], LaneModel)
    for name in ("half", "end"):
        np.testing.assert_array_equal(many[name], few[name])
    alone = program.map(values, progress=told.append)
    assert told[-1] == 1.0
    np.testing.assert_array_equal(alone["half"], few["half"])


@pytest.mark.parametrize(
    "made",
    [
        BELT.wanting({"s": sf.Samples(X, [1.0])}),
        BELT.wanting(HALF).regularised(1e-2),
        scene(-X - sp.Abs(X) * P, FLOOR, HALF),
    ],
)
def test_scenes_that_are_left_to_the_event_loop(made, monkeypatch):
    monkeypatch.setattr(route, "LEAST", 1)
    program = sf.prepare(made, route="taylor")
    assert program._lanes() is None
    name = made.parameters[0].name
    value = float(made.values[made.parameters[0]])
    assert program.map({name: [value, 1.1 * value]}).final[:, 0].tolist() == program.run().final.tolist()
