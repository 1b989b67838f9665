"""The structure on rolling bearings and its motion, section 2.1."""

import sympy as sp

from derivations.ledger import Ledger
from symfric.theory import scaling

PART = Ledger("rolling_isolation", "2.1: the structure")

L, D = scaling.SYMBOLS
f = scaling.factors(symbolic=True)  # model over prototype, in L and D
m, C, mu, g, V, R, step = sp.symbols("m C mu g V R dt", positive=True)  # V: a speed |v_s - v_e| > 0
u, w, a_e = sp.symbols("u w a_e", real=True)  # d_s - d_e, v_s - v_e, acceleration of the ground
BOTH = (1, -1)

# --- Section 2.1: the structure ----------------------------------------------------------------------------------
# The structure feels the ground through the damper, which pulls it along with C (v_e - v_s), and through the rollers,
# whose friction mu m g opposes the relative motion. The print leaves the sign open; it is that of v_e - v_s, so that
# both take power from the relative motion.


def _newton(side, speed, friction=mu, gravity=g, damping=C, mass=m):
    """Acceleration a_s while the structure moves past the ground at a speed to one side."""
    velocity = side * speed  # v_s - v_e
    return (-side * friction * mass * gravity - damping * velocity) / mass


@PART.corrected(
    "Section 2.1 motion",
    "force m a_s on the structure while it rolls",
    right=-sp.sign(w) * mu * m * g - C * w,
    printed=mu * m * g - C * w,
    note="printed with +-, without saying when; the sign is that of v_e - v_s",
)
def _(claim):
    # the power given to the relative motion is that taken by friction and damper, to both sides
    return [(claim * w).subs(w, side * V) + mu * m * g * V + C * V**2 for side in BOTH]


@PART.verified(
    "Section 2.1 relative motion", "u'' of u = d_s - d_e; beyond the source", -sp.sign(w) * mu * g - C / m * w - a_e
)
def _(claim):
    return [_newton(side, V) - a_e - claim.subs(w, side * V) for side in BOTH]


@PART.verified("Section 2.1 damper", "C sgn(v)|v|^alpha for alpha = 1, v = v_e - v_s", -C * w)
def _(claim):
    alpha = sp.Symbol("alpha", positive=True)
    force = C * sp.sign(-w) * sp.Abs(w) ** alpha
    return [(force.subs(alpha, 1) - claim).subs(w, side * V) for side in BOTH]


@PART.verified(
    "Section 2.1 damping ratio",
    "largest equivalent damping ratio, C = 200 kN s/m, m = 300 t, T = 4.5 s: below 25 %",
    sp.Rational(3, 4) / sp.pi,
)
def _(claim):
    stiffness, omega = sp.symbols("stiffness omega", positive=True)
    critical = 2 * sp.sqrt(stiffness * m)
    ratio = (C / critical).subs(stiffness, m * omega**2).subs(omega, 2 * sp.pi / sp.Rational(9, 2))
    found = ratio.subs({C: 200, m: 300})
    return found - claim, sp.Max(found, sp.Rational(1, 4)) - sp.Rational(1, 4)


@PART.verified(
    "Section 2.1 variation",
    "friction variation coefficients of cases 2 and 3",
    sp.Rational("0.163"),
    sp.Rational("0.471"),
)
def _(*claim):
    return [sp.Rational(s) / sp.Rational("0.005") - c for s, c in zip(("0.000815", "0.002355"), claim, strict=True)]


PART.unverifiable(
    "Figure 2",
    "friction along the surface in cases 2 and 3",
    "range, mean and standard deviation are given, cells and realisation are not",
)
PART.unverifiable("Section 2.2", "20 motions fitted to the spectrum of JTJ 004-89", "the records are not named")
