"""Search along one variable: values on a grid bracket zeros and minima, Brent's method polishes them."""

from collections.abc import Callable
from typing import NamedTuple, TypeAlias

import numpy as np

Function: TypeAlias = Callable[[float], float]
ROUNDING = 8.881784197001252e-16  # least relative tolerance of Brent's method in SciPy, its default


class Minimum(NamedTuple):
    """Place of a least value, and the value; floats."""

    place: float
    value: float


def zero(
    function: Function, low: float, high: float, *, xtol: float = 1e-300, rtol: float = 1e-14, most: int = 100
) -> float:
    """Return a zero of a function between two ends at which its signs differ, by Brent's method.

    Parameters
    ----------
    function : callable
    low, high : float
        Ends, in any order.
    xtol, rtol : float
        Largest absolute and relative error.
    most : int
        Most iterations.

    Raises
    ------
    ValueError
        If the signs at both ends are the same.
    """
    from scipy.optimize import brentq  # slow to load

    return float(brentq(function, low, high, xtol=xtol, rtol=rtol, maxiter=most))


def changes(values: np.ndarray) -> list[int]:
    """Return every k at which the sign changes strictly between the values k and k + 1."""
    signs = np.sign(values)
    return [int(k) for k in np.flatnonzero(signs[1:] * signs[:-1] < 0)]


def zeros(
    function: Function, grid: np.ndarray, values: np.ndarray, *, xtol: float = 1e-300, rtol: float = 1e-14
) -> list[float]:
    """Return the zeros of a function between the points of a grid at which its sign changes, in the grid's order.

    Parameters
    ----------
    function : callable
    grid, values : ndarray, shape (n,)
        Places and the values there.
    xtol, rtol : float
        As in `zero`.
    """
    return [zero(function, grid[k], grid[k + 1], xtol=xtol, rtol=rtol) for k in changes(values)]


def minimum(function: Function, low: float, high: float, *, xatol: float = 1e-5, most: int = 500) -> Minimum:
    """Return the local minimum of a function that Brent's bounded method finds between two ends.

    Parameters
    ----------
    function : callable
    low, high : float
    xatol : float
        Absolute error of the place.
    most : int
        Most evaluations.
    """
    from scipy.optimize import minimize_scalar

    options = {"xatol": xatol, "maxiter": most}
    best = minimize_scalar(function, bounds=(low, high), method="bounded", options=options)
    return Minimum(float(best.x), float(best.fun))


def valleys(values: np.ndarray) -> list[int]:
    """Return the inner places of a grid whose value is not above those of both neighbours, least value first."""
    inner = np.flatnonzero((values[1:-1] <= values[:-2]) & (values[1:-1] <= values[2:])) + 1
    return [int(k) for k in inner[np.argsort(values[inner], kind="stable")]]


def minimum_near(function: Function, grid: np.ndarray, k: int, *, xatol: float = 1e-5, most: int = 500) -> Minimum:
    """Return the local minimum of a function between the neighbours of point k of a grid; see `minimum`."""
    return minimum(function, grid[max(k - 1, 0)], grid[min(k + 1, len(grid) - 1)], xatol=xatol, most=most)
