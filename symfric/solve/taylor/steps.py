"""The length of a step, from the last coefficients of every row (Jorba and Zou, Experimental Mathematics 14, 2005)."""

import numpy as np
from numba import njit

from symfric.solve.native import INLINE, INNER
from symfric.solve.taylor.polynomials import FUSED
from symfric.solve.taylor.settle import EPS
from symfric.solve.taylor.workspace import CHECKED, H_LAST, TOLERANCE

_TINY = 1e-300  # a scale that is none


@njit(**INLINE, fastmath=FUSED)
def step_size(w, n_x):
    """Return the step at which the last two terms of every row fall below the tolerance; NaN if one is not finite."""
    order = w.c.shape[1] - 1
    tolerance, before = w.clock[TOLERANCE], w.clock[H_LAST]
    if before == 0.0:
        return _first_step(w)
    grain = EPS / tolerance
    worst, worst_below, late = 0.0, 0.0, False
    for r in range(w.c.shape[0]):
        a, b = abs(w.c[r, order]), abs(w.c[r, order - 1])
        if not (a < np.inf and b < np.inf):
            return np.nan
        if a == 0.0 and b == 0.0:
            continue
        scale = max(w.scale[r], abs(w.c[r, 1]) * before, grain * abs(w.c[r, 0]))
        if w.limits[CHECKED] and n_x <= r < n_x + w.hit.size and w.fresh[r - n_x] == 0:
            # near a singularity of a law its guard must be right relative to what is left of it
            scale = max(abs(w.c[r, 0]), abs(w.c[r, 1]) * before, grain * scale)
        if scale < _TINY:
            if _comes_late(w, r):
                late = True
                continue
            scale = _largest_term(w, r, before)
        inverse = 1.0 / scale
        worst = max(worst, a * inverse)
        worst_below = max(worst_below, b * inverse)
    if worst == 0.0 and worst_below == 0.0:
        return before if late else np.inf
    if not max(worst, worst_below) < np.inf:
        return np.nan
    limit = _log2(tolerance)
    return _exp2(min((limit - _log2(worst_below)) * (1.0 / (order - 1)), (limit - _log2(worst)) * (1.0 / order)))


@njit(**INLINE, fastmath=FUSED)
def _log2(x):
    """Return the logarithm of x >= 0, too small by up to 0.09: the bits of x. That of zero is finite.

    A root needs no more; with the C library's functions, the roots would take an eighth of the time of a run.
    """
    return np.float64(x).view(np.int64) * 2.0**-52 - 1023.0


@njit(**INLINE, fastmath=FUSED)
def _exp2(x):
    """Return 2^x, |x| < 1023, to 3 in a thousand: bits again, and a parabola between the powers of two."""
    whole = np.floor(x)
    rest = x - whole
    return np.int64((whole + 1023.0 + rest * (0.6565 + 0.3435 * rest)) * 2.0**52).view(np.float64)


@njit(**INLINE, fastmath=FUSED)
def _root(x, n):
    return _exp2(_log2(x) / n)


@njit(**INNER, fastmath=FUSED)
def _largest_term(w, r, h):
    largest, power = 0.0, 1.0
    for k in range(1, w.c.shape[1]):
        power *= h
        largest = max(largest, abs(w.c[r, k]) * power)
    return max(largest, _TINY)


@njit(**INNER, fastmath=FUSED)
def _comes_late(w, r):
    """Whether a row begins with a high power of time: a body that the motion reaches through many others.

    What it is on this step is nothing beside what it will be, and its series says nothing about the step.
    """
    return not np.any(w.c[r, : (w.c.shape[1] - 1) // 2 + 1])


@njit(**INNER, fastmath=FUSED)
def _first_step(w):
    """Return the first step, when no scale is known: the last terms are compared with the largest of their row."""
    order = w.c.shape[1] - 1
    tolerance = w.clock[TOLERANCE]
    h, late = np.inf, np.inf
    for r in range(w.c.shape[0]):
        own = np.inf
        for last in range(order - 1, order + 1):
            a = abs(w.c[r, last])
            if not a < np.inf:
                return np.nan
            if a == 0.0:
                continue
            reach = 0.0
            for k in range(1, last):
                if w.c[r, k] != 0.0:
                    reach = max(reach, _root(tolerance * abs(w.c[r, k]) / a, last - k))
            if reach == 0.0:
                reach = _root(tolerance * (abs(w.c[r, 0]) or 1.0) / a, last)
            own = min(own, reach)
        if _comes_late(w, r):
            late = min(late, own)
        else:
            h = min(h, own)
    return h if h < np.inf else late
