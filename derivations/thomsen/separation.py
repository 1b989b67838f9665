"""Thomsen's mass on a moving belt under fast excitation: its slow and its fast motion, (31)-(42)."""

from functools import cache

import sympy as sp

from derivations.ledger import Ledger
from derivations.thomsen.model import (
    DIMENSIONLESS,
    FREE,
    MU,
    SINE,
    Omega,
    a,
    acceleration,
    any_law,
    beta,
    gamma2,
    mu,
    newton,
    tau,
    v,
    v_b,
    x,
)
from derivations.thomsen.pure_slip import constant_harmonic, harmonics

PART = Ledger("thomsen", "4.1: slow and fast motion")

# q = a Omega > 0 is the intensity, of order one, and e = 1/Omega the small number of the separation, so that a = q e.
# T = Omega tau is the fast time, <> the mean over one of its periods, v_r a relative velocity.
q, e = sp.symbols("q e", positive=True)
T, T_1, v_r, z, z_dot = sp.symbols("T T_1 v_r z zdot", real=True)
INTENSITY = a * Omega


def shaken(expr) -> sp.Expr:
    """Write a Omega = q."""
    return sp.sympify(expr).subs(a, q / Omega)


def mean(f) -> sp.Expr:
    """Mean over T of a trigonometric polynomial."""
    return constant_harmonic(f, T)


# --- 4.1.1 Separating fast and slow motions ---------------------------------------------------------------------------
S = x + 2 * beta * v + gamma2 * mu


def equation_of_motion() -> sp.Expr:
    return newton().subs(DIMENSIONLESS, simultaneous=True)


@PART.verified("(31)", "x'' + s", Omega * INTENSITY * SINE)
def _(claim):
    return sp.expand(equation_of_motion() + S - claim)


@PART.verified("(32)", "forces s without the excitation", S)
def _(claim):
    return sp.expand(-equation_of_motion().subs(SINE, 0) - claim)


PHI = sp.Function("phi")(tau, T)
SLOW = sp.Function("z")(tau)
PART.definition("(33)", "split into slow and fast motion", SLOW + PHI / Omega)


# The condition <phi> = 0 makes the split unique if the mean of x = z + phi/Omega is z for every phi without a constant
# harmonic.
FAST = sp.Function("fast")


@PART.verified("(34)", "mean over the fast time", sp.Integral(FAST(T), (T, 0, 2 * sp.pi)) / (2 * sp.pi))
def _(claim):
    wave = FREE[1] * sp.cos(T) + FREE[2] * sp.sin(T) + FREE[3] * sp.cos(2 * T) + FREE[4] * sp.sin(2 * T)
    return sp.expand(claim.replace(FAST, lambda _: z + wave / Omega).doit() - z)


# d/d tau acts on both times: f(tau, Omega tau)' = df/d tau + Omega df/dT.
s, z_dd, phi_mixed, phi_slow = sp.symbols("s zddot phi_mixed phi_slow", real=True)
FAST_EQUATION = INTENSITY * sp.sin(T) - (z_dd + 2 * phi_mixed + s) / Omega - phi_slow / Omega**2


@cache
def fast_acceleration() -> sp.Expr:
    """phi'' from (31) with (33)."""

    def total(f):
        return f.diff(tau) + Omega * f.diff(T)

    motion = total(total(SLOW + PHI / Omega)) + s - Omega * INTENSITY * sp.sin(T)
    (found,) = sp.solve(sp.expand(motion), PHI.diff(T, 2))
    names = {PHI.diff(tau, T): phi_mixed, PHI.diff(tau, 2): phi_slow, SLOW.diff(tau, 2): z_dd}
    return found.subs(names)


@PART.verified("(35)", "phi'', derivatives to T by primes and to tau by dots", FAST_EQUATION)
def _(claim):
    return sp.expand(fast_acceleration() - claim)


# Order by order in e, phi = p0 + e p1: p0'' = q sin T, p1'' = -(z'' + 2 p0-dot' + s). Stationary solutions are
# periodic, which takes the mean out of the right-hand side (that is (38)), and have no constant, by (34). To the lowest
# order s is x + 2 beta v + gamma2 mu at x = z and v = z' + p0' = z' - q cos T: whatever the law, jump included, it
# depends on T by cos T only. So it is a cosine series with coefficients that depend on slow time.
SERIES = tuple(sp.Function(f"c{k}")(tau) for k in range(4))


def periodic(rhs) -> sp.Expr:
    """The periodic f of mean zero with f'' = rhs less its mean, harmonic by harmonic."""
    waves = harmonics(rhs, T)
    total = sp.Integer(0)
    for n in sorted({abs(n) for n in waves} - {0}):
        up, down = (waves.get(side * n, 0) for side in (1, -1))
        total -= ((up + down) * sp.cos(n * T) + sp.I * (up - down) * sp.sin(n * T)) / n**2
    return sp.expand(total)


@cache
def fast_motion(forces) -> sp.Expr:
    """phi to order e; `forces` is s along the fast motion of order one, as a function of T."""
    first = periodic(q * sp.sin(T))
    second = periodic(-(forces + 2 * first.diff(tau, T)))
    return first + e * second


@cache
def general_motion() -> sp.Expr:
    """phi to order e for any law."""
    return fast_motion(sum(c * sp.cos(k * T) for k, c in enumerate(SERIES)))


def orders(expr, highest: int) -> list[sp.Expr]:
    """Coefficients of e^0 ... e^highest."""
    expanded = sp.expand(expr)
    return [expanded.coeff(e, k) for k in range(highest + 1)]


@PART.verified("(36)", "fast motion phi to order 1", -INTENSITY * sp.sin(T))
def _(claim):
    return orders(general_motion() - shaken(claim), 0)


@PART.verified("(37)", "motion less slow motion, to order 1/Omega; the error is of order 1/Omega^2", -a * sp.sin(T))
def _(claim):
    return orders(e * general_motion() - claim.subs(a, q * e), 1)


# Mean of (35) for any periodic phi without a constant harmonic: phi'', the excitation and both terms with a derivative
# to tau drop out.
@PART.verified("(38)", "slow acceleration z'', <s> the mean of the forces", -s)
def _(claim):
    waves = (sp.cos(T), sp.sin(T), sp.cos(2 * T), sp.sin(2 * T))
    phi = sum(sp.Function(f"p{k}")(tau) * wave for k, wave in enumerate(waves))
    forces = s + sum(c * sp.cos(k * T) + c * sp.sin(k * T) for k, c in enumerate(SERIES[1:], 1))
    filled = FAST_EQUATION.subs(s, forces).subs({phi_mixed: phi.diff(tau, T), phi_slow: phi.diff(tau, 2)})
    (found,) = sp.solve(mean(phi.diff(T, 2) - filled), z_dd)
    return sp.expand(found - claim)


# (39): s at z + e phi and z' + phi' + e phi-dot in powers of e, phi-dot being of order e; friction by a polynomial, and
# z' = v_b + v_r.
def forces_along(position, velocity):
    return -any_law(acceleration(MU(sp.expand(velocity - v_b)), position, velocity))


@cache
def slow_forces() -> tuple[sp.Expr, sp.Expr]:
    """<s> of (38), its terms of order 1 and e."""
    phi = fast_motion(forces_along(z, v_b + v_r - q * sp.cos(T)))
    forces = forces_along(z + e * phi, v_b + v_r + phi.diff(T))
    return mean(forces.subs(e, 0)), mean(forces.diff(e).subs(e, 0))


def integrated(claim) -> sp.Expr:
    """Carry out integrals of trigonometric polynomials over a period."""
    return (
        shaken(claim).replace(sp.Integral, lambda f, limits: (limits[2] - limits[1]) * mean(f)).subs(z_dot, v_b + v_r)
    )


FORCES = sp.Function("s")
AVERAGED = sp.Integral(FORCES(z - a * sp.sin(T), z_dot - INTENSITY * sp.cos(T)), (T, 0, 2 * sp.pi)) / (2 * sp.pi)


@PART.verified("(39)", "slow acceleration to order 1", -AVERAGED)
def _(claim):
    return sp.expand(-slow_forces()[0] - integrated(claim.subs(z_dot, v_b + v_r).replace(FORCES, forces_along)))


# Terms of order 1/Omega are dropped in (39); there are none. s depends on T by cos T, so its slope to v does too, while
# p1' is a sine series, and the mean of their product vanishes, as does <phi>: the error is of order 1/Omega^2.
@PART.verified("after (39)", "terms of order 1/Omega in <s>: a polynomial law, and any law", 0, 0)
def _(polynomial, general):
    slope = sum(FREE[k] * sp.cos(k * T) for k in range(4))
    position, order_e = orders(general_motion(), 1)
    return slow_forces()[1] - polynomial, mean(position + slope * order_e.diff(T)) - general


# (40) takes the mean of (32) term by term; the effective law is what is left of friction, (41).
EFFECTIVE = sp.Function("mubar")
MEAN_FRICTION = sp.Integral(MU(v_r - INTENSITY * sp.cos(T)), (T, 0, 2 * sp.pi)) / (2 * sp.pi)


@PART.verified("(40)", "slow acceleration", -2 * beta * z_dot - z - gamma2 * EFFECTIVE(z_dot - v_b))
def _(claim):
    filled = claim.subs(z_dot, v_b + v_r).replace(EFFECTIVE, lambda w: integrated(any_law(MEAN_FRICTION)).subs(v_r, w))
    return sp.expand(-slow_forces()[0] - filled)


PART.definition("(41)", "effective friction", MEAN_FRICTION)


# At tau = 0 = T: x = z + e phi, x' = z' + phi' + e phi-dot, where phi-dot is of order e. p1 is a cosine series: it
# changes x(0) by e^2, and p1' vanishes at T = 0. So both initial values hold up to Omega^-2, as printed.
@PART.verified(
    "(42)",
    "initial position and velocity of the slow motion, to order 1/Omega",
    x,
    v + INTENSITY,
    note="x' has an error of order 1/Omega at other times, but its term of this order, p1'/Omega, is a sine series in "
    "T for every law and vanishes at tau = 0",
)
def _(position, velocity):
    phi = general_motion()
    found_z = (x - e * phi).subs(T, 0)
    found_v = (v - phi.diff(T) - e * phi.diff(tau)).subs(T, 0).doit()
    return *orders(found_z - position, 1), *orders(found_v - shaken(velocity), 1)
