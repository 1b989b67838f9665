"""One walk along a branch of closed orbits: predictor, corrector, step control, and what is met on the way."""

from dataclasses import dataclass, field, replace

import numpy as np

from symfric.errors import NotFound
from symfric.model.scene import Scene
from symfric.orbits.arclength import cosine, step_along, tangent, units
from symfric.orbits.corner import Corner, corner_ahead, corner_between
from symfric.orbits.hopf_end import vanishing_point
from symfric.orbits.shooting import Point, System, ranges, solve
from symfric.orbits.special import SMOOTH, Condition, between, is_pair, signature

_FIRST, _LEAST, _LARGEST = 0.01, 1e-6, 0.03  # of a step, in units of the span, the period and the ranges of the states
_TURN = 0.95  # least cosine between the directions of two steps on one smooth piece
_SMALL, _SMALLEST = 0.2, 0.03  # of the largest half range: where an end is looked for, and where the walk stops
_NEAR_START = 0.02  # part of the period: events so near to the start of the orbit make it move


@dataclass
class Found:
    """What a walk met: orbits, special points with their condition and the value of the parameter; why it ended."""

    points: list[Point] = field(default_factory=list)
    special: list[tuple[Condition, Point, float]] = field(default_factory=list)
    end: str = ""


class Walk:
    """Walks along a branch.

    Parameters
    ----------
    scene : Scene
    system : System
        With one parameter.
    span : (float, float)
    most : int
        Orbits of one walk.
    """

    def __init__(self, scene: Scene, system: System, span: tuple[float, float], most: int):
        self._scene, self._system, self._limits, self._most = scene, system, np.array([span]), most
        self._largest = np.zeros(len(system.flow.states))

    def go(self, start: Point, direction: np.ndarray) -> Found:
        """Walk from an orbit in a direction of its unknowns, (n_z,), to the end of the branch or of the span."""
        found, point, step, hopf = Found(), start, _FIRST, None
        way = self.tangent(point, direction)
        while len(found.points) < self._most and not found.end:
            self._largest = np.maximum(self._largest, ranges(point.passage))
            before = point
            point, way, step = self._advance(found, point, way, step)
            if found.end == "lost":
                break
            found.points.append(point)
            hopf = hopf or self._hopf_ahead(before, point)
            if hopf and ranges(point.passage)[0] <= _SMALLEST * self._largest[0]:
                found.special.append((Condition("hopf"), point, hopf.value))
                found.end = "hopf"
            elif self._has_closed(found, start):
                found.end = "closed"
            if not found.end:
                point, way = self._moved(point, way)
        found.end = found.end or "budget"
        return found

    def tangent(self, point: Point, along: np.ndarray) -> np.ndarray:
        """Return the direction of the branch at an orbit, on the side of `along`."""
        return tangent(point, self._units(point), along)

    def _units(self, point: Point) -> np.ndarray:
        return units(self._system, point, self._limits, self._largest)

    def _advance(self, found: Found, point: Point, way: np.ndarray, step: float) -> tuple[Point, np.ndarray, float]:
        """Return the next orbit, the direction there, and the next step; note what lies between."""
        size = self._units(point)
        while True:
            new, ends = step_along(self._system, point, way, step, size, self._limits)
            found.end = "span" if ends else ""
            if new is None and step <= _LEAST:
                corner = corner_ahead(self._system, point, size)
                if corner is None:
                    found.end = "lost"
                    return point, way, step
                self._note_corner(found, corner, point)
                if corner.beyond is None:
                    found.end = "grazing"
                    return corner.point, way, step
                return corner.beyond, self.tangent(corner.beyond, corner.beyond.z - corner.point.z), _FIRST
            if new is None:
                step *= 0.3
                continue
            if signature(new.passage) != signature(point.passage):
                corner = corner_between(self._system, point, new)
                self._note_corner(found, corner, point)
                return new, self.tangent(new, new.z - corner.point.z), min(step, _FIRST)
            ahead = self.tangent(new, way)
            if cosine(ahead, way, self._units(new)) < _TURN and step > _LEAST:
                step *= 0.4
                continue
            self._note_smooth(found, point, new, way, ahead)
            return new, ahead, min(1.5 * step, _LARGEST)

    def _note_corner(self, found: Found, corner: Corner, before: Point) -> None:
        value = float(corner.point.z[-1])
        found.special.append((corner.condition, corner.point, value))
        if corner.beyond and (value - before.z[-1]) * (corner.beyond.z[-1] - value) < 0:
            found.special.append((replace(corner.condition, kind="fold"), corner.point, value))

    def _note_smooth(self, found: Found, one: Point, other: Point, way: np.ndarray, ahead: np.ndarray) -> None:
        """Note folds, flips and Neimark-Sacker points between two orbits of one smooth piece."""
        free = self._system.free
        for kind, test in SMOOTH.items():
            signs = (way[-1], ahead[-1]) if kind == "fold" else (test(p.passage, free) for p in (one, other))
            met = np.prod(list(signs)) < 0
            if not met or (kind == "neimark-sacker" and not is_pair(other.passage, free)):
                continue
            there = self._located(kind, one, other)
            found.special.append((Condition(kind), there, float(there.z[-1])))

    def _located(self, kind: str, one: Point, other: Point) -> Point:
        free, span = self._system.free, np.abs(other.z - one.z)
        try:
            there = solve(Condition(kind).system(self._system, 1.0), 0.5 * (one.z + other.z))
            if np.all(np.abs(there.z - 0.5 * (one.z + other.z)) <= span + 1e-6 * np.abs(one.z)):
                return there
        except NotFound:
            pass
        return between(self._system, one, other, lambda passage: SMOOTH[kind](passage, free) > 0)[0]

    def _hopf_ahead(self, before: Point, point: Point):
        """Return the Hopf point at which shrinking orbits will end, or None."""
        sizes = np.array([ranges(p.passage)[0] for p in (before, point)])
        if not self._system.free or sizes[1] >= sizes[0] or sizes[1] > _SMALL * self._largest[0]:
            return None
        name = self._system.flow.parameters[0]
        return vanishing_point(self._scene, name, np.array([before.z[-1], point.z[-1]]), sizes)

    def _has_closed(self, found: Found, start: Point) -> bool:
        """Whether the walk is back at its start."""
        if len(found.points) < 20:
            return False
        gap = (found.points[-1].z - start.z) / self._units(start)
        return bool(abs(gap[-1]) < 1e-2 and np.linalg.norm(gap) < 0.5 * _LARGEST)

    def _moved(self, point: Point, way: np.ndarray) -> tuple[Point, np.ndarray]:
        """Return the same orbit with its start in the middle of its longest stretch without events, if one is near."""
        system, n = self._system, len(self._system.flow.states)
        start, period, values = system.unpack(point.z)
        times = np.array([e[0] for e in point.passage.events])
        near = np.any((times < _NEAR_START * period) | (times > (1 - _NEAR_START) * period))
        if not system.free or not near:
            return point, way
        edges = np.append(times, times[0] + period)
        k = int(np.argmax(np.diff(edges)))
        passage = system.flow.run(start, values, (edges[k] + 0.5 * (edges[k + 1] - edges[k])) % period)
        carried = passage.by_start @ way[:n] + passage.by_value @ way[n + 1 :]
        moved = solve(system, np.concatenate([passage.end, point.z[n:]]), np.append(np.zeros(n + 1), 1.0))
        return moved, self.tangent(moved, np.concatenate([carried, way[n:]]))
