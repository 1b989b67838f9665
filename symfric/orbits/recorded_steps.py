"""Recorded steps of one run with their modes, for calculations along a known motion."""

from typing import Any, NamedTuple

import numpy as np

from symfric.solve.loop.compiled_model import CompiledModel, Workspace
from symfric.solve.loop.workspace import LoopArrays
from symfric.solve.status import Status


class Steps(NamedTuple):
    """Taylor polynomials of a motion, step by step.

    Attributes
    ----------
    t : ndarray, shape (n + 1,)
        Where the steps begin, and the end.
    coefficients : ndarray, shape (n, n_x, order + 1)
    mode : ndarray, shape (n, n_m)
        m of every step.
    hit : ndarray, shape (n, n_g)
        Guards that fell at its end.
    least : ndarray, shape (n, n_g)
        Rates of the guards at its end below which a crossing is a touch, within the error of the run.
    ends : ndarray, shape (n, n_x)
        The states at its end, before what the event there changes.
    places : ndarray, shape (n, n_r)
        Where in the step, from 0 to 1, a row took its least local minimum so far; -1 where it did not.
    """

    t: np.ndarray
    coefficients: np.ndarray
    mode: np.ndarray
    hit: np.ndarray
    least: np.ndarray
    ends: np.ndarray
    places: np.ndarray


class Recorder:
    """Collects the steps of a run of a model that pauses after each; see `CompiledModel.pausing`."""

    def __init__(self, model: CompiledModel, n_rows: int):
        self._workspace, self._rows = Workspace(model), n_rows
        self._taken: list[tuple[Any, ...]] = []

    @property
    def arrays(self) -> LoopArrays:
        """The arrays of the run."""
        arrays: LoopArrays = self._workspace.arrays
        return arrays

    def drive(self, y: np.ndarray, p: np.ndarray, t_end: float) -> Status:
        """Run from state y at t = 0 to a time."""
        self.arrays.clock.t_end = t_end
        self._taken.clear()
        status = self._workspace.drive(y, p, self._note)
        if status == Status.OK and self.arrays.counts.steps > len(self._taken):
            self._note(1.0)
        return status

    def _note(self, _: float) -> None:
        w, n_x, n_q = self.arrays, self.arrays.given_y.size, self.arrays.limits.n_q
        size, ratio = w.scale[n_x : n_x + w.guards.hit.size], w.scale[:n_q] / np.maximum(w.scale[n_q : 2 * n_q], 1e-300)
        slow = np.sqrt(2.0 * w.clock.tolerance) * size / max(np.max(ratio), 1e-300)
        place = w.observed.total[: self._rows, 2].copy()
        row = w.y[-1] + w.clock.t_low, w.c[:n_x].copy(), w.m.copy(), w.guards.hit.copy(), place, slow, w.y[:n_x].copy()
        self._taken.append(row)

    def steps(self) -> Steps:
        """Return the steps of the last run."""
        t, coefficients, mode, hit, places, least, ends = (np.array(e) for e in zip(*self._taken, strict=True))
        return Steps(np.append(0.0, t), coefficients, mode, hit, least, ends, places)

    def log(self) -> tuple[np.ndarray, np.ndarray]:
        """Return times of the events, and contact, mode before and after of each."""
        return self._workspace.take_log()
