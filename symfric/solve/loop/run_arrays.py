"""What the runs of all event loops have in common: the arrays that others read."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from symfric.codegen.array_table import ArraySet, Cube, IntegerMatrix, Integers, Matrix, Reals, Scalars

SETTLE, EXPAND, GO = range(3)  # values of `Counts.phase`
HIT, LOADED = 1, 2  # values of `Counts.flagged`

CHUNK = 1_000_000  # steps between two reports of the progress


class Counts(Scalars, kind=int):
    """What is counted, and where the loop stands."""

    steps: int
    events: int
    kinks: int
    grazes: int
    kept_steps: int  # of the trajectory
    kept_events: int
    segment: int  # of the inputs, now
    phase: int  # what the loop does next: SETTLE, EXPAND or GO
    stall: int  # events since time has advanced
    mark_events: int  # events when `Clock.mark_t` was set
    mark_steps: int  # steps when `Clock.mark_steps_t` is set next
    flagged: int  # what was hit at the end of the step: nothing, HIT or LOADED
    doubts: int  # events after which derivatives do not exist


class Clock(Scalars):
    """Times."""

    t_low: float  # what rounding leaves of the time
    h_last: float  # length of the last step
    rest: float  # since when everything rests
    mark_t: float
    mark_steps_t: float
    t_end: float


class Limits(Scalars, kind=int):
    """What a run may use, and what it keeps."""

    max_steps: int
    max_events: int
    chunk: int
    keep_path: int
    keep_events: int


@dataclass(frozen=True, eq=False, kw_only=True)
class RunArrays(ArraySet):
    """Arrays of one run that every event loop has."""

    code: Integers  # addresses of machine code
    given_y: Reals  # state and parameters at the start of a run
    given_p: Reals
    y: Reals  # state and time, (n_x + 1,)
    p: Reals  # parameters, and what the machine code takes behind them
    total: Matrix  # smallest, largest, integral and its rounding rest of every wanted row, (n_e, 4)
    due: Reals  # times at which values of rows are wanted, row after row
    first_due: Integers  # where those of each row begin, (n_e + 1,)
    next_due: Integers  # the first of each that has not been passed, (n_e,)
    seen: Reals  # the values at the times due
    counts: Counts
    clock: Clock
    event_t: Reals
    event_i: IntegerMatrix  # contact, mode before, mode after
    path_t: Matrix  # start and length of every step kept
    path_c: Cube  # its state coefficients, (n, n_x, order + 1)
    path_m: IntegerMatrix  # its modes, (n, n_c)


def common(n_x: int, n_p: int, times: Sequence[Sequence[float]], order: int, n_c: int) -> dict[str, Any]:
    """Return the fields of `RunArrays` but `code` and `p`; `times` are those at which each row is wanted."""
    n_e = len(times)
    due = np.array([t for row in times for t in row], dtype=float)
    return {
        "given_y": np.zeros(n_x),
        "given_p": np.zeros(n_p),
        "y": np.zeros(n_x + 1),
        "total": np.zeros((n_e, 4)),
        "due": due,
        "first_due": np.cumsum([0, *(len(row) for row in times)]),
        "next_due": np.zeros(n_e, dtype=np.int64),
        "seen": np.zeros(due.size),
        "counts": Counts.zeros(),
        "clock": Clock.zeros(),
        "event_t": np.zeros(64),
        "event_i": np.zeros((64, 3), dtype=np.int64),
        "path_t": np.zeros((64, 2)),
        "path_c": np.zeros((64, n_x, order + 1)),
        "path_m": np.zeros((64, n_c), dtype=np.int64),
    }


def limit(limits: Limits, budgets: tuple[int, int], wanted) -> None:
    """Set the limits of a run from the budgets of steps and events and what is wanted."""
    limits.max_steps, limits.max_events, limits.chunk = *budgets, CHUNK
    limits.keep_path, limits.keep_events = wanted.path, wanted.events
