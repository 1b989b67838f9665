"""Sizes of states, which make differences of states relative and independent of units."""

import numpy as np

LEAST = 1e-9  # least size of a state, relative to the largest of its kind
_NONE = 1e-140  # size where nothing moves; its square does not underflow


def kinds(n_q: int, n_x: int) -> tuple[slice, slice, slice]:
    """Return the slices of coordinates, velocities and further states in ``[q; u; z]``."""
    return slice(0, n_q), slice(n_q, 2 * n_q), slice(2 * n_q, n_x)


def filled(size: np.ndarray, n_q: int) -> np.ndarray:
    """Return sizes of the states, none of them zero: at least `LEAST` times the largest of their kind.

    Coordinates and velocities have different units, so each is compared only with its own kind.
    """
    found = np.array(size, dtype=float)
    for kind in kinds(n_q, found.size):
        found[kind] = np.maximum(found[kind], LEAST * max(np.max(found[kind], initial=0.0), _NONE))
    return found


def over_time(size: np.ndarray, n_q: int, time: float) -> np.ndarray:
    """Return sizes of the states of a motion over a time.

    A velocity that moves its coordinate by less than its size within that time counts as zero, and so does every
    velocity where no coordinate moves.
    """
    found = np.array(size, dtype=float)
    q, u, z = kinds(n_q, found.size)
    found[q] = np.maximum(found[q], LEAST * np.max(found[q], initial=0.0))
    found[q] = np.where(found[q] > 0, found[q], 1.0)
    found[u] = np.maximum(found[u], found[q] / time)
    found[z] = np.maximum(found[z], LEAST * np.max(found[z], initial=0.0))
    return np.where(found > 0, found, 1.0)
