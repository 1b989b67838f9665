"""Starts of feet of one body that slip together without an acceleration: their directions depend on each other.

The slips of several feet of a rigid body, ``w = J u``, have the directions of one motion. With e the unit vectors of
these slips, n those across, and x what the friction ``B e`` gains across by a term of order k of e, the equations of
order k + 1 of `symfric.solve.loop.stepping.release_in_plane` are

    G x + D_1 x = r,   G = n^T A n,   D_j = (k + 1) w_j^T e_0/B,

where ``w_1 = 0`` at the end of a common sticking. A turn of all directions that gives no force, ``G z = 0``, has no
part in them: G has more rows than the body has motions across. It is what the next order needs,

    G x_k + D_2 z_(k-1) = r,

whose parts along the null space of G determine z of the order before; it has no effect on the motion up to there.
"""

import numpy as np

from symfric.codegen.numba_types import compiled
from symfric.lower.planes import STARTS
from symfric.solve.loop.codes import COUPLING
from symfric.solve.loop.modes.layout import backward
from symfric.solve.loop.precision import EPS, TINY
from symfric.solve.loop.stepping.calls import expand, prelude
from symfric.solve.loop.stepping.elimination import solve_in_place
from symfric.solve.loop.workspace import LoopArrays

_NOTHING = 1e-9  # part of the largest coupling below which turns of directions give no force
_PASSES = 3  # solutions of one order: products of lower terms change with them
_SWEEPS = 30  # most rotations of every pair of axes


@compiled
def depend_on_each_other(w: LoopArrays, n_x: int) -> bool:
    """Whether directions of contacts that start can turn without any force; finds the axes of all such turns."""
    if w.feet.axes.size == 0:
        return False
    prelude(w)
    expand(w)
    _couple_forces(w, n_x)
    return _find_axes(w) > 0


@compiled
def turn_feet(w: LoopArrays, n_x: int, order: int) -> None:
    """Compute the terms of this order of all directions, and what it needs of the order before."""
    for _ in range(_PASSES):
        _keep_length(w, order)
        prelude(w)
        expand(w)
        _equate(w, n_x, order)
        _solve(w, n_x, order)
    _keep_length(w, order)


@compiled(inline=True)
def _bound(w: LoopArrays, i: int) -> float:
    """Return the friction of a contact that starts."""
    return float(w.planes.kinetic[i])


@compiled(inline=True)
def _rubs(w: LoopArrays, i: int) -> bool:
    """Whether contact i starts, with friction: without any its direction has no effect."""
    return bool(w.m[i] == STARTS and _bound(w, i) > TINY)


@compiled
def _couple_forces(w: LoopArrays, n_x: int) -> None:
    """Write ``G + D_1/2`` of the contacts that start, from ``w.planes.coupling``; the largest one for the others."""
    n, f, largest = w.planes.row.size, w.feet, _largest_coupling(w)
    for k in range(n):
        i = w.planes.row[k]
        starts = _rubs(w, i)
        for c in range(n):
            j = w.planes.row[c]
            f.turning[k, c] = largest if k == c else 0.0
            if starts:
                f.turning[k, c] = w.planes.coupling[k, c] / _bound(w, j) if _rubs(w, j) else 0.0
        if starts:
            f.turning[k, k] += max(_along(w, n_x, k, 1), 0.0) / _bound(w, i)
    for k in range(n):
        for c in range(k):
            mean = 0.5 * (f.turning[k, c] + f.turning[c, k])
            f.turning[k, c], f.turning[c, k] = mean, mean


@compiled
def _largest_coupling(w: LoopArrays) -> float:
    """Return the largest coupling of a contact that starts with itself; 1 if none does."""
    largest = 0.0
    for k in range(w.planes.row.size):
        i = w.planes.row[k]
        if _rubs(w, i):
            largest = max(largest, w.gauge[COUPLING + i, i], w.gauge[COUPLING + i + 1, i + 1])
    return largest if largest > 0.0 else 1.0


@compiled(inline=True)
def _along(w: LoopArrays, n_x: int, k: int, j: int) -> float:
    """Return the part of w_j along e_0."""
    i = w.planes.row[k]
    v = w.planes.variable[i]
    return float(w.m[v] * w.c[n_x + backward(i), j] + w.m[v + 1] * w.c[n_x + backward(i + 1), j])


@compiled
def _find_axes(w: LoopArrays) -> int:
    """Compute the principal axes of the coupling by Jacobi's rotations; return how many turns give no force."""
    f, n = w.feet, w.planes.row.size
    a, axes = f.turning, f.axes
    for k in range(n):
        for c in range(n):
            axes[k, c] = 1.0 if k == c else 0.0
    for _ in range(_SWEEPS):
        off, size = 0.0, 0.0
        for k in range(n):
            size += a[k, k] ** 2
            for c in range(k):
                off += a[k, c] ** 2
        if off <= EPS * EPS * size:
            break
        for p in range(n):
            for q in range(p + 1, n):
                if a[p, q] != 0.0:
                    _rotate(w, p, q, n)
    largest, count = _largest_coupling(w), 0
    for k in range(n):
        f.weight[k] = a[k, k]
        f.idle[k] = a[k, k] <= _NOTHING * largest
        count += f.idle[k]
    return count


@compiled
def _rotate(w: LoopArrays, p: int, q: int, n: int) -> None:
    """Make entry (p, q) of the coupling zero."""
    a, axes = w.feet.turning, w.feet.axes
    theta = (a[q, q] - a[p, p]) / (2.0 * a[p, q])
    t = (1.0 if theta >= 0.0 else -1.0) / (abs(theta) + np.sqrt(theta * theta + 1.0))
    c = 1.0 / np.sqrt(t * t + 1.0)
    s = t * c
    for k in range(n):
        x, y = a[k, p], a[k, q]
        a[k, p], a[k, q] = c * x - s * y, s * x + c * y
    for k in range(n):
        x, y = a[p, k], a[q, k]
        a[p, k], a[q, k] = c * x - s * y, s * x + c * y
    for k in range(n):
        x, y = axes[k, p], axes[k, q]
        axes[k, p], axes[k, q] = c * x - s * y, s * x + c * y


@compiled
def _keep_length(w: LoopArrays, order: int) -> None:
    """Set the part of e_order along e_0 that keeps the length of e; that across stays."""
    for k in range(w.planes.row.size):
        i = w.planes.row[k]
        if w.m[i] != STARTS:
            continue
        v, total = w.planes.variable[i], 0.0
        for j in range(1, order):
            a, b = v + 2 * j, v + 2 * (order - j)
            total -= 0.5 * (w.m[a] * w.m[b] + w.m[a + 1] * w.m[b + 1])
        p = v + 2 * order
        across = w.m[v] * w.m[p + 1] - w.m[v + 1] * w.m[p]
        w.m[p], w.m[p + 1] = total * w.m[v] - across * w.m[v + 1], total * w.m[v + 1] + across * w.m[v]


@compiled
def _equate(w: LoopArrays, n_x: int, order: int) -> None:
    """Compute what is left of ``(k + 1) e x w`` in the next order."""
    for k in range(w.planes.row.size):
        i = w.planes.row[k]
        w.feet.left[k] = 0.0
        if not _rubs(w, i):
            continue
        a, b, v = n_x + backward(i), n_x + backward(i + 1), w.planes.variable[i]
        for j in range(1, order + 2):
            p = v + 2 * (order + 1 - j)
            w.feet.left[k] += (order + 1) * (w.m[p] * w.c[b, j] - w.m[p + 1] * w.c[a, j])


@compiled
def _solve(w: LoopArrays, n_x: int, order: int) -> None:
    """Solve the equations of this order along the axes, and turn the directions by the solution."""
    f, n = w.feet, w.planes.row.size
    if order > 1:
        _solve_idle(w, n_x, order)
    for k in range(n):
        f.turn[k] = 0.0
    for c in range(n):
        if f.idle[c]:
            continue
        part = 0.0
        for k in range(n):
            part += f.axes[k, c] * f.left[k]
        for k in range(n):
            f.turn[k] += f.axes[k, c] * part / f.weight[c]
    _turn(w, order)


@compiled
def _solve_idle(w: LoopArrays, n_x: int, order: int) -> None:
    """Turn the directions in the order before without a force such that nothing is left along the idle axes."""
    f, n, m = w.feet, w.planes.row.size, 0
    for c in range(n):
        if not f.idle[c]:
            continue
        f.order[m] = c
        m += 1
    for a in range(m):
        total = 0.0
        for k in range(n):
            total += f.axes[k, f.order[a]] * f.left[k]
        f.turning[a, m] = total
        for b in range(m):
            total = 0.0
            for k in range(n):
                if _rubs(w, w.planes.row[k]):
                    stiffness = (order + 1) * _along(w, n_x, k, 2) / _bound(w, w.planes.row[k])
                    total += f.axes[k, f.order[a]] * stiffness * f.axes[k, f.order[b]]
            f.turning[a, b] = total
    solve_in_place(f.turning, m, 1)
    for k in range(n):
        f.turn[k] = 0.0
        for a in range(m):
            f.turn[k] += f.axes[k, f.order[a]] * f.turning[a, m]
        if _rubs(w, w.planes.row[k]):
            f.left[k] -= (order + 1) * _along(w, n_x, k, 2) / _bound(w, w.planes.row[k]) * f.turn[k]
    _turn(w, order - 1)


@compiled
def _turn(w: LoopArrays, order: int) -> None:
    """Add the turns in ``w.feet.turn``, times the friction, to the directions in one order."""
    for k in range(w.planes.row.size):
        i = w.planes.row[k]
        if _rubs(w, i):
            v, turn = w.planes.variable[i], w.feet.turn[k] / _bound(w, i)
            w.m[v + 2 * order] -= turn * w.m[v + 1]
            w.m[v + 2 * order + 1] += turn * w.m[v]
