"""A first guess of a limit cycle: what the motion settles to."""

from typing import NamedTuple

import numpy as np

from symfric.errors import NotFound
from symfric.model.scene import Scene
from symfric.orbits.flow_map import Flow
from symfric.orbits.recurrence import nearest_return, passages
from symfric.solve.run import Run
from symfric.solve.status import Status

_MOST = 16  # periods of the excitation, or turns of the motion, in one of the cycle
_QUIET, _STILL = 1e-3, 1e-6  # parts of the largest range: a motion with less settles to rest if it still shrinks, or is
# as good as there; one that keeps so little is a small cycle
_SHRINKING = 0.98  # of the range in the third quarter: what a motion that still shrinks has less in the last
_SETTLE = 60  # periods of the excitation that a forced motion is given at least


class Fades(NotFound):
    """The motion settles to rest or to steady sliding, or shrinks towards them."""


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
    Fades
        If the motion settles to rest or to steady sliding.
    NotFound
        If it ends early, or hardly turns.
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
    Fades
        If the run settles to rest or to steady sliding.
    NotFound
        If it hardly turns.
    """
    if forcing is None:
        return _of_free(run)
    last = int(np.floor(run.t_final / forcing + 1e-9))
    looks = np.arange(max(0, last - _MOST), last + 1) * forcing
    returns = run(np.minimum(looks, run.t_final))
    late = run.x[:, run.t > run.t_final - _MOST * forcing]
    turns = nearest_return(returns, np.maximum(np.ptp(late, axis=1), 1e-300))
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
    if not np.any(late):
        raise Fades("the motion settles to rest at once; start it elsewhere, or give a guess")
    middle = (t > 0.5 * run.t_final) & ~late
    whole, size = np.ptp(x, axis=1), np.ptp(x[:, late], axis=1)
    shrinking = bool(np.any(middle) and np.all(size <= _SHRINKING * np.ptp(x[:, middle], axis=1)))
    if np.all(size <= _STILL * whole) or (np.all(size <= _QUIET * whole) and shrinking):
        raise Fades("the motion settles to steady sliding or rest; start it elsewhere, or give a guess")
    k = int(np.argmax(size[: len(run.base.system.q)] / np.maximum(whole[: len(run.base.system.q)], 1e-300)))
    times = passages(run, k, 0.5 * (np.min(x[k, late]) + np.max(x[k, late])), _MOST + 1)
    times = times[times > 0.25 * run.t_final]
    if times.size < 3:
        raise NotFound("the motion turns fewer than three times within the horizon; lengthen it")
    turns = nearest_return(run(times), np.maximum(size, 1e-300))
    begin, end = times[-1 - turns], times[-1]
    return Guess(run(_sliding_moment(run, begin, end)), end - begin, 0, turns, shrinking)


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
