"""Tuned mass damper on an undamped main mass: response, fixed points, and four optima, from Newton's law.

Letters: mu = m2/m1, f = omega2/omega1, zeta = c2/(2 m2 omega2), g = Omega/omega1; time in units of 1/omega1.
"""

from functools import cache

import sympy as sp

from derivations.ledger import Ledger
from derivations.residuals import agree, less
from symfric.theory import absorber

LEDGER = Ledger(
    "absorber",
    "Tuned mass dampers: J. P. Den Hartog, *Mechanical Vibrations*, section 3.3; G. B. Warburton, Earthquake Eng. "
    "Struct. Dyn. 10 (1982) 381-401; O. Nishihara and T. Asami, J. Vib. Acoust. 124 (2002) 576-582; T. Asami et al., "
    "ibid. 284-295. These are not among the five documents; formulas as `symfric.theory.absorber` has them.",
)

mu, f, zeta, g = absorber.SYMBOLS
s, sigma = sp.symbols("s sigma")
w = sp.Symbol("w", positive=True)
BY_ROOT = {mu: (w**2 - 4) / 3}  # w = sqrt(4 + 3 mu) makes the exact optimum rational
SYMBOLIC = {
    "fixed": absorber.fixed_points(symbolic=True),
    "peak": absorber.least_peak(symbolic=True),
    "variance": absorber.least_variance(symbolic=True),
    "decay": absorber.fastest_decay(symbolic=True),
    "stable": absorber.widest_stability(symbolic=True),
}


def stiffness(z1=0):
    """Return ``M s^2 + C s + K`` of both masses, z1 the damping ratio of the main mass."""
    link = 2 * zeta * f * s + f**2
    return sp.Matrix([[s**2 + 2 * z1 * s + 1 + mu * link, -mu * link], [-link, s**2 + link]])


def characteristic(z1=0):
    """Return the coefficients c3, c2, c1, c0 of the characteristic polynomial."""
    return sp.Poly(stiffness(z1).det(), s).all_coeffs()[1:]


def squares():
    """Return numerator and denominator of the squared response as polynomials in W = g^2."""
    W = sp.Symbol("W", positive=True)
    transfer = (stiffness().inv() * sp.Matrix([1, 0]))[0]
    above, below = sp.fraction(sp.together(transfer.subs(s, sp.I * g)))
    size = [sp.expand(sp.re(e) ** 2 + sp.im(e) ** 2) for e in map(sp.expand, (above, below))]
    return W, [e.subs(g, sp.sqrt(W)) for e in size]


W, (ABOVE, BELOW) = squares()


# --- the response -------------------------------------------------------------------------------------------------
@LEDGER.verified("response", "amplitude of the main mass under a harmonic force", absorber.response(symbolic=True) ** 2)
def _(claim):
    return ABOVE / BELOW - claim.subs(g, sp.sqrt(W))


@LEDGER.verified(
    "peaks",
    "the highest peak for mu = 1/10, f = 9/10, zeta = 1/10",
    sp.Float(absorber.peaks(0.1, 0.9, 0.1)[0][1], 17),
    numbers="12 digits at one point",
)
def _(claim):
    at = {mu: sp.Rational(1, 10), f: sp.Rational(9, 10), zeta: sp.Rational(1, 10)}
    above, below = ABOVE.subs(at), BELOW.subs(at)
    roots = sp.Poly(sp.diff(above, W) * below - above * sp.diff(below, W), W).nroots(n=30)
    return agree(max(sp.sqrt((above / below).subs(W, r)) for r in roots if r.is_real and r > 0), claim)


# --- Den Hartog's fixed points ------------------------------------------------------------------------------------
@LEDGER.verified(
    "Den Hartog, tuning",
    "squared tuning that makes the two points which all dampings share equally high, and their squared height",
    *(SYMBOLIC["fixed"].tuning ** 2, SYMBOLIC["fixed"].value ** 2),
)
def _(square, height):
    # with ABOVE = A + zeta^2 B, BELOW = C + zeta^2 D no damping counts where A D = B C; there ABOVE/BELOW = B/D
    (A, C), (B, D) = _parts()
    shared = _shared(square)
    assert sp.rem(sp.Poly(A * D - B * C, W), _shared(f**2)).is_zero
    levels = sp.Poly(sp.cancel((height * D - B).subs(f, sp.sqrt(square)) / W), W)  # zero at both
    return sp.rem(levels, shared).all_coeffs()


@LEDGER.verified(
    "Den Hartog, damping",
    "mean of the two squared dampings that make one of the shared points a peak",
    SYMBOLIC["fixed"].damping ** 2,
)
def _(claim):
    k, mean = _mean_of_two_dampings()
    return sp.cancel(mean - claim.subs(mu, 2 * k**2 / (1 - k**2)))


@cache
def _mean_of_two_dampings():
    """Return k = sqrt(mu/(2 + mu)), which makes the shared points rational, and the mean as a function of it."""
    k, z2 = sp.symbols("k z2", positive=True)
    ratio = 2 * k**2 / (1 - k**2)
    (_, _), (B, D) = _parts()
    found = []
    for side in (k, -k):
        at = {f: 1 / (1 + ratio), mu: ratio, W: (1 + side) / (1 + ratio)}
        flat = sp.Poly((sp.diff(ABOVE, W) - (B / D) * sp.diff(BELOW, W)).subs(zeta, sp.sqrt(z2)), z2)  # linear
        assert sp.cancel(_shared(at[f] ** 2).as_expr().subs(at)) == 0
        rise, level = (sp.cancel(c.subs(at)) for c in flat.all_coeffs())
        found.append(-level / rise)
    return k, sp.cancel(sum(found) / 2)


def _parts():
    """Return the parts of numerator and denominator without zeta, and their factors of zeta^2."""
    return ([sp.Poly(e, zeta).coeff_monomial(zeta**k) for e in (ABOVE, BELOW)] for k in (0, 2))


def _shared(square: sp.Expr) -> sp.Poly:
    """Return the polynomial in W = g^2 whose roots are the two points that all dampings share."""
    free = (square - W), (1 - W) * (square - W) - mu * square * W  # roots of A and C
    damped = 1, 1 - (1 + mu) * W  # of B and D over 4 f^2 W
    return sp.Poly(sp.expand(free[0] * damped[1] + free[1] * damped[0]), W)


# --- the least largest amplitude ----------------------------------------------------------------------------------
@LEDGER.verified(
    "Nishihara and Asami",
    "equal peaks of a height that is stationary: squared tuning, squared damping, squared height",
    *(e**2 for e in SYMBOLIC["peak"]),
    note="h^2 BELOW - ABOVE is a square in W = g^2, and at its roots the slopes with f and zeta are parallel",
)
def _(f2, z2, h2):
    F, Z, H = sp.symbols("F Z H", positive=True)
    field = sp.QQ.frac_field(w)
    at = {x: field.from_sympy(e.subs(BY_ROOT)) for x, e in zip((mu, F, Z, H), (mu, f2, z2, h2), strict=True)}
    gap = sp.expand((H * BELOW - ABOVE).subs({f: sp.sqrt(F), zeta: sp.sqrt(Z)}))
    c4, c3, c2, c1, c0 = _over(field, gap, at).all_coeffs()
    a = sp.cancel(c3 / (2 * c4))
    b = sp.cancel((c2 / c4 - a**2) / 2)
    yield sp.cancel(c1 / c4 - 2 * a * b)
    yield sp.cancel(c0 / c4 - b**2)
    square = sp.Poly([1, a, b], W, domain=field)
    (p1, p0), (q1, q0) = (sp.rem(_over(field, sp.diff(gap, x), at), square).all_coeffs() for x in (F, Z))
    yield sp.cancel(p1 * q0 - p0 * q1)


def _over(field, expr: sp.Expr, at: dict) -> sp.Poly:
    """Return a polynomial in W whose coefficients are elements of a field, some symbols being elements of it."""
    rows = {}
    for (power, *powers), c in sp.Poly(expr, W, *at).terms():
        product = field.from_sympy(c)
        for element, n in zip(at.values(), powers, strict=True):
            product *= element**n
        rows[(power,)] = rows.get((power,), field.zero) + product
    return sp.Poly.from_dict(rows, W, domain=field)


# --- the least mean square under white noise ----------------------------------------------------------------------
@cache
def _mean_square():
    """Return ``(1/2 pi) int |x1/F|^2 d omega`` of a force of unit intensity, from Lyapunov's equation."""
    (a, b), (c, d) = sp.Matrix([[-mu, mu], [1, -1]]).tolist()
    link = sp.Matrix([[a, b], [c, d]])
    matrix = sp.zeros(4, 4)
    matrix[:2, 2:] = sp.eye(2)
    matrix[2:, :2], matrix[2:, 2:] = f**2 * link - sp.diag(1, 0), 2 * zeta * f * link
    names = {(i, j): sp.Symbol(f"p{i}{j}") for i in range(4) for j in range(i, 4)}
    P = sp.Matrix(4, 4, lambda i, j: names[min(i, j), max(i, j)])
    balance = matrix * P + P * matrix.T
    balance[2, 2] += 1
    found = sp.solve([balance[i, j] for i in range(4) for j in range(i, 4)], list(names.values()), dict=True)
    return sp.factor(found[0][names[0, 0]])


@LEDGER.verified(
    "Warburton", "least mean square under white noise: tuning, damping, and that mean square", *SYMBOLIC["variance"]
)
def _(tuning, damping, least):
    mean = _mean_square()
    at = {f: tuning, zeta: damping}
    return [*(sp.diff(mean, x).subs(at) for x in (f, zeta)), mean.subs(at) - least]


@LEDGER.verified(
    "variance",
    "the mean square for mu = 1/10, f = 9/10, zeta = 1/10",
    sp.Float(absorber.variance(0.1, 0.9, 0.1), 17),
    numbers="12 digits at one point",
)
def _(claim):
    at = {mu: sp.Rational(1, 10), f: sp.Rational(9, 10), zeta: sp.Rational(1, 10)}
    return agree(_mean_square().subs(at), claim)


# --- the fastest decay --------------------------------------------------------------------------------------------
@LEDGER.verified(
    "fastest decay, mu <= 4",
    "both pairs of eigenvalues coincide at the rate: tuning, damping, rate",
    *(e.args[0][0] for e in SYMBOLIC["decay"]),
)
def _(tuning, damping, rate):
    pair = sp.Poly((s**2 + 2 * rate * s + tuning) ** 2, s).all_coeffs()[1:]
    return less((c.subs({f: tuning, zeta: damping}) for c in characteristic()), pair)


@LEDGER.verified(
    "fastest decay, both pairs as far left",
    "squared rate up to which all four eigenvalues can lie on one vertical line",
    (SYMBOLIC["decay"].value.args[0][0]) ** 2,
    note="eigenvalues -sigma +- i p, -sigma +- i q need (p^2 + q^2)^2 >= 4 p^2 q^2",
)
def _(claim):
    A, B, q = sp.symbols("A B q")
    shifted = sp.Poly(((s + sigma) ** 4 + A * (s + sigma) ** 2 + B).expand(), s).all_coeffs()[1:]
    c3, c2, c1, c0 = shifted
    found = sp.solve([sp.cancel((c3 - (1 + mu) * c1) / sigma), c2 - 1 - (1 + mu) * c0], [A, B], dict=True)[0]
    gap = sp.Poly(sp.simplify((found[A] ** 2 - 4 * found[B]).subs(sigma, sp.sqrt(q))), q)
    assert gap.degree() == 1  # falls with q = sigma^2
    return gap.as_expr().subs(q, claim)


@LEDGER.verified(
    "fastest decay, mu > 4",
    "three eigenvalues coincide at minus the rate: tuning, damping, rate",
    *(e.args[1][0] for e in SYMBOLIC["decay"]),
    numbers="25 digits at 3 points",
)
def _(tuning, damping, rate):
    for ratio in (sp.Integer(5), sp.Rational(21, 2), sp.Integer(300)):
        at = {f: tuning.subs(mu, ratio), zeta: damping.subs(mu, ratio), mu: ratio}
        polynomial = s**4 + sum(c.subs(at) * s ** (3 - k) for k, c in enumerate(characteristic()))
        for k in range(3):
            yield agree(sp.Integer(1), 1 + sp.diff(polynomial, s, k).subs(s, -rate.subs(mu, ratio)), 25)


@LEDGER.verified(
    "decay rate",
    "for mu = 1/10, f = 9/10, zeta = 1/10 and the main damping 1/50",
    sp.Float(absorber.decay_rate(0.1, 0.9, 0.1, 0.02), 17),
    numbers="12 digits at one point",
)
def _(claim):
    at = {mu: sp.Rational(1, 10), f: sp.Rational(9, 10), zeta: sp.Rational(1, 10)}
    roots = sp.Poly(stiffness(sp.Rational(1, 50)).det().subs(at), s).nroots(n=30)
    matrix = absorber.state_matrix(0.1, 0.9, 0.1, 0.02)
    trace = -characteristic(sp.Rational(1, 50))[0].subs(at)
    return agree(-max(sp.re(r) for r in roots), claim), agree(sp.Float(float(matrix.trace()), 17), trace)


# --- a main mass that excites itself ------------------------------------------------------------------------------
@LEDGER.verified(
    "self-excited main mass",
    "both pairs of eigenvalues meet on the imaginary axis: tuning, damping, negative damping of the main mass",
    *SYMBOLIC["stable"],
)
def _(tuning, damping, bound):
    c3, c2, c1, c0 = (c.subs({f: tuning, zeta: damping}) for c in characteristic(-bound))
    return c3, c1, c2 - 2 * tuning, c0 - tuning**2


@LEDGER.verified(
    "self-excited main mass, below the bound",
    "with c1 = (c2/2) c3 and c3 small the Hurwitz condition asks for c2 > 2 f: largest squared negative damping at f",
    SYMBOLIC["stable"].value ** 2,
    note="c3 c2 c1 - c1^2 - c3^2 c0 = c3^2 (r c2 - r^2 - c0), r = c1/c3, is positive for some r only if c2^2 > 4 c0",
)
def _(claim):
    n, p, r = sp.symbols("n p r", positive=True)  # n = 2 beta, p = 2 zeta f
    c3, c2, c1, c0 = (c.subs(zeta, p / (2 * f)) for c in characteristic(-n / 2))
    hurwitz = c3 * c2 * c1 - c1**2 - c3**2 * c0
    scaled = sp.expand(hurwitz - c3**2 * (r * c2 - r**2 - c0)).subs(r, c1 / c3)
    on_axis = sp.solve([c3, c1], [p, f], dict=True)[0]
    at = sp.solve((c2 - 2 * f).subs(on_axis), n**2)[0]
    assert sp.simplify(scaled) == 0
    return at / 4 - claim
