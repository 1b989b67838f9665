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

from symfric.codegen.numba_types import compiled
from symfric.solve.loop.modes.feet_forces import AGREES, room_left
from symfric.solve.loop.modes.feet_problem import minimise, polish
from symfric.solve.loop.modes.feet_slips import aim, factorise, is_first, slip_of, take_all
from symfric.solve.loop.precision import ROUNDING
from symfric.solve.loop.workspace import LoopArrays

_NARROW, _NARROWEST = 1e-2, 1e-10  # widths over which friction rises in smooth problems, as part of the acceleration
_NARROWER = 0.1  # from one of these problems to the next
_SLIPS = 30.0  # acceleration over that width from which on a contact slips
_SLOW = 1e-6  # acceleration, as part of that without forces, below which a contact at the limit has none


@compiled
def accelerate(w: LoopArrays, n_c: int) -> bool:
    """Compute accelerations of contacts at rest, and forces of those that slip, with the bounds in ``w.planes.bound``.

    Friction that rises over a small width tells which contacts slip, Newton's method with these the accelerations. The
    problem is convex: forces that fit are the solution, whatever the width.
    """
    f, p = w.feet, w.planes
    take_all(w, n_c)
    if room_left(w, n_c) >= -AGREES:
        for i in range(n_c):
            if f.among[i]:
                p.gain[i], p.force[i] = 0.0, f.hold[i]
        return True
    size, width = aim(w, n_c), 1.0
    for k in range(f.rank[0]):
        f.point[0, k] = f.target[k]
    while width >= _NARROWEST:
        for i in range(n_c):
            f.sticks[i] = 0
        if not minimise(w, n_c, 0.0, width * size, 0, np.inf):
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
    for i in range(n_c):
        if is_first(w, i):
            j = w.contacts.partner[i]
            moved = np.hypot(slip_of(w, i, 0), slip_of(w, j, 0) if j >= 0 else 0.0)
            tied = w.planes.leaves[i] != 0 and w.planes.bound[i] >= w.planes.static[i] * (1.0 - ROUNDING)
            w.feet.sticks[i] = moved <= max(least, _SLOW * w.feet.scale[0] if tied else 0.0) * w.feet.size[i]
            if j >= 0:
                w.feet.sticks[j] = w.feet.sticks[i]


@compiled
def _is_solution(w: LoopArrays, n_c: int) -> bool:
    """Whether the contacts that are told to stick do, and the others slip; computes their accelerations and forces."""
    f, p = w.feet, w.planes
    if not polish(w, n_c):
        return False
    for k in range(f.rank[0]):
        f.slope[k] = f.target[k]
    for i in range(n_c):
        if f.among[i]:
            p.gain[i], p.force[i] = 0.0 if f.sticks[i] else slip_of(w, i, 0), f.hold[i]
    for i in range(n_c):
        if not is_first(w, i) or f.sticks[i]:
            continue
        j = w.contacts.partner[i]
        moved = np.hypot(p.gain[i], p.gain[j] if j >= 0 else 0.0)
        if not moved > AGREES * f.scale[0] * f.size[i]:
            return False
        p.force[i] = -p.bound[i] * p.gain[i] / moved
        if j >= 0:
            p.force[j] = -p.bound[i] * p.gain[j] / moved
        for k in range(f.rank[0]):
            f.slope[k] += f.factor[i, k] * p.force[i] + (f.factor[j, k] * p.force[j] if j >= 0 else 0.0)
    for i in range(n_c):
        f.before[i] = p.free[i]
        if f.among[i]:
            p.free[i], f.among[i] = f.offset[i], f.sticks[i]
            for k in range(f.rank[0]):
                p.free[i] += f.factor[i, k] * f.slope[k]
    held = factorise(w, n_c) == 0 or room_left(w, n_c) >= -AGREES
    for i in range(n_c):
        if f.among[i]:
            p.force[i] = f.hold[i]
    for i in range(n_c):
        p.free[i] = f.before[i]
    take_all(w, n_c)
    aim(w, n_c)
    return held
