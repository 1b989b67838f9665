"""Where a fit begins: points spread between the bounds, tried in one batch, the best ones taken."""

import math

import numpy as np

from symfric.identification.local_fit import LOOSE, Minimum, Problem, costs_of, minimise
from symfric.long_calls import tell, until_interrupted

TRIALS = 32  # points tried for each start
MOST_TRIALS = 4096  # a power of two, with which Sobol points are balanced
APART = 0.03  # least distance of two starts, in units of the ranges
PREFIX = 0.15  # first part of the time, whose cost has fewer minima
WINDOWS = (PREFIX, 0.4)  # parts of the time that are fitted before the whole
AGREE, ENOUGH = 1e-6, 3  # starts that ended in the lowest minimum, relative, after which the others are left out
BRIEF = 15  # evaluations for a part of the time


def chosen_starts(problem: Problem, starts: int, seed: int, own: np.ndarray | None) -> list[tuple[np.ndarray, bool]]:
    """Return starting values, and whether each shall be fitted to the first part of the time before the whole.

    Parameters
    ----------
    problem : Problem
    starts : int
    seed : int
        Of the Sobol points.
    own : ndarray, shape (n_p,), or None
        Values to begin with, those of the scene.
    """
    unknowns = problem.predictor.unknowns
    first = [] if own is None else [(own, False)]
    if starts <= len(first):
        return first
    from scipy.stats import qmc  # slow to import

    count = 2 ** math.ceil(math.log2(min(TRIALS * starts, MOST_TRIALS)))
    points = qmc.Sobol(problem.free.size, seed=seed).random(count)
    values = np.array([problem.values(p) for p in points])
    early, whole = costs_of([problem.prefix(PREFIX), problem], values)
    begins = list(first)
    orders = [iter(np.argsort(whole, kind="stable")), iter(np.argsort(early, kind="stable"))]
    costs = [whole, early]
    turn = 0
    while len(begins) < starts and orders:
        turn = (turn + 1) % len(orders)
        k = next(orders[turn], None)
        if k is None or not np.isfinite(costs[turn][k]):
            del orders[turn], costs[turn]
            continue
        place = unknowns.inner(values[k])
        if all(np.max(np.abs(place - unknowns.inner(v))) > APART for v, _ in begins):
            begins.append((values[k], costs[turn] is early))
    return begins


def best_of(problem: Problem, starts: list[tuple[np.ndarray, bool]]) -> list[Minimum]:
    """Return the minima found from the starts, the lowest first; some starts are left out once enough agree."""
    minima: list[Minimum] = []
    for k, (start, early) in enumerate(starts, 1):
        least = f", least cost {min(m.cost for m in minima):.4g}" if minima else ""
        tell(f"start {k} of {len(starts)}{least}")
        before, values = len(minima), start
        with until_interrupted("identify"):
            if early:
                for part in WINDOWS:
                    brief = minimise(problem.prefix(part), values, LOOSE, BRIEF)
                    values = brief.values if np.isfinite(brief.cost) else values
            minima.append(minimise(problem, values))
        if not minima:
            raise KeyboardInterrupt  # there is nothing to keep
        if len(minima) == before:
            break
        lowest = min(m.cost for m in minima)
        if np.isfinite(lowest) and sum(m.cost <= lowest * (1 + AGREE) + problem.rounding for m in minima) >= ENOUGH:
            break
    return sorted(minima, key=lambda m: m.cost)
