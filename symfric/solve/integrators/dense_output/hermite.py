"""Dense output by quintic Hermite polynomials, and their extremes."""

import math
from functools import cache

import numpy as np


@cache
def _bernstein(n: int) -> np.ndarray:
    """Return the matrix that gives the Bernstein coefficients of a polynomial of degree n on [0, 1]."""
    return np.array([[math.comb(i, k) / math.comb(n, k) for k in range(n + 1)] for i in range(n + 1)])


def quintic(h: np.ndarray, value: np.ndarray, first: np.ndarray, second: np.ndarray) -> np.ndarray:
    """Return the Taylor coefficients of the quintic on every interval, about its left node.

    Parameters
    ----------
    h : ndarray, shape (n,)
        Lengths of the intervals.
    value, first, second : ndarray, shape (rows, n + 1)
        At the nodes.

    Returns
    -------
    ndarray, shape (n, rows, 6)
    """
    return _scaled(h, value, first, second) / h[:, None, None] ** np.arange(6)


def _scaled(h: np.ndarray, value: np.ndarray, first: np.ndarray, second: np.ndarray) -> np.ndarray:
    """Return the coefficients of the quintics in the fraction of their interval, shape (n, rows, 6)."""
    y0, y1 = value[:, :-1], value[:, 1:]
    d0, d1 = first[:, :-1] * h, first[:, 1:] * h
    s0, s1 = 0.5 * second[:, :-1] * h**2, 0.5 * second[:, 1:] * h**2
    rise, turn, bend = y1 - y0 - d0 - s0, d1 - d0 - 2 * s0, s1 - s0
    scaled = [y0, d0, s0, 10 * rise - 4 * turn + bend, -15 * rise + 7 * turn - 2 * bend, 6 * rise - 3 * turn + bend]
    return np.stack(scaled, axis=-1).transpose(1, 0, 2)


def middle_errors(t: np.ndarray, value: np.ndarray, first: np.ndarray, second: np.ndarray) -> np.ndarray:
    """Return the error at the odd nodes of the quintics through the even ones, shape (rows,).

    The quintics through all nodes are closer by a factor of 2**6.
    """
    even = slice(None, None, 2)
    coefficients = quintic(np.diff(t[even]), value[:, even], first[:, even], second[:, even])
    s = (t[1::2] - t[:-1:2])[:, None]
    value_there = coefficients[..., 5]
    for k in range(4, -1, -1):
        value_there = value_there * s + coefficients[..., k]
    return np.max(np.abs(value_there.T - value[:, 1::2]), axis=1)


def turning_points(
    h: np.ndarray, value: np.ndarray, first: np.ndarray, second: np.ndarray
) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """Return the extremes inside the intervals as arrays: row, interval, time since its left node, value."""
    coefficients = quintic(h, value, first, second)
    points = []
    for row, k in np.argwhere(first[:, :-1] * first[:, 1:] <= 0):
        c = coefficients[k, row]
        for root in np.roots((c[1:] * np.arange(1, 6))[::-1]):
            if abs(root.imag) < 1e-9 * h[k] and 0 < root.real < h[k]:
                points.append((row, k, root.real, np.polyval(c[::-1], root.real)))
    row, k, s, height = np.array(points, dtype=float).reshape(-1, 4).T
    return row.astype(int), k.astype(int), s, height


def extremes(h: np.ndarray, value: np.ndarray, first: np.ndarray, second: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return the smallest and the largest value of every row of quintics, shape (rows,)."""
    low, high = value.min(axis=1), value.max(axis=1)
    row, _, _, height = turning_points(h, value, first, second)
    np.minimum.at(low, row, height)
    np.maximum.at(high, row, height)
    return low, high


def first_fall(
    t: np.ndarray, value: np.ndarray, first: np.ndarray, second: np.ndarray, below: np.ndarray
) -> tuple[int, float] | None:
    """Return the first row that falls below ``-below`` and the time of its preceding root, or None.

    For a row that is not positive at its start, the time is that of reaching ``-below``.

    Parameters
    ----------
    t : ndarray, shape (n + 1,)
        The nodes.
    value, first, second : ndarray, shape (rows, n + 1)
    below : ndarray, shape (rows,)
        What is too little to count.

    Notes
    -----
    The smallest Bernstein coefficient of a polynomial bounds it from below, so no dip between nodes is overlooked.
    """
    return first_fall_of(t, _scaled(np.diff(t), value, first, second), below)


def first_fall_of(t: np.ndarray, coefficients: np.ndarray, below: np.ndarray) -> tuple[int, float] | None:
    """Return what `first_fall` does, from the coefficients (n, rows, order) in the fraction of every interval."""
    h = np.diff(t)
    bound = np.min(coefficients @ _bernstein(coefficients.shape[-1] - 1).T, axis=-1)
    fall = None
    for k, row in np.argwhere(bound < -below):
        if fall is not None and t[k] >= fall[1]:
            break
        part = _fall(coefficients[k, row], below[row], k == 0)
        if part is not None and (fall is None or t[k] + part * h[k] < fall[1]):
            fall = int(row), float(t[k] + part * h[k])
    return fall


def _fall(c: np.ndarray, below: float, beginning: bool) -> float | None:
    """Return the last root on [0, 1] before a polynomial falls below ``-below``, or None if it does not."""
    from scipy import optimize  # slow to import, and only one route needs it

    polynomial = np.polynomial.Polynomial(c)
    turns = polynomial.deriv().roots()
    turns = np.sort(turns.real[(np.abs(turns.imag) < 1e-9) & (turns.real > 0) & (turns.real < 1)])
    points = np.concatenate([[0.0], turns, [1.0]])
    heights = polynomial(points)
    if np.all(heights >= -below):
        return None
    after = int(np.argmax(heights < -below))
    before = max(after - 1, 0)
    if heights[before] > 0:
        return float(optimize.brentq(polynomial, points[before], points[after], xtol=1e-16))
    if beginning and before == 0 < after:
        return float(optimize.brentq(polynomial + below, points[before], points[after], xtol=1e-16))
    return float(points[before])
