"""Damping and friction of an isolated mass for a set of ground motions."""

import itertools
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
from scipy.optimize import linprog

from symfric.design.polish import polished, ways
from symfric.design.result import Curve, Design
from symfric.design.verification import Neighbour, design
from symfric.errors import NotFound, SceneError
from symfric.model.names import Key, finite, name_of, nearest
from symfric.model.outputs import ScalarOfExpression
from symfric.model.scene import Scene
from symfric.model.system import Signal
from symfric.solve.choose import prepare

MEASURES = {
    "acceleration": "peak_acceleration",
    "velocity": "peak_velocity",
    "displacement": "peak_displacement",
    "residual": "residual",
}
_GRID = 900  # points of the grid over the bounds
_STARTS = 8  # best points of it that none beside them beats: where searches start
_AGAIN, _SEED = 32, 23  # further starts around the best point found
_TURNS, _REACH = 5, 3e-3  # of linear programs and polls; the first distance of a poll, a part of the bounds
_STEP = 1e-6  # of differences, where no derivative exists
_ROUNDS, _TRUST, _LEAST = 40, 0.1, 1e-9  # of the refinement: steps, its first reach and its last, parts of the bounds
_NEAR = 0.1  # of the largest value: motions so near to it may be the worst after a step
_AROUND = (1e-5, 1e-3, 1e-2)  # of the bounds: distances of the designs beside an optimum
_ACTIVE = 1e-6  # of a limit
_SAME = 1e-6  # of a measure: difference of two routes
_MET = 1e-9  # of a limit, by which it may be exceeded


@dataclass(frozen=True)
class Check:
    """What the optimum does under every motion, by another route.

    Attributes
    ----------
    values : dict of str to tuple of float
        Every measure for every motion.
    worst : dict of str to float
    difference : float
        Largest difference from the route that was optimised on, relative to the worst value of its kind.
    limits : dict of str to float
    """

    values: dict[str, tuple[float, ...]]
    worst: dict[str, float]
    difference: float
    limits: dict[str, float]

    @property
    def agrees(self) -> bool:
        """Whether both routes say the same, and the limits hold."""
        return not self.disagreements

    @property
    def disagreements(self) -> tuple[str, ...]:
        """What does not, in words."""
        wrong = [f"the routes differ by {self.difference:.1g}"] if not self.difference < _SAME else []
        exceeded = ((n, limit) for n, limit in self.limits.items() if not self.worst[n] <= limit * (1 + _SAME))
        return (*wrong, *(f"{n} {self.worst[n]:.9g} exceeds its limit {limit:g}" for n, limit in exceeded))

    def to_dict(self) -> dict[str, object]:
        """Return plain Python data."""
        return {"agrees": self.agrees, "worst": self.worst, "difference": self.difference, "values": self.values}

    def __str__(self) -> str:
        worst = ", ".join(f"{name} {value:.6g}" for name, value in self.worst.items())
        return f"worst over {len(next(iter(self.values.values())))} motions: {worst} (difference {self.difference:.1g})"


def isolator(
    scene: Scene,
    motions: Sequence,
    bounds: Mapping[Key, tuple[float, float]],
    limits: Mapping[str, float] | None = None,
    minimise: str = "acceleration",
    *,
    over: str = "worst",
) -> Design:
    """Choose damping and friction of an isolator for a set of motions of the ground.

    Parameters
    ----------
    scene : Scene
        With one sampled input and the outputs of `symfric.scenes.rolling_isolator`, or others of the same names.
    motions : sequence of Motion or Signal
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
    """
    problem = _Problem(scene, motions, bounds, dict(limits or {}), minimise, over)
    points = problem.grid()
    table = [problem.values(p) for p in points]
    costs = np.array([problem.cost(v) for v in table])
    excess = np.array([problem.excess(v) for v in table])
    starts = _starts(problem, costs, np.maximum(excess, 0.0))
    best = min((_refined(problem, points[k]) for k in starts), key=lambda p: _merit(problem, p))
    others = (_refined(problem, p) for p in _scattered(best, 1.0 / (problem.per_axis - 1)))
    best = _improved(problem, min([best, *others], key=lambda p: _merit(problem, p)))
    values = problem.values(best)
    if problem.excess(values) > _MET:
        raise NotFound(problem.missing(best, values))
    return _design(problem, best, values, table)


class _Problem:
    """The isolator as functions of a point in the unit cube of the bounds."""

    def __init__(self, scene: Scene, motions: Sequence, bounds, limits: dict[str, float], minimise: str, over: str):
        for name in (minimise, *limits):
            if name not in MEASURES:
                raise SceneError(f"no measure {name!r}{nearest(str(name), MEASURES)}")
        if over not in ("worst", "mean"):
            raise SceneError(f"over is {over!r}; give 'worst' or 'mean'")
        self.limits = {name: finite(v, f"the limit of {name}") for name, v in limits.items()}
        if any(v <= 0 for v in self.limits.values()):
            raise SceneError("limits must be positive")
        self.minimise, self.over = minimise, over
        self.names, self.low, self.high = _bounds(scene, bounds)
        self.measures = tuple(dict.fromkeys((minimise, *limits, "acceleration", "displacement")))
        self.scenes = _shaken(scene, motions, [MEASURES[name] for name in self.measures])
        self._programs = [prepare(s, 1e-10) for s in self.scenes]
        self._sensitive = [None] * len(self.scenes)
        self._known: dict[bytes, np.ndarray] = {}

    @property
    def per_axis(self) -> int:
        """Number of points of the grid along each parameter."""
        return max(2, round(_GRID ** (1 / len(self.names))))

    def grid(self) -> list[np.ndarray]:
        """Return points that fill the unit cube."""
        return [np.array(p) for p in itertools.product(np.linspace(0, 1, self.per_axis), repeat=len(self.names))]

    def parameters(self, point: np.ndarray) -> dict[str, float]:
        """Return the parameters at a point."""
        numbers = self.low + np.clip(point, 0, 1) * (self.high - self.low)
        return dict(zip(self.names, numbers.tolist(), strict=True))

    def values(self, point: np.ndarray) -> np.ndarray:
        """Return the magnitude of every measure for every motion, shape (n_measures, n_motions)."""
        key = point.tobytes()
        if key not in self._known:
            rows = []
            for program in self._programs:
                run = program.run(self.parameters(point))
                rows.append([abs(run[MEASURES[m]]) if run.status == 0 else np.inf for m in self.measures])
            self._known[key] = np.array(rows).T
        return self._known[key]

    def slopes(self, point: np.ndarray, motion: int) -> np.ndarray:
        """Return the derivatives of the measures for one motion in the unit cube, shape (n_measures, n_parameters)."""
        if self._sensitive[motion] is None:
            self._sensitive[motion] = prepare(self.scenes[motion], 1e-10, sensitivities=self.names)
        run = self._sensitive[motion].run(self.parameters(point))
        rows = []
        for measure in self.measures:
            name = MEASURES[measure]
            sign = 1.0 if run[name] >= 0 else -1.0
            rows.append([sign * run.output_sensitivities[name][n] for n in self.names])
        found = np.array(rows) * (self.high - self.low)
        for k in np.flatnonzero(~np.all(np.isfinite(found), axis=0)):  # no derivative exists after a graze
            low, high = (np.clip(point + side * _STEP * np.eye(point.size)[k], 0.0, 1.0) for side in (-1, 1))
            found[:, k] = (self.values(high) - self.values(low))[:, motion] / (high - low)[k]
        return found

    def cost(self, values: np.ndarray) -> float:
        """Return what is minimised."""
        row = values[self.measures.index(self.minimise)]
        return float(np.max(row) if self.over == "worst" else np.mean(row))

    def excess(self, values: np.ndarray) -> float:
        """Return by how much the limits are exceeded at the most, relative to each."""
        return max(
            (float(np.max(values[self.measures.index(n)]) / limit - 1.0) for n, limit in self.limits.items()),
            default=-1.0,
        )

    def missing(self, point: np.ndarray, values: np.ndarray) -> str:
        """Return which limit cannot be met and by how much."""
        name = max(self.limits, key=lambda n: np.max(values[self.measures.index(n)]) / self.limits[n])
        reached = float(np.max(values[self.measures.index(name)]))
        where = ", ".join(f"{k} = {v:.6g}" for k, v in self.parameters(point).items())
        return (
            f"the limit on {name}, {self.limits[name]:g}, cannot be met within the bounds: the least found is "
            f"{reached:.6g}, {reached - self.limits[name]:.3g} too much, at {where}"
        )


def _bounds(scene: Scene, bounds) -> tuple[tuple[str, ...], np.ndarray, np.ndarray]:
    if not isinstance(bounds, Mapping) or not 1 <= len(bounds) <= 3:
        raise SceneError("give the bounds of one to three parameters, such as {'C': (lo, hi), 'mu': (lo, hi)}")
    names = tuple(scene.parameter(name_of(key)).name for key in bounds)
    ends = []
    for name, pair in zip(names, bounds.values(), strict=True):
        try:
            low, high = (finite(e, f"a bound of {name}") for e in pair)
        except (TypeError, ValueError):
            raise SceneError(f"the bounds of {name} are {pair!r}; give the lowest and the highest") from None
        if not 0 <= low < high:
            raise SceneError(f"the bounds of {name} are ({low:g}, {high:g}); give 0 <= low < high")
        ends.append((low, high))
    return names, *np.array(ends).T


def _shaken(scene: Scene, motions: Sequence, outputs: list[str]) -> list[Scene]:
    """Return the scene under every motion, wanting the outputs."""
    if len(scene.inputs) != 1:
        raise SceneError(f"the scene has {len(scene.inputs)} sampled inputs; an isolator has one, the ground's motion")
    for name in outputs:
        if not isinstance(scene.outputs.get(name), ScalarOfExpression):
            raise SceneError(f"the scene has no output {name}; sf.scenes.rolling_isolator has it")
    if not len(motions):
        raise SceneError("no motions; give at least one sf.motions.Motion or sf.Signal")
    wanted = scene.wanting({name: scene.outputs[name] for name in outputs})
    (symbol, before), found = next(iter(scene.inputs.items())), []
    for motion in motions:
        signal = motion if isinstance(motion, Signal) else getattr(motion, "signal", lambda: None)()
        if not isinstance(signal, Signal):
            raise SceneError(f"{motion!r} is no motion; give what sf.motions reads, or a sf.Signal")
        horizon = signal.t_end + (scene.horizon - before.t_end)
        found.append(replace(wanted, inputs={symbol: signal}, horizon=horizon))
    return found


def _starts(problem: _Problem, costs: np.ndarray, excess: np.ndarray) -> list[int]:
    """Return the best points of the grid that none beside them beats."""
    count = problem.per_axis
    rank = np.empty(costs.size)
    rank[np.lexsort((costs, excess))] = np.arange(costs.size)
    table = np.pad(rank.reshape((count,) * len(problem.names)), 1, constant_values=np.inf)
    inner = tuple(slice(1, -1) for _ in problem.names)
    lowest = np.ones_like(table[inner], dtype=bool)
    for way in ways(len(problem.names)).astype(int):
        beside = tuple(slice(1 + w, table.shape[0] - 1 + w) for w in way)
        lowest &= table[inner] < table[beside]
    found = np.flatnonzero(lowest.ravel())
    return [int(k) for k in found[np.argsort(rank[found])][:_STARTS]]


def _scattered(point: np.ndarray, cell: float) -> np.ndarray:
    """Return points within a cell of the grid around one: a limit and a peak may meet twice in it."""
    from scipy.stats import qmc

    drawn = qmc.Sobol(point.size, seed=_SEED).random(_AGAIN)
    return np.clip(point + cell * (2.0 * drawn - 1.0), 0.0, 1.0)


def _improved(problem: _Problem, point: np.ndarray) -> np.ndarray:
    """Return a local optimum near a point: linear programs and polls in turn, until neither finds a better one."""
    for _ in range(_TURNS):
        refined = _refined(problem, point)
        point = polished(lambda p: _merit(problem, p), refined, _REACH, _LEAST)
        if np.max(np.abs(point - refined)) < 10 * _LEAST:
            break
    return point


def _refined(problem: _Problem, point: np.ndarray) -> np.ndarray:
    """Return a local optimum near a point, by linear programs in a trust region that shrinks where they mislead."""
    reach, merit = _TRUST, _merit(problem, point)
    for _ in range(_ROUNDS):
        step = _linear_step(problem, point, reach)
        then = np.clip(point + step, 0.0, 1.0)
        better = _merit(problem, then)
        if better < merit:
            point, merit, reach = then, better, min(2.0 * reach, _TRUST)
        else:
            reach *= 0.3
        if reach < _LEAST or np.max(np.abs(step)) < _LEAST:
            break
    return point


def _merit(problem: _Problem, point: np.ndarray) -> tuple[float, float]:
    """Return what is compared: the excess over the limits first, then the cost."""
    values = problem.values(point)
    return max(problem.excess(values) - 0.1 * _MET, 0.0), problem.cost(values)


def _linear_step(problem: _Problem, point: np.ndarray, reach: float) -> np.ndarray:
    """Return the step that is best if everything were linear: unknowns are the step, the cost, and the excess."""
    values, n = problem.values(point), point.size
    target = problem.measures.index(problem.minimise)
    size = max(problem.cost(values), 1e-300)
    slopes: dict[int, np.ndarray] = {}

    def slope(motion: int) -> np.ndarray:
        if motion not in slopes:
            slopes[motion] = problem.slopes(point, motion)
        return slopes[motion]

    rows, rest, mean = [], [], np.zeros(n)
    if problem.over == "mean":
        mean = np.mean([slope(k)[target] for k in range(values.shape[1])], axis=0) / size
    else:
        for k in np.flatnonzero(values[target] >= (1 - _NEAR) * np.max(values[target])):
            rows.append([*slope(int(k))[target] / size, -1.0, 0.0])
            rest.append(-values[target, k] / size)
    for name, limit in problem.limits.items():
        m = problem.measures.index(name)
        for k in np.flatnonzero(values[m] >= (1 - _NEAR) * min(limit, np.max(values[m]))):
            rows.append([*slope(int(k))[m] / limit, 0.0, -1.0])
            rest.append(1.0 - values[m, k] / limit)
    cost = [*mean, 0.0 if problem.over == "mean" else 1.0, 1e3]
    sides = [(max(-reach, -p), min(reach, 1.0 - p)) for p in point]
    found = linprog(cost, np.array(rows) if rows else None, rest or None, bounds=[*sides, (None, None), (0.0, None)])
    return found.x[:n] if found.status == 0 else np.zeros(n)


def _design(problem: _Problem, point: np.ndarray, values: np.ndarray, table: list[np.ndarray]) -> Design:
    parameters = problem.parameters(point)
    worst = {m: float(np.max(row)) for m, row in zip(problem.measures, values, strict=True)}
    active = [f"{n} limit" for n, limit in problem.limits.items() if worst[n] >= limit * (1 - _ACTIVE)]
    for name, p in zip(problem.names, point, strict=True):
        if p <= _LEAST or p >= 1 - _LEAST:
            active.append(f"{name} at its {'lower' if p <= _LEAST else 'upper'} bound")
    if problem.over == "worst":
        row = values[problem.measures.index(problem.minimise)]
        active.append(f"motions {', '.join(str(k) for k in np.flatnonzero(row >= np.max(row) * (1 - _ACTIVE)))}")
    scene = problem.scenes[int(np.argmax(values[problem.measures.index(problem.minimise)]))].where(parameters)
    curve, check = _trade_off(problem, [*table, values], worst), _checked(problem, parameters, values)
    cost = problem.cost(values)
    beside = _beside(problem, point)
    return design(parameters, cost, active, scene, check, curve, claim="optimal", neighbours=beside)


def _beside(problem: _Problem, point: np.ndarray) -> list[Neighbour]:
    """Return the designs around one, in all directions of the axes and diagonals and at several distances."""
    found = []
    for way in ways(point.size):
        for step in _AROUND:
            then = np.clip(point + step * way, 0.0, 1.0)
            if not np.array_equal(then, point):
                values = problem.values(then)
                change = ", ".join(f"{k} = {v:.6g}" for k, v in problem.parameters(then).items())
                found.append(Neighbour(change, problem.cost(values), problem.excess(values) - _MET))
    return found


def _trade_off(problem: _Problem, table: list[np.ndarray], worst: dict[str, float]) -> Curve:
    """Return the lower left edge of all points computed: what is minimised against what it costs."""
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


def _checked(problem: _Problem, parameters: dict[str, float], values: np.ndarray) -> Check:
    found = []
    for scene in problem.scenes:
        run = prepare(scene.where(parameters), 1e-11, route="taylor").run()
        found.append([abs(run[MEASURES[m]]) if run.status == 0 else np.nan for m in problem.measures])
    other = np.array(found).T
    size = np.maximum(np.max(values, axis=1, keepdims=True), 1e-300)
    apart = float(np.max(np.abs(other - values) / size))
    rows = {m: tuple(row.tolist()) for m, row in zip(problem.measures, other, strict=True)}
    return Check(
        rows, {m: max(row) for m, row in rows.items()}, apart if np.isfinite(apart) else np.inf, problem.limits
    )
