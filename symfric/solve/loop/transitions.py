"""Events of contacts that do not slip along a line, which change state and mode by a function of the model.

See `symfric.lower.automaton.Automaton.transition`.
"""

import numpy as np

from symfric.codegen.numba_types import call_code, compiled
from symfric.solve.loop.workspace import TRANSITION


@compiled
def transit(w, n_c):
    """Change state and mode at events of such contacts; log the changes and return their number.

    Changes at the start of a run only complete the first mode; they are no events.
    """
    first, n_m, n_p = w.limits.first_other, w.m.size, w.p.size
    found, starting = 0, w.clock.h_last == 0.0 and w.counts.steps == 0
    for g in range(first, w.hit.size):
        found += w.hit[g]
    if found == 0:
        return 0
    for k in range(n_p):
        w.asked[k] = w.p[k]
    for k in range(n_m):
        w.asked[n_p + k] = w.m[k]
    n_o = w.hit.size - first
    for k in range(n_o):
        w.asked[n_p + n_m + k] = w.hit[first + k]
        w.asked[n_p + n_m + n_o + k] = w.fresh[first + k]
    call_code(w.code[TRANSITION], w.y.ctypes.data, w.asked.ctypes.data, w.answer.ctypes.data)
    n_y = w.answer.size - n_m - n_o
    for k in range(n_y):
        w.y[k] = w.answer[k]
    for k in range(n_m):
        w.m[k] = w.answer[n_y + k]
    for g in range(first, w.hit.size):
        w.fresh[g], w.slack[g] = w.answer[n_y + n_m + g - first] > 0.5, 0.0
        if w.hit[g] and w.limits.keep_events and not starting:
            variable, k = w.other_guards[g - first, 1], w.counts.kept_events
            w.event_t[k] = w.y[w.y.size - 1] + w.clock.t_low
            w.event_i[k, 0] = n_c + w.other_guards[g - first, 0]
            w.event_i[k, 1] = np.int64(w.asked[n_p + variable]) if variable >= 0 else 0
            w.event_i[k, 2] = np.int64(w.m[variable]) if variable >= 0 else 0
            w.counts.kept_events += 1
    return 0 if starting else found
