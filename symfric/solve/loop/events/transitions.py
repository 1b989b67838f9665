"""Events of contacts that do not slip along a line, which change state and mode by a function of the model.

See `symfric.lower.automaton.Automaton.transition`.
"""

import numpy as np

from symfric.codegen.numba_types import call_code, compiled
from symfric.solve.loop.codes import TRANSITION
from symfric.solve.loop.recording.trajectory import store_event
from symfric.solve.loop.workspace import LoopArrays


@compiled
def transit(w: LoopArrays, n_c: int) -> int:
    """Change state and mode at events of such contacts and of clocks; log those of contacts, return their number.

    Changes at the start of a run only complete the first mode; they are no events. The number is negative if a held
    variable has no place for one more value on its way.
    """
    first, n_m, n_p = w.limits.first_other, w.m.size, w.p.size
    hits, starting, struck = 0, w.clock.h_last == 0.0 and w.counts.steps == 0, False
    for g in range(first, w.limits.first_opening):
        hits += w.guards.hit[g]
    for g in range(w.limits.first_clock, w.guards.hit.size):
        struck = struck or w.guards.hit[g] != 0
    if hits == 0 and not struck and not (starting and w.limits.first_crossing < w.guards.hit.size):
        return 0
    if struck:
        w.counts.jumped = 1
    for k in range(n_p):
        w.transition.asked[k] = w.p[k]
    for k in range(n_m):
        w.transition.asked[n_p + k] = w.m[k]
    n_o = w.guards.hit.size - first
    for k in range(n_o):
        w.transition.asked[n_p + n_m + k] = w.guards.hit[first + k]
        w.transition.asked[n_p + n_m + n_o + k] = w.guards.fresh[first + k]
    call_code(w.code[TRANSITION], w.y.ctypes.data, w.transition.asked.ctypes.data, w.transition.answer.ctypes.data)
    n_y = w.transition.answer.size - n_m - n_o
    for k in range(n_y):
        w.y[k] = w.transition.answer[k]
    for k in range(n_m):
        w.m[k] = w.transition.answer[n_y + k]
    for g in range(first, w.guards.hit.size):
        if g < w.limits.first_crossing:
            w.guards.fresh[g], w.guards.slack[g] = w.transition.answer[n_y + n_m + g - first] > 0.5, 0.0
        if w.guards.hit[g] and w.limits.keep_events and not starting and g < w.limits.first_opening:
            contact, variable = w.contacts.other_guards[g - first, 0], w.contacts.other_guards[g - first, 1]
            before = np.int64(w.transition.asked[n_p + variable]) if variable >= 0 else 0
            store_event(w, n_c + contact, before, np.int64(w.m[variable]) if variable >= 0 else 0)
    for k in range(n_m):
        if np.isnan(w.m[k]):
            return -1
    return 0 if starting else hits
