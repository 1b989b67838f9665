"""Loop over the samples of one mass on a rough floor under a sampled input, in closed form between samples.

Between two samples, slipping in one direction inside one cell of the friction profile, the mass is an oscillator under
a force that is linear in time: its transition over a whole sample is made once for each slope of the profile and each
direction. Within a sample the rate of w has at most one zero, so w has at most one turning point and two zeros; each is
bracketed.
"""

import math
from typing import Any

import numpy as np

from symfric.codegen.numba_types import call_code, compiled, part
from symfric.solve.exact.record.accumulation import (
    CONSTANT,
    GAIN,
    HIGH,
    KINETIC,
    LAM,
    LOW,
    MU,
    SLOPE,
    STIFF,
    enter,
    hold,
    is_plain,
    log,
    note,
    note_end,
    quiet,
)
from symfric.solve.exact.record.cells import (
    AHEAD,
    BEHIND,
    FARTHEST,
    ahead,
    bound_friction,
    cell_of,
    drive,
    friction_holds,
    is_lost,
    take_off,
)
from symfric.solve.exact.record.forced_flow import (
    KAPPA,
    UF,
    UG,
    UU,
    UW,
    WF,
    WG,
    WU,
    WW,
    order_for,
    root,
    series,
    value,
)
from symfric.solve.exact.record.workspace import RecordArrays
from symfric.solve.loop.arithmetic import slope
from symfric.solve.loop.codes import LOST_CONTACT, NOT_FINITE, OK, STEP_BUDGET
from symfric.solve.loop.run_rules import begin_counting, begin_values, budget
from symfric.solve.status import EVENTS_FULL, PATH_FULL

INSIDE, AT_REST, AT_EDGE = range(3)  # kinds of end of a piece


@part
def reset(w: RecordArrays) -> None:
    """Read the given parameters and compute the transitions."""
    for k in range(w.given_p.size):
        w.p[k] = w.given_p[k]
    call_code(w.code[0], w.p.ctypes.data, w.p.ctypes.data, w.data.ctypes.data)
    n_f, n_c, n_e = w.force.size, w.cells.shape[0], w.rows.shape[0]
    for k in range(n_f):
        w.force[k] = w.data[k]
    for k in range(4 * n_c):
        w.cells[k // 4, k % 4] = w.data[n_f + k]
    for k in range(5 * n_e):
        w.rows[k // 5, k % 5] = w.data[n_f + 4 * n_c + k]
    w.place.gaps = 0
    for c in range(n_c):
        take_off(w, c)
    kinds, w.sizes.stiffest = 0, 0.0
    for c in range(n_c):
        k = 0
        while k < kinds and w.kinds[n_c + k] != c and w.cells[w.kinds[n_c + k], SLOPE] != w.cells[c, SLOPE]:
            k += 1
        if k == kinds:
            w.kinds[n_c + k] = c
            kinds += 1
        w.kinds[c] = k
    for k in range(kinds):
        friction = w.force[KINETIC] * w.cells[w.kinds[n_c + k], SLOPE]
        w.sizes.stiffest = max(w.sizes.stiffest, abs(w.force[STIFF]) + abs(friction))
    fastest = max(abs(w.force[LAM]), math.sqrt(w.sizes.stiffest))
    w.place.parts = max(1, math.ceil(w.record.dt * fastest))
    # s^2 = -(lam s + kappa) bounds a root s by (1 + sqrt 5)/2 = 1.62 times the larger of |lam| and sqrt|kappa|
    w.place.order = order_for(1.7 * fastest * w.record.dt / w.place.parts)
    for k in range(w.cu.size):
        w.cu[k] = w.cw[k] = 0.0
    for k in range(kinds):
        friction = w.force[KINETIC] * w.cells[w.kinds[n_c + k], SLOPE]
        for side in range(2):
            _transition(w, w.tables[2 * k + side], w.force[STIFF] + (2 * side - 1) * friction)


@compiled
def _transition(w: RecordArrays, table: np.ndarray, kappa: float) -> None:
    """Compute the transition over a whole part of a sample."""
    h = w.record.dt / w.place.parts
    cu, cw = w.cu[: w.place.order + 1], w.cw[: w.place.order + 1]
    for column in range(4):
        u, v = 1.0 if column == 0 else 0.0, 1.0 if column == 1 else 0.0
        f, g = 1.0 if column == 2 else 0.0, 1.0 if column == 3 else 0.0
        series(u, v, f, g, w.force[LAM], kappa, cu, cw)
        table[column] = value(cu, h)
        table[4 + column] = value(cw, h)
    table[KAPPA] = kappa


@compiled
def _first_end(w: RecordArrays, cu: np.ndarray, cw: np.ndarray, s: float, h: float) -> tuple[float, int]:
    """Return the time at which a slip with these series ends within h, and the kind of end."""
    at_start, at_end = s * cw[1], s * slope(cw, h)
    stop, kind = h, INSIDE
    falls_from, falls_to = 0.0, h
    if at_start < 0.0 <= at_end:
        falls_to = root(cw, 0.0, 0.0, h, True)
    elif at_end < 0.0 < at_start:
        falls_from = root(cw, 0.0, 0.0, h, True)
    elif at_start >= 0.0:
        falls_from = h
    if falls_from < h and s * value(cw, falls_to) <= 0.0 and s * value(cw, falls_from) > 0.0:
        stop, kind = root(cw, 0.0, falls_from, falls_to, False), AT_REST
    line = w.cells[w.place.where]
    edge = line[HIGH] if s > 0.0 else line[LOW]
    if s * (value(cu, stop) - edge) > 0.0:
        stop, kind = root(cu, edge, 0.0, stop, False), AT_EDGE
    return stop, kind


@compiled
def _slip(
    w: RecordArrays, t: float, h: float, u: float, v: float, s: float, a: float, slope_a: float
) -> tuple[float, float, float, int]:
    """Slip for at most h; return u, w, the time used and the kind of end."""
    line = w.cells[w.place.where]
    force = w.force[GAIN] * a + w.force[CONSTANT] - s * w.force[KINETIC] * line[MU]
    kappa = w.force[STIFF] + s * w.force[KINETIC] * line[SLOPE]
    cu, cw = w.cu[: w.place.order + 1], w.cw[: w.place.order + 1]
    series(u, v, force, w.force[GAIN] * slope_a, w.force[LAM], kappa, cu, cw)
    stop, kind = _first_end(w, cu, cw, s, h)
    note(w, t, stop, a, slope_a, int(s))
    u, v = value(cu, stop), value(cw, stop)
    if kind == AT_REST:
        v = 0.0
    elif kind == AT_EDGE:
        u = line[HIGH] if s > 0.0 else line[LOW]
    return u, v, stop, kind


@compiled
def _stick(w: RecordArrays, t: float, h: float, u: float, a: float, slope_a: float) -> tuple[float, float]:
    """Stick for at most h; return the time used and the direction of the slip that follows."""
    stop, side = 0.0, drive(w, u, a)
    if side == 0.0:
        stop, side = h, drive(w, u, a + slope_a * h)
        if side != 0.0:
            bound = side * w.grip[AHEAD if side > 0.0 else BEHIND]
            applied = w.force[GAIN] * a + w.force[CONSTANT] - w.force[STIFF] * u
            stop = min(h, max(0.0, (bound - applied) / (w.force[GAIN] * slope_a)))
    for k in range(w.cu.size):
        w.cu[k] = w.cw[k] = 0.0
    w.cu[0] = u
    note(w, t, stop, a, slope_a, 0)
    return stop, side


@compiled
def _turn(w: RecordArrays, t: float, old: float, new: float, u: float) -> None:
    """Log a change of mode."""
    if new != old:
        log(w, t, old, new)
    if new == 0.0:
        w.clock.rest = t
        hold(w, u)
    else:
        w.clock.rest = np.nan
        w.place.where = ahead(w, u, new)
        enter(w, new)


@compiled
def _next_due(w: RecordArrays, i: int, whole: float) -> np.int64:
    """Return the next interval after i in which an observable is sampled."""
    due = np.int64(2**62)
    for e in range(w.observed.next_due.size):
        for k in range(w.observed.next_due[e], w.times.first[e + 1]):
            interval = np.int64(w.times.due[k] / whole - 1e-9)  # a time on a sample belongs to the interval before it
            if i < interval < due:
                due = interval
    return due


@compiled
def _begin(w: RecordArrays) -> tuple[float, float, float]:
    """Initialise the run; return displacement, velocity and mode."""
    u, v = w.given_y[0], w.given_y[1]
    begin_counting(w)
    begin_values(w)
    for e in range(w.observed.total.shape[0]):
        w.observed.total[e, 0], w.observed.total[e, 1] = np.inf, -np.inf
    w.place.where, w.grip[FARTHEST] = cell_of(w, u), abs(u)
    if v == 0.0:
        u = bound_friction(w, u)
    s = math.copysign(1.0, v) if v != 0.0 else drive(w, u, w.samples[0])
    _turn(w, 0.0, s, s, u)
    return u, v, s


@compiled
def _stick_on(w: RecordArrays, i: int, stop: Any, u: float) -> int:
    """Stick over whole samples; return the first in which the mass is released, or `stop`."""
    while i < stop:
        b = w.samples[i + 1] if i < w.samples.size - 1 else 0.0
        if drive(w, u, b) != 0.0:
            break
        note_end(w, u, b)
        i += 1
    return i


@compiled(inline=True)
def _slip_on(w: RecordArrays, i: int, stop: Any, u: float, v: float, s: float) -> tuple[int, float, float]:
    """Slip over whole samples without events; return the first in which an event may occur, u and w."""
    c, n = w.place.where, w.samples.size - 1
    low, high = w.cells[c, LOW], w.cells[c, HIGH]
    steady = w.force[CONSTANT] - s * w.force[KINETIC] * w.cells[c, MU]
    k = 2 * w.kinds[c] + (1 if s > 0.0 else 0)
    uu, uw, uf, ug = w.tables[k, UU], w.tables[k, UW], w.tables[k, UF], w.tables[k, UG]
    wu, ww, wf, wg = w.tables[k, WU], w.tables[k, WW], w.tables[k, WF], w.tables[k, WG]
    kappa, lam, gain, dt = w.tables[k, KAPPA], w.force[LAM], w.force[GAIN], w.record.dt
    per_dt, plain = 1.0 / dt, is_plain(w)
    a = w.samples[i] if i < n else 0.0
    rate = gain * a + steady - lam * v - kappa * u
    while i < stop:
        b = w.samples[i + 1] if i < n else 0.0
        g, g1 = gain * a + steady, gain * (b - a) * per_dt
        v1 = (wf * g + wg * g1) + (wu * u + ww * v)
        u1 = (uf * g + ug * g1) + (uu * u + uw * v)
        then = gain * b + steady - lam * v1 - kappa * u1
        turns = rate * then <= 0.0
        if not (s * v1 > 0.0 and low < u1 < high):
            break
        if turns or not plain:
            steep = max(abs(rate), abs(then))
            if (turns and s * v1 <= 2.0 * dt * steep) or not quiet(w, dt, u1, v1, b, steep, turns, g1):
                break
        i, a, u, v, rate = i + 1, b, u1, v1, then
    return i, u, v


@part
def march(w: RecordArrays) -> int:
    """Run over the record and on to the horizon; return a status."""
    u, v, s = _begin(w)
    w.y[0], w.y[1], w.y[2] = u, v, 0.0
    status = friction_holds(w, u)
    if status != OK:
        return status
    dt, parts, n = w.record.dt, w.place.parts, w.samples.size - 1
    whole = dt / parts
    last = math.ceil(w.clock.t_end / dt - 1e-9) - 1
    i, part, tau = 0, 0, 0.0  # index of the sample and of its part, time since the start of the sample
    due = _next_due(w, -1, dt)
    while True:
        inside = i < n
        a = w.samples[i] if inside else 0.0
        slope_a = (w.samples[i + 1] - a) / dt if inside else 0.0
        t = i * dt + part * whole + tau
        h = min(whole, w.clock.t_end - i * dt - part * whole)
        if s == 0.0 and not inside and drive(w, u, 0.0) == 0.0:  # at rest until the horizon
            i, part, tau, h = last, parts - 1, 0.0, w.clock.t_end - t
        a_now = a + slope_a * (part * whole + tau)
        if s == 0.0:
            spent, new = _stick(w, t, h - tau, u, a_now, slope_a)
            kind = INSIDE if new == 0.0 else AT_REST
        else:
            u, v, spent, kind = _slip(w, t, h - tau, u, v, s, a_now, slope_a)
            new = s
            if kind == AT_REST:
                u = bound_friction(w, u)
                new = drive(w, u, a_now + slope_a * spent)
        w.counts.steps += 1
        w.counts.stall = 0 if spent > 0.0 else w.counts.stall + 1
        w.y[0], w.y[1], w.y[2] = u, v, t + spent
        if kind == AT_EDGE:
            following = w.place.where + int(s)
            if not 0 <= following < w.cells.shape[0]:
                return LOST_CONTACT
            w.place.where = following
            w.counts.kinks += 1
            enter(w, s)
        elif kind == AT_REST:
            _turn(w, t + spent, s, new, u)
            s = new
        if is_lost(w, u):
            return LOST_CONTACT
        status = budget(w, t)
        if status != OK:
            return status
        if w.counts.steps > w.limits.max_steps:
            return STEP_BUDGET
        if kind != INSIDE:
            tau += spent
            continue
        tau, part = 0.0, part + 1
        if part == parts:
            i, part = i + 1, 0
        if i > last or t + spent >= w.clock.t_end:
            break
        if i > due:
            due = _next_due(w, i - 1, dt)
        if parts == 1 and not w.limits.keep_path:
            stop = min(last, due, n if i < n else last)
            if s == 0.0:
                i = _stick_on(w, i, stop, u)
            else:
                i, u, v = _slip_on(w, i, stop, u, v, s)
    w.y[0], w.y[1], w.y[2] = u, v, w.clock.t_end
    if w.limits.keep_path and w.counts.kept_steps > w.stored.path_t.shape[0]:
        return PATH_FULL
    if w.limits.keep_events and w.counts.kept_events > w.stored.event_t.size:
        return EVENTS_FULL
    return OK if abs(u) < np.inf and abs(v) < np.inf else NOT_FINITE
