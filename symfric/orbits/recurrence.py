"""Whether a motion repeats itself, and after what time: read off its states, not off its equations."""

from typing import NamedTuple

import numpy as np

from symfric.orbits.sizes import filled
from symfric.solve.run import Run

MOST = 8  # periods of the excitation, or passages of a coordinate through its middle, in one period of the motion
LEAST = 4  # periods over which a motion has to repeat itself
SAME = 1e-3  # of the ranges: states that count as one, and what a settled motion may still change by
_QUIET = 1e-7  # of the ranges: changes that may be rounding
_PARTS = 6  # of a period of the excitation that the motion may take instead
FEW = "it does not repeat itself within the few turns of the window"
_NOT = "it does not repeat itself, or not yet"
_CORRECTIONS, _ROUNDING = 60, 1e-15  # of the time of a passage at most; of a step: a correction that is none
_PLACES = 200  # at which whole periods are compared


class Recurrence(NamedTuple):
    """What was found: the period, NaN if there is none, and in words why not."""

    period: float
    note: str = ""


def period_of(run: Run, forcing: float, times: np.ndarray) -> Recurrence:
    """Return the period of a motion, from a run over many turns with its trajectory.

    Parameters
    ----------
    run : Run
    forcing : float
        Period of the excitation; 0.0 without one.
    times : ndarray, shape (n,)
        Without excitation: when a coordinate passes its middle; see `passages`.
    """
    return _of_excited(run, run.t_final, forcing) if forcing else _of_free(run, run.t_final, times)


def passages(run: Run, row: int, level: float, most: int = 0) -> np.ndarray:
    """Return the last times, at most so many if given, at which a state rises through a level from step to step."""
    path = run.path
    before = np.append(path.coefficients[:, row, 0], run.final[row]) - level
    steps = np.flatnonzero((before[:-1] < 0) & (before[1:] >= 0))[-most:]
    c, low, high = path.coefficients[steps, row], np.zeros(steps.size), path.h[steps].copy()
    s = high * before[steps] / (before[steps] - before[steps + 1])
    for _ in range(_CORRECTIONS):  # Newton's method, halving where that leads out of what is known
        value, slope = c[:, -1], np.zeros(steps.size)
        for j in range(c.shape[1] - 2, -1, -1):
            value, slope = value * s + c[:, j], slope * s + value
        low, high = np.where(value < level, s, low), np.where(value < level, high, s)
        moved = s - (value - level) / np.where(slope == 0, np.inf, slope)
        moved = np.where((moved >= low) & (moved <= high), moved, 0.5 * (low + high))
        if np.all(np.abs(moved - s) <= _ROUNDING * path.h[steps]):
            break
        s = moved
    return path.t[steps] + s


def nearest_return(states: np.ndarray, size: np.ndarray) -> int:
    """Return after how many columns the last one comes back: the first that is near, or else the nearest.

    Enough for a first guess; whether a motion repeats itself says `period_of`.
    """
    gaps = np.max(np.abs(states[:, -1:] - states[:, -2::-1]) / size[:, None], axis=0)
    near = np.flatnonzero(gaps < SAME)
    return int(near[0] if near.size else np.argmin(gaps)) + 1


def _of_excited(run: Run, end: float, forcing: float) -> Recurrence:
    """Look at the states once in every period of the excitation."""
    count = int(np.floor(end / forcing + 1e-9))
    states = run(np.minimum(forcing * np.arange(count + 1), end))
    size = _ranges(run, end)
    back = (k for k in range(1, min(MOST, count // LEAST) + 1) if _come_back(states, k, size))
    k = next(back, None)
    if k is None:
        return Recurrence(np.nan, _NOT)
    if k == 1:  # or a part of the period, if the excitation is even in its harmonics or hardly acts
        for part in range(_PARTS, 1, -1):
            found = _checked(run, end, forcing / part, size)
            if not found.note:
                return found
    return _checked(run, end, k * forcing, size)


def _of_free(run: Run, end: float, times: np.ndarray) -> Recurrence:
    """Return the period of a motion without excitation, from the times at which a coordinate passes its middle."""
    if not times.size:
        return Recurrence(np.nan, FEW)
    states, size = run(times), _ranges(run, end)
    for k in range(1, min(MOST, (times.size - 1) // LEAST) + 1):
        if _come_back(states, k, size):
            whole = (times.size - 1) // k
            return _checked(run, end, (times[-1] - times[-1 - whole * k]) / whole, size)
    return Recurrence(np.nan, _NOT if times.size > LEAST * MOST else FEW)


def _ranges(run: Run, end: float) -> np.ndarray:
    size = np.ptp(run(np.linspace(0.0, end, 20 * _PLACES)), axis=1)
    return filled(size, len(run.base.system.q))


def _come_back(states: np.ndarray, k: int, size: np.ndarray) -> bool:
    """Whether every k-th of some states, (n_x, n), counted from the last one, is the same, and will be.

    What they change by in the first half and in the second makes a geometric series: its rest is what is to come.
    """
    states = states[:, ::-1][:, ::k][:, ::-1] / size[:, None]
    away = np.max(np.abs(states - states[:, -1:]))
    if away <= _QUIET:
        return True
    half = (states.shape[1] - 1) // 2
    first, middle, last = (states[:, m] for m in (-1 - 2 * half, -1 - half, -1))
    early, late = np.max(np.abs(middle - first)), np.max(np.abs(last - middle))
    fades = late < (0.5 if away > SAME else 1.0) * early
    return bool(fades and late <= SAME and late**2 / (early - late) <= SAME)


def _checked(run: Run, end: float, period: float, size: np.ndarray) -> Recurrence:
    """Return a period if the whole motion of the last ones repeats itself."""
    t = np.linspace(max(0.0, end - 3 * period), end - period, _PLACES)
    apart = np.max(np.abs(run(t + period) - run(t)) / size[:, None])
    return Recurrence(float(period)) if apart <= SAME else Recurrence(np.nan, _NOT)
