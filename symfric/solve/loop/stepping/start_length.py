"""How far series of a start in the plane are used: as the tolerance allows, and while slips keep their directions."""

import numpy as np

from symfric.codegen.numba_types import compiled
from symfric.lower.planes import STARTS, TURNS
from symfric.solve.loop.arithmetic import value
from symfric.solve.loop.codes import PULL, SLIP
from symfric.solve.loop.modes.layout import backward
from symfric.solve.loop.modes.tolerances import fastest
from symfric.solve.loop.precision import ROUNDING, TINY
from symfric.solve.loop.stepping.calls import measure
from symfric.solve.loop.stepping.step_acceptance import proven
from symfric.solve.loop.workspace import LoopArrays

_WITHIN = 0.9  # longest start, as part of the time to the next sample
# most lengths that are tried for slips to be straight, the next one relative to one that is too long, and most others
_SHORTENED, _LESS, _TRIALS = 12, 0.7, 40
_SAMPLES, _FALLEN = 16, 0.5  # places of a start where its slip is looked at; part of its largest to which it may fall


@compiled
def length_of_start(w: LoopArrays, n_x: int, order: int) -> float:
    """Return how far series of this order are used: slips keep their directions, and no pulse is passed over."""
    time = _length(w, n_x, order)
    least, longest = np.inf, time
    for _ in range(_SHORTENED):
        bend = max(_bend(w, n_x, 0.8 * longest), _bend(w, n_x, longest))
        if bend < least:
            least, time = bend, longest
        if bend <= 1.0:
            break
        longest *= _LESS
    for _ in range(_TRIALS):
        holds = _lasting(w, n_x, time)
        if holds == time:
            break
        time = holds
    for _ in range(_TRIALS):
        holds = proven(w, n_x, time)
        if holds == time:
            break
        time = holds
    return time


@compiled
def _length(w: LoopArrays, n_x: int, order: int) -> float:
    """Return how far the series of a start, of this order, is used.

    A slip counts as a vector: one of its rows may begin with a higher power of time than the other. So the velocities
    it depends on do not count by themselves, and places follow from velocities.
    """
    left, n_q = w.clock.t_end - w.y[n_x], w.limits.n_q
    to_sample = min(left, w.inputs.times[w.counts.segment + 1] - w.y[n_x])
    time = left
    for k in range(w.planes.row.size):
        i = w.planes.row[k]
        if w.m[i] == STARTS:
            time = min(time, _reach(w, n_x + backward(i), n_x + backward(i + 1), order))
    for r in range(n_q, n_x // (1 + w.limits.varied)):
        own = _reach(w, r, r, order)
        if own < time and not (r < 2 * n_q and _leads_to_slip(w, r)):
            time = own
    return min(time, _WITHIN * to_sample) if to_sample < left else min(time, left)


@compiled
def _reach(w: LoopArrays, one: int, other: int, order: int) -> float:
    """Return the time up to which the last term of two rows together is negligible, as the last two foretell it."""
    time, tolerance = np.inf, w.clock.tolerance
    size = max(w.scale[one], w.scale[other])
    for n in range(order - 1, order + 1):
        last = max(abs(w.c[one, n]), abs(w.c[other, n]))
        if last == 0.0:
            continue
        own = (size / last) ** (1.0 / n) * tolerance ** (1.0 / order)
        for k in range(1, n):
            radius = (max(abs(w.c[one, k]), abs(w.c[other, k])) / last) ** (1.0 / (n - k))
            own = max(own, radius * tolerance ** (1.0 / (order - k)))
        time = min(time, own)
    return time


@compiled
def _leads_to_slip(w: LoopArrays, r: int) -> bool:
    """Whether the slip of a contact that starts depends on velocity r."""
    velocity, leads = w.y[r], False
    for k in range(w.planes.row.size):
        i = w.planes.row[k]
        if w.m[i] != STARTS or leads:
            continue
        measure(w, w.y, w.gauge)
        one, other = w.gauge[SLIP, i], w.gauge[SLIP, i + 1]
        w.y[r] = velocity + 1.0 + abs(velocity)
        measure(w, w.y, w.gauge)
        w.y[r] = velocity
        leads = one != w.gauge[SLIP, i] or other != w.gauge[SLIP, i + 1]
    measure(w, w.y, w.gauge)
    return leads


@compiled
def _lasting(w: LoopArrays, n_x: int, time: float) -> float:
    """Return how much of a start its slips keep to their directions: behind their zero friction would push them on."""
    for k in range(w.planes.row.size):
        i, largest = w.planes.row[k], 0.0
        if w.m[i] != STARTS:
            continue
        for n in range(1, _SAMPLES + 1):
            t = time * n / _SAMPLES
            e, f, a, b = _slip_after(w, n_x, i, t)
            slip = e * a + f * b
            if slip <= _FALLEN * largest:
                return time * max(n - 1.0, 0.5) / _SAMPLES
            largest = max(largest, slip)
    return time


@compiled
def _bend(w: LoopArrays, n_x: int, t: float) -> float:
    """Return the largest velocity of a slip across its direction after a time t, relative to what is accepted."""
    size, largest = fastest(w), 0.0
    for k in range(w.planes.row.size):
        i = w.planes.row[k]
        if w.m[i] != STARTS:
            continue
        e, f, a, b = _slip_after(w, n_x, i, t)
        rounding = ROUNDING * t * max(w.gauge[PULL, i], w.gauge[PULL, i + 1])
        largest = max(largest, abs(a * f - b * e) / (w.clock.tolerance * max(size, np.hypot(a, b)) + rounding + TINY))
    return largest


@compiled
def _slip_after(w: LoopArrays, n_x: int, i: int, t: float) -> tuple[float, float, float, float]:
    """Return the direction and the slip of a contact that starts, after a time t."""
    order, v, e, f = w.c.shape[1] - 1, w.planes.variable[i], 0.0, 0.0
    for j in range(TURNS, -1, -1):
        e, f = e * t + w.m[v + 2 * j], f * t + w.m[v + 2 * j + 1]
    return e, f, value(w.c[n_x + backward(i)], order, t), value(w.c[n_x + backward(i + 1)], order, t)
