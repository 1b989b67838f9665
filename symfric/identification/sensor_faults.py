"""Faults of records detected from the residuals: a clock that is shifted against the run, and outliers."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any, NamedTuple

import numpy as np
from scipy.special import chdtri, ndtri

from symfric.errors import SceneError
from symfric.identification.delayed import Delayed
from symfric.identification.diagnostics import LEAST, diagnose
from symfric.identification.local_fit import Minimum, Problem, minimise
from symfric.identification.loss import LOSSES, median_scale, sandwich
from symfric.identification.prediction import Predictor

CHANCE = 1e-3  # probability with which a clean record of normal noise is told to have a fault
GLANCE = 0.02  # probability below which a first look at the shifts of clean records leads to a second one
REACH, STEPS = 0.15, 121  # largest shift, over the length of the shortest record, and shifts tried between
LAGS = 10  # over which residuals may be correlated
ALIKE, CANDIDATES = 1.2, 4  # cost over the lowest one that counts as equal, and places that a search gives
GAIN = 0.25  # cost with a shift, over that without, that counts although residuals are no white noise
SIDES = 2  # neighbours on each side with which an outlier is compared if residuals are no white noise
NEAR = 1e-3  # distance from the bounds of a shift, over the distance between them, at which it is not found


class Shift(NamedTuple):
    """By how much the clock of a record is ahead of the run.

    Attributes
    ----------
    dt : float
        Subtracted from the times of the record it makes them those of the run.
    error : float
        Its standard error.
    """

    dt: float
    error: float


@dataclass(frozen=True, eq=False)
class Faults:
    """Faults of the records of a fit, by record.

    Attributes
    ----------
    shifts : dict of str to Shift
    outliers : dict of str to ndarray of int
        Indices of samples.
    """

    shifts: dict[str, Shift]
    outliers: dict[str, np.ndarray]


def faults_of(problem: Problem, best: Minimum, tries: Sequence[Minimum], y: np.ndarray) -> Faults:
    """Return the faults of the records that the residuals of a fit show.

    Parameters
    ----------
    problem : Problem
    best : Minimum
    tries : sequence of Minimum
        Further values at which shifts are tried.
    y : ndarray, shape (n,)
        Predictions at the best values.

    Notes
    -----
    A shift is a further unknown of a fit that counts outliers less. It is told if the fit with it is better than chance
    explains (likelihood ratio), and if it is larger than chance explains with residuals as correlated as they are
    (standard errors of Newey and West 1987). Outliers are residuals beyond what the largest of n normal ones reaches
    with probability `CHANCE`, by the median of their sizes; if the others are no white noise, those that differ as
    much from their neighbours.
    """
    predictor = problem.predictor
    if not isinstance(predictor, Predictor) or min(c.y.size for c in predictor.channels) < LEAST:
        return Faults({}, {})
    robust = _scaled(problem, y)
    rest, values = robust.weight * (y - problem.y), best.values
    if not _all_white(robust, rest) or np.max(np.abs(rest)) > limit(rest.size):
        robust, values, rest = _robust(problem, robust, values, rest)
    shifted = _shifted(robust, values, rest, tries)
    shifts: dict[str, Shift] = {}
    if shifted is not None:
        shifts, rest = shifted.shifts, shifted.rest
    return Faults(shifts, _outliers(robust, rest))


def limit(n: int) -> float:
    """Return the size that none of n normal numbers exceeds but by chance, their scale known from their median."""
    return float(float(ndtri(1 - CHANCE / (2 * n))) * (1 + 1.2 / np.sqrt(n)))


def outliers_of(residuals: np.ndarray, unknowns: int = 0) -> np.ndarray:
    """Return the indices of outliers among residuals in the order of time.

    Parameters
    ----------
    residuals : ndarray, shape (n,)
    unknowns : int
        How many were fitted.
    """
    size = median_scale(residuals)
    if residuals.size < LEAST or size == 0:
        return np.zeros(0, dtype=int)
    far = np.abs(residuals) > limit(residuals.size) * size
    if np.any(far) and not diagnose(np.where(far, 0.0, residuals), unknowns).is_white:
        padded = np.pad(residuals, SIDES, mode="reflect")
        around = np.lib.stride_tricks.sliding_window_view(padded, 2 * SIDES + 1)
        off = residuals - np.median(np.delete(around, SIDES, axis=1), axis=1)
        far &= np.abs(off) > limit(residuals.size) * max(median_scale(off), 0.1 * size)
    return np.flatnonzero(far)


def _outliers(problem: Problem, rest: np.ndarray) -> dict[str, np.ndarray]:
    predictor = problem.predictor
    outliers = {}
    for channel, rows in zip(predictor.channels, predictor.rows, strict=True):
        there = np.flatnonzero((problem.weight[rows] > 0) & np.isfinite(rest[rows]))
        indices = there[outliers_of(rest[rows][there], predictor.unknowns.size)]
        if indices.size:
            outliers[channel.key] = indices
    return outliers


def _scaled(problem: Problem, y: np.ndarray) -> Problem:
    """Return the problem with a robust loss and weights that make the median of each record's residuals normal."""
    weight, rest = problem.weight.copy(), problem.weight * (y - problem.y)
    for channel, rows in zip(problem.predictor.channels, problem.predictor.rows, strict=True):
        own = rest[rows][problem.weight[rows] > 0]
        size = median_scale(own) if own.size else 1.0
        weight[rows] /= max(size, 1e-12 * float(np.max(np.abs(problem.weight[rows] * channel.y))), 1e-300)
    return replace(problem, weight=weight, loss=LOSSES["cauchy"])


def _all_white(problem: Problem, rest: np.ndarray) -> bool:
    return all(diagnose(rest[r], problem.predictor.unknowns.size).is_white for r in problem.predictor.rows)


def _robust(problem: Problem, robust: Problem, values: np.ndarray, rest: np.ndarray) -> Any:
    """Return the robust problem with its own scale, its values and residuals."""
    for _ in range(2):
        minimum = minimise(robust, values)
        if not np.isfinite(minimum.cost):
            break
        values = minimum.values
        y = problem.predictor.at(values).y
        robust = _scaled(problem, y)
        rest = robust.weight * (y - problem.y)
    return robust, values, rest


def _shifted(problem: Problem, values: np.ndarray, rest: np.ndarray, tries: Sequence[Minimum]) -> "_Refined | None":
    """Return the fit with shifts, None if no record seems shifted."""
    predictor = problem.predictor
    assert isinstance(predictor, Predictor)
    n = len(predictor.channels)
    first, errors = _first_look(problem, values, rest)
    white = _all_white(problem, np.where(np.abs(rest) > limit(rest.size), 0.0, rest))
    if white and not np.any(first**2 > chdtri(1, GLANCE / n) * errors**2):
        return None
    reach = REACH * min(float(c.t[-1] - c.t[0]) for c in predictor.channels)
    delayed = Delayed(predictor, reach, np.full(n, -reach), np.full(n, reach))
    begins = [(values, np.clip(first, -reach, reach))]
    try:
        if not white:
            begins += _searched(problem, delayed, [values, *(m.values for m in tries)])
        refined = [_refined(problem, delayed, v, s, errors) for v, s in begins]
    except SceneError:  # the run cannot be longer than the records, as with a sampled input
        return None
    better = [r for r in refined if r is not None]
    if not better:
        return None
    least = min(r.cost for r in better)
    return min((r for r in better if r.cost <= ALIKE * least), key=lambda r: r.largest)


def _first_look(problem: Problem, values: np.ndarray, rest: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return shifts and their standard errors by linear regression on the slopes of the predictions over time."""
    from scipy.interpolate import CubicSpline  # slow to import

    predictor, prediction = problem.predictor, problem.predictor.at(values)
    jacobian = problem.weight[:, None] * np.nan_to_num(prediction.slopes)
    slopes = np.zeros((predictor.size, len(predictor.channels)))
    for k, (channel, rows) in enumerate(zip(predictor.channels, predictor.rows, strict=True)):
        slopes[rows, k] = -problem.weight[rows] * CubicSpline(channel.t, prediction.y[rows])(channel.t, 1)
    root = np.sqrt(problem.loss.first((rest / problem.loss.scale) ** 2))
    both = root[:, None] * np.hstack([jacobian, slopes])
    size = np.maximum(np.linalg.norm(both, axis=0), 1e-300)
    step = np.linalg.lstsq(both / size, -root * rest, rcond=1e-10)[0] / size
    return step[jacobian.shape[1] :], _errors(problem, rest, np.hstack([jacobian, slopes]))[jacobian.shape[1] :]


def _errors(problem: Problem, rest: np.ndarray, jacobian: np.ndarray) -> np.ndarray:
    """Return standard errors of all columns, infinite where they are not fixed, for residuals that are correlated."""
    size = np.linalg.norm(jacobian, axis=0)
    scaled = jacobian / np.where(size > 0, size, 1.0)
    root = sandwich(problem.loss, rest, scaled).root
    psi = problem.loss.slope(rest)
    errors = np.full(size.size, np.inf)
    for k in range(size.size):
        others = np.delete(scaled, k, axis=1)
        own = scaled[:, k] - others @ np.linalg.lstsq(others, scaled[:, k], rcond=1e-10)[0]
        if size[k] == 0 or np.linalg.norm(own) < 1e-4:
            continue
        score = psi * own
        total = float(score @ score)
        lags = min(LAGS, score.size // 5)
        more = [2 * (1 - j / (lags + 1)) * float(score[j:] @ score[:-j]) for j in range(1, lags + 1)]
        unit = np.linalg.lstsq(root.T, np.eye(size.size)[k], rcond=1e-12)[0]
        errors[k] = np.linalg.norm(unit) / size[k] * np.sqrt(max(1.0, 1 + sum(more) / max(total, 1e-300)))
    return errors


def _searched(problem: Problem, delayed: Delayed, places: Sequence[np.ndarray]) -> list[tuple[np.ndarray, np.ndarray]]:
    """Return values and shifts that are near to the records in the median, small shifts first.

    A periodic motion is as near after whole periods, of which the smallest shift is the likely one.
    """
    predictor, fine = delayed.predictor, delayed.fine
    runs = fine.many(np.array(places))
    trials = np.linspace(-delayed.reach, delayed.reach, STEPS)
    off = np.full((len(places), len(predictor.channels), STEPS), np.inf)
    for k, (channel, rows) in enumerate(zip(predictor.channels, predictor.rows, strict=True)):
        late = (channel.t >= delayed.reach) & (problem.weight[rows] > 0)
        for j in range(len(places)):
            seen = np.interp(channel.t[late, None] - trials, fine.channels[k].t, runs[fine.rows[k], j])
            with np.errstate(invalid="ignore"):
                own = np.median(np.abs(problem.weight[rows][late, None] * (seen - channel.y[late, None])), axis=0)
            off[j, k] = np.where(np.isfinite(own), own, np.inf)
    with np.errstate(divide="ignore"):
        j = int(np.argmin(np.sum(np.log(np.min(off, axis=2)), axis=1)))
    lists = [_small_first(trials, row) for row in off[j]]
    return [(np.array(places[j]), np.array([own[r] for own in lists])) for r in range(CANDIDATES)]


def _small_first(trials: np.ndarray, off: np.ndarray) -> np.ndarray:
    """Return `CANDIDATES` of the trials at which a misfit has its lowest minima, the smallest first."""
    padded = np.concatenate([[np.inf], off, [np.inf]])
    minima = np.flatnonzero((off <= padded[:-2]) & (off <= padded[2:]) & np.isfinite(off))
    lowest = trials[minima[np.argsort(off[minima], kind="stable")][: 2 * CANDIDATES]]
    return np.resize(lowest[np.argsort(np.abs(lowest), kind="stable")], CANDIDATES)


class _Refined(NamedTuple):
    """A fit with shifts that are not zero by chance: its cost per sample, largest shift, shifts and residuals.

    Residuals are NaN where the fit has no prediction, before the start of the run.
    """

    cost: float
    largest: float
    shifts: dict[str, Shift]
    rest: np.ndarray


def _refined(
    problem: Problem, delayed: Delayed, values: np.ndarray, shifts: np.ndarray, errors: np.ndarray
) -> _Refined | None:
    """Return a fit with shifts, None if it is not better than chance explains."""
    predictor, n_p = problem.predictor, values.size
    room = np.clip(2 * np.abs(shifts) + 6 * np.where(np.isfinite(errors), errors, 0.0), None, delayed.reach)
    room = np.maximum(room, 1e-3 * delayed.reach)
    high = np.where(shifts > 0, room, np.minimum(room, 0.5 * room))
    own = delayed.between(-room, high)
    early = np.concatenate([c.t < h for c, h in zip(predictor.channels, high, strict=True)])
    weight = np.where(early, 0.0, problem.weight)
    whole = replace(problem, predictor=own, weight=weight)
    held = replace(whole, fixed={n_p + k: 0.0 for k in range(shifts.size)})
    minimum = minimise(whole, np.concatenate([values, np.clip(shifts, -room, high)]))
    without = minimise(held, np.concatenate([values, np.zeros(shifts.size)]))
    if not np.isfinite(minimum.cost):
        return None
    at = own.at(minimum.values)
    rest = weight * (at.y - problem.y)
    kept = weight > 0
    size = median_scale(rest[kept])
    scaled = replace(whole, weight=weight / max(size, 1e-300))
    jacobian = scaled.weight[:, None] * np.nan_to_num(at.slopes)
    told = _errors(scaled, rest / max(size, 1e-300), jacobian)[n_p:]
    last = minimum.values[n_p:]
    ends = (last + room < NEAR * (room + high)) | (high - last < NEAR * (room + high))
    least = float(chdtri(1, CHANCE / shifts.size))
    rise = without.cost - minimum.cost
    white = _all_white(scaled, np.where(np.abs(rest) > limit(rest.size) * size, 0.0, rest))
    sure = (last**2 > least * told**2) & ~ends
    if not np.any(sure) or not 2 * rise > least * size**2 or not (white or minimum.cost < GAIN * without.cost):
        return None
    names = [c.key for c in predictor.channels]
    known = {names[k]: Shift(float(last[k]), float(told[k])) for k in np.flatnonzero(sure)}
    begun = np.concatenate([c.t >= shift for c, shift in zip(predictor.channels, last, strict=True)])
    seen = np.where(begun, problem.weight * (at.y - problem.y), np.nan)  # also of samples too early for larger shifts
    return _Refined(minimum.cost / np.count_nonzero(kept), float(np.max(np.abs(last))), known, seen)
