"""Which motions of a controlled system come to rest, over a parameter and the sampling period."""

import itertools
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
import sympy as sp

from symfric.model.outputs import Output, Samples, StopTime
from symfric.model.scene import Scene
from symfric.solve.protocol import Program
from symfric.solve.routes import prepare
from symfric.solve.status import Status
from symfric.solve.taylor.route import Taylor

TOLERANCE = 1e-9
_LOOKS = 400  # times at which a motion is looked at after it should have settled
_STEPS, _A_SAMPLE = 20_000, 4  # most steps of a run, and those in a sampling period: one that grows for ever is left
_AT_ONCE = 4  # values that are surveyed together; beyond the border motions may grow, and cost the more


@dataclass(frozen=True, eq=False)
class SettlingMotions:
    """Motions from some starts, and whether they settle.

    Attributes
    ----------
    scene : Scene
        Its horizon is that of the motions.
    name : str
        The parameter.
    period : str or None
        Parameter that is varied besides; None for none.
    least : dict of str to float
        The least values of both.
    starts : sequence of dict of str to float
        Changes of the scene's start.
    settle : float
        Time from which on a motion has to be settled.
    half_range : float
        By which the first coordinate may still move then; zero for rest.
    tolerance : float
    """

    scene: Scene
    name: str
    period: str | None
    least: Mapping[str, float]
    starts: Sequence[Mapping[str, float]]
    settle: float
    half_range: float
    tolerance: float = TOLERANCE

    @cached_property
    def program(self) -> Program:
        """The compiled scene."""
        x, end = self.scene.system.q[0], self.scene.horizon
        looks = np.linspace(self.settle, end, _LOOKS).tolist()
        measured: dict[str, Output] = {"left": Samples(x, looks)} if self.half_range else {"left": StopTime()}
        return prepare(self.scene.wanting(measured), self.tolerance, self.route())

    def placed(self, value: float, period: float | None) -> dict[str, float]:
        """Return the values of the parameter, and of the one that is varied besides, by name."""
        return {self.name: value} | ({} if period is None else {str(self.period): period})

    def route(self) -> Taylor:
        """Return the route, with a budget of steps."""
        numbers = {s: self.least.get(s.name, 0.0) or v for s, v in self.scene.values.items()}
        periods = [sp.sympify(h.every).subs(numbers) for h in self.scene.held if h.every is not None]
        samples = sum(self.scene.horizon / float(period) for period in periods)
        return Taylor(max_steps=_STEPS + int(_A_SAMPLE * samples))

    def left(
        self,
        values: np.ndarray,
        periods: np.ndarray | None = None,
        starts: Sequence[Mapping[str, float]] | None = None,
    ) -> np.ndarray:
        """Return the latest time of rest, or largest half range left, over the starts, for some values, shape (n,).

        The time of rest, or with `half_range` the half range after `settle`; infinite where a motion goes on, or fails.
        """
        starts = self.starts if starts is None else starts
        count = len(starts)
        changes = {self.name: np.repeat(values, count)}
        if self.period is not None and periods is not None:
            changes[self.period] = np.repeat(periods, count)
        initial = {n: np.tile([start[n] for start in starts], len(values)) for n in starts[0]}
        batch = self.program.map(changes, initial)
        deviation = batch.outputs["left"]
        deviation = 0.5 * np.ptp(deviation, axis=0) if self.half_range else deviation
        deviation = np.where((batch.status == Status.OK) & np.isfinite(deviation), deviation, np.inf)
        return np.asarray(deviation.reshape(len(values), count).max(axis=1))

    def rests(
        self,
        values: np.ndarray,
        periods: np.ndarray | None = None,
        starts: Sequence[Mapping[str, float]] | None = None,
    ) -> np.ndarray:
        """Return whether all motions settle, or those from other starts, for some values, shape (n,)."""
        return self.left(values, periods, starts) <= (self.half_range or self.settle)

    def border(self, grid: np.ndarray, periods: np.ndarray | None) -> tuple[np.ndarray, np.ndarray]:
        """Return the values up to which all motions settle, from the first of a grid on.

        Parameters
        ----------
        grid : ndarray, shape (n,)
            Values, increasing; the border is sought between the first one that fails and that before.
        periods : ndarray, shape (m,), or None

        Returns
        -------
        last : ndarray, shape (m,)
            NaN where the first value of the grid fails.
        first : ndarray, shape (m,)
            The neighbouring value that fails; NaN where none of the grid does.
        """
        m = 1 if periods is None else periods.size
        last, first = np.full(m, np.nan), np.full(m, np.nan)
        for begin in range(0, grid.size, _AT_ONCE):
            part, left = grid[begin : begin + _AT_ONCE], np.flatnonzero(np.isnan(first))
            every = None if periods is None else np.tile(periods[left], part.size)
            settled = self.rests(np.repeat(part, left.size), every).reshape(part.size, left.size)
            fails = ~settled.all(axis=0)
            place = np.where(fails, np.argmin(settled, axis=0), part.size)
            first[left[fails]] = part[place[fails]]
            reached = grid[np.maximum(begin + place - 1, 0)]
            last[left] = np.where(begin + place > 0, reached, np.nan)
            if not np.any(np.isnan(first)):
                break
        while True:
            middle = 0.5 * (last + first)
            open_ = np.flatnonzero((last < middle) & (middle < first) & (first - last > 1e-12 * np.abs(first)))
            if not open_.size:
                return last, first
            good = self.rests(middle[open_], None if periods is None else periods[open_])
            last[open_[good]], first[open_[~good]] = middle[open_[good]], middle[open_[~good]]


def grid_of_starts(given: Mapping[str, Sequence[float]]) -> list[dict[str, float]]:
    """Return every combination of some start values."""
    names = list(given)
    return [dict(zip(names, row, strict=True)) for row in itertools.product(*(given[n] for n in names))]
