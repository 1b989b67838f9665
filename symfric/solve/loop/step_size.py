"""Step size from the last Taylor coefficients of every row (Jorba and Zou, Experimental Mathematics 14, 2005)."""

import numpy as np

from symfric.codegen.numba_types import compiled
from symfric.solve.loop.decay_weights import LONGEST, PREFERRED
from symfric.solve.loop.precision import EPS

_TINY = 1e-300  # scale that counts as zero
_SHORT = 1e-3  # first step without a limit by coefficients, relative to the run
_ONE = 2**52  # the number one in the fixed-point format of logarithms
_CUT = 22  # bits of a logarithm that are dropped before a multiplication
_PART = 2.0**20  # the number one in the fixed-point format of the reciprocal order
_INFINITE = 2047 * _ONE  # bits of infinity, and less than those of NaN
_NONE = -2047 * _ONE  # less than any logarithm
_MOST = 1023 << 30


@compiled(inline=True)
def step_rule(w):
    """Return the constants of `step_size` for a tolerance and order."""
    order, limit = w.c.shape[1] - 1, _logarithm(w.clock.tolerance)
    return EPS / w.clock.tolerance, limit, limit, np.int64(_PART / order), np.int64(_PART / (order - 1))


@compiled(inline=True)
def weighted_rule(w):
    """Return the constants of `weighted_size`: the error is a part of the first two coefficients that have weights."""
    last, tolerance = w.limits.exact + 2, w.clock.tolerance
    if w.limits.exact == 0:
        return step_rule(w)
    limit = _logarithm(tolerance / (1.0 - w.damping[last]))
    below = _logarithm(tolerance / (1.0 - w.damping[last - 1]))
    return EPS / tolerance, limit, below, np.int64(_PART / last), np.int64(_PART / (last - 1))


@compiled(inline=True, fused=True)
def step_size(w, n_x, rule):
    """Return the step at which the last two terms of every row fall below the tolerance; NaN if one is not finite.

    Terms are compared by their logarithms, in fixed point: see `_bits`.
    """
    if w.clock.h_last == 0.0:
        return _first_step(w)
    return _size(w, n_x, w.c.shape[1] - 1, rule)


@compiled(inline=False, fused=True)
def weighted_size(w, n_x, h, rule):
    """Return a longer step than h with weighted coefficients if fast decays limit h, else h.

    See `symfric.solve.loop.decay_weights`.
    """
    if w.clock.h_last == 0.0:
        return h
    longer = _size(w, n_x, w.limits.exact + 2, rule)
    if not longer > PREFERRED * h:  # or one of them is not finite
        return h
    for r in range(w.c.shape[0]):
        for k in range(w.limits.exact + 1, w.c.shape[1]):
            w.c[r, k] *= w.damping[k]
    return min(longer, LONGEST * h)


@compiled(inline=True, fused=True)
def _size(w, n_x, order, rule):
    """Return the step at which the terms of an order and of the one below are within their limits."""
    before = w.clock.h_last
    grain, limit, limit_below, root, root_below = rule
    worst, worst_below, late = _NONE, _NONE, False
    for r in range(w.c.shape[0]):
        a, b = _bits(abs(w.c[r, order])), _bits(abs(w.c[r, order - 1]))
        if max(a, b) >= _INFINITE:
            return np.nan
        if max(a, b) == 0:
            continue
        scale = max(w.scale[r], abs(w.c[r, 1]) * before, grain * abs(w.c[r, 0]))
        if w.limits.checked and n_x <= r < n_x + w.hit.size and w.fresh[r - n_x] == 0:
            # near a singularity of a law its guard must be accurate relative to its own value
            scale = max(abs(w.c[r, 0]), abs(w.c[r, 1]) * before, grain * scale)
        if scale < _TINY:
            if _comes_late(w, r):
                late = True
                continue
            scale = _largest_term(w, r, before)
        size = _bits(scale)
        worst = max(worst, a - size)
        worst_below = max(worst_below, b - size)
    if max(worst, worst_below) == _NONE:
        return before if late else np.inf
    if max(worst, worst_below) >= 1024 * _ONE:
        return np.nan
    return _exp2(min((limit - (worst >> _CUT)) * root, (limit_below - (worst_below >> _CUT)) * root_below) >> 20)


@compiled(inline=True)
def _logarithm(x):
    """Return log2 x in the fixed-point format."""
    return (_bits(x) - 1023 * _ONE) >> _CUT


@compiled(inline=True)
def _bits(x):
    """Return the bits of x >= 0: 2^52 (1023 + log2 x), too small by up to 0.09 x 2^52.

    This error is negligible after a root of the series' order. With logarithms and powers of the C library, the length
    of a step would take an eighth of the time of a run; converted between integers and floats, a twelfth.
    """
    return np.float64(x).view(np.int64)


@compiled(inline=True, fused=True)
def _exp2(x):
    """Return 2^(x 2^-30), to 3 in a thousand: bits again, and a parabola between the powers of two."""
    x = min(x, _MOST)
    whole = np.int64(((x >> 30) + 1023) << 52).view(np.float64)
    part = np.int64((1023 << 52) | ((x & (2**30 - 1)) << _CUT)).view(np.float64)  # mantissa from 1 to 2
    return whole * (0.6870 + part * (part * 0.3435 - 0.0305))


@compiled(inline=True, fused=True)
def _log_of_root(x, n):
    """Return the logarithm of the root of order n, as `_exp2` takes it; a float division of integers of 42 bits."""
    return np.int64(np.floor(((_bits(x) - 1023 * _ONE) >> _CUT) / n))


@compiled(fused=True)
def _largest_term(w, r, h):
    largest, power = 0.0, 1.0
    for k in range(1, w.c.shape[1]):
        power *= h
        largest = max(largest, abs(w.c[r, k]) * power)
    return max(largest, _TINY)


@compiled(fused=True)
def _comes_late(w, r):
    """Whether a row starts with a high power of time, as for a body far along a chain from the moving one.

    Its values on this step are negligible compared with later ones, and do not limit the step.
    """
    return not np.any(w.c[r, : (w.c.shape[1] - 1) // 2 + 1])


@compiled(fused=True)
def _first_step(w):
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
            own = min(own, _exp2(longest) if longest != _NONE else _SHORT * w.clock.t_end)
        if _comes_late(w, r):
            late = min(late, own)
        else:
            h = min(h, own)
    return h if h < np.inf else late
