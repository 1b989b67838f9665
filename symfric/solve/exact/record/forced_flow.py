"""An oscillator under a force that is linear in time: ``w' = f0 + f1 t - lam w - kappa u``, ``u' = w``.

Its series in time (phi functions) replaces the usual exponentials, which cancel for small damping, and needs no special
case for critical or zero damping.
"""

import numpy as np

from symfric.codegen.numba_types import compiled
from symfric.solve.exact.record.workspace import ORDER
from symfric.solve.loop.arithmetic import slope
from symfric.solve.loop.arithmetic import value as horner

EPS = 2.0**-52
NEAR = 1e-8  # last step of Newton's method, relative to the interval; the next one would be about its square
# entries of a transition: u and w from u, from w, from the force at the beginning, and from its slope
UU, UW, UF, UG, WU, WW, WF, WG, KAPPA = range(9)
_INVERSE = np.array([np.inf, *(1.0 / k for k in range(1, ORDER + 1))])


@compiled
def order_for(reach: float) -> int:
    """Return the order of the series that is exact to rounding where |root| t is at most `reach`."""
    term, order = 1.0, 0
    while order < ORDER and (term > 0.05 * EPS or order < 4):
        order += 1
        term *= reach / order
    return order


@compiled
def series(u: float, w: float, f0: float, f1: float, lam: float, kappa: float, cu: np.ndarray, cw: np.ndarray) -> None:
    """Compute the coefficients of u and w in powers of time."""
    cu[0], cw[0] = u, w
    cu[1], cw[1] = w, f0 - lam * w - kappa * u
    cu[2], cw[2] = 0.5 * cw[1], 0.5 * (f1 - lam * cw[1] - kappa * cu[1])
    for k in range(3, cu.size):
        cu[k] = cw[k - 1] * _INVERSE[k]
        cw[k] = -(lam * cw[k - 1] + kappa * cu[k - 1]) * _INVERSE[k]


@compiled
def value(c: np.ndarray, t: float) -> float:
    """Evaluate a polynomial, all of its coefficients."""
    return horner(c, c.size - 1, t)


@compiled
def bend(c: np.ndarray, t: float) -> float:
    """Evaluate the second derivative of a polynomial."""
    total = 0.0
    for k in range(c.size - 1, 1, -1):
        total = total * t + k * (k - 1) * c[k]
    return total


@compiled
def root(c: np.ndarray, level: float, low: float, high: float, derivative: bool) -> float:
    """Return the time at which a polynomial, or its derivative, passes a level, by safeguarded Newton's method.

    It starts where a straight line would pass: over a part of a sample the motion is nearly one.
    """
    f_low = (slope(c, low) if derivative else value(c, low)) - level
    f_high = (slope(c, high) if derivative else value(c, high)) - level
    near = NEAR * (high - low)
    t = low + (high - low) * (f_low / (f_low - f_high)) if f_low != f_high else low
    for _ in range(80):
        if not low < t < high:
            t = 0.5 * (low + high)
        f = (slope(c, t) if derivative else value(c, t)) - level
        if f == 0.0:
            return t
        if (f > 0.0) == (f_low > 0.0):
            low = t
        else:
            high = t
        rate = bend(c, t) if derivative else slope(c, t)
        step = f / rate if rate != 0.0 else np.inf
        if abs(step) <= near:
            return min(max(t - step, low), high)
        if high - low <= 4.0 * EPS * t:
            return t
        t -= step
    return t
