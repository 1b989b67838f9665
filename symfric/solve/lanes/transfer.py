"""From the workspace of an event loop to a lane, and back."""

from symfric.codegen.array_table import Matrix
from symfric.codegen.numba_types import compiled
from symfric.lower.cell_edges import ON_EDGE
from symfric.model.rows import FOLLOW, INTEGRAL, VALUES
from symfric.solve.lanes.arrays import LaneArrays
from symfric.solve.loop.codes import EXPAND, SEGMENT, SELECT
from symfric.solve.loop.modes.layout import is_load, sign, switch
from symfric.solve.loop.modes.tolerances import little
from symfric.solve.loop.recording.noted_values import next_due
from symfric.solve.loop.run_rules import WINDOW
from symfric.solve.loop.stepping.calls import measure
from symfric.solve.loop.stepping.step_acceptance import note_rates
from symfric.solve.loop.workspace import LoopArrays

# how a run may go on in a lane: it moves, a guard is at zero, it sticks, not at all
MOVES, BEGINS, STICKS, NOT = range(4)


@compiled
def readiness(b: LaneArrays, w: LoopArrays) -> int:
    """Return how a run may go on in a lane from here; not where something needs a second look."""
    if w.counts.phase != EXPAND or w.clock.h_last <= 0.0:
        return NOT
    n_c, begins = w.contacts.sticks.size, False
    for g in range(w.guards.fresh.size):
        if w.guards.slack[g] != 0.0 and not is_load(w, g):
            return NOT
        begins = begins or w.guards.fresh[g] != 0
    for i in range(n_c):
        if w.m[i] > 0.5 and w.guards.carries[i] == 0:  # held by others
            return NOT
    for j in range(w.contacts.edge.size):
        if abs(w.m[sign(j, n_c)]) == ON_EDGE or (w.contacts.edge[j] != 0 and w.guards.fresh[switch(j, n_c)] != 0):
            return NOT
    sticks = w.limits.sticker >= 0 and w.m[w.limits.sticker] > 0.5
    if b.kernels.selects_mode:
        return (NOT if begins else STICKS) if sticks else MOVES
    return STICKS if sticks else BEGINS if begins else MOVES


@compiled
def to_lane(b: LaneArrays, w: LoopArrays, block: Matrix, k: int) -> None:
    """Copy what a run is at into lane k."""
    at, n_x, n_c = b.kernels, b.kernels.n_x, w.contacts.sticks.size
    for i in range(n_x):
        block[i, k] = w.y[i]
        block[at.start + i, k] = w.start[i]
    block[at.t, k], block[at.t_low, k], block[at.h_last, k] = w.y[n_x], w.clock.t_low, w.clock.h_last
    block[at.end, k] = min(w.clock.t_end, w.inputs.times[w.counts.segment + 1])
    block[at.steps, k] = w.counts.steps
    block[at.mark_steps, k] = min(w.counts.mark_steps, w.limits.max_steps) - 1
    for r in range(w.scale.size):
        block[at.scale + r, k] = w.scale[r]
    for e in range(at.n_e):
        if at.follows:
            block[at.seen + e, k] = -1.0
        if w.wanted.kind[e] == VALUES:
            block[at.first + e, k], block[at.second + e, k] = next_due(w, e), 0.0
        elif w.wanted.kind[e] != FOLLOW:
            first = 2 if w.wanted.kind[e] == INTEGRAL else 0
            block[at.first + e, k], block[at.second + e, k] = w.observed.total[e, first], w.observed.total[e, first + 1]
    for i in range(w.aux.size):
        block[at.aux + i, k] = w.aux[i]
    for i in range(n_c):
        block[at.little + i, k] = little(w, i)
    if at.selects_mode:
        block[at.fresh, k] = w.guards.fresh[0]
        block[at.events, k], block[at.grazes, k] = w.counts.events, w.counts.grazes
        block[at.mark_events, k] = min(w.counts.mark_events + WINDOW, w.limits.max_events) - 1
        block[at.mode, k] = 0.0 if w.m[0] > 0.5 else w.m[1]
        block[at.way, k] = w.m[1]
        block[at.rest, k] = w.clock.rest
        for g in range(w.guards.other.size):
            block[at.other + g, k] = w.guards.other[g]
        for i in range(w.p.size):
            block[at.p + i, k] = w.p[i]
    else:
        for g in range(w.guards.fresh.size):
            block[at.fresh + g, k] = w.guards.fresh[g]
            if is_load(w, g):
                block[at.slack + g - w.limits.first_load, k] = w.guards.slack[g]


@compiled
def to_loop(b: LaneArrays, w: LoopArrays, block: Matrix, k: int, met: bool) -> None:
    """Copy lane k into the workspace of its run; `met` says whether it is at an event."""
    at, n_x = b.kernels, b.kernels.n_x
    for i in range(n_x):
        w.y[i] = block[i, k]
    w.y[n_x], w.clock.t_low, w.clock.h_last = block[at.t, k], block[at.t_low, k], block[at.h_last, k]
    advanced = block[at.steps, k] > w.counts.steps
    if advanced:
        w.counts.stall = 0
        for g in range(w.guards.fresh.size):
            w.guards.fresh[g] = 0
        for s in range(w.limits.varied):
            w.saltation.tau[s] = 0.0
    w.counts.steps = int(block[at.steps, k])
    for r in range(w.scale.size):
        w.scale[r] = block[at.scale + r, k]
    for e in range(at.n_e):
        if w.wanted.kind[e] != VALUES and w.wanted.kind[e] != FOLLOW:
            first = 2 if w.wanted.kind[e] == INTEGRAL else 0
            w.observed.total[e, first], w.observed.total[e, first + 1] = block[at.first + e, k], block[at.second + e, k]
        if at.follows and advanced and block[at.seen + e, k] != block[at.steps, k]:  # no new extreme in the last step
            w.saltation.rise[e, 0], w.saltation.rise[e, 1] = 0.0, 0.0
    for g in range(w.guards.hit.size):
        w.guards.hit[g] = 0
    w.counts.phase = EXPAND
    if met:
        w.guards.hit[int(block[at.which, k])] = 1
        w.counts.phase = SELECT
    elif block[at.t, k] >= block[at.end, k] and block[at.t, k] < w.clock.t_end:
        w.counts.phase = SEGMENT
    if at.selects_mode:
        _mode_to_loop(b, w, block, k)
    if w.limits.checked and advanced:
        for i in range(n_x + 1):
            w.step.end[i] = w.y[i]
        note_rates(w)


@compiled
def _mode_to_loop(b: LaneArrays, w: LoopArrays, block: Matrix, k: int) -> None:
    """Copy the mode that lanes have chosen."""
    at = b.kernels
    w.counts.events, w.counts.grazes = int(block[at.events, k]), int(block[at.grazes, k])
    w.m[0], w.m[1] = 1.0 if block[at.mode, k] == 0.0 else 0.0, block[at.way, k]
    w.guards.carries[0] = 1 if block[at.mode, k] == 0.0 else 0
    w.clock.rest = block[at.rest, k]
    for g in range(w.guards.fresh.size):
        w.guards.fresh[g], w.guards.slack[g] = 0, 0.0
        w.guards.other[g] = block[at.other + g, k]
    if block[at.fresh, k] > 0.0:  # the mode was selected after its step
        w.guards.fresh[0], w.counts.stall = 1, 1
    for i in range(w.aux.size):
        w.aux[i] = block[at.aux + i, k]
    measure(w, w.y, w.gauge)
