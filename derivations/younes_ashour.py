"""Younes and Ashour: a rod on a spring, braked by a contact whose friction falls with the sliding speed."""

from functools import cache

import numpy as np
import sympy as sp
from scipy import integrate, optimize

from derivations.ledger import Ledger
from symfric.model import laws
from symfric.model.names import SPEED
from symfric.theory import transient

LEDGER = Ledger(
    "younes_ashour",
    "Younes and Ashour, Experimental and theoretical investigation of damping potential of system-dependent "
    "tribological contacts undergoing transient motion",
)

A, omega, mu_m, zeta, r, x0, v0, g, v_c = transient.DAMPER
m, k, mu, V = sp.symbols("m k mu V", positive=True)  # V: a speed |x'| > 0
x, v = sp.symbols("x v", real=True)  # position, velocity x'
BOTH = (1, -1)  # sides to which the rod may move

# --- Modelling the system ----------------------------------------------------------------------------------------
# The contact presses with N = r m g. While the rod slides, friction has the magnitude mu N and opposes the motion; the
# damper takes c x'^2 and friction mu N |x'|. The print leaves the sign open.


@LEDGER.corrected(
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


@LEDGER.verified("after (1) at rest", "largest |x| at which the rod sticks; beyond the source", mu_m * r * g / omega**2)
def _(claim):
    return sp.solve(k * x - mu_m * r * m * g, x)[0].subs(k, m * omega**2) - claim


@LEDGER.corrected(
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


@LEDGER.corrected(
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


@LEDGER.verified("(3) literal", "what the printed law makes of friction sliding backwards, over mu_m", sp.exp(V / v_c))
def _(claim):
    return (mu_m * sp.exp(-v / v_c)).subs(v, -V) / mu_m - claim


# (4): energy is the work done: stretching the spring from 0 to x0, or bringing the mass from 0 to v0.


@LEDGER.corrected(
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


@LEDGER.corrected(
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


@LEDGER.verified("(5) line 2 viscous", "integrand over dx", 2 * zeta * omega * m * v)
def _(claim):
    return [_loss(side)[0] - (claim * v).subs(v, side * V) for side in BOTH]


@LEDGER.corrected(
    "(5) line 2 contact",
    "integrand over dx",
    right=mu * r * m * g * sp.sign(v),
    printed=mu * r * m * g,
    note="with dx signed the printed integral is mu r m g (x_f - x0) for constant mu, negative from x0 > 0",
)
def _(claim):
    return [_loss(side)[1] - (claim * v).subs(v, side * V) for side in BOTH]


@LEDGER.corrected(
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


LEDGER.definition("(6)", "dissipation ratio R", sp.Symbol("E_viscous") / sp.Symbol("E_contact"))

# After (6) the text compares the two losses at a given speed. Both powers: the viscous one goes with x'^2, not x' (that
# is the force); the contact one with |x'| e^{-|x'|/v_c}. Their ratio rises with speed from zero, which is what the text
# concludes.


@LEDGER.verified(
    "after (6)",
    "viscous over contact power at speed V: rises from 0",
    2 * zeta * omega * V * sp.exp(V / v_c) / (mu_m * r * g),
)
def _(claim):
    viscous, contact = _loss(1)
    return viscous / contact.subs(mu, laws.exponential(mu_m, v_c).kinetic.subs(SPEED, V)) - claim


# --- The averaged amplitude law; beyond the source ---------------------------------------------------------------
# With weak damping x = A cos p, x' = -A omega sin p, p' = omega, and the energy m omega^2 A^2/2 falls by the mean
# power. Friction gives mu_m r m g A omega (2/pi) F(A omega/v_c) with
#     F(a) = int_0^{pi/2} sin p e^{-a sin p} dp.
# The even part of the exponential in a integrates to a Struve function, the odd part to a Bessel function. Termwise,
# with Wallis' integrals W_n = int_0^{pi/2} sin^n p dp, F = sum (-a)^n W_(n+1)/n!: an entire function, so its Taylor
# coefficients decide. All of them, with a^2j from the Struve part and a^(2j+1) from the Bessel part:
#     W_(2j+1)/(2j)! = 4^j j!^2/((2j)! (2j+1)!),   W_(2j+2)/(2j+1)! = (pi/2) (1/2)^(2j+1)/(j! (j+1)!).
# The second is pi/2 times the coefficient of I_1, the first pi/2 times that of L_1, with 1 in front for j = 0.
z = sp.Symbol("a", positive=True)
j = sp.Symbol("j", integer=True, nonnegative=True)
EVEN = 2 ** (2 * j) * sp.factorial(j) ** 2 / (sp.factorial(2 * j) * sp.factorial(2 * j + 1))
ODD = -sp.pi / 2 ** (2 * j + 2) / (sp.factorial(j) * sp.factorial(j + 1))
TERMS = 6
POWERS = 5  # of A in the averaged law


def _wallis(n):
    """Return int_0^{pi/2} sin^n p dp = (1/2) B((n + 1)/2, 1/2), from sin^2 p as variable."""
    return sp.gamma((n + 1) / sp.S(2)) * sp.sqrt(sp.pi) / (2 * sp.gamma(n / sp.S(2) + 1))


@LEDGER.verified("averaged law: Wallis", "int_0^{pi/2} sin^n p dp", _wallis(j))
def _(claim):
    # W_0 and W_1, and n W_n = (n - 1) W_(n-2), by parts: int sin^n = (n - 1) int sin^(n-2) cos^2
    p = sp.Symbol("p", real=True)
    first = [sp.integrate(sp.sin(p) ** n, (p, 0, sp.pi / 2)) - claim.subs(j, n) for n in (0, 1)]
    return [*first, sp.expand_func((j + 2) * claim.subs(j, j + 2) - (j + 1) * claim)]


@LEDGER.verified("averaged law: coefficients", "of a^(2j) and a^(2j+1) in F(a)", EVEN, ODD)
def _(even, odd):
    return [
        sp.expand_func(sp.gammasimp((claim - sign * _wallis(n + 1) / sp.factorial(n)).rewrite(sp.gamma)))
        for claim, n, sign in ((even, 2 * j, 1), (odd, 2 * j + 1, -1))
    ]


@LEDGER.verified(
    "averaged law: F",
    "1 + (pi/2)(L_1(a) - I_1(a)), L_1 as 1F2",
    transient.mean_friction(symbolic=True),
    numbers=f"the first {2 * TERMS} coefficients, exactly",
)
def _(claim):
    # the first twelve coefficients; those of 1F2 and I_1 obey the recursion of EVEN and ODD by definition
    series = sp.series(claim.subs(A, z * v_c / omega), z, 0, 2 * TERMS).removeO()
    return series - sum(EVEN.subs(j, n) * z ** (2 * n) + ODD.subs(j, n) * z ** (2 * n + 1) for n in range(TERMS))


@LEDGER.verified(
    "averaged law: literal",
    "F with (3) as printed: the mean of both directions, 1 + (pi/2) L_1(a)",
    transient.mean_friction(literal=True, symbolic=True),
    numbers=f"the first {2 * TERMS} coefficients, exactly",
)
def _(claim):
    # e^{-x'/v_c} is e^{-|x'|/v_c} forward and e^{|x'|/v_c} backward, so the mean is (F(a) + F(-a))/2: the even part
    series = sp.series(claim.subs(A, z * v_c / omega), z, 0, 2 * TERMS).removeO()
    return series - sum(EVEN.subs(j, n) * z ** (2 * n) for n in range(TERMS))


@cache
def _mean_power():
    """Mean power, carried out on the law of friction, term by term in |x'|/v_c."""
    p = sp.Symbol("p", positive=True)
    speed = A * omega * sp.sin(p)  # |x'| in 0 < p < pi/2; the other quarters are alike
    law = laws.exponential(mu_m, v_c).kinetic.series(SPEED, 0, POWERS).removeO().subs(SPEED, speed)
    power = 2 * zeta * omega * m * speed**2 + sp.expand(law) * r * m * g * speed
    return sp.integrate(sp.expand(power), (p, 0, sp.pi / 2)) * 2 / sp.pi


@LEDGER.verified("averaged law", "A'", transient.amplitude_rate(), numbers="the first five coefficients, exactly")
def _(claim):
    return sp.expand(sp.series(claim, A, 0, POWERS).removeO() + _mean_power() / (m * omega**2 * A))


@LEDGER.verified(
    "averaged law: decay time", "time until the amplitude is zero", transient.averaged_decay_time(symbolic=True)
)
def _(claim):
    # separation of variables: dt = dA/A' from the amplitude of the start down to zero
    longer = claim.diff(x0) * transient.amplitude_rate().subs(A, sp.sqrt(x0**2 + v0**2 / omega**2))
    start = sp.sqrt(x0**2 + v0**2 / omega**2)
    return longer + start.diff(x0), claim.subs({x0: 0, v0: 0}).doit()


# Where friction does not fall with speed (v_c -> infinity) the handbook gives the loss exactly: 2 delta per half cycle,
# delta = mu r g/omega^2. Then A' = -zeta omega A - 2 delta omega/pi, and the time has a closed form in
# y = pi zeta omega^2 x0/(2 mu r g).
Y = sp.Symbol("y", positive=True)
BRAKING = 2 * mu * r * g / (sp.pi * omega)
DAMPING = sp.Symbol("zeta", positive=True)
START = sp.Symbol("x0", positive=True)
COULOMB_TIME = sp.log(1 + sp.pi * DAMPING * omega**2 * START / (2 * mu * r * g)) / (DAMPING * omega)


@cache
def _constant_friction_time():
    time = sp.Function("T")
    return sp.dsolve(time(A).diff(A) - 1 / (DAMPING * omega * A + BRAKING), time(A), ics={time(0): 0}).rhs


@LEDGER.verified("averaged law: constant friction", "decay time from x0 at rest", COULOMB_TIME)
def _(claim):
    difference = _constant_friction_time().subs(A, START) - claim
    return difference.diff(START), difference.subs(START, 0)


# --- Discussion of the results -----------------------------------------------------------------------------------
# Without damping the closed form tends to x0 pi/(2 delta omega) = pi omega x0/(2 mu r g): from a given displacement a
# stiff support takes longer. From a given energy, x0 = sqrt(2 E/m)/omega, the frequency drops out.


def _undamped(start):
    return sp.limit(COULOMB_TIME.subs(START, Y), DAMPING, 0).subs(Y, start)


ENERGY = sp.Symbol("E", positive=True)


@LEDGER.corrected(
    "Figure 3, conclusion 1",
    "d t_d/d omega without damping: from a given displacement, from a given energy",
    right=(sp.pi * START / (2 * mu * r * g), 0),
    printed="a stiffer support restores equilibrium sooner",
    note="false at zeta = 0, the case of figure 3: at 10 mm and mu_m = .1 exact decay takes .43 s at 3.5 Hz and "
    "1.30 s at 10 Hz; a falling law changes nothing at equal energy, where only A omega/v_c counts",
)
def _(displaced, energetic):
    impulse = _undamped(sp.sqrt(2 * ENERGY / m) / omega)
    return _undamped(START).diff(omega) - displaced, impulse.diff(omega) - energetic


@cache
def _elasticity(letter):
    """Return d ln t_d/d ln letter."""
    return sp.simplify(letter * COULOMB_TIME.diff(letter) / COULOMB_TIME)


def _in_y(expr):
    return expr.subs(START, 2 * mu * r * g * Y / (sp.pi * DAMPING * omega**2))


@LEDGER.verified(
    "Conclusion 1 with damping",
    "d ln t_d/d ln omega: negative, and the conclusion right, only for y > 3.92",
    2 * Y / ((1 + Y) * sp.log(1 + Y)) - 1,
)
def _(claim):
    return _in_y(_elasticity(omega)) - claim


@LEDGER.verified("Conclusion 2", "-d ln t_d/d ln mu falls to zero as y grows with zeta", Y / ((1 + Y) * sp.log(1 + Y)))
def _(claim):
    found = -_in_y(_elasticity(mu))
    return found - claim, sp.limit(found, Y, sp.oo)


@LEDGER.verified(
    "Conclusion 3",
    "R for small energy and damping: vanishes with x0",
    sp.pi * zeta * omega**2 * START / (3 * mu * r * g),
)
def _(claim):
    viscous, contact = m * zeta * omega**3 * A**2, mu * r * m * g * 2 * A * omega / sp.pi  # mean powers
    parts = [sp.integrate(power / BRAKING, (A, 0, START)) for power in (viscous, contact)]
    return parts[0] / parts[1] - claim


@LEDGER.corrected(
    "Figure 6",
    "d t_d/d E without damping: decay takes longer with the energy given",
    right=sp.pi / (2 * mu * r * g * sp.sqrt(2 * ENERGY * m)),
    printed=0,
    note="'not affected by the initial values' holds only between a displacement and an impulse of equal energy, "
    "which start with the same amplitude, and there within half a period",
)
def _(claim):
    return _undamped(sp.sqrt(2 * ENERGY / m) / omega).diff(ENERGY) - claim


# Numbers: x0 = 10 mm (said for figure 5 only), g = 9.81 m/s^2 (not said), r = 1, zeta = 0. Turning points are found to
# ten digits; those that decide are off the stick limit by more than 10 % of it.
INTEGRATED = "motion integrated to ten digits"


@cache
def _turning_points(f_n, mu_m, literal=False):
    """Turning points from 10 mm until the rod sticks, in m, with the falling law or the law as printed."""
    frequency, points = 2 * np.pi * f_n, [0.01]
    stick = mu_m * 9.81 / frequency**2
    while abs(points[-1]) > stick:
        side = -np.sign(points[-1])

        def motion(_t, y, side=side):
            coefficient = mu_m * np.exp(-(y[1] if literal else abs(y[1])))
            return y[1], -(frequency**2) * y[0] - side * coefficient * 9.81

        def turn(_t, y):
            return y[1]

        turn.terminal, turn.direction = True, -side
        start = [points[-1], 1e-15 * side]
        run = integrate.solve_ivp(motion, (0, 1 / f_n), start, "DOP853", events=turn, rtol=1e-12, atol=1e-15)
        points.append(run.y_events[0][0][0])
    return points


@LEDGER.corrected(
    "Figure 4",
    "half cycles to rest at 3.5 Hz, mu_m = .1, with (3) as corrected",
    right=3,
    printed=2,
    note="'in one cycle' is two half cycles; the falling law needs a third",
    numbers=INTEGRATED,
)
def _(claim):
    return len(_turning_points(3.5, 0.1)) - 1 - claim


@LEDGER.verified(
    "Figure 4 literal",
    "the same with (3) as printed, and with constant friction: one cycle",
    2,
    2,
    numbers=INTEGRATED,
)
def _(literal, constant):
    stick = sp.Rational(981, 1000) / (2 * sp.pi * sp.Rational(7, 2)) ** 2
    found = len(_turning_points(3.5, 0.1, literal=True)) - 1
    return found - literal, transient.half_cycles(float(stick), x0=0.01) - constant


@LEDGER.verified(
    "(5) line 1 at 3.5 Hz", "share of the energy left in the spring, mu_m = .1, in 1e-4", 163, numbers=INTEGRATED
)
def _(claim):
    start, *_, rest = _turning_points(3.5, 0.1)
    return round(1e4 * (rest / start) ** 2) - claim


@LEDGER.verified(
    "Figure 5",
    "frequency up to which decay takes less than 2 s at mu_m = .1, in Hz",
    14,
    note="the print has 'a large range of natural frequencies'; averaged law, good to half of a half cycle (.02 s)",
    numbers="a root by iteration, two digits",
)
def _(claim):
    return round(optimize.brentq(lambda f: transient.averaged_decay_time(f, 0.1) - 2, 5, 30)) - claim


LEDGER.unverifiable("Figures 8-10", "measured records and fitted mu_m", "the raw records are not in the source")
LEDGER.unverifiable(
    "Test apparatus",
    "equivalent masses .679 kg (steel) and .357 kg (aluminium)",
    "a solid steel rod of 16 mm and 610 mm weighs .96 kg at 7850 kg/m^3, more than the printed mass; whether the rod "
    "is hollow is not said",
    audit="objects that one leaf spring cannot give 5.3 Hz with both rods; but the spring is adjustable",
)
LEDGER.unverifiable("Conclusion 4", "(3) fits lubricated Hertzian contacts", "a statement about the experiments only")
