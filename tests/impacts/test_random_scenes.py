"""Random scenes of contacts that open against a simulator that shares nothing with the package."""

import zlib
from functools import cache

import numpy as np
import pytest

import symfric as sf
from tests.impacts.impact_reference import NEAR, Simulator
from tests.impacts.impact_scenes import ENDLESS, MAKERS, seeds_of

MOST = 20_000  # events of the simulator
APART = 1e-6  # largest difference of the final states; many impacts magnify what the tolerances leave


def drawn(structure, seed):
    """Return random values and a start of a structure."""
    values, start = structure.draw(np.random.default_rng([zlib.crc32(structure.name.encode()), seed]))
    return {name: float(e) for name, e in values.items()}, [float(e) for e in start]


@cache
def prepared(make, tolerance=1e-11):
    structure = make()
    return structure, sf.prepare(structure.scene(*drawn(structure, 0)), tolerance=tolerance)


def compare(make, seed):
    """Compare the final states, and again with the finest tolerances of both where many impacts magnify errors.

    Impacts may follow each other within the gap up to which the simulator takes them together; last it takes none so.
    """
    for tolerance, near in ((1e-11, NEAR), (1e-14, NEAR), (1e-14, 1e-15)):
        structure, program = prepared(make, max(tolerance, 1e-13))
        values, start = drawn(structure, seed)
        names = [s.name for s in (*structure.bodies.q, *structure.bodies.u)]
        run = program.run(values=values, initial=dict(zip(names, start, strict=True))).checked()
        simulator = Simulator(structure.equations, structure.numbers(values), tolerance, MOST, near)
        motion = simulator.run(start, structure.horizon)
        assert not motion.reason
        if np.max(np.abs(run.final - motion.final) / (1 + np.abs(motion.final))) < APART:
            return
    raise AssertionError(f"seed {seed}: {run.final} and {motion.final}")


@pytest.mark.one_in(24)
@pytest.mark.parametrize("make", MAKERS, ids=lambda make: make.__name__)
def test_motions_agree(make):
    for seed in range(4):
        compare(make, seed)


@pytest.mark.long(beside="test_motions_agree")
@pytest.mark.parametrize("tolerance", [1e-8, 1e-9, 1e-10])
def test_feet_that_slide_and_stop_together_at_any_tolerance(tolerance):
    """One of them carries the friction, the slip of the other follows: neither is judged without the other."""
    make = next(make for make in MAKERS if make.__name__ == "block_on_shaken_floor")
    for seed in (62, 10, 118):
        finals = []
        for fineness in (tolerance, 1e-12):
            structure, program = prepared(make, fineness)
            values, start = drawn(structure, seed)
            names = [s.name for s in (*structure.bodies.q, *structure.bodies.u)]
            finals.append(program.run(values=values, initial=dict(zip(names, start, strict=True))).checked().final)
        assert finals[0] == pytest.approx(finals[1], abs=1e3 * tolerance)


@pytest.mark.long(beside="test_motions_agree")
@pytest.mark.parametrize("make", MAKERS, ids=lambda make: make.__name__)
def test_more_motions_agree(make):
    for seed in seeds_of(make, range(4, 130)):
        compare(make, seed)


@pytest.mark.long(beside="test_motions_agree")
@pytest.mark.parametrize(("name", "seed"), sorted(ENDLESS))
def test_bounces_that_never_end_use_up_the_budget(name, seed):
    structure, program = prepared(next(make for make in MAKERS if make.__name__ == name))
    values, start = drawn(structure, seed)
    names = [s.name for s in (*structure.bodies.q, *structure.bodies.u)]
    run = program.run(values=values, initial=dict(zip(names, start, strict=True)))
    assert run.status in (sf.Status.STEP_BUDGET, sf.Status.EVENT_BUDGET)
