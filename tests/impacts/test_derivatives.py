"""Derivatives through impacts, friction and contacts that open, against differences of tight runs."""

import numpy as np
import pytest

import symfric as sf
from tests.impacts.impact_scenes import MAKERS
from tests.impacts.test_random_scenes import drawn

STEPS = (1e-6, 1e-7)
CLOSE = 2e-6  # error of the differences
FAMILIES = [
    "ball_on_slope", "ball_on_shaken_floor", "sticky_block_on_shaken_floor", "disk_in_corner", "rod_above_floor",
    "oscillator_between_stops", "dry_oscillator_with_stop", "pendulum_with_wall", "cam_follower",
]  # fmt: skip
DEFAULT = ["ball_on_shaken_floor", "rod_above_floor", "pendulum_with_wall"]


def happened(run):
    """Return the events, those of bounces that die out as their end alone: how many are told depends on the last digits."""
    found = []
    for event in run.events:
        while event.kind == "close" and found and found[-1] == (event.contact, "impact"):
            found.pop()
        found.append((event.contact, event.kind))
    return found


def compare(make, seeds):
    """Compare all derivatives of random scenes whose events stay the same nearby; return how many."""
    structure, compared = make(), 0
    values, start = drawn(structure, 0)
    n = structure.equations.n
    names = [s.name for s in (*structure.bodies.q, *structure.bodies.u)]
    keys = [*values, *names[n:]]
    scene = structure.scene(values, start)
    with_derivatives = sf.prepare(scene, tolerance=1e-12, sensitivities=keys)
    few = sf.Taylor(max_steps=100_000)  # a contact that starts at rest with restitution 1 bounces for ever nearby
    plain = sf.prepare(scene, tolerance=1e-13, route=few)
    for seed in seeds:
        values, start = drawn(structure, seed)
        initial = dict(zip(names, start, strict=True))
        run = with_derivatives.run(values=values, initial=initial)
        if run.status == sf.Status.NO_DERIVATIVE:
            continue  # simultaneous events
        kinds = happened(run.checked())
        for key in keys:
            if key in values and values[key] in (0.0, 1.0):
                continue  # no friction and full restitution: the other side is another motion, or none
            off = []
            for step in STEPS:
                sides = [nearby(plain, values, initial, key, d) for d in (step, -step)]
                if all(side is not None and side.status == sf.Status.OK and happened(side) == kinds for side in sides):
                    found = (sides[0].final - sides[1].final) / (2 * step)
                    off.append(np.max(np.abs(found - run.sensitivities[key])) / (1 + np.max(np.abs(found))))
            assert min(off, default=0.0) < CLOSE, (seed, key)
            compared += bool(off)
    return compared


def nearby(program, values, initial, key, change):
    """Return the run with one value changed, None where the scene does not allow it."""
    try:
        if key in values:
            return program.run(values=values | {key: values[key] + change}, initial=initial)
        return program.run(values=values, initial=initial | {key: initial[key] + change})
    except sf.SceneError:
        return None  # a restitution beyond its end


@pytest.mark.one_in(3)
@pytest.mark.parametrize("make", [m for m in MAKERS if m.__name__ in DEFAULT], ids=lambda make: make.__name__)
def test_derivatives_are_those_of_tight_runs(make):
    assert compare(make, range(4)) > 3


@pytest.mark.long(beside="test_derivatives_are_those_of_tight_runs")
@pytest.mark.parametrize("make", [m for m in MAKERS if m.__name__ in FAMILIES], ids=lambda make: make.__name__)
def test_more_derivatives_are_those_of_tight_runs(make):
    assert compare(make, range(4, 40)) > 40


@pytest.mark.long(beside="test_derivatives_are_those_of_tight_runs")
def test_many_derivatives_at_once_have_room():
    """What an impact tells about itself is shorter than the derivatives of its time; it was overwritten."""
    structure = next(m for m in MAKERS if m.__name__ == "ball_on_shaken_floor")()
    values, start = drawn(structure, 0)
    scene = structure.scene(values, start)
    few = sf.simulate(scene, tolerance=1e-12, sensitivities=["e"]).checked()
    many = sf.prepare(scene, tolerance=1e-12, sensitivities=[*values, "x", "y", "th", "u", "v", "om"])
    for _ in range(20):
        run = many.run().checked()
    assert run.sensitivities["e"] == pytest.approx(few.sensitivities["e"], rel=1e-8, abs=1e-9)
