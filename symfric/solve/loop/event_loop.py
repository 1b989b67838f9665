"""The event loop, compiled once for all models, whose machine code is called by address."""

import numpy as np

from symfric.codegen.numba_types import compiled, part
from symfric.solve.loop.arithmetic import drifts, is_at_rest, scale_of_state, summed
from symfric.solve.loop.codes import (
    CHATTER,
    EXPAND,
    GO,
    LOADED,
    LOST_CONTACT,
    NOT_FINITE,
    OK,
    PAINLEVE,
    QUEUE_FULL,
    SEGMENT,
    SELECT,
    STEP_COLLAPSE,
    UNDECIDED,
)
from symfric.solve.loop.events.crossings import cross
from symfric.solve.loop.events.first_event import first_event
from symfric.solve.loop.events.impacts import jams, leave, log_openings
from symfric.solve.loop.events.saltation import give_up_derivatives, has_derivatives, jump, remember
from symfric.solve.loop.events.time_steps import mark_steps, soon
from symfric.solve.loop.events.transitions import transit
from symfric.solve.loop.modes.layout import mode
from symfric.solve.loop.modes.mode_selection import keep_scales, select_mode
from symfric.solve.loop.modes.opening_selection import select_with_openings
from symfric.solve.loop.modes.planes import select_in_plane
from symfric.solve.loop.modes.zero_slips import has_slid
from symfric.solve.loop.precision import EPS, STRETCH
from symfric.solve.loop.recording.accumulation import accumulate
from symfric.solve.loop.recording.last_flights import count_flights, vary_end
from symfric.solve.loop.recording.trajectory import store_event, store_step
from symfric.solve.loop.run_rules import begin_counting, begin_values, budget, pause
from symfric.solve.loop.stepping.calls import expand, prelude
from symfric.solve.loop.stepping.release_in_plane import comes_to_rest, leave_rest, passes_rest
from symfric.solve.loop.stepping.singular_start import arrives, start_singular, within_rounding
from symfric.solve.loop.stepping.step_acceptance import proven, reach, try_end
from symfric.solve.loop.stepping.step_size import step_rule, step_size, truncated_size, weighted_rule, weighted_size
from symfric.solve.loop.workspace import LoopArrays
from symfric.solve.status import PAUSED

_MANY_STEPS, _LEAST_PROGRESS = 20_000, 1e-9  # a run stands still if so many steps advance less than this fraction of it
_LEAST_STEP = 1e-24  # shortest step, relative to the run


@part
def reset(w: LoopArrays) -> None:
    """Start a run at t = 0 from the given state and parameters."""
    n_x, n_c, n_p = w.given_y.size, w.contacts.sticks.size, w.given_p.size
    for i in range(n_x):
        w.y[i] = w.given_y[i]
    w.y[n_x] = 0.0
    for k in range(w.p.size):
        w.p[k] = w.given_p[k] if k < n_p else w.inputs.values[0, k - n_p]
    for k in range(w.m.size):
        w.m[k] = 0.0 if k < n_c or k >= w.limits.first_variable else 1.0
    begin_counting(w)
    w.scale[:] = 0.0
    w.guards.other[:] = 0.0
    w.guards.carries[:] = 0
    w.start[:] = 0.0
    w.guards.hit[:] = 0
    w.guards.fresh[:] = 0
    w.guards.slack[:] = 0.0
    for r in range(n_x):
        w.step.base[1, r], w.step.base[2, r] = 0.0, 0.0
    for e in range(w.wanted.kind.size):
        w.observed.total[e, 0], w.observed.total[e, 1], w.observed.total[e, 3] = np.inf, -np.inf, 0.0
        w.observed.total[e, 2] = 0.0
        w.saltation.rise[e, 0], w.saltation.rise[e, 1] = 0.0, 0.0
    begin_values(w)
    w.saltation.tau[:] = 0.0
    w.rest[:] = 0.0


@part
def drive(w: LoopArrays) -> int:
    """Integrate from the state in ``w.y`` to ``w.clock.t_end``; return a status, or a code to call again."""
    n_x, n_c = w.y.size - 1, w.contacts.sticks.size
    stop = w.counts.steps + w.limits.chunk
    rule, rule_weighted = step_rule(w), weighted_rule(w)
    while True:
        if w.y[n_x] >= w.clock.t_end:
            checked = w.limits.planes > 0 and w.counts.jumped == 0
            return UNDECIDED if checked and has_slid(w, n_x) else OK
        status = pause(w, stop, n_c + w.contacts.other_guards.shape[0])
        if status != OK:
            return status
        if w.counts.steps >= w.counts.mark_steps:
            if w.y[n_x] - w.clock.mark_steps_t < _LEAST_PROGRESS * w.clock.t_end:
                return STEP_COLLAPSE
            w.counts.mark_steps, w.clock.mark_steps_t = w.counts.steps + _MANY_STEPS, w.y[n_x]
        if w.counts.phase == SEGMENT:
            _next_segment(w)
        if w.counts.phase == SELECT:
            status = _switch(w, n_x, n_c)
            if status != OK:
                return status
            if w.limits.apart:
                return PAUSED
            if w.limits.planes:
                tau = leave_rest(w, n_x, n_c)
                if tau >= 0.0:
                    if tau > 0.0:
                        reach(w, tau, tau)
                        try_end(w, n_x, tau)
                        _advance(w, n_x, n_c, tau)
                        if not _is_finite(w, n_x):
                            return NOT_FINITE
                    w.counts.phase = SELECT if w.counts.flagged else EXPAND
                    if w.counts.flagged == LOADED:
                        return LOST_CONTACT
                    continue
        if w.counts.phase == EXPAND:
            expand(w)
            w.counts.phase = GO
            if w.limits.planes and comes_to_rest(w, n_x, n_c):
                continue
        h = step_size(w, n_x, rule)
        if w.limits.planes and not h > 0.0:
            h = truncated_size(w, n_x)
        if not h > 0.0 or (w.counts.stall > 0 and within_rounding(w, n_x, n_c, h)):
            status = start_singular(w, n_x, n_c)
            if status != OK:
                return status
            continue
        if w.limits.exact > 0:
            h = weighted_size(w, n_x, h, rule_weighted)
        limit = min(w.clock.t_end, w.inputs.times[w.counts.segment + 1])
        left = (limit - w.y[n_x]) - w.clock.t_low
        last = h * STRETCH >= left
        if last:
            h = left
        tau = first_event(w, n_x, n_c, h, h if last else h * STRETCH)
        collapsed = False
        while tau > 0.0:
            holds = proven(w, n_x, tau)
            if holds == tau:
                break
            if tau <= max(16.0 * EPS * w.y[n_x], _LEAST_STEP * w.clock.t_end):
                collapsed = True
                break
            last, h = False, holds
            tau = first_event(w, n_x, n_c, h, h)
        if tau < h:
            last = False
        elif not last and h <= 2.0 * EPS * abs(w.y[n_x]):
            collapsed = True
        if collapsed:
            if not arrives(w, n_x, n_c) and not (w.limits.planes and passes_rest(w, n_x)):
                return _collapse(w, n_x)
            continue
        if tau > 0.0:
            _advance(w, n_x, n_c, tau)
        if not _is_finite(w, n_x):
            return NOT_FINITE
        if w.limits.varied and not has_derivatives(w, n_x):
            give_up_derivatives(w, n_x)
        if w.clock.rest >= 0.0 and drifts(w.y, w.scale, w.limits.n_q, w.clock.t_end, w.clock.tolerance):
            w.clock.rest = np.nan
        if last:
            w.y[n_x], w.clock.t_low = limit, 0.0
            if limit < w.clock.t_end:
                w.counts.phase = SEGMENT
                continue
        w.counts.phase = SELECT if w.counts.flagged else EXPAND
        if w.counts.flagged == LOADED:
            return LOST_CONTACT


@compiled(inline=True)
def _is_finite(w: LoopArrays, n_x: int) -> bool:
    """Whether all states are numbers; derivatives of them need not be."""
    finite = True
    for i in range(n_x // (1 + w.limits.varied)):
        finite = finite and abs(w.y[i]) < np.inf
    return finite


@compiled
def _collapse(w: LoopArrays, n_x: int) -> int:
    """Return the status of steps that become too short: PAINLEVE if a normal force grows without bound."""
    return PAINLEVE if jams(w, n_x) else STEP_COLLAPSE


@compiled(inline=True, fused=True)
def _advance(w: LoopArrays, n_x: int, n_c: int, tau: float) -> None:
    """Advance the state over the step, store the trajectory and observables, and update the scales."""
    if w.limits.keep_path:
        k = store_step(w, n_c, w.y[n_x] + w.clock.t_low, tau)
        for r in range(n_x):
            for j in range(w.c.shape[1]):
                w.stored.path_c[k, r, j] = w.c[r, j]
    if w.wanted.kind.size:
        accumulate(w, n_x + w.guards.hit.size, tau)
    for r in range(w.c.shape[0]):
        if r < n_x:
            w.y[r] = w.step.end[r]
            w.scale[r] = scale_of_state(w.scale[r], w.y[r], w.start[r], w.c[r, 1], tau)
        elif r < n_x + w.guards.hit.size:
            w.scale[r] = max(w.scale[r], abs(w.c[r, 0]))
        else:
            w.scale[r] = max(w.scale[r], abs(w.c[r, 1]) * tau)
    for k in range(w.openings.variable.size):  # a flight may begin and end on the floor, in one step
        g = n_x + w.limits.first_opening + 2 * k
        w.scale[g] = max(w.scale[g], abs(w.c[g, 1]) * tau)
    w.y[n_x], w.clock.t_low = summed(w.y[n_x], w.clock.t_low, tau)
    w.clock.h_last = max(tau, 0.1 * w.clock.h_last)
    w.counts.steps += 1
    if tau > 0.0:
        w.counts.stall = 0
        for g in range(w.guards.fresh.size):
            w.guards.fresh[g] = 0
        for s in range(w.limits.varied):
            w.saltation.tau[s] = 0.0


@compiled(inline=True, fused=True)
def _switch(w: LoopArrays, n_x: int, n_c: int) -> int:
    """Select the mode after an event and log the changes."""
    starting = w.clock.h_last == 0.0 and w.counts.steps == 0
    if w.limits.first_clock < w.guards.hit.size:
        while w.inputs.times[w.counts.segment + 1] <= min(w.y[n_x] + soon(w), w.clock.t_end):
            _load_segment(w)  # the same instant to rounding: what is computed now has its value
    if w.limits.steps:
        mark_steps(w, n_x, n_c, starting)
    if w.limits.varied:
        remember(w, n_x)
    if w.openings.variable.size:
        leave(w)
    changed = transit(w, n_c) if w.contacts.other_guards.size else 0
    if changed < 0:
        return QUEUE_FULL
    if w.openings.variable.size:
        status = select_with_openings(w, starting)
    elif w.limits.planes:
        status = select_in_plane(w)
    else:
        status = select_mode(w)
    if status != OK:
        return status
    if w.limits.first_crossing < w.guards.hit.size and cross(w, n_x, starting):
        return CHATTER
    if w.limits.varied:
        jump(w, n_x, n_c, starting)
    if w.openings.variable.size:
        changed += log_openings(w, starting)
    keep_scales(w, n_x, n_c)
    late = w.clock.late if w.openings.variable.size else 0.0
    if late > 0.0:
        if w.limits.varied:
            vary_end(w, n_x)
        count_flights(w, n_x)
    at_rest = n_c > 0 or w.openings.variable.size > 0
    for i in range(n_c):
        new = mode(w, i)
        at_rest = at_rest and new == 0
        if w.contacts.opens[i] >= 0 or 0 <= w.contacts.partner[i] < i:
            continue  # its events are stored already, or with the first component of its slip
        if new != w.selection.old[i] and not starting:
            changed += 1
            if w.limits.keep_events:
                store_event(w, i, w.selection.old[i], new)
    if starting:
        _begin(w, n_x)
    for i in range(w.limits.n_q, 2 * w.limits.n_q):
        at_rest = at_rest and is_at_rest(w.y[i], w.scale[i])
    if not at_rest:
        w.clock.rest = np.nan
    elif not w.clock.rest >= 0.0:
        w.clock.rest = w.y[n_x] + w.clock.t_low + late
        for s in range(w.limits.varied):
            w.rest[s] = w.saltation.tau[s] + (w.impacts.late[s] if late > 0.0 else 0.0)
        if w.clock.rest > w.clock.t_end:
            w.clock.rest = np.nan
    w.counts.events += changed
    w.counts.grazes += changed == 0 and not starting
    w.counts.stall += 1
    w.counts.jumped = 0
    w.counts.phase = EXPAND
    return budget(w, w.y[n_x])


@compiled(fused=True)
def _begin(w: LoopArrays, n_x: int) -> None:
    """Store the first value of every row, and the size of every guard."""
    expand(w)
    for r in range(w.c.shape[0]):
        w.start[r] = w.c[r, 0]
        w.scale[r] = max(w.scale[r], abs(w.c[r, 0])) if n_x <= r < n_x + w.guards.hit.size else 0.0


@compiled(fused=True)
def _next_segment(w: LoopArrays) -> None:
    """Begin the next segment of the inputs."""
    for g in range(w.guards.hit.size):
        w.guards.hit[g] = 0
    _load_segment(w)
    w.counts.phase = SELECT


@compiled
def _load_segment(w: LoopArrays) -> None:
    """Load the next slope of the inputs."""
    w.counts.segment += 1
    n = w.inputs.values.shape[1]
    for k in range(n):
        w.p[w.p.size - n + k] = w.inputs.values[w.counts.segment, k]
    prelude(w)
    w.counts.jumped = w.limits.holds
