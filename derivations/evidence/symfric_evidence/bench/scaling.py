"""Scaling of the run time with masses, contacts, events, cases and threads, as measured exponents."""

import statistics
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import partial

import numpy as np
import sympy as sp

from symfric.ensemble.sweep import sweep
from symfric.model import scenes
from symfric.model.outputs import End, HalfRange
from symfric.model.scene import Scene
from symfric.solve.routes import RouteName, prepare
from symfric_evidence.bench.larger import chain

_TOLERANCE = 1e-10
_ROUNDS = 5
_X = sp.Symbol("x", real=True)


@dataclass(frozen=True)
class CostGrowth:
    """Time over one size.

    Attributes
    ----------
    name, unit : str
        Name of the size, and unit of the timed work.
    sizes : tuple of float
    seconds : tuple of float
        CPU seconds, median; with threads elapsed ones.
    """

    name: str
    unit: str
    sizes: tuple[float, ...]
    seconds: tuple[float, ...]

    @property
    def exponent(self) -> float:
        """Slope of the logarithms: 1 is linear."""
        return float(np.polyfit(np.log(self.sizes), np.log(self.seconds), 1)[0])

    def to_dict(self) -> dict[str, object]:
        """Return plain data."""
        plain = {"name": self.name, "unit": self.unit, "sizes": list(self.sizes), "seconds": list(self.seconds)}
        return {**plain, "exponent": self.exponent}


def growth(progress: Callable[[str], None] | None = None) -> tuple[CostGrowth, ...]:
    """Measure all growths.

    Notes
    -----
    Goals: linear in events and in cases. Masses and contacts are those of `symfric_evidence.bench.larger.chain`, on
    both compiled routes; in closed form all modes of the chain are coupled, in a series only neighbours.
    """
    tell = progress or (lambda _: None)
    growths = []
    for route in ("exact", "taylor"):
        tell(f"masses and contacts, route {route}")
        growths.append(_over(f"masses, one contact, {route}", "step", (2, 4, 8, 16), partial(_masses, route)))
        growths.append(_over(f"contacts on 16 masses, {route}", "step", (1, 4, 16), partial(_contacts, route)))
    tell("events")
    growths.append(_over("events", "run", (300, 3_000, 30_000, 300_000), _to_events))
    tell("cases")
    growths.append(_over("cases of a sweep", "sweep", (1_000, 4_000, 16_000), _cases))
    tell("threads")
    growths.append(_over("threads", "sweep of 16 000 cases, elapsed", (1, 2), lambda n: _cases(16_000, n)))
    return tuple(growths)


def _over(name: str, unit: str, sizes: Sequence[int], timed: Callable[[int], float]) -> CostGrowth:
    return CostGrowth(name, unit, tuple(map(float, sizes)), tuple(timed(n) for n in sizes))


def _masses(route: RouteName, number: int) -> float:
    return _per_step(chain(number, moving=1), route)


def _contacts(route: RouteName, number: int) -> float:
    return _per_step(chain(16, moving=number), route)


def _per_step(scene: Scene, route: RouteName) -> float:
    program = prepare(scene, _TOLERANCE, route)
    steps = program.run().checked().stats["steps"]
    repeats = max(1, int(2_000 // steps))

    def repeated() -> None:
        for _ in range(repeats):
            program.run()

    return _seconds(repeated) / (steps * repeats)


def _to_events(number: int) -> float:
    """Seconds of a run of the belt, which has 30 events in 100 units of time."""
    scene = scenes.mass_on_belt(v_b=0.2, horizon=100.0 * number / 30).wanting({"end": End()})
    program = prepare(scene, _TOLERANCE)
    program.run().checked()
    return _seconds(program.run)


def _cases(number: int, threads: int = 0) -> float:
    scene = scenes.mass_on_belt(v_b=0.2, horizon=100.0).wanting({"half": HalfRange(_X)})
    grid = {"v_b": np.linspace(0.05, 0.35, number)}
    run = partial(sweep, scene, grid, jobs=threads or 1, tolerance=_TOLERANCE)
    run()
    return _seconds(run, time.perf_counter if threads else time.process_time)


def _seconds(run: Callable[[], object], clock: Callable[[], float] = time.process_time) -> float:
    taken = []
    for _ in range(_ROUNDS):
        start = clock()
        run()
        taken.append(clock() - start)
    return statistics.median(taken)
