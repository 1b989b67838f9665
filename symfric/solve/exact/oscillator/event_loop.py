"""The event loop of one oscillator: from event to event in closed form."""

import numpy as np

from symfric.codegen.numba_types import call_code, compiled, part
from symfric.solve.exact.oscillator.closed_form import NEVER, basis, first_exit, first_zero, flow, integral
from symfric.solve.exact.oscillator.polynomial_path import keep
from symfric.solve.exact.oscillator.workspace import (
    A_0,
    A_U,
    A_X,
    BRANCH,
    BRANCHES,
    DIRECTION,
    LEFT,
    LOAD,
    PULL,
    RATE,
    ROWS,
    SHIFT,
    SPEED,
    STARTED,
    STATIC,
    STICKS,
    STILL,
    WHERE,
    J,
)
from symfric.solve.loop.event_loop import budget
from symfric.solve.loop.tolerances import MOST_DOUBT, ROUNDING, TIE
from symfric.solve.loop.workspace import (
    CHUNK,
    EVENTS,
    GO,
    GRAZES,
    KEEP_EVENTS,
    KEEP_PATH,
    KEPT_EVENTS,
    KEPT_STEPS,
    KINKS,
    MAX_STEPS,
    PHASE,
    REST,
    SETTLE,
    STALL,
    STEPS,
    T_END,
    T_LOW,
)
from symfric.solve.status import EVENTS_FULL, PATH_FULL, PAUSED, Status

_OK, _STEPS = int(Status.OK), int(Status.STEP_BUDGET)
_NAN, _LOST, _UNDECIDED = int(Status.NOT_FINITE), int(Status.LOST_CONTACT), int(Status.UNDECIDED)


@part
def reset(w):
    """Begin a run at t = 0 with what is given."""
    for i in range(2):
        w.y[i], w.largest[i] = w.given_y[i], abs(w.given_y[i])
    w.y[2] = 0.0
    for k in range(w.given_p.size):
        w.p[k] = w.given_p[k]
    call_code(w.code[0], w.p.ctypes.data, w.p.ctypes.data, w.data.ctypes.data)
    w.counts[:] = 0
    w.clock[T_LOW], w.clock[REST], w.clock[3] = 0.0, np.nan, 0.0
    w.m[STILL], w.m[STARTED], w.m[DIRECTION], w.m[WHERE] = 0, 0, 1, 0
    for e in range(w.limits[ROWS]):
        w.total[e, 0], w.total[e, 1] = np.inf, -np.inf


@part
def drive(w):
    """Go from the state in ``w.y`` to ``w.clock[T_END]``; return a status, or a reason to call again."""
    pause = w.counts[STEPS] + w.limits[CHUNK]
    while w.y[2] < w.clock[T_END]:
        if w.counts[STEPS] >= w.limits[MAX_STEPS]:
            return _STEPS
        if w.counts[STEPS] >= pause:
            return PAUSED
        if w.limits[KEEP_EVENTS] and w.counts[KEPT_EVENTS] >= w.event_t.size:
            return EVENTS_FULL
        if w.limits[KEEP_PATH] and w.counts[KEPT_STEPS] >= w.path_t.shape[0]:
            return PATH_FULL
        if w.counts[PHASE] == SETTLE:
            status = _switch(w)
            if status != _OK:
                return status
            w.counts[PHASE] = GO
        left = (w.clock[T_END] - w.y[2]) - w.clock[T_LOW]
        f = _flow(w)
        tau, side = _release(w, left) if w.m[STILL] else _exit(w, f, left)
        if w.limits[KEEP_PATH]:
            kept = w.counts[KEPT_STEPS]
            if keep(w, f, min(tau, left)) < min(tau, left):
                w.counts[KEPT_STEPS] = kept  # the step is repeated with more room, so that the motion is the same
                return PATH_FULL
        last = tau >= left
        _advance(w, f, left if last else tau)
        if not (abs(w.y[0]) < np.inf and abs(w.y[1]) < np.inf):
            return _NAN
        if last:
            w.y[2], w.clock[T_LOW] = w.clock[T_END], 0.0
        elif side != 0:
            _arrive(w, side)
            if w.counts[STALL] > 0:
                status = budget(w, 2)
                if status != _OK:
                    return status
    return _OK


@compiled(ieee_division=True)
def _flow(w):
    """Return the constants of the present mode's equation."""
    K, C = -w.data[A_X], -w.data[A_U]
    if w.limits[BRANCHES]:
        C += w.data[PULL] * w.data[J] * w.data[LOAD] * w.data[BRANCH + 3 * w.m[WHERE] + 2]
    return flow(K, C)


@compiled(ieee_division=True)
def _friction(w, speed):
    """Return the friction at a sliding speed."""
    k = BRANCH + 3 * w.m[WHERE]
    return -w.m[DIRECTION] * w.data[LOAD] * (w.data[k + 1] + w.data[k + 2] * speed)


@compiled(ieee_division=True)
def _release(w, left):
    """Return when the force that holds the contact reaches its bound, and which."""
    d = w.data
    held = -(d[A_X] * w.y[0] + d[A_U] * w.y[1] + d[A_0]) / d[PULL]
    rate = -d[A_X] * w.y[1] / d[PULL]
    if rate == 0.0:
        return NEVER, 0
    side = 1 if rate > 0.0 else -1
    tau = max(0.0, d[LOAD] * d[STATIC] - side * held) / abs(rate)
    return (tau, side) if tau < left else (NEVER, 0)


@compiled(ieee_division=True)
def _exit(w, f, left):
    """Return when the sliding speed leaves its branch of the law, and on which side."""
    if w.limits[BRANCHES] == 0:
        return NEVER, 0
    d, k = w.data, w.m[WHERE]
    rest = w.m[DIRECTION] * d[SHIFT]
    low = d[BRANCH + 3 * k - 3] if k > 0 else 0.0
    scale = w.m[DIRECTION] * d[J]
    return first_exit(f, w.v[SPEED] - rest, scale * w.v[RATE], low - rest, d[BRANCH + 3 * k] - rest, left)


@compiled(ieee_division=True)
def _advance(w, f, tau):
    """Move the state, keep what is wanted of the motion on the way."""
    x, u, a = w.y[0], w.y[1], w.v[RATE]
    if w.limits[ROWS]:
        _extend(w, f, x, u, a, 0.0)
    if w.m[STILL]:
        w.y[0] = x + u * tau
    else:
        g, rate = basis(f, tau)
        if w.limits[ROWS]:
            _turns(w, f, x, u, a, tau)
        w.y[0] = x + u * g + (a + f.C * u) * integral(f, tau, g, rate)
        w.y[1] = u * rate + (a + f.C * u) * g
        w.v[RATE] = a * rate - f.K * u * g
        w.v[SPEED] = w.m[DIRECTION] * (w.data[J] * w.y[1] + w.data[SHIFT])
    if w.limits[ROWS]:
        _extend(w, f, w.y[0], w.y[1], w.v[RATE], 0.0)
    for i in range(2):
        w.largest[i] = max(w.largest[i], abs(w.y[i]))
    gain = tau + w.clock[T_LOW]
    new = w.y[2] + gain
    w.clock[T_LOW] = gain - (new - w.y[2])
    w.y[2] = new
    w.counts[STEPS] += 1
    if tau > 0.0:
        w.counts[STALL] = 0


@compiled(ieee_division=True)
def _extend(w, f, x, u, a, t):
    """Extend the ranges of the rows by their values after the time t."""
    if t > 0.0:
        g, rate = basis(f, t)
        x, u = (
            x + u * g + (a + f.C * u) * integral(f, t, g, rate),
            u * rate + (a + f.C * u) * g,
        )
    d = w.data
    friction = 0.0
    if w.limits[BRANCHES]:
        if w.m[STILL]:
            friction = -(d[A_X] * x + d[A_U] * u + d[A_0]) / d[PULL]
        else:
            friction = _friction(w, w.m[DIRECTION] * (d[J] * u + d[SHIFT]))
    k = BRANCH + 3 * w.limits[BRANCHES]
    for e in range(w.limits[ROWS]):
        value = d[k] + d[k + 1] * x + d[k + 2] * u + d[k + 3] * friction
        w.total[e, 0], w.total[e, 1] = min(w.total[e, 0], value), max(w.total[e, 1], value)
        k += 4


@compiled(ieee_division=True)
def _turns(w, f, x, u, a, tau):
    """Extend the ranges of the rows by their turning points within tau; the largest are the first or the last."""
    d = w.data
    k = BRANCH + 3 * w.limits[BRANCHES]
    for _ in range(w.limits[ROWS]):
        along, across = d[k + 1], d[k + 2]
        if w.limits[BRANCHES]:
            across -= d[k + 3] * d[LOAD] * d[J] * d[BRANCH + 3 * w.m[WHERE] + 2]
        t = first_zero(f, along * u + across * a, along * a - across * (f.C * a + f.K * u))
        k += 4
        if t >= tau:
            continue
        _extend(w, f, x, u, a, t)
        if f.swings:
            half = np.pi / f.r
            more = int((tau - t) / half)
            for n in (1, more - 1, more):
                if 0 < n <= more:
                    _extend(w, f, x, u, a, t + n * half)


@compiled(ieee_division=True)
def _arrive(w, side):
    """Make the event exact: a release, a change of the law's branch, or zero slip, which must be settled."""
    d = w.data
    if w.m[STILL]:
        w.m[STARTED] = -side - 3  # the direction of the slip, known
        w.counts[PHASE] = SETTLE
        return
    if side < 0 and w.m[WHERE] == 0:
        w.m[STARTED] = 2
        w.counts[PHASE] = SETTLE
        return
    if side < 0:
        w.m[WHERE] -= 1
    w.v[SPEED] = d[BRANCH + 3 * w.m[WHERE]]
    if side > 0:
        w.m[WHERE] += 1
    w.y[1] = (w.m[DIRECTION] * w.v[SPEED] - d[SHIFT]) / d[J]
    w.v[RATE] = d[A_X] * w.y[0] + d[A_U] * w.y[1] + d[A_0] + d[PULL] * _friction(w, w.v[SPEED])
    w.counts[KINKS] += 1
    w.counts[STALL] += 1


@compiled(ieee_division=True)
def _switch(w):
    """Settle the mode and log what changed."""
    d = w.data
    if w.limits[BRANCHES] == 0:
        w.v[RATE] = d[A_X] * w.y[0] + d[A_U] * w.y[1] + d[A_0]
        return _OK
    if d[LOAD] < 0.0:
        return _LOST
    if d[STATIC] * (1.0 + 1e-12) < d[BRANCH + 1]:
        return _UNDECIDED
    starting = w.m[STARTED] == 0
    before = 0 if w.m[STILL] else w.m[DIRECTION]
    slip = d[J] * w.y[1] + d[SHIFT]
    if starting and abs(slip) > ROUNDING * (abs(d[J] * w.y[1]) + abs(d[SHIFT])):
        w.m[DIRECTION] = 1 if slip > 0.0 else -1
        w.v[SPEED] = abs(slip)
        _find_branch(w)
    else:
        w.y[1] = -d[SHIFT] / d[J]
        w.v[SPEED] = 0.0
        w.m[WHERE] = 0
        way = w.m[STARTED] + 3 if w.m[STARTED] < 0 else _way(w)
        w.m[STILL] = way == 0
        if way != 0:
            w.m[DIRECTION] = way
    w.m[STARTED] = 1
    w.v[RATE] = 0.0
    if w.m[STILL] == 0:
        _accelerate(w)
    after = 0 if w.m[STILL] else w.m[DIRECTION]
    if after != 0 or w.y[1] != 0.0:
        w.clock[REST] = np.nan
    elif not w.clock[REST] >= 0.0:
        w.clock[REST] = w.y[2] + w.clock[T_LOW]
    if starting:
        return _OK
    if after == before:
        w.counts[GRAZES] += 1
    else:
        if w.limits[KEEP_EVENTS]:
            k = w.counts[KEPT_EVENTS]
            w.event_t[k] = w.y[2] + w.clock[T_LOW]
            w.event_i[k, 0], w.event_i[k, 1], w.event_i[k, 2] = 0, before, after
            w.counts[KEPT_EVENTS] += 1
        w.counts[EVENTS] += 1
    w.counts[STALL] += 1
    return budget(w, 2)


@compiled(ieee_division=True)
def _find_branch(w):
    w.m[WHERE] = 0
    while w.v[SPEED] > w.data[BRANCH + 3 * w.m[WHERE]]:
        w.m[WHERE] += 1


@compiled(ieee_division=True)
def _accelerate(w):
    """Compute the acceleration of a slip that begins; what rounding leaves of none is none."""
    d = w.data
    free = d[A_X] * w.y[0] + d[A_U] * w.y[1] + d[A_0]
    w.v[RATE] = free + d[PULL] * _friction(w, w.v[SPEED])
    if w.v[SPEED] == 0.0 and abs(w.v[RATE]) <= TIE * abs(d[PULL] * d[LOAD]) * (d[STATIC] + abs(d[BRANCH + 1])):
        w.v[RATE] = 0.0


@compiled(ieee_division=True)
def _way(w):
    """Return the way a contact at zero slip goes on: 0 sticks, else the direction of its slip."""
    d = w.data
    free = d[A_X] * w.y[0] + d[A_U] * w.y[1] + d[A_0]
    if not w.limits[STICKS]:
        way = d[J] * free
        if abs(way) <= TIE * abs(d[J]) * (abs(d[A_X] * w.y[0]) + abs(d[A_U] * w.y[1]) + abs(d[A_0])):
            way = d[J] * d[A_X] * w.y[1]
        return w.m[DIRECTION] if way == 0.0 else (1 if way > 0.0 else -1)
    held, rate = -free / d[PULL], -d[A_X] * w.y[1] / d[PULL]
    bound = d[LOAD] * d[STATIC]
    room, scale = bound - abs(held), bound + abs(held)
    way = (-1 if held > 0.0 else 1) if held != 0.0 else (-1 if rate > 0.0 else 1)
    if room < -_doubt(w) * scale:
        return way
    if room <= ROUNDING * scale and -way * rate * w.clock[T_END] > TIE * scale:
        return way
    return 0


@compiled(ieee_division=True)
def _doubt(w):
    """Return the part of its bound by which rounding may have falsified the stick force."""
    if w.m[STARTED] == 0:
        return TIE
    d = w.data
    pull = abs(d[PULL]) * d[LOAD] * d[STATIC]
    size = abs(d[A_X]) * w.largest[0] + abs(d[A_U]) * w.largest[1] + abs(d[A_0])
    return max(ROUNDING, min(MOST_DOUBT, LEFT * (1.0 + size / pull))) if pull > 0.0 else ROUNDING
