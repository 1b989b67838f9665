"""Grazing-sliding: a contact that has other events of the same kind on the orbit just touches a guard.

The guard cannot be relaxed without removing the other events. The orbit that touches it is approached from the side
that does not; from there one branch of orbits leaves on either side of the touch. Both may lie on the same side of the
parameter, which then turns back. To leading order the map over a period is linear on either side, with other slopes:
M. di Bernardo et al., Piecewise-smooth Dynamical Systems (Springer 2008), section 8.2.
"""

from dataclasses import replace

import numpy as np

from symfric.errors import NotFound
from symfric.lower.mode_layout import gaps
from symfric.lower.relaxed_guards import FAR
from symfric.orbits.continuation.bifurcations import EDGE, Condition, guard_size, has_others, signature
from symfric.orbits.continuation.discontinuity import DiscontinuityPoint, kind_of, touch
from symfric.orbits.shooting import Point, ShootingSystem, null_of, solve

_AHEAD = (1e-6, 1e-5, 1e-4, 1e-3, 1e-2)  # lengths ahead of an orbit that touches, in step units, at which it may not
_INSIDE = 10.0  # how deep the motion whose slopes are taken touches, in units of `EDGE`
_LENGTHS = (1e-4, 1e-3, 1e-5, 1e-2)  # distances of the first orbit beyond, in step units
_NEAR = 0.1  # least value of a guard, relative to its size, of one that may be touched
_CLOSE = 0.05  # largest distance of the touch from the last orbit, in step units


def grazing_ahead(
    system: ShootingSystem, point: Point, way: np.ndarray, size: np.ndarray, span: tuple[float, float]
) -> DiscontinuityPoint | None:
    """Find the touch of a guard at which a walk stopped, and the branch of orbits on the other side of it.

    Parameters
    ----------
    system : ShootingSystem
    point : Point
        The last orbit.
    way : ndarray, shape (n_z,)
        Direction of the walk.
    size : ndarray, shape (n_z,)
        Units of the unknowns.
    span : (float, float)
    """
    mark = signature(point.passage)
    change = _touched(system, point, point, size, span)
    if change is not None:
        return change
    for length in _AHEAD:
        try:
            ahead = system.at(point.z + length * way, point.phase, point.z[: len(system.flow.states)])
        except NotFound:
            continue
        if signature(ahead.passage) != mark:
            change = _touched(system, ahead, point, size, span)
            if change is not None:
                return change
    return None


def _touched(
    system: ShootingSystem, untouched: Point, last: Point, size: np.ndarray, span: tuple[float, float]
) -> DiscontinuityPoint | None:
    """Return the touch near a motion that does not touch, with an orbit whose events are not those of the last one."""
    passage, values = untouched.passage, system.unpack(untouched.z)[2]
    for contact in range(len(system.flow.lines)):
        if system.flow.peaked(contact, values):
            continue
        for k in (k for k in gaps(contact) if abs(passage.gaps[k]) < FAR):
            if abs(passage.gaps[k]) > _NEAR * guard_size(system, untouched.z, passage, k):
                continue
            change = touch(system, untouched, Condition("grazing", k, side=1))
            if change is None or not span[0] <= change.value <= span[1]:
                continue
            if np.max(np.abs(change.edge - last.z) / size) > _CLOSE:
                continue
            beyond = _beyond(system, change, size, touches=untouched is last)
            if beyond is not None and signature(beyond.passage) != signature(last.passage):
                pair = (change.point.passage, (beyond if untouched is last else last).passage)
                kind = "grazing" if has_others(system.flow, change.point.passage, k) else kind_of(*pair)
                return change._replace(condition=replace(change.condition, kind=kind), beyond=beyond)
    return None


def _beyond(system: ShootingSystem, change: DiscontinuityPoint, size: np.ndarray, touches: bool) -> Point | None:
    """Return an orbit of the branch that leaves a touch, on the side whose orbits touch or on the other one."""
    at, n = change.point, len(system.flow.states)
    row, z = at.slopes[-1], at.z
    if touches:
        lower = size**2 * row / (row @ (size**2 * row))
        z = change.edge - _INSIDE * EDGE * lower
    try:
        near = system.at(z, at.phase, at.z[:n])
    except NotFound:
        return None
    if (signature(near.passage) != signature(at.passage)) != touches:
        return None
    way = null_of(system, near)
    way = way * np.copysign(1.0, (row @ way) * (-1.0 if touches else 1.0)) / np.linalg.norm(way / size)
    for length in _LENGTHS:
        try:
            there = solve(system, change.edge + length * way, way / size**2, most=12)
        except NotFound:
            continue
        if signature(there.passage) == signature(near.passage) and (there.z - change.edge) @ (way / size**2) > 0:
            return there
    return None
