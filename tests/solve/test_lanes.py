"""Cases in lanes of vectors end at the bits of single runs, whatever their neighbours and the width of the vectors."""

import numpy as np
import pytest
import sympy as sp
from longer import longer

import symfric as sf
from symfric.solve.lanes import model
from symfric.solve.lanes.cases import run_in_lanes
from symfric.solve.lanes.model import LaneModel, lane_width
from symfric.solve.loop.cases import run_cases
from symfric.solve.taylor import laned
from symfric_evidence.stress.random_scenes import Dice, structure

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
Y, V, Z = sp.symbols("y v z", real=True)
F = sp.Symbol("F", real=True)
HALVES = {**HALF, "other": sf.HalfRange(Y), "work": sf.Integral(X * V), "stop": sf.StopTime(), "end": sf.End()}
TIMES = np.linspace(0.37, 39.0, 24)


def two(contacts, outputs=HALVES, coupling=0.5, horizon=40.0, **more):
    force = [-X + coupling * (Y - X) - U / 20, -2 * Y + coupling * (X - Y) - V / 20]
    initial = {X: 1.0, Y: -0.4, U: 0.0, V: 0.1}
    return sf.Scene(
        sf.System([X, Y], [U, V], sp.diag(1, 2), force), contacts, {P: 0.2}, initial, horizon, outputs, **more
    )


def bristles():
    w = U - P
    rate = w - 30 * sp.Abs(w) * Z / (0.25 + 0.15 * sp.exp(-((w / 0.1) ** 2)))
    system = sf.System(q=[X], u=[U], mass=[[1]], force=[-X - U / 10 - 30 * Z - 2 * rate], z=[Z], z_rate=[rate])
    return sf.Scene(system, [], {P: 0.2}, {X: 0.0, U: 0.0, Z: 0.0}, 20.0, HALF)


def shaken(dt=0.5):
    """A mass on a floor that a record drives, one of 120 samples."""
    record = sf.Signal(np.random.default_rng(3).normal(size=120), dt)
    system = sf.System([X], [U], [[1]], [-X - X**3 / 5 - U / 30 + P * F])
    return sf.Scene(system, FLOOR, {P: 1.0}, {X: 0.5, U: 0.0}, 40.0, {**HALF, "at": sf.At(X, 31.7)}, {F: record})


def commanded(force=-X / 4, horizon=15.0, slip=U, **parts):
    """A mass on a floor with clocks."""
    outputs = {**HALF, "end": sf.End(), "work": sf.Integral(X * U), "at": sf.Samples(X, TIMES[TIMES < horizon])}
    floor = [sf.Contact("floor", slip, 1, sf.laws.stribeck(0.3, 0.2, 0.05))]
    initial = {X: 1.0, U: 0.0}
    return sf.Scene(sf.System([X], [U], [[1]], [force]), floor, {P: 0.2}, initial, horizon, outputs, **parts)


CONTROLLED = sf.Held("c", update=4 * (1 - X) - 2 * U, every=P, delay=P / 3, step=0.05)
LATE = sf.Held("late", update=3 * (1 - X) - 2 * U, every=0.25, offset=0.1, delay=P, waiting=3)
RELAY = sf.Held("relay", update=-sp.sign(X), when=X, delay=P, initial=-1, waiting=2)
FALLING, STEPS = sf.laws.stribeck(0.4, 0.3, 0.1), sf.laws.piecewise_linear(0.4, [0, 0.1, 0.3], [0.35, 0.2, 0.3])
DRY = sf.laws.coulomb(0.3, 0.2)
BELTS = [sf.Contact("a", U - P, 1, FALLING), sf.Contact("b", V - P, 2, FALLING)]
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
    "two belts": (two(BELTS), "p", (0.02, 0.5)),
    "two belts of which one is greased": (two([BELTS[0], sf.Contact("b", V - P, 1, sf.laws.coulomb(0.0))]), "p", (0.02, 0.5)),
    "a pad between two masses": (two([sf.Contact("a", U - V, 1, DRY), sf.Contact("b", V - P, 1, DRY)]), "p", (0.02, 0.5)),
    "two pads on one mass": (two([sf.Contact("a", U - P, 1, DRY), sf.Contact("b", U, P, DRY)]), "p", (0.1, 0.5)),
    "a load that comes and goes": (
        two([sf.Contact("a", U - P, sp.Max(0, 0.7 + sp.sin(sf.TIME)), DRY), BELTS[1]], coupling=0.2),
        "p",
        (0.02, 0.5),
    ),
    "a load that must not vanish": (two([sf.Contact("a", U - P, 1 + X / 2, DRY)]), "p", (0.02, 0.9)),
    "a law in straight lines": (sf.scenes.mass_on_belt(STEPS, v_b=0.2).wanting(ALL), "v_b", (0.02, 0.5)),
    "a regularised law": (BELT.wanting(HALF).regularised(1e-2), "v_b", (0.02, 0.45)),
    "regularised by an arctangent": (BELT.wanting(HALF).regularised(2e-2, "arctan"), "v_b", (0.02, 0.45)),
    "a spring with a kink": (scene(-X - sp.Abs(X) * P, FLOOR, HALF), "p", (0.1, 0.7)),
    "bristles": (bristles(), "p", (0.05, 0.5)),
    "a patched floor": (
        scene(-X - U / 50 + sp.cos(1.3 * sf.TIME), [sf.Contact("floor", U, 1, DRY, sp.Piecewise((P, X < 0), (1, True)))], HALF),
        "p",
        (0.4, 2.0),
    ),
    "samples": (BELT.wanting({**ALL, "x": sf.Samples(X, TIMES), "u": sf.At(U, 12.5)}), "v_b", (0.02, 0.45)),
    "a record": (shaken(), "p", (0.1, 2.0)),
    "pads behind springs": (
        two([sf.Contact("a", U - P, 1, sf.laws.coulomb(0.3), stiffness=9.0), sf.Contact("b", V, 1, DRY)]),
        "p",
        (0.1, 0.5),
    ),
    "a controller": (commanded(CONTROLLED.symbol, held=[CONTROLLED]), "p", (0.05, 0.6)),
    "a late controller": (commanded(LATE.symbol, held=[LATE]), "p", (0.05, 0.7)),
    "a relay": (commanded(RELAY.symbol, 40.0, held=[RELAY]), "p", (0.05, 0.6)),
    "kicks": (commanded(resets=[sf.Reset(every=1.3, set={U: U + P})]), "p", (0.1, 2.0)),
    "an escapement": (commanded(resets=[sf.Reset(guard=X, set={U: U - P})]), "p", (0.1, 2.0)),
    "pulses of force and belt": (
        commanded(
            sp.Piecewise((1, sp.Mod(sf.TIME, 5 * P) < 2 * P), (-1, True)) - X,
            slip=U - sp.Piecewise((0, sf.TIME < 10 * P), (sp.Rational(1, 5), True)),
        ),
        "p",
        (0.1, 2.0),
    ),
    "infinite": (scene(P * X**3, [], HALF), "p", (0.1, 2.0)),
    "load that vanishes": (scene(-P * X, [sf.Contact("floor", U, 1 + 0 * P, sf.laws.coulomb(0.0))], HALF), "p", (0.1, 2.0)),
}  # fmt: skip
SHORT = (
    "a controller",
    "a relay",
    "pulses of force and belt",
    "belt, all outputs",
    "law with a bend",
    "no contact",
    "two pads on one mass",
    "a load that comes and goes",
    "a law in straight lines",
    "a regularised law",
    "bristles",
    "pads behind springs",
    "samples",
    "a record",
)
LONG = tuple(name for name in SCENES if name not in SHORT)


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
    np.testing.assert_array_equal(a.seen, b.seen)


def some(arrays, chosen):
    from dataclasses import fields, replace

    rows = {f.name: getattr(arrays, f.name)[chosen] for f in fields(arrays) if f.name != "place"}
    return replace(arrays, **rows)


@pytest.mark.one_in(10)
@pytest.mark.filterwarnings("ignore:redundant contacts")
@pytest.mark.parametrize("name", longer(SCENES, LONG))
def test_a_case_in_a_lane_has_the_bits_of_the_event_loop(name):
    n = 97
    program, y, p = cases(name, n)
    lanes = program._lanes()
    single, batch = run_cases(program._model, y, p, 1, None), run_in_lanes(lanes, y, p, 1, None)
    same(batch, single)
    order = np.random.default_rng(1).permutation(n)[:80]
    same(run_in_lanes(lanes, y[order], p[order], 2, None), some(batch, order))
    for few in (0, 1, lane_width() + 1):
        same(run_in_lanes(lanes, y[n - few :], p[n - few :], 1, None), some(batch, slice(n - few, n)))


@pytest.mark.long(beside="test_a_case_in_a_lane_has_the_bits_of_the_event_loop")
@pytest.mark.parametrize("name", longer(("a controller", "kicks", "an escapement"), ("an escapement",)))
def test_derivatives_over_clocks_have_the_bits_of_single_runs(name, monkeypatch):
    monkeypatch.setattr(laned, "LEAST", 1)
    made, parameter, (low, high) = SCENES[name]
    program = sf.prepare(made.wanting({**HALF, "end": sf.End()}), 1e-9, sensitivities=[parameter])
    values = np.linspace(low, high, 20)
    batch = program.map({parameter: values})
    assert isinstance(program._lane_models[0], LaneModel)
    runs = [program.run({parameter: v}) for v in values]
    assert np.array_equal(batch.final.T, [r.final for r in runs])
    assert np.array_equal(batch.sensitivities[parameter].T, [r.sensitivities[parameter] for r in runs], equal_nan=True)


@pytest.mark.one_in(2)
@pytest.mark.filterwarnings("ignore")
@pytest.mark.parametrize("seed", longer((1, 57, 61, 66, 70), (57, 66, 70)))
def test_random_scenes_have_the_bits_of_the_event_loop(seed):
    n, drawn = 40, structure(seed)
    x, dice, rng = drawn.system.q[0], Dice(drawn), np.random.default_rng(seed)
    outputs = {"h": sf.HalfRange(x), "w": sf.Integral(x**2), "s": sf.Samples(x, [3.3, 15.0]), "stop": sf.StopTime()}
    program = sf.prepare(drawn.until(20.0).wanting(outputs), 10.0 ** -rng.integers(4, 12), sf.Taylor(max_steps=20_000))
    numbers = program._numbers
    y, p = (np.tile(start, (n, 1)) for start in numbers.start)
    for k in range(n):
        draw = dice.draw(seed, k)
        for name in draw.values.keys() & numbers._place.keys():
            p[k, numbers._place[name]] = draw.values[name]
        y[k] = [draw.initial[name] for name in numbers._states]
    same(run_in_lanes(program._lanes(), y, p, 1, None), run_cases(program._model, y, p, 1, None))


@pytest.mark.one_in(6)
@pytest.mark.parametrize("name", ["belt, all outputs", "two belts", "a regularised law", "bristles", "samples"])
def test_few_steps_are_left_to_the_event_loop(name, monkeypatch):
    program, y, p = cases(name, 60)
    lanes, taken = program._lanes(), []
    workspace = lanes.workspace()
    monkeypatch.setattr(lanes, "workspace", lambda: workspace)
    taking = workspace.taking
    monkeypatch.setattr(workspace, "taking", lambda given: taken.append(taking(given)) or taken[-1])
    batch = run_in_lanes(lanes, y, p, 1, None)
    changes = np.sum(batch.counted[:, 1:]) if not lanes.plan.selects_mode else 0
    assert taken[0].kernels.calls - changes < 0.15 * np.sum(batch.counted[:, 0])


@pytest.mark.long(beside="test_a_case_in_a_lane_has_the_bits_of_the_event_loop")
@pytest.mark.parametrize("width", [2, 4, 8, 16])
def test_the_width_of_the_vectors_does_not_change_a_bit(width):
    program, y, p = cases("belt, all outputs", 60)
    lanes = LaneModel(program._lanes().plan, program._model, width)
    same(run_in_lanes(lanes, y, p, 1, None), run_cases(program._model, y, p, 1, None))


@pytest.mark.one_in(2)
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
    monkeypatch.setattr(laned, "LEAST", 1)
    told = []
    many = program.map(values, threads=2, progress=told.append)
    assert isinstance(program._lane_models[0], LaneModel)
    for name in ("half", "end"):
        np.testing.assert_array_equal(many[name], few[name])
    alone = program.map(values, progress=told.append)
    assert told[-1] == 1.0
    np.testing.assert_array_equal(alone["half"], few["half"])


@pytest.mark.parametrize("made", [scene(-P * X, [], HALF), BELT.wanting(HALF)])
def test_scenes_that_are_left_to_the_event_loop(made, monkeypatch):
    monkeypatch.setattr(laned, "LEAST", 1)
    monkeypatch.setattr(model, "_LONGEST", 10)
    program = sf.prepare(made, route="taylor")
    assert program._lanes() is None
    name = made.parameters[0].name
    value = float(made.values[made.parameters[0]])
    assert program.map({name: [value, 1.1 * value]}).final[:, 0].tolist() == program.run().final.tolist()
