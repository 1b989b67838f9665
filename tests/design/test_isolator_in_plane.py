"""Isolators under pairs of motions: those of a line turned give the design of the line, and grids find nothing better."""

import math
from functools import cache

import numpy as np
import pytest

import symfric as sf
from symfric.design import isolator

BOUNDS = {"mu": (0.01, 0.12), "R": (0.5, 3.0)}


@cache
def pairs():
    return [
        tuple(sf.motions.synthetic(seed=k + j, pga=a, unit="g", duration=8) for j, a in ((0, 0.4), (20, 0.3)))
        for k in (0, 1)
    ]


@cache
def scene():
    return sf.scenes.friction_pendulum(R=2.0, mu=0.06, m=1.0, motions=pairs()[0], horizon=11.0)


def sizes(run):
    return run["peak_acceleration"], run["peak_displacement"], math.hypot(run["residual_x"], run["residual_y"])


@pytest.mark.parametrize(("free", "number"), [(["mu"], 1), pytest.param(["mu", "R"], 2, marks=pytest.mark.long)])
def test_limits_hold_and_no_point_of_a_grid_is_better(free, number):
    limits, given = {"displacement": 0.25, "residual": 0.05}, pairs()[:number]
    found = isolator(scene(), given, {name: BOUNDS[name] for name in free}, limits)
    assert found.check.agrees
    programs = [sf.prepare(sf.scenes.friction_pendulum(R=2, mu=0.06, m=1, motions=p, horizon=11.0)) for p in given]
    table = np.max([sizes(program.run(found.values)) for program in programs], axis=0)
    assert table[0] == pytest.approx(found.objective, rel=1e-6)
    assert np.all(table[1:] <= np.array([0.25, 0.05]) * (1 + 1e-6))
    rng = np.random.default_rng(3)
    for values in ({name: rng.uniform(*BOUNDS[name]) for name in free} for _ in range(25)):
        other = np.max([sizes(program.run(values)) for program in programs], axis=0)
        assert other[0] > found.objective * (1 - 1e-6) or other[1] > 0.25 or other[2] > 0.05


@pytest.mark.long(beside="test_limits_hold_and_no_point_of_a_grid_is_better")
def test_motions_along_a_turned_line_give_one_design():
    motion, angle = sf.motions.synthetic(seed=5, pga=0.4, unit="g", duration=8).signal(), 0.6
    pair = [sf.Signal(np.array(motion.samples) * f, motion.dt) for f in (math.cos(angle), math.sin(angle))]
    still = sf.Signal(np.zeros(len(motion.samples)), motion.dt)
    designs = []
    for motions in ((motion, still), tuple(pair)):
        building = sf.scenes.friction_pendulum(R=2.0, mu=0.06, m=1.0, motions=motions, horizon=11.0)
        designs.append(isolator(building, [motions], {"mu": (0.01, 0.12)}, {"displacement": 0.2}))
    assert designs[0].values["mu"] == pytest.approx(designs[1].values["mu"], rel=1e-5)
    assert designs[0].objective == pytest.approx(designs[1].objective, rel=1e-6)


@pytest.mark.parametrize("motions", [[None], [(1, 2, 3)], [(None, None)]])
def test_motions_that_are_no_pairs_are_named(motions):
    with pytest.raises(sf.SceneError, match=r"no pair|not a motion"):
        isolator(scene(), motions, BOUNDS)


@pytest.mark.one_in(2)
@pytest.mark.parametrize("mu", [0.09530612244897958, 0.12])
def test_a_start_just_before_a_sample(mu):
    """In these it comes some microseconds and less before."""
    program = sf.prepare(scene(), 1e-10)
    assert program.run({"mu": mu}).checked()["peak_displacement"] == pytest.approx(
        sf.prepare(scene(), 1e-12).run({"mu": mu}).checked()["peak_displacement"], rel=1e-8
    )
