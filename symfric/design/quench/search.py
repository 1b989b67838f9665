"""Global search for the least excitation under conditions at every belt speed of a range.

For every intensity q the best amplitude and frequency are known, so that the search is over q alone, with the worst
belt speed of each. The feasible intensities may fall into several intervals: the scan starts one search in each and
keeps the best.
"""

from dataclasses import dataclass, field
from math import sqrt
from typing import Any

import numpy as np

from symfric.design.quench.belt_scene import AMPLITUDE, FREQUENCY
from symfric.design.quench.followed_speeds import FollowedSpeeds
from symfric.design.quench.worst_speed import SpeedRange
from symfric.search import minimum, zero

FAR = 0.02  # deficit of a peak in the scan, relative to the condition's size, above which it is not polished


@dataclass(frozen=True)
class QuenchCondition:
    """A condition at every belt speed: least damping, least friction or largest power.

    Attributes
    ----------
    kind : {"damping", "friction", "power"}
    level, size : float
        The limit, and the scale that makes the slack dimensionless.
    """

    kind: str
    level: float
    size: float

    def slack(self, value: Any) -> Any:
        """Return the slack of a value (float or array) relative to the size; negative where the condition fails."""
        return (self.level - value if self.kind == "power" else value - self.level) / self.size


@dataclass(frozen=True, eq=False)
class QuenchProblem:
    """The optimisation problem: objective, bounds of the excitation, and conditions.

    Attributes
    ----------
    speeds : SpeedRange
    gain : float
        Amplitude q of the fast slip over ``a Omega``.
    minimise : {"intensity", "power", "force"}
    Omega, a : (float, float)
    margin : float
        Least damping.
    limits : dict of str to float
        Least fraction of the "friction", largest "acceleration" ``a Omega^2`` and "power", as far as given.
    top : float
        Fast slip over q: 1, or, where the excitation follows the belt speed and q is their ratio, the highest one.
    ratios : (float, float)
        Bounds of q as such.
    ratio : str
        Name of q over the gain where the excitation follows.
    """

    speeds: SpeedRange | FollowedSpeeds
    gain: float
    minimise: str
    Omega: tuple[float, float]
    a: tuple[float, float]
    margin: float
    limits: dict[str, float] = field(default_factory=dict)
    top: float = 1.0
    ratios: tuple[float, float] = (0.0, np.inf)
    ratio: str = "k"

    @property
    def followed(self) -> bool:
        """Whether the excitation follows the belt speed, ``a Omega = k v_b`` with k = q/gain."""
        return isinstance(self.speeds, FollowedSpeeds)

    @property
    def symbol(self) -> str:
        """What ``q/gain`` is called in words."""
        return f"{self.ratio} = a*Omega/v_b" if self.followed else "a*Omega"

    def values(self, q: float) -> dict[str, float]:
        """Return the design parameters of the excitation q."""
        a, Omega = self.excitation(q)
        return {self.ratio: q / self.gain, FREQUENCY: Omega} if self.followed else {AMPLITUDE: a, FREQUENCY: Omega}

    def at_speed(self, excitation: tuple[float, float], v: float) -> tuple[float, float]:
        """Return a and Omega at a belt speed, for those at the highest one."""
        a, Omega = excitation
        return (a * v / self.top, Omega) if self.followed else excitation

    @property
    def intensities(self) -> tuple[float, float]:
        """Smallest and largest q within the bounds and the limit on the acceleration; none if the first is larger."""
        largest = self.a[1] * self.Omega[1]
        if "acceleration" in self.limits:  # grows with q, at the lowest frequency that reaches it
            highest = self.limits["acceleration"]
            largest = min(largest, highest / self.Omega[0], sqrt(highest * self.a[1]))
        unit = self.gain / self.top
        return max(unit * self.a[0] * self.Omega[0], self.ratios[0]), min(unit * largest, self.ratios[1])

    @property
    def conditions(self) -> tuple[QuenchCondition, ...]:
        """Conditions at every belt speed, the damping first."""
        asked = [QuenchCondition(k, v, v) for k, v in self.limits.items() if k != "acceleration"]
        return QuenchCondition("damping", self.margin, self.speeds.averaged.scale), *asked

    @property
    def kinds(self) -> tuple[str, ...]:
        """Kinds of the conditions."""
        return tuple({c.kind for c in self.conditions} | ({"power"} if self.minimise == "power" else set()))

    def excitation(self, q: float) -> tuple[float, float]:
        """Return the a and Omega of least force among those with q, the lowest frequency; a at the highest speed."""
        intensity = q * self.top / self.gain
        Omega = max(self.Omega[0], intensity / self.a[1])
        return intensity / Omega, Omega

    def slack(self, regime: str, q: float) -> float:
        """Return the least slack of the conditions over the belt speeds."""
        return float(min(c.slack(self.speeds.worst(regime, q, c.kind)[0].value) for c in self.conditions))

    def objective(self, regime: str, q: float) -> float:
        """Return the objective at the best a and Omega of the fast slip q."""
        if self.minimise == "power":
            return self.speeds.worst(regime, q, "power")[0].value
        a, Omega = self.excitation(q)
        return a * Omega if self.minimise == "intensity" else a * Omega**2


@dataclass(frozen=True)
class Optimum:
    """The best q, its regime and objective."""

    q: float
    regime: str
    objective: float


@dataclass(frozen=True)
class QuenchStart:
    """A feasible intensity and the neighbours in the scan between which the search stays."""

    regime: str
    q: float
    low: float
    high: float
    objective: float


def search(problem: QuenchProblem) -> Optimum | tuple[float, str]:
    """Return the global optimum, or, if nothing is feasible, the intensity that comes closest and its regime."""
    starts, closest = _starts(problem)
    best = None
    for start in starts:
        if best is not None and problem.minimise != "power" and start.low >= best.q:
            break  # intensity and force rise with q
        q = _least(problem, start)
        optimum = Optimum(q, start.regime, problem.objective(start.regime, q))
        if best is None or optimum.objective < best.objective - 1e-13 * abs(best.objective):
            best = optimum
    return closest if best is None else best


def grid_of(low: float, high: float) -> np.ndarray:
    """Return a grid of intensities, dense at both ends, and logarithmic if the bounds are wide."""
    near = low + (high - low) * np.concatenate([np.logspace(-7, -1, 25), 1 - np.logspace(-7, -1, 25)])
    decades = np.geomspace(max(low, 1e-4 * high), high, 60) if high > 0 else np.array([high])
    return np.clip(np.unique(np.concatenate([[low, high], np.linspace(low, high, 60), near, decades])), low, high)


def _starts(problem: QuenchProblem) -> tuple[list[QuenchStart], tuple[float, str]]:
    """Scan every regime for feasible intervals; q = 0, no excitation, was tried before."""
    starts, closest, least = [], (0.0, "mixed"), -np.inf
    for regime, (low, high) in problem.speeds.regimes(*problem.intensities).items():
        q = grid_of(low, high)
        q = q[q > 0]
        seen = problem.speeds.scan(regime, q, problem.kinds)
        slack = np.min([c.slack(seen[c.kind]) for c in problem.conditions], axis=0)
        q, slack, power = refined(problem, regime, q, slack, seen.get("power", q))
        k = int(np.argmax(slack))
        if slack[k] > least:
            least, closest = slack[k], (float(q[k]), regime)
        objective = power if problem.minimise == "power" else q
        starts += _of_regime(regime, q, slack >= 0, objective)
    key = (lambda s: s.objective) if problem.minimise == "power" else (lambda s: s.low)
    return sorted(starts, key=key), closest


def refined(
    problem: QuenchProblem, regime: str, q: np.ndarray, slack: np.ndarray, power: np.ndarray
) -> tuple[np.ndarray, ...]:
    """Add local maxima of the slack between grid points, since a feasible interval may be narrower than a cell."""
    inner, beside = slack[1:-1], (slack[:-2], slack[2:])
    peak = (inner >= np.maximum(*beside)) & (inner > np.minimum(*beside) + 1e-12)  # not a plateau with rounding errors
    peaks = 1 + np.flatnonzero((inner < 0) & np.isfinite(inner) & peak)
    extra = []
    for k in peaks[np.argsort(-slack[peaks])][:3]:
        low, high = q[k - 1], q[k + 1]
        for tolerance in (1e-3 * (high - low), 1e-9 * high):
            top = minimum(lambda s: -problem.slack(regime, s), low, high, xatol=tolerance)
            if top.value > FAR:
                break
        if -top.value > slack[k]:
            extra.append((top.place, -top.value))
    if not extra:
        return q, slack, power
    more, values = (np.array(e) for e in zip(*extra, strict=True))
    order = np.argsort(np.concatenate([q, more]))
    joined = ((q, more), (slack, values), (power, problem.speeds.scan(regime, more, problem.kinds).get("power", more)))
    return tuple(np.concatenate(e)[order] for e in joined)


def _of_regime(regime: str, q: np.ndarray, feasible: np.ndarray, objective: np.ndarray) -> list[QuenchStart]:
    """Return a start for every local minimum of the objective on each feasible stretch of the grid."""
    cost = np.where(feasible, objective, np.inf)
    left, right = np.concatenate([[np.inf], cost[:-1]]), np.concatenate([cost[1:], [np.inf]])
    lows = np.flatnonzero(feasible & (cost <= left) & (cost <= right)).tolist()
    ends = [(float(q[max(k - 1, 0)]), float(q[min(k + 1, q.size - 1)])) for k in lows]
    return [QuenchStart(regime, float(q[k]), *e, float(cost[k])) for k, e in zip(lows, ends, strict=True)]


def _least(problem: QuenchProblem, start: QuenchStart) -> float:
    """Return the best feasible intensity between the neighbours of a start in the scan."""
    q = start.q
    low, high = (edge(problem, start.regime, q, end) for end in (start.low, start.high))
    if problem.minimise != "power" or not high > low:
        return low  # intensity and force rise with q
    ends = [(problem.objective(start.regime, e), e) for e in (low, q, high)]
    lowest = minimum(lambda s: problem.objective(start.regime, s), low, high, xatol=1e-12 * high)
    if problem.slack(start.regime, lowest.place) >= 0:
        ends.append((lowest.value, lowest.place))
    return min(ends)[1]


def edge(problem: QuenchProblem, regime: str, good: float, bad: float) -> float:
    """Bisect from a feasible intensity towards the second one; return the last feasible intensity."""

    def slack(s: float) -> float:
        return problem.slack(regime, s)

    last = slack(bad)
    if last >= 0 or good == bad:
        return bad
    if np.isfinite(last) and np.isfinite(slack(good)):
        root = zero(slack, good, bad, rtol=4e-15)
        # the root may miss the condition by rounding, and a design must meet it
        for share in (0.0, 1e-15, 1e-14, 1e-13, 1e-12):
            inner = root + share * (root if good > bad else -root)
            if min(good, bad) <= inner <= max(good, bad) and slack(inner) >= 0:
                return inner
        bad = root
    while abs(good - bad) > 1e-15 * abs(good):
        middle = 0.5 * (good + bad)
        if middle in (good, bad):
            break
        good, bad = (middle, bad) if slack(middle) >= 0 else (good, middle)
    return float(good)
