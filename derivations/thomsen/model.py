"""Thomsen's mass on a moving belt: letters, equation of motion, friction function, (1)-(6)."""

from functools import cache

import sympy as sp

from derivations.ledger import Ledger
from derivations.residuals import less
from symfric.model.laws import cubic, thomsen_regularised
from symfric.model.symbols import SPEED
from symfric.theory import belt

PART = Ledger("thomsen", "2: the model")

# Letters. Dimensionless ones are those of symfric.theory.belt; x, v = x' are position and velocity of the mass, w = v -
# v_b its velocity relative to the belt. MU stands for any friction law, odd or not; a check puts a polynomial with free
# coefficients in its place, so that what it finds holds for every law that a polynomial can follow.
v_b, beta, gamma2, a, Omega, mu_s, mu_m, v_m = belt.SYMBOLS
x, v, mu = sp.symbols("x v mu", real=True)
tau, psi = sp.symbols("tau psi", real=True)
MU = sp.Function("MU")
FREE = sp.symbols("m0:6", real=True)

ETA = belt.friction_difference(symbolic=True)
V_B1 = belt.onset_speed(symbolic=True)
V_B0 = belt.stick_speed(symbolic=True)

# Self-excited vibration needs eta > 2 beta. Written in d = mu_s - mu_m, eta and the onset speed v_1 of (19),
#     mu_s = mu_m + d,   gamma2 = 2 eta v_m/(3 d),   2 beta = eta (1 - v_1^2/v_m^2),
# all letters are positive and the square roots of the paper become those of positive numbers.
d, eta, v_1, speed = sp.symbols("d eta v_1 v_b", positive=True)
REGIME = {
    mu_s: mu_m + d,
    gamma2: 2 * eta * v_m / (3 * d),
    beta: eta * (1 - v_1**2 / v_m**2) / 2,
    v_b: speed,
}


def in_regime(expr) -> sp.Expr:
    """Write an expression in the letters of the unstable regime."""
    return sp.sympify(expr).subs(REGIME, simultaneous=True)


def any_law(expr) -> sp.Expr:
    """Put a polynomial with free coefficients in the place of MU."""
    return expr.replace(MU, lambda w: sum(m * w**k for k, m in enumerate(FREE)))


# The example of figure 3.
FIGURE_3 = {
    mu_s: sp.Rational(2, 5),
    mu_m: sp.Rational(1, 4),
    v_m: sp.Rational(1, 2),
    beta: sp.Rational(1, 20),
    gamma2: sp.Integer(1),
    v_b: sp.Rational(1, 5),
}


# --- 2.1 Equation of motion -------------------------------------------------------------------------------------------
# Newton for the mass M on the spring K, with the damper C, friction M g mu and the rotating unbalance m r:
#     M X'' = -K X - C X' - M g mu(V_r) + m r W^2 sin(W t),   V_r = X' - V_b,
# primes d/dt. With X = L x and tau = w0 t a derivative d/dt is w0 d/dtau, whatever w0 is; divided by M L w0^2 the
# acceleration is that of `newton`. Friction depends on the relative speed V_r/(w0 L) = v - V_b/(w0 L).
M, K, C, g, L, m, r, W, V, w0 = sp.symbols("M K C g L m r W V w0", positive=True)
SINE = sp.Symbol("sine", real=True)  # sin(W t) = sin(Omega tau)
DIMENSIONLESS = {K: M * w0**2, C: 2 * beta * M * w0, g: gamma2 * L * w0**2, m: a * M * L / r, W: Omega * w0}


def newton(velocity=v):
    """x'' in tau, from Newton's law."""
    force = -K * L * x - C * w0 * L * velocity - M * g * mu + m * r * W**2 * SINE
    return sp.expand(force / (M * L * w0**2))


def acceleration(friction_coefficient, position=x, velocity=v):
    """x'' of (1) without excitation."""
    return -position - 2 * beta * velocity - gamma2 * friction_coefficient


@PART.verified("(1)", "equation of motion, solved for x''", a * Omega**2 * SINE - 2 * beta * v - x - gamma2 * mu)
def _(claim):
    return sp.expand(newton().subs(DIMENSIONLESS, simultaneous=True)) - claim


# (2) follows if the coefficients of x'' and x are both to be 1: that fixes w0, and the others can be read off.
@PART.corrected(
    "(2)",
    "natural frequency squared; gamma^2, 2 beta, a, v_b, Omega",
    right=(K / M, (g / L) / (K / M), C / sp.sqrt(K * M), m * r / (M * L), V / (sp.sqrt(K / M) * L), W / sp.sqrt(K / M)),
    printed=(
        K / m,
        (g / L) / (K / M),
        C / sp.sqrt(K * M),
        m * r / (M * L),
        V / (sp.sqrt(K / M) * L),
        W / sp.sqrt(K / M),
    ),
    note="k is not defined and m is the unbalanced mass; with K/m the spring term would have the coefficient m/M",
)
def _(*claims):
    x2 = newton()
    (square,) = sp.solve(x2.coeff(x) + 1, w0**2)
    time = sp.sqrt(square)
    found = (
        square,
        -x2.coeff(mu).subs(w0, time),
        -x2.coeff(v).subs(w0, time),
        (x2.coeff(SINE) / (W / w0) ** 2).subs(w0, time),
        V / (time * L),
        W / time,
    )
    return less(found, claims)


# (3), (4). Energies M (L w0 v)^2/2 and so on, and works of the forces, in the unit that makes the kinetic one v^2/2.
KINETIC, POTENTIAL = v**2 / 2, x**2 / 2
INPUT = a * Omega**2 * v * SINE
DISSIPATED = 2 * beta * v**2 + gamma2 * v * mu
UNIT = K * L**2


@PART.verified("(3)", "rate of the mechanical energy: input less dissipated", INPUT - DISSIPATED)
def _(claim):
    x2 = newton().subs(DIMENSIONLESS, simultaneous=True)
    return sp.expand(KINETIC.diff(v) * x2 + POTENTIAL.diff(x) * v - claim)


@PART.verified(
    "(4)", "kinetic and potential energy; integrands of input and dissipated", KINETIC, POTENTIAL, INPUT, DISSIPATED
)
def _(*claims):
    per_tau = L * w0 * v / w0  # velocity times dt/dtau
    found = (
        M * (L * w0 * v) ** 2 / 2,
        K * (L * x) ** 2 / 2,
        m * r * W**2 * SINE * per_tau,
        (C * L * w0 * v + M * g * mu) * per_tau,
    )
    return less([(f / UNIT).subs(DIMENSIONLESS, simultaneous=True) for f in found], claims)


@PART.corrected(
    "after (4)", "unit of energy", right=UNIT, printed=sp.Symbol("k") * L**2, note="k is not defined; the spring is K"
)
def _(claim):
    return (M * (L * sp.sqrt(K / M) * v) ** 2 / 2) / KINETIC - claim


# Friction pulls the mass with -gamma2 mu and the belt with +gamma2 mu. What becomes heat is minus the power of both and
# of the damper. E_dis of (4) exceeds it by gamma2 mu v_b, which the belt's drive exchanges, with either sign.
@PART.corrected(
    "(4) line 3",
    "power that is dissipated",
    right=2 * beta * v**2 + gamma2 * (v - v_b) * mu,
    printed=DISSIPATED,
    note="E_dis contains the work gamma2 mu v_b of the belt's drive and is not sign definite: with 0 < v < v_b, "
    "beta = 0, the mass gains energy; the balance (3) itself is right",
)
def _(claim):
    damper = -2 * beta * v * v
    contact = (-gamma2 * mu) * v + (gamma2 * mu) * v_b
    return sp.expand(-(damper + contact) - claim)


# --- 2.2 Friction function --------------------------------------------------------------------------------------------
# Odd, with a linear and a cubic term beside the jump mu_s: the minimum mu_m at v_m gives two equations for the two.
LAW = cubic(mu_s, mu_m, v_m).kinetic
POSITIVE = sp.Symbol("v", positive=True)


def friction(w, side: int):
    """(5) for a relative velocity w of the given sign, continued as a polynomial."""
    return side * LAW.subs(SPEED, side * w)


@cache
def cubic_through_minimum(shifted, at):
    """mu_s + c1 s + c3 s^3 of the shifted speed, with value mu_m and slope zero where it is `at`."""
    c1, c3, s = sp.symbols("c1 c3 s")
    shape = mu_s + c1 * s + c3 * s**3
    found = sp.solve([shape.subs(s, at) - mu_m, shape.diff(s).subs(s, at)], [c1, c3], dict=True)[0]
    return shape.subs(found).subs(s, shifted)


@PART.verified("(5)", "friction law for v_r > 0", LAW.subs(SPEED, POSITIVE))
def _(claim):
    return cubic_through_minimum(POSITIVE, v_m) - claim


v_s, u_s = sp.symbols("v_s u_s", positive=True)


def shifted_law(start):
    s = (POSITIVE - v_s) / (v_m - v_s)
    return start - sp.Rational(3, 2) * (mu_s - mu_m) * (s - s**3 / 3)


# (6): a line through the origin up to mu_s at v_s, then the same cubic in v - v_s with its minimum still at v_m.
@PART.corrected(
    "(6)",
    "regularised law below and above v_s",
    right=(mu_s * POSITIVE / v_s, shifted_law(mu_s)),
    printed=(mu_s * POSITIVE / v_s, shifted_law(u_s)),
    note="u_s is not defined; with mu_s the law is continuous at v_s, has its minimum mu_m at v_m and tends to (5)",
)
def _(below, above):
    slope = sp.Symbol("slope")
    (found,) = sp.solve(slope * v_s - mu_s, slope)
    smooth = cubic_through_minimum(POSITIVE - v_s, v_m - v_s)
    package = [e.subs(SPEED, POSITIVE) for e, _ in thomsen_regularised(mu_s, mu_m, v_m, v_s).kinetic.args]
    return found * POSITIVE - below, smooth - above, package[0] - below, package[1] - above


# `Law.regularised` moves (5) by v_s as a whole: the same at v_s, another law beyond it, by the first order in v_s.
@PART.verified(
    "(6) moved",
    "places of the minimum: of (6), and of (5) moved by v_s; beyond the source",
    v_m,
    v_m + v_s,
)
def _(*claims):
    found = []
    for law in (thomsen_regularised(mu_s, mu_m, v_m, v_s), cubic(mu_s, mu_m, v_m).regularised(v_s)):
        slope = law.kinetic.args[-1].expr.diff(SPEED)
        found.append(max(sp.solve(slope, SPEED), key=lambda e: e.subs({v_m: 2, v_s: 1})))
    return less(found, claims)
