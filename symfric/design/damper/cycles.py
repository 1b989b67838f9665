"""Limit cycles of a system with a damper: which motions are left, and whether small ones grow."""

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
from symfric.theory.equilibrium import Equilibrium, equilibrium
from symfric.theory.stability import stability

_STARTS = (20.0, 1.0, 0.01)  # displacements, in those of steady sliding, from which motions start in turn
_PULLS = 8  # times that a slow drive takes to pull the system away, in a horizon: a few cycles of stick and slip
_WAIT, _SHRINKS = 40, 0.995  # horizons between two looks at a motion; what one that shrinks has left at the second
_SMALL = 1e-7  # of the same: disturbances whose growth is that of the linear motion, also beside narrow features
_TOLERANCE = 1e-13  # of the runs whose differences show growth


@dataclass(frozen=True)
class Requirement:
    """What a damper must do.

    Attributes
    ----------
    name, speed : str
        Parameters: the damping and the speed.
    bounds, speeds : (float, float)
    half_range : float
        Largest half range of the first coordinate; 0 for none at all.
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
        """Whether the system may move like that; None is steady sliding."""
        if orbit is None:
            return True
        small = orbit.half_range[0] <= self.half_range or (self.half_range == 0 and not self.sticking)
        return small and (self.sticking or orbit.stick_fraction == 0)


@dataclass(frozen=True)
class Left:
    """What a long run leaves where no periodic motion is found: half ranges of the coordinates, time that it sticks."""

    half_range: np.ndarray
    stick_fraction: float


def distances(r: Requirement) -> tuple[float, ...]:
    """Return how far from steady sliding motions start, in what it displaces the system by itself."""
    return _STARTS[:-1] if r.quiet else _STARTS  # what little displacements do is the stability of sliding


def outermost(scene: Scene, r: Requirement, beside: Orbit | None = None) -> Orbit | Left | None:
    """Return a limit cycle to which motions settle, the outermost of those seen; None if all end in steady sliding.

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
    pulled = max(sizes) / max(abs(v) for v in rest.sliding.values())  # how long a contact that sticks pulls
    scene = scene.until(max(scene.horizon, _PULLS * pulled))
    rounds = [[{**start, x: start[x] + share * far} for x, far in zip(q, sizes, strict=True)] for share in distances(r)]
    if beside is not None:
        rounds.insert(0, [dict(zip(states, beside.start.tolist(), strict=True))])
    found: list[Orbit | Left] = []
    for starts in rounds:
        seen = [_settled(scene.starting(e)) for e in starts]
        found += [e for e in seen if e is not None]
        if not all(r.meets(e) for e in found):
            break
    return max(found, key=lambda o: (not r.meets(o), o.half_range[0]), default=None)


def _settled(scene: Scene) -> Orbit | Left | None:
    """Return the limit cycle to which a motion settles; None if it is steady sliding."""
    try:
        return limit_cycle(scene)
    except Fades:
        return None
    except NotFound:
        return _by_run(scene)


def _by_run(scene: Scene) -> Left | None:
    """Return what a long run leaves; None if it still shrinks.

    Beside the onset of a vibration motions shrink so slowly that they look like a cycle, and are none.
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
    """Growth of small disturbances of steady sliding in runs of the full model.

    Parameters
    ----------
    scene : Scene
        Its fastest mode sets the length of the runs: one period of it.
    r : Requirement
    """

    def __init__(self, scene: Scene, r: Requirement):
        self._scene, self._r, self._duration = scene, r, 2 * np.pi / _fastest(scene)
        self._program = prepare(scene.until(self._duration).wanting({"end": End()}), _TOLERANCE)

    def rate(self, speed: float, damping: float) -> float:
        """Return the rate, 1/time, at which they grow, from differences of runs; negative where all of them shrink."""
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
                ends.append(run.checked().final)
            columns.append((ends[0] - ends[1]) / (2 * size))
        largest = np.max(np.abs(np.linalg.eigvals(np.column_stack(columns))))
        return float(np.log(max(largest, 1e-300)) / self._duration)


def _fastest(scene: Scene) -> float:
    """Return the largest absolute eigenvalue of steady sliding, 1/time."""
    return float(np.max(np.abs(stability(scene).eigenvalues)))


def _sizes(scene: Scene, rest: Equilibrium) -> np.ndarray:
    """Return what counts as a large displacement, velocity and further state: what sliding itself has of them."""
    speed = max(abs(v) for v in rest.sliding.values())
    n, numbers = len(scene.system.q), scene.numbers()
    length = max(speed / _fastest(scene), float(np.max(np.abs(rest.x[:n]))))
    length = max(length, *(abs(numbers[s]) for s in scene.system.q))
    others = np.abs(rest.x[2 * n :])
    return np.concatenate([np.full(n, length), np.full(n, speed), np.where(others > 0, others, 1.0)])
