"""A ball that slides until it rolls, and a block on an incline: the closed forms follow from Newton's equations.

Letters: p and d the accelerations by gravity down the incline and by friction, theta the direction of the motion from
the line of steepest descent, k = d/p.
"""

import math

import sympy as sp

from derivations.ledger import Ledger
from derivations.residuals import agree
from symfric.theory import plane

PART = Ledger("plane", "")

v, p, d, k, r, g, mu, theta, delta, t, x, w = sp.symbols("v p d k r g mu theta delta t x w", positive=True)


@PART.verified(
    "ball",
    "rate of the slip of the contact; time until it rolls from the slip w; share of the slip that the velocity loses; "
    "inertia k = J/(m r^2)",
    -mu * g * (1 + 1 / k),
    w / (mu * g * (1 + 1 / k)),
    1 / (1 + 1 / k),
)
def _(rate, time, share):
    direction = sp.Matrix([sp.cos(theta), sp.sin(theta), 0])
    force = -mu * g * direction  # over the mass
    down = sp.Matrix([0, 0, -r])  # from the middle to the contact
    spin = down.cross(force) / (k * r**2)
    slip = force + spin.cross(down)
    known = plane.ball_rolls((3.0, 0.0), r=1.0, mu=0.5, g=4.0)
    at = {mu: sp.Rational(1, 2), g: 4, k: sp.Rational(2, 5), w: 3}
    end = [agree(known.time, time.subs(at), 14), agree(known.velocity[0], 3 - 3 * share.subs(at), 14)]
    return (
        *sp.simplify(slip - rate * direction),
        sp.simplify(w + rate * time),
        sp.simplify(time * mu * g / w - share),
        *end,
    )


@PART.verified(
    "incline",
    "rates of the speed and of the direction; theta from the line of steepest descent",
    p * sp.cos(theta) - d,
    -p * sp.sin(theta) / v,
)
def _(speed, turn):
    size, angle = sp.Function("v")(t), sp.Function("theta")(t)
    rates = sp.solve(
        [
            (size * sp.cos(angle)).diff(t) - p + d * sp.cos(angle),
            (size * sp.sin(angle)).diff(t) + d * sp.sin(angle),
        ],
        [size.diff(t), angle.diff(t)],
    )
    found = [rates[size.diff(t)], rates[angle.diff(t)]]
    return [sp.simplify(f.subs({size: v, angle: theta}) - c) for f, c in zip(found, (speed, turn), strict=True)]


def along_the_motion(expr):
    """Return the rate of a function of the state v, theta on the incline."""
    return expr.diff(v) * (p * sp.cos(theta) - d) - expr.diff(theta) * p * sp.sin(theta) / v


HALF_SINE, HALF_COSINE = sp.sin(theta / 2), sp.cos(theta / 2)


@PART.verified(
    "incline, stop",
    "time to the stop, way down and way across, from the state v, theta",
    v * (d + p * sp.cos(theta)) / (d**2 - p**2),
    v**2 * (HALF_COSINE**4 / (2 * (d - p)) - HALF_SINE**4 / (2 * (d + p))),
    2 * v**2 * HALF_SINE * HALF_COSINE * (HALF_COSINE**2 / (2 * d - p) + HALF_SINE**2 / (2 * d + p)),
)
def _(time, down, across):
    # they vanish with v, and fall as the state moves
    rates = [along_the_motion(e) for e in (time, down, across)]
    expected = [-1, -v * sp.cos(theta), -v * sp.sin(theta)]
    alpha, coefficient = 0.3, 0.5
    at = {p: g * sp.sin(alpha), d: coefficient * g * sp.cos(alpha)}
    rest = plane.incline_stop(alpha, coefficient, 1.2, 2.0)
    values = [e.subs(at).subs({g: 9.81, v: 1.2, theta: 2.0}) for e in (time, down, across)]
    known = [agree(f, c, 12) for f, c in zip((rest.time, rest.downslope, rest.cross), values, strict=True)]
    half = {sp.sin(x): x * w, sp.cos(x): w}  # x the tangent of the half angle from here on, and w its cosine
    left = (sp.expand_trig((r - e).subs(theta, 2 * x)).subs(half) for r, e in zip(rates, expected, strict=True))
    return *(sp.cancel(sp.expand(e).subs(w, 1 / sp.sqrt(1 + x**2))) for e in left), *known


@PART.verified(
    "incline, speed",
    "speed over the direction, relative to that at a right angle, k = d/p; least where the cosine is",
    sp.tan(theta / 2) ** k / sp.sin(theta),
    k,
)
def _(speed, least):
    over = sp.log(speed).diff(theta) - (k - sp.cos(theta)) / sp.sin(theta)  # dln(v)/dtheta = v'/(v theta')
    (where,) = sp.solve(sp.Eq((k - x) / sp.sqrt(1 - x**2), 0), x)
    later = plane.incline_motion(0.3, 0.5, 1.2, 2.0, 0.7).speed / 1.2
    ratio = (speed.subs(theta, 0.7) / speed.subs(theta, 2.0)).subs(k, 0.5 / math.tan(0.3))
    return sp.simplify(over), speed.subs(theta, sp.pi / 2) - 1, where - least, agree(later, ratio, 13)


@PART.verified(
    "fast turn",
    "least speed over the first one of a block that goes up at a small angle delta from the steepest line; k = d/p < 1",
    delta ** (1 + k) / sp.sqrt(1 - k**2) * (sp.sqrt((1 - k) / (1 + k)) / 2) ** k,
)
def _(claim):
    # v over the direction as above, with sin(pi - delta) = delta, tan((pi - delta)/2) = 2/delta; at cos(theta) = k
    tangent = sp.sqrt((1 - k) / (1 + k))
    found = tangent**k / sp.sqrt(1 - k**2) * delta / (2 / delta) ** k
    slope, small = 0.4, 1e-7
    known = plane.incline_least_speed(slope, 0.5 * math.tan(slope), 1.0, math.pi - small)
    half = claim.subs({k: sp.Rational(1, 2), delta: sp.Rational(1, 10**7)})
    return sp.simplify(sp.log(found / claim).expand(force=True)), agree(known, half, 7)


@PART.verified(
    "fast turn, scaled time",
    "way s of the motion in dt = v ds while the direction turns from pi - delta to delta: the logarithm of 1/delta",
    -2 / p * sp.log(sp.tan(delta / 2)),
)
def _(claim):
    primitive = -sp.log(sp.tan(theta / 2)) / p  # of ds/dtheta = 1/(v theta') = -1/(p sin(theta))
    slope = sp.simplify(primitive.diff(theta) + 1 / (p * sp.sin(theta)))
    way = primitive.subs(theta, delta) - primitive.subs(theta, sp.pi - delta)
    return slope, sp.simplify(
        sp.expand_log(p * (way - claim).subs(sp.cot(delta / 2), 1 / sp.tan(delta / 2)), force=True)
    )
