"""A first guess of a limit cycle: what the motion settles to."""

from typing import NamedTuple

import numpy as np

from symfric.errors import NotFound
from symfric.model.scene import Scene
from symfric.orbits.flow_map import Flow
from symfric.solve.run import Path, Run
from symfric.solve.status import Status

_NEAR = 1e-3  # of the ranges: two passages that count as the same
_MOST = 16  # periods of the excitation, or turns of the motion, in one of the cycle
_QUIET = 1e-3  # part of the largest range that is left of a motion that settles to rest or steady sliding
_SHRINKING = 0.98  # of the range in the third quarter: what a motion that still shrinks has less in the last
_NEWTON = 3  # corrections of the time of a passage
_SETTLE = 60  # periods of the excitation that a forced motion is given at least


class Guess(NamedTuple):
    """State and period near a limit cycle.

    Attributes
    ----------
    start : ndarray, shape (n_x,)
    period : float
    multiple : int
        Of forced scenes, how many periods of the excitation it takes; 0 of others.
    turns : int
        How often the motion seemed to turn; the cycle may repeat itself sooner.
    shrinking : bool
        Whether the motion was still becoming smaller.
    """

    start: np.ndarray
    period: float
    multiple: int
    turns: int
    shrinking: bool = False


def settled(scene: Scene, flow: Flow, forcing: float | None, patience: int) -> Guess:
    """Follow the motion of a scene and return what it settles to.

    Parameters
    ----------
    scene : Scene
    flow : Flow
    forcing : float or None
        Period of the excitation.
    patience : int
        How many horizons of the scene to wait.

    Raises
    ------
    NotFound
        If the motion ends early, settles to rest or to steady sliding, or does not settle.
    """
    if forcing is None:
        return guess_of(_motion(scene, flow, patience * scene.horizon), None)
    periods = max(_SETTLE, int(np.ceil(scene.horizon / forcing))) * patience
    return guess_of(_motion(scene, flow, (periods + 0.5) * forcing), forcing)  # so that no return is the end


def guess_of(run: Run, forcing: float | None) -> Guess:
    """Return what the last turns of a run come back to, or come back nearest to.

    Parameters
    ----------
    run : Run
        With its trajectory.
    forcing : float or None
        Period of the excitation.

    Raises
    ------
    NotFound
        If the run settles to rest or to steady sliding, or hardly turns.
    """
    if forcing is None:
        return _of_free(run)
    last = int(np.floor(run.t_final / forcing + 1e-9))
    looks = np.arange(max(0, last - _MOST), last + 1) * forcing
    returns = run(np.minimum(looks, run.t_final))
    late = run.x[:, run.t > run.t_final - _MOST * forcing]
    turns = _repeats(returns, np.maximum(np.ptp(late, axis=1), 1e-300))
    return Guess(returns[:, -1], 0.0, turns, turns)


def _motion(scene: Scene, flow: Flow, horizon: float) -> Run:
    run = flow.motion(scene, horizon)
    if run.status != Status.OK:
        raise NotFound(f"the motion of the scene ends early, {run.status.name}: {run.advice}")
    return run


def _of_free(run: Run) -> Guess:
    """Return the last turn of a free motion, from the middle of its longest stretch without sticking."""
    x, t = run.x, run.t
    late = t > 0.75 * run.t_final
    whole, size = np.ptp(x, axis=1), np.ptp(x[:, late], axis=1)
    if np.all(size <= _QUIET * whole) or not np.any(late):
        raise NotFound("the motion settles to steady sliding or rest; start it elsewhere, or give a guess")
    k = int(np.argmax(size[: len(run.base.system.q)] / np.maximum(whole[: len(run.base.system.q)], 1e-300)))
    times = _crossings(run.path, k, 0.5 * (np.min(x[k, late]) + np.max(x[k, late])), _MOST + 1)
    times = times[times > 0.25 * run.t_final]
    if times.size < 3:
        raise NotFound("the motion turns fewer than three times within the horizon; lengthen it")
    turns = _repeats(run(times), np.maximum(size, 1e-300))
    begin, end = times[-1 - turns], times[-1]
    middle = (t > 0.5 * run.t_final) & ~late
    shrinking = bool(np.any(middle) and np.all(size < _SHRINKING * np.ptp(x[:, middle], axis=1)))
    return Guess(run(_sliding_moment(run, begin, end)), end - begin, 0, turns, shrinking)


def _crossings(path: Path, k: int, level: float, most: int) -> np.ndarray:
    """Return the last times, at most so many, at which coordinate k rises through a level; roughly."""
    before = path.coefficients[:, k, 0] - level
    steps = np.flatnonzero((before[:-1] < 0) & (before[1:] >= 0))[-most:]
    c = path.coefficients[steps, k]
    s = path.h[steps] * before[steps] / (before[steps] - before[steps + 1])
    for _ in range(_NEWTON):
        value, slope = c[:, -1], np.zeros(steps.size)
        for j in range(c.shape[1] - 2, -1, -1):
            value, slope = value * s + c[:, j], slope * s + value
        s = np.clip(s - (value - level) / np.where(slope == 0, np.inf, slope), 0.0, path.h[steps])
    return path.t[steps] + s


def _repeats(states: np.ndarray, size: np.ndarray) -> int:
    """Return after how many columns the last one comes back: the first that is near, or else the nearest."""
    gaps = [float(np.max(np.abs(states[:, -1] - states[:, -1 - k]) / size)) for k in range(1, states.shape[1])]
    return next((k for k, gap in enumerate(gaps, 1) if gap < _NEAR), int(np.argmin(gaps)) + 1)


def _sliding_moment(run: Run, begin: float, end: float) -> float:
    """Return the middle of the longest stretch in which the fewest contacts stick."""
    path = run.path
    steps = np.flatnonzero((path.t >= begin) & (path.t + path.h <= end))
    if not path.mode.shape[1] or not steps.size:
        return begin
    sticking = np.sum(path.mode[steps] == 0, axis=1)
    changes = np.flatnonzero(np.any(np.diff(path.mode[steps], axis=0), axis=1)) + 1
    least, best, moment = np.min(sticking), 0.0, begin
    for stretch in np.split(steps, changes):
        first, last = path.t[stretch[0]], path.t[stretch[-1]] + path.h[stretch[-1]]
        if np.sum(path.mode[stretch[0]] == 0) == least and last - first > best:
            best, moment = last - first, 0.5 * (first + last)
    return moment
