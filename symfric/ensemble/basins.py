"""Basins of attraction: the attractor of every start of a grid."""

from collections.abc import Callable, Mapping
from concurrent.futures import Executor
from dataclasses import dataclass, field, replace
from pathlib import Path

import numpy as np
import sympy as sp

from symfric.axes import Axes
from symfric.ensemble.attractors import Attractor, Collection
from symfric.ensemble.cases import Listed
from symfric.ensemble.progress import Progress
from symfric.ensemble.sampling import row_of
from symfric.ensemble.sweep import sweep
from symfric.ensemble.worker import CODES
from symfric.errors import SceneError
from symfric.long_calls import logged, tell, until_interrupted
from symfric.model.excitation import forcing_period
from symfric.model.outputs import End, StopTime
from symfric.model.results import ArrayResult, Drawable, Labelled, as_plain
from symfric.model.scene import Scene, check_scene
from symfric.model.symbols import Key, finite, name_of, nearest, shortened
from symfric.model.units import attributes_of
from symfric.orbits.sizes import over_time
from symfric.solve.case_values import NOT_COMPUTED

_MOST = 20  # most attractors; starts that end in others are not labelled
_TURNS = 8  # most horizons that motions slow to settle are followed together


@dataclass(frozen=True, eq=False)
class Basins(ArrayResult, Drawable):
    """Basins of attraction on a grid of starts.

    `plot` draws the basins over one or two axes in colours.

    Attributes
    ----------
    axes : dict of str to ndarray
        States and their initial values.
    label : ndarray of int, shape of the grid
        Index of the attractor; -1 where the run failed, or beyond the 20th attractor.
    status : ndarray of int, shape of the grid
        Codes of `Status`; -1 if the start is not valid, -2 for an error, -3 for one of no attractor as yet, see
        `symfric.keep_when_interrupted`.
    attractors : tuple of Attractor
        In the order in which the grid meets them.

    Examples
    --------
    >>> import symfric as sf
    >>> bistable = sf.scenes.mass_on_belt(sf.laws.exponential(0.4), v_b=1.6).until(400)
    >>> found = sf.basins(bistable, {"x": [0.5, 3.0]})
    >>> found.shares.round(6)
    array([0.5, 0.5])
    >>> sorted(found.to_dict())[:2]
    ['attractors', 'axes']
    >>> len(found.to_xarray().data_vars) > 0
    True
    >>> ax = found.plot()
    """

    axes: dict[str, np.ndarray]
    label: np.ndarray
    status: np.ndarray
    attractors: tuple[Attractor, ...] = field(metadata=as_plain(lambda attractors, _: [repr(a) for a in attractors]))
    units: Mapping[str, str] = field(default_factory=dict, repr=False)
    _told = ("axes", "label", "status", "attractors", "shares")

    def _labelled(self) -> Labelled:
        about = {f"attractor_{k}": repr(a) for k, a in enumerate(self.attractors)}
        codes = np.array(sorted(CODES), dtype=np.int32)
        meaning = {"flag_values": codes, "flag_meanings": " ".join(CODES[int(c)] for c in codes)}
        names = list(self.axes)
        axes = {n: (n, row, attributes_of(n, self.units)) for n, row in self.axes.items()}
        return {"attractor": (names, self.label, about), "status": (names, self.status, meaning)}, axes, {}

    @property
    def shares(self) -> np.ndarray:
        """Fraction of the starts that end in each attractor, shape (number of attractors,)."""
        return np.array([np.mean(self.label == k) for k in range(len(self.attractors))])

    def _draw(self, ax: Axes | None) -> Axes:
        if len(self.axes) > 2:
            raise SceneError(f"the grid has {len(self.axes)} axes; draw a slice of to_xarray().attractor")
        from symfric.ensemble.plotting import plot_basins

        return plot_basins(self, ax)

    def __repr__(self) -> str:
        parts = ", ".join(f"{s:.1%} {a!r}" for s, a in zip(self.shares, self.attractors, strict=True))
        lost = np.mean(self.label < 0)
        return f"Basins({' x '.join(map(str, self.label.shape))} starts: {parts}{f', {lost:.1%} none' if lost else ''})"


@logged
def basins(
    scene: Scene,
    starts: Mapping[Key, np.ndarray],
    *,
    near: float = 0.01,
    jobs: int = 1,
    executor: Executor | None = None,
    progress: bool | Callable[[Progress], None] = False,
    store: str | Path | None = None,
    tolerance: float = 1e-9,
) -> Basins:
    """Find the attractor of every start of a grid: rest, an equilibrium, a cycle, or an irregular motion.

    Parameters
    ----------
    scene : Scene
        Autonomous, or excited by sines and cosines of time with a common period. Its horizon is the time after which a
        motion is looked at; one that is not near anything known by then is followed for eight more. States that are not
        in `starts` start as in the scene.
    starts : mapping of state to values
    near : float
        Distance, as a part of the range of each state over all starts and ends, below which two motions count as one
        and a vibration as an equilibrium.
    jobs, executor, progress, store
        Of the runs up to the horizon; see `symfric.ensemble.sweep.sweep`.
    tolerance : float
        Of the runs.

    Returns
    -------
    Basins

    Raises
    ------
    SceneError
        If a start is no state or its values are no numbers, or the excitation has no period.

    Notes
    -----
    A start belongs to the attractor that its state at the horizon is near to. Where there is none yet, the motion is
    followed, and Newton's method on the map over a period finds the cycle it approaches; only stable ones count. What
    neither rests nor comes near a stable cycle of at most 16 periods is irregular, and so is what takes longer to
    settle; then lengthen the horizon.

    Examples
    --------
    >>> import symfric as sf
    >>> bistable = sf.scenes.mass_on_belt(sf.laws.exponential(0.4), v_b=1.6).until(400)
    >>> found = sf.basins(bistable, {"x": [0.5, 3.0]})
    >>> [a.kind for a in found.attractors]
    ['equilibrium', 'cycle']
    """
    check_scene(scene)
    near = finite(near, "near")
    if not 0 < near < 1:
        raise SceneError(f"near is {near:g}; give a fraction of the range of the states, between 0 and 1")
    axes = _axes(scene, starts)
    period = forcing_period(scene)
    if period:
        scene = scene.until(period * max(1, np.ceil(scene.horizon / period - 1e-9)), {})
    moved, grid = _with_starts(scene, axes)
    runs = sweep(moved, grid, jobs=jobs, executor=executor, progress=progress, store=store, tolerance=tolerance)
    ends = runs["end"].values.reshape(-1, len(scene.system.states)).T
    shape = runs["status"].shape
    status, stops = runs["status"].values.ravel().copy(), runs["stop"].values.ravel()
    spread = _units(scene, axes, ends[:, status == 0])
    collection = Collection(scene, period, spread, near, tolerance)
    further = Listed(scene.wanting({"end": End(), "stop": StopTime()}), tolerance=tolerance)
    label = _labelled(collection, lambda y: further.run({}, y, jobs), ends.copy(), stops, status)
    used = [k for k in range(len(collection.known)) if np.any(label == k)]
    place = np.full(len(collection.known) + 1, -1)  # the last entry is for starts without an attractor
    place[used] = np.arange(len(used))
    attractors = tuple(collection.known[k] for k in used)
    return Basins(axes, place[label].reshape(shape), status.reshape(shape), attractors, scene.units)


def _axes(scene: Scene, starts: Mapping[Key, np.ndarray]) -> dict[str, np.ndarray]:
    """Return the names of the states and their initial values."""
    if not isinstance(starts, Mapping) or not starts:
        raise SceneError(f"starts is {shortened(starts)}; give a mapping of states to sequences of values")
    states = [s.name for s in scene.system.states]
    axes = {name_of(k): v for k, v in starts.items()}
    for name in axes:
        if name not in states:
            raise SceneError(f"{name} in starts is no state{nearest(name, states)}")
    return {name: row_of(v, f"the start of {name}") for name, v in axes.items()}


def _with_starts(scene: Scene, axes: Mapping[str, np.ndarray]) -> tuple[Scene, dict[str, np.ndarray]]:
    """Return the scene with initial values as parameters, and the grid of these parameters."""
    symbols = {n: sp.Symbol(f"{n}(0)", real=True) for n in axes}
    scene = scene.wanting({"end": End(), "stop": StopTime()}).starting({n: row[0] for n, row in axes.items()})
    initial = {s.name: symbols.get(s.name, v) for s, v in scene.initial.items()}
    # not zero, since zeros are built into the equations; a start that may be, where gaps must not be negative
    begins = {symbols[n]: float(next((v for v in row if v), 1.0)) for n, row in axes.items()}
    values = {**scene.values, **begins}
    return replace(scene, initial=initial, values=values), {symbols[n].name: row for n, row in axes.items()}


def _units(scene: Scene, axes: Mapping[str, np.ndarray], ends: np.ndarray) -> np.ndarray:
    """Return the range of every state over all starts and ends; of a velocity, at least range over horizon."""
    numbers = scene.numbers()
    rows = [np.append(axes.get(s.name, [numbers[s]]), end) for s, end in zip(scene.system.states, ends, strict=True)]
    size = np.array([np.ptp(row) for row in rows])
    return over_time(size, len(scene.system.q), scene.horizon)


Follow = Callable[[np.ndarray], tuple[np.ndarray, dict[str, np.ndarray]]]  # states (n_x, n) one horizon further


def _labelled(
    collection: Collection, follow: Follow, ends: np.ndarray, stops: np.ndarray, status: np.ndarray
) -> np.ndarray:
    """Return the attractor index of every end (n_x, n), -1 if it has none; later failures are entered in `status`.

    One open end after the other is followed until its attractor is known. If that is one of those known before, the
    others are slow to come near it, and all of them are run for another horizon at once.
    """
    label = np.full(status.size, -1)
    resting = (status == 0) & np.isfinite(stops)
    if np.any(resting):
        label[resting] = collection.rest()
    with until_interrupted("basins"):
        _settle(collection, follow, ends, label, status, np.flatnonzero((status == 0) & ~resting))
    return label


def _settle(
    collection: Collection,
    follow: Follow,
    ends: np.ndarray,
    label: np.ndarray,
    status: np.ndarray,
    open_: np.ndarray,
) -> None:
    """Enter the attractors of the open ends one after the other.

    What is left when an interrupt ends this has the status `NOT_COMPUTED`.
    """
    turns = 0
    try:
        while open_.size and len(collection.known) < _MOST:
            tell(f"{len(collection.known)} attractors", 1.0 - open_.size / status.size)
            known = len(collection.known)
            first = open_[0]
            label[first], status[first] = collection.settle(ends[:, first])
            open_ = open_[1:]
            if len(collection.known) == known:
                if turns == _TURNS or not open_.size:
                    continue
                turns += 1
                status[open_], followed = follow(ends[:, open_])
                ends[:, open_] = followed["end"]
                rests = (status[open_] == 0) & np.isfinite(followed["stop"])
                if np.any(rests):
                    label[open_[rests]] = collection.rest()
                open_ = open_[(status[open_] == 0) & ~rests]
            label[open_] = collection.nearest(ends[:, open_])
            open_ = open_[label[open_] < 0]
    except KeyboardInterrupt:
        status[open_[label[open_] < 0]] = NOT_COMPUTED
        raise
