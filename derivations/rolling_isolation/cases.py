"""Cases and states, section 2.4."""

import numpy as np
import sympy as sp

from derivations.ledger import Ledger
from derivations.rolling_isolation.structure import BOTH, C, V, _newton, a_e, g, m, mu, step, w
from symfric.theory import scaling
from symfric_evidence.sources.rolling import study

PART = Ledger("rolling_isolation", "2.4: cases and states")


@PART.verified(
    "Section 2.4 cases",
    "models, friction distributions, cases in all, of the study that the package runs",
    25,
    8,
    40000,
    note="25 is the prototype and 6 scales of 2 tables with 2 gravities; 8 is 6 concave distributions with R = 0 in 3 "
    "cases",
)
def _(count, profiles, cases):
    # counted on what the package runs: models that differ in a factor or in gravity, frictions that differ at a place
    different = {(tuple(model.factors.to_dict().values()), model.gravity) for model in study.models()}
    floors = {np.array(_friction(p)).tobytes() for p in study.frictions().values()}
    runs = len(different) * len(floors) * len(study.DAMPINGS) * len(study.INTENSITIES) * len(study.synthetic_set())
    return len(different) - count, len(floors) - profiles, runs - cases


def _friction(profile):
    """Return the coefficient of a profile at some places of the floor."""
    places = np.linspace(-1.9, 1.9, 400)
    if isinstance(profile, float):
        return np.full_like(places, profile)
    if np.ndim(profile[0]) == 0:
        return profile[0] + profile[1] * np.abs(places)
    edges, values = profile
    return values[np.searchsorted(edges[1:-1], places, side="right")]


# While both move alike friction holds the structure: it must give the whole of m a_e, because the damper rests.


@PART.verified("Section 2.4 (2)1", "largest |a_e| at which the structure stays with the ground", mu * g)
def _(claim):
    ground = sp.Symbol("ground", positive=True)
    needed = m * ground  # Newton with a_s = a_e
    return sp.solve(needed - mu * m * g, ground)[0] - claim


# Beyond it the structure lags behind the ground: friction pulls it along, with the sign of a_e. The relative motion
# then starts with -(|a_e| - mu g) sgn a_e, to the side that friction was assumed to oppose: the choice is consistent,
# and the other one is not.


@PART.verified(
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


@PART.verified(
    "after Table 2 first condition",
    "quantity to compare with mu g dt, under the reading v_e new, v_s old",
    w + C * -w * step / m,
    note="with both velocities old a term a_e dt would be missing. A test by a step makes the stop depend on the step",
)
def _(claim):
    needed = sp.Symbol("F", real=True)
    (force,) = sp.solve(w + step / m * (-C * w + needed), needed)  # w: v_s old less v_e new
    return -force * step / m - claim


# The second condition is tested with the velocity w that the first one lets through, before it is set to 0. What it
# compares with mu g is the friction that the structure would need to move like the ground from there; at rest, w = 0,
# that is |a_e| <= mu g. Both differ by C w/m, which the first condition bounds.


@PART.verified(
    "after Table 2 second condition",
    "friction per mass that the structure needs to move like the ground at a velocity w; its error at the largest w",
    a_e + C * w / m,
    C * mu * g * step / (m - C * step),
    note="tested a step early, the condition is off by C mu g dt/m at the most to the first order, which vanishes with "
    "the step",
)
def _(claim, error):
    needed, left = sp.Symbol("F", real=True), sp.Symbol("left", positive=True)
    (force,) = sp.solve(needed - C * w - m * a_e, needed)  # m a_s = F - C w with a_s = a_e
    (largest,) = sp.solve(left - C * left * step / m - mu * g * step, left)  # of the first condition
    excess = (force / m).subs(w, largest) - (force / m).subs(w, 0)
    return force / m - claim, excess - error, sp.limit(error, step, 0)


PART.definition("(1)", "returned ratio", scaling.returned_ratio(*sp.symbols("model prototype factor", positive=True)))
