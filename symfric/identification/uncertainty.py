"""Covariance, standard errors, correlation and badly determined directions from the Jacobian of a fit."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np

SINGULAR = 1e-10  # of the largest singular value: below it a direction does not change the records at all
UNFIXED = 0.29  # standard deviation of a uniform distribution between the bounds, in units of their distance
SMALLEST = 0.1  # weights below this, relative to the largest, are not told


@dataclass(frozen=True, eq=False)
class Direction(Mapping[Any, Any]):
    """A direction of the unknowns along which the predictions hardly change; a mapping of name to weight.

    Attributes
    ----------
    weights : dict of str to float
        Change of each unknown along the direction, in its own unit; the largest is one range between bounds.
    error : float
        Standard error along it, in units of the weights; infinite if the records do not depend on it at all. Known
        only to lie between its bounds, an unknown has 0.29.
    at : dict of str to float
        Values at which the fit ended.
    """

    weights: dict[str, float]
    error: float
    at: dict[str, float]

    def __getitem__(self, name: str) -> float:
        return self.weights[name]

    def __iter__(self) -> Iterator[str]:
        return iter(self.weights)

    def __len__(self) -> int:
        return len(self.weights)

    def __str__(self) -> str:
        *most, last = self.weights
        if not most:
            many = abs(self.error * self.weights[last])
            return f"the records do not fix {last}" + ("" if np.isinf(many) else f": its standard error is {many:.2g}")
        moves = ", ".join(f"{n} by {self._change(n)}" for n in self.weights)
        names = f"{', '.join(most)} and {last}"
        return f"the records fix {names} only in a combination: they hardly notice a change of {moves}"

    def _change(self, name: str) -> str:
        """Return a small change along the direction in words, relative to the value if there is one."""
        small = 0.01 * self.weights[name]
        value = self.at[name]
        return f"{100 * small / abs(value):+.2g} %" if abs(value) > 10 * abs(small) else f"{small:+.2g}"

    def __repr__(self) -> str:
        return f"Direction({ {n: float(f'{w:.3g}') for n, w in self.weights.items()} }, error={self.error:.3g})"


class Uncertainty(NamedTuple):
    """Uncertainty of the unknowns, from the Jacobian.

    Attributes
    ----------
    covariance : ndarray, shape (n_p, n_p)
        NaN in rows of unknowns at a bound; infinite on the diagonal where nothing fixes them.
    errors : ndarray, shape (n_p,)
        Standard errors.
    correlation : ndarray, shape (n_p, n_p)
    directions : tuple of Direction
    """

    covariance: np.ndarray
    errors: np.ndarray
    correlation: np.ndarray
    directions: tuple[Direction, ...]


def uncertainty(
    names: Sequence[str],
    values: np.ndarray,
    jacobian: np.ndarray,
    bound: np.ndarray,
    variance: float,
    ranges: np.ndarray | None = None,
) -> Uncertainty:
    """Return covariance and directions.

    Parameters
    ----------
    names : sequence of str
    values : ndarray, shape (n_p,)
    jacobian : ndarray, shape (n, n_p)
        Of the weighted residuals by the values.
    bound : ndarray of bool, shape (n_p,)
        Which unknowns ended at a bound. They are free like the others, so that errors of the others contain that the
        truth may lie off the bound; they have no standard error themselves, because estimates do not scatter on both
        sides of a bound.
    variance : float
        Of a weighted residual.
    ranges : ndarray, shape (n_p,), optional
        Distances between the bounds, with which directions are judged; the sizes of the values unless given.

    Notes
    -----
    ``variance (J' J)^-1`` by the singular values of J with its columns scaled to unit length, which is as accurate as
    the units allow; see Golub and Van Loan, Matrix Computations, 4th edition, section 5.3.
    """
    ranges = np.where(values == 0, 1.0, np.abs(values)) if ranges is None else ranges
    own: np.ndarray = np.asarray(np.linalg.qr(jacobian, mode="r"))  # the same J'J, few rows
    reach = np.linalg.norm(own * ranges, axis=0)
    size = np.where(reach > SINGULAR * np.max(reach, initial=0.0), np.linalg.norm(own, axis=0), 0.0)
    own = np.where(size > 0, own, 0.0)
    _, singular, axes = np.linalg.svd(own / np.where(size > 0, size, 1.0), full_matrices=False)
    lost = singular <= SINGULAR * max(1.0, float(np.max(singular, initial=0.0)))
    with np.errstate(divide="ignore", invalid="ignore"):
        inverse = (axes.T * np.where(lost, 0.0, 1.0 / singular**2)) @ axes
        covariance = variance * inverse / np.outer(size, size)
    loose = (size == 0) | np.any(np.abs(axes[lost]) > 1e-6, axis=0)
    covariance[loose], covariance[:, loose] = np.nan, np.nan
    covariance[loose, loose] = np.inf
    covariance[bound], covariance[:, bound] = np.nan, np.nan
    errors = np.sqrt(np.diag(covariance))
    with np.errstate(invalid="ignore", divide="ignore"):
        correlation = covariance / np.outer(errors, errors)
    np.fill_diagonal(correlation, 1.0)
    return Uncertainty(covariance, errors, correlation, _directions(names, values, own, variance, ranges))


def _directions(
    names: Sequence[str], values: np.ndarray, own: np.ndarray, variance: float, ranges: np.ndarray
) -> tuple[Direction, ...]:
    """Return the directions whose standard error is as large as that of knowing nothing but the bounds."""
    _, singular, axes = np.linalg.svd(own * ranges, full_matrices=True)
    singular = np.concatenate([singular, np.zeros(len(names) - singular.size)])
    directions = []
    for value, axis in zip(singular[::-1], axes[::-1], strict=True):
        lost = value <= SINGULAR * singular[0]
        error = np.inf if lost else float(np.sqrt(variance) / value)
        if error < UNFIXED:
            break
        largest = axis[np.argmax(np.abs(axis))]
        axis, error = axis / largest, error * abs(largest)
        told = {names[k]: float(w * ranges[k]) for k, w in enumerate(axis) if abs(w) > SMALLEST}
        directions.append(Direction(told, error, {n: float(values[list(names).index(n)]) for n in told}))
    return tuple(directions)
