"""Friction of gears and bearings, two straight lines over the speed, from measured points: exact least squares."""

from dataclasses import dataclass, field
from typing import Any

import numpy as np

from symfric.axes import Axes, new_axes
from symfric.errors import NotFound, SceneError
from symfric.locks import DRAWING, SYMBOLIC, alone
from symfric.model import laws
from symfric.model.laws import Law
from symfric.model.results import Drawable, Result
from symfric.model.symbols import numbers_of

NAMES = ("at_rest", "slope_below", "slope_above", "corner")
_STRAIGHT = 1e-9  # difference of the slopes, relative to them, below which there is no corner


@dataclass(frozen=True, repr=False)
class TwoLines(Result, Drawable):
    """Two straight lines through points of speed and friction that meet at a corner.

    `plot` draws the points and the two lines.

    Attributes
    ----------
    at_rest : float
        Coefficient of friction at the speed 0, of the first line.
    slope_below, slope_above : float
        Slopes below and above the corner, 1 over the unit of speed.
    corner : float
        Speed of the corner.
    standard_errors : dict of str to float
        Of these four; NaN from four points without `sigma`.
    deviation : float
        Standard deviation of the points from the lines, estimated from n - 4 degrees of freedom.
    points : tuple of ndarray
        Speeds and coefficients, sorted.

    Examples
    --------
    >>> import numpy as np
    >>> import symfric as sf
    >>> v = np.linspace(0.2, 10.0, 25)
    >>> gear = sf.laws.piecewise_linear(0.05, [0.0, 2.0], [0.05, 0.014], last_slope=0.0012)
    >>> fit = sf.theory.two_lines(v, gear(v), sigma=0.001)
    >>> round(fit.corner, 6)
    2.0
    >>> sorted(fit.to_dict())[:2]
    ['at_rest', 'corner']
    >>> ax = fit.plot()
    """

    at_rest: float
    slope_below: float
    slope_above: float
    corner: float
    standard_errors: dict[str, float]
    deviation: float
    points: tuple[np.ndarray, np.ndarray] = field(compare=False)

    @property
    def law(self) -> Law:
        """The law of friction, `symfric.laws.piecewise_linear`; static friction as at rest."""
        value = self.at_rest + self.slope_below * self.corner
        ends = [self.at_rest, value]
        return laws.piecewise_linear(self.at_rest, [0.0, self.corner], ends, last_slope=self.slope_above)

    def __repr__(self) -> str:
        words = (f"{name} = {getattr(self, name):.6g} +- {self.standard_errors[name]:.2g}" for name in NAMES)
        return f"TwoLines({', '.join(words)})"

    def _draw(self, ax: Axes | None) -> Axes:
        with DRAWING:
            ax = new_axes() if ax is None else ax
            speed, friction = self.points
            ax.plot(speed, friction, "o", markersize=4, label="measured")
            ends = np.array([0.0, self.corner, max(speed[-1], self.corner)])
            rise = np.maximum(ends - self.corner, 0.0) * (self.slope_above - self.slope_below)
            ax.plot(ends, self.at_rest + self.slope_below * ends + rise, label="two lines")
            ax.set_xlabel("speed")
            ax.set_ylabel("coefficient of friction")
            ax.legend()
        return ax


@alone(SYMBOLIC)
def two_lines(speed: Any, friction: Any, sigma: Any = None) -> TwoLines:
    """Fit the friction of a gear or a bearing, two straight lines that meet, to points of speed and friction.

    Parameters
    ----------
    speed, friction : array_like, shape (n,)
        Speeds >= 0 and coefficients, n >= 4, at two or more speeds on each side of the corner.
    sigma : float or array_like, shape (n,), optional
        Standard deviation of the coefficients; estimated unless given.

    Returns
    -------
    TwoLines

    Raises
    ------
    NotFound
        If one straight line does as well, so that there is no corner.
    SceneError
        If an argument is wrong.

    Notes
    -----
    The handbook's model of rotational interfaces, section 19.5.1 and figure 19.19: a sharp fall, then a moderate rise.
    The corner is unknown, which makes the problem nonlinear, but for given points on each side it is linear: two lines
    with their intersection between the sides, or else a corner at a point (Hudson, Fitting segmented curves whose join
    points have to be estimated, J. Am. Stat. Assoc. 61 (1966)). All sides are tried, so that the least squares are
    global. The standard errors are those of the linearised model. Proved in derivations/handbook/models.py.

    Examples
    --------
    >>> import numpy as np
    >>> import symfric as sf
    >>> v = np.linspace(0.2, 10.0, 25)
    >>> gear = sf.laws.piecewise_linear(0.05, [0.0, 2.0], [0.05, 0.014], last_slope=0.0012)
    >>> fit = sf.theory.two_lines(v, gear(v), sigma=0.001)
    >>> f"{fit.slope_below:.4f}, {fit.slope_above:.4f}, corner {fit.corner:.4f} +- {fit.standard_errors['corner']:.3f}"
    '-0.0180, 0.0012, corner 2.0000 +- 0.052'
    """
    v, y, weight = _read(speed, friction, sigma)
    best: tuple[float, float] = (np.inf, np.nan)
    different = (np.flatnonzero(np.diff(v) > 0) + 1).tolist()  # first points of the upper side
    sides = [k for k in different if v[k - 1] > v[0] and v[-1] > v[k]]
    for corner in _candidates(v, y, weight, sides):
        best = min(best, (_misfit(v, y, weight, corner)[0], corner))
    if not np.isfinite(best[0]):
        raise SceneError("two lines need two or more speeds on each side of the corner")
    _, (at_rest, below, change) = _misfit(v, y, weight, best[1])
    if abs(change) <= _STRAIGHT * (abs(below) + abs(change) + np.ptp(y) / np.ptp(v)):
        raise NotFound("one straight line does as well; there is no corner")
    corner = float(best[1])
    errors, deviation = _errors(v, weight, best[0], (change, corner), sigma is not None)
    return TwoLines(float(at_rest), float(below), float(below + change), corner, errors, deviation, (v, y))


def _read(speed: Any, friction: Any, sigma: Any) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return sorted speeds, coefficients and weights."""
    v, y = numbers_of(speed, "speed"), numbers_of(friction, "friction")
    if v.ndim != 1 or v.shape != y.shape or v.size < 4:
        raise SceneError(f"speed and friction have shapes {v.shape} and {y.shape}; give rows of four or more points")
    if not (np.all(np.isfinite(v)) and np.all(np.isfinite(y)) and np.all(v >= 0)):
        raise SceneError("speeds and coefficients are finite, and the speeds not negative")
    s = numbers_of(1.0 if sigma is None else sigma, "sigma")
    if s.ndim > 1 or (s.ndim == 1 and s.shape != v.shape) or not np.all(np.isfinite(s) & (s > 0)):
        raise SceneError("sigma is one positive number, or one for each point")
    order = np.argsort(v, kind="stable")
    return v[order], y[order], (np.broadcast_to(1 / s, v.shape))[order]


def _candidates(v: np.ndarray, y: np.ndarray, weight: np.ndarray, sides: list[int]) -> list[float]:
    """Return the corners that may be the best: inner speeds, and intersections that lie between their sides."""
    corners = [float(e) for e in np.unique(v)[1:-1]]
    for k in sides:
        (a, b), (c, d) = (_line(v[part], y[part], weight[part]) for part in (slice(None, k), slice(k, None)))
        if b != d and v[k - 1] <= (corner := (a - c) / (d - b)) <= v[k]:
            corners.append(float(corner))
    return corners


def _line(v: np.ndarray, y: np.ndarray, weight: np.ndarray) -> tuple[float, float]:
    """Return a and b of the weighted line ``a + b v``."""
    w = weight**2 / np.sum(weight**2)
    middle, mean = w @ v, w @ y
    slope = (w * (v - middle)) @ (y - mean) / ((w * (v - middle)) @ (v - middle))
    return mean - slope * middle, slope


def _misfit(v: np.ndarray, y: np.ndarray, weight: np.ndarray, corner: float) -> tuple[float, np.ndarray]:
    """Return the weighted sum of squares with a given corner, and value at rest, slope, and change of slope."""
    rows = np.column_stack([np.ones_like(v), v, np.maximum(v - corner, 0.0)]) * weight[:, None]
    size = np.linalg.norm(rows, axis=0)
    coefficients = np.linalg.lstsq(rows / size, y * weight, rcond=None)[0] / size
    return float(np.sum((rows @ coefficients - y * weight) ** 2)), coefficients


def _errors(
    v: np.ndarray, weight: np.ndarray, misfit: float, kink: tuple[float, float], known: bool
) -> tuple[dict[str, float], float]:
    """Return the standard errors and the deviation of the points, whose own is known or estimated."""
    change, corner = kink
    above = v > corner
    rows = np.column_stack([np.ones_like(v), np.minimum(v, corner), np.maximum(v - corner, 0.0), -change * above])
    freedom = v.size - len(NAMES)
    variance = misfit / freedom if freedom else np.nan
    _, singular, axes = np.linalg.svd(rows * weight[:, None], full_matrices=False)
    inverse = np.sum((axes / singular[:, None]) ** 2, axis=0) if singular[-1] > 0 else np.full(len(NAMES), np.inf)
    errors = np.sqrt(inverse * (1.0 if known else variance))
    return dict(zip(NAMES, errors.tolist(), strict=True)), float(np.sqrt(variance / np.mean(weight**2)))
