"""What every contact does in an impact, see `symfric.lower.impacts`.

What all contacts that touch do is tried in every combination, and the one with the largest least margin is taken, so
that ties, where one of several is on the border between two, need no threshold. Where there are too many combinations,
`symfric.solve.loop.modes.complementarity` finds one, which is then looked at in the same way: its margins, and how it
could be mended where they are negative. Where friction may permit others, a second one is looked for from another
start, which finds another answer often but not always.
"""

import numpy as np

from symfric.codegen.numba_types import compiled
from symfric.lower.impacts import APART, SLIPS, STICKS, TURNS
from symfric.solve.loop.codes import MANY_CONTACTS, OK, PAINLEVE, SLIP, TERMS
from symfric.solve.loop.events.impacts import (
    AFTER,
    FEASIBLE,
    FIRST,
    KINETIC,
    MOST_TRIALS,
    SECOND,
    STATIC,
    after_rows,
    apply,
    ask,
    begin_impact,
    coupling,
    field,
    largest_rate,
    next_trial,
    rules,
    told,
)
from symfric.solve.loop.modes.complementarity import solve_contacts
from symfric.solve.loop.precision import ROUNDING, TINY
from symfric.solve.loop.stepping.calls import measure
from symfric.solve.loop.workspace import LoopArrays

_DISTINCT = 1e-6  # margin, relative to the largest rate of a gap, beyond which a second combination is another answer
_MENDED = 4  # most attempts to mend a combination, in numbers of contacts
_HALVINGS = 60  # most bisections of the share of restitution


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
        w.impacts.struck[k] = w.impacts.asked[field(w, 0, k)] != APART
    apply(w)
    w.counts.jumped = w.counts.jumped or strikes
    return OK


@compiled
def _choose(w: LoopArrays) -> int:
    """Determine what every contact that touches does; leave the data and the answer of that in place."""
    alone = 0
    for k in range(w.openings.variable.size):
        alone += w.impacts.touches[k]
    w.impacts.asked[rules(w) + 1] = alone == 1
    status = _try_all(w, alone == 1)
    if status == MANY_CONTACTS:
        return _choose_by_pivots(w)
    gain, scale = w.impacts.answer[after_rows(w)], w.impacts.answer[after_rows(w) + 1]
    if status == OK and gain > FEASIBLE * scale:
        w.impacts.asked[rules(w)] = 1.0
        status = _try_all(w, alone == 1)
    return status


@compiled
def _try_all(w: LoopArrays, alone: bool) -> int:
    """Try all combinations; leave the best in place."""
    n, total, best, second = w.openings.variable.size, 1.0, -np.inf, -np.inf
    for k in range(n):
        w.impacts.tried[k] = 0
        w.impacts.options[k] = _options(w, k, alone)
        total *= w.impacts.options[k]
    if total > MOST_TRIALS:
        return MANY_CONTACTS
    for _ in range(int(total)):
        for k in range(n):
            _set(w, k, alone)
        ask(w)
        margin = _least_margin(w)
        if margin > best:
            if best > -np.inf and not _is_best(w):
                second = best
            best = margin
            _keep(w)
        elif margin > second and not _is_best(w):
            second = margin
        next_trial(w, n)
    _restore(w)
    scale = max(largest_rate(w), TINY)
    return OK if best >= -FEASIBLE * scale and not second > _DISTINCT * scale else PAINLEVE


@compiled(inline=True)
def _options(w: LoopArrays, k: int, alone: bool) -> int:
    """Return the number of things that contact k may do."""
    if w.impacts.touches[k] == 0:
        return 1
    return (2 if w.openings.line[k] < 0 else 4) - alone


@compiled(inline=True)
def _set(w: LoopArrays, k: int, alone: bool) -> None:
    """Set what contact k does in the present trial."""
    kind, side, option = APART, 1.0, w.impacts.tried[k]
    if w.impacts.touches[k]:
        option += alone  # the only one is not apart
        kind = APART if option == 0 else (STICKS if option == 1 else SLIPS)
        side = 1.0 if option < 3 else -1.0
        i = w.openings.line[k]
        if alone and i >= 0 and abs(w.gauge[SLIP, i]) > ROUNDING * w.gauge[TERMS, i]:
            kind = STICKS if option == 1 else (SLIPS if option == 2 else TURNS)
            side = 1.0 if w.gauge[SLIP, i] > 0.0 else -1.0
    w.impacts.asked[field(w, 0, k)], w.impacts.asked[field(w, 1, k)] = kind, side


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
        if abs(new - best) > _DISTINCT * (abs(new - old) + abs(best - old)) + FEASIBLE * (abs(new) + abs(best)):
            return False
    return True


@compiled
def _choose_by_pivots(w: LoopArrays) -> int:
    """Determine what every contact that touches does, of many; leave the data and the answer of that in place."""
    rubs = _lay_out(w)
    if not (_solve(w, 1.0, 0.0) and _mend(w)) and not (_solve(w, 1.0, 1.0) and _mend(w)):
        return MANY_CONTACTS
    if rubs:
        _keep(w)
        other = _solve(w, 1.0, 1.0) and _mend(w) and not _is_best(w)
        if other and _least_margin(w) > _DISTINCT * max(largest_rate(w), TINY):
            return PAINLEVE
        _restore(w)
    gain, scale = w.impacts.answer[after_rows(w)], w.impacts.answer[after_rows(w) + 1]
    return OK if gain <= FEASIBLE * scale else _without_gain(w)


@compiled
def _without_gain(w: LoopArrays) -> int:
    """Determine it with the largest share of restitution that gains no energy."""
    low, high, share = 0.0, 1.0, 1.0
    w.impacts.asked[rules(w)] = 1.0
    for _ in range(_HALVINGS):
        if not _solve(w, share, 0.0):
            return MANY_CONTACTS
        gains = _work(w) > 0.0
        ask(w)
        if _least_margin(w) >= -FEASIBLE * max(largest_rate(w), TINY):
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
        w.impacts.asked[field(w, 0, k)] = APART
    ask(w)
    for i in range(n_c):
        w.pivots.takes[i] = 0
    for k in range(n):
        i = w.openings.line[k]
        w.pivots.takes[n_c + k], w.pivots.drag[k] = w.impacts.touches[k], 0.0
        w.pivots.free[n_c + k], w.pivots.target[k] = told(w, AFTER, k), told(w, AFTER, k) - told(w, FIRST, k)
        if i >= 0 and w.impacts.touches[k]:
            w.pivots.takes[i], w.pivots.free[i] = 1, w.gauge[SLIP, i]
            w.pivots.kinetic[i], w.pivots.static[i] = told(w, KINETIC, k), told(w, STATIC, k)
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
        w.impacts.asked[field(w, 0, k)], w.impacts.asked[field(w, 1, k)] = kind, side
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
        if _least_margin(w) >= least:
            return True
        worst, at, lowest = -1, FIRST, least
        for k in range(n):
            for what in (FIRST, SECOND):
                if w.impacts.touches[k] and told(w, what, k) < lowest:
                    worst, at, lowest = k, what, told(w, what, k)
        if worst < 0:
            return False
        kind, side = w.impacts.asked[field(w, 0, worst)], w.impacts.asked[field(w, 1, worst)]
        if at == FIRST:
            kind = STICKS if kind == APART else APART
        elif kind == STICKS:
            kind = SLIPS
        elif side > 0.0:
            side = -1.0
        else:
            kind, side = STICKS, 1.0
        w.impacts.asked[field(w, 0, worst)], w.impacts.asked[field(w, 1, worst)] = kind, side
    return False


@compiled
def _keep(w: LoopArrays) -> None:
    """Keep the data of the impact and the velocities after it."""
    for r in range(w.impacts.asked.size):
        w.impacts.best[r] = w.impacts.asked[r]
    for r in range(w.limits.n_q):
        w.impacts.rates[r] = w.impacts.answer[w.limits.n_q + r]


@compiled
def _restore(w: LoopArrays) -> None:
    """Compute the impact with the data that were kept."""
    for r in range(w.impacts.asked.size):
        w.impacts.asked[r] = w.impacts.best[r]
    ask(w)
