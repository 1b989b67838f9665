"""Two slides in friction: their equations and the stability of steady sliding, (21)-(27)."""

from functools import cache

import sympy as sp

from derivations.ledger import Ledger
from derivations.residuals import agree, less
from symfric.theory import drive

PART = Ledger("guida", "III")
v, t = sp.Symbol("v", positive=True), sp.Symbol("t", real=True)
f = sp.Symbol("f", real=True)

# --- III. Two slides: equations --------------------------------------------------------------------------------
# Slide 1 is drawn through k1 and sigma1 by the support, slide 2 is held by k2 and sigma2; friction acts between them.
m1, r, zeta, omega1, s1, s2, d2, fc1, fs1 = sp.symbols("m1 r zeta omega1 s1 s2 d2 fc1 fs1", positive=True)
k1, k2, sigma1, sigma2, m2 = sp.symbols("k1 k2 sigma1 sigma2 m2", positive=True)
e1, e1d, e1dd, e2, e2d, e2dd = sp.symbols("eta1 eta1d eta1dd eta2 eta2d eta2dd", real=True)
X1, X1d, X1dd, X2, X2d, X2dd, force = sp.symbols("X1 X1d X1dd X2 X2d X2dd F", real=True)


@PART.verified(
    "(21)",
    "motion of the two slides",
    m1 * X1dd + sigma1 * (X1d - v) + k1 * (X1 - v * t) + force,
    m2 * X2dd + sigma2 * X2d + k2 * X2 - force,
)
def _(*claim):
    # Lagrange's equations with Rayleigh's function; friction does the virtual work -F (delta X1 - delta X2)
    q1, q2 = sp.Function("q1")(t), sp.Function("q2")(t)
    d1, d2_ = sp.diff(q1, t), sp.diff(q2, t)
    L = (m1 * d1**2 + m2 * d2_**2 - k1 * (q1 - v * t) ** 2 - k2 * q2**2) / 2
    rayleigh = (sigma1 * (d1 - v) ** 2 + sigma2 * d2_**2) / 2
    names = {sp.diff(q1, t, 2): X1dd, sp.diff(q2, t, 2): X2dd, d1: X1d, d2_: X2d, q1: X1, q2: X2}
    left = []
    for place, rate, work, c in ((q1, d1, -force, claim[0]), (q2, d2_, force, claim[1])):
        motion = sp.diff(sp.diff(L, rate), t) - sp.diff(L, place) + sp.diff(rayleigh, rate) - work
        left.append(sp.expand(motion.subs(names) - c))
    return left


PART.definition(
    "(22)", "Coulomb friction with static force Fs and kinetic force Fc", note="odd; sticking carries any |F| < Fs"
)

# (23): X1 - v t = v eta1/omega1, X2 = v eta2/omega1, tau = omega1 t. In any friction law that is odd the two arguments
# of (24) can be told apart by a linear and a cubic term.
law1, law3 = sp.symbols("a1 a3", positive=True)


def odd_law(speed):
    """Return an odd friction force."""
    return law1 * speed + law3 * speed**3


@cache
def two_slides():
    """Return the equations of (21) in the variables of (23), over m1 omega1 v and m2 omega1 v; sigma2 is left."""
    place = {
        X1: v * e1 / omega1 + v * t,
        X1d: v * e1d + v,
        X1dd: v * omega1 * e1dd,
        X2: v * e2 / omega1,
        X2d: v * e2d,
        X2dd: v * omega1 * e2dd,
    }
    given = {k1: m1 * omega1**2, k2: m1 / r * (omega1 / zeta) ** 2, sigma1: 2 * s1 * m1 * omega1, m2: m1 / r}
    F = odd_law(X1d - X2d)
    one = m1 * X1dd + sigma1 * (X1d - v) + k1 * (X1 - v * t) + F
    two = m2 * X2dd + sigma2 * X2d + k2 * X2 - F
    one, two = (e.subs(place).subs(given) for e in (one, two))
    return sp.expand(one / (m1 * omega1 * v)), sp.expand(two * r / (m1 * omega1 * v))


BY_OMEGA2 = {sigma2: 2 * s2 * (m1 / r) * (omega1 / zeta)}  # as (23) is printed
BY_OMEGA1 = {sigma2: 2 * s2 * (m1 / r) * omega1}  # as (24) is printed
RELATIVE = e1d - e2d


@PART.corrected(
    "(23)",
    "s2, so that (24) holds as printed",
    right=sigma2 * r / (2 * m1 * omega1),
    printed=sigma2 * r / (2 * m1 * omega1 / zeta),
    note="(23) refers s2 to omega2, (24) to omega1: they contradict each other unless zeta = 1. Figures 14 and 15 come "
    "out with (24), see there; then this is the correction to make, and that of the damping in (24) line 2 is not",
)
def _(claim):
    return sp.diff(two_slides()[1], e2d).coeff(sigma2) * sigma2 / 2 - claim


@PART.corrected(
    "(24) line 1",
    "motion of slide 1",
    right=e1dd + 2 * s1 * e1d + e1 + odd_law(v * (RELATIVE + 1)) / (m1 * omega1 * v),
    printed=e1dd + 2 * s1 * e1d + e1 + odd_law(v * RELATIVE + 1) / (m1 * omega1 * v),
    note="F{v[(eta1' - eta2')] + 1} is printed: X1' - X2' = v (eta1' - eta2' + 1). The text says (23) for (21)",
)
def _(claim):
    return sp.expand(two_slides()[0] - claim)


def line2(damping, argument):
    """Return the second line of (24)."""
    return e2dd + damping * e2d + e2 / zeta**2 + r * odd_law(argument) / (m1 * omega1 * v)


@PART.corrected(
    "(24) line 2",
    "motion of slide 2, s2 as (23) defines it",
    right=line2(2 * s2 / zeta, -v * (RELATIVE + 1)),
    printed=line2(2 * s2, -v * RELATIVE + 1),
    note="F{-v[(eta1' - eta2')] + 1} is printed, and 2 s2 eta2', which is 2 (s2/zeta) eta2' by (23)",
)
def _(claim):
    return sp.expand(two_slides()[1].subs(BY_OMEGA2) - claim)


@PART.corrected(
    "(24) line 2, d2 = s2",
    "motion of slide 2, s2 = sigma2/(2 m2 omega1)",
    right=line2(2 * s2, -v * (RELATIVE + 1)),
    printed=line2(2 * s2, -v * RELATIVE + 1),
    note="the other reading, which the figures follow; only the argument of F is wrong then",
)
def _(claim):
    return sp.expand(two_slides()[1].subs(BY_OMEGA1) - claim)


@PART.verified("(25)", "eta1' - eta2' without sliding", sp.Integer(-1))
def _(claim):
    speed = (v * e1d + v) - v * e2d
    return sp.solve(speed, e1d)[0] - e2d - claim


# Sticking, w = eta1' - eta2' + 1 stays 0: eta1'' = eta2'' fixes the friction.
@PART.verified(
    "(24) with (25)",
    "friction over m1 omega1 v while sticking",
    (2 * d2 * e2d + e2 / zeta**2 - 2 * s1 * e1d - e1) / (1 + r),
)
def _(claim):
    one, two = e1dd + 2 * s1 * e1d + e1 + f, e2dd + 2 * d2 * e2d + e2 / zeta**2 - r * f
    accelerations = sp.solve([one, two], [e1dd, e2dd])
    (carried,) = sp.solve(accelerations[e1dd] - accelerations[e2dd], f)
    return carried - claim


@PART.verified(
    "after (25)",
    "the one equilibrium, eta1 and eta2",
    -fc1,
    r * zeta**2 * fc1,
    note="w = 1 there, so that the friction is kinetic; with a support at rest any |F| <= Fs is possible instead",
)
def _(*claim):
    at_rest = [e1 + fc1, e2 / zeta**2 - r * fc1]  # w = 1 > 0
    found = sp.solve(at_rest, [e1, e2])
    return found[e1] - claim[0], found[e2] - claim[1]


# With a support at rest the text lets the slides come to rest "in a finite time". Friction between them ends their
# relative motion in a finite time; from then on they move as one, r times (24) line 1 and line 2 without friction, and
# that motion decays as exp(-rate tau): never in a finite time.
@PART.corrected(
    "after (27) zero speed",
    "rate at which the common motion of slides that stick to each other decays, support at rest",
    right=(r * s1 + d2) / (1 + r),
    printed=sp.oo,
    note="'to which will tend in a finite time': only their relative motion ends then; the springs and viscous dampers "
    "bring the common motion to rest exponentially",
)
def _(claim):
    rate = sp.Symbol("rate")
    together = r * (e1dd + 2 * s1 * e1d + e1 + f) + (e1dd + 2 * d2 * e1d + e1 / zeta**2 - r * f)  # eta1 = eta2
    if claim == sp.oo:
        return claim
    polynomial = sp.expand(together).subs({e1dd: rate**2, e1d: rate, e1: 1})
    return -sum(sp.roots(sp.Poly(polynomial, rate))) / 2 - claim


# In deviations from the equilibrium forward sliding is homogeneous, and a stick ends where the friction is fs1 - fc1
# above its kinetic value: a cycle without backward sliding knows only that difference.
@PART.verified("(24), Section IV", "friction in deviations from the equilibrium when a stick ends", fs1 - fc1)
def _(claim):
    carried = (2 * d2 * e2d + e2 / zeta**2 - 2 * s1 * e1d - e1) / (1 + r)
    shifted = carried.subs({e1: e1 - fc1, e2: e2 + r * zeta**2 * fc1})
    (place,) = sp.solve(shifted - fs1, e1)
    return carried.subs(e1, place) - claim


# --- III. Two slides: stability of steady sliding --------------------------------------------------------------
# (24) near the equilibrium, with a friction of slope beta = 2 mu m1 omega1: F/(m1 omega1 v) = f + 2 mu (w - 1).
R_, ZETA_, S1_, D2_, MU_ = drive.SYMBOLS
TO_THEORY = {r: R_, zeta: ZETA_, s1: S1_, d2: D2_}
RATES = sp.Matrix([e1d, e2d])
PLACES = sp.Matrix([e1, e2])


@cache
def linearised():
    """Return B and K of (26), the mass matrix being the unit matrix, in the symbols of symfric.theory."""
    kinetic = f + 2 * MU_ * (e1d - e2d)
    forces = sp.Matrix([2 * s1 * e1d + e1 + kinetic, 2 * d2 * e2d + e2 / zeta**2 - r * kinetic]).subs(TO_THEORY)
    return forces.jacobian(RATES), forces.jacobian(PLACES)


@PART.verified("(26)", "B and K, row by row", *drive.damping_matrix(symmetric=False), sp.Integer(1), 0, 0, 1 / ZETA_**2)
def _(*claim):
    B, K = linearised()
    return [sp.expand(e) for e in less((*B, *K), claim)]


@PART.verified(
    "(26) symmetric",
    "B with the second row over r, M = diag(1, 1/r)",
    *drive.damping_matrix(),
    note="as (24) stands B is not symmetric; its symmetric part is another matrix, positive definite less often",
)
def _(*claim):
    B, _ = linearised()
    B = sp.diag(1, 1 / R_) * B
    return [*(sp.expand(a - b) for a, b in zip(B, claim, strict=True)), sp.expand(B[0, 1] - B[1, 0])]


# The theorem of Kelvin, Tait and Chetaev. Let M and K be symmetric and positive definite, V = (eta'^T M eta' + eta^T
# K eta)/2. Along M eta'' + B eta' + K eta = 0, V' = -eta'^T B eta': the skew (gyroscopic) part of B drops out. If the
# symmetric part is positive definite, V falls wherever eta' is not 0; a motion with eta' = 0 throughout has K eta = 0,
# that is eta = 0. So V is a Lyapunov function, and eta = 0 is asymptotically stable (Lasalle).
b11, b12, b22, g = sp.symbols("b11 b12 b22 g", real=True)
m11, m12, m22, k11, k12, k22 = sp.symbols("m11 m12 m22 k11 k12 k22", real=True)


@PART.verified(
    "after (26)",
    "definiteness is sufficient (Kelvin, Tait, Chetaev): rate of the energy, and det K",
    -(b11 * e1d**2 + 2 * b12 * e1d * e2d + b22 * e2d**2),
    1 / (R_ * ZETA_**2),
)
def _(rate, determinant):
    M, K = sp.Matrix([[m11, m12], [m12, m22]]), sp.Matrix([[k11, k12], [k12, k22]])
    B = sp.Matrix([[b11, b12 + g], [b12 - g, b22]])
    energy = ((RATES.T * M * RATES + PLACES.T * K * PLACES) / 2)[0]
    pull = -M.inv() * (B * RATES + K * PLACES)
    change = sp.Matrix([energy]).jacobian([*PLACES, *RATES]) * sp.Matrix([*RATES, *pull])
    return change[0] - rate, (sp.diag(1, 1 / R_) * linearised()[1]).det() - determinant


def negative_limit(condition):
    """Return the size of the mu at which a condition linear in mu vanishes."""
    (zero,) = sp.solve(condition, MU_)
    return -zero


LIMIT = S1_ * D2_ / (R_ * S1_ + D2_)


@PART.corrected(
    "(27)",
    "definiteness of the damping: bound on -mu",
    right=LIMIT,
    printed=S1_ * D2_ / (S1_ + D2_),
    note="two denominators are lost in the text, (s1 s2/ )(s1 + s2/ )^-1, and are left out in the printed form here. "
    "That both were r is an assumption: it makes the condition right for d2 = s2. Without them it fails unless r = 1",
)
def _(claim):
    B = sp.diag(1, 1 / R_) * linearised()[0]
    return negative_limit(sp.expand(B.det())) - claim, sp.expand(R_ * B.det() - drive.definite_condition())


@PART.verified(
    "(27) minors",
    "at the bound both diagonal elements of B are still positive: their halves",
    R_ * S1_**2 / (R_ * S1_ + D2_),
    D2_**2 / (R_ * S1_ + D2_),
)
def _(*claim):
    B, _ = linearised()
    at_limit = {MU_: -negative_limit(drive.definite_condition())}
    return [B[k, k].subs(at_limit) / 2 - c for k, c in enumerate(claim)]


# Coulomb friction has no slope, mu = 0: the bound holds.
@PART.verified("after (27)", "without a gradient B is positive definite: its determinant over 4", S1_ * D2_)
def _(claim):
    return sp.expand(linearised()[0].subs(MU_, 0).det() / 4 - claim)


# Exactly: det(s^2 + s B + K) = s^4 + a1 s^3 + a2 s^2 + a3 s + a4. All roots have negative real parts if and only if a1,
# a3, a4 > 0 and Delta3 = a1 a2 a3 - a3^2 - a1^2 a4 > 0 (Lienard and Chipart).
@cache
def coefficients():
    """Return a1 ... a4."""
    s = sp.Symbol("s")
    B, K = linearised()
    return sp.Poly((s**2 * sp.eye(2) + s * B + K).det(), s).all_coeffs()[1:]


@PART.verified("(27) exact", "Routh-Hurwitz: a1, a3 and Delta3 of symfric.theory.drive", *drive.hurwitz_conditions())
def _(*claim):
    a1, a2, a3, a4 = coefficients()
    exact = a1, a3, a1 * a2 * a3 - a3**2 - a1**2 * a4
    return less(exact, claim)


# a4 = 1/zeta^2 > 0 always, and then the minor Delta2 = a1 a2 - a3 is positive of itself:
@PART.verified(
    "(27) exact, second minor",
    "Delta2 by the three conditions",
    sp.simplify(
        (drive.hurwitz_conditions()[2] + drive.hurwitz_conditions()[0] ** 2 / ZETA_**2) / drive.hurwitz_conditions()[1]
    ),
)
def _(claim):
    a1, a2, a3, _ = coefficients()
    return a1 * a2 - a3 - claim


@PART.verified(
    "(27) exact, all three",
    "a1 > 0 and Delta3 > 0 are not enough: their values and the number of unstable roots, r = 1, zeta = 2, s1 = 76, "
    "d2 = 1, mu = -26",
    sp.Integer(50),
    sp.Rational(19254375, 2),
    sp.Integer(2),
    note="so a3 = k B11 + B22 > 0 is needed as well",
    numbers="roots of one polynomial, 15 digits",
)
def _(first, last, unstable):
    point = {R_: 1, ZETA_: 2, S1_: 76, D2_: 1, MU_: -26}
    a1, a2, a3, a4 = (a.subs(point) for a in coefficients())
    s = sp.Symbol("s")
    roots = sp.Poly(s**4 + a1 * s**3 + a2 * s**2 + a3 * s + a4, s).nroots()
    count = sum(1 for root in roots if sp.re(root) > 0)
    return a1 - first, a1 * a2 * a3 - a3**2 - a1**2 * a4 - last, count - unstable


@PART.verified(
    "(27) zeta = 1",
    "there definiteness is necessary too: Delta3 over the determinant of B",
    4 * (S1_ + D2_ + MU_ * (1 + R_)) ** 2,
)
def _(claim):
    a1, a2, a3, a4 = (a.subs(ZETA_, 1) for a in coefficients())
    return (a1 * a2 * a3 - a3**2 - a1**2 * a4) / linearised()[0].det() - claim


# At the bound (27) the determinant vanishes, and Delta3 is what the second term leaves: positive unless zeta = 1. So
# steady sliding is still stable there, and somewhat beyond.
@PART.verified(
    "(27) gap",
    "Delta3 at the bound (27)",
    4 * R_ * (1 - 1 / ZETA_**2) ** 2 * (S1_ * D2_) ** 2 / (R_ * S1_ + D2_) ** 2,
)
def _(claim):
    a1, a2, a3, a4 = (a.subs(MU_, -negative_limit(drive.definite_condition())) for a in coefficients())
    return a1 * a2 * a3 - a3**2 - a1**2 * a4 - claim


@PART.verified(
    "(27) not necessary",
    "r = .5, zeta = 2, s1 = .2, d2 = .3, mu = -.16: determinant of B, and the number of unstable roots",
    -sp.Rational(2, 125),
    sp.Integer(0),
    numbers="roots of one polynomial, 15 digits",
)
def _(determinant, unstable):
    point = {R_: sp.Rational(1, 2), ZETA_: 2, S1_: sp.Rational(1, 5), D2_: sp.Rational(3, 10), MU_: -sp.Rational(4, 25)}
    s = sp.Symbol("s")
    roots = sp.Poly([1, *(a.subs(point) for a in coefficients())], s).nroots()
    return linearised()[0].det().subs(point) - determinant, sum(1 for root in roots if sp.re(root) >= 0) - unstable


FIGURES = {"r": 0.5, "zeta": 2, "s1": 0.2, "s2": 0.3}


@PART.verified(
    "(27) numbers",
    "bounds on mu for the values of figure 14: definite and exact, d2 = s2 and d2 = s2/zeta",
    *(
        sp.Float(getattr(drive.slope_limits(**FIGURES, damping=damping), kind))
        for damping in ("omega1", "omega2")
        for kind in ("definite", "exact")
    ),
    numbers="12 digits",
)
def _(*claim):
    left = []
    for second, (definite, exact) in zip((".3", ".15"), (claim[:2], claim[2:]), strict=True):
        point = {R_: sp.Rational(1, 2), ZETA_: 2, S1_: sp.Rational(1, 5), D2_: sp.Rational(second)}
        a1, a2, a3, a4 = (a.subs(point) for a in coefficients())
        zeros = [sp.Poly(e, MU_).nroots(n=30) for e in (a1, a3, a1 * a2 * a3 - a3**2 - a1**2 * a4)]
        limit = max(z for found in zeros for z in found if z.is_real and z < 0)
        left += [agree(-negative_limit(linearised()[0].det().subs(point)), definite), agree(limit, exact)]
    return left
