"""Vibration across and along the sliding direction, and what remains of it as damping.

Letters: v the sliding speed, q cos(theta) the fast velocity, S the size of the slip vector, ``A^2 = v^2 + q^2``.
"""

import mpmath as mp
import sympy as sp

from derivations.ledger import Ledger
from derivations.residuals import agree, less
from symfric.model import laws
from symfric.model.symbols import SPEED
from symfric.theory import plane

PART = Ledger("plane", "")

v, q, k, N, theta, delta, t, a, b, S, x, w = sp.symbols("v q k N theta delta t a b S x w", positive=True)
A = sp.sqrt(v**2 + q**2)
MU = sp.Function("mu")
PAIRS = ((0.2, 1.0), (1.0, 0.7), (3.0, 0.4))  # sliding speed and intensity


def mean(function, speed, intensity):
    """Return the mean over theta of a function of slip, fast velocity and speed, in 30 digits."""
    with mp.workdps(30):
        speed, intensity = mp.mpf(str(speed)), mp.mpf(str(intensity))

        def at(angle):
            fast = intensity * mp.cos(angle)
            return function(mp.hypot(speed, fast), fast, speed)

        return sp.Float(
            mp.quad(at, [mp.pi / 2 * (1 - mp.mpf(2) ** -n) for n in range(9)] + [mp.pi / 2]) * 2 / mp.pi, 30
        )


def numbers(expr, speed, intensity):
    """Return an expression of v and q in 30 digits."""
    return expr.subs({v: sp.Rational(str(speed)), q: sp.Rational(str(intensity))}).evalf(30)


def of_the_package(law):
    """Return the coefficient of a law under vibration across at every pair, as the package has it, as floats."""
    coefficient = sp.lambdify((SPEED, q), law.averaged_across(q).kinetic, "math", cse=True)
    return [sp.Float(coefficient(*pair), 15) for pair in PAIRS]


@PART.verified(
    "drag across",
    "mean friction against the sliding under vibration across it, over mu N",
    2 * v / (sp.pi * A) * sp.elliptic_k(q**2 / A**2),
    numbers="20 digits at three pairs; the number of the package to 13",
)
def _(claim):
    left = []
    for pair in PAIRS:
        found = mean(lambda slip, _, speed: speed / slip, *pair)
        left += [agree(found, numbers(claim, *pair), 20), agree(plane.lateral_vibration_drag(*pair), found, 13)]
    return left


@PART.verified(
    "arithmetic-geometric mean",
    "dt/sqrt((a^2 + t^2)(b^2 + t^2)), of which the drag is an integral, keeps its form: four times the square of its "
    "rate in x = (t - a b/t)/2",
    1 / (((a + b) / 2) ** 2 + x**2) / (a * b + x**2),
)
def _(claim):
    # t runs from 0 to infinity while u runs from -infinity to infinity, over which the integrand is even: twice 1/2
    u = (t - a * b / t) / 2
    rate = 1 / ((a**2 + t**2) * (b**2 + t**2)) / u.diff(t) ** 2
    return sp.simplify(rate - claim.subs(x, u) / 4)


@PART.verified(
    "drag across by the mean",
    "the same as the speed over the arithmetic-geometric mean of it and A; of the package's law",
    *of_the_package(laws.coulomb(1)),
    numbers="13 digits at three pairs",
)
def _(*claim):
    with mp.workdps(30):
        found = [mp.mpf(str(s)) / mp.agm(mp.mpf(str(s)), mp.hypot(mp.mpf(str(s)), mp.mpf(str(i)))) for s, i in PAIRS]
    return [agree(sp.Float(f, 30), c, 13) for f, c in zip(found, claim, strict=True)]


@PART.verified(
    "power across",
    "mean power that maintains vibration across, over mu N",
    2 / sp.pi * (A * sp.elliptic_e(q**2 / A**2) - v**2 / A * sp.elliptic_k(q**2 / A**2)),
    numbers="20 digits at three pairs; the number of the package to 13",
)
def _(claim):
    left = []
    for pair in PAIRS:
        found = mean(lambda slip, fast, _: fast**2 / slip, *pair)
        left += [agree(found, numbers(claim, *pair), 20), agree(plane.lateral_vibration_power(*pair), found, 13)]
    return left


@PART.verified(
    "dissipation",
    "friction takes mu N S, of which the sliding brings this and the vibration the rest, at every instant",
    MU(S) * N * v**2 / S,
)
def _(claim):
    slip = sp.sqrt(v**2 + w**2)
    vibration = MU(S) * N * w / S * w
    return sp.simplify((MU(S) * N * S - vibration - claim).subs(S, slip))


@PART.verified(
    "powers of the slip",
    "mean of S^(k + 4), from those of S^k and S^(k + 2), over theta; denoted by a and b",
    ((k + 3) * (A**2 + v**2) * b - (k + 2) * A**2 * v**2 * a) / (k + 4),
)
def _(claim):
    # sin cos S^(k + 2) is periodic, so that the mean of its derivative vanishes; with S^2 = x
    cosine2 = (x - v**2) / q**2
    derivative = sp.expand((2 * cosine2 - 1) * x - (k + 2) * q**2 * cosine2 * (1 - cosine2))  # over S^k
    (found,) = sp.solve(derivative.coeff(x, 2) * t + derivative.coeff(x, 1) * b + derivative.coeff(x, 0) * a, t)
    return sp.simplify(found - claim)


@PART.verified(
    "drag of the cubic law across",
    "mu_s/M + alpha1 + alpha3 (v^2 + q^2/2), times v, with the arithmetic-geometric mean M; at three pairs",
    *of_the_package(laws.cubic(0.4, 0.25, 0.5)),
    numbers="12 digits",
)
def _(*claim):
    def drag(slip, _, speed):
        return (mp.mpf("0.4") - mp.mpf("0.45") * slip + mp.mpf("0.6") * slip**3) * speed / slip

    found = [mean(drag, *pair) for pair in PAIRS]
    return [agree(f, c, 12) for f, c in zip(found, claim, strict=True)]


@PART.verified(
    "weak vibration across",
    "drag, and power, up to q^2; any law",
    MU(v) - (MU(v) - v * MU(v).diff(v)) * q**2 / (4 * v**2),
    MU(v) * q**2 / (2 * v),
)
def _(drag, power):
    slip = sp.sqrt(v**2 + x * sp.cos(theta) ** 2)  # x = q^2
    left = []
    for weight, claim in ((v / slip, drag), (x * sp.cos(theta) ** 2 / slip, power)):
        exact = MU(slip) * weight
        first = exact.diff(x).doit().subs(x, 0).doit()
        mean_of = sp.integrate(sp.expand(first).coeff(sp.cos(theta), 2) * sp.cos(theta) ** 2, (theta, 0, sp.pi)) / sp.pi
        left.append(sp.simplify(exact.subs(x, 0).doit() + mean_of * q**2 - claim))
    return left


@PART.verified(
    "vibration along",
    "drag and power over mu N for v < q; Coulomb friction, Thomsen (47)",
    2 / sp.pi * sp.asin(v / q),
    2 / sp.pi * sp.sqrt(q**2 - v**2),
)
def _(drag, power):
    split = sp.pi - sp.acos(v / q)  # where v + q cos(theta) changes its sign, cos(split) = -v/q
    reverse = {theta: split}
    force = (2 * split - sp.pi) / sp.pi
    work = 2 * q * sp.sin(theta) / sp.pi  # of cos from 0 to the split, less that from there to pi
    values = [plane.longitudinal_vibration_drag(0.3, 0.7), plane.longitudinal_vibration_power(0.3, 0.7)]
    known = [agree(sp.Float(f, 20), numbers(c, 0.3, 0.7), 13) for f, c in zip(values, (drag, power), strict=True)]
    return sp.simplify(force.rewrite(sp.asin) - drag.rewrite(sp.asin)), sp.simplify(work.subs(reverse) - power), *known


@PART.verified(
    "equal power",
    "what a little power takes off the drag, over the power: across, and along; speed 1",
    sp.Rational(1, 2),
    sp.Integer(1),
)
def _(across, along):
    drag, power = q**2 / 4, q**2 / 2  # of weak vibration
    fall, taken = 1 - 2 / sp.pi * sp.asin(1 / (1 + delta**2)), 2 / sp.pi * sp.sqrt((1 + delta**2) ** 2 - 1)
    found = plane.compare_vibration([0.03])
    ratio = (1 - found.same_power_drag[0]) / (1 - found.lateral_drag[0])
    return drag / power - across, sp.limit(fall / taken, delta, 0) - along, agree(sp.Float(ratio), along / across, 3)


@PART.verified(
    "strong vibration",
    "drag across over drag along, less ln(4 q/v), tends to this",
    sp.Integer(0),
    numbers="7 digits at q/v = 1e4",
)
def _(claim):
    ratio = mean(lambda slip, _, speed: speed / slip / (2 / mp.pi * mp.asin(speed)), "1e-4", 1)
    left = ratio - sp.log(40000).evalf(30) - claim
    return sp.Integer(0) if abs(left) < 1e-6 else left


@PART.verified(
    "equal drag",
    "intensity over speed from which vibration along leaves less, at equal intensity",
    sp.Float(plane.equal_drag_ratio(), 15),
    numbers="12 digits",
)
def _(claim):
    with mp.workdps(25):
        found = mp.findroot(
            lambda i: mp.agm(1, mp.hypot(1, i)) * 2 / mp.pi * mp.asin(1 / i) - 1, (1.01, 1.2), solver="anderson"
        )
    return agree(sp.Float(found, 25), claim, 12)


@PART.verified(
    "transverse damping",
    "slope of the friction by the velocity across, and by that along; power in steady sliding",
    MU(v) * N / v,
    N * MU(v).diff(v),
    N * MU(v) * v,
)
def _(across, along, power):
    slip = sp.sqrt(v**2 + w**2)
    force = [N * MU(slip) * component / slip for component in (v, w)]
    slopes = force[1].diff(w).doit().subs(w, 0).doit(), force[0].diff(v).doit().subs(w, 0).doit()
    law, pair = laws.cubic(0.4, 0.25, 0.5), (0.3, 2.0)
    value = law(pair[0])
    kept = agree(plane.transverse_damping(law, *pair), value * pair[1] / pair[0], 14)
    taken = agree(plane.steady_power(law, *pair), value * pair[1] * pair[0], 14)
    rest = sp.simplify((force[0] * v + force[1] * w).subs(w, 0).doit() - power)
    return *(sp.simplify(e) for e in less(slopes, (across, along))), rest, kept, taken


@PART.verified(
    "slope of the drag across",
    "of mu(S) v/S by v at one instant, w the fast velocity; and what weak vibration on slow sliding adds, over mu",
    MU(S).diff(S) * v**2 / S**2 + MU(S) * w**2 / S**3,
    q**2 / (2 * v**3),
)
def _(slope, little):
    slip = sp.sqrt(v**2 + w**2)
    found = (MU(slip) * v / slip).diff(v).doit()
    claim = slope.doit().subs(S, slip).doit()
    coulomb = (v / slip).diff(v)
    mean_of = coulomb.diff(w, 2).subs(w, 0) / 2 * q**2 / 2  # with the mean square q^2/2 of w
    law = laws.cubic(0.4, 0.25, 0.5)
    limit = plane.compare_quenching(law, 0.2)
    h = 1e-3
    drags = [plane.lateral_vibration_drag(0.2 + k * h, limit.across, law) for k in (-2, -1, 1, 2)]
    level = (drags[0] - 8 * drags[1] + 8 * drags[2] - drags[3]) / (12 * h)
    return _of_definite(found - claim), sp.simplify(mean_of - little), sp.Integer(0) if abs(level) < 1e-9 else level


def _of_definite(difference):
    """Return a difference with an exponential in the place of the law."""
    return sp.simplify(difference.subs(MU, sp.Lambda(x, sp.exp(x) + x**3)).doit())
