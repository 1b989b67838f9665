"""Compiled loops over records, for runs and for many records."""

from dataclasses import replace

import numpy as np

from symfric.codegen.array_table import Table
from symfric.codegen.functions import compile_functions
from symfric.codegen.loop_loader import load_loop
from symfric.lower.sampled_oscillator import Record
from symfric.model.scene import Scene
from symfric.solve.exact.classify import recorded_in
from symfric.solve.exact.record.workspace import SHARED, make_arrays
from symfric.solve.loop.compiled_model import CompiledModel, path_rows
from symfric.solve.loop.run_arrays import limit
from symfric.solve.lowered import LoweredScene
from symfric.solve.observables import Observables


def record_model(
    scene: Scene, recorded: Record, observables: Observables, budgets: tuple[int, int], n_x: int
) -> CompiledModel:
    """Compile the loop over a record; budgets are numbers of steps and of events."""
    code = compile_functions([recorded.data])
    first = make_arrays(recorded, code.addresses["data"], [r.times for r in observables.rows])
    steps = path_rows(first) if observables.path else budgets[0]
    first.clock.t_end = scene.horizon
    limit(first.limits, (min(budgets[0], steps), budgets[1]), observables)
    loop = load_loop("symfric.solve.exact.record.entry", "the march through a sampled input")
    return CompiledModel(loop, code, first, SHARED, observables, n_x, scene.horizon)


class Marcher:
    """A scene compiled to run under many records and parameter values.

    Parameters
    ----------
    scene : Scene
        One that the march takes; its observables are answered in their order.
    """

    def __init__(self, scene: Scene) -> None:
        varied = frozenset(s.name for s in scene.values)
        lowered = LoweredScene(scene, varied)
        recorded = recorded_in(lowered)
        self.parameters = tuple(s.name for s in recorded.parameters)
        self.row = lowered.observables.row
        self._model = record_model(scene, recorded, lowered.observables, (100_000_000, 20_000_000), 2)
        self._start = np.array([float(scene.numbers()[s]) for s in scene.system.states])

    def under(self, samples: np.ndarray) -> "March":
        """Return the runner under another record, for one thread."""
        return March(self._model, self._start, samples)


class March:
    """Runner under one record, with its own memory; for one thread at a time."""

    def __init__(self, model: CompiledModel, start: np.ndarray, samples: np.ndarray) -> None:
        arrays = model.first.copy(SHARED - {"record", "times"})
        self._model, self._start = model, start
        self._room = replace(arrays, samples=np.array(samples, dtype=float))
        self._table = Table(self._room)
        self._valued = np.flatnonzero(np.diff(model.first.times.first))

    def run(self, p: np.ndarray, dt: float, horizon: float, times: dict[int, float]) -> tuple[int, np.ndarray]:
        """Run with parameters p in the order of `Marcher.parameters`, and values of rows at these times.

        Returns
        -------
        status : int
        found : ndarray, shape (rows, 3)
            Smallest and largest value of each observable; of a sampled one, its value in all columns.
        """
        room = self._room
        room.record.dt, room.clock.t_end = dt, horizon
        for row, time in times.items():
            room.times.due[room.times.first[row]] = time
        room.given_y[:], room.given_p[:] = self._start, p
        status = self._model.loop.launch(self._table, True)
        answers = room.observed.total[:, :3].copy()
        answers[self._valued] = room.observed.seen[:, None]
        return status, answers
