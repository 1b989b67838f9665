"""The first guard that becomes negative within a step."""

from symfric.codegen.numba_types import compiled
from symfric.lower.cell_edges import ON_EDGE
from symfric.solve.loop.arithmetic import is_still
from symfric.solve.loop.codes import FORCES, HIT, LOADED, TERMS
from symfric.solve.loop.events.polynomials import first_crossing
from symfric.solve.loop.modes.layout import contact_of, is_along_line, is_load, is_slip, is_switch, sign, switch
from symfric.solve.loop.modes.resting_edges import decisive, size_of
from symfric.solve.loop.modes.tolerances import LAST, instant, natural_time, no_acceleration
from symfric.solve.loop.precision import EPS, LEAST_TERM, NEAREST, TOUCH
from symfric.solve.loop.stepping.series import PROBED
from symfric.solve.loop.stepping.step_acceptance import reach
from symfric.solve.loop.workspace import LoopArrays

_SHORT = 0.5  # where a step to a stop in the plane ends, as part of the straight line before it
_WITHIN = 16.0  # slip of a contact that others hold, in roundings of its size, up to which it is zero


@compiled(fused=True)
def first_event(w: LoopArrays, n_x: int, n_c: int, h: float, far: float) -> float:
    """Return the time to the first guard that becomes negative within `far`, else h; mark it in ``w.guards.hit``.

    A switch that returns to zero within the error of the run is not marked; half of its time is the next step. Nor is
    the stop of a slip in the plane, which has a direction just before it only: the step ends there.
    """
    n_g = w.guards.hit.size
    w.counts.flagged = 0
    reach(w, h, far)
    tau, which = far, -1
    for g in range(n_g):
        w.guards.hit[g] = 0
        r = n_x + g
        total = w.step.reach[r]
        begin = w.c[r, 0]
        begin += w.guards.slack[g]
        if is_load(w, g):
            begin += TOUCH * w.clock.tolerance * max(w.scale[r], total)  # may have been zero so far
        if w.guards.fresh[g] == 0 and begin > total:
            continue
        size, given = w.scale[r], False
        if is_along_line(w, g) and w.guards.carries[contact_of(g)] == 0:
            i = contact_of(g)
            given = w.m[i] > 0.5 and w.contacts.partner[i] < 0 and w.openings.variable.size == 0  # else modes are tried
            if w.m[i] > 0.5:
                size = 8.0 * max(size, w.gauge[TERMS, i] + w.gauge[FORCES, i] * far)
            elif w.guards.fresh[g] and is_slip(g):
                size = max(size, w.gauge[FORCES, i] * far)
        j = g - switch(0, n_c)
        if is_switch(w, g) and abs(w.m[sign(j, n_c)]) == ON_EDGE:  # stays at zero, up to rounding
            moved = far * (size_of(w, n_c, j, 1) + far * size_of(w, n_c, j, 2))
            size = 8.0 * max(size, moved)
        if is_still(begin, total, size):
            continue
        near = min(far, max(tau * (1.0 + 8.0 * EPS), NEAREST * far))  # later crossings are not needed
        if given:  # held by other contacts up to rounding: it slips when that is exceeded
            t = _passing(w, r, 0, near, begin + _WITHIN * EPS * size, total)
        else:
            t = _crossing(w, r, g, begin, total, near)
        if t < tau:
            tau, which = t, g
        elif which >= 0 and t <= tau * (1.0 + 4.0 * EPS):  # reached together, up to the rounding of time
            w.guards.hit[g] = 1
    if which >= 0 and is_switch(w, which) and _returns_by_error(w, n_x + which, tau):
        for g in range(n_g):
            w.guards.hit[g] = 0
        return 0.5 * tau
    before = tau - _SHORT * LAST * natural_time(w) if which >= 0 and _stops_in_plane(w, which) else 0.0
    if before > instant(w):
        for g in range(n_g):
            w.guards.hit[g] = 0
        return before
    if which >= 0:
        w.guards.hit[which] = 1
        for g in range(which):
            if w.guards.hit[g]:  # a previous candidate that is later
                w.guards.hit[g] = 0
        w.counts.flagged = LOADED if is_load(w, which) else HIT
        return tau
    return h


@compiled(inline=True)
def _stops_in_plane(w: LoopArrays, g: int) -> bool:
    """Whether guard g is the speed of a contact in the plane that slips."""
    return is_along_line(w, g) and w.contacts.partner[contact_of(g)] >= 0 and w.m[contact_of(g)] == 0.0


@compiled
def _returns_by_error(w: LoopArrays, r: int, tau: float) -> bool:
    """Whether guard row r rises at first, by less than the error of the run, and is zero again after the time tau.

    So it may be next to a corner that is nearly singular, where the last terms of a series are as small as the run's
    error but larger than all that happens in a step: they would bring the guard back in every step.
    """
    rise = w.c[r, 0] + w.c[r, 1] * tau
    return bool(w.c[r, 1] > 0.0 and rise <= w.clock.tolerance * w.scale[r] and tau > instant(w))


@compiled(fused=True)
def _crossing(w: LoopArrays, r: int, g: int, begin: float, total: float, h: float) -> float:
    """Return the time at which guard row r becomes negative, more than h if it does not."""
    order = w.c.shape[1] - 1
    first = 0
    if w.guards.fresh[g]:
        first, little = w.guards.fresh[g], 0.0
        slips = is_along_line(w, g) and is_slip(g)
        if slips:
            little = no_acceleration(w, contact_of(g), 2.0 * w.c[r, 2])
        if slips and first == 1:  # at a release the slip acceleration is zero up to rounding, for any step length
            first = 2 if abs(w.c[r, 1]) <= little else 1
        elif is_switch(w, g):  # as in mode selection, for any step length
            first = decisive(w, w.c, r, g - switch(0, w.contacts.sticks.size), w.contacts.sticks.size, natural_time(w))
        if total == 0.0:
            return 2.0 * h
        power, decided = h**first, (slips and first == 1) or (is_switch(w, g) and first < PROBED)
        decided = decided or (_is_gap(w, g) and first <= 2)
        while first < order and abs(w.c[r, first]) * power <= LEAST_TERM * total and not decided:
            first += 1
            power *= h
        begin = w.c[r, first]
        total /= power
        if begin < 0.0 and slips and first > 1:  # the mode was selected by an acceleration of zero, up to its rounding
            first, begin, total = 1, max(w.c[r, 1], 0.0) + little, total * power / h
    elif begin <= 2.0 * EPS * w.scale[r] and w.c[r, 1] < 0.0:  # falls, and is zero up to rounding
        return 0.0
    return _passing(w, r, first, h, begin, total)


@compiled(fused=True)
def _passing(w: LoopArrays, r: int, first: int, h: float, begin: float, total: float) -> float:
    """Return when guard row r without its coefficients before `first`, and with this first value, becomes negative."""
    order = w.c.shape[1] - 1
    if begin < 0.0:
        return 0.0
    if first == order:
        return 2.0 * h
    tables, rooms = w.tables, w.roots
    return first_crossing(
        w.c[r, first:],
        order - first,
        h,
        begin,
        total,
        tables.columns,
        tables.bernstein,
        rooms.stack,
        rooms.places,
        rooms.poly,
    )


@compiled(inline=True)
def _is_gap(w: LoopArrays, g: int) -> bool:
    """Whether guard g is the gap of a contact that opens, whose first derivative that is not zero is known."""
    k = g - w.limits.first_opening
    return 0 <= k < 2 * w.openings.variable.size and k % 2 == 0
