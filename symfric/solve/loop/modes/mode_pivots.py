"""Modes of many contacts that open, whose combinations are too many to be tried.

A trial mode is changed where its guards contradict it: everywhere at once as long as that leaves fewer contradictions,
then one contact at a time. It starts from the solution of the complementarity problem of the accelerations, by
`symfric.solve.loop.modes.complementarity`; the series of the motion decide. Where friction may permit several solutions
others are looked for from another solution and from the mode before the event: two that are found are the paradox of
Painleve, while one alone need not be the only one.

References
----------
Judice and Pires, A block principal pivoting algorithm for large-scale strictly monotone linear complementarity
problems, Computers & Operations Research 21 (1994) 587.
"""

from symfric.codegen.numba_types import compiled
from symfric.solve.loop.codes import COUPLING, DROP, LOAD, MANY_CONTACTS, OK, PAINLEVE, PULL
from symfric.solve.loop.events.impacts import KINETIC, STATIC, ask_exactly, coupling, is_open, told_exactly
from symfric.solve.loop.modes.complementarity import solve_contacts
from symfric.solve.loop.modes.layout import backward, way
from symfric.solve.loop.modes.tolerances import instant, natural_time
from symfric.solve.loop.modes.trial_modes import (
    BACKWARD,
    FORWARD,
    RIGHT,
    STICKS,
    is_another,
    is_apart,
    is_wrong,
    keep_found,
    leaver,
    take_found,
    try_mode,
    way_out,
)
from symfric.solve.loop.workspace import LoopArrays

_PATIENCE = 3  # changes of all contacts at once that may leave as many contradictions as there were
_CHANGES = 2  # most changes of a mode, in numbers of contacts
_RAYS = 2  # starts of Lemke's method


@compiled
def pivot_modes(w: LoopArrays, n_x: int, n_c: int) -> int:
    """Find the modes; leave the right one in place."""
    n, n_q, found, rubs = w.openings.variable.size, w.limits.n_q, False, _rubs(w, n_c)
    for k in range(n):
        w.pivots.apart[k] = w.m[w.openings.variable[k]] > 0.5 and w.impacts.struck[k] == 0
    _lay_out(w, n_x, n_c)
    for start in range(_RAYS + 1):
        if found and not rubs:
            break
        if start < _RAYS and not solve_contacts(w, 1.0 * start):
            continue
        if start < _RAYS:
            _take_solution(w, n_c)
        else:
            _take_present(w, n, n_c)
        if not _change(w, n_x, n_c):
            continue
        if found and is_another(w, n_q):
            return PAINLEVE
        if not found:
            _hold_more(w, n_x, n_c)
            keep_found(w, n_q)
            found = True
    if not found:
        return MANY_CONTACTS
    take_found(w)
    return OK


@compiled
def _take_present(w: LoopArrays, n: int, n_c: int) -> None:
    """Set the trial mode before the event, in which contacts that have struck are closed and others at rest stick."""
    for k in range(n):
        w.impacts.tried[k] = w.impacts.options[k] > 1 and w.pivots.apart[k] != 0
    for i in range(n_c):
        w.impacts.tried[n + i] = 0


@compiled
def _rubs(w: LoopArrays, n_c: int) -> bool:
    """Whether a contact that opens and may be closed has friction."""
    rubs = False
    for i in range(n_c):
        rubs = rubs or (w.contacts.opens[i] >= 0 and not is_apart(w, i))
    return rubs


@compiled
def _change(w: LoopArrays, n_x: int, n_c: int) -> bool:
    """Change the trial mode until nothing contradicts it; return whether that ends."""
    n = w.openings.variable.size
    least, patience = n + n_c + 1, _PATIENCE
    for _ in range(_CHANGES * (n + n_c)):
        try_mode(w, n_c)
        wrong = _mark(w, n_x, n_c)
        if wrong == 0:
            return True
        if wrong < least:
            least, patience = wrong, _PATIENCE
        elif patience > 0:
            patience -= 1
        else:
            _mark_last(w)
        _turn(w, n, n_c)
    return False


@compiled
def _mark(w: LoopArrays, n_x: int, n_c: int) -> int:
    """Mark the contacts that contradict the trial mode; return their number."""
    n, wrong, time, now = w.openings.variable.size, 0, natural_time(w), instant(w)
    for k in range(n):
        w.pivots.wrong[k] = is_wrong(w, n_x, k, time, now)
        w.pivots.instead[k] = not is_open(w, k)
        wrong += w.pivots.wrong[k]
    for i in range(n_c):
        k, out = w.contacts.opens[i], RIGHT
        if k < 0 or not is_open(w, k):
            out = way_out(w, n_x, i, time, now)
        if out == STICKS and w.contacts.sticks[i] == 0:
            out = BACKWARD if way(w, i) > 0.0 else FORWARD
        w.pivots.wrong[n + i], w.pivots.instead[n + i] = out != RIGHT, out
        wrong += out != RIGHT
    if wrong == 0:
        i = leaver(w, n_x, n_c)
        if i >= 0:
            rises = w.probe[n_x + backward(i), 1] > 0.0
            w.pivots.wrong[n + i], w.pivots.instead[n + i], wrong = 1, FORWARD if rises else BACKWARD, 1
    return wrong


@compiled
def _mark_last(w: LoopArrays) -> None:
    """Leave only the last of the marks."""
    found = False
    for a in range(w.pivots.wrong.size - 1, -1, -1):
        if found:
            w.pivots.wrong[a] = 0
        found = found or w.pivots.wrong[a] != 0


@compiled
def _turn(w: LoopArrays, n: int, n_c: int) -> None:
    """Change the marked contacts in the trial mode."""
    for k in range(n):
        if w.pivots.wrong[k]:
            w.impacts.tried[k] = w.pivots.instead[k]
            if w.openings.line[k] >= 0:
                w.impacts.tried[n + w.openings.line[k]] = 0
    for i in range(n_c):
        if w.pivots.wrong[n + i]:
            _try(w, n, i, w.pivots.instead[n + i])


@compiled(inline=True)
def _try(w: LoopArrays, n: int, i: int, option: int) -> None:
    """Let contact i along a line stick, or slip forwards or backwards, in the trial mode."""
    w.impacts.tried[n + i] = option if w.contacts.sticks[i] else max(0, option - 1)


@compiled
def _hold_more(w: LoopArrays, n_x: int, n_c: int) -> None:
    """Let contacts that begin to slip stick, one after the other, where the mode stays right."""
    n = w.openings.variable.size
    for i in range(n_c):
        old = w.impacts.tried[n + i]
        if w.impacts.options[n + i] > 1 and w.contacts.sticks[i] and old > 0:
            w.impacts.tried[n + i] = 0
            try_mode(w, n_c)
            if _mark(w, n_x, n_c) > 0:
                w.impacts.tried[n + i] = old
    try_mode(w, n_c)


@compiled
def _lay_out(w: LoopArrays, n_x: int, n_c: int) -> None:
    """Lay out the accelerations without the forces of contacts at rest for the method of pivots."""
    n = w.openings.variable.size
    ask_exactly(w, w.y)
    for k in range(n):
        w.impacts.tried[k] = w.impacts.options[k] - 1
    for i in range(n_c):
        _try(w, n, i, FORWARD if w.contacts.opens[i] < 0 and w.impacts.options[n + i] > 1 else STICKS)
    try_mode(w, n_c)
    for k in range(n):
        i = w.openings.line[k]
        w.pivots.takes[n_c + k] = w.impacts.rests[k]
        w.pivots.free[n_c + k] = 2.0 * w.probe[n_x + w.limits.first_opening + 2 * k, 2]
        slips = i >= 0 and w.selection.zero[i] == 0
        w.pivots.drag[k] = way(w, i) * told_exactly(w, KINETIC, k) if slips else 0.0
    for i in range(n_c):
        k = w.contacts.opens[i]
        w.pivots.takes[i] = w.impacts.options[n + i] > 1
        w.pivots.free[i] = w.probe[n_x + backward(i), 1]
        if k >= 0:
            w.pivots.static[i], w.pivots.kinetic[i] = told_exactly(w, STATIC, k), told_exactly(w, KINETIC, k)
        else:
            both, more = w.gauge[PULL, i] / w.gauge[COUPLING + i, i], w.gauge[DROP, i] * w.gauge[LOAD, i]
            w.pivots.static[i], w.pivots.kinetic[i] = 0.5 * (both + more), 0.5 * (both - more)
    for i in range(n_c):
        if w.pivots.takes[i] and w.contacts.opens[i] < 0:  # it slips forwards in this mode
            for a in range(n_c + n):
                w.pivots.free[a] += coupling(w, a, i) * w.pivots.kinetic[i]


@compiled
def _take_solution(w: LoopArrays, n_c: int) -> None:
    """Set the trial mode that the method of pivots has found."""
    n = w.openings.variable.size
    for k in range(n):
        w.impacts.tried[k] = w.impacts.options[k] > 1 and w.pivots.kind[n_c + k] == 0
    for i in range(n_c):
        k, slip = w.contacts.opens[i], w.pivots.kind[i]
        still = w.impacts.options[n + i] == 1 or slip == 0 or (k >= 0 and w.impacts.tried[k])
        _try(w, n, i, STICKS if still else (FORWARD if slip > 0 else BACKWARD))
