"""Instants at which an observable rises through zero, and their derivatives.

It does so where it becomes positive after it was negative, both by more than its rounding; the instant is the root in
between, or that of a jump.
"""

import numpy as np

from symfric.codegen.array_table import Reals
from symfric.codegen.numba_types import compiled
from symfric.solve.loop.arithmetic import value
from symfric.solve.loop.events.polynomials import polish, roots
from symfric.solve.loop.workspace import LoopArrays

_ROUNDING = 1e-12  # part of the variation of an observable that counts as zero


@compiled(fused=True)
def note_crossings(w: LoopArrays, e: int, begin: float, tau: float) -> None:
    """Store the first and the last time of upward crossings of row e, and count them.

    ``w.roots.poly`` holds the row over the step, scaled to [0, 1], of which the part from `begin` on counts. The last
    of the four numbers of a row is the sign that it had.
    """
    order, total, rise = w.c.shape[1] - 1, w.observed.total, w.saltation.rise
    rise[e, 0], rise[e, 1] = -1.0, -1.0
    change = 0.0
    for k in range(1, order + 1):
        change += abs(w.roots.poly[k])
        w.roots.slope[k - 1] = k * w.roots.poly[k]
    zero = _ROUNDING * max(change, w.scale[w.c.shape[0] - w.wanted.kind.size + e])
    low = value(w.roots.poly, order, begin)
    if low < -zero:
        total[e, 3] = -1.0
    elif low > zero:
        if total[e, 3] < 0.0:  # it jumped
            _note(w, e, begin, tau)
        total[e, 3] = 1.0
    if change < abs(w.roots.poly[0]):
        return
    n = roots(w.roots.slope, order - 1, order, w.tables.bernstein, w.roots.stack, w.roots.places)
    left = begin
    for j in range(n + 1):  # it rises or falls all the way from one turn to the next
        right = w.roots.places[j] if j < n else 1.0
        if right <= left:
            continue
        high = value(w.roots.poly, order, right)
        if high < -zero:
            total[e, 3] = -1.0
        elif high > zero:
            if total[e, 3] < 0.0:
                _note(w, e, polish(w.roots.poly, order, left, right, low, high) if low < 0.0 else left, tau)
            total[e, 3] = 1.0
        left, low = right, high


@compiled
def _note(w: LoopArrays, e: int, place: float, tau: float) -> None:
    time = (w.y[w.y.size - 1] + place * tau) + w.clock.t_low
    if w.observed.total[e, 2] == 0.0:
        w.observed.total[e, 0], w.saltation.rise[e, 0] = time, place
    w.observed.total[e, 1], w.saltation.rise[e, 1] = time, place
    w.observed.total[e, 2] += 1.0


@compiled(fused=True)
def follow_crossings(w: LoopArrays, f: int, c: Reals, tau: float) -> None:
    """Evaluate the derivatives of the times of crossings in this step by the derivative row f of their row.

    With the row g(t, p) they are -g_p / g_t; where g jumps at the event at which the step begins, those of the event.
    """
    e = w.wanted.follows[f]
    s = (f - w.wanted.kind.size) % w.limits.varied
    order, parent = w.c.shape[1] - 1, w.c[w.c.shape[0] - w.wanted.kind.size + e]
    for side in range(2):
        place = w.saltation.rise[e, side]
        if place < 0.0:
            continue
        if w.counts.doubts > 0:
            w.observed.total[f, side] = np.nan
            continue
        rate, size = 0.0, 0.0
        for k in range(order, 0, -1):
            rate = rate * (place * tau) + k * parent[k]
            size = max(size, abs(parent[k]) * tau ** (k - 1))
        at_event = place == 0.0 and (abs(rate) <= _ROUNDING * size or abs(parent[0]) > _ROUNDING * size * tau)
        w.observed.total[f, side] = w.saltation.tau[s] if at_event else -value(c, order, place * tau) / rate
