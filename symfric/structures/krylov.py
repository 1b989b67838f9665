"""Eigenvalues of largest magnitude of an operator, by Arnoldi's method with blocks.

The space ``[V, op V, op^2 V, ...]`` of a block V of random vectors is kept orthonormal, and the eigenvalues of the
operator within it are taken until they have converged (Saad, Numerical Methods for Large Eigenvalue Problems, 2011,
6.2 and 6.5). Without restarts: for an operator that is the inverse of a pencil near a shift, some multiples of the
number of eigenvalues asked for are enough.
"""

from collections.abc import Callable
from typing import Any

import numpy as np

from symfric.errors import NotFound

_TIGHT = 1e-13  # of an eigenvalue: residual of those found
_STALLED = 1e-8  # residual that is taken if larger spaces do not halve it: rounding of the operator itself
_TWICE = 2  # spaces in a row without a gain after which rounding is taken as reached
_ROUGH = 1e-2  # of the largest one left: residual, and distance from those found
_SEED = 11  # fixed, so that the same structure gives the same modes
_BLOCK = 2  # one vector leads to one copy of a double eigenvalue only (Saad, 6.5)
_TURNS = 6  # most repetitions in the complement of what was found
_SHORT = 40  # dimension of the space in which missing ones are looked for
_MOST = 12  # of the number of eigenvalues wanted: dimension of the space at which the method gives up, beside 120


def largest(operator: Callable[..., Any], n: int, k: int, kind: type) -> tuple[np.ndarray, np.ndarray]:
    """Return the k eigenpairs of largest magnitude, also those that occur more than once.

    What is found is split off, and the method repeated in its complement, until the largest eigenvalue there is smaller
    than those found.

    Parameters
    ----------
    operator : callable
        Takes and returns arrays of shape (n,).
    n, k : int
    kind : type
        float or complex: of what the operator makes of real numbers.

    Returns
    -------
    values : ndarray of complex, shape (k,)
    vectors : ndarray of complex, shape (n, k)

    Raises
    ------
    NotFound
        If the method does not converge.
    """
    draw = np.random.default_rng(_SEED)
    values, vectors = arnoldi(operator, n, k, draw, kind)
    for _ in range(_TURNS):
        basis, size = np.linalg.qr(vectors)[0], np.sort(np.abs(values))[-k]

        def split(x: np.ndarray, basis: np.ndarray = basis) -> Any:
            y = operator(x)
            return y - basis @ (basis.conj().T @ y)

        left = min(2, n - basis.shape[1])
        try:
            rest = arnoldi(split, n, left, draw, complex, _ROUGH, limit=_SHORT)[0] if left else np.zeros(1)
            if np.max(np.abs(rest)) <= size * (1 + _ROUGH):
                break
            more = arnoldi(split, n, left, draw, complex)[1]
        except NotFound:  # what is as large as those found converges as fast as they did
            break
        basis = np.linalg.qr(np.column_stack([basis, more]))[0]
        values, inside = np.linalg.eig(basis.conj().T @ np.column_stack([operator(e) for e in basis.T]))
        vectors = basis @ inside
    order = np.argsort(-np.abs(values), kind="stable")[:k]
    return values[order], vectors[:, order]


def arnoldi(
    operator: Callable[..., Any],
    n: int,
    k: int,
    draw: np.random.Generator,
    kind: type,
    tolerance: float = _TIGHT,
    limit: int = 0,
) -> tuple[np.ndarray, np.ndarray]:
    """Return k eigenpairs of largest magnitude by Arnoldi iteration from random vectors.

    Raises
    ------
    NotFound
        If the residuals, relative to the eigenvalues, are larger than the tolerance in the largest space allowed.
    """
    whole = n - n % _BLOCK
    limit = min(limit or max(120, _MOST * k), whole)
    basis: np.ndarray = np.zeros((n, limit + _BLOCK), kind)
    matrix: np.ndarray = np.zeros((limit + _BLOCK, limit), kind)
    basis[:, :_BLOCK] = np.linalg.qr(draw.standard_normal((n, _BLOCK)))[0]
    check, error = min(max(k + 12, 2 * k), limit), np.inf
    stalled = 0
    for m in range(_BLOCK, limit + 1, _BLOCK):
        now, known = slice(m - _BLOCK, m), basis[:, :m]
        new = np.column_stack([operator(e) for e in basis[:, now].T])
        # the second pass removes what cancellation leaves in the first: twice is enough (Parlett,
        # The Symmetric Eigenvalue Problem, 1998, 6.9)
        for _ in range(2):
            part = known.conj().T @ new
            matrix[:m, now] += part
            new = new - known @ part
        basis[:, m : m + _BLOCK], matrix[m : m + _BLOCK, now] = np.linalg.qr(new)
        if m < check and m < limit:
            continue
        values, inside = np.linalg.eig(matrix[:m, :m])
        order = np.argsort(-np.abs(values), kind="stable")[:k]
        values, inside = values[order], inside[:, order]
        # the residual of a Ritz pair without forming its vector (Saad, 6.2)
        left = np.linalg.norm(matrix[m : m + _BLOCK, now] @ inside[now], axis=0)
        error, before = float(np.max(left / np.abs(values))), error
        stalled = stalled + 1 if error <= _STALLED and error > 0.5 * before else 0
        if error <= tolerance or stalled == _TWICE or m == whole:
            return values, known @ inside
        check = m + max(8, m // 6)
    raise NotFound("the iteration for the modes did not converge; choose `near` closer to them")
