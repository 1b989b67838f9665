"""Slips of contacts at rest in as few coordinates as they are independent, see `symfric.solve.loop.modes.feet`.

``s = L zeta`` by Cholesky's method with pivots, ``L L^T = J M^-1 J^T``, from the rows of J themselves: differences of
nearly parallel rows keep their digits.
"""

import numpy as np

from symfric.codegen.array_table import Reals
from symfric.codegen.numba_types import compiled
from symfric.solve.loop.codes import COUPLING
from symfric.solve.loop.modes.same_slips import undecided
from symfric.solve.loop.modes.tolerances import little
from symfric.solve.loop.workspace import LoopArrays

_SAME = 1e-24  # square of the part of a slip that no others have, relative, below which it follows from them
_APART = 1e-8  # acceleration of surfaces from each other, relative to all, below which it is rounding


@compiled
def are_redundant(w: LoopArrays, n_c: int) -> bool:
    """Whether slips of contacts at rest follow from those of others that are no multiples of them."""
    if w.limits.coupled == 0:
        return False
    n = 0
    for i in range(n_c):
        j = w.contacts.partner[i]
        first = i if j < 0 or i < j else j
        w.feet.among[i] = undecided(w, i) and w.planes.stands[first] == first
        n += w.feet.among[i]
    return n > 1 and factorise(w, n_c) < n


@compiled
def take_all(w: LoopArrays, n_c: int) -> None:
    """Let all contacts at rest that can stick be those of the problem, with the bounds in ``w.planes.bound``."""
    for i in range(n_c):
        w.feet.among[i] = undecided(w, i)
    factorise(w, n_c)


@compiled
def has_one_way(w: LoopArrays, n_c: int, i: int) -> bool:
    """Whether the slip of contact i in the plane has one direction, as contacts stick that stuck before this event.

    So has that of a foot that swings about another one.
    """
    if w.limits.coupled == 0:
        return False
    for k in range(n_c):
        w.feet.among[k] = w.m[k] > 0.5 and w.saltation.before[w.p.size + k] > 0.5
    held = factorise(w, n_c)
    w.feet.among[i], w.feet.among[w.contacts.partner[i]] = 1, 1
    return bool(factorise(w, n_c) == held + 1)


@compiled
def factorise(w: LoopArrays, n_c: int) -> int:
    """Compute L; return how many slips are independent."""
    f, slopes, response = w.feet, w.basis.slopes, w.basis.response
    n_q, spread, rank = w.limits.n_q, COUPLING + n_c, 0
    for i in range(n_c):
        f.used[i] = 0
        for r in range(n_q):
            slopes[i, r], response[i, r] = w.gauge[spread + n_q + r, i], w.gauge[spread + r, i]
    while rank < min(n_c, n_q):
        best, largest = -1, _SAME
        for i in range(n_c):
            if f.among[i] and f.used[i] == 0:
                left = _product(w, i, i) / w.gauge[COUPLING + i, i]
                if left > largest:
                    best, largest = i, left
        if best < 0:
            break
        root = np.sqrt(_product(w, best, best))
        for r in range(n_q):
            slopes[best, r] /= root
            response[best, r] /= root
        f.used[best], f.pivot[rank] = 1, best
        rank += 1
        for i in range(n_c):
            if f.among[i] == 0 or f.used[i]:
                continue
            for _ in range(2):  # twice, because once leaves an error of rounding over the difference of the rows
                part = _product(w, best, i)
                for r in range(n_q):
                    slopes[i, r] -= part * slopes[best, r]
                    response[i, r] -= part * response[best, r]
    for i in range(n_c):
        for k in range(rank):
            total = 0.0
            for r in range(n_q):
                total += w.gauge[spread + n_q + r, i] * response[f.pivot[k], r]
            f.factor[i, k] = total
    for k in range(rank):
        for n in range(k + 1, rank):
            f.factor[f.pivot[k], n] = 0.0
    for i in range(n_c):
        j, f.size[i] = w.contacts.partner[i], 0.0
        if f.among[i]:
            both = w.gauge[COUPLING + i, i] + (w.gauge[COUPLING + j, j] if j >= 0 else 0.0)
            f.size[i] = np.sqrt(0.5 * both if j >= 0 else both)
    f.rank[0] = rank
    return rank


@compiled
def _product(w: LoopArrays, i: int, j: int) -> float:
    total = 0.0
    for r in range(w.limits.n_q):
        total += w.basis.slopes[i, r] * w.basis.response[j, r]
    return total


@compiled
def is_first(w: LoopArrays, i: int) -> bool:
    """Whether row i is a contact along a line, or the first component of one in the plane, of the problem."""
    return w.feet.among[i] != 0 and not 0 <= w.contacts.partner[i] < i


@compiled
def is_active(w: LoopArrays, i: int) -> bool:
    """Whether row i is the first one of a contact whose friction is that of the smooth problem."""
    return is_first(w, i) and w.planes.bound[i] > 0.0 and w.feet.sticks[i] == 0


@compiled
def aim(w: LoopArrays, n_c: int) -> float:
    """Compute zeta_0 and the offsets from the slip accelerations in ``w.planes.free``; return the size of both."""
    f, total = w.feet, 0.0
    for k in range(f.rank[0]):
        i = f.pivot[k]
        rest = w.planes.free[i]
        for n in range(k):
            rest -= f.factor[i, n] * f.target[n]
        f.target[k] = rest / f.factor[i, k]
        total += f.target[k] ** 2
    f.scale[0] = np.sqrt(total)
    _find_offsets(w, n_c)
    return float(f.scale[0])


@compiled
def _find_offsets(w: LoopArrays, n_c: int) -> None:
    """Compute the parts of the slip accelerations that do not follow from those of the pivots: surfaces move apart."""
    f, size = w.feet, w.feet.scale[0]
    for i in range(n_c):
        f.offset[i] = 0.0
        if f.among[i]:
            size = max(size, abs(w.planes.free[i]) / f.size[i])
    for i in range(n_c):
        if f.among[i] and f.used[i] == 0:
            rest = w.planes.free[i]
            for k in range(f.rank[0]):
                rest -= f.factor[i, k] * f.target[k]
            if abs(rest) > max(_APART * size * f.size[i], little(w, i)):
                f.offset[i] = rest
                f.scale[0] = max(f.scale[0], abs(rest) / f.size[i])


@compiled
def move_apart(w: LoopArrays, n_c: int) -> bool:
    """Whether the surfaces under contacts of the problem move apart, so that not all of them can stick."""
    found = False
    for i in range(n_c):
        found = found or (w.feet.among[i] != 0 and w.feet.offset[i] != 0.0)
    return found


@compiled
def slip_of(w: LoopArrays, i: int, at: int) -> float:
    """Return the acceleration of slip i at the point (0) or at the trial point (1)."""
    total = w.feet.offset[i]
    for k in range(w.feet.rank[0]):
        total += w.feet.factor[i, k] * w.feet.point[at, k]
    return total


@compiled
def stepped(w: LoopArrays, i: int) -> float:
    """Return what the step changes of slip i."""
    total = 0.0
    for k in range(w.feet.rank[0]):
        total += w.feet.factor[i, k] * w.feet.step[k]
    return total


@compiled
def largest_slip(w: LoopArrays, n_c: int) -> float:
    """Return the largest virtual slip, relative to the size of its row."""
    largest = 0.0
    for i in range(n_c):
        if w.feet.among[i] and w.feet.size[i] > 0.0:
            largest = max(largest, abs(slip_of(w, i, 0)) / w.feet.size[i])
    return largest


@compiled
def held_directions(w: LoopArrays, n_c: int) -> int:
    """Compute an orthonormal basis of what sticking holds, and where; return its number, -1 if surfaces move apart."""
    f, n, held = w.feet, w.feet.rank[0], 0
    for i in range(n_c):
        if f.among[i] == 0 or f.sticks[i] == 0:
            continue
        place = -f.offset[i]
        for h in range(held):
            part = 0.0
            for k in range(n):
                part += f.factor[i, k] * f.kept[h, k]
            place -= part * f.place[h]
        size = 0.0
        if held < n:
            for k in range(n):
                f.kept[held, k] = f.factor[i, k]
            for _ in range(2):
                leave_free(w, f.kept[held], held)
            for k in range(n):
                size += f.kept[held, k] ** 2
        if size <= _SAME * w.gauge[COUPLING + i, i]:
            if abs(place) > _APART * f.scale[0] * f.size[i]:
                return -1
            continue
        for k in range(n):
            f.kept[held, k] /= np.sqrt(size)
        f.place[held] = place / np.sqrt(size)
        held += 1
    return held


@compiled
def put_in_place(w: LoopArrays, held: int) -> None:
    """Move the point to where the contacts that stick do not slip."""
    leave_free(w, w.feet.point[0], held)
    for h in range(held):
        for k in range(w.feet.rank[0]):
            w.feet.point[0, k] += w.feet.place[h] * w.feet.kept[h, k]


@compiled
def leave_free(w: LoopArrays, vector: Reals, held: int) -> None:
    """Subtract the components along the first directions that are held."""
    for h in range(held):
        part = 0.0
        for k in range(w.feet.rank[0]):
            part += w.feet.kept[h, k] * vector[k]
        for k in range(w.feet.rank[0]):
            vector[k] -= part * w.feet.kept[h, k]
