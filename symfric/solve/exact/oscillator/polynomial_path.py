"""Polynomials of the motion of an oscillator between events, for dense output."""

import numpy as np

from symfric.codegen.numba_types import compiled
from symfric.solve.exact.oscillator.closed_form import Flow, basis, integral
from symfric.solve.exact.oscillator.workspace import ORDER, OscillatorArrays

_LENGTH = 2.0  # length of a piece times the largest characteristic root that has not decayed
_DEAD = 1e-18


@compiled(ieee_division=True)
def keep(w: OscillatorArrays, f: Flow, tau: float) -> float:
    """Append the motion over the next tau; return the time up to which memory sufficed."""
    x, u, a = w.y[0], w.y[1], w.v.rate
    if w.m.still:
        _append(w, 0.0, tau)
        c = w.stored.path_c[w.counts.kept_steps - 1]
        c[0, 0], c[0, 1], c[1, 0] = x, u, u
        return tau
    fastest = abs(f.alpha) + f.r
    slow, fast = 0.0, 0.0
    if not f.swings and f.r > 0.0:
        slow, fast = (a - f.fast * u) / (2.0 * f.r), -(a - f.slow * u) / (2.0 * f.r)
    at = 0.0
    while at < tau:
        if w.counts.kept_steps >= w.stored.path_t.shape[0]:
            return at
        g, rate = basis(f, at)
        here = x + u * g + (a + f.C * u) * integral(f, at, g, rate) if at > 0.0 else x
        speed = u * rate + (a + f.C * u) * g
        slope = a * rate - f.K * u * g
        # once the fast root has decayed to rounding the pieces may be as long as the slow one allows
        alone = slow != 0.0 and abs(fast) * np.exp((f.fast - f.slow) * at) <= _DEAD * abs(slow)
        root = abs(f.slow) if alone else fastest
        h = min(tau - at, _LENGTH / root if root > 0.0 else tau)
        if tau - at - h < 1e-3 * h:  # no sliver at the end
            h = tau - at
        _append(w, at, h)
        c = w.stored.path_c[w.counts.kept_steps - 1]
        c[0, 0], c[1, 0], c[1, 1] = here, speed, f.slow * speed if alone else slope
        for k in range(2, ORDER + 1):
            if alone:
                c[1, k] = f.slow * c[1, k - 1] / k
            else:
                c[1, k] = -(f.C * c[1, k - 1] + f.K * c[1, k - 2] / (k - 1)) / k
        for k in range(1, ORDER + 1):
            c[0, k] = c[1, k - 1] / k
        at += h
    return tau


@compiled(ieee_division=True)
def _append(w: OscillatorArrays, at: float, h: float) -> None:
    """Append a new piece."""
    k = w.counts.kept_steps
    w.stored.path_t[k, 0], w.stored.path_t[k, 1] = w.y[2] + (w.clock.t_low + at), h
    w.stored.path_c[k] = 0.0
    if w.stored.path_m.shape[1]:
        w.stored.path_m[k, 0] = 0 if w.m.still else w.m.direction
    w.counts.kept_steps += 1
