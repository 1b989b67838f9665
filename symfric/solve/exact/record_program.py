"""The march through a record as a loop of the package: its arrays, and how outputs are read off them."""

from dataclasses import replace

from symfric.model.scene import Scene
from symfric.solve.compiled import PATH_BYTES, Loop, Wanted, wanted_of
from symfric.solve.exact.record_entry import launch_record
from symfric.solve.exact.record_room import RecordRoom, make_record_room
from symfric.solve.exact.record_rows import Recorded
from symfric.solve.taylor.jit import MachineCode, compile_functions
from symfric.solve.taylor.workspace import T_END


class RecordLoop(Loop):
    """The compiled march and the arrays it works on."""

    def __init__(self, room: RecordRoom, wanted: Wanted, recorded: Recorded, horizon: float):
        super().__init__(launch_record, room, wanted, horizon)
        self._recorded = recorded

    def collect(self, n_x: int):
        """Return what `Loop.collect` does, with ranges of magnitudes and values at given times."""
        *rest, raw = super().collect(n_x)
        total = self.work.total.tolist()
        ranges, numbers = {}, {}
        for name, k in self._recorded.row.items():
            low, high, _, then = total[k]
            row = self._recorded.rows[k]
            if row.time >= 0:
                numbers[name] = then
            else:
                ranges[name] = (max(low, -high, 0.0), max(-low, high)) if row.magnitude else (low, high)
        return (*rest, raw._replace(ranges=ranges, integrals=numbers))


def record_loop(scene: Scene, recorded: Recorded, budgets: tuple[int, int]) -> tuple[MachineCode, RecordLoop]:
    """Compile what the march needs; budgets are those of steps and of events."""
    code = compile_functions([recorded.problem.data])
    wanted = replace(wanted_of(scene), rows=(), row={})
    room = make_record_room(recorded.problem, code.addresses["data"], [r.time for r in recorded.rows])
    steps = PATH_BYTES // room.path_c[0].nbytes if wanted.path else budgets[0]
    room.clock[T_END] = scene.horizon
    room.limits[:5] = min(budgets[0], steps), budgets[1], 1_000_000, wanted.path, wanted.events
    return code, RecordLoop(room, wanted, recorded, scene.horizon)
