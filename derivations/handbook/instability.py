"""Friction that falls with speed makes steady sliding unstable, (19.109)."""

import sympy as sp

from derivations.handbook.models import V, alpha, b, f_d, k, m, omega, v_c, x, y
from derivations.ledger import Ledger
from symfric.model import laws
from symfric.model.symbols import SPEED

PART = Ledger("handbook", "19.5.2: instability")

# (19.109) is the motion of a mass that slides steadily at speed V over its counterpart, disturbed by y: the friction
# f(V + y') expanded about V. So b there is the slope of friction at V, not a property of the origin.
FRICTION = laws.lorentz(f_d, v_c, b=b).kinetic
SLOPE = FRICTION.diff(SPEED).subs(SPEED, V)
y1, y2 = sp.symbols("y1 y2", real=True)  # y', y''


@PART.verified("(19.109)", "b is the slope of friction at the nominal sliding speed V", m * y2 + SLOPE * y1 + k * y)
def _(claim):
    small = sp.Symbol("epsilon", positive=True)
    steady = -FRICTION.subs(SPEED, V) / k  # position of steady sliding
    newton = m * small * y2 + k * (steady + small * y) + FRICTION.subs(SPEED, V + small * y1)
    return newton.diff(small).subs(small, 0) - claim


@PART.verified("after (19.109) growth", "growth rate of an oscillation for b^2 < 4 m k", -alpha / (2 * m))
def _(claim):
    rate = sp.Symbol("lambda")
    roots = sp.roots(m * rate**2 + alpha * rate + k, rate)  # alpha stands for b of either sign; the roots are conjugate
    return sum(roots) / 2 - claim


# The text starts from x' = 0 and takes b < 0 there. Without nominal sliding friction reverses with x', and an
# expansion about the origin does not exist: the energy changes at the rate -f x' = -f_sb(|x'|) |x'| - b x'^2 <= 0.


@PART.corrected(
    "after (19.109) from rest",
    "rate of change of the energy without nominal sliding, speed V",
    right=-FRICTION.subs(SPEED, V) * V,
    printed=-FRICTION.diff(SPEED).subs(SPEED, V) * V**2,
    note="negative at every speed, while the printed reading, -f'(V) V^2, is positive where friction falls: nothing "
    "is destabilised unless the surfaces slide past each other on average",
)
def _(claim):
    rates = []
    for side in (1, -1):
        velocity = side * V
        acceleration = (-k * x - FRICTION.subs(SPEED, V) * side) / m
        rates.append(m * velocity * acceleration + k * x * velocity - claim)
    return rates


# "The growing and decaying cycle" settles on a limit cycle. To first order in the friction its frequency is that of the
# spring and the mass: with y = A cos p, y' = -A omega_n sin p the shift is proportional to the mean of f cos p, which
# vanishes for every f that depends on the velocity alone. Carried out for a friction of degree five about V.


@PART.verified("after (19.109) frequency", "shift of frequency by friction, first order", 0)
def _(claim):
    p = sp.Symbol("p", real=True)
    amplitude, coefficients = sp.Symbol("A", positive=True), sp.symbols("f0:6", real=True)
    force = sum(c * (-amplitude * omega * sp.sin(p)) ** n for n, c in enumerate(coefficients))
    return sp.integrate(sp.expand(force * sp.cos(p)), (p, 0, 2 * sp.pi)) / (2 * sp.pi * m * omega * amplitude) - claim
