"""Cases and states, section 2.4."""

import sympy as sp

from derivations.ledger import Ledger
from derivations.rolling_isolation.factors import SCALES
from derivations.rolling_isolation.structure import BOTH, C, V, _newton, a_e, g, m, mu, step, w
from symfric.theory import scaling

PART = Ledger("rolling_isolation", "2.4: cases and states")


@PART.verified(
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


@PART.corrected(
    "after Table 2 second condition",
    "force of friction per mass that keeps the structure with the ground",
    right=a_e,
    printed=a_e + C * w / m,
    note="|a_e - C (v_e - v_s)/m| <= mu g: at rest relative to the ground the damper gives nothing; the first "
    "condition lets through a w of mu g dt, so the printed one errs by C mu g dt/m",
)
def _(claim):
    needed = sp.Symbol("F", real=True)
    velocity = 0  # v_s - v_e once the structure stays
    return sp.solve(needed - C * velocity - m * a_e, needed)[0] / m - claim


PART.definition("(1)", "returned ratio", scaling.returned_ratio(*sp.symbols("model prototype factor", positive=True)))
