"""Sizes of states: what differences between motions are parts of, in whatever units the scene is written."""

import numpy as np

LEAST = 1e-9  # of the largest of its kind: the size of a state that hardly moves
_NONE = 1e-140  # where nothing moves at all; the square of a part of it is still a number


def kinds(n_q: int, n_x: int) -> tuple[slice, slice, slice]:
    """Return where coordinates, velocities and further states stand in ``[q; u; z]``."""
    return slice(0, n_q), slice(n_q, 2 * n_q), slice(2 * n_q, n_x)


def filled(size: np.ndarray, n_q: int) -> np.ndarray:
    """Return sizes of the states, none of them zero: at least a little of the largest of their kind.

    Coordinates are compared with coordinates and velocities with velocities: one has other units than the other.
    """
    found = np.array(size, dtype=float)
    for kind in kinds(n_q, found.size):
        found[kind] = np.maximum(found[kind], LEAST * max(np.max(found[kind], initial=0.0), _NONE))
    return found


def over_time(size: np.ndarray, n_q: int, time: float) -> np.ndarray:
    """Return sizes of the states of a motion that lasts for a time.

    A velocity that would carry its coordinate less than its size within that time is as good as none; so is any other
    where no coordinate moves.
    """
    found = np.array(size, dtype=float)
    q, u, z = kinds(n_q, found.size)
    found[q] = np.maximum(found[q], LEAST * np.max(found[q], initial=0.0))
    found[q] = np.where(found[q] > 0, found[q], 1.0)
    found[u] = np.maximum(found[u], found[q] / time)
    found[z] = np.maximum(found[z], LEAST * np.max(found[z], initial=0.0))
    return np.where(found > 0, found, 1.0)
