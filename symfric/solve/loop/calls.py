"""Calls of the machine code of a model, in the current mode of a workspace."""

from symfric.codegen.numba_types import call_code, compiled
from symfric.solve.loop.powers import gather, powers
from symfric.solve.loop.structure_powers import gather_structure, structure_powers
from symfric.solve.loop.workspace import FUNCTIONS, STRUCTURE


@compiled(inline=True)
def _variant(w):
    """Return the index in ``w.code`` of the first function of the current mode; see `Workspace`."""
    return 2 + FUNCTIONS if w.limits.sticker >= 0 and w.m[w.limits.sticker] > 0.5 else 2


@compiled(inline=True)
def prelude(w):
    """Recompute the values that depend on parameters and mode alone."""
    call_code(w.code[_variant(w)], w.p.ctypes.data, w.m.ctypes.data, w.aux.ctypes.data)
    if w.limits.linear == STRUCTURE:
        gather_structure(w)
    elif w.limits.linear:
        gather(w.aux, w.pattern, w.y.size - 1, w.filled, w.row, w.column, w.entry)


@compiled(inline=True)
def expand(w):
    """Compute all Taylor coefficients at the current state."""
    if w.limits.linear == STRUCTURE:
        structure_powers(w, w.c)
    elif w.limits.linear:
        powers(w.aux, w.filled, w.row, w.column, w.entry, w.newest, w.y, w.c)
    else:
        call_code(w.code[_variant(w) + 1], w.y.ctypes.data, w.aux.ctypes.data, w.c.ctypes.data)


@compiled(inline=True)
def probe(w):
    """Compute the first coefficients in the trial mode."""
    if w.limits.linear == STRUCTURE:
        structure_powers(w, w.probe)
    elif w.limits.linear:
        powers(w.aux, w.filled, w.row, w.column, w.entry, w.newest, w.y, w.probe)
    else:
        call_code(w.code[_variant(w) + 2], w.y.ctypes.data, w.aux.ctypes.data, w.probe.ctypes.data)


@compiled(inline=True)
def probe_trial(w):
    """Compute the first coefficients at the end of the trial step, in the current mode; of nonlinear equations."""
    call_code(w.code[_variant(w) + 2], w.trial.ctypes.data, w.aux.ctypes.data, w.probe.ctypes.data)


@compiled(inline=True)
def bound_unseen(w):
    """Bound the parts of the rows that the coefficients do not show while states and time stay in ``w.box``."""
    _bound(w, w.code[_variant(w) + 3], w.unseen)


@compiled
def bound_terms(w):
    """Compute the sizes of the terms of the rows while states and time stay in ``w.box``."""
    _bound(w, w.code[_variant(w) + 4], w.terms)


@compiled(inline=True)
def _bound(w, code, out):
    if code != 0:
        call_code(code, w.box.ctypes.data, w.aux.ctypes.data, out.ctypes.data)
    else:  # nothing is unseen in this mode
        out[:] = 0.0


@compiled(inline=True)
def measure(w, y, gauge):
    """Compute slips, their scales, and the couplings of the contacts at state and time y."""
    call_code(w.code[0], y.ctypes.data, w.p.ctypes.data, gauge.ctypes.data)
