"""Lemke's method for the forces, or impulses, of many contacts that touch, with friction along lines.

With the rates z of slips and gaps without the contacts, which forces r = (Q, P) change by ``W r``, the unknowns are the
normal forces P, friction ``Q = Q+ - Q-`` and the sizes ``lambda`` of slips (Stewart and Trinkle):

    0 <= z_n + (W r)_n                  complementary to   P >= 0
    0 <= lambda + z_t + (W r)_t         complementary to   Q+ >= 0
    0 <= lambda - z_t - (W r)_t         complementary to   Q- >= 0
    0 <= F + mu P - Q+ - Q-             complementary to   lambda >= 0

with the bound F of friction under a given load. A contact that slips already adds ``-d mu W_t`` to the column of its P.
Everything is scaled so that W has ones on its diagonal. Ties are broken by the lexicographic order, so that the pivots
end: with a solution, or on a ray, which says nothing unless the matrix is copositive, as it is for unilateral contacts
with friction that is not too large.

References
----------
Cottle, Pang and Stone, The Linear Complementarity Problem, sections 4.4 and 4.9.
Stewart and Trinkle, An implicit time-stepping scheme for rigid body dynamics with inelastic collisions and Coulomb
friction, International Journal for Numerical Methods in Engineering 39 (1996) 2673.
"""

from symfric.codegen.numba_types import compiled
from symfric.solve.loop.events.impacts import coupling
from symfric.solve.loop.precision import TINY
from symfric.solve.loop.workspace import LoopArrays

_PIVOT = 1e-11  # least entry of the scaled problem that is a pivot
_TIE = 1e-12  # relative difference of ratios that are the same
_SLIPS = 1e-9  # size of a slip, relative to the largest rate, that is not zero
_LONGEST = 50  # most pivots, in numbers of unknowns


@compiled
def solve_contacts(w: LoopArrays, skew: float) -> bool:
    """Solve the problem in ``w.pivots``; return whether Lemke's method ends with a solution.

    Contacts along a line, and after them those that open, take part where ``w.pivots.takes`` is not zero. Of each the
    arrays hold its rate `free`; of the former the coefficients `static` and, once it slips, `kinetic`, of its opening
    or, for one of given load, the bounds of its force; of the latter `drag`, which is ``d mu`` of a slip that is not
    zero. The results are `kind`, for a line the direction of its slip or 0 and for an opening 1 if it is closed, and
    the forces `force`.

    `skew` changes the ray on which the method starts, and with that perhaps which of several solutions it finds.
    """
    n_c = w.contacts.sticks.size
    for i in range(n_c):
        w.pivots.slides[i] = 0
    for _ in range(n_c + 1):
        f = _place(w, n_c)
        m = _count(w, n_c) + 2 * f
        _write(w, n_c, f, m)
        if not _lemke(w, m, skew):
            return False
        changed = False
        for i in range(n_c):
            if w.pivots.takes[i] and not w.pivots.slides[i] and _value(w, m, w.pivots.place[i] + 2 * f) > _SLIPS:
                w.pivots.slides[i], changed = 1, True
        if not changed:
            break
    _read(w, n_c, f, m)
    return True


@compiled
def _place(w: LoopArrays, n_c: int) -> int:
    """Give contacts that take part their places among the unknowns: lines, then gaps; return the number of lines."""
    n, f = 0, 0
    for a in range(w.pivots.takes.size):
        w.pivots.place[a] = n + 2 * f if a >= n_c else n  # behind Q+, Q-, lambda
        if w.pivots.takes[a]:
            n += 1
            f += a < n_c
    return f


@compiled
def _count(w: LoopArrays, n_c: int) -> int:
    """Return the number of contacts that take part."""
    n = 0
    for a in range(w.pivots.takes.size):
        n += w.pivots.takes[a] != 0
    return n


@compiled
def _write(w: LoopArrays, n_c: int, f: int, m: int) -> None:
    """Write ``x -> M x + q`` as Lemke's table: slacks, x with the factor -M, the ray, and q."""
    table, unit, largest = w.pivots.table, w.pivots.unit, TINY
    for r in range(m):
        for c in range(2 * m + 2):
            table[r, c] = 0.0
    for a in range(w.pivots.takes.size):
        own = coupling(w, a, a)
        unit[a] = own**-0.5 if own > 0.0 else 1.0
        if w.pivots.takes[a]:
            largest = max(largest, unit[a] * abs(w.pivots.free[a]))
    w.pivots.unit[w.pivots.takes.size] = largest
    for a in range(w.pivots.takes.size):
        if w.pivots.takes[a] == 0:
            continue
        row = w.pivots.place[a]
        for b in range(w.pivots.takes.size):
            if w.pivots.takes[b] == 0:
                continue
            column, change = w.pivots.place[b], coupling(w, a, b)
            if b >= n_c and w.openings.line[b - n_c] >= 0:
                change -= w.pivots.drag[b - n_c] * coupling(w, a, w.openings.line[b - n_c])
            change *= unit[a] * unit[b]
            table[row, m + column] = -change
            if a < n_c:
                table[row + f, m + column] = change
            if b < n_c:
                table[row, m + column + f] = change
                if a < n_c:
                    table[row + f, m + column + f] = -change
        rate = unit[a] * w.pivots.free[a] / largest
        table[row, 2 * m + 1] = rate
        if a < n_c:
            table[row + f, 2 * m + 1] = -rate
            table[row, m + row + 2 * f], table[row + f, m + row + 2 * f] = -1.0, -1.0
            _write_bound(w, n_c, f, m, a)


@compiled(inline=True)
def _write_bound(w: LoopArrays, n_c: int, f: int, m: int, i: int) -> None:
    """Write the row of the bound of friction i."""
    row, k = w.pivots.place[i] + 2 * f, w.contacts.opens[i]
    bound = w.pivots.kinetic[i] if w.pivots.slides[i] else w.pivots.static[i]
    w.pivots.table[row, m + row - 2 * f], w.pivots.table[row, m + row - f] = 1.0, 1.0
    if k < 0:
        w.pivots.table[row, 2 * m + 1] = bound / (w.pivots.unit[i] * w.pivots.unit[w.pivots.takes.size])
    else:
        w.pivots.table[row, m + w.pivots.place[n_c + k]] = -bound * w.pivots.unit[n_c + k] / w.pivots.unit[i]


@compiled
def _lemke(w: LoopArrays, m: int, skew: float) -> bool:
    """Pivot until the ray has left the basis; return whether it has."""
    table, basis, first, least = w.pivots.table, w.pivots.basis, -1, 0.0
    for r in range(m):
        table[r, r], basis[r] = 1.0, r
        ray = 1.0 + skew * r / m
        table[r, 2 * m] = -ray
        if table[r, 2 * m + 1] / ray < least:
            first, least = r, table[r, 2 * m + 1] / ray
    if first < 0:
        return True
    entering, row = 2 * m, first
    for _ in range(_LONGEST * m):
        leaving = basis[row]
        _pivot(w, m, row, entering)
        basis[row] = entering
        if leaving == 2 * m:
            return True
        entering = leaving + m if leaving < m else leaving - m
        row = _leaving(w, m, entering)
        if row < 0:
            return False
    return False


@compiled
def _pivot(w: LoopArrays, m: int, row: int, entering: int) -> None:
    """Bring an unknown into the basis, in a row."""
    table = w.pivots.table
    factor = 1.0 / table[row, entering]
    for c in range(2 * m + 2):
        table[row, c] *= factor
    for r in range(m):
        share = table[r, entering]
        if r == row or share == 0.0:
            continue
        for c in range(2 * m + 2):
            table[r, c] -= share * table[row, c]


@compiled
def _leaving(w: LoopArrays, m: int, entering: int) -> int:
    """Return the row whose unknown becomes zero first, -1 if none does; that of the ray, if it is among them."""
    table, basis, best, least = w.pivots.table, w.pivots.basis, -1, 0.0
    for r in range(m):
        if table[r, entering] > _PIVOT:
            ratio = table[r, 2 * m + 1] / table[r, entering]
            if best < 0 or ratio < least:
                best, least = r, ratio
    if best < 0:
        return -1
    most = least + _TIE * (1.0 + abs(least))
    for r in range(m):
        if table[r, entering] > _PIVOT and table[r, 2 * m + 1] / table[r, entering] <= most:
            if basis[r] == 2 * m:
                return r
            if r != best and _is_less(w, m, entering, r, best):
                best = r
    return best


@compiled
def _is_less(w: LoopArrays, m: int, entering: int, one: int, other: int) -> bool:
    """Whether a row comes before another one in the lexicographic order."""
    table = w.pivots.table
    for c in range(m):
        a, b = table[one, c] / table[one, entering], table[other, c] / table[other, entering]
        if a != b:
            return a < b
    return False


@compiled
def _read(w: LoopArrays, n_c: int, f: int, m: int) -> None:
    """Read what contacts do in the solution, and their forces."""
    largest = w.pivots.unit[w.pivots.takes.size]
    for a in range(w.pivots.takes.size):
        w.pivots.kind[a], w.pivots.force[a], place = 0, 0.0, w.pivots.place[a]
        if w.pivots.takes[a] == 0:
            continue
        force = _value(w, m, place)
        if a >= n_c:
            w.pivots.kind[a] = _row(w, m, place) >= 0
        else:
            force -= _value(w, m, place + f)
            if _row(w, m, place + 2 * f) >= 0:
                w.pivots.kind[a] = 1 if _row(w, m, place + f) >= 0 else -(_row(w, m, place) >= 0)
        w.pivots.force[a] = force * w.pivots.unit[a] * largest


@compiled
def _row(w: LoopArrays, m: int, x: int) -> int:
    """Return the row of the table in which unknown x is, -1 if it is zero."""
    for r in range(m):
        if w.pivots.basis[r] == m + x:
            return r
    return -1


@compiled(inline=True)
def _value(w: LoopArrays, m: int, x: int) -> float:
    """Return unknown x of the scaled problem."""
    r = _row(w, m, x)
    return w.pivots.table[r, 2 * m + 1] if r >= 0 else 0.0
