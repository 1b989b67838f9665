"""A scene prepared to run in lanes: the code of its steps, for the vectors of this processor."""

from collections import deque
from dataclasses import replace
from functools import cache
from typing import Any

import casadi as ca
import llvmlite.binding as llvm

from symfric.codegen.functions import compile_functions
from symfric.codegen.target import target_machine
from symfric.lower.automaton import Automaton
from symfric.model.outputs import INTEGRAL, RANGE
from symfric.solve.lanes.event import SLIPS, STICKS, event_step
from symfric.solve.lanes.fields import Plan
from symfric.solve.lanes.step import smooth_step
from symfric.solve.loop.compiled_model import CompiledModel, own
from symfric.solve.loop.series import Series

_LONGEST = 3000  # instructions of a series; longer ones take seconds to compile
_KEPT = 4  # sets of workspaces for the next calls


@cache
def lane_width() -> int:
    """Return how many numbers the vectors of this processor hold."""
    target_machine(opt=0)  # makes LLVM ready
    has = llvm.get_host_cpu_features()
    return 8 if has.get("avx512f") else 4 if has.get("avx2") else 2


def plan_of(model: CompiledModel, automaton: Automaton, variants: list[Series], horizon: float) -> Plan | None:
    """Return how a scene runs in lanes; None if it does not.

    That are scenes with sampled inputs, values at given times, long equations, loads that may vanish, switches or
    several contacts.
    """
    rows, layout = model.wanted.rows, automaton.layout
    if not all(isinstance(v.series, ca.Function) and v.series.n_instructions() <= _LONGEST for v in variants):
        return None
    if automaton.inputs or any(r.kind not in (RANGE, INTEGRAL) for r in rows):
        return None
    if layout.switches or layout.others or layout.loads or len(layout.lines) > 1:
        return None
    sticking = any(automaton.sticks)
    if sticking and (len(variants) != 2 or automaton.anchors[0][0] < 0):
        return None
    clock = model.first.clock
    return Plan(automaton, tuple(variants), rows, clock.tolerance, clock.doubt, horizon, sticking)


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
        kernels = [smooth_step(plan, self.width, "smooth")]
        if plan.events:
            kernels += [event_step(plan, self.width, name, k) for k, name in ((SLIPS, "event"), (STICKS, "stick"))]
        self._code = compile_functions(kernels)
        self.addresses = self._code.addresses
        self._idle: deque[list[Any]] = deque(maxlen=_KEPT)

    def workspaces(self) -> list[Any]:
        """Return the arrays of one run for each lane of two blocks; their loop pauses after every step."""
        try:
            return self._idle.pop()
        except IndexError:
            return [self._one_step() for _ in range(2 * self.width)]

    def give_back(self, workspaces: list[Any]) -> None:
        """Keep workspaces for another call."""
        self._idle.append(workspaces)

    def _one_step(self):
        arrays = replace(own(self.model.first, self.model.shared), limits=self.model.first.limits.copy())
        arrays.limits.chunk = 1
        return arrays
