"""Sprung foundation mass under a main mass that excites itself: Tondl's second device, named by Thomsen in section 1.

Letters: mu = m2/m1, kappa = k2/k1, gamma = c2/(2 m1 omega1), b = -c1/(m1 omega1) > 0; time in units of 1/omega1.
"""

from functools import cache

import numpy as np
import sympy as sp

from derivations.ledger import Ledger
from derivations.residuals import agree
from symfric.theory import foundation

LEDGER = Ledger(
    "foundation",
    "A visco-elastically mounted foundation mass (A. Tondl, Quenching of self-excited vibrations, 1991, as named by "
    "Thomsen, section 1); formulas as `symfric.theory.foundation` has them.",
)

mu, kappa, gamma = foundation.SYMBOLS
b, c, d, e, s = sp.symbols("b c d e s", positive=True)
P = sp.Symbol("p", positive=True)
SHORT = {kappa: mu * d - 1, gamma: mu * c / 2}  # e = 1/mu, d = (1 + kappa)/mu, c = 2 gamma/mu


@cache
def characteristic():
    """Coefficients a1 ... a4 of the characteristic polynomial, from Newton's law."""
    main = s**2 - b * s + 1
    base = mu * s**2 + 2 * gamma * s + kappa + 1
    polynomial = sp.expand(((main * base - 1) / mu).subs(SHORT))
    return [sp.expand(k) for k in sp.Poly(polynomial, s).all_coeffs()[1:]]


@LEDGER.verified("characteristic polynomial", "a1 ... a4 with e = 1/mu", c - b, d + 1 - b * c, c - b * d, d - e)
def _(*claim):
    return [(found - k.subs(e, 1 / mu)).subs(e, 1 / mu) for found, k in zip(characteristic(), claim, strict=True)]


# Stable if and only if a1, a3, a4 > 0 and a1 a2 a3 > a3^2 + a1^2 a4. With r = a3/a1, the squared frequency at the
# limit, that is a2 > r + a4/r. For given d the ratio r fixes c = b (r - d)/(r - 1), and what is left is a bound on b^2.
r = sp.Symbol("r", positive=True)


def bound_of(ratio):
    """Return b^2 at the limit a2 = r + a4/r."""
    square = sp.Symbol("square", positive=True)
    damper = (ratio - d) / (ratio - 1)  # c over b
    (found,) = sp.solve(d + 1 - square * damper - ratio - (d - e) / ratio, square)
    return sp.factor(found)


@LEDGER.verified(
    "limit of stability",
    "b^2 at the limit with r = 1 - p; c over b there",
    P * (e - P * (d - 1 + P)) / ((d - 1 + P) * (1 - P)),
    (d - 1 + P) / P,
)
def _(square, damper):
    ratio = sp.solve((c - b * d) - (1 - P) * (c - b), c)[0] / b
    return sp.simplify(bound_of(1 - P) - square), sp.simplify(ratio - damper)


# Which d is best? For d > 1, 0 < p < 1, b^2 falls with d; so d is as small as it may be: 1 if e <= 1, else e.
@LEDGER.verified(
    "smallest d",
    "derivative of b^2 by d: negative for 0 < p < 1",
    -P * e / ((d - 1 + P) ** 2 * (1 - P)),
)
def _(claim):
    square = P * (e - P * (d - 1 + P)) / ((d - 1 + P) * (1 - P))
    return sp.simplify(square.diff(d) - claim)


# d < 1 needs r > 1, p = -h < 0, and gives less: b^2 = (e - h (h + 1 - d)) h/((1 + h)(h + 1 - d)) < e, because
# h < h + 1 - d, while d = 1 allows 2 (1 - sqrt(1 - e)) >= e.
h = sp.Symbol("h", positive=True)


@LEDGER.verified(
    "softer than in tune",
    "b^2 with r = 1 + h, d < 1; what e exceeds it by, over positive factors; what the optimum exceeds e by",
    h * (e - h * (h + 1 - d)) / ((h + 1 - d) * (1 + h)),
    e * (1 - d) + h * (h + 1 - d) * (e + h),
    (1 - sp.sqrt(1 - e)) ** 2,
)
def _(square, excess, more):
    limit = bound_of(1 + h)
    over = sp.simplify((e - limit) * (h + 1 - d) * (1 + h))
    best = 2 * (1 - sp.sqrt(1 - e)) - e
    return sp.simplify(limit - square), sp.expand(over - excess), sp.expand(best - more)


@LEDGER.verified(
    "heavy foundation",
    "best p for d = 1, mu >= 1; b^2 there; stiffness, and damping over value",
    1 - sp.sqrt(1 - e),
    2 * (1 - sp.sqrt(1 - e)),
    mu - 1,
    mu,
)
def _(place, square, stiffness, damping):
    size = sp.Symbol("S", positive=True)  # sqrt(1 - e)
    limit = ((e - P**2) / (1 - P)).subs(e, 1 - size**2)
    stationary = sp.solve(sp.numer(sp.together(limit.diff(P))), P)
    inside = [f for f in stationary if sp.simplify(f - (1 - size)) == 0]
    best = sp.simplify(limit.subs(P, 1 - size))
    formula = foundation.widest_stability(symbolic=True)
    heavy = {name: getattr(formula, name).args[0].expr for name in ("stiffness", "damping", "value")}
    root = place.subs(e, 1 - size**2)
    return (
        sp.simplify((inside[0] if inside else sp.oo) - root),
        sp.simplify(best - square.subs(e, 1 - size**2)),
        sp.simplify(4 * heavy["value"] ** 2 - square.subs(e, 1 / mu)),
        sp.expand(heavy["stiffness"] - stiffness),
        sp.expand(sp.solve(mu * 1 - (1 + kappa), kappa)[0] - stiffness),  # d = 1
        sp.simplify(heavy["damping"] / heavy["value"] - damping),
    )


@LEDGER.verified(
    "light foundation",
    "b^2 for d = e >= 1, kappa = 0; numerator of its derivative by p: positive; its limit at p = 1, value^2 times 4",
    P * (e + P) / (e - 1 + P),
    e * (e - 1) + 2 * P * (e - 1) + P**2,
    1 + 1 / e,
)
def _(square, slope, limit):
    found = (P * (e - P * (d - 1 + P)) / ((d - 1 + P) * (1 - P))).subs(d, e)
    formula = foundation.widest_stability(symbolic=True).value.args[1].expr
    return (
        sp.simplify(found - square),
        sp.expand(sp.numer(sp.together(square.diff(P))) - slope) if square.has(P) else square,
        sp.simplify(square.subs(P, 1) - limit),
        sp.simplify(4 * formula**2 - limit.subs(e, 1 / mu)),
    )


@LEDGER.verified(
    "in tune",
    "with d = 1: a3 - a1; what the Hurwitz determinant leaves of a1^2; the bound on b^2 where c = b",
    0,
    e - b * c,
    e,
)
def _(same, left, bound):
    a1, a2, a3, a4 = (k.subs(mu, 1 / e).subs(d, 1) for k in characteristic())
    condition = sp.expand(a1 * a2 * a3 - a3**2 - a1**2 * a4)
    # c lies above b, where a1 > 0, and below the zero of what is left; the range closes where both meet
    return (
        sp.expand(a3 - a1 - same),
        sp.expand(condition - a1**2 * left),
        sp.expand((e - b * c).subs(c, b) - bound + b**2),
    )


POINTS = ((0.1, 0.2), (0.5, 1.5), (2.0, 0.3), (4.0, 8.0))


@LEDGER.verified(
    "given stiffness",
    "how much the best damping stabilises, and this damping, for mu, kappa = (.1, .2), (.5, 1.5), (2, .3), (4, 8)",
    *(sp.Float(e) for point in POINTS for e in foundation.at_stiffness(*point)[:0:-1]),
    numbers="8 and 5 digits, by search over the damping with eigenvalues",
)
def _(*claim):
    from scipy.optimize import brentq, minimize_scalar

    def stabilised(point, damping):
        def rate(beta):
            m, k = point
            A = np.array([[0, 0, 1, 0], [0, 0, 0, 1], [-1, 1, 2 * beta, 0], [1 / m, -(1 + k) / m, 0, -2 * damping / m]])
            return -np.max(np.linalg.eigvals(A).real)

        return brentq(rate, 0.0, 2.0, xtol=1e-12) if rate(0.0) > 0 else 0.0

    found = []
    for point in POINTS:
        grid = np.geomspace(0.05, 30, 90)
        k = int(np.argmax([stabilised(point, g) for g in grid]))
        ends = (grid[k - 1], grid[k + 1])
        best = minimize_scalar(
            lambda g, p=point: -stabilised(p, g), bounds=ends, method="bounded", options={"xatol": 1e-9}
        )
        found += [(-best.fun, 8), (best.x, 5)]
    return [agree(sp.Float(f), given, digits=n) for (f, n), given in zip(found, claim, strict=True)]


@LEDGER.verified(
    "against the absorber",
    "mass ratio at which both stabilise equally much",
    sp.Float(foundation.break_even()),
    numbers="12 digits",
)
def _(claim):
    from derivations.absorber import SYMBOLIC
    from derivations.absorber import mu as ratio

    both = SYMBOLIC["stable"].value.subs(ratio, s) - foundation.widest_stability(symbolic=True).value.args[0].expr.subs(
        mu, s
    )
    return agree(sp.nsolve(both, s, (1.05, 1.5), solver="bisect", prec=20), claim)
