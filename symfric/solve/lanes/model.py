"""A scene prepared to run in lanes: the code of its steps, for the vectors of this processor."""

from collections import deque
from collections.abc import Sequence
from functools import cache, partial
from typing import Any

import casadi as ca
import llvmlite.binding as llvm
import numpy as np

from symfric.codegen.array_table import Table
from symfric.codegen.columns import WithColumns
from symfric.codegen.functions import compile_functions
from symfric.codegen.llvm_ir import Drafted
from symfric.codegen.loop_loader import sources_key
from symfric.codegen.target import target_machine
from symfric.lower.automaton import Automaton
from symfric.lower.mode_layout import LINE_GUARDS
from symfric.solve.lanes.arrays import LaneArrays, lane_arrays
from symfric.solve.lanes.event import event_step
from symfric.solve.lanes.fields import Plan
from symfric.solve.lanes.located import located_step, smooth_step
from symfric.solve.lanes.swap import swap
from symfric.solve.lanes.wanted_rows import CARRIED
from symfric.solve.loop.case_arrays import CaseArrays
from symfric.solve.loop.compiled_model import CompiledModel
from symfric.solve.loop.stepping.series import Series

# instructions of a series, and number of guards; what is longer takes seconds to compile
_LONGEST, _GUARDS = 5000, 16
_KEPT = 4  # sets of workspaces for the next calls


@cache
def lane_width() -> int:
    """Return how many numbers the vectors of this processor hold."""
    target_machine(opt=0)  # makes LLVM ready
    has = llvm.get_host_cpu_features()
    return 8 if has.get("avx512f") else 4 if has.get("avx2") else 2


@cache
def _written_by() -> str:
    """Return a key of the sources that write the kernels."""
    return sources_key("symfric.solve.lanes.event") + sources_key("symfric.solve.lanes.located")


def plan_of(model: CompiledModel, automaton: Automaton, variants: Sequence[Series], horizon: float) -> Plan | None:
    """Return how a scene runs in lanes; None if it does not, as with long equations or a wanted part of the run."""
    rows, layout, clock, exact = model.wanted.rows, automaton.layout, model.first.clock, model.first.limits.exact
    kinds = ca.Function | WithColumns
    if not all(isinstance(v.series, kinds) and v.series.n_instructions() <= _LONGEST for v in variants):
        return None
    long = layout.n_guards > _GUARDS or any(r.kind not in CARRIED or r.start > 0.0 for r in rows)
    if layout.openings or automaton.planes or long:
        return None
    alone = len(layout.lines) == 1 and layout.n_guards == LINE_GUARDS and not automaton.inputs and not automaton.steps
    selects_mode = alone and len(variants) == 2 and automaton.anchors[0][0] >= 0 and not model.first.limits.varied
    return Plan(automaton, tuple(variants), rows, clock.tolerance, clock.doubt, horizon, exact, selects_mode)


class LaneModel:
    """Kernels of a scene, and workspaces that calls before have left; any number of threads may use it.

    Attributes
    ----------
    plan : Plan
    width : int
    addresses : dict of str to int
        Of the kernels.
    """

    def __init__(self, plan: Plan, model: CompiledModel, width: int | None = None):
        self.plan, self.model, self.width = plan, model, width or lane_width()
        key = f"{_written_by()} {plan.key()} {self.width}"
        kernels = [Drafted("smooth", key, partial(smooth_step, plan, self.width))]
        kernels.append(Drafted("swap", key, partial(swap, len(plan.names()), self.width)))
        if plan.n_g:
            located, names = event_step if plan.selects_mode else located_step, ("event", "stick")[: len(plan.variants)]
            kernels += [Drafted(name, key, partial(located, plan, self.width, name, k)) for k, name in enumerate(names)]
        self._code = compile_functions(kernels)
        self.addresses = self._code.addresses
        self._idle: deque[LaneWorkspace] = deque(maxlen=_KEPT)

    def workspace(self) -> "LaneWorkspace":
        """Borrow the memory of one thread, to be returned by `give_back`."""
        try:
            return self._idle.pop()
        except IndexError:
            return LaneWorkspace(self)

    def give_back(self, workspace: "LaneWorkspace") -> None:
        """Keep the memory of a thread for another call."""
        self._idle.append(workspace)


class LaneWorkspace:
    """The memory of one thread: two blocks of lanes, and the arrays of one run for each.

    Attributes
    ----------
    arrays : LaneArrays
        Without cases, see `taking`.
    """

    def __init__(self, lanes: LaneModel):
        rooms = [_one_step(lanes.model) for _ in range(2 * lanes.width)]
        self._rooms = [(room, Table(room)) for room in rooms]
        self._addresses = np.array([(t.address, t.result, t.trouble) for _, t in self._rooms], dtype=np.int64)
        self._lanes = lanes

    def taking(self, cases: CaseArrays) -> LaneArrays:
        """Return the arrays of this thread for some cases."""
        lanes = self._lanes
        return lane_arrays(cases, lanes.plan, lanes.width, lanes.addresses, lanes.model.loop.address, self._addresses)


def _one_step(model: CompiledModel) -> Any:
    """Return the arrays of a run that pauses after every step and every choice of its mode."""
    arrays = model.first.copy(model.shared - {"limits"})
    arrays.limits.chunk = arrays.limits.apart = 1
    return arrays
