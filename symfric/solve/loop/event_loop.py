"""The event loop, compiled once for all models, whose machine code is called by address."""

import numpy as np

from symfric.codegen.numba_types import compiled, part
from symfric.lower.cell_edges import ON_EDGE
from symfric.model.outputs import FOLLOW, INTEGRAL, TURN, VALUES
from symfric.solve.loop.calls import expand, prelude
from symfric.solve.loop.layout import contact_of, is_along_line, is_load, is_slip, is_switch, mode, sign, switch
from symfric.solve.loop.mode_selection import keep_scales, settle
from symfric.solve.loop.noted_values import note_values
from symfric.solve.loop.polynomials import extend_range, first_crossing
from symfric.solve.loop.precision import EPS, TOUCH
from symfric.solve.loop.resting_edges import decisive, size_of
from symfric.solve.loop.run_arrays import EXPAND, GO, HIT, LOADED, SEGMENT, SETTLE
from symfric.solve.loop.run_rules import begin_counting, begin_values, budget, pause
from symfric.solve.loop.saltation import follow, jump, note_places, remember, turn_lowest
from symfric.solve.loop.singular_start import start_singular
from symfric.solve.loop.step_acceptance import proven, reach
from symfric.solve.loop.step_size import step_rule, step_size, weighted_rule, weighted_size
from symfric.solve.loop.tolerances import natural_time, no_acceleration
from symfric.solve.loop.transitions import transit
from symfric.solve.loop.workspace import (
    FORCES,
    TERMS,
)
from symfric.solve.status import PAUSED, Status

_OK, _COLLAPSE = int(Status.OK), int(Status.STEP_COLLAPSE)
_NAN, _LOST = int(Status.NOT_FINITE), int(Status.LOST_CONTACT)
_MANY_STEPS, _LEAST_PROGRESS = 20_000, 1e-9  # a run stands still if so many steps advance less than this fraction of it
_LEAST_STEP = 1e-24  # shortest step, relative to the run
# factor by which a step may be longer if an event or the end follows: at order 20 its error is three times as large,
# still below the tolerance, see MARGIN in `symfric.solve.taylor.route`
_STRETCH = 1.05


@part
def reset(w):
    """Start a run at t = 0 from the given state and parameters."""
    n_x, n_c, n_p = w.given_y.size, w.sticks.size, w.given_p.size
    for i in range(n_x):
        w.y[i] = w.given_y[i]
    w.y[n_x] = 0.0
    for k in range(w.p.size):
        w.p[k] = w.given_p[k] if k < n_p else w.segment_p[0, k - n_p]
    for k in range(w.m.size):
        w.m[k] = 0.0 if k < n_c or k >= w.limits.first_variable else 1.0
    begin_counting(w)
    w.scale[:] = 0.0
    w.other[:] = 0.0
    w.carries[:] = 0
    w.start[:] = 0.0
    w.hit[:] = 0
    w.fresh[:] = 0
    w.slack[:] = 0.0
    for r in range(n_x):
        w.base[1, r], w.base[2, r] = 0.0, 0.0
    for e in range(w.kind.size):
        w.total[e, 0], w.total[e, 1], w.total[e, 3] = np.inf, -np.inf, 0.0
        w.total[e, 2] = 0.0
        w.rise[e, 0], w.rise[e, 1] = 0.0, 0.0
    begin_values(w)
    w.tau[:] = 0.0
    w.rest[:] = 0.0


@part
def drive(w):
    """Integrate from the state in ``w.y`` to ``w.clock.t_end``; return a status, or a code to call again."""
    n_x, n_c = w.y.size - 1, w.sticks.size
    stop = w.counts.steps + w.limits.chunk
    rule, rule_weighted = step_rule(w), weighted_rule(w)
    while True:
        if w.y[n_x] >= w.clock.t_end:
            return _OK
        status = pause(w, stop, n_c + w.other_guards.shape[0])
        if status != _OK:
            return status
        if w.counts.steps >= w.counts.mark_steps:
            if w.y[n_x] - w.clock.mark_steps_t < _LEAST_PROGRESS * w.clock.t_end:
                return _COLLAPSE
            w.counts.mark_steps, w.clock.mark_steps_t = w.counts.steps + _MANY_STEPS, w.y[n_x]
        if w.counts.phase == SEGMENT:
            _next_segment(w)
        if w.counts.phase == SETTLE:
            status = _switch(w, n_x, n_c)
            if status != _OK:
                return status
            if w.limits.apart:
                return PAUSED
        if w.counts.phase == EXPAND:
            expand(w)
            w.counts.phase = GO
        h = step_size(w, n_x, rule)
        if not h > 0.0:
            status = start_singular(w, n_x, n_c)
            if status != _OK:
                return status
            continue
        if w.limits.exact > 0:
            h = weighted_size(w, n_x, h, rule_weighted)
        limit = min(w.clock.t_end, w.segment_t[w.counts.segment + 1])
        left = (limit - w.y[n_x]) - w.clock.t_low
        last = h * _STRETCH >= left
        if last:
            h = left
        tau = _first_event(w, n_x, n_c, h, h if last else h * _STRETCH)
        while tau > 0.0:
            holds = proven(w, n_x, tau)
            if holds == tau:
                break
            if tau <= max(16.0 * EPS * w.y[n_x], _LEAST_STEP * w.clock.t_end):
                return _COLLAPSE
            last, h = False, holds
            tau = _first_event(w, n_x, n_c, h, h)
        if tau < h:
            last = False
        elif not last and h <= 2.0 * EPS * abs(w.y[n_x]):
            return _COLLAPSE
        if tau > 0.0:
            _advance(w, n_x, n_c, tau)
        for i in range(n_x):
            if not abs(w.y[i]) < np.inf:
                return _NAN
        if w.clock.rest >= 0.0 and _drifts(w):
            w.clock.rest = np.nan
        if last:
            w.y[n_x], w.clock.t_low = limit, 0.0
            if limit < w.clock.t_end:
                w.counts.phase = SEGMENT
                continue
        w.counts.phase = SETTLE if w.counts.flagged else EXPAND
        if w.counts.flagged == LOADED:
            return _LOST


@compiled(fused=True)
def _drifts(w):
    """Whether something moves that no contact holds, by more than rounding; its velocity may have begun with zero."""
    n_q, size = w.limits.n_q, 0.0
    for i in range(n_q):
        size = max(size, w.scale[i] / w.clock.t_end, w.scale[n_q + i])
    fastest = 0.0
    for i in range(n_q, 2 * n_q):
        fastest = max(fastest, abs(w.y[i]))
    return fastest > w.clock.tolerance * size


@compiled(fused=True)
def _first_event(w, n_x, n_c, h, far):
    """Return the time to the first guard that becomes negative within `far`, else h; mark it in ``w.hit``."""
    n_g = w.hit.size
    w.counts.flagged = 0
    reach(w, h, far)
    tau, which = far, -1
    for g in range(n_g):
        w.hit[g] = 0
        r = n_x + g
        total = w.reach[r]
        begin = w.c[r, 0]
        begin += w.slack[g]
        if is_load(w, g):
            begin += TOUCH * w.clock.tolerance * max(w.scale[r], total)  # may have been zero so far
        if w.fresh[g] == 0 and begin > total:
            continue
        size = w.scale[r]
        if is_along_line(w, g) and w.carries[contact_of(g)] == 0:  # held by other contacts, up to rounding
            i = contact_of(g)
            if w.m[i] > 0.5:
                size = 8.0 * max(size, w.gauge[TERMS, i] + w.gauge[FORCES, i] * far)
            elif w.fresh[g] and is_slip(g):
                size = max(size, w.gauge[FORCES, i] * far)
        j = g - switch(0, n_c)
        if is_switch(w, g) and abs(w.m[sign(j, n_c)]) == ON_EDGE:  # stays at zero, up to rounding
            moved = far * (size_of(w, n_c, j, 1) + far * size_of(w, n_c, j, 2))
            size = 8.0 * max(size, moved)
        if total + abs(begin) <= 8.0 * EPS * size:
            continue  # zero throughout, up to rounding
        near = min(far, max(tau * (1.0 + 8.0 * EPS), 1e-3 * far))  # later crossings are not needed
        t = _crossing(w, r, g, begin, total, near)
        if t < tau:
            tau, which = t, g
        elif which >= 0 and t <= tau * (1.0 + 4.0 * EPS):
            w.hit[g] = 1
    if which >= 0:
        w.hit[which] = 1
        for g in range(which):
            if w.hit[g]:  # a previous candidate that is later
                w.hit[g] = 0
        w.counts.flagged = LOADED if is_load(w, which) else HIT
        return tau
    return h


@compiled(fused=True)
def _crossing(w, r, g, begin, total, h):
    """Return the time at which guard row r becomes negative, more than h if it does not."""
    order = w.c.shape[1] - 1
    first = 0
    if w.fresh[g]:
        first = 1
        slips = is_along_line(w, g) and is_slip(g)
        if slips:  # at a release the slip acceleration is zero up to rounding, for any step length
            first = 2 if abs(w.c[r, 1]) <= no_acceleration(w, contact_of(g), 2.0 * w.c[r, 2]) else 1
        elif is_switch(w, g):  # as in mode selection, for any step length
            first = decisive(w, w.c, r, g - switch(0, w.sticks.size), w.sticks.size, natural_time(w))
        if total == 0.0:
            return 2.0 * h
        power = h**first
        while first < order and abs(w.c[r, first]) * power <= 1e-13 * total and not (slips and first == 1):
            first += 1
            power *= h
        begin = w.c[r, first]
        total /= power
        if begin < 0.0:
            return 0.0
    elif begin < 0.0 or (begin <= 2.0 * EPS * w.scale[r] and w.c[r, 1] < 0.0):
        return 0.0
    if first == order:
        return 2.0 * h
    return first_crossing(w.c[r, first:], order - first, h, begin, total, w.table, w.stack, w.found, w.poly)


@compiled(inline=True, fused=True)
def _advance(w, n_x, n_c, tau):
    """Advance the state over the step, store the trajectory and observables, and update the scales."""
    order = w.c.shape[1] - 1
    if w.limits.keep_path:
        k = w.counts.kept_steps
        w.path_t[k, 0], w.path_t[k, 1] = w.y[n_x] + w.clock.t_low, tau
        for r in range(n_x):
            for j in range(order + 1):
                w.path_c[k, r, j] = w.c[r, j]
        for i in range(n_c):
            w.path_m[k, i] = mode(w, i)
        for j in range(w.shown.size):
            w.path_m[k, n_c + j] = np.int64(w.m[w.shown[j]])
        w.counts.kept_steps += 1
    if w.kind.size:
        _accumulate(w, n_x + w.hit.size, tau)
    for r in range(w.c.shape[0]):
        if r < n_x:
            w.y[r] = w.trial[r]
            w.scale[r] = max(w.scale[r], abs(w.y[r] - w.start[r]), abs(w.c[r, 1]) * tau)
        elif r < n_x + w.hit.size:
            w.scale[r] = max(w.scale[r], abs(w.c[r, 0]))
        else:
            w.scale[r] = max(w.scale[r], abs(w.c[r, 1]) * tau)
    gain = tau + w.clock.t_low
    new = w.y[n_x] + gain
    w.clock.t_low = gain - (new - w.y[n_x])
    w.y[n_x] = new
    w.clock.h_last = max(tau, 0.1 * w.clock.h_last)
    w.counts.steps += 1
    if tau > 0.0:
        w.counts.stall = 0
        for g in range(w.fresh.size):
            w.fresh[g] = 0
        for s in range(w.limits.varied):
            w.tau[s] = 0.0


@compiled(fused=True)
def _accumulate(w, first, tau):
    """Update ranges and integrals of the observables over a step."""
    order = w.c.shape[1] - 1
    for e in range(w.kind.size):
        c = w.c[first + e]
        if w.kind[e] == INTEGRAL:
            area = 0.0
            for k in range(order, -1, -1):
                area = area * tau + c[k] / (k + 1)
            area = area * tau + w.total[e, 3]
            new = w.total[e, 2] + area
            w.total[e, 3] = area - (new - w.total[e, 2])
            w.total[e, 2] = new
            continue
        if w.kind[e] == VALUES:
            void = w.kind.size - e <= w.limits.followed * w.limits.varied and w.counts.doubts > 0
            note_values(w, e, c, order, tau, void)
            continue
        if w.kind[e] == FOLLOW:
            follow(w, e, c, tau)
            continue
        power = 1.0
        for k in range(order + 1):
            w.poly[k] = c[k] * power
            power *= tau
        if w.kind[e] == TURN:
            turn_lowest(w, e)
            continue
        old_low, old_high = w.total[e, 0], w.total[e, 1]
        low, high = extend_range(w.poly, order, old_low, old_high, w.table, w.stack, w.found, w.slope)
        w.total[e, 0], w.total[e, 1] = low, high
        if e < w.limits.followed:
            note_places(w, e, tau, old_low, old_high)


@compiled(inline=True, fused=True)
def _switch(w, n_x, n_c):
    """Select the mode after an event and log the changes."""
    if w.limits.varied:
        remember(w)
    changed = transit(w, n_c) if w.other_guards.size else 0
    status = settle(w)
    if status != _OK:
        return status
    starting = w.clock.h_last == 0.0 and w.counts.steps == 0
    if w.limits.varied:
        jump(w, n_x, n_c, starting)
    keep_scales(w, n_x, n_c)
    at_rest = n_c > 0
    for i in range(n_c):
        new = mode(w, i)
        at_rest = at_rest and new == 0
        if new != w.old[i] and not starting:
            changed += 1
            if w.limits.keep_events:
                k = w.counts.kept_events
                w.event_t[k] = w.y[n_x] + w.clock.t_low
                w.event_i[k, 0], w.event_i[k, 1], w.event_i[k, 2] = i, w.old[i], new
                w.counts.kept_events += 1
    if starting:
        _begin(w, n_x)
    for i in range(w.limits.n_q, 2 * w.limits.n_q):
        at_rest = at_rest and abs(w.y[i]) <= 1e-13 * w.scale[i]
    if not at_rest:
        w.clock.rest = np.nan
    elif not w.clock.rest >= 0.0:
        w.clock.rest = w.y[n_x] + w.clock.t_low
        for s in range(w.limits.varied):
            w.rest[s] = w.tau[s]
    w.counts.events += changed
    w.counts.grazes += changed == 0 and not starting
    w.counts.stall += 1
    w.counts.phase = EXPAND
    return budget(w, w.y[n_x])


@compiled(fused=True)
def _begin(w, n_x):
    """Store the first value of every row, and the size of every guard."""
    expand(w)
    for r in range(w.c.shape[0]):
        w.start[r] = w.c[r, 0]
        w.scale[r] = max(w.scale[r], abs(w.c[r, 0])) if n_x <= r < n_x + w.hit.size else 0.0


@compiled(fused=True)
def _next_segment(w):
    """Load the next slope of the inputs."""
    w.counts.segment += 1
    n = w.segment_p.shape[1]
    for k in range(n):
        w.p[w.p.size - n + k] = w.segment_p[w.counts.segment, k]
    for g in range(w.hit.size):
        w.hit[g] = 0
    prelude(w)
    w.counts.phase = SETTLE
