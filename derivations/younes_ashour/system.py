"""The rod and its contact: motion and loss of energy, (1)-(7)."""

from functools import cache

import sympy as sp

from derivations.ledger import Ledger
from symfric.model import laws
from symfric.model.symbols import SPEED
from symfric.theory import transient

PART = Ledger("younes_ashour", "modelling the system")

A, omega, mu_m, zeta, r, x0, v0, g, v_c = transient.DAMPER
m, k, mu, V = sp.symbols("m k mu V", positive=True)  # V: a speed |x'| > 0
x, v = sp.symbols("x v", real=True)  # position, velocity x'
BOTH = (1, -1)  # sides to which the rod may move

# --- Modelling the system ----------------------------------------------------------------------------------------
# The contact presses with N = r m g. While the rod slides, friction has the magnitude mu N and opposes the motion; the
# damper takes c x'^2 and friction mu N |x'|. The print leaves the sign open.


@PART.corrected(
    "(1)",
    "right-hand side of m x'' + c x' + k x while the rod slides; mu is the coefficient at its speed",
    right=-mu * r * m * g * sp.sign(v),
    printed=mu * r * m * g,
    note="printed with +-, without saying when; the sign is that of -x', else friction would feed the motion",
)
def _(claim):
    power = -mu * r * m * g * V  # friction takes this at speed V, to either side
    return [(claim * v).subs(v, side * V) - power for side in BOTH]


# At rest friction is what holds the rod: k x, as long as that is at most mu_m N. With k = m omega^2 the rod sticks
# within |x| <= mu_m r g/omega^2; it need not be where the spring is free.


@PART.verified("after (1) at rest", "largest |x| at which the rod sticks; beyond the source", mu_m * r * g / omega**2)
def _(claim):
    return sp.solve(k * x - mu_m * r * m * g, x)[0].subs(k, m * omega**2) - claim


@PART.corrected(
    "(2)",
    "right-hand side of x'' + 2 zeta omega x' + omega^2 x while the rod slides",
    right=-mu * r * g * sp.sign(v),
    printed=mu * r * g,
    note="the sign as in (1); the rest of (2) follows with c = 2 zeta omega m, k = m omega^2, N = r m g",
)
def _(claim):
    residuals = []
    for side in BOTH:
        newton = -2 * zeta * omega * m * v - m * omega**2 * x - mu * r * m * g * side
        left = newton / m + 2 * zeta * omega * v + omega**2 * x
        residuals.append(left - claim.subs(v, side * V))
    return residuals


# (3) must have its greatest value mu_m at rest, as the text says, and fall by the factor e over some speed v_c,
# whichever way the rod slides: d mu/d|x'| = -mu/v_c. The printed exponent has a dimension: v_c = 1 m/s is tacit in it,
# and is written out below. But it also has the sign of x', so that friction grows without bound for x' < 0.


@PART.corrected(
    "(3)",
    "friction against velocity; v_c = 1 m/s is tacit in the print",
    right=laws.exponential(mu_m, v_c).kinetic.subs(SPEED, sp.Abs(v)),
    printed=mu_m * sp.exp(-v / v_c),
    note="e^{-x'} makes friction exceed its 'maximum' mu_m for x' < 0; the two agree for x' > 0 only",
)
def _(claim):
    law = sp.Function("law")
    fall = sp.dsolve(law(V).diff(V) + law(V) / v_c, law(V), ics={law(0): mu_m}).rhs
    return [claim.subs(v, side * V) - fall for side in BOTH]


@PART.verified("(3) literal", "what the printed law makes of friction sliding backwards, over mu_m", sp.exp(V / v_c))
def _(claim):
    return (mu_m * sp.exp(-v / v_c)).subs(v, -V) / mu_m - claim


# (4): energy is the work done: stretching the spring from 0 to x0, or bringing the mass from 0 to v0.


@PART.corrected(
    "(4)",
    "energy given to the rod: by a displacement x0, by an impulse to v0",
    right=(k * x0**2 / 2, m * v0**2 / 2),
    printed=(k * x0**2 / 2, m * v0 / 2),
    note="the velocity lacks its square; the text before (4) also has x' = x0 for x = x0",
)
def _(spring, impulse):
    return sp.integrate(k * x, (x, 0, x0)) - spring, sp.integrate(m * v, (v, 0, v0)) - impulse


# (5): multiply (1) by x'. The energy E = m x'^2/2 + k x^2/2 falls at the rate c x'^2 + mu N |x'|. Over the path that is
# c x' dx and mu N |dx|; the sign of dx matters, because over a full swing the signed path is nearly zero.


@cache
def _loss(side):
    """Rate of loss of E sliding at speed V to one side: viscous part, contact part."""
    velocity = side * V
    acceleration = -2 * zeta * omega * velocity - omega**2 * x - mu * r * g * side
    loss = sp.expand(-(m * velocity * acceleration + m * omega**2 * x * velocity))
    return loss.coeff(zeta, 1) * zeta, loss.coeff(zeta, 0)


@PART.corrected(
    "(5) line 1",
    "initial energy less what damper and contact take, from x0 at rest to a stop after N half cycles, zeta = 0, mu "
    "constant",
    right=k * (x0 - 2 * transient.SYMBOLS.delta * sp.Symbol("N", integer=True)) ** 2 / 2,
    printed=0,
    note="the rod does not stop at x = 0: the elastic energy k x_f^2/2 stays in the spring. (5) has no place for it",
)
def _(claim):
    # friction mu N = k delta acts along strokes of 2 (x0 - (2 n - 1) delta), n = 1..N (handbook, Example 19.5)
    delta, count, n = transient.SYMBOLS.delta, sp.Symbol("N", integer=True), sp.Symbol("n", integer=True)
    path = sp.summation(2 * (x0 - (2 * n - 1) * delta), (n, 1, count))
    return k * x0**2 / 2 - k * delta * path - claim


@PART.verified("(5) line 2 viscous", "integrand over dx", 2 * zeta * omega * m * v)
def _(claim):
    return [_loss(side)[0] - (claim * v).subs(v, side * V) for side in BOTH]


@PART.corrected(
    "(5) line 2 contact",
    "integrand over dx",
    right=mu * r * m * g * sp.sign(v),
    printed=mu * r * m * g,
    note="with dx signed the printed integral is mu r m g (x_f - x0) for constant mu, negative from x0 > 0",
)
def _(claim):
    return [_loss(side)[1] - (claim * v).subs(v, side * V) for side in BOTH]


@PART.corrected(
    "(5) line 3",
    "integrands over dt in the brackets after m: viscous, contact",
    right=(2 * zeta * omega * v**2, mu * r * g * sp.Abs(v)),
    printed=(2 * zeta * omega * v, mu * r * g * x),
    note="the printed integrands are no powers per mass: dx = x' dt was not put in",
)
def _(viscous, contact):
    found = []
    for side in BOTH:
        at = {v: side * V}
        found += [_loss(side)[0] - m * viscous.subs(at), _loss(side)[1] - m * contact.subs(at)]
    return found


PART.definition("(6)", "dissipation ratio R", sp.Symbol("E_viscous") / sp.Symbol("E_contact"))

# After (6) the text compares the two losses at a given speed. Both powers: the viscous one goes with x'^2, not x' (that
# is the force); the contact one with |x'| e^{-|x'|/v_c}. Their ratio rises with speed from zero, which is what the text
# concludes.


@PART.verified(
    "after (6)",
    "viscous over contact power at speed V: rises from 0",
    2 * zeta * omega * V * sp.exp(V / v_c) / (mu_m * r * g),
)
def _(claim):
    viscous, contact = _loss(1)
    return viscous / contact.subs(mu, laws.exponential(mu_m, v_c).kinetic.subs(SPEED, V)) - claim
