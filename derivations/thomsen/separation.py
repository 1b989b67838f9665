"""Thomsen's mass on a moving belt under fast excitation: the effective friction, (31)-(50)."""

from functools import cache

import sympy as sp

from derivations.ledger import Ledger
from derivations.residuals import less
from derivations.thomsen.model import (
    DIMENSIONLESS,
    FREE,
    LAW,
    MU,
    SINE,
    Omega,
    a,
    acceleration,
    any_law,
    beta,
    d,
    friction,
    gamma2,
    mu,
    mu_m,
    mu_s,
    newton,
    tau,
    v,
    v_b,
    v_m,
    x,
)
from derivations.thomsen.pure_slip import constant_harmonic, harmonics
from symfric.model.names import SPEED
from symfric.theory import belt

PART = Ledger("thomsen", "4.1: slow and fast motion, effective friction")

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
    audit="has an error of order 1/Omega for the velocity; (42) is right as printed",
)
def _(position, velocity):
    phi = general_motion()
    found_z = (x - e * phi).subs(T, 0)
    found_v = (v - phi.diff(T) - e * phi.diff(tau)).subs(T, 0).doit()
    return *orders(found_z - position, 1), *orders(found_v - shaken(velocity), 1)


# --- 4.1.2 Calculating the effective friction characteristic ----------------------------------------------------------
ALPHA0, ALPHA1, ALPHA3 = belt.law_coefficients(symbolic=True)


@PART.verified(
    "(43)",
    "law (5) by powers, v_r > 0 and v_r < 0",
    *(side * ALPHA0 + ALPHA1 * v_r + ALPHA3 * v_r**3 for side in (1, -1)),
)
def _(*claims):
    return less([friction(v_r, side) for side in (1, -1)], claims)


@PART.verified("(44)", "alpha0, alpha1, alpha3", ALPHA0, ALPHA1, ALPHA3)
def _(*claims):
    found = [LAW.diff(SPEED, k).subs(SPEED, 0) / sp.factorial(k) for k in (0, 1, 3)]
    return less(found, claims)


# (45), (46): w = v_r - q cos T vanishes twice in a period if |v_r| < q. With v_r = q cos T_1 it is
#     w = 2 q sin((T + T_1)/2) sin((T - T_1)/2),
# where both angles are within (0, pi) for T_1 < T < 2 pi - T_1, and the second sine is negative for T < T_1.
@PART.verified(
    "(45)",
    "sign of v_r - q cos T between its zeros, and elsewhere",
    1,
    -1,
    numbers="the product exactly, its sign at 91 places",
)
def _(between, elsewhere):
    product = 2 * q * sp.sin((T + T_1) / 2) * sp.sin((T - T_1) / 2)
    left = [product - q * (sp.cos(T_1) - sp.cos(T))]
    for k in range(1, 8):
        for j in range(1, 16):
            if j not in (k, 16 - k):
                sign = sp.sign((product / q).subs({T_1: k * sp.pi / 8, T: j * sp.pi / 8}).evalf())
                left.append(sign - (between if k < j < 16 - k else elsewhere))
    return left


@PART.verified("(46)", "zeros of v_r - q cos T", sp.acos(v_r / q), 2 * sp.pi - sp.acos(v_r / q))
def _(*claims):
    found = sorted(sp.solve(v_r - q * sp.cos(T), T), key=lambda zero: zero.subs({v_r: 0, q: 1}))
    return less(found, claims)


# (47): (5) has one form for w > 0 and one for w < 0. Where w keeps its sign the mean is one integral; where it does
# not, the arcs [0, T_1], [T_1, 2 pi - T_1], [2 pi - T_1, 2 pi] are integrated one by one and T_1 is replaced by (46).
def over_a_period(f, side: int) -> sp.Expr:
    """Mean over T of f(sign of v_r - q cos T): |v_r| < q (side 0), v_r > q (1), v_r < -q (-1)."""

    def arc(low, high, sign):
        primitive = sp.integrate(sp.expand(f(sign)), T)
        return primitive.subs(T, high) - primitive.subs(T, low)

    if side:
        total = arc(0, 2 * sp.pi, side)
    else:
        total = arc(0, T_1, -1) + arc(T_1, 2 * sp.pi - T_1, 1) + arc(2 * sp.pi - T_1, 2 * sp.pi, -1)
    return sp.expand(sp.expand(total / (2 * sp.pi)).subs(T_1, sp.acos(v_r / q)))


@cache
def effective(side: int) -> sp.Expr:
    """<mu(v_r - q cos T)> for law (5), sides as in `over_a_period`."""
    return over_a_period(lambda sign: friction(v_r - q * sp.cos(T), sign), side)


@PART.verified(
    "(47) line 1",
    "effective friction for |v_r| <= a Omega",
    ALPHA0 * (1 - 2 / sp.pi * sp.acos(v_r / INTENSITY))
    + (ALPHA1 + sp.Rational(3, 2) * ALPHA3 * INTENSITY**2) * v_r
    + ALPHA3 * v_r**3,
)
def _(claim):
    return effective(0) - shaken(claim)


@PART.verified(
    "(47) line 2",
    "effective friction for v_r >= a Omega and v_r <= -a Omega",
    *(friction(v_r, side) + sp.Rational(3, 2) * ALPHA3 * INTENSITY**2 * v_r for side in (1, -1)),
)
def _(*claims):
    return less([effective(side) for side in (1, -1)], map(shaken, claims))


def pieces(formula) -> tuple[sp.Expr, ...]:
    """Branches of a closed form below and above a Omega."""
    return tuple(branch.expr for branch in sp.piecewise_fold(formula).args)


def differences(found, claims) -> list[sp.Expr]:
    """Residuals of claims in a and Omega; inverse cosines are brought to inverse sines, which are odd."""
    return [left.rewrite(sp.asin) for left in less(found, map(shaken, claims))]


@PART.verified(
    "(47) both lines",
    "effective friction as the package computes it",
    *pieces(belt.effective_friction(symbolic=True).kinetic),
)
def _(*claims):
    return differences((effective(0), effective(1)), [c.subs(SPEED, v_r) for c in claims])


@PART.verified(
    "after (47)",
    "effective less true friction for v_r > a Omega: larger",
    sp.Rational(3, 4) * INTENSITY**2 * (mu_s - mu_m) * v_r / v_m**3,
)
def _(claim):
    return effective(1) - friction(v_r, 1) - shaken(claim)


# --- 4.1.3 Effective friction characteristic in polynomial form -------------------------------------------------------
HAT1 = 2 * ALPHA0 / (sp.pi * INTENSITY) + ALPHA1 + sp.Rational(3, 2) * ALPHA3 * INTENSITY**2
HAT3 = ALPHA3 + ALPHA0 / (3 * sp.pi * INTENSITY**3)


def slope_at_rest(order: int) -> sp.Expr:
    """Taylor coefficient of the effective friction for |v_r| < q."""
    return effective(0).diff(v_r, order).subs(v_r, 0) / sp.factorial(order)


@PART.verified("(48)", "series of the effective friction up to v_r^4", HAT1 * v_r + HAT3 * v_r**3)
def _(claim):
    return sp.series(effective(0), v_r, 0, 5).removeO() - shaken(claim)


@PART.verified(
    "(49)",
    "its linear and cubic coefficients",
    belt.effective_damping(symbolic=True),
    belt.effective_cubic(symbolic=True),
)
def _(*claims):
    return less([slope_at_rest(k) for k in (1, 3)], map(shaken, claims))


@PART.verified(
    "(50)",
    "the same in mu_s, mu_m, v_m",
    2 / sp.pi * mu_s / INTENSITY + sp.Rational(3, 2) * (mu_s - mu_m) / v_m * ((INTENSITY / v_m) ** 2 / 2 - 1),
    mu_s / (3 * sp.pi * INTENSITY**3) + (mu_s - mu_m) / (2 * v_m**3),
)
def _(*claims):
    return less([slope_at_rest(k) for k in (1, 3)], map(shaken, claims))


@PART.verified("after (50) first term", "damping coefficient of Coulomb friction", 2 * mu_s / (sp.pi * INTENSITY))
def _(claim):
    return slope_at_rest(1).subs(mu_m, mu_s) - shaken(claim)


# The damping coefficient goes to infinity for q -> 0 and for q -> oo; its derivative has one zero in between.
LEAST = 4 / (3 * sp.pi * (1 - mu_m / mu_s))


@cache
def least_intensity_cubed() -> sp.Expr:
    """q^3 where the damping coefficient at rest is least."""
    cube = sp.Symbol("cube", positive=True)
    (found,) = sp.solve(sp.expand(slope_at_rest(1).diff(q) * q**2).subs(q**3, cube), cube)
    return found


@PART.corrected(
    "after (50) minimum",
    "intensity of least damping: its cube, and itself",
    right=(v_m**3 * LEAST, belt.least_damping_intensity(symbolic=True)),
    printed=(LEAST, sp.cbrt(LEAST)),
    note="the factor v_m^3 is missing: the cube of a velocity cannot be a ratio of coefficients",
)
def _(cubed, intensity):
    found = least_intensity_cubed().subs(mu_s, mu_m + d)
    stated = [c.subs(mu_s, mu_m + d) for c in (cubed, intensity)]
    return found - stated[0], sp.cbrt(found) - stated[1]


# alpha3-hat > 0, so (48) is steepest away from v_r = 0 and rises everywhere if and only if alpha1-hat > 0; how small
# mu_m/mu_s may become is said after (52).


# The example of figures 4 and 8, a = 0.01 and Omega = 50.
@PART.verified(
    "4.1.4", "amplitudes of the fast displacement and velocity in figure 8", sp.Rational(1, 100), sp.Rational(1, 2)
)
def _(*claims):
    motion = (e * general_motion().subs(e, 0)).subs({q: sp.Rational(1, 2), e: sp.Rational(1, 50)})
    largest = [abs(motion.subs(T, sp.pi / 2)), abs((motion.diff(T) * 50).subs(T, 0))]
    return less(largest, claims)
