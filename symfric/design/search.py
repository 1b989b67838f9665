"""The least excitation under conditions at every belt speed of a range: a coarse scan, then IPOPT with exchange.

The conditions are semi-infinite. IPOPT sees them at a few belt speeds; the worst speed of its answer joins them, until
the answer violates them nowhere. The feasible intensities may fall into several intervals, so the scan starts one
search in each and keeps the best.
"""

from dataclasses import dataclass, field, replace
from math import sqrt

import casadi as ca
import numpy as np
from scipy.optimize import brentq, minimize_scalar

from symfric.design.worst import ROWS, Point, Range

EXCHANGES = 30
FAR = 0.02  # slack that a peak lacks, over its condition's size, at a first look that makes a second one idle
IPOPT = {
    "print_time": False,
    "error_on_fail": False,
    "ipopt": {
        "print_level": 0,
        "sb": "yes",
        "tol": 1e-12,
        "compl_inf_tol": 1e-13,
        "constr_viol_tol": 1e-13,
        "bound_relax_factor": 0.0,
        "honor_original_bounds": "yes",
        "max_iter": 200,
    },
}


@dataclass(frozen=True)
class Condition:
    """What must hold at every belt speed: a damping or a friction not below a level, a power not above it.

    Attributes
    ----------
    kind : {"damping", "friction", "power"}
    level, size : float
        The size makes what is missing a number without unit.
    """

    kind: str
    level: float
    size: float

    def slack(self, value):
        """Return by how much a value, a float, an array or CasADi's, is on the right side, over the size."""
        return (self.level - value if self.kind == "power" else value - self.level) / self.size


@dataclass(frozen=True, eq=False)
class Problem:
    """What is minimised, over which excitations, under which conditions.

    Attributes
    ----------
    speeds : Range
    gain : float
        Amplitude q of the fast slip over ``a Omega``.
    minimise : {"intensity", "power", "force"}
    Omega, a : (float, float)
    margin : float
        Least damping.
    limits : dict of str to float
        Least share of the "friction", largest "acceleration" ``a Omega^2`` and "power"; those that are asked for.
    """

    speeds: Range
    gain: float
    minimise: str
    Omega: tuple[float, float]
    a: tuple[float, float]
    margin: float
    limits: dict[str, float] = field(default_factory=dict)

    @property
    def intensities(self) -> tuple[float, float]:
        """Smallest and largest q within the bounds and the limit on the acceleration; none if the first is larger."""
        largest = self.a[1] * self.Omega[1]
        if "acceleration" in self.limits:  # grows with q, at the lowest frequency that reaches it
            highest = self.limits["acceleration"]
            largest = min(largest, highest / self.Omega[0], sqrt(highest * self.a[1]))
        return self.gain * self.a[0] * self.Omega[0], self.gain * largest

    @property
    def conditions(self) -> tuple[Condition, ...]:
        """What must hold at every belt speed, the damping first."""
        asked = [Condition(k, v, v) for k, v in self.limits.items() if k != "acceleration"]
        return Condition("damping", self.margin, self.speeds.averaged.scale), *asked

    def excitation(self, q: float) -> tuple[float, float]:
        """Return the a and Omega of least force among those with the fast slip q: the lowest frequency."""
        intensity = q / self.gain
        Omega = max(self.Omega[0], intensity / self.a[1])
        return intensity / Omega, Omega

    def slack(self, regime: str, q: float) -> float:
        """Return what the conditions leave over the belt speeds, the least of them."""
        return min(c.slack(self.speeds.worst(regime, q, c.kind)[0].value) for c in self.conditions)

    def objective(self, regime: str, q: float) -> float:
        """Return what is minimised, at the best a and Omega of the fast slip q."""
        if self.minimise == "power":
            return self.speeds.worst(regime, q, "power")[0].value
        a, Omega = self.excitation(q)
        return a * Omega if self.minimise == "intensity" else a * Omega**2


@dataclass(frozen=True)
class Optimum:
    """The best q, its regime and what is minimised there."""

    q: float
    regime: str
    objective: float


@dataclass(frozen=True)
class Start:
    """A feasible intensity and the neighbours in the scan between which the search stays."""

    regime: str
    q: float
    low: float
    high: float
    objective: float


def search(problem: Problem) -> Optimum | tuple[float, str]:
    """Return the global optimum; where nothing is feasible, the intensity that comes closest and its regime."""
    starts, closest = _starts(problem)
    best = None
    for start in starts:
        if best is not None and problem.minimise != "power" and start.low >= best.q:
            break  # intensity and force rise with q
        q = _polished(problem, start, _exchange(problem, start))
        found = Optimum(q, start.regime, problem.objective(start.regime, q))
        if best is None or found.objective < best.objective - 1e-13 * abs(best.objective):
            best = found
    return closest if best is None else best


def grid_of(low: float, high: float) -> np.ndarray:
    """Return intensities that resolve both ends, and decades where the bounds are wide."""
    near = low + (high - low) * np.concatenate([np.logspace(-7, -1, 25), 1 - np.logspace(-7, -1, 25)])
    decades = np.geomspace(max(low, 1e-4 * high), high, 60) if high > 0 else np.array([high])
    return np.clip(np.unique(np.concatenate([[low, high], np.linspace(low, high, 60), near, decades])), low, high)


def _starts(problem: Problem) -> tuple[list[Start], tuple[float, str]]:
    """Scan every regime for feasible intervals; q = 0 is no excitation and has been tried before."""
    starts, closest, least = [], (0.0, "mixed"), -np.inf
    for regime, (low, high) in problem.speeds.regimes(*problem.intensities).items():
        q = grid_of(low, high)
        q = q[q > 0]
        seen = problem.speeds.scan(regime, q)
        slack = np.min([c.slack(seen[c.kind]) for c in problem.conditions], axis=0)
        q, slack, power = refined(problem, regime, q, slack, seen["power"])
        k = int(np.argmax(slack))
        if slack[k] > least:
            least, closest = slack[k], (float(q[k]), regime)
        objective = power if problem.minimise == "power" else q
        starts += _of_regime(regime, q, slack >= 0, objective)
    key = (lambda s: s.objective) if problem.minimise == "power" else (lambda s: s.low)
    return sorted(starts, key=key), closest


def refined(problem: Problem, regime: str, q, slack, power):
    """Add the local maxima of the slack that the grid missed: a feasible interval may be narrower than a cell."""
    inner, beside = slack[1:-1], (slack[:-2], slack[2:])
    peak = (inner >= np.maximum(*beside)) & (inner > np.minimum(*beside) + 1e-12)  # no plateau of rounding
    peaks = 1 + np.flatnonzero((inner < 0) & np.isfinite(inner) & peak)
    extra = []
    for k in peaks[np.argsort(-slack[peaks])][:3]:
        low, high = q[k - 1], q[k + 1]
        for tolerance in (1e-3 * (high - low), 1e-9):
            found = minimize_scalar(
                lambda s: -problem.slack(regime, s), bounds=(low, high), method="bounded", options={"xatol": tolerance}
            )
            if found.fun > FAR:
                break
        if -found.fun > slack[k]:
            extra.append((float(found.x), -float(found.fun)))
    if not extra:
        return q, slack, power
    more, values = (np.array(e) for e in zip(*extra, strict=True))
    order = np.argsort(np.concatenate([q, more]))
    joined = ((q, more), (slack, values), (power, problem.speeds.scan(regime, more)["power"]))
    return tuple(np.concatenate(e)[order] for e in joined)


def _of_regime(regime: str, q: np.ndarray, feasible: np.ndarray, objective: np.ndarray) -> list[Start]:
    """Return a start for every local minimum of the objective on each feasible stretch of the grid."""
    cost = np.where(feasible, objective, np.inf)
    left, right = np.concatenate([[np.inf], cost[:-1]]), np.concatenate([cost[1:], [np.inf]])
    lows = np.flatnonzero(feasible & (cost <= left) & (cost <= right))
    ends = [(float(q[max(k - 1, 0)]), float(q[min(k + 1, q.size - 1)])) for k in lows]
    return [Start(regime, float(q[k]), *e, float(cost[k])) for k, e in zip(lows, ends, strict=True)]


def _exchange(problem: Problem, start: Start) -> float:
    """Return q of the optimum near a start by IPOPT; the start itself if IPOPT fails."""
    if not start.high > start.low:
        return start.q
    speeds = problem.speeds
    points = [(c, speeds.worst(start.regime, start.q, c.kind)) for c in problem.conditions]
    powers = speeds.worst(start.regime, start.q, "power") if problem.minimise == "power" else []
    q = start.q
    for _ in range(EXCHANGES):
        found = _solve(problem, start, points, powers)
        if found is None:
            return start.q
        q, bound = found
        new = []
        for c, known in points:
            worst = speeds.worst(start.regime, q, c.kind)
            new.append(_unknown([p for p in worst if c.slack(p.value) < -1e-12], known))
        more = []
        if powers:
            more = [p for p in speeds.worst(start.regime, q, "power") if p.value > bound + 1e-12 * abs(bound)]
            more = _unknown(more, powers)
        if not any(new) and not more:
            break
        points = [(c, known + added) for (c, known), added in zip(points, new, strict=True)]
        powers = powers + more
    return q


def _unknown(points: list[Point], known: list[Point]) -> list[Point]:
    return [p for p in points if not any(replace(p, value=k.value, v=k.v) == k for k in known)]


def _solve(problem: Problem, start: Start, points, powers: list[Point]) -> tuple[float, float] | None:
    """Minimise over scaled a Omega, Omega and the bound on the power, with each condition at the given speeds."""
    speeds = problem.speeds
    q_size, O_size = start.high, problem.Omega[1]
    P_size = max((abs(p.value) for p in powers), default=0.0) or 1.0
    z = ca.SX.sym("z", 3)
    q, Omega, power = z[0] * q_size, z[1] * O_size, z[2] * P_size
    intensity = q / problem.gain
    g = [intensity - problem.a[0] * Omega, problem.a[1] * Omega - intensity]
    g = [e / (q_size / problem.gain) for e in g]
    if "acceleration" in problem.limits:
        g.append(1 - intensity * Omega / problem.limits["acceleration"])
    for c, known in points:
        g += [c.slack(_at(speeds, p, q)[ROWS[c.kind]]) for p in known]
    g += [(power - _at(speeds, p, q)[ROWS["power"]]) / P_size for p in powers]
    cost = {"intensity": z[0], "force": z[0] * z[1], "power": z[2] if powers else z[0]}[problem.minimise]
    solver = ca.nlpsol("quench", "ipopt", {"x": z, "f": cost, "g": ca.vertcat(*g)}, IPOPT)
    first = problem.excitation(start.q)[1]
    bound = max((p.value for p in powers), default=0.0)
    found = solver(
        x0=[start.q / q_size, first / O_size, bound / P_size],
        lbx=[start.low / q_size, problem.Omega[0] / O_size, -np.inf if powers else 0.0],
        ubx=[1.0, 1.0, np.inf if powers else 0.0],
        lbg=0.0,
        ubg=np.inf,
    )
    if not solver.stats()["success"]:
        return None
    x = np.array(found["x"]).ravel() * [q_size, O_size, P_size]
    return float(np.clip(x[0], start.low, start.high)), float(x[2])


def _at(speeds: Range, p: Point, q: ca.SX):
    function = speeds.averaged.inside if p.inside else speeds.averaged.outside
    return function(p.at(q), q)


def _polished(problem: Problem, start: Start, q: float) -> float:
    """Put q exactly on the end of its regime, or on the edge of the condition, if it lies beside it."""
    slack = problem.slack(start.regime, q)
    for end in (start.low, start.high):
        if abs(q - end) < 1e-7 * max(q, end) and problem.slack(start.regime, end) >= 0:
            return end
    edge = abs(slack) < 1e-6
    if not edge and slack >= 0:
        return q
    for width in (1e-8, 1e-6, 1e-4, 1.0):
        a, b = max(start.low, q * (1 - width)), min(start.high, q * (1 + width))
        ends = problem.slack(start.regime, a), problem.slack(start.regime, b)
        if ends[0] * ends[1] < 0 and np.all(np.isfinite(ends)):
            root = brentq(lambda s: problem.slack(start.regime, s), a, b, xtol=1e-15, rtol=4e-15)
            return float(root)
    return q if slack >= 0 else start.q
