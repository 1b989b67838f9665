"""Derivative-free pattern search around a design."""

import itertools
from collections.abc import Callable

import numpy as np

_SEED = 17  # fixed, so that a design is the same each time
_RANDOM = 2  # random directions in each poll, per parameter
_GROW, _SHRINK = 2.0, 0.4  # factors of the distance: after a better point, and after a poll without one


def ways(size: int) -> np.ndarray:
    """Return the directions along the axes and diagonals of a cube, shape (3^size - 1, size)."""
    return np.array([w for w in itertools.product((-1.0, 0.0, 1.0), repeat=size) if any(w)])


def polished(
    merit: Callable[[np.ndarray], tuple[float, ...]], point: np.ndarray, reach: float, least: float
) -> np.ndarray:
    """Return a local minimum in the unit cube, by polling at distances from `reach` down to `least`.

    Parameters
    ----------
    merit : callable
        Function to minimise; values are compared, such as (violation, cost).
    point : ndarray, shape (n,)
    reach, least : float
        First and last distance.

    Notes
    -----
    A pattern search (Kolda, Lewis and Torczon, SIAM Review 45 (2003) 385) with the directions of the axes, the
    diagonals, some drawn anew in each poll, and the last one that was better: on a ridge, where a function has a
    corner, the fixed ones may all lead upward.
    """
    draw = np.random.default_rng(_SEED)
    best, last = merit(point), None
    while reach > least:
        drawn = draw.normal(size=(_RANDOM * point.size, point.size))
        drawn /= np.linalg.norm(drawn, axis=1, keepdims=True)
        polls = [*([] if last is None else [last]), *ways(point.size), *drawn, *-drawn]
        for way in polls:
            then = np.clip(point + reach * way, 0.0, 1.0)
            if np.array_equal(then, point):
                continue
            value = merit(then)
            if value < best:
                point, best, last, reach = then, value, way, _GROW * reach
                break
        else:
            last, reach = None, _SHRINK * reach
    return point
