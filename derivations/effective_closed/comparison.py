"""How two formulas for a mean are compared: 25 digits, at points around v = q."""

import itertools
from functools import cache

import mpmath
import sympy as sp

from derivations.effective_friction import (
    QUADRATURES,
    alpha,
    b,
    branch,
    c,
    integrand,
    mu,
    mu_s,
    q,
    s,
    v,
)
from derivations.residuals import agree

DIGITS = 34
HELD = "against the package's integrals, 25 digits"
SIGNS = "signs at two places, 15 digits"

VALUES = {q: "3/10", mu: "2/5", mu_s: "1/2", b: "1/7", alpha: "-1/5"}
POINTS = [
    {v: sp.Rational(at), c: sp.Rational(wide), **{symbol: sp.Rational(text) for symbol, text in VALUES.items()}}
    for at, wide in itertools.product(("1/10", "29/100", "3/10", "2/5"), ("1/4", "2/3"))
]
BELOW = [at for at in POINTS if at[v] < at[q]]
FROM_Q = [at for at in POINTS if at[v] >= at[q]]


def digits(expr, at):
    """Evaluate an expression that may hold integrals over 0 < s < 1."""
    return _digits(expr, tuple(at.items()))


@cache
def _digits(expr, at):
    expr = expr.subs(dict(at))
    with mpmath.workdps(DIGITS):
        if not expr.has(sp.Integral):
            return expr.evalf(DIGITS)
        return sp.sympify(mpmath.quad(sp.lambdify(s, integrand(expr), "mpmath", cse=True), [0, 0.5, 1]))


def gap(derived, claim, points):
    """0 if two formulas have 25 digits in common at every point, or the first difference."""
    gaps = (agree(digits(derived, at), digits(claim, at), 25) for at in points)
    return next((e for e in gaps if e != 0), sp.Integer(0))


def disagreement(claim, law, points):
    """What is left of a claim by the package's mean."""
    return gap(law.averaged(q).kinetic, claim, points)


def slope_disagreement(claim, law):
    """The same for the slope at rest."""
    slope = branch(law.averaged(q).kinetic, {v: 1, q: 2}).diff(v)
    return gap(slope, claim, [{**at, v: 0} for at in BELOW[:2]])


LORENTZ_LAW, GAUSS_LAW, ROOT_LAW, STRIBECK_LAW = (law for law, _ in itertools.islice(QUADRATURES.values(), 4))
MEAN_OF_LINE_AND_JUMP = mu * 2 / sp.pi * sp.asin(v / q) + b * v  # of mu + b w, by 2.1, for v < q
