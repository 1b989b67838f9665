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
"""

from symfric.codegen.numba_types import compiled
from symfric.lower.constraint_forces import AT_BOUND, DISTINCT, FOLLOWS, HOLDS, REDUNDANT, SHARES
from symfric.solve.loop.layout import direction
from symfric.solve.loop.workspace import COUPLING, PULL

CLOSE = 1e-4  # pivot of the coupling relative to its diagonal below which rounding makes it inaccurate
_FAINT = 16 * DISTINCT  # coefficient c_kj relative to its terms below which it is zero up to rounding


@compiled
def share(w, n_c):
    """Mark the sticking contacts with their own constraint, and the others by how their force is determined.

    A basis is kept as long as its contacts stick. Return whether some slips are nearly dependent.
    """
    if not w.limits.coupled:  # each has its own
        n = 0
        for i in range(n_c):
            if w.m[i] > 0.5:
                w.m[i], w.order[n], w.share[i, i] = HOLDS, i, w.gauge[COUPLING + i, i]
                n += 1
        return False
    n = _order(w, n_c)
    for a in range(n):
        i = w.order[a]
        pivot = w.gauge[COUPLING + i, i]
        for b in range(a):
            j = w.order[b]
            rest = w.gauge[COUPLING + i, j]
            for c in range(b):
                k = w.order[c]
                rest -= w.share[i, k] * w.share[j, k] * w.share[k, k]
            w.share[i, j] = rest / w.share[j, j]
            pivot -= rest * w.share[i, j]
        if pivot <= CLOSE * w.gauge[COUPLING + i, i]:
            _share_closely(w, n)
            return True
        w.share[i, i] = pivot
        w.m[i] = HOLDS
    return False


@compiled(inline=True)
def _order(w, n_c):
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
            while rank == FOLLOWS and at > begin and w.gauge[PULL, w.order[at - 1]] < w.gauge[PULL, i]:
                w.order[at] = w.order[at - 1]
                at -= 1
            w.order[at] = i
            n += 1
    return n


@compiled
def _share_closely(w, n):
    """Mark the contacts if a slip nearly depends on earlier ones; see `symfric.lower.constraint_forces`."""
    n_q = w.limits.n_q
    spread = COUPLING + w.order.size
    for a in range(n):
        i = w.order[a]
        for r in range(n_q):
            w.slopes[i, r], w.response[i, r] = w.gauge[spread + n_q + r, i], w.gauge[spread + r, i]
        for b in range(a):
            w.share[i, w.order[b]] = 0.0
        for _ in range(2):
            for b in range(a):
                if w.m[w.order[b]] == HOLDS:
                    _part(w, i, w.order[b], n_q)
        w.share[i, i] = _product(w, i, i, n_q)
        if w.share[i, i] > REDUNDANT * w.gauge[COUPLING + i, i]:
            w.m[i] = HOLDS
            continue
        if w.m[i] != AT_BOUND:
            w.m[i] = FOLLOWS
        for b in range(a):
            j = w.order[b]
            if w.parallel[j] == w.parallel[i] and w.m[j] == HOLDS:
                w.m[i] = SHARES


@compiled(inline=True)
def _product(w, i, j, n_q):
    total = 0.0
    for r in range(n_q):
        total += w.slopes[i, r] * w.response[j, r]
    return total


@compiled(inline=True)
def _part(w, i, j, n_q):
    """Subtract the component along row j from row i."""
    part = _product(w, j, i, n_q) / w.share[j, j]
    w.share[i, j] += part
    for r in range(n_q):
        w.slopes[i, r] -= part * w.slopes[j, r]
        w.response[i, r] -= part * w.response[j, r]


@compiled
def coefficient(w, n_c, k, lead):
    """Return ``c_kj`` of contact k, whose force is given, for the basis contact j = `lead`."""
    found, size, n = 0.0, 0.0, 0
    while n < n_c and w.order[n] != k:
        n += 1
    for a in range(n - 1, -1, -1):
        j = w.order[a]
        if w.m[j] != HOLDS:
            continue
        found = w.share[k, j]
        size = (w.gauge[COUPLING + k, k] * w.gauge[COUPLING + j, j]) ** 0.5 / w.share[j, j]
        for b in range(a + 1, n):
            if w.m[w.order[b]] == HOLDS:
                term = w.weight[w.order[b]] * w.share[w.order[b], j]
                found -= term
                size += abs(term)
        w.weight[j] = found
        if j == lead:
            return found if abs(found) > _FAINT * size else 0.0
    return 0.0


@compiled(inline=True)
def _way(w, i, j):
    """Return 1 if the slips of two parallel contacts have the same sign, else -1."""
    return 1.0 if w.gauge[COUPLING + i, j] > 0.0 else -1.0


@compiled
def exchange(w, n_c, i, side, least):
    """Keep contact i, which would slip in the direction `side`, at its bound and replace it in the basis.

    Return whether there is one; if not, ``w.slips`` holds the ways in which contacts slip with it. Parallel contacts do
    all of it together. The marks are those that `share` has left; `least` says to take the other of least index.
    """
    lead = lead_of(w, i)
    way = side * _way(w, i, lead)
    best = entering(w, n_c, lead, way, least)
    if best < 0:
        return False
    swap(w, n_c, lead, best)
    return True


@compiled
def lead_of(w, i):
    """Return the basis contact among i and those parallel to it."""
    for j in range(w.order.size):
        if w.m[j] == HOLDS and w.parallel[j] == w.parallel[i]:
            return j
    return i


@compiled
def entering(w, n_c, lead, way, least):
    """Return the contact that can enter the basis so that `lead` does not slip in the direction `way`, -1 if none."""
    best, largest = -1, 0.0
    for k in range(n_c):
        w.slips[k] = 0.0
        if (w.m[k] == HOLDS or w.m[k] == SHARES) and w.parallel[k] == w.parallel[lead]:
            w.slips[k] = way * _way(w, k, lead)
        if w.m[k] != FOLLOWS and w.m[k] != AT_BOUND:
            continue
        c = coefficient(w, n_c, k, lead)
        w.slips[k] = 0.0 if c == 0.0 else (way if c > 0.0 else -way)
        if c == 0.0 or (w.m[k] == AT_BOUND and w.m[direction(k, n_c)] == w.slips[k]):
            continue
        size = c * c * w.gauge[COUPLING + lead, lead] / w.gauge[COUPLING + k, k]
        if size > largest and not (least and best >= 0):
            best, largest = k, size
    return best


@compiled
def swap(w, n_c, lead, best):
    """Replace contact `lead` and those parallel to it, now at their bounds, by `best` and those parallel to it."""
    for j in range(n_c):
        if (w.m[j] == HOLDS or w.m[j] == SHARES) and w.parallel[j] == w.parallel[lead]:
            w.m[j], w.m[direction(j, n_c)] = AT_BOUND, w.slips[j]
        elif w.parallel[j] == w.parallel[best] and (w.m[j] == FOLLOWS or w.m[j] == AT_BOUND):
            w.m[j] = SHARES
    w.m[best] = HOLDS


@compiled
def release(w, n_c):
    """Release the contacts that slip together, in their directions."""
    for j in range(n_c):
        if w.slips[j] != 0.0:
            w.m[j], w.m[direction(j, n_c)] = 0.0, w.slips[j]
