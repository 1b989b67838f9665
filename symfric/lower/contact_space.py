"""Sticking decided in as many directions as there are contacts, whatever the number of coordinates.

With a constant mass ``M = L L^T`` and constant slip rows J the directions are those of a factorisation ``(L^-1 J^T) =
Q R`` with orthonormal columns Q: a motion of the structure is felt by the contacts through ``b = Q^T L^T u`` alone,
``J u = R^T b``, and unit forces of the contacts cause the accelerations ``M^-1 J^T = P R`` with ``P = L^-T Q``. The
equations of the sticking contacts are those of `symfric.lower.constraint_forces` with R^T for J and R for M^-1 J^T;
what costs a product with every coordinate is only ``Q^T L^T u'`` before and P behind.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import casadi as ca
import numpy as np

from symfric.lower.constraint_forces import ConstraintBasis, constraint_basis

_NOTHING = 1e-15  # of the largest entry of a row: what rounding leaves of a zero


@dataclass(frozen=True, eq=False)
class ContactSpace:
    """Numbers that lead from the coordinates to the contacts and back.

    Attributes
    ----------
    felt : DM, shape (r, n)
        ``Q^T L^T``.
    factor : DM, shape (r, n_c)
        R.
    response : DM, shape (n, r)
        P.
    """

    felt: ca.DM
    factor: ca.DM
    response: ca.DM

    def basis(self, sticking: Sequence[int], holds: ca.SX, tested: bool) -> ConstraintBasis:
        """Return the orthogonal rows of the contacts that can stick, in these directions.

        Parameters
        ----------
        sticking : sequence of int
            Contacts that can stick.
        holds, tested
            See `symfric.lower.constraint_forces.constraint_basis`.
        """
        columns = ca.SX(self.factor[:, list(sticking)])
        return constraint_basis(columns.T, columns, holds, tested)


def contact_space(mass: ca.SX, slopes: ca.SX) -> ContactSpace:
    """Return the directions in which contacts with constant slip rows (n_c, n) feel a constant mass (n, n)."""
    M = ca.DM(ca.densify(mass)).full()
    J = ca.DM(ca.densify(slopes)).full()
    if np.count_nonzero(M - np.diag(np.diag(M))) == 0:
        root = np.sqrt(np.diag(M))
        inner, back, forth = J.T / root[:, None], lambda e: e / root[:, None], lambda e: e * root[:, None]
    else:
        L = np.linalg.cholesky(M)
        import scipy.linalg as sla  # slow to import

        inner = sla.solve_triangular(L, J.T, lower=True)
        back, forth = lambda e: sla.solve_triangular(L.T, e), lambda e: L @ e
    Q, R = np.linalg.qr(inner)
    return ContactSpace(_clean(forth(Q).T), _clean(R), _clean(back(Q)))


def _clean(A: np.ndarray) -> ca.DM:
    """Return a matrix without entries that are rounding."""
    size = np.max(np.abs(A), axis=1, keepdims=True, initial=0.0)
    return ca.sparsify(ca.DM(np.where(np.abs(A) <= _NOTHING * size, 0.0, A)))
