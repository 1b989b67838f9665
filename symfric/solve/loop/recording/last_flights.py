r"""Integrals over the last bounces: until these have died out the contact is open, although its mode is closed already.

A run closes a contact whose bounces are lower than its tolerance, at the time t of an impact, and they die out at
T = t + s: the flights of an infinite number of impacts, of length s in all; see
`symfric.solve.loop.modes.last_bounces`. The motion from t to T is in the mean that of the closed contact, but an
expression of the forces has the value that it has in flight. Integrals are therefore raised by

.. math:: \int_t^T (f_{open} - f_{closed}) dt \approx \tfrac s2 (d(t) + d(T)), \quad d = f_{open} - f_{closed},

both on the motion of the closed contact, with an error of the order of s^3. Derivatives of integrals are raised by the
same of their rows and by ``d(T) T' - d(t) t'``. With the last two flights a and b, one after the other, the times of the
impacts give ``s = b^2/(a - b)`` (Aitken), whose derivative follows from those of these times.
"""

from symfric.codegen.numba_types import compiled
from symfric.model.rows import INTEGRAL
from symfric.solve.loop.arithmetic import summed
from symfric.solve.loop.stepping.calls import prelude, probe
from symfric.solve.loop.stepping.series import PROBED
from symfric.solve.loop.workspace import LoopArrays

_LIKE = 0.1  # relative difference up to which the times of impacts tell the time at which bounces die out


@compiled
def forget_strikes(w: LoopArrays) -> None:
    """Forget the impacts of a run before."""
    for k in range(w.openings.variable.size):
        w.impacts.strikes[k, 0], w.impacts.strikes[k, 1 + w.limits.varied] = -1.0, -1.0


@compiled
def end_of_bounces(w: LoopArrays, n_x: int) -> None:
    """Determine how the time in which bounces die out changes in every direction of differentiation."""
    n_s, now = w.limits.varied, w.y[n_x] + w.clock.t_low
    for s in range(n_s):
        w.impacts.late[s] = 0.0
    for k in range(w.openings.variable.size):
        first, second = w.impacts.strikes[k, 0], w.impacts.strikes[k, 1 + n_s]
        a, b = second - first, now - second
        if w.impacts.struck[k] == 0 or first < 0.0 or not a > b > 0.0:
            continue
        if abs(b * b / (a - b) - w.clock.late) > _LIKE * w.clock.late:
            continue
        ratio = b / (a - b)
        for s in range(n_s):
            before, last = w.impacts.strikes[k, 1 + s], w.impacts.strikes[k, 2 + n_s + s]
            change_a, change_b = last - before, w.saltation.tau[s] - last
            w.impacts.late[s] = 2.0 * ratio * change_b - ratio * ratio * (change_a - change_b)
        return


@compiled
def note_strikes(w: LoopArrays, n_x: int) -> None:
    """Store the times of the last two impacts of every contact, and their derivatives."""
    n_s = w.limits.varied
    for k in range(w.openings.variable.size):
        if w.impacts.struck[k] == 0:
            continue
        for j in range(1 + n_s):
            w.impacts.strikes[k, j] = w.impacts.strikes[k, 1 + n_s + j]
        w.impacts.strikes[k, 1 + n_s] = w.y[n_x] + w.clock.t_low
        for s in range(n_s):
            w.impacts.strikes[k, 2 + n_s + s] = w.saltation.tau[s]


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
    _fly(w)
    _count(w, n_x, 0.0, length, 1.0)
    for r in range(n_x):
        w.y[r] = w.impacts.last_y[r]
    w.y[n_x] = begin + length
    _count(w, n_x, length, length, 1.0)
    _rest(w)
    _count(w, n_x, length, length, -1.0)
    for r in range(n_x):
        w.y[r] = w.impacts.entry_y[r]
    w.y[n_x] = begin
    probe(w)


@compiled
def _fly(w: LoopArrays) -> None:
    """Compute the rows of the flights."""
    for r in range(w.m.size):
        w.m[r] = w.impacts.flight_m[r]
    prelude(w)
    probe(w)


@compiled
def _rest(w: LoopArrays) -> None:
    """Compute the rows of the closed contact again."""
    for r in range(w.m.size):
        w.m[r] = w.impacts.entry_m[r]
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
