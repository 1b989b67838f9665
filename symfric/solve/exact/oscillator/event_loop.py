"""Event loop of one oscillator, in closed form between events."""

import numpy as np

from symfric.codegen.numba_types import call_code, compiled, part
from symfric.solve.exact.oscillator.closed_form import NEVER, Flow, basis, first_exit, first_zero, flow, integral
from symfric.solve.exact.oscillator.polynomial_path import keep
from symfric.solve.exact.oscillator.workspace import (
    A_0,
    A_U,
    A_X,
    BRANCH,
    LEFT,
    LOAD,
    PULL,
    SHIFT,
    STATIC,
    J,
    OscillatorArrays,
)
from symfric.solve.loop.codes import GO, LOST_CONTACT, NOT_FINITE, OK, SELECT, UNDECIDED
from symfric.solve.loop.precision import MOST_DOUBT, ROUNDING, TIE
from symfric.solve.loop.run_rules import begin_counting, budget, pause
from symfric.solve.status import PATH_FULL


@part
def reset(w: OscillatorArrays) -> None:
    """Start a run at t = 0 from the given state and parameters."""
    for i in range(2):
        w.y[i], w.largest[i] = w.given_y[i], abs(w.given_y[i])
    w.y[2] = 0.0
    for k in range(w.given_p.size):
        w.p[k] = w.given_p[k]
    call_code(w.code[0], w.p.ctypes.data, w.p.ctypes.data, w.data.ctypes.data)
    begin_counting(w)
    w.m.still, w.m.started, w.m.direction, w.m.where = 0, 0, 1, 0
    for e in range(w.limits.rows):
        w.observed.total[e, 0], w.observed.total[e, 1] = np.inf, -np.inf


@part
def drive(w: OscillatorArrays) -> int:
    """Advance the state in ``w.y`` to ``w.clock.t_end``; return a status, or a code to call again."""
    stop = w.counts.steps + w.limits.chunk
    while w.y[2] < w.clock.t_end:
        status = pause(w, stop, 1)
        if status != OK:
            return status
        if w.counts.phase == SELECT:
            status = _switch(w)
            if status != OK:
                return status
            w.counts.phase = GO
        left = (w.clock.t_end - w.y[2]) - w.clock.t_low
        f = _flow(w)
        if not f.r < np.inf:  # the rates of the equation overflow
            return NOT_FINITE
        tau, side = _release(w, left) if w.m.still else _exit(w, f, left)
        if w.limits.keep_path:
            kept = w.counts.kept_steps
            if keep(w, f, min(tau, left)) < min(tau, left):
                w.counts.kept_steps = kept  # the step is repeated with more memory, so that the result is the same
                return PATH_FULL
        last = tau >= left
        _advance(w, f, left if last else tau)
        if not (abs(w.y[0]) < np.inf and abs(w.y[1]) < np.inf):
            return NOT_FINITE
        if last:
            w.y[2], w.clock.t_low = w.clock.t_end, 0.0
        elif side != 0:
            _arrive(w, side)
            if w.counts.stall > 0:
                status = budget(w, w.y[2])
                if status != OK:
                    return status
    return OK


@compiled(ieee_division=True)
def _flow(w: OscillatorArrays) -> Flow:
    """Return the constants of the equation in the current mode."""
    K, C = -w.data[A_X], -w.data[A_U]
    if w.limits.branches:
        C += w.data[PULL] * w.data[J] * w.data[LOAD] * w.data[BRANCH + 3 * w.m.where + 2]
    return flow(K, C)


@compiled(ieee_division=True)
def _friction(w: OscillatorArrays, speed: float) -> float:
    """Return the friction at a sliding speed."""
    k = BRANCH + 3 * w.m.where
    return -w.m.direction * w.data[LOAD] * (w.data[k + 1] + w.data[k + 2] * speed)


@compiled(ieee_division=True)
def _release(w: OscillatorArrays, left: float) -> tuple[float, int]:
    """Return the time at which the constraint force of the contact reaches a bound, and which bound."""
    d = w.data
    # a contact that sticks moves x at a constant velocity, so its force is linear in time
    held = -(d[A_X] * w.y[0] + d[A_U] * w.y[1] + d[A_0]) / d[PULL]
    rate = -d[A_X] * w.y[1] / d[PULL]
    if rate == 0.0:
        return NEVER, 0
    side = 1 if rate > 0.0 else -1
    tau = max(0.0, d[LOAD] * d[STATIC] - side * held) / abs(rate)
    return (tau, side) if tau < left else (NEVER, 0)


@compiled(ieee_division=True)
def _exit(w: OscillatorArrays, f: Flow, left: float) -> tuple[float, int]:
    """Return the time at which the sliding speed leaves its branch of the law, and on which side."""
    if w.limits.branches == 0:
        return NEVER, 0
    d, k = w.data, w.m.where
    rest = w.m.direction * d[SHIFT]
    low = d[BRANCH + 3 * k - 3] if k > 0 else 0.0
    scale = w.m.direction * d[J]
    return first_exit(f, w.v.speed - rest, scale * w.v.rate, low - rest, d[BRANCH + 3 * k] - rest, left)


@compiled(ieee_division=True)
def _advance(w: OscillatorArrays, f: Flow, tau: float) -> None:
    """Advance the state, and accumulate observables and trajectory."""
    x, u, a = w.y[0], w.y[1], w.v.rate
    if w.limits.rows:
        _extend(w, f, x, u, a, 0.0)
    if w.m.still:
        w.y[0] = x + u * tau
    else:
        g, rate = basis(f, tau)
        if w.limits.rows:
            _turns(w, f, x, u, a, tau)
        w.y[0] = x + u * g + (a + f.C * u) * integral(f, tau, g, rate)
        w.y[1] = u * rate + (a + f.C * u) * g
        w.v.rate = a * rate - f.K * u * g
        w.v.speed = w.m.direction * (w.data[J] * w.y[1] + w.data[SHIFT])
    if w.limits.rows:
        _extend(w, f, w.y[0], w.y[1], w.v.rate, 0.0)
    for i in range(2):
        w.largest[i] = max(w.largest[i], abs(w.y[i]))
    # compensated summation (Kahan, 1965): time stays exact over millions of pieces
    gain = tau + w.clock.t_low
    new = w.y[2] + gain
    w.clock.t_low = gain - (new - w.y[2])
    w.y[2] = new
    w.counts.steps += 1
    if tau > 0.0:
        w.counts.stall = 0


@compiled(ieee_division=True)
def _extend(w: OscillatorArrays, f: Flow, x: float, u: float, a: float, t: float) -> None:
    """Extend the ranges of the observables by their values after the time t."""
    if t > 0.0:
        g, rate = basis(f, t)
        x, u = (
            x + u * g + (a + f.C * u) * integral(f, t, g, rate),
            u * rate + (a + f.C * u) * g,
        )
    d = w.data
    friction = 0.0
    if w.limits.branches:
        if w.m.still:
            friction = -(d[A_X] * x + d[A_U] * u + d[A_0]) / d[PULL]
        else:
            friction = _friction(w, w.m.direction * (d[J] * u + d[SHIFT]))
    k = BRANCH + 3 * w.limits.branches
    for e in range(w.limits.rows):
        value = d[k] + d[k + 1] * x + d[k + 2] * u + d[k + 3] * friction
        w.observed.total[e, 0], w.observed.total[e, 1] = (
            min(w.observed.total[e, 0], value),
            max(w.observed.total[e, 1], value),
        )
        k += 4


@compiled(ieee_division=True)
def _turns(w: OscillatorArrays, f: Flow, x: float, u: float, a: float, tau: float) -> None:
    """Extend the ranges of the observables by their turning points within tau; the first or last are extreme."""
    d = w.data
    k = BRANCH + 3 * w.limits.branches
    for _ in range(w.limits.rows):
        along, across = d[k + 1], d[k + 2]
        if w.limits.branches:
            across -= d[k + 3] * d[LOAD] * d[J] * d[BRANCH + 3 * w.m.where + 2]
        t = first_zero(f, along * u + across * a, along * a - across * (f.C * a + f.K * u))
        k += 4
        if t >= tau:
            continue
        _extend(w, f, x, u, a, t)
        if f.swings:  # turns follow each other by half a period, ever smaller or ever larger
            half = np.pi / f.r
            more = int((tau - t) / half)
            for n in (1, more - 1, more):
                if 0 < n <= more:
                    _extend(w, f, x, u, a, t + n * half)


@compiled(ieee_division=True)
def _arrive(w: OscillatorArrays, side: int) -> None:
    """Set the state exactly to the event: a release, a change of the law's branch, or zero slip."""
    d = w.data
    if w.m.still:
        w.m.started = -side - 3  # encodes the known direction of the slip
        w.counts.phase = SELECT
        return
    if side < 0 and w.m.where == 0:
        w.m.started = 2
        w.counts.phase = SELECT
        return
    if side < 0:
        w.m.where -= 1
    w.v.speed = d[BRANCH + 3 * w.m.where]  # exactly, lest the next branch begin on the wrong side of its edge
    if side > 0:
        w.m.where += 1
    w.y[1] = (w.m.direction * w.v.speed - d[SHIFT]) / d[J]
    w.v.rate = d[A_X] * w.y[0] + d[A_U] * w.y[1] + d[A_0] + d[PULL] * _friction(w, w.v.speed)
    w.counts.kinks += 1
    w.counts.stall += 1


@compiled(ieee_division=True)
def _switch(w: OscillatorArrays) -> int:
    """Select the next mode and log the change."""
    d = w.data
    if w.limits.branches == 0:
        w.v.rate = d[A_X] * w.y[0] + d[A_U] * w.y[1] + d[A_0]
        return OK
    if d[LOAD] < 0.0:
        return LOST_CONTACT
    if not -1e-12 * d[STATIC] <= d[BRANCH + 1] <= d[STATIC] * (1.0 + 1e-12):
        return UNDECIDED
    starting = w.m.started == 0
    before = 0 if w.m.still else w.m.direction
    slip = d[J] * w.y[1] + d[SHIFT]
    if starting and abs(slip) > ROUNDING * (abs(d[J] * w.y[1]) + abs(d[SHIFT])):
        w.m.direction = 1 if slip > 0.0 else -1
        w.v.speed = abs(slip)
        _find_branch(w)
    else:
        w.y[1] = -d[SHIFT] / d[J]
        w.v.speed = 0.0
        w.m.where = 0
        way = w.m.started + 3 if w.m.started < 0 else _way(w)
        w.m.still = way == 0
        if way != 0:
            w.m.direction = way
    w.m.started = 1
    w.v.rate = 0.0
    if w.m.still == 0:
        _accelerate(w)
    after = 0 if w.m.still else w.m.direction
    if after != 0 or w.y[1] != 0.0:
        w.clock.rest = np.nan
    elif not w.clock.rest >= 0.0:
        w.clock.rest = w.y[2] + w.clock.t_low
    if starting:
        return OK
    if after == before:
        w.counts.grazes += 1
    else:
        if w.limits.keep_events:
            k = w.counts.kept_events
            w.stored.event_t[k] = w.y[2] + w.clock.t_low
            w.stored.event_i[k, 0], w.stored.event_i[k, 1], w.stored.event_i[k, 2] = 0, before, after
            w.counts.kept_events += 1
        w.counts.events += 1
    w.counts.stall += 1
    return budget(w, w.y[2])


@compiled(ieee_division=True)
def _find_branch(w: OscillatorArrays) -> None:
    w.m.where = 0
    while w.v.speed > w.data[BRANCH + 3 * w.m.where]:
        w.m.where += 1


@compiled(ieee_division=True)
def _accelerate(w: OscillatorArrays) -> None:
    """Compute the acceleration of a starting slip, with rounding errors set to zero."""
    d = w.data
    free = d[A_X] * w.y[0] + d[A_U] * w.y[1] + d[A_0]
    w.v.rate = free + d[PULL] * _friction(w, w.v.speed)
    if w.v.speed == 0.0 and abs(w.v.rate) <= TIE * abs(d[PULL] * d[LOAD]) * (d[STATIC] + abs(d[BRANCH + 1])):
        w.v.rate = 0.0


@compiled(ieee_division=True)
def _way(w: OscillatorArrays) -> int:
    """Return the next mode of a contact at zero slip: 0 sticks, else the direction of its slip."""
    d = w.data
    free = d[A_X] * w.y[0] + d[A_U] * w.y[1] + d[A_0]
    if not w.limits.sticks:
        way = d[J] * free
        if abs(way) <= TIE * abs(d[J]) * (abs(d[A_X] * w.y[0]) + abs(d[A_U] * w.y[1]) + abs(d[A_0])):
            way = d[J] * d[A_X] * w.y[1]
        return w.m.direction if way == 0.0 else (1 if way > 0.0 else -1)
    held, rate = -free / d[PULL], -d[A_X] * w.y[1] / d[PULL]
    bound = d[LOAD] * d[STATIC]
    room, scale = bound - abs(held), bound + abs(held)
    way = (-1 if held > 0.0 else 1) if held != 0.0 else (-1 if rate > 0.0 else 1)
    if room < -_doubt(w) * scale:
        return way
    if room <= ROUNDING * scale and -way * rate * w.clock.t_end > TIE * scale:
        return way
    return 0


@compiled(ieee_division=True)
def _doubt(w: OscillatorArrays) -> float:
    """Return the possible rounding error of the stick force, relative to its bound."""
    if w.m.started == 0:
        return TIE
    d = w.data
    pull = abs(d[PULL]) * d[LOAD] * d[STATIC]
    size = abs(d[A_X]) * w.largest[0] + abs(d[A_U]) * w.largest[1] + abs(d[A_0])
    return max(ROUNDING, min(MOST_DOUBT, LEFT * (1.0 + size / pull))) if pull > 0.0 else ROUNDING
