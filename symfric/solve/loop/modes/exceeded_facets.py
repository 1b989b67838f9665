"""Select the contacts at rest that have to slip if no forces within bounds hold them.

Several facets of the polytope of all forces may be exceeded at once, say when a contact has just lost a part of its
friction. The forces are followed while all bounds grow by a common factor, from one exceeded facet to the next:
Newton's method for the least factor that holds. The last one is exceeded the most, and its contacts are released. Which
one that is depends neither on the basis nor on the order of the contacts.
"""

from symfric.codegen.numba_types import compiled
from symfric.lower.constraint_forces import AT_BOUND, HOLDS, SHARES
from symfric.solve.loop.codes import COUPLING, DROP, LOAD, PULL
from symfric.solve.loop.modes.layout import backward, direction, forward
from symfric.solve.loop.modes.sticking_basis import coefficient, entering, lead_of, release, share, swap
from symfric.solve.loop.workspace import LoopArrays

_BEYOND = 1e-9  # least excess over a bound, relative to it, by which a facet counts as exceeded


@compiled
def release_worst(w: LoopArrays, n_x: int, n_c: int) -> None:
    """Release the contacts of the most exceeded facet, after `exchange` found an exceeded one."""
    lead = _weigh(w, n_x, n_c)
    factor = 1.0
    for _ in range(4 + 4 * n_c):
        for j in range(n_c):
            w.basis.facet[j] = w.basis.slips[j]
        factor = _grow(w, n_c, lead, factor)
        lead = _exceeded(w, n_c, factor)
        if lead < 0:
            break
    for j in range(n_c):
        w.basis.slips[j] = w.basis.facet[j]
    release(w, n_c)


@compiled
def _first(w: LoopArrays, i: int) -> int:
    """Return the representative of the contacts parallel to i: the one with a constraint, or the first that sticks."""
    first = lead_of(w, i)
    if w.m[first] == HOLDS:
        return first
    for j in range(i):
        if w.m[j] > 0.5 and w.contacts.parallel[j] == w.contacts.parallel[i]:
            return j
    return i


@compiled(inline=True)
def _factor(w: LoopArrays, i: int, first: int) -> float:
    """Return the ratio of the slip of contact i to that of a parallel one."""
    return w.gauge[COUPLING + i, first] / w.gauge[COUPLING + first, first]


@compiled
def _weigh(w: LoopArrays, n_x: int, n_c: int) -> int:
    """Sum the forces and bounds of parallel contacts; return the representative of the slipping ones."""
    lead = -1
    for i in range(n_c):
        w.basis.force[i], w.basis.most[i] = 0.0, 0.0
    for i in range(n_c):
        if w.m[i] < 0.5:
            continue
        first = _first(w, i)
        bound = 0.5 * (w.gauge[PULL, i] / w.gauge[COUPLING + i, i] + w.gauge[LOAD, i] * w.gauge[DROP, i])
        force = 0.0
        if w.m[i] == AT_BOUND:
            force = -w.m[direction(i, n_c)] * bound
        elif w.m[i] == HOLDS or w.m[i] == SHARES:
            force = 0.5 * (w.probe[n_x + forward(i), 0] - w.probe[n_x + backward(i), 0])
            lead = first if w.basis.slips[i] != 0.0 else lead
        w.basis.force[first] += _factor(w, i, first) * force
        w.basis.most[first] += abs(_factor(w, i, first)) * bound
    return lead


@compiled
def _grow(w: LoopArrays, n_c: int, lead: int, factor: float) -> float:
    """Scale all bounds until the contacts that slip with `lead` can hold it; return the factor."""
    total = w.basis.most[lead]
    for k in range(n_c):
        if w.m[k] == AT_BOUND and w.basis.most[k] > 0.0 and w.basis.slips[k] != 0.0:
            total += abs(coefficient(w, n_c, k, lead)) * w.basis.most[k]
    excess = -w.basis.slips[lead] * w.basis.force[lead] - factor * w.basis.most[lead]
    if total <= 0.0 or excess <= 0.0:
        return factor
    growth = excess / total
    for k in range(n_c):
        if w.m[k] == AT_BOUND and w.basis.most[k] > 0.0:
            _change_force(w, n_c, k, -w.m[direction(k, n_c)] * w.basis.most[k] * growth)
    return factor + growth


@compiled
def _change_force(w: LoopArrays, n_c: int, k: int, change: float) -> None:
    """Change the force of contact k, and the constraint forces accordingly."""
    coefficient(w, n_c, k, -1)
    for j in range(n_c):
        if w.m[j] == HOLDS:
            w.basis.force[j] -= w.basis.weight[j] * change
    w.basis.force[k] += change


@compiled
def _exceeded(w: LoopArrays, n_c: int, factor: float) -> int:
    """Exchange contacts beyond bounds times `factor`; return one that cannot be exchanged, -1 if there is none."""
    for turn in range(4 + 4 * n_c):
        lead, most = -1, _BEYOND
        for j in range(n_c):
            beyond = abs(w.basis.force[j]) - factor * w.basis.most[j]
            if w.m[j] == HOLDS and beyond > most * (abs(w.basis.force[j]) + factor * w.basis.most[j]):
                lead, most = j, beyond / (abs(w.basis.force[j]) + factor * w.basis.most[j])
                if turn > 2 * n_c:
                    break
        if lead < 0:
            return -1
        sign = 1.0 if w.basis.force[lead] > 0.0 else -1.0
        best = entering(w, n_c, lead, -sign, turn > 2 * n_c)
        if best < 0:
            return lead
        first = _first(w, best)
        c = coefficient(w, n_c, first, lead)
        if c == 0.0:
            return -1
        _change_force(w, n_c, first, (w.basis.force[lead] - sign * factor * w.basis.most[lead]) / c)
        swap(w, n_c, lead, best)
        _rename(w, first, best)
        _rename(w, lead, _first(w, lead))
        share(w, n_c)
    return -1


@compiled(inline=True)
def _rename(w: LoopArrays, old: int, new: int) -> None:
    """Replace the representative of parallel contacts."""
    if old != new:
        part = _factor(w, old, new)
        w.basis.force[new], w.basis.most[new] = part * w.basis.force[old], abs(part) * w.basis.most[old]
        w.basis.force[old], w.basis.most[old] = 0.0, 0.0
