r"""Branch points: where another branch of periodic orbits crosses the one that is followed.

The equations F(z) = 0 have one unknown more than equations. Along a branch with the tangent t the determinant of
[F_z; t] keeps its sign, also round a fold; it changes where the rank of F_z falls by one and a second branch crosses.
The point is a regular solution of

    F(z) + b w = 0,    w . F_z(z) v_1 = 0,    w . F_z(z) v_2 = 0

for z and b, with the left null vector w and the right ones v of F_z, renewed in every step. A solution with b other
than zero is no branch point: there the branches pass each other without meeting. Source: W. Govaerts, Numerical Methods
for Bifurcations of Dynamical Equilibria (SIAM 2000), chapters 3 and 8.
"""

from dataclasses import replace
from typing import NamedTuple

import numpy as np

from symfric.errors import NotFound
from symfric.orbits.shooting import Point, ShootingSystem, scaled_slopes, solve

KIND = "branch-point"
_STEPS = 12  # most steps of Newton's method
_DIFFERENCE = 1e-4  # finite-difference step in units of the sizes of the unknowns
_STILL = 1e-8  # change of the unknowns in these units that ends Newton's method
_MEETS = 30.0  # largest b of a branch point, in units of the gap between end and start of a periodic orbit
_SINGULAR = 1e-6  # largest singular value of F_z that counts as zero, relative to the largest
_REGULAR = 1e-8  # least singular value of [F_z; t] with a sure sign of the determinant, relative to the largest
_HALF = 1e-6  # difference of states half a period apart, relative to the ranges, up to which they count as the same
_LENGTHS = (1e-2, 3e-3, 3e-2, 1e-3, 1e-4)  # distances of the first orbits of another branch, in units of the sizes


class Kernel(NamedTuple):
    """The two right null vectors and the left one of F_z at a branch point, in units of the sizes.

    Attributes
    ----------
    point : Point
    size : ndarray, shape (n_z,)
    right : ndarray, shape (n_z, 2)
    left : ndarray, shape (n_z - 1,)
    least, next_least : float
        Singular values of F_z that belong to them, and the next one, relative to the largest.
    """

    point: Point
    size: np.ndarray
    right: np.ndarray
    left: np.ndarray
    least: float
    next_least: float


def orientations_differ(one: Point, way: np.ndarray, other: Point, ahead: np.ndarray, size: np.ndarray) -> bool:
    """Whether the determinant of [F_z; t] changes its sign between two orbits with the tangents `way` and `ahead`."""
    both = [np.vstack([_scaled(p, size), t / size]) for p, t in ((one, way), (other, ahead))]
    signs = [float(np.linalg.slogdet(matrix)[0]) for matrix in both]
    return signs[0] * signs[1] < 0 and all(np.linalg.cond(matrix) * _REGULAR < 1 for matrix in both)


def located(system: ShootingSystem, one: Point, other: Point, size: np.ndarray) -> Point | None:
    """Return the branch point between two orbits of a branch, in units `size`; None if none is there."""
    z, reach = 0.5 * (one.z + other.z), np.linalg.norm((other.z - one.z) / size)
    middle, anchor = z, z[: len(system.flow.states)]
    try:
        now = system.at(z, one.phase, anchor)
        for _ in range(_STEPS):
            kernel = _kernel(now, size)
            step, b = _corrected(system, kernel, anchor)
            z = z + size * step
            if np.linalg.norm((z - middle) / size) > reach:
                return None
            now = system.at(z, one.phase, anchor)
            if np.max(np.abs(step)) <= _STILL:
                break
        else:
            return None
    except (NotFound, np.linalg.LinAlgError):
        return None
    kernel = _kernel(now, size)
    meets = abs(b) <= _MEETS * system.flow.closed
    return now if meets and kernel.least <= _SINGULAR < kernel.next_least else None


def doubled(system: ShootingSystem, z: np.ndarray, along: np.ndarray) -> tuple[ShootingSystem, np.ndarray, np.ndarray]:
    """Return equations, unknowns and tangent of a flip over two of its periods, where it is a branch point."""
    if not system.free:
        return replace(system, multiple=2 * system.multiple), z, along
    place = len(system.flow.states)
    twice = np.where(np.arange(z.size) == place, 2.0, 1.0)
    return system, twice * z, twice * along


def halved(system: ShootingSystem, point: Point) -> ShootingSystem | None:
    """Return the equations over half the period if an orbit repeats itself after it, as at a flip; else None."""
    start, period, values = system.unpack(point.z)
    if system.multiple % 2:
        return None
    try:
        half = system.flow.run(start, values, 0.5 * period, system.lift)
    except NotFound:
        return None
    if np.any(np.abs(half.end - start) > _HALF * point.passage.ranges):
        return None
    return replace(system, multiple=system.multiple // 2)


def departures(
    system: ShootingSystem, z: np.ndarray, along: np.ndarray
) -> tuple[Point, list[tuple[Point, np.ndarray]]]:
    """Return the orbit at a branch point, and the first orbits of the other branch on both sides with their tangents.

    Parameters
    ----------
    system : ShootingSystem
    z : ndarray, shape (n_z,)
        The unknowns at the branch point.
    along : ndarray, shape (n_z,)
        Tangent of the known branch.

    Raises
    ------
    NotFound
        If no orbit of another branch is found nearby.

    Notes
    -----
    The tangents of both branches are the directions ``d`` in the null space of F_z with ``w . F_zz d d = 0``.
    """
    anchor = z[: len(system.flow.states)]
    here = system.at(z, None, anchor)
    kernel = _kernel(here, np.maximum(system.sizes(z, here.passage), np.abs(along)))
    known, crossing = _tangents(system, kernel, along / kernel.size, anchor)
    normal = crossing - (crossing @ known) * known
    way, plane, points = kernel.size * crossing, normal / kernel.size, []
    for side in (-1.0, 1.0):
        for length in _LENGTHS:
            guess = z + side * length * way
            try:
                new = solve(system, guess, plane, most=12)
            except NotFound:
                continue
            if np.linalg.norm((new.z - guess) / kernel.size) <= length:
                points.append((new, side * way))
                break
    if not points:
        raise NotFound("no orbit of another branch is found near this point")
    return here, points


def _tangents(
    system: ShootingSystem, kernel: Kernel, along: np.ndarray, anchor: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Return the tangent of the branch that is nearly known, and of the one that crosses it, in units of the sizes."""
    share = kernel.right.T @ along
    share = share / np.linalg.norm(share)
    one, two = kernel.right @ share, kernel.right @ np.array([-share[1], share[0]])
    rows = [_bend(system, kernel, v, anchor) for v in (one, two)]
    a, b, c = float(rows[0] @ one), float(rows[0] @ two), float(rows[1] @ two)
    root = np.sqrt(max(b * b - a * c, 0.0))
    if not root > _REGULAR * max(abs(a), abs(b), abs(c)):
        raise NotFound("no other branch crosses at this point")
    ways = []  # shares x, y of `one` and `two` with a x^2 + 2 b x y + c y^2 = 0
    for sign in (1.0, -1.0):
        x, y = (-b + sign * root, a) if abs(a) >= abs(c) else (c, -b + sign * root)
        ways.append((x * one + y * two) / np.hypot(x, y))
    ways.sort(key=lambda way: -abs(float(way @ one)))
    return ways[0], ways[1]


def _scale(point: Point, size: np.ndarray) -> np.ndarray:
    """Return the scales of the equations: the units of the states, and 1 for the others, (n_e,)."""
    n = point.passage.end.size
    return np.append(size[:n], np.ones(point.rest.size - n))


def _scaled(point: Point, size: np.ndarray) -> np.ndarray:
    return scaled_slopes(point, size, _scale(point, size))


def _kernel(point: Point, size: np.ndarray) -> Kernel:
    left, singular, right = np.linalg.svd(_scaled(point, size))
    share = singular / singular[0]
    next_least = float(share[-2]) if share.size > 1 else 1.0
    return Kernel(point, size, right[-2:].T, left[:, -1], float(share[-1]), next_least)


def _bend(system: ShootingSystem, kernel: Kernel, way: np.ndarray, anchor: np.ndarray) -> np.ndarray:
    """Return the derivative of w F_z along a direction, (n_z,), by a central difference, in units of the sizes."""
    point, size = kernel.point, kernel.size
    ends = (system.at(point.z + s * _DIFFERENCE * size * way, point.phase, anchor) for s in (1, -1))
    ahead, behind = (_scaled(p, size) for p in ends)
    return np.asarray(kernel.left @ (ahead - behind) / (2 * _DIFFERENCE))


def _corrected(system: ShootingSystem, kernel: Kernel, anchor: np.ndarray) -> tuple[np.ndarray, float]:
    """Return a step of Newton's method to a branch point in units of the sizes, and b."""
    A, scale = _scaled(kernel.point, kernel.size), _scale(kernel.point, kernel.size)
    bends = np.array([_bend(system, kernel, v, anchor) for v in kernel.right.T])
    matrix = np.block([[A, kernel.left[:, None]], [bends, np.zeros((2, 1))]])
    rest = np.concatenate([kernel.point.rest / scale, kernel.left @ A @ kernel.right])
    step = np.linalg.solve(matrix, -rest)
    return step[:-1], float(step[-1])
