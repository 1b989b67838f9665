"""Whether a step obeys the equations: its defect, looked at where an estimate from its beginning is blind."""

import numpy as np

from symfric.solve.native import call_code, compiled
from symfric.solve.taylor.powers import reach_of
from symfric.solve.taylor.settle import probe_trial
from symfric.solve.taylor.workspace import CHECKED, FORCES, LINEAR, N_Q, T_LOW, TOLERANCE

_LOOKS = 4  # parts of a step, in each of which a slip turns at most once: no step spans more than 4 rad of anything


@compiled(inline=True)
def reach(w, h, far):
    """Compute what a step of length h adds to the states, and by how much one of length `far` can change the guards."""
    w.step[0], w.step[1] = h, far
    if w.limits[LINEAR]:
        reach_of(w.c, h, far, w.y.size - 1, w.reach)
        return
    call_code(w.code[1], w.step.ctypes.data, w.c.ctypes.data, w.reach.ctypes.data)


@compiled(inline=True, fused=True)
def is_sound(w, n_x, tau):
    """Move the state on trial to the end of a step; return whether the polynomial obeys the equations on the way.

    A law that is flat far from rest and steep near it (tanh, a narrow Gauss or Stribeck law) can be zero to rounding in
    all coefficients at the beginning of a step; no error estimate at the beginning sees it. The defect does: at the
    end, in the middle, and wherever a contact slips most slowly.
    """
    if w.limits[CHECKED]:
        if not _obeys(w, n_x, 0.5 * tau):
            return False
        for i in range(w.sticks.size):
            if w.m[i] > 0.5:
                continue
            slip = w.c[n_x + 2 * i]
            falling, begin = slip[1] < 0.0, 0.0
            for k in range(1, _LOOKS + 1):
                end = tau * k / _LOOKS
                falls = slope(slip, end) < 0.0
                if falling and not falls and not _obeys(w, n_x, _turn(slip, begin, end)):
                    return False
                falling, begin = falls, end
        return _obeys(w, n_x, tau)
    _try_end(w, n_x, tau)
    return True


@compiled(inline=True, fused=True)
def _try_end(w, n_x, t):
    """Set the state on trial to that of the polynomial after the time t."""
    if t != w.step[0]:
        reach(w, t, t)
    for r in range(n_x):
        w.trial[r] = w.c[r, 0] + w.reach[r]


@compiled(fused=True)
def _obeys(w, n_x, t):
    """Return whether the rates of the polynomial after the time t are those of the equations."""
    _try_end(w, n_x, t)
    w.trial[n_x] = w.y[n_x] + (w.clock[T_LOW] + t)
    probe_trial(w)
    for r in range(w.limits[N_Q]):
        w.base[1, r], w.base[2, r] = w.probe[r, 1], w.probe[r, 2]
    floor = 0.0  # forces that hold each other leave accelerations of rounding
    for i in range(w.sticks.size):
        floor = max(floor, 1e-13 * w.gauge[FORCES, i])
    for r in range(w.limits[N_Q], n_x):
        rate, start, truth = slope(w.c[r], t), abs(w.c[r, 1]), w.probe[r, 1]
        w.base[1, r], w.base[2, r] = truth, w.probe[r, 2]
        scale = max(w.scale[r], start * t, abs(truth) * t)
        allowed = 50.0 * w.clock[TOLERANCE] * scale + t * (floor + 1e-12 * (start + abs(truth)))
        if abs(rate - truth) * t > allowed:
            return not abs(truth) < np.inf  # a singular point ends the step, and is left by `start_singular`
    return True


@compiled(fused=True)
def slope(c, t):
    """Evaluate the derivative of a polynomial."""
    rate = 0.0
    for k in range(c.size - 1, 0, -1):
        rate = rate * t + k * c[k]
    return rate


@compiled(fused=True)
def _turn(c, low, high):
    """Return about where a polynomial that falls at low and no longer at high turns."""
    for _ in range(16):
        middle = 0.5 * (low + high)
        if slope(c, middle) < 0.0:
            low = middle
        else:
            high = middle
    return high
