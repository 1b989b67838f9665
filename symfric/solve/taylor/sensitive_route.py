"""Runs with derivatives: the motion with its variational equations and the exact saltation at every event."""

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import replace

import numpy as np

from symfric.errors import NoRoute, SceneError
from symfric.lower.linear_modes import matrices
from symfric.lower.variational_equations import Variations, varied
from symfric.model.outputs import FOLLOW, RANGE, TURN, Row
from symfric.model.scene import Scene
from symfric.model.symbols import Key, name_of, nearest
from symfric.solve.batch import Batch, reached
from symfric.solve.case_values import CaseValues
from symfric.solve.loop.case_arrays import COUNTS, CaseArrays
from symfric.solve.loop.compiled_model import CompiledModel
from symfric.solve.loop.model import series_model
from symfric.solve.loop.stepping.linear_series import linear_series
from symfric.solve.loop.stepping.series import Series
from symfric.solve.loop.workspace import LoopArrays
from symfric.solve.lowered import LoweredScene
from symfric.solve.observables import Wanted
from symfric.solve.program import Numbers, check_tolerance
from symfric.solve.run import Run
from symfric.solve.sensitivities import Columns, Derivatives, first_derivatives
from symfric.solve.status import Status
from symfric.solve.taylor.expansion import is_branching
from symfric.solve.taylor.laned import Laned
from symfric.solve.taylor.route import MARGIN, Taylor, order_for, variants_of
from symfric.solve.widened import widened

LINEAR_ORDER, LINEAR_TOLERANCE = 28, 1e-16  # for linear equations, whose series are cheap to compile


class SensitiveProgram(Laned):
    """A scene compiled with its derivatives; may be run from any thread.

    Parameters
    ----------
    scene : Scene
    tolerance : float
        Tolerance of the motion and of its derivatives.
    settings : Taylor
    directions : sequence of str
        From `directions_of`.
    general : frozenset of str
        Parameters that will change and must not be built in.
    order : int
        1, or 2 for second derivatives of motions without events.
    """

    def __init__(
        self,
        scene: Scene,
        tolerance: float,
        settings: Taylor,
        directions: Sequence[str],
        general: frozenset[str] = frozenset(),
        order: int = 1,
    ):
        self.scene, self.tolerance, self.settings = scene, check_tolerance(tolerance), settings
        self.directions, self.order = tuple(directions), order
        self._states = tuple(s.name for s in scene.system.states)
        self.varied = general | {name for name in self.directions if name not in self._states}
        lowered = LoweredScene(scene, self.varied)
        wanted, automaton = lowered.wanted, lowered.automaton
        variations = varied(automaton, scene, self.directions, len(wanted.rows), second=order > 1)
        self._start, self.automaton, self._directions = variations.start, variations.automaton, len(self.directions)
        self._columns = Columns(self.directions, variations.pairs, len(self._states), wanted, scene.outputs)
        self._model, self._variants = sensitive_model(scene, variations, wanted, self.tolerance, settings)
        self._lane_models = []
        self.wider: dict[frozenset[str], SensitiveProgram] = {}
        self.built_in = lowered.built_in
        self._numbers = Numbers(scene, automaton.parameters, self.built_in)
        self._moving_start = any(not isinstance(v, float) for v in scene.initial.values())
        start, p = self._numbers.start
        self._first = self._start_derivatives(p, ())
        self._extra = {}
        self._given = np.concatenate([start, self._first]), p

    def __reduce__(self):
        """Pickle as the arguments of `prepare`."""
        return SensitiveProgram, (self.scene, self.tolerance, self.settings, self.directions, self.varied, self.order)

    def remade(self, names: frozenset[str]) -> "SensitiveProgram":
        """Return the program with the parameters `names` free instead of built in."""
        return SensitiveProgram(self.scene, self.tolerance, self.settings, self.directions, names, self.order)

    def run(
        self,
        values: Mapping[Key, float] | None = None,
        initial: Mapping[Key, float] | None = None,
        progress: Callable[[float], None] | None = None,
    ) -> Run:
        """Run with other parameter values or another start; see `TaylorProgram.run`."""
        values, initial = values or {}, initial or {}
        general = widened(self, values)
        if general is not None:
            return general.run(values, initial, progress)
        y, p = self._given
        if values or initial:
            y, p = self._numbers.changed(values, initial)
            first = self._start_derivatives(p, map(name_of, initial)) if self._moving_start else self._first
            y = np.concatenate([y, first])
        workspace = self._model.workspace()
        status = workspace.drive(y, p, progress)
        final, t_final, stats, raw = workspace.collect()
        if status == Status.OK and workspace.arrays.counts.doubts:
            status = Status.NO_DERIVATIVE
        raw = raw._replace(derivatives=self._derivatives(workspace.arrays, status))
        self._model.give_back(workspace)
        return Run(
            self.scene, dict(values), dict(initial), self.settings, self.tolerance, final, t_final, status, stats, raw
        )

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
        found = super()._run_cases(y, p, threads, progress)
        found.status[(found.status == Status.OK) & (found.doubts > 0)] = Status.NO_DERIVATIVE
        return found

    def _batch(self, cases: CaseValues, found: CaseArrays) -> Batch:
        lost = ~reached(found.status)

        def masked(rows: Mapping[str, np.ndarray]) -> dict[str, np.ndarray]:
            return {name: np.where(lost, np.nan, row) for name, row in rows.items()}

        derivatives = Derivatives(
            self._columns,
            np.ascontiguousarray(found.y[:, len(self._states) : -1].T),
            np.moveaxis(found.total, 0, -1),
            found.seen.T,
            self._model.first.times.first,
            found.slopes.T,
            found.status != Status.NO_DERIVATIVE,
            found.rest >= 0.0,
            ~np.any(found.counted[:, COUNTS.index("events") : COUNTS.index("kinks") + 1], axis=1),
        )
        of_outputs = {name: masked(rows) for name, rows in derivatives.outputs.items()}
        batch = super()._batch(cases, found)
        return replace(batch, sensitivities=masked(derivatives.final), output_sensitivities=of_outputs)

    def _derivatives(self, w: LoopArrays, status: Status) -> Derivatives:
        """Copy the derivatives of a run from its arrays."""
        n_x = len(self._states)
        known, smooth = status != Status.NO_DERIVATIVE, not (w.counts.events or w.counts.kinks)
        rests = w.clock.rest >= 0.0
        return Derivatives(
            self._columns,
            w.y[n_x:-1].copy(),
            w.observed.total.copy(),
            w.observed.seen.copy(),
            w.times.first,
            w.rest.copy(),
            known,
            rests,
            smooth,
        )


def directions_of(scene: Scene, names: Sequence[Key]) -> tuple[str, ...]:
    """Check the directions of differentiation and return their names.

    Raises
    ------
    SceneError
        If a name is neither a parameter nor a state, or occurs twice.
    """
    if isinstance(names, str):
        raise SceneError(f"sensitivities is {names!r}; give a sequence of names, such as [{names!r}]")
    found = tuple(name_of(n) for n in names)
    known = [*(s.name for s in scene.parameters), *(s.name for s in scene.system.states)]
    for name in found:
        if name not in known:
            raise SceneError(f"{name} is neither a parameter nor a state{nearest(name, known)}")
        if found.count(name) > 1:
            raise SceneError(f"{name} occurs twice in sensitivities")
    return found


def sensitive_model(
    scene: Scene, variations: Variations, wanted: Wanted, tolerance: float, settings: Taylor
) -> tuple[CompiledModel, list[Series]]:
    """Compile the motion and its derivatives; linear equations of several bodies by powers of their matrices."""
    rows = list(wanted.rows)
    for e, row in enumerate(wanted.rows[: variations.followed]):
        follows = Row(FOLLOW, row.expr, follows=e) if row.kind in (RANGE, TURN) else row
        rows += [follows] * variations.columns
    wide = Wanted(tuple(rows), wanted.row, wanted.path, wanted.events)
    automaton, budgets, fine = variations.automaton, (settings.max_steps, settings.max_events), MARGIN * tolerance
    try:
        if max(len(scene.system.q), len(scene.contacts)) == 1:
            raise NoRoute("one mass: its series are as cheap")
        variants = [linear_series(matrices(automaton), len(automaton.states), LINEAR_ORDER)]
        tolerances = LINEAR_TOLERANCE, fine
    except NoRoute:
        sticker = automaton.sticks.index(True) if sum(automaton.sticks) == 1 else -1
        order = settings.order or order_for(tolerance, len(scene.system.states), is_branching(automaton.field))
        variants, tolerances = variants_of(automaton, order, sticker), (fine, fine)
    return series_model(scene, automaton, variants, wide, budgets, tolerances, variations), variants
