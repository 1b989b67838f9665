"""A ground motion: acceleration at a constant time step."""

from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING, Any

import numpy as np

from symfric.axes import Axes, axes_for
from symfric.errors import SceneError
from symfric.model.notebook import html_table
from symfric.model.numeric import Floats
from symfric.model.results import Drawable, Result
from symfric.model.symbols import finite
from symfric.model.system import Signal
from symfric.motions.units import G, factor_of
from symfric.spelling import spelt

if TYPE_CHECKING:
    from symfric.motions.spectrum import Spectrum

_WHOLE = 1e-9  # distance from a sample, relative to the step, within which a time is that of the sample


@spelt
@dataclass(frozen=True, eq=False, repr=False)
class Motion(Result, Drawable):
    """Acceleration of the ground, linear between its samples.

    `plot` draws acceleration against time.

    Attributes
    ----------
    samples : ndarray, shape (n,)
        At least two. In `unit` when given, in m/s^2 ever after.
    dt : float
        Sampling interval, s.
    unit : str
        'g', 'm/s^2', 'cm/s^2', 'gal' or 'mm/s^2' when given; 'm/s^2' ever after.
    name, note : str
        For reading: the name of the file, what its header says.

    Examples
    --------
    >>> import symfric as sf
    >>> quake = sf.motions.sine_burst(3.0, 2.0, cycles=5)
    >>> quake
    Motion(sine burst, 1001 samples, dt=0.0025 s, PGA 0.3058 g)
    >>> quake.pga, round(quake.duration, 6)
    (3.0, 2.5)
    >>> round(quake.scaled(0.3, "g").pga_g, 6)
    0.3
    >>> round(quake.times(2.0).pga, 6)
    6.0
    >>> round(quake.resampled(0.01).dt, 6)
    0.01
    >>> quake.signal().dt == quake.dt
    True
    >>> quake.spectrum([0.5]).pseudo_acceleration.round(6)
    array([16.678323])
    >>> sorted(quake.to_dict())[:2]
    ['dt', 'name']
    >>> quake.to_xarray().dims
    ('t',)
    >>> ax = quake.plot()
    """

    samples: np.ndarray
    dt: float
    unit: str = "m/s^2"
    name: str = "motion"
    note: str = field(default="")

    def __post_init__(self):
        factor = factor_of(self.unit, f"the unit of {self.name}")
        try:
            samples = np.array(self.samples, dtype=float)
        except (TypeError, ValueError):
            raise SceneError(f"the samples of {self.name} are no numbers; give a row of accelerations") from None
        if samples.ndim != 1 or samples.size < 2:
            raise SceneError(f"{self.name} has samples of shape {samples.shape}; give a row of at least two")
        if factor != 1.0:
            with np.errstate(over="ignore"):
                samples *= factor
        if not np.all(np.isfinite(samples)):
            number = int(np.flatnonzero(~np.isfinite(samples))[0])
            raise SceneError(f"sample {number} of {self.name} is not finite in m/s^2")
        samples.setflags(write=False)
        object.__setattr__(self, "samples", samples)
        object.__setattr__(self, "unit", "m/s^2")
        object.__setattr__(self, "dt", finite(self.dt, f"dt of {self.name}"))
        if self.dt <= 0:
            raise SceneError(f"dt of {self.name} is {self.dt}; it must be positive")

    @property
    def pga(self) -> float:
        """Largest magnitude, m/s^2."""
        return float(np.max(np.abs(self.samples)))

    @property
    def pga_g(self) -> float:
        """Largest magnitude in units of g = 9.81 m/s^2."""
        return self.pga / G

    @property
    def duration(self) -> float:
        """Time from the first to the last sample, s."""
        return self.dt * (self.samples.size - 1)

    @property
    def t(self) -> np.ndarray:
        """Times of the samples from 0, shape (n,)."""
        return self.dt * np.arange(self.samples.size)

    @property
    def final_velocity(self) -> float:
        """Velocity at the end, m/s; exact for linear interpolation of the samples."""
        a = self.samples
        return float(self.dt * (a.sum() - 0.5 * (a[0] + a[-1])))

    def scaled(self, pga: float, unit: str = "m/s^2") -> "Motion":
        """Return the motion with another peak acceleration, given in `unit`.

        Parameters
        ----------
        pga : float
            In `unit`.
        unit : str

        Returns
        -------
        Motion

        Raises
        ------
        SceneError
            If pga is not positive, or the motion is zero.
        """
        target = finite(pga, "pga") * factor_of(unit, "the unit of pga")
        if target <= 0:
            raise SceneError(f"pga is {pga}; it must be positive")
        if self.pga == 0:
            raise SceneError(f"{self.name} is zero throughout; it cannot be scaled to a peak")
        return self.times(target / self.pga)

    def times(self, factor: float) -> "Motion":
        """Return the motion with every sample multiplied.

        Parameters
        ----------
        factor : float

        Returns
        -------
        Motion
        """
        return replace(self, samples=self.samples * finite(factor, "factor"))

    def resampled(self, dt: float) -> "Motion":
        """Return the motion at another step, by linear interpolation.

        The same motion if `dt` divides the present step. A longer step skips samples, with their peaks, and nothing is
        filtered; the part of the record beyond the last whole step is left out.

        Parameters
        ----------
        dt : float
            New sampling interval, s.

        Returns
        -------
        Motion

        Raises
        ------
        SceneError
            If dt is not positive.
        """
        dt = finite(dt, "dt")
        if not 0 < dt <= self.duration * (1 + _WHOLE):
            raise SceneError(f"dt is {dt:g}; {self.name} can be resampled at steps up to its {self.duration:g} s")
        count = int(np.floor(self.duration / dt + _WHOLE)) + 1
        place = np.arange(count) * (dt / self.dt)
        whole = np.rint(place)
        place = np.where(np.abs(place - whole) < _WHOLE * np.maximum(whole, 1.0), whole, place)
        left = np.minimum(place.astype(int), self.samples.size - 2)
        a = self.samples
        part = place - left
        between = a[left] + part * (a[left + 1] - a[left])
        return replace(self, samples=np.where(part == 1.0, a[left + 1], between), dt=dt)

    def signal(self, t0: float = 0.0) -> Signal:
        """Return the input of a scene: ``inputs={a_g: motion.signal()}``.

        Parameters
        ----------
        t0 : float
            Time of its first sample.

        Returns
        -------
        Signal
        """
        return Signal(self.samples, self.dt, t0, self.unit)

    def spectrum(self, periods: Floats, damping: float = 0.05) -> "Spectrum":
        """Return the response spectrum; see `symfric.motions.spectrum.spectrum`.

        Parameters
        ----------
        periods : sequence of float
            s.
        damping : float
            Damping ratio.

        Returns
        -------
        Spectrum
        """
        from symfric.motions.spectrum import spectrum

        return spectrum(self, periods, damping)

    def _draw(self, ax: Axes | None) -> Axes:
        ax = axes_for(ax)
        ax.plot(self.t, self.samples, lw=0.8)
        ax.set_xlabel("time t [s]")
        ax.set_ylabel("acceleration [m/s²]")
        ax.set_title(self.name)
        return ax

    def _repr_html_(self) -> str:
        seen = {"samples": self.samples.size, "dt [s]": self.dt, "duration [s]": self.duration, "PGA [g]": self.pga_g}
        return html_table(self.name, seen | ({"note": self.note} if self.note else {}))

    def to_dict(self) -> dict[str, Any]:
        about = {name: getattr(self, name) for name in ("name", "note", "unit", "dt")}
        return {**about, "npts": self.samples.size, "pga": self.pga, "samples": self.samples.tolist()}

    def to_xarray(self):
        """Return an xarray.DataArray over time.

        Returns
        -------
        xarray.Dataset
        """
        import xarray as xr

        attrs = {"units": self.unit, "dt": self.dt, "note": self.note}
        return xr.DataArray(self.samples, dims="t", coords={"t": self.t}, name=self.name, attrs=attrs)

    def __repr__(self) -> str:
        return f"Motion({self.name}, {self.samples.size} samples, dt={self.dt:g} s, PGA {self.pga_g:.4g} g)"
