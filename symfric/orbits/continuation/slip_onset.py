"""Where the slider of a contact behind a spring begins to slip; on one side of the point it sticks all the time.

The force of a slider that never slips ranges over less than its two limits, and its mean is free. What the elongation
has left, ``2 L/k`` less its range, is smooth along the branch on this side and zero at the point; on the other side it
is zero throughout, so that the point is approached from the side that sticks.
"""

from collections.abc import Callable, Mapping
from typing import NamedTuple

import numpy as np
import sympy as sp

from symfric.errors import NotFound
from symfric.orbits.continuation.arclength import tangent
from symfric.orbits.continuation.bifurcations import Condition
from symfric.orbits.flow_map import FlowMap
from symfric.orbits.passages import Passage
from symfric.orbits.shooting import Point, ShootingSystem, solve, step_of

KIND = "slip-onset"
_TRIALS, _CLOSE = 60, 1e-13  # most orbits, and width relative to the unknowns at which the search ends
# of the range over which the slider sticks: below which it counts as slipping, what the search aims at, and accepts
_REACHED, _AIM, _ENOUGH = 1e-12, 1e-11, 3e-11
_LENGTHS = (1e-5, 1e-4, 1e-3, 1e-2)  # distances, in spans of the parameter, at which an orbit beyond an onset is sought
_NEAR = 0.01  # largest distance of the onset from the last orbit of a walk, in units of the unknowns


class SlipOnset(NamedTuple):
    """An orbit on which a slider just reaches both limits, and its condition."""

    condition: Condition
    point: Point


# the range of the elongation over which a slider sticks, from parameter values; None if the load varies
Widest = Callable[[Mapping[str, float]], float] | None


def widest_ranges(flow: FlowMap) -> dict[int, Widest]:
    """Return for every spring of a contact, by its place among the states, over what range its slider sticks."""
    return {place: _widest(flow, place) for place in flow.springs}


def slip_onsets(system: ShootingSystem, springs: Mapping[int, Widest], one: Point, other: Point) -> list[SlipOnset]:
    """Return the onsets of slip between two orbits of a branch, in order from one to the other."""
    onsets = []
    for place, widest in springs.items():
        spring = _Spring(system, place, widest)
        ways = spring.sticks(one), spring.sticks(other)
        if ways[0] != ways[1]:
            stuck, slips = (one, other) if ways[0] else (other, one)
            onsets.append(SlipOnset(Condition(KIND, spring=place), spring.onset(stuck, slips)))
    chord = other.z - one.z
    return sorted(onsets, key=lambda onset: float((onset.point.z - one.z) @ chord))


def across_onset(
    system: ShootingSystem, springs: Mapping[int, Widest], point: Point, way: np.ndarray, size: np.ndarray
) -> Point | None:
    """Return an orbit just beyond the onset of slip at which a walk has stopped; None if there is none.

    The slip begins like a root there, so that no step along the branch may lead across.

    Parameters
    ----------
    system : ShootingSystem
    springs : mapping of int to Widest
        Of the contacts, see `widest_ranges`.
    point : Point
        The last orbit.
    way : ndarray, shape (n_z,)
        Direction of the walk.
    size : ndarray, shape (n_z,)
        Units of the unknowns.
    """
    alone = np.append(np.zeros(point.z.size - 1), 1.0)
    ahead = 1.0 if way[-1] >= 0 else -1.0
    for place, widest in springs.items():
        spring = _Spring(system, place, widest)
        sticks = spring.sticks(point)
        if sticks and spring.left(point) > _NEAR:
            continue
        for distance in (sign * length * size[-1] for length in _LENGTHS for sign in (ahead, -ahead)):
            through = point.z + distance * alone
            try:
                beyond = solve(system, spring.centred(through, point), alone, through=through)
            except NotFound:
                continue
            if spring.sticks(beyond) == sticks:
                continue
            onset = spring.onset(*((point, beyond) if sticks else (beyond, point)))
            if np.max(np.abs((onset.z - point.z) / size)[_not_free(system, point.z.size)]) < _NEAR:
                return beyond
    return None


def _not_free(system: ShootingSystem, n_z: int) -> np.ndarray:
    """Return which unknowns are not elongations of springs, the means of which are free while they stick."""
    kept = np.ones(n_z, dtype=bool)
    kept[list(system.flow.springs)] = False
    return kept


def passes_the_start(one: Passage, other: Passage) -> bool:
    """Whether an event passes from the end of the period to its start, or back.

    The state at the start then moves with another rate along the branch: a corner of the unknowns that is none of the
    branch.
    """
    a, b = ([e[1:] for e in passage.changes] for passage in (one, other))
    return a != b and len(a) == len(b) and any(a[k:] + a[:k] == b for k in range(1, len(a)))


class _Spring(NamedTuple):
    """One spring along a branch."""

    system: ShootingSystem
    place: int
    widest: Widest

    def left(self, point: Point) -> float:
        """Return the reserve of the elongation, relative to the range over which the slider sticks; NaN if unknown."""
        if self.widest is None:
            return np.nan
        most = self.widest(self.system.unpack(point.z)[2])
        return 1.0 - float(point.passage.high[self.place] - point.passage.low[self.place]) / most if most > 0 else 0.0

    def sticks(self, point: Point) -> bool:
        """Whether the slider sticks all the time; an orbit may touch one of its limits, where rounding decides."""
        left = self.left(point)
        return self.place in point.passage.idle if np.isnan(left) else left > _REACHED

    def centred(self, guess: np.ndarray, near: Point) -> np.ndarray:
        """Return a guess whose elongation is that of an orbit nearby, with its mean between the limits.

        The mean of a slider that sticks is free, and near the onset only this one is possible.
        """
        centred, n = guess.copy(), self.system.flow.springs[self.place].size
        for k in {*near.passage.idle, self.place}:
            centred[k] = near.z[k] + self.system.flow.springs[k] @ (guess[:n] - near.z[:n])
        return centred - self.mean(near) * self.shift(near)

    def mean(self, point: Point) -> float:
        """Return the mean between the extremes of the elongation; zero if these may not be symmetric."""
        low, high = point.passage.low[self.place], point.passage.high[self.place]
        return 0.0 if self.widest is None else 0.5 * float(low + high)

    def shift(self, point: Point) -> np.ndarray:
        """Return how the unknowns change with the mean elongation, at the same parameter, (n_z,)."""
        alone, change = np.zeros(point.z.size), np.zeros(point.rest.size)
        alone[self.place] = 1.0
        if self.place in point.passage.idle:  # the orbit as a whole moves with it
            change[self.place] = 1.0
            whole = step_of(self.system, point, change, np.append(np.zeros(point.z.size - 1), 1.0))
            if np.isfinite(whole[self.place]) and whole[self.place] != 0.0:
                return np.asarray(whole / whole[self.place])
        return alone

    def onset(self, stuck: Point, slips: Point) -> Point:
        """Return the orbit at the onset, by secants on the side that sticks, bracketed by orbits that slip.

        Where no orbit is found the guess may have slipped, so the next one is sought nearer by; that an orbit slips
        there, and none sticks, is known if the range over which the slider sticks is not.
        """
        chord = slips.z - stuck.z
        size = np.maximum(np.abs(stuck.z), self.system.sizes(stuck.z, stuck.passage))
        normal = chord / size**2
        normal[list(self.system.flow.springs)] = 0.0  # so that free elongations do not move the planes
        low, high, reach, best = 0.0, 1.0, 1.0, self._in_the_middle(stuck, stuck, normal)
        known = [(0.0, self.left(best))]
        for _ in range(_TRIALS):
            if known[-1][1] <= _ENOUGH or (reach - low) * np.max(np.abs(chord) / size) < _CLOSE:
                break
            share = _secant(known)
            if not low < share < reach:
                share = 0.5 * (low + reach)
            through = stuck.z + share * chord
            try:
                guess = self._along(best, through, normal, size)
                middle = solve(self.system, self.centred(guess, best), normal, 12, through)
                middle = self._in_the_middle(middle, best, normal)
            except NotFound:
                reach = share
                continue
            if self.sticks(middle):
                low, reach, best = share, high, middle
                known.append((share, self.left(middle)))
            else:
                high = reach = share
        return best

    def _in_the_middle(self, point: Point, near: Point, normal: np.ndarray) -> Point:
        """Return an orbit that sticks with its mean elongation between the limits, of which it may touch one."""
        if not self.sticks(point) or (self.place in point.passage.idle and point is not near):
            return point
        guess = point.z - self.mean(point) * self.shift(near)
        try:
            middle = solve(self.system, guess, normal, 12, point.z)
        except NotFound:
            return point
        return middle if self.sticks(middle) else point

    def _along(self, best: Point, through: np.ndarray, normal: np.ndarray, size: np.ndarray) -> np.ndarray:
        """Return where the tangent at an orbit meets a plane."""
        way = tangent(self.system, best, size, through - best.z)
        across = float(normal @ way)
        return best.z + float(normal @ (through - best.z)) / across * way if across else through


def _secant(known: list[tuple[float, float]]) -> float:
    """Return where the last two values lead to what is aimed at; NaN if they do not."""
    if len(known) < 2:
        return np.nan
    (a, before), (b, after) = known[-2:]
    return b + (after - _AIM) * (b - a) / (before - after) if before != after else np.nan


def _widest(flow: FlowMap, place: int) -> Widest:
    """Return over what range of its elongation a slider sticks."""
    scene = flow.scene
    symbol = scene.system.states[place]
    contact = next(c for c in scene.contacts if symbol in c.states)
    memory = contact.law.memory
    if memory is not None and memory.limits:
        widest = 2 * memory.limits[contact.states.index(symbol)]
    elif contact.stiffness is not None:
        widest = 2 * contact.normal * contact.profile * contact.law.stick / contact.stiffness
    else:
        return None
    if not widest.free_symbols <= set(scene.parameters):
        return None
    names = sorted(s.name for s in widest.free_symbols)
    known = [sp.Symbol(f"x{k}") for k in range(len(names))]  # which Python takes as names
    value = sp.lambdify(known, widest.xreplace({s: known[names.index(s.name)] for s in widest.free_symbols}))
    return lambda values: float(value(*(values[name] for name in names)))
