"""Response spectra: the largest displacement of damped oscillators on shaking ground."""

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, TypeVar

import numpy as np

from symfric.axes import Axes, axes_for
from symfric.errors import SceneError
from symfric.model.numeric import Floats
from symfric.model.results import ArrayResult, Drawable, Labelled
from symfric.model.symbols import finite

if TYPE_CHECKING:
    from symfric.motions.motion import Motion

FINE = 20  # points per period, between which peaks are computed
FINEST = 10  # largest ratio of the record's step to a period
_MARGIN = 1 + 2 * math.pi / FINE  # an acceleration between samples: abs(z) grows by the step times the shaking there
_TERMS = 14  # terms of the series of phi functions, exact to rounding for arguments up to 2 pi/FINE
_Complex = TypeVar("_Complex", complex, np.ndarray)


@dataclass(frozen=True, eq=False, repr=False)
class Spectrum(ArrayResult, Drawable):
    """Response spectrum of a motion.

    `plot` draws pseudo-acceleration against period.

    Attributes
    ----------
    periods : ndarray, shape (n,)
        s; 0 is a rigid oscillator.
    damping : float
        Ratio to the critical one.
    displacement : ndarray, shape (n,)
        Largest magnitude relative to the ground, m.
    pseudo_velocity, pseudo_acceleration : ndarray, shape (n,)
        2 pi/T and (2 pi/T)^2 times `displacement`, m/s and m/s^2; the acceleration is the motion's PGA at period 0.
    name : str
        Of the motion.

    Examples
    --------
    >>> import symfric as sf
    >>> quake = sf.motions.sine_burst(3.0, 2.0, cycles=5)
    >>> spectrum = quake.spectrum([0.3, 0.5, 1.0])
    >>> spectrum.displacement.round(6)
    array([0.011005, 0.105617, 0.034009])
    >>> sorted(spectrum.to_dict())[:2]
    ['damping', 'displacement']
    >>> len(spectrum.to_xarray().data_vars) > 0
    True
    >>> ax = spectrum.plot()
    """

    periods: np.ndarray
    damping: float
    displacement: np.ndarray
    pseudo_velocity: np.ndarray
    pseudo_acceleration: np.ndarray
    name: str
    _told = ("name", "damping", "periods", "displacement", "pseudo_velocity", "pseudo_acceleration")

    def _labelled(self) -> Labelled:
        units = {"displacement": "m", "pseudo_velocity": "m/s", "pseudo_acceleration": "m/s^2"}
        data = {k: ("period", getattr(self, k), {"units": unit}) for k, unit in units.items()}
        return data, {"period": self.periods}, {"damping": self.damping, "motion": self.name}

    def _draw(self, ax: Axes | None) -> Axes:
        ax = axes_for(ax)
        ax.plot(self.periods, self.pseudo_acceleration, label=f"{self.name}, {100 * self.damping:g} % damping")
        ax.set_xlabel("period T [s]")
        ax.set_ylabel("pseudo-acceleration [m/s²]")
        ax.legend(loc="best", fontsize="small")
        return ax

    def __repr__(self) -> str:
        return f"Spectrum({self.name}, {self.periods.size} periods, damping {self.damping:g})"


def read_periods(periods: Floats) -> np.ndarray:
    """Return periods as an array of finite numbers, not negative."""
    try:
        row = np.atleast_1d(np.array(periods, dtype=float))
    except (TypeError, ValueError):
        raise SceneError("the periods are no numbers; give a row of seconds") from None
    if row.ndim != 1 or not row.size or not np.all(np.isfinite(row)) or np.min(row) < 0:
        raise SceneError("the periods must be a row of finite numbers, not negative")
    return row


def spectrum(motion: "Motion", periods: Floats, damping: float = 0.05) -> Spectrum:
    """Compute the response spectrum of a motion.

    Parameters
    ----------
    motion : Motion
    periods : sequence of float
        s; 0, or at least a tenth of the motion's step.
    damping : float
        Ratio to the critical one, at least 0 and below 1.

    Returns
    -------
    Spectrum

    Notes
    -----
    ``x'' + 2 zeta omega x' + omega^2 x = -a(t)`` from rest. With ``lambda = omega (-zeta + i sqrt(1 - zeta^2))`` and
    ``z = x' - conj(lambda) x`` this is ``z' = lambda z - a``, which is integrated exactly over each straight piece of
    the record (phi functions, as a recursive filter of `scipy.signal`). The peak of abs(x) is not that of the samples:
    wherever the velocity changes its sign on a grid of at least 20 points per period, its zero is found in the closed
    form. Half a cycle of free vibration after the record counts too.
    """
    row, damping = read_periods(periods), finite(damping, "damping")
    if not 0 <= damping < 1:
        raise SceneError(f"damping is {damping}; it is a ratio to the critical damping, at least 0 and below 1")
    shortest = row[row > 0].min(initial=np.inf)
    if shortest < motion.dt / FINEST:
        raise SceneError(
            f"the period {shortest:g} s is shorter than a tenth of the step {motion.dt:g} s of {motion.name}; "
            "leave it out, or ask for 0, which gives the PGA"
        )
    peak = np.array([_peak(motion, 2 * math.pi / T, damping) if T else 0.0 for T in row])
    omega = np.divide(2 * math.pi, row, out=np.zeros_like(row), where=row > 0)
    pseudo = np.where(row > 0, omega**2 * peak, motion.pga)
    return Spectrum(row, damping, peak, omega * peak, pseudo, motion.name)


def _peak(motion: "Motion", omega: float, damping: float) -> float:
    """Return the largest abs(x) of one oscillator."""
    eigenvalue = omega * complex(-damping, math.sqrt(1 - damping**2))
    h, a = _fine(motion, 2 * math.pi / (FINE * omega))
    z = filtered(a, h, eigenvalue)
    driven = _extreme(z, a[:-1], np.diff(a) / h, h, eigenvalue)
    if abs(z[-1]) <= driven * eigenvalue.imag:  # abs(z) decays after the record, and abs(Im z) is no larger
        return driven
    cycle = 2 * math.pi / (2 * FINE * omega)
    free = z[-1] * np.exp(eigenvalue * cycle * np.arange(2 * FINE + 1))
    return max(driven, _extreme(free, np.zeros(2 * FINE), np.zeros(2 * FINE), cycle, eigenvalue))


def _fine(motion: "Motion", longest: float) -> tuple[float, np.ndarray]:
    """Return a step no longer than `longest` that divides the motion's, and the samples at it."""
    parts = max(1, math.ceil(motion.dt / longest * (1 - 1e-12)))
    if parts == 1:
        return motion.dt, motion.samples
    a = motion.samples
    rows = a[:-1, None] + np.diff(a)[:, None] * (np.arange(parts) / parts)
    return motion.dt / parts, np.append(rows.ravel(), a[-1])


def _phi(w: _Complex) -> tuple[_Complex, _Complex]:
    """Return (e^w - 1)/w and (e^w - 1 - w)/w^2 by their series, for abs(w) below one."""
    tail = 1.0 + w / _TERMS
    for k in range(_TERMS - 1, 2, -1):
        tail = 1.0 + w * tail / k
    return 1.0 + 0.5 * w * tail, 0.5 * tail


def filtered(a: np.ndarray, h: float, eigenvalue: complex) -> np.ndarray:
    """Return z at the samples, from rest: ``z' = eigenvalue z - a`` with a straight between its samples."""
    from scipy.signal import lfilter

    one, two = _phi(eigenvalue * h)
    forward = np.array([-h * two, -h * (one - two)])
    z, _ = lfilter(forward, [1.0, -np.exp(eigenvalue * h)], a, zi=[-forward[0] * a[0]])
    return np.asarray(z)


def _extreme(z: np.ndarray, a: np.ndarray, slope: np.ndarray, h: float, eigenvalue: complex) -> float:
    """Return the largest abs(x) over intervals of length h that start at z[k] under ``a[k] + slope[k] tau``.

    Between two samples x exceeds the larger one by at most ``h^2/8`` times its largest acceleration, so most intervals
    in which the velocity changes its sign cannot hold the largest value, and are let go.
    """
    lean = eigenvalue.real / eigenvalue.imag  # the velocity is Re z + lean Im z
    speed, size = z.real + lean * z.imag, np.abs(z.imag)
    largest = float(np.max(size))
    shaking = max(np.max(np.abs(a)), abs(a[-1] + h * slope[-1]))
    swift = math.hypot(1.0, lean) * (abs(eigenvalue) * np.max(np.abs(z)) + _MARGIN * shaking)
    room = h**2 / 8 * swift * eigenvalue.imag
    high = np.maximum(size[:-1], size[1:]) >= largest - room
    turn = np.flatnonzero(high & (speed[:-1] * speed[1:] < 0))
    if turn.size:
        z, a, slope = z[turn], a[turn], slope[turn]
        tau = h * speed[turn] / (speed[turn] - speed[turn + 1])
        for _ in range(4):
            at = _state(z, a, slope, tau, eigenvalue)
            v = at.real + lean * at.imag
            rate = eigenvalue * at - (a + slope * tau)
            acceleration = rate.real + lean * rate.imag
            tau = np.clip(tau - np.divide(v, acceleration, out=np.zeros_like(v), where=acceleration != 0), 0.0, h)
        largest = max(largest, np.max(np.abs(_state(z, a, slope, tau, eigenvalue).imag)))
    return float(largest / eigenvalue.imag)


def _state(z: np.ndarray, a: np.ndarray, slope: np.ndarray, tau: np.ndarray, eigenvalue: complex) -> np.ndarray:
    """Return z a time tau later."""
    one, two = _phi(eigenvalue * tau)
    return np.asarray(np.exp(eigenvalue * tau) * z - tau * (a * one + slope * tau * two))
