r"""The motion :math:`y'' + C y' + K y = P` in closed form, for every sign of damping and stiffness, and its roots.

With g the solution for y = 0, y' = 1, P = 0 and G its integral, :math:`y = y_0 (g' + C g) + y_0' g + P G`. Where the
characteristic roots are real, their exponentials are never factored into cosh times exp(-C t/2), which overflows; near
critical damping they are not taken apart, which cancels.
"""

from typing import NamedTuple

import numpy as np

from symfric.codegen.numba_types import compiled

EPS = 2.0**-52
NEVER = np.inf
_APART = 0.5  # half difference of the characteristic roots times t, above which they are treated separately
_LEAST = 1e-300  # first step of an approach over the whole interval: where a rate overflows, its inverse is zero
_MANY = 1000  # half periods that are followed one by one
_TERMS = 30  # terms of the series of G, for |root| t < 2


class Flow(NamedTuple):
    """Constants of the solution of one equation."""

    K: float
    C: float
    alpha: float  # C/2
    r: float  # square root of |alpha^2 - K|
    swings: bool  # whether the characteristic roots are complex, -alpha +- i r
    slow: float  # larger real characteristic root
    fast: float  # smaller real characteristic root


@compiled(ieee_division=True)
def flow(K: float, C: float) -> Flow:
    """Return the constants of ``y'' + C y' + K y``."""
    alpha = 0.5 * C
    square = alpha * alpha - K
    r = np.sqrt(abs(square))
    if square < 0.0:
        return Flow(K, C, alpha, r, True, 0.0, 0.0)
    # the root of larger magnitude is a sum of one sign, the other follows from their product K: no cancellation, see
    # Higham, Accuracy and Stability of Numerical Algorithms, section 1.8
    if alpha >= 0.0:
        fast = -alpha - r
        slow = K / fast if fast < 0.0 else 0.0
    else:
        slow = r - alpha
        fast = K / slow
    return Flow(K, C, alpha, r, False, slow, fast)


@compiled(ieee_division=True)
def basis(f: Flow, t: float) -> tuple[float, float]:
    """Return g and g'."""
    z = f.r * t
    if f.swings:
        e = np.exp(-f.alpha * t)
        s = e * (np.sin(z) / f.r)
        return s, e * np.cos(z) - f.alpha * s
    if z < _APART:  # nearly equal roots: the difference of their exponentials cancels
        e = np.exp(-f.alpha * t)
        s = e * (np.sinh(z) / f.r if z > 0.0 else t)
        return s, e * np.cosh(z) - f.alpha * s
    a, b = np.exp(f.slow * t), np.exp(f.fast * t)
    return (a - b) / (2.0 * f.r), (f.slow * a - f.fast * b) / (2.0 * f.r)


@compiled(ieee_division=True)
def integral(f: Flow, t: float, g: float, slope: float) -> float:
    """Return G, the integral of g, from g and g' at t."""
    if abs(f.C) * t <= 1.5 and abs(f.K) * t * t <= 0.6:
        # here 1 - g' - C g cancels; the series is that of G'' + C G' + K G = 1
        total, a, b = 0.0, 0.0, 0.5 * t * t  # terms k and k + 1, with their powers of t
        for k in range(1, _TERMS):
            total += b
            a, b = b, -t * (f.C * b + f.K * t * a / (k + 1)) / (k + 2)
            if abs(a) + abs(b) <= 1e-18 * total:
                break
        return total + b
    if not f.swings and f.r * t >= _APART:
        return (_ramp(f.slow, t) - _ramp(f.fast, t)) / (2.0 * f.r)
    return (1.0 - slope - f.C * g) / f.K


@compiled(ieee_division=True)
def _ramp(root: float, t: float) -> float:
    return np.expm1(root * t) / root if root != 0.0 else t  # exact for small roots, too


@compiled(ieee_division=True)
def first_zero(f: Flow, value: float, slope: float) -> float:
    """Return the first t > 0 at which the free solution from (value, slope) is zero."""
    if f.swings:
        # y = exp(-alpha t) (value cos(r t) + q sin(r t))
        q = (slope + f.alpha * value) / f.r
        if value == 0.0:
            return np.pi / f.r if q != 0.0 else NEVER
        return (np.arctan2(value, -q) if value > 0.0 else np.arctan2(-value, q)) / f.r
    if value == 0.0:
        return NEVER
    below = slope - f.fast * value
    if below == 0.0:
        return NEVER
    # exp(2 r t) = 1 + 2 r z, of which t = z is left at critical damping
    z = -value / below
    if not z > 0.0:
        return NEVER
    x = 2.0 * f.r * z
    return z if x < 1e-17 else np.log1p(x) / (2.0 * f.r)


@compiled(ieee_division=True)
def reach(f: Flow, value: float, slope: float, level: float, t: float, end: float, tau_end: float) -> float:
    """Return the time at which the free solution from (value, slope), monotone on [t, end], passes `level`; else NEVER.

    Parameters
    ----------
    value, slope : float
        At time 0.
    t, end : float
        Interval; at t the solution is not beyond the level.
    tau_end : float
        Value at the end if it is known, else NaN.
    """
    g, rate = basis(f, t)
    y = value * (rate + f.C * g) + slope * g - level
    low, high, before = t, end, y
    if np.isnan(tau_end):
        g, rate = basis(f, end)
        tau_end = value * (rate + f.C * g) + slope * g
    after = tau_end - level
    if not abs(after) < np.inf:  # overflow: approach in doubled steps
        step = max(1.0 / (abs(f.alpha) + f.r), _LEAST * end)
        high = t
        while True:
            high = min(high + step, end)
            g, rate = basis(f, high)
            after = value * (rate + f.C * g) + slope * g - level
            if after * before < 0.0 or high >= end:
                break
            low, before, step = high, after, 2.0 * step
    if after == 0.0:
        return NEVER
    if before == 0.0 or (before > 0.0) == (after > before):
        return low  # already at the level, up to rounding
    if (after > 0.0) == (before > 0.0):
        return NEVER
    return _polish(f, value, slope, level, low, high, before, after)


@compiled(ieee_division=True)
def _polish(
    f: Flow, value: float, slope: float, level: float, low: float, high: float, before: float, after: float
) -> float:
    """Refine the only root between low and high by Newton's method, safeguarded by bisection."""
    part = before / (before - after)
    t = low + (high - low) * part if abs(after) < np.inf else 0.5 * (low + high)
    rising = after > 0.0
    for _ in range(200):
        if not low < t < high:
            t = 0.5 * (low + high)
            if not low < t < high:
                break
        g, rate = basis(f, t)
        y = value * (rate + f.C * g) + slope * g
        v = slope * rate - f.K * value * g
        miss = y - level
        if miss == 0.0:
            return t
        if (miss > 0.0) == rising:
            high = t
        else:
            low = t
        if v == 0.0:
            t = 0.5 * (low + high)
            continue
        step = -miss / v
        t += step
        # estimate of the next step: bend step^2
        if low <= t <= high and step * step * abs(f.C * v + f.K * y) <= EPS * t * abs(v):
            return t
    return high


@compiled(ieee_division=True)
def first_exit(f: Flow, value: float, slope: float, low: float, high: float, end: float) -> tuple[float, int]:
    """Return the time at which the free solution from (value, slope) leaves [low, high], and -1 or 1 for the end.

    A start on an end leaves at once if its velocity, or acceleration, points outward. NEVER if it stays until `end`.
    """
    way = slope if slope != 0.0 else -f.K * value
    if way == 0.0:
        return NEVER, 0
    up = way > 0.0
    if up and value >= high:
        return 0.0, 1
    if not up and value <= low:
        return 0.0, -1
    if low == 0.0 and high == np.inf:
        passed = first_zero(f, value, slope)
        return (passed, -1) if passed <= end else (NEVER, 0)
    t = 0.0
    turn = first_zero(f, slope, -f.C * slope - f.K * value)
    there = np.nan
    for k in range(1 << 40):
        level = high if up else low
        last = min(turn, end)
        if abs(level) < np.inf:
            passed = reach(f, value, slope, level, t, last, np.nan if last == end else there)
            if passed != NEVER:
                return passed, 1 if up else -1
        if turn >= end or (k == 1 and f.alpha >= 0.0):  # with damping no later turn is farther than these two
            return NEVER, 0
        if k == 0 and f.swings:
            g, rate = basis(f, turn)
            there = value * (rate + f.C * g) + slope * g
        t, up = turn, not up
        turn = turn + np.pi / f.r if f.swings else NEVER
        there = -there * np.exp(-f.alpha * np.pi / f.r) if f.swings else np.nan
        if k == _MANY:  # over most of the growth at once, a whole number of periods: the turns are as good as countless
            periods = _periods_left(f, there, low, high, end - turn)
            if not periods < NEVER:
                return NEVER, 0
            t, turn = t + periods * (2.0 * np.pi / f.r), turn + periods * (2.0 * np.pi / f.r)
            there *= np.exp(-f.alpha * (2.0 * np.pi / f.r) * periods)
    return NEVER, 0


@compiled(ieee_division=True)
def _periods_left(f: Flow, there: float, low: float, high: float, left: float) -> float:
    """Return how many periods a growing oscillation, now turning at `there`, surely stays in [low, high]; else NEVER.

    NEVER if it does so for all of the time that is left.
    """
    level = min(high, -low)
    if not level > abs(there):
        return 0.0
    time = np.log(level / abs(there)) / -f.alpha
    if not time < left:
        return NEVER
    return max(0.0, np.floor(time * f.r / (2.0 * np.pi)) - 2.0)
