"""Impacts of contacts that open: which strike, and what follows from what each of them does.

See `symfric.lower.impacts`, and `symfric.solve.loop.events.impact_choice` for the choice.
"""

import numpy as np

from symfric.codegen.array_table import Reals
from symfric.codegen.numba_types import call_code, compiled
from symfric.lower.impacts import APART, FIELDS
from symfric.lower.mode_layout import OPEN
from symfric.lower.planes import STARTS
from symfric.solve.loop.codes import IMPACT, SLIP, TERMS
from symfric.solve.loop.modes.layout import mode
from symfric.solve.loop.modes.tolerances import EARLIER, instant, sizes_of_velocities
from symfric.solve.loop.precision import ROUNDING, TOUCH
from symfric.solve.loop.recording.trajectory import store_event
from symfric.solve.loop.stepping.calls import measure
from symfric.solve.loop.workspace import LoopArrays

MOST_TRIALS = 20_000  # most combinations that are tried
FEASIBLE = 1e-9  # margin, relative to the largest rate of a gap, down to which a combination is possible
_JAM = 1e2  # normal force, relative to that of forces that do not cancel, that grows without bound
_OVERLAP = 1e-9  # negative gap, relative to its terms, that is an overlap
_TOGETHER = 64.0  # rounding errors of time between impacts that come at the same time
# rows of the answer, a number of every contact each
GAP, SIZE, RATE, SPEED, LEAST, RESPONSE, AFTER, FIRST, SECOND, SWERVE, KINETIC, STATIC, TOLD = range(13)


@compiled(inline=True)
def told(w: LoopArrays, what: int, k: int) -> float:
    """Return what the last call of the impact says of contact k."""
    return w.impacts.answer[_states(w) + what * w.openings.variable.size + k]


@compiled(inline=True)
def told_exactly(w: LoopArrays, what: int, k: int) -> float:
    """Return what the last call of the other impact, in ``w.impacts.exact``, says of contact k."""
    return w.impacts.exact[_states(w) + what * w.openings.variable.size + k]


@compiled(inline=True)
def ask_exactly(w: LoopArrays, y: Reals) -> None:
    """Compute the other impact, of a state y, with the present data."""
    call_code(w.code[IMPACT], y.ctypes.data, w.impacts.asked.ctypes.data, w.impacts.exact.ctypes.data)


@compiled(inline=True)
def _states(w: LoopArrays) -> int:
    """Return the number of states of the motion, without appended derivatives."""
    return (w.y.size - 1) // (1 + w.limits.varied)


@compiled(inline=True)
def after_fields(w: LoopArrays) -> int:
    """Return where the energy gained stands in the answer, its scale and the coupling of all contacts behind it."""
    return _states(w) + TOLD * w.openings.variable.size


@compiled(inline=True)
def coupling(w: LoopArrays, i: int, j: int) -> float:
    """Return what a force of contact j does to contact i: contacts along a line, then the gaps of those that open."""
    return w.impacts.answer[after_fields(w) + 2 + (w.contacts.sticks.size + w.openings.variable.size) * j + i]


@compiled(inline=True)
def is_open(w: LoopArrays, k: int) -> bool:
    """Whether contact k is open."""
    return w.m[w.openings.variable[k]] > 0.5


@compiled(inline=True)
def is_planar(w: LoopArrays, k: int) -> bool:
    """Whether contact k slides in the plane."""
    return w.openings.line[k] >= 0 and w.contacts.partner[w.openings.line[k]] >= 0


@compiled(inline=True)
def ask(w: LoopArrays) -> None:
    """Compute the impact with the present data."""
    call_code(w.code[IMPACT], w.y.ctypes.data, w.impacts.asked.ctypes.data, w.impacts.answer.ctypes.data)


@compiled
def ask_of_none(w: LoopArrays) -> None:
    """Lay out the data of an impact in which no contact takes part, and compute it: gaps, their rates, the coupling."""
    for r in range(w.impacts.asked.size):
        w.impacts.asked[r] = w.p[r] if r < w.p.size else 0.0
    ask(w)


@compiled(inline=True)
def field_of(w: LoopArrays, field: int, k: int) -> int:
    """Return the place of a number of contact k in the data of an impact: kind, direction, bounce, closed."""
    return w.p.size + field * w.openings.variable.size + k


@compiled(inline=True)
def forget_closed(w: LoopArrays, first: int) -> None:
    """Let no gap be zero in a copy of the data: at the start derivatives may move the rate of a closed one."""
    for k in range(w.openings.variable.size):
        w.saltation.before[first + field_of(w, 3, k) - w.p.size] = 0.0


@compiled(inline=True)
def set_way_before(w: LoopArrays, k: int) -> bool:
    """Set the direction of the slip of contact k before the impact, zero without slip; return whether it slips."""
    i = w.openings.line[k]
    along, across = w.gauge[SLIP, i], 0.0
    terms = w.gauge[TERMS, i]
    if is_planar(w, k):
        across, terms = w.gauge[SLIP, i + 1], max(terms, w.gauge[TERMS, i + 1])
    speed = np.hypot(along, across)
    slips = speed > ROUNDING * terms
    w.impacts.asked[field_of(w, 4, k)] = along / speed if slips else 0.0
    w.impacts.asked[field_of(w, 5, k)] = across / speed if slips else 0.0
    return slips


@compiled(inline=True)
def rules(w: LoopArrays) -> int:
    """Return the place of the two flags of the rule behind the numbers of every contact."""
    return w.p.size + FIELDS * w.openings.variable.size


@compiled
def begin_impact(w: LoopArrays, starting: bool) -> bool:
    """Determine which contacts touch, and whether one of them strikes.

    Where something may have jumped, a closed contact is left if the rate of its gap did; the error of the run is not
    such a jump. A floor that turns round has no speed, so the error is relative to the speeds so far.
    """
    strikes, now, n_x = False, _TOGETHER * instant(w), w.y.size - 1
    ask_of_none(w)
    if w.counts.jumped:
        sizes_of_velocities(w, n_x)
        ask_exactly(w, w.step.end)
    for k in range(w.openings.variable.size):
        gap, rate = told(w, GAP, k), told(w, RATE, k)
        closed = not starting and not is_open(w, k)
        near = gap <= ROUNDING * told(w, SIZE, k) - min(rate, 0.0) * now
        w.impacts.touches[k] = closed or near or (not starting and w.guards.hit[w.limits.first_opening + 2 * k] != 0)
        w.impacts.struck[k] = 0
        w.impacts.asked[field_of(w, 2, k)] = 1.0
        if w.impacts.touches[k]:
            still = abs(rate) <= ROUNDING * told(w, SPEED, k)
            if closed and not still:
                still = w.counts.jumped == 0 or abs(rate) <= TOUCH * w.clock.tolerance * _speed_so_far(w, k)
            w.impacts.asked[field_of(w, 3, k)] = still
            strikes = strikes or (not still and rate < 0.0)
        else:
            w.m[w.openings.variable[k]] = 1.0
    return strikes


@compiled(inline=True)
def _speed_so_far(w: LoopArrays, k: int) -> float:
    """Return the size of the terms of the rate of gap k, now or with the largest velocities so far."""
    return max(told(w, SPEED, k), EARLIER * told_exactly(w, SPEED, k))


@compiled
def leave(w: LoopArrays) -> None:
    """Keep the state before resets."""
    for r in range(w.y.size - 1):
        w.impacts.entry_y[r] = w.y[r]


@compiled
def overlaps(w: LoopArrays, n_x: int) -> bool:
    """Whether a gap is negative after a reset, by more than it was before and by more than the digits of a number.

    A gap that was closed may have drifted by the error of the run: so far it may be negative again.
    """
    measure(w, w.y, w.gauge)
    ask_of_none(w)
    ask_exactly(w, w.impacts.entry_y)
    for k in range(w.openings.variable.size):
        size = max(told(w, SIZE, k), w.scale[n_x + w.limits.first_opening + 2 * k])
        drift = max(-told_exactly(w, GAP, k), 0.0) if is_open(w, k) else abs(told_exactly(w, GAP, k))
        if told(w, GAP, k) < -drift - _OVERLAP * size:
            return True
    return False


@compiled
def widen_slips(w: LoopArrays, n_c: int) -> None:
    """Raise the sizes of slips, in ``w.span``, to what the impulses of a run of such velocities may add to them.

    A slip that no force drives holds nothing but the rounding of impulses, which is relative to those, not to itself.
    ``w.step.end`` holds the sizes of the velocities.
    """
    ask_exactly(w, w.step.end)
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
                size += shared / own * told_exactly(w, SPEED, k)
        w.span[TERMS, i] = max(w.span[TERMS, i], size)


@compiled
def end_bounces(w: LoopArrays) -> None:
    """Apply the impact again, from the state before it, without restitution."""
    for k in range(w.openings.variable.size):
        w.impacts.asked[field_of(w, 2, k)] = 0.0
    ask(w)
    apply(w)
    w.counts.jumped = 1


@compiled
def hold_exactly(w: LoopArrays) -> None:
    """Make gaps and rates of closed contacts, and slips of sticking ones, exactly zero.

    The data of the impact stay those of what struck.
    """
    for r in range(w.impacts.asked.size):
        w.impacts.best[r] = w.impacts.asked[r]
    for k in range(w.openings.variable.size):
        w.impacts.asked[field_of(w, 0, k)], w.impacts.asked[field_of(w, 3, k)] = APART, not is_open(w, k)
    for i in range(w.contacts.sticks.size):
        w.impacts.asked[rules(w) + 2 + i] = w.m[i] > 0.5 or w.m[i] == STARTS
    ask_exactly(w, w.y)
    for r in range(_states(w)):
        w.y[r] = w.impacts.exact[r]
    for r in range(w.impacts.asked.size):
        w.impacts.asked[r] = w.impacts.best[r]


@compiled
def close_touching(w: LoopArrays) -> None:
    """Close all contacts that touch."""
    for k in range(w.openings.variable.size):
        w.impacts.rests[k] = w.impacts.touches[k]
        if w.impacts.touches[k]:
            w.m[w.openings.variable[k]] = 0.0
    hold_exactly(w)


@compiled(inline=True)
def apply(w: LoopArrays) -> None:
    """Take over the state after the impact that was computed last, and mark the contacts that stay in touch."""
    fastest = largest_rate(w)
    for k in range(w.openings.variable.size):
        rests = w.impacts.touches[k] != 0
        if fastest > 0.0:
            bounces = w.impacts.struck[k] and w.impacts.asked[field_of(w, 2, k)] > 0.0 and told(w, RATE, k) < 0.0
            bounces = bounces and w.impacts.asked[field_of(w, 3, k)] < 0.5  # else its rate is zero up to rounding
            little = max(ROUNDING * told(w, SPEED, k), 0.0 if bounces else FEASIBLE * fastest)
            rests = rests and abs(told(w, AFTER, k)) <= little
        else:
            rests = rests and w.impacts.asked[field_of(w, 3, k)] > 0.5
        w.impacts.rests[k] = rests
        if not rests:
            w.m[w.openings.variable[k]] = 1.0
    for r in range(_states(w)):
        w.y[r] = w.impacts.answer[r]


@compiled
def largest_rate(w: LoopArrays) -> float:
    """Return the largest rate at which a gap closes in the impact."""
    largest = 0.0
    for k in range(w.openings.variable.size):
        if w.impacts.touches[k] and w.impacts.asked[field_of(w, 3, k)] < 0.5:
            largest = max(largest, -told(w, RATE, k))
    return largest


@compiled
def next_trial(w: LoopArrays, n: int) -> None:
    """Count on to the next combination of options, of the first n contacts."""
    for k in range(n):
        w.impacts.tried[k] += 1
        if w.impacts.tried[k] < w.impacts.options[k]:
            break
        w.impacts.tried[k] = 0


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
