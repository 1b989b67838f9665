"""Data of the explorer's figures for one set of values."""

import itertools
import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from types import MappingProxyType
from typing import Any

import numpy as np
import sympy as sp

from symfric.errors import SceneError
from symfric.model.excitation import is_excited
from symfric.model.numeric import numeric_function
from symfric.model.outputs import Max, Min, Output
from symfric.model.symbols import SPEED
from symfric.model.system import Contact
from symfric.orbits.steady_state import Schedule, Settling
from symfric.report.study.measurement import PATH, as_run
from symfric.scenefile import SceneFile, belt_speeds
from symfric.scenefile.writing import read_tables, tables_of, with_friction_values, with_numbers, written
from symfric.solve.plotting import motion_to_draw
from symfric.solve.routes import Program, prepare
from symfric.solve.run import Run

Numbers = Mapping[str, float]
NO_NUMBERS: Numbers = MappingProxyType({})
Evaluated = Callable[..., Any]
SAMPLES, SPEEDS, PHASES, POINTS, STEPS = 3000, 160, 1000, 33, 200
SHOWN = 0.25  # last fraction of the horizon shown under a fast excitation, which would fill the phase portrait
TOLERANCE = 1e-7
SETTLE = 4  # settling time in horizons before the amplitude is measured
FIXED = "times are the same for every frequency of the excitation"
# most values that are zero, which are dropped from the equations: each choice of them is compiled in advance
MOST_ZEROS = 3


@dataclass(frozen=True)
class SliderRange:
    """Range of a slider.

    Attributes
    ----------
    name, unit : str
    low, high, value : float
    step : float
        A round number, of which both ends are multiples; a key of the keyboard moves the slider by it.
    """

    name: str
    unit: str
    low: float
    high: float
    value: float
    step: float


def slider_range(name: str, unit: str, low: float, high: float, value: float) -> SliderRange:
    """Return a range in some `STEPS` round steps, within which the limits and the value lie."""
    least = (high - low) / STEPS
    decade = 10.0 ** np.floor(np.log10(least))
    step = next(float(decade * m) for m in (1, 2, 5, 10) if decade * m >= 0.999 * least)
    below, above = np.floor(low / step + 1e-9), np.ceil(high / step - 1e-9)
    if low > 0 and below == 0:  # a positive value stays one
        below = 1.0
    # from the count of steps in decimal digits, without the rounding of a product
    low, high = (float(f"{count * step:.12g}") for count in (below, above))
    return SliderRange(name, unit, min(low, value), max(high, value), value, step)


@dataclass(frozen=True, eq=False)
class View:
    """Data of the first two figures.

    Attributes
    ----------
    t, x, u : ndarray, shape (n,)
        Motion of a coordinate.
    held : ndarray of bool, shape (n,)
        Whether a contact of the coordinate sticks.
    speed, friction : ndarray, shape (m,)
        Law of a contact; empty without contacts.
    effective : ndarray, shape (m,)
        Under the fast excitation; NaN without one.
    status : str
        Empty if the run came to its end.
    """

    t: np.ndarray
    x: np.ndarray
    u: np.ndarray
    held: np.ndarray
    speed: np.ndarray
    friction: np.ndarray
    effective: np.ndarray
    status: str


@dataclass(frozen=True, eq=False)
class Explorer:
    """Prepared programs of a scene for repeated evaluation.

    Attributes
    ----------
    file : SceneFile
        With the numbers of the friction laws among its values.
    tables : dict or None
        The file as it is written, for saving; None if it was not read from a file.
    ranges, starts : tuple of SliderRange
        Of the values, and of the start of each state that no value gives.
    swept : str
        Parameter of the amplitude diagram; "" if there is none to sweep.
    speeds : ndarray, shape (POINTS,)
        Its values, in the order of computation: coarse first.
    reach : ndarray, shape (n_x,)
        Largest sizes of the states with the values of the file; what is far below them is not motion but its error.
    """

    file: SceneFile
    tables: dict[str, Any] | None
    ranges: tuple[SliderRange, ...]
    starts: tuple[SliderRange, ...]
    swept: str
    speeds: np.ndarray
    reach: np.ndarray
    motion: Program
    steady: Settling
    friction: tuple[Callable[..., tuple[np.ndarray, np.ndarray, np.ndarray]], ...]

    @property
    def rubbing(self) -> tuple[Contact, ...]:
        """The contacts with friction, in the order of `friction`."""
        return tuple(c for c in self.file.scene.contacts if not c.frictionless)

    def excited(self, values: Numbers) -> bool:
        """Whether time enters the equations for some values."""
        return is_excited(self.file.scene.where(values))

    def view(self, values: Numbers, initial: Numbers = NO_NUMBERS, coordinate: int = 0, contact: int = 0) -> View:
        """Return the motion of a coordinate and the friction of a contact for some values and some starts."""
        empty, unmoved = np.zeros(0), np.zeros(0, dtype=bool)
        speed, force, slow = self.friction[contact](values) if self.friction else (empty, empty, empty)
        try:
            run = self.motion.run(values=values, initial=initial)
            excited = self.excited(values)
        except SceneError as error:
            return View(empty, empty, empty, unmoved, speed, force, slow, str(error))
        if not run.t_final > 0:
            return View(empty, empty, empty, unmoved, speed, force, slow, run.advice)
        begin = (1 - SHOWN) * run.t_final if excited else 0.0
        within = run.t[run.t >= begin]
        t = np.union1d(np.linspace(begin, run.t_final, SAMPLES), within[:: max(1, within.size // SAMPLES)])
        n = len(self.file.scene.system.q)
        velocity = self.file.scene.system.u[coordinate]
        rubbing = [any(w.has(velocity) for w in c.slips) for c in self.file.scene.contacts]
        t, states, held = motion_to_draw(run, t, rubbing)
        return View(t, states[coordinate], states[n + coordinate], held, speed, force, slow, run.advice)

    def half_range(self, values: Numbers, at: float, initial: Numbers = NO_NUMBERS, coordinate: int = 0) -> float:
        """Return half the range of a coordinate after settling, with the swept value; NaN if a run fails."""
        try:
            run = next(self.steady.windows({**values, self.swept: at}, initial))
        except SceneError:
            return float("nan")
        return float("nan") if run.advice else 0.5 * float(run[f"high{coordinate}"] - run[f"low{coordinate}"])

    def amplitudes(
        self, values: Numbers, seconds: float, initial: Numbers = NO_NUMBERS, coordinate: int = 0
    ) -> Iterator[list[tuple[float, float]]]:
        """Yield batches of points of the amplitude diagram, each computed within a given time, coarse first."""
        points: list[tuple[float, float]] = []
        begin = time.perf_counter()
        for at in self.speeds if self.swept else ():
            points.append((float(at), self.half_range(values, float(at), initial, coordinate)))
            if time.perf_counter() - begin > seconds:
                yield points
                points, begin = [], time.perf_counter()
        yield points

    def toml(self, values: Numbers, initial: Numbers) -> str:
        """Return a scene file with the numbers that differ from those of the file.

        Raises
        ------
        SceneError
            If the file does not say some of them, or was not read from a file.
        """
        if self.tables is None:
            raise SceneError("the scene was not read from a file; there is nothing to write it into")
        changed = {r.name: values[r.name] for r in self.ranges if values[r.name] != r.value}
        started = {r.name: initial[r.name] for r in self.starts if initial[r.name] != r.value}
        tables = with_numbers(self.tables, changed, started)
        read_tables(tables, self.file.path)  # raises on what no file can say
        return written(tables) + "\n"


def explorer(file: SceneFile) -> Explorer:
    """Prepare a scene file: compile all programs that the explorer needs.

    Raises
    ------
    SceneError
        If the scene has no values to change.
    """
    if not file.scene.parameters:
        raise SceneError(f"{file.path}: the scene has no values to change; name some in [values]")
    tables = tables_of(file)
    if tables is not None:
        tables = with_friction_values(tables, file.path)
        file = read_tables(tables, file.path)
    scene, (swept, speeds) = file.scene, _sweep(file)
    motion = prepare(as_run(scene).wanting({PATH: as_run(scene).outputs[PATH]}), TOLERANCE)
    path, n = motion.run(), len(scene.system.q)
    times = Schedule(SETTLE * scene.horizon, scene.horizon, note=FIXED)
    extremes: dict[str, Output] = {f"high{k}": Max(q) for k, q in enumerate(scene.system.q)}
    extremes |= {f"low{k}": Min(q) for k, q in enumerate(scene.system.q)}
    fastest = float(np.max(np.abs(path.x[n : 2 * n])))
    prepared = Explorer(
        file,
        tables,
        _ranges(file, swept, speeds),
        _starts(file, path),
        swept,
        _coarse_first(speeds),
        np.max(np.abs(path.x), axis=1),
        motion,
        Settling(scene, times, extremes, tolerance=TOLERANCE),
        tuple(_friction(file, contact, fastest) for contact in scene.contacts if not contact.frictionless),
    )
    for values in _choices_of_zeros(prepared.ranges):
        prepared.view(values)
        if swept:
            prepared.half_range(values, float(speeds[-1]))
    return prepared


def _starts(file: SceneFile, path: Run) -> tuple[SliderRange, ...]:
    """Return a range around the start of each state that is a number, as wide as the motion at least."""
    sliders = []
    for k, (state, value) in enumerate(file.scene.initial.items()):
        if isinstance(value, float):
            reach = 1.5 * (float(np.max(np.abs(path.x[k]))) or 1.0)
            sliders.append(slider_range(state.name, file.units.get(state.name, ""), -reach, reach, value))
    return tuple(sliders)


def _sweep(file: SceneFile) -> tuple[str, np.ndarray]:
    """Return the parameter of the amplitude diagram and its values."""
    if file.sweep is not None:
        return file.sweep.parameter, np.linspace(file.sweep.start, file.sweep.stop, POINTS)
    values = file.scene.parameter_values()
    speeds = [s for s in belt_speeds(file.scene) if values[s] != 0]
    if not speeds:
        return "", np.zeros(0)
    return speeds[0].name, np.linspace(0.1, 3.0, POINTS) * values[speeds[0]]


def _coarse_first(values: np.ndarray) -> np.ndarray:
    """Return values with both ends first, then the middle, then the middles of the halves."""
    order, step = list(range(0, values.size, max(values.size - 1, 1))), max(values.size - 1, 0) // 2
    while step:
        order += [k for k in range(step, values.size, step) if k not in order]
        step //= 2
    return values[order]


def _ranges(file: SceneFile, swept: str, speeds: np.ndarray) -> tuple[SliderRange, ...]:
    """Return a range around each value; of a zero value, the bounds of the design, or 0 to 1."""
    plan = file.plan("quench")
    bounds = {} if plan is None else {k: list(plan.arguments[k]) for k in ("a", "Omega")}
    sliders = []
    for symbol, value in file.scene.parameter_values().items():
        low, high = (value / 10, 3 * value) if value > 0 else (3 * value, value / 10) if value < 0 else (0.0, 1.0)
        if value == 0 and symbol.name in bounds:
            high = float(bounds[symbol.name][1])
        if symbol.name == swept:
            low, high = min(float(speeds.min()), value), max(float(speeds.max()), value)
        sliders.append(slider_range(symbol.name, file.units.get(symbol.name, ""), low, high, float(value)))
    return tuple(sliders)


def _choices_of_zeros(ranges: tuple[SliderRange, ...]) -> list[dict[str, float]]:
    """Return a set of values for every choice of which zero values stay zero."""
    zeros = [r for r in ranges if r.value == 0][:MOST_ZEROS]
    base = {r.name: r.value for r in ranges}
    choices = itertools.product((False, True), repeat=len(zeros))
    return [base | {r.name: r.high for r, on in zip(zeros, chosen, strict=True) if on} for chosen in choices]


def _friction(
    file: SceneFile, contact: Contact, fastest: float
) -> Callable[..., tuple[np.ndarray, np.ndarray, np.ndarray]]:
    """Return a function of values: speeds, coefficients of a contact, and those under the fast excitation.

    The speeds go beyond the breaks of the law and the belts, or `fastest`, that of the motion, without any.
    """
    from symfric.theory.separation import fast_slips

    scene = file.scene
    parameters = tuple(scene.values)
    law = numeric_function((SPEED, *parameters), contact.law.kinetic)
    shaken = scene.where({r.name: r.high for r in _ranges(file, "", np.zeros(0)) if r.value == 0})
    try:
        fast = fast_slips(shaken)[contact.name] if is_excited(shaken) else sp.Integer(0)
    except SceneError:
        fast = sp.Integer(0)
    top = 1.5 * (max([float(b.subs(scene.values)) for b in contact.law.breaks] + [_reach(file)]) or fastest or 1.0)
    return partial(_curves, parameters, law, numeric_function(parameters, fast), top)


def _reach(file: SceneFile) -> float:
    """Return the largest belt speed of the file."""
    swept, speeds = _sweep(file)
    values = file.scene.parameter_values()
    given = [abs(values[s]) for s in belt_speeds(file.scene)]
    return max(
        [
            0.0,
            *map(float, given),
            *(np.abs(speeds).tolist() if swept in {s.name for s in belt_speeds(file.scene)} else ()),
        ]
    )


def _curves(
    parameters: Sequence[sp.Symbol], law: Evaluated, fast: Evaluated, top: float, values: Mapping[str, float]
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return both curves; the mean over a period of the fast slip is computed from equally spaced phases."""
    given = [values[s.name] for s in parameters]
    v = np.linspace(top / SPEEDS, top, SPEEDS)
    q = abs(float(fast(*given)))
    effective = np.full(SPEEDS, np.nan)
    if q > 0:
        slip = v[:, None] - q * np.cos((np.arange(PHASES) + 0.5) * np.pi / PHASES)
        effective = np.mean(np.sign(slip) * law(np.abs(slip), *given), axis=1)
    return v, law(v, *given) * np.ones(SPEEDS), effective
