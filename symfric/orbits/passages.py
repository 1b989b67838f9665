"""Passages of a scene: runs over a time with derivatives by the start and by parameters, in one of two ways.

With few states the variational equations are part of the run. With many states of a structure the run is recorded, and
the derivatives are followed along it, see `symfric.orbits.variations`; other scenes with many states are run several
times, each time with the derivatives by some of the states.
"""

from collections.abc import Sequence
from functools import cached_property
from typing import Any, NamedTuple, Protocol

import numpy as np
import sympy as sp

from symfric.errors import NoRoute, NotFound
from symfric.locks import SYMBOLIC
from symfric.lower.automaton import Automaton
from symfric.lower.channels import channels_of
from symfric.lower.variational_equations import MANY, varied
from symfric.model.rows import RANGE, TURN, Row
from symfric.model.scene import Scene
from symfric.orbits.end_states import EndStates
from symfric.orbits.recorded_steps import Recorder
from symfric.orbits.sizes import ranges_of
from symfric.orbits.variations import Variations
from symfric.solve.loop.model import series_model
from symfric.solve.loop.workspace import LoopArrays
from symfric.solve.observables import Observables
from symfric.solve.status import Status, early_end
from symfric.solve.taylor.derivatives import model_with_derivatives
from symfric.solve.taylor.expansion import is_branching
from symfric.solve.taylor.program import MARGIN, order_for, variants_of
from symfric.solve.taylor.route import Taylor

# budgets of one period; a motion off its orbit may need very many steps
BUDGETS = Taylor(max_steps=50_000, max_events=5_000)
_SLOTS = 6  # states by which one run differentiates, if there are many


class Passage(NamedTuple):
    """One evaluation of the flow map, with derivatives.

    Attributes
    ----------
    end : ndarray, shape (n_x,)
    by_start : ndarray, shape (n_x, n_x)
        Derivatives of the end by the start: the monodromy matrix if the passage is a period.
    by_value : ndarray, shape (n_x, n_p)
        Derivatives of the end by the parameters of the flow map.
    rate : ndarray, shape (n_x,)
        State derivative at the end.
    events : tuple of (float, int, int, int)
        Time, contact along a line or that opens, mode before and after.
    modes : tuple of int
        Of the contacts at the end.
    gaps : ndarray, shape (3 n_c + n_n,)
        Least local minimum of each guard (slip, reserve to either static bound; gap of each contact that opens);
        infinite if it has none.
    gaps_by_start, gaps_by_value : ndarray, shapes (3 n_c + n_n, n_x), (3 n_c + n_n, n_p)
    low, high : ndarray, shape (n_x,)
        Extremes of the states.
    ranges : ndarray, shape (n_x,)
        The largest minus the smallest value of every state, none of them zero; see `symfric.orbits.sizes.ranges_of`.
    doubtful : bool
        Whether the derivatives do not exist.
    sliders : tuple of (float, int, int, int)
        The events of the contacts behind springs.
    idle : tuple of int
        The states of springs whose sliders stick all the time: their mean elongation is free.
    """

    end: np.ndarray
    by_start: np.ndarray
    by_value: np.ndarray
    rate: np.ndarray
    events: tuple[tuple[float, int, int, int], ...]
    modes: tuple[int, ...]
    gaps: np.ndarray
    gaps_by_start: np.ndarray
    gaps_by_value: np.ndarray
    low: np.ndarray
    high: np.ndarray
    ranges: np.ndarray
    doubtful: bool
    sliders: tuple[tuple[float, int, int, int], ...] = ()
    idle: tuple[int, ...] = ()

    @property
    def changes(self) -> list[tuple[float, int, int, int]]:
        """All events in the order of time."""
        return sorted((*self.events, *self.sliders), key=lambda e: e[0])


Followed = tuple[Passage, np.ndarray, np.ndarray]  # with parameters and modes at the end


class Runs(Protocol):
    """How passages are computed."""

    def follow(self, y: np.ndarray, p: np.ndarray, time: float) -> Followed:
        """Return the passage from state y with parameters p over a time, and parameters and modes at its end.

        Raises
        ------
        NotFound
            If the run ends early.
        """
        ...


def runs_of(scene: Scene, automaton: Automaton, parameters: tuple[str, ...], tolerance: float) -> Runs:
    """Return the way for a scene.

    Parameters
    ----------
    scene : Scene
    automaton : Automaton
        Whose first rows are the gaps of its contacts along lines, three each, and whose next rows are its states.
    parameters : tuple of str
        Parameters to differentiate by.
    tolerance : float
    """
    if len(automaton.states) > MANY:
        try:
            return RecordedRun(scene, automaton, parameters, tolerance)
        except NoRoute:
            pass  # then in several runs
    return DirectedRuns(scene, automaton, parameters, tolerance)


def _observables(automaton: Automaton, scene: Scene) -> Observables:
    rows = [Row(RANGE, s) for s in scene.system.states]
    return Observables((*[Row(TURN, sp.S.Zero)] * automaton.layout.n_gaps, *rows), {}, False, True)


class DirectedRuns:
    """Runs with the variational equations in all directions, or in some of them at a time."""

    def __init__(self, scene: Scene, automaton: Automaton, parameters: tuple[str, ...], tolerance: float):
        n_x = len(automaton.states)
        self._automaton, self._parameters, self._ends = automaton, parameters, EndStates(automaton)
        self._slots = n_x if n_x <= MANY else _SLOTS
        directions = (*automaton.states[: self._slots], *parameters)  # the states' columns start with what a run needs
        self._n_rows = automaton.layout.n_gaps
        variations = varied(automaton, scene, directions, self._n_rows, constrained=True)
        observables = _observables(automaton, scene)
        self._model, _ = model_with_derivatives(scene, variations, observables, tolerance, BUDGETS)
        self._starts = [self._columns(k) for k in range(0, n_x, self._slots)]

    def follow(self, y: np.ndarray, p: np.ndarray, time: float) -> Followed:
        """See `Runs`."""
        followed: list[Followed] = []
        for first in self._starts:
            workspace = self._model.workspace()
            workspace.arrays.clock.t_end = time
            status = workspace.drive(np.concatenate([y, first]), p, None)
            w = workspace.arrays
            log = workspace.take_log()
            if status == Status.OK:
                followed.append((self._passage(w, log), w.p.copy(), w.m.copy()))
            self._model.give_back(workspace)
            if status != Status.OK:
                raise NotFound(early_end("the motion from this start", Status(status)))
        return self._together([passage for passage, _, _ in followed]), *followed[0][1:]

    def _columns(self, k: int) -> np.ndarray:
        """Return the start of the derivatives by the states from number k on, and by the parameters."""
        n_x = len(self._automaton.states)
        columns = np.zeros((self._slots + len(self._parameters), n_x))
        for i in range(min(self._slots, n_x - k)):
            columns[i, k + i] = 1.0
        return columns.ravel()

    def _together(self, parts: list[Passage]) -> Passage:
        """Return one passage with the derivatives by all states from several, each with those by some."""
        if len(parts) == 1:
            return parts[0]
        n_x = len(self._automaton.states)
        by_start = np.hstack([part.by_start for part in parts])[:, :n_x]
        gaps = np.hstack([part.gaps_by_start for part in parts])[:, :n_x]
        doubtful = any(part.doubtful for part in parts)
        return parts[0]._replace(by_start=by_start, gaps_by_start=gaps, doubtful=doubtful)

    def _passage(self, w: LoopArrays, log: tuple[np.ndarray, np.ndarray]) -> Passage:
        """Copy the results of a run from its arrays."""
        n_x, n_p = len(self._automaton.states), len(self._parameters)
        n_g, n_s = self._n_rows, self._slots + n_p
        n_e = n_x + n_g
        V = w.y[n_x:-1].reshape(n_s, n_x).T.copy()
        follow = w.observed.total[n_e:, 0].reshape(n_g, n_s).copy()
        by, gaps = ((e[:, : self._slots], e[:, self._slots :]) for e in (V, follow))
        return _passage_of(self._automaton, self._ends, w, log, by, gaps, bool(w.counts.doubts))


class RecordedRun:
    """One run, and the derivatives along its recorded steps."""

    def __init__(self, scene: Scene, automaton: Automaton, parameters: tuple[str, ...], tolerance: float):
        n_rows = automaton.layout.n_gaps
        channels = channels_of(scene, frozenset(parameters))
        self._automaton, self._ends = automaton, EndStates(automaton)
        self._other = scene, automaton, parameters, tolerance
        self._variations = Variations(automaton, channels, parameters, n_rows)
        order = order_for(tolerance, len(automaton.states), is_branching(automaton.field))
        budgets, fine = (BUDGETS.max_steps, BUDGETS.max_events), MARGIN * tolerance
        variants, observables = variants_of(automaton, order, -1), _observables(automaton, scene)
        self._model = series_model(scene, automaton, variants, observables, budgets, (fine, fine)).pausing()
        self._n_rows = n_rows

    @cached_property
    def _directed(self) -> DirectedRuns:
        """Runs without the eigenvectors of the free structure."""
        with SYMBOLIC:
            return DirectedRuns(*self._other)

    def follow(self, y: np.ndarray, p: np.ndarray, time: float) -> Followed:
        """See `Runs`."""
        recorder = Recorder(self._model, self._n_rows)
        status = recorder.drive(y, p, time)
        if status != Status.OK:
            raise NotFound(early_end("the motion from this start", Status(status)))
        w, n_x = recorder.arrays, len(y)
        try:
            followed = self._variations.along(recorder.steps(), p)
        except NoRoute:  # eigenvectors that are nearly dependent, as those of a structure that is free to move
            return self._directed.follow(y, p, time)
        by = tuple(np.split(followed.end, [n_x], axis=1))
        gaps = tuple(np.split(followed.rows, [n_x], axis=1))
        passage = _passage_of(self._automaton, self._ends, w, recorder.log(), by, gaps, followed.doubtful)
        return passage, w.p.copy(), w.m.copy()


def _passage_of(
    automaton: Automaton,
    ends: EndStates,
    w: LoopArrays,
    log: Any,
    by: Sequence[Any],
    gaps: Sequence[Any],
    doubtful: bool,
) -> Passage:
    """Return the passage of a run."""
    n_x, n_g = len(automaton.states), gaps[0].shape[0]
    if doubtful and not np.any(by[0]):  # they grew beyond all bounds, and were given up
        by = [np.full_like(e, np.nan) for e in by]
    low, high = w.observed.total[n_g : n_g + n_x, 0].copy(), w.observed.total[n_g : n_g + n_x, 1].copy()
    events = tuple(zip(log[0].tolist(), *log[1].T.tolist(), strict=True))
    return Passage(
        end=w.y[:n_x].copy(),
        by_start=by[0],
        by_value=by[1],
        rate=ends.rate(w.y, w.y.item(-1), w.p, w.m),
        events=tuple(e for e in events if e[1] in ends.contacts),
        sliders=tuple(e for e in events if e[1] not in ends.contacts),
        modes=ends.modes(w.m),
        gaps=w.observed.total[:n_g, 0].copy(),
        gaps_by_start=gaps[0],
        gaps_by_value=gaps[1],
        low=low,
        high=high,
        ranges=ranges_of(low, high, automaton.n_q),
        doubtful=doubtful,
    )
