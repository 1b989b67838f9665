"""Forces from energies with kinks: continuous derivatives, written without `sign`.

SymPy's derivative of ``Abs(x)**3`` is ``3 x**2 sign(x)``, continuous although one factor jumps; here it becomes
``3 x Abs(x)``. Where the force itself jumps it is refused.
"""

from collections.abc import Callable

import sympy as sp

from symfric.errors import SceneError
from symfric.model.validation import check_continuous

CURES = {
    "potential": "smooth the kink of the energy",
    "kinetic": "smooth the kink of the energy",
    "dissipation": "dry friction enters as a Contact with a law",
}


def gradient(energy: sp.Expr, variable: sp.Symbol, what: str, cure: str) -> sp.Expr:
    """Return the derivative of an energy with respect to a real variable; it may have kinks, but no jumps.

    Parameters
    ----------
    energy : Expr
        May hold Abs, Max, Min and Piecewise.
    variable : Symbol
    what : str
        What it is: "kinetic", "potential", "dissipation".
    cure : str
        What to do where the derivative jumps.

    Raises
    ------
    SceneError
        If the derivative jumps; it names the place and the cure.
    """
    check_continuous(energy, {}, what, variable)
    plain, extremes = with_magnitudes(energy)
    pieces = [term for term in sp.Add.make_args(plain) if term.has(sp.Piecewise)]
    parts = [plain - sp.Add(*pieces), *map(sp.piecewise_fold, pieces)]
    slope = sp.Add(*(without_signs(part.diff(variable), f"d {what}/d {variable}", cure) for part in parts))
    slope = sp.expand(slope.xreplace(extremes)) if extremes else slope
    check_continuous(slope, {}, f"d {what}/d {variable}", variable)
    return slope


def with_magnitudes(energy: sp.Expr) -> tuple[sp.Expr, dict[sp.Expr, sp.Expr]]:
    """Rewrite Max and Min with Abs (two arguments) or Piecewise (more); return also the inverse substitution."""
    extremes = {}

    def rewritten(func: Callable[..., sp.Expr], way: int) -> Callable[..., sp.Expr]:
        def replace(*arguments: sp.Expr) -> sp.Expr:
            if len(arguments) > 2:
                beyond = [[way * (a - b) >= 0 for b in arguments[i + 1 :]] for i, a in enumerate(arguments)]
                pieces = [(a, sp.And(*c)) for a, c in zip(arguments[:-1], beyond, strict=False)]
                return sp.Piecewise(*pieces, (arguments[-1], True))
            a, b = arguments
            magnitude = sp.Abs(a - b)
            if isinstance(magnitude, sp.Abs) and not energy.has(magnitude):
                extremes[magnitude] = way * (2 * func(a, b) - a - b)
            return (a + b + way * magnitude) / 2

        return replace

    return energy.replace(sp.Max, rewritten(sp.Max, 1)).replace(sp.Min, rewritten(sp.Min, -1)), extremes


def without_signs(expr: sp.Expr, what: str, cure: str) -> sp.Expr:
    """Remove each `sign` of an expression whose cofactor vanishes with its argument."""
    if isinstance(expr, sp.Piecewise):
        return sp.Piecewise(*((without_signs(e, what, cure), condition) for e, condition in expr.args))
    signs = sorted(expr.atoms(sp.sign), key=lambda e: (-e.count_ops(), str(e)))
    for sign in signs:
        expr = _without_sign(expr, sign.args[0], what, cure)
    return expr


def _without_sign(expr: sp.Expr, a: sp.Expr, what: str, cure: str) -> sp.Expr:
    """Write ``f + g sign(a)``, where g = A H + a K with A = Abs(a), as ``f + a H + A K``."""
    magnitude, side = sp.Dummy("A", positive=True), sp.Dummy("s", real=True)
    split = expr.xreplace({sp.sign(a): side}).xreplace({sp.Abs(a): magnitude})
    positive, negative = split.subs(side, 1), split.subs(side, -1)
    mean, jump = (positive + negative) / 2, (positive - negative) / 2
    at_zero = jump.subs(magnitude, 0)
    odd = sp.cancel(sp.expand(at_zero) / a)
    if _vanishes_with(sp.fraction(sp.together(odd))[1], a):
        raise SceneError(f"{what} jumps where {a} = 0; {cure}")
    even = sp.cancel(sp.expand(jump - at_zero) / magnitude)
    back = {magnitude: sp.Abs(a)}
    if sp.fraction(sp.together(even))[1].has(magnitude):
        below, above = (e.xreplace({magnitude: way * a}) for e, way in ((negative, -1), (positive, 1)))
        return sp.Piecewise((below, a < 0), (above, True))
    return (sp.expand(mean) + a * even + magnitude * odd).xreplace(back)


def _vanishes_with(divisor: sp.Expr, a: sp.Expr) -> bool:
    """Whether an expression is zero wherever `a` is; decided exactly where `a` is linear in one of its symbols."""
    if divisor.is_number:
        return bool(divisor.is_zero)
    for s in sorted(a.free_symbols, key=str):
        if a.is_polynomial(s) and sp.degree(a, s) == 1:
            return bool(sp.simplify(divisor.subs(s, sp.solve(a, s)[0])).is_zero)
    return bool(divisor.free_symbols & a.free_symbols)


def simplified(expr: sp.Expr) -> sp.Expr:
    """Simplify an expression without rewriting its kinks, which SymPy would turn into signs and conditions with Eq."""
    kinks = {e: sp.Dummy(real=True) for e in expr.atoms(sp.Abs, sp.Max, sp.Min, sp.Piecewise)}
    outermost = dict(sorted(kinks.items(), key=lambda pair: -pair[0].count_ops()))
    masked = expr
    for e, mask in outermost.items():
        masked = masked.xreplace({e: mask})
    return sp.simplify(masked).xreplace({mask: e for e, mask in kinks.items()})
