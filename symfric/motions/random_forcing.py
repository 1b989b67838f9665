"""Random forcing with a flat spectrum between two frequencies."""

import math

import numpy as np

from symfric.errors import SceneError
from symfric.model.arguments import whole
from symfric.model.symbols import finite, pair
from symfric.model.system import Signal
from symfric.spelling import spelt

_LONGER = 2  # period of the sum of waves in durations, so that the end knows nothing of the start
_POINTS = 10  # samples in the shortest period
MOST = 20_000_000  # samples of all signals


@spelt
def random_forcing(
    duration: float,
    band: tuple[float, float],
    rms: float,
    *,
    number: int = 1,
    dt: float | None = None,
    seed: int = 0,
    unit: str | None = None,
) -> tuple[Signal, ...]:
    """Return an ensemble of random signals with a flat spectrum in a band of frequencies.

    Parameters
    ----------
    duration : float
        s.
    band : (float, float)
        Lowest and highest frequency, Hz.
    rms : float
        Root mean square, in `unit`; that of the process, from which one signal's differs by chance.
    number : int
        How many signals; the first ones are the same whatever their number.
    dt : float, optional
        Sampling interval; a tenth of the shortest period unless given.
    seed : int
        The same seed gives the same signals.
    unit : str, optional
        For display only.

    Returns
    -------
    tuple of Signal

    Raises
    ------
    SceneError
        If a number is out of range.

    Notes
    -----
    A sum of waves at the multiples of ``1/(2 duration)`` inside the band, with normal amplitudes of sine and cosine of
    variance ``rms^2/m`` for m waves: a stationary Gaussian process of one-sided spectral density ``rms^2/(f_2 - f_1)``
    (Shinozuka and Deodatis, Applied Mechanics Reviews 44 (1991) 191).

    Examples
    --------
    >>> import symfric as sf
    >>> first, second = sf.motions.random_forcing(10.0, (0.5, 5.0), 2.0, number=2, seed=3)
    >>> first.samples.size, first.dt, bool(abs(first.samples.std() - 2.0) < 0.6)
    (501, 0.02, True)
    """
    duration, rms = finite(duration, "duration"), finite(rms, "rms")
    low, high = (finite(f, "a frequency of the band") for f in pair(band, "band"))
    if duration <= 0 or rms < 0:
        raise SceneError(
            f"a duration of {duration:g} and an rms of {rms:g}; the first must be positive, both not negative"
        )
    if not 0 <= low < high:
        raise SceneError(f"the band is ({low:g}, {high:g}) Hz; the first must be smaller, and not negative")
    number = whole(number, "number")
    dt = 1 / (_POINTS * high) if dt is None else finite(dt, "dt")
    if not 0 < dt <= 0.25 / high:
        raise SceneError(f"dt is {dt:g}; the shortest period, {1 / high:g}, needs at least four samples")
    size = math.ceil(duration / dt - 1e-9) + 1
    if size * number > MOST:
        raise SceneError(f"{number} signals of {size} samples are more than {MOST} numbers; take fewer, or a longer dt")
    n = _LONGER * (size - 1)
    waves = np.arange(max(1, math.ceil(low * n * dt - 1e-9)), math.floor(high * n * dt + 1e-9) + 1)
    if not waves.size:
        raise SceneError(f"the band ({low:g}, {high:g}) Hz is narrower than one over twice the duration; lengthen it")
    signals = []
    for own in np.random.SeedSequence(whole(seed, "seed", 0)).spawn(number):
        rng = np.random.default_rng(own)
        lines = np.zeros(n // 2 + 1, dtype=complex)
        parts = rng.standard_normal((2, waves.size)) * rms / math.sqrt(waves.size)
        lines[waves] = parts[0] - 1j * parts[1]
        signals.append(Signal(np.fft.irfft(lines, n)[:size] * (n / 2), dt, unit=unit))
    return tuple(signals)
