"""Saltation: derivatives of states, integrals and extremes across an event.

After an event without derivatives they are void, except those of extremes and values before it. Runs without
derivatives do not call these functions.
"""

import numpy as np

from symfric.codegen.numba_types import call_code, compiled
from symfric.lower.cell_edges import ON_EDGE
from symfric.lower.constraint_forces import AT_BOUND
from symfric.model.outputs import INTEGRAL, RANGE
from symfric.solve.loop.layout import backward, contact_of, direction, is_along_line, sign, way
from symfric.solve.loop.polynomials import roots, value
from symfric.solve.loop.tolerances import natural_time
from symfric.solve.loop.workspace import JUMP

APART = 1e-6  # relative difference of event times up to which events count as simultaneous
_ROUNDING = 1e-13  # value of a row relative to its change over a step that is zero


@compiled
def remember(w):
    """Store the mode before an event, and the guards hit."""
    n_m, first = w.m.size, w.p.size
    for k in range(first):
        w.before[k] = w.p[k]
    for k in range(n_m):
        w.before[first + k] = w.m[k]
    for g in range(w.hit.size):
        w.before[first + 2 * n_m + g] = w.hit[g]
    for k in range(w.left.size):
        w.left[k] = w.y[k]


@compiled
def jump(w, n_x, n_c, starting):
    """Apply the saltation to all derivatives; count events without derivatives, and void values on them."""
    n_s, n_m, n_g, n_f = w.limits.varied, w.m.size, w.hit.size, w.limits.followed
    n_y, first = n_x // (1 + n_s), w.kind.size - n_f * n_s
    for k in range(n_m):
        w.before[w.p.size + n_m + k] = w.m[k]
    state = w.left.ctypes.data if w.left.size else w.y.ctypes.data
    call_code(w.code[JUMP], state, w.before.ctypes.data, w.after.ctypes.data)
    shifted = n_s * n_y
    gains = shifted + n_s
    slopes = gains + n_f * n_s
    slips = slopes + 2 * n_g
    if starting:
        _doubt_start(w, n_c, n_s, slips)
    else:
        _doubt(w, n_x, n_c, slopes)
    void = np.nan if w.counts.doubts else 1.0
    if w.limits.edges:
        _doubt_edges(w, n_c, slips + n_c * n_s)
    for k in range(n_s * n_y):
        w.y[n_y + k] = w.after[k]
    for s in range(n_s):
        w.tau[s] = w.after[shifted + s]
    for e in range(n_f):
        for s in range(n_s):
            f = first + e * n_s + s
            if w.kind[e] == INTEGRAL:
                w.total[f, 2] += w.after[gains + e * n_s + s]
            elif w.kind[e] == RANGE:
                for side in range(2):
                    if w.rise[e, side] != 0.0:
                        w.total[f, side] += w.rise[e, side] * w.tau[s] * void


@compiled
def _doubt(w, n_x, n_c, slopes):
    """Count an event without derivatives: a graze, simultaneous events, or an immediately following one."""
    n_m, n_g, first = w.m.size, w.hit.size, w.p.size
    changed = False
    for i in range(n_c):
        slipped, slips = w.before[first + i] < 0.5, w.m[i] < 0.5
        changes = slipped != slips or (slips and w.before[first + direction(i, n_c)] != way(w, i))
        changed = changed or changes
        if changes and slipped and w.after[slopes + n_g + backward(i)] > APART:  # its slip ended together with another
            w.counts.doubts += 1
    for g in range(n_g):
        if w.before[first + 2 * n_m + g] == 0.0 or backward(n_c) <= g < w.limits.first_other:
            continue
        # an exchange of constraints does not change the motion
        if is_along_line(w, g) and w.m[contact_of(g)] == AT_BOUND:
            continue
        slow = abs(w.after[slopes + g]) * natural_time(w) <= (2.0 * w.clock.tolerance) ** 0.5 * w.scale[n_x + g]
        if slow or w.after[slopes + n_g + g] > APART:
            w.counts.doubts += 1
    if changed and w.counts.stall > 0:
        w.counts.doubts += 1


@compiled
def _doubt_start(w, n_c, n_s, slips):
    """Count contacts that slip from zero slip although a direction of differentiation moves their start across it."""
    for i in range(n_c):
        if w.zero[i] and w.m[i] < 0.5:
            for s in range(n_s):
                w.counts.doubts += w.after[slips + i * n_s + s] != 0.0


@compiled
def _doubt_edges(w, n_c, off):
    """Count contacts at rest on the edge of a cell that a direction of differentiation moves off it."""
    for j in range(w.edge.size):
        if w.edge[j] and abs(w.m[sign(j, n_c)]) == ON_EDGE:
            w.counts.doubts += w.after[off + w.edge[j] - 1] > APART


@compiled
def note_places(w, e, tau, low, high):
    """Store where in the step (0 to 1) row e took new extremes, -1 if it did not, and its slope if at the end.

    ``w.poly`` holds the row over the step, scaled to [0, 1]; `low` and `high` are the extremes before it.
    """
    order = w.c.shape[1] - 1
    for side in range(2):
        new, old = w.total[e, side], low if side == 0 else high
        w.rise[e, side] = 0.0
        margin = 1e-14 * max(abs(new), w.scale[w.c.shape[0] - w.kind.size + e])
        w.total[e, 2 + side] = _place(w, order, new) if abs(new - old) > margin else -1.0
        if w.total[e, 2 + side] == 1.0:
            for k in range(order, 0, -1):
                w.rise[e, side] += k * w.poly[k] / tau


@compiled
def _place(w, order, target):
    """Return the place in [0, 1] where the polynomial ``w.poly`` takes an extreme value."""
    if w.poly[0] == target:
        return 0.0
    if value(w.poly, order, 1.0) == target:
        return 1.0
    for k in range(order):
        w.slope[k] = (k + 1) * w.poly[k + 1]
    best, where = abs(w.poly[0] - target), 0.0
    for j in range(roots(w.slope, order - 1, order, w.table, w.stack, w.found)):
        gap = abs(value(w.poly, order, w.found[j]) - target)
        if gap < best:
            best, where = gap, w.found[j]
    return where


@compiled
def turn_lowest(w, e):
    """Update the least local minimum of row e; ``w.poly`` holds the row, scaled to [0, 1]."""
    order = w.c.shape[1] - 1
    w.total[e, 2], w.total[e, 3] = -1.0, -1.0
    change, bend = 0.0, 0.0
    for k in range(1, order + 1):
        change += abs(w.poly[k])
        w.slope[k - 1] = k * w.poly[k]
    for k in range(1, order):
        bend += abs(w.slope[k])
    if abs(w.slope[0]) > bend or w.poly[0] - change >= w.total[e, 0]:
        return
    for j in range(roots(w.slope, order - 1, order, w.table, w.stack, w.found)):
        curve, at = 0.0, w.found[j]
        for k in range(order - 1, 0, -1):
            curve = curve * at + k * w.slope[k]
        here = value(w.poly, order, at)
        # where a contact has just been released its slip is zero and turns there by rounding only
        if curve > 0.0 and here < w.total[e, 0] and abs(here) > _ROUNDING * change:
            w.total[e, 0], w.total[e, 2] = here, at


@compiled
def follow(w, f, c, tau):
    """Evaluate derivative row f at the extremes of its row in this step."""
    e = w.follows[f]
    s = (f - w.kind.size) % w.limits.varied
    parent = w.c[w.c.shape[0] - w.kind.size + e]
    for side in range(2):
        place = w.total[e, 2 + side]
        if place < 0.0:
            continue
        w.total[f, side] = value(c, w.c.shape[1] - 1, place * tau) if w.counts.doubts == 0 else np.nan
        if place == 0.0:  # a row that jumped at the event at the start of this step
            w.total[f, side] += parent[1] * w.tau[s]
