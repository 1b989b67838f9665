"""Cost of a case against the number of cases that run together, on one thread and on two, beside heyoka's batches."""

import time
from collections.abc import Callable
from dataclasses import asdict, dataclass, replace
from functools import partial

import numpy as np

from symfric.ensemble.sweep import sweep
from symfric.model.outputs import HalfRange
from symfric.solve.batch import Batch
from symfric_evidence.bench.peers.registry import parts_of_sweep, peers
from symfric_evidence.bench.problems import Problem, named

SIZES = (1, 10, 100, 1000, 10_000)
_TOLERANCE = 1e-6
Work = Callable[[], object]
_LEAST, _ROUNDS = 0.02, 3  # s, of a sample


@dataclass(frozen=True)
class CaseCost:
    """Time of a case over the number of cases.

    Attributes
    ----------
    name : str
    sizes : tuple of int
        Cases that run together.
    seconds : tuple of float
        Of one case, the least of some rounds: CPU time; with threads elapsed time.
    """

    name: str
    sizes: tuple[int, ...]
    seconds: tuple[float, ...]

    def to_dict(self) -> dict[str, object]:
        """Return plain data."""
        return asdict(self)


def case_costs(progress: Callable[[str], None] | None = None, sizes: tuple[int, ...] = SIZES) -> tuple[CaseCost, ...]:
    """Measure P5's belts, from rest to t = 200 with the half range from t = 150, in batches of several sizes.

    Notes
    -----
    The sweep takes the half range of the whole motion, as one call of `symfric.sweep` does; so it has one part instead
    of two. heyoka's loops are those of the benchmark.
    """
    problem, tell = named("P5"), progress or (lambda _: None)
    ways: dict[str, tuple[Callable[[int], Work], bool]] = {
        "one run after the other": (partial(_of_peer, "symfric one by one", problem), False),
        "map": (partial(_of_peer, "symfric", problem), False),
        "map on two threads, elapsed": (partial(_on_threads, problem, 2), True),
        "sweep": (partial(_sweep, problem), False),
    }
    for name in ("heyoka", "heyoka batch"):
        if not peers()[name].missing:
            ways[name] = (partial(_of_peer, name, problem), False)
    costs = []
    for name, (make, elapsed) in ways.items():
        tell(f"cases together: {name}")
        costs.append(CaseCost(name, sizes, tuple(_seconds(make(n), n, elapsed) for n in sizes)))
    return tuple(costs)


def _some(problem: Problem, number: int) -> Problem:
    low, high = problem.speeds[0], problem.speeds[-1]
    return replace(problem, speeds=tuple(np.linspace(low, high, number).tolist()))


def _of_peer(name: str, problem: Problem, number: int) -> Work:
    return peers()[name].prepare(_some(problem, number), _TOLERANCE)


def _on_threads(problem: Problem, threads: int, number: int) -> Work:
    first, second, x, u = parts_of_sweep(problem, _TOLERANCE, None)
    speeds = {"v_b": np.array(_some(problem, number).speeds)}

    def run() -> Batch:
        state = first.map(speeds, threads=threads).final
        return second.map(speeds, {x: state[0], u: state[1]}, threads=threads)

    return run


def _sweep(problem: Problem, number: int) -> Work:
    scene = problem.scene.until(problem.window[1], {"half": HalfRange(problem.scene.system.q[0])})
    grid = {"v_b": np.array(_some(problem, number).speeds)}
    return lambda: sweep(scene, grid, tolerance=_TOLERANCE)


def _seconds(run: Work, number: int, elapsed: bool) -> float:
    clock = time.perf_counter if elapsed else time.process_time
    start = clock()
    run()
    once = max(clock() - start, 1e-7)
    repeats, samples = max(1, int(_LEAST / once)), []
    for _ in range(_ROUNDS if once < 1 else 1):
        start = clock()
        for _ in range(repeats):
            run()
        samples.append((clock() - start) / (repeats * number))
    return min(samples)
