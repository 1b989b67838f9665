"""Shooting written by hand over heyoka: a branch of stick-slip cycles, and the steady response of a joint."""

import math
from collections.abc import Callable, Sequence
from typing import Any

import numpy as np

from symfric_evidence.bench.problems import Problem
from symfric_evidence.bench.result import BenchAnswer

WORKAROUNDS = (
    "the order of sticks and slips is known beforehand: one integrator for each mode, with the event that ends it",
    "the unknowns are those that a release, or a turn, leaves open: two",
    "Newton's method with differences at the first point, Broyden's updates after it, starts by extrapolation",
)
_STEP = 1e-6  # of the differences
_EARLY = 1e-6  # time after a start within which an event is that of the start
_TURNS, _LONGEST = 30, 50.0  # most iterations; longest time in one mode

_RELEASE = (0.36, -0.08)  # position and velocity of the first mass at the first speed
_TURN = {1.0: (6.4, 1.4), 1.1: (4.0, 2.3)}  # displacement and phase at a frequency

Map = Callable[[np.ndarray], tuple[np.ndarray, float]]  # what is left of the equations, and the period


def solved(
    equations: Map, z: np.ndarray, matrix: np.ndarray | None, tolerance: float
) -> tuple[np.ndarray, float, np.ndarray]:
    """Return zero, period and matrix of the equations by Broyden's method, from a matrix or from differences."""
    left, period = equations(z)
    if matrix is None:
        moved = [equations(z + _STEP * unit)[0] - left for unit in np.eye(z.size)]
        matrix = np.array(moved).T / _STEP
    for _ in range(_TURNS):
        step = -np.linalg.solve(matrix, left)
        z = z + step
        before, (left, period) = left, equations(z)
        if np.max(np.abs(left)) <= tolerance:
            return z, period, matrix
        matrix = matrix + np.outer(left - before - matrix @ step, step) / (step @ step)
    raise RuntimeError("the shooting does not converge")


def prepare_branch(problem: Problem, tolerance: float) -> Callable[[], BenchAnswer]:
    """Return a function that finds the period at each speed of P16, from release to release of the second mass.

    Notes
    -----
    A period is: both slip; the first sticks; both slip; the second sticks. A mass that sticks moves with the belt
    until the springs pull it back with the static friction.
    """
    import heyoka as hy

    one = problem.branched
    x, u = hy.make_vars("x0", "x1"), hy.make_vars("u0", "u1")
    speed = hy.par[0]

    def held(i: int, x: Sequence[Any], u: Any) -> Any:
        return -2.0 * x[i] + x[1 - i] - 2.0 * one.beta * u

    def slipping(i: int) -> Any:
        w = u[i] - speed
        return held(i, x, u[i]) - one.loads[i] * (one.c1 * w + one.c3 * (w * w) * w - one.mu_s)

    def later(ta: Any, _: object) -> bool:
        return bool(ta.time <= _EARLY)

    def integrator(rates: Sequence[Any], guard: Any) -> Any:
        event = hy.t_event(guard, callback=later, direction=hy.event_direction.positive, cooldown=_EARLY)
        equations = list(zip([*x, *u], rates, strict=True))
        return hy.taylor_adaptive(equations, [0.0] * 4, tol=tolerance, t_events=[event], fast_math=True)

    still = 0.0 * x[0]
    ends = [u[i] - speed for i in range(2)]
    full = [-held(i, x, speed) - one.loads[i] * one.mu_s for i in range(2)]
    modes = [
        integrator([*u, slipping(0), slipping(1)], ends[0]),
        integrator([speed + still, u[1], still, slipping(1)], full[0]),
        integrator([*u, slipping(0), slipping(1)], ends[1]),
        integrator([u[0], speed + still, slipping(0), still], full[1]),
    ]

    def run() -> BenchAnswer:
        periods: list[float] = []
        found: list[np.ndarray] = []
        matrix = None
        for v in one.speeds:

            def equations(z: np.ndarray, v: float = v) -> tuple[np.ndarray, float]:
                y, time = [z[0], (z[0] - 2.0 * one.beta * v + one.loads[1] * one.mu_s) / 2.0, z[1], v], 0.0
                for ta, moves_along in zip(modes, (3, 2, 2, 3), strict=True):
                    y[moves_along] = v
                    ta.reset_cooldowns()
                    ta.time, ta.state[:], ta.pars[0] = 0.0, y, v
                    _reach(ta)
                    time, y = time + ta.time, ta.state.tolist()
                return np.array([y[0] - z[0], y[2] - z[1]]), time

            z = 2 * found[-1] - found[-2] if len(found) > 1 else found[-1] if found else np.array(_RELEASE)
            z, period, matrix = solved(equations, z, matrix, 10 * tolerance)
            found.append(z)
            periods.append(period)
        return BenchAnswer(tuple(periods), 0)

    return run


def prepare_response(problem: Problem, tolerance: float) -> Callable[[], BenchAnswer]:
    """Return a function that finds the largest displacement of P10 at each frequency, from a turn to the next.

    Notes
    -----
    Half a period is: the slider holds, from the turn at X with the largest force, until the force is the opposite one;
    it slips until the next turn, which is at -X and half a period after the first. Unknowns are X and the phase.
    """
    import heyoka as hy

    one = problem.joint
    x, u = hy.make_vars("x", "u")
    frequency, phase, turn = hy.par[0], hy.par[1], hy.par[2]
    outer = -x - one.damping * u + hy.cos(frequency * hy.time + phase)
    holding = one.stiffness * (x - turn) + one.limit

    def integrator(joint: Any, guard: Any) -> Any:
        equations, events = [(x, u), (u, outer - joint)], [hy.t_event(guard)]
        return hy.taylor_adaptive(equations, [0.0] * 2, tol=tolerance, t_events=events, fast_math=True)

    modes = integrator(holding, holding + one.limit), integrator(-one.limit, u)

    def run() -> BenchAnswer:
        peaks = []
        for w in problem.frequencies:

            def equations(z: np.ndarray, w: float = w) -> tuple[np.ndarray, float]:
                y, time = [z[0], 0.0], 0.0
                for ta in modes:
                    ta.reset_cooldowns()
                    ta.time, ta.state[:], ta.pars[:] = time, y, [w, z[1], z[0]][: ta.pars.size]
                    _reach(ta)
                    time, y = ta.time, ta.state.tolist()
                return np.array([y[0] + z[0], time - math.pi / w]), time

            peaks.append(solved(equations, np.array(_TURN[w]), None, 10 * tolerance)[0][0])
        return BenchAnswer(tuple(float(p) for p in peaks), 0)

    return run


def _reach(ta: Any) -> None:
    """Integrate to the event that ends a mode."""
    import heyoka as hy

    if ta.propagate_until(ta.time + _LONGEST)[0] == hy.taylor_outcome.time_limit:
        raise RuntimeError("a mode does not end")
