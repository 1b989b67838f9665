"""Corners of a branch: orbits that touch a guard, beyond which the branch goes on with another sequence of events."""

from collections import Counter
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from symfric.errors import NotFound
from symfric.lower.lift import GAPS
from symfric.orbits.flow import Passage
from symfric.orbits.shooting import Point, System, solve
from symfric.orbits.special import between, gap_scale, lift_of, signature, touch

_BEYOND = (1e-5, 1e-4, 1e-3, 1e-6)  # of the span: how far from a corner its other side is looked for
_CLOSE = 0.3  # of the ranges of the states, the period and the span: corners farther away are others


class Corner(NamedTuple):
    """An orbit that touches a guard, "stick-onset" or "grazing"; an orbit of the other side, if it was looked for."""

    kind: str
    point: Point
    beyond: Point | None = None


def corner_between(system: System, one: Point, other: Point) -> Corner:
    """Find the corner between two orbits of a branch with different events."""
    untouched, touched = _in_order(one, other)
    contact = _contact_that_differs(untouched.passage, touched.passage)
    kind = _kind(untouched.passage, touched.passage)
    for k in _guards(untouched.passage, contact, system):
        try:
            found = touch(system, untouched, k)
        except NotFound:
            continue
        low, high = sorted((one.z[-1], other.z[-1]))
        margin = high - low + 1e-9 * abs(high)
        if low - margin <= found.z[-1] <= high + margin:
            return Corner(kind, found)
    mark = signature(untouched.passage)
    first, _ = between(system, untouched, touched, lambda passage: signature(passage) == mark)
    return Corner(kind, first)


def corner_ahead(system: System, point: Point, size: np.ndarray, span: float) -> Corner | None:
    """Find the corner at which a walk came to a halt, and an orbit beyond it; None if there is none near.

    Parameters
    ----------
    system : System
    point : Point
        The last orbit.
    size : ndarray, shape (n_z,)
        Units of the unknowns.
    span : float
        Of the parameter.
    """
    for contact in range(len(system.flow.contacts)):
        for sticks in (False, True):
            near = point
            if sticks:
                near = _without_sticking(system, point, contact)
                if near is None:
                    continue
            for k in _guards(near.passage, contact, system):
                try:
                    found = touch(system, near, k)
                except NotFound:
                    continue
                if np.max(np.abs(found.z - point.z) / size) > _CLOSE:
                    continue
                beyond = _other_side(system, point, found, size, span)
                if beyond is not None:
                    pair = _in_order(point, beyond)
                    return Corner(_kind(*(p.passage for p in pair)), found, beyond)
    return None


def _without_sticking(system: System, point: Point, contact: int) -> Point | None:
    """Return the orbit near one in which a contact sticks that ignores its zero slip."""
    if all(i != contact for _, i, _, _ in point.passage.events):
        return None
    k = GAPS * contact
    lift = lift_of(system.flow, k, gap_scale(point.passage, k, system.flow))
    normal = np.append(np.zeros(point.z.size - 1), 1.0)
    try:
        return solve(replace(system, lift=lift), point.z, normal)
    except NotFound:
        return None


def _other_side(system: System, point: Point, corner: Point, size: np.ndarray, span: float) -> Point | None:
    """Return an orbit near a corner whose events are not those of the side from which it was reached."""
    normal, mark = np.append(np.zeros(point.z.size - 1), 1.0), signature(point.passage)
    for distance in _BEYOND:
        for way in (1, -1):
            guess = corner.z + way * distance * span * normal
            try:
                found = solve(system, guess, normal)
            except NotFound:
                continue
            near = np.max(np.abs(found.z - corner.z) / size) < _CLOSE
            if near and signature(found.passage) != mark:
                return found
    return None


def _in_order(one: Point, other: Point) -> tuple[Point, Point]:
    """Return the orbit with fewer events first: it does not touch."""
    return (one, other) if len(one.passage.events) <= len(other.passage.events) else (other, one)


def _contact_that_differs(untouched: Passage, touched: Passage) -> int:
    count = [Counter((i, a, b) for _, i, a, b in p.events) for p in (touched, untouched)]
    more = (count[0] - count[1]) or (count[1] - count[0])
    return min((i for i, _, _ in more), default=0)


def _kind(untouched: Passage, touched: Passage) -> str:
    sticks = [sum(b == 0 for _, _, _, b in p.events) for p in (untouched, touched)]
    return "stick-onset" if sticks[0] < sticks[1] else "grazing"


def _guards(passage: Passage, contact: int, system: System) -> list[int]:
    """Return the guards of a contact that turn somewhere on the orbit, the nearest to zero first."""
    rows = [k for k in range(GAPS * contact, GAPS * contact + GAPS) if abs(passage.gaps[k]) < 1e29]
    return sorted(rows, key=lambda k: abs(passage.gaps[k]) / gap_scale(passage, k, system.flow))
