"""Motions of stiff laws with their derivatives at given times."""

import math
from collections import deque
from collections.abc import Callable, Sequence
from typing import NamedTuple

import casadi as ca
import numpy as np

from symfric.locks import SYMBOLIC
from symfric.long_calls import tell_of_run
from symfric.lower.automaton import Automaton, arguments_of
from symfric.solve.input_segments import segments
from symfric.solve.integrators.implicit.stretch import stretch_of
from symfric.solve.integrators.implicit.variational_flow import Scales, VariationalFlow
from symfric.solve.integrators.integrated_piece import SegmentStart
from symfric.solve.integrators.mode_functions import signs_evaluated
from symfric.solve.integrators.sizes import first_sizes, make_sizing, rough_motion, sizes_along
from symfric.solve.lowered import LoweredScene
from symfric.solve.status import Status
from symfric.time_limit import check_time

_SAFETY = 1e-3  # local tolerance relative to the tolerance, since errors at kinks are far above their estimate
_FINEST, _LOGARITHMIC = 1e-12, 1e-11  # smallest local tolerances, the second of velocities integrated as logarithms
_AGAIN = (1.0, 10.0, 100.0)  # by how much the local tolerance is coarsened where a finer one cannot be reached
_COARSER = (
    0.3  # factor of the tolerance of derivatives in layers; with a third of it steps fail, ten times cost accuracy
)
_KEPT = 4  # most flows kept


class Followed(NamedTuple):
    """A motion with its derivatives at some times.

    Attributes
    ----------
    status : Status
    t : float
        Of the end.
    final : ndarray, shape (n,)
        States and integrals at the end.
    slopes : ndarray, shape (n, n_s)
    rows, by : ndarray, shapes (n_t, n_r), (n_t, n_r, n_s)
        Observables that are no integrals, at the times, and their derivatives at fixed times; NaN if not reached.
    steps : int
    """

    status: Status
    t: float
    final: np.ndarray
    slopes: np.ndarray
    rows: np.ndarray
    by: np.ndarray
    steps: int


class VariedMotion:
    """Motions of an automaton without jumps, with derivatives in some directions, from any thread.

    Parameters
    ----------
    automaton : Automaton
        Whose first rows are integrated.
    lowered : LoweredScene
    directions : sequence of str
    n_integrals : int
    tolerance : float
    """

    def __init__(
        self, automaton: Automaton, lowered: LoweredScene, directions: Sequence[str], n_integrals: int, tolerance: float
    ) -> None:
        self.automaton, self.n_integrals = automaton, n_integrals
        self._field, self._scene = signs_evaluated(automaton), lowered.scene
        self.names = names = [s.name for s in automaton.parameters]
        chosen = np.zeros((automaton.field.nnz_in(2), len(directions)))
        for k, name in enumerate(directions):
            if name in names:
                chosen[names.index(name), k] = 1.0
        stretch = stretch_of(lowered.dynamics, automaton)
        self.local = max(_SAFETY * tolerance, _LOGARITHMIC if stretch else _FINEST)
        self._chosen, self._stretch = chosen, stretch
        self._bristles, self._stiffness = self._stiff(lowered)
        self._sizing = make_sizing(automaton, self._field, n_integrals, self._scene.horizon)
        self._look = self._rows()
        self._idle: deque[VariationalFlow] = deque(maxlen=_KEPT)

    def _stiff(self, lowered: LoweredScene) -> tuple[list[int], ca.Function]:
        """Return the places of the states of bristles, and the function of the parameters for their stiffnesses."""
        model, places, graphs = lowered.dynamics, [], []
        for contact in self._scene.contacts:
            memory = contact.law.memory
            if memory and memory.slowest is None:
                places += [self.automaton.states.index(z.name) for z in contact.states]
                graphs += [model.read(memory.stiffness)] * len(contact.states)
        p = ca.SX.sym("p", self._field.nnz_in(2))
        return places, ca.Function("stiffness", [p], [ca.substitute(ca.vertcat(*graphs), model.p, p)])

    def _coarser(self, size: np.ndarray, p: np.ndarray) -> np.ndarray:
        """Return how much coarser the derivatives of every state are taken: those of bristles where a layer is short.

        Its duration goes with the root of the stiffness, which is measured over the way of the body.
        """
        factors, way = np.ones((size.size, 1)), np.max(size[: self.automaton.n_q], initial=0.0)
        if self._bristles:
            stiff = np.abs(np.array(self._stiffness(p)).ravel()) * way
            factors[self._bristles, 0] = np.maximum(1.0, _COARSER * np.sqrt(stiff))
        return factors

    def _rows(self) -> ca.Function:
        """Return ``(y, V, t, p, m) -> (r, dr)`` for the rows that are not integrated."""
        field, n_s = self._field, self._chosen.shape[1]
        y, t, p, m = arguments_of(field)
        V = ca.SX.sym("V", y.numel(), n_s)
        rows = ca.vertcat(field(y, t, p, m)[2])[self.n_integrals :, :]
        by = ca.jacobian(rows, y) @ V + ca.jacobian(rows, p) @ self._chosen
        return ca.Function("rows", [y, V, t, p, m], [ca.densify(rows), ca.densify(by)])

    def _lease(self) -> VariationalFlow:
        try:
            flow = self._idle.pop()
        except IndexError:
            with SYMBOLIC:
                flow = VariationalFlow(self._field, self.n_integrals, self._chosen, self._stretch)
                if self._stretch is None and not self.automaton.inputs:
                    flow.rough = rough_motion(self._field, self.n_integrals, self._scene.horizon)
        flow.steps = 0
        return flow

    def follow(
        self,
        y: np.ndarray,
        V: np.ndarray,
        unit: np.ndarray,
        p: np.ndarray,
        times: np.ndarray,
        horizon: float,
        most: int,
        progress: Callable[[float], None] | None = None,
    ) -> Followed:
        """Return the motion from a state with derivatives V, (n_x, n_s), at increasing times and at the horizon.

        Parameters
        ----------
        y, V, unit
            The start, its derivatives, and the sizes of the quantities to differentiate by.
        p : ndarray
            Parameters, without the inputs.
        times : ndarray, shape (n_t,)
        horizon : float
        most : int
            Steps.
        progress : callable, optional
        """
        automaton, n_s = self.automaton, self._chosen.shape[1]
        state, V = np.append(y, np.zeros(self.n_integrals)), np.vstack([V, np.zeros((self.n_integrals, n_s))])
        m, n_r = np.ones(automaton.layout.n_mode), self._look.numel_out(0)
        rows, by = np.full((times.size, n_r), math.nan), np.full((times.size, n_r, n_s), math.nan)
        edges, inputs = segments([self._scene.inputs[s] for s in automaton.inputs], horizon)
        flow, t, status = self._lease(), 0.0, Status.OK
        given = np.concatenate([p, inputs[0]])
        size = first_sizes(self._sizing, y, 0.0, given, m)
        if flow.rough is not None:
            size = sizes_along(flow.rough, size, y, given, m, horizon)
        scales = Scales(unit, self._coarser(size, given))
        self._note(rows, by, np.flatnonzero(times == 0.0), (state[:, None], V[None]), np.zeros(1), given, m)
        for k, row in enumerate(inputs):
            given, end = np.concatenate([p, row]), min(edges[k + 1], horizon)
            size = np.maximum(size, np.abs(state))
            inside = np.flatnonzero((t < times) & (times <= end))
            grid = np.unique(np.append(times[inside], end))
            try:
                part = self._part(flow, SegmentStart(t, state, given, m, size), V, scales, grid)
            except RuntimeError:
                status = Status.INTEGRATOR
                break
            at = np.searchsorted(grid, times[inside])
            self._note(rows, by, inside, (part[0][:, at], part[1][at]), times[inside], given, m)
            t, state, V = end, part[0][:, -1], part[1][-1]
            check_time()
            tell_of_run(t / horizon)
            if progress is not None:
                progress(t / horizon)
            if flow.steps > most:
                status = Status.STEP_BUDGET
                break
        steps = flow.steps
        self._idle.append(flow)
        return Followed(status, t, state, V, rows, by, steps)

    def _part(
        self, flow: VariationalFlow, start: SegmentStart, V: np.ndarray, scales: Scales, grid: np.ndarray
    ) -> tuple[np.ndarray, np.ndarray]:
        """Return states and derivatives at times before the next change of an input."""
        for more in _AGAIN[:-1]:
            try:
                return flow.follow(start, V, scales, grid, more * self.local)
            except RuntimeError:
                continue
        return flow.follow(start, V, scales, grid, _AGAIN[-1] * self.local)

    def _note(
        self,
        rows: np.ndarray,
        by: np.ndarray,
        places: np.ndarray,
        motion: tuple[np.ndarray, np.ndarray],
        times: np.ndarray,
        p: np.ndarray,
        m: np.ndarray,
    ) -> None:
        """Store observables and their derivatives at some times."""
        n_x, n_r = self._field.nnz_in(0), rows.shape[1]
        if not n_r:
            return
        for j, k in enumerate(places):
            r, slope = self._look(motion[0][:n_x, j], motion[1][j][:n_x], times[j], p, m)
            rows[k], by[k] = np.array(r).ravel(), np.array(slope).reshape(n_r, -1)
