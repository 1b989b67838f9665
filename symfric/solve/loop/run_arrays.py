"""What the runs of all event loops have in common: the arrays that others read, and the rules that end a run."""

from dataclasses import dataclass
from typing import Any

import numpy as np

from symfric.codegen.array_table import ArraySet, Cube, IntegerMatrix, Integers, Matrix, Reals, Scalars
from symfric.codegen.numba_types import compiled
from symfric.solve.status import EVENTS_FULL, PATH_FULL, PAUSED, Status

SETTLE, EXPAND, GO = range(3)  # values of `Counts.phase`

_OK, _STEPS, _EVENTS = int(Status.OK), int(Status.STEP_BUDGET), int(Status.EVENT_BUDGET)
_CHATTER = int(Status.CHATTER)
_STALLED = 200  # events without time advancing
_WINDOW = 1000  # events that together advance less than a rounding error of the time stand still
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
    flagged: int  # 1 if a guard was hit at the end of the step, 2 if it was a load
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
    counts: Counts
    clock: Clock
    event_t: Reals
    event_i: IntegerMatrix  # contact, mode before, mode after
    path_t: Matrix  # start and length of every step kept
    path_c: Cube  # its state coefficients, (n, n_x, order + 1)
    path_m: IntegerMatrix  # its modes, (n, n_c)


def common(n_x: int, n_p: int, n_e: int, order: int, n_c: int) -> dict[str, Any]:
    """Return the fields of `RunArrays` but `code` and `p`, empty."""
    return {
        "given_y": np.zeros(n_x),
        "given_p": np.zeros(n_p),
        "y": np.zeros(n_x + 1),
        "total": np.zeros((n_e, 4)),
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


@compiled(inline=True)
def begin_counting(w):
    """Set counts and times to those of a run that begins."""
    c = w.counts
    c.steps, c.events, c.kinks, c.grazes, c.kept_steps, c.kept_events = 0, 0, 0, 0, 0, 0
    c.segment, c.phase, c.stall, c.mark_events, c.mark_steps, c.flagged, c.doubts = 0, SETTLE, 0, 0, 0, 0, 0
    w.clock.t_low, w.clock.h_last, w.clock.rest = 0.0, 0.0, np.nan
    w.clock.mark_t, w.clock.mark_steps_t = 0.0, -np.inf


@compiled(inline=True)
def pause(w, stop, most):
    """Return why a run has to stop before its next step, which logs at most so many events; `stop` counts steps."""
    if w.counts.steps >= w.limits.max_steps:
        return _STEPS
    if w.counts.steps >= stop:
        return PAUSED
    if w.limits.keep_path and w.counts.kept_steps >= w.path_t.shape[0]:
        return PATH_FULL
    if w.limits.keep_events and w.counts.kept_events + most > w.event_t.size:
        return EVENTS_FULL
    return _OK


@compiled(inline=True)
def budget(w, t):
    """Return a status that ends a run of too many events, or of too many at the time t."""
    if w.counts.stall > _STALLED:
        return _CHATTER
    if w.counts.events > w.limits.max_events:
        return _EVENTS
    if w.counts.events - w.counts.mark_events > _WINDOW:
        if t - w.clock.mark_t < 4e-13 * max(t, 1e-3 * w.clock.t_end):
            return _CHATTER
        w.counts.mark_events, w.clock.mark_t = w.counts.events, t
    return _OK
