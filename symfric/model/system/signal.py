"""A sampled input."""

from dataclasses import dataclass

import numpy as np

from symfric.errors import SceneError
from symfric.locks import SYMBOLIC, alone
from symfric.model.arguments import flag
from symfric.model.symbols import finite, numbers_of
from symfric.spelling import spelt


@spelt
@dataclass(frozen=True, eq=False)
class Signal:
    """A sampled input, linear between its samples, or held from each to the next; zero outside them.

    Attributes
    ----------
    samples : ndarray, shape (n,)
        At least two.
    dt : float
        Sampling interval, > 0.
    t0 : float
        Time of the first sample.
    unit : str or None
        For display only.
    hold : bool
        Whether a sample is held until the next (zero-order hold), the last one for dt, instead of joined by lines.

    Examples
    --------
    >>> import symfric as sf
    >>> signal = sf.Signal([0.0, 1.0, 0.0], dt=0.5, unit="m/s^2")
    >>> round(signal.t_end, 6)
    1.0
    >>> round(float(signal(0.25)), 6)
    0.5
    >>> sf.Signal([2.0, 3.0], dt=0.5, hold=True)([0.0, 0.4, 0.5, 0.9, 1.0]).tolist()
    [2.0, 2.0, 3.0, 3.0, 0.0]
    """

    samples: np.ndarray
    dt: float
    t0: float = 0.0
    unit: str | None = None
    hold: bool = False

    @alone(SYMBOLIC)
    def __post_init__(self) -> None:
        samples = numbers_of(self.samples, "samples")
        if samples.ndim != 1 or samples.size < 2:
            raise SceneError(f"a signal has shape {samples.shape}; give an array of two or more samples")
        if not np.all(np.isfinite(samples)):
            raise SceneError(f"sample {int(np.flatnonzero(~np.isfinite(samples))[0])} of a signal is not finite")
        samples.setflags(write=False)
        object.__setattr__(self, "samples", samples)
        flag(self.hold, "hold")
        object.__setattr__(self, "dt", finite(self.dt, "the sampling interval dt"))
        object.__setattr__(self, "t0", finite(self.t0, "the start t0 of a signal"))
        if self.dt <= 0:
            raise SceneError(f"the sampling interval dt is {self.dt}; it must be positive")

    @property
    def t_end(self) -> float:
        """Time of the last sample, or to which it is held."""
        return self.t0 + self.dt * (self.samples.size - (not self.hold))

    def __call__(self, t: float | np.ndarray) -> np.ndarray:
        """Evaluate at times t, any shape."""
        if self.hold:
            place = np.floor((np.asarray(t, dtype=float) - self.t0) / self.dt + 1e-9)
            inside = (place >= 0) & (place < self.samples.size)
            return np.where(inside, self.samples[np.where(inside, place, 0).astype(int)], 0.0)
        grid = self.t0 + self.dt * np.arange(self.samples.size)
        return np.asarray(np.interp(t, grid, self.samples, left=0.0, right=0.0))
