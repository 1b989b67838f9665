"""Peaks and residuals of an isolated mass under a set of ground motions, as functions of its parameters."""

import itertools
from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from symfric.errors import SceneError
from symfric.model.arguments import is_one_of, items
from symfric.model.outputs import At, Output, OutputOfExpression
from symfric.model.scene import Scene
from symfric.model.symbols import Key, finite, name_of, nearest, shortened
from symfric.model.system import Signal
from symfric.solve.protocol import Program
from symfric.solve.routes import prepare

MEASURES = {
    "acceleration": "peak_acceleration",
    "velocity": "peak_velocity",
    "displacement": "peak_displacement",
    "residual": "residual",
}
_GRID = 400  # number of points of the grid over the bounds
_STEP = 1e-6  # finite-difference step where no derivative exists, or where it takes long


class Isolated:
    """Measures of an isolator as functions of a point in the unit cube of the bounds."""

    def __init__(
        self,
        scene: Scene,
        motions: Sequence[Any],
        bounds: Mapping[Key, tuple[float, float]],
        limits: dict[str, float],
        minimise: str,
        over: str,
    ):
        for name in (minimise, *limits):
            if not is_one_of(name, MEASURES):
                raise SceneError(f"no measure {shortened(name)}{nearest(str(name), MEASURES)}")
        if not is_one_of(over, ("worst", "mean")):
            raise SceneError(f"over is {shortened(over)}; give 'worst' or 'mean'")
        self.limits = {name: finite(v, f"the limit of {name}") for name, v in limits.items()}
        if any(v <= 0 for v in self.limits.values()):
            raise SceneError("limits must be positive")
        self.minimise, self.over = minimise, over
        self.names, self.low, self.high = _bounds(scene, bounds)
        self.measures = tuple(dict.fromkeys((minimise, *limits, "acceleration", "displacement")))
        count = len(scene.inputs)
        if count not in (1, 2):
            raise SceneError(f"the scene has {count} sampled inputs; an isolator has one or two, the ground's motion")
        self._outputs = {name: _outputs(scene, MEASURES[name]) for name in self.measures}
        self.scenes = _shaken(scene, motions, [name for names in self._outputs.values() for name in names])
        self._programs = [prepare(s, 1e-10) for s in self.scenes]
        self._sensitive: list[Program | None] = [None] * len(self.scenes)
        self._known: dict[bytes, np.ndarray] = {}
        self._slopes: dict[tuple[bytes, int], np.ndarray] = {}

    @property
    def per_axis(self) -> int:
        """Number of points of the grid along each parameter."""
        return max(2, round(_GRID ** (1 / len(self.names))))

    def grid(self) -> list[np.ndarray]:
        """Return the points of a regular grid in the unit cube."""
        return [np.array(p) for p in itertools.product(np.linspace(0, 1, self.per_axis), repeat=len(self.names))]

    def parameters(self, point: np.ndarray) -> dict[str, float]:
        """Return the parameters at a point."""
        numbers = self.low + np.clip(point, 0, 1) * (self.high - self.low)
        return dict(zip(self.names, numbers.tolist(), strict=True))

    def values(self, point: np.ndarray) -> np.ndarray:
        """Return the magnitude of every measure for every motion, shape (n_measures, n_motions)."""
        key = point.tobytes()
        if key not in self._known:
            rows = []
            for program in self._programs:
                run = program.run(self.parameters(point))
                rows.append([self.size(run, m) if run.status == 0 else np.inf for m in self.measures])
            self._known[key] = np.array(rows).T
        return self._known[key]

    def computed(self) -> list[tuple[np.ndarray, np.ndarray]]:
        """Return every point that was computed so far, and the values there; the point with the best ones first."""
        points = [(np.frombuffer(key), values) for key, values in self._known.items()]
        return sorted(points, key=lambda pair: (max(self.excess(pair[1]), 0.0), self.cost(pair[1])))

    def survey(self, points: Sequence[np.ndarray]) -> list[np.ndarray]:
        """Return what `values` returns for each of many points; those of one motion run all at once."""
        new = {p.tobytes(): p for p in points if p.tobytes() not in self._known}
        if new:
            given = [self.parameters(p) for p in new.values()]
            columns = {name: np.array([row[name] for row in given]) for name in self.names}
            responses = []
            for program in self._programs:
                batch = program.map(columns)
                rows = [self.size(batch, m) for m in self.measures]
                responses.append(np.where(batch.status == 0, rows, np.inf))
            self._known |= dict(zip(new, np.array(responses).transpose(2, 1, 0), strict=True))
        return [self._known[p.tobytes()] for p in points]

    def size(self, outputs: Any, measure: str) -> Any:
        """Return the magnitude of a measure of a run or of many: of a vector its length."""
        parts = [outputs[name] for name in self._outputs[measure]]
        return np.hypot(*parts) if len(parts) == 2 else np.abs(parts[0])

    def slopes(self, point: np.ndarray, motion: int) -> np.ndarray:
        """Return the derivatives of the measures for one motion in the unit cube, shape (n_measures, n_parameters)."""
        key = (point.tobytes(), motion)
        if key not in self._slopes:
            self._slopes[key] = self._slopes_at(point, motion)
        return self._slopes[key]

    def _slopes_at(self, point: np.ndarray, motion: int) -> np.ndarray:
        slopes = np.full((len(self.measures), len(self.names)), np.nan)
        if len(self.scenes[motion].inputs) == 1:  # exact ones of slips in the plane take longer than differences
            slopes = self._exact_slopes(point, motion)
        for k in np.flatnonzero(~np.all(np.isfinite(slopes), axis=0)):  # nor does one exist after grazing
            low, high = (np.clip(point + side * _STEP * np.eye(point.size)[k], 0.0, 1.0) for side in (-1, 1))
            slopes[:, k] = (self.values(high) - self.values(low))[:, motion] / (high - low)[k]
        return slopes

    def _exact_slopes(self, point: np.ndarray, motion: int) -> np.ndarray:
        program = self._sensitive[motion] or prepare(self.scenes[motion], 1e-10, sensitivities=self.names)
        self._sensitive[motion] = program
        run = program.run(self.parameters(point))
        rows = []
        for measure in self.measures:
            (name,) = self._outputs[measure]
            sign = 1.0 if run[name] >= 0 else -1.0
            rows.append([sign * run.output_sensitivities[name][n] for n in self.names])
        return np.array(rows) * (self.high - self.low)

    def cost(self, values: np.ndarray) -> float:
        """Return the objective."""
        row = values[self.measures.index(self.minimise)]
        return float(np.max(row) if self.over == "worst" else np.mean(row))

    def excess(self, values: np.ndarray) -> float:
        """Return the largest relative excess over a limit."""
        return max(
            (float(np.max(values[self.measures.index(n)]) / limit - 1.0) for n, limit in self.limits.items()),
            default=-1.0,
        )

    def missing(self, point: np.ndarray, values: np.ndarray) -> str:
        """Return a message: the limit that cannot be met, and by how much."""
        name = max(self.limits, key=lambda n: np.max(values[self.measures.index(n)]) / self.limits[n])
        reached = float(np.max(values[self.measures.index(name)]))
        where = ", ".join(f"{k} = {v:.6g}" for k, v in self.parameters(point).items())
        return (
            f"the limit on {name}, {self.limits[name]:g}, cannot be met within the bounds: the least found is "
            f"{reached:.6g}, {reached - self.limits[name]:.3g} too much, at {where}"
        )


def _bounds(scene: Scene, bounds: Mapping[Key, tuple[float, float]]) -> tuple[tuple[str, ...], np.ndarray, np.ndarray]:
    if not isinstance(bounds, Mapping) or not 1 <= len(bounds) <= 3:
        raise SceneError("give the bounds of one to three parameters, such as {'C': (lo, hi), 'mu': (lo, hi)}")
    names = tuple(scene.parameter(name_of(key)).name for key in bounds)
    ends = []
    for name, pair in zip(names, bounds.values(), strict=True):
        try:
            low, high = (finite(e, f"a bound of {name}") for e in pair)
        except (TypeError, ValueError):
            raise SceneError(f"the bounds of {name} are {pair!r}; give the lowest and the highest") from None
        if not 0 <= low < high:
            raise SceneError(f"the bounds of {name} are ({low:g}, {high:g}); give 0 <= low < high")
        ends.append((low, high))
    return names, *np.array(ends).T


def _outputs(scene: Scene, name: str) -> tuple[str, ...]:
    """Return the output of a measure, or the two components of it."""
    for names in ((name,), (f"{name}_x", f"{name}_y")):
        if all(isinstance(scene.outputs.get(n), OutputOfExpression) for n in names):
            return names
    raise SceneError(f"the scene has no output {name}; sf.scenes.rolling_isolator has it")


def _shaken(scene: Scene, motions: Sequence[Any], outputs: list[str]) -> list[Scene]:
    """Return the scenes with each of the motions, or pairs of them, and the outputs to measure."""
    motions = tuple(items(motions, "motions"))
    if not motions:
        raise SceneError("no motions; give at least one sf.motions.Motion or sf.Signal")
    measured, scenes = scene.wanting({name: scene.outputs[name] for name in outputs}), []
    before = max(signal.t_end for signal in scene.inputs.values())
    for motion in motions:
        signals = [_signal(part) for part in _parts(motion, len(scene.inputs))]
        end = max(signal.t_end for signal in signals)
        ends = {name: _moved(output, before, end) for name, output in measured.outputs.items()}
        inputs = dict(zip(scene.inputs, signals, strict=True))
        scenes.append(replace(measured, outputs=ends, inputs=inputs, horizon=end + (scene.horizon - before)))
    return scenes


def _parts(motion: Any, count: int) -> Sequence[Any]:
    """Return the motion along each direction."""
    if count == 1:
        return [motion]
    if not isinstance(motion, Sequence) or len(motion) != 2:
        raise SceneError(f"{shortened(motion)} is no pair; give two motions, along x and along y, for each record")
    return motion


def _signal(motion: Any) -> Signal:
    signal = motion if isinstance(motion, Signal) else getattr(motion, "signal", lambda: None)()
    if not isinstance(signal, Signal):
        raise SceneError(f"{shortened(motion)} is not a motion; give a sf.motions.Motion or a sf.Signal")
    return signal


def _moved(output: Output, before: float, end: float) -> Output:
    """Return an output that is taken at the end of the record `before`, taken at the end of another one."""
    return replace(output, time=end) if isinstance(output, At) and output.time == before else output
