"""The next mode, decided by the forces.

Contacts whose slip is zero are tried as sticking; a contact whose force would exceed its static bound is released in
the direction of the excess, one that would slip against its direction is caught again. One contact is changed at a
time, the worst first and, if that runs long, the one of least index: Murty's rule for the complementarity problem
``0 <= bound -+ lambda  complementary to  +- acceleration >= 0``. Ties at the bound are decided by the next derivatives.
"""

import numpy as np

from symfric.lower.holding import REDUNDANT
from symfric.solve.native import compiled
from symfric.solve.status import Status
from symfric.solve.taylor.calls import measure, prelude, probe
from symfric.solve.taylor.edges import decisive, find_edges
from symfric.solve.taylor.workspace import (
    COUPLING,
    DROP,
    EDGES,
    FORCES,
    KINKS,
    LOAD,
    N_Q,
    PULL,
    SLIP,
    T_END,
    TERMS,
    TOLERANCE,
)
from symfric.solve.taylor.zero import ROUNDING, TIE, TOUCH, doubt_of, natural_time, no_acceleration

NO_DROP = 1e-9  # of friction from rest to slip, relative to both: less is none

_OK, _UNDECIDED, _LOST = int(Status.OK), int(Status.UNDECIDED), int(Status.LOST_CONTACT)


@compiled
def settle(w):
    """Choose the mode of every contact and switch at the present state; return a status.

    Contacts and switches that reached zero are named by ``w.hit``; the modes are left in ``w.m``, and ``w.fresh`` names
    the guards that start the new mode at zero.
    """
    n_x, n_c = w.y.size - 1, w.sticks.size
    n_s = w.m.size - 2 * n_c
    _try_sticking(w, n_x, n_c)
    lost = 0.0
    for g in range(w.m.size, w.hit.size):
        lost = min(lost, -TOUCH * w.clock[TOLERANCE] * w.scale[n_x + g])
    for i in range(n_c):
        if w.gauge[LOAD, i] < lost:
            return _LOST
        if w.gauge[DROP, i] < 0.0:
            return _UNDECIDED
    horizon = w.clock[T_END]
    for i in range(w.turns.size):
        w.turns[i] = 0
    edges = w.limits[EDGES] > 0
    rounds = 60 + 12 * (n_c + n_s)
    for turn in range(rounds):
        _share(w, n_c)
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
        _mark_fresh(w, n_x, n_c, n_s)
        return _OK
    return _UNDECIDED


@compiled(inline=True)
def _try_sticking(w, n_x, n_c):
    """Find the contacts at zero slip and put them on trial: sticking, or released if their bound was reached."""
    measure(w, w.y, w.gauge)
    n_q = w.limits[N_Q]
    for r in range(n_x + 1):  # where everything comes to rest at once, rounding is that of the velocities before
        w.trial[r] = abs(w.start[r]) + w.scale[r] if n_q <= r < 2 * n_q else w.y[r]
    measure(w, w.trial, w.span)
    for i in range(n_c):
        w.old[i] = 0 if w.m[i] > 0.5 else np.int64(w.m[n_c + i])
        w.zero[i] = w.old[i] == 0 or w.hit[2 * i] != 0
    _find_zeros(w, n_c)
    if _project(w, n_c):  # then contacts that follow from these have no slip either
        measure(w, w.y, w.gauge)
        _find_zeros(w, n_c)
    for i in range(n_c):
        if w.m[i] == 0.0:
            continue
        if w.anchor[i] >= 0:
            w.y[w.anchor[i]] -= w.gauge[SLIP, i] / w.factor[i]
        if w.old[i] == 0 and (w.hit[2 * i] or w.hit[2 * i + 1]):
            w.m[i] = 0.0
            w.m[n_c + i] = -1.0 if w.hit[2 * i] else 1.0


@compiled(inline=True)
def _find_zeros(w, n_c):
    """Add the contacts whose slip is zero to rounding; put all of zero slip on trial, the others in their direction."""
    for i in range(n_c):
        slip, size = w.gauge[SLIP, i], max(w.gauge[TERMS, i], 0.125 * w.span[TERMS, i])
        w.zero[i] = w.zero[i] or abs(slip) <= ROUNDING * size
        if not w.zero[i]:
            w.m[n_c + i] = 1.0 if slip > 0.0 else -1.0
        w.m[i] = 1.0 if w.zero[i] and w.sticks[i] else 0.0


@compiled
def _project(w, n_c):
    """Make the slips of the sticking contacts exactly zero, by the impulses that do it: the least change of energy.

    Return whether that took any.
    """
    coupled = False
    for i in range(n_c):
        coupled = coupled or (w.m[i] > 0.5 and w.anchor[i] < 0)
    if not coupled:  # exact without, where every slip has a velocity of its own
        return False
    _share(w, n_c)
    n_q = w.limits[N_Q]
    for i in range(n_c):
        w.impulse[i] = -w.gauge[SLIP, i]
        for j in range(i):
            if w.m[i] == 1.0 and w.m[j] == 1.0:
                w.impulse[i] -= w.share[i, j] * w.impulse[j]
    for i in range(n_c - 1, -1, -1):
        if w.m[i] != 1.0:
            continue
        w.impulse[i] /= w.share[i, i]
        for j in range(i + 1, n_c):
            if w.m[j] == 1.0:
                w.impulse[i] -= w.share[j, i] * w.impulse[j]
        for r in range(n_q):
            w.y[n_q + r] += w.gauge[COUPLING + n_c + r, i] * w.impulse[i]
    return True


@compiled
def _share(w, n_c):
    """Mark the sticking contacts: 1 with a constraint of its own, 2 held by the ones before it, 3 parallel to one."""
    for i in range(n_c):
        if w.m[i] < 0.5:
            continue
        pivot = w.gauge[COUPLING + i, i]
        for j in range(i):
            if w.m[j] != 1.0:
                continue
            rest = w.gauge[COUPLING + i, j]
            for k in range(j):
                if w.m[k] == 1.0:
                    rest -= w.share[i, k] * w.share[j, k] * w.share[k, k]
            w.share[i, j] = rest / w.share[j, j]
            pivot -= rest * w.share[i, j]
        w.share[i, i] = pivot
        w.m[i] = 1.0
        if pivot <= REDUNDANT * w.gauge[COUPLING + i, i]:
            w.m[i] = 2.0
            for j in range(i):
                if w.parallel[j] == w.parallel[i] and w.m[j] == 1.0:
                    w.m[i] = 3.0


@compiled(inline=True)
def _change_contact(w, n_x, n_c, horizon, least):
    """Change the mode of the contact that contradicts its forces the most; return whether there was one."""
    worst, measure, side = -1, 0.0, 0
    for i in range(n_c):
        size, where = _contradiction(w, n_x, i, horizon)
        if size > measure:
            worst, measure, side = i, size, where
            if least:
                break
    if worst < 0:
        return False
    w.turns[worst] += 1
    if w.m[worst] > 0.5:
        w.m[worst] = 0.0
        w.m[n_c + worst] = side
    elif w.sticks[worst]:
        w.m[worst] = 1.0
    else:
        w.m[n_c + worst] = -w.m[n_c + worst]
    return True


@compiled
def _contradiction(w, n_x, i, horizon):
    """Return by how much the mode of contact i contradicts its forces, and the way it would slip.

    Where sticking and slipping contradict them both, to rounding, they have been tried in turn: then sticking wins if
    its force falls below its bound again, slipping otherwise.
    """
    size, where, tie, turns = 0.0, 0, TIE, 3
    if w.zero[i]:
        if w.m[i] == 2.0:
            size, where = _drift(w, n_x + 2 * i, i)
        elif w.m[i] > 0.5:
            doubt = doubt_of(w, i)
            size, where = _excess(w, n_x + 2 * i, horizon, doubt)
            turns = 4
            if size > 0.0 and w.probe[n_x + 2 * i + (where > 0), 1] > 0.0:
                # it falls below its bound again: no slip would last
                tie, turns = max(TIE, 16.0 * doubt / _stick_scale(w, n_x + 2 * i)), 2
        else:
            size = _backing(w, n_x + 2 * i, i, horizon)
    if size <= tie and w.turns[i] >= turns:
        return 0.0, 0  # a tie to rounding: either mode is right
    return size, where


@compiled
def _hold_more(w, n_x, n_c, horizon, edges):
    """Stick where static friction holds what was released on the way to the mode found.

    Where friction drops from rest to slip, both may agree with the forces; a contact at rest slips only if it must.
    """
    for i in range(n_c - 1, -1, -1):
        reached = w.old[i] == 0 and (w.hit[2 * i] or w.hit[2 * i + 1])
        drop = w.gauge[LOAD, i] * w.gauge[DROP, i] * w.gauge[COUPLING + i, i]
        if not w.zero[i] or w.m[i] > 0.5 or reached or w.sticks[i] == 0 or drop <= NO_DROP * w.gauge[PULL, i]:
            continue
        w.m[i] = 1.0
        _share(w, n_c)
        prelude(w)
        probe(w)
        consistent = w.m[i] == 1.0
        for j in range(n_c):
            consistent = consistent and _contradiction(w, n_x, j, horizon)[0] == 0.0
        if not consistent:
            w.m[i] = 0.0
            _share(w, n_c)
            prelude(w)
            probe(w)
    if edges and find_edges(w, n_x, n_c, False):  # one that sticks now
        prelude(w)
        probe(w)


@compiled(inline=True)
def _stick_scale(w, row):
    """Return the bound of a sticking contact plus the magnitude of its force, from its guards."""
    over, under = w.probe[row, 0], w.probe[row + 1, 0]
    return 0.5 * abs(over + under) + 0.5 * abs(over - under)


@compiled(inline=True)
def _excess(w, row, horizon, doubt):
    """Return by how much (relative) a sticking contact exceeds its bound now or soon, and the way it will slip.

    Both sides may be at the bound to rounding, where it is far below the forces that cancel: then the side that falls.
    """
    scale = _stick_scale(w, row)
    side = 0 if w.probe[row, 0] < w.probe[row + 1, 0] else 1
    if w.probe[row + side, 0] < -doubt:
        return -w.probe[row + side, 0] / scale, 2 * side - 1
    for _ in range(2):
        g, slope = w.probe[row + side, 0], w.probe[row + side, 1]
        if g <= ROUNDING * scale and slope * horizon < -TIE * scale:
            return 0.5 * TIE, 2 * side - 1
        side = 1 - side
    return 0.0, 0


@compiled(inline=True)
def _drift(w, row, i):
    """Return by how much a contact that sticks without a force starts to slip all the same, and which way."""
    rate, pull = w.probe[row, 1], w.gauge[PULL, i]
    if abs(rate) <= max(REDUNDANT * pull, ROUNDING * w.gauge[FORCES, i]):
        return 0.0, 0
    return abs(rate) / (abs(rate) + pull), 1 if rate > 0.0 else -1


@compiled(inline=True)
def _backing(w, row, i, horizon):
    """Return by how much (relative to the pull of static friction) a slipping contact accelerates the wrong way."""
    first, second, pull = w.probe[row, 1], w.probe[row, 2], w.gauge[PULL, i]
    little = no_acceleration(w, i, second)
    if first < -little:
        return -first / (pull - first)
    if first <= little and second * horizon < -no_acceleration(w, i, 0.0):
        return 0.5 * TIE
    return 0.0


@compiled
def _change_switch(w, n_x, n_c, n_s, edges):
    """Flip one switch whose sign is wrong now or, at zero, in the next instant; return whether there was one."""
    if edges and find_edges(w, n_x, n_c, False):
        return True
    time = natural_time(w)
    for j in range(n_s):
        g = 2 * n_c + j
        row = n_x + g
        value = w.probe[row, 0]
        if w.turns[n_c + j] >= 2:
            continue
        if w.hit[g] or abs(value) <= abs(w.m[g]) * ROUNDING * w.scale[row]:
            if w.edge[j]:
                continue
            wrong = w.probe[row, decisive(w, w.probe, row, j, n_c, time)] < 0.0
        else:
            wrong = value < 0.0
        if wrong:
            w.turns[n_c + j] += 1
            w.m[2 * n_c + j] = -w.m[2 * n_c + j]
            w.counts[KINKS] += 1
            return True
    return False


@compiled(inline=True)
def _mark_fresh(w, n_x, n_c, n_s):
    """Name the guards that start the new mode at zero, or below it by no more than the error of the run."""
    w.slack[:] = 0.0
    for i in range(n_c):
        a, b = w.probe[n_x + 2 * i, 0], w.probe[n_x + 2 * i + 1, 0]
        if w.m[i] == 2.0:
            w.fresh[2 * i], w.fresh[2 * i + 1] = 1, 1
        elif w.m[i] > 0.5:
            scale = _stick_scale(w, n_x + 2 * i)
            w.fresh[2 * i] = a <= ROUNDING * scale
            w.fresh[2 * i + 1] = b <= ROUNDING * scale
            w.slack[2 * i], w.slack[2 * i + 1] = max(0.0, -a), max(0.0, -b)
        else:
            w.fresh[2 * i] = w.zero[i]
            w.fresh[2 * i + 1] = 0
    for j in range(n_s):
        g = 2 * n_c + j
        w.fresh[g] = w.hit[g] != 0 or abs(w.probe[n_x + g, 0]) <= abs(w.m[g]) * ROUNDING * w.scale[n_x + g]


@compiled(inline=True)
def keep_scales(w, n_x, n_c):
    """Exchange the scales of the guards of a contact that begins or ends to carry a force: guards are slips, or forces.

    The units of one say nothing about the other.
    """
    for i in range(n_c):
        carries = w.m[i] == 1.0 or w.m[i] == 3.0
        if carries == (w.carries[i] != 0):
            continue
        w.carries[i] = carries
        for g in range(2 * i, 2 * i + 2):
            w.scale[n_x + g], w.other[g] = max(w.other[g], abs(w.probe[n_x + g, 0])), w.scale[n_x + g]
