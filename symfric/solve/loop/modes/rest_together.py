"""Mode selection of contacts in the plane at rest whose forces are not unique, beside contacts that open.

Which gaps stay closed is tried. With these gaps held, the contacts at rest are decided on as without any that open, see
`symfric.solve.loop.modes.planes`, with friction bounded by the normal forces. While all of them stick these do not
depend on how friction is shared; once some slip they do, and are computed again until they agree, the fixed point of
Coulomb friction with given bounds: one answer, which is the only one as long as normal forces and friction affect each
other weakly.

References
----------
Haslinger, Approximation of the Signorini problem with friction, obeying the Coulomb law, Mathematical Methods in the
Applied Sciences 5 (1983) 422. Acary, Cadoux, Lemarechal, Malick, A formulation of the linear discrete Coulomb friction
problem via convex optimization, ZAMM 91 (2011) 155.
"""

from symfric.codegen.numba_types import compiled
from symfric.lower.constraint_forces import FOLLOWS
from symfric.solve.loop.codes import COUPLING, MANY_CONTACTS, OK, PAINLEVE, UNDECIDED
from symfric.solve.loop.events.impacts import MOST_TRIALS, coupling, is_open
from symfric.solve.loop.modes.closed_gaps import measure_held, take_bounds
from symfric.solve.loop.modes.layout import turn
from symfric.solve.loop.modes.planes import decide, turns_round
from symfric.solve.loop.modes.same_slips import undecided
from symfric.solve.loop.modes.sticking_basis import share
from symfric.solve.loop.modes.tolerances import instant, natural_time
from symfric.solve.loop.modes.trial_modes import is_another, is_wrong, keep_found
from symfric.solve.loop.stepping.calls import prelude, probe
from symfric.solve.loop.workspace import LoopArrays

_REPEATED = 200  # most computations of normal forces
_ROUNDS = 2  # most times a contact turns round, in numbers of contacts
_DEPENDENT = 1e-12  # coupling that closed gaps leave of a slip, relative, below which it follows from theirs


@compiled
def rest_together(w: LoopArrays, n_x: int, n_c: int) -> int:
    """Select the modes of what is closed or at rest; return a status."""
    n, choices = w.openings.variable.size, 1.0
    for k in range(n):
        choices *= 2.0 if w.impacts.rests[k] else 1.0
    if choices > MOST_TRIALS:
        return MANY_CONTACTS
    most, best, status = -1, -1, PAINLEVE
    for trial in range(int(choices)):
        _open(w, n_c, trial)
        if not _is_measured(w, n_c):
            return UNDECIDED
        outcome = _try(w, n_x, n_c)
        if outcome == UNDECIDED:
            status = UNDECIDED
        if outcome != OK:
            continue
        if best >= 0 and is_another(w, w.limits.n_q):
            return PAINLEVE
        held = _held(w, n_c)
        if held > most:
            most, best = held, trial
            keep_found(w, w.limits.n_q)
    if best < 0:
        return status
    _open(w, n_c, best)
    _is_measured(w, n_c)
    return _try(w, n_x, n_c)


@compiled
def _try(w: LoopArrays, n_x: int, n_c: int) -> int:
    """Select the modes with the closed gaps held; return OK, UNDECIDED, or PAINLEVE if the gaps contradict it."""
    _press(w, n_x, n_c)
    for _ in range(_REPEATED):
        status = _settle(w, n_x, n_c)
        if status != OK:
            return status
        if not take_bounds(w, n_x, n_c):
            break
    else:
        return UNDECIDED
    time, now = natural_time(w), instant(w)
    for k in range(w.openings.variable.size):
        if is_wrong(w, n_x, k, time, now):
            return PAINLEVE
    return OK


@compiled
def _open(w: LoopArrays, n_c: int, trial: int) -> None:
    """Open the contacts of a trial: one bit of every contact that touches."""
    for k in range(w.openings.variable.size):
        opens = w.impacts.rests[k] == 0 or trial % 2 == 1
        trial = trial // 2 if w.impacts.rests[k] else trial
        w.m[w.openings.variable[k]] = opens
    for i in range(n_c):
        k = w.contacts.opens[i]
        if k >= 0 and is_open(w, k):
            w.m[i] = 0.0
            turn(w, i, 1.0)


@compiled
def _is_measured(w: LoopArrays, n_c: int) -> bool:
    """Measure with the closed gaps; return whether normal forces are unique and no slip follows from gaps alone."""
    unique = measure_held(w, n_c)
    for i in range(n_c):
        unique = unique and not (undecided(w, i) and w.gauge[COUPLING + i, i] <= _DEPENDENT * coupling(w, i, i))
    return unique


@compiled
def _press(w: LoopArrays, n_x: int, n_c: int) -> None:
    """Compute the normal forces while all contacts at rest stick, and the bounds by them."""
    for i in range(n_c):
        w.planes.slides[i] = 0
        if undecided(w, i):
            w.m[i] = FOLLOWS
    share(w, n_c)
    prelude(w)
    probe(w)
    take_bounds(w, n_x, n_c)


@compiled
def _settle(w: LoopArrays, n_x: int, n_c: int) -> int:
    """Select the modes of contacts at rest with the present bounds; return a status."""
    for _ in range(1 + _ROUNDS * n_c):
        status = decide(w, n_x, n_c)
        if status != OK or not turns_round(w, n_x, n_c):
            return status
    return UNDECIDED


@compiled
def _held(w: LoopArrays, n_c: int) -> int:
    """Return how many contacts are closed or stick."""
    held = 0
    for k in range(w.openings.variable.size):
        held += not is_open(w, k)
    for i in range(n_c):
        held += w.m[i] > 0.5
    return held
