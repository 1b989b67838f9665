"""Means of the laws of Gauss and Stribeck, and of exponential decay."""

import sympy as sp

from derivations.effective_closed.comparison import (
    FROM_Q,
    GAUSS_LAW,
    HELD,
    SIGNS,
    STRIBECK_LAW,
    disagreement,
    slope_disagreement,
)
from derivations.effective_closed.lorentz import changes_sign, slope_at_rest, y
from derivations.effective_friction import (
    GAUSS,
    STRIBECK,
    b,
    c,
    mu,
    mu_s,
    q,
    theta,
    v,
)
from derivations.ledger import Ledger

PART = Ledger("effective_closed", "Gauss, exponential, Stribeck")

# With a = q^2/(2 c^2) and k = 2 v q/c^2, exp(-w^2/c^2) is exp(-v^2/c^2 - a) exp(-a cos(2 theta)) exp(k cos(theta)). By
# Jacobi and Anger the last two are sums of (-1)^n I_n(a) cos(2 n theta) and I_n(k) cos(n theta) over all integers n,
# and the mean keeps the products of equal harmonics. The row holds the sum against the integrals, in numbers only.
n = sp.Symbol("n", integer=True, positive=True)
A, K = q**2 / (2 * c**2), 2 * v * q / c**2
BESSEL = sp.besseli(0, A) * sp.besseli(0, K) + 2 * sp.Sum(
    (-1) ** n * sp.besseli(n, A) * sp.besseli(2 * n, K), (n, 1, 40)
)


@PART.verified("2.1", "Gauss, v >= q (40 terms)", mu * sp.exp(-(v**2) / c**2 - A) * BESSEL + b * v, numbers=HELD)
def _(claim):
    return disagreement(claim, GAUSS_LAW, FROM_Q)


def dawson(x):
    """exp(-x^2) times the integral of exp(t^2) from 0 to x."""
    return sp.sqrt(sp.pi) / 2 * sp.exp(-(x**2)) * sp.erfi(x)


GAUSS_SLOPE = 2 * mu / (sp.pi * q) - 4 * mu / (sp.pi * c) * dawson(q / c) + b


@PART.verified("2.2", "Gauss, slope at rest", GAUSS_SLOPE, numbers=HELD)
def _(claim):
    primitive = -2 * mu / (sp.sqrt(sp.pi) * c) * sp.exp(-(q**2) / c**2) * sp.erfi(q * y / c)
    slope, left = slope_at_rest(GAUSS, primitive)
    return left, claim - slope, slope_disagreement(claim, GAUSS_LAW)


# In x = q/c it is the slope of the Dawson function, 1 - 2 x D(x), times 2 mu/(pi q): negative beyond D's maximum.
@PART.verified("2.3", "Gauss, slope at rest by D'", 2 * mu / (sp.pi * q) * dawson(y).diff(y).subs(y, q / c) + b)
def _(claim):
    return claim - GAUSS_SLOPE


@PART.verified(
    "2.4", "Gauss, b = 0: q/c where the slope at rest changes its sign", sp.Rational(9241, 10000), numbers=SIGNS
)
def _(claim):
    return changes_sign(GAUSS_SLOPE, claim)


# --- 3. Exponential and Stribeck ----------------------------------------------------------------------------------
# For v > q the vibration multiplies exp(-v/c) by the mean of exp(q cos(theta)/c), the modified Bessel function I0(q/c).
# The exponential law is Stribeck's without its constant.
@PART.verified(
    "3.1", "Stribeck, v >= q", mu + b * v + (mu_s - mu) * sp.exp(-v / c) * sp.besseli(0, q / c), numbers=HELD
)
def _(claim):
    parts = claim.replace(sp.besseli, lambda _, x: sp.exp(x * sp.cos(theta)))
    straight = -b * q * sp.cos(theta)  # of mean zero
    return parts - STRIBECK.subs(v, v - q * sp.cos(theta)) + straight, disagreement(claim, STRIBECK_LAW, FROM_Q)


# At rest (2/pi) times the integral of exp(-x cos(theta)) from 0 to pi/2 is I0(x) - L0(x), L0 the modified Struve
# function: the even powers of x make I0, and the odd ones, with (2/pi) (n - 1)!!/n!!, the hypergeometric series. Again
# the row compares numbers, 25 digits.
def struve(x):
    """Modified Struve function of order 0."""
    return 2 * x / sp.pi * sp.hyper([1], [sp.Rational(3, 2), sp.Rational(3, 2)], x**2 / 4)


STRIBECK_SLOPE = 2 * mu_s / (sp.pi * q) - (mu_s - mu) / c * (sp.besseli(0, q / c) - struve(q / c)) + b


@PART.verified("3.2", "Stribeck, slope at rest", STRIBECK_SLOPE, numbers=HELD)
def _(claim):
    return slope_disagreement(claim, STRIBECK_LAW)


@PART.verified(
    "3.3", "exponential: q/c where the slope at rest changes its sign", sp.Rational(14262, 10000), numbers=SIGNS
)
def _(claim):
    return changes_sign(STRIBECK_SLOPE, claim, at_speed=0)
