"""Dense output from values and derivatives at nodes: quintic Hermite polynomials, and their extremes."""

import numpy as np


def quintic(h: np.ndarray, value: np.ndarray, first: np.ndarray, second: np.ndarray) -> np.ndarray:
    """Return the Taylor coefficients, about its left node, of the quintic on every interval.

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
    y0, y1 = value[:, :-1], value[:, 1:]
    d0, d1 = first[:, :-1] * h, first[:, 1:] * h
    s0, s1 = 0.5 * second[:, :-1] * h**2, 0.5 * second[:, 1:] * h**2
    rise, turn, bend = y1 - y0 - d0 - s0, d1 - d0 - 2 * s0, s1 - s0
    scaled = [y0, d0, s0, 10 * rise - 4 * turn + bend, -15 * rise + 7 * turn - 2 * bend, 6 * rise - 3 * turn + bend]
    return np.stack([c / h**k for k, c in enumerate(scaled)], axis=-1).transpose(1, 0, 2)


def middle_error(t: np.ndarray, value: np.ndarray, first: np.ndarray, second: np.ndarray) -> float:
    """Return the largest difference between the odd nodes and the quintics through the even ones.

    The quintics through all nodes are closer by a factor of 2**6.
    """
    even = slice(None, None, 2)
    coefficients = quintic(np.diff(t[even]), value[:, even], first[:, even], second[:, even])
    s = (t[1::2] - t[:-1:2])[:, None]
    found = coefficients[..., 5]
    for k in range(4, -1, -1):
        found = found * s + coefficients[..., k]
    scale = np.maximum(np.max(np.abs(value), axis=1), 1e-300)
    return float(np.max(np.abs(found.T - value[:, 1::2]) / scale[:, None]))


def turning_points(h: np.ndarray, value: np.ndarray, first: np.ndarray, second: np.ndarray):
    """Return the extremes inside the intervals as arrays: row, interval, time since its left node, value."""
    coefficients = quintic(h, value, first, second)
    points = []
    for row, k in np.argwhere(first[:, :-1] * first[:, 1:] <= 0):
        c = coefficients[k, row]
        for root in np.roots((c[1:] * np.arange(1, 6))[::-1]):
            if abs(root.imag) < 1e-9 * h[k] and 0 < root.real < h[k]:
                points.append((row, k, root.real, np.polyval(c[::-1], root.real)))
    row, k, s, found = np.array(points, dtype=float).reshape(-1, 4).T
    return row.astype(int), k.astype(int), s, found


def extremes(h: np.ndarray, value: np.ndarray, first: np.ndarray, second: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return the smallest and the largest value of every row of quintics, shape (rows,)."""
    low, high = value.min(axis=1), value.max(axis=1)
    row, _, _, found = turning_points(h, value, first, second)
    np.minimum.at(low, row, found)
    np.maximum.at(high, row, found)
    return low, high


def first_dip(t, value, first, second, below: np.ndarray) -> tuple[float, float] | None:
    """Return the times of the peak and of the dip of the first row that falls below ``-below``.

    Parameters
    ----------
    t : ndarray, shape (n + 1,)
        The nodes.
    value, first, second : ndarray, shape (rows, n + 1)
    below : ndarray, shape (rows,)
    """
    row, k, s, found = turning_points(np.diff(t), value, first, second)
    rows, nodes = np.nonzero(value < -below[:, None])
    times = np.concatenate([t[nodes], (t[k] + s)[found < -below[row]]])
    if not times.size:
        return None
    where = np.concatenate([rows, row[found < -below[row]]])[np.argmin(times)]
    dip = times.min()
    inside = (row == where) & (t[k] + s < dip)
    peaks = np.concatenate([(t[k] + s)[inside], t[t < dip]])
    heights = np.concatenate([found[inside], value[where, t < dip]])
    return float(peaks[np.argmax(heights)]) if peaks.size else float(t[0]), float(dip)
