"""Step size from the last Taylor coefficients of every row (Jorba and Zou, Experimental Mathematics 14, 2005)."""

from typing import Any

import numpy as np

from symfric.codegen.elementwise import bits_of
from symfric.codegen.numba_types import compiled
from symfric.solve.loop.arithmetic import largest_of_row, logarithm, power_of_two
from symfric.solve.loop.modes.layout import backward, contact_of, is_slip
from symfric.solve.loop.precision import EPS, TINY
from symfric.solve.loop.statements import CUT, INFINITE, ONE, PART
from symfric.solve.loop.stepping.decay_weights import LONGEST, PREFERRED
from symfric.solve.loop.workspace import LoopArrays

_SHORT = 1e-3  # first step without a limit by coefficients, relative to the run
_HUGE, _FEWEST = 1e250, 6  # coefficients that count as overflow, and the least order that is left without them
_NONE = -2047 * ONE  # less than any logarithm

Rule = tuple[float, Any, Any, Any, Any]  # see `step_rule`


@compiled(inline=True)
def step_rule(w: LoopArrays) -> Rule:
    """Return the constants of `step_size` for a tolerance and order."""
    order, limit = w.c.shape[1] - 1, logarithm(w.clock.tolerance)
    return EPS / w.clock.tolerance, limit, limit, np.int64(PART / order), np.int64(PART / (order - 1))


@compiled(inline=True)
def weighted_rule(w: LoopArrays) -> Rule:
    """Return the constants of `weighted_size`: the error is a part of the first two coefficients that have weights."""
    last, tolerance = w.limits.exact + 2, w.clock.tolerance
    if w.limits.exact == 0:
        return step_rule(w)
    limit = logarithm(tolerance / (1.0 - w.tables.damping[last]))
    below = logarithm(tolerance / (1.0 - w.tables.damping[last - 1]))
    return EPS / tolerance, limit, below, np.int64(PART / last), np.int64(PART / (last - 1))


@compiled(inline=True, fused=True)
def step_size(w: LoopArrays, n_x: int, rule: Rule) -> float:
    """Return the step at which the last two terms of every row fall below the tolerance; NaN if one is not finite.

    Terms are compared by their logarithms, in fixed point: see `logarithm`.
    """
    if w.clock.h_last == 0.0:
        return _first_step(w)
    return _size(w, n_x, w.c.shape[1] - 1, rule)


@compiled(inline=False, fused=True)
def truncated_size(w: LoopArrays, n_x: int) -> float:
    """Return the step of the terms that are no overflow, without the others; NaN if these are too few.

    So short a time to the next singularity of a slip vector has powers beyond the range of numbers.
    """
    order = w.c.shape[1] - 1
    for r in range(w.c.shape[0]):
        for k in range(order + 1):
            if not abs(w.c[r, k]) < _HUGE:
                order = k - 1
                break
    if order < _FEWEST:
        return np.nan
    for r in range(w.c.shape[0]):
        for k in range(order + 1, w.c.shape[1]):
            w.c[r, k] = 0.0
    limit = logarithm(w.clock.tolerance)
    rule = (EPS / w.clock.tolerance, limit, limit, np.int64(PART / order), np.int64(PART / (order - 1)))
    return _size(w, n_x, order, rule)


@compiled(inline=False, fused=True)
def weighted_size(w: LoopArrays, n_x: int, h: float, rule: Rule) -> float:
    """Return a longer step than h with weighted coefficients if fast decays limit h, else h.

    See `symfric.solve.loop.stepping.decay_weights`.
    """
    if w.clock.h_last == 0.0:
        return h
    longer = _size(w, n_x, w.limits.exact + 2, rule)
    if not longer > PREFERRED * h:  # or one of them is not finite
        return h
    for r in range(w.c.shape[0]):
        for k in range(w.limits.exact + 1, w.c.shape[1]):
            w.c[r, k] *= w.tables.damping[k]
    return min(longer, LONGEST * h)


@compiled(inline=True, fused=True)
def _size(w: LoopArrays, n_x: int, order: int, rule: Rule) -> float:
    """Return the step at which the terms of an order and of the one below are within their limits."""
    before = w.clock.h_last
    grain, limit, limit_below, root, root_below = rule
    worst, worst_below, late = _NONE, _NONE, False
    for r in range(w.c.shape[0]):
        a, b = bits_of(abs(w.c[r, order])), bits_of(abs(w.c[r, order - 1]))
        if max(a, b) >= INFINITE:
            return np.nan
        if max(a, b) == 0:
            continue
        scale = largest_of_row(w.scale[r], w.c[r, 1], before, grain, abs(w.c[r, 0]))
        if w.limits.checked and n_x <= r < n_x + w.guards.hit.size and w.guards.fresh[r - n_x] == 0:
            # near a singularity of a law its guard must be accurate relative to its own value
            scale = largest_of_row(abs(w.c[r, 0]), w.c[r, 1], before, grain, scale)
        if w.limits.planes and _is_speed(w, r - n_x):
            scale = abs(w.c[r, 0])  # near zero a slip vector turns fast
        if scale < TINY:
            if _comes_late(w, r):
                late = True
                continue
            scale = _largest_term(w, r, before)
        size = bits_of(scale)
        worst = max(worst, a - size)
        worst_below = max(worst_below, b - size)
    if max(worst, worst_below) == _NONE:
        return before if late else np.inf
    if max(worst, worst_below) >= 1024 * ONE:
        return np.nan
    return power_of_two(min((limit - (worst >> CUT)) * root, (limit_below - (worst_below >> CUT)) * root_below) >> 20)


@compiled(inline=True)
def _is_speed(w: LoopArrays, g: int) -> bool:
    """Whether a guard is the speed of a contact that slips in the plane."""
    if not (0 <= g < backward(w.contacts.sticks.size) and is_slip(g)):
        return False
    return w.contacts.partner[contact_of(g)] > contact_of(g) and w.m[contact_of(g)] == 0.0


@compiled(inline=True, fused=True)
def _log_of_root(x: float, n: int) -> Any:
    """Return the logarithm of the root of order n for `power_of_two`; a float division of integers of 42 bits."""
    return np.int64(np.floor(logarithm(x) / n))


@compiled(fused=True)
def _largest_term(w: LoopArrays, r: int, h: float) -> float:
    largest, power = 0.0, 1.0
    for k in range(1, w.c.shape[1]):
        power *= h
        largest = max(largest, abs(w.c[r, k]) * power)
    return max(largest, TINY)


@compiled(fused=True)
def _comes_late(w: LoopArrays, r: int) -> bool:
    """Whether a row starts with a high power of time, as for a body far along a chain from the moving one.

    Its values on this step are negligible compared with later ones, and do not limit the step.
    """
    return not np.any(w.c[r, : (w.c.shape[1] - 1) // 2 + 1])


@compiled(fused=True)
def _first_step(w: LoopArrays) -> float:
    """Return the first step, without known scales: the last terms are compared with the largest of their row.

    For a row with only every third or fourth term, the last nonzero terms are used.
    """
    order = w.c.shape[1] - 1
    tolerance = w.clock.tolerance
    h, late = np.inf, np.inf
    for r in range(w.c.shape[0]):
        own, end = np.inf, order
        while end > order // 2 and w.c[r, end] == 0.0 and w.c[r, end - 1] == 0.0:
            end -= 1
        for last in range(end - 1, end + 1):
            a = abs(w.c[r, last])
            if not a < np.inf:
                return np.nan
            if a == 0.0:
                continue
            longest = _NONE
            for k in range(1, last):
                if w.c[r, k] != 0.0:
                    longest = max(longest, _log_of_root(tolerance * abs(w.c[r, k]) / a, last - k))
            if longest == _NONE and w.c[r, 0] != 0.0:
                longest = _log_of_root(tolerance * abs(w.c[r, 0]) / a, last)
            # if no scale is known: a fraction of the run
            own = min(own, power_of_two(longest) if longest != _NONE else _SHORT * w.clock.t_end)
        if _comes_late(w, r):
            late = min(late, own)
        else:
            h = min(h, own)
    return h if h < np.inf else late
