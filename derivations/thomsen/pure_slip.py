"""Thomsen's mass on a moving belt: steady sliding, averaging, vibration in pure slip, (7)-(22)."""

from functools import cache

import sympy as sp

from derivations.ledger import Ledger
from derivations.residuals import less
from derivations.thomsen.model import (
    ETA,
    FREE,
    LAW,
    MU,
    V_B0,
    V_B1,
    acceleration,
    any_law,
    beta,
    friction,
    gamma2,
    in_regime,
    mu_m,
    mu_s,
    psi,
    speed,
    v,
    v_1,
    v_b,
    v_m,
    x,
)
from symfric.model.symbols import SPEED
from symfric.theory import belt

PART = Ledger("thomsen", "3.1, 3.2: steady sliding and pure slip")


# --- 3.1 Types of motion ----------------------------------------------------------------------------------------------
# Steady sliding: x' = x'' = 0 in (1), where w = -v_b < 0.
@PART.verified(
    "(7)",
    "position of steady sliding, for any law and for (5)",
    -gamma2 * MU(-v_b),
    belt.equilibrium_position(symbolic=True),
)
def _(general, cubic_law):
    (found,) = sp.solve(acceleration(MU(-v_b), velocity=0), x)
    (special,) = sp.solve(acceleration(friction(-v_b, -1), velocity=0), x)
    return any_law(found - general), sp.expand(special - cubic_law)


# With x = xbar + u the constant drops out, and what is neither u'' nor u depends on u' alone.
u = sp.Symbol("u", real=True)
H = 2 * beta * v + gamma2 * (MU(v - v_b) - MU(-v_b))


@PART.verified("(8)", "equation of motion about steady sliding, solved for u''", -u - H)
def _(claim):
    return sp.expand(any_law(acceleration(MU(v - v_b), position=u - gamma2 * MU(-v_b)) - claim))


@PART.verified("(9)", "damping force eps h(u') of steady sliding", H)
def _(claim):
    xbar = sp.solve(acceleration(MU(-v_b), velocity=0), x)[0]
    rest = -u - acceleration(MU(v - v_b), position=xbar + u)
    return sp.expand(any_law(rest - claim)), any_law(claim).subs(v, 0)


# (10) names a quantity; it is the rate at which friction starts to fall, in the units of a damping force.
@PART.verified("(10)", "friction difference eta, the slope -gamma2 mu'(0+)", ETA)
def _(claim):
    return -gamma2 * LAW.diff(SPEED).subs(SPEED, 0) - claim


PART.unverifiable(
    "after (10)",
    "an unstable equilibrium gives way to a periodic motion, never to chaos",
    "no equation: the Poincare-Bendixson theorem for the plane, which (8) fills; that motions stay bounded is assumed",
)

# --- 3.2 Pure-slip periodic motions -----------------------------------------------------------------------------------
# u = A sin psi, psi = tau + theta. The derivative of u is A cos psi exactly if the constraint below vanishes; together
# with u'' = -u - eps h that gives two linear equations for A' and theta'. eps is written into h.
A, h_value, A_dot, theta_dot = sp.symbols("A h Adot thetadot", real=True)


def along(expr):
    """Derivative with respect to tau, with psi' = 1 + theta'."""
    return expr.diff(A) * A_dot + expr.diff(psi) * (1 + theta_dot)


@PART.verified("(11)", "constraint that makes u' = A cos psi", A_dot * sp.sin(psi) + A * theta_dot * sp.cos(psi))
def _(claim):
    return sp.expand(along(A * sp.sin(psi)) - A * sp.cos(psi) - claim)


@PART.verified("(12)", "A' and A theta'", -h_value * sp.cos(psi), h_value * sp.sin(psi))
def _(first, second):
    position, velocity = A * sp.sin(psi), A * sp.cos(psi)
    equations = [along(position) - velocity, along(velocity) + position + h_value]
    found = sp.solve(equations, [A_dot, theta_dot], dict=True)[0]
    return found[A_dot] - first, A * found[theta_dot] - second


# Averaging. Seek A = B + eps w(B, psi) with w periodic in psi. To first order in eps (12) says
#     B' + eps dw/dpsi = eps f(B, psi),
# and w is periodic if and only if B' takes away the constant Fourier coefficient of f. `drift` finds it without an
# integral, with cos psi = (E + 1/E)/2, sin psi = (E - 1/E)/(2 i), E = exp(i psi); the same for theta.
E = sp.Symbol("E")


def harmonics(f, angle) -> dict[int, sp.Expr]:
    """Coefficients of the powers of E = exp(i angle) in a trigonometric polynomial."""

    def turned(wave):
        up, down = (E ** (sign * sp.cancel(wave.args[0] / angle)) for sign in (1, -1))
        return (up + down) / 2 if wave.func is sp.cos else (up - down) / (2 * sp.I)

    flat = f.replace(lambda w: w.func in (sp.sin, sp.cos) and w.has(angle), turned)
    found = sp.collect(sp.expand(flat), E, evaluate=False)
    return {int(power.as_coeff_exponent(E)[1]): coefficient for power, coefficient in found.items()}


def constant_harmonic(f, angle=psi) -> sp.Expr:
    """Mean of a trigonometric polynomial."""
    return harmonics(f, angle).get(0, sp.Integer(0))


def drift(force) -> tuple[sp.Expr, sp.Expr]:
    """A' and A theta' of the averaged motion, for a force that is a polynomial in sin psi and cos psi."""
    return constant_harmonic(-force * sp.cos(psi)), constant_harmonic(force * sp.sin(psi))


H_VALUE = sp.Function("h")


def mean_of(wave):
    return sp.Integral(H_VALUE(A * sp.cos(psi)) * wave, (psi, 0, 2 * sp.pi)) / (2 * sp.pi)


@cache
def carried_out(integral) -> sp.Expr:
    """The integral of (13) for the force of its check."""
    position, velocity = A * sp.sin(psi), A * sp.cos(psi)
    return integral.replace(H_VALUE, lambda _: trial_force(position, velocity)).doit()


def trial_force(position, velocity):
    return FREE[0] + FREE[1] * velocity + FREE[2] * velocity**3 + FREE[3] * position + FREE[4] * position * velocity**2


# A force of u' alone turns out to leave the phase alone. To test the second formula the force depends on u too.
@PART.verified("(13)", "averaged A' and A theta', any h", -mean_of(sp.cos(psi)), mean_of(sp.sin(psi)))
def _(first, second):
    found = drift(trial_force(A * sp.sin(psi), A * sp.cos(psi)))
    return less(found, [c.replace(sp.Integral, lambda *i: carried_out(sp.Integral(*i))) for c in (first, second)])


h0, h1, h2, h3 = COEFFICIENTS = sp.symbols("h0:4", real=True)
PART.definition("(14)", "cubic damping force", h0 + h1 * v + h2 * v**2 + h3 * v**3, note="exact for (5): see (18)")


def cubic_force(velocity):
    return sum(c * velocity**k for k, c in enumerate(COEFFICIENTS))


@PART.verified("(15)", "averaged A' and A theta' of the cubic force", -A * (h1 + sp.Rational(3, 4) * h3 * A**2) / 2, 0)
def _(first, second):
    return less(drift(cubic_force(A * sp.cos(psi))), (first, second))


# Stationary amplitude for h1 = -k < 0 < h3. The phase by Lindstedt, without averaging: with phi = omega tau, omega = 1
# + omega_1, the first order reads u1'' + u1 = 2 omega_1 A sin phi - h(A cos phi); no resonance if omega_1 = theta' = 0.
k_positive, h_positive = sp.symbols("k h_3", positive=True)


@cache
def stationary_amplitude() -> sp.Expr:
    """A0(h1, h3) where h1 < 0 < h3."""
    amplitude = sp.Symbol("A", positive=True)
    rate = drift(cubic_force(A * sp.cos(psi)))[0].subs({A: amplitude, h1: -k_positive, h3: h_positive})
    (found,) = sp.solve(sp.cancel(rate / amplitude), amplitude)
    return found


@PART.verified(
    "(16)",
    "amplitude of the periodic motion, theta', and its frequency",
    sp.sqrt(-sp.Rational(4, 3) * h1 / h3),
    0,
    belt.pure_slip_frequency(symbolic=True),
)
def _(amplitude, phase, frequency):
    omega_1 = sp.Symbol("omega_1")
    resonant = 2 * constant_harmonic(sp.sin(psi) * (2 * omega_1 * A * sp.sin(psi) - cubic_force(A * sp.cos(psi))))
    (shift,) = sp.solve(resonant, omega_1)
    found = stationary_amplitude() - amplitude.subs({h1: -k_positive, h3: h_positive})
    return found, shift - phase, 1 + shift - frequency


# Stability: dA'/dA at the two amplitudes. At A = 0 it must be the real part of the eigenvalues of u'' + h1 u' + u = 0.
@PART.verified("after (16)", "growth rate at A = 0 and at A0: stable cycle if h1 < 0 < h3", -h1 / 2, h1)
def _(rest, cycle):
    eigenvalue_sum = sp.Matrix([[0, 1], [-1, -h1]]).trace()
    slope = (
        drift(cubic_force(A * sp.cos(psi)))[0]
        .diff(A)
        .subs(A, stationary_amplitude())
        .subs({h1: -k_positive, h3: h_positive})
    )
    return eigenvalue_sum / 2 - rest, slope - cycle.subs(h1, -k_positive)


# The same growth rate from (1): the trace of the Jacobian of (x, v) at steady sliding is -gamma2 times (17).
@PART.verified("(17)", "slope whose sign decides the stability of steady sliding", belt.damping_slope(symbolic=True))
def _(claim):
    field = sp.Matrix([v, acceleration(friction(v - v_b, -1))])
    trace = field.jacobian([x, v]).trace().subs(v, 0)
    return -trace / gamma2 - claim


# With (5) and v < v_b, w < 0, the force (9) is a cubic in u'.
@cache
def force_coefficients() -> list[sp.Expr]:
    """h0 ... h3 of (9) with (5)."""
    force = 2 * beta * v + gamma2 * (friction(v - v_b, -1) - friction(-v_b, -1))
    return sp.Poly(sp.expand(force), v).all_coeffs()[::-1]


@PART.verified("(18)", "h0, h1, h2, h3 of law (5)", 0, *belt.damping_polynomial(symbolic=True))
def _(*claims):
    return less(force_coefficients(), claims)


@cache
def solved_in_regime(equation, variable) -> sp.Expr:
    """The positive solution of an equation written in the letters of the unstable regime."""
    (found,) = sp.solve(sp.simplify(in_regime(equation)), variable)
    return found


@PART.verified("(19)", "belt speed v_b1 below which steady sliding is unstable", V_B1)
def _(claim):
    return solved_in_regime(force_coefficients()[1], speed) - in_regime(claim)


# h1 grows with v_b, so it is positive for every belt speed if it is so at v_b = 0.
@PART.verified("after (19)", "smallest h1 of all belt speeds: never unstable if 2 beta > eta", 2 * beta - ETA)
def _(claim):
    slope = force_coefficients()[1]
    lowest = sp.solve(slope.diff(v_b), v_b)
    return [slope.subs(v_b, where) - claim for where in lowest]


@cache
def pure_slip() -> sp.Expr:
    """A0 as a function of the belt speed: (16) with the derived h1 and h3."""
    slope, cubic_term = (sp.simplify(in_regime(force_coefficients()[k])) for k in (1, 3))
    return sp.simplify(stationary_amplitude().subs({k_positive: -slope, h_positive: cubic_term}))


A0 = belt.pure_slip_amplitude(symbolic=True)


@PART.verified("(20)", "amplitude of pure slip, both forms", A0, 2 * sp.sqrt(V_B1**2 - v_b**2))
def _(first, second):
    return [pure_slip() - in_regime(c) for c in (first, second)]


# The largest velocity of u = A0 sin(tau + theta_0) is A0; sticking starts where it reaches that of the belt.
@cache
def stick_start() -> sp.Expr:
    """v_b0 in the letters of the regime."""
    (found,) = sp.solve(pure_slip() - speed, speed)
    return found


@PART.corrected(
    "(21)",
    "belt speed v_b0 below which the mass sticks",
    right=V_B0,
    printed=sp.sqrt(sp.Rational(4, 3)) * V_B1,
    note="A0 = v_b gives 4 (v_b1^2 - v_b^2) = v_b^2, so 4/5; the paper's own 10 % after (21) and 0.3944 use 4/5, and "
    "with 4/3 sticking would start above the onset",
)
def _(claim):
    return stick_start() - in_regime(claim)


@PART.verified("after (21)", "width of the range of pure slip over v_b1, about 10 %", 1 - sp.sqrt(sp.Rational(4, 5)))
def _(claim):
    return 1 - stick_start() / v_1 - claim


@PART.corrected(
    "(22)",
    "amplitude where sticking starts, both forms",
    right=(
        belt.largest_pure_slip_amplitude(symbolic=True),
        sp.sqrt(sp.Rational(4, 5)) * v_m * sp.sqrt(1 - 2 * beta / ETA),
    ),
    printed=(V_B0, sp.sqrt(sp.Rational(4, 3)) * v_m * sp.sqrt(1 - 2 * beta / ETA)),
    note="the factor of (21)",
)
def _(first, second):
    found = pure_slip().subs(speed, stick_start())
    return [found - in_regime(c) for c in (first, second)]


# A law with a quadratic instead of the cubic term, mu_s + c1 w + c2 w^2 for w > 0, minimum mu_m at v_m: for w < 0 the
# force h(u') has a linear and a quadratic term. The quadratic one averages out, so A' is linear in A and there is no
# cycle in pure slip.
def quadratic_law(speed):
    c1, c2, s = sp.symbols("c1 c2 s")
    law = mu_s + c1 * s + c2 * s**2
    found = sp.solve([law.subs(s, v_m) - mu_m, law.diff(s).subs(s, v_m)], [c1, c2], dict=True)[0]
    return law.subs(found).subs(s, speed)


@PART.verified(
    "after (22) quadratic law",
    "A' of a law with a quadratic instead of the cubic term: no limit to the growth",
    -(2 * beta - sp.Rational(4, 3) * ETA * (1 - v_b / v_m)) * A / 2,
)
def _(claim):
    odd = -quadratic_law(v_b - v)  # for v < v_b
    force = sp.expand(2 * beta * v + gamma2 * (odd - odd.subs(v, 0)))
    return drift(force.subs(v, A * sp.cos(psi)))[0] - claim


@PART.corrected(
    "after (22) onset",
    "belt speed below which steady sliding is unstable with the quadratic law",
    right=v_m * (1 - 3 * beta / (2 * ETA)),
    printed=V_B1,
    note="'the condition ... will not change' is true of (17), for any law; of its result (19) without damping only",
)
def _(claim):
    slope = 2 * beta + gamma2 * quadratic_law(v_b).diff(v_b)  # minus the trace, as in (17)
    return sp.solve(slope, v_b)[0] - claim
