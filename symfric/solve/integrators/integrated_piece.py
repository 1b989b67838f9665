"""Start and result of the integration of a motion in one mode."""

from dataclasses import dataclass

import numpy as np


@dataclass(frozen=True)
class SegmentStart:
    """Start of a piece: time, state with integrals appended, parameters, mode and sizes of the states.

    With `inner`, the integrated variables, if these are others and known.
    """

    t: float
    state: np.ndarray
    p: np.ndarray
    m: np.ndarray
    size: np.ndarray
    inner: np.ndarray | None = None


@dataclass(frozen=True)
class IntegratedPiece:
    """Motion in one mode, by its nodes.

    Attributes
    ----------
    t : ndarray, shape (n + 1,)
    state : ndarray, shape (n_x + n_integrals, n + 1)
    first, second : ndarray, shape (n_x, n + 1)
        Derivatives of the state without the integrals.
    rows : tuple of three ndarrays, shape (n_r, n + 1)
        Guards and observables, and their first and second derivatives.
    reach : float
        How long the next piece may be.
    fell : int
        The guard that fell at the end, -1 if none did.
    cubic : bool
        Whether between the nodes are cubics through the values, not quintics with the derivatives.
    inner : ndarray, shape (n_x + n_integrals,), optional
        The integrated variables at the end, if these are others than the states.
    """

    t: np.ndarray
    state: np.ndarray
    first: np.ndarray
    second: np.ndarray
    rows: tuple[np.ndarray, ...]
    reach: float
    fell: int = -1
    cubic: bool = False
    inner: np.ndarray | None = None
