"""Complex modes ``(lambda^2 M + lambda C + K + mu F) phi = 0`` of a large structure by shift-invert Arnoldi.

Without damping the squares ``-lambda^2`` are eigenvalues of the n equations themselves. With damping the quadratic
problem is linearised, and the inverse of the pencil with 2n rows at the shift s needs the factors of the n rows of
``s^2 M + s C + K + mu F`` only (Tisseur and Meerbergen, The quadratic eigenvalue problem, SIAM Review 43, 2001, 4.1).

The eigenvalues of the inverse are those of largest magnitude; see `symfric.structures.krylov`.
"""

import contextlib
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any

import numpy as np
import scipy.linalg as sla
import scipy.sparse as sps
import scipy.sparse.linalg as spla

from symfric.axes import Axes, axes_for
from symfric.errors import NotFound, SceneError
from symfric.model.notebook import html_table
from symfric.model.results import COMPLEX, ArrayResult, Drawable, Labelled
from symfric.structures.checks import positive_count
from symfric.structures.krylov import largest

_DENSE = 60  # degrees of freedom up to which all modes are computed
_EXTRA = 3  # eigenvalues computed beside those asked for, so that none of equal distance is cut off
_LAST = 1e-3  # by which a shift is moved at the most
_CLOSE = 1e-9  # of a shift: distance from an eigenvalue
_SEED = 3  # fixed, so that the same structure gives the same modes
_RIGID = 1e-11  # of the sum of the magnitudes of its terms: strain energy that is zero
# of the largest squared frequency: a shift nearer to zero is moved below it, where the stiffness of a free body
# has an inverse
_FREE = 1e-8
_NEAR_ZERO = 1e-5, 0.1  # of the largest frequency: shifts up to which zero, or conjugates, lie among the nearest values
_LARGEST = 0.999  # of the largest entry of a shape: equal up to rounding, so that the first of equal ones sets the sign
_SLOW = 1e-9  # of the same sum: kinetic energy of a mode that does not move by itself
_UPPER = 1e-9  # of an eigenvalue: an imaginary part below which it is real


@dataclass(frozen=True, eq=False, repr=False)
class ComplexModes(ArrayResult, Drawable):
    """Modes of a damped structure with friction.

    `plot` draws the eigenvalues in the complex plane.

    Attributes
    ----------
    eigenvalues : ndarray of complex, shape (count,)
        lambda in 1/time, by increasing imaginary part; of conjugate pairs the one with the positive imaginary part.
        Without damping, of two real ones ``+-s`` the positive one.
    shapes : ndarray of complex, shape (n, count)
        Columns of length 1, the largest entry of each real and positive.
    residuals : ndarray, shape (count,)
        ``|Q(lambda) phi|`` over the sum of the magnitudes of its terms, in the largest norm, dimensionless.
    mu : float
    names : tuple of str
        Of the degrees of freedom.

    Examples
    --------
    >>> import symfric as sf
    >>> modes = sf.structures.ziegler().complex_modes(2, mu=2.5)
    >>> len(modes.eigenvalues)
    2
    >>> sorted(modes.to_dict())[:2]
    ['damping', 'eigenvalues']
    >>> len(modes.to_xarray().data_vars) > 0
    True
    >>> ax = modes.plot()
    """

    eigenvalues: np.ndarray = field(metadata=COMPLEX)
    shapes: np.ndarray
    residuals: np.ndarray
    mu: float
    names: tuple[str, ...] = field(repr=False, default=())
    _told = ("mu", "eigenvalues", "damping", "largest_residual")

    @property
    def largest_residual(self) -> float:
        """Largest of the residuals."""
        return float(np.max(self.residuals))

    def _labelled(self) -> Labelled:
        data = {"eigenvalues": ("mode", self.eigenvalues), "shapes": (("dof", "mode"), self.shapes)}
        return data, {"dof": list(self.names), "mode": np.arange(self.eigenvalues.size)}, {"mu": self.mu}

    @property
    def frequency(self) -> np.ndarray:
        """Imaginary parts, rad/time, shape (count,)."""
        return self.eigenvalues.imag

    @property
    def damping(self) -> np.ndarray:
        """Damping ratios ``-Re lambda/|lambda|``, negative where a mode grows; shape (count,)."""
        size = np.abs(self.eigenvalues)
        return np.where(size > 0, -self.eigenvalues.real / np.where(size > 0, size, 1), 0.0)

    def _draw(self, ax: Axes | None) -> Axes:
        ax = axes_for(ax)
        ax.axvline(0.0, color="0.6", linewidth=0.8)
        ax.plot(self.eigenvalues.real, self.eigenvalues.imag, "x")
        ax.set_xlabel("real part")
        ax.set_ylabel("imaginary part")
        return ax

    def _repr_html_(self) -> str:
        return html_table("ComplexModes", {**self.to_dict(), "eigenvalues": self.eigenvalues.tolist()})

    def __repr__(self) -> str:
        growing = int(np.sum(self.eigenvalues.real > 0))
        return (
            f"ComplexModes({self.eigenvalues.size} at mu = {self.mu:g}, largest real part "
            f"{np.max(self.eigenvalues.real):.6g}, {growing} with a positive one)"
        )


@dataclass(frozen=True, eq=False)
class Pencil:
    """The matrices of ``lambda^2 M + lambda C + A``; C is None without damping."""

    M: sps.csr_array
    C: sps.csr_array | None
    A: sps.csr_array

    def at(self, value: complex) -> sps.csr_array:
        """Return the matrix for one lambda."""
        A = value * value * self.M + self.A
        return sps.csr_array(A if self.C is None else A + value * self.C)

    def residuals(self, values: np.ndarray, shapes: np.ndarray) -> np.ndarray:
        """Return the residual of each eigenpair, relative to the terms that cancel in it."""
        left, size = self.A @ shapes + (self.M @ shapes) * values**2, abs(self.A) @ np.abs(shapes)
        size = size + (abs(self.M) @ np.abs(shapes)) * np.abs(values) ** 2
        if self.C is not None:
            left, size = left + (self.C @ shapes) * values, size + (abs(self.C) @ np.abs(shapes)) * np.abs(values)
        return np.asarray(np.max(np.abs(left), axis=0) / np.max(size, axis=0))


def shift_of(near: complex | float) -> complex:
    """Return the point of the complex plane that `near` means: a real number is a frequency."""
    try:
        value = complex(near)
    except (TypeError, ValueError):
        raise SceneError(f"near is {near!r}; give a frequency in rad/time or a complex number") from None
    if not np.isfinite(value):
        raise SceneError(f"near is {near}; it must be finite")
    return value if isinstance(near, complex) and value.imag else 1j * value.real


def eigenpairs(pencil: Pencil, count: int, near: complex) -> tuple[np.ndarray, np.ndarray]:
    """Return the eigenvalues nearest to a point, by increasing imaginary part, and their shapes of length 1.

    Raises
    ------
    NotFound
        If the iteration does not converge.
    """
    n = pencil.M.shape[0]
    positive_count(count, n, "the number of modes")
    if pencil.C is None:
        values, shapes = _undamped(pencil, count, near)
    else:
        values, shapes = _damped(pencil, count, near)
    values, shapes = _cleared(pencil, values, shapes)
    nearest = np.argsort(np.abs(values - near), kind="stable")[:count]
    values, shapes = values[nearest], shapes[:, nearest]
    order = np.lexsort((values.real, np.round(values.imag, 12)))
    return values[order], shapes[:, order]


def complex_modes(pencil: Pencil, count: int, near: complex, mu: float, names: tuple[str, ...]) -> ComplexModes:
    """Return complex modes with their residuals; see `eigenpairs`."""
    values, shapes = eigenpairs(pencil, count, near)
    return ComplexModes(values, shapes, pencil.residuals(values, shapes), mu, names)


def _undamped(pencil: Pencil, count: int, near: complex) -> tuple[np.ndarray, np.ndarray]:
    n, target = pencil.M.shape[0], -(near**2)
    if n <= _DENSE or count > n // 3:
        squares, shapes = sla.eig(pencil.A.toarray(), pencil.M.toarray())
    else:
        target = target.real if abs(target.imag) <= 1e-14 * abs(target) else target
        size = float(np.max(pencil.A.diagonal() / pencil.M.diagonal()))
        s = target if abs(target) > _FREE * size else -_FREE * size
        k, kind = min(count + _EXTRA, n - 2), complex if np.iscomplexobj(s) else float

        def nearest(s: complex) -> tuple[np.ndarray, np.ndarray]:
            solve = _inverse(pencil.A - s * pencil.M)
            inverse, shapes = largest(lambda x: solve(pencil.M @ x), n, k, kind)
            return s + 1 / inverse, shapes

        squares, shapes = _beside(nearest, s)
    values = np.sqrt(-squares.astype(complex))
    return np.where(values.imag < 0, -values, values), shapes


def _damped(pencil: Pencil, count: int, near: complex) -> tuple[np.ndarray, np.ndarray]:
    n, M, C = pencil.M.shape[0], pencil.M, pencil.C
    assert C is not None
    if 2 * n <= _DENSE or 2 * count + _EXTRA > n:
        Z, one = np.zeros((n, n)), np.eye(n)
        left = np.block([[Z, one], [-pencil.A.toarray(), -C.toarray()]])
        values, vectors = sla.eig(left, sla.block_diag(one, M.toarray()))
        return _upper(values, vectors[:n])
    size = float(np.sqrt(np.max(np.abs(pencil.A.diagonal()) / M.diagonal())))
    low = abs(near) <= _NEAR_ZERO[0] * size
    asked = (
        count if abs(near) > _NEAR_ZERO[1] * size else 2 * count
    ) + _EXTRA  # of values near zero the conjugate is as near

    def nearest(s: complex) -> tuple[np.ndarray, np.ndarray]:
        solve = _inverse(pencil.at(s))
        scale = max(abs(s), _slowest(solve, M))  # of velocities, to make them as large as the displacements

        def operator(v: np.ndarray) -> np.ndarray:
            f, g = v[:n], scale * (M @ v[n:])
            x = solve(-(g + C @ f + s * (M @ f)))
            return np.concatenate([x, (s * x + f) / scale])

        inverse, vectors = largest(operator, 2 * n, min(asked, 2 * n - 2), float if low else complex)
        return s + 1 / inverse, vectors

    values, vectors = _beside(nearest, _NEAR_ZERO[0] * size if low else near)
    return _upper(values, vectors[:n])


def _slowest(solve: Callable[..., Any], M: sps.csr_array) -> float:
    """Return about the lowest frequency beside a shift, by some inverse iterations."""
    x = np.random.default_rng(_SEED).standard_normal(M.shape[0])
    # its order of magnitude is enough to place a shift
    for _ in range(4):
        x = x / np.linalg.norm(x)
        x, before = solve(M @ x), x
    return float(np.sqrt(abs(1 / (before @ x))))


def _beside(
    nearest: Callable[[complex], tuple[np.ndarray, np.ndarray]], shift: complex
) -> tuple[np.ndarray, np.ndarray]:
    """Return the eigenpairs nearest to a shift, which is moved off an eigenvalue, whose pole would hide the others."""
    for moved in (0.0, 1e-5, 1e-4, _LAST):
        at = shift * (1 + moved)
        with contextlib.suppress(ZeroDivisionError, *([NotFound] if moved < _LAST else [])):
            pairs = nearest(at)
            if np.min(np.abs(pairs[0] - at)) > _CLOSE * abs(at):
                return pairs
    raise NotFound("the matrix cannot be factorised at this point; choose another `near`")


def _inverse(A: sps.csr_array) -> Callable[[np.ndarray], np.ndarray]:
    """Return the inverse of a sparse matrix as a function of real or complex vectors.

    Raises
    ------
    ZeroDivisionError
        If the matrix is singular.
    """
    try:
        factors = spla.splu(sps.csc_matrix(A))
    except RuntimeError:
        raise ZeroDivisionError from None
    if np.iscomplexobj(A):
        return lambda x: factors.solve(x.astype(complex))

    def solve(x: np.ndarray) -> np.ndarray:
        if np.iscomplexobj(x):
            return solve(x.real) + 1j * solve(x.imag)
        return np.asarray(factors.solve(np.ascontiguousarray(x)))

    return solve


def _upper(values: np.ndarray, shapes: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return the eigenpairs in the upper half plane or on the real axis."""
    finite = np.isfinite(values) & (values.imag >= -_UPPER * np.abs(values))
    values, shapes = values[finite], shapes[:, finite]
    real = np.abs(values.imag) <= _UPPER * np.abs(values)
    return np.where(real, values.real, values), shapes


def _cleared(pencil: Pencil, values: np.ndarray, shapes: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return eigenvalues with the zeros of rigid motions, and shapes of length 1 with a real largest entry."""
    shapes = shapes / np.linalg.norm(shapes, axis=0)
    largest = np.argmax(np.abs(shapes) > _LARGEST * np.max(np.abs(shapes), axis=0), axis=0)
    top = shapes[largest, np.arange(shapes.shape[1])]
    shapes = shapes * (np.abs(top) / top)
    strain = np.abs(np.sum(shapes.conj() * (pencil.A @ shapes), axis=0))
    terms = np.sum(np.abs(shapes) * (abs(pencil.A) @ np.abs(shapes)), axis=0)
    slow = np.abs(values) ** 2 * np.sum(np.abs(shapes) * (abs(pencil.M) @ np.abs(shapes)), axis=0) <= _SLOW * terms
    values = np.where((strain <= _RIGID * terms) & slow, 0.0, values)
    return values, shapes
