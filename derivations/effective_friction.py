"""The effective friction of every law: what is left of dry friction when a fast vibration shakes the contact.

A law mu(|w|) acts against the slip velocity w, as m(w) = sgn(w) mu(|w|). Under a fast vibration of intensity q the
slip is w = v - q cos(theta), and the slow motion feels the mean of m over theta, Thomsen (41). Because cos is even the
mean over one period is the mean over 0 < theta < pi, where w rises from v - q to v + q.

``symfric.laws`` gives this mean in closed form for polynomials (section 2) and as an integral for all other laws. For
any law, smooth (sections 1, 3) or with branches (section 4), the integrals are proved to be the mean: they are split
where the integrand may not be smooth, each part is the mean's own integrand under a change of variable, and the parts
tile 0 < theta < pi. ``effective_closed.py`` derives closed forms and holds the integrals against them.
"""

import itertools
from functools import cache

import sympy as sp

from derivations.ledger import Ledger
from derivations.residuals import less
from symfric.model import laws
from symfric.model.averaged_law import effective_coefficient
from symfric.model.symbols import SPEED

LEDGER = Ledger("effective_friction", "The mean of friction over a fast vibration, Thomsen (41), for every law")

v = SPEED  # slip velocity of the slow motion, v > 0; the mean is odd in it
q, c, mu, mu_s, b, p = sp.symbols("q c mu mu_s b p", positive=True)
alpha = sp.Symbol("alpha", real=True)
theta, s = sp.symbols("theta s", positive=True)
F = sp.Function("F")  # any law

# --- 1. Any law without branches --------------------------------------------------------------------------------
# For v < q the slip passes zero once, upwards, because w' = q sin(theta) > 0; for v > q it stays above v - q > 0.


@LEDGER.verified("1.1", "angle at which the slip turns, v < q", sp.acos(v / q))
def _(claim):
    return v - q * sp.cos(claim), sp.sin(claim) - sp.sqrt(1 - v**2 / q**2)


# The friction m is as smooth as mu on either side of w = 0. Across it the derivatives of even order jump by twice
# those of mu, the odd ones are continuous, because m is odd: with mu = f0 + f1 w + f2 w^2/2 + f3 w^3/6 + ...
f = sp.symbols("f0:4")


def jumps(law, order):
    """Jumps at w = 0 of the derivatives of sgn(w) mu(|w|)."""
    left = -law.subs(v, -v)
    return tuple((law - left).diff(v, k).subs(v, 0) for k in range(order))


@LEDGER.verified("1.2", "jumps of m, m', m'', m''' at w = 0", 2 * f[0], 0, 2 * f[2], 0)
def _(*claim):
    law = sum(f[k] * v**k / sp.factorial(k) for k in range(4))
    return less(jumps(law, 4), claim)


# So w = 0 is the one point where the integrand may not be smooth. A regularised constant coefficient is itself odd,
# and there w = 0 is no such point: the split is then not needed, and does no harm.
REGULARISED = [laws.coulomb(mu).regularised(c, shape) for shape in laws.SHAPES]


@LEDGER.verified("1.3", "a regularised Coulomb law is smooth at w = 0", 0, 0, 0)
def _(*claim):
    pieces = [law.kinetic.args[0].expr if law.breaks else law.kinetic for law in REGULARISED]
    return [sum(abs(j) for j in jumps(piece, 5)) - right for piece, right in zip(pieces, claim, strict=True)]


# Each arc of theta on which m is smooth is mapped to 0 < s < 1 by the polynomial of least degree that rests at both
# ends. It rises in between, d/ds = 6 s (1 - s), so that an integral over the arc keeps its value.
CLUSTERED = s**2 * (3 - 2 * s)


@LEDGER.verified("1.4", "map of an arc to 0 < s < 1", CLUSTERED)
def _(claim):
    ends = (claim.subs(s, 0), claim.subs(s, 1) - 1, claim.diff(s).subs(s, 0), claim.diff(s).subs(s, 1))
    return *ends, claim.diff(s) - 6 * s * (1 - s)


# What it is for: behind the turn w = q sin(theta_0) (theta - theta_0) + ..., and theta - theta_0 is the arc times
# 3 s^2 + ..., so that the square root of the slip, with an infinite slope in w, is smooth in s.
@LEDGER.verified("1.5", "w/s^2 behind the turn", 3 * sp.sqrt(q**2 - v**2) * (sp.pi - sp.acos(v / q)))
def _(claim):
    turn = sp.acos(v / q)
    slip = v - q * sp.cos(turn + (sp.pi - turn) * CLUSTERED)
    return slip.subs(s, 0), slip.diff(s).subs(s, 0), slip.diff(s, 2).subs(s, 0) / 2 - claim


def arc(friction, low, high):
    """Integrand over s of an arc's part of the mean of friction(w)."""
    angle = low + (high - low) * CLUSTERED
    return friction(v - q * sp.cos(angle)) * angle.diff(s) / sp.pi


def integrand(expr):
    """A function of s whose integral from 0 to 1 is `expr`, which is linear in its integrals."""

    def body(integral):
        ((variable, low, high),) = integral.limits
        return (high - low) * integral.function.xreplace({variable: low + (high - low) * s})

    return expr.replace(lambda e: isinstance(e, sp.Integral), body)


def inside(expr):
    """Put v < q: the conditions of a Piecewise decide themselves."""
    return expr.subs(q, v + p)


def outside(expr):
    """Put v > q."""
    return expr.subs(v, q + p)


def branch(expr, at):
    """Take the branch of every Piecewise that holds at the point `at`."""

    def chosen(piecewise):
        return next(e for e, condition in piecewise.args if condition.subs(at) == True)  # noqa: E712

    return expr.replace(lambda e: e.is_Piecewise, chosen)


def at_turn(expr):
    """Put v = q."""
    return expr.subs(v, q)


@cache
def means(law):
    """Integrands of the mean of a law given as a function of the speed, for v < q, v > q and v = q."""
    turn = sp.acos(v / q)
    slips_back, slips_on = arc(lambda w: -law(-w), 0, turn), arc(law, turn, sp.pi)
    always_on = arc(law, 0, sp.pi)
    return [sp.expand(e) for e in (inside(slips_back + slips_on), outside(always_on), at_turn(always_on))]


@cache
def expanded(expr):
    """Integrand of an expression, expanded."""
    return sp.expand(integrand(expr))


def mean_residuals(claim, law):
    """Yield what remains of a claimed mean."""
    for case, mean in zip((inside, outside, at_turn), means(law), strict=True):
        yield expanded(case(claim)) - mean


@LEDGER.verified("1.6", "the integrals are the mean, any law without branches", effective_coefficient(F(v), (), q)[0])
def _(claim):
    return mean_residuals(claim, F)


# Slope. By Leibniz's rule the moving turn adds the jump 2 mu(0) times its rate 1/(pi sqrt(q^2 - v^2)) to the mean of
# m'. It is infinite just below v = q, unless mu(0) = 0, and finite above: the kink that `Law.steep` names.
def whole_mean():
    back = sp.Integral(-F(q * sp.cos(theta) - v), (theta, 0, sp.acos(v / q)))
    on = sp.Integral(F(v - q * sp.cos(theta)), (theta, sp.acos(v / q), sp.pi))
    return back, on


JUMP = 2 * F(0) / (sp.pi * sp.sqrt(q**2 - v**2))


@LEDGER.verified("1.7", "slope less the mean of m', v < q", JUMP)
def _(claim):
    total = sum(part.diff(v) for part in whole_mean())
    smooth = sum(sp.Integral(part.function.diff(v), *part.limits) for part in whole_mean())
    return (total - smooth) / sp.pi - claim


@LEDGER.verified("1.8", "limit of sqrt(q - v) times the slope at v = q", sp.sqrt(2) * F(0) / (sp.pi * sp.sqrt(q)))
def _(claim):
    return sp.limit((JUMP / F(0) * sp.sqrt(q - v)).subs(v, q - p), p, 0, "+") * F(0) - claim


# Far above q the vibration adds mu''(v) <(q cos)^2>/2 = mu'' q^2/4 to the law, and nothing to a straight line.
@LEDGER.verified("1.10", "what a small intensity adds", F(v).diff(v, 2) * q**2 / 4)
def _(claim):
    second = F(v).diff(v, 2) * (q * sp.cos(theta)) ** 2 / 2
    return sp.integrate(second, (theta, 0, sp.pi)) / sp.pi - claim


# --- 2. Polynomials: Coulomb and the cubic law, closed ------------------------------------------------------------
# M_n = <sgn(w) |w|^n> follows without integrals from 1.7: the jump at rest, 2 for n = 0, makes M_0' = 2/(pi sqrt(q^2
# - v^2)), and for n > 1 two derivatives give M_n'' = n (n - 1) M_(n-2). M_n is odd, so M_n(0) = 0, and at v = q it has
# the value of the outside, sum of C(n, 2j) v^(n - 2j) q^2j (2j - 1)!!/(2j)!!.
POWERS = tuple(effective_coefficient(v**n, (), q)[0] for n in range(6))


@LEDGER.verified("2.1", "powers 0 ... 5 of the speed", *POWERS)
def _(*claim):
    left = []
    slow = [branch(mean, {v: 1, q: 2}) for mean in claim]
    for n, (mean, below) in enumerate(zip(claim, slow, strict=True)):
        if n == 0:
            left.append(below.diff(v) - 2 / (sp.pi * sp.sqrt(q**2 - v**2)))
        elif n > 1:
            left.append(below.diff(v, 2) - n * (n - 1) * slow[n - 2])
        above = sum(
            sp.binomial(n, 2 * j) * v ** (n - 2 * j) * q ** (2 * j) * sp.factorial2(2 * j - 1) / sp.factorial2(2 * j)
            for j in range(n // 2 + 1)
        )
        left += [below.subs(v, 0), below.subs(v, q) - mean.subs(v, q), outside(mean - above)]
    return left


@LEDGER.verified("2.2", "Coulomb", laws.coulomb(mu_s, mu).averaged(q).kinetic)
def _(claim):
    within = (sp.pi - 2 * sp.acos(v / q)) * mu / sp.pi  # w > 0 on the arc behind the turn, w < 0 before it
    return [(branch(claim, {v: 1, q: 2}) - within).rewrite(sp.asin), outside(claim) - mu, claim.subs(v, q) - mu]


# Thomsen's law: mu_s M_0 - (3/2)(mu_s - mu)(M_1/c - M_3/(3 c^3)), with mu at its smallest at the speed c. Only the
# jump is averaged away; the cubic term adds 3 v q^2/2 to v^3 at every v.
@LEDGER.verified("2.3", "cubic law", laws.cubic(mu_s, mu, c).averaged(q).kinetic)
def _(claim):
    m_3 = v**3 + sp.Rational(3, 2) * v * q**2
    curved = -sp.Rational(3, 2) * (mu_s - mu) * (v / c - m_3 / (3 * c**3))
    within = mu_s * 2 / sp.pi * sp.asin(v / q) + curved
    return branch(claim, {v: 1, q: 2}) - within, outside(claim - mu_s - curved), (claim - mu_s - curved).subs(v, q)


# --- 3. The laws averaged by quadrature ---------------------------------------------------------------------------
# 1.6 with each law in place of F; the formulas are written here once more, not taken from the package.
GAUSS, LORENTZ = mu * sp.exp(-(v**2) / c**2) + b * v, mu / (1 + v**2 / c**2) + b * v
ROOT, STRIBECK = mu + alpha * sp.sqrt(v) + b * v, mu + (mu_s - mu) * sp.exp(-v / c) + b * v
QUADRATURES = {
    "Lorentz": (laws.lorentz(mu, c, mu_s, b), LORENTZ),
    "Gauss": (laws.gauss(mu, c, mu_s, b), GAUSS),
    "square root": (laws.square_root(mu, alpha, mu_s, b), ROOT),
    "Stribeck": (laws.stribeck(mu_s, mu, c, b), STRIBECK),
    "exponential": (laws.exponential(mu, c), mu * sp.exp(-v / c)),
    "custom": (laws.custom(mu / (1 + v / c), mu), mu / (1 + v / c)),
    "arctan, Coulomb": (REGULARISED[1], 2 * mu / sp.pi * sp.atan(v / c)),
    "tanh, Coulomb": (REGULARISED[2], mu * sp.tanh(v / c)),
    "tanh, Stribeck": (laws.stribeck(mu_s, mu, c, b).regularised(p, "tanh"), STRIBECK * sp.tanh(v / p)),
}


def quadrature_row(number, name, law, formula):
    def coefficient(w):
        return formula.subs(v, w)

    @LEDGER.verified(f"3.{number}", f"{name}: the integrals are the mean", law.averaged(q).kinetic)
    def _(claim):
        return mean_residuals(claim, coefficient)


for number, (name, (law, formula)) in enumerate(QUADRATURES.items(), 1):
    quadrature_row(number, name, law, formula)


# --- 4. Laws with branches ----------------------------------------------------------------------------------------
# m changes its branch where w passes a level 0, +-b_1, +-b_2, ... Because w rises with theta, each interval between two
# levels l < u is one arc, from theta(l) to theta(u) with theta(l) = acos((v - l)/q). Where l < v - q or l > v + q the
# slip never takes the level, and theta(l) is 0 or pi. So the arcs change, as functions of v, at the speeds |l +- q|,
# and between two of them one formula holds.
def arcs(breaks, intensity, low, high, odd):
    """Yield the arcs for low < v < high: ends in theta, number of the branch, sign of w; None where they change.

    If the branch at rest is odd, nothing changes at w = 0.
    """
    rest = [] if odd else [sp.Integer(0)]
    levels = [-sp.oo, *(-e for e in reversed(breaks)), *rest, *breaks, sp.oo]

    def angle(level):
        if level <= low - intensity:
            return sp.Integer(0)
        if level >= high + intensity:
            return sp.pi
        return sp.acos((v - level) / intensity) if high - intensity <= level <= low + intensity else None

    for lower, upper in itertools.pairwise(levels):
        ends = angle(lower), angle(upper)
        if None in ends:
            yield None
        elif ends[0] != ends[1]:
            sign = 1 if upper > 0 else -1
            yield *ends, sum(1 for e in breaks if max(abs(lower), abs(upper)) > e), sign


def ranges(edges):
    return itertools.pairwise([sp.Integer(0), *edges, sp.oo])


@cache
def mean_between(pieces, breaks, intensity, low, high):
    """Integrand of the mean for low < v < high of a law with branches; nan if the arcs change there."""
    odd = sp.expand(pieces[0](v) + pieces[0](-v)) == 0
    found = list(arcs(breaks, intensity, low, high, odd))
    if None in found:
        return sp.nan
    parts = (
        arc(lambda w, piece=pieces[k], sign=sign: sign * piece(sign * w), *ends).subs(q, intensity)
        for *ends, k, sign in found
    )
    return sp.expand(sum(parts))


def branched_residuals(claim, pieces, breaks, intensity):
    """Yield what remains of a claimed Piecewise, for a law whose branches `pieces` are functions of the speed."""
    branches = sp.piecewise_fold(claim).args
    edges = [condition.gts for _, condition in branches[:-1]]
    for (expr, _), (low, high) in zip(branches, ranges(edges), strict=True):
        mean = mean_between(pieces, breaks, intensity, low, high)
        yield sp.oo if mean is sp.nan else expanded(expr) - mean


G = sp.symbols("F0:3", cls=sp.Function)  # the branches of any law
BREAKS = sp.Rational(1, 5), sp.Rational(3, 5)
INTENSITIES = [sp.Rational(k, 10) for k in (1, 2, 4, 9)]  # below, at and above the breaks, and at their difference
ANY = sp.Piecewise((G[0](v), BREAKS[0] > v), (G[1](v), BREAKS[1] > v), (G[2](v), True))


def branched_row(number, name, law, pieces, intensities):
    @LEDGER.verified(f"4.{number}", name, *(law.averaged(intensity).kinetic for intensity in intensities))
    def _(*claim):
        for mean, intensity in zip(claim, intensities, strict=True):
            yield from branched_residuals(mean, pieces, law.breaks, intensity)


for number, intensity in enumerate(INTENSITIES, 1):
    branched_row(number, f"any law of three branches, q = {intensity}", laws.custom(ANY, mu, BREAKS), G, [intensity])


@LEDGER.verified("4.5", "breaks of the effective law", *laws.custom(ANY, mu, BREAKS).averaged(INTENSITIES[3]).breaks)
def _(*claim):
    levels = {sp.Integer(0), *BREAKS, *(-e for e in BREAKS)}
    speeds = sorted({level + side * INTENSITIES[3] for level in levels for side in (-1, 1)})
    return [right - speed for right, speed in zip(claim, [e for e in speeds if e > 0], strict=True)]


# The package's laws with branches; the formulas are written out once more. "linear" is the shape of a regularisation.
f_0, f_1, f_2 = (sp.Rational(k, 10) for k in (4, 3, 2))
LINES = laws.piecewise_linear(mu_s, [0, *BREAKS], [f_0, f_1, f_2], last_slope=b)
LINE_PIECES = (lambda w: f_0 - w / 2, lambda w: f_1 - (w - BREAKS[0]) / 4, lambda w: f_2 + b * (w - BREAKS[1]))
V_S = sp.Rational(1, 10)
CUBIC = sp.Rational(2, 5) - sp.Rational(9, 40) * (2 * v - sp.Rational(8, 3) * v**3)
LEVELLING = laws.piecewise_linear(mu_s, [0, *BREAKS], [f_0, f_1, f_1], last_slope=0)
BRANCHED = {
    "piecewise linear": (LINES, LINE_PIECES),
    "piecewise linear with two equal branches, tanh": (
        LEVELLING.regularised(V_S, "tanh"),
        (
            lambda w: (f_0 - w / 2) * sp.tanh(w / V_S),
            lambda w: f_1 * sp.tanh(w / V_S),
            lambda w: f_1 * sp.tanh(w / V_S),
        ),
    ),
    "Coulomb, linear": (laws.coulomb(mu).regularised(V_S), (lambda w: mu * w / V_S, lambda w: mu)),
    "Coulomb with static coefficient, linear": (
        laws.coulomb(mu_s, mu).regularised(V_S),
        (lambda w: mu_s * w / V_S, lambda w: mu_s + (mu - mu_s) * (w / V_S - 1), lambda w: mu),
    ),
    "cubic, linear": (
        laws.cubic(f_0, sp.Rational(1, 4), sp.Rational(1, 2)).regularised(V_S),
        (lambda w: f_0 * w / V_S, lambda w: CUBIC.subs(v, w - V_S)),
    ),
    "Thomsen regularised, (6)": (
        laws.thomsen_regularised(f_0, sp.Rational(1, 4), sp.Rational(1, 2), V_S),
        (lambda w: f_0 * w / V_S, lambda w: CUBIC.subs(v, (w - V_S) * sp.Rational(5, 4))),  # v_m/(v_m - v_s) = 5/4
    ),
    "Stribeck, linear": (
        laws.stribeck(mu_s, mu, c, b).regularised(V_S),
        (lambda w: mu_s * w / V_S, lambda w: STRIBECK.subs(v, w - V_S)),
    ),
}

for number, (name, (law, pieces)) in enumerate(BRANCHED.items(), 6):
    branched_row(number, f"{name}, q = 1/5 and 2/5", law, pieces, INTENSITIES[1:3])
