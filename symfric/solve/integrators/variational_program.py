"""Runs with derivatives of scenes with stiff laws with memory: by an implicit integrator, at a cost like the run's.

Extremes are found by a run without derivatives; theirs are those of the observable at the time of the extreme.
"""

import math
from collections.abc import Callable
from typing import TYPE_CHECKING, Any

import numpy as np

from symfric.errors import NoRoute
from symfric.lower.variational_equations import starts_of
from symfric.model.outputs import HalfRange
from symfric.model.rows import INTEGRAL, RANGE, VALUES, Row
from symfric.model.symbols import Key, name_of
from symfric.solve.integrators.implicit.varied_motion import Followed, VariedMotion
from symfric.solve.integrators.motion import Motion
from symfric.solve.integrators.program import IntegratorsProgram, check_tolerance
from symfric.solve.integrators.refusals import declines, refuse_crossings
from symfric.solve.lowered import LoweredScene
from symfric.solve.program import Numbers
from symfric.solve.protocol import Program
from symfric.solve.run import Raw, Run
from symfric.solve.sensitivities import Columns, Derivatives, first_derivatives
from symfric.solve.status import Status

if TYPE_CHECKING:
    from symfric.solve.integrators.route import Integrators


class VariationalProgram(Program):
    """A scene prepared with its derivatives for an implicit integrator; may be run from any thread.

    Parameters
    ----------
    lowered : LoweredScene
    tolerance : float
        Of the motion and of its derivatives.
    settings : Integrators

    Raises
    ------
    NoRoute
        If a contact can stick, or a force has kinks that outputs would see.
    """

    settings: "Integrators"

    def __init__(self, lowered: LoweredScene, tolerance: float, settings: "Integrators"):
        super().__init__(lowered, check_tolerance(tolerance), settings)
        scene, self._observables = self.scene, lowered.observables
        refuse_crossings(scene.outputs)
        if any(r.kind == INTEGRAL and r.start > 0.0 for r in self._observables.rows):
            raise NoRoute(
                "the route 'integrators' declines: derivatives of a mean that leaves out the begin of the run"
            )
        self._states = tuple(s.name for s in scene.system.states)
        self._integrals = [r for r in self._observables.rows if r.kind == INTEGRAL]
        self._looked = [r for r in self._observables.rows if r.kind != INTEGRAL]
        automaton = lowered.automaton_with([r.expr for r in (*self._integrals, *self._looked)])
        refusal = declines(automaton, settings.plugin, scene, derivatives=True)
        if refusal:
            raise NoRoute(f"the route 'integrators' declines: {refusal}")
        self._motion = VariedMotion(automaton, lowered, self.directions, len(self._integrals), self.tolerance)
        self._columns = Columns(self.directions, (), len(self._states), self._observables, scene.outputs)
        self._numbers = Numbers(scene, automaton.parameters, self.built_in)
        self._start = starts_of(automaton, scene, self.directions)
        self._plain = self._without_derivatives(lowered)

    def _without_derivatives(self, lowered: LoweredScene) -> IntegratorsProgram | None:
        """Return the program that finds extremes and the trajectory, if any are outputs."""
        kept = {n: o for n, o in self.scene.outputs.items() if o.keeps_path or o.keeps_events}
        ranges = {f"row {k}": HalfRange(r.expr, r.start) for k, r in enumerate(self._looked) if r.kind == RANGE}
        if not ranges and not self._observables.path:
            return None
        return IntegratorsProgram(lowered.wanting({**ranges, **kept}), self.tolerance, self.settings)

    def _run(
        self, values: dict[Key, float], initial: dict[Key, float], progress: Callable[[float], None] | None
    ) -> Run:
        y, p = self._numbers.changed(values, initial)
        first = first_derivatives(self._start, self.directions, self._states, p, map(name_of, initial))
        given = dict(zip((*self._motion.names, *self._states), (*p, *y), strict=True))
        unit = np.array([abs(float(given[name])) or 1.0 for name in self.directions])
        plain = None if self._plain is None else self._plain.follow(values, initial)
        times = self._times(plain)
        grid = np.unique(np.concatenate([np.zeros(0), *times.values()]))
        followed = self._motion.follow(y, first.T, unit, p, grid, self.scene.horizon, self.settings.max_steps, progress)
        status = followed.status if plain is None or plain.status == Status.OK else plain.status
        return self._collect(followed, plain, times, grid, status, values, initial)

    def _times(self, plain: Motion | None) -> dict[Row, np.ndarray]:
        """Return the times at which the derivatives of every observable are needed."""
        times, ranges = {}, iter(range(len(self._looked)))
        for row in self._looked:
            if row.kind == VALUES:
                times[row] = np.array(row.times)
            else:
                assert plain is not None
                k = next(ranges)
                times[row] = np.zeros(2) if plain.at is None else plain.at[:, k]
        return times

    def _collect(
        self,
        followed: Followed,
        plain: Motion | None,
        times: dict[Row, np.ndarray],
        grid: np.ndarray,
        status: Status,
        values: dict[Key, float],
        initial: dict[Key, float],
    ) -> Run:
        """Return the result of a motion with derivatives on a grid, and of the same without them if there is one."""
        n_s, n_x, rows = len(self.directions), len(self._states), self._observables.rows
        total = np.zeros((len(rows) * (1 + n_s), 4))
        own: list[np.ndarray] = [np.zeros(0)] * len(rows)
        slopes: list[list[np.ndarray]] = [[np.zeros(0)] * n_s for _ in rows]
        for k, row in enumerate(rows):
            part = total[len(rows) + k * n_s : len(rows) + (k + 1) * n_s]
            if row.kind == INTEGRAL:
                j = n_x + self._integrals.index(row)
                total[k, 2], part[:, 2] = followed.final[j], followed.slopes[j]
                continue
            j, at = self._looked.index(row), np.searchsorted(grid, times[row])
            if row.kind == VALUES:
                own[k], slopes[k] = followed.rows[at, j], list(followed.by[at, j].T)
            else:
                total[k, :2], part[:, :2] = followed.rows[at, j], followed.by[at, j].T
        seen = [*own, *(e for columns in slopes for e in columns)]
        first = np.concatenate([[0], np.cumsum([e.size for e in seen])]).astype(int)
        derivatives = Derivatives(
            self._columns, followed.slopes[:n_x].T.ravel(), total, np.concatenate([*seen, np.zeros(0)]), first,
            np.zeros(n_s), known=status == Status.OK, rests=False, smooth=True,
        )  # fmt: skip
        kept = {name: self._value(rows[k], total[k], own[k]) for name, k in self._observables.row.items()}
        path = events = None
        if plain is not None and self._plain is not None:
            raw = self._plain.collect(plain, values, initial).raw
            path, events = raw.path, raw.events
        elif self._observables.events:
            events = np.zeros(0), np.zeros((0, 3), dtype=np.int64)
        counts: dict[str, float] = {"pieces": 1, "steps": followed.steps, "events": 0, "kinks": 0, "grazes": 0}
        raw = Raw(kept, math.nan, path, events, derivatives)
        end = followed.final[:n_x], followed.t, status, counts
        return Run(self.scene, values, initial, self.settings, self.tolerance, *end, raw)

    @staticmethod
    def _value(row: Row, total: np.ndarray, values: np.ndarray) -> Any:
        """Return what an output is made of; see `symfric.solve.run.Raw`."""
        if row.kind == VALUES:
            return values
        if row.kind == INTEGRAL:
            return float(total[2])
        low, high = float(total[0]), float(total[1])
        return (max(low, -high, 0.0), max(-low, high)) if row.magnitude else (low, high)
