"""Arrays that the runs of all event loops have in common."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from symfric.codegen.array_table import ArraySet, Cube, IntegerMatrix, Integers, Matrix, Reals, Scalars
from symfric.solve.observables import Observables

CHUNK = 1_000_000  # number of steps between two reports of the progress


class Counts(Scalars, kind=int):
    """Counters and current position of the loop."""

    steps: int
    events: int
    kinks: int
    grazes: int
    kept_steps: int  # stored steps of the trajectory
    kept_events: int
    segment: int  # current segment of the inputs
    phase: int  # next phase of the loop: SELECT, EXPAND, GO or SEGMENT
    stall: int  # events since time has advanced
    mark_events: int  # events when `Clock.mark_t` was set
    mark_steps: int  # steps when `Clock.mark_steps_t` is set next
    flagged: int  # event at the end of the step: 0 for none, HIT or LOADED
    jumped: int  # whether slips may have jumped: at a step in time, or at a sample of an input
    doubts: int  # events after which derivatives do not exist


class Clock(Scalars):
    """Times and their rounding errors."""

    t_low: float  # rounding error of the time
    h_last: float  # length of the last step
    rest: float  # time since which everything rests
    mark_t: float
    mark_steps_t: float
    t_end: float


class Limits(Scalars, kind=int):
    """Budgets of a run, and what it stores."""

    max_steps: int
    max_events: int
    chunk: int
    keep_path: int
    keep_events: int


@dataclass(frozen=True, eq=False, kw_only=True)
class Observed(ArraySet):
    """What a run finds of the observables."""

    total: Matrix  # smallest, largest, integral and its rounding error of every observable, (n_e, 4)
    next_due: Integers  # index of the first sampling time not yet passed, (n_e,)
    seen: Reals  # sampled values


@dataclass(frozen=True, eq=False, kw_only=True)
class Times(ArraySet):
    """When observables are sampled."""

    due: Reals  # sampling times of the observables, one after the other
    first: Integers  # index of the first sampling time of each, (n_e + 1,)


@dataclass(frozen=True, eq=False, kw_only=True)
class Stored(ArraySet):
    """The present piece of a trajectory, and of a list of events; see `symfric.solve.loop.compiled_model`."""

    event_t: Reals
    event_i: IntegerMatrix  # contact, mode before, mode after
    path_t: Matrix  # start and length of every stored step
    path_c: Cube  # its state coefficients, (n, n_x, order + 1)
    path_m: IntegerMatrix  # its modes, (n, n_c)


@dataclass(frozen=True, eq=False, kw_only=True)
class RunArrays(ArraySet):
    """Common arrays of one run."""

    code: Integers  # addresses of machine code
    given_y: Reals  # state and parameters at the start of a run
    given_p: Reals
    y: Reals  # state and time, (n_x + 1,)
    p: Reals  # parameters, and further inputs of the machine code
    rest: Reals  # derivatives of the time since which everything rests, where a loop has them
    observed: Observed
    times: Times
    stored: Stored
    counts: Counts
    clock: Clock
    limits: Limits


def common(n_x: int, n_p: int, times: Sequence[Sequence[float]], order: int, n_c: int) -> dict[str, Any]:
    """Return the fields of `RunArrays` but `code`, `p`, `clock`; `times` are the sampling times of each observable."""
    n_e = len(times)
    due = np.array([t for row in times for t in row], dtype=float)
    return {
        "given_y": np.zeros(n_x),
        "given_p": np.zeros(n_p),
        "y": np.zeros(n_x + 1),
        "rest": np.zeros(n_x),
        "observed": Observed(total=np.zeros((n_e, 4)), next_due=np.zeros(n_e, dtype=np.int64), seen=np.zeros(due.size)),
        "times": Times(due=due, first=np.cumsum([0, *(len(row) for row in times)])),
        "stored": Stored(
            event_t=np.zeros(64),
            event_i=np.zeros((64, 3), dtype=np.int64),
            path_t=np.zeros((64, 2)),
            path_c=np.zeros((64, n_x, order + 1)),
            path_m=np.zeros((64, n_c), dtype=np.int64),
        ),
        "counts": Counts.zeros(),
    }


def limit(limits: Limits, budgets: tuple[int, int], wanted: Observables) -> None:
    """Set the limits of a run from the budgets of steps and events and the observables."""
    limits.max_steps, limits.max_events, limits.chunk = *budgets, CHUNK
    limits.keep_path, limits.keep_events = wanted.path, wanted.events
