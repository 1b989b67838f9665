"""Step acceptance: check that a step satisfies the equations where its coefficients do not show it.

A step of which nothing is unseen beyond the tolerance, as `enclosure` bounds it, holds if its defect is small at the
end, where that of a series is largest. Any other is cut into parts, which hold if nothing is unseen on them and if
their defect is small in the middle and at the end.
"""

import numpy as np

from symfric.codegen.numba_types import call_code, compiled
from symfric.solve.loop.calls import bound_terms, bound_unseen, probe_trial
from symfric.solve.loop.polynomials import value
from symfric.solve.loop.powers import reach_of
from symfric.solve.loop.precision import EPS

_PARTS = 400  # most parts of a step
_LEAST = 2.0**-12  # least length of a part, relative to the step
_WORTH = 2.0**-6  # least fraction of a step that is accepted instead of a new trial
_NOTHING = 1e-150  # negligible size, such as the tail of a pulse that acts on a body at rest
_ROUNDING = 1e-13  # rounding error of a sum, relative to the magnitudes of its terms
_SLACK = 50.0  # largest defect at a checked point, in tolerances


@compiled(inline=True)
def reach(w, h, far):
    """Compute the change of the states over a step h, and bounds of the change of the guards over `far`."""
    w.step[0], w.step[1] = h, far
    if w.limits.linear or w.code[1] == 0:
        reach_of(w.c, h, far, w.y.size - 1, w.reach)
        return
    call_code(w.code[1], w.step.ctypes.data, w.c.ctypes.data, w.reach.ctypes.data)


@compiled(inline=True, fused=True)
def proven(w, n_x, tau):
    """Set the trial state to the end of a step of length tau; return the accepted length, or one to try."""
    if w.limits.checked:
        return _proven(w, n_x, tau)
    _try_end(w, n_x, tau)
    return tau


@compiled(fused=True)
def _proven(w, n_x, tau):
    if _hides_nothing(w, n_x, 0.0, tau, tau):
        return tau if _obeys(w, n_x, tau, tau) else 0.25 * tau
    begin, length = 0.0, 0.5 * tau
    _note_bends(w, n_x, tau)
    for _ in range(_PARTS):
        end = begin + length
        if end >= tau * (1.0 - 8.0 * EPS):
            end = tau
        if _hides_nothing(w, n_x, begin, end, tau):
            if not (_obeys(w, n_x, 0.5 * (begin + end), tau) and _obeys(w, n_x, end, tau)):
                break
            if end == tau:
                return tau
            begin = end
            length = min(2.0 * length, tau - begin)
        else:
            length *= 0.5
            if length < _LEAST * tau:
                break
    return begin if begin >= _WORTH * tau else 0.25 * tau


@compiled(inline=True, fused=True)
def _note_bends(w, n_x, tau):
    """Bound the second derivative of every state over the step."""
    for r in range(n_x):
        bend = 0.0
        for k in range(w.c.shape[1] - 1, 1, -1):
            bend = bend * tau + k * (k - 1) * abs(w.c[r, k])
        w.bend[r] = bend


@compiled(fused=True)
def _hides_nothing(w, n_x, begin, end, tau):
    """Whether unseen features between two times of the step stay below the tolerance."""
    half = 0.5 * (end - begin)
    order, middle = w.c.shape[1] - 1, begin + half
    for r in range(n_x):
        if begin == 0.0 and end == tau:  # the whole step, which is cheaper and usually sufficient
            step, rest = tau * w.c[r, 1], 0.0
            for k in range(order, 1, -1):
                rest = rest * tau + abs(w.c[r, k])
            w.box[r], w.box[n_x + 1 + r] = w.c[r, 0] + 0.5 * step, 0.5 * abs(step) + rest * tau * tau
        else:
            w.box[r] = value(w.c[r], order, middle)
            w.box[n_x + 1 + r] = abs(slope(w.c[r], middle)) * half + 0.5 * half * half * w.bend[r]
    w.box[n_x], w.box[2 * n_x + 1] = w.y[n_x] + (w.clock.t_low + middle), half
    bound_unseen(w)
    for e in range(w.exposed.size):
        r = w.exposed[e]
        if r < n_x:
            start = abs(w.c[r, 1])
            allowed = w.clock.tolerance * max(w.scale[r], start * tau) / (end - begin) + _NOTHING
        else:
            allowed = w.clock.tolerance * _size(w, r, tau) + _NOTHING
        if not w.unseen[r] <= allowed and not w.unseen[r] <= allowed + _rounding(w, r):
            return False
    return True


@compiled(inline=True, fused=True)
def _size(w, r, tau):
    """Return the scale of a guard or an observable."""
    return max(w.scale[r], abs(w.c[r, 0]), abs(w.c[r, 1]) * tau)


@compiled
def _rounding(w, r):
    """Return the rounding error of row r, whose terms may cancel, while states and time stay in ``w.box``."""
    bound_terms(w)
    return _ROUNDING * w.terms[r] if w.terms[r] < np.inf else 0.0


@compiled(inline=True, fused=True)
def _try_end(w, n_x, t):
    """Set the trial state to the polynomial after the time t."""
    if t != w.step[0]:
        reach(w, t, t)
    for r in range(n_x):
        w.trial[r] = w.c[r, 0] + w.reach[r]


@compiled(fused=True)
def _obeys(w, n_x, t, tau):
    """Whether rates and exposed rows of the polynomial after the time t satisfy the equations (small defect)."""
    _try_end(w, n_x, t)
    w.trial[n_x] = w.y[n_x] + (w.clock.t_low + t)
    note_rates(w)
    tolerance = _SLACK * w.clock.tolerance
    for r in range(w.limits.n_q, n_x):
        rate, start, truth = slope(w.c[r], t), abs(w.c[r, 1]), w.probe[r, 1]
        scale = max(w.scale[r], start * t, abs(truth) * t)
        allowed = tolerance * scale + t * (1e-12 * (start + abs(truth)) + _NOTHING)
        error = abs(rate - truth) * t
        if error > allowed and error > allowed + t * _rounding(w, r):
            return not abs(truth) < np.inf  # a singular point ends the step; `start_singular` continues from it
    for e in range(w.exposed.size):
        r = w.exposed[e]
        if r < n_x:
            continue
        truth = w.probe[r, 0]
        error = abs(value(w.c[r], w.c.shape[1] - 1, t) - truth)
        allowed = (tolerance + 1e-12) * max(_size(w, r, tau), abs(truth)) + _NOTHING
        if error > allowed and error > allowed + _rounding(w, r):
            return not abs(truth) < np.inf
    return True


@compiled(inline=True)
def note_rates(w):
    """Compute rates and curvatures at the trial state, from where `start_singular` may have to go on."""
    probe_trial(w)
    for r in range(w.trial.size - 1):
        w.base[1, r], w.base[2, r] = w.probe[r, 1], w.probe[r, 2]


@compiled(fused=True)
def slope(c, t):
    """Evaluate the derivative of a polynomial."""
    rate = 0.0
    for k in range(c.size - 1, 0, -1):
        rate = rate * t + k * c[k]
    return rate
