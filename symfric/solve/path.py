"""Trajectory of a run as piecewise polynomials."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np

_JUMP = 1e-6  # least jump, relative to the largest value of the state; tolerances part steps by less


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

    def ends(self, k: np.ndarray) -> np.ndarray:
        """Return the states at the end of some steps, before any jump there, shape (n_x, len(k))."""
        x = self.coefficients[k, :, -1]
        for j in range(self.coefficients.shape[2] - 2, -1, -1):
            x = x * self.h[k, None] + self.coefficients[k, :, j]
        return x.T

    @cached_property
    def jumps(self) -> np.ndarray:
        """Indices of the steps at whose start a state jumps."""
        return 1 + np.flatnonzero(self._apart.any(axis=0))

    def jumps_of(self, state: int) -> np.ndarray:
        """Return the indices of the steps at whose start one state jumps."""
        return 1 + np.flatnonzero(self._apart[state])

    @cached_property
    def _apart(self) -> np.ndarray:
        """Whether each state jumps at the start of every step but the first, shape (n_x, n - 1)."""
        before, after = self.ends(np.arange(self.t.size - 1)), self.coefficients[1:, :, 0].T
        with np.errstate(invalid="ignore"):
            size = np.max(np.abs(self.coefficients[:, :, 0].T), axis=1, keepdims=True, initial=0.0)
            return np.abs(after - before) > _JUMP * size

    def line(self, t: np.ndarray, most: int = 20_000) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Return what to draw: times with both sides of the jumps, states there, and the steps to which they belong.

        Parameters
        ----------
        t : ndarray, shape (n,)
            Increasing.
        most : int
            Of more jumps between the first time and the last, every second, third, ... is drawn with both sides.

        Returns
        -------
        t : ndarray, shape (m,)
            At a jump twice.
        x : ndarray, shape (n_x, m)
        step : ndarray of int, shape (m,)
        """
        inside = self.jumps[(self.t[self.jumps] > t[0]) & (self.t[self.jumps] <= t[-1])]
        inside = inside[:: 1 + inside.size // most]
        own = np.setdiff1d(t, self.t[inside])
        times = np.concatenate([own, self.t[inside], self.t[inside]])
        step = np.concatenate([self.step_of(own), inside - 1, inside])
        order = np.lexsort((step, times))
        return times[order], self._at(times[order], step[order]), step[order]

    def __call__(self, t: np.ndarray) -> np.ndarray:
        """Return the state, shape (n_x, *t.shape)."""
        return self._at(t, self.step_of(t))

    def before(self, t: np.ndarray) -> np.ndarray:
        """Return the state just before given times, that at zero for zero, shape (n_x, *t.shape)."""
        return self._at(t, np.clip(np.searchsorted(self.t, t, side="left") - 1, 0, self.t.size - 1))

    def _at(self, t: np.ndarray, k: np.ndarray) -> np.ndarray:
        """Return the states of some steps at given times, shape (n_x, *t.shape)."""
        s = t - self.t[k]
        c = self.coefficients[k]
        x = c[..., -1]
        for j in range(c.shape[-1] - 2, -1, -1):
            x = x * s[..., None] + c[..., j]
        return np.moveaxis(x, -1, 0)
