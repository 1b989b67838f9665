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
from dataclasses import dataclass

import numpy as np
from scipy.optimize import minimize_scalar

from symfric.design.averaged import Averaged

_ENDS = np.logspace(-5, -1.1, 12)
ROWS = {"damping": 0, "power": 1, "friction": 3}  # which output of the averaged contact a condition looks at
SHARES = np.unique(np.concatenate([np.linspace(0, 1, 21), _ENDS, 1 - _ENDS]))  # of an interval, denser at its ends


@dataclass(frozen=True)
class Edge:
    """An end of an interval of belt speeds, ``fixed + rate * q``; intervals move with q."""

    fixed: float
    rate: float

    def __call__(self, q):
        """Return its place; q may be a float, an array or CasADi's."""
        return self.fixed + self.rate * q


@dataclass(frozen=True)
class Point:
    """A belt speed as the optimiser keeps it: a share of an interval between two kinks, which moves with q.

    Attributes
    ----------
    value : float
        Damping, mean power or share of the friction there.
    v, share : float
    inside : bool
    low, high : Edge
    """

    value: float
    v: float
    share: float
    inside: bool
    low: Edge
    high: Edge

    def at(self, q):
        """Return the belt speed at another q."""
        return self.low(q) + self.share * (self.high(q) - self.low(q))


@dataclass(frozen=True, eq=False)
class Range:
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

    def interval(self, regime: str, inside: bool) -> tuple[Edge, Edge]:
        """Return the ends of the inside or outside interval of belt speeds."""
        low, high, split = Edge(self.low, 0.0), Edge(self.high, 0.0), Edge(0.0, 1.0)
        if regime == "mixed":
            return (low, split) if inside else (split, high)
        return low, high

    def sides(self, regime: str) -> tuple[bool, ...]:
        """Return which of inside and outside there are."""
        return {"outside": (False,), "mixed": (True, False), "inside": (True,)}[regime]

    def on(self, inside: bool, v: np.ndarray, q: np.ndarray) -> dict[str, np.ndarray]:
        """Return what `ROWS` names on arrays of equal shape."""
        function = self.averaged.inside if inside else self.averaged.outside
        outputs = [np.array(e).reshape(v.shape) for e in function(v.reshape(1, -1), q.reshape(1, -1))]
        found = {kind: outputs[row] for kind, row in ROWS.items()}
        if not inside and self.averaged.falls_steeply:
            found["damping"] = np.where(v <= q, -np.inf, found["damping"])
        return found

    def scan(self, regime: str, q: np.ndarray) -> dict[str, np.ndarray]:
        """Return the worst of each kind over a grid of the belt speeds, shapes (n,)."""
        parts: dict[str, list[np.ndarray]] = {kind: [] for kind in ROWS}
        for inside in self.sides(regime):
            low, high = (np.broadcast_to(e(q), q.shape)[:, None] for e in self.interval(regime, inside))
            kinks = np.abs(q[:, None, None] * [-1.0, 0.0, 1.0] + np.array(self.averaged.levels)[:, None])
            kinks = np.clip(kinks.reshape(q.size, -1), low, high)
            v = np.hstack([low + (high - low) * SHARES, kinks])
            for kind, values in self.on(inside, v, np.broadcast_to(q[:, None], v.shape)).items():
                parts[kind].append(values.max(axis=1) if kind == "power" else values.min(axis=1))
        return {k: np.max(p, axis=0) if k == "power" else np.min(p, axis=0) for k, p in parts.items()}

    def worst(self, regime: str, q: float, kind: str = "damping") -> list[Point]:
        """Return the local minima of the damping or the friction, maxima of the power, over the belt speeds.

        The worst comes first. Every interval between kinks is searched on a grid, and each low point of it polished.
        """
        found = []
        for inside in self.sides(regime):
            for low, high in itertools.pairwise(self._edges(regime, inside, q, kind)):
                # kinks themselves are left out by a hair: the slope can be infinite on one of their sides
                hair = 1e-12 * q
                a, b = (e(q) + side * hair * (e.rate != 0 and e.fixed != 0) for e, side in ((low, 1), (high, -1)))
                for v, value in self._least(inside, q, a, max(a, b), kind):
                    width = high(q) - low(q)
                    share = (v - low(q)) / width if width > 0 else 0.0
                    found.append(Point(value, v, share, inside, low, high))
        return sorted(found, key=lambda p: -p.value if kind == "power" else p.value)

    def _edges(self, regime: str, inside: bool, q: float, kind: str) -> list[Edge]:
        """Return the ends of the interval and the kinks in it, in order; friction without excitation has its own."""
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

    def _least(self, inside: bool, q: float, a: float, b: float, kind: str) -> list[tuple[float, float]]:
        sign = -1.0 if kind == "power" else 1.0
        v = a + (b - a) * SHARES if b > a else np.array([a])
        y = sign * self.on(inside, v, np.full(v.shape, q))[kind]
        size = np.max(np.abs(y[np.isfinite(y)]), initial=self.averaged.scale if kind == "damping" else 0.0)
        rounding = 1e-13 * float(size)
        left, right = np.concatenate([[np.inf], y[:-1]]), np.concatenate([y[1:], [np.inf]])
        found = []
        for k in np.flatnonzero((y <= left) & (y <= right)):
            best = v[k], y[k]
            beside = y[max(k - 1, 0) : k + 2]
            if np.isfinite(y[k]) and np.max(beside) > y[k] + rounding:  # no plateau
                ends = v[max(k - 1, 0)], v[min(k + 1, v.size - 1)]
                polished = minimize_scalar(
                    lambda s: sign * self.on(inside, np.array([s]), np.array([q]))[kind][0],
                    bounds=ends,
                    method="bounded",
                    options={"xatol": 1e-9 * (ends[1] - ends[0])},
                )
                if polished.fun < y[k] - rounding:  # so that an end stays an end
                    best = float(polished.x), float(polished.fun)
            found.append((float(best[0]), sign * float(best[1])))
        return found
