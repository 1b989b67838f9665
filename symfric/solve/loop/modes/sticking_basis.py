"""Basis of the sticking contacts (those with their own constraint), and its exchange when one reaches its bound.

Where more contacts stick than slips are independent, those with a constraint of their own are a basis: the slip rows of
the others are ``J_k = sum_j c_kj J_j`` over the basis, and their friction is given, zero or at the static bound. The
motion determines the forces of the basis,

    lambda_j = g_j - sum_k c_kj lambda_k.

Contacts at rest hold if forces within their bounds exist that do it: a linear programme without an objective. A contact
of the basis whose force would exceed its bound stays there, and another whose force can still change the right way
takes its place in the basis: the dual simplex method for bounded variables, with Bland's rule where it runs long. If
there is no such contact, the forces lie on a facet of the polytope of all forces, a zonotope: its normal is a slip of
this contact and of all those with ``c_kj != 0``, which start together.

References
----------
Bland, New finite pivoting rules for the simplex method, Mathematics of Operations Research 2 (1977) 103.
"""

from symfric.codegen.numba_types import compiled
from symfric.lower.constraint_forces import AT_BOUND, DISTINCT, FOLLOWS, HOLDS, REDUNDANT, SHARES
from symfric.solve.loop.codes import COUPLING, PULL
from symfric.solve.loop.modes.layout import direction
from symfric.solve.loop.workspace import LoopArrays

CLOSE = 1e-4  # pivot of the coupling relative to its diagonal below which rounding makes it inaccurate
_FAINT = 16 * DISTINCT  # coefficient c_kj relative to its terms, and their errors, below which it may be rounding


@compiled
def share(w: LoopArrays, n_c: int) -> bool:
    """Mark the sticking contacts with their own constraint, and the others by how their force is determined.

    A basis is kept as long as its contacts stick. Return whether some slips are nearly dependent.
    """
    if not w.limits.coupled:  # each has its own
        n = 0
        for i in range(n_c):
            if w.m[i] > 0.5:
                w.m[i], w.basis.order[n], w.basis.share[i, i] = HOLDS, i, w.gauge[COUPLING + i, i]
                n += 1
        return False
    n = _order(w, n_c)
    for a in range(n):
        i = w.basis.order[a]
        pivot = w.gauge[COUPLING + i, i]
        for b in range(a):
            j = w.basis.order[b]
            rest = w.gauge[COUPLING + i, j]
            for c in range(b):
                k = w.basis.order[c]
                rest -= w.basis.share[i, k] * w.basis.share[j, k] * w.basis.share[k, k]
            w.basis.share[i, j] = rest / w.basis.share[j, j]
            pivot -= rest * w.basis.share[i, j]
        if pivot <= CLOSE * w.gauge[COUPLING + i, i]:
            _share_closely(w, n)
            return True
        w.basis.share[i, i] = pivot
        w.m[i] = HOLDS
    return False


@compiled(inline=True)
def _order(w: LoopArrays, n_c: int) -> int:
    """List the sticking contacts, basis first, contacts at their bounds last; return their number.

    Those without a force are sorted by decreasing static friction, independent of the order of the contacts.
    """
    n = 0
    for rank in (HOLDS, SHARES, FOLLOWS, AT_BOUND):
        begin = n
        for i in range(n_c):
            if w.m[i] != rank:
                continue
            at = n
            while rank == FOLLOWS and at > begin and w.gauge[PULL, w.basis.order[at - 1]] < w.gauge[PULL, i]:
                w.basis.order[at] = w.basis.order[at - 1]
                at -= 1
            w.basis.order[at] = i
            n += 1
    return n


@compiled
def _share_closely(w: LoopArrays, n: int) -> None:
    """Mark the contacts if a slip nearly depends on earlier ones; see `symfric.lower.constraint_forces`."""
    n_q, waits = w.limits.n_q, n
    a = 0
    while a < n:
        i = w.basis.order[a]
        _orthogonalise(w, a, n_q)
        if w.m[i] == FOLLOWS and waits > 0 and w.basis.share[i, i] <= CLOSE * w.gauge[COUPLING + i, i]:
            last = a
            while last + 1 < n and w.m[w.basis.order[last + 1]] == FOLLOWS:
                w.basis.order[last] = w.basis.order[last + 1]
                last += 1
            w.basis.order[last] = i  # those that are clearly independent come first
            waits -= 1
            if last > a:
                continue
        a += 1
        if w.basis.share[i, i] > REDUNDANT * w.gauge[COUPLING + i, i]:
            w.m[i] = HOLDS
            continue
        if w.m[i] != AT_BOUND:
            w.m[i] = FOLLOWS
        for b in range(a - 1):
            j = w.basis.order[b]
            if w.contacts.parallel[j] == w.contacts.parallel[i] and w.m[j] == HOLDS:
                w.m[i] = SHARES


@compiled(inline=True)
def _orthogonalise(w: LoopArrays, a: int, n_q: int) -> None:
    """Subtract from the row at place a of the order its components along those of the basis before it."""
    i, spread = w.basis.order[a], COUPLING + w.basis.order.size
    for r in range(n_q):
        w.basis.slopes[i, r], w.basis.response[i, r] = w.gauge[spread + n_q + r, i], w.gauge[spread + r, i]
    for b in range(a):
        w.basis.share[i, w.basis.order[b]] = 0.0
    for _ in range(2):
        for b in range(a):
            if w.m[w.basis.order[b]] == HOLDS:
                _part(w, i, w.basis.order[b], n_q)
    w.basis.share[i, i] = _product(w, i, i, n_q)


@compiled(inline=True)
def _product(w: LoopArrays, i: int, j: int, n_q: int) -> float:
    total = 0.0
    for r in range(n_q):
        total += w.basis.slopes[i, r] * w.basis.response[j, r]
    return total


@compiled(inline=True)
def _part(w: LoopArrays, i: int, j: int, n_q: int) -> None:
    """Subtract the component along row j from row i."""
    part = _product(w, j, i, n_q) / w.basis.share[j, j]
    w.basis.share[i, j] += part
    for r in range(n_q):
        w.basis.slopes[i, r] -= part * w.basis.slopes[j, r]
        w.basis.response[i, r] -= part * w.basis.response[j, r]


@compiled
def coefficient(w: LoopArrays, n_c: int, k: int, lead: int) -> float:
    """Return ``c_kj`` of contact k, whose force is given, for the basis contact j = `lead`; zero if it may be rounding.

    The weights of all of the basis are left in ``w.basis.weight``. Where rows nearly agree, the errors of the weights
    of later ones count for those of earlier ones; parallel contacts have no such errors.
    """
    for j in range(n_c):
        if w.m[j] == HOLDS and w.contacts.parallel[j] == w.contacts.parallel[k]:
            for i in range(n_c):
                w.basis.weight[i] = 0.0
            w.basis.weight[j] = w.gauge[COUPLING + k, j] / w.gauge[COUPLING + j, j]
            return w.basis.weight[j] if j == lead else 0.0
    total, n = 0.0, 0
    while n < n_c and w.basis.order[n] != k:
        n += 1
    for a in range(n - 1, -1, -1):
        j = w.basis.order[a]
        if w.m[j] != HOLDS:
            continue
        total = w.basis.share[k, j]
        error = (w.gauge[COUPLING + k, k] * w.gauge[COUPLING + j, j]) ** 0.5 / w.basis.share[j, j]
        for b in range(a + 1, n):
            i = w.basis.order[b]
            if w.m[i] == HOLDS:
                term = w.basis.weight[i] * w.basis.share[i, j]
                total -= term
                error += abs(term) + w.basis.error[i] * abs(w.basis.share[i, j])
        w.basis.weight[j], w.basis.error[j] = total, error
        if j == lead:
            return total if abs(total) > _FAINT * error else 0.0
    return 0.0


@compiled(inline=True)
def _way(w: LoopArrays, i: int, j: int) -> float:
    """Return 1 if the slips of two parallel contacts have the same sign, else -1."""
    return 1.0 if w.gauge[COUPLING + i, j] > 0.0 else -1.0


@compiled
def exchange(w: LoopArrays, n_c: int, i: int, side: int, least: bool) -> bool:
    """Keep contact i, which would slip in the direction `side`, at its bound and replace it in the basis.

    Return whether there is one; if not, ``w.basis.slips`` holds the ways in which contacts slip with it. Parallel
    contacts do all of it together. The marks are those that `share` has left; `least` says to take the other of least
    index.
    """
    lead = lead_of(w, i)
    way = side * _way(w, i, lead)
    best = entering(w, n_c, lead, way, least)
    if best < 0:
        return False
    swap(w, n_c, lead, best)
    return True


@compiled
def lead_of(w: LoopArrays, i: int) -> int:
    """Return the basis contact among i and those parallel to it."""
    for j in range(w.basis.order.size):
        if w.m[j] == HOLDS and w.contacts.parallel[j] == w.contacts.parallel[i]:
            return j
    return i


@compiled
def entering(w: LoopArrays, n_c: int, lead: int, way: float, least: bool) -> int:
    """Return the contact that can enter the basis so that `lead` does not slip in the direction `way`, -1 if none."""
    best, largest = -1, 0.0
    for k in range(n_c):
        w.basis.slips[k] = 0.0
        if (w.m[k] == HOLDS or w.m[k] == SHARES) and w.contacts.parallel[k] == w.contacts.parallel[lead]:
            w.basis.slips[k] = way * _way(w, k, lead)
        if w.m[k] != FOLLOWS and w.m[k] != AT_BOUND:
            continue
        c = coefficient(w, n_c, k, lead)
        w.basis.slips[k] = 0.0 if c == 0.0 else (way if c > 0.0 else -way)
        if c == 0.0 or (w.m[k] == AT_BOUND and w.m[direction(k, n_c)] == w.basis.slips[k]):
            continue
        size = c * c * w.gauge[COUPLING + lead, lead] / w.gauge[COUPLING + k, k]
        if size > largest and not (least and best >= 0):
            best, largest = k, size
    return best


@compiled
def swap(w: LoopArrays, n_c: int, lead: int, best: int) -> None:
    """Replace contact `lead` and those parallel to it, now at their bounds, by `best` and those parallel to it."""
    for j in range(n_c):
        if (w.m[j] == HOLDS or w.m[j] == SHARES) and w.contacts.parallel[j] == w.contacts.parallel[lead]:
            w.m[j], w.m[direction(j, n_c)] = AT_BOUND, w.basis.slips[j]
        elif w.contacts.parallel[j] == w.contacts.parallel[best] and (w.m[j] == FOLLOWS or w.m[j] == AT_BOUND):
            w.m[j] = SHARES
    w.m[best] = HOLDS


@compiled
def release(w: LoopArrays, n_c: int) -> None:
    """Release the contacts that slip together, in their directions."""
    for j in range(n_c):
        if w.basis.slips[j] != 0.0:
            w.m[j], w.m[direction(j, n_c)] = 0.0, w.basis.slips[j]
