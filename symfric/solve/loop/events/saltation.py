"""Saltation: derivatives of states, integrals and extremes across an event.

After an event without derivatives they are void, except those of extremes and values before it. Runs without
derivatives do not call these functions.
"""

import numpy as np

from symfric.codegen.array_table import Reals
from symfric.codegen.numba_types import call_code, compiled
from symfric.lower.cell_edges import ON_EDGE
from symfric.lower.constraint_forces import AT_BOUND
from symfric.lower.mode_layout import GAPS
from symfric.lower.planes import STARTS
from symfric.model.rows import INTEGRAL, RANGE
from symfric.solve.loop.arithmetic import value
from symfric.solve.loop.codes import JUMP
from symfric.solve.loop.events.crossings import jumped_across
from symfric.solve.loop.events.impacts import forget_closed
from symfric.solve.loop.events.polynomials import roots
from symfric.solve.loop.modes.feet_slips import has_one_way
from symfric.solve.loop.modes.layout import (
    backward,
    contact_of,
    direction,
    is_along_line,
    is_switch,
    sign,
    switch,
    way,
)
from symfric.solve.loop.modes.tolerances import natural_time
from symfric.solve.loop.precision import TIE
from symfric.solve.loop.workspace import LoopArrays

APART = 1e-6  # relative difference of event times up to which events count as simultaneous
# the same of feet of one body, which stop together: the times of slow stops have larger errors
_APART_OF_FEET = 1e-3
_LARGEST = 1e150  # derivative whose square is still a number
# A row that changes by more than this part of its size over less than this part of the run has no derivatives there.
_JUMPS, _INSTANT = 1e-6, 1e-11
_START = 1e-3  # part of a step that counts as its start


@compiled
def remember(w: LoopArrays, n_x: int) -> None:
    """Store the mode before an event, the guards hit, and whether the derivatives of its time are those of the last."""
    n_m, first = w.m.size, w.p.size
    for k in range(first):
        w.saltation.before[k] = w.p[k]
    for k in range(n_m):
        w.saltation.before[first + k] = w.m[k]
    for g in range(w.guards.hit.size):
        w.saltation.before[first + 2 * n_m + g] = w.guards.hit[g]
    last = _given(w)
    if last >= 0:
        w.saltation.before[last] = jumped_across(w, n_x)
        for s in range(w.limits.varied):
            w.saltation.before[last + 1 + s] = w.saltation.tau[s]
    for k in range(w.saltation.left.size):
        w.saltation.left[k] = w.y[k]


@compiled(inline=True)
def _given(w: LoopArrays) -> int:
    """Return where the derivatives of the time of an event before are told, -1 if the jump does not ask for them."""
    last = w.p.size + 2 * w.m.size + w.guards.hit.size
    return last if w.saltation.before.size - _of_impacts(w) - w.feet.limit.size > last else -1


@compiled(inline=True)
def _of_impacts(w: LoopArrays) -> int:
    """Return how many numbers tell the jump what contacts do in an impact."""
    return w.impacts.asked.size - w.p.size if w.openings.variable.size else 0


@compiled
def jump(w: LoopArrays, n_x: int, n_c: int, starting: bool) -> None:
    """Apply the saltation to all derivatives; count events without derivatives, and void values on them."""
    n_s, n_m, n_g, n_f = w.limits.varied, w.m.size, w.guards.hit.size, w.limits.followed
    n_y, first = n_x // (1 + n_s), w.wanted.kind.size - n_f * n_s
    for k in range(n_m):
        w.saltation.before[w.p.size + n_m + k] = w.m[k]
    n_k = _of_impacts(w)
    struck = w.saltation.before.size - n_k
    for k in range(n_k):
        w.saltation.before[struck + k] = w.impacts.asked[w.p.size + k]
    for k in range(w.feet.limit.size):
        w.saltation.before[struck - w.feet.limit.size + k] = w.feet.limit[k]
    if starting:
        forget_closed(w, struck)
    state = w.saltation.left.ctypes.data if w.saltation.left.size else w.y.ctypes.data
    call_code(w.code[JUMP], state, w.saltation.before.ctypes.data, w.saltation.after.ctypes.data)
    shifted = n_s * n_y
    gains = shifted + n_s
    slopes = gains + n_f * n_s
    slips = slopes + 2 * n_g
    if starting:
        _doubt_start(w, n_c, n_s, slips)
        _doubt_touches(w, slips + n_c * n_s)
    else:
        _doubt(w, n_x, n_c, slopes)
    for k in range(n_s * n_y):
        w.y[n_y + k] = w.saltation.after[k]
    if not has_derivatives(w, n_x):
        give_up_derivatives(w, n_x)
    void = np.nan if w.counts.doubts else 1.0
    if w.limits.edges:
        _doubt_edges(w, n_c, slips + n_c * n_s + w.openings.variable.size)
    for s in range(n_s):
        w.saltation.tau[s] = w.saltation.after[shifted + s]
    for e in range(n_f):
        for s in range(n_s):
            f = first + e * n_s + s
            if w.wanted.kind[e] == INTEGRAL:
                if w.y[n_x] + w.clock.t_low >= w.wanted.start[e]:
                    w.observed.total[f, 2] += w.saltation.after[gains + e * n_s + s]
            elif w.wanted.kind[e] == RANGE:
                for side in range(2):
                    if w.saltation.rise[e, side] != 0.0:
                        w.observed.total[f, side] += w.saltation.rise[e, side] * w.saltation.tau[s] * void
    w.saltation.rise[:] = 0.0  # another event of the same instant is no other end of the step


@compiled
def has_derivatives(w: LoopArrays, n_x: int) -> bool:
    """Whether all derivatives are numbers, small enough to go on with."""
    lost = 0
    for k in range(n_x // (1 + w.limits.varied), n_x):
        lost += not abs(w.y[k]) < _LARGEST
    return lost == 0


@compiled
def give_up_derivatives(w: LoopArrays, n_x: int) -> None:
    """Let the motion go on without derivatives, which are zero from here on, and marked as unknown."""
    for k in range(n_x // (1 + w.limits.varied), n_x):
        w.y[k], w.scale[k] = 0.0, 0.0
    w.counts.doubts += 1


@compiled
def _doubt(w: LoopArrays, n_x: int, n_c: int, slopes: int) -> None:
    """Count an event without derivatives: a graze, simultaneous events, or an immediately following one."""
    n_m, n_g, first, given = w.m.size, w.guards.hit.size, w.p.size, _given(w)
    changed, give_way = False, _feet_give_way(w)
    if give_way:  # the rate of their room, a part of the largest work of their forces
        rate = abs(w.saltation.after[w.saltation.after.size - 1])
        w.counts.doubts += rate * natural_time(w) <= (2.0 * w.clock.tolerance) ** 0.5
    for i in range(n_c):
        slipped, slips = w.saltation.before[first + i] < 0.5, w.m[i] < 0.5
        if slipped and w.m[i] == STARTS:  # it stopped and started at once
            w.counts.doubts += not has_one_way(w, n_c, i)
        changes = slipped != slips or (slips and w.saltation.before[first + direction(i, n_c)] != way(w, i))
        changed = changed or changes
        ended = changes and slipped and (w.selection.zero[i] or not w.counts.jumped)
        if ended and w.saltation.after[slopes + n_g + backward(i)] > _least_apart(w, i):  # it ended with another slip
            w.counts.doubts += 1
    for g in range(n_g):
        if w.saltation.before[first + 2 * n_m + g] == 0.0:
            continue
        if w.limits.first_opening <= g < w.limits.first_clock and w.impacts.struck[(g - w.limits.first_opening) // 2]:
            changed = True
            continue  # small bounces that die out are slow, and have derivatives
        if backward(n_c) <= g < w.limits.first_other:
            apart = is_switch(w, g) and w.contacts.step[g - switch(0, n_c)] != 0
            w.counts.doubts += apart and w.saltation.after[slopes + n_g + g] > APART
            continue
        if given >= 0 and w.saltation.before[given] != 0.0:
            continue  # its time is that of an event before
        # an exchange of constraints does not change the motion
        if is_along_line(w, g) and w.m[contact_of(g)] == AT_BOUND:
            continue
        if is_along_line(w, g) and (_only_passes(w, contact_of(g)) or _hands_on(w, contact_of(g))):
            continue
        if is_along_line(w, g) and give_way and w.saltation.before[first + contact_of(g)] > 0.5:
            continue
        slow = (
            abs(w.saltation.after[slopes + g]) * natural_time(w) <= (2.0 * w.clock.tolerance) ** 0.5 * w.scale[n_x + g]
        )
        least = _least_apart(w, contact_of(g)) if is_along_line(w, g) else APART
        if slow or w.saltation.after[slopes + n_g + g] > least:
            w.counts.doubts += 1
    if changed and w.counts.stall > 0:
        w.counts.doubts += 1


@compiled(inline=True)
def _least_apart(w: LoopArrays, i: int) -> float:
    """Return the difference of event times from which on the slip of contact i does not end together with others."""
    return _APART_OF_FEET if w.contacts.partner[i] >= 0 and w.contacts.depends[i] != 0 else APART


@compiled(inline=True)
def _only_passes(w: LoopArrays, i: int) -> bool:
    """Whether contact i slips in the plane, and its speed was zero up to the error of a step only."""
    return w.contacts.partner[i] >= 0 and w.m[i] == 0.0 and w.saltation.before[w.p.size + i] == 0.0


@compiled(inline=True)
def _feet_give_way(w: LoopArrays) -> bool:
    """Whether feet have reached their limit surface at this event."""
    found = False
    for k in range(w.feet.limit.size // 3):
        found = found or w.feet.limit[k] != 0.0
    return found


@compiled(inline=True)
def _hands_on(w: LoopArrays, i: int) -> bool:
    """Whether contact i, a foot that sticks on, has handed on a part of its force to others at its bound."""
    stuck = w.saltation.before[w.p.size + i] > 0.5 and w.m[i] > 0.5
    return w.contacts.partner[i] >= 0 and w.contacts.depends[i] != 0 and stuck


@compiled
def _doubt_start(w: LoopArrays, n_c: int, n_s: int, slips: int) -> None:
    """Count contacts that slip from zero slip although a direction of differentiation moves their start across it."""
    for i in range(n_c):
        if w.selection.zero[i] and w.m[i] < 0.5:
            for s in range(n_s):
                w.counts.doubts += w.saltation.after[slips + i * n_s + s] != 0.0


@compiled
def _doubt_touches(w: LoopArrays, off: int) -> None:
    """Count contacts that are closed at the start, or strike there, and that a direction of differentiation opens."""
    for k in range(w.openings.variable.size):
        touches = w.m[w.openings.variable[k]] < 0.5 or w.impacts.struck[k]
        w.counts.doubts += touches and w.saltation.after[off + k] > APART


@compiled
def _doubt_edges(w: LoopArrays, n_c: int, off: int) -> None:
    """Count contacts at rest on the edge of a cell that a direction of differentiation moves off it."""
    for j in range(w.contacts.edge.size):
        if w.contacts.edge[j] and abs(w.m[sign(j, n_c)]) == ON_EDGE:
            w.counts.doubts += w.saltation.after[off + w.contacts.edge[j] - 1] > APART


@compiled
def note_places(w: LoopArrays, e: int, tau: float, low: float, high: float) -> None:
    """Store where in the step (0 to 1) row e took new extremes, -1 if it did not, and its slope if at the end.

    Beyond 1 the place is unknown: the row changes at once, as the direction of a slip in the plane near its stop.
    ``w.roots.poly`` holds the row over the step, scaled to [0, 1]; `low` and `high` are the extremes before it.
    """
    order, change = w.c.shape[1] - 1, 0.0
    for k in range(1, order + 1):
        change += k * abs(w.roots.poly[k])
    for side in range(2):
        new, old = w.observed.total[e, side], low if side == 0 else high
        w.saltation.rise[e, side] = 0.0
        size = max(abs(new), w.scale[w.c.shape[0] - w.wanted.kind.size + e])
        w.observed.total[e, 2 + side] = _place(w, order, new) if abs(new - old) > 1e-14 * size else -1.0
        if w.observed.total[e, 2 + side] >= 0.0 and tau < _INSTANT * w.clock.t_end and change > _JUMPS * size:
            w.observed.total[e, 2 + side] = 2.0
        if w.observed.total[e, 2 + side] == 1.0:
            for k in range(order, 0, -1):
                w.saltation.rise[e, side] += k * w.roots.poly[k] / tau


@compiled
def _place(w: LoopArrays, order: int, target: float) -> float:
    """Return the place in [0, 1] where the polynomial ``w.roots.poly`` takes an extreme value."""
    if w.roots.poly[0] == target:
        return 0.0
    if value(w.roots.poly, order, 1.0) == target:
        return 1.0
    for k in range(order):
        w.roots.slope[k] = (k + 1) * w.roots.poly[k + 1]
    best, where = abs(w.roots.poly[0] - target), 0.0
    gap = abs(value(w.roots.poly, order, 1.0) - target)
    if gap < best:
        best, where = gap, 1.0
    for j in range(roots(w.roots.slope, order - 1, order, w.tables.bernstein, w.roots.stack, w.roots.places)):
        gap = abs(value(w.roots.poly, order, w.roots.places[j]) - target)
        if gap < best:
            best, where = gap, w.roots.places[j]
    return where


@compiled
def turn_lowest(w: LoopArrays, e: int) -> None:
    """Update the least local minimum of row e; ``w.roots.poly`` holds the row, scaled to [0, 1]."""
    order = w.c.shape[1] - 1
    w.observed.total[e, 2], w.observed.total[e, 3] = -1.0, -1.0
    change, bend = 0.0, 0.0
    for k in range(1, order + 1):
        change += abs(w.roots.poly[k])
        w.roots.slope[k - 1] = k * w.roots.poly[k]
    for k in range(1, order):
        bend += abs(w.roots.slope[k])
    if abs(w.roots.slope[0]) > bend or w.roots.poly[0] - change >= w.observed.total[e, 0]:
        return
    # the slip of a contact that has just been released starts from zero, and turns there by rounding only
    begins = e < GAPS * w.contacts.sticks.size and w.selection.old[e // GAPS] == 0
    for j in range(roots(w.roots.slope, order - 1, order, w.tables.bernstein, w.roots.stack, w.roots.places)):
        curve, at = 0.0, w.roots.places[j]
        for k in range(order - 1, 0, -1):
            curve = curve * at + k * w.roots.slope[k]
        here = value(w.roots.poly, order, at)
        rounding = begins and at < _START and abs(here) <= TIE * change
        if curve > 0.0 and here < w.observed.total[e, 0] and not rounding:
            w.observed.total[e, 0], w.observed.total[e, 2] = here, at


@compiled
def follow(w: LoopArrays, f: int, c: Reals, tau: float) -> None:
    """Evaluate derivative row f at the extremes of its row in this step."""
    e = w.wanted.follows[f]
    s = (f - w.wanted.kind.size) % w.limits.varied
    parent = w.c[w.c.shape[0] - w.wanted.kind.size + e]
    for side in range(2):
        place = w.observed.total[e, 2 + side]
        if place < 0.0:
            continue
        known = w.counts.doubts == 0 and place <= 1.0
        w.observed.total[f, side] = value(c, w.c.shape[1] - 1, place * tau) if known else np.nan
        if place == 0.0:  # a row that jumped at the event at the start of this step
            w.observed.total[f, side] += parent[1] * w.saltation.tau[s]
