"""Continuation beyond a jump: the orbit to which the motion settles after a branch ends."""

from dataclasses import replace

import numpy as np

from symfric.errors import NotFound, SceneError
from symfric.model.scene import Scene
from symfric.orbits.continuation.arclength import REST
from symfric.orbits.continuation.bifurcations import signature
from symfric.orbits.cycle import limit_cycle, read_guess
from symfric.orbits.shooting import Point, ShootingSystem, solve

_BEYOND = (1e-6, 1e-4)  # distances beyond the end, relative to the span


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
    (name,), normal = system.flow.parameters, np.append(np.zeros(end.z.size - 1), 1.0)
    states = dict(zip(system.flow.states, end.z.tolist(), strict=False))
    for distance in _BEYOND:
        there = value + np.copysign(distance, way) * (span[1] - span[0])
        if not span[0] < there < span[1]:
            continue
        try:
            orbit = limit_cycle(scene.where({name: there}).starting(states), tolerance=system.flow.tolerance)
            period = None if system.free else system.flow.period
            forcing = period({**system.values, name: there}) if period else None
            other = replace(system, multiple=read_guess(orbit, system.flow, forcing).multiple)
            settled = solve(other, other.pack(orbit.start, orbit.period, {**system.values, name: there}), normal)
        except (NotFound, SceneError):
            continue
        rests = np.all(settled.passage.ranges <= REST * end.passage.ranges)
        if not rests and signature(settled.passage) != signature(end.passage):
            return other, settled
    return None
