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
SHARES = np.unique(np.concatenate([np.linspace(0, 1, 21), _ENDS, 1 - _ENDS]))  # of an interval, denser at its ends


@dataclass(frozen=True)
class Point:
    """A belt speed as the optimiser keeps it: a share of the inside or outside interval, which moves with q.

    Attributes
    ----------
    value : float
        Damping or mean power there.
    v, share : float
    inside : bool
    """

    value: float
    v: float
    share: float
    inside: bool


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

    def interval(self, regime: str, inside: bool, q):
        """Return the ends of the inside or outside interval of belt speeds; q may be an array or CasADi's."""
        if regime == "mixed":
            return (self.low, q) if inside else (q, self.high)
        return self.low, self.high

    def sides(self, regime: str) -> tuple[bool, ...]:
        """Return which of inside and outside there are."""
        return {"outside": (False,), "mixed": (True, False), "inside": (True,)}[regime]

    def on(self, inside: bool, v: np.ndarray, q: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Return damping and power on arrays of equal shape."""
        function = self.averaged.inside if inside else self.averaged.outside
        damping, power, _ = (np.array(e).reshape(v.shape) for e in function(v.reshape(1, -1), q.reshape(1, -1)))
        if not inside and self.averaged.falls_steeply:
            damping = np.where(v <= q, -np.inf, damping)
        return damping, power

    def scan(self, regime: str, q: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Return the least damping and the largest power over the belt speeds of a grid, shapes (n,)."""
        least, most = np.full(q.size, np.inf), np.full(q.size, -np.inf)
        for inside in self.sides(regime):
            low, high = (np.broadcast_to(e, q.shape)[:, None] for e in self.interval(regime, inside, q))
            kinks = np.abs(q[:, None, None] * [-1.0, 1.0] + np.array(self.averaged.levels)[:, None])
            kinks = np.clip(kinks.reshape(q.size, -1), low, high)
            v = np.hstack([low + (high - low) * SHARES, kinks])
            damping, power = self.on(inside, v, np.broadcast_to(q[:, None], v.shape))
            least, most = np.minimum(least, damping.min(axis=1)), np.maximum(most, power.max(axis=1))
        return least, most

    def worst(self, regime: str, q: float, *, power: bool = False) -> list[Point]:
        """Return the local minima of the damping (maxima of the power) over the belt speeds, the worst first.

        Every interval between kinks is searched on a grid, and each low point of the grid polished.
        """
        found = []
        for inside in self.sides(regime):
            low, high = self.interval(regime, inside, q)
            kinks = {abs(level + side * q) for level in self.averaged.levels for side in (-1, 1)}
            edges = [low, *sorted(k for k in kinks if low < k < high), high]
            for a, b in itertools.pairwise(edges):
                for v, value in self._least(inside, q, a, b, power):
                    share = (v - low) / (high - low) if high > low else 0.0
                    found.append(Point(value, v, share, inside))
        return sorted(found, key=lambda p: -p.value if power else p.value)

    def _least(self, inside: bool, q: float, a: float, b: float, power: bool) -> list[tuple[float, float]]:
        sign, row = (-1.0, 1) if power else (1.0, 0)
        v = a + (b - a) * SHARES if b > a else np.array([a])
        y = sign * self.on(inside, v, np.full(v.shape, q))[row]
        rounding = 1e-13 * max(
            self.averaged.scale if not power else 0.0, float(np.max(np.abs(y[np.isfinite(y)]), initial=0))
        )
        left, right = np.concatenate([[np.inf], y[:-1]]), np.concatenate([y[1:], [np.inf]])
        found = []
        for k in np.flatnonzero((y <= left) & (y <= right)):
            best = v[k], y[k]
            if v.size > 1 and np.isfinite(y[k]):
                ends = v[max(k - 1, 0)], v[min(k + 1, v.size - 1)]
                polished = minimize_scalar(
                    lambda s: sign * self.on(inside, np.array([s]), np.array([q]))[row][0],
                    bounds=ends,
                    method="bounded",
                    options={"xatol": 1e-9 * (ends[1] - ends[0])},
                )
                if polished.fun < y[k] - rounding:  # so that an end stays an end
                    best = float(polished.x), float(polished.fun)
            found.append((float(best[0]), sign * float(best[1])))
        return found
