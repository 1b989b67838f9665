"""The march through a record as a loop of the package."""

import math

from symfric.model.scene import Scene
from symfric.solve.compiled import PATH_BYTES, THEN, Loop
from symfric.solve.exact.record_entry import launch_record
from symfric.solve.exact.record_room import make_record_room
from symfric.solve.exact.record_rows import Recorded
from symfric.solve.taylor.jit import MachineCode, compile_functions
from symfric.solve.taylor.workspace import T_END


def record_loop(scene: Scene, recorded: Recorded, budgets: tuple[int, int]) -> tuple[MachineCode, Loop]:
    """Compile what the march needs; budgets are those of steps and of events."""
    code = compile_functions([recorded.problem.data])
    wanted = recorded.wanted
    times = [r.time if r.kind == THEN else -math.inf for r in wanted.rows]
    room = make_record_room(recorded.problem, code.addresses["data"], times)
    steps = PATH_BYTES // room.path_c[0].nbytes if wanted.path else budgets[0]
    room.clock[T_END] = scene.horizon
    room.limits[:5] = min(budgets[0], steps), budgets[1], 1_000_000, wanted.path, wanted.events
    return code, Loop(launch_record, room, wanted, scene.horizon)
