"""Steps in time: functions of time that jump become a Piecewise whose conditions change at known instants.

A jump at an instant is harmless where one at a place or a speed is not: whether and when it happens does not depend on
the motion. So every function that jumps with time is written in one form, and a condition on the phase ``Mod(t, T)`` as
one on sines, which has a root wherever the phase passes the bound:

    Mod(s, T) < d   <=>   sin(pi s/T) sin(pi (d - s)/T) > 0   for 0 <= d <= T.

The two sines are held as signs of their own, see `symfric.model.alternations`.
"""

import numpy as np
import sympy as sp
from sympy.core.relational import Relational

from symfric.errors import SceneError
from symfric.model.numeric import numeric_function
from symfric.model.symbols import TIME
from symfric.model.tables import Table
from symfric.model.tree import parts_of

STEPPED = (sp.Heaviside, sp.sign)
STAIRS = (sp.floor, sp.ceiling, sp.frac, sp.Mod)
_SEED = 19
_ORDERS = (sp.StrictLessThan, sp.LessThan, sp.StrictGreaterThan, sp.GreaterThan)


def with_steps(expr: sp.Expr, what: str) -> sp.Expr:
    """Return an expression with its jumps in time written as a Piecewise; all else stays as it is.

    Parameters
    ----------
    expr : Expr
    what : str
        What the expression is, for messages.

    Raises
    ------
    SceneError
        If time stands in a function that jumps and has no such form.

    Examples
    --------
    >>> import sympy as sp
    >>> from symfric.model.symbols import TIME
    >>> with_steps(3 * sp.Heaviside(TIME - 2), "force[0]")
    3*Piecewise((0, t < 2), (1, True))
    >>> with_steps(sp.Piecewise((1, sp.Mod(TIME, 2) < 1), (0, True)), "force[0]")
    Piecewise((1, sin(pi*t/2)*sin(pi*(1/2 - t/2)) > 0), (0, True))
    """
    if TIME not in expr.free_symbols:
        return expr
    conditions = {c for p in parts_of(expr, sp.Piecewise) for _, c in p.args for c in parts_of(c, Relational)}
    phases = {c: _on_phase(c, what) for c in conditions if c.has(sp.Mod) and TIME in c.free_symbols}
    expr = expr.xreplace(phases) if phases else expr
    jumps = sorted((e for e in parts_of(expr, *STEPPED) if TIME in e.free_symbols), key=lambda e: e.count_ops())
    for e in jumps:  # the inner ones first; what is left of an outer one is found by the call below
        low = sp.S.Zero if isinstance(e, sp.Heaviside) else sp.S.NegativeOne
        return with_steps(expr.xreplace({e: sp.Piecewise((low, e.args[0] < 0), (1, True))}), what)
    _refuse_others(expr, what)
    return expr


def _on_phase(condition: Relational, what: str) -> Relational:
    """Return a condition on a phase as one on sines."""
    cure = f"{what} contains the condition {condition}; write it as sympy.Mod(sf.TIME - a, T) < d"
    if not isinstance(condition, _ORDERS):
        raise SceneError(cure)
    (lhs, phase), bound = condition.lhs.as_coeff_Mul(), condition.rhs
    below = isinstance(condition, sp.StrictLessThan | sp.LessThan)
    if not isinstance(phase, sp.Mod):
        (lhs, phase), bound, below = condition.rhs.as_coeff_Mul(), condition.lhs, not below
    if not (isinstance(phase, sp.Mod) and lhs > 0):
        raise SceneError(cure)
    (s, period), bound = phase.args, bound / lhs
    if TIME in (bound.free_symbols | period.free_symbols | s.diff(TIME).free_symbols):
        raise SceneError(cure)
    width = bound if bound.is_number and period.is_number and 0 <= bound <= period else sp.Max(0, sp.Min(bound, period))
    wave = sp.sin(sp.pi * s / period) * sp.sin(sp.pi * (width - s) / period)
    return wave > 0 if below else wave < 0


def _refuse_others(expr: sp.Expr, what: str) -> None:
    kick = next((e for e in parts_of(expr, sp.DiracDelta) if TIME in e.free_symbols), None)
    if kick is not None:
        raise SceneError(f"{what} contains {kick}, an impulse; give a force of finite length, such as a short pulse")
    others = parts_of(expr, *STAIRS)
    stairs = next((e for e in sorted(others, key=str) if TIME in e.free_symbols), None)
    if stairs is not None:
        raise SceneError(
            f"{what} contains {stairs}, which jumps for ever; write a Piecewise of sf.TIME, a sf.Signal, or the "
            "condition sympy.Mod(sf.TIME - a, T) < d of a Piecewise"
        )


def jumps_in_time(expr: sp.Expr) -> bool:
    """Whether a Piecewise in an expression jumps where a condition on time changes; ramps do not.

    Examples
    --------
    >>> import sympy as sp
    >>> from symfric.model.symbols import TIME
    >>> ramp = sp.Piecewise((TIME, TIME < 1), (1, True))
    >>> jumps_in_time(ramp), jumps_in_time(1 - 2 * sp.Piecewise((0, TIME < 1), (1, True)))
    (False, True)
    """
    if TIME not in expr.free_symbols:
        return False
    for piecewise in parts_of(expr, sp.Piecewise):
        relations = {r for _, c in piecewise.args for r in parts_of(c, Relational) if TIME in r.free_symbols}
        for boundary in (r.lhs - r.rhs for r in relations):
            if not (boundary.is_polynomial(TIME) and sp.degree(boundary, TIME) <= 2):
                return True
            try:
                compare_across(piecewise, boundary, TIME, "")
            except SceneError:
                return True
    return False


def compare_across(piecewise: sp.Piecewise, boundary: sp.Expr, unknown: sp.Symbol, what: str) -> None:
    """Raise if a Piecewise jumps at a boundary, for three random values of all symbols but `unknown`."""
    rng = np.random.default_rng(_SEED)
    others = sorted((piecewise.free_symbols | boundary.free_symbols) - {unknown}, key=str)
    evaluate = numeric_function((unknown, *others), piecewise)
    for _ in range(3):
        point = dict(zip(others, rng.uniform(0.5, 1.5, len(others)), strict=True))
        coefficients = [complex(c) for c in sp.Poly(boundary.xreplace(point), unknown).all_coeffs()]
        roots = np.roots(coefficients) if np.all(np.isfinite(coefficients)) else np.zeros(0)
        for root in (r.real for r in roots if abs(r.imag) < 1e-12 and not (unknown.is_positive and r.real <= 0)):
            step = 1e-7 * max(1.0, abs(root))
            at = [float(evaluate(root + d, *point.values())) for d in (-2 * step, -step, step, 2 * step)]
            slope = max(abs(at[1] - at[0]), abs(at[3] - at[2]))
            if abs(at[2] - at[1]) > 20 * slope + 1e-9 * max(1.0, abs(at[1])):
                raise _jump(what, at[2] - at[1], unknown, root)


def check_lines(table: Table, what: str) -> bool:
    """Raise if a table of straight lines in numbers jumps; return whether it is one.

    The lines are compared as `compare_across` compares functions.
    """
    if table.lines is None or not all(e.is_number for line in table.lines for e in line):
        return False
    values, slopes = np.array(table.lines, dtype=float).T
    at = np.array(table.breaks, dtype=float)
    before, after = values[:-1] + slopes[:-1] * at, values[1:] + slopes[1:] * at
    steep = 1e-7 * np.maximum(1.0, np.abs(at)) * np.maximum(np.abs(slopes[:-1]), np.abs(slopes[1:]))
    for k in np.flatnonzero(np.abs(after - before) > 20 * steep + 1e-9 * np.maximum(1.0, np.abs(before))):
        raise _jump(what, after[k] - before[k], table.argument, at[k])
    return True


def _jump(what: str, size: float, unknown: sp.Symbol, root: float) -> SceneError:
    return SceneError(
        f"{what} jumps by {size:.3g} at {unknown} = {root:.6g}; "
        "a Piecewise must be continuous, and jumps of friction are contacts"
    )
