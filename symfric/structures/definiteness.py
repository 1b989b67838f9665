"""Stability of a structure by the definiteness of its matrices, without eigenvalues of the damped system.

For a motion ``phi e^(lambda t)`` with ``phi^* M phi = 1`` the numbers ``c, k`` (real, of the symmetric parts of C and
A = K + mu F) and ``g, n`` (of their skew parts) satisfy ``lambda^2 + (c + i g) lambda + k + i n = 0``. Both roots decay
if and only if ``c > 0`` and ``c^2 k + c g n - n^2 > 0`` (Routh and Hurwitz for complex coefficients). With a symmetric
C it is enough that ``c_min^2 k_min > n_max^2``.
"""

from typing import NamedTuple

import numpy as np
import scipy.linalg as sla
import scipy.sparse as sps
import scipy.sparse.linalg as spla

from symfric.structures.complex_modes import Pencil
from symfric.structures.factors import definite

_DENSE = 60  # degrees of freedom up to which all eigenvalues are computed
_ITERATED = 1e-8  # relative error of an iterated eigenvalue, taken off on the side on which the proof stays valid
_SYMMETRIC = 1e-14  # relative size of a skew part that is rounding of the assembly


class Verdict(NamedTuple):
    """Stability as the definiteness of symmetric parts proves it.

    Attributes
    ----------
    definiteness : {"stable", "unstable", "undecided"}
    reason : str
    """

    definiteness: str
    reason: str


def verdict_of(pencil: Pencil) -> Verdict:
    """Judge a structure by sparse factors of the symmetric parts of its matrices."""
    skew = sps.csr_array(0.5 * (pencil.A - pencil.A.T))
    circulatory = abs(skew).max() > _SYMMETRIC * abs(pencil.A).max()
    stiff = definite(pencil.A)
    damped = None if pencil.C is None else definite(pencil.C)
    if not circulatory and stiff:
        if damped:
            return Verdict("stable", "symmetric stiffness and damping are positive definite (Kelvin, Tait, Chetaev)")
        if pencil.C is None:
            return Verdict(
                "undecided", "positive definite stiffness without damping: the motion stays, but does not decay"
            )
        return Verdict("undecided", "the symmetric part of C is not positive definite")
    if not circulatory and stiff is False and damped:
        return Verdict("unstable", "the stiffness has a negative eigenvalue, and the damping is complete (Chetaev)")
    if not (stiff and damped):
        return Verdict("undecided", "the symmetric parts of K + mu F and C are not both positive definite")
    assert pencil.C is not None  # it is definite
    turning = pencil.C - pencil.C.T
    if turning.nnz and abs(turning).max() > _SYMMETRIC * abs(pencil.C).max():
        return Verdict("undecided", "C has a gyroscopic part beside the circulatory forces")
    c, k = (_least(0.5 * (part + part.T), pencil.M) for part in (pencil.C, pencil.A))
    n = _largest_skew(skew, pencil.M)
    if c * c * k > n * n:
        return Verdict("stable", f"damping outweighs the circulatory forces: {c:.3g}^2 {k:.3g} > {n:.3g}^2")
    return Verdict("undecided", f"damping does not outweigh the circulatory forces: {c:.3g}^2 {k:.3g} < {n:.3g}^2")


def _least(A: sps.csr_array, M: sps.csr_array) -> float:
    """Return the least eigenvalue of a positive definite matrix over the mass, a little less if it is iterated."""
    if A.shape[0] <= _DENSE:
        return float(sla.eigh(A.toarray(), M.toarray(), eigvals_only=True)[0])
    (value,) = spla.eigsh(sps.csc_matrix(A), 1, sps.csc_matrix(M), sigma=0.0, return_eigenvectors=False)
    # a proof needs a lower bound, and a Ritz value of a definite matrix never lies below the least eigenvalue
    return float(value) * (1 - _ITERATED)


def _largest_skew(N: sps.csr_array, M: sps.csr_array) -> float:
    """Return the largest magnitude of ``phi^* N phi`` over ``phi^* M phi``: the square root of an eigenvalue."""
    if N.shape[0] <= _DENSE:
        return float(np.max(np.abs(sla.eigh(1j * N.toarray(), M.toarray(), eigvals_only=True))))
    factors = spla.splu(sps.csc_matrix(M))
    square = spla.LinearOperator(N.shape, lambda x: N.T @ factors.solve(N @ x.ravel()), dtype=float)
    (value,) = spla.eigsh(square, 1, sps.csc_matrix(M), Minv=spla.LinearOperator(N.shape, factors.solve, dtype=float),
                          return_eigenvectors=False)  # fmt: skip
    # a proof needs an upper bound, and a Ritz value never lies above the largest eigenvalue
    return float(np.sqrt(max(value, 0.0))) * (1 + _ITERATED)
