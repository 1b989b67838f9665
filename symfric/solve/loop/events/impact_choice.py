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
from symfric.solve.loop.events.impacts import (
    AFTER,
    FEASIBLE,
    FIRST,
    KINETIC,
    MOST_TRIALS,
    SECOND,
    STATIC,
    SWERVE,
    after_fields,
    apply,
    ask,
    begin_impact,
    coupling,
    field_of,
    is_planar,
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
_HALVINGS = 60  # most bisections of the part of restitutions with which an impact gains no energy


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
    status = _try_all(w, alone == 1)
    if status == MANY_CONTACTS and not planar:
        return _choose_by_pivots(w)
    if planar:
        return _bounce_less(w, alone == 1) if status == OK and _gains(w, ROUNDING) else status
    if status == OK and _gains(w, FEASIBLE):
        w.impacts.asked[rules(w)] = 1.0
        status = _try_all(w, alone == 1)
    return status


@compiled
def _gains(w: LoopArrays, least: float) -> bool:
    """Whether the impact adds energy, by more than a part of its terms."""
    return w.impacts.answer[after_fields(w)] > least * w.impacts.answer[after_fields(w) + 1]


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
        w.impacts.asked[field_of(w, 2, k)] = part


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
        for way in range(_aim(w)):
            _take_way(w, way)
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


@compiled
def _aim(w: LoopArrays) -> int:
    """Find the directions of slips in the plane after the impact that friction opposes; return the number of choices.

    Those of one contact are in ``w.planes.angles``. Those of several are found one after the other, until they agree:
    one choice at most, which is the only one as long as the contacts affect each other weakly.
    """
    slipping, last = 0, -1
    for k in range(w.openings.variable.size):
        if is_planar(w, k) and w.impacts.asked[field_of(w, 0, k)] == SLIPS:
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
            if is_planar(w, k) and w.impacts.asked[field_of(w, 0, k)] == SLIPS:
                turned = max(turned, _turn_to_best(w, k))
        if not turned > AGREE:
            return 1 if turned >= 0.0 else 0
    return 0


@compiled
def _ways(w: LoopArrays, k: int) -> int:
    """Find the directions of contact k, with those of the others as they are; return how many there are."""
    for s in range(SAMPLES):
        _point(w, k, sample_angle(s))
        ask(w)
        w.planes.samples[s] = told(w, SWERVE, k)
    n = find_angles(w)
    for s in range(n):
        for _ in range(POLISHES):
            angle = w.planes.angles[s]
            _point(w, k, angle)
            ask(w)
            step = chord_step(w, angle, told(w, SWERVE, k))
            w.planes.angles[s] = angle - step
    return n


@compiled
def _turn_to_best(w: LoopArrays, k: int) -> float:
    """Turn contact k to the direction of the largest margin; return by how much, NaN if there is none."""
    e, f, best, found = w.impacts.asked[field_of(w, 4, k)], w.impacts.asked[field_of(w, 5, k)], -np.inf, np.nan
    for s in range(_ways(w, k)):
        _point(w, k, w.planes.angles[s])
        ask(w)
        if told(w, SECOND, k) > best:
            best, found = told(w, SECOND, k), w.planes.angles[s]
    _point(w, k, found)
    return abs(w.impacts.asked[field_of(w, 4, k)] - e) + abs(w.impacts.asked[field_of(w, 5, k)] - f)


@compiled(inline=True)
def _take_way(w: LoopArrays, way: int) -> None:
    """Take one of the directions that were found."""
    if w.planes.aimed.size and w.planes.aimed[0] >= 0:
        _point(w, w.planes.aimed[0], w.planes.angles[way])


@compiled(inline=True)
def _point(w: LoopArrays, k: int, angle: float) -> None:
    """Set the direction of contact k in the plane."""
    w.impacts.asked[field_of(w, 4, k)], w.impacts.asked[field_of(w, 5, k)] = np.cos(angle), np.sin(angle)


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
            w.impacts.asked[field_of(w, 4, k)] = w.gauge[SLIP, i] / speed if slips else 0.0
            w.impacts.asked[field_of(w, 5, k)] = w.gauge[SLIP, i + 1] / speed if slips else 0.0
        elif alone and i >= 0 and abs(w.gauge[SLIP, i]) > ROUNDING * w.gauge[TERMS, i]:
            kind = STICKS if option == 1 else (SLIPS if option == 2 else TURNS)
            side = 1.0 if w.gauge[SLIP, i] > 0.0 else -1.0
    w.impacts.asked[field_of(w, 0, k)], w.impacts.asked[field_of(w, 1, k)] = kind, side


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
    return _without_gain(w) if _gains(w, FEASIBLE) else OK


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
        if _least_margin(w) >= least:
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
