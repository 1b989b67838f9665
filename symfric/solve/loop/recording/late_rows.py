"""Observables that are accumulated from a time on, over a step: of the step at that time, over its last part."""

from symfric.codegen.array_table import Reals
from symfric.codegen.numba_types import compiled
from symfric.model.rows import CROSSINGS, INTEGRAL
from symfric.solve.loop.arithmetic import area, summed
from symfric.solve.loop.events.polynomials import extend_range
from symfric.solve.loop.events.saltation import note_places
from symfric.solve.loop.recording.crossing_times import note_crossings
from symfric.solve.loop.workspace import LoopArrays


@compiled
def accumulate_late(w: LoopArrays, e: int, c: Reals, tau: float) -> None:
    """Update integral, range or crossings of row e over the part of a step after its time."""
    begin = max((w.wanted.start[e] - w.y[w.y.size - 1]) - w.clock.t_low, 0.0)
    kind, order, total = w.wanted.kind[e], w.c.shape[1] - 1, w.observed.total
    if begin > 0.0 and begin >= tau:  # nothing that derivatives could follow
        if kind == CROSSINGS:
            w.saltation.rise[e, 0], w.saltation.rise[e, 1] = -1.0, -1.0
        elif kind != INTEGRAL:
            total[e, 2], total[e, 3] = -1.0, -1.0
        return
    if kind == INTEGRAL:
        total[e, 2], total[e, 3] = summed(total[e, 2], total[e, 3], area(c, order, tau) - area(c, order, begin))
        return
    power, part = 1.0, begin / tau if begin > 0.0 else 0.0
    for k in range(order + 1):
        w.roots.poly[k] = c[k] * power
        power *= tau
    if kind == CROSSINGS:
        note_crossings(w, e, part, tau)
    else:
        _extend(w, e, part, tau)


@compiled
def _extend(w: LoopArrays, e: int, part: float, tau: float) -> None:
    """Extend the range of row e by the part of the step behind a place, and note where it was extended."""
    order, total = w.c.shape[1] - 1, w.observed.total
    _move_origin(w.roots.poly, order, part)
    low, high = total[e, 0], total[e, 1]
    total[e, 0], total[e, 1] = extend_range(
        w.roots.poly, order, low, high, w.tables.bernstein, w.roots.stack, w.roots.places, w.roots.slope
    )
    if e < w.limits.followed:
        note_places(w, e, tau * (1.0 - part), low, high)
        for side in range(2):
            place = total[e, 2 + side]
            if 0.0 <= place < 1.0:
                total[e, 2 + side] = part + place * (1.0 - part)


@compiled(fused=True)
def _move_origin(b: Reals, n: int, begin: float) -> None:
    """Replace a polynomial of degree n on [0, 1] by that of its part on [begin, 1], scaled to [0, 1]."""
    if begin == 0.0:
        return
    for i in range(n):  # Taylor shift by synthetic division
        for k in range(n - 1, i - 1, -1):
            b[k] += begin * b[k + 1]
    power = 1.0
    for k in range(n + 1):
        b[k] *= power
        power *= 1.0 - begin
