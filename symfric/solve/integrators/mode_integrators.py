"""Integration of one mode in short pieces, up to the first guard that falls.

A mode's equations are those of its law continued beyond the guard, where they may have a pole or grow without bound: a
motion that leaves its mode unseen can end anywhere or nowhere. So no integration goes on for long before its guards are
looked at, between the outputs too, and one that fails is repeated over a shorter time. CasADi's own events do neither.
"""

import math
from collections import OrderedDict
from dataclasses import replace

import casadi as ca
import numpy as np

from symfric.locks import SYMBOLIC
from symfric.lower.mode_layout import backward, forward
from symfric.solve.integrators.dense_output.hermite import first_fall, middle_errors
from symfric.solve.integrators.dense_output.refined_grid import Look, refined
from symfric.solve.integrators.implicit.stretch import inside, outside, stretched
from symfric.solve.integrators.integrated_piece import IntegratedPiece, SegmentStart
from symfric.solve.integrators.mode_functions import CONTINUOUS, ONE_STEP, ModeEquations, mode_integrator, node_function
from symfric.solve.integrators.sizes import filled, rough_motion
from symfric.solve.integrators.step_control import growth, shrinkage
from symfric.solve.loop.precision import ROUNDING
from symfric.solve.loop.stepping.enclosure import unseen_by

FINEST = 1e-14  # smallest tolerance
_SAFETY = {"erk": 0.1, "rosenbrock": 0.1, "collocation": 0.1}  # factors of the local tolerance: errors of steps add up,
_SAFETY |= {"cvodes": 1e-3, "idas": 1e-3}  # and those of the multistep methods at kinks are far above their estimate
NODES = 8  # output nodes of a piece; few, since those beyond an event are discarded
_PIECE_STEPS = 1000  # steps of the integrator in one piece, above which pieces are shortened
_MOST_NODES = 2**15  # most nodes between two changes of an input, for plugins without pieces
_DENSE = 50  # error allowed with half the nodes, in tolerances; with all nodes it is about one tolerance
_BETWEEN = 10  # error allowed between the nodes of stiff motions, in tolerances
_STRETCHED = 1e6  # scaled length of such a motion, since CasADi takes times less than 1e-9 apart for one
_ROUGH = 300.0  # local tolerance of the motion from which nodes are found, relative to that of the motion itself
_LOGARITHMIC = 1e-11  # smallest local tolerance of velocities integrated as logarithms: rounding spoils smaller ones
_DEEPEST = 40  # halvings of a motion between whose parts the integrator is restarted
_DEGREES = 18  # powers above half of this may hide features from a check at a few points
_SHORTEST = 1e-9  # shortest piece, relative to the horizon
_GROWTH = 10  # largest growth of a state in one piece, which sets the scale of its errors
_KEPT = 8  # most integrators kept, one for each grid of nodes
_FEWEST = 4  # nodes of a cubic
_ORDER = 6  # power of the length with which the error of quintics goes
_INSTANT = 16  # roundings of time in which nothing changes
_NEWTON = 4  # most Newton corrections of an event time


class ModeIntegrators:
    """The integrators of the modes of one automaton, with step counts; for one run at a time."""

    def __init__(self, equations: ModeEquations) -> None:
        field, automaton, n_integrals, settings, tolerance, horizon, stretch = equations
        self.stretch = stretch if settings.plugin in CONTINUOUS else None
        self.settings, self.tolerance, self.plugin = settings, tolerance, settings.plugin or "erk"
        self.local = max(_SAFETY[self.plugin] * tolerance, FINEST if self.stretch is None else _LOGARITHMIC)
        self.in_pieces = self.plugin in ONE_STEP
        self.n_x, self.n_guards = len(automaton.states), automaton.layout.n_guards
        self._watched = automaton.layout.first_clock  # the end of a piece is no later than the next clock
        self._n_c = len(automaton.contacts)
        self._field, self._n_integrals, self._horizon = stretched(field, self.stretch), n_integrals, horizon
        self._nodes = node_function(self._field, n_integrals)
        continuous = self.plugin == "cvodes" and self.stretch is None and not automaton.inputs
        self.rough = rough_motion(field, n_integrals, horizon) if continuous else None
        self._compiled: dict[tuple[int, int], ca.Function] = {}
        self._for_grids: OrderedDict[tuple[bytes, float], ca.Function] = OrderedDict()
        self._unseen = unseen_by(field, _DEGREES) if self.in_pieces else None
        self.begin()

    def begin(self) -> None:
        """Reset all data of the previous run, so that results do not depend on it."""
        self.steps, self._elements = 0, min(2000, self.settings.elements)

    def _integrator(self, nodes: int) -> ca.Function:
        key = nodes, self._elements
        if key not in self._compiled:
            s = self.settings
            most, span = (_PIECE_STEPS // nodes, NODES * s.max_step) if self.in_pieces else (s.max_steps, self._horizon)
            with SYMBOLIC:
                self._compiled[key] = mode_integrator(
                    self._field,
                    self._n_integrals,
                    self.plugin,
                    s.max_step,
                    self.local,
                    span,
                    self._elements,
                    nodes,
                    most,
                )
        return self._compiled[key]

    def at_nodes(self, start: SegmentStart, span: float, nodes: int) -> np.ndarray:
        """Return the states at equidistant times after the start; raise RuntimeError if the integrator fails."""
        integrator = self._integrator(nodes)
        try:
            data = np.concatenate([start.p, start.m, start.size, [start.t, span]])
            return np.array(integrator(x0=start.state / start.size, p=data)["xf"]) * start.size[:, None]
        finally:
            counts = integrator.stats()
            self.steps += counts.get("n_steps", counts.get("nsteps", 0)) + counts.get("n_reject", 0)

    def _uninterrupted(self, start: SegmentStart, span: float, grid: np.ndarray, rough: float = 1.0) -> np.ndarray:
        """Return the states at fractions of a time after the start, the last one 1."""
        integrator = self._for_grid(grid, rough)
        data = np.concatenate([start.p, start.m, start.size, [start.t, span / _STRETCHED]])
        state = np.array(integrator(x0=start.state / start.size, p=data)["xf"]) * start.size[:, None]
        self.steps += integrator.stats().get("nsteps", 0)
        return state

    def _for_grid(self, grid: np.ndarray, rough: float) -> ca.Function:
        """Return the integrator for fractions of a time; those used last are kept."""
        key, s = (grid.tobytes(), rough), self.settings
        if key not in self._for_grids:
            with SYMBOLIC:
                self._for_grids[key] = mode_integrator(
                    self._field,
                    self._n_integrals,
                    self.plugin,
                    s.max_step,
                    self.local * rough,
                    self._horizon,
                    0,
                    grid * _STRETCHED,
                    s.max_steps,
                )
            if len(self._for_grids) > _KEPT:
                self._for_grids.popitem(last=False)
        self._for_grids.move_to_end(key)
        return self._for_grids[key]

    def end(self, start: SegmentStart, span: float) -> np.ndarray:
        """Return the state after a time; raise RuntimeError if the integrator fails."""
        if self.settings.plugin != "collocation":
            return self.at_nodes(start, span, 1)[:, -1]
        before = None
        while self._elements <= self.settings.elements:
            last = self.at_nodes(start, span, 1)[:, -1]
            if before is not None and np.all(
                np.abs(last - before) <= self.tolerance * np.maximum(start.size, np.abs(last))
            ):
                self._elements //= 2  # the next time begins with as many as have sufficed
                return last
            before = last
            self._elements *= 2
        raise RuntimeError("the result still changes with the number of elements")

    @np.errstate(all="ignore")  # beyond a guard the motion may overflow
    def advance(
        self, start: SegmentStart, end: float, reach: float, watched: bool, times: np.ndarray | None = None
    ) -> IntegratedPiece | None:
        """Return the motion up to `end`, to the first guard that falls, or about to `reach`.

        None if the integrator fails over the shortest time too. Plugins without pieces integrate to `end` regardless of
        guards, and have nodes only if the motion is `watched`; if `times` are given, at these alone.
        """
        if end - start.t <= _INSTANT * np.spacing(end):
            return self._instant(start, end, reach)
        if self.in_pieces:
            return self._next_piece(start, end, reach)
        begun = inside(self.stretch, start)
        try:
            if times is not None and self.plugin != "collocation":
                piece = self._at_times(begun, end, times)
            else:
                piece = self._whole(begun, end) if watched else self._ends(begun, end)
        except RuntimeError:
            return None
        return outside(self.stretch, piece, start.p)

    def _instant(self, start: SegmentStart, end: float, reach: float) -> IntegratedPiece:
        """Return a motion over a time of a few roundings, in which nothing changes."""
        t, begun = np.array([start.t, end]), inside(self.stretch, start)
        state = np.column_stack([begun.state, begun.state])
        first, second, *rows, _ = self._look(t, state, begun)
        return outside(self.stretch, IntegratedPiece(t, state, first, second, tuple(rows), reach), start.p)

    def _ends(self, start: SegmentStart, end: float) -> IntegratedPiece:
        none = np.zeros((0, 2))
        if self.settings.plugin == "collocation":
            state = np.column_stack([start.state, self.end(start, end - start.t)])
        else:
            state = np.column_stack([start.state, self._states_at(start, np.array([end]))])
        return IntegratedPiece(np.array([start.t, end]), state, none, none, (none, none, none), math.inf)

    def _whole(self, start: SegmentStart, end: float) -> IntegratedPiece:
        """Return the motion with as many nodes as the polynomials between them need; raise RuntimeError if too many."""
        if self.settings.plugin != "collocation":
            return self._refined(start, end)
        span, n, last = end - start.t, NODES, self.end(start, end - start.t)
        while True:
            states = self.at_nodes(start, span, n)
            states[:, -1] = last
            piece, excess, _ = self._between(start, end, states)
            if excess <= 1:
                return piece
            if n >= _MOST_NODES:
                raise RuntimeError("the motion has details between the nodes")
            n *= 2

    def _at_times(self, start: SegmentStart, end: float, times: np.ndarray) -> IntegratedPiece:
        """Return the motion with nodes at some times, regardless of those outside of the interval."""
        few = np.linspace(start.t, end, _FEWEST)[1:]  # as many as a cubic needs
        inside = times[(start.t < times) & (times < end)]
        t = np.unique(np.concatenate([few, inside]))
        state = np.column_stack([start.state, self._states_at(start, t)])
        t = np.append(start.t, t)
        first, second, *rows, _ = self._look(t, state, start)
        return IntegratedPiece(t, state, first, second, tuple(rows), math.inf, cubic=True)

    def _states_at(self, start: SegmentStart, t: np.ndarray, depth: int = 0) -> np.ndarray:
        """Return the states at times; raise RuntimeError if that fails.

        The integrator gives up where a motion changes within a small part of its last step; it is restarted half way.
        """
        span = t.item(-1) - start.t
        try:
            return self._uninterrupted(start, span, (t - start.t) / span)
        except RuntimeError:
            if depth >= _DEEPEST:
                raise
        middle = start.t + span / 2
        early = t < middle
        state = self._states_at(start, np.append(t[early], middle), depth + 1)
        later = self._states_at(replace(start, t=middle, state=state[:, -1]), t[~early], depth + 1)
        return np.column_stack([state[:, :-1], later])

    def _refined(self, start: SegmentStart, end: float) -> IntegratedPiece:
        """Return the motion with nodes where cubics through the values need them.

        Of stiff equations the derivatives at the nodes are no help: they magnify the errors of the values.
        """
        t, state = self._nodes_between(start, end, 0)
        first, second, *rows, _ = self._look(t, state, start)
        return IntegratedPiece(t, state, first, second, tuple(rows), math.inf, cubic=True)

    def _nodes_between(self, start: SegmentStart, end: float, depth: int) -> tuple[np.ndarray, np.ndarray]:
        """Return nodes and states; where the integrator gives up, it is restarted half way."""
        look, span = self._values(start, end), end - start.t
        try:
            grid, _ = refined(lambda grid: self._uninterrupted(start, span, grid, _ROUGH), look)
            grid, inner = refined(lambda grid: self._uninterrupted(start, span, grid), look, grid)
            return start.t + span * grid, np.column_stack([start.state, inner])
        except RuntimeError:
            if depth >= _DEEPEST:
                raise
        t, state = self._nodes_between(start, start.t + span / 2, depth + 1)
        later = self._nodes_between(replace(start, t=t.item(-1), state=state[:, -1]), end, depth + 1)
        return np.append(t, later[0][1:]), np.column_stack([state, later[1][:, 1:]])

    def _values(self, start: SegmentStart, end: float) -> Look:
        """Return a function that gives states and observables at nodes, and how much they may be in error."""

        def look(grid: np.ndarray, states: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
            state = np.column_stack([start.state, states])
            looked = self._look(start.t + (end - start.t) * grid, state, start)
            t = start.t + (end - start.t) * grid
            seen = state if self.stretch is None else self.stretch.outside(state, t, start.p)
            values = np.concatenate([seen[: self.n_x], looked[2][self.n_guards :]])
            if not np.all(np.isfinite(values)):
                raise RuntimeError("the motion left the finite numbers")
            noise = self.local * np.max(
                np.concatenate([start.size[: self.n_x, None] + np.abs(seen[: self.n_x]), looked[-1]]), axis=1
            )
            noise = np.delete(noise, np.s_[self.n_x : self.n_x + self.n_guards])
            return values, _BETWEEN * self.tolerance * np.max(np.abs(values), axis=1) + 10 * noise

        return look

    def _next_piece(self, start: SegmentStart, end: float, reach: float) -> IntegratedPiece | None:
        reach = min(reach, NODES * self.settings.max_step)
        while True:
            span, error = min(reach, end - start.t), math.inf
            try:
                states = self.at_nodes(start, span, NODES)
                size = start.size[:, None]
                if np.any(size + np.abs(states) > _GROWTH * (size + np.abs(start.state[:, None]))):
                    raise RuntimeError("what is small at the start would be lost in what is large at the end")
                piece, excess, below = self._between(start, min(start.t + reach, end), states)
                if excess <= 1:
                    cut = self._cut(start, piece, below)
                    if cut is not None and not self._hides_something(start, cut):
                        return replace(cut, reach=max(reach, growth(excess, _ORDER) * span))
                error = excess
            except RuntimeError:
                pass  # a piece that cannot be computed is too long
            reach = span * shrinkage(error, _ORDER)
            if reach < 4 * np.spacing(end):
                return None

    def _hides_something(self, start: SegmentStart, piece: IntegratedPiece) -> bool:
        """Whether a function may have a feature between the nodes that no step of the integrator resolved."""
        t, y = piece.t, piece.state[: self.n_x]
        span = t[-1] - t[0]
        if self._unseen is None or span < _SHORTEST * self._horizon:
            return False
        low, high = y.min(axis=1), y.max(axis=1)
        between = 0.25 * np.max(np.diff(t)) * np.max(np.abs(piece.first), axis=1)
        middle, radius = 0.5 * (low + high), 0.5 * (high - low) + between
        box = np.concatenate([middle, [0.5 * (t[0] + t[-1])], radius, [0.5 * span], np.zeros(self.n_x + 1)])
        unseen = np.array(self._unseen(box, start.p, start.m)).ravel()
        states = start.size + np.max(np.abs(piece.state), axis=1)
        rows = filled(np.max(np.abs(piece.rows[0]) + self._look(t[:1], piece.state[:, :1], start)[-1], axis=1))
        n, n_g = self.n_x, self.n_guards
        sizes = np.concatenate([states[:n] / span, rows[:n_g], states[n:] / span, rows[n_g:]])
        return not np.all(unseen <= self.tolerance * sizes)

    def _between(
        self, start: SegmentStart, stop: float, states: np.ndarray
    ) -> tuple[IntegratedPiece, float, np.ndarray]:
        """Return the piece through nodes, its interpolation error over the allowed one, and the noise of the guards."""
        t = np.linspace(start.t, stop, states.shape[1] + 1)
        state = np.column_stack([start.state, states])
        first, second, *rows, blur = looked = self._look(t, state, start)
        if not all(np.all(np.isfinite(e)) for e in looked):
            raise RuntimeError("the motion left the finite numbers")
        n, y = self.n_x, state[: self.n_x]
        values = np.concatenate([y, rows[0]]), np.concatenate([first, rows[1]]), np.concatenate([second, rows[2]])
        noise = self.local * np.max(np.concatenate([start.size[:n, None] + np.abs(y), blur]), axis=1)
        error = middle_errors(t, *values)
        allowed = _DENSE * self.tolerance * np.max(np.abs(values[0]), axis=1) + 10 * noise
        excess = np.max(error / np.maximum(allowed, 1e-300), initial=0.0)  # an observable may be zero throughout
        # twice the noise, and twice the error of the quintics through all nodes; see `middle_errors`
        rounding = self._rounding(t, rows, start.m)[: self._watched]
        below = (2 * noise + error / 32)[n : n + self._watched] + rounding
        return IntegratedPiece(t, state, first, second, tuple(rows), stop - start.t), float(excess), below

    def _rounding(self, t: np.ndarray, rows: list[np.ndarray], m: np.ndarray) -> np.ndarray:
        """Return the rounding errors of the guards: of the time, and of the force and bound of contacts that stick.

        They are all that is left where a guard does not depend on the state.
        """
        guards, slopes = (e[: self.n_guards] for e in rows[:2])
        size = np.max(np.abs(slopes) * np.abs(t), axis=1, initial=0.0)
        for i in map(int, np.flatnonzero(m[: self._n_c])):
            own = [backward(i), forward(i)]
            size[own] += np.max(np.sum(np.abs(guards[own]), axis=0))
        return ROUNDING * np.where(np.isfinite(size), size, 0.0)

    def _look(self, t: np.ndarray, state: np.ndarray, start: SegmentStart) -> list[np.ndarray]:
        return [
            np.array(e) for e in self._nodes(state[: self.n_x], t[None, :], start.p, start.m, start.size[: self.n_x])
        ]

    def _cut(self, start: SegmentStart, piece: IntegratedPiece, below: np.ndarray) -> IntegratedPiece | None:
        """Return the piece up to the first guard that falls, integrated to that time again; None if that misses it."""
        n = self._watched
        value, slope, bend = (e[:n] for e in piece.rows)
        fall = first_fall(piece.t, value, slope, bend, below) if n else None
        if fall is None:
            return piece
        index, t = fall
        k = max(1, int(np.searchsorted(piece.t, t)))
        t, state = self._at_root(start, t, index, below[index], min(t - start.t, piece.t[k] - piece.t[k - 1]))
        first, second, *rows, _ = self._look(np.array([t]), state, start)
        if abs(rows[0][index, 0]) > 4 * below[index]:
            return None
        k = int(np.searchsorted(piece.t, t))  # keep the nodes before the event
        join = lambda before, last: np.column_stack([before[:, :k], last])  # noqa: E731
        return IntegratedPiece(
            t=np.append(piece.t[:k], t),
            state=join(piece.state, state),
            first=join(piece.first, first),
            second=join(piece.second, second),
            rows=tuple(join(*pair) for pair in zip(piece.rows, rows, strict=True)),
            reach=piece.reach,
            fell=index,
        )

    def _at_root(
        self, start: SegmentStart, t: float, index: int, noise: float, most: float
    ) -> tuple[float, np.ndarray]:
        """Integrate to `t` and correct it by Newton's method until the guard is far below its noise."""
        if t <= start.t:
            return start.t, start.state[:, None]
        state, value, slope = self._guard(start, t, index)
        for _ in range(_NEWTON):
            correction = -value / slope if slope else math.inf
            if abs(value) <= 1e-3 * noise or not abs(correction) < most:  # at a graze the slope is zero
                break
            there = self._guard(replace(start, t=t, state=state), t + correction, index)
            if not abs(there[1]) < abs(value):  # the integrator's error is reached
                break
            t, (state, value, slope) = t + correction, there
        return t, state[:, None]

    def _guard(self, start: SegmentStart, t: float, index: int) -> tuple[np.ndarray, float, float]:
        """Return the state at time t, which may lie before the start, and there a guard and its slope."""
        state = self.end(start, t - start.t)
        _, _, value, slope, *_ = self._look(np.array([t]), state[:, None], start)
        return state, value[index, 0], slope[index, 0]
