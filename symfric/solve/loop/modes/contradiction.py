"""Contradiction between the modes of contacts and their forces, for mode selection."""

import numpy as np

from symfric.codegen.numba_types import compiled
from symfric.lower.constraint_forces import AT_BOUND, FOLLOWS, HOLDS, SHARES
from symfric.solve.loop import arithmetic
from symfric.solve.loop.codes import PULL
from symfric.solve.loop.modes.layout import backward, forward
from symfric.solve.loop.modes.tolerances import doubt_of, instant, natural_time, no_acceleration
from symfric.solve.loop.precision import EPS, ROUNDING, TIE
from symfric.solve.loop.workspace import LoopArrays

_SOON = 1e-9  # time in which a reserve is used up at once, in natural times
_CLEARLY = 1e3  # slip after a natural time, in units of its zero, that counts as motion


@compiled
def contradiction(w: LoopArrays, n_x: int, i: int, horizon: float) -> tuple[float, int]:
    """Return the contradiction of contact i, and the direction in which it would slip.

    If both stick and slip contradict the forces, up to rounding, both have been tried: then stick is selected if its
    force falls below its bound again, else slip.
    """
    size, where = contradicts(w, n_x, i, horizon)
    if size > 0.0:
        tie, turns = tie_of(w, n_x, i, where)
        if size <= tie and w.selection.turns[i] >= turns:
            return 0.0, 0  # both modes are admissible
    return size, where


@compiled
def tie_of(w: LoopArrays, n_x: int, i: int, where: int) -> tuple[float, int]:
    """Return the largest contradiction of contact i that is rounding, and how many of these tell that it is a tie."""
    if w.m[i] != HOLDS and w.m[i] != SHARES:
        return TIE, 3
    row = n_x + (forward(i) if where > 0 else backward(i))
    if w.probe[row, 1] > 0.0:  # falls below its bound again: no slip would last
        return max(TIE, 16.0 * doubt_of(w, i) / stick_scale(w, n_x + backward(i))), 2
    return TIE, 4


@compiled(inline=True)
def contradicts(w: LoopArrays, n_x: int, i: int, horizon: float) -> tuple[float, int]:
    """Return the contradiction without the rule for ties."""
    if not w.selection.zero[i]:
        return 0.0, 0
    if w.m[i] == FOLLOWS or w.m[i] == AT_BOUND:
        return _drift(w, n_x + backward(i), i)
    if w.m[i] > 0.5:
        return _excess(w, n_x + backward(i), doubt_of(w, i))
    return _backing(w, n_x + backward(i), i, horizon), 0


@compiled(inline=True)
def idles(w: LoopArrays, row: int) -> bool:
    """Whether a starting slip has no acceleration, also not later."""
    return w.probe[row, 1] == 0.0 and w.probe[row, 2] == 0.0 and w.probe[row, 3] == 0.0


@compiled
def rests(w: LoopArrays, row: int, i: int) -> bool:
    """Whether a starting slip has no acceleration, up to rounding."""
    later = 6.0 * abs(w.probe[row, 3]) * natural_time(w) ** 2
    return _drift(w, row, i)[0] == 0.0 and later <= _CLEARLY * no_acceleration(w, i, 0.0)


@compiled(inline=True)
def stick_scale(w: LoopArrays, row: int) -> float:
    """Return the bound of a sticking contact plus the magnitude of its force, from its guards."""
    return arithmetic.stick_scale(w.probe[row, 0], w.probe[row + 1, 0])


@compiled
def at_bound(w: LoopArrays, row: int, scale: float) -> bool:
    """Whether the reserve of a sticking contact is zero up to rounding, and not used up later, at a time that is known.

    A force that grows slowly, as that of an integrator near its target, may take long for what is a rounding error of
    its bound.
    """
    g, slope = w.probe[row, 0], w.probe[row, 1]
    later = slope < 0.0 and g > 4.0 * EPS * scale and g > -slope * _SOON * natural_time(w)
    return g <= ROUNDING * scale and not later


@compiled(inline=True)
def tied(w: LoopArrays, slope: float, scale: float) -> bool:
    """Whether a contact at its bound may stay there: its force grows by less than counts within a natural time.

    Slip would have no acceleration that could be told from rounding; it begins when the excess can be.
    """
    return slope * natural_time(w) >= -TIE * scale


@compiled(inline=True)
def _excess(w: LoopArrays, row: int, doubt: float) -> tuple[float, int]:
    """Return the relative excess of a sticking contact over its bound, now or soon, and the direction of its slip.

    Both sides may be at the bound to rounding, where it is far below the forces that cancel: then the side that falls.
    An excess that ends within the rounding of time does not count: that of a load which returns from zero, missed by as
    much. An infinite slope, that of another contact's law at rest, tells nothing of when it ends.
    """
    scale = stick_scale(w, row)
    side = 0 if w.probe[row, 0] < w.probe[row + 1, 0] else 1
    g, slope = w.probe[row + side, 0], w.probe[row + side, 1]
    if g < -doubt and (-g > slope * instant(w) or not slope < np.inf):
        return -g / scale, 2 * side - 1
    for _ in range(2):
        slope = w.probe[row + side, 1]
        if at_bound(w, row + side, scale) and not tied(w, slope, scale):
            return 0.5 * TIE, 2 * side - 1
        side = 1 - side
    return 0.0, 0


@compiled(inline=True)
def _drift(w: LoopArrays, row: int, i: int) -> tuple[float, int]:
    """Return by how much a contact with a given force starts to slip, and in which direction.

    More than anything else may contradict: what others have to hold is known only with its friction.
    """
    rate, pull, little = w.probe[row, 1], w.gauge[PULL, i], no_acceleration(w, i, 0.0)
    if abs(rate) <= little:
        rate = w.probe[row, 2] * natural_time(w)
        if abs(rate) <= _CLEARLY * little:
            return 0.0, 0
    return 1.0 + abs(rate) / (abs(rate) + pull), 1 if rate > 0.0 else -1


@compiled(inline=True)
def _backing(w: LoopArrays, row: int, i: int, horizon: float) -> float:
    """Return the acceleration of a slipping contact in the wrong direction, relative to that by static friction."""
    first, second, pull = w.probe[row, 1], w.probe[row, 2], w.gauge[PULL, i]
    little = no_acceleration(w, i, second if abs(second) < np.inf else 0.0)  # a law may have an infinite slope at rest
    if first < -little:
        return -first / (pull - first)
    if first <= little and second * horizon < -no_acceleration(w, i, 0.0):
        return 0.5 * TIE
    return 0.0


@compiled(inline=True)
def worst_contact(w: LoopArrays, n_x: int, n_c: int, horizon: float, least: bool) -> tuple[int, int, float]:
    """Return the contact whose mode contradicts its forces most, or the first one; its side, and by how much.

    The contact is -1 if there is none.
    """
    worst, measure, side = -1, 0.0, 0
    for i in range(n_c):
        size, where = contradiction(w, n_x, i, horizon)
        if size > measure:
            worst, measure, side = i, size, where
            if least:
                break
    return worst, side, measure
