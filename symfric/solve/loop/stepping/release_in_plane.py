"""Starts and stops of contacts in the plane, where the direction of their slip has no Taylor series.

**Start.** With e the unit vector of the slip w and friction ``-B e``, w stays parallel to ``e = e_0 + e_1 t + ...``:
``sum_j e_(k+1-j) x w_j = 0`` for the coefficients of every order. With the part ``eta n`` of e_k across e_0, and the
coefficient r of ``w'`` without it,

    ((k + 1) w_1^T e_0 + B n^T A n) eta = n^T r + (k + 1) sum_(j=2..k) e_(k+1-j) x w_j,

one order after the other, for all contacts that start at once together; the part along e_0 keeps the length of e. From
the end of this short step on the direction follows from the slip. Its error there dies out: friction across the slip
damps it by ``B/|w|``, which is also why steps after a slow start are short.

**Stop.** The direction turns like a power of the time left, so that series reach no further than the stop: steps shrink
in proportion to that time, which costs its logarithm. Within a rounding error of the stop the rest is a straight line.
Beside feet that stick on the same bodies a slip does not become smaller than theirs, which is an error of the run: it
goes on at the angle at which friction no longer slows it. Theirs are made exactly zero then; where they are not, the
contact has stopped.

References
----------
Antali and Stepan, Sliding and crossing dynamics in extended Filippov systems, SIAM Journal on Applied Dynamical Systems
17 (2018) 823: the limit directions of slip in the plane.
"""

import numpy as np

from symfric.codegen.numba_types import compiled
from symfric.lower.planes import STARTS, TURNS
from symfric.solve.loop.codes import COUPLING, FORCES, SELECT, SLIP, TERMS
from symfric.solve.loop.events.first_event import first_event
from symfric.solve.loop.modes.layout import backward, forward
from symfric.solve.loop.modes.tolerances import LAST, fastest, instant, natural_time
from symfric.solve.loop.precision import EPS, ROUNDING
from symfric.solve.loop.stepping.calls import expand, measure, prelude
from symfric.solve.loop.stepping.common_start import depend_on_each_other, turn_feet
from symfric.solve.loop.stepping.elimination import solve_in_place
from symfric.solve.loop.stepping.singular_start import keep_straight
from symfric.solve.loop.stepping.start_derivatives import vary_start
from symfric.solve.loop.stepping.start_length import length_of_start
from symfric.solve.loop.workspace import LoopArrays

# speed, in slips of contacts that stick, at which one on the same bodies has stopped; longest straight line then
_OF_DRIFT, _LONGEST = 10.0, 1e-10
_BESIDE_DRIFT = 1e4  # up to which it is held up by these slips, which are made exactly zero,
_HELD = 4.0 * EPS  # unless they are so already, relative to its terms
_NEAR = 1e3  # slip, in rounding errors of it, from which on these are told of the present state


@compiled
def leave_rest(w: LoopArrays, n_x: int, n_c: int) -> float:
    """Write the series of contacts in the plane that start to slip into ``w.c``; return how far it is used, -1 if none.

    It ends at the first event of another guard, which is marked as `first_event` does. The mode is left in which they
    slip.
    """
    starting = 0
    for k in range(w.planes.row.size):
        starting += w.m[w.planes.row[k]] == STARTS
    if starting == 0:
        return -1.0
    known = min(TURNS, w.c.shape[1] - 2)
    _couple(w, n_x)
    together = depend_on_each_other(w, n_x)
    for order in range(1, known + 1):
        if together:
            turn_feet(w, n_x, order)
            continue
        _keep_length(w, order)
        prelude(w)
        expand(w)
        _turn(w, n_x, order)
    prelude(w)
    expand(w)
    for r in range(w.c.shape[0]):
        for k in range(known + 2, w.c.shape[1]):
            w.c[r, k] = 0.0
    time = length_of_start(w, n_x, known + 1)
    _leave_out(w, np.inf)
    time = first_event(w, n_x, n_c, time, time)
    _leave_out(w, 0.0)
    for k in range(w.planes.row.size):
        i = w.planes.row[k]
        if w.m[i] == STARTS:
            w.m[i], w.m[i + 1] = 0.0, 0.0
    prelude(w)
    if w.limits.varied and time > 0.0:
        vary_start(w, n_x, time)
    return time


@compiled
def _leave_out(w: LoopArrays, slack: float) -> None:
    """Set the slack of the guards of contacts that start, which leave zero to any side: no event of theirs."""
    for k in range(w.planes.row.size):
        i = w.planes.row[k]
        if w.m[i] != STARTS:
            continue
        for g in range(backward(i), forward(i + 1) + 1):
            w.guards.slack[g], w.guards.fresh[g] = slack, 0


@compiled
def _couple(w: LoopArrays, n_x: int) -> None:
    """Find what a turn of every direction does to the slips, with the contacts that stick: ``B n^T A n``."""
    n, across = w.planes.row.size, w.planes.across
    for k in range(n):
        for c in range(n):
            w.planes.coupling[k, c] = 0.0
    for c in range(-1, n):  # without any turn first
        v = 0
        if c >= 0:
            if w.m[w.planes.row[c]] != STARTS:
                continue
            v = w.planes.variable[w.planes.row[c]]
            w.m[v + 2], w.m[v + 3] = -w.m[v + 1], w.m[v]
        prelude(w)
        expand(w)
        for k in range(n):
            i = w.planes.row[k]
            p = w.planes.variable[i]
            felt = 2.0 * (w.m[p] * w.c[n_x + backward(i + 1), 2] - w.m[p + 1] * w.c[n_x + backward(i), 2])
            if c < 0:
                across[k] = felt
            elif w.m[i] == STARTS:
                w.planes.coupling[k, c] = across[k] - felt
        if c >= 0:
            w.m[v + 2], w.m[v + 3] = 0.0, 0.0


@compiled
def _keep_length(w: LoopArrays, order: int) -> None:
    """Set the part of e_order along e_0 that keeps the length of e, and none across."""
    for k in range(w.planes.row.size):
        i = w.planes.row[k]
        v, total = w.planes.variable[i], 0.0
        for j in range(1, order):
            a, b = v + 2 * j, v + 2 * (order - j)
            total -= 0.5 * (w.m[a] * w.m[b] + w.m[a + 1] * w.m[b + 1])
        if w.m[i] == STARTS:
            w.m[v + 2 * order], w.m[v + 2 * order + 1] = total * w.m[v], total * w.m[v + 1]


@compiled
def _turn(w: LoopArrays, n_x: int, order: int) -> None:
    """Solve for the parts of e_order across e_0 of all contacts that start, and add them."""
    n, T, next_order = w.planes.row.size, w.planes.turning, order + 1
    for k in range(n):
        i = w.planes.row[k]
        for c in range(n + 1):
            T[k, c] = 0.0
        T[k, k] = 1.0  # another contact, which does not turn
        if w.m[i] != STARTS:
            continue
        a, b, v = n_x + backward(i), n_x + backward(i + 1), w.planes.variable[i]
        e, f = w.m[v], w.m[v + 1]
        T[k, k] = next_order * (e * w.c[a, 1] + f * w.c[b, 1])
        total = e * w.c[b, next_order] - f * w.c[a, next_order]
        for j in range(2, next_order):
            p = v + 2 * (next_order - j)
            total += w.m[p] * w.c[b, j] - w.m[p + 1] * w.c[a, j]
        T[k, n] = next_order * total
        for c in range(n):
            T[k, c] += w.planes.coupling[k, c]
    _turn_together(w, n)
    for k in range(n):
        if T[k, k] == 0.0:  # a contact without friction, whose direction has no effect
            for c in range(n + 1):
                T[k, c] = 0.0
            T[k, k] = 1.0
    solve_in_place(T, n, 1)
    for k in range(n):
        w.planes.across[k] = T[k, n]
    for k in range(n):
        i = w.planes.row[k]
        v = w.planes.variable[i]
        if w.m[i] == STARTS and w.planes.stands[i] != i:
            w.planes.across[k] = w.planes.turned[i] * w.planes.across[_place(w, w.planes.stands[i])]
        if w.m[i] == STARTS:
            w.m[v + 2 * order] -= w.planes.across[k] * w.m[v + 1]
            w.m[v + 2 * order + 1] += w.planes.across[k] * w.m[v]


@compiled
def _turn_together(w: LoopArrays, n: int) -> None:
    """Let contacts of the same slip turn as the one that stands for them: their directions are the same."""
    T = w.planes.turning
    for k in range(n):
        i = w.planes.row[k]
        if w.m[i] != STARTS or w.planes.stands[i] == i:
            continue
        first = _place(w, w.planes.stands[i])
        for r in range(n):
            T[r, first] += w.planes.turned[i] * T[r, k]
            T[r, k] = 0.0
        for c in range(n + 1):
            T[k, c] = 0.0
        T[k, k] = 1.0


@compiled(inline=True)
def _place(w: LoopArrays, i: int) -> int:
    """Return the index of the contact in the plane whose first row is i."""
    k = 0
    while w.planes.row[k] != i:
        k += 1
    return k


@compiled
def comes_to_rest(w: LoopArrays, n_x: int, n_c: int) -> bool:
    """Step to the stop of a contact in the plane if it is that near; return whether there was one.

    Velocities keep their directions until the modes are selected: they lead to the derivatives of the time of the stop.
    """
    nature, largest = natural_time(w), fastest(w)
    hit, time, measured, held_up = -1, LAST * nature, False, False
    for k in range(w.planes.row.size):
        i = w.planes.row[k]
        row = n_x + backward(i)
        speed, rate = w.c[row, 0], w.c[row, 1]
        if w.m[i] != 0.0:
            continue
        size = max(w.gauge[TERMS, i], w.gauge[TERMS, i + 1])
        depends = w.limits.coupled and w.contacts.depends[i]
        least = _rounding_of_slip(w, i, rate)
        slow = depends and speed < w.clock.tolerance * max(size, largest)
        if not measured and (speed < _NEAR * least or slow):
            measure(w, w.y, w.gauge)
            measured, least = True, _rounding_of_slip(w, i, rate)
        stops = speed < max(-rate * time, least)
        if hit < 0 and slow and not stops:
            drift = _drift(w, i, n_c)
            stops = speed < w.clock.tolerance * size and speed <= _OF_DRIFT * drift
            held_up = held_up or (drift > _HELD * size and speed <= _BESIDE_DRIFT * drift)
        if stops and rate < 0.0:
            hit, time = k, min(speed / -rate, _LONGEST * nature)
    if hit < 0:
        return held_up and _hold_anew(w)
    n_q, n_y = w.limits.n_q, n_x // (1 + w.limits.varied)
    for r in range(n_x):
        moves = r < n_q or 2 * n_q <= r < n_y
        w.step.base[0, r] = w.y[r]
        w.y[r] += time * w.c[r, 1] if moves else 0.0
    w.y[n_x] += time
    keep_straight(w, n_x, n_c, time)
    for g in range(w.guards.hit.size):
        w.guards.hit[g], w.guards.fresh[g] = 0, 0
    for k in range(w.planes.row.size):  # those whose slip is zero then, to rounding, arrive together
        i = w.planes.row[k]
        speed, rate = w.c[n_x + backward(i), 0], w.c[n_x + backward(i), 1]
        if k == hit or (w.m[i] == 0.0 and rate < 0.0 and abs(speed + rate * time) <= _rounding_of_slip(w, i, rate)):
            w.guards.hit[backward(i)], w.planes.arrived[k] = 1, 1
    w.counts.phase = SELECT
    return True


@compiled
def _hold_anew(w: LoopArrays) -> bool:
    """Select the modes once more, which makes the slips of contacts that stick exactly zero; once after every step."""
    if w.counts.stall > 0:
        return False
    for g in range(w.guards.hit.size):
        w.guards.hit[g], w.guards.fresh[g] = 0, 0
    w.counts.phase = SELECT
    return True


@compiled(inline=True)
def _rounding_of_slip(w: LoopArrays, i: int, rate: float) -> float:
    """Return the rounding error of the slip of contact i, which changes at a rate: of its terms, and of time.

    The forces on its bodies and the rate bound the acceleration of a surface that moves by itself.
    """
    size = max(w.gauge[TERMS, i], w.gauge[TERMS, i + 1])
    pushed = max(w.gauge[FORCES, i], w.gauge[FORCES, i + 1])
    return float(ROUNDING * size + instant(w) * (pushed + abs(rate)))


@compiled
def _drift(w: LoopArrays, i: int, n_c: int) -> float:
    """Return the largest slip of the contacts that stick and whose forces act on the slip of contact i."""
    largest = 0.0
    for n in range(n_c):
        if w.m[n] > 0.5 and (w.gauge[COUPLING + i, n] != 0.0 or w.gauge[COUPLING + i + 1, n] != 0.0):
            largest = max(largest, abs(w.gauge[SLIP, n]))
    return largest


@compiled
def passes_rest(w: LoopArrays, n_x: int) -> bool:
    """Let contacts in the plane whose slip is zero up to rounding be at rest; return whether there are any.

    A slip that turns round on a line may be stepped over zero by that much; no step leads on from there.
    """
    found = False
    measure(w, w.y, w.gauge)
    for g in range(w.guards.hit.size):
        w.guards.hit[g] = 0
    for k in range(w.planes.row.size):
        i = w.planes.row[k]
        row = n_x + backward(i)
        if w.m[i] == 0.0 and w.c[row, 0] <= _rounding_of_slip(w, i, w.c[row, 1]):
            w.guards.hit[backward(i)], w.guards.fresh[backward(i)], w.planes.arrived[k], found = 1, 0, 1, True
    if found:
        w.counts.phase = SELECT
    return found
