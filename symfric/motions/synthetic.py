"""Artificial motions: sine bursts, and synthetic earthquakes compatible with a spectrum."""

import math
from dataclasses import dataclass, replace

import numpy as np

from symfric.errors import SceneError
from symfric.model.arguments import instance, is_one_of, whole
from symfric.model.numeric import Floats
from symfric.model.results import Result
from symfric.model.symbols import finite, numbers_of, positive, shortened
from symfric.motions.motion import Motion
from symfric.motions.spectrum import filtered, read_periods, spectrum
from symfric.motions.units import factor_of
from symfric.spelling import spelt

_COARSE = 10  # points per period in the iteration; the final spectrum is exact
_LONGER = 4  # period of the noise in durations, for a finer frequency step
_RELAXED = 0.7  # power of target over computed by which an amplitude is corrected
_GROUNDS = {  # T_B, T_C, T_D of EN 1998-1 table 3.2, spectrum of type 1; its soil factor S cancels in eurocode8
    "A": (0.15, 0.4, 2.0),
    "B": (0.15, 0.5, 2.0),
    "C": (0.2, 0.6, 2.0),
    "D": (0.2, 0.8, 2.0),
    "E": (0.15, 0.5, 2.0),
}


@spelt
def sine_burst(
    pga: float, frequency: float, cycles: int = 10, *, ramp: int = 2, dt: float | None = None, unit: str = "m/s^2"
) -> Motion:
    """Return a burst of whole sine cycles with ramps at both ends.

    Parameters
    ----------
    pga : float
        Amplitude in `unit`; reached exactly if a cycle between the ramps has a sample at its crest.
    frequency : float
        Hz.
    cycles : int
        All of them, ramps included.
    ramp : int
        Cycles over which it swells, and as many over which it fades, as half a cosine; 0 for none.
    dt : float, optional
        s; a two-hundredth of the period unless given.
    unit : str
        Of `pga`.

    Returns
    -------
    Motion

    Raises
    ------
    SceneError
        If an argument is out of its range.

    Examples
    --------
    >>> import symfric as sf
    >>> round(sf.motions.sine_burst(3.0, 2.0, cycles=5).pga, 6)
    3.0
    """
    amplitude = finite(pga, "pga") * factor_of(unit, "the unit of pga")
    frequency = finite(frequency, "frequency")
    if amplitude <= 0 or frequency <= 0:
        raise SceneError(f"a burst of pga {pga} at {frequency} Hz; both must be positive")
    if 2 * whole(ramp, "ramp", 0) > whole(cycles, "cycles"):
        raise SceneError(f"{cycles} cycles with ramps of {ramp}; the ramps must fit into the cycles")
    dt = 1 / (200 * frequency) if dt is None else finite(dt, "dt")
    if not 0 < dt <= 0.25 / frequency:
        raise SceneError(f"dt is {dt:g}; a period of {1 / frequency:g} s needs at least four samples")
    phase = frequency * dt * np.arange(math.floor(cycles / (frequency * dt) + 1e-9) + 1)
    window = np.ones_like(phase)
    if ramp:
        edge = np.clip(np.minimum(phase, cycles - phase) / ramp, 0.0, 1.0)
        window = 0.5 - 0.5 * np.cos(np.pi * edge)
    # all periods have the same samples, with exact zeros
    samples = amplitude * window * np.sin(2 * np.pi * (phase - np.floor(phase + 1e-12)))
    return Motion(samples, dt, "m/s^2", "sine burst", f"{cycles} cycles at {frequency:g} Hz, ramps of {ramp}")


@spelt
def eurocode8(periods: Floats, ground: str = "B") -> np.ndarray:
    """Return the elastic spectrum of EN 1998-1, type 1, 5 % damping, over its acceleration at period 0.

    Parameters
    ----------
    periods : sequence of float
        s.
    ground : str
        Ground type 'A' to 'E'.

    Returns
    -------
    ndarray

    Raises
    ------
    SceneError
        If the ground is none of A to E.

    Notes
    -----
    EN 1998-1:2004, equations (3.2) to (3.5) and table 3.2, divided by a_g S.

    Examples
    --------
    >>> import symfric as sf
    >>> (sf.motions.eurocode8([0.0, 0.5, 2.0], "B")).round(6)
    array([1.   , 2.5  , 0.625])
    """
    if not is_one_of(ground, _GROUNDS):
        raise SceneError(f"ground is {shortened(ground)}; it is one of {', '.join(_GROUNDS)}")
    T_B, T_C, T_D = _GROUNDS[ground]
    T = read_periods(periods)
    safe = np.maximum(T, 1e-12)
    pieces = [1 + 1.5 * T / T_B, np.full_like(T, 2.5), 2.5 * T_C / safe, 2.5 * T_C * T_D / safe**2]
    return np.select([T_B > T, T_C >= T, T_D >= T], pieces[:3], pieces[3])


@dataclass(frozen=True)
class Misfit(Result):
    """Relative difference between a motion's spectrum and a target.

    Attributes
    ----------
    largest, mean : float
        Of the magnitudes over the periods.
    worst_period : float
        Where it is largest, s.

    Examples
    --------
    >>> import symfric as sf
    >>> quake = sf.motions.sine_burst(3.0, 2.0, cycles=5)
    >>> found = sf.motions.misfit(quake, [0.3, 0.5], [10.0, 20.0])
    >>> round(found.worst_period, 6)
    0.3
    >>> sorted(found.to_dict())
    ['largest', 'mean', 'worst_period']
    """

    largest: float
    mean: float
    worst_period: float


@spelt
def misfit(motion: Motion, periods: Floats, values: Floats, damping: float = 0.05) -> Misfit:
    """Compare a motion's pseudo-acceleration with a target of positive `values`, m/s^2.

    Parameters
    ----------
    motion : Motion
    periods : sequence of float
        s.
    values : sequence of float
        Of the target, m/s^2.
    damping : float
        Damping ratio.

    Returns
    -------
    Misfit

    Examples
    --------
    >>> import symfric as sf
    >>> quake = sf.motions.sine_burst(3.0, 2.0, cycles=5)
    >>> target = quake.spectrum([0.3, 0.5]).pseudo_acceleration
    >>> round(sf.motions.misfit(quake, [0.3, 0.5], target).largest, 6)
    0.0
    """
    at, target = _target(periods, values)
    off = np.abs(spectrum(instance(motion, Motion, "motion"), at, damping).pseudo_acceleration / target - 1)
    worst = int(np.argmax(off))
    return Misfit(float(off[worst]), float(off.mean()), float(at[worst]))


@spelt
def synthetic(
    periods: Floats | None = None,
    values: Floats | None = None,
    *,
    seed: int,
    pga: float = 1.0,
    unit: str = "m/s^2",
    damping: float = 0.05,
    duration: float = 30.0,
    dt: float = 0.01,
    rise: float = 0.1,
    decay: float = 0.5,
    iterations: int = 40,
) -> Motion:
    """Return a synthetic earthquake whose response spectrum matches a target.

    Parameters
    ----------
    periods, values : sequences of float, same length
        Target: periods in s, increasing, and pseudo-accelerations in `unit`; Eurocode 8 on ground B with acceleration
        `pga` at period 0 unless given.
    seed : int
    pga : float
        Of the default target, in `unit`; without effect with a target.
    unit : str
        Of `values` and `pga`.
    damping : float
        Of the target.
    duration, dt : float
        s.
    rise, decay : float
        Parts of the duration over which the shaking swells and fades.
    iterations : int
        The best of them is returned.

    Returns
    -------
    Motion
        Its `note` says how near the target it comes; `misfit` computes that.

    Raises
    ------
    SceneError
        If an argument is out of its range.

    Notes
    -----
    Random phases under an envelope; the amplitudes in the frequency domain are multiplied by target over computed
    spectrum until they agree. What the envelope leaves of final velocity is taken out under the envelope.

    Examples
    --------
    >>> import symfric as sf
    >>> round(sf.motions.synthetic(seed=1, pga=0.3, unit="g", duration=20.0).pga_g, 6)
    0.35111
    """
    scale = factor_of(unit, "the unit of the target")
    if periods is None and values is None:
        periods = np.geomspace(0.1, 4.0, 60)
        values = finite(pga, "pga") * eurocode8(periods)
    if periods is None or values is None:
        raise SceneError("a target has periods and values; give both, or neither")
    at, target = _target(periods, values)
    dt, duration = finite(dt, "dt"), finite(duration, "duration")
    _check_synthesis(at, dt, duration, rise, decay, iterations)
    damping = positive(damping, "damping", zero=True)
    whole(seed, "seed", 0)
    n = round(duration / dt) + 1
    best = _synthesis(at, scale * target, seed, damping, n, dt, (rise, decay), iterations)
    motion = Motion(best, dt, name=f"synthetic {seed}")
    return replace(motion, note=_nearness(misfit(motion, at, scale * target, damping), at))


def _nearness(off: Misfit, periods: np.ndarray) -> str:
    span = f"{periods.size} periods from {periods[0]:g} to {periods[-1]:g} s"
    return f"within {100 * off.largest:.1f} % of its target at {span}, {100 * off.mean:.1f} % on average"


def _target(periods: Floats, values: Floats) -> tuple[np.ndarray, np.ndarray]:
    """Return a target as two arrays of positive numbers."""
    at, target = read_periods(periods), np.atleast_1d(numbers_of(values, "values"))
    if target.shape != at.shape:
        raise SceneError(f"a target has {at.size} periods and {target.size} values; give as many of each")
    if at[0] <= 0 or np.any(np.diff(at) <= 0) or not np.all((target > 0) & np.isfinite(target)):
        raise SceneError("a target has increasing positive periods and positive finite values")
    return at, target


def _check_synthesis(
    periods: np.ndarray, dt: float, duration: float, rise: float, decay: float, iterations: int
) -> None:
    if dt <= 0 or duration < 2 * periods[-1]:
        raise SceneError(f"duration {duration:g} s in steps of {dt:g} s; it must hold twice the longest period")
    if periods[0] < 4 * dt:
        raise SceneError(f"dt is {dt:g}; the shortest period {periods[0]:g} s needs at least four samples")
    if duration / dt > 1e6:
        raise SceneError(f"{duration / dt:.0f} samples; at most a million are made")
    if positive(rise, "rise", zero=True) + positive(decay, "decay", zero=True) > 1:
        raise SceneError("rise and decay are parts of the duration, together at most 1")
    whole(iterations, "iterations")


def _synthesis(
    periods: np.ndarray,
    values: np.ndarray,
    seed: int,
    damping: float,
    n: int,
    dt: float,
    edges: tuple[float, float],
    iterations: int,
) -> np.ndarray:
    """Return the samples, shape (n,), of the iteration with the coarse spectrum nearest to the target."""
    envelope = _envelope(n, *edges)
    frequency = np.fft.rfftfreq(_LONGER * n, dt)
    turn = np.exp(2j * np.pi * np.random.default_rng(seed).random(frequency.size))
    known = np.log(1 / periods[::-1])
    inside = np.log(np.maximum(frequency, 1e-12))
    band = (frequency >= 0.5 / periods[-1]) & (frequency <= min(2 / periods[0], 0.45 / dt))
    amplitude = np.where(band, np.exp(np.interp(inside, known, np.log(values[::-1]))), 0.0)
    best, smallest = np.zeros(n), np.inf
    for k in range(iterations):
        a = _without_drift(envelope * np.fft.irfft(amplitude * turn)[:n], envelope)
        coarse = _coarse(a, dt, periods, damping)
        if k == 0:
            level = np.exp(np.mean(np.log(values / coarse)))
            a, coarse, amplitude = level * a, level * coarse, level * amplitude
        off = np.max(np.abs(coarse / values - 1))
        if off < smallest:
            best, smallest = a, off
        amplitude *= np.exp(_RELAXED * np.interp(inside, known, np.log(values / coarse)[::-1]))
    return best


def _envelope(n: int, rise: float, decay: float) -> np.ndarray:
    """Return a window with half-cosine ramps, zero at both ends."""
    s = np.arange(n) / (n - 1)
    with np.errstate(divide="ignore", invalid="ignore"):
        up = np.where(s < rise, s / rise, 1.0) if rise else np.ones(n)
        down = np.where(s > 1 - decay, (1 - s) / decay, 1.0) if decay else np.ones(n)
    return (0.5 - 0.5 * np.cos(np.pi * up)) * (0.5 - 0.5 * np.cos(np.pi * down))


def _without_drift(a: np.ndarray, envelope: np.ndarray) -> np.ndarray:
    """Return the samples without final velocity and displacement."""
    s = np.linspace(-1.0, 1.0, a.size)
    shapes = np.stack([envelope, envelope * s])
    weights = np.ones(a.size)
    weights[[0, -1]] = 0.5  # straight lines between samples; their first moment differs by no more than one sample
    moments = np.stack([weights, weights * s])
    return np.asarray(a - np.linalg.solve(moments @ shapes.T, moments @ a) @ shapes)


def _coarse(a: np.ndarray, dt: float, periods: np.ndarray, damping: float) -> np.ndarray:
    """Return the pseudo-accelerations from peaks at a few points per period."""
    peaks = []
    for T in periods:
        omega = 2 * math.pi / T
        eigenvalue = omega * complex(-damping, math.sqrt(1 - damping**2))
        parts = math.ceil(_COARSE * dt / T)
        grid = np.arange((a.size - 1) * parts + 1) / parts
        fine = a if parts == 1 else np.interp(grid, np.arange(a.size), a)
        x = filtered(fine, dt / parts, eigenvalue).imag / eigenvalue.imag
        peaks.append(omega**2 * np.max(np.abs(x)))
    return np.array(peaks)
