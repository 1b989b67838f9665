"""Optimal damping and friction of an isolator for a set of ground motions."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Literal

import numpy as np

from symfric.design.isolator.measures import Isolated
from symfric.design.isolator.minimax import LEAST, MET, least
from symfric.design.polish import ways
from symfric.design.result import Curve, Design
from symfric.design.verification import Interrupted, Neighbour, design
from symfric.errors import NotFound
from symfric.long_calls import logged, tell, until_interrupted
from symfric.model.results import Result
from symfric.model.scene import Scene, check_given_loads, check_scene
from symfric.model.symbols import Key, mapped
from symfric.solve.routes import prepare

_AROUND = (1e-5, 1e-3, 1e-2)  # distances of the neighbouring designs, relative to the bounds
_ACTIVE = 1e-6  # relative distance at which a limit counts as active
_SAME = 1e-6  # largest relative difference of a measure between two routes


@dataclass(frozen=True)
class IsolatorCheck(Result):
    """Verification: the optimum under every motion, computed by another route.

    Attributes
    ----------
    values : dict of str to tuple of float
        Every measure for every motion.
    worst : dict of str to float
    difference : float
        Largest difference from the route of the optimisation, relative to the worst value of its kind.
    limits : dict of str to float
    """

    _told = ("agrees", "worst", "difference", "values")

    values: dict[str, tuple[float, ...]]
    worst: dict[str, float]
    difference: float
    limits: dict[str, float]

    @property
    def agrees(self) -> bool:
        """Whether both routes agree and the limits hold."""
        return not self.disagreements

    @property
    def disagreements(self) -> tuple[str, ...]:
        """Disagreements and exceeded limits, as lines of text."""
        wrong = [f"the routes differ by {self.difference:.1g}"] if not self.difference < _SAME else []
        exceeded = ((n, limit) for n, limit in self.limits.items() if not self.worst[n] <= limit * (1 + _SAME))
        return (*wrong, *(f"{n} {self.worst[n]:.9g} exceeds its limit {limit:g}" for n, limit in exceeded))

    def __str__(self) -> str:
        worst = ", ".join(f"{name} {value:.6g}" for name, value in self.worst.items())
        return f"worst over {len(next(iter(self.values.values())))} motions: {worst} (difference {self.difference:.1g})"


@logged
def isolator(
    scene: Scene,
    motions: Sequence[Any],
    bounds: Mapping[Key, tuple[float, float]],
    limits: Mapping[str, float] | None = None,
    minimise: str = "acceleration",
    *,
    over: Literal["worst", "mean"] = "worst",
) -> Design:
    """Find the optimal damping and friction of an isolator for a set of ground motions.

    Parameters
    ----------
    scene : Scene
        With one sampled input and the outputs of `symfric.scenes.rolling_isolator`, or others of the same names; or
        with two, those of `symfric.scenes.friction_pendulum`.
    motions : sequence of Motion or Signal, or of pairs of these
        One for each input.
    bounds : mapping of parameter to (float, float)
        Of what is chosen, such as ``{"C": (lo, hi), "mu": (lo, hi)}``; one to three parameters.
    limits : mapping of str to float
        Largest magnitudes under any of the motions, by "acceleration", "velocity", "displacement" or "residual".
    minimise : str
        One of these four.
    over : {"worst", "mean"}
        Whether the largest over the motions is minimised or their mean.

    Returns
    -------
    Design
        Its curve is the trade-off: the least that was reached of what is minimised against the displacement that is
        allowed for it (against the acceleration, if the displacement is minimised).

    Raises
    ------
    NotFound
        If no point within the bounds meets the limits: names the one that is missed, and by how much at the point
        that comes nearest.
    SceneError
        If an argument is wrong.

    Notes
    -----
    A grid over the bounds, run through the closed forms between samples, gives the trade-off and several starts. Each
    is refined by linear programs in a trust region (sequential linear programming; Nocedal and Wright, Numerical
    Optimization, section 18.5), with the exact derivatives of the motions that are or may become the worst: peaks and
    residuals are smooth only piece by piece.

    Examples
    --------
    >>> import symfric as sf
    >>> quake = sf.motions.sine_burst(3.0, 1.0, cycles=5)
    >>> building = sf.scenes.rolling_isolator(C=1e5, m=3e5, motion=quake, profile=0.01)
    >>> found = sf.design.isolator(building, [quake], {"C": (1e3, 1e6)}, limits={"displacement": 0.15})
    >>> found.status
    'optimal'
    """
    check_scene(scene)
    check_given_loads(scene, "isolator, whose measure is an acceleration,")
    problem = Isolated(
        scene, motions, bounds, dict(mapped(limits or {}, "limits", "{'residual': 0.01}")), minimise, over
    )
    with until_interrupted("isolator"):
        tell("a survey of the bounds")
        points = problem.grid()
        table = problem.survey(points)
        costs = np.array([problem.cost(v) for v in table])
        excess = np.array([problem.excess(v) for v in table])
        tell("the best points refined")
        best = least(problem, points, costs, np.maximum(excess, 0.0))
        values = problem.values(best)
        if problem.excess(values) > MET:
            raise NotFound(problem.missing(best, values))
        return _design(problem, best, values, table)
    return _interrupted(problem)


def _interrupted(problem: Isolated) -> Design:
    """Return the best design that was computed before an interrupt."""
    computed = problem.computed()
    if not computed:
        raise KeyboardInterrupt
    point, values = computed[0]
    parameters = problem.parameters(point)
    worst = {m: float(np.max(row)) for m, row in zip(problem.measures, values, strict=True)}
    curve = _trade_off(problem, [*(v for _, v in computed), values], worst)
    cost, scene = problem.cost(values), problem.scenes[0].where(parameters)
    return design(parameters, cost, (), scene, Interrupted(), curve, claim="best found", neighbours=())


def _design(problem: Isolated, point: np.ndarray, values: np.ndarray, table: list[np.ndarray]) -> Design:
    tell("verification of the design")
    parameters = problem.parameters(point)
    worst = {m: float(np.max(row)) for m, row in zip(problem.measures, values, strict=True)}
    active = [f"{n} limit" for n, limit in problem.limits.items() if worst[n] >= limit * (1 - _ACTIVE)]
    for name, p in zip(problem.names, point, strict=True):
        if p <= LEAST or p >= 1 - LEAST:
            active.append(f"{name} at its {'lower' if p <= LEAST else 'upper'} bound")
    if problem.over == "worst":
        row = values[problem.measures.index(problem.minimise)]
        active.append(f"motions {', '.join(str(k) for k in np.flatnonzero(row >= np.max(row) * (1 - _ACTIVE)))}")
    scene = problem.scenes[int(np.argmax(values[problem.measures.index(problem.minimise)]))].where(parameters)
    curve, check = _trade_off(problem, [*table, values], worst), _checked(problem, parameters, values)
    cost = problem.cost(values)
    beside = _beside(problem, point)
    return design(parameters, cost, active, scene, check, curve, claim="optimal", neighbours=beside)


def _beside(problem: Isolated, point: np.ndarray) -> list[Neighbour]:
    """Return the neighbours of a design, along axes and diagonals and at several distances."""
    neighbours = []
    for way in ways(point.size):
        for step in _AROUND:
            then = np.clip(point + step * way, 0.0, 1.0)
            if not np.array_equal(then, point):
                values = problem.values(then)
                change = ", ".join(f"{k} = {v:.6g}" for k, v in problem.parameters(then).items())
                neighbours.append(Neighbour(change, problem.cost(values), problem.excess(values) - MET))
    return neighbours


def _trade_off(problem: Isolated, table: list[np.ndarray], worst: dict[str, float]) -> Curve:
    """Return the Pareto front of all computed points: the objective over a conflicting measure."""
    other = "acceleration" if problem.minimise == "displacement" else "displacement"
    price = np.array([np.max(v[problem.measures.index(other)]) for v in table])
    cost = np.array([problem.cost(v) for v in table])
    order = np.lexsort((cost, price))
    best = np.minimum.accumulate(cost[order])
    keep = np.concatenate([[True], np.diff(best) < 0]) & np.isfinite(price[order])
    x, y = price[order][keep], best[keep]
    return Curve(
        x, y, problem.cost(table[-1]), f"peak {other} allowed", f"{problem.over} {problem.minimise}", (worst[other],)
    )


def _checked(problem: Isolated, parameters: dict[str, float], values: np.ndarray) -> IsolatorCheck:
    responses = []
    for scene in problem.scenes:
        run = prepare(scene.where(parameters), 1e-11, route="taylor").run()
        responses.append([problem.size(run, m) if run.status == 0 else np.nan for m in problem.measures])
    other = np.array(responses).T
    size = np.maximum(np.max(values, axis=1, keepdims=True), 1e-300)
    apart = float(np.max(np.abs(other - values) / size))
    rows = {m: tuple(row.tolist()) for m, row in zip(problem.measures, other, strict=True)}
    return IsolatorCheck(
        rows, {m: max(row) for m, row in rows.items()}, apart if np.isfinite(apart) else np.inf, problem.limits
    )
