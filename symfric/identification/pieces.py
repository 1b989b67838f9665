"""Records cut into pieces of time, each with a run of its own from start values that are unknown too."""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any, NamedTuple

import numpy as np
import sympy as sp

from symfric.errors import SceneError
from symfric.identification.prediction import Predictor
from symfric.identification.records import Channel
from symfric.identification.unknowns import OFFSET, SCALE, VALUE
from symfric.locks import SYMBOLIC, alone
from symfric.model.outputs import Samples
from symfric.model.scene import Scene
from symfric.model.symbols import TIME
from symfric.solve.batch import reached
from symfric.solve.routes import prepare
from symfric.solve.run import Run

LATER = sp.Symbol("start of the piece", real=True)  # time at which a piece begins, in scenes that depend on time
SAME = 1e-9  # times of samples in different pieces that count as the same, relative to the length of a piece


class Linearised(NamedTuple):
    """Predictions and gaps at one point, with their derivatives by values and nodes.

    Attributes
    ----------
    y : ndarray, shape (n,)
    by_values, by_nodes : ndarray, shape (n, n_p) and (n, n_n)
    gaps : ndarray, shape (n_n,)
        State at the end of each piece less the start of the next one.
    gaps_by_values, gaps_by_nodes : ndarray, shape (n_n, n_p) and (n_n, n_n)
    """

    y: np.ndarray
    by_values: np.ndarray
    by_nodes: np.ndarray
    gaps: np.ndarray
    gaps_by_values: np.ndarray
    gaps_by_nodes: np.ndarray


@dataclass(frozen=True, eq=False)
class Pieces:
    """The scenes of a fit, each cut into equally long pieces.

    Attributes
    ----------
    predictor : Predictor
    count : int
        Pieces of each scene.
    """

    predictor: Predictor
    count: int

    @cached_property
    def states(self) -> dict[str, tuple[str, ...]]:
        """Names of the states of each scene with records."""
        return {n: tuple(s.name for s in self.predictor.scenes[n].system.states) for n in self.predictor.labels}

    @cached_property
    def places(self) -> dict[str, int]:
        """Index of the first node of each scene among all numbers of the nodes."""
        places, place = {}, 0
        for label, names in self.states.items():
            places[label] = place
            place += (self.count - 1) * len(names)
        return places

    @property
    def size(self) -> int:
        """Numbers of all nodes."""
        return sum((self.count - 1) * len(names) for names in self.states.values())

    @cached_property
    def lengths(self) -> dict[str, float]:
        """Length of a piece of each scene."""
        ends = {n: max(float(c.t[-1]) for c in self._channels(n)) for n in self.predictor.labels}
        return {n: end / self.count for n, end in ends.items()}

    def _channels(self, label: str) -> list[Channel]:
        return [c for c in self.predictor.channels if c.scene == label]

    @cached_property
    def _samples(self) -> dict[str, tuple[np.ndarray, np.ndarray]]:
        """Of each channel the piece of every sample, and its time since the start of the piece."""
        samples = {}
        for c in self.predictor.channels:
            length = self.lengths[c.scene]
            piece = np.minimum((c.t / length * (1 - 1e-12)).astype(int), self.count - 1)
            samples[c.key] = piece, np.clip(c.t - piece * length, 0.0, length)
        return samples

    @cached_property
    def _times(self) -> dict[str, np.ndarray]:
        """Times since the start of a piece at which each scene's sensors are read in some piece."""
        times_of = {}
        for label in self.predictor.labels:
            times = np.sort(np.concatenate([self._samples[c.key][1] for c in self._channels(label)]))
            apart = np.concatenate([[True], np.diff(times) > SAME * self.lengths[label]])
            times_of[label] = times[apart]
        return times_of

    @cached_property
    def _programs(self) -> dict[Any, Any]:
        """Programs of one piece, with derivatives by the values and by the start."""
        return {label: self._program(label) for label in self.predictor.labels}

    @alone(SYMBOLIC)
    def _program(self, label: str) -> Any:
        scene = self.predictor.scene_of(label)
        if scene.clocks:
            raise SceneError("segments is for scenes without held variables and resets")
        if scene.inputs:
            raise SceneError("segments is for scenes without sampled inputs; fit shorter parts of the record instead")
        scene = _later(scene)
        times = self._times[label].tolist()
        outputs = {c.name: Samples(_shift(c.expr), times) for c in self._channels(label)}
        names = self.predictor.names(label, VALUE)
        scene = scene.until(self.lengths[label], outputs)
        return prepare(scene, self.predictor.tolerance, sensitivities=[*names, *self.states[label]])

    def first_nodes(self, values: np.ndarray) -> np.ndarray:
        """Return start values of the pieces from the records, and from a run where no record shows a state."""
        nodes = np.zeros(self.size)
        for label, names in self.states.items():
            times = self.lengths[label] * np.arange(1, self.count)
            run = self._whole_run(label, values)
            rows = np.array([self._guess(label, name, times, run) for name in names])
            begin = self.places[label]
            nodes[begin : begin + rows.size] = rows.T.ravel()
        return nodes

    def _whole_run(self, label: str, values: np.ndarray) -> Run:
        scene = self.predictor.scene_of(label, values)
        times = (self.lengths[label] * np.arange(1, self.count)).tolist()
        return prepare(scene.wanting({s.name: Samples(s, times) for s in scene.system.states}), 1e-6).run()

    def _guess(self, label: str, name: str, times: np.ndarray, run: Run) -> np.ndarray:
        """Return the values of a state at the nodes."""
        system = self.predictor.scenes[label].system
        rates = dict(zip((u.name for u in system.u), (q.name for q in system.q), strict=True))
        for channel in self._channels(label):
            if channel.expr.is_Symbol and channel.expr.name in (name, rates.get(name)):
                return _smoothed(channel.t, channel.y, times, rate=channel.expr.name != name)
        return np.asarray(np.nan_to_num(run[name]))

    def linearised(self, values: np.ndarray, nodes: np.ndarray) -> Linearised | None:
        """Return predictions and gaps at a point, None if a run fails."""
        predictor, n_p = self.predictor, self.predictor.unknowns.size
        y, by_values, by_nodes = (
            np.zeros(predictor.size),
            np.zeros((predictor.size, n_p)),
            np.zeros((predictor.size, self.size)),
        )
        gaps, gaps_by_values = np.zeros(self.size), np.zeros((self.size, n_p))
        gaps_by_nodes = np.zeros((self.size, self.size))
        sensors = predictor.sensors(values)
        for label, names in self.states.items():
            n_x = len(names)
            for piece in range(self.count):
                run = self._run(label, piece, values, nodes)
                if run is None:
                    return None
                own = self.places[label] + (piece - 1) * n_x  # start of this piece among the nodes
                if piece < self.count - 1:
                    end = slice(own + n_x, own + 2 * n_x)
                    gaps[end] = run.final - nodes[end]
                    gaps_by_nodes[end, end] -= np.eye(n_x)
                    self._spread(gaps_by_values[end], gaps_by_nodes[end], label, piece, own, run.sensitivities)
                for k, (channel, rows) in enumerate(zip(predictor.channels, predictor.rows, strict=True)):
                    if channel.scene == label:
                        self._fill(y, by_values, by_nodes, run, channel, rows, piece, own, sensors[k])
        return Linearised(y, by_values, by_nodes, gaps, gaps_by_values, gaps_by_nodes)

    def _run(self, label: str, piece: int, values: np.ndarray, nodes: np.ndarray) -> Run | None:
        program, names = self._programs[label], self.states[label]
        changes, starts = ({n: float(v) for n, v in part.items()} for part in self.predictor.changes(label, values))
        if LATER in program.scene.values:
            changes[LATER.name] = piece * self.lengths[label]
        if piece:
            begin = self.places[label] + (piece - 1) * len(names)
            starts = dict(zip(names, nodes[begin : begin + len(names)].tolist(), strict=True))
        try:
            run = program.run(changes, starts)
        except SceneError:
            return None
        return run if reached(np.array(run.status)) else None

    def _spread(
        self,
        by_values: np.ndarray,
        by_nodes: np.ndarray,
        label: str,
        piece: int,
        own: int,
        slopes: Mapping[str, np.ndarray],
    ) -> None:
        """Add derivatives of one piece by values and starts to the columns of what they depend on."""
        for k, target in self.predictor.own(label):
            if target.kind == VALUE or piece == 0:
                by_values[:, k] += np.nan_to_num(slopes[target.name])
        if piece:
            for j, name in enumerate(self.states[label]):
                by_nodes[:, own + j] += np.nan_to_num(slopes[name])

    def _fill(
        self,
        y: np.ndarray,
        by_values: np.ndarray,
        by_nodes: np.ndarray,
        run: Run,
        channel: Channel,
        rows: slice,
        piece: int,
        own: int,
        sensor: Any,
    ) -> None:
        """Write predictions of one piece and their derivatives."""
        of, at = self._samples[channel.key]
        here = np.flatnonzero(of == piece)
        place = np.clip(
            np.searchsorted(self._times[channel.scene], at[here] - SAME * self.lengths[channel.scene]), 0, None
        )
        scale, offset = (float(v) for v in sensor)
        index = np.arange(rows.start, rows.stop)[here]
        seen = run[channel.name][place]
        y[index] = scale * seen + offset
        derivatives: dict[Any, Any] = run.output_sensitivities[channel.name]
        slopes = {n: scale * v[place] for n, v in derivatives.items()}
        part_values, part_nodes = np.zeros((here.size, by_values.shape[1])), np.zeros((here.size, by_nodes.shape[1]))
        self._spread(part_values, part_nodes, channel.scene, piece, own, slopes)
        for k, targets in enumerate(self.predictor.unknowns.targets):
            for target in targets:
                if target.label == channel.key and target.kind in (SCALE, OFFSET):
                    part_values[:, k] += seen if target.kind == SCALE else 1.0
        by_values[index], by_nodes[index] = part_values, part_nodes


def _smoothed(t: np.ndarray, y: np.ndarray, times: np.ndarray, rate: bool) -> np.ndarray:
    """Return values, or rates, of a record at some times by cubics through the nearest samples."""
    count = min(t.size, 9)
    fitted = []
    for time in times:
        begin = int(np.clip(np.searchsorted(t, time) - count // 2, 0, t.size - count))
        near = slice(begin, begin + count)
        width = t[near][-1] - t[near][0]
        cubic = np.polynomial.Polynomial.fit((t[near] - time) / width, y[near], min(3, count - 1)).convert().coef
        fitted.append(cubic[1] / width if rate else cubic[0])
    return np.array(fitted)


def _shift(e: sp.Expr) -> sp.Expr:
    return e.xreplace({TIME: TIME + LATER})


def _later(scene: Scene) -> Scene:
    """Return a scene in which time begins at `LATER`, if it depends on time."""
    system = scene.system
    if not any(TIME in e.free_symbols for e in (*system.expressions, *scene.contacts)):
        return scene
    if system.linear is not None:
        raise SceneError("segments is for scenes of matrices only if they do not depend on time")
    own = len(system.z) - system.made
    moved = replace(
        system,
        mass=_shift(system.mass),
        force=tuple(map(_shift, system.force)),
        z=system.z[:own],
        z_rate=tuple(map(_shift, system.z_rate[:own])),
        made=0,
    )
    contacts = tuple(replace(c.rewritten(_shift), law=c.law.where({TIME: TIME + LATER})) for c in scene.contacts)
    return replace(scene, system=moved, contacts=contacts, values={**scene.values, LATER: 0.0})
