"""What the solver says: one motion with its stick intervals, and the steady vibration over a range of values."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from symfric.ensemble.cases import run_cases
from symfric.model.excitation import excitation_of
from symfric.model.outputs import Max, Min, Trajectory
from symfric.model.scene import Scene
from symfric.orbits.steady_state import (
    END,
    Vibration,
    measuring,
    schedule,
    settling,
    state_symbol,
    stick_intervals,
    sticking,
    still_changes,
)
from symfric.scenefile import SweepPlan

SAMPLES = 4000  # of a motion to draw
PATH = "motion of the study"  # an output's name no file is likely to use


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
        return sticking(self.t, sticks, 0.0 if ends else 1e-12 * self.t[-1])


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


def vibrations(
    scene: Scene, parameter: str, values: np.ndarray, plan: SweepPlan, progress: Callable
) -> list[Vibration]:
    """Return the steady vibration for each value of a parameter; NaN where a run failed.

    The range is measured twice, one window after the other: where both differ, the motion had not settled.

    Parameters
    ----------
    plan : SweepPlan
        Coordinate, settling time and window.
    progress : callable ``(fraction) -> None``
    """
    varied = frozenset({parameter})
    if parameter in excitation_of(scene, varied).parameters:  # every value has its own times
        scenes, columns = [scene.where({parameter: float(v)}) for v in values], {}
        times = [schedule(one, plan.settle, plan.window) for one in scenes]
    else:
        scenes, columns = [scene.where({parameter: float(values[0])})], {parameter: np.asarray(values, dtype=float)}
        times = [schedule(scenes[0], plan.settle, plan.window, varied)]
    x = state_symbol(scene, plan.coordinate)
    first = [settling(one, wait) for one, wait in zip(scenes, times, strict=True)]
    window = [measuring(one, wait, {"high": Max(x), "low": Min(x)}) for one, wait in zip(scenes, times, strict=True)]
    _, found = run_cases(first, columns, progress=lambda f: progress(f / 3))
    kept = {n: column for n, column in columns.items() if n in {s.name for s in window[0].parameters}}
    _, one = run_cases(window, kept, starts=found[END], progress=lambda f: progress((1 + f) / 3))
    _, two = run_cases(window, kept, starts=one[END], progress=lambda f: progress((2 + f) / 3))
    return [
        _of_windows(*((float(w["high"][k]), float(w["low"][k])) for w in (one, two)), times[k % len(times)].note)
        for k in range(len(values))
    ]


def _of_windows(one: tuple[float, float], two: tuple[float, float], note: str) -> Vibration:
    """Return what two windows say; without a period of the excitation, by which they are apart, the first alone."""
    last = one if note else two
    if not np.all(np.isfinite(last)):
        return Vibration(np.nan, np.nan)
    return Vibration(*last, note=note or ("its range still changes" if still_changes(one, two) else ""))
