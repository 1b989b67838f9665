"""Make a `Fit` of a minimum, with notes on its reliability."""

from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from symfric.identification.crossings import crossings_near
from symfric.identification.fit import Fit
from symfric.identification.local_fit import Minimum, Problem
from symfric.identification.loss import sandwich
from symfric.identification.sensor_faults import faults_of

SHOWN = 5  # outliers that a note lists
LARGE, EXACT = 0.9, 1e-6  # residuals over the variation of a record: no fit at all, and no noise at all


def made_fit(problem: Problem, best: Minimum, tries: list[Minimum], known: bool) -> Fit:
    """Return the fit at a minimum of one run for each scene."""
    at = problem.predictor.at(best.values)
    jacobian = problem.weight[:, None] * np.where(np.isfinite(at.slopes), at.slopes, 0.0)
    rest, inflation = problem.weight * (at.y - problem.y), 1.0
    if problem.loss.is_robust:
        jacobian, inflation = sandwich(problem.loss, rest, jacobian)
    faults = faults_of(problem, best, tries, at.y)
    fit = replace(fit_of(problem, best, tries, known, at.y, jacobian), _inflation=inflation, faults=faults)
    fit = replace(fit, crossings=crossings_near(problem, best, jacobian, fit.variance, at.sequence))
    secants = (
        "the motion grazes, has simultaneous events or a law of infinite slope here: some derivatives are differences"
    )
    return with_notes(fit, *([secants] if at.secants else []))


def fit_of(
    problem: Problem, best: Minimum, tries: list[Minimum], known: bool, y: np.ndarray, jacobian: np.ndarray
) -> Fit:
    """Return a fit without notes.

    Parameters
    ----------
    problem : Problem
    best : Minimum
    tries : list of Minimum
        What the starts led to.
    known : bool
        Whether the noise was given.
    y : ndarray, shape (n,)
        Predictions.
    jacobian : ndarray, shape (any, n_p)
        Whose ``(J'J)^-1`` is the covariance for unit variance.
    """
    predictor, unknowns = problem.predictor, problem.predictor.unknowns
    values = dict(zip(unknowns.names, best.values.tolist(), strict=True))
    on = (best.values == unknowns.low) | (best.values == unknowns.high)
    active = tuple(n for n, a in zip(unknowns.names, on, strict=True) if a)
    scenes = predictor.scenes_at(best.values)
    rest = (problem.y - y) * problem.weight
    freedom = max(1, int(np.count_nonzero(problem.weight)) - int(np.count_nonzero(~on)))
    scale = 1.0 if known or problem.loss.is_robust else float(np.sqrt(rest @ rest / freedom))
    sigma = {
        c.key: scale * float(np.mean(1 / problem.weight[r]))
        for c, r in zip(predictor.channels, predictor.rows, strict=True)
    }
    return Fit(
        names=unknowns.names,
        values=values,
        scenes=scenes,
        tries=tuple(tries),
        crossings=(),
        notes=(),
        active=active,
        sigma=sigma,
        law=None,
        evaluations=best.evaluations + sum(m.evaluations for m in tries[1:]),
        _problem=problem,
        _known=known,
        _y=y,
        _jacobian=jacobian,
    )


def with_notes(fit: Fit, *further: str) -> Fit:
    """Return a fit with its notes and further ones."""
    return replace(fit, notes=(*_notes(fit), *further))


def _notes(fit: Fit) -> Iterator[str]:
    """Yield the notes: whatever limits the use of the fitted numbers."""
    for name in fit.active:
        yield (
            f"{name} is at its bound {fit.values[name]:.6g}; widen it, or take the value as unknown beyond it: "
            f"intervals follow the cost with {name} free between its bounds, and standard errors of the others "
            "regard it as free"
        )
    for direction in fit.unidentifiable:
        yield str(direction)
    for crossing in fit.crossings:
        shown = ", ".join(f"{n} = {v:.6g}" for n, v in crossing.values.items())
        if not np.isfinite(crossing.jump):
            yield f"within one standard error, beyond {shown}, no run reaches the end of the records; use profiles"
            continue
        kind = f"jumps by {100 * crossing.jump:.2g} %" if abs(crossing.jump) > 1e-3 else "has an edge"
        yield (
            f"within one standard error, at {shown}, the number of events goes from {crossing.events[0]} to "
            f"{crossing.events[1]} and the cost {kind}; use profiles in place of standard errors"
        )
    yield from _fault_notes(fit)
    for name, statistics in fit.diagnostics.items():
        size = float(np.std(fit.records[name][1]))
        if statistics.rms > LARGE * size and np.isfinite(statistics.white):
            yield (
                f"the fit explains hardly anything of {name}: its residuals are as large as its variation; check what "
                f"it measures, the units of its values and times, and the bounds"
            )
        elif not statistics.is_white and statistics.rms > EXACT * size:
            yield (
                f"the residuals of {name} are not white noise (autocorrelation {statistics.autocorrelation:.2f}): the "
                "scene or the sensor lacks something, and standard errors are too small"
            )
    if fit._known and fit.freedom > 0 and not fit._problem.loss.is_robust:
        ratio = 2 * fit.cost / fit.freedom
        spread = 4 * np.sqrt(2 / fit.freedom)
        if abs(ratio - 1) > spread:
            word = "larger" if ratio > 1 else "smaller"
            yield f"the residuals are {np.sqrt(ratio):.3g} times as large as sigma says, {word} than chance explains"


def _fault_notes(fit: Fit) -> Iterator[str]:
    """Yield a sentence for each fault of a record."""
    for name, shift in fit.faults.shifts.items():
        yield (
            f"the record of {name} seems shifted by about dt = {shift.dt:.3g} +- {shift.error:.1g} s against the run; "
            "subtract dt from its times, leave out samples that are then before the start of the run, and fit again"
        )
    for name, indices in fit.faults.outliers.items():
        shown = ", ".join(f"{k} (t = {fit.records[name][0][k]:.6g})" for k in indices[:SHOWN])
        more = ", ..." if indices.size > SHOWN else ""
        word = (
            f"{indices.size} samples of {name} are outliers"
            if indices.size > 1
            else f"1 sample of {name} is an outlier"
        )
        cure = (
            "leave them out, or fit with loss='cauchy'"
            if fit.loss == "linear"
            else f"loss={fit.loss!r} counts them less"
        )
        yield f"{word}: samples {shown}{more}; {cure}"
