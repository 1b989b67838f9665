"""Which models are similar, and what gravity as it is spoils, sections 3 to 6 and Table 3."""

import numpy as np
import sympy as sp

from derivations.ledger import Ledger
from derivations.rolling_isolation.factors import MASS, SCALES, _factor
from derivations.rolling_isolation.structure import BOTH, C, D, L, R, V, _newton, a_e, f, g, m, mu, u
from symfric.motions import sine_burst
from symfric.theory import scaling
from symfric_evidence.sources.rolling.printed_scheme import returned_by_steps, rounded_factors

PART = Ledger("rolling_isolation", "3 to 6: similarity")

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


@PART.verified(
    "Section 3.1",
    "RR with uniform friction and scaled gravity, for every D: tables 1 and 2",
    1,
    note="exact; so are fixed steps, which scale along: the printed errors come from rounded factors, see the next row",
)
def _(claim):
    return [ratio - claim for ratio in _ratios(mu, mu)]


# The scheme of section 2.4 marches a similar model in similar steps, dt sqrt(D)/L: every state of the model is that of
# the prototype times its factor, to rounding. With the factors as table 1 prints them, mass and damping constant do not
# belong together any more, nor does the step.
MOTION = (sine_burst(2.0, 1.1, 6, dt=0.01),)


@PART.verified(
    "Section 3.1 fixed steps",
    "largest |RR - 1| of the peaks by the scheme of section 2.4, with exact factors and with those printed in table 1: "
    "0 below 1e-12, 1 above 1e-4",
    0,
    1,
    note="so it is not the fixed step that leaves RR beside 1, as one might think, but the digits of the factors",
    numbers="one sine burst at five intensities",
)
def _(*claim):
    found = []
    for by in ([scaling.factors(float(scale)) for scale in SCALES[1:]], rounded_factors()):
        ratios = returned_by_steps(MOTION, 0.005, by)
        off = max(float(np.nanmax(np.abs(ratios[k] - 1))) for k in list(ratios)[:3])
        found.append(0 if off < 1e-12 else 1 if off > 1e-4 else off)
    return [f - c for f, c in zip(found, claim, strict=True)]


@PART.verified("Section 3.2 concave", "RR with mu + R |u|, R scaled by L", 1)
def _(claim):
    position = sp.Abs(u) * f.length
    return [ratio - claim for ratio in _ratios(mu + R * f.friction_increment * position, mu + R * sp.Abs(u))]


@PART.verified("Section 3.2 positions moved", "RR with any profile mu(u), its positions scaled by 1/L", 1)
def _(claim):
    def profile(position):
        return PROFILE(position / f.length)

    return [ratio - claim for ratio in _ratios(profile(u * f.length), PROFILE(u))]


# With the profile of the prototype left as it is, the model meets at u/L the friction of the place u/L, not of u.


@PART.verified(
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


@PART.verified(
    "Section 5.1 distortion", "coefficient that the model seems to have, over its own", f.friction_distortion
)
def _(claim):
    return [
        _acceleration(side, friction=mu, scales=f, gravity=f.gravity_2) / f.acceleration
        - _acceleration(side, friction=claim * mu)
        for side in BOTH
    ]


@PART.verified("Section 5.1 underestimate", "gravity over its theoretical value, table 1: the model scale", 1 / L)
def _(claim):
    return (f.gravity_2 / _factor("acceleration")).subs(D, 1) - claim


@PART.verified(
    "Section 5.1 trend, conclusion 3",
    "1 - RR of the structural acceleration at speed V: falls to 0 as C V grows; its derivatives by C and by V over it",
    (1 - 1 / L) * mu * g / (mu * g + C * V / m),
    -V / (m * mu * g + C * V),
    -C / (m * mu * g + C * V),
    note="at a given velocity: both are negative, so that damping and intensity raise the ratio towards 1. Of relative "
    "velocities and displacements this says nothing, see the next rows",
)
def _(claim, by_damping, by_speed):
    distorted = _newton(1, V, friction=f.friction_distortion.subs(D, 1) * mu)
    short = 1 - distorted / _newton(1, V)
    slopes = [short.diff(s) / short - c for s, c in ((C, by_damping), (V, by_speed))]
    return short - claim, sp.limit(claim, V, sp.oo), *slopes


PART.unverifiable(
    "Section 5.1 RVRR, DRR",
    "RVRR rises with PGA, the relative DRR tends to 1",
    "the source's records are not named. With those at hand `symfric reproduce rolling-7` gives the medians: RVRR "
    "falls towards 1 from above, and the medians of the DRR pass 1 or stay beside it",
)
PART.unverifiable(
    "Section 6.1 close to 1",
    "at 1:10 all four ratios are always close to 1",
    "the source's records are not named. `symfric reproduce rolling-8` finds it so for the acceleration only: the "
    "residual is off by a factor of several",
)


@PART.verified("Sections 5.2 and 6.2", "factor on mu that makes up for unscaled gravity", L / D)
def _(claim):
    return [ratio - 1 for ratio in _ratios(claim * mu, mu, f.gravity_2)]


@PART.verified(
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


@PART.verified("Conclusion 1", "density that makes the factor of acceleration 1", L)
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


PART.unverifiable(
    "Table 3 entries",
    "ranges of RR in cases 2 and 3",
    "neither friction along the surface nor records are given",
)


@PART.verified("Table 3 variation", "columns in which case 3 is wider than case 2, for C = 100 and 200", 4, 4)
def _(*claim):
    return [_wider(_widths(c, 3), _widths(c, 2)) - n for c, n in zip((100, 200), claim, strict=True)]


@PART.corrected(
    "Table 3 damping",
    "columns that become narrower from C = 100 to 200, in cases 2 and 3",
    right=(2, 3),
    printed=(4, 4),
    note="case 2: acceleration .21 to .35 and displacement .51 to .70 become wider; case 3: acceleration .39 to .40",
)
def _(*claim):
    return [_wider(_widths(100, c), _widths(200, c)) - n for c, n in zip((2, 3), claim, strict=True)]


@PART.verified("Section 3.2 order", "case 3, C = 100: steps to a wider range from column to column", 3)
def _(claim):
    widths = _widths(100, 3)
    return _wider(widths[1:], widths[:-1]) - claim
