"""One walk along a branch of periodic orbits: predictor, corrector, step control, and detection of special points."""

from collections.abc import Callable
from dataclasses import dataclass, field, replace
from typing import NamedTuple

import numpy as np

from symfric.errors import NotFound
from symfric.long_calls import tell, until_interrupted
from symfric.model.scene import Scene
from symfric.orbits.continuation import branch_points
from symfric.orbits.continuation.arclength import CORRECTIONS, Behind, cosine, step_along, tangent, units
from symfric.orbits.continuation.bifurcations import (
    SMOOTH,
    Condition,
    between,
    is_pair,
    other_multipliers,
    signature,
    smooth_test,
)
from symfric.orbits.continuation.closed_branch import Placed, marks_of, passed_again
from symfric.orbits.continuation.discontinuity import (
    DiscontinuityPoint,
    break_ahead,
    discontinuity_ahead,
    discontinuity_between,
)
from symfric.orbits.continuation.grazing import grazing_ahead
from symfric.orbits.continuation.hopf import vanishing_point
from symfric.orbits.continuation.jump import settled_beyond
from symfric.orbits.continuation.slip_onset import SlipOnset, across_onset, passes_the_start, slip_onsets, widest_ranges
from symfric.orbits.shooting import Point, ShootingSystem, solve
from symfric.search import zero

_FIRST, _LEAST = 0.01, 1e-6  # step lengths in units of the span, the period and the ranges of the states
_APART = 1e-3  # step length down to which a turn of the parameter is told apart from a branch point or a discontinuity
# sizes relative to the largest orbit: at which a Hopf point is sought ahead, and at which the walk stops
_SMALL, _SMALLEST = 0.2, 0.03
_GUESSES = 3  # orbits nearest by from which one between two others is sought
_ENDS = ("lost", "jump", "grazing", "flip")  # reasons for ending without a further orbit
_BEHIND = 2  # orbits before the last one from which the next one is guessed
_NEAR_START = 0.02  # fraction of the period: the start of an orbit is moved if an event is so close to it


@dataclass(frozen=True)
class Steps:
    """How finely a branch is followed.

    Attributes
    ----------
    largest : float
        Largest step in units of the span, the period and the ranges of the states.
    turn : float
        Least cosine of the angle between consecutive steps on one smooth piece.
    """

    largest: float = 0.03
    turn: float = 0.95


FINE = Steps()


class SpecialPoint(NamedTuple):
    """A special point: its condition, orbit and parameter value, and whether the orbits jump there."""

    condition: Condition
    orbit: Placed
    value: float
    jump: bool = False


class _Enclosed(NamedTuple):
    """A discontinuity enclosed between orbits but not located: what changes there, and its unknowns (n_z,)."""

    signs: tuple[object, object]
    z: np.ndarray


@dataclass
class HalfBranch:
    """One side of a branch as a walk follows it: orbits and special points in order, and why it ended."""

    orbits: list[Placed] = field(default_factory=list)
    special: list[SpecialPoint] = field(default_factory=list)
    end: str = ""


class Walk:
    """Walks along one branch of periodic orbits.

    Parameters
    ----------
    scene : Scene
    system : ShootingSystem
        With one parameter.
    span : (float, float)
    most : int
        Orbits of one walk.
    steps : Steps, optional
    """

    def __init__(self, scene: Scene, system: ShootingSystem, span: tuple[float, float], most: int, steps: Steps = FINE):
        self._steps = steps
        self._scene, self._system, self._limits, self._most = scene, system, np.array([span]), most
        self._largest = np.zeros(len(system.flow.states))
        self._springs = widest_ranges(system.flow)
        self._known = 0  # special points up to the last orbit
        self._behind: tuple[Behind, ...] = ()  # the last one, on a smooth piece, latest first
        self._enclosed: _Enclosed | None = None  # the last of its kind
        self._tested: tuple[Point, dict[str, float]] | None = None  # test functions of the last orbit

    def go(self, start: Point, direction: np.ndarray) -> HalfBranch:
        """Walk from an orbit in a direction of the unknowns, (n_z,), to the end of the branch or of the span."""
        half = HalfBranch()
        with until_interrupted("continue_cycle", "frequency_response", "onset"):
            self._walk(half, start, direction)
            return half
        half.end = "interrupted"
        del half.special[self._known :]
        return half

    def _walk(self, half: HalfBranch, start: Point, direction: np.ndarray) -> None:
        point, step, hopf, self._behind, self._enclosed = start, _FIRST, None, (), None
        way, trail = self.tangent(point, direction), [Placed(self._system, start)]
        marks = [marks_of(trail[0])]
        while len(half.orbits) < self._most and not half.end:
            self._largest = np.maximum(self._largest, point.passage.ranges)
            before, self._known = point, len(half.special)
            point, way, step = self._advance(half, point, way, step)
            if half.end in _ENDS:
                break
            mark = marks_of(Placed(self._system, point))
            again = passed_again(trail, np.array([*marks, mark]), Placed(self._system, point))
            if again is not None:
                half.end = "closed" if again == 0 else "folded-back"
                del half.special[self._known :]
                break
            half.orbits.append(Placed(self._system, point))
            tell(f"{len(half.orbits)} orbits to {self._system.flow.parameters[0]} = {point.z[-1]:.5g}")
            trail.append(half.orbits[-1])
            marks.append(mark)
            hopf = self._hopf_ahead(before, point) if hopf is None else hopf
            if hopf is not None and point.passage.ranges[0] <= _SMALLEST * self._largest[0]:
                half.special.append(SpecialPoint(Condition("hopf"), Placed(self._system, point), hopf))
                half.end = "hopf"
            if not half.end:
                point, way = self._moved(point, way)
        half.end = half.end or "budget"

    def tangent(self, point: Point, along: np.ndarray) -> np.ndarray:
        """Return the direction of the branch at an orbit, on the side of `along`."""
        return tangent(self._system, point, self._units(point), along)

    def _units(self, point: Point) -> np.ndarray:
        return units(self._system, point, self._limits, self._largest)

    def _advance(self, half: HalfBranch, point: Point, way: np.ndarray, step: float) -> tuple[Point, np.ndarray, float]:
        """Return the next orbit, the direction there, and the next step length; record special points in between."""
        size, span = self._units(point), tuple(self._limits[0])
        behind, self._behind = self._behind, ()
        while True:
            del half.special[self._known :]
            new, ends = step_along(self._system, point, way, step, size, self._limits, behind)
            half.end = "span" if ends else ""
            if new is None and step <= _LEAST:
                beyond = across_onset(self._system, self._springs, point, way, size)
                if beyond is not None:
                    onsets = self._note_onsets(half, point, beyond)
                    return beyond, self.tangent(beyond, beyond.z - onsets[-1].point.z), _FIRST
                change = discontinuity_ahead(self._system, point, way, size, span)
                if change is None or not (change.beyond or change.jump):
                    change = grazing_ahead(self._system, point, way, size, span) or change
                change = change or break_ahead(self._system, point, way, step)
                if change is None:
                    half.end = "lost"
                    return point, way, step
                return self._beyond(half, change, point, way)
            if new is None:
                step *= 0.3
                continue
            onsets = self._note_onsets(half, point, new)
            if signature(new.passage) != signature(point.passage):
                if step > _APART and self._encloses(point, new):
                    step *= 0.4
                    continue
                change = discontinuity_between(self._system, point, new, size, span)
                if change.jump and (new.z[-1] - change.value) * way[-1] < 0:  # an orbit of another branch, on this side
                    return self._beyond(half, change._replace(beyond=None), point, way)
                ahead = self.tangent(new, new.z - change.point.z)
                if step > _APART and not change.jump and _hides_a_turn(change, point, way, new, ahead):
                    self._enclosed = None if change.located else _Enclosed(_signs(point, new), change.point.z)
                    step *= 0.4
                    continue
                self._note_discontinuity(half, change, point)
                return new, ahead, min(step, _FIRST)
            if onsets:
                return new, self.tangent(new, new.z - onsets[-1].point.z), min(step, _FIRST)
            ahead = self.tangent(new, way)
            passes = passes_the_start(point.passage, new.passage)
            if cosine(ahead, way, self._units(new)) < self._steps.turn and step > _LEAST and not passes:
                step *= 0.4
                continue
            crosses = not passes and branch_points.orientations_differ(point, way, new, ahead, size)
            there = branch_points.located(self._system, point, new, size) if crosses else None
            turns = way[-1] * ahead[-1] < 0
            fold = self._fold(point, new) if turns and not there else None
            hidden = turns and not there and fold is None
            if (step > _LEAST and (hidden or (crosses and there is None))) or (there and turns and step > _APART):
                step *= 0.4
                continue
            if there and self._ends_at_flip(half, there):
                return point, way, step
            if there:
                half.special.append(self._met(branch_points.KIND, there, point, new))
            if turns and not there:
                half.special.append(self._met("fold", fold or point, point, new))
            self._note_smooth(half, point, new)
            self._behind = (Behind(point.z, way), *behind)[:_BEHIND]
            return new, ahead, min(1.5 * step, self._steps.largest)

    def _encloses(self, point: Point, new: Point) -> bool:
        """Whether a discontinuity enclosed by bisection lies between two orbits; only shorter steps locate it."""
        if self._enclosed is None or self._enclosed.signs != _signs(point, new):
            return False
        size, there = self._units(point), self._enclosed.z
        way, ahead = (new.z - point.z) / size, (there - point.z) / size
        share = float(ahead @ way) / float(way @ way)
        return 0.0 < share < 1.0 and bool(np.linalg.norm(ahead - share * way) < np.linalg.norm(way))

    def _beyond(
        self, half: HalfBranch, change: DiscontinuityPoint, point: Point, way: np.ndarray
    ) -> tuple[Point, np.ndarray, float]:
        """Continue beyond the discontinuity at which the walk stopped, on a nearby orbit or an attractor."""
        if change.beyond is not None:
            self._note_discontinuity(half, change, point)
            return change.beyond, self.tangent(change.beyond, change.beyond.z - change.edge), _FIRST
        span = tuple(self._limits[0])
        settled = settled_beyond(self._scene, self._system, change.point, change.value, way[-1], span)
        self._note_discontinuity(half, change._replace(jump=change.jump or settled is not None), point)
        if change.jump:
            half.orbits.append(Placed(self._system, change.point))
        if settled is None:
            half.end = "jump" if change.jump else "grazing"
            return point, way, _FIRST
        self._system, new = settled
        onward = np.append(np.zeros(way.size - 1), way[-1])
        return new, self.tangent(new, onward), _FIRST

    def _note_discontinuity(self, half: HalfBranch, change: DiscontinuityPoint, before: Point) -> None:
        met = SpecialPoint(change.condition, Placed(self._system, change.point), change.value, change.jump)
        half.special.append(met)
        if change.beyond and not change.jump and (met.value - before.z[-1]) * (change.beyond.z[-1] - met.value) < 0:
            half.special.append(met._replace(condition=replace(change.condition, kind="fold")))

    def _note_onsets(self, half: HalfBranch, one: Point, other: Point) -> list[SlipOnset]:
        """Record where contacts behind springs begin to slip between two orbits, or stick from there on."""
        onsets = slip_onsets(self._system, self._springs, one, other)
        for condition, there in onsets:
            half.special.append(SpecialPoint(condition, Placed(self._system, there), float(there.z[-1])))
        return onsets

    def _ends_at_flip(self, side: HalfBranch, there: Point) -> bool:
        """Whether a branch ends on one of half its period, where it is found; it would run back over its own orbits."""
        half = branch_points.halved(self._system, there)
        if half is None:
            return False
        start, period, values = self._system.unpack(there.z)
        alone = np.append(np.zeros(there.z.size - 1), 1.0)
        try:
            orbit = solve(half, half.pack(start, 0.5 * period, values), alone)
        except NotFound:
            return False
        condition = Condition("flip", along=tuple(alone.tolist()))
        side.special.append(SpecialPoint(condition, Placed(half, orbit), float(there.z[-1])))
        side.end = "flip"
        return True

    def _met(self, kind: str, there: Point, one: Point, other: Point) -> SpecialPoint:
        """Return a special point of a smooth piece between two orbits."""
        along = tuple((other.z - one.z).tolist()) if kind in (branch_points.KIND, "flip") else ()
        return SpecialPoint(Condition(kind, along=along), Placed(self._system, there), float(there.z[-1]))

    def _note_smooth(self, half: HalfBranch, one: Point, other: Point) -> None:
        """Record flips and Neimark-Sacker points between two orbits of one smooth piece."""
        free, before, after = self._system.free, self._tests_at(one), self._tests_at(other)
        self._tested = other, after
        for kind in after:
            if not before[kind] * after[kind] < 0 or (kind == "neimark-sacker" and not is_pair(other.passage, free)):
                continue
            half.special.append(self._met(kind, self._located(kind, one, other) or one, one, other))

    def _tests_at(self, point: Point) -> dict[str, float]:
        """Return the test functions of flips and Neimark-Sacker points; those of the last orbit are known."""
        if self._tested is not None and self._tested[0] is point:
            return self._tested[1]
        others = other_multipliers(point.passage, self._system.free)
        return {kind: test(others) for kind, test in SMOOTH.items() if kind != "fold"}

    def _fold(self, one: Point, other: Point) -> Point | None:
        """Return the point between two orbits where the parameter turns; None if it is not found.

        There the direction of the branch has no part along the parameter. Its zero is found along the branch; the
        multiplier that reaches one there is hardly told from that of a shift of time, so it is no smooth test function.
        It may also jump across zero, at a corner of the map such as the limit of a sampled command: Newton's method
        starts from the orbits nearest by, since from the chord it may go to and fro across the corner.
        """
        chord = other.z - one.z
        try:
            return self._zero(one, other, lambda point: float(self.tangent(point, chord)[-1]))
        except (NotFound, ValueError):
            return self._located("fold", one, other)

    def _zero(self, one: Point, other: Point, test: Callable[[Point], float]) -> Point:
        """Return the orbit between two at which a function of other signs on both is zero.

        Raises
        ------
        NotFound
            If an orbit in between is not found.
        ValueError
            If the signs are the same.
        """
        chord = other.z - one.z
        normal, points = chord / self._units(one) ** 2, {0.0: one, 1.0: other}

        def at(share: float) -> Point:
            if share not in points:
                points[share] = found(share)
            return points[share]

        def found(share: float) -> Point:
            for known in sorted(points, key=lambda k: abs(k - share))[:_GUESSES]:
                along = self.tangent(points[known], chord)
                guess = points[known].z + (share - known) * float(chord @ normal) / float(along @ normal) * along
                try:
                    return solve(self._system, guess, normal, CORRECTIONS)
                except NotFound:
                    continue
            return solve(self._system, one.z + share * chord, normal, CORRECTIONS)

        return at(zero(lambda share: test(at(share)), 0.0, 1.0, xtol=1e-12, rtol=1e-12))

    def _located(self, kind: str, one: Point, other: Point) -> Point | None:
        """Return the point of a kind between two orbits; None if its test function keeps its sign and is not zero."""
        free, span = self._system.free, np.abs(other.z - one.z)
        if kind != "fold":
            try:
                return self._zero(one, other, lambda point: smooth_test(kind, point.passage, free))
            except (NotFound, ValueError):
                pass
        try:
            there = solve(Condition(kind).system(self._system, 1.0), 0.5 * (one.z + other.z))
            if np.all(np.abs(there.z - 0.5 * (one.z + other.z)) <= span + 1e-6 * np.abs(one.z)):
                return there
        except NotFound:
            pass
        positive = [smooth_test(kind, p.passage, free) > 0 for p in (one, other)]
        if positive[0] == positive[1]:
            return None
        return between(self._system, one, other, lambda passage: smooth_test(kind, passage, free) > 0)[0]

    def _hopf_ahead(self, before: Point, point: Point) -> float | None:
        """Return the parameter at the Hopf point towards which the orbits shrink, or None."""
        sizes = np.array([p.passage.ranges[0] for p in (before, point)])
        if not self._system.free or sizes[1] >= sizes[0] or sizes[1] > _SMALL * self._largest[0]:
            return None
        name = self._system.flow.parameters[0]
        values, period = np.array([before.z[-1], point.z[-1]]), self._system.unpack(point.z)[1]
        return vanishing_point(self._scene, name, values, sizes, period)

    def _moved(self, point: Point, way: np.ndarray) -> tuple[Point, np.ndarray]:
        """Move the start of an orbit that is close to an event to the middle of the longest stretch without events."""
        system, n = self._system, len(self._system.flow.states)
        start, period, values = system.unpack(point.z)
        times = np.array([e[0] for e in point.passage.changes])
        near = np.any((times < _NEAR_START * period) | (times > (1 - _NEAR_START) * period))
        if not system.free or not near:
            return point, way
        edges = np.append(times, times[0] + period)
        k = int(np.argmax(np.diff(edges)))
        passage = system.flow.run(start, values, (edges[k] + 0.5 * (edges[k + 1] - edges[k])) % period)
        carried = passage.by_start @ way[:n] + passage.by_value @ way[n + 1 :]
        moved = solve(system, np.concatenate([passage.end, point.z[n:]]), np.append(np.zeros(n + 1), 1.0))
        self._behind = ()  # they start at other times
        return moved, self.tangent(moved, np.concatenate([carried, way[n:]]))


def _hides_a_turn(change: DiscontinuityPoint, one: Point, way: np.ndarray, other: Point, ahead: np.ndarray) -> bool:
    """Whether the parameter may turn between a discontinuity and an orbit beside it, of tangents `way`, `ahead`."""
    beside = way[-1] * (change.value - one.z[-1]) < 0 or ahead[-1] * (other.z[-1] - change.value) < 0
    return beside or way[-1] * ahead[-1] < 0 or not change.located


def _signs(one: Point, other: Point) -> tuple[object, object]:
    return signature(one.passage), signature(other.passage)
