"""Thomsen's mass on a moving belt under fast excitation: quenching, (51)-(61)."""

from functools import cache

import sympy as sp

from derivations.ledger import Ledger
from derivations.residuals import less, rounded
from derivations.thomsen.effective import ALPHA3, differences, effective, pieces, slope_at_rest
from derivations.thomsen.model import (
    ETA,
    FIGURE_3,
    LAW,
    V_B1,
    acceleration,
    beta,
    d,
    eta,
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
from derivations.thomsen.pure_slip import A, drift, force_coefficients
from derivations.thomsen.separation import INTENSITY, q, shaken, v_r
from symfric.model.symbols import SPEED
from symfric.theory import belt

PART = Ledger("thomsen", "4.2, 5: stability under fast excitation, quenching")


# --- 4.2 Self-excited oscillations under fast excitation --------------------------------------------------------------
# Steady sliding has v_r = -v_b. `below` and `above` mean v_b < a Omega and v_b > a Omega.
@cache
def at_belt_speed() -> tuple[sp.Expr, sp.Expr]:
    """Effective friction on the sliding mass for relative velocities v - v_b, below and above."""
    return tuple(effective(side).subs(v_r, v - v_b) for side in (0, -1))


@cache
def growth() -> tuple[sp.Expr, sp.Expr]:
    """-trace/gamma2 of the Jacobian of (40) at the quasi-equilibrium, below and above."""
    fields = [sp.Matrix([v, acceleration(law)]) for law in at_belt_speed()]
    return tuple(-field.jacobian([x, v]).trace().subs(v, 0) / gamma2 for field in fields)


@cache
def quasi_equilibria() -> list[sp.Expr]:
    """Positions at which the mass rests in the mean, below and above."""
    return [sp.solve(acceleration(law.subs(v, 0), velocity=0), x)[0] for law in at_belt_speed()]


@PART.verified(
    "(51)",
    "position of the quasi-equilibrium, below and above",
    *pieces(belt.quasi_equilibrium_position(symbolic=True)),
)
def _(*claims):
    return differences(quasi_equilibria(), claims)


@PART.verified(
    "(52)",
    "slope that decides the stability of the quasi-equilibrium, below and above",
    *(slope + 2 * beta / gamma2 for slope in pieces(belt.effective_slope(symbolic=True))),
)
def _(*claims):
    return differences(growth(), claims)


# Below a Omega the slope of (47) is 2 alpha0/(pi sqrt(q^2 - v^2)) + alpha1 + 3 alpha3 q^2/2 + 3 alpha3 v^2, least at
# v = 0, where it is alpha1-hat; over all q that is least at the intensity after (50). One ratio mu_m/mu_s makes it zero
# there.
@cache
def least_ratio() -> sp.Expr:
    """mu_m/mu_s at which the least slope is zero."""
    (lowest,) = sp.solve(slope_at_rest(1), mu_m)
    (where,) = sp.solve(sp.together(slope_at_rest(1).diff(q).subs(mu_m, lowest)), q)
    return sp.simplify((lowest / mu_s).subs(q, where))


@PART.verified(
    "after (52)",
    "mu_m/mu_s above which neither (47) line 1 nor (48) ever falls, and its two digits",
    1 - sp.sqrt(6) / sp.pi,
    sp.Rational(22, 100),
)
def _(ratio, digits):
    return least_ratio() - ratio, rounded(least_ratio(), 2) - digits


@PART.verified(
    "(53)",
    "slope of the effective friction for v_b >= a Omega",
    LAW.diff(SPEED).subs(SPEED, v_b) + sp.Rational(3, 4) * INTENSITY**2 * (mu_s - mu_m) / v_m**3,
)
def _(claim):
    return effective(1).diff(v_r).subs(v_r, v_b) - shaken(claim)


@PART.verified(
    "(54)",
    "quantity whose negative sign means self-excited vibration, v_b > a Omega",
    LAW.diff(SPEED).subs(SPEED, v_b) + sp.Rational(3, 4) * INTENSITY**2 * (mu_s - mu_m) / v_m**3 + 2 * beta / gamma2,
)
def _(claim):
    return growth()[1] - shaken(claim)


# The upper end is where (54) is zero. With v_1^2 = k^2 + q^2/2 in the letters of the regime its root is that of a
# square.
LOWER, UPPER = belt.unstable_speeds(symbolic=True)
k = sp.Symbol("k", positive=True)
REACH = {v_1: sp.sqrt(k**2 + q**2 / 2)}


@PART.verified(
    "(55) upper end",
    "belt speed up to which vibration is self-excited",
    v_m * sp.sqrt(1 - (INTENSITY / v_m) ** 2 / 2 - 2 * beta / ETA),
    UPPER,
)
def _(*claims):
    (found,) = sp.solve(sp.numer(sp.together(in_regime(growth()[1]).subs(REACH))), speed)
    return [found - in_regime(shaken(c)).subs(REACH) for c in claims]


# The lower end: at v_b = q the slope for faster relative motion is negative, but the one for slower relative motion is
# infinite, mubar(q) - mubar(q - w) = c sqrt(w) + ... with the c below. A vibration of velocity amplitude A loses an
# energy of order A^(3/2) in the half period with x' > 0 and gains one of order A^2 in the other: small ones die out.
@cache
def join() -> tuple[sp.Expr, sp.Expr]:
    """v_r where both lines of (47) join, and c."""
    (place,) = sp.solve(effective(0) - effective(1), v_r)
    below = sp.Symbol("w", positive=True)
    fall = (effective(0).subs(v_r, q) - effective(0).subs(v_r, q - below)) / sp.sqrt(below)
    return place, sp.limit(fall, below, 0)


@PART.corrected(
    "(55) lower end",
    "belt speed above which vibration is self-excited; c",
    right=(LOWER, 2 * sp.sqrt(2) * mu_s / (sp.pi * sp.sqrt(q))),
    printed="a Omega <= v_b",
    note="strict: at v_b = a Omega steady sliding is stable. With figure 9's parameters and a Omega = 0.2 a velocity "
    "amplitude A loses 1.41 A^1.5 in one half period and gains 0.38 A^2 in the other; the text before (53) says so too",
)
def _(speed_where_lines_join, coefficient):
    place, found = join()
    return place - shaken(speed_where_lines_join), found - coefficient


@PART.verified(
    "figure 9, beta",
    "derivative of the squared upper end of (55) by beta: damping narrows the range, and lowers a Omega*^2, by",
    -2 * v_m**2 / ETA,
    -sp.Rational(4, 3) * v_m**2 / ETA,
)
def _(*claims):
    squares = [UPPER**2, belt.quench_intensity(symbolic=True) ** 2]
    return [sp.simplify(e.diff(beta) - c) for e, c in zip(squares, claims, strict=True)]


# The range closes where both ends meet.
@cache
def upper_end_squared() -> sp.Expr:
    """Square of the upper end of (55) in the letters of the regime."""
    square = sp.Symbol("square")
    equation = sp.numer(sp.together(in_regime(growth()[1]))).subs(speed, sp.sqrt(square))
    (found,) = sp.solve(equation, square)
    return sp.expand(found)


@cache
def quenching_intensity() -> sp.Expr:
    """a Omega* in the letters of the regime."""
    (found,) = sp.solve(upper_end_squared() - q**2, q)
    return found


Q_STAR = belt.quench_intensity(symbolic=True)


@PART.verified(
    "(56)",
    "intensity a Omega* above which no belt speed is unstable",
    Q_STAR,
    sp.sqrt(sp.Rational(2, 3)) * v_m * sp.sqrt(1 - 2 * beta / ETA),
)
def _(*claims):
    return [quenching_intensity() - in_regime(c) for c in claims]


# Amplitude under excitation, for vibrations that stay outside |v_r| < a Omega: averaging of (40) with (47) line 2.
# They do as long as the amplitude is at most v_b - q: from the belt speed on at which both are equal.
@PART.verified(
    "after (56)",
    "what excitation adds to the slope and to the cubic coefficient of friction; the amplitude, less than A0; the belt "
    "speed from which on it holds",
    sp.Rational(3, 2) * ALPHA3 * INTENSITY**2,
    0,
    2 * sp.sqrt(V_B1**2 - v_b**2 - INTENSITY**2 / 2),
    (INTENSITY + sp.sqrt(20 * V_B1**2 - 14 * INTENSITY**2)) / 5,
    note="below that speed the cycle enters |v_r| < a Omega, where friction is another one; at a Omega = .2 with "
    "figure 3's values from v_b = .4049",
)
def _(slope, cubic_coefficient, amplitude, from_speed):
    added = sp.Poly(sp.expand(effective(-1) - friction(v_r, -1)), v_r)
    force = 2 * beta * v + gamma2 * (at_belt_speed()[1] - at_belt_speed()[1].subs(v, 0))
    rate = drift(sp.expand(force).subs(v, A * sp.cos(psi)))[0]
    square, radius = sp.symbols("square k", positive=True)
    (found,) = sp.solve(in_regime(sp.cancel(rate / A).subs(A, sp.sqrt(square))), square)
    # the root of a square again: v_1^2 = v_b^2 + q^2/2 + k^2
    reach = {v_1: sp.sqrt(speed**2 + q**2 / 2 + radius**2)}
    return (
        added.coeff_monomial(v_r) - shaken(slope),
        added.coeff_monomial(v_r**3) - cubic_coefficient,
        sp.sqrt(sp.factor(sp.expand(found.subs(reach)))) - in_regime(shaken(amplitude)).subs(reach),
        _touches(found.subs(square, 1), in_regime(shaken(from_speed))),
    )


def _touches(amplitude_squared, from_speed):
    """What is left of A = v_b - q at a belt speed, v_1 written through the root in it."""
    root = sp.Symbol("root", positive=True)
    through = {v_1: sp.sqrt((root**2 + 14 * q**2) / 20)}
    place = from_speed.subs(through)
    return sp.expand(sp.simplify((amplitude_squared - (speed - q) ** 2).subs(through).subs(speed, place)))


# --- 5.1 More damping, or another material ----------------------------------------------------------------------------
@PART.verified("5.1 material", "mu_s - mu_m below which nothing vibrates", sp.Rational(4, 3) * beta * v_m / gamma2)
def _(claim):
    slope_at_slow_belt = 2 * beta + gamma2 * LAW.diff(SPEED).subs(SPEED, 0)  # least of all belt speeds, after (19)
    (found,) = sp.solve(slope_at_slow_belt.subs(mu_s, mu_m + d), d)
    return found - claim


@cache
def onset_squared() -> sp.Expr:
    """v_b1^2 in the letters of the paper."""
    square = sp.Symbol("square", positive=True)
    (found,) = sp.solve(force_coefficients()[1].subs(v_b, sp.sqrt(square)), square)
    return found


@PART.corrected(
    "5.1 reduction",
    "sign of the change of A0,max with beta, mu_s and mu_m",
    right=(-1, 1, -1),
    printed=(-1, 1, 1),
    note="lowering mu_m alone makes mu_s - mu_m and with it A0,max larger",
    numbers="signs at the values of figure 3",
)
def _(*claims):
    # A0,max is a fixed part of v_b1
    signs = [sp.sign(onset_squared().diff(letter).subs(FIGURE_3)) for letter in (beta, mu_s, mu_m)]
    return less(signs, claims)


# --- 5.2 By fast vibrations -------------------------------------------------------------------------------------------
@PART.verified("5.2", "a Omega* over v_m for small damping, one digit: below 1", sp.Rational(8, 10))
def _(claim):
    return rounded(quenching_intensity() / v_1, 1) - claim  # v_1 = v_m without damping


# A belt of speed V is unstable if q < V and V^2 < v_1^2 - q^2/2, both; so it is quiet from the smaller one of two
# intensities on: V and sqrt(2 (v_1^2 - V^2)). They are equal at V = a Omega*, and the second one vanishes at V = v_1.
V = sp.Symbol("v_hat", positive=True)
AT, BELOW = belt.quench_intensity_at(symbolic=True), belt.quench_intensity_below(symbolic=True)


@cache
def limits() -> tuple[sp.Expr, sp.Expr]:
    """The two intensities."""
    square = sp.Symbol("square", positive=True)
    (second,) = sp.solve(upper_end_squared().subs(q, sp.sqrt(square)) - V**2, square)
    return V, sp.sqrt(second)


@PART.verified("(57)", "intensity that quenches a belt speed up to a Omega*, and above", *pieces(AT)[:2])
def _(*claims):
    star = quenching_intensity() / v_1
    samples = ({V: star / 2, v_1: 1}, {V: (star + 1) / 2, v_1: 1})
    found = [min(limits(), key=lambda limit: limit.subs(sample)) for sample in samples]
    apart = {v_1: sp.sqrt(V**2 + k**2)}
    return [residual.subs(apart) for residual in less(found, map(in_regime, claims))]


@PART.corrected(
    "(57) line 2",
    "belt speed up to which the second line holds",
    right=sp.sqrt(sp.Rational(3, 2)) * Q_STAR,
    printed=sp.oo,
    note="beyond sqrt(3/2) a Omega* = v_b1 the radicand is negative: nothing vibrates and no excitation is needed",
)
def _(claim):
    (found,) = sp.solve(limits()[1] ** 2, V)
    return found - in_regime(claim)


@cache
def crossing() -> sp.Expr:
    """V at which both intensities are equal."""
    first, second = limits()
    (found,) = sp.solve(first**2 - second**2, V)
    return found


# All belt speeds up to V: the first intensity grows with the belt speed, the second one falls, so the largest of the
# smaller ones is at V, or where they are equal.
@PART.verified(
    "(58)",
    "intensity that quenches all belt speeds up to one below a Omega*, and above",
    V,
    Q_STAR,
    BELOW,
    numbers="the package's form at two belt speeds, exactly",
)
def _(slow, fast, package):
    numbers = {v_1: 1, v_m: 2, eta: sp.Rational(1, 3), mu_m: sp.Rational(1, 4), d: sp.Rational(1, 7)}
    belts = (sp.Rational(5, 10), sp.Rational(9, 10))  # a Omega* is 0.816
    found = [min(given, crossing().subs(numbers)) for given in belts]
    stated = [in_regime(package).subs({**numbers, V: given}) for given in belts]
    return limits()[0] - slow, crossing() - in_regime(fast), *less(found, stated)
