"""Fits of formulas to measured points, on the same least squares as fits of scenes."""

from collections.abc import Callable, Collection, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np
import sympy as sp

from symfric.errors import NotFound, SceneError
from symfric.identification.fit import Fit
from symfric.identification.local_fit import Problem, polished, stepped_over
from symfric.identification.making import made_fit
from symfric.identification.prediction import Prediction
from symfric.identification.records import Channel, places
from symfric.identification.starts import best_of, chosen_starts
from symfric.identification.unknowns import Unknowns
from symfric.locks import SYMBOLIC, alone
from symfric.model.arguments import whole
from symfric.model.laws import Law
from symfric.model.scene import Scene
from symfric.model.symbols import nearest

STARTS = 4  # descents, from the best of the points tried


@dataclass(frozen=True, eq=False)
class Formula:
    """Predictions by a formula; what `symfric.identification.prediction.Predictor` is for scenes.

    Attributes
    ----------
    channels : tuple of Channel
    unknowns : Unknowns
    evaluate : callable
        Of values (n_p,): predictions (n,) and their derivatives (n, n_p).
    plain : callable, optional
        The same without derivatives.
    """

    channels: tuple[Channel, ...]
    unknowns: Unknowns
    evaluate: Callable[[np.ndarray], tuple[np.ndarray, np.ndarray]]
    plain: Callable[[np.ndarray], np.ndarray] | None = None

    def scenes_at(self, values: np.ndarray) -> dict[str, Scene]:
        """Return no scenes."""
        return {}

    @cached_property
    def rows(self) -> tuple[slice, ...]:
        """Place of each channel in the predictions."""
        return places(self.channels)

    @property
    def size(self) -> int:
        """Number of points."""
        return int(self.rows[-1].stop)

    def at(self, values: np.ndarray, differences: bool = True) -> Prediction:
        """Return the predictions for one set of values with their derivatives."""
        y, slopes = self.evaluate(values)
        return Prediction(y, slopes, ((),), 0)

    def many(self, values: np.ndarray) -> np.ndarray:
        """Return the predictions for many sets of values, shape (n, n_p) to (points, n)."""
        plain = self.plain or (lambda v: self.evaluate(v)[0])
        return np.stack([plain(v) for v in values], axis=1)


def fit_formula(formula: Formula, sigma: np.ndarray | None, first: np.ndarray | None = None, seed: int = 0) -> Fit:
    """Fit a formula to its channels.

    Parameters
    ----------
    formula : Formula
    sigma : ndarray, shape (n,), or None
        Standard deviations; estimated from the residuals unless given.
    first : ndarray, shape (n_p,), optional
        Values to begin with.
    seed : int
    """
    whole(seed, "seed", 0)
    y = np.concatenate([c.y for c in formula.channels])
    if y.size < formula.unknowns.size:
        raise SceneError(f"{y.size} points cannot fix {formula.unknowns.size} unknowns; measure more points")
    problem = Problem(formula, y, np.ones(y.size) if sigma is None else 1 / sigma)
    tries = best_of(problem, chosen_starts(problem, STARTS, seed, first))
    if not tries or not np.isfinite(tries[0].cost):
        raise NotFound("the formula has no finite value between the bounds; narrow them")
    return made_fit(problem, polished(problem, stepped_over(problem, tries[0], seed)), tries, sigma is not None)


def symbols_called(names: Sequence[str], own: Collection[sp.Symbol]) -> list[sp.Symbol]:
    """Return the symbols of a law by the names of the unknowns; raise unless these are all of them."""
    known = {s.name: s for s in own}
    for name in names:
        if name not in known:
            raise SceneError(f"{name} is no symbol of the law{nearest(name, known)}")
    missing = sorted(set(known) - set(names))
    if missing:
        raise SceneError(f"the law has the symbol {missing[0]} too; give its bounds, or a number in its place")
    return [known[n] for n in names]


@alone(SYMBOLIC)
def with_law(fit: Fit, law: Law) -> Fit:
    """Return a fit with its law in numbers."""
    return replace(fit, law=law.where(fit.values))


def noise_of(sigma: Any, size: int) -> np.ndarray | None:
    """Return standard deviations as a row (n,); raise unless they are positive."""
    if sigma is None:
        return None
    try:
        row = np.array(np.broadcast_to(np.asarray(sigma, dtype=float), (size,)))
    except (TypeError, ValueError):
        raise SceneError(
            f"sigma has shape {np.shape(sigma)}; give a number, or one for each of {size} points"
        ) from None
    if not np.all((row > 0) & np.isfinite(row)):
        raise SceneError("sigma is not positive and finite; give standard deviations of the noise")
    return row
