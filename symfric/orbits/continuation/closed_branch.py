"""Orbits on a branch, and whether a branch has closed: whether one of them has been passed again."""

from typing import NamedTuple

import numpy as np

from symfric.errors import NotFound
from symfric.orbits.continuation.bifurcations import signature
from symfric.orbits.shooting import Point, ShootingSystem, solve

_RECENT = 3  # number of last orbits not compared with the new one
_SAME = 1e-7  # difference relative to the ranges of the states up to which two orbits count as one


class Placed(NamedTuple):
    """An orbit with its equations; beyond a jump it may take another number of excitation periods."""

    system: ShootingSystem
    point: Point


def marks_of(orbit: Placed) -> np.ndarray:
    """Return numbers that identify an orbit: extremes, parameter, and the period or, if forced, the start."""
    passage, z = orbit.point.passage, orbit.point.z
    n = passage.low.size
    return np.concatenate([passage.low, passage.high, z[n:] if orbit.system.free else z])


def passed_again(trail: list[Placed], every: np.ndarray, new: Placed) -> int | None:
    """Return the index of the orbit that a closed branch has passed again, None if it has not.

    A closed branch passes its start first. The marks of the orbits and, last, of the new one are the rows `every`.
    """
    size = np.ptp(every, axis=0)
    moves = size > _SAME * np.max(np.abs(every), axis=0)  # what stays the same along the branch differs by rounding
    every = np.where(moves, every / np.where(moves, size, 1.0), 0.0)
    marks, mark = every[:-1], every[-1]
    ways = np.diff(marks[: max(len(trail) - _RECENT, 0) + 1], axis=0)
    from_start = mark - marks[: len(ways)]
    lengths = np.linalg.norm(ways, axis=1)
    shares = np.sum(from_start * ways, axis=1) / np.maximum(lengths**2, 1e-300)
    off = np.linalg.norm(from_start - shares[:, None] * ways, axis=1)
    near = np.flatnonzero((shares >= 0) & (shares < 1) & (off < 0.1 * lengths))
    return next((int(k) for k in near if _is_same(trail[k + (shares[k] > 0.5)], new)), None)


def _is_same(old: Placed, new: Placed) -> bool:
    """Whether the orbit near an old one, at the parameter of a new one, equals the new one."""
    z, passage = new.point.z, new.point.passage
    try:
        there = solve(old.system, np.append(old.point.z[:-1], z[-1]), np.append(np.zeros(z.size - 1), 1.0), most=8)
    except NotFound:
        return False
    if signature(there.passage) != signature(old.point.passage):  # of another arm at a discontinuity
        return False
    apart = np.abs(marks_of(Placed(old.system, there)) - marks_of(new))
    size = np.tile(np.maximum(passage.ranges, there.passage.ranges), 2)
    return bool(np.all(apart[: size.size] <= _SAME * size))
