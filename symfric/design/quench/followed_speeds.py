"""The worst belt speed of a range where the excitation follows the belt: fast slip q = ratio * v_b.

At a ratio above 1 the fast motion reverses the slip at every belt speed, up to 1 at none; the ratio 1 itself belongs to
the second, and to the first as a limit, in which the damping is infinite.
"""

import itertools
from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np

from symfric.design.quench.averaged_damping import Averaged
from symfric.design.quench.worst_speed import ROWS, SHARES, SpeedPoint, evaluated, worst_points

_SLOWEST = 1e-9  # belt speed that stands for a belt at rest, relative to the highest
_GAP = 1e-12  # distance from a kink, relative to it, because the slope can be infinite on one side


@dataclass(frozen=True, eq=False)
class FollowedSpeeds:
    """Belt speeds [low, high] and the averaged contact on them, with the methods of `SpeedRange`; q is the ratio."""

    averaged: Averaged
    low: float
    high: float

    def regimes(self, q_min: float, q_max: float) -> dict[str, tuple[float, float]]:
        """Return the ratios of each regime within the bounds."""
        cut = {"outside": (q_min, min(q_max, 1.0)), "inside": (max(q_min, 1.0), q_max)}
        return {name: ends for name, ends in cut.items() if ends[0] <= ends[1]}

    def regime_of(self, q: float) -> str:
        """Return the regime of a ratio."""
        return "outside" if q <= 1 else "inside"

    def fast(self, q: float, v: float) -> float:
        """Return the amplitude of the fast slip at a belt speed."""
        return q * v

    def kinks_of(self, q: float) -> list[float]:
        """Return the belt speeds at which the averaged damping has a kink."""
        rates = [rate for rate in (1 - q, 1 + q) if rate != 0]
        return [level / rate for level in self.averaged.kinks for rate in rates if level / rate > 0]

    def scan(self, regime: str, q: np.ndarray, kinds: Iterable[str] = ROWS) -> dict[str, np.ndarray]:
        """Return the worst value of each kind over a grid of the belt speeds, shapes (n,)."""
        low, high = self._ends
        kinks = np.array([np.resize(self._kinks(ratio, "friction"), self._most) for ratio in q]).reshape(q.size, -1)
        v = np.hstack([np.broadcast_to(low + (high - low) * SHARES, (q.size, SHARES.size)), np.clip(kinks, low, high)])
        values = evaluated(self.averaged, regime == "inside", v, q[:, None] * v, kinds)
        return {k: y.max(axis=1) if k == "power" else y.min(axis=1) for k, y in values.items()}

    def worst(self, regime: str, q: float, kind: str = "damping") -> list[SpeedPoint]:
        """Return the local minima of the damping or the friction, maxima of the power; the worst comes first."""
        low, high = self._ends
        inside = regime == "inside"
        edges = [low, *(v for v in self._kinks(q, kind) if low < v < high), high]
        cells = [_cell(a, b) for a, b in itertools.pairwise(edges)]
        values_at = lambda v: evaluated(self.averaged, inside, v, q * v, (kind,))[kind]  # noqa: E731
        return worst_points([(inside, cells, values_at)], kind, self.averaged.scale)

    @property
    def _ends(self) -> tuple[float, float]:
        return max(self.low, _SLOWEST * self.high), self.high

    @property
    def _most(self) -> int:
        return 3 * len(self.averaged.levels)

    def _kinks(self, ratio: float, kind: str) -> list[float]:
        """Return the belt speeds at which v, v - q v or v + q v is at a level of the law, increasing."""
        rates = (1 - ratio, 1 + ratio, *([1.0] if kind == "friction" else []))
        speeds = {level / rate for level in self.averaged.levels for rate in rates if rate != 0 and level != 0}
        return sorted(v for v in speeds if v > 0) or [self.high]


def _cell(low: float, high: float) -> np.ndarray:
    """Return the grid of an interval between kinks."""
    a, b = low * (1 + _GAP), high * (1 - _GAP)
    return a + (b - a) * SHARES if b > a else np.array([0.5 * (low + high)])
