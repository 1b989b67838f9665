"""Newton's method for the smooth convex problems of contacts at rest, see `symfric.solve.loop.modes.feet`."""

import numpy as np

from symfric.codegen.numba_types import compiled
from symfric.solve.loop.modes.feet_slips import (
    held_directions,
    is_active,
    largest_slip,
    leave_free,
    move_apart,
    put_in_place,
    slip_of,
    stepped,
)
from symfric.solve.loop.precision import EPS, TINY
from symfric.solve.loop.workspace import LoopArrays

_ITERATIONS, _HALVINGS, _LAST_ITERATIONS = 200, 40, 4
_NEAR = 1e-4  # relative change by a step of Newton's method from which on its steps are taken whole
_OVERSHOOT = 0.1  # largest slope behind the lowest point of a step, as part of that before it
_CLOSE = 1e-10  # last step of Newton's method, relative, to a minimum


@compiled
def minimise(w: LoopArrays, n_c: int, soft: float, width: float, held: int, farthest: float) -> bool:
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
        if last >= _LAST_ITERATIONS or largest_slip(w, n_c) > farthest:
            return True
    return True


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
        if is_active(w, i):
            j = w.contacts.partner[i]
            x, y, a, b = slip_of(w, i, 1), 0.0, stepped(w, i), 0.0
            if j >= 0:
                y, b = slip_of(w, j, 1), stepped(w, j)
            least = width * f.size[i]
            total += w.planes.bound[i] * (x * a + y * b) / (soft * least + np.hypot(least, np.hypot(x, y)))
    return total


@compiled
def _changed(w: LoopArrays, n_c: int, width: float) -> float:
    """Return the largest change of a slip by the step, relative to what changes its friction."""
    f, largest = w.feet, 0.0
    for i in range(n_c):
        if is_active(w, i):
            j = w.contacts.partner[i]
            x, y, a, b = slip_of(w, i, 0), 0.0, stepped(w, i), 0.0
            if j >= 0:
                y, b = slip_of(w, j, 0), stepped(w, j)
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
        if not is_active(w, i):
            continue
        j = w.contacts.partner[i]
        x, y = slip_of(w, i, 0), (slip_of(w, j, 0) if j >= 0 else 0.0)
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
def _solve_free_step(w: LoopArrays, held: int) -> float:
    """Compute Newton's step in the directions that are not held; return its decrement."""
    f, n = w.feet, w.feet.rank[0]
    leave_free(w, f.slope, held)
    for k in range(n):  # curvatures among the free directions, their sum in the held ones
        leave_free(w, f.matrix[k], held)
    for c in range(n):
        for h in range(held):
            part = 0.0
            for k in range(n):
                part += f.kept[h, k] * f.matrix[k, c]
            for k in range(n):
                f.matrix[k, c] -= part * f.kept[h, k]
    size = 0.0  # near the limit surface curvatures are tiny, and lost beside numbers of another size
    for k in range(n):
        size += f.matrix[k, k]
    for h in range(held):
        for k in range(n):
            for c in range(n):
                f.matrix[k, c] += size * f.kept[h, k] * f.kept[h, c]
    gained = solve_step(w)
    leave_free(w, f.step, held)
    return gained


@compiled
def solve_step(w: LoopArrays) -> float:
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
def polish(w: LoopArrays, n_c: int) -> bool:
    """Minimise with the slips of contacts that stick held at zero and the others' friction at their bounds.

    Return whether there is a minimum.
    """
    f, n = w.feet, w.feet.rank[0]
    held = held_directions(w, n_c)
    if held < 0:
        return False
    put_in_place(w, held)
    if held == n:
        if not move_apart(w, n_c):
            for i in range(n_c):
                f.sticks[i] = 1
        return True
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
