"""Detect periodicity of a motion from its states."""

from typing import NamedTuple

import numpy as np

from symfric.orbits.sizes import ranges_of
from symfric.solve.run import Run

MOST = 8  # largest period sought, in periods of the excitation or passages of a coordinate through its middle
LEAST = 4  # number of periods over which a motion has to repeat itself
SAME = 1e-3  # difference relative to the ranges up to which states count as one and a motion as settled
_QUIET = 1e-7  # changes relative to the ranges that may be rounding
_PARTS = 6  # the period of the motion may be the period of the excitation over 2 to 6
FEW = "it does not repeat itself within the few turns of the window"
_NOT = "it does not repeat itself, or not yet"
# most corrections of the time of a passage; correction relative to a step that ends them
_CORRECTIONS, _ROUNDING = 60, 1e-15
_BESIDE = 0.5 - 1 / 30  # of the range: a controller's switch is usually at its middle
_PLACES = 200  # sampling points at which whole periods are compared


class Recurrence(NamedTuple):
    """The period of a motion, NaN with a reason if there is none."""

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
        Without excitation: times at which a coordinate passes its middle; see `passages`.
    """
    return _of_excited(run, run.t_final, forcing) if forcing else _of_free(run, run.t_final, times)


def passages(run: Run, weights: np.ndarray, level: float, most: int = 0) -> np.ndarray:
    """Return the times at which a sum of states rises through a level; with a count, only the last ones."""
    path = run.path
    before = np.append(path.coefficients[:, :, 0] @ weights, run.final @ weights) - level
    steps = np.flatnonzero((before[:-1] < 0) & (before[1:] >= 0))[-most:]
    c = np.einsum("sxk,x->sk", path.coefficients[steps], weights)
    low, high = np.zeros(steps.size), path.h[steps].copy()
    s = high * before[steps] / (before[steps] - before[steps + 1])
    for _ in range(_CORRECTIONS):  # Newton's method, with bisection where it leaves the bracket
        value, slope = c[:, -1], np.zeros(steps.size)
        # Horner's rule for the value and its slope at once
        for j in range(c.shape[1] - 2, -1, -1):
            value, slope = value * s + c[:, j], slope * s + value
        low, high = np.where(value < level, s, low), np.where(value < level, high, s)
        moved = s - (value - level) / np.where(slope == 0, np.inf, slope)
        moved = np.where((moved >= low) & (moved <= high), moved, 0.5 * (low + high))
        if np.all(np.abs(moved - s) <= _ROUNDING * path.h[steps]):
            break
        s = moved
    return path.t[steps] + s


def level_of(run: Run, low: float, high: float) -> float:
    """Return the level at whose passages states are compared: the middle, or beside it if states may jump there."""
    return low + (_BESIDE if run.base.clocks else 0.5) * (high - low)


def nearest_return(states: np.ndarray, size: np.ndarray) -> int:
    """Return after how many columns the last one recurs: the first close one, or else the closest.

    Sufficient as a first guess; `period_of` decides whether a motion is periodic.
    """
    gaps = np.max(np.abs(states[:, -1:] - states[:, -2::-1]) / size[:, None], axis=0)
    near = np.flatnonzero(gaps < SAME)
    return int(near[0] if near.size else np.argmin(gaps)) + 1


def _of_excited(run: Run, end: float, forcing: float) -> Recurrence:
    """Return the period of a forced motion, from the states once in every period of the excitation."""
    count = int(np.floor(end / forcing + 1e-9))  # the end may lie before a whole period by rounding
    states = run(np.minimum(forcing * np.arange(count + 1), end))
    size = _ranges(run, end)
    back = (k for k in range(1, min(MOST, count // LEAST) + 1) if _come_back(states, k, size))
    k = next(back, None)
    if k is None:
        return Recurrence(np.nan, _NOT)
    if k == 1:  # or a fraction of the period, if the excitation has only even harmonics or hardly acts
        for part in range(_PARTS, 1, -1):
            recurrence = _checked(run, end, forcing / part, size)
            if not recurrence.note:
                return recurrence
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
    states = run(np.linspace(0.0, end, 20 * _PLACES))
    return ranges_of(np.min(states, axis=1), np.max(states, axis=1), len(run.base.system.q))


def _come_back(states: np.ndarray, k: int, size: np.ndarray) -> bool:
    """Whether every k-th of some states, (n_x, n), counted from the last one, has converged.

    The changes in the first and second half define a geometric series, whose remainder is the change to come.
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
    """Return a period if the trajectory repeats itself over all of the last periods."""
    t = np.linspace(max(0.0, end - 3 * period), end - period, _PLACES)
    apart = np.max(np.abs(run(t + period) - run(t)) / size[:, None])
    return Recurrence(float(period)) if apart <= SAME else Recurrence(np.nan, _NOT)
