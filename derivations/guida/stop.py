"""The drive stops: whether the slide moves on, (5)-(16)."""

import sympy as sp

from derivations.guida.friction import (
    BY_V_STAR,
    SLOPES,
    V_,
    V,
    X,
    Xdd,
    eps,
    f,
    fac,
    fas,
    fc,
    fcb,
    friction,
    fs,
    fsb,
    m,
    mu1,
    mu2,
    newton,
    omega,
    p1,
    p2,
    place,
    scaled,
    sigma,
    t,
    tan1,
    tan2,
    v,
    v_star,
    x,
    xd,
    xdd,
)
from derivations.ledger import Ledger
from derivations.residuals import agree
from symfric.theory import drive

PART = Ledger("guida", "II.B")


# --- II.B The stop phase: equations ----------------------------------------------------------------------------
@PART.verified("(5)", "motion of the slide", m * Xdd + f + m * omega**2 * (X - v * t))
def _(claim):
    # Lagrange's equation for the energies of mass and spring, with F as the generalised resistance
    place = sp.Function("X")(t)
    L = m * sp.diff(place, t) ** 2 / 2 - m * omega**2 * (place - v * t) ** 2 / 2
    motion = sp.diff(sp.diff(L, sp.diff(place, t)), t) - sp.diff(L, place) + f
    return sp.expand(motion.subs(sp.diff(place, t, 2), Xdd).subs(place, X) - claim)


# (5) turns into (7), without v tau, only if x is measured from the moving support.
@PART.corrected(
    "(6)",
    "scaled position",
    right=(X - v * t) * omega / v_star,
    printed=X * omega / v_star,
    note="with X omega/v* the spring force of (7) would be x - V tau",
)
def _(claim):
    place, tau = sp.Function("X"), sp.Symbol("tau", positive=True)
    motion = m * sp.diff(place(t), t, 2) + m * omega * v_star * f + m * omega**2 * (place(t) - v * t)
    small = sp.Function("x")
    (back,) = sp.solve(claim - small(tau), X)
    motion = motion.subs(place(t), back.subs(tau, omega * t)).doit().subs(t, tau / omega).doit()
    target = sp.diff(small(tau), tau, 2) + f + small(tau)
    return motion / (m * omega * v_star) - target


@PART.verified("(7)", "motion in the scaling by v*, sliding speed x' - p1", xdd + f + x, xd - p1)
def _(motion, argument):
    speed = sp.diff(place(v_star), t).subs(t, 0) / v_star
    return newton(v_star, m * omega * v_star * f) - motion, sp.expand(speed - argument.subs(BY_V_STAR))


@PART.verified(
    "(8)",
    "force in forward sliding, at rest and in slow backward sliding",
    fc + 2 * mu1 * (xd - p1),
    fc + 2 * (mu1 - mu2) + 2 * mu2 * (xd - p1),
    fs,
    fsb,
    fcb + 2 * mu1 * (xd - p1),
)
def _(*claim):
    branches = ("first", "second", "rest", "rest backward", "first backward")
    return [sp.expand(scaled(b, v_star) - c.subs(BY_V_STAR)) for b, c in zip(branches, claim, strict=True)]


@PART.corrected(
    "(8) range of line 5",
    "slow backward sliding, from x' = p2 - 2 to",
    right=(p2 - 2, p1),
    printed=(p2 - 2, -p1),
    note="x' < -p1 is printed; -p1 = V > 0 lies in forward sliding, rest is at p1",
)
def _(*claim):
    return [(s - v) / v_star - c.subs(BY_V_STAR) for s, c in zip((-v_star, 0), claim, strict=True)]


@PART.corrected(
    "(8) last line",
    "force in fast backward sliding",
    right=fcb - 2 * (mu1 - mu2) + 2 * mu2 * (xd - p1),
    printed=fcb + 2 * (mu1 - mu2) + 2 * mu2 * (xd - p1),
    note="as in (2): the characteristic is odd; with + it jumps at x' = p2 - 2",
)
def _(claim):
    return sp.expand(scaled("second backward", v_star) - claim.subs(BY_V_STAR))


@PART.verified(
    "(9)",
    "forces at rest while the drive runs",
    fac + 2 * p1 * sigma,
    fas + 2 * p1 * sigma,
    -fac + 2 * p1 * sigma,
    -fas + 2 * p1 * sigma,
    note="the damper sits on the support here; after the stop p1 = 0 and fs = fas, fc = fac",
)
def _(*claim):
    branches = ("first", "rest", "first backward", "rest backward")
    at_rest = {xd: -V_}
    return [
        sp.expand(scaled(b, v_star).subs(at_rest) - c.subs(BY_V_STAR)) for b, c in zip(branches, claim, strict=True)
    ]


# Steady sliding at V > 1, point E, x = -f(0): small motions obey x'' + 2 mu2 x' + x = 0.
@PART.verified(
    "before (10)", "steady sliding is asymptotically stable: sum and product of the two exponents", -2 * mu2, 1
)
def _(total, product):
    s = sp.Symbol("s")
    matrix = sp.Matrix([[xd, -x - scaled("second", v_star)]]).jacobian([x, xd])
    _, linear, constant = sp.Poly((s * sp.eye(2) - matrix).det(), s).all_coeffs()
    return sp.expand(-linear - total.subs(SLOPES)), constant - product


# --- II.B The stop phase: does the slide move? -----------------------------------------------------------------
PART.definition(
    "(10)", "the two outcomes: the slide stays or moves on", note="the second case overlaps the first; > 0 is meant"
)
PART.definition("(11)", "positioning error: what the slide moves after the drive's stop at t*")
start, end = sp.symbols("X_start X_end", real=True)


@PART.verified("(12)", "the error in the scaling of (6)", (end - start) * omega / v_star)
def _(claim):
    stop = sp.Symbol("t_stop", real=True)  # the support stays at v t_stop
    return sp.expand(sum(sign * (place - v * stop) * omega / v_star for sign, place in ((1, end), (-1, start))) - claim)


# In steady sliding the spring carries F(v), the damper on the support nothing. When the drive stops, and the slide with
# it, the spring keeps its force, and friction must carry it alone. It can if the force is below F_as.
SPRING = sp.expand(friction(v, v_star)["second"])


@PART.verified("(13)", "force that the friction must carry after the stop", SPRING, note="necessary as well")
def _(claim):
    steady = friction(v, v_star)["second"] + 2 * sigma * m * omega * (v - v) + m * omega**2 * (X - v * t)
    (place,) = sp.solve(steady, X)
    return sp.expand(m * omega**2 * (v * t - place) - claim)


MARGIN = fac + tan1 + tan2 * (V - 1) - fas  # of holding, below zero


@PART.corrected(
    "(14)",
    "force beyond the static friction at the stop, f(0) - fs",
    right=MARGIN,
    printed=MARGIN + 2 * sigma * V,
    note="fs of (9) holds the damper's share 2 p1 sigma of the running drive; at the stop p1 = 0, fs = fas. With the "
    "damper on the support, as in (3) and (9), sigma does not enter",
)
def _(claim):
    return (SPRING - friction(0, v_star)["rest"]) / (m * omega * v_star) - claim.subs(V, V_)


# lambda is the excess of the spring's force over the kinetic friction at rest; the slide moves if lambda > eps. With
# the damper between slide and way, the spring carries its force c v too in steady sliding.
def steady_excess(damper):
    """Return the spring's force in steady sliding less F_ac, over m omega v*."""
    carried = 2 * sigma * m * omega * v if damper == "ground" else 0
    return sp.expand((SPRING + carried) / (m * omega * v_star) - fac).subs(v, V * v_star)


@PART.verified(
    "(14) lambda",
    "lambda of steady sliding, damper on the support and to ground",
    2 * (mu1 - sigma) + 2 * (mu2 - sigma) * (V - 1),
    2 * mu1 + 2 * mu2 * (V - 1),
)
def _(*claim):
    return [
        sp.expand(steady_excess(damper) - c.subs(SLOPES))
        for damper, c in zip(("support", "ground"), claim, strict=True)
    ]


SPEEDS = ((-0.4, 0.7, 3.5, 0.1), (-0.4, 0.7, 0.6, 0.1))


@PART.verified(
    "(14) lambda, numbers",
    "symfric.theory.drive.excess on both sections",
    *(
        sp.Float(drive.excess(a, b, speed, damper=damper, sigma=s))
        for a, b, speed, s in SPEEDS
        for damper in ("support", "ground")
    ),
    numbers="12 digits",
)
def _(*claim):
    left = iter(claim)
    residuals = []
    for a, b, speed, s in SPEEDS:
        section = "second" if speed > 1 else "first"
        for damper in ("support", "ground"):
            carried = 2 * sigma * V if damper == "ground" else 0
            force = friction(V * v_star, v_star)[section] / (m * omega * v_star) - fac + carried
            numbers = {V: speed, sigma: s, tan1: 2 * a - 2 * s, tan2: 2 * b - 2 * s}
            residuals.append(agree(sp.simplify(force).subs(numbers), next(left)))
    return residuals


@PART.corrected(
    "Sections I, IV, damper",
    "growth of lambda with the damper, d lambda/d sigma",
    right=sp.Integer(0),
    printed=2 * V,
    note="that dampers cause positioning errors, and that choosing them removes errors, holds for a damper to ground "
    "(d lambda/d sigma = 2 V); in the model as written the damper is on the support",
)
def _(claim):
    return sp.diff(steady_excess("support"), sigma) - claim


@PART.verified(
    "Section IV, errors",
    "steep second section and small eps cause errors: derivatives of lambda - eps by mu2 and eps",
    2 * (V - 1),
    sp.Integer(-1),
)
def _(by_mu2, by_eps):
    margin = steady_excess("ground").subs(sp.solve([mu1 - SLOPES[mu1], mu2 - SLOPES[mu2]], [tan1, tan2])) - eps
    return sp.expand(sp.diff(margin, mu2) - by_mu2), sp.diff(margin, eps) - by_eps


# --- II.B The stop phase: how far? -----------------------------------------------------------------------------
@PART.verified("(15)", "motion with the drive at rest", xdd + f + x)
def _(claim):
    # the support stands at X_d: (5) with v = 0 from there, x = (X - X_d) omega/v*
    support = sp.Symbol("X_d", real=True)
    motion = m * Xdd + m * omega * v_star * f + m * omega**2 * (X - support)
    place = {Xdd: v_star * omega * xdd, X: v_star / omega * x + support}
    return sp.expand(motion.subs(place) / (m * omega * v_star)) - claim


# (8) with p1 = 0 and without drive: four sections, each a linear oscillator about its own origin. Numbered as in (16)
# from the fastest forward one, the first has the slope mu2.
def stopped(branch):
    """Return the force of (15) on a branch."""
    force = friction(v_star * xd, v_star)[branch] + 2 * sigma * m * omega * v_star * xd
    return sp.expand(force / (m * omega * v_star))


SECTIONS = ("second", "first", "first backward", "second backward")


@PART.verified(
    "(16)",
    "origins O1 ... O4 about which the sections are linear and homogeneous",
    -(fac + 2 * (mu1 - mu2)),
    -fac,
    fac,
    fac + 2 * (mu1 - mu2),
)
def _(*claim):
    return [sp.expand(-stopped(b).subs(xd, 0) - c.subs(SLOPES)) for b, c in zip(SECTIONS, claim, strict=True)]


@PART.corrected(
    "(16) slopes",
    "slopes of the four sections in the order of (16)",
    right=(2 * mu2, 2 * mu1, 2 * mu1, 2 * mu2),
    printed=(2 * mu1, 2 * mu2, 2 * mu1, 2 * mu2),
    note="(16) numbers the sections from the fastest, (2) and (3) from rest; psi(u_i, mu_i) with mu_1 on x' > 1 "
    "has the wrong slope",
)
def _(*claim):
    return [sp.expand(sp.diff(stopped(b), xd) - c.subs(SLOPES)) for b, c in zip(SECTIONS, claim, strict=True)]
