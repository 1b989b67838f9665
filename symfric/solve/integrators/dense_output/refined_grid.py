"""Nodes of a motion where cubics through its values need them: layers and kinks of stiff motions.

Between two nodes is the cubic through them and one further node on either side.
"""

from collections.abc import Callable

import numpy as np

_FIRST = 64  # intervals of the first grid
_PARTS = 8  # into which an interval is divided that needs it
_MOST = 200_000  # nodes, above which the motion has more details than are followed
_ROUNDS = 24
_RATIO = 3.0  # of the lengths of neighbouring intervals

Look = Callable[[np.ndarray, np.ndarray], tuple[np.ndarray, np.ndarray]]


def cubics(t: np.ndarray, value: np.ndarray) -> np.ndarray:
    """Return the coefficients of the cubics, about the left node of every interval, shape (n, rows, 4).

    Parameters
    ----------
    t : ndarray, shape (n + 1,)
        At least four nodes.
    value : ndarray, shape (rows, n + 1)
    """
    n = t.size - 1
    first = np.clip(np.arange(n) - 1, 0, n - 3)
    places = first[:, None] + np.arange(4)
    # Newton's divided differences, then the polynomial about the left node
    x, d = t[places] - t[:n, None], [value[:, places[:, k]] for k in range(4)]
    for order in range(1, 4):
        for k in range(3, order - 1, -1):
            d[k] = (d[k] - d[k - 1]) / (x[:, k] - x[:, k - order])
    return _expanded(x, d)


def _expanded(x: np.ndarray, d: list[np.ndarray]) -> np.ndarray:
    """Expand Newton's form with the nodes x, (n, 4), and differences d, each (rows, n), in powers."""
    c = [d[3], np.zeros_like(d[3]), np.zeros_like(d[3]), np.zeros_like(d[3])]
    for k in (2, 1, 0):  # c <- c (s - x_k) + d_k
        c = [d[k] - x[:, k] * c[0], *(c[j - 1] - x[:, k] * c[j] for j in range(1, 4))]
    return np.stack(c, axis=-1).transpose(1, 0, 2)


def extremes_of(t: np.ndarray, value: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return the smallest and the largest value of every row of cubics, (rows,), and their times, (2, rows)."""
    c, rows = cubics(t, value), np.arange(len(value))
    first, last = np.argmin(value, axis=1), np.argmax(value, axis=1)
    low, high, at, h = value[rows, first], value[rows, last], np.array([t[first], t[last]]), np.diff(t)[:, None]
    with np.errstate(all="ignore"):
        middle, root = -c[..., 2], np.sqrt(c[..., 2] ** 2 - 3 * c[..., 3] * c[..., 1])
        for s in ((middle + root) / (3 * c[..., 3]), (middle - root) / (3 * c[..., 3]), -c[..., 1] / (2 * c[..., 2])):
            inside = (s > 0) & (s < h)
            height = ((c[..., 3] * s + c[..., 2]) * s + c[..., 1]) * s + c[..., 0]
            slope = np.abs((3 * c[..., 3] * s + 2 * c[..., 2]) * s + c[..., 1])
            turns = inside & (slope <= 1e-6 * (np.abs(c[..., 1]) + np.abs(c[..., 2]) * h + np.abs(c[..., 3]) * h**2))
            below, above = np.where(turns, height, np.inf), np.where(turns, height, -np.inf)
            k, j = np.argmin(below, axis=0), np.argmax(above, axis=0)
            at[0] = np.where(below[k, rows] < low, t[k] + s[k, rows], at[0])
            at[1] = np.where(above[j, rows] > high, t[j] + s[j, rows], at[1])
            low, high = np.minimum(low, below[k, rows]), np.maximum(high, above[j, rows])
    return low, high, at


def refined(
    at: Callable[[np.ndarray], np.ndarray], look: Look, grid: np.ndarray | None = None
) -> tuple[np.ndarray, np.ndarray]:
    """Return nodes on [0, 1] and what belongs to those behind the first.

    Parameters
    ----------
    at : callable
        ``grid -> states``, for increasing times, the last one 1.
    look : callable
        ``(grid with 0 in front, states) -> values (rows, n + 1), allowed errors (rows,)``.
    grid : ndarray, optional
        Nodes to begin with, 0 and 1 included.

    Raises
    ------
    RuntimeError
        If there are details that too many nodes do not resolve.
    """
    grid = np.linspace(0.0, 1.0, _FIRST + 1) if grid is None else grid
    for _ in range(_ROUNDS):
        states = at(grid[1:])
        values, allowed = look(grid, states)
        wrong = _between(grid, values, allowed)
        if not np.any(wrong):
            return grid, states
        parts = np.linspace(0.0, 1.0, _PARTS + 1)[1:-1]
        inner = grid[:-1][wrong][:, None] + np.diff(grid)[wrong][:, None] * parts
        inner = inner[np.all(np.diff(np.column_stack([grid[:-1][wrong], inner, grid[1:][wrong]])) > 0, axis=1)]
        grid = _graded(np.sort(np.concatenate([grid, inner.ravel()])))
        if grid.size > _MOST or not inner.size:
            break
    raise RuntimeError("the motion has details that too many nodes do not resolve")


def _graded(t: np.ndarray) -> np.ndarray:
    """Divide intervals that are much longer than a neighbour, which may hide the end of a layer."""
    while True:
        h = np.diff(t)
        least = np.minimum(np.append(h[1:], np.inf), np.append(np.inf, h[:-1]))
        longer = h > _RATIO * least
        if not np.any(longer):
            return t
        t = np.sort(np.concatenate([t, (t[:-1] + t[1:])[longer] / 2]))


def _between(t: np.ndarray, value: np.ndarray, allowed: np.ndarray) -> np.ndarray:
    """Return the intervals in which a cubic is in error: there it differs too much from the one of its neighbours."""
    c, h = cubics(t, value), np.diff(t)
    wrong = np.zeros(h.size, dtype=bool)
    for side in (-1, 1):  # the cubic of the neighbour, at the middle of the interval
        other = np.arange(h.size) + side
        other[0], other[-1] = 2, h.size - 3  # the outermost cubics go through the same nodes
        s = t[:-1] + h / 2 - t[other]
        apart = np.zeros_like(c[..., 0])
        for k in (3, 2, 1, 0):
            apart = apart * s[:, None] + c[other, :, k]
        own = ((c[..., 3] * (h / 2)[:, None] + c[..., 2]) * (h / 2)[:, None] + c[..., 1]) * (h / 2)[:, None] + c[..., 0]
        wrong |= np.any(np.abs(apart - own) > 4 * allowed, axis=1)
    return wrong
