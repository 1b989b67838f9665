"""Mode selection of scenes with contacts in the plane: which contacts at rest stay, and where the others start to.

With the friction forces ``lambda`` of the contacts at rest, their slips have the accelerations ``a + A lambda``, with
``A = J M^-1 J^T`` and a those without these forces. Of all forces within the bounds, discs ``|lambda_i| <= B_i`` in the
plane and intervals along a line, those that hold are the ones of

    minimal  lambda^T A lambda/2 + a^T lambda:

a contact inside its bound has no acceleration, one on its bound accelerates against its force. The problem is convex,
so the accelerations are unique. It is solved contact by contact, each exactly, until nothing changes.

The bounds are the static ones. A contact that is accelerated nevertheless slips, with its kinetic bound, which may
release further ones; one that would come to rest under its kinetic bound is held again. A contact on its bound without
an acceleration is decided by the next derivative.
"""

import numpy as np

from symfric.codegen.numba_types import compiled
from symfric.lower.constraint_forces import FOLLOWS, HOLDS
from symfric.lower.planes import SINCE, STARTS
from symfric.solve.loop.codes import COUPLING, OK, UNDECIDED
from symfric.solve.loop.events.time_steps import step_over
from symfric.solve.loop.modes.closed_gaps import take_bounds
from symfric.solve.loop.modes.contradiction import contradiction
from symfric.solve.loop.modes.feet import accelerate
from symfric.solve.loop.modes.feet_forces import (
    carry,
    forget_limit,
    gives_way,
    leave_at_limit,
    rate_of_start,
    tell_forces,
)
from symfric.solve.loop.modes.feet_slips import are_redundant, slip_of
from symfric.solve.loop.modes.layout import backward, forward, turn, way
from symfric.solve.loop.modes.mode_selection import change_switch, loads_hold, mark_fresh
from symfric.solve.loop.modes.resting_edges import find_edges
from symfric.solve.loop.modes.same_slips import (
    component,
    is_second,
    join,
    leave_together,
    ratio,
    shares,
    undecided,
)
from symfric.solve.loop.modes.sticking_basis import share
from symfric.solve.loop.modes.tolerances import doubt_of, little
from symfric.solve.loop.modes.zero_slips import has_slid, try_sticking
from symfric.solve.loop.precision import EPS, ROUNDING
from symfric.solve.loop.stepping.calls import prelude, probe
from symfric.solve.loop.workspace import LoopArrays

_SWEEPS = 5000  # most repetitions over all contacts
_ROOT = 60  # most Newton steps of one contact, each nearer from the same side
_ROUNDS = 8  # most repetitions because kinks were passed
_MORE = 2  # and for each kink and contact, because one is passed or turns round at a time
_RETURNS = 3  # how often a contact that started may be held again


@compiled
def select_in_plane(w: LoopArrays) -> int:
    """Select the mode of every contact and switch at the current state; return a status."""
    n_x, n_c = w.y.size - 1, w.contacts.sticks.size
    n_s = w.contacts.edge.size
    if w.counts.jumped == 0 and has_slid(w, n_x):
        return UNDECIDED
    if w.limits.steps and w.counts.jumped:
        step_over(w, n_x, n_c)
    try_sticking(w, n_x, n_c)
    for k in range(w.planes.arrived.size):
        w.planes.arrived[k] = 0
    status = loads_hold(w, n_x, n_c)
    if status != OK:
        return status
    for i in range(w.selection.turns.size):
        w.selection.turns[i] = 0
    edges = w.limits.edges > 0
    take_bounds(w, n_x, n_c)
    for attempt in range(_ROUNDS + _MORE * (n_s + n_c)):
        status = decide(w, n_x, n_c)
        if status != OK:
            return status
        if turns_round(w, n_x, n_c):
            continue
        if attempt == 0 and edges and find_edges(w, n_x, n_c, True):
            continue
        if n_s == 0 or not change_switch(w, n_x, n_c, n_s, edges):
            mark_fresh(w, n_x, n_c, n_s)
            return OK
    return UNDECIDED


@compiled
def turns_round(w: LoopArrays, n_x: int, n_c: int) -> bool:
    """Turn round one contact along a line that cannot stick and contradicts its direction; return whether one did.

    A law with memory has such a contact: its force is a state, and only the direction of the slip changes.
    """
    for i in range(n_c):
        alone = w.contacts.sticks[i] == 0 and w.contacts.partner[i] < 0
        if alone and contradiction(w, n_x, i, w.clock.t_end)[0] > 0.0:
            w.selection.turns[i] += 1
            turn(w, i, -way(w, i))
            return True
    return False


@compiled
def decide(w: LoopArrays, n_x: int, n_c: int) -> int:
    """Find a mode in which no contact at rest contradicts its force."""
    p = w.planes
    for i in range(n_c):
        p.returned[i] = 0
        p.leaves[i] = undecided(w, i) and w.selection.old[i] == 0 and _was_hit(w, i)
    leave_together(w, n_c)
    join(w, n_c)
    forget_limit(w)
    feet, fell = are_redundant(w, n_c), False
    for i in range(n_c):
        fell = fell or p.leaves[i] != 0
        if feet:  # one that has reached its bound may hand on its force
            p.leaves[i], p.stands[i] = 0, i
    for _ in range(2 * n_c + 4):
        _free(w, n_x, n_c)
        if feet and fell:
            ends, fell = leave_at_limit(w, n_c), False
            for i in range(n_c):
                p.leaves[i] *= ends
                p.returned[i] = p.returned[i] if ends else _RETURNS  # forces that hold have been found
        status = _balance(w, n_c, feet)
        if status != OK:
            return status
        for i in range(n_c):
            if undecided(w, i) and not is_second(w, i):
                _set_mode(w, i)
        if feet:
            _hold_lines_first(w, n_c)
        share(w, n_c)
        if feet and carry(w, n_c):
            tell_forces(w, n_x, n_c)
        for i in range(n_c):
            beyond = w.m[i] != HOLDS and not shares(w, i) and not (feet and w.contacts.partner[i] >= 0)
            if undecided(w, i) and w.m[i] > 0.5 and beyond:
                return UNDECIDED  # its force is not determined
        prelude(w)
        probe(w)
        if not _contradicts(w, n_x, n_c):
            return OK
        if feet:
            for i in range(n_c):
                fell = fell or (p.leaves[i] != 0 and w.m[i] > 0.5)
    return UNDECIDED


@compiled
def _hold_lines_first(w: LoopArrays, n_c: int) -> None:
    """Let contacts along a line that stick be the first of the basis: only those in the plane can be told a force."""
    for i in range(n_c):
        if undecided(w, i) and w.m[i] == FOLLOWS and w.contacts.partner[i] < 0:
            w.m[i] = HOLDS


@compiled(inline=True)
def _was_hit(w: LoopArrays, i: int) -> bool:
    """Whether the force of contact i has just reached its bound."""
    return w.guards.hit[backward(i)] != 0 or w.guards.hit[forward(i)] != 0


@compiled
def _free(w: LoopArrays, n_x: int, n_c: int) -> None:
    """Compute the slip accelerations without forces of the contacts at rest."""
    for i in range(n_c):
        if not undecided(w, i):
            continue
        w.m[i] = FOLLOWS
        if w.contacts.partner[i] > i:
            for k in range(SINCE):
                w.m[w.planes.variable[i] + k] = 0.0
    prelude(w)
    probe(w)
    for i in range(n_c):
        w.planes.free[i] = w.probe[n_x + backward(i), 1]


@compiled
def _balance(w: LoopArrays, n_c: int, feet: bool) -> int:
    """Find which contacts start to slip, with the forces of all contacts at rest and their accelerations."""
    p = w.planes
    for i in range(n_c):
        p.slides[i], p.force[i] = p.leaves[i], 0.0
    for _ in range(4 * n_c + 8):
        if feet:
            for i in range(n_c):
                p.bound[i] = p.kinetic[i] if p.slides[i] else p.static[i]
            if not accelerate(w, n_c):
                return UNDECIDED
        else:
            join(w, n_c)
            if not _forces(w, n_c):
                return UNDECIDED
        changed = False
        for i in range(n_c):
            if not undecided(w, i) or is_second(w, i):
                continue
            moves = _speeding(w, i) > _nothing(w, i)
            if moves and p.slides[i] == 0:
                p.slides[i], changed = 1, True
            elif p.slides[i] and not moves and not _is_tied(w, i) and p.returned[i] < _RETURNS:
                p.slides[i], p.leaves[i], changed = 0, 0, True
                p.returned[i] += 1
        if not changed:
            return OK
    return UNDECIDED


@compiled(inline=True)
def _is_tied(w: LoopArrays, i: int) -> bool:
    """Whether contact i has reached a bound that does not fall with its release."""
    return w.planes.leaves[i] != 0 and w.planes.kinetic[i] >= w.planes.static[i] * (1.0 - ROUNDING)


@compiled(inline=True)
def _speeding(w: LoopArrays, i: int) -> float:
    """Return the magnitude of the slip acceleration of contact i."""
    j = w.contacts.partner[i]
    return abs(w.planes.gain[i]) if j < 0 else np.hypot(w.planes.gain[i], w.planes.gain[j])


@compiled(inline=True)
def _nothing(w: LoopArrays, i: int) -> float:
    """Return the slip acceleration of contact i below which it is zero."""
    j = w.contacts.partner[i]
    return little(w, i) if j < 0 else max(little(w, i), little(w, j))


@compiled
def _forces(w: LoopArrays, n_c: int) -> bool:
    """Compute forces within the bounds and accelerations of contacts at rest; return whether they were found."""
    p = w.planes
    for _ in range(_SWEEPS):
        moved, size = 0.0, 0.0
        for i in range(n_c):
            if not undecided(w, i) or is_second(w, i):
                continue
            if p.stands[i] != i:
                p.force[i], p.force[w.contacts.partner[i]] = 0.0, 0.0
                continue
            before, j = p.force[i], w.contacts.partner[i]
            if j < 0:
                rest = _felt(w, i, n_c, i, i)
                bound = p.bound[i]
                p.force[i] = min(max(-rest / w.gauge[COUPLING + i, i], -bound), bound)
                moved = max(moved, abs(p.force[i] - before) * w.gauge[COUPLING + i, i])
            else:
                across = p.force[j]
                _force_in_plane(w, i, j, _felt(w, i, n_c, i, j), _felt(w, j, n_c, i, j))
                change = abs(p.force[i] - before) + abs(p.force[j] - across)
                moved = max(moved, change * (w.gauge[COUPLING + i, i] + w.gauge[COUPLING + j, j]))
                size = max(size, abs(p.force[j]) * w.gauge[COUPLING + j, j])
            size = max(size, abs(p.force[i]) * w.gauge[COUPLING + i, i])
        if not moved < np.inf:
            return False
        if moved <= 4.0 * EPS * size:
            break
    else:
        return False
    for i in range(n_c):
        if undecided(w, i):
            p.gain[i] = _felt(w, i, n_c, -1, -1)
    return True


@compiled(inline=True)
def _felt(w: LoopArrays, i: int, n_c: int, first: int, second: int) -> float:
    """Return the acceleration of slip i by all forces but those of rows `first` and `second`."""
    total = w.planes.free[i]
    for k in range(n_c):
        if k != first and k != second and undecided(w, k):
            total += w.gauge[COUPLING + i, k] * w.planes.force[k]
    return total


@compiled
def _force_in_plane(w: LoopArrays, i: int, j: int, a: float, b: float) -> None:
    """Compute the force of one contact in the plane on which the accelerations (a, b) act otherwise.

    On its bound ``(kappa + B A) e = (a, b)`` with ``|e| = 1``; |e| falls with kappa, and Newton's method for 1/|e|
    approaches its root from below.
    """
    p, bound = w.planes, w.planes.bound[i]
    ii, ij, jj = w.gauge[COUPLING + i, i], w.gauge[COUPLING + i, j], w.gauge[COUPLING + j, j]
    det = ii * jj - ij * ij
    x, y = -(jj * a - ij * b) / det, -(ii * b - ij * a) / det
    if np.hypot(x, y) <= bound:
        p.force[i], p.force[j] = x, y
        return
    if bound <= 0.0:
        p.force[i], p.force[j] = 0.0, 0.0
        return
    kappa, e, f = 0.0, 0.0, 0.0
    for _ in range(_ROOT):
        k11, k12, k22 = kappa + bound * ii, bound * ij, kappa + bound * jj
        det = k11 * k22 - k12 * k12
        e, f = (k22 * a - k12 * b) / det, (k11 * b - k12 * a) / det
        size = np.hypot(e, f)
        # with K e = (a, b): d|e|/dkappa = -e^T K^-1 e/|e|
        slope = (e * (k22 * e - k12 * f) + f * (k11 * f - k12 * e)) / (det * size)
        step = size * (size - 1.0) / slope
        if not step > EPS * kappa:
            break
        kappa += step
    size = np.hypot(e, f)
    p.force[i], p.force[j] = -bound * e / size, -bound * f / size


@compiled(inline=True)
def _set_mode(w: LoopArrays, i: int) -> None:
    """Set the mode of a contact at rest as found."""
    p, j = w.planes, w.contacts.partner[i]
    if p.slides[i] == 0:
        return  # it sticks on trial already
    if j < 0:
        w.m[i] = 0.0
        pushed = p.gain[i] if abs(p.gain[i]) > _nothing(w, i) else -p.force[i]
        turn(w, i, 1.0 if pushed > 0.0 else -1.0)
        return
    k, v = p.stands[i], p.variable[i]
    x, y = _start(w, k, component(w, i, k)), _start(w, k, component(w, j, k))
    if k != i:
        x = x if ratio(w, i, component(w, i, k)) > 0.0 else -x
        y = y if ratio(w, j, component(w, j, k)) > 0.0 else -y
    size = np.hypot(x, y)
    if size == 0.0:
        return
    w.m[i], w.m[j] = STARTS, STARTS
    w.m[v], w.m[v + 1], w.m[v + SINCE] = x / size, y / size, w.y[w.y.size - 1]
    for k in range(2, SINCE):
        w.m[v + k] = 0.0


@compiled(inline=True)
def _start(w: LoopArrays, k: int, component: int) -> float:
    """Return a component of the way contact k starts: against its force, without one along its acceleration.

    An acceleration that has just begun is the small difference of forces, of which rounding turns the direction. A foot
    without load starts where the others take it, as the problem of the forces that hold tells.
    """
    if np.hypot(w.planes.force[k], w.planes.force[w.contacts.partner[k]]) > 0.0:
        return float(-w.planes.force[component])
    if _speeding(w, k) > 0.0 or w.feet.axes.size == 0:
        return float(w.planes.gain[component])
    return slip_of(w, component, 0)


@compiled
def _contradicts(w: LoopArrays, n_x: int, n_c: int) -> bool:
    """Mark contacts at rest whose force exceeds its bound just after, or that do not leave it; return whether so."""
    p, found = w.planes, False
    for i in range(n_c):
        if not undecided(w, i) or is_second(w, i) or p.returned[i] >= _RETURNS:
            continue
        g, j, slips = n_x + backward(i), w.contacts.partner[i], w.m[i] < 0.5
        if slips and p.leaves[i] and _speeding(w, i) <= _nothing(w, i):
            rise = w.probe[g, 2]  # of a contact along a line already in the direction of its slip
            if gives_way(w, n_c, i):
                rise = rate_of_start(w, n_x, n_c)
            elif j >= 0:
                rise = _rise_in_plane(w, i, w.probe[g, 2], w.probe[n_x + backward(j), 2])
            if rise < 0.0:
                p.leaves[i], found = 0, True
                p.returned[i] += 1
        elif not slips and p.leaves[i] == 0:
            for side in range(1 if j >= 0 else 2):
                room, change = w.probe[g + side, 0], w.probe[g + side, 1]
                if _exceeds(w, i, room, change):
                    p.leaves[i], found = 1, True
    return found


@compiled(inline=True)
def _rise_in_plane(w: LoopArrays, i: int, x: float, y: float) -> float:
    """Return how contact i accelerates out of rest, up to a positive factor, from the rates of its acceleration (x, y).

    These are for a friction of one direction e. It turns until the slip is along e, which takes a force across e: by
    this ``A^-1 (x, y)`` changes across e alone, with the coupling A, and its part along e tells the start.
    """
    j, v = w.contacts.partner[i], w.planes.variable[i]
    ii, ij, jj = w.gauge[COUPLING + i, i], w.gauge[COUPLING + i, j], w.gauge[COUPLING + j, j]
    return float(w.m[v] * (jj * x - ij * y) + w.m[v + 1] * (ii * y - ij * x))


@compiled(inline=True)
def _exceeds(w: LoopArrays, i: int, room: float, change: float) -> bool:
    """Whether the force of a sticking contact is beyond its bound, or on it and growing."""
    doubt = doubt_of(w, i)
    if w.contacts.partner[i] >= 0:  # the guard is the difference of two squares
        doubt *= 2.0 * w.planes.static[i] + doubt
    return room < -doubt or (abs(room) <= doubt and change < 0.0 and w.counts.steps == 0)
