"""Real modes of a large structure, ``K phi = omega^2 M phi``, by shift-invert Lanczos, none of them missing.

A Lanczos method from one vector finds copies of a multiple eigenvalue only through rounding. The number of eigenvalues
between two shifts is known from two sparse factorisations (Sylvester's law of inertia); as long as some are missing,
the iteration is repeated orthogonally to those found (Parlett, The Symmetric Eigenvalue Problem, 3.3 and 13.7).
"""

import itertools
from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np
import scipy.linalg as sla
import scipy.sparse as sps
import scipy.sparse.linalg as spla

from symfric.axes import Axes
from symfric.errors import NotFound, SceneError
from symfric.model.results import ArrayResult, Labelled
from symfric.structures.checks import positive_count
from symfric.structures.factors import factorised, negative_pivots

_DENSE = 60  # degrees of freedom up to which all modes are computed
_EXTRA = 4  # modes computed beside those wanted, among which a gap is looked for
_GAP = 1e-6  # relative, between eigenvalues that a shift can tell apart
_BELOW = 1e-10  # of the largest eigenvalue: shift below zero, where the stiffness of a free body has an inverse
_MOVED = 1e-7, 1e-9  # of a shift, and of the largest eigenvalue: by which a shift at an eigenvalue is moved
_LARGEST = 0.999  # of the largest entry of a shape: equal up to rounding, so that the first of equal ones sets the sign
_RIGID = 1e-12, 1e-18  # of the terms that cancel in phi^T K phi, and of the largest eigenvalue: squares that are zero
_TURNS = 12  # most searches for modes that the count by Sylvester's law of inertia says are missing
_SEED = 7  # fixed, so that the same structure gives the same modes


@dataclass(frozen=True, eq=False, repr=False)
class Modes(ArrayResult):
    """Undamped natural modes of a structure.

    Attributes
    ----------
    frequency : ndarray, shape (count,)
        omega in rad/time, increasing; zero for the motions of a rigid body.
    shapes : ndarray, shape (n, count)
        Columns with ``shapes.T @ M @ shapes = I``, the largest entry of each positive.
    residuals : ndarray, shape (count,)
        ``|K phi - omega^2 M phi|`` over ``|K| |phi| + omega^2 |M| |phi|`` in the largest norm, dimensionless.
    complete : bool
        Whether it is proved that no mode between those found is missing.
    names : tuple of str
        Of the degrees of freedom.

    Examples
    --------
    >>> import symfric as sf
    >>> chain = sf.structures.chain(20, damping=0.02)
    >>> modes = chain.modes(3)
    >>> modes.frequency.round(6)
    array([0.14946 , 0.298085, 0.445042])
    >>> sorted(modes.to_dict())[:2]
    ['complete', 'frequency']
    >>> len(modes.to_xarray().data_vars) > 0
    True
    >>> ax = modes.plot()
    """

    frequency: np.ndarray
    shapes: np.ndarray
    residuals: np.ndarray
    complete: bool
    names: tuple[str, ...] = field(repr=False, default=())
    _told = ("frequency", "rigid", "largest_residual", "complete")

    @property
    def largest_residual(self) -> float:
        """Largest of the residuals."""
        return float(np.max(self.residuals))

    def _labelled(self) -> Labelled:
        data = {"frequency": ("mode", self.frequency), "shapes": (("dof", "mode"), self.shapes)}
        return data, {"dof": list(self.names), "mode": np.arange(self.frequency.size)}, {}

    @property
    def rigid(self) -> int:
        """Number of modes without stiffness."""
        return int(np.sum(self.frequency == 0))

    def plot(self, ax: Axes | None = None, modes: Sequence[int] = (0, 1, 2), at: Any = None) -> Axes:
        """Draw some shapes over the degrees of freedom, or over places `at`, shape (n,); return the Axes.

        Parameters
        ----------
        ax : matplotlib Axes, optional
            Where to draw; a new figure unless given.
        modes : sequence of int
            Numbers of the modes to draw.
        at : ndarray, shape (n,), optional
            Places of the degrees of freedom.

        Returns
        -------
        matplotlib Axes
        """
        from symfric.structures.pictures import plot_shapes

        return plot_shapes(self.shapes, self.frequency, ax, modes, at)

    def __repr__(self) -> str:
        return (
            f"Modes({self.frequency.size} from omega = {self.frequency[0]:.9g} to {self.frequency[-1]:.9g}, "
            f"{self.rigid} rigid, largest residual {self.largest_residual:.1e})"
        )


def real_modes(K: sps.csr_array, M: sps.csr_array, count: int, near: float, names: tuple[str, ...]) -> Modes:
    """Return the modes whose frequencies are nearest to `near`.

    Parameters
    ----------
    K, M : sparse, shape (n, n)
        Symmetric, M positive definite.
    count : int
    near : float
        In rad/time, >= 0.
    names : tuple of str

    Raises
    ------
    SceneError
        If there are not so many modes.
    NotFound
        If the iteration does not converge.
    """
    n = M.shape[0]
    positive_count(count, n, "the number of modes")
    if not (np.isfinite(near) and near >= 0):
        raise SceneError(f"near is {near}; give a frequency in rad/time that is not negative")
    if n <= _DENSE or count > n // 3:
        values, shapes = sla.eigh(K.toarray(), M.toarray())
        nearest = np.sort(np.argsort(np.abs(_root(values) - near), kind="stable")[:count])
        values, shapes, complete = values[nearest], shapes[:, nearest], True
    else:
        values, shapes, complete = _iterated(K, M, count, near)
    return _finished(K, M, values, shapes, complete, names)


def _root(values: np.ndarray) -> np.ndarray:
    """Return frequencies with the sign of their squares."""
    return np.asarray(np.sign(values) * np.sqrt(np.abs(values)))


def _typical(K: sps.csr_array, M: sps.csr_array) -> float:
    """Return a lower bound of the size of the largest eigenvalue: a ratio of diagonals."""
    return float(np.max(K.diagonal() / M.diagonal())) or 1.0


def _iterated(K: sps.csr_array, M: sps.csr_array, count: int, near: float) -> tuple[np.ndarray, np.ndarray, bool]:
    """Return eigenvalues and shapes nearest to a frequency, and whether none is missing."""
    n = M.shape[0]
    shift, solve = _invertible(K, M, near)
    k = min(count + _EXTRA, n - 2)
    values, shapes = _lanczos(K, M, solve, shift, k, np.zeros((n, 0)))
    complete = False
    for _ in range(_TURNS):
        missing = _missing(K, M, values, shift, near, count)
        complete = missing == 0
        if missing is None or complete:
            break
        more, others = _lanczos(K, M, solve, shift, min(missing + 2, n - 2 - values.size), shapes)
        values, shapes = np.concatenate([values, more]), np.column_stack([shapes, others])
        order = np.argsort(values)
        values, shapes = values[order], shapes[:, order]
    nearest = np.sort(np.argsort(np.abs(_root(values) - near), kind="stable")[:count])
    return values[nearest], shapes[:, nearest], complete


def _invertible(K: sps.csr_array, M: sps.csr_array, near: float) -> Any:
    """Return a shift near a squared frequency at which ``K - shift M`` can be factorised, and the factors."""
    size = _typical(K, M)
    shift = near**2
    if near == 0:  # just below, where the stiffness of a body that is free can be inverted as well
        shift = -_BELOW * size
    for _ in range(8):
        factors = factorised(K - shift * M)
        if factors is not None:
            pivots = np.abs(factors.U.diagonal())
            if np.all(np.isfinite(pivots)) and np.min(pivots) > 0:
                return shift, factors.solve
        shift = shift * (1 + _MOVED[0]) - _MOVED[1] * size
    raise NotFound(f"K - omega^2 M cannot be factorised near omega = {near}; choose another `near`")


def _lanczos(
    K: sps.csr_array, M: sps.csr_array, solve: Any, shift: float, k: int, known: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Return k eigenpairs nearest to the shift, orthogonal to those found, increasing."""
    n = M.shape[0]
    image = M @ known

    def inverse(x: np.ndarray) -> np.ndarray:
        x = x.ravel()
        y = solve(x - image @ (known.T @ x))  # x is M times a vector: its parts along the known ones are removed
        return np.asarray(y - known @ (image.T @ y))

    start = np.random.default_rng(_SEED + known.shape[1]).standard_normal(n)
    start -= known @ (image.T @ start)
    ncv = min(n, max(2 * k + 1, 24))
    operator = spla.LinearOperator((n, n), matvec=inverse, dtype=float)
    try:
        _, shapes = spla.eigsh(K, k, M, sigma=shift, OPinv=operator, v0=start, ncv=ncv, maxiter=60, tol=0)
    except spla.ArpackNoConvergence as failure:
        raise NotFound(
            f"the iteration for the modes did not converge ({failure}); ask for fewer, or choose `near` closer"
        ) from None
    return _rotated(K, M, shapes)


def _rotated(K: sps.csr_array, M: sps.csr_array, shapes: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return the eigenpairs within the space of some shapes, one step of Rayleigh and Ritz."""
    k, m = shapes.T @ (K @ shapes), shapes.T @ (M @ shapes)
    values, inside = sla.eigh(0.5 * (k + k.T), 0.5 * (m + m.T))
    return values, shapes @ inside


def _missing(
    K: sps.csr_array, M: sps.csr_array, values: np.ndarray, shift: float, near: float, count: int
) -> int | None:
    """Return how many eigenvalues lie between two gaps around those asked for and were not found; None if unknown."""
    values = np.sort(values)
    asked = np.sort(values[np.argsort(np.abs(_root(values) - near), kind="stable")[:count]])
    size = max(abs(values[0]), abs(values[-1]), abs(shift))
    low, high = _gap_below(values, asked[0], size), _gap_above(values, asked[-1], size)
    # Sylvester's law of inertia: K - s M has as many negative pivots as there are eigenvalues below s (Parlett,
    # The Symmetric Eigenvalue Problem, 1998, 3.3)
    below, above = negative_pivots(K - low * M), negative_pivots(K - high * M)
    if below is None or above is None:
        return None
    inside = values[(values > low) & (values < high)]
    return max(0, above - below - inside.size)


def _gap_above(values: np.ndarray, start: float, size: float) -> float:
    """Return a number behind `start` that lies in a gap of the values."""
    later = values[values >= start]
    for a, b in itertools.pairwise(later):
        if b - a > _GAP * size:
            return float(0.5 * (a + b))
    return float(later[-1] + _GAP * size)


def _gap_below(values: np.ndarray, start: float, size: float) -> float:
    return -_gap_above(-values[::-1], -start, size)


def _finished(
    K: sps.csr_array, M: sps.csr_array, values: np.ndarray, shapes: np.ndarray, complete: bool, names: tuple[str, ...]
) -> Modes:
    """Return modes with the zeros of rigid motions, signs and residuals."""
    shapes = shapes / np.sqrt(np.sum(shapes * (M @ shapes), axis=0))
    largest = np.argmax(np.abs(shapes) > _LARGEST * np.max(np.abs(shapes), axis=0), axis=0)
    shapes = shapes * np.sign(shapes[largest, np.arange(shapes.shape[1])])
    strain = np.sum(np.abs(shapes) * (abs(K) @ np.abs(shapes)), axis=0)  # what cancels in phi^T K phi
    values = np.where(np.abs(values) <= np.maximum(_RIGID[0] * strain, _RIGID[1] * _typical(K, M)), 0.0, values)
    if np.any(values < 0):
        raise NotFound(
            f"K is not positive semidefinite: omega^2 = {values.min():.6g}; the structure buckles before it vibrates"
        )
    left = np.max(np.abs(K @ shapes - (M @ shapes) * values), axis=0)
    sizes = np.max(abs(K) @ np.abs(shapes) + (abs(M) @ np.abs(shapes)) * np.abs(values), axis=0)
    return Modes(np.sqrt(values), shapes, left / sizes, complete, names)
