"""Speeds at which a law bends without a break: a step that leaps over a narrow one would not see it."""

from collections.abc import Mapping

import sympy as sp

from symfric.model.laws import Law
from symfric.model.names import SPEED

_BENT = (sp.exp, sp.tanh, sp.atan, sp.erf, sp.log, sp.asinh, sp.cosh, sp.sinh)


def bends(law: Law, values: Mapping[sp.Symbol, float | None]) -> list[sp.Expr]:
    """Return the positive speeds at which the arguments of a law's functions vanish or turn, in its parameters.

    All events end there, so that the series of the next step begins where the law is steep or curved most: at v0 for
    ``exp(-((v - v0)/w)**2)``, ``tanh((v - v0)/w)`` and ``1/(1 + ((v - v0)/w)**2)``. The laws of the handbook have no
    such speed but zero.

    Parameters
    ----------
    law : Law
    values : mapping of Symbol to float or None
        Decide which speeds are real and positive; those without a number are left out.
    """
    given = {symbol: value for symbol, value in values.items() if value is not None}
    found: dict[float, sp.Expr] = {}
    for node in sp.preorder_traversal(law.kinetic):
        bent = isinstance(node, _BENT) or (node.is_Pow and not (node.exp.is_Integer and node.exp > 0))
        argument = node.args[0] if bent else sp.S.Zero
        if not argument.has(SPEED) or not argument.is_polynomial(SPEED):
            continue
        for curve in (argument, sp.diff(argument, SPEED)):
            for root in sp.roots(sp.Poly(curve, SPEED)):
                at = sp.N(root.subs(given))
                if at.is_number and at.is_real and at > 0:
                    found.setdefault(float(at), root)
    known = [sp.N(b.subs(given)) for b in law.breaks]
    return [
        root for at, root in sorted(found.items()) if not any(b.is_number and abs(at - b) <= 1e-9 * b for b in known)
    ]
