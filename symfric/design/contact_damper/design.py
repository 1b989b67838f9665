"""Shortest decay time of a rod braked by a contact: optimal friction, stiffness and damping within bounds.

The rod stops at a turning point, so the decay time jumps wherever a turning point just reaches the stick limit. Between
the jumps it is smooth: the time of the N-th turning point, where the N-th one sticks. Each piece is a smooth problem of
its own, "the time of turning point N, which must lie within the stick limit"; its optimum mostly lies on the jump.
"""

import itertools
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from symfric.design.comparison import Compared, Comparison
from symfric.design.polish import polished
from symfric.design.result import Curve, Design
from symfric.design.verification import BEST_FOUND, Interrupted, Neighbour, design
from symfric.errors import NotFound, SceneError
from symfric.long_calls import logged, tell, until_interrupted
from symfric.model import scenes
from symfric.model.arguments import is_one_of
from symfric.model.outputs import StopTime, Trajectory
from symfric.model.scene import Scene
from symfric.model.symbols import Key, finite, mapped, name_of, nearest, pair, positive
from symfric.solve.protocol import Program
from symfric.solve.routes import prepare, simulate
from symfric.solve.run import finished
from symfric.theory.transient.decay import damper_numbers, decisions

VARIED = ("f_n", "mu_m", "zeta", "r", "v_c")
POINTS = {1: 1001, 2: 45, 3: 13, 4: 7, 5: 5}  # survey points along each parameter, by the number of parameters
TOLERANCE = 1e-12
STARTS = 3  # points of the survey from which a piece is optimised
WORTH = 1.6  # time relative to the shortest of the survey above which a piece is not searched
TURNS = 6  # most rounds of polling around the best point and optimising its piece again
STEP = 1e-6  # finite-difference step relative to the width of the bounds
SAFE = 1e-10  # least distance of the last turning point within the stick limit, relative to it, against rounding
BESIDE = (1e-6, 1e-4, 1e-2)  # distances of the neighbouring designs, relative to the bounds
_DECAY = "decay time [s]"
JUST = 1e-9  # distance of a turning point from the stick limit, relative to it, that counts as at the jump


@dataclass(frozen=True)
class Decay:
    """A motion until rest, by its turning points.

    Attributes
    ----------
    t, margin : tuple of float
        Times of the turning points up to the one that sticks, beginning with the start if it is at rest; distance of
        each beyond the stick limit, relative to it: the rod sticks where that is 0 or negative.
    x : float
        Final position of the rod.
    """

    t: tuple[float, ...]
    margin: tuple[float, ...]
    x: float

    @property
    def time(self) -> float:
        """Decay time; infinite if it does not stop."""
        return self.t[-1] if self.t and self.margin[-1] <= 0 else np.inf

    @property
    def turns(self) -> int:
        """Number of turning points, not counting a start at rest."""
        return len(self.t) - (self.t[:1] == (0.0,))


@dataclass(frozen=True, eq=False)
class Damper:
    """Decay as a function of the parameters, each from 0 to 1 between its bounds."""

    program: Program
    names: tuple[str, ...]
    low: np.ndarray
    high: np.ndarray
    numbers: Mapping[str, float]
    margin: float
    residual: float
    seen: dict[tuple[float, ...], Decay] = field(default_factory=dict)

    def values(self, p: np.ndarray) -> dict[str, float]:
        """Return the parameters at a point of the unit cube."""
        inner = self.low + np.clip(p, 0.0, 1.0) * (self.high - self.low)
        return dict(zip(self.names, np.clip(inner, self.low, self.high).tolist(), strict=True))

    def limit(self, p: np.ndarray) -> float:
        """Return the distance from the middle up to which the rod sticks."""
        n = {**self.numbers, **self.values(p)}
        return n["mu_m"] * n["r"] * n["g"] / (2 * np.pi * n["f_n"]) ** 2

    def __call__(self, p: np.ndarray) -> Decay:
        """Simulate the motion at a point of the unit cube."""
        key = tuple(np.clip(p, 0.0, 1.0).tolist())
        if key not in self.seen:
            run = finished(self.program.run(values=self.values(np.array(key))))
            times = [e.t for e in run.events if e.before]
            if self.numbers["v0"] == 0 and self.numbers["x0"] != 0:
                times = [0.0, *times]
            limit = self.limit(np.array(key))
            x = run(np.array(times))[0] if times else np.array([])
            margin = np.abs(x) / limit - 1 if limit > 0 else np.full(x.size, np.inf)
            if times and not (run.events and run.events[-1].after != 0) and run.final[1] == 0:
                margin[-1] = min(margin[-1], 0.0)  # the solver found sticking, so a positive margin is rounding
            self.seen[key] = Decay(tuple(times), tuple(margin.tolist()), float(run.final[0]))
        return self.seen[key]

    def shortfall(self, p: np.ndarray, n: int) -> float:
        """Return by how much turning point n, or an earlier one that sticks, violates residual and margin."""
        decay = self(p)
        if not decay.t:
            return np.inf
        k = min(n, len(decay.t) - 1)
        miss = decay.margin[k] + self.margin
        if np.isfinite(self.residual) and self.limit(p) > 0:
            miss = max(miss, (1 + decay.margin[k]) * self.limit(p) / self.residual - 1)
        return miss

    def good(self, decay: Decay) -> bool:
        """Whether a motion stops within the allowed residual and margin."""
        return decay.time < np.inf and decay.margin[-1] <= -self.margin and abs(decay.x) <= self.residual * (1 + 1e-12)


@logged
def contact_damper(
    scene: Scene, bounds: Mapping[Key, tuple[float, float]], *, residual: float = np.inf, margin: float = 0.0
) -> Design:
    """Find friction, stiffness and damping of the shortest decay of a rod braked by a contact.

    Parameters
    ----------
    scene : Scene
        `symfric.scenes.contact_damper`.
    bounds : mapping of parameter to (float, float)
        Of some of "mu_m", "f_n", "zeta", "r" and "v_c": friction, natural frequency in Hz (the stiffness, the mass
        being fixed), damping ratio, load, and the speed over which friction falls.
    residual : float
        Largest distance from the middle at which the rod may stay, m.
    margin : float
        The last turning point must lie within the stick limit by this share of it, 0 to 1. At 0 the design mostly lies
        where that turning point just sticks, and the least disturbance costs half a cycle more.

    Returns
    -------
    Design
        The objective is the decay time, s.

    Raises
    ------
    SceneError
        If the scene is another one or an argument is wrong.
    NotFound
        If no motion stops as asked; says what comes closest and by how much it misses.

    Notes
    -----
    Younes and Ashour (2), (3). A rod that starts at rest within the stick limit never moves: its decay time is 0, and
    `residual` excludes that.

    Examples
    --------
    >>> import symfric as sf
    >>> rod = sf.scenes.contact_damper(f_n=5, mu_m=0.1)
    >>> found = sf.design.contact_damper(rod, {"mu_m": (0.05, 0.2)})
    >>> found.status
    'optimal'
    """
    damper = _read(scene, bounds, residual, margin)
    points = POINTS[len(damper.names)]
    grid = [np.array(p) for p in itertools.product(np.linspace(0, 1, points), repeat=len(damper.names))]
    with until_interrupted("contact_damper"):
        tell("the shortest decay")
        best = _best(damper, grid)
        if best is None:
            raise NotFound(_missing(damper, grid))
        tell("verification of the design")
        return _design(scene, damper, best)
    return _interrupted(scene, damper)


def _interrupted(scene: Scene, damper: Damper) -> Design:
    """Return the best design that was computed before an interrupt."""
    good = {key: decay for key, decay in damper.seen.items() if damper.good(decay)}
    if not good:
        raise KeyboardInterrupt
    best = min(good, key=lambda key: good[key].time)
    values, beside = damper.values(np.array(best)), sorted(key for key in damper.seen if key[1:] == best[1:])
    x = np.array([damper.values(np.array(key))[damper.names[0]] for key in beside])
    y = np.array([damper.seen[key].time for key in beside])
    name, full = damper.names[0], scene.where(values)
    curve = Curve(x, np.where(np.isfinite(y), y, np.nan), good[best].time, name, _DECAY, (values[name],))
    return design(values, good[best].time, (), full, Interrupted(), curve, claim=BEST_FOUND, neighbours=())


def _read(scene: Scene, bounds: Mapping[Key, tuple[float, float]], residual: float, margin: float) -> Damper:
    own, _ = damper_numbers(scene)
    numbers: dict[str, Any] = {k: own[k] for k in (*VARIED, "m", "x0", "v0", "g")}
    given = {name_of(k): v for k, v in mapped(bounds, "bounds", "{'mu_m': (lower, upper)}").items()}
    if not given:
        raise SceneError("bounds is empty; give those of mu_m, f_n, zeta, r or v_c")
    low: list[float] = []
    high: list[float] = []
    for name, span in given.items():
        if name not in VARIED:
            raise SceneError(f"{name} in bounds is no parameter that contact_damper varies{nearest(name, VARIED)}")
        a, b = (finite(e, f"a bound of {name}") for e in pair(span, f"the bounds of {name}"))
        if not (0 < a <= b if name in ("f_n", "v_c") else 0 <= a <= b):
            raise SceneError(f"the bounds of {name} are ({a:g}, {b:g}); give the lower one first, not negative")
        low, high = [*low, a], [*high, b]
    if not is_one_of(residual, (np.inf,)):
        positive(residual, "residual")
    if not 0 <= finite(margin, "margin") < 1:
        raise SceneError(f"margin is {margin:g}; it is a fraction of the stick limit, from 0 to less than 1")
    corners = (dict(zip(given, c, strict=True)) for c in itertools.product(*zip(low, high, strict=True)))
    longest = max(scenes.contact_damper(**{**numbers, **corner}).horizon for corner in corners)
    x, u = scene.system.states
    start = {x: numbers["x0"], u: numbers["v0"]}  # as numbers: a start that depends on parameters is slow to change
    # not zero, so that no parameter is dropped
    scene = scene.where(dict(zip(given, high, strict=True))).starting(start)
    program = prepare(scene.until(longest, {"path": Trajectory()}), TOLERANCE)
    return Damper(
        program, tuple(given), np.array(low), np.array(high), numbers, max(float(margin), SAFE), float(residual)
    )


def _best(damper: Damper, grid: list[np.ndarray]) -> np.ndarray | None:
    """Return the point of the shortest decay: a survey, then an optimisation of every piece that may improve on it."""
    decays = [damper(p) for p in grid]
    good = [k for k, d in enumerate(decays) if damper.good(d)]
    best = grid[min(good, key=lambda k: decays[k].time)] if good else None
    shortest = np.inf if best is None else damper(best).time
    pieces: dict[int, list[int]] = {}
    for k, d in enumerate(decays):
        at_rest = d.t[:1] == (0.0,)
        for n in {d.turns, d.turns - 1} if d.t else ():
            if n < 0 or (n == 0 and not at_rest):
                continue
            pieces.setdefault(n, []).append(k)
    for n in sorted(pieces):
        # index of turning point n in each motion
        index = {k: len(decays[k].t) - decays[k].turns + n - 1 for k in pieces[n]}
        first = min(decays[k].t[min(index[k], len(decays[k].t) - 1)] for k in pieces[n])
        if first > WORTH * shortest:
            break
        order = sorted(pieces[n], key=lambda k: (max(damper.shortfall(grid[k], index[k]), 0.0), decays[k].time))
        for k in order[:STARTS]:
            point = _on_piece(damper, grid[k], index[k])
            if point is not None and damper(point).time < shortest:
                best, shortest = point, damper(point).time
    return None if best is None else _polled(damper, best, 0.5 / (POINTS[len(damper.names)] - 1))


def _polled(damper: Damper, best: np.ndarray, reach: float) -> np.ndarray:
    """Improve a point by polling around it, and optimise its piece again after each improvement."""

    def merit(p: np.ndarray) -> tuple[float, float]:
        decay = damper(p)
        return (0.0, decay.time) if damper.good(decay) else (1.0, np.inf)

    for _ in range(TURNS):
        before = damper(best).time
        best = polished(merit, best, reach, STEP)
        decay = damper(best)
        point = _on_piece(damper, best, len(decay.t) - 1) if decay.t else None
        if point is not None and merit(point) < merit(best):
            best = point
        if damper(best).time >= before * (1 - 1e-9):
            break
    return best


def _on_piece(damper: Damper, start: np.ndarray, n: int) -> np.ndarray | None:
    """Return the point near a start where turning point n sticks at the least time; None if it does not stick."""
    from scipy.optimize import minimize

    size = len(start)
    if not np.isfinite(damper.shortfall(start, n)):
        return None  # no sticking without friction

    def time(p: np.ndarray) -> float:
        decay = damper(p)
        return decay.t[min(n, len(decay.t) - 1)] if decay.t else np.inf

    def slopes(function: Callable[[np.ndarray], float]) -> Callable[[np.ndarray], np.ndarray]:
        def at(p: np.ndarray) -> np.ndarray:
            low, high = (np.clip(p + s * STEP * np.eye(size), 0, 1) for s in (-1, 1))
            return np.array([(function(b) - function(a)) / np.sum(b - a) for a, b in zip(low, high, strict=True)])

        return at

    scale = time(start) or 1.0
    miss = lambda p: -damper.shortfall(p, n)  # noqa: E731
    optimum = minimize(
        lambda p: time(p) / scale,
        start,
        jac=lambda p: slopes(time)(p) / scale,
        bounds=[(0, 1)] * size,
        constraints={"type": "ineq", "fun": miss, "jac": slopes(miss)},
        method="SLSQP",
        options={"ftol": 1e-13, "maxiter": 60},
    )
    return _pulled_in(damper, start, np.clip(optimum.x, 0, 1), n) if np.all(np.isfinite(optimum.x)) else None


def _pulled_in(damper: Damper, start: np.ndarray, p: np.ndarray, n: int) -> np.ndarray | None:
    """Return the point nearest to p, towards smaller margins, at which the motion stops within residual and margin."""
    if damper.good(damper(p)):
        return p
    step = STEP * np.eye(len(p))
    slope = np.array([damper.shortfall(p + d, n) - damper.shortfall(p - d, n) for d in step]) / (2 * STEP)
    way = -slope / max(float(slope @ slope), 1e-300)
    for share in 10.0 ** np.arange(-13, -3):
        inside = np.clip(p + (max(damper.shortfall(p, n), 0.0) + share) * way, 0, 1)
        if damper.good(damper(inside)):
            return inside
    return None


def _missing(damper: Damper, grid: list[np.ndarray]) -> str:
    def miss(p: np.ndarray) -> tuple[int, float]:
        decay = damper(p)
        stops = decay.time < np.inf
        return (0, damper.shortfall(p, len(decay.t))) if stops else (1, 0.0)

    closest = min(grid, key=miss)
    decay, values = damper(closest), ", ".join(f"{k} = {v:.6g}" for k, v in damper.values(closest).items())
    if decay.time == np.inf:
        return f"no values within the bounds bring the rod to rest within {damper.program.scene.horizon:.6g} s"
    words = f"no motion meets the residual and the margin; {values} comes closest: it stays at {decay.x:.6g} m"
    if abs(decay.x) > damper.residual:
        return f"{words}, {abs(decay.x) - damper.residual:.6g} m beyond the residual allowed"
    return f"{words}, within the stick limit by {-decay.margin[-1]:.6g} of it, less than the margin {damper.margin:g}"


def _design(scene: Scene, damper: Damper, p: np.ndarray) -> Design:
    decay, values = damper(p), damper.values(p)
    active = []
    if decay.turns == 0 and decay.time == 0:
        active.append("the rod sticks where it starts")
    if abs(decay.margin[-1] + damper.margin) < JUST:
        words = f"within the stick limit by the margin of {damper.margin:g}"
        if damper.margin == SAFE:
            words = f"just sticks; a change of 1e-6 of the bounds beyond, the decay takes {_beyond(damper, p):.9g}"
        active.append(f"turning point {decay.turns} {words}")
    if np.isfinite(damper.residual) and abs(abs(decay.x) - damper.residual) <= 1e-8 * damper.residual:
        active.append("residual at its limit")
    for name, place in zip(damper.names, p, strict=True):
        active += [f"{name} at its {word} bound" for word, end in (("lower", 0.0), ("upper", 1.0)) if place == end]
    outputs = {"stop_time": StopTime(), "path": Trajectory()}
    full = scene.where(values).until(damper.program.scene.horizon, outputs)
    run = finished(simulate(full, 1e-13))
    limit = damper.limit(p)
    rows = [
        Compared("decay time", decay.time, float(run["stop_time"]), 1e-9),
        Compared("half cycles", decay.turns, sum(e.before != 0 for e in run.events), 0.0),
        Compared("margin of the last turning point", decay.margin[-1], decisions(run).last, 1e-9, size=1.0),
        Compared("residual over the stick limit", abs(decay.x) / limit, abs(float(run.final[0])) / limit, 1e-8, size=1),
    ]
    check, beside = Comparison(tuple(rows)), _beside(damper, p)
    return design(values, decay.time, active, full, check, _curve(damper, p), claim="optimal", neighbours=beside)


def _beside(damper: Damper, p: np.ndarray) -> list[Neighbour]:
    """Return the neighbours of a design along each parameter, at several distances."""
    neighbours = []
    for k, (name, step) in itertools.product(range(len(p)), itertools.product(("smaller", "larger"), BESIDE)):
        q = p.copy()
        q[k] += step if name == "larger" else -step
        if 0 <= q[k] <= 1:
            decay = damper(q)
            met = damper.good(decay)
            miss = max(damper.shortfall(q, len(decay.t) - 1), SAFE) if decay.t else np.inf
            change = f"{damper.names[k]} {name} by {step:g} of its bounds"
            neighbours.append(Neighbour(change, decay.time, 0.0 if met else miss))
    return neighbours


def _beyond(damper: Damper, p: np.ndarray) -> float:
    """Return the largest decay time at the nearest neighbours: the cost of the jump."""
    steps = np.concatenate([np.eye(len(p)), -np.eye(len(p))]) * 1e-6
    return max(damper(np.clip(p + d, 0, 1)).time for d in steps)


def _curve(damper: Damper, p: np.ndarray) -> Curve:
    """Return the curve of the decay time over the first parameter."""
    places = np.unique(np.append(np.linspace(0, 1, 201), p[0]))
    y = np.array([damper(np.array([e, *p[1:]])).time for e in places])
    x = damper.low[0] + places * (damper.high[0] - damper.low[0])
    mark = damper.values(p)[damper.names[0]]
    return Curve(x, np.where(np.isfinite(y), y, np.nan), damper(p).time, damper.names[0], _DECAY, (mark,))
