"""Trial modes of scenes with contacts that open: every combination of modes is tried on the series of the motion.

A mode is right if every guard that starts at zero is positive just after, by the first of its coefficients that is not
rounding. Contacts that are apart, or slip, are not tried otherwise. Of several right modes the one in which most
contacts stick is taken, as long as the same contacts are closed or the accelerations agree; else the forces have
several solutions, and if no mode is right they have none: the paradox of Painleve.
"""

from symfric.codegen.numba_types import compiled
from symfric.lower.constraint_forces import AT_BOUND, FOLLOWS, HOLDS
from symfric.solve.loop.codes import MANY_CONTACTS, OK, PAINLEVE
from symfric.solve.loop.events.impacts import LEAST, MOST_TRIALS, RESPONSE, coupling, is_open, next_trial, told
from symfric.solve.loop.modes.layout import backward, direction, forward
from symfric.solve.loop.modes.planes_that_open import (
    aim_starts,
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
from symfric.solve.loop.precision import ROUNDING
from symfric.solve.loop.stepping.calls import prelude, probe
from symfric.solve.loop.workspace import LoopArrays

_DEPENDENT = 1e-13  # pivot of the coupling, relative to its diagonal, below which a slip follows from others
_SAME = 1e-9  # relative difference of accelerations up to which two modes are the same motion
STICKS, FORWARD, BACKWARD, RIGHT = 0, 1, 2, 3  # options of a contact along a line; 3 is none


@compiled(inline=True)
def is_apart(w: LoopArrays, i: int) -> bool:
    """Whether contact i along a line is one that opens, and has opened."""
    k = w.contacts.opens[i]
    return k >= 0 and w.impacts.rests[k] == 0


@compiled
def lay_out_trials(w: LoopArrays, n_c: int) -> float:
    """Lay out the combinations of modes, and begin with what is closed and sticks; return their number."""
    n, total = w.openings.variable.size, 1.0
    for k in range(n + n_c):
        w.impacts.tried[k] = 0
        w.impacts.options[k] = _options_of_opening(w, k) if k < n else _options_of_line(w, k - n)
        total *= w.impacts.options[k]
    return total


@compiled
def rests_undetermined(w: LoopArrays, n_c: int) -> bool:
    """Whether contacts in the plane at rest have forces that are not unique, as long as all of them stick."""
    if w.planes.row.size == 0:
        return False
    lay_out_trials(w, n_c)
    _try_forces(w, n_c)
    return is_undetermined(w)


@compiled
def try_modes(w: LoopArrays, n_x: int, n_c: int) -> int:
    """Try all combinations of modes; leave the right one in place."""
    n, n_q, total = w.openings.variable.size, w.limits.n_q, lay_out_trials(w, n_c)
    if total > MOST_TRIALS:
        return MANY_CONTACTS
    best, several = -1, False
    for _ in range(int(total)):
        sticking = _try_forces(w, n_c)
        right = 0
        for start in range(aim_starts(w, n_x)):
            take_start(w, start)
            prelude(w)
            probe(w)
            if not (_is_right(w, n_x, n_c) and leaver(w, n_x, n_c) < 0):
                continue
            if best >= 0 and is_another(w, n_q):
                return PAINLEVE
            several = several or (right > 0 and sticking == best and not _same_motion(w, n_q))
            right += 1
            if sticking > best:
                best, several = sticking, False
                keep_found(w, n_q)
        next_trial(w, n + n_c)
    if best < 0 or several:
        return PAINLEVE
    take_found(w)
    return OK


@compiled
def try_mode(w: LoopArrays, n_c: int) -> int:
    """Compute the series in the present trial mode; return how many contacts stick or are closed in it."""
    held = _try_forces(w, n_c)
    prelude(w)
    probe(w)
    return held


@compiled
def _try_forces(w: LoopArrays, n_c: int) -> int:
    """Set the present trial mode and the forces of what sticks in it; return how many contacts stick or are closed."""
    held = _set(w, w.openings.variable.size, n_c)
    share(w, n_c)
    _leave_dependents(w, n_c)
    return held


@compiled
def is_another(w: LoopArrays, n_q: int) -> bool:
    """Whether the present mode and the one found before are two solutions: others are closed, and motions differ."""
    return not _same_closed(w) and not _same_motion(w, n_q)


@compiled
def keep_found(w: LoopArrays, n_q: int) -> None:
    """Keep the present mode and its accelerations as those found."""
    for r in range(w.m.size):
        w.impacts.chosen[r] = w.m[r]
    for r in range(n_q):
        w.impacts.rates[r] = w.probe[n_q + r, 1]


@compiled
def take_found(w: LoopArrays) -> None:
    """Set the mode that was found."""
    for r in range(w.m.size):
        w.m[r] = w.impacts.chosen[r]
    prelude(w)
    probe(w)


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
    if w.selection.zero[i] == 0 or is_apart(w, i) or 0 <= w.contacts.partner[i] < i:
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
    """Whether no guard that starts at zero contradicts the trial mode, which is no other one written twice."""
    time, now, n = natural_time(w), instant(w), w.openings.variable.size
    for k in range(n):
        if is_wrong(w, n_x, k, time, now):
            return False
    for i in range(n_c):
        k = w.contacts.opens[i]
        if k >= 0 and is_open(w, k):
            if w.impacts.rests[k] and w.impacts.tried[n + i] > 0:
                return False  # the same mode as without slip
        elif w.contacts.partner[i] >= 0:
            if w.contacts.partner[i] > i and not plane_is_right(w, n_x, i, time, now):
                return False
        elif way_out(w, n_x, i, time, now) != RIGHT:
            return False
    return True


@compiled
def is_wrong(w: LoopArrays, n_x: int, k: int, time: float, now: float) -> bool:
    """Whether the guard of contact k that opens contradicts the trial mode."""
    if w.impacts.rests[k] == 0:
        return False
    g, little = n_x + w.limits.first_opening + 2 * k, ROUNDING * told(w, LEAST, k)
    if is_open(w, k):
        little *= told(w, RESPONSE, k)
        a, b, c = 2.0 * w.probe[g, 2], 6.0 * w.probe[g, 3], 0.0
    else:
        a, b, c = w.probe[g + 1, 0], w.probe[g + 1, 1], 2.0 * w.probe[g + 1, 2]
    return not stays(a, b, c, little, time, now)


@compiled
def way_out(w: LoopArrays, n_x: int, i: int, time: float, now: float) -> int:
    """Return what contact i along a line does against the trial mode: STICKS, FORWARD or BACKWARD, or RIGHT."""
    if w.m[i] == FOLLOWS or w.m[i] == AT_BOUND:
        return RIGHT
    if w.m[i] > 0.5:
        for g, out in ((n_x + backward(i), BACKWARD), (n_x + forward(i), FORWARD)):
            room, change, bend = w.probe[g, 0], w.probe[g, 1], 2.0 * w.probe[g, 2]
            if not stays(room, change, bend, doubt_of(w, i), time, now):
                return out
    elif w.selection.zero[i]:
        g = n_x + backward(i)
        a, b, c = w.probe[g, 1], 2.0 * w.probe[g, 2], 6.0 * w.probe[g, 3]
        if not stays(a, b, c, doubted_acceleration(w, i, b), time, now):
            return STICKS
    return RIGHT


@compiled
def leaver(w: LoopArrays, n_x: int, n_c: int) -> int:
    """Return a contact whose slip is zero because it follows from others, and does not stay so: the gap may move.

    It is -1 if there is none, and the direction of the slip that of its guard.
    """
    time, now, probed, first = natural_time(w), instant(w), False, -1
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
        if not (abs(a) <= little and abs(b) * time <= little and abs(c) * time * time <= little):
            first = i
            break
    if probed:
        prelude(w)
        probe(w)
    return first


@compiled
def _same_closed(w: LoopArrays) -> bool:
    """Whether the same contacts are closed as in the mode found before."""
    for k in range(w.openings.variable.size):
        v = w.openings.variable[k]
        if w.m[v] != w.impacts.chosen[v]:
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
