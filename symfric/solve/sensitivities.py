"""Derivatives of a run, as its loop left them, and by name when they are asked for."""

import math
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from symfric.model.outputs import HalfRange, Min, Output, StopTime
from symfric.solve.observables import INTEGRAL, RANGE, Wanted


@dataclass(frozen=True, eq=False)
class Columns:
    """What the numbers of a loop with derivatives mean.

    Attributes
    ----------
    directions : tuple of str
        Parameters, or states whose start is meant.
    pairs : tuple of (int, int)
        Directions of second derivatives.
    n_x : int
        States of the motion.
    wanted : Wanted
        Of the motion.
    outputs : mapping of str to Output
        Of the scene.
    """

    directions: tuple[str, ...]
    pairs: tuple[tuple[int, int], ...]
    n_x: int
    wanted: Wanted
    outputs: Mapping[str, Output]


@dataclass(frozen=True, eq=False)
class Derivatives:
    """Derivatives of a run, by the name of the parameter or of the state whose start is meant.

    Attributes
    ----------
    columns : Columns
    state : ndarray
        Derivatives of the final state, direction by direction, then the second ones, pair by pair.
    total : ndarray, shape (rows, 4)
        Smallest and largest value, integral or value at a time of every wanted row, then of its derivatives.
    rest : ndarray
        Derivatives of the time since which the system rests.
    known : bool
        Whether there are derivatives at the end of the run; else those of the final state and of integrals are NaN, and
        those of extremes and values taken after the event at which there are none.
    rests, smooth : bool
        Whether the system rests at the end, and whether nothing happened before it.
    """

    columns: Columns
    state: np.ndarray
    total: np.ndarray
    rest: np.ndarray
    known: bool
    rests: bool
    smooth: bool

    @cached_property
    def _ends(self) -> np.ndarray:
        return (1.0 if self.known else math.nan) * self.state.reshape(-1, self.columns.n_x)

    @cached_property
    def _tables(self) -> np.ndarray:
        """Of every row and column its four numbers."""
        n_e = len(self.columns.wanted.rows)
        return self.total[n_e:].reshape(n_e, len(self._ends), 4)

    @cached_property
    def final(self) -> dict[str, np.ndarray]:
        """Of the final state, shape (n_x,)."""
        names = self.columns.directions
        return dict(zip(names, self._ends[: len(names)], strict=True))

    @cached_property
    def outputs(self) -> dict[str, dict[str, float]]:
        """Of every scalar output, by its name."""
        names = self.columns.directions
        found = {
            name: dict(zip(names, self._of(name, row, self._tables[row, : len(names)]).tolist(), strict=True))
            for name, row in self.columns.wanted.row.items()
        }
        for name in (n for n, o in self.columns.outputs.items() if isinstance(o, StopTime)):
            factor = 1.0 if self.known and self.rests else math.nan
            found[name] = dict(zip(names, (factor * self.rest[: len(names)]).tolist(), strict=True))
        return found

    @cached_property
    def void(self) -> tuple[str, ...]:
        """Outputs without a derivative in some direction."""
        return tuple(name for name, row in self.outputs.items() if not all(map(math.isfinite, row.values())))

    @cached_property
    def _pairs(self) -> list[tuple[str, str]]:
        names = self.columns.directions
        return [(names[a], names[b]) for a, b in self.columns.pairs]

    @cached_property
    def second(self) -> dict[tuple[str, str], np.ndarray]:
        """Second derivatives of the final state, if they were wanted; NaN if an event occurred."""
        factor = 1.0 if self.smooth else math.nan
        return dict(zip(self._pairs, factor * self._ends[len(self.columns.directions) :], strict=True))

    @cached_property
    def second_outputs(self) -> dict[str, dict[tuple[str, str], float]]:
        """Second derivatives of integrals and of values at a time."""
        factor, n_s = 1.0 if self.smooth else math.nan, len(self.columns.directions)
        return {
            name: dict(zip(self._pairs, (factor * self._tables[row, n_s:, 2]).tolist(), strict=True))
            for name, row in self.columns.wanted.row.items()
            if self._pairs and self.columns.wanted.rows[row].kind != RANGE
        }

    def _of(self, name: str, k: int, table: np.ndarray) -> np.ndarray:
        """Return the derivatives of a scalar output from those of its row, shape (n_s,)."""
        row = self.columns.wanted.rows[k]
        if row.kind != RANGE:
            return table[:, 2] if self.known or row.kind != INTEGRAL else np.full_like(table[:, 2], math.nan)
        low, high = self.total[k, :2]
        d_low, d_high = table[:, 0], table[:, 1]
        if row.magnitude:
            d_low, d_high = (
                d_low if low > 0 else -d_high if high < 0 else np.zeros_like(d_low),
                -d_low if -low > high else d_high,
            )
        output = self.columns.outputs[name]
        if isinstance(output, HalfRange):
            return 0.5 * (d_high - d_low)
        return d_low if isinstance(output, Min) else d_high
