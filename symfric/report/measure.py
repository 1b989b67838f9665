"""What the solver says: one motion with its stick intervals, and the steady vibration over a range of values."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
import sympy as sp

from symfric.locks import SYMBOLIC, alone
from symfric.model.names import TIME
from symfric.model.outputs import End, Integral, Max, Min, Trajectory
from symfric.model.scene import Scene

SAMPLES = 4000  # of a motion to draw
PATH = "motion of the study"  # an output's name no file is likely to use
MOST_PASSAGES, SAME = 8, 1e-3  # of a coordinate through its middle in a period; of the range, how well states repeat
SETTLE, WINDOW = 20.0, 1.0  # waiting and measuring time in horizons, unless the file says otherwise


@dataclass(frozen=True, eq=False)
class Motion:
    """One computed motion, sampled for drawing.

    Attributes
    ----------
    t : ndarray, shape (n_t,)
    x : ndarray, shape (n_x, n_t)
    names : tuple of str
    sticks : dict of str to tuple of (start, end)
        Intervals in which each contact sticks.
    outputs : dict of str to float
        Scalar outputs of the scene.
    route, status, advice : str
    events : int
    energy_residual : float
    """

    t: np.ndarray
    x: np.ndarray
    names: tuple[str, ...]
    sticks: Mapping[str, tuple[tuple[float, float], ...]]
    outputs: Mapping[str, float]
    route: str
    status: str
    advice: str
    events: int
    energy_residual: float

    def sticking(self, contacts: Sequence[str], ends: bool = True) -> np.ndarray:
        """Return whether any of some contacts sticks at each time, shape (n_t,), with or without the ends."""
        sticks = {name: self.sticks[name] for name in contacts}
        return _inside(self.t, sticks, 0.0 if ends else 1e-12 * self.t[-1])


def _inside(t: np.ndarray, sticks: Mapping[str, tuple[tuple[float, float], ...]], inset: float) -> np.ndarray:
    """Return whether each time lies in an interval, shortened by `inset` at both ends."""
    on = np.zeros(t.shape, dtype=bool)
    for start, end in (interval for intervals in sticks.values() for interval in intervals):
        on |= (t >= start + inset) & (t <= end - inset)
    return on


@dataclass(frozen=True)
class Vibration:
    """Steady vibration of one coordinate; NaN where the run failed.

    Attributes
    ----------
    largest, smallest : float
        Over the window.
    mean : float
        Over the window, in whole periods of an excitation.
    period : float
        Time in which the state comes back; NaN if it does not vibrate.
    stick_fraction : float
        Part of the window, in whole periods, in which a contact sticks.
    """

    largest: float
    smallest: float
    mean: float = float("nan")
    period: float = float("nan")
    stick_fraction: float = float("nan")

    @property
    def half_range(self) -> float:
        """(largest - smallest) / 2."""
        return 0.5 * (self.largest - self.smallest)


def as_run(scene: Scene) -> Scene:
    """Return the scene with its trajectory wanted beside its outputs."""
    return scene.wanting({**scene.outputs, PATH: Trajectory()})


def motion(scene: Scene, tolerance: float = 1e-9) -> Motion:
    """Compute the scene's motion and whatever scalar outputs it wants."""
    from symfric.solve.choose import simulate

    run = simulate(as_run(scene), tolerance=tolerance)
    t = np.union1d(np.linspace(0.0, run.t_final, SAMPLES), run.t[run.t <= run.t_final])
    scalars = {k: float(v) for k, v in run.outputs.items() if isinstance(v, float)}
    return Motion(
        t,
        run(t),
        run.names,
        stick_intervals(run),
        scalars,
        run.route,
        run.status.name,
        run.advice,
        int(run.stats.get("events", 0)),
        float(run.energy_residual()),
    )


def stick_intervals(run) -> dict[str, tuple[tuple[float, float], ...]]:
    """Return the intervals in which each contact of a run sticks."""
    result = {}
    for contact, row in zip(run.scene.contacts, run.mode, strict=True):
        stuck = np.concatenate([[False], row[:-1] == 0, [False]])
        starts, ends = np.flatnonzero(stuck[1:] & ~stuck[:-1]), np.flatnonzero(~stuck[1:] & stuck[:-1])
        result[contact.name] = tuple((float(run.t[a]), float(run.t[b])) for a, b in zip(starts, ends, strict=True))
    return result


@alone(SYMBOLIC)
def frequencies(scene: Scene) -> set[sp.Expr]:
    """Return the frequencies of the harmonic functions of time in a scene, as expressions of its parameters."""
    found = set()
    for e in (*scene.system.expressions, *(c.slip for c in scene.contacts), *(c.normal for c in scene.contacts)):
        for wave in e.atoms(sp.sin, sp.cos):
            rate = wave.args[0].diff(TIME)
            if not rate.is_zero:
                found.add(sp.Abs(rate))
    return found


@alone(SYMBOLIC)
def is_excited(scene: Scene) -> bool:
    """Return whether time enters the equations with the scene's own values."""
    expressions = (*scene.system.expressions, *(c.slip for c in scene.contacts), *(c.normal for c in scene.contacts))
    zero = {k: 0 for k, v in scene.values.items() if v == 0}
    return any(TIME in e.subs(zero).free_symbols for e in expressions if TIME in e.free_symbols)


def settling(scene: Scene, settle: float | None, window: float | None) -> tuple[float, float]:
    """Return the times to wait and to measure, in whole periods of a single excitation.

    The window is a run of its own, which starts at t = 0: only so does it continue the first one's excitation.
    """
    settle = SETTLE * scene.horizon if settle is None else settle
    window = WINDOW * scene.horizon if window is None else window
    if is_excited(scene):
        rates = {abs(float(f.subs(scene.values))) for f in frequencies(scene)} - {0.0}
        if len(rates) == 1:
            period = 2 * np.pi / rates.pop()
            settle, window = (max(1.0, round(length / period)) * period for length in (settle, window))
    return settle, window


def restarted(scene: Scene, state: np.ndarray) -> Scene:
    """Return the scene started from numbers, without the values that only its old start used."""
    used = set().union(*(e.free_symbols for e in scene.system.expressions), *(c.free_symbols for c in scene.contacts))
    values = {k: v for k, v in scene.values.items() if k in used}
    start = dict(zip(scene.system.states, np.asarray(state, dtype=float).tolist(), strict=True))
    return replace(scene, values=values, initial=start, outputs={"end": End()})


def vibration(scene: Scene, coordinate: str, settle: float, window: float, tolerance: float = 1e-9) -> Vibration:
    """Return the steady vibration of a coordinate with its period and its share of sticking."""
    from symfric.solve.choose import simulate

    end = simulate(scene.wanting({"end": End()}).until(settle), tolerance=tolerance).checked()
    scene = restarted(scene, end.final).until(window)
    x = _symbol(scene, coordinate)
    wanted = {"high": Max(x), "low": Min(x), "sum": Integral(x), PATH: Trajectory()}
    run = simulate(scene.wanting(wanted), tolerance=tolerance).checked()
    high, low = float(run["high"]), float(run["low"])
    t = np.union1d(np.linspace(0.0, run.t_final, SAMPLES), run.t)
    i = run.names.index(coordinate)
    still = high - low <= 1e-7 * max(abs(high), abs(low), 1e-300)
    period = float("nan") if still else _period(run, i, 0.5 * (high + low), t)
    whole = period * (run.t_final // period) if period <= run.t_final else run.t_final
    middles, lengths = 0.5 * (t[1:] + t[:-1]), np.diff(t)
    counted = middles > run.t_final - whole
    stuck = _inside(middles, stick_intervals(run), 0.0) & counted
    fraction = float(np.sum(lengths[stuck]) / np.sum(lengths[counted]))
    return Vibration(high, low, float(run["sum"]) / run.t_final, period, fraction)


def _period(run: Callable, row: int, middle: float, t: np.ndarray) -> float:
    """Return the mean time in which the state comes back, from upward passages of a coordinate through its middle.

    A coordinate may pass its middle several times in a period; the state tells those passages apart. Where no passage
    among the last few repeats the last one, the mean time between passages.
    """
    from scipy.optimize import brentq

    f = lambda s: float(run(s)[row] - middle)  # noqa: E731
    values = run(t)[row] - middle
    turns = np.flatnonzero((values[:-1] < 0) & (values[1:] >= 0))
    if turns.size < 2:
        return float("nan")
    passages = np.array([brentq(f, t[k], t[k + 1], xtol=1e-14 * t[-1]) for k in turns])
    states, scale = run(passages), np.ptp(run(t), axis=1)[:, None]
    away = np.max(np.abs(states - states[:, -1:]) / np.where(scale > 0, scale, 1.0), axis=0)
    back = next((k for k in range(1, min(MOST_PASSAGES, turns.size - 1) + 1) if away[-1 - k] < SAME), 1)
    whole = (turns.size - 1) // back
    return float((passages[-1] - passages[-1 - back * whole]) / whole)


def vibrations(scene: Scene, parameter: str, values: np.ndarray, plan, progress: Callable) -> list[Vibration]:
    """Return the steady vibration for each value of a parameter.

    Parameters
    ----------
    plan : SweepPlan
        Coordinate, settling time and window.
    progress : callable ``(fraction) -> None``
    """
    symbol = scene.parameter(parameter)
    fixed = not any(symbol in f.free_symbols for f in frequencies(scene))
    measure = _prepared(scene, plan) if fixed else None
    result = []
    for k, value in enumerate(values):
        progress(k / len(values))
        if not fixed:
            measure = _prepared(scene.where({parameter: float(value)}), plan)
        result.append(measure({parameter: float(value)}))
    return result


def _prepared(scene: Scene, plan) -> Callable[[Mapping[str, float]], Vibration]:
    """Compile settling and measuring once; return a function from values to the vibration."""
    from symfric.solve.choose import prepare

    settle, window = settling(scene, plan.settle, plan.window)
    x = _symbol(scene, plan.coordinate)
    names = tuple(s.name for s in scene.system.states)
    first = prepare(scene.wanting({"end": End()}).until(settle))
    start = [scene.numbers()[s] for s in scene.system.states]
    again = restarted(scene, np.array(start)).wanting({"high": Max(x), "low": Min(x)}).until(window)
    second, known = prepare(again), {s.name for s in again.parameters}

    def measure(values: Mapping[str, float]) -> Vibration:
        end = first.run(values=values)
        if end.advice:
            return Vibration(float("nan"), float("nan"))
        kept = {name: v for name, v in values.items() if name in known}
        run = second.run(values=kept, initial=dict(zip(names, end.final.tolist(), strict=True)))
        if run.advice:
            return Vibration(float("nan"), float("nan"))
        return Vibration(float(run["high"]), float(run["low"]))

    return measure


def _symbol(scene: Scene, name: str) -> sp.Symbol:
    return next(s for s in scene.system.states if s.name == name)
