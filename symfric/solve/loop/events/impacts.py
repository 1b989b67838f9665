"""Impacts of contacts that open: which strike, and what each of them does; see `symfric.lower.impacts`.

What all contacts that touch do is tried in every combination, and the one with the largest least margin is taken, so
that ties, where one of several is on the border between two, need no threshold.
"""

import numpy as np

from symfric.codegen.numba_types import call_code, compiled
from symfric.lower.impacts import APART, FIELDS, SLIPS, STICKS, TURNS
from symfric.lower.mode_layout import OPEN
from symfric.lower.planes import STARTS
from symfric.solve.loop.codes import IMPACT, MANY_CONTACTS, OK, PAINLEVE, SLIP, TERMS
from symfric.solve.loop.events.direction_sizes import SAMPLES
from symfric.solve.loop.events.directions import (
    AGREE,
    MOST_SWEEPS,
    POLISHES,
    START_ANGLE,
    chord_step,
    find_angles,
    sample_angle,
)
from symfric.solve.loop.modes.layout import mode
from symfric.solve.loop.modes.tolerances import instant
from symfric.solve.loop.precision import ROUNDING, TINY
from symfric.solve.loop.recording.trajectory import store_event
from symfric.solve.loop.stepping.calls import measure
from symfric.solve.loop.workspace import LoopArrays

MOST_TRIALS = 20_000  # most combinations that are tried
_FEASIBLE = 1e-9  # margin, relative to the largest rate of a gap, down to which a combination is possible
_JAM = 1e2  # normal force, relative to that of forces that do not cancel, that grows without bound
_DISTINCT = 1e-6  # the same beyond which a second possible combination is another answer
_OVERLAP, _DRIFTS, _MOST = 1e-9, 1e3, 1e-2  # negative gap that is an overlap, relative; the same per tolerance; at most
_HALVINGS = 60  # of the part of restitutions with which an impact gains no energy
_TOGETHER = 64.0  # rounding errors of time between impacts that come at the same time
# of the answer, n numbers each
GAP, SIZE, RATE, SPEED, LEAST, RESPONSE, AFTER, FIRST, SECOND, SWERVE, TOLD = range(11)


@compiled(inline=True)
def told(w: LoopArrays, what: int, k: int) -> float:
    """Return what the last call of the impact says of contact k."""
    return w.impacts.answer[_states(w) + what * w.openings.variable.size + k]


@compiled(inline=True)
def _states(w: LoopArrays) -> int:
    """Return the number of states of the motion, without appended derivatives."""
    n = w.openings.variable.size
    return w.impacts.answer.size - TOLD * n - 2 - (w.contacts.sticks.size + n) ** 2


@compiled(inline=True)
def _after_fields(w: LoopArrays) -> int:
    """Return where the energy gained stands in the answer, its scale and the coupling of all contacts behind it."""
    return _states(w) + TOLD * w.openings.variable.size


@compiled(inline=True)
def coupling(w: LoopArrays, i: int, j: int) -> float:
    """Return what a force of contact j does to contact i: contacts along a line, then the gaps of those that open."""
    return w.impacts.answer[_after_fields(w) + 2 + (w.contacts.sticks.size + w.openings.variable.size) * j + i]


@compiled(inline=True)
def is_open(w: LoopArrays, k: int) -> bool:
    """Whether contact k is open."""
    return w.m[w.openings.variable[k]] > 0.5


@compiled(inline=True)
def is_planar(w: LoopArrays, k: int) -> bool:
    """Whether contact k slides in the plane."""
    return w.openings.line[k] >= 0 and w.contacts.partner[w.openings.line[k]] >= 0


@compiled(inline=True)
def _ask(w: LoopArrays) -> None:
    """Compute the impact with the present data."""
    call_code(w.code[IMPACT], w.y.ctypes.data, w.impacts.asked.ctypes.data, w.impacts.answer.ctypes.data)


@compiled(inline=True)
def _field(w: LoopArrays, field: int, k: int) -> int:
    """Return the place of a number of contact k in the data of an impact: kind, direction, bounce, closed."""
    return w.p.size + field * w.openings.variable.size + k


@compiled(inline=True)
def forget_closed(w: LoopArrays, first: int) -> None:
    """Let no gap be zero in a copy of the data: at the start derivatives may move the rate of a closed one."""
    for k in range(w.openings.variable.size):
        w.saltation.before[first + _field(w, 3, k) - w.p.size] = 0.0


@compiled(inline=True)
def _rules(w: LoopArrays) -> int:
    """Return the place of the two flags of the rule behind the numbers of every contact."""
    return w.p.size + FIELDS * w.openings.variable.size


@compiled
def begin_impact(w: LoopArrays, starting: bool) -> bool:
    """Determine which contacts touch, and whether one of them strikes."""
    n, n_p, strikes, now = w.openings.variable.size, w.p.size, False, _TOGETHER * instant(w)
    for r in range(n_p):
        w.impacts.asked[r] = w.p[r]
    for r in range(n_p, w.impacts.asked.size):
        w.impacts.asked[r] = 0.0
    _ask(w)
    for k in range(n):
        gap, rate = told(w, GAP, k), told(w, RATE, k)
        closed = not starting and not is_open(w, k)
        near = gap <= ROUNDING * told(w, SIZE, k) - min(rate, 0.0) * now
        w.impacts.touches[k] = closed or near or (not starting and w.guards.hit[w.limits.first_opening + 2 * k] != 0)
        w.impacts.struck[k] = 0
        w.impacts.asked[_field(w, 2, k)] = 1.0
        if w.impacts.touches[k]:
            still = abs(rate) <= ROUNDING * told(w, SPEED, k) or (closed and not w.counts.jumped)
            w.impacts.asked[_field(w, 3, k)] = still
            strikes = strikes or (not still and rate < 0.0)
        else:
            w.m[w.openings.variable[k]] = 1.0
    return strikes


@compiled
def overlaps(w: LoopArrays, n_x: int) -> bool:
    """Whether a gap is negative by more than the errors of a run, as only a reset can make it.

    A gap that was open is as exact as its event; one that was closed may have drifted by the tolerance.
    """
    measure(w, w.y, w.gauge)
    for r in range(w.impacts.asked.size):
        w.impacts.asked[r] = w.p[r] if r < w.p.size else 0.0
    _ask(w)
    for k in range(w.openings.variable.size):
        size = max(told(w, SIZE, k), w.scale[n_x + w.limits.first_opening + 2 * k])
        drift = 0.0 if is_open(w, k) else _DRIFTS * w.clock.tolerance
        if told(w, GAP, k) < -min(_OVERLAP + drift, _MOST) * size:
            return True
    return False


@compiled
def widen_slips(w: LoopArrays, n_c: int) -> None:
    """Raise the sizes of slips, in ``w.span``, to what the impulses of a run of such velocities may add to them.

    A slip that no force drives holds nothing but the rounding of impulses, which is relative to those, not to itself.
    ``w.step.end`` holds the sizes of the velocities.
    """
    call_code(w.code[IMPACT], w.step.end.ctypes.data, w.impacts.asked.ctypes.data, w.impacts.exact.ctypes.data)
    n = w.openings.variable.size
    for i in range(n_c):
        size = 0.0
        for k in range(n):
            own, along = coupling(w, n_c + k, n_c + k), w.openings.line[k]
            shared = abs(coupling(w, i, n_c + k))
            if along >= 0:
                shared = max(shared, abs(coupling(w, i, along)))
            if is_planar(w, k):
                shared = max(shared, abs(coupling(w, i, along + 1)))
            if own > 0.0:
                size += shared / own * w.impacts.exact[_states(w) + SPEED * n + k]
        w.span[TERMS, i] = max(w.span[TERMS, i], size)


@compiled
def strike(w: LoopArrays, n_c: int, starting: bool) -> int:
    """Apply the impact of the contacts that strike, if any, and make gaps and rates of closed ones exactly zero.

    ``w.impacts.rests`` marks those that stay in touch.
    """
    n = w.openings.variable.size
    measure(w, w.y, w.gauge)
    strikes = begin_impact(w, starting)
    status = _choose(w) if strikes else OK
    if status != OK:
        return status
    for k in range(n):
        w.impacts.struck[k] = w.impacts.asked[_field(w, 0, k)] != APART
    _apply(w)
    w.counts.jumped = w.counts.jumped or strikes
    return OK


@compiled
def settle_bounces(w: LoopArrays) -> None:
    """Apply the impact again, from the state before it, without restitution."""
    for k in range(w.openings.variable.size):
        w.impacts.asked[_field(w, 2, k)] = 0.0
    _ask(w)
    _apply(w)
    w.counts.jumped = 1


@compiled
def hold_exactly(w: LoopArrays) -> None:
    """Make gaps and rates of closed contacts, and slips of sticking ones, exactly zero.

    The data of the impact stay those of what struck.
    """
    for r in range(w.impacts.asked.size):
        w.impacts.best[r] = w.impacts.asked[r]
    for k in range(w.openings.variable.size):
        w.impacts.asked[_field(w, 0, k)], w.impacts.asked[_field(w, 3, k)] = APART, not is_open(w, k)
    for i in range(w.contacts.sticks.size):
        w.impacts.asked[_rules(w) + 2 + i] = w.m[i] > 0.5 or w.m[i] == STARTS
    call_code(w.code[IMPACT], w.y.ctypes.data, w.impacts.asked.ctypes.data, w.impacts.exact.ctypes.data)
    for r in range(_states(w)):
        w.y[r] = w.impacts.exact[r]
    for r in range(w.impacts.asked.size):
        w.impacts.asked[r] = w.impacts.best[r]


@compiled
def settle_touches(w: LoopArrays) -> None:
    """Close all contacts that touch."""
    for k in range(w.openings.variable.size):
        w.impacts.rests[k] = w.impacts.touches[k]
        if w.impacts.touches[k]:
            w.m[w.openings.variable[k]] = 0.0
    hold_exactly(w)


@compiled(inline=True)
def _apply(w: LoopArrays) -> None:
    """Take over the state after the impact that was computed last, and mark the contacts that stay in touch."""
    fastest = _largest_rate(w)
    for k in range(w.openings.variable.size):
        rests = w.impacts.touches[k] != 0
        if fastest > 0.0:
            bounces = w.impacts.struck[k] and w.impacts.asked[_field(w, 2, k)] > 0.0 and told(w, RATE, k) < 0.0
            bounces = bounces and w.impacts.asked[_field(w, 3, k)] < 0.5  # else its rate is zero up to rounding
            little = max(ROUNDING * told(w, SPEED, k), 0.0 if bounces else _FEASIBLE * fastest)
            rests = rests and abs(told(w, AFTER, k)) <= little
        else:
            rests = rests and w.impacts.asked[_field(w, 3, k)] > 0.5
        w.impacts.rests[k] = rests
        if not rests:
            w.m[w.openings.variable[k]] = 1.0
    for r in range(_states(w)):
        w.y[r] = w.impacts.answer[r]


@compiled
def _largest_rate(w: LoopArrays) -> float:
    """Return the largest rate at which a gap closes in the impact."""
    largest = 0.0
    for k in range(w.openings.variable.size):
        if w.impacts.touches[k] and w.impacts.asked[_field(w, 3, k)] < 0.5:
            largest = max(largest, -told(w, RATE, k))
    return largest


@compiled
def _choose(w: LoopArrays) -> int:
    """Determine what every contact that touches does; leave the data and the answer of that in place."""
    alone, planar = 0, False
    for k in range(w.openings.variable.size):
        alone += w.impacts.touches[k]
        planar = planar or (w.impacts.touches[k] != 0 and is_planar(w, k))
    w.impacts.asked[_rules(w) + 1] = alone == 1
    status = _try_all(w, alone == 1)
    if planar:
        return _bounce_less(w, alone == 1) if status == OK and _gains(w, ROUNDING) else status
    if status == OK and _gains(w, _FEASIBLE):
        w.impacts.asked[_rules(w)] = 1.0
        status = _try_all(w, alone == 1)
    return status


@compiled
def _gains(w: LoopArrays, least: float) -> bool:
    """Whether the impact adds energy, by more than a part of its terms."""
    return w.impacts.answer[_after_fields(w)] > least * w.impacts.answer[_after_fields(w) + 1]


@compiled
def _bounce_less(w: LoopArrays, alone: bool) -> int:
    """Find the largest part of all restitutions with which the impact adds no energy; it has no derivative here."""
    low, high, status = 0.0, 1.0, OK
    for _ in range(_HALVINGS):
        part = 0.5 * (low + high)
        _set_bounces(w, part)
        status = _try_all(w, alone)
        if status != OK:
            return status
        if _gains(w, 0.0):
            high = part
        else:
            low = part
    w.counts.doubts += w.limits.varied > 0
    _set_bounces(w, low)
    return _try_all(w, alone)


@compiled(inline=True)
def _set_bounces(w: LoopArrays, part: float) -> None:
    """Set the part of the restitution of all contacts."""
    for k in range(w.openings.variable.size):
        w.impacts.asked[_field(w, 2, k)] = part


@compiled
def _try_all(w: LoopArrays, alone: bool) -> int:
    """Try all combinations; leave the best in place."""
    n, total, best, second = w.openings.variable.size, 1, -np.inf, -np.inf
    for k in range(n):
        w.impacts.tried[k] = 0
        w.impacts.options[k] = _options(w, k, alone)
        total *= w.impacts.options[k]
    if total > MOST_TRIALS:
        return MANY_CONTACTS
    for _ in range(total):
        for k in range(n):
            _set(w, k, alone)
        for way in range(_aim(w)):
            _take_way(w, way)
            _ask(w)
            margin = _least_margin(w)
            if margin > best:
                if best > -np.inf and not _is_best(w):
                    second = best
                best = margin
                for r in range(w.impacts.asked.size):
                    w.impacts.best[r] = w.impacts.asked[r]
                for r in range(w.limits.n_q):
                    w.impacts.rates[r] = w.impacts.answer[w.limits.n_q + r]
            elif margin > second and not _is_best(w):
                second = margin
        next_trial(w, n)
    for r in range(w.impacts.asked.size):
        w.impacts.asked[r] = w.impacts.best[r]
    _ask(w)
    scale = max(_largest_rate(w), TINY)
    return OK if best >= -_FEASIBLE * scale and not second > _DISTINCT * scale else PAINLEVE


@compiled
def _aim(w: LoopArrays) -> int:
    """Find the directions of slips in the plane after the impact that friction opposes; return the number of choices.

    Those of one contact are in ``w.planes.angles``. Those of several are found one after the other, until they agree:
    one choice at most, which is the only one as long as the contacts affect each other weakly.
    """
    slipping, last = 0, -1
    for k in range(w.openings.variable.size):
        if is_planar(w, k) and w.impacts.asked[_field(w, 0, k)] == SLIPS:
            slipping, last = slipping + 1, k
            _point(w, k, START_ANGLE)
    w.planes.aimed[0] = last
    if slipping == 0:
        w.planes.aimed[0] = -1
        return 1
    if slipping == 1:
        return _ways(w, last)
    w.planes.aimed[0] = -1
    for _ in range(MOST_SWEEPS):
        turned = 0.0
        for k in range(w.openings.variable.size):
            if is_planar(w, k) and w.impacts.asked[_field(w, 0, k)] == SLIPS:
                turned = max(turned, _turn_to_best(w, k))
        if not turned > AGREE:
            return 1 if turned >= 0.0 else 0
    return 0


@compiled
def _ways(w: LoopArrays, k: int) -> int:
    """Find the directions of contact k, with those of the others as they are; return how many there are."""
    for s in range(SAMPLES):
        _point(w, k, sample_angle(s))
        _ask(w)
        w.planes.samples[s] = told(w, SWERVE, k)
    n = find_angles(w)
    for s in range(n):
        for _ in range(POLISHES):
            angle = w.planes.angles[s]
            _point(w, k, angle)
            _ask(w)
            step = chord_step(w, angle, told(w, SWERVE, k))
            w.planes.angles[s] = angle - step
    return n


@compiled
def _turn_to_best(w: LoopArrays, k: int) -> float:
    """Turn contact k to the direction of the largest margin; return by how much, NaN if there is none."""
    e, f, best, found = w.impacts.asked[_field(w, 4, k)], w.impacts.asked[_field(w, 5, k)], -np.inf, np.nan
    for s in range(_ways(w, k)):
        _point(w, k, w.planes.angles[s])
        _ask(w)
        if told(w, SECOND, k) > best:
            best, found = told(w, SECOND, k), w.planes.angles[s]
    _point(w, k, found)
    return abs(w.impacts.asked[_field(w, 4, k)] - e) + abs(w.impacts.asked[_field(w, 5, k)] - f)


@compiled(inline=True)
def _take_way(w: LoopArrays, way: int) -> None:
    """Take one of the directions that were found."""
    if w.planes.aimed.size and w.planes.aimed[0] >= 0:
        _point(w, w.planes.aimed[0], w.planes.angles[way])


@compiled(inline=True)
def _point(w: LoopArrays, k: int, angle: float) -> None:
    """Set the direction of contact k in the plane."""
    w.impacts.asked[_field(w, 4, k)], w.impacts.asked[_field(w, 5, k)] = np.cos(angle), np.sin(angle)


@compiled
def next_trial(w: LoopArrays, n: int) -> None:
    """Count on to the next combination of options, of the first n contacts."""
    for k in range(n):
        w.impacts.tried[k] += 1
        if w.impacts.tried[k] < w.impacts.options[k]:
            break
        w.impacts.tried[k] = 0


@compiled(inline=True)
def _options(w: LoopArrays, k: int, alone: bool) -> int:
    """Return the number of things that contact k may do."""
    if w.impacts.touches[k] == 0:
        return 1
    return (2 if w.openings.line[k] < 0 else (3 if is_planar(w, k) else 4)) - alone


@compiled(inline=True)
def _set(w: LoopArrays, k: int, alone: bool) -> None:
    """Set what contact k does in the present trial."""
    kind, side, option = APART, 1.0, w.impacts.tried[k]
    if w.impacts.touches[k]:
        option += alone  # the only one is not apart
        kind = APART if option == 0 else (STICKS if option == 1 else SLIPS)
        side = 1.0 if option < 3 else -1.0
        i = w.openings.line[k]
        if is_planar(w, k):
            speed = np.hypot(w.gauge[SLIP, i], w.gauge[SLIP, i + 1])
            slips = speed > ROUNDING * max(w.gauge[TERMS, i], w.gauge[TERMS, i + 1])
            w.impacts.asked[_field(w, 4, k)] = w.gauge[SLIP, i] / speed if slips else 0.0
            w.impacts.asked[_field(w, 5, k)] = w.gauge[SLIP, i + 1] / speed if slips else 0.0
        elif alone and i >= 0 and abs(w.gauge[SLIP, i]) > ROUNDING * w.gauge[TERMS, i]:
            kind = STICKS if option == 1 else (SLIPS if option == 2 else TURNS)
            side = 1.0 if w.gauge[SLIP, i] > 0.0 else -1.0
    w.impacts.asked[_field(w, 0, k)], w.impacts.asked[_field(w, 1, k)] = kind, side


@compiled
def _least_margin(w: LoopArrays) -> float:
    """Return the least margin of the contacts that touch; less than all others if the impact has no solution."""
    least = np.inf
    for k in range(w.openings.variable.size):
        if w.impacts.touches[k]:
            for what in (FIRST, SECOND):
                margin = told(w, what, k)
                if not abs(margin) < np.inf:
                    return -np.inf
                least = min(least, margin)
    return least


@compiled
def _is_best(w: LoopArrays) -> bool:
    """Whether the velocities after the impact are those of the best combination so far."""
    n_q = w.limits.n_q
    for r in range(n_q):
        new, best, old = w.impacts.answer[n_q + r], w.impacts.rates[r], w.y[n_q + r]
        if abs(new - best) > _DISTINCT * (abs(new - old) + abs(best - old)) + _FEASIBLE * (abs(new) + abs(best)):
            return False
    return True


@compiled
def jams(w: LoopArrays, n_x: int) -> bool:
    """Whether a normal force has grown far beyond what all other forces together press with."""
    for k in range(w.openings.variable.size):
        if not is_open(w, k) and w.c[n_x + w.limits.first_opening + 2 * k + 1, 0] > _JAM * told(w, LEAST, k):
            return True
    return False


@compiled
def log_openings(w: LoopArrays, starting: bool) -> int:
    """Store the events of contacts that open, of bounces that died out at their end; return the number."""
    changed = 0
    for k in range(w.openings.variable.size):
        old, i = w.impacts.before[k], w.openings.line[k]
        new = OPEN if is_open(w, k) else (mode(w, i) if i >= 0 else 0)
        w.impacts.before[k] = new
        if starting or (new == old and not (old == OPEN and w.impacts.struck[k])):
            continue
        changed += 1
        if w.limits.keep_events:
            store_event(w, w.openings.number[k], old, new)
            rests, last = old == OPEN and new != OPEN, w.counts.kept_events - 1
            if rests and w.clock.late > 0.0:
                w.stored.event_t[last] = min(w.stored.event_t[last] + w.clock.late, w.clock.t_end)
    return changed
