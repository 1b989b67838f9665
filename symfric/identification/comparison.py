"""`compare_laws`: several scenes on the same records, with information criteria and errors on parts not fitted."""

import math
import warnings
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from symfric.errors import NotFound, SceneError
from symfric.identification.fit import Fit
from symfric.identification.identify import identify
from symfric.identification.local_fit import Problem, minimise
from symfric.long_calls import logged, tell, until_interrupted
from symfric.model.results import ArrayResult, Labelled
from symfric.model.scene import Scene
from symfric.model.symbols import Key, name_of, nearest, shortened

INTERRUPTED = "interrupted"  # why a law was not fitted
SAME = 2.0  # difference of AICc below which the records do not tell two laws apart (Burnham and Anderson)


@dataclass(frozen=True, eq=False)
class LawScore:
    """How well one law fits the records.

    Attributes
    ----------
    name : str
    unknowns : int
    cost : float
        Half the sum of squares; see `Fit.cost`.
    aicc, bic : float
        Information criteria; only their differences between laws mean something.
    error : float
        Root mean square of the residuals in blocks of time that were left out of the fit: over `sigma` if that was
        given, in the unit of the record if there is one, else over the standard deviation of each record.
    fit : Fit
    """

    name: str
    unknowns: int
    cost: float
    aicc: float
    bic: float
    error: float
    fit: Fit


@dataclass(frozen=True, eq=False)
class Comparison(ArrayResult):
    """Laws in the order of AICc, the best first.

    Attributes
    ----------
    scores : tuple of LawScore
    failed : dict of str to str
        Laws that could not be fitted, with the reason; see also `symfric.keep_when_interrupted`.
    notes : tuple of str
        Which laws the records do not tell apart.

    Examples
    --------
    >>> import numpy as np
    >>> import symfric as sf
    >>> scene = sf.scenes.coulomb_oscillator(0.03, delta_s=0.05)
    >>> t = np.linspace(0.1, 40.0, 200)
    >>> y = sf.simulate(scene)(t)[0] + 0.01 * np.random.default_rng(0).standard_normal(t.size)
    >>> table = sf.compare_laws({"dry": scene}, {"x": (t, y)}, {"delta": (0.001, 0.05)}, starts=2)
    >>> len(table.rows())
    1
    >>> sorted(table.to_dict())
    ['failed', 'laws', 'notes']
    >>> len(table.to_xarray().data_vars) > 0
    True
    """

    scores: tuple[LawScore, ...]
    failed: dict[str, str]
    notes: tuple[str, ...]

    def _labelled(self) -> Labelled:
        rows = self.rows()
        return (
            {n: ("law", [row[n] for row in rows]) for n in rows[0] if n != "law"},
            {"law": [r["law"] for r in rows]},
            {},
        )

    @property
    def best(self) -> LawScore:
        """The law with the lowest AICc."""
        return self.scores[0]

    def __getitem__(self, name: str) -> LawScore:
        for score in self.scores:
            if score.name == name:
                return score
        raise SceneError(f"no law {name!r} was fitted{nearest(name, [s.name for s in self.scores])}")

    def __iter__(self) -> Iterator[LawScore]:
        return iter(self.scores)

    def __len__(self) -> int:
        return len(self.scores)

    def rows(self) -> list[dict[str, Any]]:
        """Return one row of plain numbers for each law; AICc and BIC less those of the best one.

        Returns
        -------
        list[dict]
        """
        least = min(s.bic for s in self.scores)
        return [
            {
                "law": s.name,
                "unknowns": s.unknowns,
                "cost": s.cost,
                "AICc": s.aicc,
                "delta AICc": s.aicc - self.best.aicc,
                "BIC": s.bic,
                "delta BIC": s.bic - least,
                "cross-validated error": s.error,
            }
            for s in self.scores
        ]

    def to_dict(self) -> dict[str, Any]:
        return {"laws": self.rows(), "failed": dict(self.failed), "notes": list(self.notes)}

    def __str__(self) -> str:
        wide = max(len(s.name) for s in self.scores)
        lines = [f"{'law':<{wide}}  unknowns  delta AICc  delta BIC  error"]
        lines += [
            f"{r['law']:<{wide}}  {r['unknowns']:8d}  {r['delta AICc']:10.2f}  {r['delta BIC']:9.2f}  "
            f"{r['cross-validated error']:.4g}"
            for r in self.rows()
        ]
        return "\n".join([*lines, *(f"{n}: not fitted: {why}" for n, why in self.failed.items()), *self.notes])

    def __repr__(self) -> str:
        return f"Comparison({', '.join(s.name for s in self.scores)}; best: {self.best.name})"


@logged
def compare_laws(
    scenes: Mapping[str, Scene],
    records: Any,
    parameters: Mapping[Any, Any],
    observed: Mapping[Key, Any] | None = None,
    sigma: Any = None,
    starts: int = 8,
    *,
    folds: int = 4,
    seed: int = 0,
    tolerance: float = 1e-10,
    threads: int = 1,
) -> Comparison:
    """Fit several laws to the same records and compare them.

    Parameters
    ----------
    scenes : mapping of str to Scene
        The same system with different laws, by their names.
    records, observed, sigma, starts, seed, tolerance, threads
        See `identify`.
    parameters : mapping
        Unknowns with their bounds, of which each scene takes those that it has; or by the names of the laws a mapping
        for each.
    folds : int
        Each record is cut into 3 blocks of time a fold; every fold leaves out its own blocks, is fitted to the others
        and predicts what it left out.

    Returns
    -------
    Comparison

    Raises
    ------
    SceneError
        If an argument is wrong.
    NotFound
        If no law could be fitted.

    Warns
    -----
    UserWarning
        If the AICc of two laws differ by less than 2: the records do not tell them apart.

    Notes
    -----
    With k the number of unknowns, and of variances that were estimated, n samples, and -2 log L the weighted sum of
    squares S for known noise, else n log(S/n) summed over the records:
    ``AICc = -2 log L + 2 k + 2 k (k + 1)/(n - k - 1)`` and ``BIC = -2 log L + k log n`` (Burnham and Anderson, Model
    Selection and Multimodel Inference, 2002, chapters 2 and 6).

    Examples
    --------
    >>> import numpy as np
    >>> import symfric as sf
    >>> scene = sf.scenes.coulomb_oscillator(0.03, delta_s=0.05)
    >>> t = np.linspace(0.1, 40.0, 200)
    >>> y = sf.simulate(scene)(t)[0] + 0.01 * np.random.default_rng(0).standard_normal(t.size)
    >>> table = sf.compare_laws({"dry": scene}, {"x": (t, y)}, {"delta": (0.001, 0.05)}, starts=2)
    >>> table.best.name
    'dry'
    """
    if not isinstance(scenes, Mapping) or not scenes or not all(isinstance(s, Scene) for s in scenes.values()):
        raise SceneError(f"{shortened(scenes)} is no mapping of names of laws to scenes")
    if isinstance(folds, bool) or not isinstance(folds, int) or folds < 2:
        raise SceneError(f"folds is {shortened(folds)}; give at least 2")
    own = _parameters_of(scenes, parameters)
    scores, failed, left = [], {}, list(scenes)
    with until_interrupted("compare_laws"):
        for name, scene in scenes.items():
            tell(f"the law {name}, {len(scenes) - len(left) + 1} of {len(scenes)}")
            try:
                fit = identify(
                    scene, records, own[name], observed, sigma, starts, seed=seed, tolerance=tolerance, threads=threads
                )
                scores.append(_score(name, fit, folds))
            except NotFound as reason:
                failed[name] = str(reason)
            left.remove(name)
    if left and not scores:
        raise KeyboardInterrupt  # there is nothing to keep
    failed |= dict.fromkeys(left, INTERRUPTED)
    if not scores:
        raise NotFound(f"no law could be fitted: {'; '.join(f'{n}: {why}' for n, why in failed.items())}")
    scores.sort(key=lambda s: s.aicc)
    notes = tuple(_alike(scores))
    for note in notes:
        warnings.warn(note, stacklevel=2)
    return Comparison(tuple(scores), failed, notes)


def _alike(scores: list[LawScore]) -> Iterator[str]:
    """Yield a sentence for each law that is not worse than the best one."""
    best = scores[0]
    for other in scores[1:]:
        if other.aicc - best.aicc < SAME:
            yield (
                f"the records do not tell {best.name} and {other.name} apart: their AICc differ by "
                f"{other.aicc - best.aicc:.2g}; measure where they differ, see sf.test_design"
            )


def _parameters_of(scenes: Mapping[str, Scene], parameters: Any) -> dict[str, dict[Any, Any]]:
    """Return the unknowns of each scene."""
    if not isinstance(parameters, Mapping) or not parameters:
        raise SceneError("parameters must name the unknowns with their bounds, such as {'mu_s': (0.1, 0.8)}")
    if all(isinstance(v, Mapping) for v in parameters.values()):
        strange = [n for n in parameters if n not in scenes]
        if strange:
            raise SceneError(f"parameters names the law {strange[0]!r}{nearest(str(strange[0]), scenes)}")
        missing = [n for n in scenes if n not in parameters]
        if missing:
            raise SceneError(f"parameters has no unknowns for the law {missing[0]!r}; add them")
        return {n: dict(v) for n, v in parameters.items()}
    given = {name_of(k): v for k, v in parameters.items()}
    known = {n: {s.name for s in (*scene.parameters, *scene.system.states)} for n, scene in scenes.items()}
    sensors = {n for n in given if n.endswith((".offset", ".scale"))}
    nobody = [n for n in given if n not in sensors and not any(n in own for own in known.values())]
    if nobody:
        raise SceneError(f"{nobody[0]} belongs to none of the scenes{nearest(nobody[0], set().union(*known.values()))}")
    return {n: {p: v for p, v in given.items() if p in own or p in sensors} for n, own in known.items()}


def _score(name: str, fit: Fit, folds: int) -> LawScore:
    problem, n = fit._problem, fit.samples
    rows = problem.predictor.rows
    squares = [float(np.sum((problem.weight * (problem.y - fit._y))[r] ** 2)) for r in rows]
    counts = [int(np.count_nonzero(problem.weight[r])) for r in rows]
    k = len(fit.names) + (0 if fit._known else len(rows))
    if fit._known:
        deviance = sum(squares)
    else:  # with the weights taken out again, so that fits with different estimates compare
        scales = [float(np.mean(1 / problem.weight[r])) for r in rows]
        deviance = sum(
            m * math.log(max(s * scale**2 / m, 1e-300)) for m, s, scale in zip(counts, squares, scales, strict=True)
        )
    small = 2 * k * (k + 1) / (n - k - 1) if n > k + 1 else math.inf
    aicc, bic = deviance + 2 * k + small, deviance + k * math.log(n)
    return LawScore(name, len(fit.names), fit.cost, aicc, bic, left_out_error(fit, problem, folds), fit)


def left_out_error(fit: Fit, problem: Problem, folds: int) -> float:
    """Return the root mean square of the residuals in blocks left out of fits to the others; see `LawScore`."""
    predictor = problem.predictor
    block = np.zeros(predictor.size, dtype=int)
    for channel, rows in zip(predictor.channels, predictor.rows, strict=True):
        part = (channel.t - channel.t[0]) / (channel.t[-1] - channel.t[0])
        block[rows] = np.minimum((part * 3 * folds).astype(int), 3 * folds - 1) % folds
    total, count = 0.0, 0
    single = len(predictor.channels) == 1
    unit = np.concatenate(
        [c.sigma if fit._known else np.full(c.y.size, 1.0 if single else np.std(c.y)) for c in predictor.channels]
    )
    for fold in range(folds):
        out = (block == fold) & (problem.weight > 0)
        if not np.any(out):
            continue
        kept = replace(problem, weight=np.where(block == fold, 0.0, problem.weight))
        best = minimise(kept, fit.vector)
        rest = (predictor.at(best.values).y - problem.y)[out]
        total += float(np.sum((rest / unit[out]) ** 2))
        count += int(np.count_nonzero(out))
    return math.sqrt(total / count) if count else math.nan
