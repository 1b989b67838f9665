"""Scale factors of the model, section 2.3."""

from functools import cache, partial

import sympy as sp

from derivations.ledger import Ledger
from derivations.residuals import agree
from derivations.rolling_isolation.structure import D, L, f
from symfric.motions import sine_burst
from symfric.theory import scaling

PART = Ledger("rolling_isolation", "2.3: scale factors")

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
    PART.verified(f"Tables 1 and 2 {_name}", "equation in terms of L and D", f.to_dict()[_name])(
        partial(_by_dimension, name=_name)
    )
PART.definition("Tables 1 and 2 gravity_2", "gravity as it is on a shaking table", f.gravity_2)

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
        PART.verified(f"{_table} {_name}", "all seven entries", *map(sp.Rational, _entries.split()))(
            partial(_recomputed, name=_name, printed=_entries, mass=_mass)
        )


@PART.verified(
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


# --- Beyond the source: dampers C |w|^alpha, friction that depends on the speed, the density for a table --------------
ALPHA = sp.Symbol("alpha", positive=True)


@PART.verified(
    "beyond 2.3 damper", "factor of C with the force C |w|^alpha", f.damper(ALPHA), note="alpha = 1 is the printed row"
)
def _(claim):
    by_dimension = _factor("force") / _factor("velocity") ** ALPHA
    return (
        sp.simplify(by_dimension - claim),
        sp.simplify(claim - D ** (ALPHA / 2) / L**2),
        sp.simplify(claim.subs(ALPHA, 1) - f.damping),
    )


@PART.verified("beyond 2.3 speeds", "factor of the speeds at which a law of friction changes, v_c", 1 / sp.sqrt(D))
def _(claim):
    return _factor("velocity") - claim


@PART.verified(
    "beyond 2.3 model",
    "C, m and g of the package's model 1:7 with D = 2.8 of a prototype with 1, 1, 1 and a damper C |w|^(1/2)",
    *(
        sp.Float(v)
        for name, v in sorted(
            (s.name, v)
            for s, v in scaling.isolator_model(
                scaling.factors(7, D=2.8), C=1, m=1, g=1, motion=sine_burst(1.0, 1.0, cycles=4), profile=0.1, alpha=0.5
            ).values.items()
        )
        if name in ("C", "g", "m")
    ),
    numbers="12 digits, by dimensions",
)
def _(*claim):
    powers = (_factor("force") / _factor("velocity") ** sp.Rational(1, 2), _factor("gravity_1"), _factor("mass"))
    return [agree(e.subs({L: 7, D: sp.Rational("2.8")}), c) for e, c in zip(powers, claim, strict=True)]


@PART.verified(
    "beyond 2.3 density",
    "D with which accelerations scale by 1; factor of the mass then; L at which the mass of table 2 balances",
    L,
    1 / L**2,
    1 / sp.sqrt(MASS),
    note="11.0682: between the models 1:10 and 1:13, whose accelerations scale by 1.225 and 0.725",
)
def _(density, mass, balance):
    (found,) = sp.solve(f.acceleration - 1, D)
    (length,) = sp.solve(f.acceleration.subs(D, MASS * L**3) - 1, L)
    package = scaling.for_table(1.0, float(MASS))
    beside = [int(abs(a - b) > 1e-9) for a, b in ((package.L, float(balance)), (package.D, float(balance)))]
    return found - density, f.mass.subs(D, density) - mass, length - balance, *beside


@PART.verified("Section 2.3 extra mass", "added mass over that of a model of density 1, table 2", MASS * L**3 - 1)
def _(claim):
    same = f.mass.subs(D, 1)
    found = (MASS - same) / same
    signs = [sp.sign(found.subs(L, s)) for s in SCALES[1:]]  # negative for 1:4 only
    return found - claim, signs[0] + 1, sum(signs[1:]) - 5
