"""Steady states: simulate until a motion has settled, measure it over a window, and check that it had settled."""

import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace

import numpy as np
import sympy as sp

from symfric.errors import SceneError
from symfric.lower.mode_layout import OPEN
from symfric.model.excitation import forcing_period, later
from symfric.model.outputs import End, Integral, Max, Min, Output, OutputOfExpression, Trajectory
from symfric.model.scene import Scene
from symfric.model.symbols import Key, name_of
from symfric.orbits.recurrence import FEW, SAME, Recurrence, level_of, passages, period_of
from symfric.solve.routes import RouteName, Settings, prepare
from symfric.solve.run import Run, finished
from symfric.solve.status import Status
from symfric.solve.sticking import stuck

END, PATH = "end of the window", "path of the window"  # names of additional outputs, unlikely to occur in a scene
SAMPLES = 4000  # samples of a window
LEAST = 32  # least periods of the excitation in a window, so that subharmonic motions repeat in it
LONGER = 12  # factor by which a window with few oscillations is lengthened
LONGEST = 40.0  # longest such window, in horizons
# A motion comes to rest if its range is below RESTS of that of the whole motion and SHRINKS of the one before.
RESTS, SHRINKS = 1e-4, 0.9
STILL = 1e-7  # range relative to the largest value, or the whole range, below which a motion is rounding
_ROUNDING = 4 * np.finfo(float).eps  # of a whole number of periods
SETTLE, WINDOW = 20.0, 1.0  # default settling and measuring times, in horizons


@dataclass(frozen=True)
class Schedule:
    """Settling time and measuring window.

    Attributes
    ----------
    settle, window : float
        In whole periods of an excitation that has one.
    forcing : float
        Period of the excitation, whatever values are run; 0.0 if there is none, NaN if it has no period.
    note : str
        Why it has no period: then one window is not like the next.
    """

    settle: float
    window: float
    forcing: float = 0.0
    note: str = ""


def schedule(
    scene: Scene, settle: float | None = None, window: float | None = None, varied: frozenset[str] = frozenset()
) -> Schedule:
    """Return settling time and window; the window holds enough periods of an excitation to detect a periodic motion.

    Parameters
    ----------
    scene : Scene
    settle, window : float, optional
        20 horizons and one unless given; rounded to whole periods of an excitation.
    varied : frozenset of str
        Parameters that will take other values, and do not change the frequencies.
    """
    settle = SETTLE * scene.horizon if settle is None else settle
    window = WINDOW * scene.horizon if window is None else window
    try:
        period = forcing_period(scene, varied)
    except SceneError as reason:
        return Schedule(settle, window, np.nan, str(reason))
    if period is None:
        return Schedule(settle, window)
    whole = max(round(window / period), LEAST)
    if whole * period > max(window, LONGEST * scene.horizon):
        return Schedule(settle, window, np.nan, f"the excitation repeats itself after {period:.6g} only")
    return Schedule(max(1.0, round(settle / period)) * period, whole * period, period)


def settling(scene: Scene, times: Schedule, outputs: Mapping[str, Output] | None = None) -> Scene:
    """Return the scene of the settling run; its output `END` is the settled state."""
    return scene.until(times.settle, {END: End(), **(outputs or {})})


def measuring(scene: Scene, times: Schedule, outputs: Mapping[str, Output], state: np.ndarray | None = None) -> Scene:
    """Return the scene of one window, with the phase that the excitation has after settling.

    Values that only the start of the scene used are gone.

    Parameters
    ----------
    state : ndarray, shape (n_x,), optional
        Its start; that of the scene unless given.
    """
    system = scene.system
    numbers = scene.numbers()
    start = [numbers[s] for s in system.states] if state is None else np.asarray(state, dtype=float).tolist()
    used = set().union(
        *(e.free_symbols for e in (*system.expressions, *scene.clocked)), *(c.free_symbols for c in scene.contacts)
    )
    used = used.union(*(o.expr.free_symbols for o in outputs.values() if isinstance(o, OutputOfExpression)))
    values = {k: v for k, v in scene.values.items() if k in used}
    initial: dict[Key, float] = dict(zip(system.states, start, strict=True))
    scene = replace(scene, values=values, initial=initial, outputs={END: End(), **outputs}, horizon=times.window)
    return scene if _begins_anew(times) else later(scene, times.settle)


def _begins_anew(times: Schedule) -> bool:
    """Whether the excitation is after settling as at the start: then both runs are of the same equations."""
    rest = math.remainder(times.settle, times.forcing) if times.forcing > 0 else np.nan
    return bool(times.settle == 0 or abs(rest) <= _ROUNDING * times.settle)


class Settling:
    """Programs for settling and measuring a scene, for any values and starts and from any thread.

    Parameters
    ----------
    scene : Scene
    times : Schedule
        Without time to settle, the first window begins at the start.
    outputs : mapping of str to Output
        Of every window.
    tolerance, route
        See `symfric.solve.routes.prepare`.
    """

    def __init__(
        self,
        scene: Scene,
        times: Schedule,
        outputs: Mapping[str, Output],
        *,
        tolerance: float = 1e-9,
        route: RouteName | Settings | None = None,
    ):
        self.times = times
        self.states = tuple(s.name for s in scene.system.states)
        self._first = prepare(settling(scene, times), tolerance, route) if times.settle else None
        window = measuring(scene, times, outputs)
        self._known = frozenset(s.name for s in window.parameters)
        self._window = prepare(window, tolerance, route)

    def windows(
        self, values: Mapping[Key, float] | None = None, initial: Mapping[Key, float] | None = None
    ) -> Iterator[Run]:
        """Yield the runs over consecutive windows after settling.

        A run that fails, also the settling run, is the last one. Without a period of the excitation there is only one.
        """
        given, start = dict(values or {}), initial
        if self._first is not None:
            run = self._first.run(given, initial)
            if run.status != Status.OK:
                yield run
                return
            start = self.start(run.final)
        given = {k: v for k, v in given.items() if name_of(k) in self._known}
        while True:
            run = self._window.run(given, start)
            yield run
            if run.status != Status.OK or self.times.note:
                return
            start = self.start(run.final)

    def measured(self, values: Mapping[Key, float] | None = None, initial: Mapping[Key, float] | None = None) -> Run:
        """Return the run over the first window after settling.

        Raises
        ------
        RunFailed
            If it ends early, or settling does.
        """
        return finished(next(self.windows(values, initial)))

    def start(self, state: np.ndarray) -> dict[Key, float]:
        """Return a state (n_x,) as a dict by name."""
        return dict(zip(self.states, state.tolist(), strict=True))


@dataclass(frozen=True)
class Vibration:
    """Vibration of one coordinate after settling; NaN where the run failed.

    Attributes
    ----------
    largest, smallest : float
        Over the window.
    mean : float
        Over the window, in whole periods of an excitation.
    period : float
        Period of the motion; NaN if it does not vibrate or is not periodic.
    stick_fraction : float
        Fraction of the window, in whole periods, in which a contact sticks.
    note : str
        Why this is not a steady vibration, "" if it is; the other numbers are those of the motion so far.
    """

    largest: float
    smallest: float
    mean: float = float("nan")
    period: float = float("nan")
    stick_fraction: float = float("nan")
    note: str = ""

    @property
    def half_range(self) -> float:
        """(largest - smallest) / 2."""
        return 0.5 * (self.largest - self.smallest)

    @property
    def settled(self) -> bool:
        """Whether the motion repeats itself, or has come to rest."""
        return not self.note


def vibration(scene: Scene, coordinate: str, times: Schedule | None = None, tolerance: float = 1e-9) -> Vibration:
    """Measure the vibration of a coordinate after settling: extremes, period and stick fraction.

    A period is one of the motion that was computed: its states come back, several times and everywhere in between.
    """
    times = schedule(scene) if times is None else times
    x = state_symbol(scene, coordinate)
    scalars = {"high": Max(x), "low": Min(x), "sum": Integral(x)}  # of both runs, which then share their equations
    before = finished(prepare(settling(scene, times, scalars), tolerance).run())
    outputs = {**scalars, PATH: Trajectory()}
    for longer in (1, LONGER):
        window = measuring(scene, replace(times, window=longer * times.window), outputs, before.final)
        run = finished(prepare(window, tolerance).run())
        high, low = float(run["high"]), float(run["low"])
        t = np.union1d(np.linspace(0.0, run.t_final, SAMPLES), run.t)
        reach = max(high, float(before["high"])) - min(low, float(before["low"]))
        recurrence = _recurrence(run, weights_of(scene, coordinate), t, times, reach)
        if recurrence.note != FEW:
            break
    whole = recurrence.period * (run.t_final // recurrence.period) if recurrence.period <= run.t_final else run.t_final
    mean, stuck = float(run["sum"]) / run.t_final, stick_fraction(run, run.t_final - whole)
    return Vibration(high, low, mean, recurrence.period, stuck, recurrence.note)


def _recurrence(run: Run, weights: np.ndarray, t: np.ndarray, times: Schedule, reach: float) -> Recurrence:
    """Return the period of a motion; neither period nor note if it has come to rest."""
    values = weights @ run(t)
    halves = [np.ptp(part) for part in np.array_split(values, 2)]
    if np.ptp(values) <= STILL * max(np.max(np.abs(values)), 1e-300):
        return Recurrence(np.nan)
    if np.ptp(values) <= RESTS * reach and halves[1] < SHRINKS * halves[0]:
        return Recurrence(np.nan)
    if times.note:
        return Recurrence(np.nan, times.note)
    level = level_of(run, np.min(values), np.max(values))
    turns = np.zeros(0) if times.forcing else passages(run, weights, level)
    recurrence = period_of(run, times.forcing, turns)
    if recurrence.note and recurrence.note != FEW and abs(halves[1] - halves[0]) > 0.05 * halves[0]:
        return recurrence._replace(note=f"its range still {'grows' if halves[1] > halves[0] else 'shrinks'}")
    return recurrence


def still_changes(ranges: tuple[float, float], then: tuple[float, float], reach: float = 0.0) -> bool:
    """Whether a motion had not settled.

    Parameters
    ----------
    ranges, then : (float, float)
        Largest and smallest value in one window and in the next.
    reach : float
        Range of the whole motion: one that has shrunk to nearly nothing of it, and still shrinks, comes to rest.
    """
    apart = np.max(np.abs(np.subtract(ranges, then)))
    before, after = (high - low for high, low in (ranges, then))
    if after <= RESTS * reach and after < SHRINKS * before:
        return False
    size = max(before, after)
    return bool(apart > SAME * size + STILL * np.max(np.abs([ranges, then])))


def stick_intervals(run: Run) -> dict[str, tuple[tuple[float, float], ...]]:
    """Return the intervals in which each contact of a run sticks."""
    return {c.name: _intervals(run, row) for c, row in zip(run.scene.contacts, stuck(run), strict=True)}


def open_intervals(run: Run) -> dict[str, tuple[tuple[float, float], ...]]:
    """Return the intervals in which each contact of a run is open; none of those with a given load."""
    return {c.name: _intervals(run, row == OPEN) for c, row in zip(run.scene.contacts, run.mode, strict=True)}


def _intervals(run: Run, where: np.ndarray) -> tuple[tuple[float, float], ...]:
    """Return the intervals of the steps of a run in which something holds; `where` has a last entry for its end."""
    on = np.concatenate([[False], where[:-1], [False]])
    starts, ends = np.flatnonzero(on[1:] & ~on[:-1]), np.flatnonzero(~on[1:] & on[:-1])
    return tuple((float(run.t[a]), float(run.t[b])) for a, b in zip(starts, ends, strict=True))


def stick_fraction(run: Run, after: float = 0.0) -> float:
    """Return the fraction of a run, from a time on, during which at least one contact sticks."""
    on = np.any(stuck(run), axis=0)
    lengths = np.diff(np.clip(run.t, after, run.t_final), append=run.t_final)
    return float(np.sum(lengths[on]) / (run.t_final - after))


def sticking(t: np.ndarray, sticks: Mapping[str, tuple[tuple[float, float], ...]], inset: float = 0.0) -> np.ndarray:
    """Return whether each time lies in an interval of any contact, shortened by `inset` at both ends."""
    on = np.zeros(t.shape, dtype=bool)
    for start, end in (interval for intervals in sticks.values() for interval in intervals):
        on |= (t >= start + inset) & (t <= end - inset)
    return on


def weights_of(scene: Scene, name: str) -> np.ndarray:
    """Return the weights of the states in a state or in a named row of a structure, shape (n_x,)."""
    symbol, states = state_symbol(scene, name), scene.system.states
    weights = np.zeros(len(states))
    if symbol in states:
        weights[states.index(symbol)] = 1.0
        return weights
    assert scene.system.linear is not None
    row, n = scene.system.linear.rows[symbol], len(scene.system.q)
    weights[slice(0, n) if row.of == "q" else slice(n, 2 * n)] = row.weights
    return weights


def state_symbol(scene: Scene, name: str) -> sp.Symbol:
    """Return the symbol of a state, or of a named row of a structure."""
    return next(s for s in (*scene.system.states, *scene.system.rows) if s.name == name)
