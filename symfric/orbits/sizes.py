"""Sizes of states, which make differences of states relative and independent of units."""

import numpy as np

LEAST = 1e-9  # least size of a state, relative to the largest of its kind
_ROUNDING = 1e-12  # of a state that follows from others, relative to its value
UNMOVED = 1e-6  # range of a state relative to its value below which it stays the same
_NONE = 1e-140  # size where nothing moves; its square does not underflow


def kinds(n_q: int, n_x: int) -> tuple[slice, slice, slice]:
    """Return the slices of coordinates, velocities and further states in ``[q; u; z]``."""
    return slice(0, n_q), slice(n_q, 2 * n_q), slice(2 * n_q, n_x)


def filled(size: np.ndarray, n_q: int) -> np.ndarray:
    """Return sizes of the states, none of them zero: at least `LEAST` times the largest of their kind.

    Coordinates and velocities have different units, so each is compared only with its own kind.
    """
    sizes = np.array(size, dtype=float)
    for part in (sizes[kind] for kind in kinds(n_q, sizes.size)):
        if part.size:
            np.maximum(part, LEAST * max(float(part.max()), _NONE), out=part)
    return sizes


def ranges_of(low: np.ndarray, high: np.ndarray, n_q: int) -> np.ndarray:
    """Return the ranges of states between extremes (n_x,) as sizes, none of them below the rounding of the values."""
    rounding = _ROUNDING * np.maximum(np.abs(low), np.abs(high))
    return filled(np.maximum(high - low, rounding), n_q)


def over_time(size: np.ndarray, n_q: int, time: float) -> np.ndarray:
    """Return sizes of the states of a motion over a time.

    A velocity that moves its coordinate by less than its size within that time counts as zero, and so does every
    velocity where no coordinate moves.
    """
    sizes = np.array(size, dtype=float)
    q, u, z = kinds(n_q, sizes.size)
    sizes[q] = np.maximum(sizes[q], LEAST * np.max(sizes[q], initial=0.0))
    sizes[q] = np.where(sizes[q] > 0, sizes[q], 1.0)
    sizes[u] = np.maximum(sizes[u], sizes[q] / time)
    sizes[z] = np.maximum(sizes[z], LEAST * np.max(sizes[z], initial=0.0))
    return np.where(sizes > 0, sizes, 1.0)
