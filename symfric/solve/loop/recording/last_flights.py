r"""Integrals over the last bounces: until these have died out the contact is open, although its mode is closed already.

A run closes a contact whose bounces are lower than its tolerance, at the time t of an impact, and they die out at
T = t + s: the flights of an infinite number of impacts, of length s in all; see
`symfric.solve.loop.modes.last_bounces`. The motion from t to T is in the mean that of the closed contact, but an
expression of the forces has the value that it has in flight. Integrals are therefore raised by

.. math:: \int_t^T (f_{open} - f_{closed}) dt \approx \tfrac s2 (d(t) + d(T)), \quad d = f_{open} - f_{closed},

both on the motion of the closed contact, with an error of the order of s^3. Derivatives of integrals are raised by the
same of their rows and by ``d(T) T' - d(t) t'``, with s' from differences of the formula of s.
"""

import numpy as np

from symfric.codegen.numba_types import compiled
from symfric.model.rows import INTEGRAL
from symfric.solve.loop.arithmetic import summed
from symfric.solve.loop.events.impacts import ask, field_of
from symfric.solve.loop.modes.last_bounces import all_flights
from symfric.solve.loop.stepping.calls import prelude, probe
from symfric.solve.loop.stepping.series import PROBED
from symfric.solve.loop.workspace import LoopArrays

_PART = 1e-5  # relative change of state and parameters for the derivatives of the time of rest


@compiled
def vary_end(w: LoopArrays, n_x: int) -> None:
    """Determine how the time in which bounces die out changes in every direction of differentiation.

    The state before the impact, its time and the parameters are moved along a direction, to both sides, and the impact
    and the flight after it computed again. The time is nearly linear in what moves.
    """
    n_s = w.limits.varied
    n_y = n_x // (1 + n_s)
    for r in range(n_x):
        w.impacts.last_y[r] = w.y[r]
    for r in range(w.m.size):
        w.impacts.last_m[r], w.m[r] = w.m[r], w.impacts.entry_m[r]
    for r in range(n_x):
        w.y[r] = w.impacts.entry_y[r]
    _series(w)
    for r in range(n_y):
        w.impacts.slope_y[r] = w.probe[r, 1]
    for k in range(w.openings.variable.size):
        w.impacts.asked[field_of(w, 2, k)] = 1.0
    for r in range(w.m.size):
        w.m[r] = w.impacts.flight_m[r]
    for s in range(n_s):
        w.impacts.late[s] = _rise(w, n_x, s) if w.openings.direction[s] > -2 else 0.0
    for r in range(n_x):
        w.y[r] = w.impacts.last_y[r]
    for r in range(w.m.size):
        w.m[r] = w.impacts.last_m[r]
    _series(w)


@compiled
def _rise(w: LoopArrays, n_x: int, s: int) -> float:
    """Return the derivative of the time in which bounces die out in direction s."""
    n_y, i, now = n_x // (1 + w.limits.varied), w.openings.direction[s], w.y[n_x]
    given = w.p[i] if i >= 0 else 0.0
    largest = 1.0 / abs(given) if given != 0.0 else 0.0
    for r in range(n_y):
        if w.scale[r] > 0.0:
            largest = max(largest, abs(_moves(w, n_y, s, r)) / w.scale[r])
    part = _PART / largest if largest > 0.0 else _PART
    found = 0.0
    for side in range(2):
        change = part if side == 0 else -part
        if i >= 0:
            w.p[i] = given + change
            w.impacts.asked[i] = w.p[i]
        for r in range(n_y):
            w.y[r] = w.impacts.entry_y[r] + change * _moves(w, n_y, s, r)
        w.y[n_x] = now + change * w.saltation.tau[s]
        ask(w)
        for r in range(n_y):
            w.y[r] = w.impacts.answer[r]
        _series(w)
        last = 0.0
        for k in range(w.openings.variable.size):
            if w.impacts.struck[k] != 0 and w.m[w.openings.variable[k]] > 0.5:
                last = max(last, all_flights(w, n_x, k))
        found += last / (2.0 * change)
    if i >= 0:
        w.p[i] = given
        w.impacts.asked[i] = given
    w.y[n_x] = now
    return found if abs(found) < np.inf else np.nan


@compiled(inline=True)
def _moves(w: LoopArrays, n_y: int, s: int, r: int) -> float:
    """Return how state r at the impact, at the time of that, changes in direction s."""
    return w.impacts.entry_y[n_y * (1 + s) + r] + w.impacts.slope_y[r] * w.saltation.tau[s]


@compiled
def count_flights(w: LoopArrays, n_x: int) -> None:
    """Raise integrals by what the open contacts add to them until their bounces have died out."""
    for r in range(w.m.size):
        w.impacts.entry_m[r] = w.m[r]
    for r in range(n_x):
        w.impacts.entry_y[r] = w.y[r]
    begin, length = w.y[n_x], min(w.clock.late, w.clock.t_end - w.y[n_x])
    probe(w)
    for r in range(n_x):
        w.impacts.last_y[r] = 0.0
        for j in range(PROBED, -1, -1):
            w.impacts.last_y[r] = w.impacts.last_y[r] * length + w.probe[r, j]
    _count(w, n_x, 0.0, length, -1.0)
    for r in range(w.m.size):
        w.m[r] = w.impacts.flight_m[r]
    _series(w)
    _count(w, n_x, 0.0, length, 1.0)
    for r in range(n_x):
        w.y[r] = w.impacts.last_y[r]
    w.y[n_x] = begin + length
    _count(w, n_x, length, length, 1.0)
    for r in range(w.m.size):
        w.m[r] = w.impacts.entry_m[r]
    _series(w)
    _count(w, n_x, length, length, -1.0)
    for r in range(n_x):
        w.y[r] = w.impacts.entry_y[r]
    w.y[n_x] = begin
    probe(w)


@compiled
def _series(w: LoopArrays) -> None:
    """Compute the first coefficients of all rows in the mode and with the parameters of the workspace."""
    prelude(w)
    probe(w)


@compiled
def _count(w: LoopArrays, n_x: int, at: float, length: float, sign: float) -> None:
    """Add the rows at one end, a time `at` after the impact, of an interval of a given length, or subtract them."""
    first, n_s, n_f = n_x + w.guards.hit.size, w.limits.varied, w.limits.followed
    n_e, impact = w.wanted.kind.size, w.y[n_x] - at + w.clock.t_low
    for e in range(n_e):
        if w.wanted.kind[e] != INTEGRAL:
            continue
        row, past = w.probe[first + e, 0], max(w.wanted.start[e] - impact, 0.0)
        if past >= length:
            continue
        half, total = sign * 0.5 * (length - past), w.observed.total
        total[e, 2], total[e, 3] = summed(total[e, 2], total[e, 3], half * row)
        for s in range(n_s if e < n_f else 0):
            f = n_e - n_f * n_s + e * n_s + s
            if at == 0.0 and past == 0.0:
                total[f, 2] -= sign * row * w.saltation.tau[s]
            elif at > 0.0 and length == w.clock.late:
                total[f, 2] += sign * row * (w.saltation.tau[s] + w.impacts.late[s])
