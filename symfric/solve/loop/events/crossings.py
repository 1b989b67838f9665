"""Crossings of zero by expressions of the user; see `symfric.lower.crossings`.

An event changes the side. Where the expression is zero then, its guard is fresh: the next derivatives decide, and if it
returns it has crossed again, at the same instant. Where its own event made it jump back, that is no crossing; a jump at
another event is one, and happens at the time of that one.
"""

from symfric.codegen.numba_types import compiled
from symfric.lower.crossings import PAIR
from symfric.solve.loop.modes.tolerances import natural_time
from symfric.solve.loop.precision import EPS, LEAST_TERM
from symfric.solve.loop.stepping.calls import prelude
from symfric.solve.loop.workspace import LoopArrays

_ZERO = 1e-11  # value relative to the largest that counts as zero after an event


@compiled(inline=True)
def _side(w: LoopArrays, g: int) -> int:
    """Return the index in m of the side of a crossing whose first guard is g."""
    return w.m.size - (w.guards.hit.size - g) // PAIR


@compiled
def jumped_across(w: LoopArrays, n_x: int) -> bool:
    """Whether a crossing or a slider that was hit jumped across zero at an event of the same instant.

    A kick or an impact may turn the velocity over a slider that moves.
    """
    for g in range(w.limits.first_crossing, w.guards.hit.size):
        if _beyond(w, n_x, g, _size(w, n_x, g, w.c[n_x + g, 1])):
            return True
    for g in range(w.limits.first_other, w.limits.first_plane):
        if _beyond(w, n_x, g, max(w.scale[n_x + g], abs(w.c[n_x + g, 1]) * natural_time(w))):
            return True
    return False


@compiled(inline=True)
def _beyond(w: LoopArrays, n_x: int, g: int, size: float) -> bool:
    """Whether a guard that was hit, and was not near zero before, is below zero by more than rounding of its size."""
    return bool(w.guards.hit[g] and w.guards.fresh[g] == 0 and w.c[n_x + g, 0] < -_ZERO * size)


@compiled(inline=True)
def _size(w: LoopArrays, n_x: int, g: int, rate: float) -> float:
    """Return the size of an expression with the guard g."""
    first = w.limits.first_crossing + PAIR * ((g - w.limits.first_crossing) // PAIR)
    return max(w.scale[n_x + first], w.scale[n_x + first + 1], abs(rate) * natural_time(w))


@compiled
def cross(w: LoopArrays, n_x: int, starting: bool) -> bool:
    """Mark the guards of crossings that start at zero, and give those of a new run their sides.

    Return whether a reset leaves its guard at zero without a rate, and falling.
    """
    turned, stays = False, False
    for g in range(w.limits.first_crossing, w.guards.hit.size, PAIR):
        side = _side(w, g)
        sign = w.m[side]
        ahead = g if sign >= 0.0 else g + 1  # the guard in force
        value, rate, bend = w.probe[n_x + ahead, 0], w.probe[n_x + ahead, 1], w.probe[n_x + ahead, 2]
        size = _size(w, n_x, ahead, rate)
        zero = abs(value) <= _ZERO * size
        if w.guards.hit[g] or w.guards.hit[g + 1]:
            w.guards.fresh[g], w.guards.fresh[g + 1], w.guards.slack[g], w.guards.slack[g + 1] = 0, 0, 0.0, 0.0
            if zero:
                w.guards.fresh[ahead], w.guards.slack[ahead] = 1, max(8.0 * EPS * size, -2.0 * value)
                slow = abs(rate) <= 10.0 * LEAST_TERM * abs(bend) * w.clock.t_end
                stays = stays or (g >= w.limits.first_reset and sign < 0.0 and bend > 0.0 and slow)
            elif value < 0.0:
                w.m[side], turned = -sign, True
        elif starting and sign == 0.0:
            if zero:
                w.guards.fresh[g], w.guards.fresh[g + 1] = 1, 1
            else:
                w.m[side], turned = 1.0 if value > 0.0 else -1.0, True
        elif w.guards.fresh[ahead] == 0 or not zero:  # time has gone on, or it has jumped
            w.guards.fresh[ahead], w.guards.slack[ahead] = 0, 0.0
    if turned:
        prelude(w)
    return stays
