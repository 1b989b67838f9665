"""`identify`: values of scenes from measured records by least squares on exact derivatives."""

from collections.abc import Mapping
from dataclasses import replace
from typing import Any, Literal

import numpy as np

from symfric.errors import NotFound, SceneError
from symfric.identification.fit import Fit
from symfric.identification.joined_fit import joined_fit
from symfric.identification.local_fit import Minimum, Problem, polished, stepped_over
from symfric.identification.loss import Loss, median_scale, read_loss
from symfric.identification.making import made_fit
from symfric.identification.prediction import PredictionModel, Predictor
from symfric.identification.records import read_channels
from symfric.identification.starts import best_of, chosen_starts
from symfric.identification.unknowns import OFFSET, SCALE, START, Unknowns, read_unknowns
from symfric.long_calls import logged, tell
from symfric.model.arguments import whole
from symfric.model.scene import Scene
from symfric.model.symbols import Key, shortened
from symfric.solve.case_values import workers_of
from symfric.solve.program import check_tolerance

UNLIKE = 100.0  # ratio of a record to what the scene can do, beyond which the record is in another unit
TRIALS = 64  # cases that such a comparison takes
REWEIGHTED, SAME = 10, 1e-3  # rounds of estimating the noise of several records, and the change that ends them


@logged
def identify(
    scene: Scene | Mapping[str, Scene],
    records: Any,
    parameters: Mapping[Key, tuple[float, float]],
    observed: Mapping[Key, Any] | None = None,
    sigma: Any = None,
    starts: int = 8,
    *,
    segments: int = 1,
    seed: int = 0,
    tolerance: float = 1e-10,
    threads: int = 1,
    loss: Literal["linear", "soft_l1", "huber", "cauchy"] = "linear",
) -> Fit:
    """Fit values of a scene to measured records by least squares.

    Parameters
    ----------
    scene : Scene or mapping of str to Scene
        Several scenes by label are fitted at once; their records are then given by label.
    records : mapping of name to (t, y), xarray.Dataset, or path of a .csv, .txt or .npy file
        Times in the scene's unit of time, from its start on, and values, each shape (n,); or an xarray.DataArray over
        time. A file has times in its first column; a text names its columns in its first line, those of an array in a
        .npy are called c1, c2, ... unless its fields have names. For several scenes a mapping of label to such records.
    parameters : mapping of name to (low, high)
        The unknowns with their bounds: values of the scene, states (their start values), and ``record.offset`` and
        ``record.scale`` of a sensor that shows ``scale * expression + offset``. With several scenes a name holds for
        all of them, ``label.name`` for one.
    observed : mapping of record to Expr, optional
        What a record measures; the state of its name unless given.
    sigma : float, array or mapping of record to these, optional
        Standard deviations of the noise; the weights are their inverse squares. Estimated from the residuals unless
        given, for every record its own.
    starts : int
        How many starts; the scene's own values are the first if they lie between the bounds, the others are the best
        ones of 32 times as many Sobol points, by the whole record and by its first part in turn.
    segments : int
        Pieces of time into which the records are cut for multiple shooting: every piece runs from a start of its own
        that is fitted too, and the pieces have to join. For long records, in which the cost of one run has many
        minima, and for chaotic ones, which one run cannot follow; a few swings a piece.
    seed : int
        Of the Sobol points.
    tolerance : float
        Of the runs.
    threads : int
        For the runs without derivatives.
    loss : str
        How residuals count: "linear" by their squares; "soft_l1", "huber" or "cauchy" (as in
        `scipy.optimize.least_squares`) less than that from about one, 1.3 or 2.4 standard deviations on, for records
        with outliers. Noise that is not given is estimated from the median of the residuals.

    Returns
    -------
    Fit

    Raises
    ------
    SceneError
        If an argument or a record is bad; one line that names it and the cure.
    NotFound
        If no run between the bounds reaches the end of the records.

    Notes
    -----
    Gauss-Newton steps in a trust region with bounds (`scipy.optimize.least_squares`), on derivatives that hold through
    stick and slip: variational equations with saltation (Leine and Nijmeijer 2004, section 7.5). Where a run has none,
    because it grazes or two events coincide, they are differences. The cost has an edge or a jump where the sequence of
    events changes; points behind such places are tried before a minimum is accepted. Unknowns between positive bounds
    of a ratio of 100 or more are searched by their logarithm. ``covariance = s^2 (J' J)^-1``, with s^2 = 1 for given
    noise; Seber and Wild, Nonlinear Regression (1989), section 5.1. With another `loss` it is that of
    `symfric.identification.loss.sandwich`. With `segments` see `symfric.identification.shooting.join`.

    Examples
    --------
    >>> import numpy as np
    >>> import symfric as sf
    >>> scene = sf.scenes.coulomb_oscillator(0.03, delta_s=0.05)
    >>> t = np.linspace(0.1, 40.0, 200)
    >>> y = sf.simulate(scene)(t)[0] + 0.01 * np.random.default_rng(0).standard_normal(t.size)
    >>> fit = sf.identify(scene, {"x": (t, y)}, {"delta": (0.001, 0.05), "omega_n": (0.8, 1.3)}, starts=4)
    >>> abs(fit.values["delta"] - 0.03) < 3 * fit.standard_errors["delta"]
    True
    """
    scenes = _scenes(scene)
    channels = read_channels(scenes, records, observed, sigma)
    whole(seed, "seed", 0)
    unknowns = read_unknowns(parameters, scenes, channels)
    if isinstance(starts, bool) or not isinstance(starts, int | np.integer) or starts < 1:
        raise SceneError(f"starts is {shortened(starts)}; give how many starts the fit makes, at least 1")
    if isinstance(segments, bool) or not isinstance(segments, int | np.integer) or segments < 1:
        raise SceneError(
            f"segments is {shortened(segments)}; give into how many pieces the records are cut, at least 1"
        )
    if (counted := read_loss(loss)).is_robust and segments > 1:
        raise SceneError(f"loss is {loss!r}, which is for fits of one piece; leave out segments, or take loss='linear'")
    samples = sum(c.y.size for c in channels)
    if samples < unknowns.size:
        raise SceneError(
            f"{samples} samples cannot fix {unknowns.size} unknowns; give longer records or fewer unknowns"
        )
    predictor = Predictor(scenes, channels, unknowns, check_tolerance(tolerance), workers_of(threads))
    y = np.concatenate([c.y for c in channels])
    known = channels[0].sigma is not None
    weight = np.concatenate([1 / c.sigma if c.sigma is not None else _first_weight(c.y, channels) for c in channels])
    problem = Problem(predictor, y, weight, loss=counted)
    trials = _check_units(problem)
    if counted.is_robust and not known:
        problem = _first_scaled(problem, trials)
    tell("choosing the starts")
    begins = chosen_starts(problem, int(starts), seed, _own_values(scenes, unknowns))
    if segments > 1:
        return joined_fit(problem, begins, int(segments), known)
    minima = best_of(problem, begins)
    if not minima or not np.isfinite(minima[0].cost):
        raise NotFound(
            "no run between the bounds reaches the end of the records; simulate the scene with values between them to "
            "see why, and narrow the bounds"
        )
    tell("points beside the best minimum")
    best = polished(problem, stepped_over(problem, minima[0], seed))
    if not known and (len(channels) > 1 or counted.is_robust):
        problem, best = _reweighted(problem, best, seed)
    return made_fit(problem, best, minima, known)


def _scenes(scene: Any) -> dict[str, Scene]:
    scenes = {"": scene} if isinstance(scene, Scene) else scene
    if not isinstance(scenes, Mapping) or not scenes or not all(isinstance(s, Scene) for s in scenes.values()):
        raise SceneError(f"{shortened(scene)} is neither a sf.Scene nor a mapping of labels to scenes")
    if any(not isinstance(n, str) or ("" == n and not isinstance(scene, Scene)) for n in scenes):
        raise SceneError("the labels of the scenes must be strings that are not empty")
    return dict(scenes)


def _first_weight(y: np.ndarray, channels: tuple[Any, ...]) -> np.ndarray:
    """Return weights for unknown noise: 1 for a single record, else such that all records count alike."""
    return np.full(y.size, 1.0 if len(channels) == 1 else 1 / np.std(y))


def _own_values(scenes: Mapping[str, Scene], unknowns: Unknowns) -> np.ndarray | None:
    """Return the scenes' own values of the unknowns, None if one is missing or outside its bounds."""
    values: list[float | None] = []
    for targets in unknowns.targets:
        target = targets[0]
        if target.kind in (OFFSET, SCALE):
            values.append(float(target.kind == SCALE))
            continue
        scene = scenes[target.label]
        if None in scene.values.values() and (
            target.kind == START or scene.values[scene.parameter(target.name)] is None
        ):
            return None
        numbers = scene.numbers() if target.kind == START else scene.values
        values.append(next(v for s, v in numbers.items() if s.name == target.name))
    row = np.array(values, dtype=float)
    return row if np.all((row >= unknowns.low) & (row <= unknowns.high)) else None


def _check_units(problem: Problem) -> np.ndarray:
    """Raise on a record that is far larger or smaller than what the scene does anywhere between the bounds.

    Returns
    -------
    ndarray, shape (n, TRIALS)
        The predictions that were compared.
    """
    predictor, unknowns = problem.predictor, problem.predictor.unknowns
    scaled = {target.label for targets in unknowns.targets for target in targets if target.kind == SCALE}
    from scipy.stats import qmc  # slow to import

    samples = predictor.many(unknowns.outer(qmc.Sobol(unknowns.size, seed=0).random(TRIALS)))
    for channel, rows in zip(predictor.channels, predictor.rows, strict=True):
        if channel.key in scaled:
            continue
        ranges = np.ptp(samples[rows], axis=0)
        ranges = ranges[np.isfinite(ranges)]
        if not ranges.size:
            continue
        own, most, least = float(np.ptp(channel.y)), float(np.max(ranges)), float(np.min(ranges))
        if own > UNLIKE * most or own * UNLIKE < least:
            raise SceneError(
                f"record {channel.key} varies by {own:.3g}, the scene between the bounds by {least:.3g} to {most:.3g}; "
                f"convert the record to the scene's unit, or fit {channel.key}.scale"
            )
    return samples


def _first_scaled(problem: Problem, predictions: np.ndarray) -> Problem:
    """Return the problem with the noise of the best in the median of many predictions, shape (n, any)."""
    with np.errstate(invalid="ignore"):
        medians = np.median(np.abs(problem.weight[:, None] * (predictions - problem.y[:, None])), axis=0)
    if not np.any(np.isfinite(medians)):
        return problem
    return replace(problem, weight=_new_weights(problem, predictions[:, np.nanargmin(medians)]))


def _reweighted(problem: Problem, best: Minimum, seed: int) -> tuple[Problem, Minimum]:
    """Fit records with the noise of each estimated from its residuals, until both agree.

    The likelihood of records with unknown variances is largest where each record's variance is its mean square. With a
    robust loss it is the median that says how large the noise is.
    """
    for _ in range(REWEIGHTED):
        y = problem.predictor.at(best.values).y
        weight = _new_weights(problem, y)
        unchanged = np.max(np.abs(weight / problem.weight - 1)) < SAME
        problem = replace(problem, weight=weight)
        best = polished(problem, best._replace(cost=float(problem.loss.cost(weight * (y - problem.y)))))
        if unchanged:
            break
        if problem.loss.is_robust:  # the first estimate of the noise may hide a lower minimum
            best = polished(problem, stepped_over(problem, best, seed))
    return problem, best


def _new_weights(problem: Problem, predicted: np.ndarray) -> np.ndarray:
    """Return one over the standard deviation of each record's residuals."""
    predictor, rest = problem.predictor, predicted - problem.y
    share = predictor.unknowns.size / predictor.size
    spreads = [_spread(problem.loss, rest[r], share, c.y) for c, r in _rows(predictor)]
    return np.concatenate([np.full(c.y.size, 1 / s) for (c, _), s in zip(_rows(predictor), spreads, strict=True)])


def _rows(predictor: PredictionModel) -> Any:
    return zip(predictor.channels, predictor.rows, strict=True)


def _spread(loss: Loss, rest: np.ndarray, share: float, y: np.ndarray) -> float:
    """Return the standard deviation of residuals, of exact ones no less than rounding."""
    spread = median_scale(rest) if loss.is_robust else float(np.sqrt(np.mean(rest**2)))
    return max(spread / float(np.sqrt(max(1 - share, 0.1))), 1e-12 * float(np.max(np.abs(y))))
