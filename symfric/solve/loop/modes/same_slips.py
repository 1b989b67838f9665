"""Contacts in the plane whose slips are the same vector, up to a factor and the order of components.

They share their force in proportion to their bounds, leave together, and are decided as one with the sum of these.
"""

from symfric.codegen.numba_types import compiled
from symfric.lower.constraint_forces import DISTINCT, HOLDS, SHARES
from symfric.solve.loop.codes import COUPLING
from symfric.solve.loop.events.impacts import is_open
from symfric.solve.loop.workspace import LoopArrays


@compiled(inline=True)
def is_second(w: LoopArrays, i: int) -> bool:
    """Whether row i is the second component of a contact in the plane."""
    return 0 <= w.contacts.partner[i] < i


@compiled(inline=True)
def undecided(w: LoopArrays, i: int) -> bool:
    """Whether contact i is at rest and can stick; one that is open in the mode has no friction."""
    k = w.contacts.opens[i]
    return w.selection.zero[i] != 0 and w.contacts.sticks[i] != 0 and not (k >= 0 and is_open(w, k))


@compiled
def leave_together(w: LoopArrays, n_c: int) -> None:
    """Mark the contacts in the plane that shared their force with one that leaves: all reach their bounds at once."""
    for i in range(n_c):
        if not w.planes.leaves[i] or w.contacts.partner[i] <= i:
            continue
        for k in range(n_c):
            j = w.contacts.partner[k]
            if j > k and w.selection.old[k] == 0 and undecided(w, k) and is_twin(w, k, i):
                w.planes.leaves[k] = 1


@compiled(inline=True)
def shares(w: LoopArrays, i: int) -> bool:
    """Whether contact i shares the force of one in the plane with the same slip, in proportion to their bounds."""
    j = w.contacts.partner[i]
    if j < 0 or w.m[i] != SHARES or w.m[j] != SHARES:
        return False
    for k in range(w.basis.order.size):
        n = w.contacts.partner[k]
        if n > k and w.m[k] == HOLDS and w.m[n] == HOLDS and is_twin(w, min(i, j), k):
            return True
    return False


@compiled
def is_twin(w: LoopArrays, i: int, k: int) -> bool:
    """Whether the slips of two contacts in the plane have the same magnitude, up to one factor, in any motion.

    The components of one are those of the other, in any order and direction, times the factor.
    """
    j = w.contacts.partner[i]
    first = component(w, i, k)
    second = w.contacts.partner[first]
    if w.contacts.parallel[i] != w.contacts.parallel[first] or w.contacts.parallel[j] != w.contacts.parallel[second]:
        return False
    a, b = ratio(w, i, first), ratio(w, j, second)
    return abs(abs(a) - abs(b)) <= DISTINCT * (abs(a) + abs(b))


@compiled(inline=True)
def component(w: LoopArrays, i: int, k: int) -> int:
    """Return the component of contact k in the plane that is a multiple of row i, if either is."""
    return k if w.contacts.parallel[i] == w.contacts.parallel[k] else w.contacts.partner[k]


@compiled(inline=True)
def ratio(w: LoopArrays, i: int, k: int) -> float:
    """Return slip i over slip k, of which it is a multiple."""
    return w.gauge[COUPLING + i, k] / w.gauge[COUPLING + k, k]


@compiled
def join(w: LoopArrays, n_c: int) -> None:
    """Let the first of the contacts with the same slip stand for all of them, with the sum of their bounds."""
    p = w.planes
    for i in range(n_c):
        p.bound[i], p.stands[i] = p.kinetic[i] if p.slides[i] else p.static[i], i
        if not undecided(w, i) or w.contacts.partner[i] <= i:
            continue
        for k in range(i):
            if w.contacts.partner[k] > k and p.stands[k] == k and undecided(w, k) and is_twin(w, i, k):
                first, n = component(w, i, k), w.contacts.partner[k]
                second = w.contacts.partner[first]
                way = ratio(w, i, first) * ratio(w, w.contacts.partner[i], second)
                p.stands[i], p.turned[i] = k, 1.0 if (way > 0.0) == (second == n) else -1.0
                p.bound[k] += p.bound[i] * abs(ratio(w, i, first))
