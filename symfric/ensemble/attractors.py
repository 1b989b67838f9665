"""Attractors of a scene (rest, equilibrium, cycle or irregular motion), collected one after the other."""

from dataclasses import dataclass
from itertools import islice

import numpy as np
from scipy.spatial import cKDTree

from symfric.errors import NotFound
from symfric.model.outputs import StopTime, Trajectory
from symfric.model.scene import Scene
from symfric.orbits.cycle import Orbit, limit_cycle
from symfric.orbits.guess import guess_of
from symfric.orbits.steady_state import Schedule, Settling
from symfric.solve.run import Run
from symfric.solve.status import Status

_POINTS = 2000  # points stored of an autonomous cycle, or of the end of a motion without a period
_PATIENCE = 8  # settling time in horizons
_LATE = 0.75  # fraction of a run after which its motion is compared with attractors
# fractions of a motion's points that must be near an attractor for the motion to lie on it; near an irregular one,
# which is known by points only, means within the distance of neighbouring points
_WHOLE, _SHARED = 0.95, 0.5
_NEIGHBOURS = 0.9  # fraction of the points of an irregular attractor that have a neighbour within this distance


@dataclass(frozen=True, eq=False)
class Attractor:
    """An attractor: rest, equilibrium, cycle or irregular motion.

    Attributes
    ----------
    kind : str
        "rest" (friction holds the bodies, wherever they came to rest), "equilibrium" (a point that motions approach,
        such as steady sliding), "cycle" or "irregular" (chaos, a torus, or a cycle of very many periods).
    points : ndarray, shape (n_x, n)
        States on it; of a forced scene those at whole periods of the excitation. Of "rest" there are none.
    orbit : Orbit or None
        Of a cycle.

    Examples
    --------
    >>> import symfric as sf
    >>> bistable = sf.scenes.mass_on_belt(sf.laws.exponential(0.4), v_b=1.6).until(400)
    >>> found = sf.basins(bistable, {"x": [0.5, 3.0]})
    >>> found.attractors[0].kind
    'equilibrium'
    """

    kind: str
    points: np.ndarray
    orbit: Orbit | None = None

    def __repr__(self) -> str:
        if self.orbit is not None:
            return f"Attractor(cycle, period={self.orbit.period:.9g}, half_range={self.orbit.half_range[0]:.6g})"
        where = f" at {np.array2string(self.points[:, 0], precision=6)}" if self.kind == "equilibrium" else ""
        return f"Attractor({self.kind}{where})"


class Collection:
    """The attractors found so far; assigns motions to them and adds new ones.

    One motion after the other, since each is compared with the attractors of those before; many motions that all are
    far enough along are assigned at once by `nearest`.

    Parameters
    ----------
    scene : Scene
        Its horizon, whole periods of the excitation, is the time after which motions are compared with attractors.
    period : float or None
        Of the excitation.
    units : ndarray, shape (n_x,)
        Units of distances between states.
    near : float
        Distance in these units below which two states count as the same.
    tolerance : float
        Of runs.
    """

    def __init__(self, scene: Scene, period: float | None, units: np.ndarray, near: float, tolerance: float):
        self.known: list[Attractor] = []
        self._trees: list[cKDTree | None] = []
        self._reach: list[float] = []
        self._scene, self._period, self._units, self._near = scene, period, units, near
        times = Schedule(0.0, scene.horizon, period or 0.0)
        self._settling = Settling(scene, times, {"path": Trajectory(), "stop": StopTime()}, tolerance=tolerance)

    def rest(self) -> int:
        """Return the index of rest among the attractors, adding it if it is new."""
        index = next((k for k, a in enumerate(self.known) if a.kind == "rest"), None)
        return self._add(Attractor("rest", np.zeros((self._units.size, 0)))) if index is None else index

    def nearest(self, states: np.ndarray) -> np.ndarray:
        """Return the index of the attractor nearest to each state (n_x, n), -1 if none is near; shape (n,)."""
        best, label = np.full(states.shape[1], np.inf), np.full(states.shape[1], -1)
        for k, (tree, reach) in enumerate(zip(self._trees, self._reach, strict=True)):
            if tree is not None:
                distance = tree.query(states.T / self._units)[0]
                better = (distance < best) & (distance < reach)
                label, best = np.where(better, k, label), np.where(better, distance, best)
        return label

    def settle(self, state: np.ndarray) -> tuple[int, Status]:
        """Simulate from a state until the attractor of the motion is known.

        Returns
        -------
        attractor : int
            Its index, possibly a new one; -1 if the run failed.
        status : Status
        """
        cloud = []
        windows = self._settling.windows(initial=self._settling.start(state))
        for turn, run in enumerate(islice(windows, _PATIENCE)):
            if run.status != Status.OK:
                return -1, run.status
            if np.isfinite(run["stop"]):
                return self.rest(), Status.OK
            late = self._sampled(run, _LATE * run.t_final)
            known = self._among(late)
            # may contain a cycle
            if known < 0 or self.known[known].kind == "irregular":
                self._seek(run, late)
                known = self._among(late)
            if known >= 0:
                return known, Status.OK
            if turn >= _PATIENCE // 2:
                cloud.append(self._sampled(run, 0.0))
        return self._add(Attractor("irregular", np.concatenate(cloud, axis=1))), Status.OK

    def _sampled(self, run: Run, begin: float) -> np.ndarray:
        """Sample a run from a time on, at whole periods of the excitation if there is one; shape (n_x, n)."""
        if self._period is None:
            return run(np.linspace(begin, run.t_final, _POINTS))
        turns = np.arange(np.ceil(begin / self._period - 1e-9), round(run.t_final / self._period) + 1)
        return run(np.minimum(turns * self._period, run.t_final))

    def _among(self, states: np.ndarray) -> int:
        """Return the index of the attractor that contains a piece of motion (n_x, n), -1 if none does."""
        label = self.nearest(states)
        for k, attractor in enumerate(self.known):
            enough = _SHARED if attractor.kind == "irregular" else _WHOLE
            if np.mean(label == k) >= enough:
                return k
        return -1

    def _seek(self, run: Run, late: np.ndarray) -> None:
        """Add the equilibrium or the stable cycle that a motion approaches, if there is one."""
        if self._period is None and np.all(np.ptp(late, axis=1) <= self._near * self._units):
            self._add(Attractor("equilibrium", np.mean(late, axis=1)[:, None]))
            return
        try:
            guess = guess_of(run, self._period)
            turn = guess.multiple * self._period if self._period else guess.period
            orbit = limit_cycle(self._scene, (guess.start, turn))
        except NotFound:
            return
        points = self._sampled(orbit.run, 0.0)
        if orbit.stable and self._among(points) < 0:
            self._add(Attractor("cycle", points, orbit))

    def _add(self, attractor: Attractor) -> int:
        tree = cKDTree(attractor.points.T / self._units) if attractor.points.size else None
        reach = self._near
        if tree is not None and attractor.kind == "irregular":
            reach = max(reach, float(np.quantile(tree.query(tree.data, k=2)[0][:, 1], _NEIGHBOURS)))
        self.known.append(attractor)
        self._trees.append(tree)
        self._reach.append(reach)
        return len(self.known) - 1
