"""Vibration across the sliding direction against vibration along it, at equal intensity and at equal power."""

from dataclasses import dataclass
from typing import Any

import numpy as np

from symfric.axes import Axes, axes_for
from symfric.errors import NotFound, SceneError
from symfric.model.laws import Law
from symfric.model.results import ArrayResult, Drawable, Labelled
from symfric.model.symbols import numbers_of, positive
from symfric.search import zero
from symfric.spelling import spelt
from symfric.theory.plane.vibration import (
    lateral_vibration_drag,
    lateral_vibration_power,
    longitudinal_vibration_drag,
    longitudinal_vibration_power,
)

_DECADES = np.geomspace(1e-3, 1e6, 109)  # of the intensity over the speed, searched for an equal drag or power


@dataclass(frozen=True, eq=False, repr=False)
class VibrationComparison(ArrayResult, Drawable):
    """Drag and power of fast vibration across and along the sliding direction, per normal load.

    Attributes
    ----------
    speed : float
        Of the sliding.
    intensity : ndarray, shape (n,)
        Amplitude of the fast velocity, the same in both directions.
    lateral_drag, longitudinal_drag : ndarray, shape (n,)
        Mean friction against the sliding, dimensionless.
    lateral_power, longitudinal_power : ndarray, shape (n,)
        That maintains the vibration, coefficient times speed.
    same_power_intensity, same_power_drag : ndarray, shape (n,)
        Of vibration along that takes the power which vibration across of this intensity takes; NaN where none does.

    Examples
    --------
    >>> import symfric as sf
    >>> found = sf.theory.plane.compare_vibration([0.5, 1.0, 2.0])
    >>> found.better
    ('across', 'across', 'along')
    >>> bool((found.same_power_drag < found.lateral_drag).all())
    True
    >>> found.to_xarray()["lateral_drag"].dims
    ('intensity',)
    """

    speed: float
    intensity: np.ndarray
    lateral_drag: np.ndarray
    longitudinal_drag: np.ndarray
    lateral_power: np.ndarray
    longitudinal_power: np.ndarray
    same_power_intensity: np.ndarray
    same_power_drag: np.ndarray

    @property
    def better(self) -> tuple[str, ...]:
        """Which direction leaves less drag at equal intensity, "across", "along" or "equal"."""
        return _words(self.lateral_drag, self.longitudinal_drag)

    @property
    def better_for_power(self) -> tuple[str, ...]:
        """Which direction leaves less drag at equal power, "across", "along", "equal", or "unknown"."""
        return _words(self.lateral_drag, self.same_power_drag)

    def _labelled(self) -> Labelled:
        named = ("lateral_drag", "longitudinal_drag", "lateral_power", "longitudinal_power", "same_power_intensity")
        data = {name: ("intensity", getattr(self, name)) for name in (*named, "same_power_drag")}
        return data, {"intensity": self.intensity}, {"speed": self.speed}

    def _draw(self, ax: Axes | None) -> Axes:
        ax = axes_for(ax)
        ax.plot(self.intensity, self.lateral_drag, label="across")
        ax.plot(self.intensity, self.longitudinal_drag, "--", label="along, equal intensity")
        ax.plot(self.intensity, self.same_power_drag, ":", label="along, equal power")
        ax.set(xlabel="intensity of the vibration", ylabel="mean drag / normal load")
        ax.legend(frameon=False)
        return ax

    def __repr__(self) -> str:
        ends = f"{self.intensity.min():.3g} to {self.intensity.max():.3g}" if self.intensity.size else "none"
        return f"VibrationComparison(speed {self.speed:.6g}; intensities: {ends})"


@spelt
def compare_vibration(intensities: Any, speed: float = 1.0, law: Law | None = None) -> VibrationComparison:
    """Compare vibration across the sliding direction with vibration along it.

    Parameters
    ----------
    intensities : array_like, shape (n,)
        Amplitudes of the fast velocity, >= 0.
    speed : float
        Of the sliding, > 0.
    law : Law, optional
        In numbers; Coulomb friction with the coefficient 1 by default.

    Returns
    -------
    VibrationComparison

    Raises
    ------
    SceneError
        If a number is out of range or the law has symbols.

    Notes
    -----
    Coulomb friction: along, nothing happens below the sliding speed, while across takes off ``q^2/(4 v^2)``; from
    `equal_drag_ratio` on vibration along leaves less, in the limit less by the factor ``ln(4 q/v)``. At equal power
    vibration along leaves less drag always: the same little power takes off twice as much. Laws that depend on the
    speed shift this; derivations/plane.

    Examples
    --------
    >>> import symfric as sf
    >>> found = sf.theory.plane.compare_vibration([0.05])
    >>> print(f"{((1 - found.same_power_drag) / (1 - found.lateral_drag))[0]:.3f}")
    2.001
    """
    v = positive(speed, "speed")
    q = np.atleast_1d(numbers_of(intensities, "intensities"))
    if q.ndim != 1:
        raise SceneError(f"intensities has the shape {q.shape}; give a list of numbers")
    lateral, power = lateral_vibration_drag(v, q, law), lateral_vibration_power(v, q, law)
    same = np.array([_intensity_along(v, float(p), law) for p in power])
    known = np.isfinite(same)
    drag = np.full(q.shape, np.nan)
    drag[known] = longitudinal_vibration_drag(v, same[known], law)
    along = longitudinal_vibration_drag(v, q, law), longitudinal_vibration_power(v, q, law)
    return VibrationComparison(v, q, lateral, along[0], power, along[1], same, drag)


@spelt
def equal_drag_ratio(speed: float = 1.0, law: Law | None = None) -> float:
    """Return the intensity over the sliding speed at which vibration across and along leave the same drag.

    Parameters
    ----------
    speed : float
        Of the sliding, > 0; without effect on Coulomb friction.
    law : Law, optional
        In numbers; Coulomb friction by default.

    Returns
    -------
    float
        The smallest one above which vibration along leaves less.

    Raises
    ------
    NotFound
        If one direction leaves less at every intensity between a thousandth of and a million times the speed.
    SceneError
        If a number is out of range or the law has symbols.

    Examples
    --------
    >>> import symfric as sf
    >>> f"{sf.theory.plane.equal_drag_ratio():.6f}"
    '1.038592'
    """
    v = positive(speed, "speed")

    def gap(ratio: float) -> float:
        return float(lateral_vibration_drag(v, ratio * v, law) - longitudinal_vibration_drag(v, ratio * v, law))

    values = np.array([gap(r) for r in _DECADES])
    for k in np.flatnonzero((values[:-1] < 0) & (values[1:] >= 0)):
        return zero(gap, _DECADES[k], _DECADES[k + 1], rtol=1e-15)
    raise NotFound("one direction of the vibration leaves less drag at every intensity; see compare_vibration")


def _intensity_along(v: float, power: float, law: Law | None) -> float:
    """Return the least intensity of vibration along that takes a power, NaN if none does."""
    if power <= 0:
        return 0.0 if power == 0 else float("nan")
    if law is None:
        return float(np.hypot(v, np.pi * power / 2))

    def gap(q: float) -> float:
        return float(longitudinal_vibration_power(v, q, law)) - power

    grid = v * np.unique([*_DECADES, 1.0])
    below = 0.0
    for q in grid:
        if gap(q) >= 0:
            return zero(gap, below, q)
        below = q
    return float("nan")


def _words(across: np.ndarray, along: np.ndarray) -> tuple[str, ...]:
    known = np.isfinite(across - along)
    words = np.select([~known, across < along, along < across], ["unknown", "across", "along"], "equal")
    return tuple(str(w) for w in words)
