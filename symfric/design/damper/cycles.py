"""Limit cycles of a system with a damper, and growth of small disturbances of steady sliding."""

from dataclasses import dataclass

import numpy as np

from symfric.errors import NotFound
from symfric.model.outputs import End, HalfRange, Trajectory
from symfric.model.scene import Scene
from symfric.model.symbols import Key
from symfric.orbits.cycle import Orbit, limit_cycle
from symfric.orbits.guess import Fades
from symfric.orbits.steady_state import Schedule, Settling, stick_fraction
from symfric.solve.routes import prepare
from symfric.solve.run import finished
from symfric.theory.equilibrium import Equilibrium, equilibrium
from symfric.theory.stability import stability

_STARTS = (20.0, 1.0, 0.01)  # initial displacements, tried in turn, relative to those of steady sliding
_PULLS = 8  # least horizon in units of the time that a slow drive pulls until release: some stick-slip cycles
_WAIT, _SHRINKS = 40, 0.995  # horizons between two measurements; ratio of half ranges below which a motion shrinks
_SMALL = 1e-7  # disturbance, relative to steady sliding, that grows linearly even near narrow features of a law
_TOLERANCE = 1e-13  # tolerance of the runs whose differences give the growth


@dataclass(frozen=True)
class Requirement:
    """Requirement on a damper.

    Attributes
    ----------
    name, speed : str
        Names of the parameters of damping and speed.
    bounds, speeds : (float, float)
    half_range : float
        Largest half range of the first coordinate; 0 for no vibration.
    sticking : bool
        Whether contacts may stick.
    """

    name: str
    speed: str
    bounds: tuple[float, float]
    speeds: tuple[float, float]
    half_range: float
    sticking: bool

    @property
    def quiet(self) -> bool:
        """Whether no vibration is allowed."""
        return self.half_range == 0 and self.sticking

    def meets(self, orbit: "Orbit | Left | None") -> bool:
        """Whether a motion meets the requirement; None stands for steady sliding."""
        if orbit is None:
            return True
        small = orbit.half_range[0] <= self.half_range or (self.half_range == 0 and not self.sticking)
        return small and (self.sticking or orbit.stick_fraction == 0)


@dataclass(frozen=True)
class Left:
    """End of a long run without a periodic motion: half ranges of the coordinates and stick fraction."""

    half_range: np.ndarray
    stick_fraction: float


def distances(r: Requirement) -> tuple[float, ...]:
    """Return the initial distances from steady sliding, relative to its own displacement."""
    return _STARTS[:-1] if r.quiet else _STARTS  # small displacements are covered by the stability of sliding


def outermost(scene: Scene, r: Requirement, beside: Orbit | None = None) -> Orbit | Left | None:
    """Return the outermost limit cycle to which runs settle; None if all end in steady sliding.

    Every coordinate is displaced in turn, first far, then as far as steady sliding displaces the system, then little;
    smaller displacements are tried while no motion misses the requirement. Of several cycles one that misses it comes
    first, the largest of them.

    Parameters
    ----------
    scene : Scene
    r : Requirement
    beside : Orbit, optional
        A cycle for other values nearby, whose start is tried too.
    """
    rest = equilibrium(scene)
    states, q = scene.system.states, scene.system.q
    start = dict(zip(states, rest.x.tolist(), strict=True))
    sizes = _sizes(scene, rest)[: len(q)].tolist()
    pulled = max(sizes) / max(abs(v) for v in rest.sliding.values())  # time for which a sticking contact pulls
    scene = scene.until(max(scene.horizon, _PULLS * pulled))
    rounds = [[{**start, x: start[x] + share * far} for x, far in zip(q, sizes, strict=True)] for share in distances(r)]
    if beside is not None:
        rounds.insert(0, [dict(zip(states, beside.start.tolist(), strict=True))])
    ends: list[Orbit | Left] = []
    for starts in rounds:
        seen = [_settled(scene.starting(e)) for e in starts]
        ends += [e for e in seen if e is not None]
        if not all(r.meets(e) for e in ends):
            break
    return max(ends, key=lambda o: (not r.meets(o), o.half_range[0]), default=None)


def _settled(scene: Scene) -> Orbit | Left | None:
    """Return the limit cycle to which a motion settles; None if it is steady sliding."""
    try:
        return limit_cycle(scene)
    except Fades:
        return None
    except NotFound:
        return _by_run(scene)


def _by_run(scene: Scene) -> Left | None:
    """Return the end of a long run; None if the motion still shrinks.

    Near the onset of vibration, motions shrink so slowly that they resemble a cycle.
    """
    outputs = {f"x{k}": HalfRange(q) for k, q in enumerate(scene.system.q)} | {"path": Trajectory()}
    settling = Settling(scene, Schedule(_WAIT * scene.horizon, scene.horizon), outputs)
    before = settling.measured()
    after = settling.measured(initial=settling.start(before.final))
    first, last = ([float(run[f"x{k}"]) for k in range(len(scene.system.q))] for run in (before, after))
    if all(b < _SHRINKS * a for a, b in zip(first, last, strict=True)):
        return None
    return Left(np.array(last), stick_fraction(after))


class Disturbed:
    """Growth rate of small disturbances of steady sliding, from runs of the full model.

    Parameters
    ----------
    scene : Scene
        Its fastest mode sets the length of the runs: one period of it.
    r : Requirement
    """

    def __init__(self, scene: Scene, r: Requirement):
        self._scene, self._r, self._duration = scene, r, 2 * np.pi / _fastest(scene)
        self._program = prepare(scene.until(self._duration, {"end": End()}), _TOLERANCE)

    def rate(self, speed: float, damping: float) -> float:
        """Return the growth rate, 1/time, from differences of runs; negative if all disturbances shrink."""
        values: dict[Key, float] = {self._r.speed: speed, self._r.name: damping}
        there = self._scene.where(values)
        rest = equilibrium(there)
        names, columns = [s.name for s in there.system.states], []
        for k, size in enumerate(_SMALL * _sizes(there, rest)):
            ends = []
            for side in (1, -1):
                x = rest.x.copy()
                x[k] += side * size
                run = self._program.run(values=values, initial=dict(zip(names, x.tolist(), strict=True)))
                ends.append(finished(run).final)
            columns.append((ends[0] - ends[1]) / (2 * size))
        largest = np.max(np.abs(np.linalg.eigvals(np.column_stack(columns))))
        return float(np.log(max(largest, 1e-300)) / self._duration)


def _fastest(scene: Scene) -> float:
    """Return the largest absolute eigenvalue of steady sliding, 1/time."""
    return float(np.max(np.abs(stability(scene).eigenvalues)))


def _sizes(scene: Scene, rest: Equilibrium) -> np.ndarray:
    """Return the scales of displacement, velocity and further states, from steady sliding itself."""
    speed = max(abs(v) for v in rest.sliding.values())
    n, numbers = len(scene.system.q), scene.numbers()
    length = max(speed / _fastest(scene), float(np.max(np.abs(rest.x[:n]))))
    length = max(length, *(abs(numbers[s]) for s in scene.system.q))
    others = np.abs(rest.x[2 * n :])
    return np.concatenate([np.full(n, length), np.full(n, speed), np.where(others > 0, others, 1.0)])
