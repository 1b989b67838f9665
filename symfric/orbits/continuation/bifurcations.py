"""Equations that define the special points of a branch of periodic orbits."""

import itertools
from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from symfric.errors import NotFound
from symfric.lower.mode_layout import OPEN, contact_of_gap, is_slip_gap, slip_gap
from symfric.lower.relaxed_guards import LIFTS, lift_of
from symfric.orbits.cycle import multipliers_of
from symfric.orbits.flow_map import FlowMap, Guard
from symfric.orbits.passages import Passage
from symfric.orbits.shooting import Point, ShootingSystem, TestFunction, solve, step_of

LIFTED = 1e3  # shift of a relaxed guard in units of its size; no motion reaches it
EDGE = 3e-6  # distance from a grazing, relative to the guard's size, from which the grazing orbit is extrapolated
WINDOW = 0.1  # fraction of the period for which a motion that ignores an event is followed beyond it
_NEAR = 1e-8  # finite-difference step relative to the ranges, so small that it stays on one side of the grazing
_BISECTIONS, _CLOSE = 60, 1e-13  # limits of a bisection: steps, and width relative to the unknowns
TOUCHES = ("stick-onset", "grazing")  # kinds at which a guard touches zero


@dataclass(frozen=True)
class Condition:
    """The defining condition of a special point.

    Attributes
    ----------
    kind : str
        "fold", "branch-point", "flip", "neimark-sacker", "stick-onset", "slip-onset", "grazing", or "half-range": that
        of the first state is `level`.
    guard : int
        Index in `Passage.gaps` of the guard that touches zero; -1 if none does.
    landing : bool
        Whether the touch is the first event of the orbit itself, which cannot be ignored; otherwise the orbit is
        continued with that guard relaxed.
    turn : (int, int) or None
        A contact, and the index among the ends of its slips in one period of the one at the limit between stick and
        reversal: the constraint force there equals the largest static friction.
    side : int
        Where static friction exceeds kinetic friction, the orbits on both sides differ, and the condition is approached
        from one of them: for a turn, 1 for orbits that stick there, -1 for orbits that slip back; for a guard, 1 for
        orbits that do not touch it. Otherwise 0.
    event : int
        Index among the events of a period of the one whose guard just touches zero; else -1. Derivatives of such orbits
        grow without bound near the grazing, so the orbit keeps a distance of `deep` from it.
    deep : float
    level : float
    spring : int
        Of an onset of slip, the place of the elongation among the states.
    along : tuple of float, length n_z
        Of a branch point or a flip, about the tangent of the branch on which it was found.
    """

    kind: str
    guard: int = -1
    landing: bool = False
    turn: tuple[int, int] | None = None
    side: int = 0
    event: int = -1
    deep: float = 0.0
    level: float = 0.0
    spring: int = -1
    along: tuple[float, ...] = ()

    @property
    def depth(self) -> float:
        """Distance of the solutions of `system` from the grazing itself, in units of the guard's size."""
        return self.deep if self.event >= 0 else EDGE if self.landing else -self.side * EDGE

    def system(self, system: ShootingSystem, size: float) -> ShootingSystem:
        """Return the equations of periodic orbits with this condition; `size` is that of the guard."""
        if self.kind == "half-range":
            return replace(system, test=TestFunction(lambda z, passage: 0.5 * passage.ranges[0] / self.level - 1.0))
        if self.turn:
            return replace(system, test=_turn(system, self))
        if self.event >= 0:
            return replace(system, test=_graze(system, self))
        if self.guard < 0:
            return replace(system, test=TestFunction(lambda z, passage: smooth_test(self.kind, passage, system.free)))
        if self.side:
            return replace(system, test=_touch(self, size))
        lift = ignoring(system.flow, self.guard, size)
        if self.landing:
            return replace(system, test=_landing(system, self.guard, size, lift))
        return replace(system, test=_touch(self, size), lift=lift)


def signature(passage: Passage) -> tuple[tuple[int, int, int], ...]:
    """Return the changes of mode in cyclic order, rotated so that the result does not depend on the start."""
    changes = [(i, a, b) for _, i, a, b in passage.events]
    turns = [tuple(changes[k:] + changes[:k]) for k in range(len(changes))]
    return min(turns, default=())


def flip(others: np.ndarray) -> float:
    """Return the test function of a flip: zero where a nontrivial multiplier is -1."""
    return float(np.prod(1.0 + others).real)


def fold(others: np.ndarray) -> float:
    """Return the test function of a fold: zero where a nontrivial multiplier is 1."""
    return float(np.prod(1.0 - others).real)


def torus(others: np.ndarray) -> float:
    """Return the test function of a Neimark-Sacker point: zero where two nontrivial multipliers have the product 1."""
    one, other = np.triu_indices(others.size, 1)
    return float(np.prod(1.0 - others[one] * others[other]).real)


# test functions of the nontrivial multipliers
SMOOTH: dict[str, Callable[[np.ndarray], float]] = {"fold": fold, "flip": flip, "neimark-sacker": torus}


def smooth_test(kind: str, passage: Passage, free: bool) -> float:
    """Return the test function of a kind on an orbit."""
    return SMOOTH[kind](other_multipliers(passage, free))


def is_pair(passage: Passage, free: bool) -> bool:
    """Whether the two multipliers with the product nearest to 1 are complex; real ones belong to a neutral saddle."""
    pairs = list(itertools.combinations(other_multipliers(passage, free), 2))
    nearest = min(pairs, key=lambda pair: abs(1.0 - pair[0] * pair[1]))
    return bool(abs(np.imag(nearest[0])) > 0)


def other_multipliers(passage: Passage, free: bool) -> np.ndarray:
    """Return the multipliers besides those of a shift of time and of the elongations that nothing determines."""
    multipliers, trivial = multipliers_of(passage, free)
    others = np.delete(multipliers, trivial) if trivial is not None else multipliers
    for _ in passage.idle:
        others = np.delete(others, int(np.argmin(np.abs(others - 1.0))))
    return others


def _touch(condition: Condition, size: float) -> TestFunction:
    """Return the test function of a touch: least value of a guard, less the distance that the condition keeps."""
    k = condition.guard

    def slopes(z: np.ndarray, passage: Passage) -> np.ndarray:
        n_p = passage.gaps_by_value.shape[1]
        parts = passage.gaps_by_start[k], np.zeros(z.size - passage.end.size - n_p), passage.gaps_by_value[k]
        return np.concatenate(parts) / size

    return TestFunction(lambda z, passage: float(passage.gaps[k] / size) + condition.depth, slopes)


def _landing(system: ShootingSystem, k: int, size: float, lift: np.ndarray) -> TestFunction:
    """Return the test function of a touch at the first event of the orbit, where guard k has zero rate."""
    flow = system.flow

    def beyond_it(z: np.ndarray, passage: Passage) -> Passage:
        start, period, values = system.unpack(z)
        first = passage.events[0][0] if passage.events else 0.0
        return flow.run(start, values, first + WINDOW * period, lift)

    def value(z: np.ndarray, passage: Passage) -> float:
        return float(beyond_it(z, passage).gaps[k] / size) + EDGE

    def slopes(z: np.ndarray, passage: Passage) -> np.ndarray:
        beyond = beyond_it(z, passage)
        return np.concatenate([beyond.gaps_by_start[k], np.zeros(int(system.free)), beyond.gaps_by_value[k]]) / size

    return TestFunction(value, slopes)


def has_others(flow: FlowMap, passage: Passage, k: int) -> bool:
    """Whether guard k causes another event on the orbit, which relaxing it would remove too."""
    opening = flow.opening_of(k)
    if opening is not None:
        return any(i == opening and before == OPEN for _, i, before, _ in passage.events)
    begins = [before == 0 for _, i, before, _ in passage.events if i == contact_of_gap(k)]
    return not all(begins) if is_slip_gap(k) else any(begins)


def at_the_edge(
    system: ShootingSystem, point: Point, condition: Condition, normal: np.ndarray | None = None
) -> np.ndarray:
    """Return the change of the unknowns from an orbit with a condition to the grazing itself, (n_z,).

    At right angles to `normal` if there is one unknown more than equations; the shortest way unless it is given.
    """
    if not condition.depth:
        return np.zeros(point.z.size)
    return step_of(system, point, np.append(np.zeros(point.rest.size - 1), condition.depth), normal)


def holding_at(system: ShootingSystem, z: np.ndarray, passage: Passage, contact: int, which: int) -> Guard:
    """Return the reserve of static friction at one of the ends of a contact's slips.

    Raises
    ------
    NotFound
        If there is no such end.
    """
    time, way = _slip_end(passage, contact, which)
    start, _, values = system.unpack(z)
    return system.flow.guard(start, values, time, contact, way, sticks=True)


def _turn(system: ShootingSystem, condition: Condition) -> TestFunction:
    """Return the test function of a turn: relative reserve of static friction at the end of a slip, less `depth`."""
    assert condition.turn is not None
    contact, which = condition.turn

    def value(z: np.ndarray, passage: Passage) -> float:
        return holding_at(system, z, passage, contact, which).left + condition.depth

    def slopes(z: np.ndarray, passage: Passage) -> np.ndarray:
        time, way = _slip_end(passage, contact, which)
        start, _, values = system.unpack(z)
        by_start, by_value = system.flow.reserve_slopes(start, values, time, contact, way)
        return np.concatenate([by_start, np.zeros(int(system.free)), by_value])

    return TestFunction(value, slopes)


def _slip_end(passage: Passage, contact: int, which: int) -> tuple[float, int]:
    """Return the time at which a slip ends, and its direction; raise NotFound if there is no such slip."""
    ends = slip_ends(passage, contact)
    if which >= len(ends):
        raise NotFound("the contact no longer ends a slip there")
    return ends[which]


def _graze(system: ShootingSystem, condition: Condition) -> TestFunction:
    """Return the test function of a grazing event: its guard just reaches zero.

    With the event ignored, the guard would reach ``-g'^2/(2 g'')``, to leading order, after the time ``-g'/g''``. If
    friction drops when a contact begins to slip, the orbits depend on this time, the square root of the depth.
    """

    def value(z: np.ndarray, passage: Passage) -> float:
        if condition.event >= len(passage.events):
            raise NotFound("the event does not occur on this orbit")
        start, _, values = system.unpack(z)
        time, contact, before, after = passage.events[condition.event]
        if OPEN in (before, after):
            raise NotFound("the event is an impact")
        guard = system.flow.guard(start, values, time, contact, before or -after, sticks=before == 0)
        size = 1.0 if before == 0 else guard_size(system, z, passage, slip_gap(contact))
        if not guard.bend > 0:
            raise NotFound("the guard crosses zero at the event instead of grazing it")
        depth = 0.5 * guard.rate**2 / (guard.bend * size)
        return condition.depth - (np.sqrt(depth) if before == 0 and system.flow.peaked(contact, values) else depth)

    def slopes(z: np.ndarray, passage: Passage) -> np.ndarray:
        size = system.sizes(z, passage)
        ends = [
            [value(z + way * step, system.follow(z + way * step)) for way in (1, -1)] for step in _NEAR * np.diag(size)
        ]
        return np.array([(ahead - behind) / (2 * _NEAR * h) for (ahead, behind), h in zip(ends, size, strict=True)])

    return TestFunction(value, slopes)


def slip_ends(passage: Passage, contact: int) -> list[tuple[float, int]]:
    """Return the times at which slips of a contact end, and their directions."""
    slips = ((t, before) for t, i, before, after in passage.events if i == contact and OPEN not in (before, after))
    return [(t, before) for t, before in slips if before]


def ignoring(flow: FlowMap, k: int, size: float) -> np.ndarray:
    """Return the guard shifts with which a motion ignores guard k of `Passage.gaps`."""
    lift = np.zeros(flow.n_lifts)
    opening = flow.opening_of(k)
    if opening is not None:
        lift[LIFTS * len(flow.lines) + flow.openings.index(opening)] = LIFTED * size
        return lift
    lift[lift_of(contact_of_gap(k), slips=is_slip_gap(k))] = LIFTED * size
    return lift


def guard_size(system: ShootingSystem, z: np.ndarray, passage: Passage, k: int) -> float:
    """Return a size of guard k: of a slip, the range of the velocities; of a static bound, twice the bound.

    The bound is the largest static friction at the start and where the contact begins to stick.
    """
    flow, contact = system.flow, contact_of_gap(k)
    if flow.opening_of(k) is not None:
        return float(np.max(passage.ranges[: len(flow.scene.system.q)]))
    if is_slip_gap(k):
        n_q = len(flow.scene.system.q)
        return float(np.max(passage.ranges[n_q : 2 * n_q]))
    start, _, values = system.unpack(z)
    times = {0.0, *(t for t, i, _, after in passage.events if i == contact and after == 0)}
    size = max(flow.guard(start, values, t, contact, 1, sticks=True).size for t in times)
    return size or abs(float(passage.gaps[k]))


def between(
    system: ShootingSystem, one: Point, other: Point, where: Callable[[Passage], object]
) -> tuple[Point, Point]:
    """Bisect along the branch for a change of a property of the orbits; return the orbits on both sides.

    Where the branch ends at a jump, a trial may have no orbit; it then counts as the other side.
    """
    start, chord = one.z, other.z - one.z
    low, high, mark = 0.0, 1.0, where(one.passage)
    size = np.maximum(np.abs(start), system.sizes(start, one.passage))
    normal = chord / size**2
    for _ in range(_BISECTIONS):
        share = 0.5 * (low + high)
        if np.max(np.abs((high - low) * chord) / size) < _CLOSE:
            break
        # from between the nearest orbits, in the plane across the chord
        guess = 0.5 * (one.z + other.z)
        guess = guess + (share - (guess - start) @ normal / (chord @ normal)) * chord
        try:
            middle = solve(system, guess, normal, most=12)
        except NotFound:
            high = share
            continue
        if where(middle.passage) == mark:
            low, one = share, middle
        else:
            high, other = share, middle
    return one, other
