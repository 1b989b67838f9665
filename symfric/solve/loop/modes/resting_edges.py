"""Switches of friction profiles at contacts at rest on an edge, see `symfric.lower.cell_edges`."""

from symfric.codegen.array_table import Matrix
from symfric.codegen.numba_types import compiled
from symfric.lower.cell_edges import ON_EDGE
from symfric.solve.loop.codes import COUPLING
from symfric.solve.loop.modes.layout import sign, switch
from symfric.solve.loop.modes.tolerances import natural_time
from symfric.solve.loop.precision import ROUNDING, TIE
from symfric.solve.loop.stepping.series import PROBED
from symfric.solve.loop.workspace import LoopArrays

_MOST = 6  # most changes of one switch during mode selection


@compiled
def find_edges(w: LoopArrays, n_x: int, n_c: int, first: bool) -> bool:
    """Set every profile switch at zero in the trial mode: its sign, or no sign if it stays at zero.

    Return whether one was changed. `first` marks the start of mode selection.
    """
    changed = False
    for j in range(w.contacts.edge.size):
        if w.contacts.edge[j] == 0:
            continue
        g = sign(j, n_c)
        row = n_x + switch(j, n_c)
        w.scale[row] = max(w.scale[row], size_of(w, n_c, j, 0))
        if first:
            w.selection.rested[j] = abs(w.m[g]) == ON_EDGE
        new = _new_sign(w, row, g, j, n_c)
        if new != w.m[g] and w.selection.turns[n_c + j] < _MOST:
            w.selection.turns[n_c + j] += 1
            w.counts.kinks += new * w.m[g] < 0.0
            w.m[g] = new
            changed = True
    return changed


@compiled(inline=True)
def size_of(w: LoopArrays, n_c: int, j: int, derivative: int) -> float:
    """Return the size of the terms of the quantity of a profile switch j, or of one of its derivatives."""
    at = (COUPLING + n_c + w.limits.n_q + w.limits.coupled) * n_c + derivative * w.limits.edges + w.contacts.edge[j] - 1
    return w.gauge[at // n_c, at % n_c]


@compiled
def _new_sign(w: LoopArrays, row: int, g: int, j: int, n_c: int) -> float:
    """Return the mode entry of a switch: its sign now or immediately after, +-ON_EDGE if it stays at zero.

    One that is not at zero and has the wrong sign is left to `_change_switch` in `.mode_selection`. Of one that was at
    zero before, what the forces leave by rounding in the meantime is zero, too.
    """
    old = w.m[g]
    present = 1.0 if old > 0.0 else -1.0
    limit, time = ROUNDING * w.scale[row], natural_time(w)
    if w.selection.rested[j]:
        limit = max(limit, TIE * size_of(w, n_c, j, 2) * time * time)
    if w.guards.hit[switch(j, n_c)] == 0 and abs(w.probe[row, 0] / old) > limit:
        return present
    order = decisive(w, w.probe, row, j, n_c, time)
    if order > PROBED:
        return present * ON_EDGE
    return 1.0 if w.probe[row, order] / old > 0.0 else -1.0


@compiled(inline=True)
def decisive(w: LoopArrays, c: Matrix, row: int, j: int, n_c: int, time: float) -> int:
    """Return the order of the first coefficient of switch j, at zero, that is nonzero up to rounding.

    4 if the first three are. `c` holds the coefficients of all rows, `time` is the natural one.
    """
    if w.contacts.edge[j] == 0:
        if abs(c[row, 1]) * time > TIE * w.scale[row]:
            return 1
        return 2 if abs(c[row, 2]) > TIE * abs(c[row, 3]) * time else 3
    scale, force = abs(w.m[sign(j, n_c)]), size_of(w, n_c, j, 2)
    little = max(ROUNDING * size_of(w, n_c, j, 1), TIE * w.scale[row] / time)
    if w.selection.rested[j]:
        little = max(little, TIE * force * time)
    if abs(c[row, 1]) > scale * little:
        return 1
    if 2.0 * abs(c[row, 2]) > scale * TIE * force:
        return 2
    return 3 if 6.0 * abs(c[row, 3]) * time > scale * TIE * force else 4
