"""From the workspace of an event loop to a lane, and back."""

from symfric.codegen.numba_types import compiled
from symfric.model.outputs import INTEGRAL
from symfric.solve.loop.calls import measure
from symfric.solve.loop.run_arrays import EXPAND
from symfric.solve.loop.run_rules import WINDOW

MOVES, STICKS, NOT = range(3)  # whether a run may go on in a lane: in one that moves, in one that sticks, or not


@compiled
def readiness(b, w):
    """Return whether a run may go on in a lane from here: nothing has just happened that needs a second look."""
    if w.counts.phase != EXPAND or w.clock.h_last <= 0.0:
        return NOT
    for g in range(w.fresh.size):
        if w.fresh[g] != 0 or w.slack[g] != 0.0:
            return NOT
    if b.kernels.sticker >= 0 and w.m[b.kernels.sticker] > 0.5:
        return STICKS if b.kernels.stick != 0 else NOT
    return MOVES


@compiled
def to_lane(b, w, block, k):
    """Copy what a run is at into lane k."""
    at, n_x = b.kernels, b.kernels.n_x
    for i in range(n_x):
        block[i, k] = w.y[i]
        block[at.start + i, k] = w.start[i]
    block[at.t, k], block[at.t_low, k], block[at.h_last, k] = w.y[n_x], w.clock.t_low, w.clock.h_last
    block[at.end, k] = w.clock.t_end
    block[at.steps, k] = w.counts.steps
    block[at.mark_steps, k] = min(w.counts.mark_steps, w.limits.max_steps) - 1
    block[at.events, k], block[at.grazes, k] = w.counts.events, w.counts.grazes
    block[at.mark_events, k] = min(w.counts.mark_events + WINDOW, w.limits.max_events) - 1
    for r in range(w.scale.size):
        block[at.scale + r, k] = w.scale[r]
    for e in range(at.n_e):
        first = 2 if w.kind[e] == INTEGRAL else 0
        block[at.first + e, k], block[at.second + e, k] = w.total[e, first], w.total[e, first + 1]
    for i in range(w.aux.size):
        block[at.aux + i, k] = w.aux[i]
    if at.stick != 0:
        block[at.mode, k] = 0.0 if w.m[0] > 0.5 else w.m[1]
        block[at.way, k], block[at.fresh, k], block[at.little, k] = w.m[1], 0.0, 0.0
        block[at.rest, k] = w.clock.rest
        for g in range(w.other.size):
            block[at.other + g, k] = w.other[g]
        for i in range(w.p.size):
            block[at.p + i, k] = w.p[i]


@compiled
def to_loop(b, w, block, k):
    """Copy lane k into the workspace of its run."""
    at, n_x = b.kernels, b.kernels.n_x
    for i in range(n_x):
        w.y[i] = block[i, k]
    w.y[n_x], w.clock.t_low, w.clock.h_last = block[at.t, k], block[at.t_low, k], block[at.h_last, k]
    if block[at.steps, k] > w.counts.steps:
        w.counts.stall = 0
    w.counts.steps = int(block[at.steps, k])
    for r in range(w.scale.size):
        w.scale[r] = block[at.scale + r, k]
    for e in range(at.n_e):
        first = 2 if w.kind[e] == INTEGRAL else 0
        w.total[e, first], w.total[e, first + 1] = block[at.first + e, k], block[at.second + e, k]
    w.counts.phase = EXPAND
    if at.stick != 0:
        w.counts.events, w.counts.grazes = int(block[at.events, k]), int(block[at.grazes, k])
        w.m[0], w.m[1] = 1.0 if block[at.mode, k] == 0.0 else 0.0, block[at.way, k]
        w.carries[0] = 1 if block[at.mode, k] == 0.0 else 0
        w.clock.rest = block[at.rest, k]
        for g in range(w.fresh.size):
            w.fresh[g], w.slack[g], w.hit[g] = 0, 0.0, 0
            w.other[g] = block[at.other + g, k]
        if block[at.fresh, k] > 0.0:  # the event was settled after its step
            w.fresh[0], w.counts.stall = 1, 1
        for i in range(w.aux.size):
            w.aux[i] = block[at.aux + i, k]
        measure(w, w.y, w.gauge)
