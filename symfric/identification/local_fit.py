"""Least squares from one start, and steps over the edges at which the cost is not smooth."""

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from typing import NamedTuple

import numpy as np
from scipy.optimize import least_squares

from symfric.identification.loss import LINEAR, Loss
from symfric.identification.prediction import Prediction, PredictionModel

LOOSE, TIGHT = 1e-9, 1e-15  # relative changes of cost, values and gradient at which a fit ends
EVALUATIONS = 60  # most of them from one start
NEWTON, SETTLED = 12, 1e-13  # final Gauss-Newton steps, and the step (in units of the range) that ends them
AT_BOUND = 1e-7  # distance from a bound, in units of the range, at which an unknown counts as being on it
BETTER = 1e-6  # relative decrease of the cost that counts as another minimum
REACHES = (0.3, 1.0, 3.0, 10.0, 30.0)  # how far points beyond a minimum are tried, in standard errors
NEAR = 0.02  # the largest such distance, in units of the range
ROUNDS = 3  # most descents from points beyond a minimum
INSIDE = 1e-9  # distance from a bound, in units of the range, at which a descent begins
UNDETERMINED = 1e-10  # singular value, relative to the largest, of a direction that the data do not determine
WORSE = 1e-12, 1e-9  # relative rise of the cost by rounding: of one step, and of all final steps together
MOST = 4_000_000  # numbers that one batch of predictions holds


@dataclass(frozen=True, eq=False)
class Problem:
    """A weighted least-squares problem.

    Attributes
    ----------
    predictor : PredictionModel
    y : ndarray, shape (n,)
        Measured values.
    weight : ndarray, shape (n,)
        One over the standard deviations; zero for samples that are left out.
    fixed : dict of int to float
        Unknowns that are held, by index.
    loss : Loss
        Of the weighted residuals; the sum of squares unless given.
    """

    predictor: PredictionModel
    y: np.ndarray
    weight: np.ndarray
    fixed: dict[int, float] = field(default_factory=dict)
    loss: Loss = LINEAR

    @property
    def free(self) -> np.ndarray:
        """Indices of the unknowns that are not held."""
        return np.array([k for k in range(self.predictor.unknowns.size) if k not in self.fixed], dtype=int)

    def values(self, inner: np.ndarray) -> np.ndarray:
        """Return all values from the coordinates of the free ones."""
        unknowns = self.predictor.unknowns
        whole = np.zeros(unknowns.size)
        whole[self.free] = inner
        values = unknowns.outer(whole)
        for k, value in self.fixed.items():
            values[k] = value
        return values

    def costs(self, values: np.ndarray) -> np.ndarray:
        """Return half the sums of squares or of the loss at values (n, n_p), shape (n,); infinite for a failed run."""
        return costs_of([self], values)[0]

    @property
    def rounding(self) -> float:
        """Cost of residuals as large as rounding, below which differences mean nothing."""
        return 0.5e-24 * float(np.sum((self.weight * self.y) ** 2))  # half the squares of 1e-12 of each value

    def prefix(self, part: float) -> "Problem":
        """Return the problem of the samples of the first part of the time."""
        weight = self.weight.copy()
        for channel, rows in zip(self.predictor.channels, self.predictor.rows, strict=True):
            late = channel.t > channel.t[0] + part * (channel.t[-1] - channel.t[0])
            weight[rows] = np.where(late, 0.0, weight[rows])
        return replace(self, weight=weight)


def costs_of(problems: Sequence[Problem], values: np.ndarray) -> list[np.ndarray]:
    """Return the costs of problems that differ in their weights only, from one prediction; see `Problem.costs`."""
    first = problems[0]
    count = max(1, MOST // first.predictor.size)
    parts: list[list[np.ndarray]] = [[] for _ in problems]
    for begin in range(0, len(values), count):
        rest = first.predictor.many(values[begin : begin + count]) - first.y[:, None]
        for problem, own in zip(problems, parts, strict=True):
            kept = problem.weight > 0
            with np.errstate(over="ignore", invalid="ignore"):
                cost = problem.loss.cost(problem.weight[kept, None] * rest[kept])
            own.append(np.where(np.isfinite(cost), cost, np.inf))
    return [np.concatenate(own) for own in parts]


class Minimum(NamedTuple):
    """Where a local fit ended.

    Attributes
    ----------
    values : ndarray, shape (n_p,)
    cost : float
        Half the sum of squares; infinite if no run succeeded.
    evaluations : int
    changes : int
        How often the sequence of events differed from one evaluation to the next.
    """

    values: np.ndarray
    cost: float
    evaluations: int
    changes: int


class Evaluator:
    """Residuals and Jacobian of a problem in the coordinates of its free unknowns, evaluated together."""

    def __init__(self, problem: Problem):
        self.problem, self.kept = problem, problem.weight > 0
        self.evaluations = self.changes = 0
        self._at: np.ndarray | None = None
        self._last: Prediction | None = None

    def prediction(self, inner: np.ndarray) -> Prediction:
        """Return the prediction at a point; that of the last one is kept."""
        if self._last is None or self._at is None or not np.array_equal(inner, self._at):
            before = self._last
            self._at = np.array(inner)
            self._last = self.problem.predictor.at(self.problem.values(inner))
            self.evaluations += 1
            self.changes += before is not None and before.sequence != self._last.sequence
        return self._last

    def residuals(self, inner: np.ndarray) -> np.ndarray:
        """Return predicted minus measured values, weighted."""
        kept = self.kept
        return np.asarray(self.problem.weight[kept] * (self.prediction(inner).y[kept] - self.problem.y[kept]))

    def jacobian(self, inner: np.ndarray) -> np.ndarray:
        """Return the derivatives of the residuals by the coordinates; zero where none could be made."""
        prediction, free = self.prediction(inner), self.problem.free
        stretch = self.problem.predictor.unknowns.stretch(self.problem.values(inner))[free]
        slopes = self.problem.weight[self.kept, None] * prediction.slopes[self.kept][:, free] * stretch
        return np.where(np.isfinite(slopes), slopes, 0.0)

    def cost(self, inner: np.ndarray) -> float:
        """Return half the sum of squares, or of the loss, infinite if a run failed."""
        with np.errstate(over="ignore", invalid="ignore"):
            total = float(self.problem.loss.cost(self.residuals(inner)))
        return total if np.isfinite(total) else np.inf


def minimise(problem: Problem, start: np.ndarray, tolerance: float = LOOSE, most: int = EVALUATIONS) -> Minimum:
    """Minimise from one start by `scipy.optimize.least_squares` with bounds.

    Parameters
    ----------
    problem : Problem
    start : ndarray, shape (n_p,)
        Values.
    tolerance : float
    most : int
        Evaluations.
    """
    free = problem.free
    evaluate = Evaluator(problem)
    # off the bounds, at which the scaled steps of SciPy's reflective method would vanish (Branch, Coleman and Li,
    # SIAM J. Sci. Comput. 21 (1999) 1)
    inner = np.clip(problem.predictor.unknowns.inner(start)[free], INSIDE, 1 - INSIDE)
    if not free.size:
        return Minimum(problem.values(inner), evaluate.cost(inner), 1, 0)
    if not np.isfinite(evaluate.cost(inner)):
        return Minimum(problem.values(inner), np.inf, evaluate.evaluations, 0)
    solution = least_squares(
        evaluate.residuals,
        inner,
        evaluate.jacobian,
        (0.0, 1.0),
        ftol=tolerance,
        xtol=tolerance,
        gtol=tolerance,
        x_scale="jac",
        max_nfev=most,
        loss=problem.loss.name,
        f_scale=problem.loss.scale,
    )
    return Minimum(problem.values(solution.x), float(solution.cost), evaluate.evaluations, evaluate.changes)


def polished(problem: Problem, at: Minimum) -> Minimum:
    """Return the minimum after tight steps of Gauss and Newton; unknowns at a bound are put onto it and held."""
    at = _best(at, minimise(problem, at.values, TIGHT))
    unknowns = problem.predictor.unknowns
    inner = unknowns.inner(at.values)
    evaluate = Evaluator(problem)
    gradient = np.zeros(unknowns.size)
    gradient[problem.free] = _gradient(evaluate, inner[problem.free])
    for k in problem.free:
        low, high = inner[k] < AT_BOUND and gradient[k] > 0, inner[k] > 1 - AT_BOUND and gradient[k] < 0
        if low or high:
            problem = replace(
                problem, fixed={**problem.fixed, int(k): float((unknowns.high if high else unknowns.low)[k])}
            )
    free = problem.free
    evaluate = Evaluator(problem)
    inner, cost = unknowns.inner(at.values)[free], evaluate.cost(unknowns.inner(at.values)[free])
    for _ in range(NEWTON if free.size else 0):
        rest = evaluate.residuals(inner)
        root = problem.loss.root(rest)
        # directions that the data do not determine are left alone
        step = np.linalg.lstsq(root[:, None] * evaluate.jacobian(inner), -root * rest, rcond=UNDETERMINED)[0]
        trial = np.clip(inner + step, 0.0, 1.0)
        reached = evaluate.cost(trial)
        if not reached <= cost * (1 + WORSE[0]):
            break
        inner, cost = trial, reached
        if np.max(np.abs(step)) < SETTLED:
            break
    moved = Minimum(problem.values(inner), cost, at.evaluations + evaluate.evaluations, at.changes)
    return moved if cost <= at.cost * (1 + WORSE[1]) else at


def _gradient(evaluate: Evaluator, inner: np.ndarray) -> np.ndarray:
    return np.asarray(evaluate.jacobian(inner).T @ evaluate.problem.loss.slope(evaluate.residuals(inner)))


def _best(first: Minimum, second: Minimum) -> Minimum:
    kept = second if second.cost <= first.cost else first
    return Minimum(kept.values, kept.cost, first.evaluations + second.evaluations, first.changes + second.changes)


def stepped_over(problem: Problem, at: Minimum, seed: int) -> Minimum:
    """Return the best minimum found from points around one.

    Where the sequence of events changes, the cost has an edge or a jump, at which a descent ends although lower values
    lie behind it. Points along the principal axes of the Jacobian and scattered around the minimum are tried, all in
    one batch, and a better one starts another descent.
    """
    free = problem.free
    for turn in range(ROUNDS if free.size else 0):
        unknowns = problem.predictor.unknowns
        inner = unknowns.inner(at.values)[free]
        points = np.clip(_around(Evaluator(problem), inner, seed + turn), 0.0, 1.0)
        values = np.array([problem.values(p) for p in points])
        costs = problem.costs(values)
        k = int(np.argmin(costs))
        if not costs[k] < at.cost * (1 - BETTER) - problem.rounding:
            return at
        stepped = minimise(problem, values[k])
        at = _best(
            at, stepped if stepped.cost < costs[k] else Minimum(values[k], float(costs[k]), stepped.evaluations, 0)
        )
    return at


def _around(evaluate: Evaluator, inner: np.ndarray, seed: int) -> np.ndarray:
    """Return points around one: on the principal axes of the Jacobian, and scattered."""
    jacobian = evaluate.jacobian(inner)
    noise = np.sqrt(2 * evaluate.cost(inner) / max(1, len(jacobian)))  # root mean square of the residuals
    _, sizes, axes = np.linalg.svd(jacobian, full_matrices=False)
    # standard errors along the axes of the confidence ellipsoid
    error = np.minimum(noise / np.maximum(sizes, 1e-12), NEAR)
    points = [
        inner + way * np.minimum(reach * e, NEAR) * axis
        for e, axis in zip(error, axes, strict=True)
        for reach in REACHES
        for way in (1.0, -1.0)
    ]
    cloud = np.random.default_rng(seed).random((16, inner.size)) - 0.5
    return np.concatenate([np.array(points), inner + 2 * NEAR * cloud, inner + 20 * NEAR * cloud])
