"""Derivatives of a run, or of many, by parameters and initial values."""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np

from symfric.model.outputs import End, OutputOfExpression, StopTime
from symfric.model.rows import CROSSINGS, INTEGRAL, VALUES, Row
from symfric.solve.observables import Observables


@dataclass(frozen=True, eq=False)
class Columns:
    """Meaning of the columns of derivatives that a loop returns.

    Attributes
    ----------
    directions : tuple of str
        Parameters, or states (for their initial values).
    pairs : tuple of (int, int)
        Directions of second derivatives.
    n_x : int
        States of the motion.
    observables : Observables
        Of the motion.
    outputs : mapping of str to Output
        Of the scene.
    """

    directions: tuple[str, ...]
    pairs: tuple[tuple[int, int], ...]
    n_x: int
    observables: Observables
    outputs: Mapping[str, Any]


@dataclass(frozen=True, eq=False)
class Derivatives:
    """Derivatives of a run, by the name of a parameter, or of a state for its initial value.

    Those of many cases at once have the cases as a further, last axis.

    Attributes
    ----------
    columns : Columns
    state : ndarray
        Derivatives of the final state, direction by direction, then the second ones, pair by pair.
    total : ndarray, shape (rows, 4)
        Smallest and largest value and integral of every observable, then of its derivatives.
    seen, first : ndarray
        Sampled values, observable after observable, and the index at which those of each begin.
    rest : ndarray
        Derivatives of the time since which the system rests.
    known : bool or ndarray of bool
        Whether derivatives exist at the end of the run; else those of the final state and of integrals are NaN, and
        those of extremes and values taken after the event at which they cease to exist.
    rests, smooth : bool or ndarray of bool
        Whether the system rests at the end, and whether no event occurred before the end.
    """

    columns: Columns
    state: np.ndarray
    total: np.ndarray
    seen: np.ndarray
    first: np.ndarray
    rest: np.ndarray
    known: bool | np.ndarray
    rests: bool | np.ndarray
    smooth: bool | np.ndarray

    @property
    def _cases(self) -> tuple[int, ...]:
        return self.state.shape[1:]

    @cached_property
    def _ends(self) -> np.ndarray:
        return np.where(self.known, 1.0, np.nan) * self.state.reshape(-1, self.columns.n_x, *self._cases)

    @cached_property
    def _tables(self) -> np.ndarray:
        """The four numbers of every observable and column."""
        n_e = len(self.columns.observables.rows)
        return self.total[n_e:].reshape(n_e, len(self._ends), 4, *self._cases)

    @cached_property
    def final(self) -> dict[str, np.ndarray]:
        """Derivatives of the final state, shape (n_x,)."""
        names = self.columns.directions
        return dict(zip(names, self._ends[: len(names)], strict=True))

    @cached_property
    def outputs(self) -> dict[str, dict[str, Any]]:
        """Derivatives of the outputs that have any, by name: numbers, or arrays of the shape of the output."""
        names, by_output = self.columns.directions, {}
        for name, output in self.columns.outputs.items():
            if isinstance(output, OutputOfExpression | StopTime | End):
                slopes = output.slopes(self, name)
                columns = slopes.tolist() if slopes.ndim == 1 else np.moveaxis(slopes, -1 - len(self._cases), 0)
                by_output[name] = dict(zip(names, columns, strict=True))
        return by_output

    def of_end(self) -> np.ndarray:
        """Return the derivatives of the final state, (n_x, n_s)."""
        return self._ends[: len(self.columns.directions)].swapaxes(0, 1)

    def of_rest(self) -> np.ndarray:
        """Return the derivatives of the time since which the system rests, (n_s,)."""
        factor = np.where(np.logical_and(self.known, self.rests), 1.0, np.nan)
        return factor * self.rest[: len(self.columns.directions)]

    def integral(self, name: str) -> Any:
        """Return the integral that an output is made of, of one run or of every case."""
        return self.total[self.columns.observables.row[name], 2]

    def of_row(self, name: str) -> Any:
        """Return the derivatives of the observable of an output: a pair, (n_s,) or (n_t, n_s).

        Of crossings, those of the first and the last time, and how many there are.
        """
        k, n_s = self.columns.observables.row[name], len(self.columns.directions)
        row = self.columns.observables.rows[k]
        if row.kind == VALUES:
            return self._values(k)[:, :n_s]
        table = self._tables[k, :n_s]
        if row.kind == INTEGRAL:
            return np.where(self.known, table[:, 2], np.nan)
        if row.kind == CROSSINGS:
            return table[:, 0], table[:, 1], self.total[k, 2]
        return self._of_range(k, row, table[:, 0], table[:, 1])

    def ends(self, name: str) -> np.ndarray:
        """Return the smallest and the largest value of the observable of an output."""
        low_high: np.ndarray = self.total[self.columns.observables.row[name], :2]
        return low_high

    def values(self, name: str) -> np.ndarray:
        """Return the values of the observable of an output at its times."""
        k = self.columns.observables.row[name]
        seen: np.ndarray = self.seen[self.first[k] : self.first[k + 1]]
        return seen

    @cached_property
    def void(self) -> tuple[str, ...]:
        """Outputs whose derivative does not exist in some direction."""
        return tuple(
            name for name, row in self.outputs.items() if not all(np.all(np.isfinite(e)) for e in row.values())
        )

    @cached_property
    def _pairs(self) -> list[tuple[str, str]]:
        names = self.columns.directions
        return [(names[a], names[b]) for a, b in self.columns.pairs]

    @cached_property
    def second(self) -> dict[tuple[str, str], np.ndarray]:
        """Second derivatives of the final state if ``order=2``; NaN if an event occurred."""
        factor = np.where(self.smooth, 1.0, np.nan)
        return dict(zip(self._pairs, factor * self._ends[len(self.columns.directions) :], strict=True))

    @cached_property
    def second_outputs(self) -> dict[str, dict[tuple[str, str], Any]]:
        """Second derivatives of integrals, means and values at given times."""
        factor, n_s = np.where(self.smooth, 1.0, np.nan), len(self.columns.directions)
        by_output = {}
        for name, k in self.columns.observables.row.items():
            kind, output = self.columns.observables.rows[k].kind, self.columns.outputs[name]
            if self._pairs and kind in (INTEGRAL, VALUES):
                twice = self._values(k)[:, n_s:] if kind == VALUES else self._tables[k, n_s:, 2]
                reduced = factor * output.second_slopes(self, name, twice)
                columns = reduced.tolist() if reduced.ndim == 1 else reduced.T
                by_output[name] = dict(zip(self._pairs, columns, strict=True))
        return by_output

    def _values(self, k: int) -> np.ndarray:
        """Return the derivatives of an observable at its times, the second after the first ones, (n_t, columns)."""
        n_e, n_columns = len(self.columns.observables.rows), len(self._ends)
        rows = range(n_e + k * n_columns, n_e + (k + 1) * n_columns)
        return np.stack([self.seen[self.first[r] : self.first[r + 1]] for r in rows], axis=1)

    def _of_range(self, k: int, row: Row, d_low: np.ndarray, d_high: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Return the derivatives of the smallest and the largest value of an observable."""
        if not row.magnitude:
            return d_low, d_high
        low, high = self.total[k, :2]
        least = np.where(low > 0, d_low, np.where(high < 0, -d_high, 0.0))
        return least, np.where(-low > high, -d_low, d_high)


def first_derivatives(
    start: Any, columns: Sequence[Any], states: Sequence[str], p: np.ndarray, replaced: Iterable[str]
) -> np.ndarray:
    """Return the derivatives of the initial state, of one case (columns, n_x) or of rows of them.

    Parameters
    ----------
    start : casadi.Function
        ``p -> V(0)``, all columns.
    columns : sequence
        Directions, then pairs of them.
    states : sequence of str
    p : ndarray, shape (..., n_p)
        Parameters.
    replaced : iterable of str
        States whose start, a formula, was replaced by a number.
    """
    columns_of_start = np.array(start(p[..., : start.nnz_in(0)].T), dtype=float).T
    first = columns_of_start.reshape(*p.shape[:-1], len(columns), len(states))
    for name in replaced:
        for k, direction in enumerate(columns):
            first[..., k, states.index(name)] = float(direction == name)
    return first
