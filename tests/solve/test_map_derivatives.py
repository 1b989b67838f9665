"""Derivatives of many cases at once: the bits of single runs, whatever the neighbours, the order and the threads."""

from dataclasses import replace

import numpy as np
import pytest
import sympy as sp
from longer import longer

import symfric as sf
from symfric.model.rows import INTEGRAL
from symfric.solve.case_values import read_cases
from symfric.solve.lanes.cases import run_in_lanes
from symfric.solve.loop.cases import run_cases

X, U, Y, W, Z = sp.symbols("x u y w z", real=True)
P, Q, V = sp.symbols("p q v_b", positive=True)
CUBIC = sf.laws.cubic(0.4, 0.25, 0.5)
ROWS = ("y", "status", "counted", "doubts", "rest", "slopes", "seen", "total")  # of the arrays of cases
SIGNAL = sf.Signal(np.random.default_rng(3).standard_normal(40), 0.25)
FLOOR = [sf.Contact("floor", U, 1, sf.laws.coulomb(0.3, 0.2))]
BELT = sf.scenes.mass_on_belt(v_b=0.2, horizon=30.0)


def one(force, contacts=(), values=None, horizon=10.0, initial=None, **rest):
    initial = initial or {X: 0.5, U: 0.0}
    return sf.Scene(sf.System([X], [U], [[1]], [force]), contacts, values or {}, initial, horizon, **rest)


def two():
    """Two masses on one belt, coupled by a spring."""
    force = [-X - P * (X - Y) - U / 20, -Y - P * (Y - X)]
    contacts = [sf.Contact("left", U - V, 1, CUBIC), sf.Contact("right", W - V, 1, sf.laws.coulomb(0.3, 0.2))]
    initial = {X: 0.0, Y: 0.1, U: 0.0, W: 0.0}
    return sf.Scene(sf.System([X, Y], [U, W], sp.eye(2), force), contacts, {P: 0.5, V: 0.2}, initial, 15.0)


# scene, directions of differentiation, what varies and between which bounds
SCENES = {
    "belt": (BELT, ["v_b", "beta", "x"], {"v_b": (0.1, 0.45), "beta": (0.01, 0.1)}),
    "comes to rest": (one(-X, FLOOR, {P: 1.0, Q: 2.0}, initial={X: sp.sqrt(P) * Q, U: 0.0}), ["p", "q"], {"p": (0.5, 3.0)}),
    "two contacts": (two(), ["v_b", "p"], {"v_b": (0.05, 0.3), "p": (0.2, 1.0)}),
    "switch": (one(-X - U / 10 - 10 * sp.Max(0, X - P) + sp.cos(1.2 * sf.TIME), values={P: 0.5}), ["p"], {"p": (0.3, 0.9)}),
    "input": (one(-X - U / 20 + P * Q, FLOOR, {P: 1.0}, inputs={Q: SIGNAL}), ["p", "x"], {"p": (0.5, 2.0)}),
    "smooth law": (BELT.until(10.0).regularised(1e-2), ["v_b"], {"v_b": (0.1, 0.4)}),
}  # fmt: skip


def prepared(name):
    scene, directions, ranges = SCENES[name]
    x = scene.system.q[0]
    wanted = {"top": sf.Max(x), "size": sf.Max(sp.Abs(x)), "half": sf.HalfRange(x), "work": sf.Integral(x * x)}
    wanted |= {"s": sf.Samples(x, [0.0, 0.5, 7.0]), "end": sf.End(), "rest": sf.StopTime()}
    return sf.prepare(scene.wanting(wanted), 1e-9, sensitivities=directions), ranges


def drawn(ranges, n, seed=1):
    rng = np.random.default_rng(seed)
    return {name: rng.uniform(low, high, n) for name, (low, high) in ranges.items()}


def same(batch, k, other, j):
    """Compare the derivatives of a case with those of a case of another batch."""
    for name, row in batch.sensitivities.items():
        np.testing.assert_array_equal(row[..., k], other.sensitivities[name][..., j], err_msg=name)
    for output, rows in batch.output_sensitivities.items():
        for name, row in rows.items():
            found = other.output_sensitivities[output][name]
            np.testing.assert_array_equal(row[..., k], found[..., j], err_msg=f"{output} {name}")


def as_run(batch, k, run):
    """Compare a case with its single run."""
    assert batch.status[k] == run.status
    np.testing.assert_array_equal(batch.final[:, k], run.final)
    assert {n: row[k] for n, row in batch.stats.items()} == run.stats
    for name, row in batch.sensitivities.items():
        np.testing.assert_array_equal(row[:, k], run.sensitivities[name], err_msg=name)
    for output, rows in batch.output_sensitivities.items():
        for name, row in rows.items():
            np.testing.assert_array_equal(row[..., k], run.output_sensitivities[output][name], err_msg=output)


def same_arrays(a, b, kinds):
    for name in ROWS[:-1]:
        np.testing.assert_array_equal(getattr(a, name), getattr(b, name), err_msg=name)
    np.testing.assert_array_equal(a.total[..., :2], b.total[..., :2])
    areas = kinds == INTEGRAL  # of other rows these are places within the last step
    np.testing.assert_array_equal(a.total[:, areas, 2], b.total[:, areas, 2])


IN_LANES = [name for name in SCENES if name != "two contacts"]  # whose series are too long for lanes


@pytest.mark.one_in(4)
@pytest.mark.parametrize("name", longer(IN_LANES, ["smooth law"]))
def test_lanes_end_at_the_bits_of_the_event_loop(name):
    program, ranges = prepared(name)
    n, directions, kinds = 53, len(program.directions), program._model.first.wanted.kind
    y, p = program._starts_of(read_cases(drawn(ranges, n), {}))
    lanes = program._lanes()
    single = run_cases(program._model, y, p, 1, None, directions)
    same_arrays(run_in_lanes(lanes, y, p, 1, None, directions), single, kinds)
    order = np.random.default_rng(1).permutation(n)
    turned = run_in_lanes(lanes, y[order], p[order], 2, None, directions)
    same_arrays(turned, replace(single, **{n: getattr(single, n)[order] for n in ROWS}), kinds)


@pytest.mark.one_in(3)
@pytest.mark.parametrize("name", longer(SCENES, ["smooth law"]))
def test_a_case_has_the_derivatives_of_its_run_whatever_its_neighbours(name):
    program, ranges = prepared(name)
    n = 24
    values = drawn(ranges, n)
    batch = program.map(values)
    assert set(batch.status.tolist()) <= {sf.Status.OK, sf.Status.NO_DERIVATIVE}
    for k in (0, 7, n - 1):
        as_run(batch, k, program.run({v: float(row[k]) for v, row in values.items()}))
    order = np.random.default_rng(2).permutation(n)
    mixed = program.map({v: row[order] for v, row in values.items()}, threads=2)
    for j, k in enumerate(order):
        same(batch, k, mixed, j)
    alone = program.map({v: row[5] for v, row in values.items()})
    same(batch, 5, alone, 0)


def test_the_start_of_a_case_replaces_a_formula_and_its_derivative():
    program, ranges = prepared("comes to rest")
    values, starts = drawn(ranges, 6), {"x": np.linspace(0.6, 1.2, 6)}
    batch = program.map(values, starts)
    for k in range(6):
        as_run(batch, k, program.run({"p": float(values["p"][k])}, {"x": float(starts["x"][k])}))
    assert not batch.output_sensitivities["s"]["p"][0].any()  # at t = 0, which no parameter moves now


def test_a_built_in_value_that_changes_in_some_cases():
    program, _ = prepared("belt")
    zero = sf.prepare(program.scene.where({"beta": 0.0}), 1e-9, sensitivities=["v_b"])
    beta = np.array([0.0, 0.05, 0.0, 0.02])
    batch = zero.map({"beta": beta})
    for k in range(4):
        as_run(batch, k, zero.run({"beta": float(beta[k])}))


def test_a_case_that_fails_or_has_no_derivative_leaves_the_others_alone():
    floor = sf.Contact("floor", U, 1 - P * X, sf.laws.coulomb(0.3, 0.2))  # lifts off at x = 1 / p
    x0 = sp.Symbol("x0", real=True)
    scene = one(-X, [floor], {P: 0.1, x0: 1.0}, initial={X: sp.sqrt(x0), U: 1.5})
    wanted = {"top": sf.Max(X), "work": sf.Integral(X), "s": sf.Samples(X, [0.5, 8.0]), "rest": sf.StopTime()}
    program = sf.prepare(scene.wanting(wanted), sensitivities=["p", "x0"])
    p, start = np.array([0.1, 0.1, 0.9, 0.2]), np.array([1.0, -1.0, 1.0, 2.0])
    batch = program.map({"p": p, "x0": start}, threads=2)
    assert batch.status.tolist() == [sf.Status.OK, sf.Status.NOT_FINITE, sf.Status.LOST_CONTACT, sf.Status.OK]
    for rows in (batch.sensitivities, *(batch.output_sensitivities[n] for n in ("top", "work", "s"))):
        for row in rows.values():
            assert np.all(np.isfinite(row) == [True, False, False, True])
    assert np.all(np.isnan(batch.output_sensitivities["rest"]["p"]))  # no case comes to rest
    alone = program.map({"p": p[[0, 3]], "x0": start[[0, 3]]})
    same(batch, 0, alone, 0)
    same(batch, 3, alone, 1)

    graze = one(-X, FLOOR, {P: 0.0}, initial={X: 0.25 + P, U: 0.0})  # at rest within the bound of sticking, or just not
    program = sf.prepare(graze.wanting({"s": sf.Samples(X, [1.0])}), sensitivities=["p"])
    batch = program.map({"p": np.array([0.0, 0.05, 0.1])})
    assert batch.status.tolist() == [program.run({"p": v}).status for v in (0.0, 0.05, 0.1)]


def test_what_progress_raises_ends_all_and_lists_are_refused():
    program, ranges = prepared("belt")
    told = []
    program.map(drawn(ranges, 40), progress=told.append)
    assert told[-1] == 1.0
    assert told == sorted(told)
    with pytest.raises(sf.SceneError, match="keeps neither trajectories"):
        sf.prepare(BELT, sensitivities=["v_b"]).map({"v_b": [0.1]})
