"""Contacts at rest that were released during mode selection although static friction can hold them."""

from symfric.codegen.numba_types import compiled
from symfric.lower.constraint_forces import AT_BOUND, FOLLOWS, HOLDS, SHARES
from symfric.solve.loop.codes import COUPLING, DROP, LOAD, PULL
from symfric.solve.loop.modes.contradiction import contradicts, idles, rests, stick_scale, worst_contact
from symfric.solve.loop.modes.layout import backward, direction, forward, mode, sign
from symfric.solve.loop.modes.resting_edges import find_edges
from symfric.solve.loop.modes.sticking_basis import exchange, share
from symfric.solve.loop.stepping.calls import prelude, probe
from symfric.solve.loop.workspace import LoopArrays

NO_DROP = 1e-9  # relative drop of friction from rest to slip below which there is none
_CLEARLY = 1e-9  # distance of a force from its bound, relative to both, that is no error of an event's time


@compiled(inline=True)
def hold_more(w: LoopArrays, n_x: int, n_c: int, horizon: float, edges: bool) -> None:
    """Let contacts stick again that were released during the selection but that static friction can hold.

    If friction drops from rest to slip, both modes may be consistent; a contact at rest slips only if it must. Without
    an applied force it need not: with a vanishing load, or if others hold it, it stays at rest. One that reached its
    bound need not either if others that slip now let go of a part of its force.
    """
    trials = 0
    for i in range(n_c):
        w.selection.tried[i] = not w.selection.zero[i] or w.m[i] > 0.5 or w.contacts.sticks[i] == 0
        trials += w.selection.tried[i] == 0 and _may_hold(w, n_x, n_c, i)[0]
    if trials > 0:
        _try_to_hold(w, n_x, n_c, horizon)
    if edges and find_edges(w, n_x, n_c, False):  # for a contact that sticks now
        prelude(w)
        probe(w)


@compiled(inline=True)
def _may_hold(w: LoopArrays, n_x: int, n_c: int, i: int) -> tuple[bool, bool]:
    """Whether contact i, released at rest, may stick again, and whether it may with its own constraint."""
    reached = _reached(w, i)
    drop = w.gauge[LOAD, i] * w.gauge[DROP, i] * w.gauge[COUPLING + i, i]
    relieved = not reached or (w.limits.coupled and _others_changed(w, n_c, i))
    alone = idles(w, n_x + backward(i)) or (relieved and drop > NO_DROP * w.gauge[PULL, i])
    if alone or not w.contacts.depends[i] or (_hit(w, i) and w.guards.carries[i] == 0):
        return bool(alone), bool(alone)
    return rests(w, n_x + backward(i), i), False


@compiled(inline=True)
def _reached(w: LoopArrays, i: int) -> bool:
    """Whether contact i stuck before the event and its force was at its bound."""
    return _hit(w, i) or bool(w.selection.old[i] == 0 and w.limits.coupled and w.selection.entry_m[i] == AT_BOUND)


@compiled(inline=True)
def _hit(w: LoopArrays, i: int) -> bool:
    """Whether contact i stuck before the event and its guard fell there."""
    return bool(w.selection.old[i] == 0 and (w.guards.hit[backward(i)] or w.guards.hit[forward(i)]))


@compiled
def _others_changed(w: LoopArrays, n_c: int, i: int) -> bool:
    """Whether the mode of a contact other than i changes at the event, and with it forces."""
    found = False
    for j in range(n_c):
        found = found or (j != i and w.selection.zero[j] and mode(w, j) != w.selection.old[j])
    return found


@compiled
def _try_to_hold(w: LoopArrays, n_x: int, n_c: int, horizon: float) -> None:
    """Let contacts stick that are not marked as tried, if that is consistent with the forces."""
    for i in range(n_c):
        if contradicts(w, n_x, i, horizon)[0] == 0.0:
            w.selection.turns[i] = 0  # changes during the trial do not count
    while True:
        i = _next_to_hold(w, n_c)
        if i < 0:
            break
        w.selection.tried[i] = 1
        if w.m[i] > 0.5:
            continue
        may, alone = _may_hold(w, n_x, n_c, i)
        if not may:
            continue
        loaded = not idles(w, n_x + backward(i))
        for k in range(sign(0, n_c)):
            w.selection.kept[k] = w.m[k]
        w.m[i] = FOLLOWS
        share(w, n_c)
        if alone and w.m[i] == HOLDS:
            _hold_followers(w, n_c, i)
        holds = (w.m[i] != HOLDS or alone) and _holds(w, n_x, n_c, horizon)
        if not holds or (loaded and _reached(w, i) and not _is_clear(w, n_x, n_c)):
            for k in range(sign(0, n_c)):
                w.m[k] = w.selection.kept[k]
            share(w, n_c)
            prelude(w)
            probe(w)


@compiled
def _hold_followers(w: LoopArrays, n_c: int, i: int) -> None:
    """Let the contacts at rest stick whose slips follow from those that stick: they may bear a part of the forces.

    Contacts parallel to contact i, which sticks on trial, are among them.
    """
    for j in range(n_c):
        follows = w.contacts.depends[j] or w.contacts.parallel[j] == w.contacts.parallel[i]
        if w.selection.zero[j] and w.m[j] < 0.5 and w.contacts.sticks[j] and follows:
            w.m[j] = FOLLOWS
            share(w, n_c)
            if w.m[j] == HOLDS:
                w.m[j] = 0.0
    share(w, n_c)


@compiled(inline=True)
def _next_to_hold(w: LoopArrays, n_c: int) -> int:
    """Return the next contact to try: first those that stuck, then by decreasing static friction.

    If only one of two can be held, the selection must not depend on the order of the contacts.
    """
    best, first, strongest = -1, False, 0.0
    for i in range(n_c - 1, -1, -1):
        if w.selection.tried[i]:
            continue
        stuck = w.selection.old[i] == 0 and not _reached(w, i)
        if best < 0 or (stuck and not first) or (stuck == first and w.gauge[PULL, i] > strongest):
            best, first, strongest = i, stuck, w.gauge[PULL, i]
    return best


@compiled(inline=True)
def _holds(w: LoopArrays, n_x: int, n_c: int, horizon: float) -> bool:
    """Whether the trial mode is consistent with the forces, possibly after exchanges between contacts.

    Contacts that slipped before the trial may slip the other way.
    """
    for turn in range(1 + 4 * n_c):
        prelude(w)
        probe(w)
        least = turn > 2 * n_c
        worst, side, _ = worst_contact(w, n_x, n_c, horizon, least)
        if worst < 0:
            return True
        if w.m[worst] == HOLDS or w.m[worst] == SHARES:
            if not w.contacts.depends[worst] or not exchange(w, n_c, worst, side, least):
                return False
        elif w.selection.kept[worst] > 0.5:
            return False
        elif w.m[worst] > 0.5:  # it was tried as a follower, and slips
            w.m[worst], w.m[direction(worst, n_c)] = 0.0, side
        elif w.contacts.sticks[worst]:
            w.m[worst] = FOLLOWS
        else:
            return False
        share(w, n_c)
    return False


@compiled
def _is_clear(w: LoopArrays, n_x: int, n_c: int) -> bool:
    """Whether the forces that hold contacts at rest are clearly within their bounds, not where the event found them."""
    for j in range(n_c):
        if w.m[j] == HOLDS or w.m[j] == SHARES:
            room = min(w.probe[n_x + backward(j), 0], w.probe[n_x + forward(j), 0])
            if not room > _CLEARLY * stick_scale(w, n_x + backward(j)):
                return False
    return True
