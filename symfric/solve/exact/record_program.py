"""What a program needs to march through a record: the arrays, and how outputs are read off them."""

import math
from typing import NamedTuple

import sympy as sp

from symfric.errors import NoRoute
from symfric.lower.record import Record, record
from symfric.model.outputs import At, Events, Integral, ScalarOfExpression, Trajectory
from symfric.model.scene import Scene
from symfric.solve.compiled import PATH_BYTES, Loop, Wanted
from symfric.solve.exact.record_entry import launch_record
from symfric.solve.exact.record_room import make_record_room
from symfric.solve.taylor.jit import MachineCode, compile_functions
from symfric.solve.taylor.workspace import T_END


class Asked(NamedTuple):
    """A row: the range of an expression, of its magnitude, or its value at a time."""

    expr: sp.Expr
    magnitude: bool
    time: float


class RecordLoop(Loop):
    """The march through a record and the arrays it works on."""

    def __init__(self, room, wanted: Wanted, asked: dict[str, int], rows: list[Asked], horizon: float):
        super().__init__(launch_record, room, wanted, horizon)
        self._asked, self._rows = asked, rows

    def collect(self, *arguments):
        """Return what `Loop.collect` does, with ranges of magnitudes and values at given times."""
        *rest, raw = super().collect(*arguments)
        total = self.work.total.tolist()
        ranges, numbers = {}, {}
        for name, k in self._asked.items():
            low, high, _, then = total[k]
            if self._rows[k].magnitude:
                low, high = max(low, -high, 0.0), max(-low, high)
            if math.isnan(self._rows[k].time):
                ranges[name] = low, high
            else:
                numbers[name] = then
        return (*rest, raw._replace(ranges=ranges, integrals=numbers))


def record_loop(scene: Scene, settings, varied: frozenset[str]) -> tuple[MachineCode, RecordLoop, Record]:
    """Compile what the march needs.

    Raises
    ------
    NoRoute
        If the scene is not one mass under a record, or wants more than the march gives.
    """
    asked, rows = {}, {}
    for name, output in scene.outputs.items():
        if isinstance(output, Integral):
            raise NoRoute("an integral is wanted")
        if isinstance(output, ScalarOfExpression):
            expr, time = output.expr, math.nan
            if isinstance(output, At):
                time = min(output.time, scene.horizon) if output.time is not None else scene.horizon
            magnitude = isinstance(expr, sp.Abs) and math.isnan(time)
            key = Asked(expr.args[0] if magnitude else expr, magnitude, time if not math.isnan(time) else -1.0)
            asked[name] = rows.setdefault(key, len(rows))
    wants = [type(o) for o in scene.outputs.values()]
    wanted = Wanted((), {}, Trajectory in wants, Trajectory in wants or Events in wants)
    questions = [k._replace(time=math.nan if k.time < 0 else k.time) for k in rows]
    problem = record(scene, [k.expr for k in rows], varied)
    code = compile_functions([problem.data])
    room = make_record_room(problem, code.addresses["data"], [k.time for k in questions])
    steps = PATH_BYTES // room.path_c[0].nbytes if wanted.path else settings.max_steps
    room.clock[T_END] = scene.horizon
    room.limits[:5] = min(settings.max_steps, steps), settings.max_events, 1_000_000, wanted.path, wanted.events
    return code, RecordLoop(room, wanted, asked, questions, scene.horizon), problem
