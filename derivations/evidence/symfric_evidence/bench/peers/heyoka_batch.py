"""heyoka's batch mode on the sweep: several belts side by side in vector registers, stick and slip in callbacks."""

from collections.abc import Callable
from typing import Any

import numpy as np

from symfric_evidence.bench.problems import Problem
from symfric_evidence.bench.result import BenchAnswer

WORKAROUNDS = (
    "sticking is a mode of the equations, as a terminal event that stops one belt would stop all of them",
    "the sign of slip is a runtime parameter, 0 while the mass sticks",
    "event cooldown set by hand to 1e-6, and the cube multiplied out, as in the loop for one belt",
)
SIZES = (4, 8, 16)  # belts side by side
_COOLDOWN = 1e-6


def prepare_sweep(problem: Problem, tolerance: float, size: int = 4) -> Callable[[], BenchAnswer]:
    """Compile once for `size` belts side by side; return a function that finds the half range at each speed."""
    import heyoka as hy

    o, (begin, end) = problem.by_hand, problem.window
    speeds = np.array(problem.speeds)
    if speeds.size % size:
        speeds = np.append(speeds, np.repeat(speeds[-1], -speeds.size % size))
    low, high = np.zeros(size), np.zeros(size)
    watching = [False]

    def arrive(ta: Any, _: object, k: int) -> bool:
        v_b = pars[1, k]
        state[1, k] = v_b
        if pars[0, k] == 0.0:  # the spring pulls the mass off
            state[0, k], pars[0, k] = o.mu_s - 2 * o.beta * v_b, -1.0
            return True
        force = -2 * o.beta * v_b - state[0, k]
        pars[0, k] = 0.0 if abs(force) <= o.mu_s else 1.0 if force > 0 else -1.0
        return True

    def turn(ta: Any, time: float, _: object, k: int) -> None:
        if watching[0]:
            ta.update_d_output(time)
            x = ta.d_output[0, k]
            low[k], high[k] = min(x, low[k]), max(x, high[k])

    x, u = hy.make_vars("x", "u")
    sign, v_b = hy.par[0], hy.par[1]
    slips, w = sign * sign, u - v_b
    force = -x - 2 * o.beta * u - sign * o.mu_s - o.c1 * w - o.c3 * (w * w) * w
    guard = slips * w + (1.0 - slips) * (o.mu_s - 2 * o.beta * v_b - x)
    ta = hy.taylor_adaptive_batch(
        [(x, u), (u, slips * force)],
        np.zeros((2, size)),
        pars=np.zeros((2, size)),
        tol=tolerance,
        t_events=[hy.t_event_batch(guard, callback=arrive, cooldown=_COOLDOWN)],
        nt_events=[hy.nt_event_batch(u, turn)],
        fast_math=True,
    )
    state, pars = ta.state, ta.pars

    def run() -> BenchAnswer:
        half_ranges = np.empty(speeds.size)
        for first in range(0, speeds.size, size):
            ta.reset_cooldowns()
            ta.set_time(0.0)
            state[0], state[1], pars[0], pars[1] = o.x0, 0.0, -1.0, speeds[first : first + size]
            watching[0] = False
            ta.propagate_until(begin)
            low[:] = high[:] = state[0]
            watching[0] = True
            ta.propagate_until(end)
            low[:], high[:] = np.minimum(low, state[0]), np.maximum(high, state[0])
            half_ranges[first : first + size] = (high - low) / 2
        return BenchAnswer(tuple(half_ranges[: len(problem.speeds)].tolist()), 0)

    return run
