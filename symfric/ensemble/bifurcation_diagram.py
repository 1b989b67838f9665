"""Brute-force bifurcation diagrams: section points after a transient, for many values of a parameter."""

from collections.abc import Callable, Generator, Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from contextlib import closing
from dataclasses import dataclass, field
from typing import Any

import numpy as np
import sympy as sp

from symfric.axes import Axes
from symfric.ensemble.cases import Listed
from symfric.ensemble.sampling import row_of
from symfric.ensemble.worker import CODES, NOT_COMPUTED, REFUSED, Task, make_program
from symfric.errors import NoRoute, SceneError
from symfric.long_calls import logged, tell, until_interrupted
from symfric.model.arguments import flag
from symfric.model.excitation import periodic
from symfric.model.outputs import Samples, Trajectory
from symfric.model.results import ArrayResult, Drawable, Labelled
from symfric.model.scene import Scene, check_scene
from symfric.model.symbols import Key, finite
from symfric.model.units import attributes_of
from symfric.orbits.poincare import Cut, cut_of
from symfric.orbits.sizes import over_time
from symfric.solve.case_values import workers_of
from symfric.solve.program import check_tolerance
from symfric.solve.protocol import Program
from symfric.solve.run import Run
from symfric.solve.status import Status

_MOST = 4_000_000  # most numbers of points that are computed at once
_AT_ONCE = 256  # most values that one thread computes at once, so that an interrupt loses no more
_STILL = 1e-6  # range relative to the sizes of the states below which a motion after the transient is a point


@dataclass(frozen=True, eq=False)
class BifurcationDiagram(ArrayResult, Drawable):
    """The points of a section for every value of a parameter.

    `plot` draws the first coordinate on the section against the parameter.

    Attributes
    ----------
    parameter : str
    values : ndarray, shape (n_v,)
        In the order given.
    case : ndarray of int, shape (n,)
        Index of the value to which a point belongs.
    times : ndarray, shape (n,)
    states : ndarray, shape (n_x, n)
    status : ndarray of int, shape (n_v,)
        Codes of `Status`; -1 if the value is not valid, -3 if it was not computed, see
        `symfric.keep_when_interrupted`. A run that failed has no points.
    names : tuple of str
        Of the states.
    about : str
        Description of the section.

    Examples
    --------
    >>> import sympy as sp
    >>> import symfric as sf
    >>> x = sp.Symbol("x", real=True)
    >>> belt = sf.scenes.mass_on_belt(v_b=0.2, horizon=20.0)
    >>> diagram = sf.bifurcation_diagram(belt.until(100.0), "v_b", [0.2, 0.3], "u")
    >>> diagram.points(0).shape[0]
    2
    >>> sorted(diagram.to_dict())[:2]
    ['parameter', 'points']
    >>> len(diagram.to_xarray().data_vars) > 0
    True
    >>> ax = diagram.plot()
    """

    parameter: str
    values: np.ndarray
    case: np.ndarray
    times: np.ndarray
    states: np.ndarray
    status: np.ndarray
    names: tuple[str, ...]
    about: str
    units: Mapping[str, str] = field(default_factory=dict, repr=False)

    def _labelled(self) -> Labelled:
        told = lambda name: attributes_of(name, self.units)  # noqa: E731
        data: dict = {n: ("point", row, told(n)) for n, row in zip(self.names, self.states, strict=True)}
        data |= {"t": ("point", self.times, told("t")), "status": ("case", self.status)}
        coordinates = {
            self.parameter: ("point", self.values[self.case], told(self.parameter)),
            "value": ("case", self.values, told(self.parameter)),
        }
        return data, coordinates, {"section": self.about}

    def points(self, k: int) -> np.ndarray:
        """Return the states on the section for value k, shape (n_x, number of points).

        Parameters
        ----------
        k : int
            Number of the value, from 0.

        Returns
        -------
        ndarray, shape (n_x, number of points)
        """
        return self.states[:, self.case == k]

    def _draw(self, ax: Axes | None) -> Axes:
        from symfric.ensemble.plotting import plot_diagram

        return plot_diagram(self, ax)

    def to_dict(self) -> dict[str, Any]:
        rows = range(self.values.size)
        return {
            "parameter": self.parameter,
            "section": self.about,
            "values": self.values.tolist(),
            "status": [CODES[s] for s in self.status.tolist()],
            "points": [dict(zip(self.names, self.points(k).tolist(), strict=True)) for k in rows],
        }

    def __repr__(self) -> str:
        failed = int(np.count_nonzero(self.status))
        lost = f", {failed} runs failed" if failed else ""
        low, high = np.min(self.values), np.max(self.values)
        return (
            f"BifurcationDiagram({self.parameter} from {low:.6g} to {high:.6g}, {self.values.size} values, "
            f"{self.times.size} points of {self.about}{lost})"
        )


@logged
def bifurcation_diagram(
    scene: Scene,
    parameter: Key,
    values: Sequence[float],
    section: sp.Expr | str | None = None,
    *,
    level: float = 0.0,
    direction: int = 1,
    phase: float = 0.0,
    transient: float | None = None,
    carry: bool = False,
    jobs: int = 1,
    tolerance: float = 1e-9,
) -> BifurcationDiagram:
    """Run a scene for many values of a parameter and store the points on a section after a transient.

    Parameters
    ----------
    scene : Scene
        Its horizon is that of every run.
    parameter : Symbol or str
    values : sequence of float
    section, level, direction, phase
        See `symfric.orbits.poincare.poincare`. A velocity as section keeps the extremes of its coordinate: the largest
        with ``direction=-1``, the smallest with 1.
    transient : float, optional
        Time that is skipped; half of the horizon unless given.
    carry : bool
        Start every value but the first at the end of the previous run, so that increasing and decreasing values
        show hysteresis; otherwise each starts as the scene does. Such runs wait for each other.
    jobs : int
        Threads for the values, if they are not carried on; -1 for as many as there are processors.
    tolerance : float

    Returns
    -------
    BifurcationDiagram

    Raises
    ------
    SceneError
        If the section cannot be read, or names and numbers are wrong.

    Notes
    -----
    A motion that comes to rest does not cross a section any more: then its final state is its one point.

    Values that are not carried on and have sections at the same times, phases of an excitation whose period does not
    depend on the parameter, run all at once by `Program.map`. Other sections need the trajectory of every value.

    Examples
    --------
    >>> import sympy as sp
    >>> import symfric as sf
    >>> x = sp.Symbol("x", real=True)
    >>> belt = sf.scenes.mass_on_belt(v_b=0.2, horizon=20.0)
    >>> diagram = sf.bifurcation_diagram(belt.until(100.0), "v_b", [0.2, 0.3], "u")
    >>> diagram.values.round(6)
    array([0.2, 0.3])
    """
    flag(carry, "carry")
    check_scene(scene)
    name = scene.parameter(parameter).name
    row = row_of(values, name)
    scene = scene.where({name: row[0]}) if scene.values[scene.parameter(name)] is None else scene
    transient = finite(0.5 * scene.horizon if transient is None else transient, "transient")
    if not 0 <= transient < scene.horizon:
        raise SceneError(f"transient is {transient:g}; the runs cover 0 to {scene.horizon:g}")
    cut = cut_of(scene, section, level, direction, phase, frozenset({name}))
    task = Task(scene.wanting({"path": Trajectory()}), check_tolerance(tolerance), None, (name,), ())
    jobs = min(workers_of(jobs, "jobs"), row.size)
    stream: Generator[Case, None, None]
    if carry:
        excitation = periodic(scene, frozenset({name}))
        stream = _carried(make_program(task), name, row, cut, transient, excitation.period if excitation else None)
    else:
        common = _common_times(scene, name, row, cut, transient)
        if common is None:
            stream = _apart(make_program(task), name, row, cut, transient, jobs)
        else:
            stream = _at_once(scene, name, row, common, task.tolerance, jobs)
    cases: list[Case] = []
    with until_interrupted("bifurcation_diagram"), closing(stream):
        for case in stream:
            cases.append(case)
            tell(f"{len(cases)} of {row.size} values of {name}", len(cases) / row.size)
    if not cases:
        raise KeyboardInterrupt
    none = np.zeros((len(scene.system.states), 0))
    cases += [(NOT_COMPUTED, none[0], none)] * (row.size - len(cases))
    status, times, states = zip(*cases, strict=True)
    return BifurcationDiagram(
        parameter=name,
        values=row,
        case=np.repeat(np.arange(row.size), [t.size for t in times]),
        times=np.concatenate(times),
        states=np.concatenate(states, axis=1),
        status=np.array(status, dtype=np.int32),
        names=tuple(s.name for s in scene.system.states),
        about=cut.about,
        units=scene.units,
    )


Case = tuple[int, np.ndarray, np.ndarray]  # status, times (n,), states (n_x, n)


def _common_times(scene: Scene, name: str, row: np.ndarray, cut: Cut, transient: float) -> np.ndarray | None:
    """Return the times of the sections if they are the same for all values, else None."""
    if cut.period is None:
        return None
    fixed = {s.name: v for s, v in scene.parameter_values().items()}
    ends = {cut.period(fixed | {name: v}) for v in row.tolist()}
    times = cut.times(fixed | {name: row[0]}, transient, scene.horizon)
    return None if len(ends) > 1 or not times.size else times


def _at_once(
    scene: Scene, name: str, row: np.ndarray, times: np.ndarray, tolerance: float, jobs: int
) -> Generator[Case, None, None]:
    """Run many values at once, with sections at the same times."""
    states = [s.name for s in scene.system.states]
    outputs = {s.name: Samples(s, times.tolist()) for s in scene.system.states}
    most = max(1, min(_AT_ONCE * jobs, _MOST // (len(states) * times.size)))
    cases = Listed(scene.wanting(outputs), (name,), tolerance)
    for begin in range(0, row.size, most):
        status, seen = cases.run({name: row[begin : begin + most]}, jobs=jobs)
        blocks = np.stack([np.atleast_2d(seen[n]) for n in states])  # (n_x, n_t, n)
        for k, code in enumerate(status.tolist()):
            right = code == Status.OK
            yield code, times if right else times[:0], blocks[:, :, k] if right else blocks[:, :0, k]


def _apart(
    program: Program, name: str, row: np.ndarray, cut: Cut, transient: float, jobs: int
) -> Generator[Case, None, None]:
    """Run every value from the scene's own start, on several threads."""

    def work(v: float) -> Case:
        return _case(program, {name: v}, {}, cut, transient)[0]

    if jobs == 1:
        yield from map(work, row.tolist())
        return
    crew = ThreadPoolExecutor(jobs)
    try:
        yield from crew.map(work, row.tolist())
    finally:
        crew.shutdown(cancel_futures=True)


def _carried(
    program: Program,
    name: str,
    row: np.ndarray,
    cut: Cut,
    transient: float,
    period: Callable[[Mapping[str, float]], float] | None,
) -> Generator[Case, None, None]:
    """Run every value from the end of the last successful run, at the same phase of the excitation."""
    start: dict[str, float] = {}
    fixed = {s.name: v for s, v in program.scene.parameter_values().items()}
    for v in row.tolist():
        case, run = _case(program, {name: v}, start, cut, transient)
        yield case
        if run is not None:
            end = run.final
            if period:
                turn = period(fixed | {name: v})
                end = run(np.floor(run.t_final / turn) * turn)
            start = dict(zip(run.names, end.tolist(), strict=True))


def _case(
    program: Program, values: dict[str, float], start: dict[str, float], cut: Cut, transient: float
) -> tuple[Case, Run | None]:
    """Return the points of one value, and its run unless it failed."""
    nothing = np.zeros(0), np.zeros((len(program.scene.system.states), 0))
    try:
        run = program.run(values, start)
    except (SceneError, NoRoute):
        return (REFUSED, *nothing), None
    if run.status != Status.OK:
        return (int(run.status), *nothing), None
    times, states = cut.points(run, transient)
    if not times.size:
        late = run.x[:, run.t >= transient]
        size = over_time(np.max(np.abs(run.x), axis=1), len(run.base.system.q), run.t_final)
        if np.all(np.ptp(late, axis=1) <= _STILL * size):
            times, states = np.array([run.t_final]), run.final[:, None]
    return (0, times, states), run
