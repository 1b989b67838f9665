"""Calls of the machine code of a model, in the current mode of a workspace."""

from symfric.codegen.array_table import Matrix, Reals
from symfric.codegen.numba_types import call_code, compiled
from symfric.solve.loop.codes import FUNCTIONS, GAUGE, PRELUDE, PROBE, ROW_TERMS, SERIES, STRUCTURE, UNSEEN, VARIANTS
from symfric.solve.loop.stepping.powers import gather, powers
from symfric.solve.loop.stepping.structure_powers import gather_structure, structure_powers
from symfric.solve.loop.workspace import LoopArrays


@compiled(inline=True)
def _variant(w: LoopArrays) -> int:
    """Return the index in ``w.code`` of the first function of the current mode; see `symfric.solve.loop.codes`."""
    return VARIANTS + FUNCTIONS if w.limits.sticker >= 0 and w.m[w.limits.sticker] > 0.5 else VARIANTS


@compiled(inline=True)
def prelude(w: LoopArrays) -> None:
    """Recompute the values that depend on parameters and mode alone."""
    call_code(w.code[_variant(w) + PRELUDE], w.p.ctypes.data, w.m.ctypes.data, w.aux.ctypes.data)
    if w.limits.linear == STRUCTURE:
        gather_structure(w)
    elif w.limits.linear:
        gather(w.aux, w.matrices.pattern, w.y.size - 1, w.powers)


@compiled(inline=True)
def expand(w: LoopArrays) -> None:
    """Compute all Taylor coefficients at the current state."""
    _compute(w, SERIES, w.c)


@compiled(inline=True)
def probe(w: LoopArrays) -> None:
    """Compute the first coefficients in the trial mode."""
    _compute(w, PROBE, w.probe)


@compiled(inline=True)
def _compute(w: LoopArrays, function: int, c: Matrix) -> None:
    if w.limits.linear == STRUCTURE:
        structure_powers(w, c)
    elif w.limits.linear:
        powers(w.aux, w.powers, w.y, c)
    else:
        call_code(w.code[_variant(w) + function], w.y.ctypes.data, w.aux.ctypes.data, c.ctypes.data)


@compiled(inline=True)
def probe_trial(w: LoopArrays) -> None:
    """Compute the first coefficients at the end of the trial step, in the current mode; of nonlinear equations."""
    call_code(w.code[_variant(w) + PROBE], w.step.end.ctypes.data, w.aux.ctypes.data, w.probe.ctypes.data)


@compiled(inline=True)
def may_hide(w: LoopArrays) -> bool:
    """Whether anything may be unseen in the coefficients of a step in the current mode."""
    return bool(w.code[_variant(w) + UNSEEN] != 0)


@compiled(inline=True)
def bound_unseen(w: LoopArrays) -> None:
    """Bound the parts of the rows that the coefficients do not show while states and time stay in ``w.step.box``."""
    _bound(w, w.code[_variant(w) + UNSEEN], w.step.unseen)


@compiled
def bound_terms(w: LoopArrays) -> None:
    """Compute the sizes of the terms of the rows while states and time stay in ``w.step.box``."""
    _bound(w, w.code[_variant(w) + ROW_TERMS], w.step.terms)


@compiled(inline=True)
def _bound(w: LoopArrays, code: int, out: Reals) -> None:
    call_code(code, w.step.box.ctypes.data, w.aux.ctypes.data, out.ctypes.data)


@compiled(inline=True)
def measure(w: LoopArrays, y: Reals, gauge: Matrix) -> None:
    """Compute slips, their scales, and the couplings of the contacts at state and time y."""
    call_code(w.code[GAUGE], y.ctypes.data, w.p.ctypes.data, gauge.ctypes.data)
