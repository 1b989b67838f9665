"""The march through a record as a loop of the package."""

import math
from collections.abc import Callable

import numpy as np

from symfric.model.scene import Scene
from symfric.solve.compiled import PATH_BYTES, Loop
from symfric.solve.door import open_door
from symfric.solve.exact.record_room import make_record_room
from symfric.solve.exact.record_rows import Recorded, recorded_in
from symfric.solve.exact.room import FOLDERS
from symfric.solve.memory import Table
from symfric.solve.taylor.jit import MachineCode, compile_functions
from symfric.solve.taylor.workspace import T_END
from symfric.solve.wanted import THEN


def _march() -> Callable[[Table, bool], int]:
    return open_door("symfric.solve.exact.record_loop", "the march through a sampled input", *FOLDERS)


def record_loop(scene: Scene, recorded: Recorded, budgets: tuple[int, int]) -> tuple[MachineCode, Loop]:
    """Compile what the march needs; budgets are those of steps and of events."""
    code = compile_functions([recorded.problem.data])
    wanted = recorded.wanted
    times = [r.time if r.kind == THEN else -math.inf for r in wanted.rows]
    room = make_record_room(recorded.problem, code.addresses["data"], times)
    steps = PATH_BYTES // room.path_c[0].nbytes if wanted.path else budgets[0]
    room.clock[T_END] = scene.horizon
    room.limits[:5] = min(budgets[0], steps), budgets[1], 1_000_000, wanted.path, wanted.events
    return code, Loop(_march(), room, wanted, scene.horizon)


class Marcher:
    """A scene under a record, for many records and values: all parameters may change, and what is wanted is a row.

    Not to be shared between threads; `copy` shares the machine code.

    Parameters
    ----------
    scene : Scene
        One that the march takes; its wanted rows are answered in their order.
    """

    def __init__(self, scene: Scene):
        varied = frozenset(s.name for s in scene.values)
        recorded = recorded_in(scene, varied)
        self.parameters = tuple(s.name for s in recorded.problem.parameters)
        self.row = recorded.wanted.row
        self._recorded = recorded
        self._march = _march()
        self._code, loop = record_loop(scene, recorded, (100_000_000, 20_000_000))
        self._room = loop.work
        self._start = np.array([float(scene.numbers()[s]) for s in scene.system.states])

    def copy(self) -> "Marcher":
        """Return one for another thread."""
        other = object.__new__(Marcher)
        other.__dict__.update(self.__dict__, _room=type(self._room)(*(a.copy() for a in self._room)))
        return other

    def load(self, samples: np.ndarray) -> None:
        """Take another record."""
        self._room = self._room._replace(samples=np.array(samples, dtype=float))
        self._table = Table(self._room)

    def run(self, p: np.ndarray, dt: float, horizon: float, times: dict[int, float]) -> tuple[int, np.ndarray]:
        """Run with parameters p in the order of `parameters`, and values of rows at these times.

        Returns
        -------
        status : int
        total : ndarray, shape (rows, 4)
            Smallest and largest value, and the value at the time of the row; overwritten by the next run.
        """
        room = self._room
        room.dt[0], room.clock[T_END] = dt, horizon
        for row, time in times.items():
            room.at[row] = time
        room.given_y[:], room.given_p[:] = self._start, p
        return self._march(self._table, True), room.total
