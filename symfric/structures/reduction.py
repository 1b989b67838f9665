"""Craig-Bampton reduction of a structure: kept rows, and modes with these rows held.

With kept rows ``y = R q`` the degrees of freedom are written as ``q = Psi y + Phi p``: Psi are the static shapes that
give one kept row the value 1 and the others 0 (the constraint modes), Phi the lowest modes with all of them zero (the
fixed-interface modes). This is the method of Craig and Bampton (AIAA Journal 6, 1968, 1313), written with Lagrange
multipliers, so that a row may be any combination of degrees of freedom; with no rows it is modal truncation. The static
response to loads on the kept rows is exact, which is the static correction of what is left out.

What is left out is estimated: for a frequency by the residual of its expanded shape, which the static solution with the
rows held turns into the energy that is missing; the response at the kept rows is compared with that of the full
structure at some frequencies up to half of the lowest one that was left out.
"""

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
import scipy.linalg as sla
import scipy.sparse as sps
import scipy.sparse.linalg as spla

from symfric.errors import NotFound, SceneError
from symfric.model.results import Result
from symfric.structures.checks import positive_count
from symfric.structures.factors import factorised

if TYPE_CHECKING:
    from symfric.structures.structure import Structure

_RANK = 1e-10  # singular value of the rows, each of length one, below which they count as dependent
_SEED = 5  # fixed, so that the same structure gives the same basis
_PARTS = (0.31, 0.62, 0.97)  # of the highest frequency of interest, at which responses are compared


class Reduced(NamedTuple):
    """A basis and what is known of it.

    Attributes
    ----------
    basis : ndarray, shape (n, r + m)
        Columns of Psi, then of Phi.
    cut : float
        Frequency of the lowest mode with fixed rows that was left out, rad/time; infinite if none was.
    """

    basis: np.ndarray
    cut: float


@dataclass(frozen=True, eq=False, repr=False)
class ReductionError(Result):
    """How far a reduced structure is from the full one.

    Attributes
    ----------
    frequency : ndarray, shape (k,)
        Of the reduced structure, rad/time, increasing: those up to half of `cut`.
    frequency_error : ndarray, shape (k,)
        Estimates of their relative errors; the reduced frequencies are too high.
    response : ndarray, shape (r,)
        Relative error of the response of each kept row to a force along itself, over the frequencies up to `upto`.
    upto : float
        Highest frequency for which `response` holds, rad/time.
    cut : float
        Frequency of the lowest mode with fixed rows that was left out, rad/time.

    Examples
    --------
    >>> import symfric as sf
    >>> chain = sf.structures.chain(20, damping=0.02)
    >>> error = chain.reduced(["x5"], modes=6).error
    >>> bool(error.frequency_error[0] < 1e-3)
    True
    >>> sorted(error.to_dict())[:2]
    ['cut', 'frequency']
    """

    frequency: np.ndarray
    frequency_error: np.ndarray
    response: np.ndarray
    upto: float
    cut: float

    @property
    def worst(self) -> float:
        """The largest of all estimates, dimensionless."""
        return float(max(np.max(self.frequency_error, initial=0.0), np.max(self.response, initial=0.0)))

    def __repr__(self) -> str:
        return (
            f"ReductionError(frequencies {np.max(self.frequency_error, initial=0.0):.2g}, response at rows "
            f"{np.max(self.response, initial=0.0):.2g}, up to omega = {self.upto:.6g}; left out from {self.cut:.6g})"
        )


def reduce(K: sps.csr_array, M: sps.csr_array, rows: np.ndarray, count: int) -> Reduced:
    """Return the basis of Craig and Bampton.

    Parameters
    ----------
    K, M : sparse, shape (n, n)
    rows : ndarray, shape (r, n)
        Linearly independent; none for modal truncation.
    count : int
        Modes with fixed rows.

    Raises
    ------
    SceneError
        If the rows depend on each other, or there are not so many modes.
    NotFound
        If the iteration does not converge, or the structure can move as a rigid body with all rows held.
    """
    n, r = M.shape[0], len(rows)
    if r and np.linalg.matrix_rank(rows / np.linalg.norm(rows, axis=1)[:, None], tol=_RANK) < r:
        raise SceneError("the kept rows depend on each other; leave out those that follow from others")
    count = positive_count(count, n - r, f"the number of modes with {r} rows held", least=0 if r else 1)
    solve = _held(K, M, rows)
    shapes = solve(np.zeros((n, r)), np.eye(r)) if r else np.zeros((n, 0))
    modes, cut = _modes_held(K, M, rows, solve, count)
    return Reduced(np.column_stack([shapes, modes]), cut)


def _held(K: sps.csr_array, M: sps.csr_array, rows: np.ndarray) -> Any:
    """Return the solver of ``K x + R^T f = b, R x = y``, for several right-hand sides."""
    r = len(rows)
    weight = float(np.max(np.abs(K.diagonal()))) / np.max(np.abs(rows), axis=1) if r else np.zeros(0)
    R = sps.csr_array(rows * weight[:, None])  # as large as the stiffness
    for shift in (0.0, 1e-10):  # a body that is free with its rows held is held by a trace of its mass
        size = shift * float(np.max(K.diagonal() / M.diagonal()))
        A = sps.block_array([[K + size * M, R.T], [R, None]], format="csc") if r else K + size * M
        try:
            factors = spla.splu(sps.csc_matrix(A))
        except RuntimeError:
            continue
        pivots = np.abs(factors.U.diagonal())
        if np.all(np.isfinite(pivots)) and np.min(pivots) > 1e-14 * np.max(pivots):
            break
        if shift:
            break
    else:
        raise NotFound("the stiffness cannot be factorised even with the kept rows held")

    def solve(b: np.ndarray, y: np.ndarray) -> np.ndarray:
        return np.asarray(factors.solve(np.concatenate([b, (y.T * weight).T]))[: len(b)])

    return solve


def _modes_held(
    K: sps.csr_array, M: sps.csr_array, rows: np.ndarray, solve: Any, count: int
) -> tuple[np.ndarray, float]:
    """Return the lowest modes with the rows held, and the frequency of the next one."""
    n, r = M.shape[0], len(rows)
    if r == n:
        return np.zeros((n, 0)), np.inf  # older SciPy knows no eigenvalues of an empty matrix
    if count + 1 >= n - r or n <= 60:
        free = sla.null_space(rows) if r else np.eye(n)
        k, m = free.T @ (K @ free), free.T @ (M @ free)
        values, inside = sla.eigh(0.5 * (k + k.T), 0.5 * (m + m.T))
        cut = values[count] if count < values.size else np.inf
        return free @ inside[:, :count], float(np.sqrt(max(cut, 0.0)))
    zero = np.zeros(r)
    operator = spla.LinearOperator((n, n), matvec=lambda b: solve(b.ravel(), zero), dtype=float)
    k = count + min(6, n - r - count)
    start = solve(np.random.default_rng(_SEED).standard_normal(n), zero)
    shapes = np.zeros((n, 0))
    try:
        _, shapes = spla.eigsh(K, k, M, sigma=0.0, OPinv=operator, v0=start, ncv=min(n, 2 * k + 20), maxiter=60, tol=0)
    except spla.ArpackNoConvergence as failure:
        raise NotFound(f"the iteration for the modes did not converge ({failure}); ask for fewer") from None
    shapes = _completed(K, M, solve, shapes, count, zero)
    kk, mm = shapes.T @ (K @ shapes), shapes.T @ (M @ shapes)
    values, inside = sla.eigh(0.5 * (kk + kk.T), 0.5 * (mm + mm.T))
    return (shapes @ inside)[:, :count], float(np.sqrt(max(values[count], 0.0)))


def _completed(
    K: sps.csr_array, M: sps.csr_array, solve: Any, shapes: np.ndarray, count: int, zero: np.ndarray
) -> np.ndarray:
    """Return the shapes with copies of multiple modes that one start did not lead to, found from another."""
    draw = np.random.default_rng(_SEED + 1)
    new = solve(M @ draw.standard_normal((len(shapes), 4)), np.zeros((zero.size, 4)))
    for _ in range(12):
        new = new - shapes @ (shapes.T @ (M @ new))
        new = solve(M @ np.linalg.qr(new)[0], np.zeros((zero.size, 4)))
    new = np.linalg.qr(new - shapes @ (shapes.T @ (M @ new)))[0]
    return np.column_stack([shapes, new])


def errors_of(
    structure: "Structure", basis: np.ndarray, small: "Structure", rows: np.ndarray, cut: float
) -> ReductionError:
    """Estimate the errors of a reduced structure against the full one.

    Parameters
    ----------
    structure : Structure
        The full one.
    basis : ndarray, shape (n, m)
    small : Structure
        The reduced one.
    rows : ndarray, shape (r, n)
    cut : float
    """
    K, M = structure.K, structure.M
    squares, inside = sla.eigh(small.K.toarray(), small.M.toarray())
    top = min(0.5 * cut, float(np.sqrt(max(squares[-1], 0.0))))
    chosen = np.flatnonzero(squares <= top**2 * (1 + 1e-12))
    omega = np.sqrt(np.maximum(squares[chosen], 0.0))
    shapes = basis @ inside[:, chosen]
    left = K @ shapes - (M @ shapes) * squares[chosen]
    if len(rows):  # forces along the kept rows are in balance already
        left = left - rows.T @ np.linalg.lstsq(rows @ rows.T, rows @ left, rcond=None)[0]
    solve = _held(K, M, rows)
    gain = np.sum(left * solve(left, np.zeros((len(rows), left.shape[1]))), axis=0) if chosen.size else np.zeros(0)
    amplified = 1 / np.maximum(1 - squares[chosen] / cut**2, 0.5) if np.isfinite(cut) else np.ones(chosen.size)
    scale = np.where(squares[chosen] > 0, squares[chosen], 1.0)
    error = 0.5 * np.abs(gain) * amplified / scale
    response = _response(structure, small, rows, rows @ basis, top)
    return ReductionError(omega, error, response, top, cut)


def _response(
    structure: "Structure", small: "Structure", rows: np.ndarray, projected: np.ndarray, top: float
) -> np.ndarray:
    """Return the relative errors of the flexibility of each row, compared with the full structure at some frequencies.

    Relative to the largest of a row's: between two resonances a flexibility passes zero.
    """
    if not len(rows) or not 0 < top < np.inf:
        return np.zeros(len(rows))
    apart, sizes = np.zeros(len(rows)), np.zeros(len(rows))
    for part in _PARTS:
        square = (part * top) ** 2
        factors = factorised(structure.K - square * structure.M)
        if factors is None:
            continue
        full = np.sum(rows.T * factors.solve(np.ascontiguousarray(rows.T)), axis=0)
        dynamic = small.K.toarray() - square * small.M.toarray()
        own = np.sum(projected.T * np.linalg.solve(dynamic, projected.T), axis=0)
        apart, sizes = np.maximum(apart, np.abs(full - own)), np.maximum(sizes, np.abs(full))
    return apart / np.where(sizes > 0, sizes, 1.0)
