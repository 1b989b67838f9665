"""One slide that a drive draws over a way: (1)-(4), and when it keeps sticking, figures 4 and 5."""

import sympy as sp

from derivations.guida.friction import (
    BY_V,
    SLOPES,
    eps,
    f,
    f1c,
    f1cb,
    f1s,
    f1sb,
    m,
    mu1,
    mu2,
    newton,
    omega,
    p_star,
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
from derivations.guida.orbits import threshold
from derivations.ledger import Ledger
from derivations.residuals import agree, trend
from symfric.theory import drive

PART = Ledger("guida", "II, II.A")


# In the scaling by v, x = (X - v t) omega/v, the corner X' = v* is at x' = p*. In the scaling by v*, which the stop
# phase uses, x = (X - v t) omega/v*, rest is at x' = p1 and the corner at p2.
@PART.corrected(
    "(1)",
    "places p1, p2, p* of rest and of the corner",
    right=(-v / v_star, (v_star - v) / v_star, (v_star - v) / v),
    printed=(-v_star / v, (v_star - v) / v_star, -(v_star**2) / (v * (v_star - v))),
    note="p1 = -v*/v and p* = p1/p2 are printed; (8) needs p2 = 1 + p1, and figure 3 the corner at p* = -p2/p1",
)
def _(*claim):
    def at(speed, unit):
        return sp.solve(sp.diff(place(unit), t).subs(t, 0) - speed, xd)[0]

    return [
        at(speed, unit) - c
        for (speed, unit), c in zip(((0, v_star), (v_star, v_star), (v_star, v)), claim, strict=True)
    ]


@PART.verified("(1) argument", "sliding speed X'/v = 1 + x'", 1 + xd)
def _(claim):
    return sp.expand(sp.diff(place(v), t).subs(t, 0) / v - claim)


@PART.verified("(1) sigma_c", "critical damping", 2 * m * omega)  # 2 sqrt(k m)
def _(claim):
    c, s = sp.symbols("c s", positive=True)
    discriminant = sp.discriminant(m * s**2 + c * s + m * omega**2, s)
    (critical,) = sp.solve(discriminant, c)
    return critical - claim


# (2): friction and damper on the support as one force F = F_a(X') + c (X' - v), branch by branch.
@PART.verified(
    "(2)",
    "force in forward sliding, and at rest",
    f1c + 2 * mu1 * (1 + xd),
    f1c + 2 * mu2 * (1 + xd) + 2 * (mu1 - mu2) * (1 + p_star),
    f1s,
    f1sb,
)
def _(*claim):
    branches = ("first", "second", "rest", "rest backward")
    return [sp.expand(scaled(b, v) - c.subs(BY_V)) for b, c in zip(branches, claim, strict=True)]


@PART.verified("(2) line 5", "force in slow backward sliding", f1cb + 2 * mu1 * (1 + xd))
def _(claim):
    return sp.expand(scaled("first backward", v) - claim.subs(BY_V))


@PART.corrected(
    "(2) last line",
    "force in fast backward sliding",
    right=f1cb + 2 * mu2 * (1 + xd) - 2 * (mu1 - mu2) * (1 + p_star),
    printed=f1cb + 2 * mu2 * (1 + xd) + 2 * (mu1 - mu2) * (1 + p_star),
    note="the odd characteristic has the opposite constant; with + it jumps at x' = -(2 + p*) by 4 (mu1 - mu2)(1 + p*)",
)
def _(claim):
    return sp.expand(scaled("second backward", v) - claim.subs(BY_V))


@PART.verified("(2) ranges", "corners at p* and -(2 + p*)", p_star, -(2 + p_star))
def _(forward, backward):
    rate = sp.diff(place(v), t).subs(t, 0)
    return [sp.solve(rate - s, xd)[0] - c.subs(BY_V) for s, c in ((v_star, forward), (-v_star, backward))]


@PART.verified("(3)", "forces at rest with the damper's share", *(BY_V[s] for s in (f1s, f1c, f1sb, f1cb)))
def _(*claim):
    at_rest = {xd: -1}
    branches = ("rest", "first", "rest backward", "first backward")
    return [sp.expand(scaled(b, v).subs(at_rest) - c) for b, c in zip(branches, claim, strict=True)]


@PART.verified(
    "(3) slopes", "2 mu1, 2 mu2, and mu3 = mu1, mu4 = mu2", tan1 + 2 * sigma, tan2 + 2 * sigma, 2 * mu1, 2 * mu2
)
def _(*claim):
    branches = ("first", "second", "first backward", "second backward")
    return [sp.expand(sp.diff(scaled(b, v), xd) - c.subs(SLOPES)) for b, c in zip(branches, claim, strict=True)]


@PART.corrected(
    "(3) epsilon",
    "jump of the friction at rest in the scaling of (2)",
    right=eps * (1 + p_star),
    printed=eps,
    note="(F_as - F_ac)/(m omega v*) is the jump over v*; the f of (2) are over v, so f1s - f1c = eps (1 + p*)",
)
def _(claim):
    jump = scaled("rest", v) - scaled("first", v).subs(xd, -1)  # f_as - f_ac, over v
    dimensional = sp.expand(jump * m * omega * v)
    return jump - claim.subs(eps, dimensional / (m * omega * v_star)).subs(BY_V)


@PART.verified("(4)", "motion in the scaling by v", xdd + f + x)
def _(claim):
    return newton(v, m * omega * v * f) - claim


# With p = x' as a function of x, x'' = p dp/dx.
P, slope = sp.symbols("p slope", real=True)


@PART.verified(
    "after (4)", "first-order equation of the phase plane", P * slope + f + x, note="the text derives it from (3): (4)"
)
def _(claim):
    path = sp.Function("P")
    X_ = sp.Function("x")(t)
    chain = sp.diff(path(X_), t).subs(sp.Derivative(X_, t), path(X_))  # x'' along x' = P(x)
    chain = chain.doit().replace(sp.Subs, lambda *_: slope).subs(sp.Derivative(path(X_), X_), slope)
    return sp.expand(chain.subs(path(X_), P) + f + x - claim)


# --- II.A Stick-slip: the threshold, figures 4 and 5 -----------------------------------------------------------
# Differentiate (4): with w = x', w'' + 2 mu(w) w' + w = 0, where mu(w) is mu1 below the corner p* and mu2 above; f1c is
# gone. w' = -f1 - x does not jump at the corner, because f1 does not. While the slide sticks w = -1 and x falls until
# -x = f1s; then the force drops to f1c.
@PART.verified("(4) with (2)", "the slide leaves rest with w' = eps1", f1s - f1c)
def _(claim):
    acceleration = -(f1c + 2 * mu1 * (1 + xd)) - x
    return sp.expand(acceleration.subs({x: -f1s, xd: -1}) - claim)


@PART.verified("(4) differentiated", "w = x' on both sections", xdd + 2 * mu1 * xd + x, xdd + 2 * mu2 * xd + x)
def _(*claim):
    w = sp.Function("w")(t)
    left = []
    for branch, c in zip(("first", "second"), claim, strict=True):
        force = scaled(branch, v).subs(xd, w)
        motion = sp.diff(w, t, 2) + sp.diff(force, t) + w  # x' = w
        names = {sp.diff(w, t, 2): xdd, sp.diff(w, t): xd, w: x}
        left.append(sp.expand(motion.subs(names) - c.subs(SLOPES)))
    return left


# Orbits do not cross. The orbit that touches w = -1 from above, (w, w') = (-1, 0), therefore separates those that come
# back to rest from those that do not; where it comes from, (-1, eps1_crit), is the threshold. On each section (17) and
# (18), proved below, give the orbit without time: w = C psi(w'/w). Backwards from (-1, 0), with |w| = |p*| at both
# crossings of the corner and w < 0 there:
#   ln psi1(u1) = ln psi1(0) + ln|p*|              u1 = w'/w > 0, coming down through the corner
#   ln psi2(u2) = ln psi2(u1) - 2 pi mu2/omega2    u2 < 0, going up; w passes 0 twice in between, see (18)
#   ln psi1(-eps1) = ln psi1(u2) - ln|p*|          the start; no solution: it comes from a turn above w = -1.
# ln psi rises up to u = 0 and falls beyond, so each root is alone on its side.
MAP = (("-.1", ".5", "-.1"), ("-.3", ".3", "-.2"), ("-.6", ".2", "-.5"), ("-.9", ".5", "-.4"), ("-.3", ".95", "-.8"))


@PART.verified(
    "Figs 4, 5",
    "points of the stability maps: eps_crit of symfric.theory.drive",
    *(sp.Float(drive.threshold(*map(float, point))) for point in MAP),
    numbers="12 digits",
)
def _(*claim):
    return [agree(threshold(*point), c) for point, c in zip(MAP, claim, strict=True)]


@PART.verified(
    "Figs 4, 5, below the surface",
    "stick-slip below the curves and to the right: eps_crit grows with mu2, falls with -mu1",
    sp.Integer(1),
    sp.Integer(1),
    note="Above the corner dw'/dw = -2 mu2 - w/w', so that a larger mu2 shifts the orbit back from (-1, 0) outwards",
    numbers="four values each way, 30 digits",
)
def _(by_mu2, by_mu1):
    grid = [threshold("-.3", b, "-.4") for b in (".3", ".5", ".7", ".9")]
    other = [threshold(a, ".5", "-.4") for a in ("-.5", "-.4", "-.3", "-.2")]
    return trend(grid) - by_mu2, trend(other) - by_mu1


# With p* < 0 the equilibrium w = 0 lies on the second section. Backwards from grazing the orbit passes the corner, and
# then w = 0, upwards; beyond it u = w'/w falls from infinity by u' = -(u^2 - 2 mu2 u + 1) (time reversed). It turns
# down only if u reaches 0, that is if the quadratic has no real root, mu2 < 1.
def least_without_threshold():
    """Return the mu2 from which the quadratic has a real root."""
    u, b = sp.symbols("u b", positive=True)
    (least,) = sp.solve(sp.discriminant(u**2 - 2 * b * u + 1, u), b)
    return least


@PART.verified(
    "Section IV, slope mu2",
    "least mu2 of the second section without stick-slip for any eps, p* < 0: stable from 1 on",
    sp.Integer(1),
    note="the statement is true if the slope of the second section is mu2, the ordinate of figure 5",
)
def _(claim):
    return least_without_threshold() - claim


@PART.corrected(
    "Section IV, slope",
    "least tangent of the second section, 2 mu2 with damper, without stick-slip for any eps",
    right=sp.Integer(2),
    printed=sp.Integer(1),
    note="false if the slope is the one drawn in figure 3, tan(beta2) = 2 mu2: with 2 mu2 = 1.1, mu1 = -.3, p* = -.2 "
    "stick-slip exists above eps = 8.39; p* < 0 is needed in both readings",
)
def _(claim):
    return 2 * least_without_threshold() - claim
