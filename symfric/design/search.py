"""The least excitation under a condition at every belt speed of a range: a coarse scan, then IPOPT with exchange.

The condition is semi-infinite. IPOPT sees it at a few belt speeds; the worst speed of its answer joins them, until the
answer violates it nowhere. The feasible intensities may fall into several intervals, so the scan starts one search in
each and keeps the best.
"""

from dataclasses import dataclass, replace

import casadi as ca
import numpy as np
from scipy.optimize import brentq, minimize_scalar

from symfric.design.worst import Point, Range

EXCHANGES = 30
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


@dataclass(frozen=True, eq=False)
class Problem:
    """What is minimised, over which excitations, under which condition.

    Attributes
    ----------
    speeds : Range
    gain : float
        Amplitude q of the fast slip over ``a Omega``.
    minimise : {"intensity", "power", "force"}
    Omega, a : (float, float)
    margin : float
        Least damping.
    """

    speeds: Range
    gain: float
    minimise: str
    Omega: tuple[float, float]
    a: tuple[float, float]
    margin: float

    @property
    def intensities(self) -> tuple[float, float]:
        """Smallest and largest q within the bounds."""
        return self.gain * self.a[0] * self.Omega[0], self.gain * self.a[1] * self.Omega[1]

    def excitation(self, q: float) -> tuple[float, float]:
        """Return the a and Omega of least force among those with the fast slip q: the lowest frequency."""
        intensity = q / self.gain
        Omega = max(self.Omega[0], intensity / self.a[1])
        return intensity / Omega, Omega

    def slack(self, regime: str, q: float) -> float:
        """Return the least damping over the belt speeds beyond the margin."""
        return self.speeds.worst(regime, q)[0].value - self.margin

    def objective(self, regime: str, q: float) -> float:
        """Return what is minimised, at the best a and Omega of the fast slip q."""
        if self.minimise == "power":
            return self.speeds.worst(regime, q, power=True)[0].value
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


def _grid(low: float, high: float) -> np.ndarray:
    """Return intensities that resolve both ends, and decades where the bounds are wide."""
    near = low + (high - low) * np.concatenate([np.logspace(-7, -1, 25), 1 - np.logspace(-7, -1, 25)])
    decades = np.geomspace(max(low, 1e-4 * high), high, 60) if high > 0 else np.array([high])
    return np.clip(np.unique(np.concatenate([[low, high], np.linspace(low, high, 60), near, decades])), low, high)


def _starts(problem: Problem) -> tuple[list[Start], tuple[float, str]]:
    """Scan every regime for feasible intervals; q = 0 is no excitation and has been tried before."""
    starts, closest, least = [], (0.0, "mixed"), -np.inf
    for regime, (low, high) in problem.speeds.regimes(*problem.intensities).items():
        q = _grid(low, high)
        q = q[q > 0]
        slack, power = problem.speeds.scan(regime, q)
        slack = slack - problem.margin
        q, slack, power = _refined(problem, regime, q, slack, power)
        k = int(np.argmax(slack))
        if slack[k] > least:
            least, closest = slack[k], (float(q[k]), regime)
        objective = power if problem.minimise == "power" else q
        starts += _of_regime(regime, q, slack >= 0, objective)
    key = (lambda s: s.objective) if problem.minimise == "power" else (lambda s: s.low)
    return sorted(starts, key=key), closest


def _refined(problem: Problem, regime: str, q, slack, power):
    """Add the local maxima of the slack that the grid missed: a feasible interval may be narrower than a cell."""
    inner = slack[1:-1]
    peaks = 1 + np.flatnonzero((inner < 0) & np.isfinite(inner) & (inner >= np.maximum(slack[:-2], slack[2:])))
    extra = []
    for k in peaks[np.argsort(-slack[peaks])][:3]:
        found = minimize_scalar(
            lambda s: -problem.slack(regime, s), bounds=(q[k - 1], q[k + 1]), method="bounded", options={"xatol": 1e-9}
        )
        if -found.fun > slack[k]:
            extra.append((float(found.x), -float(found.fun)))
    if not extra:
        return q, slack, power
    more, values = (np.array(e) for e in zip(*extra, strict=True))
    order = np.argsort(np.concatenate([q, more]))
    joined = ((q, more), (slack, values), (power, problem.speeds.scan(regime, more)[1]))
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
    speeds, tolerance = problem.speeds, 1e-12 * problem.speeds.averaged.scale
    dampings = speeds.worst(start.regime, start.q)
    powers = speeds.worst(start.regime, start.q, power=True) if problem.minimise == "power" else []
    q = start.q
    for _ in range(EXCHANGES):
        found = _solve(problem, start, dampings, powers)
        if found is None:
            return start.q
        q, bound = found
        new = [p for p in speeds.worst(start.regime, q) if p.value < problem.margin - tolerance]
        more = []
        if powers:
            more = [p for p in speeds.worst(start.regime, q, power=True) if p.value > bound + 1e-12 * abs(bound)]
        new, more = _unknown(new, dampings), _unknown(more, powers)
        if not new and not more:
            break
        dampings, powers = dampings + new, powers + more
    return q


def _unknown(points: list[Point], known: list[Point]) -> list[Point]:
    return [p for p in points if not any(replace(p, value=k.value, v=k.v) == k for k in known)]


def _solve(problem: Problem, start: Start, dampings: list[Point], powers: list[Point]) -> tuple[float, float] | None:
    """Minimise over scaled a Omega, Omega and the bound on the power, with the condition at the given speeds."""
    speeds, scale = problem.speeds, problem.speeds.averaged.scale
    q_size, O_size = start.high, problem.Omega[1]
    P_size = max((abs(p.value) for p in powers), default=0.0) or 1.0
    z = ca.SX.sym("z", 3)
    q, Omega, power = z[0] * q_size, z[1] * O_size, z[2] * P_size
    intensity = q / problem.gain
    g = [intensity - problem.a[0] * Omega, problem.a[1] * Omega - intensity]
    g = [e / (q_size / problem.gain) for e in g]
    for p in dampings:
        g.append((_at(speeds, p, q)[0] - problem.margin) / scale)
    for p in powers:
        g.append((power - _at(speeds, p, q)[1]) / P_size)
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
    edge = abs(slack) < 1e-6 * problem.speeds.averaged.scale
    if not edge and slack >= 0:
        return q
    for width in (1e-8, 1e-6, 1e-4, 1.0):
        a, b = max(start.low, q * (1 - width)), min(start.high, q * (1 + width))
        ends = problem.slack(start.regime, a), problem.slack(start.regime, b)
        if ends[0] * ends[1] < 0 and np.all(np.isfinite(ends)):
            root = brentq(lambda s: problem.slack(start.regime, s), a, b, xtol=1e-15, rtol=4e-15)
            return float(root)
    return q if slack >= 0 else start.q
