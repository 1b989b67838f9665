"""What the solver says: one motion with its stick intervals, and the steady vibration over a range of values."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
import sympy as sp

from symfric.errors import SceneError
from symfric.locks import SYMBOLIC, alone
from symfric.lower.constant_parameters import vanishing
from symfric.model.excitation import later
from symfric.model.outputs import End, Integral, Max, Min, Trajectory
from symfric.model.scene import Scene
from symfric.model.symbols import TIME
from symfric.orbits.flow_map import excitation
from symfric.report.study.recurrence import FEW, SAME, Recurrence, of_excited, of_free
from symfric.scenefile import SweepPlan
from symfric.solve.run import Run

SAMPLES = 4000  # of a motion to draw
PATH = "motion of the study"  # an output's name no file is likely to use
LEAST = 32  # periods of an excitation in the window: enough for a motion that takes several of them to repeat itself
LONGER = 12  # windows, where the motion turns a few times only in one
LONGEST = 40.0  # horizons: how long the window may become for that
RESTS = 1e-4  # of the range of the whole motion: what is left of one that comes to rest
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
    """Vibration of one coordinate after settling; NaN where the run failed.

    Attributes
    ----------
    largest, smallest : float
        Over the window.
    mean : float
        Over the window, in whole periods of an excitation.
    period : float
        Time in which the motion repeats itself; NaN if it does not vibrate, or not with a period.
    stick_fraction : float
        Part of the window, in whole periods, in which a contact sticks.
    note : str
        Why this is no steady vibration, "" if it is one: the other numbers are those of the motion so far.
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


def as_run(scene: Scene) -> Scene:
    """Return the scene with its trajectory wanted beside its outputs."""
    return scene.wanting({**scene.outputs, PATH: Trajectory()})


def motion(scene: Scene, tolerance: float = 1e-9) -> Motion:
    """Compute the scene's motion and whatever scalar outputs it wants."""
    from symfric.solve.routes import simulate

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
def is_excited(scene: Scene) -> bool:
    """Return whether time enters the equations with the scene's own values."""
    if scene.inputs:
        return True
    expressions = (*scene.system.expressions, *(e for c in scene.contacts for e in (c.slip, c.normal, c.profile)))
    zero = vanishing(scene)
    return any(TIME in e.xreplace(zero).free_symbols for e in expressions if TIME in e.free_symbols)


@dataclass(frozen=True)
class Plan:
    """How long to wait and to measure.

    Attributes
    ----------
    settle, window : float
        In whole periods of an excitation that has one.
    forcing : float
        Period of the excitation; 0.0 if there is none, NaN if it has no period.
    note : str
        Why it has no period.
    """

    settle: float
    window: float
    forcing: float = 0.0
    note: str = ""


def settling(scene: Scene, settle: float | None, window: float | None) -> Plan:
    """Return the times to wait and to measure; the window holds enough periods of an excitation to see one repeat."""
    settle = SETTLE * scene.horizon if settle is None else settle
    window = WINDOW * scene.horizon if window is None else window
    try:
        period_of = excitation(scene) if is_excited(scene) else None
        if period_of is None:
            return Plan(settle, window)
        period = period_of({s.name: v for s, v in scene.parameter_values().items()})
    except SceneError as reason:
        return Plan(settle, window, np.nan, str(reason))
    whole = max(round(window / period), LEAST)
    if whole * period > max(window, LONGEST * scene.horizon):
        return Plan(settle, window, np.nan, f"the excitation repeats itself after {period:.6g} only")
    return Plan(max(1.0, round(settle / period)) * period, whole * period, period)


def restarted(scene: Scene, state: np.ndarray) -> Scene:
    """Return the scene started from numbers, without the values that only its old start used."""
    used = set().union(*(e.free_symbols for e in scene.system.expressions), *(c.free_symbols for c in scene.contacts))
    values = {k: v for k, v in scene.values.items() if k in used}
    start = dict(zip(scene.system.states, np.asarray(state, dtype=float).tolist(), strict=True))
    return replace(scene, values=values, initial=start, outputs={"end": End()})


def vibration(scene: Scene, coordinate: str, plan: Plan, tolerance: float = 1e-9) -> Vibration:
    """Return the vibration of a coordinate after settling, with its period and its share of sticking.

    A period is one of the motion that was computed: its states come back, several times and everywhere in between.
    """
    from symfric.solve.routes import simulate

    x = _symbol(scene, coordinate)
    extremes = {"high": Max(x), "low": Min(x)}
    before = simulate(scene.wanting(extremes).until(plan.settle), tolerance=tolerance).checked()
    scene = later(restarted(scene, before.final), plan.settle)
    wanted = {**extremes, "sum": Integral(x), PATH: Trajectory()}
    for longer in (1, LONGER):
        run = simulate(scene.until(longer * plan.window).wanting(wanted), tolerance=tolerance).checked()
        high, low = float(run["high"]), float(run["low"])
        t = np.union1d(np.linspace(0.0, run.t_final, SAMPLES), run.t)
        reach = max(high, float(before["high"])) - min(low, float(before["low"]))
        found = _recurrence(run, run.names.index(coordinate), t, plan, reach)
        if found.note != FEW:
            break
    whole = found.period * (run.t_final // found.period) if found.period <= run.t_final else run.t_final
    middles, lengths = 0.5 * (t[1:] + t[:-1]), np.diff(t)
    counted = middles > run.t_final - whole
    stuck = _inside(middles, stick_intervals(run), 0.0) & counted
    fraction = float(np.sum(lengths[stuck]) / np.sum(lengths[counted]))
    return Vibration(high, low, float(run["sum"]) / run.t_final, found.period, fraction, found.note)


def _recurrence(run: Run, row: int, t: np.ndarray, plan: Plan, reach: float) -> Recurrence:
    """Return how a motion repeats itself; without period and without note if it has come to rest."""
    values = run(t)[row]
    halves = [np.ptp(part) for part in np.array_split(values, 2)]
    if np.ptp(values) <= 1e-7 * max(np.max(np.abs(values)), 1e-300):
        return Recurrence(np.nan)
    if np.ptp(values) <= RESTS * reach and halves[1] < 0.9 * halves[0]:
        return Recurrence(np.nan)
    if plan.note:
        return Recurrence(np.nan, plan.note)
    if plan.forcing:
        found = of_excited(run, run.t_final, plan.forcing)
    else:
        found = of_free(run, run.t_final, _passages(run, row, 0.5 * (np.max(values) + np.min(values)), t))
    if found.note and found.note != FEW and abs(halves[1] - halves[0]) > 0.05 * halves[0]:
        return found._replace(note=f"its range still {'grows' if halves[1] > halves[0] else 'shrinks'}")
    return found


def _passages(run: Run, row: int, middle: float, t: np.ndarray) -> np.ndarray:
    """Return the times at which a coordinate rises through a value."""
    from scipy.optimize import brentq

    f = lambda s: float(run(s)[row] - middle)  # noqa: E731
    values = run(t)[row] - middle
    turns = np.flatnonzero((values[:-1] < 0) & (values[1:] >= 0))
    return np.array([brentq(f, t[k], t[k + 1], xtol=1e-14 * t[-1]) for k in turns])


def vibrations(scene: Scene, parameter: str, values: np.ndarray, plan, progress: Callable) -> list[Vibration]:
    """Return the steady vibration for each value of a parameter.

    Parameters
    ----------
    plan : SweepPlan
        Coordinate, settling time and window.
    progress : callable ``(fraction) -> None``
    """
    symbol = scene.parameter(parameter)
    fixed = symbol not in _in_time(scene)
    measure = _prepared(scene, plan) if fixed else None
    result = []
    for k, value in enumerate(values):
        progress(k / len(values))
        here = {parameter: float(value)}
        result.append((measure or _prepared(scene.where(here), plan))(here))
    return result


def _in_time(scene: Scene) -> set[sp.Symbol]:
    """Return the parameters on which the period of the excitation may depend."""
    expressions = (*scene.system.expressions, *(e for c in scene.contacts for e in (c.slip, c.normal, c.profile)))
    return set().union(*(w.args[0].free_symbols for e in expressions for w in e.atoms(sp.sin, sp.cos) if w.has(TIME)))


def _prepared(scene: Scene, sweep: SweepPlan) -> Callable[[Mapping[str, float]], Vibration]:
    """Compile settling and measuring once; return a function from values to the vibration.

    The range is measured twice, one window after the other: where both differ, the motion had not settled.
    """
    from symfric.solve.routes import prepare

    plan = settling(scene, sweep.settle, sweep.window)
    x = _symbol(scene, sweep.coordinate)
    names = tuple(s.name for s in scene.system.states)
    first = prepare(scene.wanting({"end": End()}).until(plan.settle))
    start = [scene.numbers()[s] for s in scene.system.states]
    again = later(restarted(scene, np.array(start)), plan.settle)
    again = again.wanting({"high": Max(x), "low": Min(x)}).until(plan.window)
    second, known = prepare(again), {s.name for s in again.parameters}

    def measure(values: Mapping[str, float]) -> Vibration:
        run, kept, ranges = first.run(values=values), {name: v for name, v in values.items() if name in known}, []
        for _ in range(1 if plan.note else 2):
            if not run.advice:
                run = second.run(values=kept, initial=dict(zip(names, run.final.tolist(), strict=True)))
            if run.advice:
                return Vibration(float("nan"), float("nan"))
            ranges.append((float(run["high"]), float(run["low"])))
        apart = np.max(np.abs(np.subtract(ranges[0], ranges[-1])))
        changes = apart > SAME * max(high - low for high, low in ranges) + 1e-7 * np.max(np.abs(ranges))
        return Vibration(*ranges[-1], note=plan.note or ("its range still changes" if changes else ""))

    return measure


def _symbol(scene: Scene, name: str) -> sp.Symbol:
    return next(s for s in scene.system.states if s.name == name)
