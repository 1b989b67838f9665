"""Where a branch of closed orbits changes its kind: what vanishes there, and how the point is found exactly."""

import itertools
from collections.abc import Callable
from dataclasses import replace

import numpy as np

from symfric.errors import NotFound
from symfric.lower.lift import GAPS
from symfric.orbits.cycle import multipliers_of
from symfric.orbits.flow import Flow, Passage
from symfric.orbits.shooting import Point, System, Test, ranges, solve

LIFTED = 1e3  # ranges of a slip, or bounds of a stick: no motion gets so far below a guard that is lifted
TOUCHES = ("stick-onset", "grazing")
_BISECTIONS = 60


def signature(passage: Passage) -> tuple[tuple[int, int, int], ...]:
    """Return the changes of mode in their cyclic order, beginning with the least."""
    changes = [(i, a, b) for _, i, a, b in passage.events]
    turns = [tuple(changes[k:] + changes[:k]) for k in range(len(changes))]
    return min(turns, default=())


def flip(passage: Passage, free: bool) -> float:
    """Return what vanishes where a nontrivial multiplier is -1."""
    return float(np.prod(1.0 + _others(passage, free)).real)


def fold(passage: Passage, free: bool) -> float:
    """Return what vanishes where a nontrivial multiplier is 1."""
    return float(np.prod(1.0 - _others(passage, free)).real)


def torus(passage: Passage, free: bool) -> float:
    """Return what vanishes where two nontrivial multipliers have the product 1: a pair on the unit circle."""
    pairs = itertools.combinations(_others(passage, free), 2)
    return float(np.prod([1.0 - a * b for a, b in pairs]).real)


SMOOTH: dict[str, Callable[[Passage, bool], float]] = {"fold": fold, "flip": flip, "neimark-sacker": torus}


def is_pair(passage: Passage, free: bool) -> bool:
    """Whether the pair of multipliers whose product is nearest to 1 is complex; a real one is a neutral saddle."""
    pairs = list(itertools.combinations(_others(passage, free), 2))
    nearest = min(pairs, key=lambda pair: abs(1.0 - pair[0] * pair[1]))
    return abs(np.imag(nearest[0])) > 0


def _others(passage: Passage, free: bool) -> np.ndarray:
    multipliers, trivial = multipliers_of(passage, free)
    return np.delete(multipliers, trivial) if trivial is not None else multipliers


def smooth_test(kind: str, free: bool) -> Test:
    """Return the equation that a fold, a flip or a Neimark-Sacker point obeys."""
    return Test(lambda passage: SMOOTH[kind](passage, free))


def gap_test(k: int, scale: float) -> Test:
    """Return the equation that guard k just touches zero; with the size of the guard as a unit."""

    def slopes(passage: Passage) -> tuple[np.ndarray, np.ndarray]:
        return passage.gaps_by_start[k] / scale, passage.gaps_by_value[k] / scale

    return Test(lambda passage: float(passage.gaps[k] / scale), slopes)


def lift_of(flow: Flow, k: int, scale: float) -> np.ndarray:
    """Return the lift that makes a motion ignore guard k of `Passage.gaps`."""
    contact, row = divmod(k, GAPS)
    lift = np.zeros(2 * len(flow.contacts))
    lift[2 * contact + (row > 0)] = LIFTED * scale
    return lift


def gap_scale(passage: Passage, k: int, flow: Flow) -> float:
    """Return a size of guard k: for a slip the range of the velocities, for a bound what is left at the most."""
    if k % GAPS == 0:
        n_q = len(flow.scene.system.q)
        return float(np.max(ranges(passage)[n_q : 2 * n_q]))
    return float(max(abs(passage.gaps[k]) if np.isfinite(passage.gaps[k]) else 0.0, 1.0))


def touch(system: System, untouched: Point, k: int) -> Point:
    """Find where guard k touches zero, near an orbit that it does not touch.

    Parameters
    ----------
    system : System
        With one parameter more than closed orbits need.
    untouched : Point
    k : int
        Of `Passage.gaps`.

    Raises
    ------
    NotFound
        If Newton's method does not converge, or the contact that touches has other events of the same kind.
    """
    scale = gap_scale(untouched.passage, k, system.flow)
    contact, row = divmod(k, GAPS)
    begins = [(a == 0) for _, i, a, _ in untouched.passage.events if i == contact]
    if (row == 0 and not all(begins)) or (row > 0 and any(begins)):
        raise NotFound("the guard has events elsewhere on the orbit, which cannot be told from the touch")
    found = solve(replace(system, test=gap_test(k, scale), lift=lift_of(system.flow, k, scale)), untouched.z)
    if signature(found.passage) != signature(untouched.passage):
        raise NotFound("the orbit that touches has other events than those near it")
    return found


def between(system: System, one: Point, other: Point, where: Callable[[Passage], bool]) -> tuple[Point, Point]:
    """Bisect along the branch for the place where a property of the orbits changes; return the orbits on both sides."""
    for _ in range(_BISECTIONS):
        chord = other.z - one.z
        size = np.max(np.abs(chord) / np.maximum(np.abs(one.z), 1e-9))
        if size < 1e-13:
            break
        try:
            middle = solve(system, one.z + 0.5 * chord, chord / np.linalg.norm(chord), most=12)
        except NotFound:
            break
        if where(middle.passage) == where(one.passage):
            one = middle
        else:
            other = middle
    return one, other
