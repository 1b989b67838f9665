"""Wanted rows of a step that a kernel has left, with the code of the event loop; see `.wanted_rows`."""

from symfric.codegen.numba_types import compiled
from symfric.model.outputs import FOLLOW, VALUES
from symfric.solve.lanes.fields import LENGTH, NOTED, OWED_OF, TIME, TIME_LOW
from symfric.solve.loop.noted_values import next_due, note_values
from symfric.solve.loop.polynomials import extend_range
from symfric.solve.loop.saltation import follow, note_places


@compiled
def pay(b, loop_at, block, which, lanes):
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
def _pay_one(b, w, block, e, k):
    order, first, second = w.c.shape[1] - 1, b.kernels.first + e, b.kernels.second + e
    row, tau = NOTED + e * (order + 2), b.notes[LENGTH, k]
    if w.kind[e] == VALUES:
        for j in range(order + 1):
            w.poly[j] = b.notes[row + j, k]
        w.y[w.y.size - 1], w.clock.t_low = b.notes[TIME, k], b.notes[TIME_LOW, k]
        void = w.kind.size - e <= w.limits.followed * w.limits.varied and w.counts.doubts > 0
        note_values(w, e, w.poly, order, tau, void)
        block[first, k] = next_due(w, e)
        return
    power = 1.0
    for j in range(order + 1):
        w.poly[j] = b.notes[row + j, k] * power
        power *= tau
    low, high = block[first, k], block[second, k]
    block[first, k], block[second, k] = extend_range(w.poly, order, low, high, w.table, w.stack, w.found, w.slope)
    if b.kernels.follows:
        _follow_one(b, w, block, e, k, low, high)


@compiled(fused=True)
def _follow_one(b, w, block, e, k, low, high):
    """Evaluate the derivatives of a row at its new extremes, as `symfric.solve.loop.event_loop` does after a step."""
    order, n_e = w.c.shape[1] - 1, w.kind.size
    begin, tau = w.c.shape[0] - n_e, b.notes[LENGTH, k]
    w.scale[begin + e] = b.notes[NOTED + e * (order + 2) + order + 1, k]
    w.total[e, 0], w.total[e, 1] = block[b.kernels.first + e, k], block[b.kernels.second + e, k]
    if block[b.kernels.steps, k] > w.counts.steps + 1:  # this step does not begin at an event
        w.tau[:] = 0.0
    note_places(w, e, tau, low, high)
    block[b.kernels.seen + e, k] = block[b.kernels.steps, k]
    for r in range(n_e):
        if r == e or (w.kind[r] == FOLLOW and w.follows[r] == e):
            for j in range(order + 1):
                w.c[begin + r, j] = b.notes[NOTED + r * (order + 2) + j, k]
    for f in range(n_e):
        if w.kind[f] == FOLLOW and w.follows[f] == e:
            follow(w, f, w.c[begin + f], tau)
