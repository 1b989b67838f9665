"""Switches at the place where contacts rest: which of them have no sign, see `symfric.lower.edges`."""

from symfric.lower.edges import ON_EDGE
from symfric.solve.native import compiled
from symfric.solve.taylor.workspace import COUPLING, EDGES, KINKS, N_Q
from symfric.solve.taylor.zero import ROUNDING, TIE, natural_time

_MOST = 6  # changes of one switch while settling


@compiled
def find_edges(w, n_x, n_c, n_s):
    """Give every switch at which a load jumps, if it is at zero, its sign in the mode on trial, or none if it stays.

    Return whether one was changed.
    """
    n_e = w.limits[EDGES]
    if n_e == 0:
        return False
    k, changed = 0, False
    first = (COUPLING + n_c + w.limits[N_Q]) * n_c  # of the sizes, after the other entries of the gauge
    for j in range(n_s):
        if w.edge[j] == 0:
            continue
        row, g, at = n_x + 2 * n_c + j, 2 * n_c + j, first + k
        k += 1
        w.scale[row] = max(w.scale[row], w.gauge[at // n_c, at % n_c])
        new = _sign(w, row, g, at + n_e, at + 2 * n_e, n_c)
        if new != w.m[g] and w.turns[n_c + j] < _MOST:
            w.turns[n_c + j] += 1
            w.counts[KINKS] += new * w.m[g] < 0.0
            w.m[g] = new
            changed = True
    return changed


@compiled
def _sign(w, row, g, at_rate, at_force, n_c):
    """Return the entry of a switch: its sign now or in the next instant, +-ON_EDGE if it stays at zero.

    One that is not at zero and has the wrong sign is left to `_change_switch` of `symfric.solve.taylor.settle`.
    """
    old = w.m[g]
    present = 1.0 if old > 0.0 else -1.0
    value, slope, curve, third = (
        w.probe[row, 0] / old,
        w.probe[row, 1] / old,
        2.0 * w.probe[row, 2] / old,
        6.0 * w.probe[row, 3] / old,
    )
    if w.hit[g] == 0 and abs(value) > ROUNDING * w.scale[row]:
        return present
    time, force = natural_time(w), w.gauge[at_force // n_c, at_force % n_c]
    if abs(slope) > max(ROUNDING * w.gauge[at_rate // n_c, at_rate % n_c], TIE * w.scale[row] / time):
        moved = slope
    elif abs(curve) > TIE * force:
        moved = curve
    elif abs(third) * time > TIE * force:
        moved = third
    else:
        return present * ON_EDGE
    return 1.0 if moved > 0.0 else -1.0
