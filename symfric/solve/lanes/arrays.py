"""The arrays with which one thread runs cases in lanes."""

import math
from dataclasses import dataclass, fields

import numpy as np

from symfric.codegen.array_table import IntegerMatrix, Integers, Matrix, Scalars
from symfric.solve.lanes.fields import NOTED, OWED_OF, Plan
from symfric.solve.loop.case_arrays import CaseArrays

_ALIGNED = 128  # bytes


class Kernels(Scalars, kind=int):
    """Addresses of machine code, what cases there are, and where the fields of each kind begin."""

    smooth: int  # kernels; those that there are not are zero
    event: int
    stick: int
    swap: int
    selects_mode: int  # whether lanes choose the mode after an event
    closing: int  # whether there are no cases beside those that are handed out
    wanting: int  # whether a lane waits for one
    calls: int  # number of calls of the event loop so far
    n_x: int
    n_e: int
    sticker: int  # see `symfric.solve.loop.workspace.LoopLimits`
    t: int
    t_low: int
    h_last: int
    end: int
    steps: int
    mark_steps: int
    start: int
    scale: int
    first: int
    second: int
    seen: int
    follows: int  # whether rows hold derivatives at the extremes of others
    aux: int
    fresh: int
    little: int
    slack: int
    which: int
    events: int
    mark_events: int
    grazes: int
    mode: int
    way: int
    rest: int
    other: int
    p: int


@dataclass(frozen=True, eq=False, kw_only=True)
class LaneArrays(CaseArrays):
    """And two blocks of lanes: one in which all take steps without events, and one from which they are replaced."""

    kernels: Kernels
    moving: Matrix  # fields of the lanes, (fields, width)
    waiting: Matrix
    case_of: IntegerMatrix  # cases of the lanes of both blocks, -1 for none, (2, width)
    room_of: IntegerMatrix  # their workspaces
    state: Integers  # what the lanes that wait need, (width,)
    tables: IntegerMatrix  # of the workspaces, with result and trouble, (2 width, 3)
    masks: Integers
    notes: Matrix  # what a kernel notes of a step for rows that it leaves, (3 + rows (order + 2), width)


def lane_arrays(
    cases: CaseArrays, plan: Plan, width: int, addresses: dict[str, int], loop: int, tables: np.ndarray
) -> LaneArrays:
    """Return the arrays of one thread, which share those of the cases with all others.

    Parameters
    ----------
    cases : CaseArrays
    plan : Plan
    width : int
    addresses : dict of str to int
        Of the kernels.
    loop : int
        Address of the event loop.
    tables : ndarray
        As in `LaneArrays`.
    """
    at, kernels = plan.names(), Kernels.zeros()
    given = {f.name: getattr(cases, f.name) for f in fields(CaseArrays)} | {"place": cases.place.copy()}
    for name in Kernels.names:
        place = at.get(name, at.get(f"{name}0", -1))
        setattr(kernels, name, addresses.get(name, 0) if name in ("smooth", "event", "stick", "swap") else place)
    kernels.closing, kernels.wanting, kernels.calls, kernels.selects_mode = 0, 0, 0, plan.selects_mode
    kernels.n_x, kernels.n_e, kernels.follows = plan.n_x, len(plan.rows), plan.follows
    kernels.sticker = plan.automaton.sticks.index(True) if len(plan.variants) > 1 else -1
    given["place"].loop = loop
    return LaneArrays(
        **given,
        kernels=kernels,
        moving=_aligned(len(at), width),
        waiting=_aligned(len(at), width),
        case_of=np.full((2, width), -1, dtype=np.int64),
        room_of=np.arange(2 * width, dtype=np.int64).reshape(2, width),
        state=np.zeros(width, dtype=np.int64),
        tables=tables,
        masks=np.zeros(OWED_OF + len(plan.rows), dtype=np.int64),
        notes=_aligned(NOTED + len(plan.rows) * plan.noted, width),
    )


def _aligned(*shape: int) -> np.ndarray:
    """Return zeros that begin where vectors may."""
    n, more = math.prod(shape), _ALIGNED // 8
    room = np.zeros(n + more)
    first = (-room.ctypes.data // 8) % more
    return room[first : first + n].reshape(shape)
