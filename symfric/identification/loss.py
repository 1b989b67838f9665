"""Robust losses, which weigh large residuals less than their squares, and the uncertainty of such fits."""

from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np

from symfric.errors import SceneError
from symfric.model.symbols import nearest

NORMAL = 1.482602218505602  # standard deviation of normal noise over the median of its sizes


class Loss(NamedTuple):
    """A function rho of z = (residual / scale)^2, with ``rho(z) = z`` for small z.

    Attributes
    ----------
    name : str
        As `scipy.optimize.least_squares` has it.
    scale : float
        Residual, in standard deviations of the noise, from which on it counts less; such that normal noise costs 5 %
        of the efficiency of least squares.
    rho, first, second : callable
        The function and its derivatives by z.
    """

    name: str
    scale: float
    rho: Callable[[np.ndarray], np.ndarray]
    first: Callable[[np.ndarray], np.ndarray]
    second: Callable[[np.ndarray], np.ndarray]

    @property
    def is_robust(self) -> bool:
        """Whether it differs from the sum of squares."""
        return self.name != "linear"

    def cost(self, residuals: np.ndarray) -> Any:
        """Return half the sum of the loss over weighted residuals, along the first axis."""
        with np.errstate(over="ignore", invalid="ignore"):
            return 0.5 * self.scale**2 * np.sum(self.rho((residuals / self.scale) ** 2), axis=0)

    def root(self, residuals: np.ndarray) -> np.ndarray:
        """Return factors of residuals whose squares weigh them as the loss does (iteratively reweighted squares)."""
        return np.asarray(np.sqrt(self.first((residuals / self.scale) ** 2)))

    def slope(self, residuals: np.ndarray) -> np.ndarray:
        """Return the derivative of the loss by each residual (psi)."""
        return np.asarray(residuals * self.first((residuals / self.scale) ** 2))

    def curvature(self, residuals: np.ndarray) -> np.ndarray:
        """Return the second derivative of the loss by each residual."""
        z = (residuals / self.scale) ** 2
        return np.asarray(self.first(z) + 2 * z * self.second(z))


def _ones(z: np.ndarray) -> np.ndarray:
    return np.ones_like(z)


def _huber(z: np.ndarray) -> np.ndarray:
    return np.where(z <= 1, z, 2 * np.sqrt(np.maximum(z, 1.0)) - 1)


LOSSES = {
    "linear": Loss("linear", 1.0, lambda z: z, _ones, np.zeros_like),
    "soft_l1": Loss(
        "soft_l1",
        1.2871,
        lambda z: 2 * (np.sqrt(1 + z) - 1),
        lambda z: (1 + z) ** -0.5,
        lambda z: -0.5 * (1 + z) ** -1.5,
    ),
    "huber": Loss(
        "huber",
        1.345,
        _huber,
        lambda z: np.maximum(z, 1.0) ** -0.5,
        lambda z: np.where(z <= 1, 0.0, -0.5 * np.maximum(z, 1.0) ** -1.5),
    ),
    "cauchy": Loss("cauchy", 2.3849, np.log1p, lambda z: 1 / (1 + z), lambda z: -1 / (1 + z) ** 2),
}
LINEAR = LOSSES["linear"]


def read_loss(name: str) -> Loss:
    """Return a loss by its name; raise `SceneError` if there is none."""
    if not isinstance(name, str) or name not in LOSSES:
        raise SceneError(f"loss is {name!r}{nearest(str(name), LOSSES)}")
    return LOSSES[name]


def median_scale(residuals: np.ndarray) -> float:
    """Return the standard deviation of normal noise with the median of the residuals' sizes."""
    return NORMAL * float(np.median(np.abs(residuals)))


class Sandwich(NamedTuple):
    """Uncertainty of a fit with a robust loss (sandwich estimator).

    Attributes
    ----------
    root : ndarray, shape (n_p, n_p)
        A matrix R with ``(R'R)^-1`` the covariance of the values.
    inflation : float
        Twice the rise of the cost over a chi-square distributed number.
    """

    root: np.ndarray
    inflation: float


def sandwich(loss: Loss, residuals: np.ndarray, jacobian: np.ndarray) -> Sandwich:
    """Return the covariance of a fit with a robust loss.

    Parameters
    ----------
    loss : Loss
    residuals : ndarray, shape (n,)
        Weighted, those that count.
    jacobian : ndarray, shape (n, n_p)
        Their derivatives by the values.

    Notes
    -----
    ``A^-1 B A^-1`` with ``A = mean(psi') J'J`` and ``B = n/(n - n_p) sum psi_i^2 j_i j_i'`` (Huber, Robust Statistics,
    1981, section 7.6), which holds for noise that is not normal and differs from sample to sample. Twice the rise of
    the cost is ``mean(psi^2)/mean(psi')`` times as large as a chi-square distributed number (Ronchetti 1982).
    """
    n, n_p = jacobian.shape
    basis, triangle = np.linalg.qr(jacobian)
    freed = n / max(n - n_p, 1)
    psi = loss.slope(residuals)
    bend = max(float(np.mean(loss.curvature(residuals))), 1e-3)  # not zero where all residuals are outliers
    within = basis.T @ (basis * (freed * psi**2)[:, None])
    # a trace keeps the factorisation from failing where fewer samples than unknowns count
    floor = 1e-12 * max(float(np.trace(within)) / n_p, 1e-300)
    root = bend * np.linalg.solve(np.linalg.cholesky(within + floor * np.eye(n_p)), triangle)
    return Sandwich(root, freed * float(np.mean(psi**2)) / bend)
