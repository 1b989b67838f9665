"""Roots and extrema of polynomials on [0, 1], rigorously: Bernstein subdivision, then safeguarded Newton.

A polynomial is a row of coefficients ``b[0..n]`` in powers of s. Sampling signs would miss a guard that dips below zero
and returns within a step; the signs of the Bernstein coefficients cannot, by the variation-diminishing property
(Lane and Riesenfeld, 1981).
"""

import numpy as np
from numba import njit

DEPTH = 52  # of subdivision; 2^-52 of a step
FUSED = {"contract"}  # products and sums in one instruction; infinities and NaN keep their meaning


def bernstein_table(order: int) -> np.ndarray:
    """Return the tables ``C(j, k) / C(n, k)`` for every degree n <= order, shape (order+1, order+1, order+1)."""
    binomial = np.zeros((order + 1, order + 1))
    for j in range(order + 1):
        binomial[j, 0] = 1
        for k in range(1, j + 1):
            binomial[j, k] = binomial[j - 1, k - 1] + binomial[j - 1, k]
    table = np.zeros((order + 1, order + 1, order + 1))
    for n in range(order + 1):
        for j in range(n + 1):
            table[n, j, : j + 1] = binomial[j, : j + 1] / binomial[n, : j + 1]
    return table


@njit(nogil=True, _nrt=False, fastmath=FUSED)
def value(b, n, s):
    """Evaluate by Horner's rule."""
    r = b[n]
    for k in range(n - 1, -1, -1):
        r = r * s + b[k]
    return r


@njit(nogil=True, _nrt=False, fastmath={"contract", "reassoc"})
def magnitude(b, n, powers):
    """Return the sum of the magnitudes of the terms 1 .. n: a bound of |b - b[0]|, so the order of the sum is free."""
    r = 0.0
    for k in range(1, n + 1):
        r += abs(b[k]) * powers[k]
    return r


@njit(nogil=True, _nrt=False, fastmath={"contract", "reassoc"})
def gain(b, n, powers):
    """Return the sum of the terms 1 .. n; free order of the sum, because it is added to the larger b[0] afterwards."""
    r = 0.0
    for k in range(1, n + 1):
        r += b[k] * powers[k]
    return r


@njit(nogil=True, _nrt=False)
def fill_powers(powers, n, h):
    """Fill in the powers 0 .. n of h, in two independent chains."""
    square = h * h
    powers[0], powers[1] = 1.0, h
    for k in range(2, n + 1):
        powers[k] = powers[k - 2] * square


@njit(nogil=True, _nrt=False, fastmath=FUSED)
def polish(b, n, lo, hi, f_lo, f_hi):
    """Refine the only root between lo and hi, where the signs of b are those of f_lo and f_hi."""
    s = 0.5 * (lo + hi)  # unless both ends are clearly no roots themselves, as an end of a subdivision may be
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
        if lo <= new <= hi and abs(new - s) <= 1e-9 * s:  # the next step would be about the square of this one
            return new
        s = new
    return hi


@njit(nogil=True, _nrt=False, fastmath=FUSED)
def roots(b, n, most, table, stack, found):
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
        From `bernstein_table`.
    stack : ndarray, shape (DEPTH + 2, order + 3)
        Work space.
    found : ndarray
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
            found[count] = polish(b, n, lo, hi, c[0], c[n])
            count += 1
            if count == most:
                return count
            continue
        if hi - lo < 4.5e-16:
            if (c[0] >= 0.0) != (c[n] >= 0.0):
                found[count] = hi
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


@njit(nogil=True, _nrt=False, fastmath={"contract", "reassoc"})
def _parabola_clear(b, n):
    """Return whether the first three terms stay above the magnitude of all others on [0, 1]; excludes most steps."""
    rest = 0.0
    for k in range(3, n + 1):
        rest += abs(b[k])
    lowest = min(b[0], b[0] + b[1] + b[2])
    if b[2] > 0.0 and -2.0 * b[2] < b[1] < 0.0:
        lowest = b[0] - 0.25 * b[1] * b[1] / b[2]
    return lowest > rest


@njit(nogil=True, _nrt=False, fastmath=FUSED)
def first_crossing(b, n, table, stack, found):
    """Return the first s in (0, 1] at which b, not negative at 0, becomes negative; 2.0 if it does not."""
    if n >= 2 and _parabola_clear(b, n):
        return 2.0
    bound = 0.0
    for k in range(2, n + 1):
        bound += k * abs(b[k])
    if abs(b[1]) > bound:  # monotone
        if b[1] >= 0.0:
            return 2.0
        end = value(b, n, 1.0)
        return 2.0 if end >= 0.0 else polish(b, n, 0.0, 1.0, b[0], end)
    if roots(b, n, 1, table, stack, found) == 0:
        return 2.0
    return found[0]


@njit(nogil=True, _nrt=False, fastmath=FUSED)
def extend_range(b, n, low, high, table, stack, found, slope):
    """Return (low, high) extended by the values of b on [0, 1]."""
    bound = 0.0
    for k in range(1, n + 1):
        bound += abs(b[k])
    if b[0] + bound <= high and b[0] - bound >= low:
        return low, high
    low, high = min(low, b[0]), max(high, b[0])
    end = value(b, n, 1.0)
    low, high = min(low, end), max(high, end)
    bound = 0.0
    for k in range(2, n + 1):
        bound += k * abs(b[k])
    if n >= 2 and bound >= abs(b[1]):
        for k in range(n):
            slope[k] = (k + 1) * b[k + 1]
        for j in range(roots(slope, n - 1, n, table, stack, found)):
            inner = value(b, n, found[j])
            low, high = min(low, inner), max(high, inner)
    return low, high
