"""Continuation beyond a jump: the orbit to which the motion settles after a branch ends."""

import itertools
from dataclasses import replace

import numpy as np

from symfric.errors import NotFound, SceneError
from symfric.model.scene import Scene
from symfric.orbits.continuation.arclength import REST
from symfric.orbits.continuation.bifurcations import signature
from symfric.orbits.cycle import Orbit, found_cycle, read_guess, values_of
from symfric.orbits.shooting import Point, ShootingSystem, solve

_BEYOND = (1e-6, 1e-4)  # distances beyond the end, relative to the span
# other starts on the last orbit, in shares of its period: the motion may wander for long, and then the start decides
# to which cycle it settles, if to any
_LATER = (0.5,)


def settled_beyond(
    scene: Scene, system: ShootingSystem, end: Point, value: float, way: float, span: tuple[float, float]
) -> tuple[ShootingSystem, Point] | None:
    """Return the orbit to which the motion settles just beyond the last orbit of a branch; None if to none.

    Parameters
    ----------
    scene : Scene
    system : ShootingSystem
        With one parameter.
    end : Point
        The last orbit.
    value : float
        Of the parameter there.
    way : float
        Its sign is the direction in which the parameter goes on.
    span : (float, float)
    """
    (name,), unsettled = system.flow.parameters, None
    places = [value + np.copysign(distance, way) * (span[1] - span[0]) for distance in _BEYOND]
    inside = [there for there in places if span[0] < there < span[1]]
    for begin, there in itertools.product(_starts(system, end), inside):
        found = _settled(scene.where({name: there}), system, end, begin)
        if found is not None and found[1].stable:
            return found[0]
        unsettled = unsettled or found
    return unsettled[0] if unsettled else None


def _starts(system: ShootingSystem, end: Point) -> list[np.ndarray]:
    """Return the states from which the motion is followed; that of a forced scene starts at t = 0."""
    start, period, values = system.unpack(end.z)
    return [start, *(system.flow.run(start, values, share * period).end for share in _LATER if system.free)]


def _settled(
    scene: Scene, system: ShootingSystem, end: Point, begin: np.ndarray
) -> tuple[tuple[ShootingSystem, Point], Orbit] | None:
    """Return the orbit to which the motion settles from a state, unless it is the last one.

    Where it settles to none in time, the orbit may be an unstable one that it passes.
    """
    values = values_of(scene)
    try:
        states = dict(zip(system.flow.states, begin.tolist(), strict=True))
        orbit = found_cycle(scene.starting(states), system.flow)
        period = system.flow.period(values) if system.flow.period else None
        other = replace(system, multiple=read_guess(orbit, system.flow, period).multiple)
        z = other.pack(orbit.start, orbit.period, values)
        settled = solve(other, z, np.append(np.zeros(z.size - 1), 1.0))
    except (NotFound, SceneError):
        return None
    rests = np.all(settled.passage.ranges <= REST * end.passage.ranges)
    return None if rests or signature(settled.passage) == signature(end.passage) else ((other, settled), orbit)
