"""Discontinuity-induced bifurcations: grazing points at which the events along a branch change, or the branch ends."""

from collections import Counter
from dataclasses import replace
from typing import NamedTuple, TypeGuard

import numpy as np

from symfric.errors import NotFound
from symfric.lower.mode_layout import OPEN, contact_of_gap, gaps, is_slip_gap, slip_gap
from symfric.lower.relaxed_guards import FAR
from symfric.orbits.continuation.bifurcations import (
    Condition,
    at_the_edge,
    between,
    guard_size,
    has_others,
    holding_at,
    ignoring,
    signature,
    slip_ends,
)
from symfric.orbits.passages import Passage
from symfric.orbits.shooting import Point, ShootingSystem, solve

_BISECTIONS = 20  # halvings of the last distance
# distances from the point, relative to the span, at which an orbit on its other side is sought
_BEYOND = (1e-5, 1e-4, 1e-3, 1e-6)
_STRAYS = 10.0  # trials that far from where a point may lie, relative to it, end its search
_SLOW = 4  # steps of a search that may leave more than half of the residual
_CLOSE = 0.3  # largest distance of a point on this step, relative to the ranges, the period and the span
_HALT = 1e-3  # the same where a walk stopped just before the end of a branch
_GRAZES = 0.01  # depth of a grazing event relative to the guard's size (or its square root) that counts as near zero
_BEHIND = 1e-5  # distance behind the walk, in step units, at which rounding may place a point ahead of it
_REACH = 3.0  # largest distance of a point from the ends of its step, in step lengths


class DiscontinuityPoint(NamedTuple):
    """A discontinuity-induced bifurcation: the orbit, its condition, and an orbit on the other side if there is one.

    Attributes
    ----------
    condition : Condition
    system : ShootingSystem
        Of the branch.
    point : Point
        At the grazing, or at the distance from it that the condition keeps.
    beyond : Point or None
    jump : bool
        Whether the orbits of the other side are distant: with static friction above kinetic friction, sticking lasts a
        finite time from its onset.
    """

    condition: Condition
    system: ShootingSystem
    point: Point
    beyond: Point | None = None
    jump: bool = False

    @property
    def located(self) -> bool:
        """Whether it solves the equations of a condition, and was not only enclosed between orbits."""
        return self.condition.guard >= 0 or self.condition.turn is not None or self.condition.event >= 0

    @property
    def edge(self) -> np.ndarray:
        """The unknowns at the grazing, (n_z,)."""
        return np.asarray(self.point.z + at_the_edge(self.system, self.point, self.condition))

    @property
    def value(self) -> float:
        """Value of the parameter at the grazing."""
        return float(self.edge[-1])


def discontinuity_between(
    system: ShootingSystem, one: Point, other: Point, size: np.ndarray, span: tuple[float, float]
) -> DiscontinuityPoint:
    """Locate the change of events between two orbits of a branch, in units `size` of the unknowns."""
    untouched, touched = _in_order(one, other)
    contact = _contact_that_differs(untouched.passage, touched.passage)
    kind = kind_of(untouched.passage, touched.passage)
    reach = float(_REACH * np.linalg.norm((other.z - one.z) / size))
    farthest = _STRAYS * reach * size

    def lies_there(change: DiscontinuityPoint | None) -> TypeGuard[DiscontinuityPoint]:
        """Whether the point lies on this step."""
        if change is None or not span[0] <= change.value <= span[1]:
            return False
        return bool(max(np.linalg.norm((change.point.z - z) / size) for z in (one.z, other.z)) <= reach)

    for which in _turns_that_differ(untouched.passage, touched.passage, contact):
        for near in (untouched, touched):
            change = _turned(system, near, contact, which, kind, farthest)
            if lies_there(change):
                return change._replace(beyond=other)
    peaked = system.flow.peaked(contact, system.unpack(one.z)[2])
    for k in _guards(untouched, contact, system):
        again = has_others(system.flow, untouched.passage, k)
        condition = Condition("grazing" if again else kind, k, side=int(peaked or again))
        change = touch(system, untouched, condition, farthest)
        if lies_there(change):
            return change._replace(beyond=other)
    first, _ = between(system, one, other, signature)
    return DiscontinuityPoint(Condition(kind), system, first, other)


def discontinuity_ahead(
    system: ShootingSystem, point: Point, way: np.ndarray, size: np.ndarray, span: tuple[float, float]
) -> DiscontinuityPoint | None:
    """Locate the discontinuity at which a walk stopped, and an orbit beyond it if there is one nearby.

    Parameters
    ----------
    system : ShootingSystem
    point : Point
        The last orbit.
    way : ndarray, shape (n_z,)
        Direction of the walk.
    size : ndarray, shape (n_z,)
        Units of the unknowns, the span of the parameter last.
    span : (float, float)
    """

    def near(change: DiscontinuityPoint, most: float) -> bool:
        """Whether a point is ahead of the walk and close."""
        away = (change.edge - point.z) / size
        return bool(np.max(np.abs(away)) < most and away @ (way / size) > -_BEHIND)

    ends = []
    for contact in sorted({*range(len(system.flow.lines)), *system.flow.openings}):
        for change in _edges(system, point, contact, _STRAYS * _HALT * size):
            if not near(change, _HALT):
                continue
            beyond = None if change.jump else _other_side(system, point, change.point, size)
            if beyond is not None:
                return change._replace(beyond=beyond)
            ends += [change] if change.jump else []
        for other in (point, _without_sticking(system, point, contact)):
            if other is None or ends:
                continue
            for k in _guards(other, contact, system):
                graze = touch(system, other, Condition("grazing", k), _STRAYS * _CLOSE * size)
                if graze is None or not near(graze, _CLOSE):
                    continue
                beyond = _other_side(system, point, graze.point, size)
                if beyond is not None:
                    kind = kind_of(*(p.passage for p in _in_order(point, beyond)))
                    return graze._replace(condition=Condition(kind, k), beyond=beyond)
                if system.flow.opening_of(k) is not None:  # near it, orbits that strike may be none, or unstable
                    ends.append(graze)
    ends += [
        change
        for change in (_landing(system, point, _STRAYS * _CLOSE * size), *_grazes(system, point))
        if change and near(change, _CLOSE)
    ]
    inside = [change for change in ends if span[0] <= change.value <= span[1]]
    return min(inside, key=lambda change: np.max(np.abs(change.edge - point.z) / size), default=None)


def break_ahead(system: ShootingSystem, point: Point, way: np.ndarray, step: float) -> DiscontinuityPoint | None:
    """Return the last orbit as a point at which the motion jumps, if just ahead of it a contact has other events.

    So ends a branch where a slip is zero at an instant at which its rate jumps, as at a step of a force or a sample of
    a held variable: there no guard has a least value inside a step.

    Parameters
    ----------
    system : ShootingSystem
    point : Point
        The last orbit.
    way : ndarray, shape (n_z,)
        Direction of the walk.
    step : float
        Its last step, which found no orbit.
    """
    values = system.unpack(point.z)[2]
    for distance in (step, 10 * step, 100 * step):
        ahead = _followed(system, point.z + distance * way)
        if ahead is None or signature(ahead) == signature(point.passage):
            continue
        contact = _contact_that_differs(point.passage, ahead)
        if not system.flow.peaked(contact, values):
            return None
        return DiscontinuityPoint(
            Condition(kind_of(point.passage, ahead)), system, _last(system, point, way, distance), jump=True
        )
    return None


def _followed(system: ShootingSystem, z: np.ndarray) -> Passage | None:
    try:
        return system.follow(z)
    except NotFound:
        return None


def _last(system: ShootingSystem, point: Point, way: np.ndarray, beyond: float) -> Point:
    """Return the last orbit with the events of a given one, between it and a distance at which they are others."""
    mark, inside = signature(point.passage), 0.0
    for _ in range(_BISECTIONS):
        middle = 0.5 * (inside + beyond)
        passage = _followed(system, point.z + middle * way)
        if passage is not None and signature(passage) == mark:
            inside = middle
        else:
            beyond = middle
    try:
        last = solve(system, point.z + inside * way, _parameter_alone(point))
    except NotFound:
        return point
    return last if signature(last.passage) == mark else point


def _edges(system: ShootingSystem, point: Point, contact: int, reach: np.ndarray) -> list[DiscontinuityPoint]:
    """Return the grazing orbits near a given one, whether or not the contact has other events."""
    n = len(slip_ends(point.passage, contact))
    edges = [_turned(system, point, contact, which, "stick-onset", reach) for which in range(n)]
    if system.flow.peaked(contact, system.unpack(point.z)[2]):
        for k in _guards(point, contact, system):
            kind = "stick-onset" if is_slip_gap(k) else "grazing"
            edges.append(touch(system, point, Condition(kind, k, side=1), reach))
    return [change for change in edges if change]


def _turned(
    system: ShootingSystem, near: Point, contact: int, which: int, kind: str, reach: np.ndarray
) -> DiscontinuityPoint | None:
    """Return the nearby orbit on which the end of a slip is at the limit between a stick and a reversal."""
    values = system.unpack(near.z)[2]
    ends = [after for _, i, before, after in near.passage.events if i == contact and before]
    peaked = system.flow.peaked(contact, values)
    condition = Condition(kind, turn=(contact, which), side=(1 if ends[which] == 0 else -1) if peaked else 0)
    try:
        turned = solve(condition.system(system, 1.0), near.z, slow=_SLOW, reach=reach)
        holding = holding_at(system, turned.z, turned.passage, contact, which)
    except NotFound:
        return None
    if condition.side and signature(turned.passage) != signature(near.passage):
        return None
    return DiscontinuityPoint(condition, system, turned, jump=peaked and holding.rate > 0)


def touch(
    system: ShootingSystem, untouched: Point, condition: Condition, reach: np.ndarray | None = None
) -> DiscontinuityPoint | None:
    """Return the nearby orbit that touches a guard, None if it is not found within a distance `reach`, (n_z,).

    Unless approached from one side, it is computed with that guard relaxed, so the contact must have no other events of
    this kind.
    """
    if not condition.side and has_others(system.flow, untouched.passage, condition.guard):
        return None
    try:
        size = guard_size(system, untouched.z, untouched.passage, condition.guard)
        touching = solve(condition.system(system, size), untouched.z, slow=_SLOW, reach=reach)
    except NotFound:
        return None
    same = signature(touching.passage) == signature(untouched.passage)
    jump = bool(condition.side) and system.flow.opening_of(condition.guard) is None
    jump = jump and system.flow.peaked(contact_of_gap(condition.guard), system.unpack(touching.z)[2])
    return DiscontinuityPoint(condition, system, touching, jump=jump) if same else None


def _landing(system: ShootingSystem, point: Point, reach: np.ndarray) -> DiscontinuityPoint | None:
    """Return the nearby orbit whose first event is a grazing of its guard, beyond which the event is missed."""
    if not point.passage.events:
        return None
    _, contact, before, after = point.passage.events[0]
    if OPEN in (before, after):
        return None
    for k in (k for k in gaps(contact) if is_slip_gap(k) == bool(before)):
        condition = Condition("grazing", k, landing=True)
        try:
            size = guard_size(system, point.z, point.passage, k)
            landing = solve(condition.system(system, size), point.z, slow=_SLOW, reach=reach)
            return DiscontinuityPoint(condition, system, landing)
        except NotFound:
            continue
    return None


def _grazes(system: ShootingSystem, point: Point) -> list[DiscontinuityPoint]:
    """Return the nearby orbits on which one of the other events is a grazing, to leading order."""
    grazes = []
    for k in range(1, len(point.passage.events)):
        condition = Condition("grazing", event=k)
        try:
            test = condition.system(system, 1.0).test
            assert test is not None
            deep = -test.value(point.z, point.passage)
            if deep < _GRAZES:
                condition = replace(condition, deep=deep)
                there = condition.system(system, 1.0).at(point.z, point.phase, point.z[: len(system.flow.states)])
                grazes.append(DiscontinuityPoint(condition, system, there))
        except NotFound:
            continue
    return grazes


def _without_sticking(system: ShootingSystem, point: Point, contact: int) -> Point | None:
    """Return the nearby orbit that ignores the zero slip at which a contact of the given orbit sticks.

    There is none in the plane, where the direction of a slip is singular at zero.
    """
    never = all(i != contact for _, i, _, _ in point.passage.events)
    if never or contact >= len(system.flow.lines) or contact in system.flow.planes:
        return None
    k = slip_gap(contact)
    lift = ignoring(system.flow, k, guard_size(system, point.z, point.passage, k))
    try:
        return solve(replace(system, lift=lift), point.z, _parameter_alone(point), slow=_SLOW)
    except NotFound:
        return None


def _other_side(system: ShootingSystem, point: Point, change: Point, size: np.ndarray) -> Point | None:
    """Return an orbit on the other side of a discontinuity, with other events."""
    normal, mark = _parameter_alone(point), signature(point.passage)
    for distance in _BEYOND:
        for way in (1, -1):
            try:
                there = solve(system, change.z + way * distance * size[-1] * normal, normal)
            except NotFound:
                continue
            near = np.max(np.abs(there.z - change.z) / size) < _CLOSE
            if near and signature(there.passage) != mark:
                return there
    return None


def _parameter_alone(point: Point) -> np.ndarray:
    return np.append(np.zeros(point.z.size - 1), 1.0)


def _in_order(one: Point, other: Point) -> tuple[Point, Point]:
    """Return the two orbits, the one with fewer events, which does not touch, first."""
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


def kind_of(untouched: Passage, touched: Passage) -> str:
    """Return the kind of the change of events between two orbits."""
    sticks = [sum(b == 0 and a != OPEN for _, _, a, b in p.events) for p in (untouched, touched)]
    return "stick-onset" if sticks[0] < sticks[1] else "grazing"


def _guards(point: Point, contact: int, system: ShootingSystem) -> list[int]:
    """Return the guards of a contact that have a local minimum on the orbit, the nearest to zero first."""
    near = np.abs(point.passage.gaps)
    rows = [slip_gap(contact)] if contact in system.flow.planes else []
    rows += gaps(contact) if contact < len(system.flow.lines) and not rows else ()
    rows += [system.flow.gap_of(contact)] if contact in system.flow.openings else []
    rows = [k for k in rows if near[k] < FAR]
    return sorted(rows, key=lambda k: near[k] / guard_size(system, point.z, point.passage, k))
