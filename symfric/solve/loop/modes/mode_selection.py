"""Mode selection: the next mode from the forces.

Contacts whose slip is zero are tried as sticking; a contact whose force would exceed its static bound, and cannot leave
the excess to others that stick, is released in its direction; one that would slip against its direction is caught
again. One contact is changed at a time, the worst first and, if that runs long, the one of least index: Murty's rule
for the complementarity problem ``0 <= bound -+ lambda  complementary to  +- acceleration >= 0``. Ties at the bound are
decided by the next derivatives.

References
----------
Murty, Note on a Bard-type scheme for solving the complementarity problem, Opsearch 11 (1974) 123.
"""

import numpy as np

from symfric.codegen.numba_types import compiled
from symfric.lower.constraint_forces import AT_BOUND, FOLLOWS, HOLDS, SHARES
from symfric.solve.loop.codes import DROP, LOAD, LOST_CONTACT, NOT_FINITE, OK, UNDECIDED
from symfric.solve.loop.events.time_steps import just_after, missed, soon, step_over
from symfric.solve.loop.modes.contradiction import at_bound, stick_scale, tie_of, tied, worst_contact
from symfric.solve.loop.modes.exceeded_facets import release_worst
from symfric.solve.loop.modes.holding import hold_more
from symfric.solve.loop.modes.layout import backward, direction, forward, sign, switch
from symfric.solve.loop.modes.resting_edges import decisive, find_edges
from symfric.solve.loop.modes.sticking_basis import exchange, release, share
from symfric.solve.loop.modes.tolerances import natural_time, no_load
from symfric.solve.loop.modes.zero_slips import moved_in_vain, try_sticking
from symfric.solve.loop.precision import ROUNDING, TIE, TOUCH
from symfric.solve.loop.stepping.calls import prelude, probe
from symfric.solve.loop.workspace import LoopArrays


@compiled
def select_mode(w: LoopArrays) -> int:
    """Select the mode of every contact and switch at the current state; return a status.

    Contacts and switches that reached zero are marked in ``w.guards.hit``; the modes are stored in ``w.m``, and
    ``w.guards.fresh`` marks the guards that start the new mode at zero.
    """
    n_x, n_c = w.y.size - 1, w.contacts.sticks.size
    if w.limits.steps and w.counts.jumped:
        step_over(w, n_x, n_c)
    if not w.limits.coupled:
        return _select(w, n_x, n_c)
    for i in range(n_c):
        w.selection.passes[i] = 0
    for k in range(w.m.size):
        w.selection.entry_m[k] = w.m[k]
    for r in range(n_x):
        w.selection.entry_y[r] = w.y[r]
    for attempt in range(2):
        status = _select(w, n_x, n_c)
        if attempt == 1 or status != OK or not moved_in_vain(w, n_c):
            break
        for k in range(w.m.size):
            w.m[k] = w.selection.entry_m[k]
        for r in range(n_x):
            w.y[r] = w.selection.entry_y[r]
    return status


@compiled
def _select(w: LoopArrays, n_x: int, n_c: int) -> int:
    """Select the mode; the slips of contacts in ``w.selection.passes`` are not set to zero first."""
    n_s = w.contacts.edge.size
    try_sticking(w, n_x, n_c)
    status = loads_hold(w, n_x, n_c)
    if status != OK:
        return status
    horizon = w.clock.t_end
    for i in range(w.selection.turns.size):
        w.selection.turns[i] = 0
    edges = w.limits.edges > 0
    _leave_bounds(w, n_c)
    rounds = 60 + 12 * (n_c + n_s)
    for turn in range(rounds):
        share(w, n_c)
        prelude(w)
        probe(w)
        if turn == 0 and edges and find_edges(w, n_x, n_c, True):
            continue
        least = turn > 20 + 4 * n_c
        if _change_contact(w, n_x, n_c, horizon, least):
            continue
        if n_s > 0 and change_switch(w, n_x, n_c, n_s, edges):
            continue
        hold_more(w, n_x, n_c, horizon, edges)
        for i in range(n_c):
            if w.m[i] > 0.5 and not abs(w.probe[n_x + backward(i), 0]) < np.inf:
                return NOT_FINITE  # it would contradict nothing
        mark_fresh(w, n_x, n_c, n_s)
        return OK
    return UNDECIDED


@compiled(inline=True)
def loads_hold(w: LoopArrays, n_x: int, n_c: int) -> int:
    """Return the status of normal loads and of coefficients at rest, which may not be negative."""
    for i in range(n_c):
        g, lost = w.contacts.loads[i], 0.0
        if g >= 0:
            w.guards.slack[g] = no_load(w, i) + missed(w, n_x + g)
            lost = -w.guards.slack[g] - TOUCH * w.clock.tolerance * w.scale[n_x + g]
        if w.gauge[LOAD, i] < lost:
            return LOST_CONTACT
        if w.gauge[DROP, i] < 0.0:
            return UNDECIDED
    return OK


@compiled(inline=True)
def _leave_bounds(w: LoopArrays, n_c: int) -> None:
    """Release the sticking contacts whose guard fell, unless others can bear the excess.

    A contact with a given force is judged by its acceleration.
    """
    for i in range(n_c):
        if w.m[i] == 0.0 or w.selection.old[i] != 0 or not (w.guards.hit[backward(i)] or w.guards.hit[forward(i)]):
            continue
        side = -1 if w.guards.hit[backward(i)] else 1
        if not w.contacts.depends[i] or (w.guards.carries[i] == 0 and w.counts.stall > 0):
            w.m[i], w.m[direction(i, n_c)] = 0.0, side
        elif w.guards.carries[i]:
            share(w, n_c)
            carries = w.m[i] == HOLDS or w.m[i] == SHARES  # false if it left its bound together with another
            if carries and not exchange(w, n_c, i, side, False):
                release(w, n_c)


@compiled(inline=True)
def _change_contact(w: LoopArrays, n_x: int, n_c: int, horizon: float, least: bool) -> bool:
    """Change the mode of the contact that contradicts its forces most; return whether there was one."""
    worst, side, size = worst_contact(w, n_x, n_c, horizon, least)
    if worst < 0:
        return False
    if size <= tie_of(w, n_x, worst, side)[0]:  # others may have been worse before, and have changed it in passing
        w.selection.turns[worst] += 1
    if w.contacts.depends[worst] and (w.m[worst] == HOLDS or w.m[worst] == SHARES):
        if not exchange(w, n_c, worst, side, least):
            release_worst(w, n_x, n_c)
    elif w.m[worst] > 0.5:
        w.m[worst], w.m[direction(worst, n_c)] = 0.0, side
    elif w.contacts.sticks[worst]:
        w.m[worst] = FOLLOWS
    else:
        w.m[direction(worst, n_c)] = -w.m[direction(worst, n_c)]
    return True


@compiled(inline=True)
def change_switch(w: LoopArrays, n_x: int, n_c: int, n_s: int, edges: bool) -> bool:
    """Flip one switch whose sign is wrong, now or, at zero, immediately after; return whether there was one."""
    if edges and find_edges(w, n_x, n_c, False):
        return True
    time = natural_time(w)
    for j in range(n_s):
        g, row = switch(j, n_c), n_x + switch(j, n_c)
        value = just_after(w, row) if w.contacts.step[j] else w.probe[row, 0]
        if w.selection.turns[n_c + j] >= 2:
            continue
        if w.guards.hit[g] or abs(value) <= abs(w.m[sign(j, n_c)]) * ROUNDING * w.scale[row]:
            if w.contacts.edge[j]:
                continue
            wrong = w.probe[row, decisive(w, w.probe, row, j, n_c, time)] < 0.0
        else:
            wrong = value < 0.0
        if wrong:
            w.selection.turns[n_c + j] += 1
            w.m[sign(j, n_c)] = -w.m[sign(j, n_c)]
            w.counts.kinks += 1
            return True
    return False


@compiled(inline=True)
def mark_fresh(w: LoopArrays, n_x: int, n_c: int, n_s: int) -> None:
    """Mark the guards that start the new mode at zero, or below it within the error of the run."""
    for i in range(n_c):
        a, b = w.probe[n_x + backward(i), 0], w.probe[n_x + forward(i), 0]
        if w.contacts.partner[i] >= 0:
            _mark_in_plane(w, i, a, w.probe[n_x + backward(i), 1])
        elif w.m[i] == FOLLOWS or w.m[i] == AT_BOUND:
            w.guards.fresh[backward(i)], w.guards.fresh[forward(i)] = 1, 1
            w.guards.slack[backward(i)], w.guards.slack[forward(i)] = 0.0, 0.0
        elif w.m[i] > 0.5:
            scale = stick_scale(w, n_x + backward(i))
            for g, room in ((backward(i), a), (forward(i), b)):
                largest = w.scale[n_x + g] if w.guards.carries[i] else w.guards.other[g]
                w.guards.fresh[g], w.guards.slack[g] = at_bound(w, n_x + g, scale), max(0.0, -room)
                if w.guards.fresh[g] and w.probe[n_x + g, 1] < 0.0 and tied(w, w.probe[n_x + g, 1], scale):
                    w.guards.fresh[g], w.guards.slack[g] = 0, 2.0 * TIE * scale - room  # it stays
                if scale <= TIE * largest or (
                    w.guards.hit[g] and w.guards.carries[i]
                ):  # zero up to the rounding of earlier values
                    w.guards.fresh[g], w.guards.slack[g] = 0, max(0.0, ROUNDING * max(scale, largest) - room)
        else:
            w.guards.fresh[backward(i)] = w.selection.zero[i]
            w.guards.fresh[forward(i)] = 0
            w.guards.slack[backward(i)], w.guards.slack[forward(i)] = 0.0, 0.0
    for j in range(n_s):
        g, little = switch(j, n_c), abs(w.m[sign(j, n_c)]) * ROUNDING
        zero = little * w.scale[n_x + g]
        if w.contacts.step[j]:
            zero = max(zero, 2.0 * soon(w) * abs(w.probe[n_x + g, 1]))
        w.guards.fresh[g] = w.guards.hit[g] != 0 or abs(w.probe[n_x + g, 0]) <= zero


@compiled(inline=True)
def _mark_in_plane(w: LoopArrays, i: int, value: float, change: float) -> None:
    """Mark the guards of a row of a contact in the plane; while it sticks the first may start at zero.

    As one that opens lets go, its bound falls to zero, and the square of that to the rounding of earlier ones before.
    """
    g, rises = backward(i), change > 0.0
    earlier = w.scale[w.y.size - 1 + g] if w.guards.carries[i] else w.guards.other[g]  # of forces, not of slips
    little = ROUNDING * max(earlier, w.planes.static[i] ** 2)
    near = w.m[i] > 0.5 and w.contacts.partner[i] > i and value <= little
    tied = near and rises
    w.guards.fresh[g], w.guards.fresh[forward(i)] = tied, 0
    w.guards.slack[g], w.guards.slack[forward(i)] = 0.0 if tied else max(0.0, -value), 0.0
    if near and not rises and w.contacts.opens[i] >= 0:
        w.guards.slack[g] = max(0.0, little - value)


@compiled(inline=True)
def keep_scales(w: LoopArrays, n_x: int, n_c: int) -> None:
    """Exchange the scales of a contact's guards when they change between slips and forces.

    Slips and forces have different units.
    """
    for i in range(n_c):
        told = w.contacts.partner[i] >= 0 and w.m[i] == AT_BOUND  # of one in the plane the guard is that of its force
        carries = w.m[i] == HOLDS or w.m[i] == SHARES or told
        if carries == (w.guards.carries[i] != 0):
            continue
        w.guards.carries[i] = carries
        for g in (backward(i), forward(i)):
            w.scale[n_x + g], w.guards.other[g] = max(w.guards.other[g], abs(w.probe[n_x + g, 0])), w.scale[n_x + g]
