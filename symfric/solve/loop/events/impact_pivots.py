"""What many contacts do in an impact, found by the method of pivots.

Where there are too many combinations, `symfric.solve.loop.modes.complementarity` finds one, which is then looked at
like one of few: its margins, and how it could be mended where they are negative. Where friction may permit others, a
second one is looked for from another start, which finds another answer often but not always. Where friction drops from
rest to slip, what static friction can hold stays: in the end no further contact could stick.
"""

from symfric.codegen.numba_types import compiled
from symfric.lower.impacts import APART, SLIPS, STICKS
from symfric.solve.loop.codes import MANY_CONTACTS, OK, PAINLEVE, SLIP
from symfric.solve.loop.events.impact_verdicts import (
    DISTINCT,
    HALVINGS,
    gains,
    is_best,
    keep,
    least_margin,
    may_stay,
    restore,
    staying,
)
from symfric.solve.loop.events.impacts import (
    AFTER,
    FEASIBLE,
    FIRST,
    KINETIC,
    SECOND,
    STATIC,
    ask,
    coupling,
    field_of,
    largest_rate,
    rules,
    set_way_before,
    told,
)
from symfric.solve.loop.modes.complementarity import solve_contacts
from symfric.solve.loop.precision import TINY
from symfric.solve.loop.workspace import LoopArrays

_MENDED = 4  # most attempts to mend a combination, in numbers of contacts


@compiled
def choose_by_pivots(w: LoopArrays) -> int:
    """Determine what every contact that touches does, of many; leave the data and the answer of that in place."""
    rubs = _lay_out(w)
    if not (_solve(w, 1.0, 0.0) and _mend(w)) and not (_solve(w, 1.0, 1.0) and _mend(w)):
        return MANY_CONTACTS
    if rubs:
        held = _hold_more(w)
        if _solve(w, 1.0, 1.0) and _mend(w) and not is_best(w):
            distinct = least_margin(w) > DISTINCT * max(largest_rate(w), TINY)
            if distinct and staying(w) == held:
                return PAINLEVE
            if distinct and staying(w) > held:
                _hold_more(w)
        restore(w)
    return _without_gain(w) if gains(w, FEASIBLE) else OK


@compiled
def _hold_more(w: LoopArrays) -> int:
    """Let contacts that rest stick as long as others can be found that then obey; keep that, return how many stay."""
    held, n, k = staying(w), w.openings.variable.size, 0
    keep(w)
    while k < n:
        more = may_stay(w, k) and w.impacts.asked[field_of(w, 0, k)] != STICKS
        if more:
            w.impacts.asked[field_of(w, 0, k)], w.impacts.asked[field_of(w, 1, k)] = STICKS, 1.0
            more = _mend(w) and staying(w) > held and least_margin(w) > DISTINCT * max(largest_rate(w), TINY)
            if more:
                held = staying(w)
                keep(w)
            else:
                restore(w)
        k = 0 if more else k + 1
    return held


@compiled
def _without_gain(w: LoopArrays) -> int:
    """Determine it with the largest share of restitution that gains no energy."""
    low, high, share = 0.0, 1.0, 1.0
    w.impacts.asked[rules(w)] = 1.0
    for _ in range(HALVINGS):
        if not _solve(w, share, 0.0):
            return MANY_CONTACTS
        gains = _work(w) > 0.0
        ask(w)
        if least_margin(w) >= -FEASIBLE * max(largest_rate(w), TINY):
            return OK
        low, high = (low, share) if gains else (share, high)
        share = 0.5 * (low + high)
    return OK if _mend(w) else MANY_CONTACTS


@compiled
def _lay_out(w: LoopArrays) -> bool:
    """Lay out the contacts that touch for the method of pivots; return whether one of them has friction."""
    n, n_c, rubs = w.openings.variable.size, w.contacts.sticks.size, False
    w.impacts.asked[rules(w)] = 0.0
    for k in range(n):
        w.impacts.asked[field_of(w, 0, k)] = APART
    ask(w)
    for i in range(n_c):
        w.pivots.takes[i] = 0
    for k in range(n):
        i = w.openings.line[k]
        w.pivots.takes[n_c + k], w.pivots.drag[k] = w.impacts.touches[k], 0.0
        w.pivots.free[n_c + k], w.pivots.target[k] = told(w, AFTER, k), told(w, AFTER, k) - told(w, FIRST, k)
        if i >= 0 and w.impacts.touches[k]:
            w.pivots.takes[i], w.pivots.free[i] = 1, w.gauge[SLIP, i]
            w.pivots.kinetic[i] = told(w, KINETIC, k)
            w.pivots.static[i] = told(w, KINETIC if set_way_before(w, k) else STATIC, k)
            rubs = rubs or w.pivots.kinetic[i] > 0.0
    return rubs


@compiled
def _solve(w: LoopArrays, share: float, skew: float) -> bool:
    """Set what contacts do by the method of pivots, with a share of the restitution; return whether that ends."""
    n, n_c = w.openings.variable.size, w.contacts.sticks.size
    for k in range(n):
        w.pivots.free[n_c + k] -= share * w.pivots.target[k]
    solved = solve_contacts(w, skew)
    for k in range(n):
        w.pivots.free[n_c + k] += share * w.pivots.target[k]
    for k in range(n):
        kind, side, i = APART, 1.0, w.openings.line[k]
        if solved and w.pivots.kind[n_c + k]:
            slip = w.pivots.kind[i] if i >= 0 else 0
            kind, side = (STICKS if slip == 0 else SLIPS), (-1.0 if slip < 0 else 1.0)
        w.impacts.asked[field_of(w, 0, k)], w.impacts.asked[field_of(w, 1, k)] = kind, side
    return solved


@compiled
def _work(w: LoopArrays) -> float:
    """Return the energy that the impulses of the method of pivots bring."""
    work = 0.0
    for a in range(w.pivots.takes.size):
        if w.pivots.takes[a]:
            change = 0.0
            for b in range(w.pivots.takes.size):
                if w.pivots.takes[b]:
                    change += coupling(w, a, b) * w.pivots.force[b]
            work += w.pivots.force[a] * (w.pivots.free[a] + 0.5 * change)
    return work


@compiled
def _mend(w: LoopArrays) -> bool:
    """Compute the impact; change what the contact of the least margin does until no margin is negative."""
    n = w.openings.variable.size
    for _ in range(_MENDED * n + 1):
        ask(w)
        least = -FEASIBLE * max(largest_rate(w), TINY)
        if least_margin(w) >= least:
            return True
        worst, at, lowest = -1, FIRST, least
        for k in range(n):
            for what in (FIRST, SECOND):
                if w.impacts.touches[k] and told(w, what, k) < lowest:
                    worst, at, lowest = k, what, told(w, what, k)
        if worst < 0:
            return False
        kind, side = w.impacts.asked[field_of(w, 0, worst)], w.impacts.asked[field_of(w, 1, worst)]
        if at == FIRST:
            kind = STICKS if kind == APART else APART
        elif kind == STICKS:
            kind = SLIPS
        elif side > 0.0:
            side = -1.0
        else:
            kind, side = STICKS, 1.0
        w.impacts.asked[field_of(w, 0, worst)], w.impacts.asked[field_of(w, 1, worst)] = kind, side
    return False
