"""Random scenes run by the chosen route, and compared with other routes: does a wrong run ever say nothing?"""

import math
from collections import Counter
from collections.abc import Callable, Iterator, Sequence
from dataclasses import asdict, dataclass
from functools import cached_property

import numpy as np
import sympy as sp
from joblib import Parallel, delayed

from symfric.bench.random_scenes import Dice, Draw, structure
from symfric.errors import SceneError
from symfric.lower.energy import energy_functions
from symfric.model.names import SPEED
from symfric.model.scene import Scene
from symfric.solve.choose import Program, explain, prepare
from symfric.solve.energy import imbalance
from symfric.solve.exact.program import Exact
from symfric.solve.integrators import IntegratorsProgram
from symfric.solve.one_mode import Integrators
from symfric.solve.run import Run
from symfric.solve.status import ADVICE, Status
from symfric.solve.taylor.program import Taylor, TaylorProgram

PER_STRUCTURE = 200  # runs of one structure, whose compilation takes as long as some dozens of them
TOLERANCES = (1e-6, 1e-8, 1e-10)  # the first where a law has an infinite slope, which no route takes much finer
WRONG = 1000.0  # tolerances that two runs may differ by
CHANGE = 10.0  # how many times the change that a perturbation causes two runs may differ by
_FINER = 1e-3  # of the tolerance: the third opinion
_STEPS, _EVENTS = 20_000, 5_000  # budgets of a run; within them every run is over in about a second
_SECOND = Integrators(max_steps=5_000, max_events=300)
_REFEREE = 1e-13  # tolerance of the second route where it disagrees: its errors are relative to 1, or to the state
_PATIENT = Integrators(max_steps=100_000, max_events=300)
_TIMES = 8  # at which runs are compared
_ROUNDING = 4e-16  # of a perturbation by rounding alone

VERDICTS = ("agrees", "alone", "unconfirmed", "status", "sensitive", "silent failure")


@dataclass(frozen=True)
class Verdict:
    """What became of one random scene.

    Attributes
    ----------
    name : str
        Seed of the structure and number of the run, "17/42".
    kind : str
        Kind of its numbers, see `symfric.bench.random_scenes.KINDS`.
    verdict : str
        "agrees" with the second route; "alone" if that had no answer: agrees with itself at a finer tolerance;
        "unconfirmed" if that had none either; the energies balance in all three. "status": ended early, with advice;
        "sensitive": runs differ, but by no more than rounding or the tolerance in its numbers makes of it; "silent
        failure": none of these.
    route, status : str
        Of the chosen run.
    tolerance : float
    finer, second, energy : float
        Largest difference from the run at a finer tolerance and from the second route, relative to each state's largest
        value, and the residual of the energies; NaN where there is none.
    change : float
        Largest change of the run by perturbations, relative likewise; NaN where it was not needed.
    """

    name: str
    kind: str
    verdict: str
    route: str
    status: str
    tolerance: float
    finer: float
    second: float
    energy: float
    change: float


@dataclass(frozen=True)
class StressResult:
    """What a stress run found.

    Attributes
    ----------
    verdicts : tuple of Verdict
    """

    verdicts: tuple[Verdict, ...]

    @property
    def counts(self) -> dict[str, int]:
        """Number of scenes by verdict."""
        found = Counter(v.verdict for v in self.verdicts)
        return {name: found[name] for name in VERDICTS}

    @property
    def failures(self) -> tuple[Verdict, ...]:
        """The silent failures."""
        return tuple(v for v in self.verdicts if v.verdict == "silent failure")

    def to_dict(self) -> dict[str, object]:
        """Return counts and every scene that did not simply agree, as plain data."""
        statuses = Counter(v.status for v in self.verdicts if v.verdict == "status")
        notable = [asdict(v) for v in self.verdicts if v.verdict not in ("agrees", "alone")]
        plain = [{k: None if x != x else x for k, x in row.items()} for row in notable]
        return {"scenes": len(self.verdicts), "counts": self.counts, "statuses": dict(statuses), "notable": plain}

    def __repr__(self) -> str:
        return f"StressResult({', '.join(f'{n} {name}' for name, n in self.counts.items() if n)})"


def stress(
    scenes: int = 10_000,
    *,
    seed: int = 0,
    jobs: int = 1,
    progress: Callable[[int], None] | None = None,
) -> StressResult:
    """Run random scenes and compare each with other routes.

    Parameters
    ----------
    scenes : int
        Some dozens of structures with `PER_STRUCTURE` draws of numbers each.
    seed : int
        Of the first structure; the next ones follow.
    jobs : int
        Processes; -1 takes every processor.
    progress : callable, optional
        Called with the number of scenes done.

    Returns
    -------
    StressResult
        The same for the same scenes and seed, whatever `jobs` is.

    Raises
    ------
    SceneError
        If a number is not positive.
    """
    if scenes < 1 or seed < 0 or jobs == 0:
        raise SceneError("scenes must be positive, seed not negative, and jobs not zero")
    parts = [
        (seed + k, range(min(PER_STRUCTURE, scenes - k * PER_STRUCTURE))) for k in range(-(-scenes // PER_STRUCTURE))
    ]
    found: list[Verdict] = []
    for verdicts in Parallel(n_jobs=jobs, return_as="generator")(delayed(examine)(*part) for part in parts):
        found += verdicts
        if progress is not None:
            progress(len(found))
    return StressResult(tuple(found))


def scene_named(name: str) -> tuple[int, int]:
    """Return seed and number of a scene's name, such as "17/42"; raise `SceneError` if it is none."""
    parts = name.split("/")
    if len(parts) != 2 or not all(p.isdecimal() for p in parts):
        raise SceneError(f"{name!r} is no scene's name; give seed and number, such as 17/42")
    return int(parts[0]), int(parts[1])


def examine(seed: int, numbers: Sequence[int]) -> list[Verdict]:
    """Run one structure with the draws of these numbers."""
    bench = Comparison(seed)
    return [bench.verdict(number) for number in numbers]


class Comparison:
    """One structure, compiled for every route that takes it."""

    def __init__(self, seed: int):
        self.seed, self.scene = seed, structure(seed)
        self.dice = Dice(self.scene)
        steep = any(c.law.kinetic.has(sp.sqrt(SPEED), sp.asin) for c in self.scene.contacts)
        self.tolerance = TOLERANCES[0 if steep else seed % len(TOLERANCES)]
        self.chosen = _chosen(self.scene, self.tolerance)
        budgets = Taylor(max_steps=_STEPS, max_events=_EVENTS)
        self.fine = TaylorProgram(self.scene, max(_FINER * self.tolerance, 1e-13), budgets)
        self.second = None if steep else IntegratorsProgram(self.scene, max(0.1 * self.tolerance, 1e-10), _SECOND)
        self.energies = energy_functions(self.scene)
        self.symbols = {s.name: s for s in self.scene.parameters}
        self.times = np.linspace(0, self.scene.horizon, _TIMES + 1)[1:]

    @cached_property
    def referee(self) -> IntegratorsProgram:
        """The second route at its finest."""
        return IntegratorsProgram(self.scene, _REFEREE, _PATIENT)

    def verdict(self, number: int) -> Verdict:
        """Run one draw and compare."""
        draw = self.dice.draw(self.seed, number)
        run, fine = (p.run(draw.values, draw.initial) for p in (self.chosen, self.fine))
        finer, other, energy, change = self.difference(run, fine), math.nan, math.nan, math.nan
        if self.second is not None:
            other = self.difference(run, self.second.run(draw.values, draw.initial))
            if other > WRONG * self.tolerance:
                better = self.difference(run, self.referee.run(draw.values, draw.initial))
                other = better if better == better else other
        if run.status != Status.OK:
            verdict = "status" if ADVICE[run.status] and np.isfinite(run.t_final) else "silent failure"
        else:
            energy = imbalance(run, *self.energies, {self.symbols[k]: v for k, v in draw.values.items()})
            allowed = WRONG * self.tolerance
            if energy <= allowed and not (finer > allowed or other > allowed):
                verdict = "agrees" if other == other else "alone" if finer == finer else "unconfirmed"
            else:
                change = self.change(draw, fine)
                within = energy <= allowed and np.nanmax([finer, other, 0.0]) <= CHANGE * change  # not if it is NaN
                verdict = "sensitive" if within else "silent failure"
        name, status = f"{self.seed}/{number}", run.status.name
        return Verdict(name, draw.kind, verdict, run.route, status, self.tolerance, finer, other, energy, change)

    def difference(self, a: Run, b: Run) -> float:
        """Return the largest difference of two runs, each state relative to its largest value; NaN if one failed."""
        if a.status != Status.OK or b.status != Status.OK:
            return math.nan
        size = np.maximum(np.max(np.abs(a.x), axis=1), np.max(np.abs(b.x), axis=1))
        for part in np.split(np.arange(size.size), 2):  # what is a millionth of its like is noise
            size[part] = np.maximum(size[part], 1e-6 * np.max(size[part]))
        size = np.maximum(size, max(1e-12 * np.max(size), 1e-300))
        return float(np.max(np.abs(a(self.times) - b(self.times)) / size[:, None]))

    def change(self, draw: Draw, fine: Run) -> float:
        """Return the largest change of a run when its numbers change by a tolerance, or by a rounding."""
        changes = [self.difference(self.fine.run(v, i), fine) for v, i in _perturbed(draw, self.tolerance)]
        return max((c for c in changes if c == c), default=math.nan)


def _chosen(scene: Scene, tolerance: float) -> Program:
    """Prepare the route that `prepare` would choose, within the budgets."""
    settings = Exact if explain(scene).route == "exact" else Taylor
    return prepare(scene, tolerance, settings(max_steps=_STEPS, max_events=_EVENTS))


def _perturbed(draw: Draw, tolerance: float) -> Iterator[tuple[dict, dict]]:
    """Yield values and starts that differ by a tolerance and by a rounding, in random directions."""
    rng = np.random.default_rng(0)
    largest = max(abs(x) for x in draw.initial.values())
    for part in (tolerance, tolerance, tolerance, _ROUNDING, _ROUNDING, _ROUNDING):
        values = {k: v * (1 + part * rng.choice([-1, 1])) for k, v in draw.values.items()}
        initial = {k: v + part * largest * rng.choice([-1, 1]) for k, v in draw.initial.items()}
        yield values, initial
