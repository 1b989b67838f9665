"""Sparse factors of symmetric matrices: solving, definiteness, and the number of eigenvalues below a shift.

A symmetric matrix factorised without interchange of rows, ``P A P^T = L U``, has ``U = D L^T``: by Sylvester's law of
inertia the signs of the pivots D are those of its eigenvalues (Golub and Van Loan, Matrix Computations, 8.1.5). SuperLU
takes the pivots from the diagonal unless one of them is zero.
"""

import warnings

import numpy as np
import scipy.sparse as sps
import scipy.sparse.linalg as spla

_GROWTH = 1e8  # of the entries over those of the matrix: with more the signs of the pivots prove nothing
_RELATIVE = 1e-13  # of the diagonal: a pivot as small as this is zero to rounding


def factorised(A: sps.csr_array) -> spla.SuperLU | None:
    """Return factors of a symmetric matrix with its pivots on the diagonal; None if it is singular."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        try:
            return spla.splu(
                sps.csc_matrix(A), permc_spec="MMD_AT_PLUS_A", diag_pivot_thresh=0.0, options={"SymmetricMode": True}
            )
        except RuntimeError:
            return None


def negative_pivots(A: sps.csr_array) -> int | None:
    """Return the number of negative eigenvalues of a symmetric matrix; None if the factors do not prove it."""
    factors = factorised(A)
    if factors is None or np.any(factors.perm_r != factors.perm_c):
        return None
    pivots, largest = factors.U.diagonal(), abs(A).max()
    if np.max(np.abs(factors.U.data)) > _GROWTH * largest or np.min(np.abs(pivots)) <= _RELATIVE * largest * 1e-3:
        return None
    return int(np.sum(pivots < 0))


def indefinite_at(A: sps.csr_array) -> int | None:
    """Return the row of a pivot that is not positive; None if a symmetric matrix is positive definite.

    The pivots are compared with rounding after a scaling of rows and columns that makes the diagonal 1.
    """
    scale = 1 / np.sqrt(A.diagonal())
    scaled = sps.diags_array(scale) @ A @ sps.diags_array(scale)
    factors = factorised(scaled)
    if factors is None:
        return int(np.argmax(abs(scaled - sps.eye_array(A.shape[0])).sum(axis=1)))
    place = np.empty(A.shape[0], dtype=int)
    place[factors.perm_c] = np.arange(A.shape[0])
    pivots = factors.U.diagonal()
    bad = np.flatnonzero(pivots <= _RELATIVE)
    if np.any(factors.perm_r != factors.perm_c) and not bad.size:
        bad = np.flatnonzero(factors.perm_r != factors.perm_c)[:1]
    return int(place[bad[0]]) if bad.size else None


def definite(A: sps.csr_array) -> bool | None:
    """Return whether the symmetric part of a matrix is positive definite; None where rounding hides it."""
    symmetric = sps.csr_array(0.5 * (A + A.T))
    if np.min(symmetric.diagonal()) <= 0:
        return False
    if indefinite_at(symmetric) is None:
        return True
    negative = negative_pivots(symmetric)
    return False if negative else None
