"""Floquet multipliers of random sampled systems against differences of the map over a period."""

import numpy as np
import pytest
import sympy as sp

import symfric as sf

x, u = sp.symbols("x u", real=True)
STEP = 1e-5


def drawn(seed):
    """Return a driven mass under two sampled controllers of different rates, with delays, friction and perhaps kicks."""
    rng = np.random.default_rng(seed)
    base = float(rng.choice([0.1, 0.15, 0.25]))
    slow = base * int(rng.integers(1, 4))
    period = 12 * base * int(rng.integers(1, 3))
    late = [float(d) for d in rng.uniform(0, 1, 2) * rng.choice([0.0, 0.9, 2.4], 2) * (base, slow)]
    offsets = [float(d) for d in rng.uniform(0, 0.9, 2) * rng.integers(0, 2, 2) * (base, slow)]
    own, other = (sp.Symbol(n, real=True) for n in ("fast.previous", "slow"))
    fast = sf.Held("fast", -float(rng.uniform(0.5, 3)) * u - own / 4 + other / 2, base, offsets[0], late[0])
    turn = float(rng.uniform(0.5, 2)) * (sp.Max(-1, sp.Min(1, -x)) if rng.random() < 0.5 else -x)
    held = [fast, sf.Held("slow", turn, slow, offsets[1], late[1])]
    wave = float(rng.uniform(0.5, 2)) * sp.sin(2 * sp.pi * sf.TIME / period)
    if rng.random() < 0.4:
        wave = wave + float(rng.uniform(0.2, 1)) * sp.sign(sp.sin(2 * sp.pi * sf.TIME / period))
    belt = u - float(rng.choice([0.0, 0.1]))
    law = [sf.laws.coulomb(0.2), sf.laws.coulomb(0.3, 0.2), sf.laws.stribeck(0.4, 0.25, 0.1)][rng.integers(3)]
    kicks = [sf.Reset(every=period, offset=period / 3, set={u: u / 2 + 0.3})] if rng.random() < 0.3 else []
    system = sf.System([x], [u], [[1]], [-x - u / 10 + fast.symbol + other + wave])
    rail = sf.Contact("rail", belt, 1, law)
    return sf.Scene(system, [rail], {}, {x: 0.1, u: 0.0}, 30 * period, held=held, resets=kicks)


@pytest.mark.one_in(90)
@pytest.mark.parametrize("seed", range(90))
def test_multipliers_are_those_of_the_map(seed):
    scene = drawn(seed)
    try:
        orbit = sf.limit_cycle(scene)
    except sf.NotFound:
        pytest.skip("it settles to no cycle")
    if not orbit.differentiable:
        pytest.skip("an event lies at a corner")
    base = dict(zip(orbit.names, orbit.start.tolist(), strict=True))
    program = sf.prepare(scene.until(orbit.period).wanting({"end": sf.End()}), 1e-13)
    end = lambda n, h: program.run({}, {**base, n: base[n] + h}).checked().final  # noqa: E731
    assert np.max(np.abs(program.run({}, base).final - orbit.start)) < 1e-8
    columns = [
        (4 * (end(n, STEP) - end(n, -STEP)) - (end(n, 2 * STEP) - end(n, -2 * STEP)) / 2) / (6 * STEP) for n in base
    ]
    expected = np.linalg.eigvals(np.array(columns).T)
    for power in (1, 2, 3):  # sums of powers: eigenvalues near a multiple one are sensitive, these are not
        found = np.sum(orbit.multipliers.astype(complex) ** power)
        assert found == pytest.approx(np.sum(expected.astype(complex) ** power), abs=2e-6)
