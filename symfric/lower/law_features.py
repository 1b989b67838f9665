"""Locate narrow features of a friction law: speeds at which one of its derivatives changes its sign.

A search over speeds that starts from equally spaced ones misses a bump that is narrower than their distance. Here the
extrema of mu and of its first derivatives are enclosed by interval bounds and bisection, so that none is missed,
however narrow.
"""

import itertools
from collections.abc import Callable

import numpy as np
import sympy as sp
from scipy.optimize import brentq

from symfric.locks import SYMBOLIC, alone
from symfric.lower.speed_intervals import Unbounded, enclosure
from symfric.model.averaged_law import pieces_between
from symfric.model.laws import Law
from symfric.model.symbols import SPEED

ORDERS = (1, 2, 3, 4)  # orders of the derivatives whose zeros are features
_PANELS = 16  # initial number of intervals of a piece
_DEPTH = 45  # most bisections, down to rounding
_MANY = 20000  # most intervals at one depth; with more, the law oscillates everywhere and the search ends
_FLAT = 1e-9  # change over an interval, relative to the derivative's size, that is not a feature
_AWAY = {"DiracDelta": lambda x, order=0: 0.0 * x}  # zero away from kinks, which the bounds find separately
_APART = 1e-9  # distance relative to the range below which two zeros count as one


@alone(SYMBOLIC)
def features(law: Law, low: float, high: float, orders: tuple[int, ...] = ORDERS) -> np.ndarray:
    """Return the speeds in an interval at which derivatives of a law change their sign, and its breaks, increasing.

    Parameters
    ----------
    law : Law
        In numbers.
    low, high : float
        Speeds, 0 <= low < high.
    orders : tuple of int
        Of the derivatives.

    Returns
    -------
    ndarray
        Without `low` and `high` themselves. A law of a function without interval bounds has its breaks only.
    """
    breaks = [float(b) for b in law.breaks]
    edges = [0.0, *breaks, np.inf]
    places = [b for b in breaks if low < b < high]
    for piece, (left, right) in zip(pieces_between(law.kinetic, law.breaks), itertools.pairwise(edges), strict=True):
        a, b = max(left, low), min(right, high)
        if a < b:
            places += _of_piece(piece, a, b, orders)
    return _apart(np.sort(places), _APART * (high - low))


@alone(SYMBOLIC)
def narrow(law: Law, low: float, high: float, least: float) -> np.ndarray:
    """Return speeds that separate narrow features of a law from the rest of it, without breaks.

    Features closer together than `least` belong together. Of each such group the extrema of mu', its ends, and its ends
    moved outward by its width are returned: between these the law has no detail finer than the distance itself.
    """
    breaks = {float(b) for b in law.breaks}
    places, bends = features(law, low, high), features(law, low, high, orders=(2,))
    parts = []
    for group in np.split(places, np.flatnonzero(np.diff(places) >= least) + 1):
        if group.size > 1:
            width = group[-1] - group[0]
            ends = [group[0] - width, group[0], group[-1], group[-1] + width]
            parts += [v for v in ends if low < v < high]
            parts += [v for v in bends if group[0] < v < group[-1]]
    return np.array(sorted(set(parts) - breaks))


def _of_piece(mu: sp.Expr, low: float, high: float, orders: tuple[int, ...]) -> list[float]:
    speeds: list[float] = []
    slope = mu
    for order in range(1, max(orders) + 1):
        slope = sp.diff(slope, SPEED)
        if not slope.has(SPEED):
            break
        if order in orders:
            try:
                speeds += _zeros(slope, low, high)
            except Unbounded:
                return []
    return speeds


def _zeros(expr: sp.Expr, low: float, high: float) -> list[float]:
    """Return the zeros with a change of sign of an expression on one branch of a law."""
    value = sp.lambdify(SPEED, expr, [_AWAY, "scipy", "numpy"])
    bound, rise = enclosure(expr, SPEED), enclosure(sp.diff(expr, SPEED), SPEED)
    edges = np.linspace(low, high, _PANELS + 1)
    a, b = edges[:-1], edges[1:]
    size, places = 0.0, []
    for _ in range(_DEPTH):
        least, most = bound(a, b)
        with np.errstate(all="ignore"):
            here = np.abs(np.broadcast_to(value(0.5 * (a + b)), a.shape))
        size = max(size, float(np.max(here[np.isfinite(here)], initial=0.0)))
        reach = np.maximum(np.abs(least), np.abs(most))
        down, up = rise(a, b)
        kinked = np.isinf(down) | np.isinf(up)
        places += (0.5 * (a + b))[kinked & (b - a <= _APART * (high - low))].tolist()
        flat = np.where(kinked, b - a <= _APART * (high - low), reach * (b - a) <= _FLAT * size * (high - low))
        # an interval whose enclosure excludes zero holds none, one with a monotone function at most one (Moore, 1966)
        keep = ~((least > 0) | (most < 0) | flat)
        a, b, down, up = a[keep], b[keep], down[keep], up[keep]
        monotone = (down > 0) | (up < 0)
        places += [root for ends in zip(a[monotone], b[monotone], strict=True) for root in _root(value, *ends)]
        a, b = a[~monotone], b[~monotone]
        if not a.size or a.size > _MANY:
            break
        middle = 0.5 * (a + b)
        a, b = np.concatenate([a, middle]), np.concatenate([middle, b])
    return [v for v in places if low < v < high]


def _root(value: Callable[[float], float], a: float, b: float) -> list[float]:
    ends = float(value(a)), float(value(b))
    if not all(np.isfinite(ends)) or ends[0] * ends[1] > 0:
        return []
    if 0.0 in ends:
        return [a if ends[0] == 0 else b]
    return [float(brentq(value, a, b, xtol=1e-15 * b, rtol=1e-14))]


def _apart(speeds: np.ndarray, least: float) -> np.ndarray:
    if not speeds.size:
        return speeds
    return speeds[np.insert(np.diff(speeds) > least, 0, True)]
