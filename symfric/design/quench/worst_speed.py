"""The worst belt speed of a range, for a given intensity.

The damping jumps at ``v = q``, q the amplitude of the fast slip: the slow mass reverses its slip below, and not above.
So the intensities fall into three regimes, in each of which the damping over the range is continuous in q:

| regime  | intensities    | belt speeds                                  |
|---------|----------------|----------------------------------------------|
| outside | q <= low       | all faster than the fast motion              |
| mixed   | low < q <= high| [low, q) inside, [q, high] outside           |
| inside  | q >= high      | all slower; q = high only as a limit          |
"""

import itertools
from collections.abc import Callable, Iterable
from dataclasses import dataclass
from typing import Any, TypeAlias

import numpy as np

from symfric.design.quench.averaged_damping import Averaged

Values: TypeAlias = Callable[..., np.ndarray]  # of a condition at belt speeds
_ENDS = np.logspace(-5, -1.1, 12)
_ZOOM, _FINE = (
    17,
    1e-9,
)  # points of the grid between the neighbours of a low point; width of the last grid relative to the first
ROWS = {"damping": 0, "power": 1, "friction": 3}  # output of the averaged contact for each kind of condition
# grid on an interval [0, 1], denser at its ends
SHARES = np.unique(np.concatenate([np.linspace(0, 1, 21), _ENDS, 1 - _ENDS]))


@dataclass(frozen=True)
class Edge:
    """An end of an interval of belt speeds, ``fixed + rate * q``; intervals move with q."""

    fixed: float
    rate: float

    def __call__(self, q: Any) -> Any:
        """Return the belt speed of the end; q may be a float or an array."""
        return self.fixed + self.rate * q


@dataclass(frozen=True)
class SpeedPoint:
    """Value of a condition at a belt speed.

    Attributes
    ----------
    value : float
        Damping, mean power or fraction of the friction there.
    v : float
    inside : bool
        Whether the fast motion reverses the slip there.
    """

    value: float
    v: float
    inside: bool


@dataclass(frozen=True, eq=False)
class SpeedRange:
    """Belt speeds [low, high] and the averaged contact on them."""

    averaged: Averaged
    low: float
    high: float

    def regimes(self, q_min: float, q_max: float) -> dict[str, tuple[float, float]]:
        """Return the intensities of each regime within the bounds."""
        whole = {"outside": (0.0, self.low), "mixed": (self.low, self.high), "inside": (self.high, np.inf)}
        cut = {name: (max(a, q_min), min(b, q_max)) for name, (a, b) in whole.items()}
        empty = {name for name, (a, b) in cut.items() if a > b or whole[name][0] == whole[name][1]}
        return {name: ends for name, ends in cut.items() if name not in empty}

    def regime_of(self, q: float) -> str:
        """Return the regime of an intensity."""
        return "outside" if q <= self.low else "mixed" if q <= self.high else "inside"

    def fast(self, q: float, _v: float) -> float:
        """Return the amplitude of the fast slip at a belt speed."""
        return q

    def kinks_of(self, q: float) -> list[float]:
        """Return the belt speeds at which the averaged damping has a kink."""
        return [abs(level + side * q) for level in self.averaged.kinks for side in (-1, 1)]

    def interval(self, regime: str, inside: bool) -> tuple[Edge, Edge]:
        """Return the ends of the inside or outside interval of belt speeds."""
        low, high, split = Edge(self.low, 0.0), Edge(self.high, 0.0), Edge(0.0, 1.0)
        if regime == "mixed":
            return (low, split) if inside else (split, high)
        return low, high

    def sides(self, regime: str) -> tuple[bool, ...]:
        """Return which of the inside and outside intervals exist."""
        return {"outside": (False,), "mixed": (True, False), "inside": (True,)}[regime]

    def on(self, inside: bool, v: np.ndarray, q: np.ndarray, kinds: Iterable[str] = ROWS) -> dict[str, np.ndarray]:
        """Evaluate the quantities of `ROWS`, or some of them, on arrays of equal shape."""
        return evaluated(self.averaged, inside, v, q, kinds)

    def scan(self, regime: str, q: np.ndarray, kinds: Iterable[str] = ROWS) -> dict[str, np.ndarray]:
        """Return the worst value of each kind over a grid of the belt speeds, shapes (n,)."""
        parts: dict[str, list[np.ndarray]] = {kind: [] for kind in kinds}
        for inside in self.sides(regime):
            low, high = (np.broadcast_to(e(q), q.shape)[:, None] for e in self.interval(regime, inside))
            kinks = np.abs(q[:, None, None] * [-1.0, 0.0, 1.0] + np.array(self.averaged.levels)[:, None])
            kinks = np.clip(kinks.reshape(q.size, -1), low, high)
            v = np.hstack([low + (high - low) * SHARES, kinks])
            for kind, values in self.on(inside, v, np.broadcast_to(q[:, None], v.shape), kinds).items():
                parts[kind].append(values.max(axis=1) if kind == "power" else values.min(axis=1))
        return {k: np.max(p, axis=0) if k == "power" else np.min(p, axis=0) for k, p in parts.items()}

    def worst(self, regime: str, q: float, kind: str = "damping") -> list[SpeedPoint]:
        """Return the local minima of the damping or the friction, maxima of the power, over the belt speeds.

        The worst comes first. Every interval between kinks is searched on a grid, and the low points that may
        contain the worst are polished.
        """
        groups = []
        for inside in self.sides(regime):
            edges = self._edges(regime, inside, q, kind)
            cells = [_cell(low, high, q) for low, high in itertools.pairwise(edges)]
            groups.append((inside, cells, lambda v, i=inside: self.on(i, v, np.full(v.shape, q), (kind,))[kind]))
        return worst_points(groups, kind, self.averaged.scale)

    def _edges(self, regime: str, inside: bool, q: float, kind: str) -> list[Edge]:
        """Return the ends of the interval and the kinks in it, in order."""
        low, high = self.interval(regime, inside)
        own = [Edge(level, 0.0) for level in self.averaged.levels] if kind == "friction" else []
        kinks = {edge(q): edge for edge in own if low(q) < edge(q) < high(q)}
        for level in self.averaged.levels:
            for side in (-1.0, 1.0):
                sign = 1.0 if level + side * q >= 0 else -1.0
                kink = Edge(sign * level, sign * side)
                if low(q) < kink(q) < high(q):
                    kinks[kink(q)] = kink
        return [low, *(kinks[v] for v in sorted(kinks)), high]


def evaluated(
    averaged: Averaged, inside: bool, v: np.ndarray, q: np.ndarray, kinds: Iterable[str] = ROWS
) -> dict[str, np.ndarray]:
    """Evaluate the quantities of `ROWS`, or some of them, at belt speeds and intensities of equal shape."""
    if set(kinds) == {"damping"}:
        values = {"damping": averaged.dampings[0 if inside else 1](v, q)}
    else:
        outputs = (averaged.inside if inside else averaged.outside)(v.reshape(1, -1), q.reshape(1, -1))
        values = {kind: np.array(outputs[ROWS[kind]]).reshape(v.shape) for kind in kinds}
    if not inside and averaged.falls_steeply and "damping" in values:
        values["damping"] = np.where(v <= q, -np.inf, values["damping"])
    return values


def worst_points(groups: list[tuple[bool, list[np.ndarray], Values]], kind: str, scale: float) -> list[SpeedPoint]:
    """Return the local minima of the damping or the friction, maxima of the power, the worst first.

    Parameters
    ----------
    groups : list of (bool, list of ndarray, callable)
        Whether the fast motion reverses the slip there; a grid for every interval between kinks; values at speeds.
    kind : str
        Of `ROWS`.
    scale : float
        Size of a damping.
    """
    sign, lows = -1.0 if kind == "power" else 1.0, []
    for inside, cells, values_at in groups:
        y = sign * values_at(np.concatenate(cells))
        size = np.max(np.abs(y[np.isfinite(y)]), initial=scale if kind == "damping" else 0.0)
        split = np.cumsum([c.size for c in cells])[:-1]
        for speeds, values in zip(cells, np.split(y, split), strict=True):
            lows += [(_Low(inside, *e), values_at) for e in _lows(speeds, values, 1e-13 * float(size))]
    least = min((low.value for low, _ in lows), default=np.inf)
    points = []
    for low, values_at in lows:
        at, value = low.v, low.value
        if low.reach <= least and low.ends[1] > low.ends[0]:
            at, value = _polished(low, values_at, sign)
        points.append(SpeedPoint(sign * value, at, low.inside))
    return sorted(points, key=lambda p: -p.value if kind == "power" else p.value)


def _polished(low: "_Low", values_at: Values, sign: float) -> tuple[float, float]:
    """Return the minimum between the neighbours of a low point, by successively finer grids."""
    best, (a, b) = (low.v, low.value), low.ends
    while b - a > _FINE * (low.ends[1] - low.ends[0]):
        v = np.linspace(a, b, _ZOOM)
        y = sign * values_at(v)
        k = int(np.argmin(y))
        if y[k] < best[1] - low.rounding:  # strictly lower, so that an end of the interval is kept
            best = float(v[k]), float(y[k])
        if (a, b) == (v[max(k - 1, 0)], v[min(k + 1, _ZOOM - 1)]):
            break
        a, b = v[max(k - 1, 0)], v[min(k + 1, _ZOOM - 1)]
    return best


@dataclass(frozen=True)
class _Low:
    """A local minimum on a grid, its neighbours, and a lower bound of the value between them."""

    inside: bool
    v: float
    value: float
    ends: tuple[float, float]
    reach: float
    rounding: float


def _cell(low: Edge, high: Edge, q: float) -> np.ndarray:
    """Return the grid of an interval between kinks.

    Kinks are excluded by a distance of 1e-12 q: the slope can be infinite on one side of them.
    """
    gap = 1e-12 * q
    a, b = (e(q) + side * gap * (e.rate != 0 and e.fixed != 0) for e, side in ((low, 1), (high, -1)))
    b = max(a, b)
    return a + (b - a) * SHARES if b > a else np.array([a])


def _lows(v: np.ndarray, y: np.ndarray, rounding: float) -> list[tuple[Any, ...]]:
    """Return the local minima of values on a grid: v, y, neighbours, lower bound and rounding error."""
    left, right = np.concatenate([[np.inf], y[:-1]]), np.concatenate([y[1:], [np.inf]])
    lows = []
    for k in np.flatnonzero((y <= left) & (y <= right)).tolist():
        a, b = max(k - 1, 0), min(k + 1, v.size - 1)
        highest = float(np.max(y[a : b + 1]))
        smooth = np.isfinite(y[k]) and highest > y[k] + rounding  # not a plateau
        ends = (float(v[a]), float(v[b])) if smooth else (float(v[k]), float(v[k]))
        lows.append((float(v[k]), float(y[k]), ends, float(2 * y[k] - highest) if smooth else np.inf, rounding))
    return lows
