"""Models of interface damping, (19.104)-(19.108)."""

import sympy as sp

from derivations.ledger import Ledger
from derivations.residuals import agree
from symfric.model import laws
from symfric.model.symbols import SPEED
from symfric.theory import falling_speeds, transient, two_lines

PART = Ledger("handbook", "models of interface damping")

m, k, g, mu, R, omega = sp.symbols("m k g mu R omega_n", positive=True)
f_s, f_d, v_c, b, V = sp.symbols("f_s f_d v_c b V", positive=True)
alpha, x, v, y = sp.symbols("alpha x v y", real=True)
t = sp.Symbol("t", nonnegative=True)
A1, A2, B1, B2 = sp.symbols("A1 A2 B1 B2", real=True)
i = sp.Symbol("i", integer=True, positive=True)
x0 = transient.SYMBOLS.x0  # real; the example releases the mass at x0 > 0
Delta, Delta_s = transient.SYMBOLS.delta, transient.SYMBOLS.delta_s

# --- Models of interface damping ---------------------------------------------------------------------------------
# A dry contact opposes the sliding: the force on the sliding body is -f with f = mu R sgn v. What makes it damping is
# the power it takes, f v, which is never negative.

PART.definition("(19.104)", "Coulomb friction", laws.coulomb(mu).kinetic * R * sp.sign(v))


@PART.verified("(19.104) power", "Coulomb friction takes mu R |v| in both directions", mu * R * sp.Abs(v))
def _(claim):
    force = laws.coulomb(mu).kinetic * R * sp.sign(v)
    return [(force * v - claim).subs(v, side * V) for side in (1, -1)]


# At rest the friction has no value of its own. Under an applied force F with |F| <= f_s the body does not move, so its
# acceleration (F - f)/m must vanish. With f = f_s the body would accelerate against the force that holds it.
F = sp.Symbol("F", real=True)


@PART.corrected(
    "(19.105) at rest",
    "static friction balances the applied force F, as long as |F| <= f_s",
    right=F,
    printed=f_s,
    note="f = f_s at v = 0 is the largest value, not the value: with F = f_s/2 it would push the body backwards",
)
def _(claim):
    acceleration = sp.Symbol("a", real=True)
    (held,) = sp.solve(m * acceleration - (F - claim), acceleration)
    return held


PART.definition(
    "(19.105) sliding",
    "kinetic friction and viscous damping; f_sb(|v|) >= 0 is the magnitude",
    sp.Function("f_sb")(sp.Abs(v)) * sp.sign(v) + b * v,
    note="the laws of symfric carry b v in their kinetic part, and f_s as their static coefficient",
)
PART.definition("(19.106)", "Stribeck effect, Lorentz form", laws.lorentz(f_d, v_c).kinetic)
PART.definition(
    "(19.107)",
    "Stribeck effect, Gauss form",
    laws.gauss(f_d, v_c).kinetic,
    note="the exponent is -(v/v_c)^2; the transcript has lost its minus sign",
)

# (19.108) carries sgn v, and (19.105) multiplies by sgn v once more. Sliding backwards, friction would then point
# along the motion and feed it. The sign must enter once: power f v = (f_d + alpha |v|^(1/2)) |v| + b v^2.


@PART.corrected(
    "(19.108)",
    "square-root law in (19.105), whole force",
    right=(f_d + alpha * sp.sqrt(sp.Abs(v))) * sp.sign(v) + b * v,
    printed=(f_d + alpha * sp.sqrt(sp.Abs(v))) * sp.sign(v) ** 2 + b * v,
    note="(19.108) already has sgn v; put into (19.105) as printed the sign is squared and friction drives v < 0",
)
def _(claim):
    magnitude = laws.square_root(f_d, alpha, b=b).kinetic.subs(SPEED, V)
    return [(claim * v).subs(v, side * V) - magnitude * V for side in (1, -1)]


# What the text says about the constants. f_d is the friction that is left when the motion has just begun, v -> 0; it
# is not the friction at large speed, where (19.106) and (19.107) vanish and only b v remains.
FALLING = (("(19.106)", laws.lorentz(f_d, v_c, b=b)), ("(19.107)", laws.gauss(f_d, v_c, b=b)))
for _number, _law in FALLING:

    @PART.verified(f"{_number} at v -> 0", "f_d is the force needed just after breaking away", f_d)
    def _(claim, law=_law):
        return sp.limit(law.kinetic, SPEED, 0, "+") - claim

    @PART.verified(f"{_number} region 3", "viscous damping alone at high speed: f/v tends to b", b)
    def _(claim, law=_law):
        return sp.limit(law.kinetic / SPEED, SPEED, sp.oo) - claim


# Regions 1 and 2 of figure 19.15. Without the viscous part both laws fall at every speed, as the text says. With it
# they leave f_d with the slope b > 0, because f_sb starts horizontally: region 1 begins with a rise, and it depends on
# b v_c/f_d whether there is a fall at all.
WITHOUT = (
    ("(19.106)", laws.lorentz(f_d, v_c), -2 * f_d * V / (v_c * (1 + (V / v_c) ** 2)) ** 2),
    ("(19.107)", laws.gauss(f_d, v_c), -2 * f_d * V / v_c**2 * sp.exp(-((V / v_c) ** 2))),
)
for _number, _law, _slope in WITHOUT:

    @PART.verified(
        f"{_number} regions 1 and 2, b = 0",
        "slope of friction without viscous damping: negative at every speed, -1 for its sign",
        _slope,
        -1,
    )
    def _(claim, sign, law=_law):
        slope = law.kinetic.diff(SPEED).subs(SPEED, V)
        return slope - claim, (-1 if slope.is_negative else 0) - sign

    @PART.corrected(
        f"{_number} region 1, b > 0",
        "slope of friction at v -> 0",
        right=b,
        printed="negative slope in regions 1 and 2",
        note="f_sb starts with slope 0, so that b decides: for b > 0 the slope is positive up to a first speed, "
        "negative up to a second one, if there are two, see the next rows. For b = 0 the statement holds at "
        "every v > 0, for (19.108) with alpha < 0 up to alpha^2/(4 b^2)",
    )
    def _(claim, law=dict(FALLING)[_number]):
        return sp.limit(law.kinetic.diff(SPEED), SPEED, 0, "+") - claim


# The two speeds. (19.107): with z = -2 (v/v_c)^2 the slope vanishes where z e^z = -(b v_c/f_d)^2/2, Lambert's function.
# (19.106): with s = v/v_c where (b v_c/f_d) (1 + s^2)^2 = 2 s, of degree four; its numbers are below.
BETWEEN = tuple(v_c * sp.sqrt(-sp.LambertW(-((b * v_c / f_d) ** 2) / 2, branch) / 2) for branch in (0, -1))


@PART.verified("(19.107) unstable speeds", "speeds between which friction falls, b > 0", *BETWEEN)
def _(*claim):
    # W e^W = -(b v_c/f_d)^2/2 with W = -w on either branch; b is written through it
    w = sp.Symbol("w", positive=True)
    through = sp.sqrt(2 * w) * sp.exp(-w / 2) * f_d / v_c
    slope = laws.gauss(f_d, v_c, b=b).kinetic.diff(SPEED)
    speeds = [speed.replace(sp.LambertW, lambda *_: -w) for speed in claim]
    return [slope.subs(SPEED, speed).subs(b, through) for speed in speeds]


SKETCH = {f_d: sp.Rational(8, 10), v_c: sp.Rational(3, 10), b: sp.Rational(35, 100)}  # drawn for figure 19.15, ours
LIMITS = [[sp.Float(e) for e in falling_speeds(law(0.8, 0.3, b=0.35))[0]] for law in (laws.lorentz, laws.gauss)]


@PART.verified(
    "(19.106), (19.107) numbers",
    "speeds between which friction falls: symfric.theory.falling_speeds for f_d = .8, v_c = .3, b = .35",
    *LIMITS[0],
    *LIMITS[1],
    numbers="12 digits",
)
def _(*claim):
    s = sp.Symbol("s")
    quartic = sp.Poly((b * v_c / f_d).subs(SKETCH) * (1 + s**2) ** 2 - 2 * s, s)
    lorentz = sorted(r * SKETCH[v_c] for r in quartic.nroots(n=30) if r.is_real)
    return [agree(f, c) for f, c in zip([*lorentz, *(e.subs(SKETCH) for e in BETWEEN)], claim, strict=True)]


# Region 2 exists only if the fall of f_sb beats the viscous rise somewhere. The steepest fall is where the second
# derivative vanishes; b must stay below it.
STEEPEST = (
    ("(19.106)", laws.lorentz(f_d, v_c), 3 * sp.sqrt(3) * f_d / (8 * v_c)),
    ("(19.107)", laws.gauss(f_d, v_c), sp.sqrt(2 / sp.E) * f_d / v_c),
)
for _number, _law, _bound in STEEPEST:

    @PART.verified(f"{_number} region 2", "viscous coefficient from which no slope is negative", _bound)
    def _(claim, law=_law):
        slope = law.kinetic.diff(SPEED)
        return [-slope.subs(SPEED, turn) - claim for turn in sp.solve(slope.diff(SPEED), SPEED)]


# 19.5.1: two straight lines stand for gears and bearings. The package's law of two sections is continuous at its corner
# and falls up to there, and only there.
@PART.verified(
    "19.5.1 two lines",
    "speeds between which a law of two lines falls, slopes -a and c: from rest to the corner",
    0,
    v_c,
    note="figure 19.19; sharp fall, then a moderate rise, the equivalent viscous damping constant",
)
def _(*claim):
    law = laws.piecewise_linear(f_d, [0, v_c], [f_d, f_d - V * v_c], last_slope=b)  # slopes -V and b
    slopes = [piece.expr.diff(SPEED) for piece in law.kinetic.args]
    corner = law.kinetic.args[0].expr - law.kinetic.args[1].expr
    (place,) = sp.solve(corner, SPEED)
    falls = [bool(slope.is_negative) for slope in slopes]
    return 0 - claim[0], (place if falls == [True, False] else sp.oo) - claim[1]


@PART.verified(
    "19.5.1 corner",
    "corner and slopes of the lines through points of a law 1/20 - 9/500 v up to 2, then + 3/2500 v",
    2,
    -sp.Rational(9, 500),
    sp.Rational(3, 2500),
    numbers="10 digits, from 9 points of which none is the corner",
)
def _(*claim):
    speeds = [sp.Rational(n, 4) for n in (1, 3, 5, 7, 9, 13, 19, 27, 40)]
    low, high = sp.Rational(1, 20) - sp.Rational(9, 500) * SPEED, sp.Rational(58, 5000) + sp.Rational(3, 2500) * SPEED
    (corner,) = sp.solve(low - high, SPEED)
    points = [(low if s < corner else high).subs(SPEED, s) for s in speeds]
    fit = two_lines([float(s) for s in speeds], [float(p) for p in points])
    exact = [agree(e, c) for e, c in zip((corner, low.diff(SPEED), high.diff(SPEED)), claim, strict=True)]
    package = (fit.corner, fit.slope_below, fit.slope_above)
    return [*exact, *(agree(sp.Float(f), c, digits=10) for f, c in zip(package, claim, strict=True))]


PART.unverifiable("Figure 19.14", "damping ratio of structures against amplitude", "measured; no data is printed")
PART.unverifiable(
    "Figure 19.18",
    "measured friction of a pair of spur gears, close to two lines",
    "no data is printed; `sf.theory.two_lines` fits the law to points and says how well",
)
PART.unverifiable("Table 19.6", "damping ratios for seismic design", "a code's values; nothing to derive")


@PART.verified("(19.108) region 2", "speed at which friction is least, for alpha = -|alpha|", V**2 / (4 * b**2))
def _(claim):
    slope = laws.square_root(f_d, -V, b=b).kinetic.diff(SPEED)  # V stands for |alpha|
    return sp.solve(slope, SPEED)[0] - claim
