"""Random scenes with steps in time against chains of runs: several contacts of all kinds, many instants."""

import numpy as np
import pytest
import sympy as sp

import symfric as sf

x, y, u, w = sp.symbols("x y u w", real=True)
MU = sf.laws.coulomb(0.4, 0.3)
LAWS = {
    "coulomb": MU,
    "dahl": sf.laws.dahl(0.4, 40.0),
    "lugre": sf.laws.lugre(0.4, 0.3, 0.1, 50.0, 0.5, 0.02),
    "bouc-wen": sf.laws.bouc_wen(20.0, 20.0, 20.0, 1.0),
    "maxwell": sf.laws.maxwell_slip([10.0, 20.0], [0.1, 0.2]),
    "spring": sf.laws.coulomb(0.3),
    "regularised": MU.regularised(0.05),
    "parallel": MU,
    "dependent": MU,
}


def contacts(kind, belt, load):
    stiffness = 15 if kind == "spring" else None
    first = sf.Contact("a", slip=u - belt, normal=1 if stiffness else load, law=LAWS[kind], stiffness=stiffness)
    if kind == "parallel":
        return [first, sf.Contact("b", slip=2 * u - 2 * belt, normal=0.5, law=MU)]
    second = sf.Contact("b", slip=w, normal=0.5, law=MU)
    third = [sf.Contact("c", slip=u - w - belt / 2, normal=0.4, law=MU)] if kind == "dependent" else []
    return [first, second, *third]


def scene(kind, numbers, horizon, start):
    belt, load, force = numbers
    pull = -x + 0.8 * (y - x) - 0.05 * u + force
    system = sf.System([x, y], [u, w], [[1, 0], [0, 2]], [pull, -0.8 * (y - x) - 0.03 * w])
    return sf.Scene(system, contacts(kind, belt, load), {}, start, horizon, {"end": sf.End()})


@pytest.mark.one_in(72)
@pytest.mark.parametrize("kind", LAWS)
@pytest.mark.parametrize("seed", range(8))
def test_random_steps_are_restarts(kind, seed):
    rng = np.random.default_rng([seed, list(LAWS).index(kind)])
    times, horizon = np.sort(rng.uniform(0.3, 9.0, 4)), 10.0
    if seed % 3 == 0:
        times[2] = times[1] * (1 + 2e-16)
    rows = np.round([rng.uniform(-0.5, 0.5, 5), rng.uniform(0.2, 2.0, 5), rng.uniform(-1.0, 1.0, 5)], 3)
    rows[0, rng.integers(5)] = 0.0
    pieces = [[(float(v), sf.TIME < float(t)) for v, t in zip(row, times, strict=False)] for row in rows]
    stepped = [sp.Piecewise(*p, (float(row[-1]), True)) for p, row in zip(pieces, rows, strict=True)]
    start = {"x": 0.1, "y": 0.0, "u": 0.0, "w": 0.0}
    run = sf.simulate(scene(kind, stepped, horizon, start), 1e-12, "taylor").checked()
    state, now = start, 0.0
    for part, time in zip(rows.T, [*times, horizon], strict=True):
        if time - now > 1e-14:
            piece = sf.simulate(scene(kind, [sp.Float(v) for v in part], time - now, state), 1e-12, "taylor").checked()
            state, now = dict(zip(piece.names, piece.final.tolist(), strict=True)), time
    assert np.max(np.abs(run.final - list(state.values()))) < 1e-10


@pytest.mark.long(beside="test_random_steps_are_restarts")
def test_pulses_with_a_share_as_parameter():
    d = sp.Symbol("d", positive=True)
    pulse = sp.Piecewise((1, sp.Mod(sf.TIME, 1) < d), (0, True))
    system = sf.System([x], [u], [[1]], [-x - u / 5 + pulse])
    guide = sf.Contact("guide", slip=u, normal=1, law=sf.laws.coulomb(0.2, 0.15))
    given = sf.Scene(system, [guide], {d: 0.7}, {x: 0.0, u: 0.0}, 20.0, {"end": sf.End()})
    program, h = sf.prepare(given, 1e-13), 1e-5
    difference = (program.run({"d": 0.7 + h}).final - program.run({"d": 0.7 - h}).final) / (2 * h)
    run = sf.simulate(given, 1e-12, sensitivities=("d",))
    assert np.max(np.abs(run.sensitivities["d"] - difference)) < 1e-7
    always, never = (program.run({"d": share}).checked().final for share in (1.0, 0.0))
    assert np.array_equal(program.run({"d": 1.5}).final, always)
    assert np.max(np.abs(never)) < 1e-15
