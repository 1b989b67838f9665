"""Trajectory of a run as piecewise polynomials."""

from dataclasses import dataclass

import numpy as np


@dataclass(frozen=True, eq=False)
class Path:
    """A trajectory as piecewise polynomials.

    Attributes
    ----------
    t : ndarray, shape (n,)
        Start of every step.
    h : ndarray, shape (n,)
        Length of every step.
    coefficients : ndarray, shape (n, n_x, order + 1)
        Taylor coefficients of the state in powers of the time since the start of the step.
    mode : ndarray of int, shape (n, n_contacts)
    """

    t: np.ndarray
    h: np.ndarray
    coefficients: np.ndarray
    mode: np.ndarray

    def step_of(self, t: np.ndarray) -> np.ndarray:
        """Return the index of the step that holds each time; at an event the step that begins there."""
        return np.clip(np.searchsorted(self.t, t, side="right") - 1, 0, self.t.size - 1)

    def __call__(self, t: np.ndarray) -> np.ndarray:
        """Return the state, shape (n_x, *t.shape)."""
        k = self.step_of(t)
        s = t - self.t[k]
        c = self.coefficients[k]
        x = c[..., -1]
        for j in range(c.shape[-1] - 2, -1, -1):
            x = x * s[..., None] + c[..., j]
        return np.moveaxis(x, -1, 0)
