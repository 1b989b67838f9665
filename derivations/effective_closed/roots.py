"""Means of the square-root law and of straight lines."""

import itertools

import sympy as sp

from derivations.effective_closed.comparison import (
    BELOW,
    FROM_Q,
    HELD,
    MEAN_OF_LINE_AND_JUMP,
    ROOT_LAW,
    disagreement,
    slope_disagreement,
)
from derivations.effective_friction import (
    BREAKS,
    INTENSITIES,
    alpha,
    arcs,
    b,
    branch,
    c,
    mu,
    q,
    ranges,
    theta,
    v,
)
from derivations.ledger import Ledger

PART = Ledger("effective_closed", "square root, straight lines")

# Outside, theta = pi - 2 phi gives sqrt(w) = sqrt(v + q) sqrt(1 - m sin(phi)^2), m = 2 q/(v + q).
phi = sp.Symbol("phi", positive=True)


def over_a_quarter(expr):
    """Integrand over 0 < phi < pi/2 of complete elliptic integrals."""
    first = expr.replace(sp.elliptic_k, lambda m: 1 / sp.sqrt(1 - m * sp.sin(phi) ** 2))
    return first.replace(sp.elliptic_e, lambda m: sp.sqrt(1 - m * sp.sin(phi) ** 2))


@PART.verified(
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


@PART.verified(
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
@PART.verified("4.3", "square root, slope at rest", 2 * mu / (sp.pi * q) + SLOPE_OF_ROOT + b, numbers=HELD)
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


@PART.verified("5.1", "mean of max(w, 0), |v| < q", RAMP)
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

    @PART.verified(
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


@PART.verified("5.4", "Coulomb, linear shape of width c, closed, v < q - c", four_angles())
def _(claim):
    back, on = sp.acos((v + c) / q), sp.acos((v - c) / q)
    middle = sp.integrate(mu / c * (v - q * sp.cos(theta)), (theta, back, on))
    return sp.expand((claim - (middle - mu * back + mu * (sp.pi - on)) / sp.pi).rewrite(sp.asin))


# At rest the slope is mu/c times the share of the period within the edges; for c -> 0 it tends to 2 mu/(pi q).
@PART.verified("5.5", "Coulomb, linear shape, slope at rest", 2 * mu / (sp.pi * c) * sp.asin(c / q))
def _(claim):
    return (four_angles().diff(v).subs(v, 0) - claim).rewrite(sp.asin)
