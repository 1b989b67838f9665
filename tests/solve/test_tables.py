"""Tables as lookups: the same motion as with a switch for each break, at a cost that hardly grows with the table."""

import itertools
import time

import casadi as ca
import numpy as np
import pytest
import sympy as sp

import symfric as sf
from symfric.lower import printer
from symfric.lower.lookup import LEAST, looked_up
from symfric.model.tables import table_of

X, U, Y, W = sp.symbols("x u y w", real=True)
SMOOTH = sf.laws.cubic(0.4, 0.25, 0.5)


def broken(x, places, values):
    slopes = np.diff(values) / np.diff(places)
    lines = [v + k * (x - a) for a, v, k in zip(places[:-1], values[:-1], slopes, strict=True)]
    return sp.Piecewise(*((line, x < b) for line, b in zip(lines[:-1], places[1:-1], strict=True)), (lines[-1], True))


def steps(places, values):
    pieces = [(v, place > sf.TIME) for v, place in zip(values[:-1], places, strict=True)]
    return sp.Piecewise(*pieces, (values[-1], True))


def law_of(rng, n):
    speeds = np.concatenate([[0.0], np.sort(rng.uniform(0.01, 1.2, n))])
    values = 0.2 + 0.2 * np.exp(-speeds / 0.2) + 0.05 * rng.random(n + 1) * (speeds > 0)
    return sf.laws.piecewise_linear(1.1 * values[0], speeds.tolist(), values.tolist(), last_slope=0.0)


def one(force, law, profile=1, belt=0.2):
    contact = sf.Contact("belt", slip=U - belt, normal=1, law=law, profile=profile)
    return sf.Scene(sf.System([X], [U], [[1]], [force]), [contact], {}, {X: 0.0, U: 0.0}, 15.0)


def two(law):
    force = [-2 * X + Y, X - 3 * Y + sp.sin(1.3 * sf.TIME) / 2]
    contacts = [sf.Contact("a", slip=U - 0.2, normal=1, law=law), sf.Contact("b", slip=W - U, normal=0.5, law=law)]
    start = {X: 0.0, Y: 0.1, U: 0.0, W: 0.0}
    return sf.Scene(sf.System([X, Y], [U, W], [[1, 0], [0, 2]], force), contacts, {}, start, 15.0)


FAMILIES = {
    "law": lambda rng, n: one(-X - 0.05 * U, law_of(rng, n)),
    "law and cubic spring": lambda rng, n: one(-X - 0.3 * X**3, law_of(rng, n)),
    "profile": lambda rng, n: one(-X, SMOOTH, broken(X, np.linspace(-2, 2, n), 1 + 0.3 * rng.random(n))),
    "force over time": lambda rng, n: one(-X + broken(sf.TIME, np.linspace(0, 15, n), 0.4 * rng.random(n)), SMOOTH),
    "spring": lambda rng, n: one(broken(X, np.linspace(-2, 2, n), np.sort(-rng.random(n))[::-1]) - X, SMOOTH),
    "steps in time": lambda rng, n: one(
        -X + steps(np.sort(rng.uniform(0, 15, n)), 0.6 * rng.standard_normal(n + 1)), law_of(rng, n)
    ),
    "belt that steps": lambda rng, n: one(
        -X, law_of(rng, n), belt=steps(np.sort(rng.uniform(0, 15, 12)), rng.uniform(-1, 1, 13))
    ),
    "two masses": lambda rng, n: two(law_of(rng, n)),
}


def with_switches(monkeypatch, scene, route="taylor"):
    """Run a scene with a switch for each break."""
    with monkeypatch.context() as patch:
        patch.setattr(printer, "LEAST", 10**9)
        return sf.simulate(scene, route=route).checked()


@pytest.mark.one_in(16)
@pytest.mark.parametrize(("name", "n"), [*itertools.product(FAMILIES, (9, 33))])
def test_motion_is_that_of_a_switch_for_each_break(monkeypatch, name, n):
    scene = FAMILIES[name](np.random.default_rng(n), n)
    run, other = sf.simulate(scene, route="taylor").checked(), with_switches(monkeypatch, scene)
    assert [e.contact for e in run.events] == [e.contact for e in other.events]
    assert run.events
    assert np.allclose([e.t for e in run.events], [e.t for e in other.events], rtol=0, atol=1e-9)
    assert np.allclose(run.final, other.final, rtol=0, atol=1e-9)


@pytest.mark.one_in(2)
@pytest.mark.parametrize("n", [8, 33])
def test_route_exact_agrees(n):
    scene = FAMILIES["law"](np.random.default_rng(n), n)
    exact = sf.simulate(scene, route="exact")
    assert np.allclose(exact.final, sf.simulate(scene, 1e-12, route="taylor").final, rtol=0, atol=1e-11)


def test_cases_in_lanes_have_the_bits_of_single_runs():
    scene = FAMILIES["law and cubic spring"](np.random.default_rng(3), 20).wanting({"x_max": sf.Max(X)})
    program = sf.prepare(scene, route="taylor")
    starts = np.linspace(-0.4, 0.6, 9)
    batch = program.map(initial={"x": starts})
    assert [program.run(initial={"x": x})["x_max"] for x in starts] == batch.outputs["x_max"].tolist()


@pytest.mark.one_in(3)
@pytest.mark.parametrize("name", ["law", "profile", "spring"])
def test_derivatives_hold(name):
    scene = FAMILIES[name](np.random.default_rng(5), 20)
    c = sp.Symbol("c", positive=True)
    changed = sf.Scene(
        sf.System([X], [U], [[1]], [scene.system.force[0] - c * X]), scene.contacts, {c: 0.2}, scene.initial, 6.0
    )
    run = sf.simulate(changed, 1e-11, route="taylor", sensitivities=["c"])
    ends = [sf.simulate(changed.where({"c": 0.2 + h}), 1e-13, route="taylor").final for h in (-1e-5, 1e-5)]
    assert np.allclose(run.sensitivities["c"], (ends[1] - ends[0]) / 2e-5, rtol=1e-6, atol=1e-7)


def test_step_function_for_export_agrees():
    scene = FAMILIES["law"](np.random.default_rng(7), 16)
    made = sf.export.stepper(scene, 2e-3)
    assert made.error(until=3.0) < 1e-6


@pytest.mark.parametrize("n", [*range(1, 20), 50])
def test_segment_of_every_number_is_found(n):
    rng = np.random.default_rng(n)
    breaks = np.sort(rng.uniform(-1, 1, n))
    x, signs, quantities = ca.SX.sym("x"), [], []

    def switch(quantity, level):
        assert level == len(signs)
        signs.append(ca.SX.sym(f"s{level}"))
        quantities.append(quantity)
        return signs[-1]

    entries = [ca.SX(float(k)) for k in range(n + 1)]
    found = looked_up(x, breaks.tolist(), switch)(entries)
    sign = ca.vertcat(*signs)
    f = ca.Function("f", [x, sign], [found, sign * ca.vertcat(*quantities)])
    before = None
    for k, place in enumerate([breaks[0] - 1, *(breaks[:-1] + breaks[1:]) / 2, breaks[-1] + 1]):
        m = np.ones(len(signs))
        for j in range(m.size):  # a switch depends on those before it
            m[j] = 1.0 if np.array(f(place, m)[1]).ravel()[j] >= 0 else -1.0
        value, guards = f(place, m)
        assert float(value) == k
        assert np.all(np.array(guards) > 0)
        if before is not None:
            assert np.sum(m != before) == 1  # one switch changes at every break
            assert np.min(np.array(f(breaks[k - 1], m)[1])) == 0.0  # exactly there
        else:
            assert np.all(m == 1)
        before = m


@pytest.mark.parametrize(
    ("pieces", "breaks"),
    [
        ([(X, X < 1), (2 - X, X < 3), (0, True)], (1, 3)),
        ([(0, X > 3), (2 - X, X > 1), (X, True)], (1, 3)),
        ([(X, sp.Or(X < 1, X < 2)), (0, True)], (2,)),
        ([(X, X < 3), (2, X < 1), (0, True)], None),
        ([(X, X < Y), (0, True)], None),
        ([(X, X < 1), (Y, Y < 2), (0, True)], None),
        ([(X, sp.And(X < 1, Y < 2)), (0, True)], None),
        ([(X, X < 1), (0, X > 2), (1, True)], None),
    ],
)
def test_tables_are_recognised(pieces, breaks):
    table = table_of(sp.Piecewise(*pieces, evaluate=False))
    assert (table and table.breaks) == breaks


@pytest.mark.one_in(2)
@pytest.mark.parametrize("n", [50, 500])
def test_law_jumps_are_still_refused(n):
    values = sp.Piecewise(*((1 + 0.1 * k, sf.SPEED < k + 1) for k in range(n)), (2, True))
    with pytest.raises(sf.SceneError, match=r"jumps by .* at v = 1"):
        one(-X, sf.laws.custom(values, 1.0))


def test_few_switches_serve_large_tables():
    """The number of guards grows with the logarithm of the breaks; so does what is computed in every step."""
    x = ca.SX.sym("x")
    for n in (LEAST, 50, 500):
        asked = []
        looked_up(x, list(range(n)), lambda q, level, asked=asked: asked.append(q) or ca.SX.sym("s"))
        assert len(asked) == n.bit_length()


@pytest.mark.long(beside="test_few_switches_serve_large_tables")
def test_a_table_of_many_points_costs_no_more_for_each():
    """With a switch for each break the cost grew with their square."""
    rng, costs = np.random.default_rng(250), []
    for n in (3, 50, 250):  # the first one for what every process does once
        start = time.process_time()
        sf.simulate(FAMILIES["law and cubic spring"](rng, n), route="taylor").checked()
        costs.append(time.process_time() - start)
    assert costs[2] < 5 * costs[1]
