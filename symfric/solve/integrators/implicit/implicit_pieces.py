"""Stiff laws with memory beside contacts that can stick: an implicit integrator in pieces, each up to the next event.

Directions and kinks of the laws with memory are computed from the state, those of the contacts that can stick are held
until their guards fall. Between the nodes of a piece are cubics through the values: of stiff equations the derivatives
at the nodes would be no help, they magnify the errors of the values.
"""

import math
from dataclasses import replace

import casadi as ca
import numpy as np

from symfric.locks import SYMBOLIC
from symfric.lower.automaton import Automaton, arguments_of
from symfric.solve.integrators.dense_output.hermite import first_fall_of
from symfric.solve.integrators.dense_output.refined_grid import cubics
from symfric.solve.integrators.implicit.stretch import inside, outside, stretched
from symfric.solve.integrators.integrated_piece import IntegratedPiece, SegmentStart
from symfric.solve.integrators.mode_functions import ModeEquations, mode_integrator
from symfric.solve.integrators.step_control import growth, shrinkage

_SAFETY, _FINEST = 1e-3, 1e-11  # local tolerance relative to that of the run, and the smallest
_NODES = 32  # of a piece
_ORDER = 4  # power of the length with which the error of cubics goes
_PARTS = 16  # pieces of which the horizon has at least so many
_STRETCHED = 1e6  # scaled length of a motion, since CasADi takes times less than 1e-9 apart for one
_BETWEEN = 10  # error allowed between the nodes, in tolerances
_SHORTEST = 1e-12  # piece, relative to the horizon, within which layers are not resolved
_INSTANT = 16 * _NODES  # roundings of time in which nothing changes
_NEWTON = 6  # most corrections of an event time


class ImplicitPieces:
    """The integrators of an automaton, with step counts; for one run at a time."""

    rough = None  # sizes come from the start

    def __init__(self, equations: ModeEquations) -> None:
        field, automaton, n_integrals, settings, tolerance, horizon, stretch = equations
        self.stretch, self.settings, self.tolerance = stretch, settings, tolerance
        self.local = max(_SAFETY * tolerance, _FINEST)
        self.n_x, self._watched, self._horizon = len(automaton.states), _events(automaton), horizon
        self._field, self._n_integrals = stretched(field, stretch), n_integrals
        self._look = _values(self._field, n_integrals)
        self._piece, self._single = (self._integrator(k) for k in (_NODES, 1))
        self.begin()

    def _integrator(self, nodes: int) -> ca.Function:
        grid, s = _STRETCHED * np.linspace(0, 1, nodes + 1)[1:], self.settings
        with SYMBOLIC:
            return mode_integrator(
                self._field, self._n_integrals, "cvodes", s.max_step, self.local, self._horizon, 0, grid, s.max_steps
            )

    def begin(self) -> None:
        """Reset the data of the previous run."""
        self.steps = 0

    def _at(self, integrator: ca.Function, start: SegmentStart, span: float) -> np.ndarray:
        """Return the integrated variables at the nodes of an integrator; raise RuntimeError if it fails."""
        data = np.concatenate([start.p, start.m, start.size, [start.t, span / _STRETCHED]])
        states = np.array(integrator(x0=start.state / start.size, p=data)["xf"]) * start.size[:, None]
        self.steps += integrator.stats().get("nsteps", 0)
        if not np.all(np.isfinite(states)):
            raise RuntimeError("the motion left the finite numbers")
        return states

    @np.errstate(all="ignore")  # beyond a guard the motion may overflow
    def advance(
        self, start: SegmentStart, end: float, reach: float, watched: bool, times: np.ndarray | None = None
    ) -> IntegratedPiece | None:
        """Return the motion up to `end`, to the first guard that falls, or about to `reach`; None if that fails."""
        begun, at_start = inside(self.stretch, start), start.t
        shortest = _SHORTEST * self._horizon
        reach = max(min(reach, self._horizon / _PARTS), shortest)
        while True:
            left = end - at_start
            if left <= _INSTANT * np.spacing(end):
                return outside(self.stretch, self._instant(begun, end, reach), start.p)
            span, piece, error = min(reach, left), None, math.inf
            try:
                piece, excess, noise = self._cubics(begun, start.size, at_start + span if span < left else end)
                if excess <= 1:
                    cut = self._cut(begun, start.size, piece, noise)
                    if cut is not None:
                        return outside(
                            self.stretch, replace(cut, reach=max(reach, span * growth(excess, _ORDER))), start.p
                        )
                error = excess
            except RuntimeError:
                pass  # a piece that cannot be computed is too long
            if span <= shortest:
                return None if piece is None else outside(self.stretch, self._layer(piece, reach), start.p)
            reach = max(span * shrinkage(error, _ORDER), shortest)

    def _layer(self, piece: IntegratedPiece, reach: float) -> IntegratedPiece:
        """Return a piece too short to resolve what happens in it: guards that fell in it did so at its end."""
        left = np.where(self._watched, piece.rows[0][: self._watched.size, -1], math.inf)
        fell = int(np.argmin(left)) if np.any(left < 0) else -1
        return replace(piece, reach=reach, fell=fell)

    def _cubics(self, start: SegmentStart, sizes: np.ndarray, end: float) -> tuple[IntegratedPiece, float, np.ndarray]:
        """Return a piece, the error of its cubics over the allowed one, and the noise of its guards."""
        states = self._at(self._piece, start, end - start.t)
        t = np.linspace(start.t, end, _NODES + 1)
        state = np.column_stack([start.state, states])
        rows, blur = (np.array(e) for e in self._look(state[: self.n_x], t[None, :], start.p, start.m, start.size))
        seen = state if self.stretch is None else self.stretch.outside(state, t, start.p)
        values = np.concatenate([seen[: self.n_x], rows])
        if not np.all(np.isfinite(values)):
            raise RuntimeError("the motion left the finite numbers")
        n_g, n = self._watched.size, self.n_x
        noise = self.local * np.max(np.concatenate([sizes[:n, None] + np.abs(seen[:n]), blur]), axis=1)
        error = _middle_errors(t, values)
        allowed = _BETWEEN * self.tolerance * np.max(np.abs(values), axis=1) + 10 * noise
        ignored = np.concatenate([np.zeros(n, dtype=bool), ~self._watched, np.zeros(len(rows) - n_g, dtype=bool)])
        excess = np.max(np.where(ignored, 0.0, error / np.maximum(allowed, 1e-300)))
        none = np.zeros((n, t.size))
        piece = IntegratedPiece(t, state, none, none, (rows,), math.inf, cubic=True)
        return piece, float(excess), (2 * noise + error / 16)[n : n + n_g]

    def _instant(self, start: SegmentStart, end: float, reach: float) -> IntegratedPiece:
        """Return a motion over a time of a few roundings, in which nothing changes."""
        t, state = np.array([start.t, end]), np.column_stack([start.state, start.state])
        rows = np.array(self._look(state[: self.n_x], t[None, :], start.p, start.m, start.size)[0])
        none = np.zeros_like(state[: self.n_x])
        return IntegratedPiece(t, state, none, none, (rows, np.zeros_like(rows), np.zeros_like(rows)), reach)

    def _cut(
        self, start: SegmentStart, sizes: np.ndarray, piece: IntegratedPiece, noise: np.ndarray
    ) -> IntegratedPiece | None:
        """Return the piece up to the first watched guard that falls; None if the time of that is missed."""
        kept = np.flatnonzero(self._watched)
        guards, below = piece.rows[0][kept], noise[kept]
        if not kept.size:
            return piece
        h = np.diff(piece.t)
        coefficients = cubics(piece.t, guards) * (h[:, None, None] ** np.arange(4))
        fall = first_fall_of(piece.t, coefficients, below)
        if fall is None:
            return piece
        k, t = fall
        index = int(kept[k])
        root = self._root(start, piece, coefficients[:, k], t, index, below[k])
        if root is None:
            return None
        if root - start.t <= _INSTANT * np.spacing(root):
            return replace(self._instant(start, start.t, math.inf), fell=index)
        return replace(self._cubics(start, sizes, root)[0], fell=index)

    def _root(
        self, start: SegmentStart, piece: IntegratedPiece, c: np.ndarray, t: float, index: int, below: float
    ) -> float | None:
        """Return the time at which a guard falls, from one near it."""
        first = t
        for _ in range(_NEWTON):
            if t - start.t <= _INSTANT * np.spacing(t):
                return t
            state = self._at(self._single, start, t - start.t)
            value = float(self._look(state[: self.n_x], t, start.p, start.m, start.size)[0][index])
            if abs(value) <= below:
                return t
            k = int(np.clip(np.searchsorted(piece.t, t, side="right") - 1, 0, c.shape[0] - 1))
            h = piece.t[k + 1] - piece.t[k]
            s = (t - piece.t[k]) / h
            slope = float((c[k, 1] + s * (2 * c[k, 2] + 3 * s * c[k, 3])) / h)
            t = min(max(t - value / slope, start.t), piece.t.item(-1)) if slope else math.nan
            if not abs(t - first) <= h:
                return None
        return None


def _events(automaton: Automaton) -> np.ndarray:
    """Return which guards end a piece, (n_g,): of contacts that can stick or are behind springs, and of loads."""
    layout = automaton.layout
    return np.concatenate(
        [np.repeat(automaton.sticks, 2), np.zeros(layout.switches), np.ones(layout.n_guards - layout.first_load)]
    ).astype(bool)


def _values(field: ca.Function, n_integrals: int) -> ca.Function:
    """Return ``(y, t, p, m, size) -> (r, b)``: guards and rows not integrated, and how much they may be in error.

    That is by how much they change at most if every variable changes by ``size + |y|``.
    """
    y, t, p, m = arguments_of(field)
    size = ca.SX.sym("size", y.numel() + n_integrals)
    _, guards, rows = field(y, t, p, m)
    rows = ca.vertcat(guards, rows[n_integrals:])
    blur = ca.fabs(ca.jacobian(rows, y)) @ (size[: y.numel()] + ca.fabs(y))
    return ca.Function("values", [y, t, p, m, size], [ca.densify(rows), ca.densify(blur)])


def _middle_errors(t: np.ndarray, value: np.ndarray) -> np.ndarray:
    """Return the error at the odd nodes of the cubics through the even ones, (rows,); with all it is 16 times less."""
    c = cubics(t[::2], value[:, ::2])
    s = (t[1::2] - t[:-1:2])[:, None]
    cubic = ((c[..., 3] * s + c[..., 2]) * s + c[..., 1]) * s + c[..., 0]
    return np.max(np.abs(cubic.T - value[:, 1::2]), axis=1)
