"""Stress test: random scenes, run by the automatic route and compared with a reference simulator."""

import itertools
from collections.abc import Callable, Iterator, Sequence

import numpy as np

from symfric.errors import SceneError
from symfric.solve.case_values import processors
from symfric_evidence.processes import interrupts_ignored, processes
from symfric_evidence.stress.comparison import Comparison
from symfric_evidence.stress.derivative_comparison import DerivativeComparison
from symfric_evidence.stress.families import FAMILIES, family
from symfric_evidence.stress.instants_comparison import InstantsComparison
from symfric_evidence.stress.lane_comparison import LaneComparison
from symfric_evidence.stress.orbit_comparison import OrbitComparison
from symfric_evidence.stress.scene_comparison import SceneComparison
from symfric_evidence.stress.verdict import VERDICTS, StressResult, Verdict

__all__ = [
    "FAMILIES",
    "VERDICTS",
    "DerivativeComparison",
    "InstantsComparison",
    "LaneComparison",
    "OrbitComparison",
    "SceneComparison",
    "StressResult",
    "Verdict",
    "comparison_of",
    "examine",
    "scene_named",
    "stress",
]


def stress(
    scenes: int = 10_000,
    *,
    seed: int = 0,
    families: Sequence[str] = (),
    jobs: int = 1,
    told: Callable[[list[Verdict]], None] | None = None,
) -> StressResult:
    """Run random scenes of several families and compare each with the reference simulator.

    Parameters
    ----------
    scenes : int
        Total number, divided among the families by their weights.
    seed : int
        Of the first structure of every family; the next ones follow.
    families : sequence of str, optional
        All of them unless given.
    jobs : int
        Processes; -1 takes every processor, -2 all but one.
    told : callable, optional
        Called with the verdicts on every structure, as they come.

    Returns
    -------
    StressResult
        The same for the same scenes, families and seed, whatever `jobs` is.

    Raises
    ------
    SceneError
        If a number is not positive, or a family is unknown.
    """
    if scenes < 1 or seed < 0 or jobs == 0:
        raise SceneError("scenes must be positive, seed not negative, and jobs not zero")
    names = [family(name).name for name in families] or list(FAMILIES)
    judged: list[Verdict] = []
    for verdicts in _examined(_parts(names, scenes, seed), jobs if jobs > 0 else processors() + 1 + jobs):
        judged += verdicts
        if told is not None:
            told(verdicts)
    return StressResult(tuple(judged))


def _examined(parts: list[tuple[str, int, range]], jobs: int) -> Iterator[list[Verdict]]:
    """Yield the verdicts of every part, in the order of the parts."""
    if jobs <= 1:
        yield from itertools.starmap(examine, parts)
        return
    with processes(min(jobs, len(parts))) as pool:
        with interrupts_ignored():
            waiting = [pool.submit(examine, *part) for part in parts]
        yield from (done.result() for done in waiting)


def _parts(names: list[str], scenes: int, seed: int) -> list[tuple[str, int, range]]:
    """Return family, seed and numbers of every structure, family by family."""
    weights = [FAMILIES[name].weight for name in names]
    ends = [round(scenes * w / sum(weights)) for w in itertools.accumulate(weights)]
    parts = []
    for name, count in zip(names, np.diff([0, *ends]).tolist(), strict=True):
        runs = FAMILIES[name].runs
        parts += [(name, seed + k, range(min(runs, count - k * runs))) for k in range(-(-count // runs))]
    return parts


def scene_named(name: str) -> tuple[str, int, int]:
    """Return family, seed and number of a scene's name, such as "mixed/17/42"; raise `SceneError` if it is none."""
    parts = name.split("/")
    if len(parts) != 3 or not all(p.isdecimal() for p in parts[1:]):
        raise SceneError(f"{name!r} is no scene's name; give family, seed and number, such as mixed/17/42")
    return family(parts[0]).name, int(parts[1]), int(parts[2])


_COMPARISONS: dict[str, Callable[[str, int], Comparison]] = {
    "": SceneComparison,
    "lanes": LaneComparison,
    "derivatives": DerivativeComparison,
    "cycle": OrbitComparison,
    "branch": OrbitComparison,
    "instants": InstantsComparison,
}


def comparison_of(name: str, seed: int) -> Comparison:
    """Return the comparison of one structure of a family."""
    return _COMPARISONS[family(name).sought](name, seed)


def examine(name: str, seed: int, numbers: Sequence[int]) -> list[Verdict]:
    """Run one structure of a family with the draws of these numbers."""
    comparison = comparison_of(name, seed)
    return [comparison.verdict(number) for number in numbers]
