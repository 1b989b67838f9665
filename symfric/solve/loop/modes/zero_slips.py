"""Slips that are zero: contacts that may stick are tried as sticking, and their slips made exactly zero."""

import numpy as np

from symfric.codegen.numba_types import compiled
from symfric.lower.constraint_forces import AT_BOUND, FOLLOWS, HOLDS
from symfric.solve.loop.codes import COUPLING, PULL, SLIP, TERMS
from symfric.solve.loop.events.impacts import widen_slips
from symfric.solve.loop.modes.layout import backward, direction, forward, mode
from symfric.solve.loop.modes.sticking_basis import share
from symfric.solve.loop.modes.tolerances import EARLIER, instant, sizes_of_velocities
from symfric.solve.loop.precision import ROUNDING, TOUCH
from symfric.solve.loop.stepping.calls import measure
from symfric.solve.loop.workspace import LoopArrays

SLID = 100.0  # speed at rest, relative to its largest terms and over the tolerance, that is no error of the run
NEAR = 1e-10  # speed, relative to its largest terms, below which a contact in the plane that comes to rest is at rest
_BESIDE = 4e-12  # the same beside another that has just stopped: that much is stepped over on a straight line
_COUNTS = 8.0  # ratio of the largest slope of a slip to that of a velocity that may be changed
AMPLIFIED = 1e3  # change of velocities, relative to that for a single slip, by nearly parallel slips made zero


@compiled(inline=True)
def try_sticking(w: LoopArrays, n_x: int, n_c: int) -> None:
    """Set the trial mode: contacts at zero slip stick, or are released if their bound was reached."""
    measure(w, w.y, w.gauge)
    w.clock.removed, w.clock.gained = 0.0, 0.0
    for k in range(w.planes.rests.size):
        w.planes.rests[k] = 0
    sizes_of_velocities(w, n_x)  # if everything comes to rest at once, rounding is relative to the previous velocities
    measure(w, w.step.end, w.span)
    if w.openings.variable.size:
        widen_slips(w, n_c)
    for i in range(n_c):
        w.selection.old[i] = mode(w, i)
        w.selection.zero[i] = w.selection.old[i] == 0 or w.guards.hit[backward(i)] != 0
        given = w.m[i] > 0.5 and w.guards.carries[i] == 0 and w.contacts.partner[i] < 0
        if w.openings.variable.size == 0 and given and (w.guards.hit[backward(i)] or w.guards.hit[forward(i)]):
            w.selection.zero[i] = 0  # others held it up to rounding, which its slip exceeds now
        if w.counts.jumped and w.selection.zero[i]:  # it was, and may have jumped
            size = max(w.gauge[TERMS, i], EARLIER * w.span[TERMS, i])
            w.selection.zero[i] = abs(w.gauge[SLIP, i]) <= TOUCH * w.clock.tolerance * size
    _find_zeros(w, n_c)
    passing = False
    if w.limits.coupled:
        for i in range(n_c):
            if w.selection.passes[i]:
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
    stopped = False
    for i in range(n_c):
        if w.m[i] != 0.0 and w.contacts.anchor[i] >= 0 and not _is_stopped(w, i):
            w.y[w.contacts.anchor[i]] -= w.gauge[SLIP, i] / w.contacts.factor[i]
            stopped = True
    if w.limits.coupled and stopped:  # so are those of others by the same velocities
        measure(w, w.y, w.gauge)
        _find_zeros(w, n_c)
    if w.limits.coupled and sticking > 0 and w.planes.rests.size == 0 and w.openings.variable.size == 0:
        measure(w, w.y, w.gauge)
        for i in range(n_c):
            if w.m[i] != 0.0 and w.contacts.anchor[i] < 0:
                _make_exact(w, i, n_c)
    if w.planes.rests.size > 1:  # then the slips of others on the same bodies are zero too
        measure(w, w.y, w.gauge)
        _find_zeros_in_plane(w)


@compiled
def has_slid(w: LoopArrays, n_x: int) -> bool:
    """Whether a contact in the plane that is told its force at rest is not at rest: surfaces have moved apart."""
    told, found = False, False
    for k in range(w.planes.row.size):
        i = w.planes.row[k]
        told = told or w.m[i] == AT_BOUND or w.m[i + 1] == AT_BOUND
    if not told:
        return False
    measure(w, w.y, w.gauge)
    sizes_of_velocities(w, n_x)
    measure(w, w.step.end, w.span)
    moment = instant(w)
    for k in range(w.planes.row.size):
        i = w.planes.row[k]
        j = i + 1
        size = max(w.gauge[TERMS, i], w.gauge[TERMS, j], w.span[TERMS, i], w.span[TERMS, j])
        slip = np.hypot(w.gauge[SLIP, i], w.gauge[SLIP, j])
        rests = w.m[i] == AT_BOUND or w.m[j] == AT_BOUND
        least = max(SLID * max(w.clock.tolerance, NEAR) * size, moment * max(w.gauge[PULL, i], w.gauge[PULL, j]))
        found = found or (rests and slip > least)
    return found


@compiled
def _make_exact(w: LoopArrays, i: int, n_c: int) -> None:
    """Make what rounding has left of the slip of contact i zero, by a velocity that no sticking contact has alone.

    Under a law with an infinite slope at rest it would be a speed of its own: rates far larger than any force, or, on
    the other side of zero, none at all, and neither contradicts a mode.
    """
    n_q, largest, free = w.limits.n_q, 0.0, 0.0
    for k in range(n_q, 2 * n_q):
        size = abs(w.gauge[COUPLING + n_c + k, i])
        largest = max(largest, size)
        if not _is_anchor(w, k, n_c):
            free = max(free, size)
    if free == 0.0 or free * AMPLIFIED < largest:
        return
    place, finest = -1, np.inf
    for k in range(n_q, 2 * n_q):  # of those that count, the one by which the slip changes in the smallest steps
        size = abs(w.gauge[COUPLING + n_c + k, i])
        if size * _COUNTS >= free and size * abs(w.y[k]) < finest and not _is_anchor(w, k, n_c):
            place, finest = k, size * abs(w.y[k])
    if place < 0:
        return
    slope = w.gauge[COUPLING + n_c + place, i]
    for _ in range(3):
        slip, size = w.gauge[SLIP, i], max(w.gauge[TERMS, i], EARLIER * w.span[TERMS, i])
        if slip == 0.0 or abs(slip) > ROUNDING * size:
            return
        w.y[place] -= slip / slope
        measure(w, w.y, w.gauge)


@compiled(inline=True)
def _is_anchor(w: LoopArrays, k: int, n_c: int) -> bool:
    """Whether the velocity at row k is the whole slip of a contact that sticks."""
    found = False
    for j in range(n_c):
        found = found or (w.m[j] != 0.0 and w.contacts.anchor[j] == k)
    return found


@compiled(inline=True)
def _is_stopped(w: LoopArrays, i: int) -> bool:
    """Whether the velocity in the slip of contact i is that of one before it, which sticks."""
    others = 0
    for j in range(i):
        others += w.m[j] != 0.0 and w.contacts.anchor[j] == w.contacts.anchor[i]
    return others > 0


@compiled(inline=True)
def _find_zeros(w: LoopArrays, n_c: int) -> None:
    """Add the contacts whose slip is zero up to rounding; all at zero slip stick on trial, the others slip."""
    _find_zeros_in_plane(w)
    for i in range(n_c):
        if w.contacts.partner[i] >= 0:
            continue
        slip, size = w.gauge[SLIP, i], max(w.gauge[TERMS, i], EARLIER * w.span[TERMS, i])
        w.selection.zero[i] = w.selection.zero[i] or abs(slip) <= ROUNDING * size
        if not w.selection.zero[i]:
            w.m[direction(i, n_c)] = 1.0 if slip > 0.0 else -1.0
            w.m[i] = 0.0
        elif w.contacts.sticks[i] and w.m[i] == 0.0:
            w.m[i] = FOLLOWS  # unless `share` finds it independent


@compiled
def _find_zeros_in_plane(w: LoopArrays) -> None:
    """Do the same for contacts in the plane.

    The series of a speed that has fallen to zero may be off by the error of a step where the slip vector only passes
    near zero. Speeds of feet of one body fall to zero together, and at the last of them the others are as small: a step
    of the same error does not tell the order of their stops. What forces change within the rounding of time is no slip.
    """
    moment = instant(w)
    for k in range(w.planes.rests.size):
        i = w.planes.row[k]
        j = i + 1
        size = max(w.gauge[TERMS, i], w.gauge[TERMS, j], EARLIER * w.span[TERMS, i], EARLIER * w.span[TERMS, j])
        share = ROUNDING
        if w.guards.hit[backward(i)] or _arrives_beside(w, i):
            share = max(share, min(NEAR, max(w.clock.tolerance, _BESIDE)))
        rests = w.planes.arrived[k] or (w.selection.old[i] == 0 and not w.counts.jumped)
        least = max(share * size, moment * max(w.gauge[PULL, i], w.gauge[PULL, j]))
        if rests or np.hypot(w.gauge[SLIP, i], w.gauge[SLIP, j]) <= least:
            w.planes.rests[k] = 1
        w.selection.zero[i], w.selection.zero[j] = w.planes.rests[k], w.planes.rests[k]
        w.m[direction(i, w.contacts.sticks.size)], w.m[direction(j, w.contacts.sticks.size)] = 1.0, 1.0
        if w.planes.rests[k] == 0:
            w.m[i], w.m[j] = 0.0, 0.0
        elif w.m[i] <= 0.5:
            w.m[i], w.m[j] = FOLLOWS, FOLLOWS


@compiled
def _arrives_beside(w: LoopArrays, i: int) -> bool:
    """Whether the slip of another contact in the plane, of the same bodies as contact i, has just fallen to zero."""
    found = False
    if w.limits.coupled and w.openings.variable.size == 0:
        for k in range(w.planes.rests.size):
            n = w.planes.row[k]
            if n != i and w.selection.old[n] != 0 and w.guards.hit[backward(n)]:
                found = found or w.gauge[COUPLING + i, n] != 0.0 or w.gauge[COUPLING + i, n + 1] != 0.0
                found = found or w.gauge[COUPLING + i + 1, n] != 0.0 or w.gauge[COUPLING + i + 1, n + 1] != 0.0
    return found


@compiled
def _project(w: LoopArrays, n_c: int) -> bool:
    """Set the slips of the sticking contacts exactly to zero by impulses, the least change in the norm of energy.

    Return whether impulses were needed.
    """
    coupled = False
    for i in range(n_c):
        coupled = coupled or (w.m[i] > 0.5 and w.contacts.anchor[i] < 0)
    if not coupled or w.openings.variable.size:  # exact without impulses if every slip has its own velocity
        return False  # with contacts that open, their gaps are held together with the slips later
    close = share(w, n_c)
    n_q, n, impulse = w.limits.n_q, 0, w.selection.impulse
    for i in range(n_c):
        n += w.m[i] > 0.5
    for a in range(n):
        i = w.basis.order[a]
        impulse[i] = -w.gauge[SLIP, i]
        w.clock.removed = max(w.clock.removed, w.gauge[SLIP, i] ** 2 / w.gauge[COUPLING + i, i])
        for b in range(a):
            j = w.basis.order[b]
            if w.m[i] == HOLDS and w.m[j] == HOLDS:
                impulse[i] -= w.basis.share[i, j] * impulse[j]
    for a in range(n - 1, -1, -1):
        i = w.basis.order[a]
        if w.m[i] != HOLDS:
            continue
        w.clock.gained += impulse[i] ** 2 / w.basis.share[i, i]
        impulse[i] /= w.basis.share[i, i]
        for b in range(a + 1, n):
            j = w.basis.order[b]
            if w.m[j] == HOLDS and not close:
                impulse[i] -= w.basis.share[j, i] * impulse[j]
        for r in range(n_q):
            before = w.y[n_q + r]
            w.y[n_q + r] += (w.basis.response[i, r] if close else w.gauge[COUPLING + n_c + r, i]) * impulse[i]
            if w.planes.rests.size and abs(w.y[n_q + r]) <= ROUNDING * abs(before):
                w.y[n_q + r] = 0.0  # on still ground no other speed tells that this one is rounding
    return True


@compiled(inline=True)
def moved_in_vain(w: LoopArrays, n_c: int) -> bool:
    """Whether velocities were changed for slips that do not stay zero; mark these in ``w.selection.passes``.

    Rounding of a slip is that much of a velocity, where slips are nearly parallel far more: another contact would be
    taken to rest then, at a speed that is not zero.
    """
    found = False
    if w.clock.gained > AMPLIFIED**2 * w.clock.removed:
        for i in range(n_c):
            w.selection.passes[i] = w.selection.zero[i] and w.m[i] < 0.5
            found = found or w.selection.passes[i]
    return found
