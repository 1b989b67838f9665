"""Steps and events in the order of time, for runs that store them."""

from typing import Any

import numpy as np

from symfric.codegen.numba_types import compiled
from symfric.lower.mode_layout import OPEN
from symfric.solve.loop.modes.layout import mode
from symfric.solve.loop.run_arrays import RunArrays
from symfric.solve.loop.workspace import LoopArrays


@compiled(inline=True)
def store_step(w: LoopArrays, n_c: int, begin: float, length: float) -> int:
    """Store start, length and modes of a step; return its index, at which its coefficients belong."""
    k, shown = w.counts.kept_steps, w.contacts.shown
    w.stored.path_t[k, 0], w.stored.path_t[k, 1] = begin, length
    for i in range(n_c):
        w.stored.path_m[k, i] = mode(w, i)
    for j in range(shown.size):
        w.stored.path_m[k, n_c + j] = np.int64(w.m[shown[j]])
    for j in range(w.openings.variable.size):
        if w.m[w.openings.variable[j]] > 0.5:
            w.stored.path_m[k, w.openings.number[j]] = OPEN
    w.counts.kept_steps += 1
    return k


@compiled(inline=True)
def store_event(w: RunArrays, contact: int, before: Any, after: Any) -> None:
    """Store the change of a contact's mode at the present time."""
    k = w.counts.kept_events
    w.stored.event_t[k] = w.y[w.y.size - 1] + w.clock.t_low
    w.stored.event_i[k, 0], w.stored.event_i[k, 1], w.stored.event_i[k, 2] = contact, before, after
    w.counts.kept_events += 1
