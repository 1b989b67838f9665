"""Replace the integrals inside an averaged law by Chebyshev series and short sums, which are cheap for the solvers.

The mean of a law over a fast vibration has no closed form in general. As a quadrature it is a hundred copies of the
law, each of which gets its own Taylor recurrence; as a function of the speed alone it is a short series.
"""

from collections.abc import Callable
from functools import lru_cache

import numpy as np
import sympy as sp

from symfric.lower.chebyshev import ACCURACY, RESOLVED, chebyshev
from symfric.model.laws import Law
from symfric.model.numeric import NODES, Rule, numeric_function
from symfric.model.symbols import SPEED

FINEST = 16 * NODES  # quadrature nodes from which the series are computed
SHORT = (4, 6, 8, 12)  # numbers of terms of the sums beyond the fast speed
BEYOND = (1.0, 1.1, 1.3, 1.6, 2.0, 3.0, 5.0)  # where they begin, relative to the fast speed
# relative distance on either side of an infinite slope bridged by a line; less makes high orders overflow
BRIDGE = 1e-9
_EDGE = 1e-12  # distance of an argument of acos from 1 that counts as zero at the end of an interval

_DISTANCE = sp.Dummy("distance", positive=True)


@lru_cache(maxsize=64)
def without_integrals(kinetic: sp.Expr) -> sp.Expr:
    """Replace the integrals of a law by short expressions with a relative error of about 1e-12.

    Parameters
    ----------
    kinetic : Expr
        In SPEED; an integral that holds other symbols or another integral is left as it is.

    Returns
    -------
    Expr
        With `ChebyshevSeries`; parts without a short series keep their integrals.
    """
    if any(e.function.has(sp.Integral) for e in kinetic.atoms(sp.Integral)):
        return kinetic
    return _walk(kinetic, 0.0, np.inf)


def _walk(e: sp.Expr, low: float, high: float) -> sp.Expr:
    """Replace the integrals of an expression used for low <= SPEED < high."""
    if not e.has(sp.Integral):
        return e
    if not e.free_symbols:
        return sp.Float(float(numeric_function((), e, FINEST)()))
    if isinstance(e, sp.Piecewise):
        return _branches(e, low, high)
    if not isinstance(e, sp.Add | sp.Integral):
        return e.func(*(_walk(a, low, high) for a in e.args))
    alone = [a for a in sp.Add.make_args(e) if a.free_symbols <= {SPEED}]
    others = [a for a in sp.Add.make_args(e) if not a.free_symbols <= {SPEED}]
    together = sp.Add(*alone)
    if together.has(sp.Integral):
        series = _bounded(together, low, high) if np.isfinite(high) else _unbounded(together, low)
        together = together if series is None else series
    return sp.Add(together, *(a if isinstance(a, sp.Integral) else _walk(a, low, high) for a in others))


def _branches(e: sp.Piecewise, low: float, high: float) -> sp.Expr:
    """Replace branch by branch; conditions must be upper bounds of the speed."""
    pieces, start = [], low
    for expr, condition in e.args:
        stop = high if condition == sp.true else _bound(condition)
        if stop is None:
            return e
        pieces.append((_walk(expr, start, min(stop, high)) if start < min(stop, high) else expr, condition))
        start = max(start, stop)
    return sp.Piecewise(*pieces)


def _bound(condition: sp.Basic) -> float | None:
    """Return b of ``SPEED < b``."""
    if isinstance(condition, sp.core.relational.Relational) and condition.lts == SPEED and condition.gts.is_number:
        return float(condition.gts)
    return None


def _bounded(e: sp.Expr, low: float, high: float) -> sp.Expr | None:
    from_low, from_high = _measured(e, low, 1), _measured(e, high, -1)

    def sample(above: np.ndarray, below: np.ndarray) -> np.ndarray:
        near = above < below
        return np.where(near, from_low(np.where(near, above, below)), from_high(np.where(near, above, below)))

    return chebyshev(sample, SPEED, low, high)


def _measured(e: sp.Expr, end: float, side: int) -> Callable[[np.ndarray], np.ndarray]:
    """Return the expression as a function of the distance from one end of an interval, NaN where inaccurate.

    An angle acos(x) that begins at the end, x = +-1, is taken as an arcsine of the root of the distance: the rounding
    of the speed would cost half the digits there.
    """
    changes = {}
    for angle in e.atoms(sp.acos, sp.asin):
        x = angle.args[0]
        slope = x.diff(SPEED)
        if x.free_symbols == {SPEED} and slope.is_number and slope != 0:
            at_end = float(x.subs(SPEED, end))
            if abs(abs(at_end) - 1) < _EDGE:
                away = 2 * sp.asin(sp.sqrt(abs(slope) * _DISTANCE / 2))
                turned = away if at_end > 0 else sp.pi - away
                changes[angle] = turned if isinstance(angle, sp.acos) else sp.pi / 2 - turned
    moved = e.xreplace(changes).subs(SPEED, end + side * _DISTANCE)

    def evaluate(distance: np.ndarray) -> np.ndarray:
        nodes, values = NODES, numeric_function((_DISTANCE,), moved, NODES)(distance)
        while nodes < FINEST:
            nodes, coarse = 2 * nodes, values
            values = numeric_function((_DISTANCE,), moved, nodes)(distance)
            scale = np.max(np.abs(values))
            if np.max(np.abs(values - coarse)) <= RESOLVED * scale:
                return values
        return np.where(np.abs(values - coarse) <= ACCURACY * scale, values, np.nan)

    return evaluate


def _unbounded(e: sp.Expr, low: float) -> sp.Expr | None:
    """Replace the integrals from `low` on by short sums, preceded by a series where the sums are not accurate."""
    distance = np.concatenate([[0.0], np.geomspace(1e-9, 1e3, 60)])
    true = _measured(e, low, 1)
    for factor in BEYOND:
        begin = low * factor
        speeds = np.maximum(begin, low + distance * low)
        exact = true(speeds - low)
        for n in SHORT:
            error = numeric_function((SPEED,), e, _periodic(n))(speeds) - exact
            if np.all(np.abs(error) <= 0.1 * ACCURACY * np.maximum(np.abs(exact[0]), np.abs(exact))):
                short = e.replace(lambda a: isinstance(a, sp.Integral), lambda a, n=n: _summed(a, *_periodic(n)))
                if begin == low:
                    return short
                near = _bounded(e, low, begin)
                return None if near is None else sp.Piecewise((near, begin > SPEED), (short, True))
    return None


def _periodic(n: int) -> Rule:
    """Return the midpoint rule in ``c = s^2 (3 - 2 s)``, which is exact to rounding where the integrand is periodic.

    That is the variable of `symfric.model.averaged_law`; over a whole period the angle is pi c.
    """
    # converges geometrically, see Trefethen and Weideman, SIAM Review 56 (2014)
    c = (np.arange(n) + 0.5) / n
    s = 0.5 - np.sin(np.arcsin(1 - 2 * c) / 3)
    return s, 1 / (6 * s * (1 - s) * n)


def _summed(integral: sp.Integral, places: np.ndarray, weights: np.ndarray) -> sp.Expr:
    ((variable, low, high),) = integral.limits
    terms = [
        integral.function.xreplace({variable: low + (high - low) * sp.Float(x)}) * w
        for x, w in zip(places, weights, strict=True)
    ]
    return (high - low) * sp.Add(*terms)


def bridged(law: Law) -> sp.Expr:
    """Return the kinetic coefficient without integrals, with a straight line across every speed in `steep`.

    The slope of an effective law behaves like 1/sqrt(q - v); a motion that hovers at v = q has no Taylor series there.
    """
    kinetic = without_integrals(law.kinetic)
    if not law.steep:
        return kinetic
    bridged = []
    for k, (expr, condition) in enumerate(kinetic.args):
        speed = next((s for s in law.steep if condition in (SPEED < s, s > SPEED)), None)
        if speed is None:
            bridged.append((expr, condition))
            continue
        above = kinetic.args[k + 1].expr
        begin, end = speed * (1 - BRIDGE), speed * (1 + BRIDGE) if _has_ends(above) else speed
        low, high = expr.subs(SPEED, begin), above.subs(SPEED, end)
        line = low + (high - low) * (SPEED - begin) / (end - begin)
        bridged += [(expr, SPEED < begin), (line, SPEED < end)]
    return sp.Piecewise(*bridged)


def _has_ends(expr: sp.Expr) -> bool:
    """Whether an expression may be defined on a part of the speeds only, because of inverse functions and roots."""
    roots = [e for e in expr.atoms(sp.Pow) if not e.exp.is_Integer and SPEED in e.base.free_symbols]
    return bool(roots or expr.atoms(sp.asin, sp.acos))
