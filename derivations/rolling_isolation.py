"""Scaling rolling friction effects in shaking table tests: the isolator's motion, the scale factors, similarity."""

from functools import cache, partial

import sympy as sp

from derivations.ledger import Ledger
from symfric.theory import scaling

LEDGER = Ledger(
    "rolling_isolation", "A numerical investigation on scaling rolling friction effects in shaking table model tests"
)

L, D = scaling.SYMBOLS
f = scaling.factors(symbolic=True)  # model over prototype, in L and D
m, C, mu, g, V, R, step = sp.symbols("m C mu g V R dt", positive=True)  # V: a speed |v_s - v_e| > 0
u, w, a_e = sp.symbols("u w a_e", real=True)  # d_s - d_e, v_s - v_e, acceleration of the ground
BOTH = (1, -1)

# --- Section 2.1: the structure ----------------------------------------------------------------------------------
# The structure feels the ground through the damper, which pulls it along with C (v_e - v_s), and through the rollers,
# whose friction mu m g opposes the relative motion. The print leaves the sign open; it is that of v_e - v_s, so that
# both take power from the relative motion.


def _newton(side, speed, friction=mu, gravity=g, damping=C, mass=m):
    """Acceleration a_s while the structure moves past the ground at a speed to one side."""
    velocity = side * speed  # v_s - v_e
    return (-side * friction * mass * gravity - damping * velocity) / mass


@LEDGER.corrected(
    "Section 2.1 motion",
    "force m a_s on the structure while it rolls",
    right=-sp.sign(w) * mu * m * g - C * w,
    printed=mu * m * g - C * w,
    note="printed with +-, without saying when; the sign is that of v_e - v_s",
)
def _(claim):
    # the power given to the relative motion is that taken by friction and damper, to both sides
    return [(claim * w).subs(w, side * V) + mu * m * g * V + C * V**2 for side in BOTH]


@LEDGER.verified(
    "Section 2.1 relative motion", "u'' of u = d_s - d_e; beyond the source", -sp.sign(w) * mu * g - C / m * w - a_e
)
def _(claim):
    return [_newton(side, V) - a_e - claim.subs(w, side * V) for side in BOTH]


@LEDGER.verified("Section 2.1 damper", "C sgn(v)|v|^alpha for alpha = 1, v = v_e - v_s", -C * w)
def _(claim):
    alpha = sp.Symbol("alpha", positive=True)
    force = C * sp.sign(-w) * sp.Abs(w) ** alpha
    return [(force.subs(alpha, 1) - claim).subs(w, side * V) for side in BOTH]


@LEDGER.verified(
    "Section 2.1 damping ratio",
    "largest equivalent damping ratio, C = 200 kN s/m, m = 300 t, T = 4.5 s: below 25 %",
    sp.Rational(3, 4) / sp.pi,
)
def _(claim):
    stiffness, omega = sp.symbols("stiffness omega", positive=True)
    critical = 2 * sp.sqrt(stiffness * m)
    ratio = (C / critical).subs(stiffness, m * omega**2).subs(omega, 2 * sp.pi / sp.Rational(9, 2))
    found = ratio.subs({C: 200, m: 300})
    return found - claim, sp.Max(found, sp.Rational(1, 4)) - sp.Rational(1, 4)


@LEDGER.verified(
    "Section 2.1 variation",
    "friction variation coefficients of cases 2 and 3",
    sp.Rational("0.163"),
    sp.Rational("0.471"),
)
def _(*claim):
    return [sp.Rational(s) / sp.Rational("0.005") - c for s, c in zip(("0.000815", "0.002355"), claim, strict=True)]


LEDGER.unverifiable(
    "Figure 2",
    "friction along the surface in cases 2 and 3",
    "range, mean and standard deviation are given, cells and realisation are not",
)
LEDGER.unverifiable("Section 2.2", "20 motions fitted to the spectrum of JTJ 004-89", "the records are not named")

# --- Section 2.3: scale factors ----------------------------------------------------------------------------------
# Three independent quantities carry the dimensions: length (model 1/L), elastic modulus (the material stays, 1) and
# density (D). Every other quantity is length^a modulus^b density^c with exponents from its dimension in kg, m, s, and
# scales alike.
DIMENSIONS = {  # kg, m, s
    "length": (0, 1, 0),
    "friction_increment": (0, -1, 0),
    "elastic_modulus": (1, -1, -2),
    "stress": (1, -1, -2),
    "density": (1, -3, 0),
    "mass": (1, 0, 0),
    "force": (1, 1, -2),
    "damping": (1, 0, -1),
    "time": (0, 0, 1),
    "velocity": (0, 1, -1),
    "acceleration": (0, 1, -2),
    "gravity_1": (0, 1, -2),
}
BASIS = ("length", "elastic_modulus", "density")


@cache
def _factor(name):
    """Return the scale factor of a quantity by dimensional analysis."""
    basis = sp.Matrix([DIMENSIONS[b] for b in BASIS]).T
    exponents = basis.solve(sp.Matrix(DIMENSIONS[name]))
    powers = (base**e for base, e in zip((1 / L, sp.Integer(1), D), exponents, strict=True))
    return sp.powdenest(sp.Mul(*powers), force=True)


def _by_dimension(claim, name):
    return _factor(name) - claim


for _name in DIMENSIONS:
    LEDGER.verified(f"Tables 1 and 2 {_name}", "equation in terms of L and D", f.to_dict()[_name])(
        partial(_by_dimension, name=_name)
    )
LEDGER.definition("Tables 1 and 2 gravity_2", "gravity as it is on a shaking table", f.gravity_2)

# The printed numbers are the formulas rounded to the digits printed. `L` is 1, 4, ..., 19: the inverse of the length
# scale. In table 2 the density is chosen so that the mass scales by one number, 0.008163, whatever L; the prototype
# has D = 1.
SCALES = (1, 4, 7, 10, 13, 16, 19)
MASS = sp.Rational("0.008163")
SAME = "1 4 7 10 13 16 19"
ONES = "1 1 1 1 1 1 1"
LENGTHS = "1 1/4 1/7 1/10 1/13 1/16 1/19"
FORCES = "1 0.0625 0.0204 0.01 0.00592 0.00391 0.00277"
ACCELERATIONS = "1 7.656 2.5 1.225 0.725 0.479 0.339"
TABLE_1 = {
    "length": LENGTHS,
    "friction_increment": SAME,
    "elastic_modulus": ONES,
    "stress": ONES,
    "density": ONES,
    "mass": "1 0.0156 0.00292 0.001 0.000455 0.000244 0.000146",
    "force": FORCES,
    "damping": FORCES,
    "time": "1 0.25 0.143 0.1 0.0769 0.0625 0.0526",
    "velocity": ONES,
    "acceleration": SAME,
    "gravity_1": SAME,
    "gravity_2": ONES,
}
TABLE_2 = {
    **TABLE_1,
    "density": "1 0.522 2.800 8.163 17.934 33.436 55.990",
    "mass": "1 0.00816 0.00816 0.00816 0.00816 0.00816 0.00816",
    "damping": "1 0.0452 0.0341 0.0286 0.0251 0.0226 0.0207",
    "time": "1 0.181 0.239 0.286 0.326 0.361 0.394",
    "velocity": "1 1.384 0.598 0.350 0.236 0.173 0.134",
    "acceleration": ACCELERATIONS,
    "gravity_1": ACCELERATIONS,
}


def _rounded(value, entry):
    """Round a number to the digits printed in an entry; exact entries, integers and fractions, compare as they are."""
    places = len(entry.partition(".")[2])
    return value if not places else sp.Rational(round(sp.N(value, 30) * 10**places), 10**places)


def _recomputed(*claim, name, printed, mass=None):
    found = []
    for scale, entry, number in zip(SCALES, printed.split(), claim, strict=True):
        density = 1 if mass is None or scale == 1 else mass * scale**3
        exact = _factor(name) if name in DIMENSIONS else sp.Integer(1)
        found.append(_rounded(exact.subs({L: scale, D: density}), entry) - number)
    return found


for _table, _rows, _mass in (("Table 1", TABLE_1, None), ("Table 2", TABLE_2, MASS)):
    for _name in f.to_dict():
        _entries = _rows[_name]
        LEDGER.verified(f"{_table} {_name}", "all seven entries", *map(sp.Rational, _entries.split()))(
            partial(_recomputed, name=_name, printed=_entries, mass=_mass)
        )


@LEDGER.verified(
    "Table 2 choice of density",
    "bounds on D/L^3 set by the rounding of the printed densities",
    sp.Rational("33.4355") / 16**3,
    sp.Rational("55.9905") / 19**3,
    note="0.008163 is inside; 1/122.5, which would make the accelerations 7.656 and 2.5 exact, is not",
)
def _(low, high):
    half = sp.Rational("0.0005")
    entries = list(zip(SCALES[1:], map(sp.Rational, TABLE_2["density"].split()[1:]), strict=True))
    bounds = max((d - half) / s**3 for s, d in entries), min((d + half) / s**3 for s, d in entries)
    inside = sp.Integer(0 if bounds[0] < MASS < bounds[1] < 1 / sp.Rational("122.5") else 1)
    return bounds[0] - low, bounds[1] - high, inside


@LEDGER.verified("Section 2.3 extra mass", "added mass over that of a model of density 1, table 2", MASS * L**3 - 1)
def _(claim):
    same = f.mass.subs(D, 1)
    found = (MASS - same) / same
    signs = [sp.sign(found.subs(L, s)) for s in SCALES[1:]]  # negative for 1:4 only
    return found - claim, signs[0] + 1, sum(signs[1:]) - 5


# --- Section 2.4: cases and states -------------------------------------------------------------------------------


@LEDGER.verified(
    "Section 2.4 cases",
    "models, friction distributions, cases in all",
    25,
    8,
    40000,
    note="25 is the prototype and 6 scales of 2 tables with 2 gravities; 8 is 6 concave distributions with R = 0 in 3 "
    "cases",
)
def _(models, frictions, cases):
    scales, tables, gravities = len(SCALES) - 1, 2, 2
    found = 1 + scales * tables * gravities, 6 - 1 + 3
    return found[0] - models, found[1] - frictions, 1 * 2 * found[0] * found[1] * 20 * 5 - cases


# While both move alike friction holds the structure: it must give the whole of m a_e, because the damper rests.


@LEDGER.verified("Section 2.4 (2)1", "largest |a_e| at which the structure stays with the ground", mu * g)
def _(claim):
    ground = sp.Symbol("ground", positive=True)
    needed = m * ground  # Newton with a_s = a_e
    return sp.solve(needed - mu * m * g, ground)[0] - claim


# Beyond it the structure lags behind the ground: friction pulls it along, with the sign of a_e. The relative motion
# then starts with -(|a_e| - mu g) sgn a_e, to the side that friction was assumed to oppose: the choice is consistent,
# and the other one is not.


@LEDGER.verified(
    "Section 2.4 (2)2",
    "a_s just after release, |a_e| = mu g + V; the print leaves the sign open",
    sp.sign(a_e) * mu * g,
)
def _(claim):
    found = []
    for side in BOTH:
        ground = side * (mu * g + V)
        consistent = [s for s in BOTH if sp.sign(_newton(s, 0) - ground) == s]  # u'' to the side s of the assumed slip
        found += [len(consistent) - 1, _newton(consistent[0], 0) - claim.subs(a_e, ground)]
    return found


# The printed test for coming to rest belongs to a step of dt. With v_e at its end, v_s at its beginning and the damper
# taken between these two, friction must give m (v_e - v_s)/dt - C (v_e - v_s) to make the structure as fast as the
# ground; it can if that is at most mu m g. For dt -> 0 this is v_e = v_s, and |a_e| <= mu g remains as the condition.


@LEDGER.verified(
    "after Table 2 first condition",
    "quantity to compare with mu g dt, under the reading v_e new, v_s old",
    w + C * -w * step / m,
    note="with both velocities old a term a_e dt would be missing. A test by a step makes the stop depend on the step",
)
def _(claim):
    needed = sp.Symbol("F", real=True)
    (force,) = sp.solve(w + step / m * (-C * w + needed), needed)  # w: v_s old less v_e new
    return -force * step / m - claim


@LEDGER.corrected(
    "after Table 2 second condition",
    "force of friction per mass that keeps the structure with the ground",
    right=a_e,
    printed=a_e + C * w / m,
    note="|a_e - C (v_e - v_s)/m| <= mu g: at rest relative to the ground the damper gives nothing; the first "
    "condition lets through a w of mu g dt, so the printed one errs by C mu g dt/m",
    audit="blames the step alone; the second condition has a force too many at any step",
)
def _(claim):
    needed = sp.Symbol("F", real=True)
    velocity = 0  # v_s - v_e once the structure stays
    return sp.solve(needed - C * velocity - m * a_e, needed)[0] / m - claim


LEDGER.definition("(1)", "returned ratio", scaling.returned_ratio(*sp.symbols("model prototype factor", positive=True)))

# --- Sections 3 and 4: similarity --------------------------------------------------------------------------------
# The relative motion is u'' = -sgn(u') mu(u) g - (C/m) u' - a_e. In the model every quantity is that of the prototype
# times its factor. If then u'' comes out as that of the prototype times the factor of acceleration, for every state,
# the scaled motion of the prototype solves the model's equation; the bounds mu g on |a_e| scale likewise, so it sticks
# and releases at corresponding times, and every response returned has the ratio (1) equal to 1. The ratio of
# accelerations below is therefore that of all responses.
PROFILE = sp.Function("mu", positive=True)


def _acceleration(side, *, friction, scales=None, gravity=1):
    """Relative acceleration at speed V to one side; with factors, that of the model in the state that corresponds."""
    s = scales
    mass, damping, velocity, ground = (s.mass, s.damping, s.velocity, s.acceleration) if s else (1, 1, 1, 1)
    return _newton(side, V * velocity, friction, g * gravity, C * damping, m * mass) - a_e * ground


def _ratios(friction_model, friction, gravity=f.gravity_1):
    """Returned ratio (1) of the relative acceleration, to both sides; in scaled gravity unless given."""
    return [
        scaling.returned_ratio(
            _acceleration(side, friction=friction_model, scales=f, gravity=gravity),
            _acceleration(side, friction=friction),
            f.acceleration,
        )
        for side in BOTH
    ]


@LEDGER.verified(
    "Section 3.1",
    "RR with uniform friction and scaled gravity, for every D: tables 1 and 2",
    1,
    note="exact; the printed errors, up to 20 % in the residual displacement, must be numerical",
)
def _(claim):
    return [ratio - claim for ratio in _ratios(mu, mu)]


@LEDGER.verified("Section 3.2 concave", "RR with mu + R |u|, R scaled by L", 1)
def _(claim):
    position = sp.Abs(u) * f.length
    return [ratio - claim for ratio in _ratios(mu + R * f.friction_increment * position, mu + R * sp.Abs(u))]


@LEDGER.verified("Section 3.2 positions moved", "RR with any profile mu(u), its positions scaled by 1/L", 1)
def _(claim):
    def profile(position):
        return PROFILE(position / f.length)

    return [ratio - claim for ratio in _ratios(profile(u * f.length), PROFILE(u))]


# With the profile of the prototype left as it is, the model meets at u/L the friction of the place u/L, not of u.


@LEDGER.verified(
    "Section 3.2 positions not moved",
    "friction of the model over what it should be, mu + R |u|, scaled gravity",
    (mu + R * sp.Abs(u) / L) / (mu + R * sp.Abs(u)),
)
def _(claim):
    model = mu + R * sp.Abs(u * f.length)
    force = [
        _acceleration(side, friction=model, scales=f, gravity=f.gravity_1) / f.acceleration
        - _acceleration(side, friction=0)
        for side in BOTH
    ]
    return [e + side * claim * (mu + R * sp.Abs(u)) * g for e, side in zip(force, BOTH, strict=True)]


# --- Sections 5 and 6: gravity as it is --------------------------------------------------------------------------
# Without scaled gravity the friction of the model is short of what similarity demands by gravity_2/gravity_1 = D/L, and
# by nothing else: the model is the prototype with another coefficient of friction.


@LEDGER.verified(
    "Section 5.1 distortion", "coefficient that the model seems to have, over its own", f.friction_distortion
)
def _(claim):
    return [
        _acceleration(side, friction=mu, scales=f, gravity=f.gravity_2) / f.acceleration
        - _acceleration(side, friction=claim * mu)
        for side in BOTH
    ]


@LEDGER.verified("Section 5.1 underestimate", "gravity over its theoretical value, table 1: the model scale", 1 / L)
def _(claim):
    return (f.gravity_2 / _factor("acceleration")).subs(D, 1) - claim


@LEDGER.verified(
    "Section 5.1 trend, conclusion 3",
    "1 - RR of the structural acceleration at speed V: falls to 0 as C V grows",
    (1 - 1 / L) * mu * g / (mu * g + C * V / m),
)
def _(claim):
    distorted = _newton(1, V, friction=f.friction_distortion.subs(D, 1) * mu)
    return 1 - distorted / _newton(1, V) - claim, sp.limit(claim, V, sp.oo)


@LEDGER.verified("Sections 5.2 and 6.2", "factor on mu that makes up for unscaled gravity", L / D)
def _(claim):
    return [ratio - 1 for ratio in _ratios(claim * mu, mu, f.gravity_2)]


@LEDGER.verified(
    "Section 6.1 estimates",
    "L below which gravity is underestimated and above which it is overestimated, table 2",
    1 / sp.sqrt(MASS),
    note="11.07: at 1:10 the factor is 1.225, so that friction is still 18 % short; 'close to 1.0' is lenient",
)
def _(claim):
    acceleration = f.acceleration.subs(D, MASS * L**3)
    (balanced,) = sp.solve(acceleration - 1, L)
    below = sp.sign(acceleration.subs(L, 10) - 1) - 1, sp.sign(acceleration.subs(L, 13) - 1) + 1
    return balanced - claim, *below


@LEDGER.verified("Conclusion 1", "density that makes the factor of acceleration 1", L)
def _(claim):
    return sp.solve(f.acceleration - 1, D)[0] - claim


# --- Table 3 -----------------------------------------------------------------------------------------------------
# The ranges themselves need the friction along the surface and the records, which are not given. What the text says
# about them can be checked on the printed numbers. Columns: acceleration, velocity, displacement, residual.
RANGES = {  # (C, case): (low, high)
    (100, 2): ("0.82 1.03", "0.88 1.07", "0.71 1.22", "0 15"),
    (100, 3): ("0.71 1.10", "0.62 1.40", "0.49 1.67", "0 650"),
    (200, 2): ("0.83 1.18", "0.91 1.07", "0.72 1.42", "0 11"),
    (200, 3): ("0.72 1.12", "0.72 1.22", "0.54 1.49", "0 21"),
}


def _widths(damping, case):
    ranges = (map(sp.Rational, entry.split()) for entry in RANGES[damping, case])
    return [high - low for low, high in ranges]


def _wider(first, second):
    """Count the columns in which the first row of widths is the wider one."""
    return sum(bool(a > b) for a, b in zip(first, second, strict=True))


LEDGER.unverifiable(
    "Table 3 entries",
    "ranges of RR in cases 2 and 3",
    "neither friction along the surface nor records are given",
)


@LEDGER.verified("Table 3 variation", "columns in which case 3 is wider than case 2, for C = 100 and 200", 4, 4)
def _(*claim):
    return [_wider(_widths(c, 3), _widths(c, 2)) - n for c, n in zip((100, 200), claim, strict=True)]


@LEDGER.corrected(
    "Table 3 damping",
    "columns that become narrower from C = 100 to 200, in cases 2 and 3",
    right=(2, 3),
    printed=(4, 4),
    note="case 2: acceleration .21 to .35 and displacement .51 to .70 become wider; case 3: acceleration .39 to .40",
    audit="names case 2 only; the acceleration of case 3 becomes wider too",
)
def _(*claim):
    return [_wider(_widths(100, c), _widths(200, c)) - n for c, n in zip((2, 3), claim, strict=True)]


@LEDGER.verified("Section 3.2 order", "case 3, C = 100: steps to a wider range from column to column", 3)
def _(claim):
    widths = _widths(100, 3)
    return _wider(widths[1:], widths[:-1]) - claim
