"""Effective friction: its characteristic, exactly and as a polynomial, (43)-(50)."""

from functools import cache

import sympy as sp

from derivations.ledger import Ledger
from derivations.residuals import less
from derivations.thomsen.model import (
    LAW,
    d,
    friction,
    mu_m,
    mu_s,
    v_m,
)
from derivations.thomsen.separation import INTENSITY, T_1, T, e, general_motion, q, shaken, v_r
from symfric.model.symbols import SPEED
from symfric.theory import belt

PART = Ledger("thomsen", "4.1: effective friction")

# --- 4.1.2 Calculating the effective friction characteristic ----------------------------------------------------------
ALPHA0, ALPHA1, ALPHA3 = belt.law_coefficients(symbolic=True)


@PART.verified(
    "(43)",
    "law (5) by powers, v_r > 0 and v_r < 0",
    *(side * ALPHA0 + ALPHA1 * v_r + ALPHA3 * v_r**3 for side in (1, -1)),
)
def _(*claims):
    return less([friction(v_r, side) for side in (1, -1)], claims)


@PART.verified("(44)", "alpha0, alpha1, alpha3", ALPHA0, ALPHA1, ALPHA3)
def _(*claims):
    found = [LAW.diff(SPEED, k).subs(SPEED, 0) / sp.factorial(k) for k in (0, 1, 3)]
    return less(found, claims)


# (45), (46): w = v_r - q cos T vanishes twice in a period if |v_r| < q. With v_r = q cos T_1 it is
#     w = 2 q sin((T + T_1)/2) sin((T - T_1)/2),
# where both angles are within (0, pi) for T_1 < T < 2 pi - T_1, and the second sine is negative for T < T_1.
@PART.verified(
    "(45)",
    "sign of v_r - q cos T between its zeros, and elsewhere",
    1,
    -1,
    numbers="the product exactly, its sign at 91 places",
)
def _(between, elsewhere):
    product = 2 * q * sp.sin((T + T_1) / 2) * sp.sin((T - T_1) / 2)
    left = [product - q * (sp.cos(T_1) - sp.cos(T))]
    for k in range(1, 8):
        for j in range(1, 16):
            if j not in (k, 16 - k):
                sign = sp.sign((product / q).subs({T_1: k * sp.pi / 8, T: j * sp.pi / 8}).evalf())
                left.append(sign - (between if k < j < 16 - k else elsewhere))
    return left


@PART.verified("(46)", "zeros of v_r - q cos T", sp.acos(v_r / q), 2 * sp.pi - sp.acos(v_r / q))
def _(*claims):
    found = sorted(sp.solve(v_r - q * sp.cos(T), T), key=lambda zero: zero.subs({v_r: 0, q: 1}))
    return less(found, claims)


# (47): (5) has one form for w > 0 and one for w < 0. Where w keeps its sign the mean is one integral; where it does
# not, the arcs [0, T_1], [T_1, 2 pi - T_1], [2 pi - T_1, 2 pi] are integrated one by one and T_1 is replaced by (46).
def over_a_period(f, side: int) -> sp.Expr:
    """Mean over T of f(sign of v_r - q cos T): |v_r| < q (side 0), v_r > q (1), v_r < -q (-1)."""

    def arc(low, high, sign):
        primitive = sp.integrate(sp.expand(f(sign)), T)
        return primitive.subs(T, high) - primitive.subs(T, low)

    if side:
        total = arc(0, 2 * sp.pi, side)
    else:
        total = arc(0, T_1, -1) + arc(T_1, 2 * sp.pi - T_1, 1) + arc(2 * sp.pi - T_1, 2 * sp.pi, -1)
    return sp.expand(sp.expand(total / (2 * sp.pi)).subs(T_1, sp.acos(v_r / q)))


@cache
def effective(side: int) -> sp.Expr:
    """<mu(v_r - q cos T)> for law (5), sides as in `over_a_period`."""
    return over_a_period(lambda sign: friction(v_r - q * sp.cos(T), sign), side)


@PART.verified(
    "(47) line 1",
    "effective friction for |v_r| <= a Omega",
    ALPHA0 * (1 - 2 / sp.pi * sp.acos(v_r / INTENSITY))
    + (ALPHA1 + sp.Rational(3, 2) * ALPHA3 * INTENSITY**2) * v_r
    + ALPHA3 * v_r**3,
)
def _(claim):
    return effective(0) - shaken(claim)


@PART.verified(
    "(47) line 2",
    "effective friction for v_r >= a Omega and v_r <= -a Omega",
    *(friction(v_r, side) + sp.Rational(3, 2) * ALPHA3 * INTENSITY**2 * v_r for side in (1, -1)),
)
def _(*claims):
    return less([effective(side) for side in (1, -1)], map(shaken, claims))


def pieces(formula) -> tuple[sp.Expr, ...]:
    """Branches of a closed form below and above a Omega."""
    return tuple(branch.expr for branch in sp.piecewise_fold(formula).args)


def differences(found, claims) -> list[sp.Expr]:
    """Residuals of claims in a and Omega; inverse cosines are brought to inverse sines, which are odd."""
    return [left.rewrite(sp.asin) for left in less(found, map(shaken, claims))]


@PART.verified(
    "(47) both lines",
    "effective friction as the package computes it",
    *pieces(belt.effective_friction(symbolic=True).kinetic),
)
def _(*claims):
    return differences((effective(0), effective(1)), [c.subs(SPEED, v_r) for c in claims])


@PART.verified(
    "after (47)",
    "effective less true friction for v_r > a Omega: larger",
    sp.Rational(3, 4) * INTENSITY**2 * (mu_s - mu_m) * v_r / v_m**3,
)
def _(claim):
    return effective(1) - friction(v_r, 1) - shaken(claim)


# --- 4.1.3 Effective friction characteristic in polynomial form -------------------------------------------------------
HAT1 = 2 * ALPHA0 / (sp.pi * INTENSITY) + ALPHA1 + sp.Rational(3, 2) * ALPHA3 * INTENSITY**2
HAT3 = ALPHA3 + ALPHA0 / (3 * sp.pi * INTENSITY**3)


def slope_at_rest(order: int) -> sp.Expr:
    """Taylor coefficient of the effective friction for |v_r| < q."""
    return effective(0).diff(v_r, order).subs(v_r, 0) / sp.factorial(order)


@PART.verified("(48)", "series of the effective friction up to v_r^4", HAT1 * v_r + HAT3 * v_r**3)
def _(claim):
    return sp.series(effective(0), v_r, 0, 5).removeO() - shaken(claim)


@PART.verified(
    "(49)",
    "its linear and cubic coefficients",
    belt.effective_damping(symbolic=True),
    belt.effective_cubic(symbolic=True),
)
def _(*claims):
    return less([slope_at_rest(k) for k in (1, 3)], map(shaken, claims))


@PART.verified(
    "(50)",
    "the same in mu_s, mu_m, v_m",
    2 / sp.pi * mu_s / INTENSITY + sp.Rational(3, 2) * (mu_s - mu_m) / v_m * ((INTENSITY / v_m) ** 2 / 2 - 1),
    mu_s / (3 * sp.pi * INTENSITY**3) + (mu_s - mu_m) / (2 * v_m**3),
)
def _(*claims):
    return less([slope_at_rest(k) for k in (1, 3)], map(shaken, claims))


S = sp.Symbol("s", positive=True)


# What (48) leaves out belongs to the jump alone: (2 mu_s/pi)(asin s - s - s^3/6), s = v_r/q, whatever mu_m and v_m.
@PART.verified(
    "after (50) accuracy",
    "(47) less (48) at v_r = s a Omega; at s = 1, in thousandths of mu_s",
    2 * mu_s / sp.pi * (sp.asin(S) - S - S**3 / 6),
    257,
    note="'reasonable accuracy' for |v_r| <= a Omega: .4 % of mu_s at s = 1/2, 2.7 % at 3/4, a quarter at the end, "
    "where the slope of (47) is infinite",
)
def _(claim, end):
    left = (effective(0) - shaken(HAT1 * v_r + HAT3 * v_r**3)).subs(v_r, S * q)
    left = (left - claim).replace(sp.acos, lambda cosine: sp.pi / 2 - sp.asin(cosine))
    return sp.expand(left), round(1000 * float(claim.subs({S: 1, mu_s: 1}))) - end


@PART.verified("after (50) first term", "damping coefficient of Coulomb friction", 2 * mu_s / (sp.pi * INTENSITY))
def _(claim):
    return slope_at_rest(1).subs(mu_m, mu_s) - shaken(claim)


# The damping coefficient goes to infinity for q -> 0 and for q -> oo; its derivative has one zero in between.
LEAST = 4 / (3 * sp.pi * (1 - mu_m / mu_s))


@cache
def least_intensity_cubed() -> sp.Expr:
    """q^3 where the damping coefficient at rest is least."""
    cube = sp.Symbol("cube", positive=True)
    (found,) = sp.solve(sp.expand(slope_at_rest(1).diff(q) * q**2).subs(q**3, cube), cube)
    return found


@PART.corrected(
    "after (50) minimum",
    "intensity of least damping: its cube, and itself",
    right=(v_m**3 * LEAST, belt.least_damping_intensity(symbolic=True)),
    printed=(LEAST, sp.cbrt(LEAST)),
    note="the factor v_m^3 is missing: the cube of a velocity cannot be a ratio of coefficients",
)
def _(cubed, intensity):
    found = least_intensity_cubed().subs(mu_s, mu_m + d)
    stated = [c.subs(mu_s, mu_m + d) for c in (cubed, intensity)]
    return found - stated[0], sp.cbrt(found) - stated[1]


# alpha3-hat > 0, so (48) is steepest away from v_r = 0 and rises everywhere if and only if alpha1-hat > 0; how small
# mu_m/mu_s may become is said after (52).


# The example of figures 4 and 8, a = 0.01 and Omega = 50.
@PART.verified(
    "4.1.4", "amplitudes of the fast displacement and velocity in figure 8", sp.Rational(1, 100), sp.Rational(1, 2)
)
def _(*claims):
    motion = (e * general_motion().subs(e, 0)).subs({q: sp.Rational(1, 2), e: sp.Rational(1, 50)})
    largest = [abs(motion.subs(T, sp.pi / 2)), abs((motion.diff(T) * 50).subs(T, 0))]
    return less(largest, claims)
