"""The march through a record as a loop of the package: its arrays, and how outputs are read off them."""

import math

from symfric.model.scene import Scene
from symfric.solve.compiled import PATH_BYTES, THEN, Loop
from symfric.solve.exact.record_entry import launch_record
from symfric.solve.exact.record_room import RecordRoom, make_record_room
from symfric.solve.exact.record_rows import Recorded
from symfric.solve.taylor.jit import MachineCode, compile_functions
from symfric.solve.taylor.workspace import T_END


class RecordLoop(Loop):
    """The compiled march and the arrays it works on."""

    def __init__(self, room: RecordRoom, recorded: Recorded, horizon: float):
        super().__init__(launch_record, room, recorded.wanted, horizon)
        self._recorded = recorded

    def collect(self, n_x: int):
        """Return what `Loop.collect` does, with the ranges of magnitudes where those are meant."""
        *rest, raw = super().collect(n_x)
        ranges = dict(raw.ranges)
        for name, k in self._recorded.wanted.row.items():
            if self._recorded.magnitude[k]:
                low, high = ranges[name]
                ranges[name] = max(low, -high, 0.0), max(-low, high)
        return (*rest, raw._replace(ranges=ranges))


def record_loop(scene: Scene, recorded: Recorded, budgets: tuple[int, int]) -> tuple[MachineCode, RecordLoop]:
    """Compile what the march needs; budgets are those of steps and of events."""
    code = compile_functions([recorded.problem.data])
    wanted = recorded.wanted
    times = [r.time if r.kind == THEN else -math.inf for r in wanted.rows]
    room = make_record_room(recorded.problem, code.addresses["data"], times)
    steps = PATH_BYTES // room.path_c[0].nbytes if wanted.path else budgets[0]
    room.clock[T_END] = scene.horizon
    room.limits[:5] = min(budgets[0], steps), budgets[1], 1_000_000, wanted.path, wanted.events
    return code, RecordLoop(room, recorded, scene.horizon)
