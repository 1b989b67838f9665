"""Feet of bodies at rest that can turn: more contacts than motions, whose forces are not unique although the motion is.

Write the slips of the contacts at rest as ``s = L zeta`` with coordinates zeta that are orthonormal in the kinetic
energy, ``L L^T = J M^-1 J^T``, as many as slips are independent; zeta_0 are those of the slip accelerations without the
forces of these contacts. With the bounds b_i and discs in the plane, intervals along a line:

- **Accelerations** are unique: they minimise ``|zeta - zeta_0|^2/2 + sum_i b_i |L_i zeta|`` (Gauss and Moreau).
- **Forces that hold** exist as long as zeta_0 lies within the limit surface of all of them, with the support function
  ``sum_i b_i |L_i zeta|``: a direction in which it is less than ``zeta_0^T zeta`` proves that there are none.

Of all forces that hold, those of the smooth convex problem

    minimal  -sum_i b_i k_i log(1 - |lambda_i|^2/b_i^2)   among those with   sum_i L_i^T lambda_i = -zeta_0

are taken, k_i the size of L_i, their analytic centre: ``lambda_i = -b_i s_i/(1 + sqrt(1 + |s_i|^2))`` with
``s_i = L_i zeta/k_i`` and zeta without conditions. They are unique, within the bounds whenever any forces are, and
smooth in time up to the end of the sticking, also where the body then turns about a foot, whose force is inside its
bound. As no formula gives them, they are told for a while by their values and rates at one instant; what the motion
needs besides is quadratic in the time since, and left to the contacts of the basis. Where a force of these reaches its
bound they are computed anew. Near the end of the sticking each such event comes with the square of the time that is
left before, as in Newton's method, so that the last one is exact to rounding. There the same problem tells the contacts
that start, which are on their bounds, and where to.

References
----------
Moreau, Unilateral contact and dry friction in finite freedom dynamics, in: Nonsmooth Mechanics and Applications,
Springer (1988). Goyal, Ruina, Papadopoulos, Planar sliding with dry friction, Part 1, Wear 143 (1991) 307.
"""

import numpy as np

from symfric.codegen.array_table import Reals
from symfric.codegen.numba_types import compiled
from symfric.lower.constraint_forces import AT_BOUND, FOLLOWS
from symfric.solve.loop.arithmetic import value
from symfric.solve.loop.codes import COUPLING
from symfric.solve.loop.modes.layout import backward
from symfric.solve.loop.modes.tolerances import natural_time
from symfric.solve.loop.precision import EPS, ROUNDING, TINY
from symfric.solve.loop.stepping.calls import expand, measure, prelude, probe
from symfric.solve.loop.workspace import LoopArrays

LAST_ROOM = 2e-13  # part of the limit surface by which forces must be inside for the contacts to hold on
AT_LIMIT = 1e-6  # distance of a force from its bound, relative, that is one at the end of the sticking
_SAME = 1e-24  # square of the part of a slip that no others have, relative, below which it follows from them
_NARROW, _NARROWEST = 1e-2, 1e-10  # widths over which friction rises in smooth problems, as part of the acceleration
_NARROWER = 0.1  # from one of these problems to the next
_SLIPS = 30.0  # acceleration over that width from which on a contact slips
_AGREES = 1e-9  # error of forces and accelerations, relative, of a solution
_SLOW = 1e-6  # acceleration, as part of that without forces, below which a contact at the limit has none
_FAR = 1e5  # virtual slip, relative, from which on contacts that would not slip are left out
_INSIDE = 1e-3  # of these the least distance of a force from its bound, relative
_FARTHEST = 1e14  # virtual slip, relative, beyond which forces are on the limit surface
_ITERATIONS, _HALVINGS, _LAST_ITERATIONS = 200, 40, 4
_NEAR = 1e-4  # relative change by a step of Newton's method from which on its steps are taken whole
_OVERSHOOT = 0.1  # largest slope behind the lowest point of a step, as part of that before it
_CLOSE = 1e-10  # last step of Newton's method, relative, to a minimum
_INSTANT = 1e-6  # part of the scale of time over which rates are differences


@compiled
def are_redundant(w: LoopArrays, n_c: int) -> bool:
    """Whether slips of contacts at rest follow from those of others that are no multiples of them."""
    if w.limits.coupled == 0:
        return False
    n = 0
    for i in range(n_c):
        j = w.contacts.partner[i]
        first = i if j < 0 or i < j else j
        w.feet.among[i] = w.selection.zero[i] != 0 and w.contacts.sticks[i] != 0 and w.planes.stands[first] == first
        n += w.feet.among[i]
    return n > 1 and _factorise(w, n_c) < n


@compiled
def take_all(w: LoopArrays, n_c: int) -> None:
    """Let all contacts at rest that can stick be those of the problem, with the bounds in ``w.planes.bound``."""
    for i in range(n_c):
        w.feet.among[i] = w.selection.zero[i] != 0 and w.contacts.sticks[i] != 0
    _factorise(w, n_c)


@compiled
def _factorise(w: LoopArrays, n_c: int) -> int:
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
def _is_first(w: LoopArrays, i: int) -> bool:
    """Whether row i is a contact along a line, or the first component of one in the plane, of the problem."""
    return w.feet.among[i] != 0 and not 0 <= w.contacts.partner[i] < i


@compiled
def _is_active(w: LoopArrays, i: int) -> bool:
    """Whether row i is the first one of a contact whose friction is that of the smooth problem."""
    return _is_first(w, i) and w.planes.bound[i] > 0.0 and w.feet.sticks[i] == 0


@compiled
def _aim(w: LoopArrays) -> float:
    """Compute zeta_0 from the slip accelerations in ``w.planes.free``; return its length."""
    f, total = w.feet, 0.0
    for k in range(f.rank[0]):
        i = f.pivot[k]
        rest = w.planes.free[i]
        for n in range(k):
            rest -= f.factor[i, n] * f.target[n]
        f.target[k] = rest / f.factor[i, k]
        total += f.target[k] ** 2
    f.scale[0] = np.sqrt(total)
    return float(f.scale[0])


@compiled
def _slip_of(w: LoopArrays, i: int, at: int) -> float:
    """Return slip i at the point (0) or at the trial point (1)."""
    total = 0.0
    for k in range(w.feet.rank[0]):
        total += w.feet.factor[i, k] * w.feet.point[at, k]
    return total


@compiled
def _slope_along(w: LoopArrays, n_c: int, soft: float, width: float) -> float:
    """Return the slope of the smooth problem at the trial point along the step.

    With ``soft = 1`` it is that of the forces that hold, with ``soft = 0`` that of the accelerations, where friction
    rises over the width.
    """
    f, total = w.feet, 0.0
    for k in range(f.rank[0]):
        total += ((1.0 - soft) * f.point[1, k] - f.target[k]) * f.step[k]
    for i in range(n_c):
        if _is_active(w, i):
            j = w.contacts.partner[i]
            x, y, a, b = _slip_of(w, i, 1), 0.0, _stepped(w, i), 0.0
            if j >= 0:
                y, b = _slip_of(w, j, 1), _stepped(w, j)
            least = width * f.size[i]
            total += w.planes.bound[i] * (x * a + y * b) / (soft * least + np.hypot(least, np.hypot(x, y)))
    return total


@compiled
def _stepped(w: LoopArrays, i: int) -> float:
    """Return what the step changes of slip i."""
    total = 0.0
    for k in range(w.feet.rank[0]):
        total += w.feet.factor[i, k] * w.feet.step[k]
    return total


@compiled
def _changed(w: LoopArrays, n_c: int, width: float) -> float:
    """Return the largest change of a slip by the step, relative to what changes its friction."""
    f, largest = w.feet, 0.0
    for i in range(n_c):
        if _is_active(w, i):
            j = w.contacts.partner[i]
            x, y, a, b = _slip_of(w, i, 0), 0.0, _stepped(w, i), 0.0
            if j >= 0:
                y, b = _slip_of(w, j, 0), _stepped(w, j)
            largest = max(largest, np.hypot(a, b) / np.hypot(width * f.size[i], np.hypot(x, y)))
    return largest


@compiled
def _differentiate(w: LoopArrays, n_c: int, soft: float, width: float) -> None:
    """Compute slopes and curvatures of the smooth problem at the point."""
    f, n = w.feet, w.feet.rank[0]
    for k in range(n):
        f.slope[k] = (1.0 - soft) * f.point[0, k] - f.target[k]
        for c in range(n):
            f.matrix[k, c] = 1.0 - soft if k == c else 0.0
    for i in range(n_c):
        bound = w.planes.bound[i]
        if not _is_active(w, i):
            continue
        j = w.contacts.partner[i]
        x, y = _slip_of(w, i, 0), (_slip_of(w, j, 0) if j >= 0 else 0.0)
        least = width * f.size[i]
        root = np.hypot(least, np.hypot(x, y))
        size = soft * least + root
        turn, still = bound / (root * size * size), bound * least * (least + soft * root) / (root * size * size)
        own, other, both = still + turn * y * y, still + turn * x * x, -turn * x * y
        for k in range(n):
            a, b = f.factor[i, k], (f.factor[j, k] if j >= 0 else 0.0)
            f.slope[k] += bound * (x * a + y * b) / size
            for c in range(n):
                p, q = f.factor[i, c], (f.factor[j, c] if j >= 0 else 0.0)
                f.matrix[k, c] += own * a * p + other * b * q + both * (a * q + b * p)


@compiled
def _solve_step(w: LoopArrays) -> float:
    """Compute Newton's step from slopes and curvatures, by Cholesky's method; return its decrement."""
    f, n = w.feet, w.feet.rank[0]
    for k in range(n):
        for c in range(k + 1):
            rest = f.matrix[k, c]
            for r in range(c):
                rest -= f.matrix[k, r] * f.matrix[c, r]
            if c < k:
                f.matrix[k, c] = rest / f.matrix[c, c]
            else:
                f.matrix[k, k] = np.sqrt(max(rest, EPS * EPS * f.matrix[k, k] + TINY))
    for k in range(n):
        rest = -f.slope[k]
        for c in range(k):
            rest -= f.matrix[k, c] * f.step[c]
        f.step[k] = rest / f.matrix[k, k]
    gained = 0.0
    for k in range(n):
        gained += f.step[k] ** 2
    for k in range(n - 1, -1, -1):
        rest = f.step[k]
        for c in range(k + 1, n):
            rest -= f.matrix[c, k] * f.step[c]
        f.step[k] = rest / f.matrix[k, k]
    return gained


@compiled
def _solve_free_step(w: LoopArrays, held: int) -> float:
    """Compute Newton's step in the directions that are not held; return its decrement."""
    f, n = w.feet, w.feet.rank[0]
    _leave_free(w, f.slope, held)
    for k in range(n):  # curvatures among the free directions, one in the held ones
        _leave_free(w, f.matrix[k], held)
    for c in range(n):
        for h in range(held):
            part = 0.0
            for k in range(n):
                part += f.kept[h, k] * f.matrix[k, c]
            for k in range(n):
                f.matrix[k, c] -= part * f.kept[h, k]
    for h in range(held):
        for k in range(n):
            for c in range(n):
                f.matrix[k, c] += f.kept[h, k] * f.kept[h, c]
    gained = _solve_step(w)
    _leave_free(w, f.step, held)
    return gained


@compiled
def _minimise(w: LoopArrays, n_c: int, soft: float, width: float, held: int, farthest: float) -> bool:
    """Minimise the smooth problem from the point by Newton's method; return whether it was followed with numbers.

    Where the forces reach the limit surface the point is far away, and the last one.
    """
    f, n, last = w.feet, w.feet.rank[0], 0
    for _ in range(_ITERATIONS):
        _differentiate(w, n_c, soft, width)
        gained = _solve_free_step(w, held)
        if not gained < np.inf:
            return False
        if last > 0 or _changed(w, n_c, width) <= _NEAR:
            last += 1
        part = 1.0
        for _ in range(_HALVINGS):
            for k in range(n):
                f.point[1, k] = f.point[0, k] + part * f.step[k]
            if last > 0 or _slope_along(w, n_c, soft, width) <= _OVERSHOOT * gained:
                break
            part *= 0.5
        for k in range(n):
            f.point[0, k] = f.point[1, k]
        if last >= _LAST_ITERATIONS or _largest_slip(w, n_c) > farthest:
            return True
    return True


@compiled
def _largest_slip(w: LoopArrays, n_c: int) -> float:
    """Return the largest virtual slip, relative to the size of its row."""
    largest = 0.0
    for i in range(n_c):
        if w.feet.among[i] and w.feet.size[i] > 0.0:
            largest = max(largest, abs(_slip_of(w, i, 0)) / w.feet.size[i])
    return largest


@compiled
def room_left(w: LoopArrays, n_c: int) -> float:
    """Compute the forces that hold the contacts in ``w.feet.hold``; return how far they are inside the limit surface.

    The answer is relative, negative if there are no such forces. Near the limit contacts that would not slip there,
    such as a foot about which a body turns, are left out: their forces follow from those of the others, and the virtual
    slip, which is large, leaves them at rest.
    """
    f, held = w.feet, 0
    _aim(w)
    for k in range(f.rank[0]):
        f.point[0, k] = 0.0
    for i in range(n_c):
        f.sticks[i] = 0
    _minimise(w, n_c, 1.0, 1.0, 0, _FAR)
    _compute_forces(w, n_c)
    if _largest_slip(w, n_c) > _FAR:
        for i in range(n_c):
            if _is_first(w, i):
                j = w.contacts.partner[i]
                force = abs(f.hold[i]) if j < 0 else np.hypot(f.hold[i], f.hold[j])
                f.sticks[i] = force < w.planes.bound[i] * (1.0 - _INSIDE)
                if j >= 0:
                    f.sticks[j] = f.sticks[i]
        held = _held_directions(w, n_c)
        if held == f.rank[0]:
            for i in range(n_c):
                f.sticks[i] = 0
            held = 0
        _leave_free(w, f.point[0], held)
        _minimise(w, n_c, 1.0, 1.0, held, _FARTHEST)
        _compute_forces(w, n_c)
        if held > 0:
            _complete_forces(w, n_c, held)
    reach, pushed = 0.0, 0.0
    for i in range(n_c):
        if _is_active(w, i):
            j = w.contacts.partner[i]
            reach += w.planes.bound[i] * np.hypot(_slip_of(w, i, 0), _slip_of(w, j, 0) if j >= 0 else 0.0)
    for k in range(f.rank[0]):
        pushed += f.target[k] * f.point[0, k]
    return 1.0 - pushed / reach if reach > 0.0 else (1.0 if pushed == 0.0 else -1.0)


@compiled
def _compute_forces(w: LoopArrays, n_c: int) -> None:
    """Compute the forces of active contacts from the virtual slip; zero for those without a bound."""
    f = w.feet
    for i in range(n_c):
        if not _is_first(w, i) or f.sticks[i]:
            continue
        j = w.contacts.partner[i]
        x, y = _slip_of(w, i, 0), (_slip_of(w, j, 0) if j >= 0 else 0.0)
        size = f.size[i] + np.hypot(f.size[i], np.hypot(x, y))
        f.hold[i] = -w.planes.bound[i] * x / size if size > 0.0 else 0.0
        if j >= 0:
            f.hold[j] = -w.planes.bound[i] * y / size if size > 0.0 else 0.0


@compiled
def _complete_forces(w: LoopArrays, n_c: int, held: int) -> None:
    """Change the forces of contacts that are left out, as little as possible, so that all together hold."""
    f, n = w.feet, w.feet.rank[0]
    for k in range(n):
        f.slope[k] = f.target[k]
        for c in range(n):
            f.matrix[k, c] = 0.0
    for i in range(n_c):
        if f.among[i] == 0:
            continue
        for k in range(n):
            f.slope[k] += f.factor[i, k] * f.hold[i]
            for c in range(n):
                f.matrix[k, c] += f.factor[i, k] * f.factor[i, c] if f.sticks[i] else 0.0
    for k in range(n):  # what acts along the free directions is balanced by the others
        f.step[k] = f.slope[k]
    _leave_free(w, f.step, held)
    for k in range(n):
        f.slope[k] -= f.step[k]
    for c in range(n):
        for k in range(n):
            free = 1.0 if k == c else 0.0
            for h in range(held):
                free -= f.kept[h, k] * f.kept[h, c]
            f.matrix[k, c] += free
    _solve_step(w)
    for i in range(n_c):
        if f.among[i] and f.sticks[i]:
            for k in range(n):
                f.hold[i] += f.factor[i, k] * f.step[k]


@compiled
def leave_at_limit(w: LoopArrays, n_c: int) -> bool:
    """Mark the contacts that start at the end of a common sticking as leaving; return whether it is there."""
    row = COUPLING + n_c + w.limits.n_q + w.limits.coupled
    for i in range(n_c):
        w.planes.bound[i] = w.gauge[row, i]
    take_all(w, n_c)
    if not -_AGREES <= room_left(w, n_c) <= LAST_ROOM:
        return False
    for i in range(n_c):
        if _is_first(w, i):
            j = w.contacts.partner[i]
            force = abs(w.feet.hold[i]) if j < 0 else np.hypot(w.feet.hold[i], w.feet.hold[j])
            w.planes.leaves[i] = force >= w.planes.bound[i] * (1.0 - AT_LIMIT)
    return True


@compiled
def accelerate(w: LoopArrays, n_c: int) -> bool:
    """Compute accelerations of contacts at rest, and forces of those that slip, with the bounds in ``w.planes.bound``.

    Friction that rises over a small width tells which contacts slip, Newton's method with these the accelerations. The
    problem is convex: forces that fit are the solution, whatever the width.
    """
    f, p = w.feet, w.planes
    take_all(w, n_c)
    if room_left(w, n_c) >= -_AGREES:
        for i in range(n_c):
            if f.among[i]:
                p.gain[i], p.force[i] = 0.0, f.hold[i]
        return True
    size, width = _aim(w), 1.0
    for k in range(f.rank[0]):
        f.point[0, k] = f.target[k]
    while width >= _NARROWEST:
        for i in range(n_c):
            f.sticks[i] = 0
        if not _minimise(w, n_c, 0.0, width * size, 0, np.inf):
            return False
        _tell_sticking(w, n_c, _SLIPS * width * size)
        for k in range(f.rank[0]):
            f.point[2, k] = f.point[0, k]
        if width <= _NARROW and _is_solution(w, n_c):
            return True
        for k in range(f.rank[0]):
            f.point[0, k] = f.point[2, k]
        width *= _NARROWER
    return False


@compiled
def _tell_sticking(w: LoopArrays, n_c: int, least: float) -> None:
    """Tell contacts that stick by their accelerations; those that leave at the limit have none, but for rounding."""
    row = COUPLING + n_c + w.limits.n_q + w.limits.coupled
    for i in range(n_c):
        if _is_first(w, i):
            j = w.contacts.partner[i]
            moved = np.hypot(_slip_of(w, i, 0), _slip_of(w, j, 0) if j >= 0 else 0.0)
            tied = w.planes.leaves[i] != 0 and w.planes.bound[i] >= w.gauge[row, i] * (1.0 - ROUNDING)
            w.feet.sticks[i] = moved <= max(least, _SLOW * w.feet.scale[0] if tied else 0.0) * w.feet.size[i]
            if j >= 0:
                w.feet.sticks[j] = w.feet.sticks[i]


@compiled
def _is_solution(w: LoopArrays, n_c: int) -> bool:
    """Whether the contacts that are told to stick do, and the others slip; computes their accelerations and forces."""
    f, p = w.feet, w.planes
    if not _polish(w, n_c):
        return False
    for k in range(f.rank[0]):
        f.slope[k] = f.target[k]
    for i in range(n_c):
        if f.among[i]:
            p.gain[i], p.force[i] = 0.0 if f.sticks[i] else _slip_of(w, i, 0), f.hold[i]
    for i in range(n_c):
        if not _is_first(w, i) or f.sticks[i]:
            continue
        j = w.contacts.partner[i]
        moved = np.hypot(p.gain[i], p.gain[j] if j >= 0 else 0.0)
        if not moved > _AGREES * f.scale[0] * f.size[i]:
            return False
        p.force[i] = -p.bound[i] * p.gain[i] / moved
        if j >= 0:
            p.force[j] = -p.bound[i] * p.gain[j] / moved
        for k in range(f.rank[0]):
            f.slope[k] += f.factor[i, k] * p.force[i] + (f.factor[j, k] * p.force[j] if j >= 0 else 0.0)
    for i in range(n_c):
        f.before[i] = p.free[i]
        if f.among[i]:
            p.free[i], f.among[i] = 0.0, f.sticks[i]
            for k in range(f.rank[0]):
                p.free[i] += f.factor[i, k] * f.slope[k]
    held = _factorise(w, n_c) == 0 or room_left(w, n_c) >= -_AGREES
    for i in range(n_c):
        if f.among[i]:
            p.force[i] = f.hold[i]
    for i in range(n_c):
        p.free[i] = f.before[i]
    take_all(w, n_c)
    _aim(w)
    return held


@compiled
def _polish(w: LoopArrays, n_c: int) -> bool:
    """Minimise with the slips of contacts that stick held at zero and the others' friction at their bounds.

    Return whether there is a minimum.
    """
    f, n = w.feet, w.feet.rank[0]
    held = _held_directions(w, n_c)
    if held == n:
        for i in range(n_c):
            f.sticks[i] = 1
        return True
    _leave_free(w, f.point[0], held)
    moved, size = 0.0, 0.0
    for _ in range(2 * _LAST_ITERATIONS):
        _differentiate(w, n_c, 0.0, 0.0)
        if not _solve_free_step(w, held) < np.inf:
            return False
        moved, size = 0.0, 0.0
        for k in range(n):
            f.point[0, k] += f.step[k]
            moved, size = max(moved, abs(f.step[k])), max(size, abs(f.point[0, k]))
    return moved <= _CLOSE * size


@compiled
def _held_directions(w: LoopArrays, n_c: int) -> int:
    """Compute an orthonormal basis of what contacts that stick hold; return its number."""
    f, n, held = w.feet, w.feet.rank[0], 0
    for i in range(n_c):
        if f.among[i] == 0 or f.sticks[i] == 0 or held == n:
            continue
        for k in range(n):
            f.kept[held, k] = f.factor[i, k]
        for _ in range(2):
            _leave_free(w, f.kept[held], held)
        size = 0.0
        for k in range(n):
            size += f.kept[held, k] ** 2
        if size <= _SAME * w.gauge[COUPLING + i, i]:
            continue
        for k in range(n):
            f.kept[held, k] /= np.sqrt(size)
        held += 1
    return held


@compiled
def _leave_free(w: LoopArrays, vector: Reals, held: int) -> None:
    """Subtract the components along the first directions that are held."""
    for h in range(held):
        part = 0.0
        for k in range(w.feet.rank[0]):
            part += w.feet.kept[h, k] * vector[k]
        for k in range(w.feet.rank[0]):
            vector[k] -= part * w.feet.kept[h, k]


@compiled
def tell_forces(w: LoopArrays, n_x: int, n_c: int) -> None:
    """Tell the mode the forces of contacts in the plane that stick beyond the basis, with their rates."""
    _mark(w, n_c)
    if not _hold_now(w, n_x, n_c):
        return
    for i in range(n_c):
        w.feet.before[i] = w.feet.hold[i]
    prelude(w)
    expand(w)
    time = -_INSTANT * _scale_of_time(w, n_x, n_c)  # before, where there are forces that hold
    order, n_t, finite = w.c.shape[1] - 1, w.y.size, True
    for r in range(n_t):
        w.feet.entry_y[r] = w.y[r]
    for r in range(n_x):
        w.y[r] = value(w.c[r], order, time)
        finite = finite and abs(w.y[r]) < np.inf
    w.y[n_x] += time
    if finite:
        measure(w, w.y, w.gauge)
        finite = _hold_now(w, n_x, n_c)
    for r in range(n_t):
        w.y[r] = w.feet.entry_y[r]
    measure(w, w.y, w.gauge)
    for i in range(n_c):
        if w.feet.among[i] and w.contacts.partner[i] >= 0:
            v = w.planes.variable[i] + (w.contacts.partner[i] < i)
            w.m[v] = w.feet.before[i]
            w.m[v + 2] = (w.feet.hold[i] - w.feet.before[i]) / time if finite else 0.0
            w.m[w.planes.since[i]] = w.y[n_x]


@compiled
def _mark(w: LoopArrays, n_c: int) -> None:
    """Let contacts that stick be those of the problem, and remember their marks."""
    for i in range(n_c):
        w.feet.among[i], w.feet.mark[i] = w.m[i] > 0.5, w.m[i]


@compiled
def _hold_now(w: LoopArrays, n_x: int, n_c: int) -> bool:
    """Compute the forces that hold the contacts that stick, at the state; return whether these are numbers."""
    row = COUPLING + n_c + w.limits.n_q + w.limits.coupled
    for i in range(n_c):
        if w.feet.among[i]:
            w.m[i] = FOLLOWS
    prelude(w)
    probe(w)
    for i in range(n_c):
        if w.feet.among[i]:
            w.planes.free[i], w.planes.bound[i] = w.probe[n_x + backward(i), 1], w.gauge[row, i]
            w.m[i] = w.feet.mark[i]
    _factorise(w, n_c)
    return abs(room_left(w, n_c)) < np.inf


@compiled
def _scale_of_time(w: LoopArrays, n_x: int, n_c: int) -> float:
    """Return the time in which a term of the series of a guard alone would use up a bound."""
    time = natural_time(w)
    for i in range(n_c):
        if _is_first(w, i) and w.contacts.partner[i] >= 0:
            for k in range(1, w.c.shape[1]):
                term = abs(w.c[n_x + backward(i), k])
                if term > 0.0:
                    time = min(time, (w.planes.bound[i] ** 2 / term) ** (1.0 / k))
    return time


@compiled
def carry(w: LoopArrays, n_c: int) -> bool:
    """Mark contacts in the plane that stick beyond the basis as given their force; return whether there are any."""
    found = False
    for i in range(n_c):
        if w.m[i] == FOLLOWS and w.contacts.partner[i] >= 0:
            w.m[i], found = AT_BOUND, True
    return found
