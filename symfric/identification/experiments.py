"""`test_design`: which further measurements would fix the unknowns of a fit."""

import itertools
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from symfric.errors import NotFound, SceneError
from symfric.identification.fit import Fit
from symfric.identification.prediction import Predictor
from symfric.long_calls import logged, tell, until_interrupted
from symfric.model.arguments import instance, is_one_of
from symfric.model.results import Result
from symfric.model.symbols import Key, finite, name_of, shortened

WEAK = 1e-12  # information of the bounds themselves, relative, that keeps determinants of unfixed unknowns finite
MOST = 10_000  # candidates


@dataclass(frozen=True, eq=False)
class TestDesign(Result):
    """Measurements in the order in which they should be made.

    Attributes
    ----------
    chosen : tuple of dict
        Values of the settings, the most informative first.
    standard_errors : tuple of dict
        Expected standard errors of the unknowns after each of them.
    candidates : tuple of dict
        All settings that were considered.
    gains : ndarray, shape (n,)
        By how much each candidate alone raises log det of the information; NaN where its run failed.

    Examples
    --------
    >>> import numpy as np
    >>> import symfric as sf
    >>> scene = sf.scenes.coulomb_oscillator(0.03, delta_s=0.05)
    >>> t = np.linspace(0.1, 40.0, 200)
    >>> y = sf.simulate(scene)(t)[0] + 0.01 * np.random.default_rng(0).standard_normal(t.size)
    >>> fit = sf.identify(scene, {"x": (t, y)}, {"delta": (0.001, 0.05)}, starts=2)
    >>> plan = sf.test_design(fit, {"x0": [0.5, 1.0]})
    >>> sorted(plan.to_dict())[:2]
    ['candidates', 'chosen']
    """

    __test__ = False  # no class of tests

    chosen: tuple[dict[str, float], ...]
    standard_errors: tuple[dict[str, float], ...]
    candidates: tuple[dict[str, float], ...]
    gains: np.ndarray

    def __repr__(self) -> str:
        shown = "; ".join(", ".join(f"{n}={v:.4g}" for n, v in c.items()) for c in self.chosen)
        return f"TestDesign({shown}; of {len(self.candidates)} candidates)"


@logged
def test_design(
    fit: Fit,
    settings: Mapping[Key, Sequence[float]],
    number: int = 1,  # noqa: PT028 - no test
    label: str | None = None,  # noqa: PT028
) -> TestDesign:
    """Choose settings whose records, added to those of a fit, would fix its unknowns best.

    Parameters
    ----------
    fit : Fit
        Its values are taken for the truth; times and noise of its records are those of what would be measured.
    settings : mapping of name to sequence of float
        Values of the scene that the experimenter can set, such as belt speeds or amplitudes and frequencies of an
        excitation; all combinations are candidates.
    number : int
        How many measurements to choose, one after the other; one may be chosen again.
    label : str, optional
        Of the scene to measure on, if the fit has several.

    Returns
    -------
    TestDesign

    Raises
    ------
    SceneError
        If a setting is no value of the scene, or is one of the unknowns.
    NotFound
        If no candidate's run reaches the end of the records.

    Notes
    -----
    D-optimal design: the determinant of the information ``J' J/s^2`` of all records is made as large as possible, which
    makes the volume of the confidence ellipsoid smallest (Atkinson, Donev and Tobias, Optimum Experimental Designs,
    2007, chapter 10), here greedily. Unknowns are counted in units of the distance of their bounds.

    Examples
    --------
    >>> import numpy as np
    >>> import symfric as sf
    >>> scene = sf.scenes.coulomb_oscillator(0.03, delta_s=0.05)
    >>> t = np.linspace(0.1, 40.0, 200)
    >>> y = sf.simulate(scene)(t)[0] + 0.01 * np.random.default_rng(0).standard_normal(t.size)
    >>> fit = sf.identify(scene, {"x": (t, y)}, {"delta": (0.001, 0.05)}, starts=2)
    >>> plan = sf.test_design(fit, {"x0": [0.5, 1.0]})
    >>> len(plan.chosen)
    1
    """
    predictor, unknowns = instance(fit, Fit, "fit").predictor, fit.predictor.unknowns
    scene_label = _label(fit, label)
    names, rows = _grid(fit, settings, scene_label)
    if isinstance(number, bool) or not isinstance(number, int) or number < 1:
        raise SceneError(f"number is {shortened(number)}; give how many measurements to choose, at least 1")
    ranges = unknowns.high - unknowns.low
    own = fit._jacobian * ranges / np.sqrt(fit.variance)
    base = own.T @ own
    candidates: list[dict[str, float]] = []
    parts: dict[int, np.ndarray] = {}  # information of the candidates whose runs succeed
    channels = tuple(c for c in predictor.channels if c.scene == scene_label)
    kept = np.concatenate([np.full(c.y.size, c.scene == scene_label) for c in predictor.channels])
    weight = fit._problem.weight[kept] / np.sqrt(fit.variance)
    again = replace(predictor, channels=channels)
    with until_interrupted("test_design"):
        for k, row in enumerate(rows):
            tell(f"setting {k + 1} of {len(rows)}")
            candidate = dict(zip(names, row, strict=True))
            part = _information(again, candidate, fit.vector, weight[:, None] * ranges)
            candidates.append(candidate)
            parts |= {} if part is None else {k: part}
    there = list(parts)
    if not there and len(candidates) < len(rows):
        raise KeyboardInterrupt  # there is nothing to keep
    if not there:
        raise NotFound("no candidate's run reaches the end of the records; choose other settings")
    level = WEAK * max(1.0, *(float(np.trace(parts[k])) for k in there))
    weak = np.eye(ranges.size) * level
    gains = np.full(len(candidates), np.nan)
    gains[there] = [_log_det(base + weak + parts[k]) - _log_det(base + weak) for k in there]
    chosen, errors, total = [], [], base + weak
    for _ in range(number):
        best = max(there, key=lambda k: _log_det(total + parts[k]))
        total = total + parts[best]
        chosen.append(candidates[best])
        spread = np.sqrt(np.diag(np.linalg.inv(total))) * ranges
        errors.append(dict(zip(fit.names, spread.tolist(), strict=True)))
    return TestDesign(tuple(chosen), tuple(errors), tuple(candidates), gains)


def _log_det(matrix: np.ndarray) -> float:
    return float(np.linalg.slogdet(matrix)[1])


def _label(fit: Fit, label: str | None) -> str:
    labels = fit.predictor.labels
    if label is None and len(labels) == 1:
        return labels[0]
    if label is None or not is_one_of(label, labels):
        raise SceneError(f"label is {shortened(label)}; the fit has the scenes {', '.join(labels)}")
    return label


def _grid(fit: Fit, settings: Any, label: str) -> tuple[list[str], list[tuple[float, ...]]]:
    """Return names and all combinations of the settings."""
    if not isinstance(settings, Mapping) or not settings:
        raise SceneError("settings must name what can be set, such as {'v_b': [0.1, 0.2, 0.5]}")
    scene = fit.predictor.scenes[label]
    names, axes = [], []
    for key, values in settings.items():
        name = name_of(key)
        scene.parameter(name)
        if name in fit.names:
            raise SceneError(f"{name} is an unknown of the fit; settings are values that the experimenter knows")
        names.append(name)
        axes.append([finite(float(v), f"a value of {name}") for v in np.atleast_1d(np.asarray(values, dtype=float))])
    rows = list(itertools.product(*axes))
    if not 1 <= len(rows) <= MOST:
        raise SceneError(f"settings have {len(rows)} combinations; give 1 to {MOST}")
    return names, rows


def _information(
    predictor: Predictor, candidate: dict[str, float], values: np.ndarray, scale: np.ndarray
) -> np.ndarray | None:
    """Return the information of one candidate's records, None if its run fails."""
    record = predictor.at(values, differences=False, settings=candidate)
    if not np.all(np.isfinite(record.y)):
        return None
    slopes = scale * np.where(np.isfinite(record.slopes), record.slopes, 0.0)
    return np.asarray(slopes.T @ slopes)
