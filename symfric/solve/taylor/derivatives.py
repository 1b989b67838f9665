"""Runs with derivatives: the motion with its variational equations and the exact saltation at every event."""

from collections.abc import Callable, Iterable, Mapping
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from symfric.errors import NoRoute
from symfric.lower.linear_modes import matrices
from symfric.lower.variational_equations import Variations, varied
from symfric.model.rows import CROSSINGS, FOLLOW, RANGE, TURN, Row
from symfric.model.scene import Scene
from symfric.model.symbols import Key, name_of
from symfric.solve.batch import Batch, reached
from symfric.solve.case_values import CaseValues
from symfric.solve.loop.case_arrays import COUNTS, CaseArrays
from symfric.solve.loop.compiled_model import CompiledModel
from symfric.solve.loop.model import series_model
from symfric.solve.loop.stepping.linear_series import linear_series
from symfric.solve.loop.stepping.series import Series
from symfric.solve.lowered import LoweredScene
from symfric.solve.observables import Observables
from symfric.solve.program import Numbers
from symfric.solve.run import Raw
from symfric.solve.sensitivities import Columns, Derivatives, first_derivatives
from symfric.solve.status import Status
from symfric.solve.taylor.laned import Laned
from symfric.solve.taylor.program import MARGIN, series_of

if TYPE_CHECKING:
    from symfric.solve.taylor.route import Taylor

LINEAR_ORDER, LINEAR_TOLERANCE = 28, 1e-16  # for linear equations, whose series are cheap to compile


class DerivativesProgram(Laned):
    """A scene compiled with its derivatives; may be run from any thread."""

    def __init__(self, lowered: LoweredScene, tolerance: float, settings: "Taylor"):
        super().__init__(lowered, tolerance, settings)
        scene, observables = self.scene, lowered.observables
        self._states = tuple(s.name for s in scene.system.states)
        variations = varied(
            lowered.automaton, scene, self.directions, len(observables.rows), second=self._derivative_order > 1
        )
        self._start, self.automaton = variations.start, variations.automaton
        self._columns = Columns(self.directions, variations.pairs, len(self._states), observables, scene.outputs)
        self._model, self._variants = model_with_derivatives(scene, variations, observables, self.tolerance, settings)
        self._numbers = Numbers(scene, self.automaton.parameters, self.built_in)
        self._moving_start = any(not isinstance(v, float) for v in scene.initial.values())
        start, p = self._numbers.start
        self._first = self._start_derivatives(p, ())
        self._given = np.concatenate([start, self._first]), p

    def _changed(self, values: Mapping[Key, float], initial: Mapping[Key, float]) -> tuple[np.ndarray, np.ndarray]:
        y, p = self._numbers.changed(values, initial)
        first = self._start_derivatives(p, map(name_of, initial)) if self._moving_start else self._first
        return np.concatenate([y, first]), p

    def _follow(
        self, y: np.ndarray, p: np.ndarray, progress: Callable[[float], None] | None
    ) -> tuple[Status, tuple[np.ndarray, float, dict[str, float], Raw]]:
        model = self._model
        workspace = model.workspace()
        status = workspace.drive(y, p, progress)
        final, t_final, stats, (rows, rest, path, events, _) = workspace.collect()
        w = workspace.arrays
        if status == Status.OK and w.counts.doubts:
            status = Status.NO_DERIVATIVE
        derivatives = Derivatives(
            self._columns,
            w.y[model.n_x : -1].copy(),
            w.observed.total.copy(),
            w.observed.seen.copy(),
            w.times.first,
            w.rest.copy(),
            status != Status.NO_DERIVATIVE,
            rest >= 0.0,
            not (stats["events"] or stats["kinks"]),
        )
        model.give_back(workspace)
        return status, (final, t_final, stats, Raw(rows, rest, path, events, derivatives))

    def _start_derivatives(self, p: np.ndarray, replaced: Iterable[str]) -> np.ndarray:
        """Return the derivatives of the initial state, of one case or of rows of them, column after column.

        They are zero for a state whose formula was `replaced` by a number.
        """
        columns = [*self.directions, *self._columns.pairs]
        return first_derivatives(self._start, columns, self._states, p, replaced).reshape(*p.shape[:-1], -1)

    def _starts_of(self, cases: CaseValues) -> tuple[np.ndarray, np.ndarray]:
        y, p = super()._starts_of(cases)
        first = self._start_derivatives(p, cases.initial) if self._moving_start else self._first
        return np.hstack([y, np.broadcast_to(first, (len(y), self._first.size))]), p

    def _run_cases(
        self, y: np.ndarray, p: np.ndarray, threads: int, progress: Callable[[float], None] | None
    ) -> CaseArrays:
        kept = super()._run_cases(y, p, threads, progress)
        kept.status[(kept.status == Status.OK) & (kept.doubts > 0)] = Status.NO_DERIVATIVE
        return kept

    def _batch(self, cases: CaseValues, kept: CaseArrays) -> Batch:
        lost = ~reached(kept.status)

        def masked(rows: Mapping[str, np.ndarray]) -> dict[str, np.ndarray]:
            return {name: np.where(lost, np.nan, row) for name, row in rows.items()}

        derivatives = Derivatives(
            self._columns,
            np.ascontiguousarray(kept.y[:, len(self._states) : -1].T),
            np.moveaxis(kept.total, 0, -1),
            kept.seen.T,
            self._model.first.times.first,
            kept.slopes.T,
            kept.status != Status.NO_DERIVATIVE,
            kept.rest >= 0.0,
            ~np.any(kept.counted[:, COUNTS.index("events") : COUNTS.index("kinks") + 1], axis=1),
        )
        of_outputs = {name: masked(rows) for name, rows in derivatives.outputs.items()}
        batch = super()._batch(cases, kept)
        return replace(batch, sensitivities=masked(derivatives.final), output_sensitivities=of_outputs)


def model_with_derivatives(
    scene: Scene, variations: Variations, observables: Observables, tolerance: float, settings: "Taylor"
) -> tuple[CompiledModel, list[Series]]:
    """Compile the motion and its derivatives; linear equations of several bodies by powers of their matrices."""
    rows = list(observables.rows)
    for e, row in enumerate(observables.rows[: variations.followed]):
        follows = Row(FOLLOW, row.expr, follows=e) if row.kind in (RANGE, TURN, CROSSINGS) else row
        rows += [follows] * variations.columns
    wide = Observables(tuple(rows), observables.row, observables.path, observables.events)
    automaton, budgets, fine = variations.automaton, (settings.max_steps, settings.max_events), MARGIN * tolerance
    try:
        if max(len(scene.system.q), len(scene.contacts)) == 1:
            raise NoRoute("one mass: its series are as cheap")
        variants = [linear_series(matrices(automaton), len(automaton.states), LINEAR_ORDER)]
        tolerances = LINEAR_TOLERANCE, fine
    except NoRoute:
        _, variants = series_of(automaton, tolerance, settings.order, len(scene.system.states))
        tolerances = fine, fine
    return series_model(scene, automaton, variants, wide, budgets, tolerances, variations), variants
