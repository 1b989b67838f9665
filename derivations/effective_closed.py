"""Effective friction in closed form: Lorentz, Gauss, Stribeck and square root, regularised Coulomb, straight lines.

``effective_friction.py`` proves that the package's integrals are the mean of a law under a fast vibration. Here these
means are found in closed form, with the slope at rest, which decides whether the vibration damps a slow motion. They
are also held against the package's integrals, evaluated by mpmath: 25 digits below, just below, at and above v = q.
"""

import itertools
from functools import cache

import mpmath
import sympy as sp

from derivations.effective_friction import (
    BREAKS,
    GAUSS,
    INTENSITIES,
    LORENTZ,
    QUADRATURES,
    REGULARISED,
    STRIBECK,
    alpha,
    arcs,
    b,
    branch,
    c,
    integrand,
    mu,
    mu_s,
    q,
    ranges,
    s,
    theta,
    v,
)
from derivations.ledger import Ledger
from derivations.residuals import agree

LEDGER = Ledger("effective_closed", "The mean of friction over a fast vibration in closed form")
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

# --- 1. Lorentz, and Coulomb regularised by the arctangent --------------------------------------------------------
# With z = v - i c the Lorentz curve is c Im 1/(z - q cos(theta)), and T = tan(theta/2) turns the integral over theta
# into that of 2/((z - q) + (z + q) T^2). Im(z + q) = Im(z - q) = -c keeps the quotient K of their roots in the right
# half plane, so that atan(K T) runs from 0 to pi/2 without meeting its cuts on the imaginary axis.
z, T = sp.symbols("z T")
R = sp.sqrt(z - q) * sp.sqrt(z + q)
PRIMITIVE = 2 / R * sp.atan(T * sp.sqrt(z + q) / sp.sqrt(z - q))


@LEDGER.verified("1.1", "primitive of 1/(z - q cos theta) in T = tan(theta/2)", PRIMITIVE)
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


@LEDGER.verified("1.2", "square of Im 1/sqrt(z^2 - q^2)", IMAGINARY_SQUARED)
def _(claim):
    square = ((v - sp.I * c) ** 2 - q**2).expand()
    real, imag = square.as_real_imag()
    modulus = r1 * r2
    return sp.expand(real**2 + imag**2 - modulus**2), claim - (1 / modulus - real / modulus**2) / 2


@LEDGER.verified(
    "1.3", "Lorentz, v >= q", mu * c * sp.sqrt((r1 * r2 - v**2 + c**2 + q**2) / 2) / (r1 * r2) + b * v, numbers=HELD
)
def _(claim):
    return (claim - b * v) ** 2 - mu**2 * c**2 * IMAGINARY_SQUARED, disagreement(claim, LORENTZ_LAW, FROM_Q)


# Inside, the arc behind the turn counts once and the one before it negatively: P(oo) - 2 P(T1), P(oo) = pi/R.
T1 = sp.sqrt((q - v) / (q + v))
WITHIN = (1 - 4 / sp.pi * sp.atan(T1 * sp.sqrt(z + q) / sp.sqrt(z - q))) / R


@LEDGER.verified("1.4", "Lorentz, v < q", mu * c * imaginary(WITHIN) + b * v, numbers=HELD)
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


@LEDGER.verified("1.5", "Lorentz, slope at rest", LORENTZ_SLOPE, numbers=HELD)
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


@LEDGER.verified(
    "1.6", "Lorentz, b = 0: q/c where the slope at rest changes its sign", sp.Rational(1509, 1000), numbers=SIGNS
)
def _(claim):
    return changes_sign(LORENTZ_SLOPE, claim)


# Coulomb, regularised by (2/pi) atan(w/c): its derivative in v is the Lorentz curve without the sign, whose mean is
# Im 1/R for every v; no turn matters, and the mean of atan(w/c) is the one that vanishes at rest.
ARCTAN = 2 * mu / sp.pi * sp.asin(2 * v / (r1 + r2))


@LEDGER.verified(
    "1.7", "arctan, Coulomb, every v", ARCTAN, note="tends to (2/pi) mu asin(v/q) and mu for c -> 0", numbers=HELD
)
def _(claim):
    rate = claim.diff(v) ** 2 - (2 * mu / sp.pi) ** 2 * IMAGINARY_SQUARED
    return rate, claim.subs(v, 0), disagreement(claim, REGULARISED[1], POINTS)


@LEDGER.verified("1.8", "arctan, Coulomb, slope at rest", 2 * mu / (sp.pi * h))
def _(claim):
    return ARCTAN.diff(v).subs(v, 0) - claim


# --- 2. Gauss -----------------------------------------------------------------------------------------------------
# With a = q^2/(2 c^2) and k = 2 v q/c^2, exp(-w^2/c^2) is exp(-v^2/c^2 - a) exp(-a cos(2 theta)) exp(k cos(theta)). By
# Jacobi and Anger the last two are sums of (-1)^n I_n(a) cos(2 n theta) and I_n(k) cos(n theta) over all integers n,
# and the mean keeps the products of equal harmonics. The row holds the sum against the integrals, in numbers only.
n = sp.Symbol("n", integer=True, positive=True)
A, K = q**2 / (2 * c**2), 2 * v * q / c**2
BESSEL = sp.besseli(0, A) * sp.besseli(0, K) + 2 * sp.Sum(
    (-1) ** n * sp.besseli(n, A) * sp.besseli(2 * n, K), (n, 1, 40)
)


@LEDGER.verified("2.1", "Gauss, v >= q (40 terms)", mu * sp.exp(-(v**2) / c**2 - A) * BESSEL + b * v, numbers=HELD)
def _(claim):
    return disagreement(claim, GAUSS_LAW, FROM_Q)


def dawson(x):
    """exp(-x^2) times the integral of exp(t^2) from 0 to x."""
    return sp.sqrt(sp.pi) / 2 * sp.exp(-(x**2)) * sp.erfi(x)


GAUSS_SLOPE = 2 * mu / (sp.pi * q) - 4 * mu / (sp.pi * c) * dawson(q / c) + b


@LEDGER.verified("2.2", "Gauss, slope at rest", GAUSS_SLOPE, numbers=HELD)
def _(claim):
    primitive = -2 * mu / (sp.sqrt(sp.pi) * c) * sp.exp(-(q**2) / c**2) * sp.erfi(q * y / c)
    slope, left = slope_at_rest(GAUSS, primitive)
    return left, claim - slope, slope_disagreement(claim, GAUSS_LAW)


# In x = q/c it is the slope of the Dawson function, 1 - 2 x D(x), times 2 mu/(pi q): negative beyond D's maximum.
@LEDGER.verified("2.3", "Gauss, slope at rest by D'", 2 * mu / (sp.pi * q) * dawson(y).diff(y).subs(y, q / c) + b)
def _(claim):
    return claim - GAUSS_SLOPE


@LEDGER.verified(
    "2.4", "Gauss, b = 0: q/c where the slope at rest changes its sign", sp.Rational(9241, 10000), numbers=SIGNS
)
def _(claim):
    return changes_sign(GAUSS_SLOPE, claim)


# --- 3. Exponential and Stribeck ----------------------------------------------------------------------------------
# For v > q the vibration multiplies exp(-v/c) by the mean of exp(q cos(theta)/c), the modified Bessel function I0(q/c).
# The exponential law is Stribeck's without its constant.
@LEDGER.verified(
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


@LEDGER.verified("3.2", "Stribeck, slope at rest", STRIBECK_SLOPE, numbers=HELD)
def _(claim):
    return slope_disagreement(claim, STRIBECK_LAW)


@LEDGER.verified(
    "3.3", "exponential: q/c where the slope at rest changes its sign", sp.Rational(14262, 10000), numbers=SIGNS
)
def _(claim):
    return changes_sign(STRIBECK_SLOPE, claim, at_speed=0)


# --- 4. Square root -----------------------------------------------------------------------------------------------
# Outside, theta = pi - 2 phi gives sqrt(w) = sqrt(v + q) sqrt(1 - m sin(phi)^2), m = 2 q/(v + q).
phi = sp.Symbol("phi", positive=True)


def over_a_quarter(expr):
    """Integrand over 0 < phi < pi/2 of complete elliptic integrals."""
    first = expr.replace(sp.elliptic_k, lambda m: 1 / sp.sqrt(1 - m * sp.sin(phi) ** 2))
    return first.replace(sp.elliptic_e, lambda m: sp.sqrt(1 - m * sp.sin(phi) ** 2))


@LEDGER.verified(
    "4.1",
    "square root, v >= q",
    mu + 2 * alpha / sp.pi * sp.sqrt(v + q) * sp.elliptic_e(2 * q / (v + q)) + b * v,
    numbers=HELD,
)
def _(claim):
    root = sp.sqrt(v - q * sp.cos(sp.pi - 2 * phi))
    square = over_a_quarter((claim - mu - b * v) / alpha) ** 2 - (2 / sp.pi * root) ** 2
    return square.rewrite(sp.sin).expand(trig=True), disagreement(claim, ROOT_LAW, FROM_Q)


# Inside, sin(phi) = sqrt(k) sin(psi) with k = (q + v)/(2 q) maps the arc behind the turn to a quarter as well, and
# sqrt(w) = sqrt(q + v) cos(psi); the arc before it has v -> -v, k -> 1 - k. With E(k) - (1 - k) K(k) = k times the
# integral of cos(psi)^2/sqrt(1 - k sin(psi)^2) the mean is
k_on, k_back = (q + v) / (2 * q), (q - v) / (2 * q)
ELLIPTIC = sp.elliptic_e(k_on) - k_back * sp.elliptic_k(k_on) - sp.elliptic_e(k_back) + k_on * sp.elliptic_k(k_back)


@LEDGER.verified(
    "4.2",
    "square root, v < q",
    MEAN_OF_LINE_AND_JUMP + 2 * alpha / sp.pi * sp.sqrt(2 * q) * ELLIPTIC,
    numbers=HELD,
)
def _(claim):
    arcs = []
    for k, top in ((k_on, q + v), (k_back, q - v)):
        angle = sp.asin(sp.sqrt(k) * sp.sin(phi))  # from 0 to the turn, where phi = pi/2
        arcs.append(2 / sp.pi * sp.sqrt(top) * sp.cos(phi) * angle.diff(phi))
        slip = top - 2 * q * sp.sin(angle) ** 2
        arcs.append(slip - top * sp.cos(phi) ** 2)
    on, slip_on, back, slip_back = arcs
    elliptic = over_a_quarter((claim - MEAN_OF_LINE_AND_JUMP) / alpha)
    return elliptic - on + back, slip_on, slip_back, disagreement(claim, ROOT_LAW, BELOW)


SLOPE_OF_ROOT = alpha * sp.gamma(sp.Rational(1, 4)) / (2 * sp.sqrt(sp.pi * q) * sp.gamma(sp.Rational(3, 4)))


# The mean of alpha/(2 sqrt(q cos(theta))), by Euler's beta function of 1/4 and 1/2.
@LEDGER.verified("4.3", "square root, slope at rest", 2 * mu / (sp.pi * q) + SLOPE_OF_ROOT + b, numbers=HELD)
def _(claim):
    beta = sp.gamma(sp.Rational(1, 4)) * sp.gamma(sp.Rational(1, 2)) / sp.gamma(sp.Rational(3, 4))
    mean = 2 / sp.pi * alpha / (2 * sp.sqrt(q)) * beta / 2
    return claim - 2 * mu / (sp.pi * q) - mean - b, slope_disagreement(claim, ROOT_LAW)


# --- 5. Straight lines --------------------------------------------------------------------------------------------
# The mean of max(w, 0) is r(v) = v for v > q, 0 for v < -q, and between, from the turn on,
# (v acos(-v/q) + sqrt(q^2 - v^2))/pi. A law that starts at mu(0) with slope s_0 and turns by d_j at b_j is
# m = mu(0) sgn(w) + s_0 w + sum of d_j (max(w - b_j, 0) - max(-w - b_j, 0)), and v - b_j, -v - b_j take the place of v.
x = sp.Symbol("x", real=True)
RAMP = (x * sp.acos(-x / q) + sp.sqrt(q**2 - x**2)) / sp.pi


@LEDGER.verified("5.1", "mean of max(w, 0), |v| < q", RAMP)
def _(claim):
    return (claim - sp.integrate(x - q * sp.cos(theta), (theta, sp.acos(x / q), sp.pi)) / sp.pi).rewrite(sp.asin)


def ramp(at, intensity):
    """Mean of max(w, 0) for any v."""
    within = RAMP.subs(q, intensity).subs(x, at)
    return sp.Piecewise((0, at < -intensity), (within, at < intensity), (at, True))


def mean_of_lines(start, slopes, breaks, intensity):
    """Mean of the law with the slopes before, between and behind the breaks, that starts at mu(0)."""
    jump = sp.Piecewise((2 / sp.pi * sp.asin(v / intensity), v < intensity), (1, True))
    turns = zip(breaks, itertools.pairwise(slopes), strict=True)
    kinks = [(after - before) * (ramp(v - e, intensity) - ramp(-v - e, intensity)) for e, (before, after) in turns]
    return start * jump + slopes[0] * v + sp.Add(*kinks)


def lines_row(number, intensity):
    slopes = sp.symbols("s0:3")
    start = sp.Symbol("f")

    @LEDGER.verified(
        f"5.{number}", f"piecewise linear, closed, q = {intensity}", mean_of_lines(start, slopes, BREAKS, intensity)
    )
    def _(claim):
        values = (start, start + slopes[0] * BREAKS[0])
        values = (*values, values[1] + slopes[1] * (BREAKS[1] - BREAKS[0]))
        speeds = sorted({abs(level + side * intensity) for level in (0, *BREAKS) for side in (-1, 1)} - {0})
        left = []
        for low, high in ranges(speeds):
            total = sp.Integer(0)
            for first, last, k, sign in arcs(BREAKS, intensity, low, high, odd=False):
                # sign (f_k + s_k (sign w - b_k)) over the arc
                line = sign * (values[k] - slopes[k] * (0, *BREAKS)[k]) + slopes[k] * v
                total += line * (last - first) - slopes[k] * intensity * (sp.sin(last) - sp.sin(first))
            middle = low + 1 if high is sp.oo else (low + high) / 2
            gap = (branch(claim, {v: middle}) - total / sp.pi).rewrite(sp.asin)
            left.append(sp.expand(sp.expand(gap), func=True))
        return left


for number, intensity in enumerate(INTENSITIES[1:3], 2):
    lines_row(number, intensity)


# Coulomb with the linear shape is mu ((max(w + c, 0) - max(w - c, 0))/c - 1). For v < q - c the slip crosses both
# edges, at four angles of a whole period.
def four_angles():
    def part(at):
        return at * sp.acos(-at / q) + sp.sqrt(q**2 - at**2)

    return mu * ((part(v + c) - part(v - c)) / (sp.pi * c) - 1)


@LEDGER.verified("5.4", "Coulomb, linear shape of width c, closed, v < q - c", four_angles())
def _(claim):
    back, on = sp.acos((v + c) / q), sp.acos((v - c) / q)
    middle = sp.integrate(mu / c * (v - q * sp.cos(theta)), (theta, back, on))
    return sp.expand((claim - (middle - mu * back + mu * (sp.pi - on)) / sp.pi).rewrite(sp.asin))


# At rest the slope is mu/c times the share of the period within the edges; for c -> 0 it tends to 2 mu/(pi q).
@LEDGER.verified("5.5", "Coulomb, linear shape, slope at rest", 2 * mu / (sp.pi * c) * sp.asin(c / q))
def _(claim):
    return (four_angles().diff(v).subs(v, 0) - claim).rewrite(sp.asin)
