"""Mass on a moving belt, beyond the numbered equations of Thomsen's paper.

x'' + 2 beta x' + x + gamma2 mu(x' - v_b) = a Omega^2 sin(Omega t) with the cubic law, where eta = (3/2) gamma2 (mu_s -
mu_m)/v_m and beta are small; u = x - xbar is measured from steady sliding. In order: how steady sliding is lost, pure
slip to second order, the cycle that sticks to first order, power and thresholds under fast vibration.
"""

from functools import cache

import sympy as sp

from derivations.effective_friction import branch
from derivations.ledger import Ledger
from derivations.oscillations import AMPLITUDE as A
from derivations.oscillations import BELT, PLANAR, c02, c03, extreme, oscillation
from derivations.residuals import less
from derivations.thomsen.effective import ALPHA1, ALPHA3, over_a_period
from derivations.thomsen.model import (
    ETA,
    LAW,
    Omega,
    a,
    beta,
    eta,
    friction,
    gamma2,
    in_regime,
    mu_m,
    mu_s,
    speed,
    v_1,
    v_b,
    v_m,
)
from derivations.thomsen.separation import T, q, shaken, v_r
from symfric.model.symbols import SPEED
from symfric.theory import belt
from symfric.theory.belt.slip import EXCESS, KAPPA

LEDGER = Ledger(
    "thomsen_beyond",
    "Thomsen's mass on a belt beyond his paper: the Hopf coefficient, pure slip to second order, stick-slip to first "
    "order, the mean power of fast vibration, exact thresholds",
)

u, t = sp.symbols("u t", real=True)


# eta and v_1 = v_b1 instead of gamma2 and beta, so h1 = -eta (v_1^2 - v_b^2)/v_m^2, and `speed` for v_b.
def plain(expr):
    """Write a formula in the letters of the unstable regime."""
    return sp.simplify(in_regime(expr))


# --- 1. How steady sliding is lost --------------------------------------------------------------------------------
# While the mass slips backward the force of damping and friction, without its value at u' = 0, is a cubic in u'.
DAMPING = sp.expand(2 * beta * u - gamma2 * (LAW.subs(SPEED, v_b - u) - LAW.subs(SPEED, v_b)))
H = tuple(DAMPING.coeff(u, k) for k in (1, 2, 3))


@LEDGER.verified("1.1", "coefficient a of A' = sigma A + a A^3 at v_b1", -eta / (8 * v_m**2))
def _(claim):
    # from the general coefficient of `oscillations.py`, in which the square of u' alone does not appear
    others = dict.fromkeys(PLANAR.free_symbols - {c02, c03}, 0)
    return claim - plain(PLANAR.subs({**others, c02: H[1], c03: H[2]}))


# a < 0 for every v_b1: as steady sliding is lost the cycle is born small and stable, and its amplitude is that of (20)
# near v_b1, A^2 = -sigma/a with the growth sigma = -h1/2.
@LEDGER.verified("1.2", "A^2 by the normal form", 4 * (v_1**2 - speed**2))
def _(claim):
    return claim - plain((-H[0] / 2) / (3 * H[2] / 8))


# --- 2. Pure slip to second order ---------------------------------------------------------------------------------
# A' = f1 + f2 + f3 with f2 = 0 vanishes at A = A0 + A2: f1(A0) = 0 is (16), and f1'(A0) A2 = -f3(A0). Half range and
# largest velocity are A0 + A2 and what u1, u2 add at A0.
h1, h2, h3 = LETTERS = sp.symbols("h1 h2 h3", real=True)
A0 = 2 * sp.sqrt(v_1**2 - speed**2)


@cache
def second_order():
    """Relative corrections of half range, frequency and largest velocity at the amplitude A0."""
    f, g, waves, speeds = oscillation(BELT, LETTERS)
    shift = -f[3] / f[1].diff(A) / A
    top, bottom, fastest = extreme(waves, 0), extreme(waves, 2), extreme(speeds, 3)
    corrections = (top[2] - bottom[2]) / (2 * A) + shift, g[2], fastest[2] / A + shift
    on_cycle = (e.subs(h1, -sp.Rational(3, 4) * h3 * A**2) for e in corrections)
    return tuple(plain(e.subs(dict(zip(LETTERS, H, strict=True)))).subs(A, A0) for e in on_cycle)


@LEDGER.verified("2.1", "half range in pure slip", belt.pure_slip_amplitude(order=2, symbolic=True))
def _(claim):
    return plain(claim) - A0 * (1 + second_order()[0])


@LEDGER.verified("2.2", "frequency in pure slip", belt.pure_slip_frequency(order=2, symbolic=True))
def _(claim):
    return plain(claim) - 1 - second_order()[1]


# Sticking starts where the largest velocity A0 (1 + w(v)) reaches v: A0^2 (1 + 2 w) = v^2. Without w this is v0^2 =
# (4/5) v_1^2, and to first order in w it is v = v0 (1 + w(v0)/5).
@LEDGER.verified("2.3", "speed below which it sticks", belt.stick_speed(order=2, symbolic=True))
def _(claim):
    k, w = sp.symbols("k w")
    v0 = 2 * v_1 / sp.sqrt(5)
    balance = (4 * (v_1**2 - speed**2) * (1 + 2 * w) - speed**2).subs(speed, v0 * (1 + k))
    first = balance.subs({k: k * t, w: w * t}).diff(t).subs(t, 0)
    (shift,) = sp.solve(first, k)
    return plain(claim) - v0 * (1 + shift.subs(w, second_order()[2].subs(speed, v0)))


# --- 3. Stick-slip to first order ---------------------------------------------------------------------------------
# Sticking ends at gamma2 mu_s - 2 beta v_b (25), above steady sliding by kappa v_b.
@LEDGER.verified("3.1", "release above steady sliding, over v_b", KAPPA)
def _(claim):
    return claim - sp.simplify((gamma2 * mu_s - 2 * beta * v_b - gamma2 * LAW.subs(SPEED, v_b)) / v_b)


# The slip that follows is u = v_b sin(t) + u1 to first order in eta and beta, from u1 = kappa v_b and u1' = 0:
# u1'' + u1 = -h(v_b cos(t)) by Duhamel's integral.
@cache
def slip():
    """u1(t)."""
    s = sp.Symbol("s", real=True)
    h = sum(coefficient * (v_b * sp.cos(s)) ** k for k, coefficient in enumerate(H, 1))
    forced = sp.integrate(sp.expand(sp.sin(t - s) * h, trig=True), (s, 0, t))
    return KAPPA * v_b * sp.cos(t) - forced


@LEDGER.verified("3.2", "slip to first order, v_b sin(t) + u1 with u1 =", slip())
def _(claim):
    h = sum(coefficient * (v_b * sp.cos(t)) ** k for k, coefficient in enumerate(H, 1))
    return (claim.diff(t, 2) + claim + h).rewrite(sp.exp), claim.subs(t, 0) - KAPPA * v_b, claim.diff(t).subs(t, 0)


# Extremes move by first order only: they are at t = pi/2 and 3 pi/2, where u1 adds to +-v_b.
@LEDGER.verified("3.3", "half range, first order", belt.stick_slip_amplitude(order=2, symbolic=True))
def _(claim):
    top, bottom = (v_b * sp.sin(at) + slip().subs(t, at) for at in (sp.pi / 2, 3 * sp.pi / 2))
    return claim - (top - bottom) / 2


# It meets the amplitude of pure slip (20) where this equals v_b, at v_b0; in the value, though not in the slope.
@LEDGER.verified("3.4", "v_b0, where both half ranges are v_b", belt.stick_speed(symbolic=True))
def _(claim):
    stuck = belt.stick_slip_amplitude(order=2, symbolic=True).subs(v_b, claim)
    slipping = belt.pure_slip_amplitude(symbolic=True).subs(v_b, claim)
    return plain(claim) - 2 * v_1 / sp.sqrt(5), plain(stuck - claim), plain(slipping**2 - claim**2)


@LEDGER.verified("3.5", "half range on a slow belt", belt.slow_belt_amplitude(order=2, symbolic=True))
def _(claim):
    top, bottom = (sp.sin(at) + slip().subs(t, at) / v_b for at in (sp.pi / 2, 3 * sp.pi / 2))
    return claim / v_b - sp.simplify((top - bottom) / 2).subs(v_b, 0)


# One period after the release the velocity, which has fallen and come back, would exceed v_b by the share d; for d > 0,
# that is v_b < v_b0, the mass is caught before.
@LEDGER.verified("3.6", "excess d of the velocity after one period", EXCESS)
def _(claim):
    return claim - slip().diff(t).subs(t, 2 * sp.pi) / v_b


# It is caught at t = 2 pi - alpha, where cos(alpha) + u1'(t)/v_b = 1. With eta and beta of order D^2, d = D^2 d2, alpha
# is of order D: alpha = D s1 + D^2 s2 + ... Sticking lasts (u(0) - u(t))/v_b. The period is the sum, 2 pi and terms
# from D^3 on, of order eta^(3/2); the next, of order eta^2, would take u2.
D, d2, s1, s2, bend, kappa = sp.symbols("D d2 s1 s2 bend kappa", positive=True)


@LEDGER.verified("3.7", "period", 2 * sp.pi + 2 * sp.sqrt(2) / 3 * (D**2 * d2) ** sp.Rational(3, 2))
def _(claim):
    alpha = D * s1 + D**2 * s2
    # u1/v_b near 2 pi: the value kappa of t = 0 again, slope d, some curvature
    near = D**2 * (kappa - d2 * alpha + bend * alpha**2)
    again = slip().subs(t, 2 * sp.pi) / v_b - KAPPA
    caught = sp.series(sp.cos(alpha) + D**2 * (d2 - 2 * bend * alpha) - 1, D, 0, 3).removeO()
    start = sp.solve(caught.coeff(D, 2), s1)[0]
    period = 2 * sp.pi - alpha + D**2 * kappa - (-sp.sin(alpha) + near)
    expanded = sp.series(period, D, 0, 4).removeO().subs(s1, start)
    return again, sp.expand(claim - expanded)


# The package's formula is this period and terms of the orders left out. With b = sqrt(d^2 + 2 d), the tangent of the
# angle whose cosine is 1/(1 + d), it is 2 pi + kappa - atan(kappa) + b - atan(b).
@LEDGER.verified("3.8", "frequency", belt.stick_slip_frequency(order=2, symbolic=True))
def _(claim):
    d = sp.Symbol("d", positive=True)
    tangent = sp.sqrt(d**2 + 2 * d)
    form = 2 * sp.pi / claim.replace(sp.Max, lambda *_: d)
    whole = 2 * sp.pi + KAPPA - sp.atan(KAPPA) + tangent - sp.acos(1 / (1 + d))  # acos is atan(tangent)
    small = (tangent - sp.atan(tangent)).subs(d, D**2 * d2)
    leading = sp.series(small, D, 0, 4).removeO()
    gone = sp.series(kappa * D**2 - sp.atan(kappa * D**2), D, 0, 4).removeO()
    return (
        form - whole,
        sp.expand((1 + d) ** 2 - 1 - tangent**2),
        leading - 2 * sp.sqrt(2) / 3 * (D**2 * d2) ** sp.Rational(3, 2),
        gone,
    )


# --- 4. Power under fast vibration --------------------------------------------------------------------------------
# The fast motion is x' = -q cos(Omega t), q = a Omega (37). The equation of motion, multiplied by x' and averaged over
# a period, in which x and x' return to what they were, says what power the force spends, exactly:
x = sp.Function("x")(t)
M = sp.Function("m")  # friction with its sign, of the slip velocity


@LEDGER.verified(
    "4.1",
    "power of the force less the rate of x'^2/2 + x^2/2",
    2 * beta * x.diff(t) ** 2 + gamma2 * M(x.diff(t) - v_b) * x.diff(t),
)
def _(claim):
    motion = x.diff(t, 2) + 2 * beta * x.diff(t) + x + gamma2 * M(x.diff(t) - v_b)  # equals the force
    return sp.expand(motion * x.diff(t) - ((x.diff(t) ** 2 + x**2) / 2).diff(t) - claim)


FAST = -q * sp.cos(T)


def mean(integrand):
    """Mean over the fast period of integrand(sign of the slip velocity), for v_b < q and for v_b > q."""
    return [over_a_period(integrand, side).subs(v_r, -speed) for side in (0, -1)]


def piece(expr, at):
    """Put q = a Omega and take the branch that holds for v_b < q (at = 1) or v_b > q (at = 3)."""
    return branch(shaken(expr).subs(v_b, speed), {q: 2, speed: at})


def both(claim, derived):
    """What is left of a claim below and above v_b = q."""
    return less((piece(claim, at) for at in (1, 3)), derived)


@cache
def power():
    return mean(lambda sign: FAST * (2 * beta * FAST + gamma2 * friction(FAST + v_r, sign)))


@LEDGER.verified("4.2", "mean power", belt.mean_power(symbolic=True))
def _(claim):
    return [left.rewrite(sp.asin) for left in both(claim, power())]


# The belt's drive overcomes the mean friction and spends gamma2 mubar(v_b) v_b, which is v_b times (51). Together they
# cover what the damper and the sliding dissipate.
@LEDGER.verified(
    "4.3",
    "power of force and belt",
    belt.mean_power(symbolic=True) + v_b * belt.quasi_equilibrium_position(symbolic=True),
)
def _(claim):
    dissipated = mean(lambda sign: 2 * beta * FAST**2 + gamma2 * (FAST + v_r) * friction(FAST + v_r, sign))
    return [left.rewrite(sp.asin) for left in both(claim, dissipated)]


# For v_b > q the power is q^2/2 times 2 beta + gamma2 mubar'(v_b), the damping that (52) speaks of, and something less:
# where the quasi-equilibrium is unstable the belt drives the vibration, and the force takes power out.
@LEDGER.verified(
    "4.4",
    "mean power by the effective slope, v_b > a Omega",
    q**2 / 2 * (2 * beta + gamma2 * belt.effective_slope(symbolic=True)) - ETA * q**4 / (8 * v_m**2),
)
def _(claim):
    return piece(claim, 3) - power()[1]


# --- 5. Thresholds under fast vibration -----------------------------------------------------------------------------
# Slow belts, v_b < q. The slope of the effective friction is least at rest, because its own slope is positive: the jump
# gives (2 mu_s/pi)/sqrt(q^2 - v^2), and the rest of the law the mean of alpha1 + 3 alpha3 w^2.
ROOT = sp.sqrt(q**2 - speed**2)
SLOW_SLOPE = 2 * mu_s / (sp.pi * ROOT) + ALPHA1 + 3 * ALPHA3 * (speed**2 + q**2 / 2)


@LEDGER.verified("5.1", "slope of the effective friction, v_b < a Omega", belt.effective_slope(symbolic=True))
def _(claim):
    return piece(claim, 1) - SLOW_SLOPE


@LEDGER.verified(
    "5.2", "its slope, positive", 2 * mu_s * speed / (sp.pi * sp.sqrt(q**2 - speed**2) ** 3) + 6 * ALPHA3 * speed
)
def _(claim):
    return claim - SLOW_SLOPE.diff(speed)


# So slower belts are stable too if the slope at rest with damping is positive. It is convex in the intensity.
@LEDGER.verified("5.3", "second derivative of the slope at rest, positive", 4 * mu_s / (sp.pi * q**3) + 3 * ALPHA3)
def _(claim):
    return claim - shaken(belt.effective_damping(symbolic=True)).diff(q, 2)


# The exact upper end of the range. By Liouville the two Floquet multipliers of a periodic motion in pure slip have a
# product that passes 1 where 2 beta + gamma2 mu'(|w|), mu' = alpha1 + 3 alpha3 w^2, has the mean 0. As x' has none,
# <w^2> is v_b^2 + <x'^2>.
w, spread = sp.symbols("w spread", positive=True)  # spread: <x'^2>


@LEDGER.verified("5.4", "belt speed above which the fast motion in pure slip is stable", sp.sqrt(v_1**2 - spread))
def _(claim):
    rate = plain(2 * beta + gamma2 * LAW.diff(SPEED).subs(SPEED, w))
    return rate.subs(w, sp.sqrt(claim**2 + spread)), claim.subs({v_1: 2, spread: 3}) - 1


# With q^2/2 for <x'^2> this is the upper end of (55). The spring makes the fast velocity greater, damping aside: with
# q/(1 - Omega^-2) in place of q (55) is a hundred times better, as tests/derivations/test_thresholds.py measures.
@LEDGER.verified("5.5", "amplitude of the fast velocity", a * Omega / (1 - Omega**-2))
def _(claim):
    motion = -claim / Omega * sp.sin(Omega * t)
    return motion.diff(t, 2) + motion - a * Omega**2 * sp.sin(Omega * t)


@LEDGER.verified("5.6", "upper end of (55) from <x'^2> = q^2/2", belt.unstable_speeds(symbolic=True)[1])
def _(claim):
    return plain(shaken(claim)) - sp.sqrt(v_1**2 - spread).subs(spread, q**2 / 2)


# Any law c0 - c1 s + c3 s^3 is the cubic one: smallest, mu_m, at v_m, and mu_s = c0.
c0, c1, c3 = sp.symbols("c0 c1 c3", positive=True)


@LEDGER.verified(
    "5.7",
    "v_m and mu_m from the coefficients",
    sp.sqrt(c1 / (3 * c3)),
    c0 - 2 * c1 / 3 * sp.sqrt(c1 / (3 * c3)),
)
def _(*claim):
    law = c0 - c1 * SPEED + c3 * SPEED**3
    return law - LAW.subs({mu_s: c0, v_m: claim[0], mu_m: claim[1]}), law.diff(SPEED).subs(SPEED, claim[0])
