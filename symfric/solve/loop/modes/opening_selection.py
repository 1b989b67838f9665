"""Mode selection of scenes with contacts that open: their impacts, bounces that die out, and the modes that follow."""

from symfric.codegen.numba_types import compiled
from symfric.solve.loop.codes import MANY_CONTACTS, OK, OVERLAP, UNDECIDED
from symfric.solve.loop.events.impact_choice import strike
from symfric.solve.loop.events.impacts import (
    LEAST,
    RESPONSE,
    SIZE,
    close_touching,
    end_bounces,
    hold_exactly,
    is_open,
    leave,
    overlaps,
    told,
)
from symfric.solve.loop.events.time_steps import step_over
from symfric.solve.loop.modes.closed_gaps import take_bounds
from symfric.solve.loop.modes.last_bounces import dies_out, time_to_rest
from symfric.solve.loop.modes.layout import backward
from symfric.solve.loop.modes.mode_pivots import pivot_modes
from symfric.solve.loop.modes.mode_selection import change_switch, mark_fresh
from symfric.solve.loop.modes.planes_that_open import begin_planes, forget_arrivals, has_arrived
from symfric.solve.loop.modes.rest_together import rest_together
from symfric.solve.loop.modes.resting_edges import find_edges
from symfric.solve.loop.modes.tolerances import doubted_acceleration, instant
from symfric.solve.loop.modes.trial_modes import is_apart, rests_undetermined, try_modes
from symfric.solve.loop.modes.zero_slips import has_slid, try_sticking
from symfric.solve.loop.precision import ROUNDING
from symfric.solve.loop.stepping.calls import measure
from symfric.solve.loop.workspace import LoopArrays

_ROUNDS = 8  # most repetitions because kinks were passed
_MORE = 2  # and for each kink, because one is passed at a time


@compiled
def select_with_openings(w: LoopArrays, starting: bool) -> int:
    """Apply impacts and select the mode of every contact and switch."""
    n_x, n_c = w.y.size - 1, w.contacts.sticks.size
    if w.limits.steps and w.counts.jumped:
        step_over(w, n_x, n_c)
    if w.counts.jumped and not starting and overlaps(w, n_x):
        return OVERLAP
    if w.limits.planes and not w.counts.jumped and has_slid(w, n_x):
        return UNDECIDED
    leave(w)
    for r in range(w.m.size):
        w.impacts.entry_m[r] = w.m[r]
    begin_planes(w)
    status = strike(w, n_c, starting)
    if status == OK:
        status = _select(w, n_x, n_c)
    w.clock.late = time_to_rest(w, n_x) if status == OK and not starting else 0.0
    if w.clock.late > 0.0:
        for r in range(w.m.size):
            w.impacts.flight_m[r] = w.m[r]
        for r in range(n_x):
            w.y[r] = w.impacts.entry_y[r]
        for r in range(w.m.size):
            w.m[r] = w.impacts.entry_m[r]
        end_bounces(w)
        status = _select(w, n_x, n_c)
    if status == OK and not starting and dies_out(w, n_x):
        close_touching(w)
        status = _select(w, n_x, n_c)
    forget_arrivals(w)
    return status


@compiled
def _select(w: LoopArrays, n_x: int, n_c: int) -> int:
    """Select the mode of contacts that are closed or may close, and of switches."""
    for i in range(n_c):
        w.selection.passes[i] = is_apart(w, i)
    try_sticking(w, n_x, n_c)
    for i in range(n_c):
        if is_apart(w, i):
            w.selection.zero[i], w.m[i] = 0, 0.0
    if has_arrived(w):  # its slip is what a straight line has left of it
        hold_exactly(w)
        measure(w, w.y, w.gauge)
    return _select_modes(w, n_x, n_c)


@compiled
def _select_modes(w: LoopArrays, n_x: int, n_c: int) -> int:
    """Try modes until the switches agree with them."""
    n_s = w.contacts.edge.size
    for i in range(w.selection.turns.size):
        w.selection.turns[i] = 0
    edges = w.limits.edges > 0
    for attempt in range(_ROUNDS + _MORE * n_s):
        status = rest_together(w, n_x, n_c) if rests_undetermined(w, n_c) else try_modes(w, n_x, n_c)
        if status == MANY_CONTACTS and not w.limits.planes:
            status = pivot_modes(w, n_x, n_c)
        if status != OK:
            return status
        if attempt == 0 and edges and find_edges(w, n_x, n_c, True):
            continue
        if n_s == 0 or not change_switch(w, n_x, n_c, n_s, edges):
            hold_exactly(w)
            if w.limits.planes:
                take_bounds(w, n_x, n_c)
            mark_fresh(w, n_x, n_c, n_s)
            _mark_slips(w, n_x, n_c)
            return OK if _mark_openings(w, n_x) else UNDECIDED
    return UNDECIDED


@compiled
def _mark_slips(w: LoopArrays, n_x: int, n_c: int) -> None:
    """Mark slips whose acceleration is zero within the error of the run, so that the next derivative counts."""
    for i in range(n_c):
        g = backward(i)
        if w.m[i] == 0.0 and w.guards.fresh[g] and w.contacts.partner[i] < 0:
            a, b = w.probe[n_x + g, 1], 2.0 * w.probe[n_x + g, 2]
            w.guards.fresh[g] = 1 + (abs(a) <= doubted_acceleration(w, i, b))


@compiled
def _mark_openings(w: LoopArrays, n_x: int) -> bool:
    """Mark the guards of contacts that open which start the new mode at zero, and give them scales.

    Return whether no gap is about to become negative.
    """
    now = instant(w)
    for k in range(w.openings.variable.size):
        g, little = w.limits.first_opening + 2 * k, ROUNDING * told(w, LEAST, k)
        w.guards.slack[g], w.guards.slack[g + 1], w.guards.fresh[g], w.guards.fresh[g + 1] = 0.0, 0.0, 0, 0
        if not is_open(w, k):
            force, change = w.probe[n_x + g + 1, 0], w.probe[n_x + g + 1, 1]
            w.guards.fresh[g + 1] = abs(force) <= little + abs(change) * now
        elif w.impacts.touches[k]:
            if w.impacts.rests[k] == 0 and not w.probe[n_x + g, 1] > 0.0:
                return False
            a, jerk = 2.0 * w.probe[n_x + g, 2], 6.0 * w.probe[n_x + g, 3]
            still = w.impacts.rests[k] != 0
            w.guards.fresh[g] = 1 + still + (still and abs(a) <= told(w, RESPONSE, k) * little + abs(jerk) * now)
        w.scale[n_x + g] = max(w.scale[n_x + g], told(w, SIZE, k))
        w.scale[n_x + g + 1] = max(w.scale[n_x + g + 1], told(w, LEAST, k))
    return True
