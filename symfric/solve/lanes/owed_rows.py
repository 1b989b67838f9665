"""Observables rows of a step that a kernel has left, with the code of the event loop; see `.wanted_rows`."""

from collections.abc import Callable

from symfric.codegen.array_table import Matrix
from symfric.codegen.numba_types import compiled
from symfric.model.rows import FOLLOW, VALUES
from symfric.solve.lanes.arrays import LaneArrays
from symfric.solve.lanes.fields import LENGTH, NOTED, OWED_OF, TIME, TIME_LOW
from symfric.solve.loop.events.polynomials import extend_range
from symfric.solve.loop.events.saltation import follow, note_places
from symfric.solve.loop.recording.noted_values import next_due, note_values
from symfric.solve.loop.workspace import LoopArrays


@compiled
def pay(b: LaneArrays, loop_at: Callable[[int], LoopArrays], block: Matrix, which: int, lanes: int) -> int:
    """Do what is left to do for the rows of a step of some lanes; return about how many steps that took."""
    spent, n_e = 0, b.kernels.n_e
    for e in range(n_e):
        left = b.masks[OWED_OF + e] & lanes
        for k in range(b.state.size):
            if (left >> k) & 1:
                w = loop_at(b.tables[b.room_of[which, k], 0])
                _pay_one(b, w, block, e, k)
                spent += 1
    return spent


@compiled(fused=True)
def _pay_one(b: LaneArrays, w: LoopArrays, block: Matrix, e: int, k: int) -> None:
    order, first, second = w.c.shape[1] - 1, b.kernels.first + e, b.kernels.second + e
    row, tau = NOTED + e * (order + 2), b.notes[LENGTH, k]
    if w.wanted.kind[e] == VALUES:
        for j in range(order + 1):
            w.roots.poly[j] = b.notes[row + j, k]
        w.y[w.y.size - 1], w.clock.t_low = b.notes[TIME, k], b.notes[TIME_LOW, k]
        void = w.wanted.kind.size - e <= w.limits.followed * w.limits.varied and w.counts.doubts > 0
        note_values(w, e, w.roots.poly, order, tau, void)
        block[first, k] = next_due(w, e)
        return
    power = 1.0
    for j in range(order + 1):
        w.roots.poly[j] = b.notes[row + j, k] * power
        power *= tau
    low, high, r = block[first, k], block[second, k], w.roots
    ends = extend_range(r.poly, order, low, high, w.tables.bernstein, r.stack, r.places, r.slope)
    block[first, k], block[second, k] = ends
    if b.kernels.follows:
        _follow_one(b, w, block, e, k, low, high)


@compiled(fused=True)
def _follow_one(b: LaneArrays, w: LoopArrays, block: Matrix, e: int, k: int, low: float, high: float) -> None:
    """Evaluate the derivatives of a row at its new extremes, as `symfric.solve.loop.event_loop` does after a step."""
    order, n_e = w.c.shape[1] - 1, w.wanted.kind.size
    begin, tau = w.c.shape[0] - n_e, b.notes[LENGTH, k]
    w.scale[begin + e] = b.notes[NOTED + e * (order + 2) + order + 1, k]
    w.observed.total[e, 0], w.observed.total[e, 1] = block[b.kernels.first + e, k], block[b.kernels.second + e, k]
    if block[b.kernels.steps, k] > w.counts.steps + 1:  # this step does not begin at an event
        w.saltation.tau[:] = 0.0
    note_places(w, e, tau, low, high)
    block[b.kernels.seen + e, k] = block[b.kernels.steps, k]
    for r in range(n_e):
        if r == e or (w.wanted.kind[r] == FOLLOW and w.wanted.follows[r] == e):
            for j in range(order + 1):
                w.c[begin + r, j] = b.notes[NOTED + r * (order + 2) + j, k]
    for f in range(n_e):
        if w.wanted.kind[f] == FOLLOW and w.wanted.follows[f] == e:
            follow(w, f, w.c[begin + f], tau)
