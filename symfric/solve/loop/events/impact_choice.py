"""What every contact does in an impact, see `symfric.lower.impacts`.

What all contacts that touch do is tried in every combination where these are few, and otherwise found by the method of
pivots. Where the impact would gain energy, contacts bounce less.
"""

from symfric.codegen.numba_types import compiled
from symfric.lower.impacts import APART
from symfric.solve.loop.codes import MANY_CONTACTS, OK
from symfric.solve.loop.events.impact_pivots import choose_by_pivots
from symfric.solve.loop.events.impact_trials import try_all
from symfric.solve.loop.events.impact_verdicts import HALVINGS, gains
from symfric.solve.loop.events.impacts import FEASIBLE, apply, begin_impact, field_of, is_planar, rules
from symfric.solve.loop.precision import ROUNDING
from symfric.solve.loop.stepping.calls import measure
from symfric.solve.loop.workspace import LoopArrays


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
        w.impacts.struck[k] = w.impacts.asked[field_of(w, 0, k)] != APART
    apply(w)
    w.counts.jumped = w.counts.jumped or strikes
    return OK


@compiled
def _choose(w: LoopArrays) -> int:
    """Determine what every contact that touches does; leave the data and the answer of that in place."""
    alone, planar = 0, False
    for k in range(w.openings.variable.size):
        alone += w.impacts.touches[k]
        planar = planar or (w.impacts.touches[k] != 0 and is_planar(w, k))
    w.impacts.asked[rules(w) + 1] = alone == 1
    status = try_all(w, alone == 1)
    if status == MANY_CONTACTS and not planar:
        return choose_by_pivots(w)
    if planar:
        return _bounce_less(w, alone == 1) if status == OK and gains(w, ROUNDING) else status
    if status == OK and gains(w, FEASIBLE):
        w.impacts.asked[rules(w)] = 1.0
        status = try_all(w, alone == 1)
    return status


@compiled
def _bounce_less(w: LoopArrays, alone: bool) -> int:
    """Find the largest part of all restitutions with which the impact adds no energy; it has no derivative here."""
    low, high, status = 0.0, 1.0, OK
    for _ in range(HALVINGS):
        part = 0.5 * (low + high)
        _set_bounces(w, part)
        status = try_all(w, alone)
        if status != OK:
            return status
        if gains(w, 0.0):
            high = part
        else:
            low = part
    w.counts.doubts += w.limits.varied > 0
    _set_bounces(w, low)
    return try_all(w, alone)


@compiled(inline=True)
def _set_bounces(w: LoopArrays, part: float) -> None:
    """Set the part of the restitution of all contacts."""
    for k in range(w.openings.variable.size):
        w.impacts.asked[field_of(w, 2, k)] = part
