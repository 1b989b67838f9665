"""The impact oscillator written by hand for SciPy and heyoka: an event at the stop turns the velocity round."""

import math
from collections.abc import Callable
from typing import Any

from symfric_evidence.bench.problems import Problem
from symfric_evidence.bench.result import BenchAnswer

WORKAROUNDS = (
    "one event at the stop, behind which the velocity is -e times that before and the place the stop's",
    "no friction, no contact that stays closed, no bounces that die out: those would need modes by hand",
)


def _numbers(problem: Problem) -> tuple[float, float, float, list[float], float]:
    given = {symbol.name: float(value) for symbol, value in problem.scene.numbers().items()}
    return given["zeta"], given["Omega"], given["e"], [given["x"], given["u"]], problem.scene.horizon


def prepare_scipy(problem: Problem, tolerance: float) -> Callable[[], BenchAnswer]:
    """Return a function that runs DOP853 from impact to impact."""
    from scipy.integrate import solve_ivp

    zeta, omega, e, start, horizon = _numbers(problem)

    def rate(t: float, y: Any) -> list[float]:
        x, u = float(y[0]), float(y[1])
        return [u, -2 * zeta * u - x + math.cos(omega * t)]

    def stop(_: float, y: Any) -> float:
        return float(y[0])

    stop.terminal, stop.direction = True, 1.0  # type: ignore[attr-defined]
    options = {"method": "DOP853", "rtol": max(tolerance, 3e-14), "atol": tolerance, "events": stop}

    def run() -> BenchAnswer:
        t, y, impacts = 0.0, start, 0
        while True:
            found = solve_ivp(rate, (t, horizon), y, **options)
            if found.status != 1:
                return BenchAnswer(tuple(found.y[:, -1].tolist()), impacts)
            t, y, impacts = float(found.t[-1]), [0.0, -e * float(found.y[1, -1])], impacts + 1

    return run


def prepare_heyoka(problem: Problem, tolerance: float) -> Callable[[], BenchAnswer]:
    """Return a function that runs heyoka's adaptive Taylor integrator with one terminal event."""
    import heyoka as hy

    zeta, omega, e, start, horizon = _numbers(problem)
    x, u = hy.make_vars("x", "u")
    impacts = [0]

    def turn(ta: Any, _: int) -> bool:
        ta.state[0], ta.state[1] = 0.0, -e * ta.state[1]
        impacts[0] += 1
        return True

    ta = hy.taylor_adaptive(
        [(x, u), (u, -2 * zeta * u - x + hy.cos(omega * hy.time))],
        start,
        tol=tolerance,
        t_events=[hy.t_event(x, callback=turn, direction=hy.event_direction.positive)],
        fast_math=True,
    )

    def run() -> BenchAnswer:
        impacts[0], ta.time, ta.state[:] = 0, 0.0, start
        ta.reset_cooldowns()
        ta.propagate_until(horizon)
        return BenchAnswer(tuple(ta.state.tolist()), impacts[0])

    return run
