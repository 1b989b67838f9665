"""Kinetic energy that the resets of a scene bring along a run, for the balance of its energy."""

from collections.abc import Callable, Iterator, Mapping, Sequence
from typing import TYPE_CHECKING

import casadi as ca
import numpy as np
import sympy as sp

from symfric.lower.energy import resets_functions
from symfric.lower.mode_layout import JUST_AFTER
from symfric.model.resets import Reset
from symfric.solve.path import Path

if TYPE_CHECKING:
    from symfric.solve.run import Run

_ALIKE = 8 * JUST_AFTER  # instants that differ by less, relative to t plus the horizon, may be one event
_CROSSED = 1e-9  # value of a guard relative to its largest below which it has reached zero
_AROUND = 2  # steps before and after an instant among which is the one that ends there


def brought(
    run: "Run",
    kinetic: ca.Function,
    numbers: Mapping[sp.Symbol, float],
    parameters: Callable[[np.ndarray], np.ndarray],
) -> tuple[np.ndarray, dict[int, np.ndarray]]:
    r"""Return the kinetic energy that resets bring at the end of every step of a run, and the states after them.

    A kick changes the velocities from :math:`u^-` to :math:`u^+`; its impulse :math:`p = M (u^+ - u^-)` does the work
    :math:`p^T (u^+ + u^-)/2`. The velocities after it are computed here from the expressions of the reset, so that a
    reset that the run missed or took too often shows in the balance. A held variable that resets change is taken as
    before the samples of the same instant.

    Parameters
    ----------
    run : Run
        With its trajectory.
    kinetic : casadi.Function
        See `symfric.lower.energy.energy_functions`.
    numbers : mapping of Symbol to float
        Parameters of the run.
    parameters : callable
        Returns parameters and inputs at times (n,), shape (n_p, n).

    Returns
    -------
    work : ndarray, shape (n,)
    after : dict of int to ndarray, shape (n_x,)
        States after the resets at the end of a step.
    """
    path, scene = run.path, run.base
    work = np.zeros(path.t.size)
    if not scene.resets or path.t.size < 2:
        return work, {}
    after_all, guards = resets_functions(scene)
    due, falling = _timed(run, numbers), _Falling(run, guards, parameters)
    for r, k in falling.crossings():
        due.setdefault(k, []).append((r, falling.columns[r]))
    ends = np.array(sorted({*due, *falling.jumps}), dtype=int)
    if not ends.size:
        return work, {}
    times, before, after = path.t[ends + 1], path.ends(ends), path.coefficients[ends + 1, :, 0].T
    p = parameters(times)
    sampled = {s.name for h in scene.held for s in h.states} - {n for r in scene.resets for n in r.targets}
    first = [s.name in sampled for s in scene.system.states]  # samples of the same instant come first
    before[first] = after[first]
    state = before.copy()

    def take(cases: np.ndarray, columns: np.ndarray) -> None:
        kicked = np.array(after_all(state[:, cases], times[None, cases], p[:, cases]))
        state[:, cases] = kicked.reshape(len(state), cases.size, -1)[:, np.arange(cases.size), columns]

    listed = [[column for _, column in sorted(due.get(k, []))] for k in ends.tolist()]
    for turn in range(max(map(len, listed))):
        cases = np.array([i for i, columns in enumerate(listed) if len(columns) > turn])
        take(cases, np.array([listed[i][turn] for i in cases]))
    for r, cases in falling.jumped(ends, state, times, p):
        take(cases, np.full(cases.size, falling.columns[r]))
    work[ends] = np.array(kinetic(state, p) - kinetic(before, p)).ravel()
    return work, dict(zip(ends.tolist(), state.T, strict=True))


class _Falling:
    """The guards of resets along a run: where they fall through zero."""

    def __init__(self, run: "Run", guards: ca.Function, parameters: Callable[[np.ndarray], np.ndarray]) -> None:
        resets, path = run.base.resets, run.path
        self._guards = guards
        self.numbers = [r for r, reset in enumerate(resets) if reset.guard is not None]
        self.columns = dict(zip(range(len(resets)), _columns(resets), strict=True))
        self.jumps = (path.jumps - 1).tolist() if self.numbers else []
        if not self.numbers:
            return
        middle, steps = path.t + 0.5 * path.h, np.arange(path.t.size - 1)
        p = parameters(path.t)
        inside = self._at(path(middle), middle, p)
        self._end = self._at(path.ends(steps), path.t[1:], p[:, :-1])
        self._zero = _CROSSED * np.max(np.abs(inside), axis=1, keepdims=True)
        self._falls = (inside[:, :-1] > 0) & (self._end <= self._zero)

    def _at(self, states: np.ndarray, times: np.ndarray, p: np.ndarray) -> np.ndarray:
        return np.array(self._guards(states, times[None], p))

    def crossings(self) -> Iterator[tuple[int, int]]:
        """Yield resets, and the steps at whose ends their guards reach zero from above."""
        for row, r in enumerate(self.numbers):
            yield from ((r, k) for k in np.flatnonzero(self._falls[row]).tolist())

    def jumped(
        self, ends: np.ndarray, states: np.ndarray, times: np.ndarray, p: np.ndarray
    ) -> Iterator[tuple[int, np.ndarray]]:
        """Yield resets, and the cases in which other changes at the end of a step took their guards below zero."""
        if not self.numbers:
            return
        after = self._at(states, times, p)
        for row, r in enumerate(self.numbers):
            across = (self._end[row, ends] > self._zero[row]) & (after[row] < -self._zero[row])
            if np.any(across):
                yield r, np.flatnonzero(across)


def _columns(resets: Sequence[Reset]) -> list[int]:
    """Return the first column of every reset in the function of `resets_functions`."""
    counts = [max(len(values) for values in reset.set.values()) for reset in resets]
    return np.cumsum([0, *counts])[:-1].tolist()


def _timed(run: "Run", numbers: Mapping[sp.Symbol, float]) -> dict[int, list[tuple[int, int]]]:
    """Return resets at known times with their columns, by the steps at whose ends they are."""
    resets, end = run.base.resets, run.t_final
    due: dict[int, list[tuple[int, int]]] = {}
    for r, (reset, column) in enumerate(zip(resets, _columns(resets), strict=True)):
        if reset.guard is not None:
            continue
        columns = max(len(values) for values in reset.set.values())
        if reset.every is None:
            times = np.array([_number(t, numbers) for t in reset.at])
        else:
            offset, period = _number(reset.offset, numbers), _number(reset.every, numbers)
            times = offset + period * np.arange(max(0, int((end - offset) / period) + 2))
        own = column + np.minimum(np.arange(times.size), columns - 1)
        inside = (times > 0) & (times < end)
        steps, met = _steps_before(run.path, times[inside], end)
        for k, c in zip(steps.tolist(), own[inside][met].tolist(), strict=True):
            due.setdefault(k, []).append((r, c))
    return due


def _steps_before(path: Path, times: np.ndarray, end: float) -> tuple[np.ndarray, np.ndarray]:
    """Return the steps that end at some times, and whether there is one for each; of several, that with a jump."""
    near = np.searchsorted(path.t, times)[:, None] + np.arange(-_AROUND, _AROUND + 1)
    near = np.clip(near, 1, path.t.size - 1)
    there = np.abs(path.t[near] - times[:, None]) <= _ALIKE * (times[:, None] + end)
    after = path.coefficients[near, :, 0]
    jumps = np.abs(after - path.ends(near.ravel() - 1).T.reshape(after.shape)).max(axis=2)
    best = np.argmax(np.where(there, jumps, -1.0), axis=1)
    met = there.any(axis=1)
    return near[np.arange(times.size), best][met] - 1, met


def _number(e: float | sp.Expr, numbers: Mapping[sp.Symbol, float]) -> float:
    """Return the value of a time."""
    return float(sp.sympify(e).subs(numbers))
