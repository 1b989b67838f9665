"""Roots and extrema of polynomials on an interval, with guaranteed detection.

A polynomial is a row of coefficients ``b[0..n]``. Its Bernstein coefficients have at least as many changes of sign as
it has roots, by the variation-diminishing property (Lane and Riesenfeld, Bounds on a polynomial, BIT 21 (1981) 112):
without one there is no crossing, and with one a single root. With more, as before a graze, a first crossing is
approached from below in steps that cannot pass it; where these get short, subdivision decides. Sampling signs would
miss a guard that dips below zero and returns within a step.
"""

import numpy as np

from symfric.codegen.array_table import VECTOR, Cube, Matrix, Reals
from symfric.codegen.numba_types import compiled, signs_of_sums
from symfric.solve.loop.arithmetic import value, value_and_slope
from symfric.solve.loop.precision import HALF_OF_DIGITS, LAST_STEP, MARCHES


@compiled(fused=True, from_python=True)
def polish(b: Reals, n: int, lo: float, hi: float, f_lo: float, f_hi: float) -> float:
    """Refine the only root between lo and hi, with values f_lo and f_hi of opposite signs there."""
    s = 0.5 * (lo + hi)  # used if an end may be a root itself, as after subdivision
    if min(abs(f_lo), abs(f_hi)) > 1e-6 * max(abs(f_lo), abs(f_hi)):
        s = lo + (hi - lo) * (f_lo / (f_lo - f_hi))
    for _ in range(100):
        if not lo < s < hi:
            s = 0.5 * (lo + hi)
            if not lo < s < hi:
                break
        f = b[n]
        slope = 0.0
        for k in range(n - 1, -1, -1):
            slope = slope * s + f
            f = f * s + b[k]
        if (f >= 0.0) == (f_lo >= 0.0):
            lo = s
        else:
            hi = s
        new = s - f / slope if slope != 0.0 else 0.5 * (lo + hi)
        if lo <= new <= hi and abs(new - s) <= 1e-9 * s:  # converged: the next step is about the square of this one
            return new
        s = new
    return hi


@compiled(inline=True, fused=False, ieee_division=True, from_python=True)
def _guess(first: float, last: float, slope: float) -> float:
    """Return the root between 0 and 1 of the parabola with these ends and this slope at 0."""
    bend = (last - first) - slope
    root = np.sqrt(max(slope * slope - 4.0 * (first * bend), 0.0))
    return 2.0 * abs(first) / (root + (slope if first < 0.0 else -slope))


@compiled(fused=True, from_python=True)
def _summit(b: Reals, n: int, first: float, last: float) -> tuple[float, float]:
    """Return place and value of the extremum of b in (0, 1) whose slope has these values of different signs there.

    Half of the digits of the place are all of those of the extremum: a step of Newton's method that changes no more is
    not taken, but what it adds to the value is.
    """
    lo, hi = 0.0, 1.0
    s = _guess(first, last, 2.0 * b[2])
    f = b[0]
    for _ in range(100):
        if not lo < s < hi:
            s = 0.5 * (lo + hi)
        f, slope, curve = b[n], 0.0, 0.0
        for k in range(n - 1, -1, -1):
            curve = curve * s + slope
            slope = slope * s + f
            f = f * s + b[k]
        curve = 2.0 * curve
        if (slope >= 0.0) == (first >= 0.0):
            lo = s
        else:
            hi = s
        new = s - slope / curve if curve != 0.0 else 0.5 * (lo + hi)
        if lo <= new <= hi and abs(new - s) <= HALF_OF_DIGITS:
            return s, f + 0.5 * slope * (new - s)
        if not lo < new < hi:
            new = 0.5 * (lo + hi)
            if not lo < new < hi:
                break
        s = new
    return s, f


@compiled(fused=True, from_python=True)
def roots(b: Reals, n: int, most: int, table: Cube, stack: Matrix, places: Reals) -> int:
    """Find the first `most` sign changes of b in (0, 1], a zero counting as positive.

    Parameters
    ----------
    b : ndarray
        Coefficients, at least n + 1.
    n : int
        Degree.
    most : int
        Stop after so many.
    table : ndarray
        From `symfric.solve.loop.events.bernstein`.
    stack : ndarray, shape (`DEPTH` + 2, order + 3)
        Work space.
    places : ndarray
        Receives the roots, increasing.

    Returns
    -------
    int
        How many were found. A root of even multiplicity is no sign change and is not reported.
    """
    while n > 1 and b[n] == 0.0:
        n -= 1
    for j in range(n + 1):
        r = 0.0
        for k in range(j + 1):
            r += table[n, j, k] * b[k]
        stack[0, j] = r
    stack[0, n + 1] = 0.0
    stack[0, n + 2] = 1.0
    top, count = 0, 0
    while top >= 0:
        c = stack[top]
        lo, hi = c[n + 1], c[n + 2]
        changes = 0
        for j in range(1, n + 1):
            if (c[j] >= 0.0) != (c[j - 1] >= 0.0):
                changes += 1
        top -= 1
        if changes == 0:
            continue
        if changes == 1:
            places[count] = polish(b, n, lo, hi, c[0], c[n])
            count += 1
            if count == most:
                return count
            continue
        if hi - lo < 4.5e-16:
            if (c[0] >= 0.0) != (c[n] >= 0.0):
                places[count] = hi
                count += 1
                if count == most:
                    return count
            continue
        # de Casteljau at the middle: the right half stays on the stack below the left one
        left, right = stack[top + 2], stack[top + 1]
        mid = 0.5 * (lo + hi)
        for j in range(n + 1):
            right[j] = c[j]
        left[0] = right[0]
        for level in range(1, n + 1):
            for j in range(n - level + 1):
                right[j] = 0.5 * (right[j] + right[j + 1])
            left[level] = right[0]
        left[n + 1], left[n + 2] = lo, mid
        right[n + 1], right[n + 2] = mid, hi
        top += 2
    return count


@compiled(inline=True, fused=True, from_python=True)
def _stays_above(b: Reals, h: float, start: float, total: float) -> bool:
    """Whether the first three terms exceed the magnitude of all others on [0, h], which excludes most steps."""
    first, second = b[1] * h, b[2] * h * h
    rest = max(total - abs(first) - abs(second), 0.0) + 1e-15 * total
    lowest = min(start, start + first + second)
    if second > 0.0 and -2.0 * second < first < 0.0:
        lowest = start - 0.25 * first * first / second
    return lowest > rest


@compiled(inline=True, fused=False, from_python=True)
def _march(b: Reals, n: int, h: float) -> float:
    """Step from 0 towards the first crossing without passing it; NaN if that takes too many steps.

    With |b''| <= bend on [0, h], b stays above ``f + slope s - bend s^2/2`` behind every point: the root of this
    parabola is safe, and converges to a simple root of b as fast as Newton's method.
    """
    bend, power = 0.0, 1.0
    for k in range(2, n + 1):
        bend += k * (k - 1) * (power * abs(b[k]))
        power *= h
    t, f, slope = 0.0, b[0], b[1]
    if bend == 0.0:
        return -f / slope if f < -slope * h else 2.0 * h
    for _ in range(MARCHES):
        root = np.sqrt(slope * slope + 2.0 * bend * f)
        step = 2.0 * f / (root - slope) if slope < 0.0 else (slope + root) / bend
        if slope < 0.0 and bend * step * step <= -1e-16 * slope * t:
            return t + step if t + step < h else 2.0 * h
        t += step
        if t >= h:
            return 2.0 * h
        if t == 0.0:  # b and its slope are zero
            return np.nan
        f, slope = value_and_slope(b, n, t)
        if f <= 0.0:  # at the root, up to rounding
            return t
    return np.nan


@compiled(inline=True, fused=False, ieee_division=True, from_python=True)
def _only_root(b: Reals, n: int, last: float) -> float:
    """Return the only root of b, zero beyond n, in (0, 1); b[0] is not negative, and b is `last` < 0 at 1.

    Nothing is fused, because of two products in a sum compilers choose one: the lanes of `symfric.solve.lanes` are to
    end at the same bits.
    """
    lo, hi = 0.0, 1.0
    s = _guess(b[0], last, b[1])
    for _ in range(100):
        if not lo < s < hi:
            s = 0.5 * (lo + hi)
            if not lo < s < hi:
                break
        f, slope = value_and_slope(b, n, s)
        if f >= 0.0:
            lo = s
        else:
            hi = s
        new = s - f / slope
        if lo <= new <= hi and abs(new - s) <= LAST_STEP * s:
            return new
        s = new
    return hi


@compiled(inline=True, fused=True, from_python=True)
def first_crossing(
    b: Reals,
    n: int,
    h: float,
    start: float,
    total: float,
    columns: Matrix,
    table: Cube,
    stack: Matrix,
    places: Reals,
    own: Reals,
) -> float:
    """Return the first time in (0, h) at which b, not negative at 0, becomes negative; 2 h if it does not.

    Parameters
    ----------
    b : ndarray
        Coefficients, at least n + 1.
    n : int
        Degree, at least 1.
    h : float
    start : float
        Value used as b[0], not negative.
    total : float
        Sum of the magnitudes of the terms 1 .. n at h, or a bound of it.
    columns, table : ndarray
        From `symfric.solve.loop.events.bernstein`, for the highest degree and for all.
    stack, places : ndarray
        As for `roots`.
    own : ndarray
        Work space, at least four more than the rows of `columns`.
    """
    if n >= 2 and _stays_above(b, h, start, total):
        return 2.0 * h
    order, width = columns.shape[0] - 1, columns.shape[1]
    own[0], square, bent = start, h * h, 0.0
    odd, even = h, square  # in two chains
    for k in range(1, n, 2):
        own[k], own[k + 1] = b[k] * odd, b[k + 1] * even
        odd *= square
        even *= square
    if n % 2 == 1:
        own[n] = b[n] * odd
    for k in range(2, n + 1):
        bent += abs(own[k])
    if bent == 0.0:
        return -start / b[1] if start < -b[1] * h else 2.0 * h
    own[n + 1 : order + 4] = 0.0
    negative = signs_of_sums(columns.ctypes.data, own.ctypes.data, order + 1, width // VECTOR, stack.ctypes.data)
    if negative == 0:
        return 2.0 * h
    positive = ~((negative << (64 - width)) >> (64 - width))  # the last column continues
    if positive & (positive + 1) == 0:  # positive, then negative
        return h * _only_root(own, order, stack[0, order])
    for k in range(1, n + 1):
        own[k] = b[k]
    t = _march(own, n, h)
    if t >= 0.0:
        return t
    power = 1.0
    for k in range(1, n + 1):
        power *= h
        own[k] *= power
    return h * places[0] if roots(own, n, 1, table, stack, places) else 2.0 * h


@compiled(fused=True, from_python=True)
def _bends_one_way(b: Reals, n: int, t: float) -> bool:
    """Whether the second derivative at t is larger than all its changes on [0, 1] may be."""
    curve, change = 0.0, 0.0
    for k in range(n, 1, -1):
        curve = curve * t + (k * (k - 1)) * b[k]
        change += (k * (k - 1) * (k - 2)) * abs(b[k])
    return abs(curve) > change * max(t, 1.0 - t)


@compiled(fused=True, from_python=True)
def extend_range(
    b: Reals, n: int, low: float, high: float, table: Cube, stack: Matrix, places: Reals, slope: Reals
) -> tuple[float, float]:
    """Return (low, high) extended by the values of b on [0, 1]."""
    first, second = (b[1] if n > 0 else 0.0), (b[2] if n > 1 else 0.0)
    rest, steep, bend = 0.0, 0.0, 0.0  # bounds of all terms beyond the parabola
    for k in range(3, n + 1):
        size = abs(b[k])
        rest += size
        steep += k * size
        bend += k * (k - 1) * size
    bottom, top = min(b[0], b[0] + first + second), max(b[0], b[0] + first + second)
    if abs(first) < 2.0 * abs(second) and first * second < 0.0:
        turn = b[0] - 0.25 * first * first / second
        bottom, top = min(bottom, turn), max(top, turn)
    if bottom - rest >= low and top + rest <= high:
        return low, high
    end = value(b, n, 1.0)
    low, high = min(low, b[0], end), max(high, b[0], end)
    if abs(first) > 2.0 * abs(second) + steep:
        return low, high
    for k in range(n):
        slope[k] = (k + 1) * b[k + 1]
    last = value(slope, n - 1, 1.0)
    turns = (first < 0.0) != (last < 0.0)
    t, inner = 0.5, 0.0
    if turns:
        t, inner = _summit(b, n, slope[0], last)
    if 2.0 * abs(second) > bend or _bends_one_way(b, n, t):  # the slope is monotone: at most one extremum
        if not turns:
            return low, high
        return min(low, inner), max(high, inner)
    for j in range(roots(slope, n - 1, n, table, stack, places)):
        inner = value(b, n, places[j])
        low, high = min(low, inner), max(high, inner)
    return low, high
