"""Velocities that sticking contacts determine without the forces: their accelerations are those of the constraints.

The sum ``a + M^-1 J^T lambda`` leaves the rounding of forces that cancel, under which a body at rest would creep. Where
the rows of the sticking contacts determine a velocity, its acceleration is that of the drift alone, zero without drift.
A velocity is determined if the constraints leave nothing of it, whatever the velocities; one set of velocities without
any relation between them shows it for all.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import casadi as ca
import numpy as np

from symfric.lower.constraint_forces import DISTINCT, ConstraintBasis, constraint_basis
from symfric.lower.contact_space import ContactSpace

_NEARLY = 1e-6  # relative remainder of a velocity, left by all rows, above which no rows determine it
_GOLDEN = 0.6180339887498949  # fractions of its multiples satisfy no relation with few digits


@dataclass(frozen=True, eq=False)
class HeldVelocities:
    """What the sticking contacts determine.

    Attributes
    ----------
    places : list of int
        Velocities that coupled contacts can determine.
    held : list of SX
        For each of these, whether they do.
    rates : list of SX
        For each, its acceleration if they do.
    """

    places: list[int]
    held: list[ca.SX]
    rates: list[ca.SX]


def held_velocities(
    J: ca.SX, mass: ca.SX, basis: ConstraintBasis, drift: ca.SX, moving: ca.SX, space: ContactSpace | None
) -> HeldVelocities:
    """Return the velocities that sticking contacts determine together; those of one velocity alone are not listed.

    Parameters
    ----------
    J : SX, shape (n_c, n_u)
        Slopes of the slips of the contacts that can stick.
    mass : SX, shape (n_u, n_u)
    basis : ConstraintBasis
        Of the rows of J, or of those in the directions of `space`.
    drift : SX, shape (n_c,)
    moving : SX
        What changes along a run.
    space : ContactSpace, optional
    """
    J = ca.sparsify(J)
    touched = [set(J[i, :].sparsity().get_col()) for i in range(J.rows())]
    places = sorted(set().union(*(e for e in touched if len(e) > 1)))
    if J.is_constant() and places:
        within = _determined_by_all(ca.DM(J).full())
        places = [k for k in places if within[k]]
    if not places:
        return HeldVelocities([], [], [])
    if ca.depends_on(J, moving):
        held = [_all_held(touched, k, basis.own) for k in places]
    else:
        held = _without_remainder(J, mass, basis, places, moving, space)
    if drift.is_zero():
        return HeldVelocities(places, held, [ca.SX(0)] * len(places))
    n = J.columns() if space is None else space.felt.rows()
    gain = basis.forces(ca.SX(n, 1), drift)[1]
    rates = ca.densify(gain[places] if space is None else space.response[places, :] @ gain)
    return HeldVelocities(places, held, ca.vertsplit(rates))


def _determined_by_all(J: np.ndarray) -> np.ndarray:
    """Return which velocities all rows together determine, those of nearly dependent rows included."""
    size = np.max(np.abs(J), axis=0)
    scaled = J / np.where(size > 0, size, 1.0)
    _, singular, V = np.linalg.svd(scaled / np.linalg.norm(scaled, axis=1, keepdims=True), full_matrices=False)
    V = V[singular > DISTINCT * singular[0]]
    left = np.eye(J.shape[1]) - V.T @ V
    return np.max(np.abs(left), axis=1) <= _NEARLY


def _without_remainder(
    J: ca.SX, mass: ca.SX, basis: ConstraintBasis, places: list[int], moving: ca.SX, space: ContactSpace | None
) -> list[ca.SX]:
    """Return whether rows that do not move leave nothing of velocities, in units of equal energy if these are known."""
    # what the rows leave of a vector without special relations vanishes only where it does for every vector
    generic = ca.SX(1 + np.arange(1, J.columns() + 1) * _GOLDEN % 1)
    moves = ca.depends_on(mass, moving)  # the same velocities are determined whatever the mass
    units = ca.SX.ones(J.columns()) if moves else 1 / ca.sqrt(ca.diag(ca.densify(mass)))
    if space is None:  # one set of rows, because M^-1 J^T differs from them by rounding where they nearly agree
        scaled = ca.sparsify(J @ ca.diag(units))
        left, size = constraint_basis(scaled, scaled.T, ca.vertcat(*basis.own), tested=False).remainder(generic)
        left, size = left[places], size[places]
    else:
        z, back = units * generic, space.response[places, :]
        felt = space.felt @ z
        inside, sizes = basis.remainder(felt)
        left = z[places] - back @ (felt - inside)
        size = ca.fabs(z[places]) + ca.fabs(back) @ sizes
    return ca.vertsplit(ca.densify(ca.fabs(left) <= DISTINCT * size))


def _all_held(touched: Sequence[set[int]], place: int, own: Sequence[ca.SX]) -> ca.SX:
    """Return whether there are as many constraints as velocities among those connected with one velocity."""
    joined, grown = {place}, True
    while grown:
        wider = joined.union(*(e for e in touched if e & joined))
        joined, grown = wider, wider != joined
    return sum((o for o, e in zip(own, touched, strict=True) if e & joined), ca.SX(0)) == len(joined)
