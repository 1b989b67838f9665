"""Common rules of all event loops for starting, pausing and ending a run."""

import numpy as np

from symfric.codegen.numba_types import compiled
from symfric.solve.loop.codes import CHATTER, EVENT_BUDGET, OK, SELECT, STEP_BUDGET
from symfric.solve.loop.run_arrays import RunArrays
from symfric.solve.status import EVENTS_FULL, PATH_FULL, PAUSED

_STALLED = 200  # most events without advance of time
WINDOW = 1000  # a run stands still if so many events advance less than a rounding error of the time


@compiled(inline=True)
def begin_counting(w: RunArrays) -> None:
    """Initialise counters and times of a run."""
    c = w.counts
    c.steps, c.events, c.kinks, c.grazes, c.kept_steps, c.kept_events = 0, 0, 0, 0, 0, 0
    c.segment, c.phase, c.stall, c.mark_events, c.mark_steps, c.flagged, c.doubts = 0, SELECT, 0, 0, 0, 0, 0
    c.jumped = 0
    w.clock.t_low, w.clock.h_last, w.clock.rest = 0.0, 0.0, np.nan
    w.clock.mark_t, w.clock.mark_steps_t = 0.0, -np.inf


@compiled(inline=True)
def begin_values(w: RunArrays) -> None:
    """Reset the sampled values of a previous run."""
    for e in range(w.observed.next_due.size):
        w.observed.next_due[e] = w.times.first[e]
    for k in range(w.observed.seen.size):
        w.observed.seen[k] = np.nan


@compiled(inline=True)
def pause(w: RunArrays, stop: int, most: int) -> int:
    """Return why a run has to pause before its next step, which logs at most so many events; `stop` counts steps."""
    if w.counts.steps >= w.limits.max_steps:
        return STEP_BUDGET
    if w.counts.steps >= stop:
        return PAUSED
    if w.limits.keep_path and w.counts.kept_steps >= w.stored.path_t.shape[0]:
        return PATH_FULL
    if w.limits.keep_events and w.counts.kept_events + most > w.stored.event_t.size:
        return EVENTS_FULL
    return OK


@compiled(inline=True)
def budget(w: RunArrays, t: float) -> int:
    """Return a status that ends a run with too many events, in total or at the time t."""
    if w.counts.stall > _STALLED:
        return CHATTER
    if w.counts.events > w.limits.max_events:
        return EVENT_BUDGET
    if w.counts.events - w.counts.mark_events > WINDOW:
        if t - w.clock.mark_t < 4e-13 * max(t, 1e-3 * w.clock.t_end):
            return CHATTER
        w.counts.mark_events, w.clock.mark_t = w.counts.events, t
    return OK
