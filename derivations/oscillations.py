"""Oscillations of small amplitude or small nonlinearity: the expansion to second order, and the Hopf coefficient.

``symfric.theory.second_order`` and ``symfric.theory.hopf`` serve any scene; ``thomsen_beyond.py`` applies their
results to the mass on a belt.
"""

import itertools
from functools import cache

import sympy as sp

from derivations.ledger import Ledger
from derivations.residuals import agree, less
from symfric.model.scene import Scene
from symfric.model.system import System
from symfric.theory.hopf import hopf
from symfric.theory.second_order import expansion

LEDGER = Ledger("oscillations", "Expansion of Krylov, Bogoliubov and Mitropolsky; normal form of Hopf points")

# --- 1. Oscillations of x'' + x + e h(x, x') = 0, after Krylov, Bogoliubov and Mitropolsky -------------------------
# x = A cos(psi) + e u1(A, psi) + e^2 u2 + ... with A' = e f1 + e^2 f2 + ..., psi' = 1 + e g1 + ..., no first harmonic
# in u1, u2, ...: A is that of the first harmonic. The time derivative is A' d/dA + psi' d/dpsi. At each power of e
# the equation asks u_k'' + u_k - 2 f_k sin(psi) - 2 A g_k cos(psi) to cancel what the lower powers leave: the first
# harmonic of that gives f_k and g_k, the harmonic n divided by n^2 - 1 gives u_k.
ORDER = 3
TURN, AMPLITUDE = sp.Symbol("E"), sp.Symbol("A", positive=True)  # TURN is exp(i psi)


@cache
def oscillation(monomials, coefficients, order=ORDER):
    """f_0, f_1, ..., g_0, ..., u_0, ... in A and E = exp(i psi), for h a sum of x^m x'^n, m + n <= 3."""
    # u_k has harmonics up to 1 + 2 k, and stands here multiplied by E^(1 + 2 k)
    ring, E, A, *c = sp.ring((TURN, AMPLITUDE, *coefficients), sp.QQ_I)
    i, zero = ring(sp.I), ring(0)
    f, g = [zero] * (order + 1), [ring(1)] + [zero] * order
    u = [A * (E**2 + 1) / 2] + [zero] * order

    def rate(series):
        slow = [wave.diff(A) for wave in series]
        fast = [i * (E * wave.diff(E) - (1 + 2 * k) * wave) for k, wave in enumerate(series)]
        return [
            sum((E ** (2 * a) * (f[a] * slow[k - a] + g[a] * fast[k - a]) for a in range(k + 1)), zero)
            for k in range(order + 1)
        ]

    for k in range(1, order + 1):
        speed = rate(u)
        left = rate(speed)[k] + u[k]
        for (m, n), factor in zip(monomials, c, strict=True):
            product = [factor * E ** (3 - m - n)] + [zero] * (k - 1)
            for wave in [u] * m + [speed] * n:
                product = [sum((product[a] * wave[j - a] for a in range(j + 1)), zero) for j in range(k)]
            left += product[k - 1]
        harmonics = {}
        for (power, *rest), factor in left.terms():
            harmonics.setdefault(power - 1 - 2 * k, {})[(0, *rest)] = factor
        harmonics = {n: ring.from_dict(terms) for n, terms in harmonics.items()}
        plus, minus = (harmonics.pop(n, zero) for n in (1, -1))
        f[k], g[k] = i * (plus - minus) / 2, ((plus + minus) / 2).exquo(A)
        u[k] = sum((wave * E ** (n + 1 + 2 * k) / (n**2 - 1) for n, wave in harmonics.items()), zero)
    waves = [sp.expand(wave.as_expr() / TURN ** (1 + 2 * k)) for k, wave in enumerate(u)]
    speeds = [sp.expand(wave.as_expr() / TURN ** (1 + 2 * k)) for k, wave in enumerate(rate(u))]
    return [e.as_expr() for e in f], [e.as_expr() for e in g], waves, speeds


def extreme(series, quarter):
    """Extreme near psi = quarter pi/2 of p0 + e p1 + e^2 p2: it lies at -e p1'/p0'', so p2 gains -p1'^2/(2 p0'')."""

    def at(wave, order):
        for _ in range(order):
            wave = sp.expand(sp.I * TURN * wave.diff(TURN))
        return sp.expand(wave.subs(TURN, sp.I**quarter))

    zeroth, first, second = series[:3]
    return at(zeroth, 0), at(first, 0), sp.expand(at(second, 0) - at(first, 1) ** 2 / (2 * at(zeroth, 2)))


BELT = ((0, 1), (0, 2), (0, 3))  # damping of first to third power
MIXED = ((0, 1), (2, 0), (1, 1), (0, 2), (3, 0), (0, 3))  # and forces that bend with the position


def expansion_rows(number, name, monomials):
    found = expansion(monomials)

    @LEDGER.verified(f"1.{number}", f"{name}: f1, f2, f3, g1, g2, g3", *found.rates, *found.frequencies)
    def _(*claim):
        f, g, *_ = oscillation(monomials, found.coefficients)
        return [sp.expand(right - left) for right, left in zip(claim, (*f[1:], *g[1:]), strict=True)]

    places = [(quarter, 2) for quarter in found.position] + [(quarter, 3) for quarter in found.velocity]
    claims = [*found.position.values(), *found.velocity.values()]

    @LEDGER.verified(f"1.{number + 1}", f"{name}: extremes of x and of x'", *itertools.chain(*claims))
    def _(*claim):
        results = oscillation(monomials, found.coefficients)
        derived = [e for quarter, which in places for e in extreme(results[which], quarter)]
        return [sp.expand(e) for e in less(claim, derived)]


expansion_rows(1, "powers of x'", BELT)
expansion_rows(3, "powers of x and x'", MIXED)


# t -> -t, x -> -x, e -> -e leaves the equation alone when h depends on x' only. A' and psi' - 1 change their signs with
# t and with e, so that A' is odd in e, and psi' even.
@LEDGER.verified("1.5", "powers of x': f2, g1, g3 and the first order of the extremes vanish", *[sp.Integer(0)] * 5)
def _(*claim):
    f, g, waves, speeds = oscillation(BELT, expansion(BELT).coefficients)
    half_range = extreme(waves, 0)[1] - extreme(waves, 2)[1]
    return less((f[2], g[1], g[3], half_range, extreme(speeds, 3)[1]), claim)


# --- 2. Hopf points ------------------------------------------------------------------------------------------------
# At the Hopf point h has no linear damping, and A' = a A^3 + O(A^5): a is what f1 and f2 hold of A^3.
QUADRATIC_CUBIC = ((2, 0), (1, 1), (0, 2), (3, 0), (2, 1), (1, 2), (0, 3))
c20, c11, c02, c30, c21, c12, c03 = COEFFICIENTS = sp.symbols("c20 c11 c02 c30 c21 c12 c03", real=True)
PLANAR = (c11 * (c20 + c02) - c21 - 3 * c03) / 8


@LEDGER.verified("2.1", "a for x'' + x + sum of c_mn x^m x'^n = 0", PLANAR)
def _(claim):
    f, *_ = oscillation(QUADRATIC_CUBIC, COEFFICIENTS, order=2)
    return sp.expand(f[1] + f[2]).coeff(AMPLITUDE, 3) - claim


# Any number of states: y' = J y + sigma y + N2(y) + N3(y), where J turns the first two states with omega and damps the
# others. By harmonic balance y = r (cos, sin, 0) + r^2 y2 + r^3 y3 is periodic for sigma = r^2 s2 + ...; there, growth
# sigma r + a r^3 vanishes, so a = -s2. The harmonics n = 0, +-2 of y2 solve (i n omega - J) y2 = N2. At r^3 the first
# harmonic is solvable if the product with l = (1, i, 0), l J = i omega l, vanishes: l s2 (1, -i, 0)/2 = s2, a change of
# frequency, which is imaginary, and l of the first harmonic of N2 + N3 at r^3. So a is the real part of the last.
OMEGA = sp.Rational(3, 2)
J = sp.Matrix([[0, -OMEGA, 0], [OMEGA, 0, 0], [0, 0, -sp.Rational(4, 5)]])
Y = sp.Matrix(sp.symbols("y1:4"))
y1, y2, y3 = Y
N = sp.ImmutableMatrix(
    [
        y1**2 - 2 * y1 * y2 + 3 * y2**2 + y1 * y3 - y2 * y3 + y3**2 - y1**3 + y1 * y2**2,
        2 * y1**2 + y1 * y2 - y2**2 + 3 * y1 * y3 + 2 * y2 * y3 + y2**3 - 2 * y1**2 * y2,
        y1**2 - 4 * y1 * y2 - 2 * y2**2 + y2 * y3 + y1**2 * y3,
    ]
)
MIX = sp.Matrix([[2, 1, 1], [1, 1, -1], [0, 1, 3]])  # x = MIX y, the states of a scene


@cache
def balanced(bent):
    """The coefficient a of r' = a r^3, r the amplitude of y1, by harmonic balance of y' = J y + bent."""
    grow = sp.Symbol("r")
    first = sp.Matrix([(TURN + 1 / TURN) / 2, (TURN - 1 / TURN) / (2 * sp.I), 0])

    def coefficient(vector, power, harmonic):
        return vector.applyfunc(lambda e: sp.expand(e * TURN**9).coeff(grow, power).coeff(TURN, harmonic + 9))

    forced = bent.subs(dict(zip(Y, grow * first, strict=True)))
    second = sp.zeros(3, 1)
    for n in (-2, 0, 2):
        second += (sp.I * n * OMEGA * sp.eye(3) - J).solve(coefficient(forced, 2, n)) * TURN**n
    forced = bent.subs(dict(zip(Y, grow * first + grow**2 * second, strict=True)))
    return sp.re(sp.expand((sp.Matrix([[1, sp.I, 0]]) * coefficient(forced, 3, 1))[0]))


@cache
def projections():
    """Return in x, with <p, q> = 1, the terms <p, C(q, q, q*)>, <p, B(q*, (2 i omega - A)^-1 B(q, q))> and
    <p, B(q, A^-1 B(q, q*))>; |q_1|^2; and A q - i omega q.
    """
    x = sp.Matrix(sp.symbols("x1:4"))
    field = MIX * N.subs(dict(zip(Y, MIX.inv() * x, strict=True)), simultaneous=True)
    A = MIX * J * MIX.inv()

    def form(*vectors):
        # the derivative along several directions at x = 0 is the coefficient of the product of their parameters
        steps = sp.symbols(f"t:{len(vectors)}")
        moved = sum((t * v for t, v in zip(steps, vectors, strict=True)), sp.zeros(3, 1))
        along = field.subs(dict(zip(x, moved, strict=True)), simultaneous=True)
        for t in steps:
            along = along.diff(t)
        return along.subs(dict.fromkeys(steps, 0)).applyfunc(sp.expand)

    q = (2 + sp.I) * MIX * sp.Matrix([1, -sp.I, 0])
    p = sp.Matrix([[1, sp.I, 0]]) * MIX.inv()
    p = p / sp.expand((p * q)[0])
    bent = (2 * sp.I * OMEGA * sp.eye(3) - A).solve(form(q, q))
    shift = A.solve(form(q, q.conjugate()))
    terms = form(q, q, q.conjugate()), form(q.conjugate(), bent), form(q, shift)
    eigen = (A * q - sp.I * OMEGA * q).applyfunc(sp.expand)
    return [sp.expand((p * t)[0]) for t in terms], sp.expand(q[0] * q[0].conjugate()), eigen


C_TERM, B_TERM, SHIFT_TERM, SIZE = sp.symbols("C_qqq B_bent B_shift q_1^2", real=True)


@LEDGER.verified(
    "2.2",
    "projection on the centre manifold, three states",
    (C_TERM + B_TERM - 2 * SHIFT_TERM) / 2 / (4 * SIZE),
    numbers="one field of degree three, exactly",
)
def _(claim):
    terms, size, eigen = projections()
    numbers = dict(zip((C_TERM, B_TERM, SHIFT_TERM), map(sp.re, terms), strict=True))
    in_x = balanced(N) / (MIX[0, 0] ** 2 + MIX[0, 1] ** 2)  # by the amplitude of x1
    return claim.subs({**numbers, SIZE: size}) - in_x, *eigen


# With a mass matrix, M a = G. Along a line through the equilibrium, where a = 0, this is differentiated two and three
# times; the multilinear forms are the polarisations of the results.
M_0, M_1, M_2, G_1, G_2, G_3, t = sp.symbols("M0 M1 M2 G1 G2 G3 t")
A_1, A_2 = sp.symbols("a1 a2")


@LEDGER.verified(
    "2.3",
    "second and third derivative of a",
    (G_2 - 2 * M_1 * A_1) / M_0,
    (G_3 - 3 * M_1 * A_2 - 3 * M_2 * A_1) / M_0,
)
def _(*claim):
    a = (G_1 * t + G_2 * t**2 / 2 + G_3 * t**3 / 6) / (M_0 + M_1 * t + M_2 * t**2 / 2)
    slopes = [a.diff(t, k).subs(t, 0) for k in (1, 2, 3)]
    values = {A_1: slopes[0], A_2: slopes[1]}
    return [slopes[k + 1] - right.subs(values) for k, right in enumerate(claim)]


# The package's own number, for a mass that varies with the position and a state of first order. In q = y1, u = q' =
# -omega y2, z = y3 a force -omega^2 q + F and a rate -(4/5) z + G give N = (0, -(acceleration + omega^2 q)/omega, G).
q, u, w = sp.symbols("q u w", real=True)
MASS = 1 + q / 2 + q**2 / 4
FORCE = -(OMEGA**2) * q + q * u - 2 * u**2 + q**2 - u * w + 2 * q * w - u**3 + q**2 * u
RATE = J[2, 2] * w + q**2 + 3 * q * u - u**2


def varying_mass() -> Scene:
    growth = sp.Symbol("growth", real=True)
    system = System(q=[q], u=[u], mass=[[MASS]], force=[FORCE + growth * u], z=[w], z_rate=[RATE])
    start = {q: 0.0, u: 0.0, w: 0.0}
    return Scene(system=system, contacts=[], values={growth: 0.0}, initial=start, horizon=1.0)


@LEDGER.verified(
    "2.4",
    "symfric's coefficient for a mass that varies and a state of first order",
    sp.Float(hopf(varying_mass(), "growth", (-0.5, 0.4)).first_lyapunov),
    numbers="one scene, 12 digits",
)
def _(claim):
    scaled = (FORCE / MASS + OMEGA**2 * q).subs({q: t * q, u: t * u, w: t * w}, simultaneous=True)
    acceleration = sum(scaled.diff(t, k).subs(t, 0) / sp.factorial(k) for k in (1, 2, 3))
    bent = sp.ImmutableMatrix([0, -acceleration / OMEGA, RATE - J[2, 2] * w])
    return agree(balanced(bent.subs({q: y1, u: -OMEGA * y2, w: y3}).applyfunc(sp.expand)), claim)
