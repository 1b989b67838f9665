"""SciPy's LSODA on the block of an incline with friction regularised in the plane, written by hand."""

import math
from collections.abc import Callable

import numpy as np

from symfric_evidence.bench.problems import Problem
from symfric_evidence.bench.result import BenchAnswer

WORKAROUNDS = (
    "friction is -mu N s/sqrt(s^2 + eps^2), eps the tolerance times the first speed: the block creeps by as much",
    "right-hand side and its Jacobian in plain floats, without NumPy",
)


def prepare(problem: Problem, tolerance: float) -> Callable[[], BenchAnswer]:
    """Return a function that runs ``solve_ivp(method="LSODA")`` through the stop, without events."""
    from scipy.integrate import solve_ivp

    given = {symbol.name: float(value) for symbol, value in problem.scene.numbers().items()}
    pull = given["g"] * math.sin(given["slope"])
    grip, eps = given["mu"] * given["g"] * math.cos(given["slope"]), tolerance * given["speed"]
    start = [0.0, 0.0, given["speed"] * math.sin(given["direction"]), given["speed"] * math.cos(given["direction"])]

    def rate(t: float, y: np.ndarray) -> list[float]:
        u, w = float(y[2]), float(y[3])
        factor = -grip / math.sqrt(u * u + w * w + eps * eps)
        return [u, w, factor * u, pull + factor * w]

    def slopes(t: float, y: np.ndarray) -> list[list[float]]:
        u, w = float(y[2]), float(y[3])
        size = math.sqrt(u * u + w * w + eps * eps)
        a, b = -grip / size, grip / size**3
        return [[0, 0, 1, 0], [0, 0, 0, 1], [0, 0, a + b * u * u, b * u * w], [0, 0, b * u * w, a + b * w * w]]

    options = {"method": "LSODA", "rtol": tolerance, "atol": 0.1 * tolerance, "jac": slopes}

    def run() -> BenchAnswer:
        found = solve_ivp(rate, (0.0, problem.scene.horizon), start, **options)
        if found.status != 0:
            raise RuntimeError(found.message)
        return BenchAnswer(tuple(found.y[:, -1].tolist()), 0)

    return run
