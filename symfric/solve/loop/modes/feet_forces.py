"""Forces that hold contacts at rest, how far they are inside the limit surface, and what the mode is told of them.

See `symfric.solve.loop.modes.feet`.
"""

import numpy as np

from symfric.codegen.numba_types import compiled
from symfric.lower.constraint_forces import AT_BOUND, FOLLOWS
from symfric.solve.loop.arithmetic import value
from symfric.solve.loop.modes.closed_gaps import measure_held, static_bound
from symfric.solve.loop.modes.feet_problem import minimise, solve_step
from symfric.solve.loop.modes.feet_slips import (
    aim,
    factorise,
    held_directions,
    is_active,
    is_first,
    largest_slip,
    leave_free,
    move_apart,
    slip_of,
    take_all,
)
from symfric.solve.loop.modes.layout import backward
from symfric.solve.loop.modes.tolerances import natural_time
from symfric.solve.loop.stepping.calls import expand, prelude, probe
from symfric.solve.loop.workspace import LoopArrays

_LAST_ROOM = 2e-13  # part of the limit surface by which forces must be inside for the contacts to hold on
_AT_LIMIT = 1e-6  # distance of a force from its bound, relative, that is one at the end of the sticking
AGREES = 1e-9  # error of forces and accelerations, relative, of a solution
_FAR = 1e5  # virtual slip, relative, from which on contacts that would not slip are left out
_INSIDE = 1e-3  # of these the least distance of a force from its bound, relative
_TAKES = 1e-5  # distance of a force from its bound, relative, far larger than the rounding that it takes
_FARTHEST = 1e14  # virtual slip, relative, beyond which forces are on the limit surface
_INSTANT = 1e-6  # part of the scale of time over which rates are differences
_VANISHES = 1e-6  # bound, relative to the largest, of a contact that is about to open


@compiled
def room_left(w: LoopArrays, n_c: int) -> float:
    """Compute the forces that hold the contacts in ``w.feet.hold``; return how far they are inside the limit surface.

    The answer is relative, negative if there are no such forces. Near the limit contacts that would not slip there,
    such as a foot about which a body turns, are left out: their forces follow from those of the others, and the virtual
    slip, which is large, leaves them at rest. One whose force is beyond its bound then slips after all.
    """
    f = w.feet
    aim(w, n_c)
    if move_apart(w, n_c):
        return -1.0
    for i in range(n_c):
        f.yields[i] = 0
    for _ in range(n_c + 1):
        for k in range(f.rank[0]):
            f.point[0, k] = 0.0
        for i in range(n_c):
            f.sticks[i] = 0
        minimise(w, n_c, 1.0, 1.0, 0, _FAR)
        _compute_forces(w, n_c)
        if not largest_slip(w, n_c) > _FAR:
            break
        held = _leave_out(w, n_c)
        minimise(w, n_c, 1.0, 1.0, held, _FARTHEST)
        _compute_forces(w, n_c)
        if held > 0:
            _complete_forces(w, n_c, held)
        if not _one_yields(w, n_c):
            _balance(w, n_c)
            break
    reach, pushed = 0.0, 0.0
    for i in range(n_c):
        if is_active(w, i):
            j = w.contacts.partner[i]
            reach += w.planes.bound[i] * np.hypot(slip_of(w, i, 0), slip_of(w, j, 0) if j >= 0 else 0.0)
    for k in range(f.rank[0]):
        pushed += f.target[k] * f.point[0, k]
    return 1.0 - pushed / reach if reach > 0.0 else (1.0 if pushed == 0.0 else -1.0)


@compiled(inline=True)
def _size_of_force(w: LoopArrays, i: int) -> float:
    """Return the magnitude of the force of a contact."""
    j = w.contacts.partner[i]
    return abs(w.feet.hold[i]) if j < 0 else float(np.hypot(w.feet.hold[i], w.feet.hold[j]))


@compiled
def _leave_out(w: LoopArrays, n_c: int) -> int:
    """Leave out the contacts that would not slip at the limit; return how many directions they hold."""
    f = w.feet
    for i in range(n_c):
        if is_first(w, i):
            j = w.contacts.partner[i]
            f.sticks[i] = f.yields[i] == 0 and _size_of_force(w, i) < w.planes.bound[i] * (1.0 - _INSIDE)
            if j >= 0:
                f.sticks[j] = f.sticks[i]
    held = held_directions(w, n_c)
    if held == f.rank[0]:
        for i in range(n_c):
            f.sticks[i] = 0
        held = 0
    leave_free(w, f.point[0], held)
    return held


@compiled
def _one_yields(w: LoopArrays, n_c: int) -> bool:
    """Mark contacts that were left out although they are on their bounds; return whether there are any."""
    found = False
    for i in range(n_c):
        if is_first(w, i) and w.feet.sticks[i]:
            w.feet.yields[i] = not _size_of_force(w, i) < w.planes.bound[i] * (1.0 - 0.5 * _INSIDE)
            found = found or w.feet.yields[i] != 0
    return found


@compiled
def _balance(w: LoopArrays, n_c: int) -> None:
    """Let the contacts inside their bounds take the rounding of the large virtual slip, which is in their forces."""
    f = w.feet
    for i in range(n_c):
        f.yields[i] = f.sticks[i]
    for i in range(n_c):
        if is_first(w, i):
            j = w.contacts.partner[i]
            f.sticks[i] = _size_of_force(w, i) < w.planes.bound[i] * (1.0 - _TAKES)
            if j >= 0:
                f.sticks[j] = f.sticks[i]
    held = held_directions(w, n_c)
    if held > 0:
        _complete_forces(w, n_c, held)
    for i in range(n_c):
        f.sticks[i] = f.yields[i]


@compiled
def _compute_forces(w: LoopArrays, n_c: int) -> None:
    """Compute the forces of active contacts from the virtual slip; zero for those without a bound."""
    f = w.feet
    for i in range(n_c):
        if not is_first(w, i) or f.sticks[i]:
            continue
        j = w.contacts.partner[i]
        x, y = slip_of(w, i, 0), (slip_of(w, j, 0) if j >= 0 else 0.0)
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
    leave_free(w, f.step, held)
    for k in range(n):
        f.slope[k] -= f.step[k]
    size = 0.0  # of the free directions as of the held ones, whatever the unit of force
    for k in range(n):
        size += f.matrix[k, k]
    for c in range(n):
        for k in range(n):
            free = size if k == c else 0.0
            for h in range(held):
                free -= size * f.kept[h, k] * f.kept[h, c]
            f.matrix[k, c] += free
    solve_step(w)
    for i in range(n_c):
        if f.among[i] and f.sticks[i]:
            for k in range(n):
                f.hold[i] += f.factor[i, k] * f.step[k]


@compiled
def leave_at_limit(w: LoopArrays, n_c: int) -> bool:
    """Mark the contacts that start at the end of a common sticking as leaving; return whether it is there.

    It is there, too, if forces that were told at this very instant reach a bound at once: so near the limit nothing but
    the rounding of time tells its place.
    """
    for i in range(n_c):
        w.planes.bound[i] = w.planes.static[i]
    take_all(w, n_c)
    room = room_left(w, n_c)
    if not -AGREES <= room <= (AGREES if w.counts.stall > 0 else _LAST_ROOM):
        return False
    for i in range(n_c):
        if is_first(w, i):
            w.planes.leaves[i] = _size_of_force(w, i) >= w.planes.bound[i] * (1.0 - _AT_LIMIT)
    _tell_limit(w, n_c)
    return True


@compiled
def forget_limit(w: LoopArrays) -> None:
    """Forget the last end of a common sticking."""
    for i in range(w.feet.limit.size):
        w.feet.limit[i] = 0.0


@compiled
def rate_of_start(w: LoopArrays, n_x: int, n_c: int) -> float:
    """Return the rate at which contacts that give way together accelerate, along the slips of their motion.

    Of any single one ``w.probe`` does not tell it: the directions of all turn, but give no force along this motion. One
    about which a body turns sticks: it has no slip, and its guard is that of its force.
    """
    total = 0.0
    for i in range(n_c):
        if w.m[i] <= 0.5:
            total += w.feet.limit[i] * w.probe[n_x + backward(i), 2]
    return total


@compiled
def gives_way(w: LoopArrays, n_c: int, i: int) -> bool:
    """Whether contact i starts at the end of a common sticking."""
    j = w.contacts.partner[i]
    if w.feet.limit.size == 0:
        return False
    return w.feet.limit[n_c + i] != 0.0 or (j >= 0 and w.feet.limit[n_c + j] != 0.0)


@compiled
def _tell_limit(w: LoopArrays, n_c: int) -> None:
    """Tell the motion in which contacts give way at the end of a common sticking, and their forces.

    The motion is scaled such that the largest forces do the work 1.
    """
    f, reach = w.feet, 0.0
    for i in range(n_c):
        if is_first(w, i):
            j = w.contacts.partner[i]
            reach += w.planes.bound[i] * np.hypot(slip_of(w, i, 0), slip_of(w, j, 0) if j >= 0 else 0.0)
    for i in range(3 * n_c):
        f.limit[i] = 0.0
    for k in range(f.rank[0] - 1, -1, -1):
        rest = f.point[0, k]
        for n in range(k + 1, f.rank[0]):
            rest -= f.factor[f.pivot[n], k] * f.limit[f.pivot[n]]
        f.limit[f.pivot[k]] = rest / f.factor[f.pivot[k], k]
    for i in range(n_c):
        f.limit[i] /= reach
        first = i - 1 if 0 <= w.contacts.partner[i] < i else i
        at_bound = f.among[i] != 0 and w.planes.leaves[first] != 0 and w.planes.bound[i] > 0.0
        if at_bound:
            f.limit[n_c + i] = f.hold[i] / w.planes.bound[i]
        elif f.among[i]:
            f.limit[2 * n_c + i] = f.hold[i]


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
        measure_held(w, n_c)
        finite = _hold_now(w, n_x, n_c)
    for r in range(n_t):
        w.y[r] = w.feet.entry_y[r]
    measure_held(w, n_c)
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
    for i in range(n_c):
        if w.feet.among[i]:
            w.m[i] = FOLLOWS
    prelude(w)
    probe(w)
    for i in range(n_c):
        if w.feet.among[i]:
            w.planes.free[i], w.m[i] = w.probe[n_x + backward(i), 1], w.feet.mark[i]
    if w.openings.variable.size:  # which press as all stick
        prelude(w)
        probe(w)
    for i in range(n_c):
        if w.feet.among[i]:
            w.planes.bound[i] = static_bound(w, n_x, i)
    factorise(w, n_c)
    return abs(room_left(w, n_c)) < np.inf


@compiled
def _scale_of_time(w: LoopArrays, n_x: int, n_c: int) -> float:
    """Return the time in which a term of the series of a guard alone would use up a bound; not one that vanishes."""
    time, largest = natural_time(w), 0.0
    for i in range(n_c):
        if is_first(w, i):
            largest = max(largest, w.planes.bound[i])
    for i in range(n_c):
        if is_first(w, i) and w.contacts.partner[i] >= 0 and w.planes.bound[i] > _VANISHES * largest:
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
