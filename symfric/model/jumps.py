"""Expressions with jumps are refused: dry friction is a contact."""

import sympy as sp

from symfric.errors import SceneError
from symfric.model.tree import parts_of, replaced

JUMPS = (sp.sign, sp.Heaviside, sp.DiracDelta, sp.floor, sp.ceiling, sp.Mod, sp.frac)


def refuse_jumps(expr: sp.Expr, what: str) -> None:
    """Raise if the expression has a jump; friction enters only through `Contact`."""
    jumps = [e for e in parts_of(expr, sp.Function, sp.Mod) if isinstance(e, JUMPS)] or _hidden_signs(expr)
    if jumps:
        raise SceneError(f"{what} contains {jumps[0]}, which jumps; dry friction enters as a Contact with a law")


def _hidden_signs(expr: sp.Expr) -> list[sp.Expr]:
    """Return the quotients in `expr` that equal a sign: a/Abs(a), Abs(a)/a, a/sqrt(a**2)."""
    if not any(isinstance(e, sp.Abs) or abs(e.exp) == sp.Rational(1, 2) for e in parts_of(expr, sp.Abs, sp.Pow)):
        return []
    real = {s: sp.Symbol(s.name, real=True) for s in expr.free_symbols if s.is_extended_real is None}
    quotients = []
    for product in parts_of(replaced(expr, real), sp.Mul):
        power = dict(factor.as_base_exp() for factor in product.args)
        pairs = [(power.get(e.args[0], sp.Integer(0)), n) for e, n in power.items() if isinstance(e, sp.Abs)]
        if any(m.is_odd and m + n == 0 for m, n in pairs):
            quotients.append(product)
    return sorted(quotients, key=str)
