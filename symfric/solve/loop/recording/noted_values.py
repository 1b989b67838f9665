"""Values of an observable at given times."""

import numpy as np

from symfric.codegen.array_table import Reals
from symfric.codegen.numba_types import compiled
from symfric.solve.loop.arithmetic import value
from symfric.solve.loop.precision import LATE
from symfric.solve.loop.workspace import LoopArrays


@compiled(fused=True)
def note_values(w: LoopArrays, e: int, c: Reals, order: int, tau: float, void: bool) -> None:
    """Store the values of an observable at its times within a step; the next step may overwrite one at the end."""
    k, end = w.observed.next_due[e], w.times.first[e + 1]
    while k < end:
        since = (w.times.due[k] - w.y[w.y.size - 1]) - w.clock.t_low
        if since > tau * (1.0 + LATE):
            break
        if since >= -LATE * tau or not abs(w.observed.seen[k]) < np.inf:  # or between steps
            w.observed.seen[k] = np.nan if void else value(c, order, max(since, 0.0))
        k += 1
        if since < tau * (1.0 - LATE):
            w.observed.next_due[e] = k


@compiled
def next_due(w: LoopArrays, e: int) -> float:
    """Return when the next value of an observable is due."""
    return np.inf if w.observed.next_due[e] == w.times.first[e + 1] else w.times.due[w.observed.next_due[e]]
