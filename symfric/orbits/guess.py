"""First guess of a limit cycle, from the motion after settling."""

from typing import NamedTuple

import numpy as np

from symfric.errors import NotFound
from symfric.model.numeric import numeric_function
from symfric.model.scene import Scene
from symfric.model.symbols import TIME
from symfric.orbits.flow_map import FlowMap
from symfric.orbits.recurrence import level_of, nearest_return, passages
from symfric.orbits.sizes import filled, ranges_of
from symfric.solve.run import Run
from symfric.solve.status import Status, early_end

_MOST = 16  # most periods of the excitation, or oscillations of the motion, in one period of the cycle
# ranges relative to the largest one: below _QUIET a motion that still shrinks counts as settling to rest, below _STILL
# any motion counts as at rest
_QUIET, _STILL = 1e-3, 1e-6
_SHRINKING = 0.98  # ratio of the ranges in the last and third quarter below which a motion still shrinks
# range of a wait relative to that of the motion around it; ratio of the ranges in the last and third quarter of a run
# above which a motion goes on
_WAITING, _GOES_ON = 1e-2, 0.1
_STRETCHES, _LOOKS = 100, 41  # of a motion that may wait: stretches of its last quarter, and times in each
# size of the last motion relative to that of the first quarter of a run above which it has no bound; from rounding to
# a cycle it grows by less
_HUGE = 1e30
_SETTLE = 60  # least settling time of a forced motion, in periods of the excitation


class Fades(NotFound):
    """The motion settles to rest or to steady sliding, or shrinks towards them."""


class Grows(NotFound):
    """The motion grows beyond any bound."""


class Waits(NotFound):
    """The motion waits and goes on by turns, for longer than any cycle that is looked for."""


class EndsEarly(NotFound):
    """The motion ends before it has settled; a longer wait ends there too."""


class Guess(NamedTuple):
    """State and period near a limit cycle.

    Attributes
    ----------
    start : ndarray, shape (n_x,)
    period : float
    multiple : int
        Period in periods of the excitation; 0 without excitation.
    turns : int
        Number of oscillations found in the period; the least period may be shorter.
    shrinking : bool
        Whether the motion was still becoming smaller.
    """

    start: np.ndarray
    period: float
    multiple: int
    turns: int
    shrinking: bool = False


def settled(scene: Scene, flow: FlowMap, forcing: float | None, patience: int) -> Guess:
    """Simulate a scene until it settles, and return state and period of the motion then.

    Parameters
    ----------
    scene : Scene
    flow : FlowMap
    forcing : float or None
        Period of the excitation.
    patience : int
        Settling time in horizons of the scene.

    Raises
    ------
    Fades
        If the motion settles to rest or to steady sliding.
    Grows
        If it grows beyond any bound.
    EndsEarly
        If it ends early.
    Waits
        If it waits for longer than any cycle that is looked for.
    NotFound
        If it hardly turns.
    """
    horizon = patience * scene.horizon
    if forcing is not None:
        periods = max(_SETTLE, int(np.ceil(scene.horizon / forcing))) * patience
        horizon = (periods + 0.5) * forcing  # half a period more, so that no return falls on the end
    run = flow.motion(scene, horizon)
    if run.status == Status.OK:
        return guess_of(run, forcing)
    ends = EndsEarly(f"{early_end('the motion of the scene', run.status)}; a guess replaces this motion")
    if run.status != Status.STEP_BUDGET:
        raise ends
    try:
        return guess_of(run, forcing)  # as far as it goes
    except (Fades, Grows):
        raise
    except Waits as failure:
        raise EndsEarly(str(failure)) from None  # a longer run takes no more steps
    except NotFound:
        raise ends from None


def guess_of(run: Run, forcing: float | None) -> Guess:
    """Return the state to which the last oscillations of a run return, exactly or most nearly, and the period.

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
    Grows
        If it grows beyond any bound.
    Waits
        If it waits for longer than any cycle that is looked for.
    NotFound
        If it hardly oscillates.
    """
    _look_at_growth(run)
    if forcing is None:
        return _of_free(run)
    last = int(np.floor(run.t_final / forcing + 1e-9))
    looks = np.arange(max(0, last - _MOST), last + 1) * forcing
    returns = run(np.minimum(looks, run.t_final))
    late = run.x[:, run.t > run.t_final - _MOST * forcing]
    if _waits(run, _MOST * forcing):
        raise Waits(
            f"the motion waits and moves on by turns of more than {_MOST} periods of the excitation or the sampling, "
            "and has no cycle as short as these; look at the motion itself"
        )
    sizes = ranges_of(np.min(late, axis=1), np.max(late, axis=1), len(run.base.system.q))
    turns = nearest_return(returns, sizes)
    return Guess(returns[:, -1], 0.0, turns, turns)


def _look_at_growth(run: Run) -> None:
    """Raise if the motion grows beyond any bound: near the largest numbers it would seem to repeat itself."""
    first, late = run.t <= 0.25 * run.t_final, run.t > 0.75 * run.t_final
    if np.any(first) and np.any(late):
        before, after = (np.max(np.abs(run.x[:, part]), axis=1) for part in (first, late))
        if np.any((after / _HUGE > before) & (before > 0)):
            raise Grows("the motion grows beyond any bound; start it elsewhere, or give a guess")


def _waits(run: Run, span: float) -> bool:
    """Whether a motion waits for longer than `span` and goes on by turns, such as the hunting of a PID."""
    n = len(run.base.system.q)
    quarters = [(run.t > a * run.t_final) & (run.t <= (a + 0.25) * run.t_final) for a in (0.5, 0.75)]
    if not all(np.any(part) for part in quarters):
        return False
    before, after = (np.ptp(run.x[:n, part], axis=1) for part in quarters)
    if not np.any((after > _GOES_ON * before) & (before > 0)):
        return False
    ends = run.t_final - np.linspace(0.0, max(0.25 * run.t_final - span, 0.0), _STRETCHES)
    looks = ends[:, None] - span * np.linspace(0.0, 1.0, _LOOKS)
    ranges = np.ptp(run(np.maximum(looks, 0.0).ravel())[:n].reshape(n, *looks.shape), axis=2)
    return bool(np.any(np.all(ranges <= _WAITING * after[:, None], axis=0)))


def _of_free(run: Run) -> Guess:
    """Return the last oscillation of a free motion, from the middle of its longest stretch without sticking."""
    x, t = run.x, run.t
    late = t > 0.75 * run.t_final
    if not np.any(late):
        raise Fades("the motion settles to rest at once; start it elsewhere, or give a guess")
    middle = (t > 0.5 * run.t_final) & ~late
    whole, size = np.ptp(x, axis=1), np.ptp(x[:, late], axis=1)
    shrinking = bool(np.any(middle) and np.all(size <= _SHRINKING * np.ptp(x[:, middle], axis=1)))
    if np.all(size <= _STILL * whole) or (np.all(size <= _QUIET * whole) and shrinking):
        raise Fades("the motion settles to steady sliding or rest; start it elsewhere, or give a guess")
    n_q = len(run.base.system.q)
    k = int(np.argmax((size / filled(whole, n_q))[:n_q]))  # not of a state that moves by rounding alone
    level = level_of(run, np.min(x[k, late]), np.max(x[k, late]))
    times = passages(run, np.eye(len(x))[k], level, _MOST + 1)
    times = times[times > 0.25 * run.t_final]
    if times.size < 3:
        raise NotFound("the motion completes fewer than three oscillations within the horizon; lengthen it")
    sizes = ranges_of(np.min(x[:, late], axis=1), np.max(x[:, late], axis=1), n_q)
    turns = nearest_return(run(times), sizes)
    begin, end = times[-1 - turns], times[-1]
    return Guess(run(_sliding_moment(run, begin, end)), end - begin, 0, turns, shrinking)


def _sliding_moment(run: Run, begin: float, end: float) -> float:
    """Return the middle of the longest stretch in which the fewest contacts stick and nothing jumps."""
    path = run.path
    steps = np.flatnonzero((path.t >= begin) & (path.t + path.h <= end))
    discrete = np.column_stack([path.mode, _jumping(run)])
    if not discrete.shape[1] or not steps.size:
        return begin
    sticking = np.sum(path.mode[steps] == 0, axis=1)
    changes = np.flatnonzero(np.any(np.diff(discrete[steps], axis=0), axis=1)) + 1
    least, best, moment = np.min(sticking), 0.0, begin
    for stretch in np.split(steps, changes):
        first, last = path.t[stretch[0]], path.t[stretch[-1]] + path.h[stretch[-1]]
        if np.sum(path.mode[stretch[0]] == 0) == least and last - first > best:
            best, moment = last - first, 0.5 * (first + last)
    return moment


def _jumping(run: Run) -> np.ndarray:
    """Return held variables, and the signs of expressions whose zeros are events, in every step of a run."""
    path = run.path
    if not run.base.held and all(part.crossing is None for part in run.base.clocks):
        return np.zeros((path.t.size, 0))
    scene, middle = run.scene, path.t + 0.5 * path.h
    states = dict(zip(scene.system.states, run(middle), strict=True))
    numbers = {**scene.parameter_values(), **states, TIME: middle}
    rows = [states[h.symbol] for h in scene.held]
    for e in (part.crossing for part in scene.clocks if part.crossing is not None):
        symbols = sorted(e.free_symbols, key=str)
        rows.append(np.sign(numeric_function(symbols, e)(*(numbers[s] for s in symbols))))
    return np.array(rows).reshape(len(rows), middle.size).T
