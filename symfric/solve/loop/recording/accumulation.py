"""Ranges, integrals and values of the observables over a step."""

from symfric.codegen.numba_types import compiled
from symfric.model.rows import CROSSINGS, FOLLOW, INTEGRAL, TURN, VALUES
from symfric.solve.loop.arithmetic import area, summed
from symfric.solve.loop.events.polynomials import extend_range
from symfric.solve.loop.events.saltation import follow, note_places, turn_lowest
from symfric.solve.loop.recording.crossing_times import follow_crossings
from symfric.solve.loop.recording.late_rows import accumulate_late
from symfric.solve.loop.recording.noted_values import note_values
from symfric.solve.loop.workspace import LoopArrays


@compiled(fused=True)
def accumulate(w: LoopArrays, first: int, tau: float) -> None:
    """Update ranges and integrals of the observables over a step."""
    order = w.c.shape[1] - 1
    for e in range(w.wanted.kind.size):
        c = w.c[first + e]
        if w.wanted.start[e] > 0.0 or w.wanted.kind[e] == CROSSINGS:
            accumulate_late(w, e, c, tau)
            continue
        if w.wanted.kind[e] == INTEGRAL:
            more, total = area(c, order, tau), w.observed.total
            total[e, 2], total[e, 3] = summed(total[e, 2], total[e, 3], more)
            continue
        if w.wanted.kind[e] == VALUES:
            void = w.wanted.kind.size - e <= w.limits.followed * w.limits.varied and w.counts.doubts > 0
            note_values(w, e, c, order, tau, void)
            continue
        if w.wanted.kind[e] == FOLLOW:
            if w.wanted.kind[w.wanted.follows[e]] == CROSSINGS:
                follow_crossings(w, e, c, tau)
            else:
                follow(w, e, c, tau)
            continue
        power = 1.0
        for k in range(order + 1):
            w.roots.poly[k] = c[k] * power
            power *= tau
        if w.wanted.kind[e] == TURN:
            turn_lowest(w, e)
            continue
        old_low, old_high = w.observed.total[e, 0], w.observed.total[e, 1]
        low, high = extend_range(
            w.roots.poly, order, old_low, old_high, w.tables.bernstein, w.roots.stack, w.roots.places, w.roots.slope
        )
        w.observed.total[e, 0], w.observed.total[e, 1] = low, high
        if e < w.limits.followed:
            note_places(w, e, tau, old_low, old_high)
