"""Fits by multiple shooting: a run for the whole record where one exists, else the pieces."""

from dataclasses import replace

import numpy as np

from symfric.errors import NotFound
from symfric.identification.fit import Fit
from symfric.identification.local_fit import Minimum, Problem, minimise, polished
from symfric.identification.making import fit_of, made_fit, with_notes
from symfric.identification.pieces import Pieces
from symfric.identification.prediction import Predictor
from symfric.identification.shooting import Joined, join

AGREE, ENOUGH = 1e-6, 2  # starts that ended in the lowest minimum, relative, after which the others are left out
SAME = 1e-3  # how much larger, relative, the cost of one run may be than that of the pieces


def joined_fit(problem: Problem, begins: list[tuple[np.ndarray, bool]], segments: int, known: bool) -> Fit:
    """Return the fit of records cut into pieces.

    Parameters
    ----------
    problem : Problem
        Of a `Predictor`.
    begins : list of (values, bool)
        Starts; see `symfric.identification.starts.chosen_starts`.
    segments : int
    known : bool
        Whether the noise was given.

    Raises
    ------
    NotFound
        If the pieces join from no start.
    """
    assert isinstance(problem.predictor, Predictor)
    pieces = Pieces(problem.predictor, segments)
    minima: list[Joined] = []
    for values, _ in begins:
        joined = join(problem, pieces, values)
        if joined is not None and np.isfinite(joined.cost):
            minima.append(joined)
            lowest = min(j.cost for j in minima)
            if sum(j.cost <= lowest * (1 + AGREE) + problem.rounding for j in minima) >= ENOUGH:
                break
    if not minima:
        raise NotFound(
            f"the {segments} pieces of the records join from no start; take more pieces, or narrow the bounds"
        )
    minima.sort(key=lambda j: j.cost)
    best = minima[0]
    tries = [Minimum(j.values, j.cost, j.evaluations, 0) for j in minima]
    whole = minimise(problem, best.values)
    if whole.cost <= best.cost * (1 + SAME) + problem.rounding:
        return made_fit(problem, polished(problem, whole), tries, known)
    fit = replace(fit_of(problem, tries[0], tries, known, best.y, best.information), _step=best.step)
    return with_notes(
        fit,
        f"one run cannot follow the records so long: predictions are those of {segments} pieces that join, and "
        "profiles do not apply",
    )
