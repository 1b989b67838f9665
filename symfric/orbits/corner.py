"""Corners of a branch: orbits that touch a guard, beyond which it goes on with another sequence of events, or ends."""

from collections import Counter
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from symfric.errors import NotFound
from symfric.lower.lift import FAR, GAPS
from symfric.orbits.flow import Passage
from symfric.orbits.shooting import Point, System, solve
from symfric.orbits.special import Condition, at_the_edge, between, guard_size, has_others, lift_of, signature

_BEYOND = (1e-5, 1e-4, 1e-3, 1e-6)  # of the span: how far from a corner its other side is looked for
_CLOSE = 0.3  # of the ranges of the states, the period and the span: corners farther away are others


class Corner(NamedTuple):
    """An orbit that touches a guard, what holds there, and an orbit of the other side, if there is one."""

    condition: Condition
    point: Point
    beyond: Point | None = None


def corner_between(system: System, one: Point, other: Point) -> Corner:
    """Find the corner between two orbits of a branch with different events."""
    untouched, touched = _in_order(one, other)
    contact = _contact_that_differs(untouched.passage, touched.passage)
    kind = _kind(untouched.passage, touched.passage)
    for which in _turns_that_differ(untouched.passage, touched.passage, contact):
        condition = Condition(kind, turn=(contact, which))
        try:
            return Corner(condition, solve(condition.system(system, 1.0), untouched.z), other)
        except NotFound:
            continue
    guards = _guards(untouched.passage, contact, system)
    for k in guards:
        found = _touch(system, untouched, Condition(kind, k))
        if found is None:
            continue
        low, high = sorted((one.z[-1], other.z[-1]))
        margin = high - low + 1e-9 * abs(high)
        if low - margin <= found.z[-1] <= high + margin:
            return Corner(Condition(kind, k), found, other)
    first, _ = between(system, untouched, touched, signature)
    return Corner(Condition(kind), first, other)


def corner_ahead(system: System, point: Point, size: np.ndarray) -> Corner | None:
    """Find the corner at which a walk came to a halt, and an orbit beyond it if there is one.

    Parameters
    ----------
    system : System
    point : Point
        The last orbit.
    size : ndarray, shape (n_z,)
        Units of the unknowns, the span of the parameter last.
    """
    for contact in range(len(system.flow.contacts)):
        for near in (point, _without_sticking(system, point, contact)):
            if near is None:
                continue
            for k in _guards(near.passage, contact, system):
                found = _touch(system, near, Condition("grazing", k))
                if found is None or np.max(np.abs(found.z - point.z) / size) > _CLOSE:
                    continue
                beyond = _other_side(system, point, found, size)
                if beyond is not None:
                    untouched, touched = _in_order(point, beyond)
                    return Corner(Condition(_kind(untouched.passage, touched.passage), k), found, beyond)
    return _landing(system, point, size)


def _touch(system: System, untouched: Point, condition: Condition) -> Point | None:
    """Return the orbit that touches a guard near one that does not, None if it is not found.

    It is one that ignores the touch, so the contact must have no other events of this kind.
    """
    if has_others(untouched.passage, condition.guard):
        return None
    size = guard_size(untouched.passage, condition.guard, system.flow)
    try:
        found = solve(condition.system(system, size), untouched.z)
    except NotFound:
        return None
    return found if signature(found.passage) == signature(untouched.passage) else None


def _landing(system: System, point: Point, size: np.ndarray) -> Corner | None:
    """Return the orbit whose first event lies where its guard only just touches zero: beyond, it would be missed."""
    if not point.passage.events:
        return None
    _, contact, before, _ = point.passage.events[0]
    rows = (0,) if before else (1, 2)
    for k in (GAPS * contact + row for row in rows):
        condition = Condition("grazing", k, landing=True)
        try:
            found = solve(condition.system(system, guard_size(point.passage, k, system.flow)), point.z)
        except NotFound:
            continue
        if np.max(np.abs(found.z - point.z) / size) < _CLOSE:
            return Corner(condition, found._replace(z=found.z + at_the_edge(found)))
    return None


def _without_sticking(system: System, point: Point, contact: int) -> Point | None:
    """Return the orbit near one in which a contact sticks that ignores its zero slip."""
    if all(i != contact for _, i, _, _ in point.passage.events):
        return None
    k = GAPS * contact
    lift = lift_of(system.flow, k, guard_size(point.passage, k, system.flow))
    try:
        return solve(replace(system, lift=lift), point.z, _parameter_alone(point))
    except NotFound:
        return None


def _other_side(system: System, point: Point, corner: Point, size: np.ndarray) -> Point | None:
    """Return an orbit near a corner whose events are not those of the side from which it was reached."""
    normal, mark = _parameter_alone(point), signature(point.passage)
    for distance in _BEYOND:
        for way in (1, -1):
            try:
                found = solve(system, corner.z + way * distance * size[-1] * normal, normal)
            except NotFound:
                continue
            near = np.max(np.abs(found.z - corner.z) / size) < _CLOSE
            if near and signature(found.passage) != mark:
                return found
    return None


def _parameter_alone(point: Point) -> np.ndarray:
    return np.append(np.zeros(point.z.size - 1), 1.0)


def _in_order(one: Point, other: Point) -> tuple[Point, Point]:
    """Return the orbit with fewer events first: it does not touch."""
    return (one, other) if len(one.passage.events) <= len(other.passage.events) else (other, one)


def _contact_that_differs(untouched: Passage, touched: Passage) -> int:
    count = [Counter((i, a, b) for _, i, a, b in p.events) for p in (touched, untouched)]
    more = (count[0] - count[1]) or (count[1] - count[0])
    return min((i for i, _, _ in more), default=0)


def _turns_that_differ(untouched: Passage, touched: Passage, contact: int) -> list[int]:
    """Return which slips end by a reversal on one orbit and by a stick on the other."""
    ends = [[after for _, i, before, after in p.events if i == contact and before] for p in (untouched, touched)]
    if len(ends[0]) != len(ends[1]):
        return []
    return [k for k, (a, b) in enumerate(zip(*ends, strict=True)) if (a == 0) != (b == 0)]


def _kind(untouched: Passage, touched: Passage) -> str:
    sticks = [sum(b == 0 for _, _, _, b in p.events) for p in (untouched, touched)]
    return "stick-onset" if sticks[0] < sticks[1] else "grazing"


def _guards(passage: Passage, contact: int, system: System) -> list[int]:
    """Return the guards of a contact that turn somewhere on the orbit, the nearest to zero first."""
    rows = [k for k in range(GAPS * contact, GAPS * contact + GAPS) if abs(passage.gaps[k]) < FAR]
    return sorted(rows, key=lambda k: abs(passage.gaps[k]) / guard_size(passage, k, system.flow))
