"""Places near a solution where the sequence of events changes, so that the cost is not smooth there."""

from typing import Any, NamedTuple

import numpy as np

from symfric.identification.local_fit import Minimum, Problem

HALVINGS = 20  # of the distance, which leaves 1e-6 of it
ENDS = 1e-9  # the jump of the cost is taken between points this close, relative to the distance searched


class Crossing(NamedTuple):
    """A place near the solution where the sequence of events changes, so that the cost is not smooth.

    Attributes
    ----------
    values : dict of str to float
        Between these and the solution's the sequence is that of the solution.
    events : (int, int)
        Number of events at the solution, and beyond.
    jump : float
        By how much the cost jumps there, relative to the cost at the solution; near zero for a mere edge.
    """

    values: dict[str, float]
    events: tuple[int, int]
    jump: float


def crossings_near(
    problem: Problem, best: Minimum, jacobian: np.ndarray, variance: float, sequence: tuple[Any, ...]
) -> tuple[Crossing, ...]:
    """Return changes in the sequence of events within one standard error along the axes of the Jacobian.

    Parameters
    ----------
    problem : Problem
    best : Minimum
    jacobian : ndarray, shape (n, n_p)
    variance : float
        Of a weighted residual.
    sequence : tuple
        The events at the solution, scene by scene.
    """
    unknowns = problem.predictor.unknowns
    ranges = unknowns.high - unknowns.low
    _, sizes, axes = np.linalg.svd(jacobian * ranges, full_matrices=False)
    crossings = []
    for size, axis in zip(sizes, axes, strict=True):
        reach = min(0.1, float(np.sqrt(variance)) / size) if size > 0 else 0.1
        for way in (1.0, -1.0):
            far = best.values + way * reach * axis * ranges
            crossing = _between(problem, best, np.clip(far, unknowns.low, unknowns.high), sequence)
            crossings += [] if crossing is None else [crossing]
    return tuple(crossings)


def _between(problem: Problem, best: Minimum, far: np.ndarray, sequence: tuple[Any, ...]) -> Crossing | None:
    """Return the change in the sequence between the solution and a point, located by halving; None if there is none."""
    predictor = problem.predictor

    def same(part: float) -> bool:
        shown = predictor.at(best.values + part * (far - best.values), differences=False)
        return all(_continues(a, b) for a, b in zip(sequence, shown.sequence, strict=True))

    if same(1.0):
        return None
    low, high = 0.0, 1.0
    for _ in range(HALVINGS):
        middle = 0.5 * (low + high)
        low, high = (middle, high) if same(middle) else (low, middle)
    points = best.values + np.array([[low - ENDS], [high + ENDS]]) * (far - best.values)
    costs = problem.costs(points)
    beyond = predictor.at(points[1], differences=False).sequence
    jump = float((costs[1] - costs[0]) / max(best.cost, 1e-300)) if np.all(np.isfinite(costs)) else float("inf")
    values = dict(zip(predictor.unknowns.names, points[0].tolist(), strict=True))
    return Crossing(values, (sum(map(len, sequence)), sum(map(len, beyond))), jump)


def _continues(first: tuple[Any, ...], second: tuple[Any, ...]) -> bool:
    """Whether one sequence begins with the other: an event that moves across the end of a record changes no sample."""
    short = min(len(first), len(second))
    return first[:short] == second[:short] and abs(len(first) - len(second)) <= 2
