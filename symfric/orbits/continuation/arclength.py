"""Steps of Keller's pseudo-arclength continuation, with unknowns scaled to comparable size."""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from symfric.errors import NotFound
from symfric.orbits.shooting import Point, ShootingSystem, solve, step_of
from symfric.orbits.sizes import UNMOVED, kinds

CORRECTIONS = 8  # most of one step; a step that needs more is better halved
_SLOW = 1  # corrections that may leave more than half of the residual, as one across a corner of the map does
REST = 1e-6  # range of a motion, relative to those of an orbit, below which it counts as at rest
_FARTHEST = 3.0  # length of a step relative to that before it, up to which the bend of the curve is extrapolated
_SHARE = 0.02  # least unit of a state, relative to its largest range along the branch
_FAINT = 1e-3  # the same relative to the largest range of a state of its kind, for states that do not move as yet


def units(system: ShootingSystem, point: Point, limits: np.ndarray, largest: np.ndarray) -> np.ndarray:
    """Return the units of the unknowns: ranges of the states, the period, the spans of the parameters.

    Parameters
    ----------
    system : ShootingSystem
    point : Point
    limits : ndarray, shape (n_p, 2)
        Ends of the spans.
    largest : ndarray, shape (n_x,)
        Ranges of the states on the largest orbit so far.
    """
    own = np.maximum(point.passage.ranges, _SHARE * largest)
    for kind in kinds(len(system.flow.scene.system.q), own.size):
        own[kind] = np.maximum(own[kind], _FAINT * np.max(own[kind], initial=0.0))
    size = np.abs(point.z[: own.size])  # of states that stay the same on the orbit, as a friction at its limit
    own = np.where(own > UNMOVED * size, own, np.where(size > 0, size, 1.0))
    return np.concatenate([own, [system.period(point.z)] if system.free else [], limits[:, 1] - limits[:, 0]])


def tangent(system: ShootingSystem, point: Point, size: np.ndarray, along: np.ndarray) -> np.ndarray:
    """Return the direction of the curve, of unit length in the units `size`, on the side of `along`, (n_z,)."""
    normal = along / size**2
    way = step_of(system, point, np.zeros(point.rest.size), normal, float(np.linalg.norm(along / size)))
    return np.asarray(way / np.linalg.norm(way / size))


def cosine(one: np.ndarray, other: np.ndarray, size: np.ndarray) -> float:
    """Return the cosine of the angle between two directions in the units `size`."""
    a, b = one / size, other / size
    return float(a @ b / (np.linalg.norm(a) * np.linalg.norm(b)))


class Behind(NamedTuple):
    """A solution before the last one of a smooth piece: its unknowns and the direction of the curve there, (n_z,)."""

    z: np.ndarray
    way: np.ndarray


def bend_ahead(point: Point, way: np.ndarray, behind: Sequence[Behind], step: float, size: np.ndarray) -> np.ndarray:
    """Return how far the curve leaves its tangent `way` over a step, by the solutions `behind`, latest first, (n_z,).

    They and their directions are extrapolated by Hermite's polynomial of the arc length. The result is zero where the
    step is much longer than that between the solutions, or where the polynomial bends by more than half of it.
    """
    lengths, values, slopes = [0.0], [np.zeros(way.size)], [_unit(way, size)]
    for one in behind:
        value, slope = (one.z - point.z) / size, _unit(one.way, size)
        chord, turn = np.linalg.norm(value - values[-1]), np.linalg.norm(slope - slopes[-1])
        lengths.append(lengths[-1] - float(chord * (1.0 + turn**2 / 24.0)))  # of a circle's arc, to fourth order
        values.append(value)
        slopes.append(slope)
    if len(lengths) < 2 or not step <= -_FARTHEST * lengths[1]:
        return np.zeros(way.size)
    nodes, row = np.repeat(lengths, 2), np.repeat(values, 2, axis=0)
    product, away = step, np.zeros(way.size)
    for order in range(1, nodes.size):  # Newton's divided differences, with the tangents where two nodes are one
        apart = nodes[order:] - nodes[:-order]
        row = (row[1:] - row[:-1]) / np.where(apart, apart, 1.0)[:, None]
        if order == 1:
            row[::2] = slopes
        else:
            away = away + product * row[0]
        product *= step - nodes[order]
    return away * size if np.linalg.norm(away) <= 0.5 * step else np.zeros(way.size)


def _unit(way: np.ndarray, size: np.ndarray) -> np.ndarray:
    return np.asarray(way / size / np.linalg.norm(way / size))


def step_along(
    system: ShootingSystem,
    point: Point,
    way: np.ndarray,
    step: float,
    size: np.ndarray,
    limits: np.ndarray,
    behind: Sequence[Behind] = (),
) -> tuple[Point | None, bool]:
    """Return the next solution, or the one where a parameter reaches its limit, and whether it reached it.

    The solution is None if none was found nearby. It is sought in the plane at right angles to `way` at the distance
    `step`; the solutions `behind` only make the guess better.
    """
    along, guess, normal = step, point.z + step * way, way / size**2
    limit = _limit_passed(point.z, guess, limits)
    if limit:
        along *= limit.share
        guess, normal = _at(limit, point.z + along * way)
    better = guess
    if behind:
        away = bend_ahead(point, way, behind, along, size)
        better = guess + away - way * float(normal @ away) / float(normal @ way)
    try:
        new = solve(system, better, normal, CORRECTIONS, reference=guess, beside=point, slow=_SLOW)
        passed = None if limit else _limit_passed(point.z, new.z, limits)
        if passed:  # by what the corrections added to the step
            limit = passed
            guess, normal = _at(limit, point.z + limit.share * (new.z - point.z))
            new = solve(system, guess, normal, CORRECTIONS, reference=guess, beside=point, slow=_SLOW)
    except NotFound:
        return None, False
    # rest solves the equations too; and what lies farther off than the step may be another branch
    rests = np.all(new.passage.ranges <= REST * point.passage.ranges)
    if rests or np.linalg.norm((new.z - guess) / size) > max(step, 1e-9):
        return None, False
    return system.across_itself(new), limit is not None


class _Limit(NamedTuple):
    """A limit of a parameter that a step passes."""

    place: int  # of the parameter among the unknowns
    value: float
    share: float  # of the step, from 0 to 1, at which it is reached


def _limit_passed(here: np.ndarray, there: np.ndarray, limits: np.ndarray) -> _Limit | None:
    """Return the first limit of a parameter on the line from here to there, both (n_z,); None if it passes none."""
    passed = []
    for place, (low, high) in enumerate(limits, here.size - len(limits)):
        if not low < there[place] < high and there[place] != here[place]:
            value = high if there[place] >= high else low
            share = (value - here[place]) / (there[place] - here[place])
            passed.append(_Limit(place, value, max(0.0, share)))
    return min(passed, key=lambda limit: limit.share, default=None)


def _at(limit: _Limit, z: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return unknowns with a parameter at its limit, and the normal of the plane of these, (n_z,)."""
    z, normal = z.copy(), np.zeros(z.size)
    z[limit.place], normal[limit.place] = limit.value, 1.0
    return z, normal
