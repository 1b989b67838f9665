"""Common parts of the compiled routes: the numbers of a run, and programs that run again with other numbers."""

import math
from collections.abc import Callable, Collection, Iterable, Mapping
from functools import cached_property
from types import MappingProxyType
from typing import Any

import numpy as np
import sympy as sp

from symfric.errors import SceneError
from symfric.model.numeric import numeric
from symfric.model.rows import INTEGRAL
from symfric.model.scene import Scene
from symfric.model.symbols import Key, finite, name_of, nearest
from symfric.solve.batch import Batch, make_batch, merged
from symfric.solve.case_values import CaseValues
from symfric.solve.gap_starts import GapStarts
from symfric.solve.inertia import Inertia
from symfric.solve.loop.case_arrays import COUNTS, CaseArrays
from symfric.solve.loop.cases import rows_of, run_cases
from symfric.solve.loop.compiled_model import CompiledModel
from symfric.solve.lowered import LoweredScene
from symfric.solve.protocol import Program, Route
from symfric.solve.requirements import Requirements
from symfric.solve.run import Raw, Run
from symfric.solve.status import Status

FINEST, COARSEST = 1e-16, 0.1  # tolerances


def check_tolerance(tolerance: float) -> float:
    """Return the tolerance as a float; raise unless double precision can reach it."""
    tolerance = finite(tolerance, "tolerance")
    if not FINEST <= tolerance <= COARSEST:
        raise SceneError(f"tolerance is {tolerance}; it must lie between {FINEST:g} and {COARSEST:g}")
    return tolerance


class Numbers:
    """Initial state and parameters of a scene as arrays, with the changes of a run applied."""

    def __init__(self, scene: Scene, parameters: tuple[sp.Symbol, ...], built_in: dict[str, float]) -> None:
        numbers = scene.numbers()
        self._scene, self._built_in = scene, built_in
        self.start = np.array([numbers[s] for s in scene.system.states]), np.array([numbers[s] for s in parameters])
        self._place = {s.name: k for k, s in enumerate(parameters)}
        self._states = tuple(s.name for s in scene.system.states)
        moving = any(not isinstance(v, float) for v in scene.initial.values())
        starts = tuple(sp.sympify(v) for v in scene.initial.values())
        self._start_of = numeric(scene.parameters, starts) if moving else None
        equations = set().union(*(e.free_symbols for e in (*scene.system.expressions, *scene.clocked, *scene.contacts)))
        self._starters = {s.name for s in scene.parameters if s not in equations}
        self._inertia, self._gaps, self._required = Inertia(scene), GapStarts(scene), Requirements(scene)

    def changed(self, values: Mapping[Key, float], initial: Mapping[Key, float]) -> tuple[np.ndarray, np.ndarray]:
        """Return initial state and parameters with the changes of a run, which are checked as in the scene."""
        y, p = (a.copy() for a in self.start)
        for key, value in values.items():
            name = name_of(key)
            number = finite(value, "the value of ", name)
            if name in self._place:
                p[self._place[name]] = number
            elif name not in self._built_in:
                self._scene.parameter(key)  # raises with a hint if the name is unknown
        if values and self._start_of:
            y = self._moved(self._start_of, {name_of(k): v for k, v in values.items()})
        for key, value in initial.items():
            name = name_of(key)
            if name not in self._states:
                raise SceneError(f"{name} is no state{nearest(name, self._states)}")
            y[self._states.index(name)] = finite(value, "the initial value of ", name)
        if self._inertia.names:
            self._check_mass(y, values, initial)
        for rules in (self._gaps, self._required):
            if rules.names:
                self._check(rules, y, values, initial)
        return y, p

    def _check(
        self, rules: GapStarts | Requirements, y: np.ndarray, values: Mapping[Key, float], initial: Mapping[Key, float]
    ) -> None:
        """Raise if a change of values or of the start y (n_x,) breaks a rule."""
        given = {name_of(k): float(v) for k, v in values.items()}
        if self._moved_names(rules.names, given.keys() | {name_of(k) for k in initial}):
            wrong, said = rules.wrong(given | dict(zip(self._states, y.tolist(), strict=True)))
            if wrong.any():
                raise SceneError(said)

    def _check_mass(self, y: np.ndarray, values: Mapping[Key, float], initial: Mapping[Key, float]) -> None:
        """Raise unless the mass is positive definite at the start y (n_x,), if a change concerns it."""
        given = {name_of(k): float(v) for k, v in values.items()}
        if not self._moved_names(self._inertia.names, given.keys() | {name_of(k) for k in initial}):
            return
        if not self._inertia.definite(given | dict(zip(self._states, y.tolist(), strict=True))):
            told = ", ".join(f"{n} = {v:g}" for n, v in given.items() if n in self._inertia.names)
            raise SceneError(f"the mass matrix is not positive definite at the start{told and f', with {told}'}")

    def _moved_names(self, names: frozenset[str], changed: Collection[str]) -> bool:
        """Whether a change of some parameters and states concerns, at the start, what depends on others."""
        return not names.isdisjoint(changed) or (self._start_of is not None and not names.isdisjoint(self._states))

    def _moved(self, start_of: Callable[..., Any], values: dict[str, float]) -> np.ndarray:
        """Return the initial state for other parameter values."""
        if not values.keys() <= self._starters:
            self._scene.where(values)
        numbers = self._starts(start_of, {n: np.array([v], dtype=float) for n, v in values.items()})
        return np.array([finite(float(v[0]), f"the start of {n}") for n, v in zip(self._states, numbers, strict=True)])

    def _starts(self, start_of: Callable[..., Any], values: dict[str, np.ndarray]) -> list[np.ndarray]:
        """Return the start of each state, (n,); NumPy rounds rows, of one number too, in the same way, not numbers."""
        numbers = start_of(*(values.get(s.name, v) for s, v in self._scene.values.items()))
        size = len(next(iter(values.values())))
        return [np.broadcast_to(v, (size,)) for v in numbers]

    def rows(self, cases: CaseValues) -> tuple[np.ndarray, np.ndarray]:
        """Return starts (n, states) and parameters (n, ...) of many cases.

        A start given by a formula may be NaN; so is that of a case whose mass is not positive definite, that starts
        with a negative gap, or that has a number of a contact or a law which must be positive and is not.

        Raises
        ------
        SceneError
            If a name is unknown.
        """
        y, p = (np.tile(a, (cases.size, 1)) for a in self.start)
        for name, row in cases.values.items():
            if name in self._place:
                p[:, self._place[name]] = row
            elif name not in self._built_in:
                self._scene.parameter(name)
        if cases.values and self._start_of:
            rows = {n: np.full(cases.size, v, dtype=float) for n, v in cases.values.items()}
            y[:] = np.transpose(self._starts(self._start_of, rows))
        for name, row in cases.initial.items():
            if name not in self._states:
                raise SceneError(f"{name} is no state{nearest(name, self._states)}")
            y[:, self._states.index(name)] = row
        changed = cases.values.keys() | cases.initial.keys()
        for rules in (self._gaps, self._required):
            if self._moved_names(rules.names, changed):
                y[rules.wrong({**cases.values, **dict(zip(self._states, y.T, strict=True))})[0]] = np.nan
        if self._moved_names(self._inertia.names, changed):
            y[~self._inertia.definite({**cases.values, **dict(zip(self._states, y.T, strict=True))})] = np.nan
        return y, p


class Compiled(Program):
    """Base of the programs of compiled loops.

    A route sets the attributes declared here. The entries of `_extra` are added to the counts of a run.
    """

    _numbers: Numbers
    _given: tuple[np.ndarray, np.ndarray]  # the scene's own start and parameters, always the same arrays
    _model: CompiledModel
    _extra: Mapping[str, float] = MappingProxyType({})

    def __init__(self, lowered: LoweredScene, tolerance: float, settings: Route) -> None:
        super().__init__(lowered, check_tolerance(tolerance), settings)

    def _run(
        self, values: dict[Key, float], initial: dict[Key, float], progress: Callable[[float], None] | None
    ) -> Run:
        y, p = self._changed(values, initial) if values or initial else self._given
        status, (final, t_final, stats, raw) = self._follow(y, p, progress)
        stats.update(self._extra)
        if self._integrals and status == Status.OK and any(math.isnan(raw.rows[name]) for name in self._integrals):
            status = Status.NOT_FINITE
        return Run(self.scene, values, initial, self.settings, self.tolerance, final, t_final, status, stats, raw)

    @cached_property
    def _integrals(self) -> tuple[str, ...]:
        """Outputs that are integrals, which have no value where their expression has no series, as a length at rest."""
        wanted = self._model.wanted
        return tuple(name for name, k in wanted.row.items() if wanted.rows[k].kind == INTEGRAL)

    def _changed(self, values: Mapping[Key, float], initial: Mapping[Key, float]) -> tuple[np.ndarray, np.ndarray]:
        """Return start and parameters of a run, as the loop takes them."""
        return self._numbers.changed(values, initial)

    def _follow(
        self, y: np.ndarray, p: np.ndarray, progress: Callable[[float], None] | None
    ) -> tuple[Status, tuple[np.ndarray, float, dict[str, float], Raw]]:
        """Run the loop; return the status, the final state and its time, counts, and what outputs are made of."""
        return self._model.run(y, p, progress)

    def expect(self, names: Iterable[str], cases: int) -> None:
        """Get ready for so many cases in all with other values of some parameters, which may come in parts."""
        general = self.widened(dict.fromkeys(names, math.nan)) or self  # NaN differs from every value
        if isinstance(general, Compiled):
            general._get_ready(cases)

    def _get_ready(self, cases: int) -> None:
        """Prepare what pays for so many cases."""

    def _map(self, cases: CaseValues, threads: int, progress: Callable[[float], None] | None) -> Batch:
        other = np.zeros(cases.size, dtype=bool)  # cases with values that differ from built-in ones
        for name, row in cases.values.items():
            if name in self.built_in:
                other |= self.built_in[name] != row
        if not np.any(other):
            return self._map_own(cases, threads, progress)
        general = self.widened(dict.fromkeys(cases.values, math.nan))  # NaN differs from every value
        assert general is not None  # since some differ
        if np.all(other):
            return general.map(cases.values, cases.initial, threads, progress)
        first, second = cases.some(other), cases.some(~other)
        middle = first.size / cases.size
        apart = general.map(first.values, first.initial, threads, _between(progress, 0.0, middle))
        return merged(
            cases, [(other, apart), (~other, self._map_own(second, threads, _between(progress, middle, 1.0)))]
        )

    def _map_own(self, cases: CaseValues, threads: int, progress: Callable[[float], None] | None) -> Batch:
        """Run cases whose built-in values are unchanged."""
        return self._batch(cases, self._run_cases(*self._starts_of(cases), threads, progress))

    def _starts_of(self, cases: CaseValues) -> tuple[np.ndarray, np.ndarray]:
        """Return starts and parameters of cases, row by row, as the loop takes them."""
        return self._numbers.rows(cases)

    def _batch(self, cases: CaseValues, kept: CaseArrays) -> Batch:
        """Return the results of cases from what their loop has left."""
        model = self._model
        stats: dict[str, np.ndarray] = dict(zip(COUNTS, np.ascontiguousarray(kept.counted.T), strict=True))
        stats |= {name: np.full(cases.size, value) for name, value in self._extra.items()}
        final, t_final = kept.y[:, : model.n_x].T, kept.y[:, -1].copy()
        rows = rows_of(model.wanted, kept)
        for name in self._integrals:
            kept.status[(kept.status == Status.OK) & np.isnan(rows[name])] = Status.NOT_FINITE
        return make_batch(self.scene, cases, final, t_final, kept.status, stats, rows, kept.rest)

    def _run_cases(
        self, y: np.ndarray, p: np.ndarray, threads: int, progress: Callable[[float], None] | None
    ) -> CaseArrays:
        return run_cases(self._model, y, p, threads, progress)


def _between(progress: Callable[[float], None] | None, low: float, high: float) -> Callable[[float], None] | None:
    """Return a progress function for a part of the work, from `low` to `high` of the whole."""
    if progress is None:
        return None
    tell = progress
    return lambda part: tell(low + (high - low) * part)
