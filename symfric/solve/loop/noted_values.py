"""Values of an observable at given times."""

import numpy as np

from symfric.codegen.numba_types import compiled
from symfric.solve.loop.polynomials import value


@compiled(fused=True)
def note_values(w, e, c, order, tau, void):
    """Store the values of an observable at its times within a step; the next step may overwrite one at the end."""
    k, end = w.next_due[e], w.first_due[e + 1]
    while k < end:
        since = (w.due[k] - w.y[w.y.size - 1]) - w.clock.t_low
        if since > tau * (1.0 + 1e-9):
            break
        if since >= -1e-9 * tau or not abs(w.seen[k]) < np.inf:  # or between steps
            w.seen[k] = np.nan if void else value(c, order, max(since, 0.0))
        k += 1
        if since < tau * (1.0 - 1e-9):
            w.next_due[e] = k


@compiled
def next_due(w, e):
    """Return when the next value of an observable is due."""
    return np.inf if w.next_due[e] == w.first_due[e + 1] else w.due[w.next_due[e]]
