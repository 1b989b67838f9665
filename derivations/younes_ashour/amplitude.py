"""The averaged amplitude law; beyond the source."""

from functools import cache

import sympy as sp

from derivations.ledger import Ledger
from derivations.younes_ashour.system import A, g, m, mu, mu_m, omega, r, v0, v_c, x0, zeta
from symfric.model import laws
from symfric.model.symbols import SPEED
from symfric.theory import transient

PART = Ledger("younes_ashour", "the averaged amplitude law")

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


@PART.verified("averaged law: Wallis", "int_0^{pi/2} sin^n p dp", _wallis(j))
def _(claim):
    # W_0 and W_1, and n W_n = (n - 1) W_(n-2), by parts: int sin^n = (n - 1) int sin^(n-2) cos^2
    p = sp.Symbol("p", real=True)
    first = [sp.integrate(sp.sin(p) ** n, (p, 0, sp.pi / 2)) - claim.subs(j, n) for n in (0, 1)]
    return [*first, sp.expand_func((j + 2) * claim.subs(j, j + 2) - (j + 1) * claim)]


@PART.verified("averaged law: coefficients", "of a^(2j) and a^(2j+1) in F(a)", EVEN, ODD)
def _(even, odd):
    return [
        sp.expand_func(sp.gammasimp((claim - sign * _wallis(n + 1) / sp.factorial(n)).rewrite(sp.gamma)))
        for claim, n, sign in ((even, 2 * j, 1), (odd, 2 * j + 1, -1))
    ]


@PART.verified(
    "averaged law: F",
    "1 + (pi/2)(L_1(a) - I_1(a)), L_1 as 1F2",
    transient.mean_friction(symbolic=True),
    numbers=f"the first {2 * TERMS} coefficients, exactly",
)
def _(claim):
    # the first twelve coefficients; those of 1F2 and I_1 obey the recursion of EVEN and ODD by definition
    series = sp.series(claim.subs(A, z * v_c / omega), z, 0, 2 * TERMS).removeO()
    return series - sum(EVEN.subs(j, n) * z ** (2 * n) + ODD.subs(j, n) * z ** (2 * n + 1) for n in range(TERMS))


@PART.verified(
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


@PART.verified("averaged law", "A'", transient.amplitude_rate(), numbers="the first five coefficients, exactly")
def _(claim):
    return sp.expand(sp.series(claim, A, 0, POWERS).removeO() + _mean_power() / (m * omega**2 * A))


@PART.verified(
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


@PART.verified("averaged law: constant friction", "decay time from x0 at rest", COULOMB_TIME)
def _(claim):
    difference = _constant_friction_time().subs(A, START) - claim
    return difference.diff(START), difference.subs(START, 0)
