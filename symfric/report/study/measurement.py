"""Computed results of a study: one motion with its stick intervals, and the steady vibration over a range of values."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from types import MappingProxyType

import numpy as np
import sympy as sp

from symfric.ensemble.cases import Listed
from symfric.model.excitation import excitation_of
from symfric.model.outputs import Integral, Max, Min, Output, Trajectory, dissipated_power, normal_force
from symfric.model.scene import Scene
from symfric.orbits.steady_state import (
    END,
    Schedule,
    Vibration,
    measuring,
    open_intervals,
    schedule,
    settling,
    state_symbol,
    stick_intervals,
    sticking,
    still_changes,
    weights_of,
)
from symfric.scenefile import SweepPlan
from symfric.solve.plotting import motion_to_draw
from symfric.solve.routes import simulate

SAMPLES = 4000  # samples of a motion to draw
END_SHOWN = 0.025  # last fraction of a motion that is sampled more densely, for the picture of its last periods
MOST_STEPS = 40_000  # further samples, at the steps of a run; of more, at every second, third, ...
MOST_CONTACTS = 40  # of which the loads and the energies are computed
STRIKES = ("impact", "close")  # kinds of events
PATH = "motion of the study"  # name of an additional output, unlikely to occur in a file


@dataclass(frozen=True, eq=False)
class SampledMotion:
    """One computed motion, sampled for drawing.

    Attributes
    ----------
    t : ndarray, shape (n_t,)
        At a jump of a state twice.
    x : ndarray, shape (n_x, n_t)
    names : tuple of str
        States, and named rows of a structure.
    sticks : dict of str to tuple of (start, end)
        Intervals in which each contact sticks.
    outputs : dict of str to float
        Scalar outputs of the scene.
    route, status, advice : str
    events : int
    energy_residual : float
    also : dict of str to float
        Further outputs that a page shows.
    opens : dict of str to tuple of (start, end)
        Intervals in which each contact is open.
    impacts : dict of str to int
        How often each contact that opens strikes.
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
    also: Mapping[str, float] = field(default_factory=dict)
    opens: Mapping[str, tuple[tuple[float, float], ...]] = field(default_factory=dict)
    impacts: Mapping[str, int] = field(default_factory=dict)

    def sticking(self, contacts: Sequence[str], ends: bool = True) -> np.ndarray:
        """Whether any of some contacts sticks at each time, shape (n_t,), with or without the ends of the intervals."""
        sticks = {name: self.sticks[name] for name in contacts}
        return sticking(self.t, sticks, 0.0 if ends else 1e-12 * self.t[-1])


def as_run(scene: Scene) -> Scene:
    """Return the scene with its trajectory as an additional output."""
    return scene.wanting({**scene.outputs, PATH: Trajectory()})


def motion(scene: Scene, also: Mapping[str, Output] = MappingProxyType({}), tolerance: float = 1e-9) -> SampledMotion:
    """Simulate the scene; return its motion and scalar outputs, with further outputs."""
    run = simulate(as_run(scene.wanting({**scene.outputs, **also})), tolerance=tolerance)
    if not run.t_final > 0:
        run.checked()
    steps = run.t[run.t <= run.t_final]
    end = np.linspace((1 - END_SHOWN) * run.t_final, run.t_final, SAMPLES // 4)
    t = np.union1d(np.linspace(0.0, run.t_final, SAMPLES), np.append(end, steps[:: 1 + steps.size // MOST_STEPS]))
    scalars = {k: float(v) for k, v in run.outputs.items() if isinstance(v, float)}
    t, x, _ = motion_to_draw(run, t)
    points = [s.name for s in scene.system.rows if s.name.isidentifier()]
    return SampledMotion(
        t,
        np.vstack([x, *(weights_of(scene, name) @ x for name in points)]),
        (*run.names, *points),
        stick_intervals(run),
        {k: v for k, v in scalars.items() if k not in also},
        run.route,
        run.status.name,
        run.advice,
        int(run.stats.get("events", 0)),
        float(run.energy_residual()),
        {k: v for k, v in scalars.items() if k in also},
        open_intervals(run),
        {c.name: sum(e.contact == c.name and e.kind in STRIKES for e in run.events) for c in scene.contacts_that_open},
    )


def largest_load(contact: str) -> str:
    """Return the name of the output of the largest normal force of a contact."""
    return f"largest load of contact {contact}"


def contact_outputs(scene: Scene) -> dict[str, Output]:
    """Return outputs of the motion that say what the contacts of a structure do, or contacts that open."""
    outputs: dict[str, Output] = {}
    if scene.contacts_that_open:
        return {largest_load(c.name): Max(normal_force(c.name)) for c in scene.contacts}
    if scene.system.linear is None or len(scene.contacts) > MOST_CONTACTS:
        return outputs
    for c in scene.contacts:
        outputs[f"least load of contact {c.name}"] = Min(sp.sympify(c.normal))
        outputs[f"energy dissipated in contact {c.name}"] = Integral(dissipated_power(c.name))
    return outputs


def vibrations(
    scene: Scene, parameter: str, values: np.ndarray, plan: SweepPlan, progress: Callable[[float], None]
) -> list[Vibration]:
    """Return the steady vibration for each value of a parameter; NaN where a run failed.

    The range is measured in two consecutive windows; where they differ, the motion had not settled.

    Parameters
    ----------
    plan : SweepPlan
        Coordinate, settling time and window.
    progress : callable ``(fraction) -> None``
    """
    varied = frozenset({parameter})
    if parameter not in excitation_of(scene, varied).parameters:
        if scene.values[scene.parameter(parameter)] is None:
            scene = scene.where({parameter: float(values[0])})
        times = schedule(scene, plan.settle, plan.window, varied)
        return _measured(scene, times, plan.coordinate, {parameter: np.asarray(values)}, progress)
    measured = []
    for k, v in enumerate(values):  # settling times depend on the value
        progress(k / len(values))
        one = scene.where({parameter: float(v)})
        measured += _measured(one, schedule(one, plan.settle, plan.window), plan.coordinate, {}, None)
    return measured


def _measured(
    scene: Scene,
    times: Schedule,
    coordinate: str,
    values: Mapping[str, np.ndarray],
    progress: Callable[[float], None] | None,
) -> list[Vibration]:
    """Return the steady vibration for given parameter values, or for those of the scene."""
    x = state_symbol(scene, coordinate)

    def told(k: int) -> Callable[[float], None] | None:
        return None if progress is None else lambda f: progress((k + f) / 3)

    extremes = {"high": Max(x), "low": Min(x)}
    first = Listed(settling(scene, times, extremes), tuple(values))
    window = Listed(measuring(scene, times, extremes), tuple(values))
    _, settled = first.run(values, progress=told(0))
    _, one = window.run(values, settled[END], progress=told(1))
    two = one if times.note else window.run(values, one[END], progress=told(2))[1]
    reach = np.fmax(settled["high"], one["high"]) - np.fmin(settled["low"], one["low"])
    first_range, second_range = (list(zip(w["high"].tolist(), w["low"].tolist(), strict=True)) for w in (one, two))
    windows = zip(first_range, second_range, reach.tolist(), strict=True)
    return [_of_windows(before, after, size, times.note) for before, after, size in windows]


def _of_windows(one: tuple[float, float], two: tuple[float, float], reach: float, note: str) -> Vibration:
    """Return the vibration from two windows, or from one if the excitation has no period."""
    if not np.all(np.isfinite(two)):
        return Vibration(np.nan, np.nan)
    return Vibration(*two, note=note or ("its range still changes" if still_changes(one, two, reach) else ""))
