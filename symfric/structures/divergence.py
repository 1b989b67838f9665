"""Where a structure diverges: the zeros of the determinant of ``K + mu F``.

At a point mu_0 of the range they are ``mu_0 - 1/nu`` for the real eigenvalues nu of ``(K + mu_0 F)^-1 F``. Those that
are not zero are eigenvalues of the block over the rows in which F has entries, a small matrix where friction acts at
few places. Motions without any stiffness are held by rows and columns at random; what depends on these is no zero.

With null vectors ``A x = 0``, ``y^T A = 0`` of ``A = K + mu F`` the eigenvalue near zero obeys
``lambda y^T C x + lambda^2 (y^T M x - y^T C A^+ C x) + (mu - mu_0) y^T F x = 0``.
"""

from typing import Any, NamedTuple

import numpy as np
import scipy.sparse as sps
import scipy.sparse.linalg as spla

from symfric.errors import NotFound
from symfric.structures.krylov import largest
from symfric.structures.structure import Structure

_ROWS = 800  # of friction, up to which its whole block is formed
_DENSE = 300  # degrees of freedom up to which a generic rank is computed
_PLACES = (0.381966, 0.723607, 0.127322)  # of the range: where the matrix is factorised
_SINGULAR = 1e-13  # of the largest singular value
_REAL = 1e-9  # of an eigenvalue: imaginary part of a real one
_SAME = 1e-7  # of the range: difference of a zero between two computations
_TOUCH = 1e-11  # of the sum of the magnitudes of its terms: a product that is zero
_SEED = 7
_FIRST, _LARGEST = 12, 96  # eigenvalues that the iteration computes


class Divergence(NamedTuple):
    """A real eigenvalue that passes zero.

    Attributes
    ----------
    mu : float
    begins : bool
        Whether it becomes positive.
    shape : ndarray, shape (n,)
        Real, of length 1.
    """

    mu: float
    begins: bool
    shape: np.ndarray


def divergences(structure: Structure, low: float, high: float) -> list[Divergence]:
    """Return where real eigenvalues pass zero for mu in a range, its ends included.

    Raises
    ------
    NotFound
        If the iteration for a large structure with friction in many rows does not converge.
    """
    scale = 1 / np.sqrt(structure.M.diagonal())
    K, F = (sps.csc_matrix(sps.diags_array(scale) @ e @ sps.diags_array(scale))
            for e in (structure.K, structure.friction))  # fmt: skip
    free = _free(K, F, low + _PLACES[0] * (high - low))
    draw = np.random.default_rng(_SEED)
    size = abs(K).max() or abs(F).max() * max(abs(low), abs(high))
    runs = [_zeros(*_held(K, F, free, size, draw), low, high) for _ in range(2 if free else 1)]
    width, passages = _SAME * (high - low), []
    for mu in runs[0]:
        if all(np.min(np.abs(other - mu), initial=np.inf) <= width for other in runs[1:]):
            held_K, held_F = _held(K, F, free, size, draw)
            passages.append(_passage(structure, held_K + mu * held_F, mu, scale))
    return sorted((e for e in passages if e is not None), key=lambda e: e.mu)


def _free(K: sps.csr_array, F: sps.csr_array, mu: float) -> int:
    """Return the number of motions without stiffness for any mu."""
    if K.shape[0] > _DENSE:
        return 0
    values = np.linalg.svd((K + mu * F).toarray(), compute_uv=False)
    return int(np.sum(values <= _SINGULAR * values[0]))


def _held(
    K: sps.csr_array, F: sps.csr_array, free: int, size: float, draw: Any
) -> tuple[sps.csc_matrix, sps.csc_matrix]:
    """Return the matrices bordered by a random row and column for each motion without stiffness."""
    if not free:
        return K, F
    n = K.shape[0]
    rows, columns = size * draw.standard_normal((free, n)), size * draw.standard_normal((n, free))
    return (sps.csc_matrix(sps.block_array([[K, columns], [rows, None]])),
            sps.csc_matrix(sps.block_diag([F, sps.csc_matrix((free, free))])))  # fmt: skip


def _zeros(K: sps.csr_array, F: sps.csr_array, low: float, high: float) -> np.ndarray:
    """Return the zeros of the determinant in a range, increasing."""
    at, solve = _factorised(K, F, low, high)
    if solve is None:
        return np.zeros(0)
    rows = np.unique(F.tocoo().row)
    if rows.size <= _ROWS:
        unit = np.zeros((K.shape[0], rows.size))
        unit[rows, np.arange(rows.size)] = 1.0
        nu = np.linalg.eigvals(sps.csr_array(F)[rows] @ solve(unit))
    else:
        nu = _iterated(F, solve, max(high - at, at - low))
    nu = nu[np.abs(nu) * 2 * (high - low) >= 1]
    mu = np.sort((at - 1 / nu[np.abs(nu.imag) <= _REAL * np.abs(nu)]).real)
    slack = 1e-12 * (high - low)
    return np.asarray(np.clip(mu[(mu >= low - slack) & (mu <= high + slack)], low, high))


def _factorised(K: sps.csr_array, F: sps.csr_array, low: float, high: float) -> Any:
    for place in _PLACES:
        at = low + place * (high - low)
        try:
            factors = spla.splu(sps.csc_matrix(K + at * F))
        except RuntimeError:
            continue
        pivots = np.abs(factors.U.diagonal())
        if np.min(pivots) > 1e-14 * np.max(pivots):
            return at, factors.solve
    return low, None


def _iterated(F: sps.csr_array, solve: Any, half: float) -> np.ndarray:
    """Return the eigenvalues of the inverse that belong to the range."""
    n, k = F.shape[0], _FIRST

    def operator(x: np.ndarray) -> np.ndarray:
        y = F @ x
        return np.asarray(solve(y.real) + 1j * solve(y.imag) if np.iscomplexobj(y) else solve(y))

    while True:
        values = largest(operator, n, min(k, n - 2), float)[0]
        if np.min(np.abs(values)) * half < 1 or k >= n - 2:
            return values
        if k >= _LARGEST:
            raise NotFound(f"more than {k} loads of divergence; give a narrower range of mu")
        k *= 2


def _passage(s: Structure, A: sps.csr_array, mu: float, scale: np.ndarray) -> Divergence | None:
    """Return the direction in which an eigenvalue passes zero, and its shape; None where it only touches."""
    whole = [_null(e) for e in (A, A.T)]
    right, left = (scale * e[: s.n] for e in whole)
    assert s.friction is not None
    push = left @ (s.friction @ right)
    if abs(push) <= _TOUCH * (np.abs(left) @ (abs(s.friction) @ np.abs(right))):
        return None
    resist = left @ (s.M @ right)
    if s.C is not None:
        damping = left @ (s.C @ right)
        if abs(damping) > _TOUCH * (np.abs(left) @ (abs(s.C) @ np.abs(right))):
            resist = damping
        else:
            turned = np.zeros(A.shape[0] + 1)
            turned[: s.n] = scale * (s.C @ right)
            bordered = sps.block_array([[A, whole[1][:, None]], [whole[0][None, :], None]])
            follows = scale * spla.splu(sps.csc_matrix(bordered)).solve(turned)[: s.n]
            resist -= left @ (s.C @ follows)
    return Divergence(float(mu), bool(push * resist < 0), right / np.linalg.norm(right))


def _null(A: sps.csr_array) -> np.ndarray:
    """Return the vector that a singular matrix takes to zero, of length 1."""
    n = A.shape[0]
    if n <= _DENSE:
        return np.asarray(np.linalg.svd(A.toarray())[2][-1])
    size = abs(A).max()
    factors = spla.splu(sps.csc_matrix(A + 1e-14 * size * sps.eye_array(n)))
    x = np.random.default_rng(_SEED).standard_normal(n)
    for _ in range(3):
        x = factors.solve(x / np.linalg.norm(x))
    return np.asarray(x / np.linalg.norm(x))
