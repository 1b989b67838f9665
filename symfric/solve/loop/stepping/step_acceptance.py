"""Step acceptance: check that a step satisfies the equations where its coefficients do not show it.

A step of which nothing is unseen beyond the tolerance, as `enclosure` bounds it, holds if its defect is small at the
end, where that of a series is largest. Any other is cut into parts, which hold if nothing is unseen on them and if
their defect is small in the middle and at the end.
"""

import numpy as np

from symfric.codegen.numba_types import call_code, compiled
from symfric.solve.loop.arithmetic import box_of_step, defect_of_rate, defect_of_value, size_of_row, slope, value
from symfric.solve.loop.codes import REACH
from symfric.solve.loop.modes.tolerances import instant, natural_time
from symfric.solve.loop.precision import EPS
from symfric.solve.loop.statements import NOTHING, SLACK
from symfric.solve.loop.stepping.calls import bound_terms, bound_unseen, may_hide, probe_trial
from symfric.solve.loop.stepping.powers import reach_of
from symfric.solve.loop.workspace import LoopArrays

_PARTS = 400  # most parts of a step
_LEAST = 2.0**-12  # least length of a part, relative to the step
_WORTH = 2.0**-6  # least fraction of a step that is accepted instead of a new trial
_ROUNDING = 1e-13  # rounding error of a sum, relative to the magnitudes of its terms


@compiled(inline=True)
def reach(w: LoopArrays, h: float, far: float) -> None:
    """Compute the change of the states over a step h, and bounds of the change of the guards over `far`."""
    w.step.lengths[0], w.step.lengths[1] = h, far
    if w.limits.linear or w.code[REACH] == 0:
        reach_of(w.c, h, far, w.y.size - 1, w.step.reach)
        return
    call_code(w.code[REACH], w.step.lengths.ctypes.data, w.c.ctypes.data, w.step.reach.ctypes.data)


@compiled(inline=True, fused=True)
def proven(w: LoopArrays, n_x: int, tau: float) -> float:
    """Set the trial state to the end of a step of length tau; return the accepted length, or one to try."""
    if w.limits.checked and may_hide(w):
        return _proven(w, n_x, tau)
    try_end(w, n_x, tau)
    return tau


@compiled(fused=True)
def _proven(w: LoopArrays, n_x: int, tau: float) -> float:
    # late in a run the rounding of time counts for more than that of the terms, as functions of time among them show
    part = max(_ROUNDING, instant(w) / natural_time(w))
    if _hides_nothing(w, n_x, 0.0, tau, tau, part):
        return tau if _obeys(w, n_x, tau, tau, part) else 0.25 * tau
    begin, length = 0.0, 0.5 * tau
    _note_bends(w, n_x, tau)
    for _ in range(_PARTS):
        end = begin + length
        if end >= tau * (1.0 - 8.0 * EPS):
            end = tau
        if _hides_nothing(w, n_x, begin, end, tau, part):
            if not (_obeys(w, n_x, 0.5 * (begin + end), tau, part) and _obeys(w, n_x, end, tau, part)):
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
def _note_bends(w: LoopArrays, n_x: int, tau: float) -> None:
    """Bound the second derivative of every state over the step."""
    for r in range(n_x):
        bend = 0.0
        for k in range(w.c.shape[1] - 1, 1, -1):
            bend = bend * tau + k * (k - 1) * abs(w.c[r, k])
        w.step.bend[r] = bend


@compiled(fused=True)
def _hides_nothing(w: LoopArrays, n_x: int, begin: float, end: float, tau: float, part: float) -> bool:
    """Whether unseen features between two times of the step stay below the tolerance; `part` as in `_rounding`."""
    half = 0.5 * (end - begin)
    order, middle = w.c.shape[1] - 1, begin + half
    for r in range(n_x):
        if begin == 0.0 and end == tau:  # the whole step, which is cheaper and usually sufficient
            w.step.box[r], w.step.box[n_x + 1 + r] = box_of_step(w.c[r], order, tau)
            w.step.box[2 * n_x + 2 + r] = w.c[r, 1] * half
        else:
            change = slope(w.c[r], middle) * half
            w.step.box[r], w.step.box[2 * n_x + 2 + r] = value(w.c[r], order, middle), change
            w.step.box[n_x + 1 + r] = abs(change) + 0.5 * half * half * w.step.bend[r]
    w.step.box[n_x], w.step.box[2 * n_x + 1] = w.y[n_x] + (w.clock.t_low + middle), half
    w.step.box[3 * n_x + 2] = half
    bound_unseen(w)
    for e in range(w.tables.exposed.size):
        r = w.tables.exposed[e]
        if r < n_x:
            start = abs(w.c[r, 1])
            allowed = w.clock.tolerance * max(w.scale[r], start * tau) / (end - begin) + NOTHING
        else:
            allowed = w.clock.tolerance * size_of_row(w.scale[r], w.c[r, 0], w.c[r, 1], tau) + NOTHING
        if not w.step.unseen[r] <= allowed and not w.step.unseen[r] <= allowed + _rounding(w, r, part):
            return False
    return True


@compiled
def _rounding(w: LoopArrays, r: int, part: float) -> float:
    """Return the rounding error of row r, whose terms may cancel, while states and time stay in ``w.step.box``.

    It is a part of the magnitudes of these terms.
    """
    bound_terms(w)
    return part * w.step.terms[r] if w.step.terms[r] < np.inf else 0.0


@compiled(inline=True, fused=True)
def try_end(w: LoopArrays, n_x: int, t: float) -> None:
    """Set the trial state to the polynomial after the time t."""
    if t != w.step.lengths[0]:
        reach(w, t, t)
    for r in range(n_x):
        w.step.end[r] = w.c[r, 0] + w.step.reach[r]


@compiled(fused=True)
def _obeys(w: LoopArrays, n_x: int, t: float, tau: float, part: float) -> bool:
    """Whether rates and exposed rows of the polynomial after a time satisfy the equations; `part` as in `_rounding`."""
    try_end(w, n_x, t)
    w.step.end[n_x] = w.y[n_x] + (w.clock.t_low + t)
    note_rates(w)
    tolerance = SLACK * w.clock.tolerance
    for r in range(w.limits.n_q, n_x):
        rate, start, truth = slope(w.c[r], t), abs(w.c[r, 1]), w.probe[r, 1]
        allowed = defect_of_rate(w.scale[r], start, truth, t, tolerance)
        error = abs(rate - truth) * t
        if error > allowed and error > allowed + t * _rounding(w, r, part):
            if error <= allowed + t * _by_time(w, n_x, r, 1, truth):
                continue
            return not abs(truth) < np.inf  # a singular point ends the step; `start_singular` continues from it
    for e in range(w.tables.exposed.size):
        r = w.tables.exposed[e]
        if r < n_x:
            continue
        truth = w.probe[r, 0]
        error = abs(value(w.c[r], w.c.shape[1] - 1, t) - truth)
        allowed = defect_of_value(size_of_row(w.scale[r], w.c[r, 0], w.c[r, 1], tau), truth, tolerance)
        if error > allowed and error > allowed + _rounding(w, r, part) + abs(w.c[r, 1]) * instant(w):
            if error <= allowed + _by_time(w, n_x, r, 0, truth):
                continue
            return not abs(truth) < np.inf
    return True


@compiled
def _by_time(w: LoopArrays, n_x: int, r: int, order: int, truth: float) -> float:
    """Return the change of a coefficient of row r at the trial state by the rounding error of time.

    Where a small slip is the difference of velocities, one of them of a table that moves by itself, its direction
    changes by more than the terms tell, the more the faster the table.
    """
    time = w.step.end[n_x]
    w.step.end[n_x] = time + instant(w)
    probe_trial(w)
    change = abs(w.probe[r, order] - truth)
    w.step.end[n_x] = time
    probe_trial(w)
    return float(change) if change < np.inf else 0.0


@compiled(inline=True)
def note_rates(w: LoopArrays) -> None:
    """Compute rates and curvatures at the trial state, from where `start_singular` may have to go on."""
    probe_trial(w)
    for r in range(w.step.end.size - 1):
        w.step.base[1, r], w.step.base[2, r] = w.probe[r, 1], w.probe[r, 2]
