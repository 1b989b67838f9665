"""Methods of ``symfric.theory`` for any scene: Routh and Hurwitz, averaging across the sign of friction, separation of
fast and slow motion.
"""

import itertools
from functools import cache

import numpy as np
import sympy as sp

from derivations.effective_friction import BREAKS, CLUSTERED, F, G, branch, integrand, s
from derivations.ledger import Ledger
from derivations.oscillations import AMPLITUDE, BELT, oscillation
from derivations.residuals import less
from symfric.model import laws
from symfric.model.scene import Scene
from symfric.model.scenes import mass_on_belt
from symfric.model.symbols import SPEED, TIME
from symfric.model.system import Contact, System
from symfric.theory import belt
from symfric.theory.averaging import average
from symfric.theory.harmonics import Arc, arc_mean, ranges
from symfric.theory.hurwitz import characteristic_coefficients, routh_hurwitz, symbolic_hurwitz
from symfric.theory.separation import separate

LEDGER = Ledger("methods", "Routh and Hurwitz, averaging, separation of motions, for any scene")

# --- 1. Routh and Hurwitz ------------------------------------------------------------------------------------------
# p(s) = c_0 s^n + ... + c_n with c_0 > 0, and the minors D_1 ... D_n of H[i, j] = c_(2j - i + 1). Stable means that all
# roots lie left of the imaginary axis.
c = sp.symbols("c0:5")
z = sp.Symbol("z")


def minors(coefficients):
    n = len(coefficients) - 1
    matrix = sp.Matrix(n, n, lambda i, j: coefficients[2 * j - i + 1] if 0 <= 2 * j - i + 1 <= n else sp.Integer(0))
    return [sp.expand(matrix[: k + 1, : k + 1].det(method="berkowitz")) for k in range(n)]


MINORS = (c[1], c[1] * c[2] - c[0] * c[3], c[1] * c[2] * c[3] - c[0] * c[3] ** 2 - c[1] ** 2 * c[4])


@LEDGER.verified(
    "1.1",
    "minors for n = 4; symfric's on numbers",
    *MINORS,
    c[4] * MINORS[2],
    numbers="symfric's function on one polynomial",
)
def _(*claim):
    numbers = dict(zip(c, (2, 3, 11, 5, 4), strict=True))
    found = map(round, routh_hurwitz(list(numbers.values())).determinants)
    return [
        e
        for right, minor, number in zip(claim, minors(c), found, strict=True)
        for e in (right - minor, right.subs(numbers) - number)
    ]


# One step of Routh. Write p as the sum of its parts P0 with c_0, c_2, ... and P1 with c_1, c_3, ..., of which on the
# axis one is real and the other imaginary, and let k run from 0 to 1 in r_k = P0 - k (c_0/c_1) s P1 + P1. A root of r_k
# on the axis is one of P1 and of P0, so of p: if p has none, no root of r_k crosses. The only one that leaves, through
# infinity, is near -c_1/(c_0 (1 - k)). Hence p is stable if and only if c_1 > 0 and r = r_1, of degree n - 1, is too;
# and since D_1 = c_1 and D_k(p) = c_1 D_(k-1)(r), if and only if all its minors are positive.
def routh_step(coefficients):
    taken = [
        coefficients[k] - coefficients[0] / coefficients[1] * coefficients[k + 1]
        if k % 2 == 0 and k + 1 < len(coefficients)
        else coefficients[k]
        for k in range(len(coefficients))
    ]
    return taken[1:]


@LEDGER.verified("1.2", "minors of p from those of r, n = 4", *(c[1] * d for d in minors(routh_step(c))))
def _(*claim):
    return [right - minor for right, minor in zip(claim, minors(c)[1:], strict=True)]


# Orlando: the last minor but one vanishes where two roots are opposite, as a pair on the axis is.
ROOTS = sp.symbols("s1:5")


@LEDGER.verified(
    "1.3",
    "Orlando's product for n = 2, 3, 4",
    *((-1) ** (n * (n - 1) // 2) * sp.prod(a + b for a, b in itertools.combinations(ROOTS[:n], 2)) for n in (2, 3, 4)),
)
def _(*claim):
    left = []
    for n, right in zip((2, 3, 4), claim, strict=True):
        coefficients = sp.Poly(sp.prod(z - root for root in ROOTS[:n]), z).all_coeffs()
        left.append(sp.expand(right - minors(coefficients)[n - 2]))
    return left


@cache
def cubic_belt():
    """The mass on a belt with the cubic law in symbols; the numbers serve only to tell which way it slips."""
    law = laws.cubic(belt.SYMBOLS.mu_s, belt.SYMBOLS.mu_m, belt.SYMBOLS.v_m)
    return mass_on_belt(law, v_b=0.42).where({"mu_s": 0.4, "mu_m": 0.25, "v_m": 0.5})


@LEDGER.verified("1.4", "mass on a belt: both minors are the damping h1", *symbolic_hurwitz(cubic_belt()))
def _(*claim):
    v_b, beta, gamma2, *_ = belt.SYMBOLS
    friction = cubic_belt().contacts[0].law.kinetic.subs(SPEED, v_b - U)  # on the mass, while u < v_b
    u_slope = (-2 * beta * U + gamma2 * friction).diff(U).subs(U, 0)
    return [right + u_slope for right in claim]


# det(s I - A) has the sums of the principal minors of A as coefficients, with alternating signs.
MATRIX = sp.Matrix(3, 3, sp.symbols("a:3:3"))
PRINCIPAL = tuple(
    (-1) ** k * sum(MATRIX.extract(rows, rows).det() for rows in map(list, itertools.combinations(range(3), k)))
    for k in (1, 2, 3)
)


@LEDGER.verified(
    "1.5",
    "characteristic polynomial, n = 3; symfric's on numbers",
    *PRINCIPAL,
    numbers="symfric's function on one matrix",
)
def _(*claim):
    numbers = dict(zip(MATRIX, (2, -3, 5, 7, 11, -13, 17, 19, 23), strict=True))
    derived = sp.Poly((z * sp.eye(3) - MATRIX).det(), z).all_coeffs()[1:]
    found = characteristic_coefficients(np.array(MATRIX.subs(numbers), dtype=float))[1:]
    left = [sp.expand(e) for e in less(claim, derived)]
    return left + [right.subs(numbers) - round(value) for right, value in zip(claim, found, strict=True)]


# M q'' + B q' + K q = 0: the eigenvalues solve det(s^2 M + s B + K) = 0, and their sum and product stand in the
# coefficients. A sum above zero or a negative product leaves one on the right: the two quick verdicts of `stability`.
MASS, DAMPING, STIFFNESS = (sp.Matrix(2, 2, sp.symbols(f"{name}:2:2")) for name in "mbk")


@LEDGER.verified(
    "1.6", "sum and product of the eigenvalues", -(MASS.inv() * DAMPING).trace(), STIFFNESS.det() / MASS.det()
)
def _(*claim):
    first, second, *_, last = sp.Poly((z**2 * MASS + z * DAMPING + STIFFNESS).det(), z).all_coeffs()
    return claim[0] + second / first, claim[1] - last / first


# --- 2. Averaging, where the friction changes its sign on the way -------------------------------------------------
# x = A sin(psi), x' = A cos(psi), A' = -<h cos(psi)>. The slip is w = W + V cos(theta), and falls from W + V to W - V
# over 0 < theta < pi; the other half of the period is its mirror image, with sin -> -sin.
V, W = sp.symbols("V W", positive=True)
theta, X = sp.symbols("theta X", real=True)
U = sp.Symbol("u", real=True)


@LEDGER.verified(
    "2.1",
    "an arc's part of the mean, any law",
    arc_mean(lambda law, sine, cosine: law * (cosine + sine**2 + sine), Arc(X, 2 * X, F(SPEED), -1), W, V),
)
def _(claim):
    at = X + X * CLUSTERED
    friction = -F(-(W + V * sp.cos(at)))
    both = sum(friction * (sp.cos(at) + sp.sin(side * at) ** 2 + sp.sin(side * at)) for side in (1, -1))
    return sp.expand(integrand(claim) - both * at.diff(s) / (2 * sp.pi))


# Which arcs there are changes with V where an end W +- V of the slip meets a level 0, +-b_1, ... of the law.
SLIDING = sp.Rational(3, 10)


def arcs_between(low, high):
    """Yield the arcs for low < V < high between the levels that w passes for every such V; nan if it is not every."""
    levels = [sp.oo, *reversed(BREAKS), sp.Integer(0), *(-e for e in BREAKS), -sp.oo]

    def angle(level):
        if level >= SLIDING + high:
            return sp.Integer(0)
        if level <= SLIDING - high:
            return sp.pi
        return sp.acos((level - SLIDING) / V) if abs(level - SLIDING) <= low else sp.nan

    for upper, lower in itertools.pairwise(levels):
        if angle(upper) != angle(lower):
            sign = 1 if upper > 0 else -1
            yield angle(upper), angle(lower), sum(1 for e in BREAKS if max(abs(upper), abs(lower)) > e), sign


ANY = sp.Piecewise((G[0](SPEED), BREAKS[0] > SPEED), (G[1](SPEED), BREAKS[1] > SPEED), (G[2](SPEED), True))


def mean_over_arcs():
    """Mean of m cos(theta) as the package splits it, for every V."""
    pieces = []
    for top, found in ranges(ANY, BREAKS, SLIDING, V):
        mean = sum(arc_mean(lambda law, _, cosine: law * cosine, arc, SLIDING, V) for arc in found)
        pieces.append((mean, True if top is sp.oo else V < top))
    return sp.Piecewise(*pieces)


@LEDGER.verified("2.2", "the means over the arcs of any law of three branches, W = 3/10", mean_over_arcs())
def _(claim):
    left, low = [], sp.Integer(0)
    for right, condition in sp.piecewise_fold(claim).args:
        high = sp.oo if condition == True else condition.gts  # noqa: E712
        total = sp.Integer(0)
        for first, last, k, sign in arcs_between(low, high):
            at = first + (last - first) * CLUSTERED
            total += sign * G[k](sign * (SLIDING + V * sp.cos(at))) * sp.cos(at) * at.diff(s) / sp.pi
        left.append(sp.expand(integrand(right) - total))
        low = high
    return left


# The cubic law is a polynomial, and its mean closed, also where the mass overhauls the belt, during psi < psi_1 with
# A cos(psi_1) = v_b. (Sticking, which then fills a part of the period, is no part of this mean.)
@LEDGER.verified("2.3", "cubic law: A', slipping and overhauling", average(cubic_belt()).rate)
def _(claim):
    v_b, beta, gamma2, *_, mu_s, mu_m, v_m = belt.SYMBOLS
    law = cubic_belt().contacts[0].law.kinetic
    amplitude = AMPLITUDE * sp.cos(theta)
    forward = 2 * beta * amplitude + gamma2 * law.subs(SPEED, amplitude - v_b)
    backward = 2 * beta * amplitude - gamma2 * law.subs(SPEED, v_b - amplitude)
    turn = sp.acos(v_b / AMPLITUDE)

    def mean(force, low, high):
        return -sp.integrate(sp.expand(force * sp.cos(theta)), (theta, low, high)) / sp.pi

    slipping = mean(backward, 0, sp.pi)
    overhauling = mean(forward, 0, turn) + mean(backward, turn, sp.pi)
    point = {v_b: 2, mu_s: 1, mu_m: 1, v_m: 1, beta: 1, gamma2: 1}
    first, second = (branch(claim, {**point, AMPLITUDE: at}) for at in (1, 3))
    return first - slipping, (second - overhauling).rewrite(sp.asin)


# To second order, in pure slip, by the expansion of `oscillations.py`.
LETTERS = sp.symbols("h1 h2 h3", real=True)


def second_order_flow():
    slow = average(cubic_belt(), order=2)
    return slow.rate, slow.frequency


@LEDGER.verified("2.4", "cubic law: A' and frequency to second order", *second_order_flow())
def _(rate, frequency):
    v_b, beta, gamma2, *_ = belt.SYMBOLS
    friction = cubic_belt().contacts[0].law.kinetic.subs(SPEED, v_b - U)
    force = sp.Poly(2 * beta * U - gamma2 * friction, U)
    letters = dict(zip(LETTERS, (force.coeff_monomial(U**k) for k in (1, 2, 3)), strict=True))
    f, g, *_ = oscillation(BELT, LETTERS)
    derived = sum(f).subs(letters), sum(g[:3]).subs(letters)
    return [sp.expand(e) for e in less((rate, frequency), derived)]


# --- 3. Separation of fast and slow motion -----------------------------------------------------------------------
# Forces F = F_s sin(Omega t) + F_c cos(Omega t) of order Omega, as in Thomsen (31), move them by -M^-1 F/Omega^2.
# What is left of the start is the slow motion's, and velocities enter through their mean over the fast phase.
EVEN_POWERS = ((2, 0), (0, 2), (2, 2), (4, 0), (4, 2))


@cache
def mean_over_a_period(wave):
    return sp.integrate(wave, (theta, 0, 2 * sp.pi)) / (2 * sp.pi)


def mean_of_power(m, n):
    """Mean of sin^m cos^n."""
    if m % 2 or n % 2:
        return sp.Integer(0)
    return sp.factorial2(m - 1) * sp.factorial2(n - 1) / sp.factorial2(m + n)


@LEDGER.verified("3.1", "means of sin^m cos^n, m and n even", *(mean_of_power(m, n) for m, n in EVEN_POWERS))
def _(*claim):
    return less(claim, map(mean_over_a_period, (sp.sin(theta) ** m * sp.cos(theta) ** n for m, n in EVEN_POWERS)))


x1, x2, u1, u2 = sp.symbols("x1 x2 u1 u2", real=True)
m_1, m_2, m_c, rate, P1, R1, P2, R2, d1, d2, v_0, mu_s, mu_m, v_m = PARAMETERS = sp.symbols(
    "m_1 m_2 m_c omega P1 R1 P2 R2 d1 d2 v_0 mu_s mu_m v_m", positive=True
)
COUPLED = sp.Matrix([[m_1, m_c], [m_c, m_2]])


@cache
def separated():
    """Two coupled masses with forces of all phases, damped by u1^2 u2 and u2^3, in contact with each other."""
    phase = rate * TIME
    shake = [P1 * sp.sin(phase) + R1 * sp.cos(phase), P2 * sp.sin(phase) + R2 * sp.cos(phase)]
    force = [-x1 - d1 * u1**2 * u2 + shake[0], -x2 - d2 * u2**3 + shake[1]]
    scene = Scene(
        system=System(q=[x1, x2], u=[u1, u2], mass=COUPLED, force=force),
        contacts=[Contact("pad", slip=u1 - u2 + v_0, normal=1, law=laws.cubic(mu_s, mu_m, v_m))],
        values={symbol: 2 - 0.1 * k for k, symbol in enumerate(PARAMETERS)},
        initial={x1: 0.0, x2: 0.0, u1: 0.0, u2: 0.0},
        horizon=1.0,
    )
    return separate(scene)


def slow_claim():
    slow = separated()
    (break_,) = slow.contacts[0].law.breaks  # the intensity
    return *(slow.initial[state] for state in (x1, x2, u1, u2)), *slow.system.force, break_**2


@cache
def slow_motion():
    """The same from the fast motion."""
    shake = sp.Matrix([P1 * sp.sin(theta) + R1 * sp.cos(theta), P2 * sp.sin(theta) + R2 * sp.cos(theta)])
    fast = -(COUPLED.inv() * shake) / rate**2
    speed = fast.diff(theta) * rate
    moved = {u1: u1 + speed[0], u2: u2 + speed[1]}
    damping = [(-d1 * u1**2 * u2).subs(moved, simultaneous=True), (-d2 * u2**3).subs(moved, simultaneous=True)]
    terms = (sp.Poly(e, sp.sin(theta), sp.cos(theta)).terms() for e in damping)
    means = [sum(c * mean_of_power(*powers) for powers, c in found) for found in terms]
    slip = sp.expand(speed[0] - speed[1])
    intensity = slip.coeff(sp.sin(theta)) ** 2 + slip.coeff(sp.cos(theta)) ** 2
    return *(-fast.subs(theta, 0)), *(-speed.subs(theta, 0)), means[0] - x1, means[1] - x2, intensity


@LEDGER.verified("3.2", "two masses: start, forces and intensity of the slow motion", *slow_claim())
def _(*claim):
    return less(claim, slow_motion())
