"""Predictions of the records by the scenes, with derivatives by the unknowns."""

import math
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import Any, NamedTuple, Protocol

import numpy as np

from symfric.errors import SceneError
from symfric.identification.records import Channel, places
from symfric.identification.unknowns import OFFSET, SCALE, START, VALUE, Unknowns
from symfric.model.outputs import Events, Samples
from symfric.model.scene import Scene
from symfric.solve.batch import reached
from symfric.solve.routes import prepare
from symfric.solve.run import Run
from symfric.solve.status import Status

SECANT = 1e-5  # half width of a difference where no derivative exists, in units of the range between the bounds
TRIALS = 64  # values tried for a scene that has none of its own


class Prediction(NamedTuple):
    """Predictions at one set of values.

    Attributes
    ----------
    y : ndarray, shape (n,)
        Of all channels, one behind the other; NaN where a run failed.
    slopes : ndarray, shape (n, n_p)
        Derivatives by the values.
    sequence : tuple
        The events of all scenes in their order: contact, mode before, mode after.
    secants : int
        How many entries of `slopes` are differences, because no derivative exists there.
    """

    y: np.ndarray
    slopes: np.ndarray
    sequence: tuple[Any, ...]
    secants: int


class PredictionModel(Protocol):
    """Interface of the models that can be fitted: scenes with records (`Predictor`), or a formula with points."""

    @property
    def channels(self) -> tuple[Channel, ...]:
        """Measured channels."""

    @property
    def unknowns(self) -> Unknowns:
        """Unknowns of the fit."""

    @property
    def rows(self) -> tuple[slice, ...]:
        """Place of each channel in the predictions."""

    @property
    def size(self) -> int:
        """Number of samples."""

    def at(self, values: np.ndarray, differences: bool = True) -> Prediction:
        """Return the predictions for one set of values with their derivatives."""

    def many(self, values: np.ndarray) -> np.ndarray:
        """Return the predictions for many sets of values, shape (n, n_p) to (samples, n)."""

    def scenes_at(self, values: np.ndarray) -> dict[str, Scene]:
        """Return the scenes with the values of a fit, by label."""


@dataclass(frozen=True, eq=False)
class Predictor:
    """The scenes of a fit with the outputs that the records measure, compiled at first use.

    Attributes
    ----------
    scenes : mapping of str to Scene
    channels : tuple of Channel
    unknowns : Unknowns
    tolerance : float
    threads : int
        For runs without derivatives.
    """

    scenes: Mapping[str, Scene]
    channels: tuple[Channel, ...]
    unknowns: Unknowns
    tolerance: float
    threads: int = 1

    @cached_property
    def rows(self) -> tuple[slice, ...]:
        """Place of each channel in the predictions."""
        return places(self.channels)

    @property
    def size(self) -> int:
        """Number of samples."""
        return int(self.rows[-1].stop)

    @cached_property
    def labels(self) -> tuple[str, ...]:
        """Labels of the scenes that have records."""
        return tuple(dict.fromkeys(c.scene for c in self.channels))

    def scene_of(self, label: str, values: np.ndarray | None = None) -> Scene:
        """Return a scene until its last sample, with the outputs that its records measure and the values of a fit."""
        own = [c for c in self.channels if c.scene == label]
        outputs = {c.name: Samples(c.expr, c.t.tolist()) for c in own}
        scene = self.scenes[label].until(max(float(c.t[-1]) for c in own), outputs)
        if values is not None:
            return self.filled(scene, label, values)
        if all(scene.values[scene.parameter(n)] is not None for n in self.names(label, VALUE)):
            return self.filled(scene, label, self.unknowns.outer(np.full(self.unknowns.size, 0.5)), starts_only=True)
        from scipy.stats import qmc  # slow to import

        refusal = None
        for point in qmc.Sobol(self.unknowns.size, seed=0).random(TRIALS):  # the first that the scene accepts
            try:
                return self.filled(scene, label, self.unknowns.outer(point))
            except SceneError as error:
                refusal = error
        raise SceneError(f"the scene refuses every value tried between the bounds: {refusal}")

    def filled(self, scene: Scene, label: str, values: np.ndarray, starts_only: bool = False) -> Scene:
        """Return a scene with the values and starts of a fit."""
        changes, starts = ({n: float(v) for n, v in part.items()} for part in self.changes(label, values))
        scene = scene.where(changes) if changes and not starts_only else scene
        return scene.starting(starts) if starts else scene

    def scenes_at(self, values: np.ndarray) -> dict[str, Scene]:
        """Return the scenes of the user with the values of a fit."""
        return {label: self.filled(scene, label, values) for label, scene in self.scenes.items()}

    @cached_property
    def _plain(self) -> dict[Any, Any]:
        return {label: prepare(self.scene_of(label), self.tolerance) for label in self.labels}

    @cached_property
    def _sensitive(self) -> dict[Any, Any]:
        """Programs with derivatives; None for a scene that has no unknowns but those of its sensors."""
        programs = {}
        for label in self.labels:
            names = [target.name for _, target in self.own(label)]
            scene = self.scene_of(label)
            scene = scene.wanting({**scene.outputs, "events of the run": Events()})
            programs[label] = (
                prepare(scene, self.tolerance, sensitivities=names) if names else prepare(scene, self.tolerance)
            )
        return programs

    def own(self, label: str) -> list[Any]:
        """Return index and target of the unknowns that set something of a scene itself."""
        return [
            (k, target)
            for k, targets in enumerate(self.unknowns.targets)
            for target in targets
            if target.label == label and target.kind in (VALUE, START)
        ]

    def names(self, label: str, kind: str) -> list[str]:
        """Return the names of the values, or the starts, of a scene that are fitted."""
        return [target.name for _, target in self.own(label) if target.kind == kind]

    def changes(self, label: str, values: np.ndarray) -> tuple[dict[Any, Any], dict[Any, Any]]:
        """Return the values and the starts of a scene, for one (n_p,) or many sets of values (n, n_p)."""
        changes: tuple[dict[Any, Any], dict[Any, Any]] = {}, {}
        for k, target in self.own(label):
            changes[target.kind == START][target.name] = values[..., k]
        return changes

    def sensors(self, values: np.ndarray) -> list[tuple[np.ndarray, np.ndarray]]:
        """Return scale and offset of every channel, for one or many sets of values."""
        gains = []
        for channel in self.channels:
            numbers = {SCALE: np.ones(values.shape[:-1]), OFFSET: np.zeros(values.shape[:-1])}
            for k, targets in enumerate(self.unknowns.targets):
                for target in targets:
                    if target.label == channel.key and target.kind in numbers:
                        numbers[target.kind] = values[..., k]
            gains.append((numbers[SCALE], numbers[OFFSET]))
        return gains

    def many(self, values: np.ndarray) -> np.ndarray:
        """Return the predictions for many sets of values, shape (n, n_p) to (samples, n); NaN where a run failed."""
        predicted = np.full((self.size, len(values)), np.nan)
        sensors = self.sensors(values)
        for label, program in self._plain.items():
            changes, starts = self.changes(label, values)
            batch = program.map(changes, starts, self.threads) if changes or starts else program.map()
            for channel, rows, (scale, offset) in zip(self.channels, self.rows, sensors, strict=True):
                if channel.scene == label:
                    predicted[rows] = scale * np.where(reached(batch.status), batch[channel.name], np.nan) + offset
        return predicted

    def at(
        self, values: np.ndarray, differences: bool = True, settings: Mapping[str, float] | None = None
    ) -> Prediction:
        """Return the predictions for one set of values with their derivatives.

        Parameters
        ----------
        values : ndarray, shape (n_p,)
        differences : bool
            Whether derivatives that do not exist are replaced by differences.
        settings : mapping of str to float, optional
            Other values of the scenes, which are not fitted; differences do not regard them.
        """
        y, slopes = np.full(self.size, np.nan), np.zeros((self.size, self.unknowns.size))
        sequence: list[Any] = []
        sensors = self.sensors(values)
        for label in self.labels:
            run = self._run(label, values, settings or {})
            sequence.append(() if run is None else _sequence(run))
            if run is None:
                continue
            for channel, rows, (scale, offset) in zip(self.channels, self.rows, sensors, strict=True):
                if channel.scene == label:
                    sensed = run[channel.name]
                    y[rows] = scale * sensed + offset
                    self._fill(slopes, rows, channel, run, float(scale), sensed)
        if differences and np.any(np.isnan(y)):
            self._without_derivatives(values, y, slopes)
        void = ~np.isfinite(slopes) & np.isfinite(y)[:, None]
        if differences and np.any(void):
            slopes = np.where(void, self._differences(values, np.flatnonzero(np.any(void, axis=0))), slopes)
        return Prediction(y, slopes, tuple(sequence), int(np.count_nonzero(void)))

    def _without_derivatives(self, values: np.ndarray, y: np.ndarray, slopes: np.ndarray) -> None:
        """Write predictions of runs that succeed only without derivatives, as with a law of infinite slope at rest."""
        missing = np.isnan(y)
        y[missing] = self.many(values[None])[missing, 0]
        slopes[missing & np.isfinite(y)] = math.nan

    def _run(self, label: str, values: np.ndarray, settings: Mapping[str, float]) -> Run | None:
        """Return the run of a scene with derivatives, None if it failed."""
        changes, starts = ({n: float(v) for n, v in part.items()} for part in self.changes(label, values))
        try:
            run = self._sensitive[label].run({**changes, **settings}, starts)
        except SceneError:  # values that the scene refuses
            return None
        return run if run.status in (Status.OK, Status.NO_DERIVATIVE) else None

    def _fill(
        self, slopes: np.ndarray, rows: slice, channel: Channel, run: Run, scale: float, sensed: np.ndarray
    ) -> None:
        """Write the derivatives of one channel."""
        for k, targets in enumerate(self.unknowns.targets):
            for target in targets:
                if target.label == channel.scene and target.kind in (VALUE, START):
                    slopes[rows, k] += scale * run.output_sensitivities[channel.name][target.name]
                elif target.label == channel.key and target.kind == SCALE:
                    slopes[rows, k] += sensed
                elif target.label == channel.key and target.kind == OFFSET:
                    slopes[rows, k] += 1.0

    def _differences(self, values: np.ndarray, columns: np.ndarray) -> np.ndarray:
        """Return differences of the predictions across some of the values, one-sided at a bound."""
        low, high = self.unknowns.low, self.unknowns.high
        step = SECANT * (high - low)
        points = []
        for k in columns:
            for way in (1.0, -1.0):
                points.append(values.copy())
                points[-1][k] = np.clip(values[k] + way * step[k], low[k], high[k])
        predicted, slopes = self.many(np.array(points)), np.full((self.size, self.unknowns.size), math.nan)
        for j, k in enumerate(columns):
            slopes[:, k] = (predicted[:, 2 * j] - predicted[:, 2 * j + 1]) / (points[2 * j][k] - points[2 * j + 1][k])
        return slopes


def _sequence(run: Run) -> tuple[Any, ...]:
    """Return the events of a run in their order: contact, mode before, mode after."""
    return () if run.raw.events is None else tuple(map(tuple, run.raw.events[1].tolist()))
