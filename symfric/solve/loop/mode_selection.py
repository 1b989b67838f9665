"""Mode selection: the next mode from the forces.

Contacts whose slip is zero are tried as sticking; a contact whose force would exceed its static bound, and cannot leave
the excess to others that stick, is released in its direction; one that would slip against its direction is caught
again. One contact is changed at a time, the worst first and, if that runs long, the one of least index: Murty's rule
for the complementarity problem ``0 <= bound -+ lambda  complementary to  +- acceleration >= 0``. Ties at the bound are
decided by the next derivatives.
"""

import numpy as np

from symfric.codegen.numba_types import compiled
from symfric.lower.constraint_forces import AT_BOUND, FOLLOWS, HOLDS, SHARES
from symfric.solve.loop.calls import measure, prelude, probe
from symfric.solve.loop.contradiction import at_bound, contradiction, contradicts, idles, rests, stick_scale, tied
from symfric.solve.loop.exceeded_facets import release_worst
from symfric.solve.loop.layout import backward, direction, forward, mode, sign, switch
from symfric.solve.loop.precision import ROUNDING, TIE, TOUCH
from symfric.solve.loop.resting_edges import decisive, find_edges
from symfric.solve.loop.sticking_basis import exchange, release, share
from symfric.solve.loop.tolerances import natural_time, no_load
from symfric.solve.loop.workspace import (
    COUPLING,
    DROP,
    LOAD,
    PULL,
    SLIP,
    TERMS,
)
from symfric.solve.status import Status

AMPLIFIED = 1e3  # change of velocities, relative to that for a single slip, by nearly parallel slips made zero
NO_DROP = 1e-9  # relative drop of friction from rest to slip below which there is none

_OK, _UNDECIDED, _LOST = int(Status.OK), int(Status.UNDECIDED), int(Status.LOST_CONTACT)
_NAN = int(Status.NOT_FINITE)


@compiled
def settle(w):
    """Select the mode of every contact and switch at the current state; return a status.

    Contacts and switches that reached zero are marked in ``w.hit``; the modes are stored in ``w.m``, and ``w.fresh``
    marks the guards that start the new mode at zero.
    """
    n_x, n_c = w.y.size - 1, w.sticks.size
    if not w.limits.coupled:
        return _select(w, n_x, n_c)
    for i in range(n_c):
        w.passes[i] = 0
    for k in range(w.m.size):
        w.entry_m[k] = w.m[k]
    for r in range(n_x):
        w.entry_y[r] = w.y[r]
    for attempt in range(2):
        status = _select(w, n_x, n_c)
        if attempt == 1 or status != _OK or not _moved_in_vain(w, n_c):
            break
        for k in range(w.m.size):
            w.m[k] = w.entry_m[k]
        for r in range(n_x):
            w.y[r] = w.entry_y[r]
    return status


@compiled(inline=True)
def _moved_in_vain(w, n_c):
    """Whether velocities were changed for slips that do not stay zero; mark these in ``w.passes``.

    Rounding of a slip is that much of a velocity, where slips are nearly parallel far more: another contact would be
    taken to rest then, at a speed that is not zero.
    """
    found = False
    if w.clock.gained > AMPLIFIED**2 * w.clock.removed:
        for i in range(n_c):
            w.passes[i] = w.zero[i] and w.m[i] < 0.5
            found = found or w.passes[i]
    return found


@compiled
def _select(w, n_x, n_c):
    """Select the mode; the slips of contacts in ``w.passes`` are not set to zero first."""
    n_s = w.edge.size
    _try_sticking(w, n_x, n_c)
    for i in range(n_c):
        g, lost = w.loads[i], 0.0
        if g >= 0:
            w.slack[g] = no_load(w, i)
            lost = -w.slack[g] - TOUCH * w.clock.tolerance * w.scale[n_x + g]
        if w.gauge[LOAD, i] < lost:
            return _LOST
        if w.gauge[DROP, i] < 0.0:
            return _UNDECIDED
    horizon = w.clock.t_end
    for i in range(w.turns.size):
        w.turns[i] = 0
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
        if n_s > 0 and _change_switch(w, n_x, n_c, n_s, edges):
            continue
        _hold_more(w, n_x, n_c, horizon, edges)
        for i in range(n_c):
            if w.m[i] > 0.5 and not abs(w.probe[n_x + backward(i), 0]) < np.inf:
                return _NAN  # it would contradict nothing
        _mark_fresh(w, n_x, n_c, n_s)
        return _OK
    return _UNDECIDED


@compiled(inline=True)
def _try_sticking(w, n_x, n_c):
    """Set the trial mode: contacts at zero slip stick, or are released if their bound was reached."""
    measure(w, w.y, w.gauge)
    n_q, w.clock.removed, w.clock.gained = w.limits.n_q, 0.0, 0.0
    for r in range(n_x + 1):  # if everything comes to rest at once, rounding is relative to the previous velocities
        w.trial[r] = abs(w.start[r]) + w.scale[r] if n_q <= r < 2 * n_q else w.y[r]
    measure(w, w.trial, w.span)
    for i in range(n_c):
        w.old[i] = mode(w, i)
        w.zero[i] = w.old[i] == 0 or w.hit[backward(i)] != 0
    _find_zeros(w, n_c)
    passing = False
    if w.limits.coupled:
        for i in range(n_c):
            if w.passes[i]:
                w.m[i], passing = 0.0, True
    projected = _project(w, n_c)
    sticking = 0
    for i in range(n_c):
        sticking += w.m[i] > 0.5
    if projected and sticking > 1:  # twice, because impulses that cancel leave their rounding
        measure(w, w.y, w.gauge)
        _project(w, n_c)
    if projected or passing:  # then the slips of dependent contacts are zero too
        measure(w, w.y, w.gauge)
        _find_zeros(w, n_c)
    for i in range(n_c):
        if w.m[i] != 0.0 and w.anchor[i] >= 0:
            w.y[w.anchor[i]] -= w.gauge[SLIP, i] / w.factor[i]


@compiled(inline=True)
def _leave_bounds(w, n_c):
    """Release the sticking contacts whose guard fell, unless others can bear the excess.

    A contact with a given force is judged by its acceleration.
    """
    for i in range(n_c):
        if w.m[i] == 0.0 or w.old[i] != 0 or not (w.hit[backward(i)] or w.hit[forward(i)]):
            continue
        side = -1 if w.hit[backward(i)] else 1
        if not w.depends[i] or (w.carries[i] == 0 and w.counts.stall > 0):
            w.m[i], w.m[direction(i, n_c)] = 0.0, side
        elif w.carries[i]:
            share(w, n_c)
            carries = w.m[i] == HOLDS or w.m[i] == SHARES  # false if it left its bound together with another
            if carries and not exchange(w, n_c, i, side, False):
                release(w, n_c)


@compiled(inline=True)
def _find_zeros(w, n_c):
    """Add the contacts whose slip is zero up to rounding; all at zero slip stick on trial, the others slip."""
    for i in range(n_c):
        slip, size = w.gauge[SLIP, i], max(w.gauge[TERMS, i], 0.125 * w.span[TERMS, i])
        w.zero[i] = w.zero[i] or abs(slip) <= ROUNDING * size
        if not w.zero[i]:
            w.m[direction(i, n_c)] = 1.0 if slip > 0.0 else -1.0
            w.m[i] = 0.0
        elif w.sticks[i] and w.m[i] == 0.0:
            w.m[i] = FOLLOWS  # unless `share` finds it independent


@compiled
def _project(w, n_c):
    """Set the slips of the sticking contacts exactly to zero by impulses, the least change in the norm of energy.

    Return whether impulses were needed.
    """
    coupled = False
    for i in range(n_c):
        coupled = coupled or (w.m[i] > 0.5 and w.anchor[i] < 0)
    if not coupled:  # exact without impulses if every slip has its own velocity
        return False
    close = share(w, n_c)
    n_q, n = w.limits.n_q, 0
    for i in range(n_c):
        n += w.m[i] > 0.5
    for a in range(n):
        i = w.order[a]
        w.impulse[i] = -w.gauge[SLIP, i]
        w.clock.removed = max(w.clock.removed, w.gauge[SLIP, i] ** 2 / w.gauge[COUPLING + i, i])
        for b in range(a):
            j = w.order[b]
            if w.m[i] == HOLDS and w.m[j] == HOLDS:
                w.impulse[i] -= w.share[i, j] * w.impulse[j]
    for a in range(n - 1, -1, -1):
        i = w.order[a]
        if w.m[i] != HOLDS:
            continue
        w.clock.gained += w.impulse[i] ** 2 / w.share[i, i]
        w.impulse[i] /= w.share[i, i]
        for b in range(a + 1, n):
            j = w.order[b]
            if w.m[j] == HOLDS and not close:
                w.impulse[i] -= w.share[j, i] * w.impulse[j]
        for r in range(n_q):
            w.y[n_q + r] += (w.response[i, r] if close else w.gauge[COUPLING + n_c + r, i]) * w.impulse[i]
    return True


@compiled(inline=True)
def _worst(w, n_x, n_c, horizon, least):
    """Return the contact whose mode contradicts its forces most, or the first one, and its side; -1 if none."""
    worst, measure, side = -1, 0.0, 0
    for i in range(n_c):
        size, where = contradiction(w, n_x, i, horizon)
        if size > measure:
            worst, measure, side = i, size, where
            if least:
                break
    return worst, side


@compiled(inline=True)
def _change_contact(w, n_x, n_c, horizon, least):
    """Change the mode of the contact that contradicts its forces most; return whether there was one."""
    worst, side = _worst(w, n_x, n_c, horizon, least)
    if worst < 0:
        return False
    w.turns[worst] += 1
    if w.depends[worst] and (w.m[worst] == HOLDS or w.m[worst] == SHARES):
        if not exchange(w, n_c, worst, side, least):
            release_worst(w, n_x, n_c)
    elif w.m[worst] > 0.5:
        w.m[worst], w.m[direction(worst, n_c)] = 0.0, side
    elif w.sticks[worst]:
        w.m[worst] = FOLLOWS
    else:
        w.m[direction(worst, n_c)] = -w.m[direction(worst, n_c)]
    return True


@compiled(inline=True)
def _hold_more(w, n_x, n_c, horizon, edges):
    """Let contacts stick again that were released during the selection but that static friction can hold.

    If friction drops from rest to slip, both modes may be consistent; a contact at rest slips only if it must. Without
    an applied force it need not: with a vanishing load, or if others hold it, it stays at rest.
    """
    trials = 0
    for i in range(n_c):
        w.tried[i] = not w.zero[i] or w.m[i] > 0.5 or w.sticks[i] == 0
        trials += w.tried[i] == 0 and _may_hold(w, n_x, i)[0]
    if trials > 0:
        _try_to_hold(w, n_x, n_c, horizon)
    if edges and find_edges(w, n_x, n_c, False):  # for a contact that sticks now
        prelude(w)
        probe(w)


@compiled(inline=True)
def _may_hold(w, n_x, i):
    """Whether contact i, released at rest, may stick with its own constraint."""
    reached = w.old[i] == 0 and (w.hit[backward(i)] or w.hit[forward(i)])
    drop = w.gauge[LOAD, i] * w.gauge[DROP, i] * w.gauge[COUPLING + i, i]
    alone = idles(w, n_x + backward(i)) or (not reached and drop > NO_DROP * w.gauge[PULL, i])
    if alone or not w.depends[i] or (reached and w.carries[i] == 0):
        return alone, alone
    return rests(w, n_x + backward(i), i), False


@compiled
def _try_to_hold(w, n_x, n_c, horizon):
    """Let contacts stick that are not marked as tried, if that is consistent with the forces."""
    for i in range(n_c):
        if contradicts(w, n_x, i, horizon)[0] == 0.0:
            w.turns[i] = 0  # changes during the trial do not count
    while True:
        i = _next_to_hold(w, n_c)
        if i < 0:
            break
        w.tried[i] = 1
        if w.m[i] > 0.5:
            continue
        may, alone = _may_hold(w, n_x, i)
        if not may:
            continue
        for k in range(sign(0, n_c)):
            w.kept[k] = w.m[k]
        w.m[i] = FOLLOWS
        share(w, n_c)
        if (w.m[i] == HOLDS and not alone) or not _holds(w, n_x, n_c, horizon):
            for k in range(sign(0, n_c)):
                w.m[k] = w.kept[k]
            share(w, n_c)
            prelude(w)
            probe(w)


@compiled(inline=True)
def _next_to_hold(w, n_c):
    """Return the next contact to try: first those that stuck, then by decreasing static friction.

    If only one of two can be held, the selection must not depend on the order of the contacts.
    """
    best, first, strongest = -1, False, 0.0
    for i in range(n_c - 1, -1, -1):
        if w.tried[i]:
            continue
        stuck = w.old[i] == 0 and not (w.hit[backward(i)] or w.hit[forward(i)])
        if best < 0 or (stuck and not first) or (stuck == first and w.gauge[PULL, i] > strongest):
            best, first, strongest = i, stuck, w.gauge[PULL, i]
    return best


@compiled(inline=True)
def _holds(w, n_x, n_c, horizon):
    """Whether the trial mode is consistent with the forces, possibly after exchanges between contacts."""
    for turn in range(1 + 4 * n_c):
        prelude(w)
        probe(w)
        least = turn > 2 * n_c
        worst, side = _worst(w, n_x, n_c, horizon, least)
        if worst < 0:
            return True
        carries = w.depends[worst] and (w.m[worst] == HOLDS or w.m[worst] == SHARES)
        if not carries or not exchange(w, n_c, worst, side, least):
            return False
        share(w, n_c)
    return False


@compiled(inline=True)
def _change_switch(w, n_x, n_c, n_s, edges):
    """Flip one switch whose sign is wrong, now or, at zero, immediately after; return whether there was one."""
    if edges and find_edges(w, n_x, n_c, False):
        return True
    time = natural_time(w)
    for j in range(n_s):
        g, row = switch(j, n_c), n_x + switch(j, n_c)
        value = w.probe[row, 0]
        if w.turns[n_c + j] >= 2:
            continue
        if w.hit[g] or abs(value) <= abs(w.m[sign(j, n_c)]) * ROUNDING * w.scale[row]:
            if w.edge[j]:
                continue
            wrong = w.probe[row, decisive(w, w.probe, row, j, n_c, time)] < 0.0
        else:
            wrong = value < 0.0
        if wrong:
            w.turns[n_c + j] += 1
            w.m[sign(j, n_c)] = -w.m[sign(j, n_c)]
            w.counts.kinks += 1
            return True
    return False


@compiled(inline=True)
def _mark_fresh(w, n_x, n_c, n_s):
    """Mark the guards that start the new mode at zero, or below it within the error of the run."""
    for i in range(n_c):
        a, b = w.probe[n_x + backward(i), 0], w.probe[n_x + forward(i), 0]
        if w.m[i] == FOLLOWS or w.m[i] == AT_BOUND:
            w.fresh[backward(i)], w.fresh[forward(i)] = 1, 1
            w.slack[backward(i)], w.slack[forward(i)] = 0.0, 0.0
        elif w.m[i] > 0.5:
            scale = stick_scale(w, n_x + backward(i))
            for g, room in ((backward(i), a), (forward(i), b)):
                largest = w.scale[n_x + g] if w.carries[i] else w.other[g]
                w.fresh[g], w.slack[g] = at_bound(w, n_x + g, scale), max(0.0, -room)
                if w.fresh[g] and w.probe[n_x + g, 1] < 0.0 and tied(w, w.probe[n_x + g, 1], scale):
                    w.fresh[g], w.slack[g] = 0, 2.0 * TIE * scale - room  # it stays
                if scale <= TIE * largest or (w.hit[g] and w.carries[i]):  # zero up to the rounding of earlier values
                    w.fresh[g], w.slack[g] = 0, max(0.0, ROUNDING * max(scale, largest) - room)
        else:
            w.fresh[backward(i)] = w.zero[i]
            w.fresh[forward(i)] = 0
            w.slack[backward(i)], w.slack[forward(i)] = 0.0, 0.0
    for j in range(n_s):
        g, little = switch(j, n_c), abs(w.m[sign(j, n_c)]) * ROUNDING
        w.fresh[g] = w.hit[g] != 0 or abs(w.probe[n_x + g, 0]) <= little * w.scale[n_x + g]


@compiled(inline=True)
def keep_scales(w, n_x, n_c):
    """Exchange the scales of a contact's guards when they change between slips and forces.

    Slips and forces have different units.
    """
    for i in range(n_c):
        carries = w.m[i] == HOLDS or w.m[i] == SHARES
        if carries == (w.carries[i] != 0):
            continue
        w.carries[i] = carries
        for g in (backward(i), forward(i)):
            w.scale[n_x + g], w.other[g] = max(w.other[g], abs(w.probe[n_x + g, 0])), w.scale[n_x + g]
