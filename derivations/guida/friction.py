"""The drawn slide and its friction in dimensions, and the two scalings of the source."""

import sympy as sp

from symfric.theory.drive.stop import MU1

# A slide of mass m at X on a way at rest is drawn through a spring k, with a damper c beside it, by a support with
# speed v. The friction F_a is odd in the sliding speed X'. It jumps from F_as at rest to F_ac, and has the slope
# m omega tan(alpha1) up to the speed v*, m omega tan(alpha2) beyond, without a jump there. k = m omega^2 and
# c = 2 sigma m omega; the spring is unstressed for X = v t.
m, omega, v, v_star, sigma = sp.symbols("m omega v v_star sigma", positive=True)
tan1, tan2, X, Xd, Xdd, t = sp.symbols("tan1 tan2 X Xd Xdd t", real=True)
eps = sp.Symbol("epsilon", positive=True)  # (F_as - F_ac)/(m omega v*)
fas, fac = sp.symbols("f_as f_ac", positive=True)
x, xd, xdd, f = sp.symbols("x xd xdd f", real=True)  # dimensionless position and its derivatives by tau = omega t
mu1, mu2 = MU1, sp.Symbol("mu2", real=True)
f1s, f1c, f1sb, f1cb, fs, fc, fsb, fcb = sp.symbols("f1s f1c f1sb f1cb fs fc fsb fcb", real=True)
p_star, p1, p2, V = sp.symbols("p_star p1 p2 V", real=True)
V_ = v / v_star  # the drive's speed in units of the corner's


def friction(Xd, unit):
    """Return the branches of F_a at sliding speed Xd; f_as and f_ac are the forces at rest over m omega unit."""
    scale = m * omega

    def first(s):
        return scale * (unit * fac + tan1 * s)

    def second(s):
        return scale * (unit * fac + tan1 * v_star + tan2 * (s - v_star))

    return {
        "rest": scale * unit * fas,
        "first": first(Xd),
        "second": second(Xd),
        "rest backward": -scale * unit * fas,
        "first backward": -first(-Xd),
        "second backward": -second(-Xd),
    }


def scaled(branch, unit):
    """Return friction and damping together over m omega unit, at sliding speed X' = v + unit x'."""
    speed = 0 if branch.startswith("rest") else v + unit * xd
    return (friction(speed, unit)[branch] + 2 * sigma * m * omega * (speed - v)) / (m * omega * unit)


# What (3) and (9) say of the constants, in the scaling by v and in that by v*; both are checked below.
SLOPES = {mu1: (tan1 + 2 * sigma) / 2, mu2: (tan2 + 2 * sigma) / 2}
BY_V = {
    f1s: fas - 2 * sigma,
    f1c: fac - 2 * sigma,
    f1sb: -fas - 2 * sigma,
    f1cb: -fac - 2 * sigma,
    p_star: v_star / v - 1,
    **SLOPES,
}
BY_V_STAR = {
    fs: fas - 2 * sigma * V_,
    fc: fac - 2 * sigma * V_,
    fsb: -fas - 2 * sigma * V_,
    fcb: -fac - 2 * sigma * V_,
    p1: -V_,
    p2: 1 - V_,
    **SLOPES,
}


# The motion near an instant, to the order that Newton's law sees: x(tau) = x + x' tau + x'' tau^2/2.
def place(unit):
    """Return X(t) for x = (X - v t) omega/unit."""
    s = omega * t
    return unit / omega * (x + xd * s + xdd * s**2 / 2) + v * t


def newton(unit, force):
    """Return m X'' + F + k (X - v t) over m omega unit at the instant t = 0."""
    motion = m * sp.diff(place(unit), t, 2) + force + m * omega**2 * (place(unit) - v * t)
    return sp.expand(motion.subs(t, 0) / (m * omega * unit))
