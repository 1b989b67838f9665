"""Two slides followed in time: figures 14 to 16 and what section IV concludes from them."""

import sympy as sp

from derivations.guida.motion import sticks, vibrates
from derivations.ledger import Ledger
from derivations.residuals import less, trend

PART = Ledger("guida", "III, IV")


# --- III. Two slides: figures 14 to 16 -------------------------------------------------------------------------
# Followed for 600 + 20 fs1 units of time from sticking with eta1' = -1, the other states 0. 1 stands for lasting
# stick-slip, 0 for none.
@PART.verified(
    "Figs 14, 15",
    "fs1 = 7.4 without, 7.8 with a limit cycle for d2 = s2; both with one for d2 = s2/zeta",
    *map(sp.Integer, (0, 1, 1, 1)),
    note="so the figures were drawn with d2 = s2, that is with (24) as printed",
)
def _(*claim):
    found = [vibrates(0.2, d, fs) for d in (0.3, 0.15) for fs in (7.4, 7.8)]
    return less(found, claim)


STARTS = tuple(
    (a, b, c, d) for a in (-30.0, 20.0) for b in (-25.0, 40.0) for c, d in ((-9.0, 3.0), (0.0, -6.0), (5.0, 9.0))
)


@PART.verified(
    "Fig 14", "no vibration from any start", sp.Integer(0), note="from twelve starts up to 40 away: a sample, no proof"
)
def _(claim):
    return sum(vibrates(0.2, 0.3, 7.4, start=y) for y in STARTS) - claim


@PART.verified(
    "before Fig 16", "the part of a cycle spent sticking grows with fs1", sp.Integer(1), note="fs1 = 7.8, 9, 12, 20"
)
def _(claim):
    def part(fs):
        (_, before), (begin, end) = sticks(0.2, 0.3, fs)[-4:-2]
        return (end - begin) / (end - before)

    return trend([part(fs) for fs in (7.8, 9.0, 12.0, 20.0)]) - claim


@PART.corrected(
    "Fig 16",
    "vibration with the values of the caption, s1 = 1.3, s2 = .3",
    right=sp.Integer(0),
    printed=sp.Integer(1),
    note="the motion dies out, with d2 = s2 as in figures 14 and 15; the figure belongs to the text's values, see the "
    "next row. With d2 = s2/zeta it would not die out",
)
def _(claim):
    return vibrates(1.3, 0.3, 7.4) - claim


@PART.verified("Fig 16, text", "vibration with s1 = .2, s2 = 1.3, a second damper above critical", sp.Integer(1))
def _(claim):
    return vibrates(0.2, 1.3, 7.4) - claim


@PART.verified(
    "after Fig 16", "no limit cycles with both dampers above critical", sp.Integer(0), note="s1 = s2 = 1.3, fs1 to 1000"
)
def _(claim):
    return sum(vibrates(1.3, 1.3, fs) for fs in (7.4, 50.0, 1000.0)) - claim


@PART.corrected(
    "Section IV, 2)",
    "vibration with s2 = .3 < 1, s1 = 1.3, for fs1 = 7.4, 20 and 30",
    right=tuple(map(sp.Integer, (0, 0, 1))),
    printed=tuple(map(sp.Integer, (1, 1, 1))),
    note="s1 < 1 or s2 < 1 is not sufficient: fs1 must exceed a threshold, here 25.3, for s1 = .2, s2 = .3 it is 7.74",
)
def _(*claim):
    return [vibrates(1.3, 0.3, fs) - c for fs, c in zip((7.4, 20.0, 30.0), claim, strict=True)]


@PART.verified(
    "Section IV, 2), perturbation", "a cycle is not reached from near the equilibrium: fs1 = 7.8", sp.Integer(0)
)
def _(claim):
    return vibrates(0.2, 0.3, 7.8, start=(-0.7, 2.0, 0.2, 0.0)) - claim


@PART.verified(
    "Section IV, 1)",
    "more damping can cause a cycle: fs1 = 5, s2 = .3 and 1.3, s1 = .2",
    sp.Integer(0),
    sp.Integer(1),
    note="the threshold on fs1 falls from 7.74 to 3.88",
)
def _(*claim):
    return [vibrates(0.2, d, 5.0) - c for d, c in zip((0.3, 1.3), claim, strict=True)]
