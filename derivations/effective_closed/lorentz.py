"""Means of the Lorentz law, and of Coulomb friction regularised by the arctangent."""

import sympy as sp

from derivations.effective_closed.comparison import (
    BELOW,
    FROM_Q,
    HELD,
    LORENTZ_LAW,
    POINTS,
    SIGNS,
    disagreement,
    slope_disagreement,
)
from derivations.effective_friction import (
    LORENTZ,
    REGULARISED,
    b,
    c,
    mu,
    mu_s,
    q,
    v,
)
from derivations.ledger import Ledger

PART = Ledger("effective_closed", "Lorentz, regularised Coulomb")

# With z = v - i c the Lorentz curve is c Im 1/(z - q cos(theta)), and T = tan(theta/2) turns the integral over theta
# into that of 2/((z - q) + (z + q) T^2). Im(z + q) = Im(z - q) = -c keeps the quotient K of their roots in the right
# half plane, so that atan(K T) runs from 0 to pi/2 without meeting its cuts on the imaginary axis.
z, T = sp.symbols("z T")
R = sp.sqrt(z - q) * sp.sqrt(z + q)
PRIMITIVE = 2 / R * sp.atan(T * sp.sqrt(z + q) / sp.sqrt(z - q))


@PART.verified("1.1", "primitive of 1/(z - q cos theta) in T = tan(theta/2)", PRIMITIVE)
def _(claim):
    cosine = (1 - T**2) / (1 + T**2)
    return claim.diff(T) - 2 / (1 + T**2) / (z - q * cosine), claim.subs(T, 0)


def imaginary(expr):
    """Imaginary part at z = v - i c of an expression that is real for real z."""
    return (expr.subs(z, v - sp.I * c) - expr.subs(z, v + sp.I * c)) / (2 * sp.I)


# Outside the mean of 1/(z - q cos) is 1/R. Its imaginary part is positive and follows from its square 1/(z^2 - q^2),
# of modulus 1/(r1 r2): Im^2 = (modulus - real part)/2.
r1, r2 = sp.sqrt((v + q) ** 2 + c**2), sp.sqrt((v - q) ** 2 + c**2)
IMAGINARY_SQUARED = (r1 * r2 - (v**2 - c**2 - q**2)) / (2 * r1**2 * r2**2)


@PART.verified("1.2", "square of Im 1/sqrt(z^2 - q^2)", IMAGINARY_SQUARED)
def _(claim):
    square = ((v - sp.I * c) ** 2 - q**2).expand()
    real, imag = square.as_real_imag()
    modulus = r1 * r2
    return sp.expand(real**2 + imag**2 - modulus**2), claim - (1 / modulus - real / modulus**2) / 2


@PART.verified(
    "1.3", "Lorentz, v >= q", mu * c * sp.sqrt((r1 * r2 - v**2 + c**2 + q**2) / 2) / (r1 * r2) + b * v, numbers=HELD
)
def _(claim):
    return (claim - b * v) ** 2 - mu**2 * c**2 * IMAGINARY_SQUARED, disagreement(claim, LORENTZ_LAW, FROM_Q)


# Inside, the arc behind the turn counts once and the one before it negatively: P(oo) - 2 P(T1), P(oo) = pi/R.
T1 = sp.sqrt((q - v) / (q + v))
WITHIN = (1 - 4 / sp.pi * sp.atan(T1 * sp.sqrt(z + q) / sp.sqrt(z - q))) / R


@PART.verified("1.4", "Lorentz, v < q", mu * c * imaginary(WITHIN) + b * v, numbers=HELD)
def _(claim):
    w = v - q * (1 - T**2) / (1 + T**2)
    kernel = 1 / (z - q * (1 - T**2) / (1 + T**2))
    mean = (sp.pi / R - 2 * PRIMITIVE.subs(T, T1)) / sp.pi
    return (
        c * imaginary(kernel) - 1 / (1 + w**2 / c**2),
        w.subs(T, T1),
        claim - b * v - mu * c * imaginary(mean),
        disagreement(claim, LORENTZ_LAW, BELOW),
    )


# Slope at rest, by 1.7: 2 mu(0)/(pi q) + (2/pi) times the integral of mu'(q cos theta) from 0 to pi/2, or with
# y = sin(theta), of mu'(q sqrt(1 - y^2))/sqrt(1 - y^2) from 0 to 1.
y = sp.Symbol("y", positive=True)


def slope_at_rest(formula, primitive):
    """Slope at rest from a primitive over y of the second part, and what the primitive leaves."""
    root = sp.sqrt(1 - y**2)
    second = 2 / sp.pi * (formula.diff(v).subs(v, q * root) - b) / root
    return 2 * formula.subs(v, 0) / (sp.pi * q) + b + primitive.subs(y, 1) - primitive.subs(y, 0), (
        primitive.diff(y) - second
    )


h = sp.sqrt(q**2 + c**2)
LORENTZ_SLOPE = 2 * mu * c**2 / sp.pi * (1 / (q * h**2) - sp.atanh(q / h) / h**3) + b


@PART.verified("1.5", "Lorentz, slope at rest", LORENTZ_SLOPE, numbers=HELD)
def _(claim):
    primitive = -2 * mu * q * c**2 / (sp.pi * h**2) * (y / (h**2 - q**2 * y**2) + sp.atanh(q * y / h) / (h * q))
    slope, left = slope_at_rest(LORENTZ, primitive)
    return left, claim - slope, slope_disagreement(claim, LORENTZ_LAW)


# Without b the slope is positive for weak vibration and negative beyond the q with (h/q) tanh(h/q) = 1: fast vibration
# that is too strong makes such a contact fall with speed at rest. So do the other two laws that fall to nothing.
def changes_sign(slope, at, at_speed=1):
    """0 if the slope at rest falls through zero within 1e-4 of q/c = `at`; `at_speed` is the coefficient mu."""
    near = (at * (1 + side * sp.Rational(1, 10000)) for side in (-1, 1))
    low, high = (slope.subs({b: 0, mu: at_speed, mu_s: 1, c: 1, q: x}).evalf() for x in near)
    return sp.Integer(0) if low > 0 > high else sp.Integer(1)


@PART.verified(
    "1.6", "Lorentz, b = 0: q/c where the slope at rest changes its sign", sp.Rational(1509, 1000), numbers=SIGNS
)
def _(claim):
    return changes_sign(LORENTZ_SLOPE, claim)


# Coulomb, regularised by (2/pi) atan(w/c): its derivative in v is the Lorentz curve without the sign, whose mean is
# Im 1/R for every v; no turn matters, and the mean of atan(w/c) is the one that vanishes at rest.
ARCTAN = 2 * mu / sp.pi * sp.asin(2 * v / (r1 + r2))


@PART.verified(
    "1.7", "arctan, Coulomb, every v", ARCTAN, note="tends to (2/pi) mu asin(v/q) and mu for c -> 0", numbers=HELD
)
def _(claim):
    rate = claim.diff(v) ** 2 - (2 * mu / sp.pi) ** 2 * IMAGINARY_SQUARED
    return rate, claim.subs(v, 0), disagreement(claim, REGULARISED[1], POINTS)


@PART.verified("1.8", "arctan, Coulomb, slope at rest", 2 * mu / (sp.pi * h))
def _(claim):
    return ARCTAN.diff(v).subs(v, 0) - claim
