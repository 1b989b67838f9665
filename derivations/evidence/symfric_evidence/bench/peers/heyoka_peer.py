"""heyoka's adaptive Taylor integrator on a written-out scene: one terminal event for each guard, logic in callbacks."""

import math
from collections.abc import Callable, Sequence
from functools import partial
from typing import Any

import sympy as sp

from symfric.model.symbols import TIME
from symfric_evidence.bench.peers.written_out import PeerLoop, form_of
from symfric_evidence.bench.problems import Problem
from symfric_evidence.bench.result import BenchAnswer

_COOLDOWN = 1e-6  # the one that heyoka deduces grows without bound where the slip has a double root


def prepare(problem: Problem, tolerance: float) -> Callable[[], BenchAnswer]:
    """Compile the integrator and return a function that resets its state and runs it."""
    solver = _Solver(problem, tolerance)
    start, segments = solver.form.start, solver.form.segments
    mode = solver.loop.first(list(start))

    def run() -> BenchAnswer:
        solver.reset(start, mode)
        for segment in segments:
            solver.go(segment)
        return BenchAnswer(tuple(solver.state.tolist()), solver.events[0])

    return run


class _Solver:
    """The compiled integrator with the mode it is in."""

    def __init__(self, problem: Problem, tolerance: float):
        import heyoka as hy

        self.form = form = form_of(problem.scene).with_rest_apart()
        self.loop, self.events, self._limit = PeerLoop(form), [0], hy.taylor_outcome.time_limit
        constants = [*form.signs, *form.moving, *form.line]
        guards = (*form.slips, *form.kinks) if form.apart else form.guards
        used = [c for c in constants if any(e.has(c) for e in (*form.rates, *guards))]
        self._modes = [(k, used.index(c)) for k, c in enumerate((*form.signs, *form.moving)) if c in used]
        self._lines = [(k, used.index(c)) for k, c in enumerate(form.line) if c in used]
        self._mode: list[float] = []
        self._arrays: list[Any] = []
        self._released = [-math.inf]
        self._line: list[float] = []
        states = hy.make_vars(*(s.name for s in form.states))
        states = [states] if len(form.states) == 1 else states
        rates, guards = _translated(hy, (TIME, *form.states, *used), (form.rates, guards))(
            hy.time, *states, *(hy.par[k] for k in range(len(used)))
        )
        direction = hy.event_direction.any if form.apart else hy.event_direction.negative
        options = {"cooldown": _COOLDOWN, "direction": direction}
        self._ta = hy.taylor_adaptive(
            list(zip(states, [rate + 0.0 * states[0] for rate in rates], strict=True)),
            list(form.start),
            pars=[0.0] * len(used),
            tol=tolerance,
            t_events=[hy.t_event(guard, callback=self._falls(k), **options) for k, guard in enumerate(guards)],
            fast_math=True,
        )
        self.state, self._pars = self._ta.state, self._ta.pars
        self._arrays[:] = self.state, self._pars

    def _falls(self, k: int) -> Callable[[Any, object], bool]:
        loop, mode, line, events, pairs = self.loop, self._mode, self._line, self.events, self._modes
        apart, arrays, released = self.form.apart, self._arrays, self._released
        place = len(self.form.signs) + k
        contact = k < len(self.form.moving)
        touched = [i for i, _ in loop.shares[k]] if contact else []
        arrive, rests = loop.arrivals[k] if contact else partial(loop.after, k=k), loop.rests

        def callback(ta: Any, _: object) -> bool:
            t = ta.time
            if t - released[0] <= _COOLDOWN:  # rounding error of the zero at the release
                return True
            state, pars = arrays
            y = state.tolist()
            changed = arrive(t, y, mode, line)
            for i in touched:
                state[i] = y[i]
            if not changed and contact:
                return True
            events[0] += changed
            if contact and mode[place] == 0.0 and (apart or rests(mode)):
                return False
            for i, j in pairs:
                pars[j] = mode[i]
            return True

        return callback

    def reset(self, start: Sequence[float], mode: list[float]) -> None:
        """Reset state and mode to the start."""
        self.events[0], self._released[0] = 0, -math.inf
        self._ta.reset_cooldowns()
        self._ta.time, self.state[:] = 0.0, start
        self._mode[:] = mode
        for i, j in self._modes:
            self._pars[j] = mode[i]

    def go(self, segment: tuple[float, ...]) -> None:
        """Integrate to the end of a segment of the input."""
        end, *self._line[:] = segment
        for i, j in self._lines:
            self._pars[j] = self._line[i]
        ta, mode, line, state, events = self._ta, self._mode, self._line, self.state, self.events
        loop, limit, pairs, pars = self.loop, self._limit, self._modes, self._pars
        rests = loop.rests(mode)
        while rests or ta.propagate_until(end)[0] != limit:
            ta.time, y, released = loop.resting(ta.time, state.tolist(), mode, line, end)
            for i, value in enumerate(y):
                state[i] = value
            if not released:
                return
            for i, j in pairs:
                pars[j] = mode[i]
            events[0], self._released[0], rests = events[0] + 1, ta.time, False


def _translated(hy: Any, arguments: Sequence[sp.Symbol], expressions: Sequence[Sequence[sp.Expr]]) -> Any:
    """Return a function that builds heyoka's expressions; powers become products."""

    def product(base: Any, n: int) -> Any:
        return base if n == 1 else base * product(base, n - 1)

    multiplied = sp.Function("product")
    plain = [
        [e.replace(lambda p: p.is_Pow and p.exp.is_Integer and p.exp > 1, lambda p: multiplied(*p.args)) for e in row]
        for row in (map(sp.sympify, row) for row in expressions)
    ]
    return sp.lambdify(arguments, plain, [{"product": product, "sin": hy.sin, "cos": hy.cos, "exp": hy.exp}])
