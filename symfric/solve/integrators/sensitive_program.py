"""Runs with derivatives of scenes with stiff laws with memory: by an implicit integrator, at a cost like the run's.

Extremes are found by a run without derivatives; theirs are those of the observable at the time of the extreme.
"""

import math
from collections.abc import Callable, Mapping, Sequence
from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np

from symfric.errors import NoRoute
from symfric.locks import SYMBOLIC
from symfric.lower.automaton import automaton_of
from symfric.lower.variational_equations import starts_of
from symfric.model.outputs import INTEGRAL, RANGE, VALUES, HalfRange, Row
from symfric.model.scene import Scene
from symfric.model.symbols import Key, name_of
from symfric.solve.integrators.motion import Motion
from symfric.solve.integrators.one_by_one import OneByOne
from symfric.solve.integrators.program import IntegratorsProgram, check_tolerance
from symfric.solve.integrators.refusals import declines_derivatives
from symfric.solve.integrators.varied_motion import Followed, VariedMotion
from symfric.solve.lowered import LoweredScene
from symfric.solve.program import Numbers
from symfric.solve.run import Raw, Run
from symfric.solve.sensitivities import Columns, Derivatives, first_derivatives
from symfric.solve.status import Status
from symfric.solve.widened import widened

if TYPE_CHECKING:
    from symfric.solve.integrators.route import Integrators


class SensitiveIntegratorsProgram(OneByOne):
    """A scene prepared with its derivatives for an implicit integrator; may be run from any thread.

    Parameters
    ----------
    scene : Scene
    tolerance : float
        Of the motion and of its derivatives.
    settings : Integrators
    directions : sequence of str
        Parameters, and states for their initial values.
    general : frozenset of str
        Parameters that will change and must not be built in.

    Raises
    ------
    NoRoute
        If a contact can stick, or a force has kinks that outputs would see.
    """

    def __init__(
        self,
        scene: Scene,
        tolerance: float,
        settings: "Integrators",
        directions: Sequence[str],
        general: frozenset[str] = frozenset(),
    ):
        self.scene, self.tolerance, self.settings = scene, check_tolerance(tolerance), settings
        self.directions = tuple(directions)
        self._states = tuple(s.name for s in scene.system.states)
        self.varied = general | {name for name in self.directions if name not in self._states}
        lowered = LoweredScene(scene, self.varied)
        self._wanted, self.built_in = lowered.wanted, lowered.built_in
        self._integrals = [r for r in self._wanted.rows if r.kind == INTEGRAL]
        self._looked = [r for r in self._wanted.rows if r.kind != INTEGRAL]
        automaton = automaton_of(lowered.dynamics, [r.expr for r in (*self._integrals, *self._looked)])
        refusal = declines_derivatives(automaton, settings.plugin, scene)
        if refusal:
            raise NoRoute(f"only the route 'taylor' computes derivatives here, leave route=None: {refusal}")
        self._motion = VariedMotion(automaton, lowered, self.directions, len(self._integrals), self.tolerance)
        self._columns = Columns(self.directions, (), len(self._states), self._wanted, scene.outputs)
        self._numbers = Numbers(scene, automaton.parameters, self.built_in)
        self._start = starts_of(automaton, scene, self.directions)
        self.wider: dict[frozenset[str], SensitiveIntegratorsProgram] = {}

    def __reduce__(self):
        """Pickle as the arguments of `prepare`."""
        return SensitiveIntegratorsProgram, (self.scene, self.tolerance, self.settings, self.directions, self.varied)

    def remade(self, names: frozenset[str]) -> "SensitiveIntegratorsProgram":
        """Return the program with the parameters `names` free instead of built in."""
        return SensitiveIntegratorsProgram(self.scene, self.tolerance, self.settings, self.directions, names)

    @cached_property
    def _plain(self) -> IntegratorsProgram | None:
        """The program that finds extremes and the trajectory, if any are wanted."""
        kept = {n: o for n, o in self.scene.outputs.items() if o.keeps_path or o.keeps_events}
        ranges = {f"row {k}": HalfRange(r.expr) for k, r in enumerate(self._looked) if r.kind == RANGE}
        if not ranges and not self._wanted.path:
            return None
        with SYMBOLIC:
            return IntegratorsProgram(
                self.scene.wanting({**ranges, **kept}), self.tolerance, self.settings, self.varied
            )

    def run(
        self,
        values: Mapping[Key, float] | None = None,
        initial: Mapping[Key, float] | None = None,
        progress: Callable[[float], None] | None = None,
    ) -> Run:
        """Run with other parameter values or another start; see `symfric.solve.program.Compiled.run`."""
        values, initial = values or {}, initial or {}
        general = widened(self, values)
        if general is not None:
            return general.run(values, initial, progress)
        y, p = self._numbers.changed(values, initial)
        first = first_derivatives(self._start, self.directions, self._states, p, map(name_of, initial))
        given = dict(zip((*self._names, *self._states), (*p, *y), strict=True))
        unit = np.array([abs(float(given[name])) or 1.0 for name in self.directions])
        plain = None if self._plain is None else self._plain.follow(values, initial)
        times = self._times(plain)
        grid = np.unique(np.concatenate([np.zeros(0), *times.values()]))
        found = self._motion.follow(y, first.T, unit, p, grid, self.scene.horizon, self.settings.max_steps, progress)
        status = found.status if plain is None or plain.status == Status.OK else plain.status
        return self._collect(found, plain, times, grid, status, dict(values), dict(initial))

    @property
    def _names(self) -> list[str]:
        return [s.name for s in self._motion.automaton.parameters]

    def _times(self, plain: Motion | None) -> dict[Row, np.ndarray]:
        """Return the times at which the derivatives of every observable are needed."""
        found, ranges = {}, iter(range(len(self._looked)))
        for row in self._looked:
            if row.kind == VALUES:
                found[row] = np.array(row.times)
            else:
                assert plain is not None
                k = next(ranges)
                found[row] = np.zeros(2) if plain.at is None else plain.at[:, k]
        return found

    def _collect(self, found: Followed, plain: Motion | None, times, grid, status, values: dict, initial: dict) -> Run:
        n_s, n_x, rows = len(self.directions), len(self._states), self._wanted.rows
        total = np.zeros((len(rows) * (1 + n_s), 4))
        own: list[np.ndarray] = [np.zeros(0)] * len(rows)
        slopes: list[list[np.ndarray]] = [[np.zeros(0)] * n_s for _ in rows]
        for k, row in enumerate(rows):
            part = total[len(rows) + k * n_s : len(rows) + (k + 1) * n_s]
            if row.kind == INTEGRAL:
                j = n_x + self._integrals.index(row)
                total[k, 2], part[:, 2] = found.final[j], found.slopes[j]
                continue
            j, at = self._looked.index(row), np.searchsorted(grid, times[row])
            if row.kind == VALUES:
                own[k], slopes[k] = found.rows[at, j], list(found.by[at, j].T)
            else:
                total[k, :2], part[:, :2] = found.rows[at, j], found.by[at, j].T
        seen = [*own, *(e for columns in slopes for e in columns)]
        first = np.concatenate([[0], np.cumsum([e.size for e in seen])]).astype(int)
        derivatives = Derivatives(
            self._columns, found.slopes[:n_x].T.ravel(), total, np.concatenate([*seen, np.zeros(0)]), first,
            np.zeros(n_s), known=status == Status.OK, rests=False, smooth=True,
        )  # fmt: skip
        kept = {name: self._value(rows[k], total[k], own[k]) for name, k in self._wanted.row.items()}
        path = events = None
        if plain is not None and self._plain is not None:
            raw = self._plain.collect(plain, values, initial).raw
            path, events = raw.path, raw.events
        elif self._wanted.events:
            events = np.zeros(0), np.zeros((0, 3), dtype=np.int64)
        counts: dict[str, float] = {"pieces": 1, "steps": found.steps, "events": 0, "kinks": 0, "grazes": 0}
        return Run(
            base=self.scene,
            values=values,
            initial=initial,
            settings=self.settings,
            tolerance=self.tolerance,
            final=found.final[:n_x],
            t_final=found.t,
            status=status,
            stats=counts,
            raw=Raw(kept, math.nan, path, events, derivatives),
        )

    @staticmethod
    def _value(row: Row, total: np.ndarray, values: np.ndarray) -> Any:
        """Return what an output is made of; see `symfric.solve.run.Raw`."""
        if row.kind == VALUES:
            return values
        if row.kind == INTEGRAL:
            return float(total[2])
        low, high = float(total[0]), float(total[1])
        return (max(low, -high, 0.0), max(-low, high)) if row.magnitude else (low, high)
