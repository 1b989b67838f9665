"""Select the contacts at rest that have to slip if no forces within bounds hold them.

Several facets of the polytope of all forces may be exceeded at once, say when a contact has just lost a part of its
friction. The forces are followed while all bounds grow by a common factor, from one exceeded facet to the next:
Newton's method for the least factor that holds. The last one is exceeded the most, and its contacts are released. Which
one that is depends neither on the basis nor on the order of the contacts.
"""

from symfric.codegen.numba_types import compiled
from symfric.lower.constraint_forces import AT_BOUND, HOLDS, SHARES
from symfric.solve.loop.layout import backward, direction, forward
from symfric.solve.loop.sticking_basis import coefficient, entering, lead_of, release, share, swap
from symfric.solve.loop.workspace import COUPLING, DROP, LOAD, PULL

_BEYOND = 1e-9  # least excess over a bound, relative to it, by which a facet counts as exceeded


@compiled
def release_worst(w, n_x, n_c):
    """Release the contacts of the most exceeded facet, after `exchange` found an exceeded one."""
    lead = _weigh(w, n_x, n_c)
    factor = 1.0
    for _ in range(4 + 4 * n_c):
        for j in range(n_c):
            w.facet[j] = w.slips[j]
        factor = _grow(w, n_c, lead, factor)
        lead = _exceeded(w, n_c, factor)
        if lead < 0:
            break
    for j in range(n_c):
        w.slips[j] = w.facet[j]
    release(w, n_c)


@compiled
def _first(w, i):
    """Return the representative of the contacts parallel to i: the one with a constraint, or the first that sticks."""
    first = lead_of(w, i)
    if w.m[first] == HOLDS:
        return first
    for j in range(i):
        if w.m[j] > 0.5 and w.parallel[j] == w.parallel[i]:
            return j
    return i


@compiled(inline=True)
def _factor(w, i, first):
    """Return the ratio of the slip of contact i to that of a parallel one."""
    return w.gauge[COUPLING + i, first] / w.gauge[COUPLING + first, first]


@compiled
def _weigh(w, n_x, n_c):
    """Sum the forces and bounds of parallel contacts; return the representative of the slipping ones."""
    lead = -1
    for i in range(n_c):
        w.force[i], w.most[i] = 0.0, 0.0
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
            lead = first if w.slips[i] != 0.0 else lead
        w.force[first] += _factor(w, i, first) * force
        w.most[first] += abs(_factor(w, i, first)) * bound
    return lead


@compiled
def _grow(w, n_c, lead, factor):
    """Scale all bounds until the contacts that slip with `lead` can hold it; return the factor."""
    total = w.most[lead]
    for k in range(n_c):
        if w.m[k] == AT_BOUND and w.most[k] > 0.0 and w.slips[k] != 0.0:
            total += abs(coefficient(w, n_c, k, lead)) * w.most[k]
    excess = -w.slips[lead] * w.force[lead] - factor * w.most[lead]
    if total <= 0.0 or excess <= 0.0:
        return factor
    growth = excess / total
    for k in range(n_c):
        if w.m[k] == AT_BOUND and w.most[k] > 0.0:
            _change_force(w, n_c, k, -w.m[direction(k, n_c)] * w.most[k] * growth)
    return factor + growth


@compiled
def _change_force(w, n_c, k, change):
    """Change the force of contact k, and the constraint forces accordingly."""
    coefficient(w, n_c, k, -1)
    for j in range(n_c):
        if w.m[j] == HOLDS:
            w.force[j] -= w.weight[j] * change
    w.force[k] += change


@compiled
def _exceeded(w, n_c, factor):
    """Exchange contacts beyond bounds times `factor`; return one that cannot be exchanged, -1 if there is none."""
    for turn in range(4 + 4 * n_c):
        lead, most = -1, _BEYOND
        for j in range(n_c):
            beyond = abs(w.force[j]) - factor * w.most[j]
            if w.m[j] == HOLDS and beyond > most * (abs(w.force[j]) + factor * w.most[j]):
                lead, most = j, beyond / (abs(w.force[j]) + factor * w.most[j])
                if turn > 2 * n_c:
                    break
        if lead < 0:
            return -1
        sign = 1.0 if w.force[lead] > 0.0 else -1.0
        best = entering(w, n_c, lead, -sign, turn > 2 * n_c)
        if best < 0:
            return lead
        first = _first(w, best)
        c = coefficient(w, n_c, first, lead)
        if c == 0.0:
            return -1
        _change_force(w, n_c, first, (w.force[lead] - sign * factor * w.most[lead]) / c)
        swap(w, n_c, lead, best)
        _rename(w, first, best)
        _rename(w, lead, _first(w, lead))
        share(w, n_c)
    return -1


@compiled(inline=True)
def _rename(w, old, new):
    """Replace the representative of parallel contacts."""
    if old != new:
        part = _factor(w, old, new)
        w.force[new], w.most[new] = part * w.force[old], abs(part) * w.most[old]
        w.force[old], w.most[old] = 0.0, 0.0
