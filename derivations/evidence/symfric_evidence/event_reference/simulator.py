"""Integration of one mode at a time, and location of the events that end it."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from typing import Any

import numpy as np
from scipy.integrate import DOP853
from scipy.optimize import brentq, minimize_scalar

from symfric.model.scene import Scene
from symfric_evidence.event_reference.equations import Equations
from symfric_evidence.event_reference.modes import Choice, Mechanics, SmoothMode

Dense = Callable[[Any], np.ndarray]  # state at a time, or at an array of times
Rate = Callable[[float, np.ndarray], np.ndarray]
_GRID = np.linspace(0.0, 1.0, 13)  # grid on a step at which guards are evaluated
# dense near the start, since a mode may end soon
_FIRST = np.concatenate([[0.0], 2.0 ** np.arange(-40, -4), _GRID[1:]])
_CHANGE = 1.0  # of the argument of a feature over a step; and this part of the argument itself:
_PART = 0.5
_WORTH = 1e-6  # of the time to an event: shortest step whose motion is that near it
_LEAVES = 4.0  # multiple of that at which a kink that rested has left zero
_ZERO = 1e-13, 1e-12  # of the largest slip and of the largest guard of a kink so far: what counts as zero


class GaveUp(Exception):
    """Raised if the reference fails; its text is the reason."""


@dataclass(frozen=True)
class Reference:
    """Result of the reference simulator.

    Attributes
    ----------
    x : ndarray, shape (n_x, n_times)
        At the times asked for; NaN after an early end.
    events : tuple of (time, modes)
    reason : str
        Why it ended early; empty if it did not.
    alternatives : bool
        Whether at some event several modes were admissible that move differently.
    """

    x: np.ndarray
    events: tuple[tuple[float, tuple[int, ...]], ...]
    reason: str
    alternatives: bool


class ReferenceSimulator:
    """A scene, its functions made once, run for many numbers.

    Parameters
    ----------
    scene : Scene
        Its values and start are the defaults of a run.
    tolerance : float
        Relative, and relative to the sizes of the states.
    max_steps, max_events : int
        Where it gives up.
    """

    def __init__(self, scene: Scene, tolerance: float = 1e-10, *, max_steps: int = 10_000, max_events: int = 200):
        self.scene, self.tolerance, self.max_steps, self.max_events = scene, tolerance, max_steps, max_events
        self.equations = Equations(scene)

    def run(
        self,
        values: Mapping[str, float] | None = None,
        initial: Mapping[str, float] | None = None,
        *,
        horizon: float | None = None,
        times: np.ndarray | None = None,
        sizes: np.ndarray | None = None,
        tolerance: float | None = None,
        preference: int = 0,
    ) -> Reference:
        """Run with other values and another start, both by name.

        Parameters
        ----------
        values, initial : dict of str to float, optional
        horizon : float, optional
            Of the scene unless given.
        times : array_like, optional
            At which the state is wanted; only the horizon unless given.
        sizes : array_like, shape (n_x,), optional
            Typical sizes of the states, for the absolute tolerance; one unless given.
        preference : {0, 1}
            Which of several admissible modes: the first or the last that is enumerated.
        """
        scene = self.scene
        numbers = {s.name: v for s, v in scene.numbers().items()} | dict(values or {}) | dict(initial or {})
        y = np.array([numbers[s.name] for s in scene.system.states], dtype=float)
        parameters = tuple(float(numbers[s.name]) for s in self.equations.parameters)
        horizon = scene.horizon if horizon is None else horizon
        times = np.atleast_1d(np.asarray(horizon if times is None else times, dtype=float))
        sizes = np.ones(y.size) if sizes is None else np.maximum(np.asarray(sizes, dtype=float), 1e-300)
        mechanics = Mechanics(self.equations, parameters, 0.1 * horizon)
        tolerance = self.tolerance if tolerance is None else tolerance
        return _Motion(self, mechanics, horizon, times, sizes, tolerance, preference).run(y)


class _Motion:
    """One run."""

    def __init__(
        self,
        simulator: ReferenceSimulator,
        mechanics: Mechanics,
        horizon: float,
        times: np.ndarray,
        sizes: np.ndarray,
        tolerance: float,
        preference: int,
    ):
        self.m, self.e, self.scene = mechanics, mechanics.e, simulator.scene
        self.limits, self.horizon = simulator, horizon
        self.times, self.tolerance, self.atol = times, tolerance, 0.1 * tolerance * sizes
        self.x = np.full((len(sizes), times.size), np.nan)
        self.choice = Choice(mechanics, preference)
        self.events: list[tuple[float, tuple[int, ...]]] = []
        self.steps, self.h = 0, self.horizon / 40
        self.largest = np.zeros(self.e.n_c + self.e.n_k)  # largest slips and guards so far

    def run(self, y: np.ndarray) -> Reference:
        reason = ""
        self.x[:, self.times <= 0] = y[:, None]
        try:
            with np.errstate(all="ignore"):  # steps check for finite values
                self._motion(y)
        except GaveUp as gave_up:
            reason = str(gave_up)
        except (ArithmeticError, ValueError, TypeError, np.linalg.LinAlgError) as error:
            reason = f"not a number: {error}"
        return Reference(self.x, tuple(self.events), reason, self.choice.alternatives)

    def _motion(self, y: np.ndarray) -> None:
        t, at_zero = 0.0, [False] * (self.e.n_c + self.e.n_k)
        stops = self._stops()
        self._inputs(t, stops[0])
        while True:
            mode = self._mode(t, y, at_zero)
            self.events.append((t, mode.modes))
            if len(self.events) > self.limits.max_events:
                raise GaveUp("too many events")
            y = self._projected(t, y, mode)
            t, y, at_zero, stopped = self._segment(t, y, mode, stops[0])
            if stopped:
                stops.pop(0)
                if not stops:
                    return
                self._inputs(t, stops[0])

    def _stops(self) -> list[float]:
        """Times at which a sampled input has a kink or jump, and the end."""
        end = self.horizon
        grids = [s.t0 + s.dt * np.arange(s.samples.size) for s in self.scene.inputs.values()]
        inner = np.unique(np.concatenate([np.zeros(0), *grids]))
        return [*(float(t) for t in inner if 1e-14 * end < t < end * (1 - 1e-14)), end]

    def _inputs(self, t: float, stop: float) -> None:
        middle, half = 0.5 * (t + stop), 0.25 * (stop - t)
        signals = self.scene.inputs.values()
        slopes = [float(s(middle + half) - s(middle - half)) / (2 * half) for s in signals]
        self.m.slopes, self.m.since = tuple(slopes), t
        self.m.signals = tuple(float(s(middle)) - b * (middle - t) for s, b in zip(signals, slopes, strict=True))

    def _mode(self, t: float, y: np.ndarray, at_zero: Sequence[bool]) -> SmoothMode:
        watched, _ = self.m.look(t, y, (1,) * self.e.n_c)
        self.largest = np.maximum(self.largest, np.abs(watched))
        n_c, n_k = self.e.n_c, self.e.n_k
        mode = self.choice.at(t, y, at_zero, np.repeat(_ZERO, (n_c, n_k)) * self.largest)
        if mode is None:
            raise GaveUp(f"no admissible mode at t = {t:.17g}")
        return mode

    def _projected(self, t: float, y: np.ndarray, mode: SmoothMode) -> np.ndarray:
        """Return the state with the slips of sticking contacts set to zero."""
        stuck = [i for i, m in enumerate(mode.modes) if m == 0]
        if not stuck:
            return y
        rows = self.m.parts(t, y, mode)[3][stuck]
        y = y.copy()
        slips = np.array(self.e.watched(*self.m.arguments(t, y, mode)), dtype=float)[stuck]
        y[self.e.n : 2 * self.e.n] -= np.linalg.lstsq(rows, slips, rcond=1e-13)[0]
        return y

    def _segment(
        self, t: float, y: np.ndarray, mode: SmoothMode, stop: float
    ) -> tuple[float, np.ndarray, list[bool], bool]:
        """Integrate one mode; return its end, the contacts at zero slip there, and whether it is the stop."""
        if stop - t <= 4e-16 * stop:
            return t, y, self._zero(mode), True
        rate = lambda t, y: self.m.rate(t, y, mode)  # noqa: E731
        solver, first = None, True
        while True:
            if self.steps >= self.limits.max_steps:
                raise GaveUp("too many steps")
            self.steps += 1
            if solver is None:
                h = min(self.h, stop - t)
                solver = DOP853(rate, t, y, stop, max_step=self.h, first_step=h, rtol=self.tolerance, atol=self.atol)
            solver.max_step = self.h
            solver.h_abs = min(solver.h_abs, self.h)
            if solver.step():
                raise GaveUp(f"the step collapsed at t = {t:.17g}")
            dense = solver.dense_output()
            length = solver.t - t
            grid = t + length * (_FIRST if first else _GRID)
            grid[-1] = solver.t
            states = dense(grid)
            watched = self.e.watched_array(*self.m.arguments(grid, states, mode))
            watched = np.array([np.broadcast_to(w, grid.shape) for w in watched], dtype=float).reshape(-1, grid.size)
            if not np.all(np.isfinite(states)):
                raise GaveUp(f"not finite at t = {t:.17g}")
            change = _change(watched[self.e.n_c + self.e.n_k :])
            if change > 1.5 and length > 1e-13 * self.horizon:
                self.h, solver = length * max(0.1, 0.8 / change), None
                continue
            self.h = min(length * min(4.0, 0.8 / max(change, 1e-3)), self.horizon / 20)
            guards, function = self._guards(mode, grid, states, watched, dense)
            noise = np.concatenate([_ZERO[0] * self.largest, np.zeros(self.e.n_c)])
            event = _first_event(grid, guards, function, noise if first else None)
            if event is not None:
                te, row = event
                self._check(0.5 * (t + te), dense, mode)
                self._keep(t, y, te, rate)
                if te > t:
                    dense = self._stepped(t, y, te, rate)
                    te = _crossing(lambda t: function(row, t, dense), t, te)  # noqa: B023
                zero = self._zero(mode, row)
                if self.e.n_c <= row < len(zero) and function(row, te, dense) < -_ZERO[1] * self.largest[row]:
                    zero[row] = False  # a kink that the error of interpolation had not yet reached is behind it
                return te, dense(te), zero, False
            self._check(0.5 * (t + solver.t), dense, mode)
            self._keep(t, y, solver.t, rate)
            t, y, first = solver.t, solver.y.copy(), False
            self.choice.see(t, y, mode)
            if solver.status == "finished":
                return t, y, self._zero(mode), True

    def _check(self, t: float, dense: Dense, mode: SmoothMode) -> None:
        """Raise if a root or an inverse function has left its domain inside a mode."""
        if self.e.inside is not None and not np.all(np.isfinite(self.e.inside(*self.m.arguments(t, dense(t), mode)))):
            raise GaveUp(f"not a number at t = {t:.17g}")

    def _keep(self, t: float, y: np.ndarray, te: float, rate: Rate) -> None:
        for k in np.flatnonzero((self.times > t) & (self.times <= te)):
            self.x[:, k] = self._stepped(t, y, self.times[k], rate)(self.times[k])

    def _stepped(self, t: float, y: np.ndarray, end: float, rate: Rate) -> Dense:
        """Return the motion near a time inside a step by a step that ends there, where it holds the tolerance.

        A last step of rounding has no motion beside it: that of the step before goes on.
        """
        solver, dense = DOP853(rate, t, y, end, first_step=end - t, rtol=self.tolerance, atol=self.atol), None
        while solver.status == "running":
            if solver.step():
                raise GaveUp(f"the step collapsed at t = {t:.17g}")
            if dense is None or solver.step_size > _WORTH * (end - t):
                dense = solver.dense_output()
        assert dense is not None  # there was a step
        return dense

    def _zero(self, mode: SmoothMode, row: int = -1) -> list[bool]:
        """Return which slips and guards of kinks are zero where a guard ends the mode."""
        zero = [m == 0 for m in mode.modes] + list(mode.resting)
        if 0 <= row < len(zero):
            zero[row] = not zero[row]  # a kink that rested has left zero
        return zero

    def _guards(
        self, mode: SmoothMode, grid: np.ndarray, states: np.ndarray, watched: np.ndarray, dense: Dense
    ) -> tuple[np.ndarray, Callable[..., float]]:
        """Return the guards on the grid, positive while the mode lasts, and a function of row, time and motion.

        Rows: slips of slipping contacts, kinks, and what is left of the bounds of sticking contacts; infinite where
        there is nothing to watch. A kink that rests may leave zero again, by more than counts as zero.
        """
        n_c, n_k = self.e.n_c, self.e.n_k
        rows = np.full((2 * n_c + n_k, grid.size), np.inf)
        self.largest = np.maximum(self.largest, np.max(np.abs(watched[: n_c + n_k]), axis=1, initial=0.0))
        for i, m in enumerate(mode.modes):
            if m:
                rows[i] = m * watched[i]
        leaves = np.where(mode.resting, _LEAVES * np.maximum(_ZERO[1] * self.largest[n_c:], self.choice.zeros()), 0.0)
        for k, sign in enumerate(mode.signs):
            rows[n_c + k] = sign * watched[n_c + k] + leaves[k]
        stuck = [i for i, m in enumerate(mode.modes) if m == 0]
        turning = [p != 0 for p in mode.pushes] or [False] * n_c  # the bound at an edge is that of one side
        if stuck:
            for j, t in enumerate(grid):
                motion = self.m.motion(t, states[:, j], mode)
                excess = self.m.excess(t, states[:, j], mode, motion)
                for i in stuck:
                    rows[n_c + n_k + i, j] = -excess[i]
                    if turning[i] and mode.pushes[i] * motion[1][i] < 0:
                        rows[n_c + n_k + i, j] = min(rows[n_c + n_k + i, j], mode.pushes[i] * motion[1][i])

        def value(row: int, t: float, dense: Dense = dense) -> float:
            y = dense(t)
            if row < n_c + n_k:
                guard = float(self.e.watched(*self.m.arguments(t, y, mode))[row])
                return mode.modes[row] * guard if row < n_c else mode.signs[row - n_c] * guard + leaves[row - n_c]
            i = row - n_c - n_k
            motion = self.m.motion(t, y, mode)
            left = -float(self.m.excess(t, y, mode, motion)[i])
            return min(left, mode.pushes[i] * motion[1][i]) if turning[i] else left

        return rows, value


def _change(arguments: np.ndarray) -> float:
    """Return the largest change of an argument over a step, relative to the allowed change."""
    if not arguments.size:
        return 0.0
    low, high = np.min(arguments, axis=1), np.max(arguments, axis=1)
    nearest = np.where(low * high > 0, np.minimum(np.abs(low), np.abs(high)), 0.0)
    change = (high - low) / np.maximum(_CHANGE, _PART * nearest)
    return float(np.max(np.where(np.isfinite(change), change, 0.0)))


def _first_event(
    grid: np.ndarray, guards: np.ndarray, function: Callable[..., float], noise: np.ndarray | None
) -> tuple[float, int] | None:
    """Return time and row of the first guard that becomes negative, None if none does.

    `noise` is what a guard has to reach before that, in the first step of a mode.
    """
    best = None
    for row, g in enumerate(guards):
        if not np.isfinite(g[0]):
            continue
        end = grid.size if best is None else int(np.searchsorted(grid, best[0], side="right")) + 1
        zero = _first_zero(grid[:end], g[:end], partial(function, row), noise[row] if noise is not None else None)
        if zero is not None and (best is None or zero < best[0]):
            best = (zero, row)
    return best


def _first_zero(
    grid: np.ndarray, g: np.ndarray, function: Callable[[float], float], noise: float | None
) -> float | None:
    """Return where a guard that starts at zero or above becomes negative."""
    start = 0
    if g[0] <= 0 or noise is not None:  # it may begin at zero, and below it by rounding
        above = np.flatnonzero(g > max(-4 * g[0], 0.0))
        if not above.size:
            level = 1e-9 * np.max(np.abs(g)) + 1e-13
            below = np.flatnonzero(g < -level)
            if not below.size or below[-1] < g.size - 1:
                return None
            return _root(lambda t: function(t) + level, grid[max(below[0] - 1, 0)], grid[below[0]])
        start = int(above[0])
    clear = np.flatnonzero(np.abs(g[start:]) > (noise or 0.0))
    if clear.size and g[start + clear[0]] > 0:  # until then it is zero
        start += int(clear[0])
    for j in range(start, g.size):
        if g[j] < 0:
            if j == start:
                return float(grid[j])
            return _root(function, grid[j - 1], grid[j])
        if j < 2 or j - 2 < start:
            continue
        a, b, c = g[j - 2], g[j - 1], g[j]
        low = min(a, b, c)
        turns = (b <= a and b <= c) or (c < b < a and b - c < 0.5 * (a - b)) or (a < b < c and b - a < 0.5 * (c - b))
        if turns and low <= 2 * (max(a, b, c) - low):  # a minimum inside, or next to the ends, that may lie below zero
            limits = {"bounds": (grid[j - 2], grid[j]), "options": {"xatol": 1e-10 * (grid[j] - grid[j - 2])}}
            at = minimize_scalar(function, method="bounded", **limits)
            if at.fun < 0:
                return _root(function, grid[j - 2], at.x)
    return None


def _crossing(function: Callable[[float], float], start: float, end: float) -> float:
    """Return the zero next to the end of a step, or the end if there is none."""
    near = 1e-6 * (end - start)
    a, b = end - near, end + near
    return _root(function, a, b) if function(a) > 0 > function(b) else end


def _root(function: Callable[[float], float], a: float, b: float) -> float:
    if function(a) <= 0:
        return float(a)
    if function(b) >= 0:
        return float(b)
    return float(brentq(function, a, b, xtol=1e-15 * max(abs(a), abs(b), 1e-300), rtol=8.9e-16))
