"""Mode selection of scenes with contacts that open: every combination of modes is tried on the series of the motion.

A mode is right if every guard that starts at zero is positive just after, by the first of its coefficients that is not
rounding. Contacts that are apart, or slip, are not tried otherwise. Of several right modes the one in which most
contacts stick is taken, as long as the same contacts are closed or the accelerations agree; else the forces have
several solutions, and if no mode is right they have none: the paradox of Painleve.
"""

from symfric.codegen.numba_types import compiled
from symfric.lower.constraint_forces import AT_BOUND, FOLLOWS, HOLDS
from symfric.solve.loop.codes import MANY_CONTACTS, OK, OVERLAP, PAINLEVE, UNDECIDED
from symfric.solve.loop.events.impact_choice import MOST_TRIALS, next_trial, strike
from symfric.solve.loop.events.impacts import (
    LEAST,
    RESPONSE,
    SIZE,
    coupling,
    hold_exactly,
    is_open,
    overlaps,
    settle_bounces,
    settle_touches,
    told,
)
from symfric.solve.loop.events.time_steps import step_over
from symfric.solve.loop.modes.last_bounces import dies_out, time_to_rest
from symfric.solve.loop.modes.layout import backward, direction, forward
from symfric.solve.loop.modes.mode_selection import change_switch, mark_fresh
from symfric.solve.loop.modes.planes_that_open import (
    aim_starts,
    begin_planes,
    forget_arrivals,
    has_arrived,
    is_undetermined,
    plane_is_right,
    set_plane,
    take_start,
)
from symfric.solve.loop.modes.sticking_basis import share
from symfric.solve.loop.modes.tolerances import (
    doubt_of,
    doubted_acceleration,
    instant,
    natural_time,
    no_acceleration,
    stays,
)
from symfric.solve.loop.modes.zero_slips import try_sticking
from symfric.solve.loop.precision import ROUNDING
from symfric.solve.loop.stepping.calls import measure, prelude, probe
from symfric.solve.loop.workspace import LoopArrays

_DEPENDENT = 1e-13  # pivot of the coupling, relative to its diagonal, below which a slip follows from others
_SAME = 1e-9  # relative difference of accelerations up to which two modes are the same motion
_ROUNDS = 8  # most repetitions because a kink was passed


@compiled
def settle_openings(w: LoopArrays, starting: bool) -> int:
    """Apply impacts and select the mode of every contact and switch."""
    n_x, n_c = w.y.size - 1, w.contacts.sticks.size
    if w.limits.steps and w.counts.jumped:
        step_over(w, n_x, n_c)
    for r in range(n_x):
        w.impacts.entry_y[r] = w.y[r]
    for r in range(w.m.size):
        w.impacts.entry_m[r] = w.m[r]
    if w.counts.jumped and not starting and overlaps(w, n_x):
        return OVERLAP
    begin_planes(w)
    status = strike(w, n_c, starting)
    if status == OK:
        status = _select(w, n_x, n_c)
    w.clock.late = time_to_rest(w, n_x) if status == OK and not starting else 0.0
    if w.clock.late > 0.0:
        for r in range(n_x):
            w.y[r] = w.impacts.entry_y[r]
        for r in range(w.m.size):
            w.m[r] = w.impacts.entry_m[r]
        settle_bounces(w)
        status = _select(w, n_x, n_c)
    if status == OK and not starting and dies_out(w, n_x):
        settle_touches(w)
        status = _select(w, n_x, n_c)
    forget_arrivals(w)
    return status


@compiled
def _select(w: LoopArrays, n_x: int, n_c: int) -> int:
    """Select the mode of contacts that are closed or may close, and of switches."""
    for i in range(n_c):
        w.selection.passes[i] = _is_apart(w, i)
    try_sticking(w, n_x, n_c)
    for i in range(n_c):
        if _is_apart(w, i):
            w.selection.zero[i], w.m[i] = 0, 0.0
    if has_arrived(w):  # its slip is what a straight line has left of it
        hold_exactly(w)
        measure(w, w.y, w.gauge)
    return _select_modes(w, n_x, n_c)


@compiled(inline=True)
def _is_apart(w: LoopArrays, i: int) -> bool:
    """Whether contact i along a line is one that opens, and has opened."""
    k = w.contacts.opens[i]
    return k >= 0 and w.impacts.rests[k] == 0


@compiled
def _select_modes(w: LoopArrays, n_x: int, n_c: int) -> int:
    """Try modes until the switches agree with them."""
    n_s = w.contacts.edge.size
    for i in range(w.selection.turns.size):
        w.selection.turns[i] = 0
    for _ in range(_ROUNDS):
        status = _try_all(w, n_x, n_c)
        if status != OK:
            return status
        if n_s == 0 or not change_switch(w, n_x, n_c, n_s, w.limits.edges > 0):
            hold_exactly(w)
            mark_fresh(w, n_x, n_c, n_s)
            _mark_slips(w, n_x, n_c)
            return OK if _mark_openings(w, n_x) else UNDECIDED
    return UNDECIDED


@compiled
def _try_all(w: LoopArrays, n_x: int, n_c: int) -> int:
    """Try all combinations of modes; leave the right one in place."""
    n, n_q, total = w.openings.variable.size, w.limits.n_q, 1
    for k in range(n + n_c):
        w.impacts.tried[k] = 0
        w.impacts.options[k] = _options_of_opening(w, k) if k < n else _options_of_line(w, k - n)
        total *= w.impacts.options[k]
    if total > MOST_TRIALS:
        return MANY_CONTACTS
    best, several = -1, False
    for _ in range(total):
        sticking = _set(w, n, n_c)
        share(w, n_c)
        _leave_dependents(w, n_c)
        if is_undetermined(w):
            return UNDECIDED
        right = 0
        for way in range(aim_starts(w, n_x)):
            take_start(w, way)
            prelude(w)
            probe(w)
            if not (_is_right(w, n_x, n_c) and _followers_stay(w, n_x, n_c)):
                continue
            same = best >= 0 and _same_motion(w, n_q)
            if best >= 0 and not same and not _same_closed(w):
                return PAINLEVE
            several = several or (right > 0 and not same and sticking == best)
            right += 1
            if sticking > best:
                best, several = sticking, False
                for r in range(w.m.size):
                    w.impacts.found[r] = w.m[r]
                for r in range(n_q):
                    w.impacts.rates[r] = w.probe[n_q + r, 1]
        next_trial(w, n + n_c)
    if best < 0 or several:
        return PAINLEVE
    for r in range(w.m.size):
        w.m[r] = w.impacts.found[r]
    prelude(w)
    probe(w)
    return OK


@compiled
def _leave_dependents(w: LoopArrays, n_c: int) -> None:
    """Mark sticking contacts whose slip follows from gaps that are closed and from others that stick."""
    n = 0
    for j in range(w.openings.variable.size + n_c):
        k, i = j, j - w.openings.variable.size
        if (i < 0 and is_open(w, k)) or (i >= 0 and w.m[i] != HOLDS):
            continue
        w.impacts.held[n] = n_c + k if i < 0 else i
        pivot = coupling(w, w.impacts.held[n], w.impacts.held[n])
        least = _DEPENDENT * pivot
        for a in range(n):
            rest = coupling(w, w.impacts.held[n], w.impacts.held[a])
            for b in range(a):
                rest -= w.impacts.factor[n, b] * w.impacts.factor[a, b] * w.impacts.factor[b, b]
            w.impacts.factor[n, a] = rest / w.impacts.factor[a, a]
            pivot -= rest * w.impacts.factor[n, a]
        w.impacts.factor[n, n] = pivot
        if pivot > least:
            n += 1
        elif i >= 0:
            w.m[i] = FOLLOWS


@compiled(inline=True)
def _options_of_line(w: LoopArrays, i: int) -> int:
    """Return the number of modes to try of friction along a line, apart from those of a contact that opens."""
    if w.selection.zero[i] == 0 or _is_apart(w, i) or 0 <= w.contacts.partner[i] < i:
        return 1
    if w.contacts.partner[i] > i:
        return 2
    return 3 if w.contacts.sticks[i] else 2


@compiled(inline=True)
def _options_of_opening(w: LoopArrays, k: int) -> int:
    """Return the number of modes to try of a normal direction: closed, open."""
    return 2 if w.impacts.rests[k] else 1


@compiled
def _set(w: LoopArrays, n: int, n_c: int) -> int:
    """Set the modes of the present trial; return how many contacts stick or are closed."""
    held = 0
    for k in range(n):
        opens = w.impacts.rests[k] == 0 or w.impacts.tried[k] == 1
        w.m[w.openings.variable[k]] = opens
        held += not opens
    for i in range(n_c):
        if w.impacts.options[n + i] == 1:
            continue
        option, k = w.impacts.tried[n + i] + (w.contacts.sticks[i] == 0), w.contacts.opens[i]
        if w.contacts.partner[i] >= 0:
            set_plane(w, i, k >= 0 and is_open(w, k), option == 0)
            held += option == 0 and not (k >= 0 and is_open(w, k))
            continue
        if k >= 0 and is_open(w, k):
            w.m[i], w.m[direction(i, n_c)] = 0.0, 1.0
            continue
        w.m[i] = FOLLOWS if option == 0 else 0.0
        w.m[direction(i, n_c)] = -1.0 if option == 2 else 1.0
        held += option == 0
    return held


@compiled
def _is_right(w: LoopArrays, n_x: int, n_c: int) -> bool:
    """Whether no guard that starts at zero contradicts the trial mode."""
    time, now = natural_time(w), instant(w)
    for k in range(w.openings.variable.size):
        if w.impacts.rests[k] == 0:
            continue
        g, little = n_x + w.limits.first_opening + 2 * k, ROUNDING * told(w, LEAST, k)
        if is_open(w, k):
            little *= told(w, RESPONSE, k)
            a, b, c = 2.0 * w.probe[g, 2], 6.0 * w.probe[g, 3], 0.0
        else:
            a, b, c = w.probe[g + 1, 0], w.probe[g + 1, 1], 2.0 * w.probe[g + 1, 2]
        if not stays(a, b, c, little, time, now):
            return False
    for i in range(n_c):
        k = w.contacts.opens[i]
        if k >= 0 and is_open(w, k):
            if w.impacts.rests[k] and w.impacts.tried[w.openings.variable.size + i] > 0:
                return False  # the same mode as without slip
            continue
        if w.contacts.partner[i] >= 0:
            if w.contacts.partner[i] > i and not plane_is_right(w, n_x, i, time, now):
                return False
            continue
        if w.m[i] == FOLLOWS or w.m[i] == AT_BOUND:
            continue
        if w.m[i] > 0.5:
            for g in (n_x + backward(i), n_x + forward(i)):
                room, change, bend = w.probe[g, 0], w.probe[g, 1], 2.0 * w.probe[g, 2]
                if not stays(room, change, bend, doubt_of(w, i), time, now):
                    return False
        elif w.selection.zero[i]:
            g = n_x + backward(i)
            a, b, c = w.probe[g, 1], 2.0 * w.probe[g, 2], 6.0 * w.probe[g, 3]
            if not stays(a, b, c, doubted_acceleration(w, i, b), time, now):
                return False
    return True


@compiled
def _followers_stay(w: LoopArrays, n_x: int, n_c: int) -> bool:
    """Whether slips that are zero because they follow from others stay so: the gap they follow from may move."""
    time, now, probed, stay = natural_time(w), instant(w), False, True
    for i in range(n_c):
        if w.m[i] != FOLLOWS or w.contacts.partner[i] >= 0:
            continue
        w.m[i] = 0.0  # its friction does not change the motion that the others determine
        prelude(w)
        probe(w)
        w.m[i] = FOLLOWS
        g, probed = n_x + backward(i), True
        a, b, c = w.probe[g, 1], 2.0 * w.probe[g, 2], 6.0 * w.probe[g, 3]
        little = no_acceleration(w, i, b) + abs(b) * now
        stay = stay and abs(a) <= little and abs(b) * time <= little and abs(c) * time * time <= little
    if probed:
        prelude(w)
        probe(w)
    return stay


@compiled
def _same_closed(w: LoopArrays) -> bool:
    """Whether the same contacts are closed as in the mode found before."""
    for k in range(w.openings.variable.size):
        v = w.openings.variable[k]
        if w.m[v] != w.impacts.found[v]:
            return False
    return True


@compiled
def _same_motion(w: LoopArrays, n_q: int) -> bool:
    """Whether the accelerations are those of the mode found before."""
    scale = 0.0
    for k in range(w.openings.variable.size):
        scale = max(scale, told(w, LEAST, k) * told(w, RESPONSE, k))
    for r in range(n_q):
        new, old = w.probe[n_q + r, 1], w.impacts.rates[r]
        if abs(new - old) > _SAME * (abs(new) + abs(old)) + ROUNDING * scale:
            return False
    return True


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
