"""Verdicts that were revised, each with the row of the ledger that decides now, and why."""

from dataclasses import dataclass

from derivations.sources import ledger_of

NONE = "none"  # the statement was not judged


@dataclass(frozen=True)
class Revision:
    """A statement of a source, or about it, whose verdict changed.

    Attributes
    ----------
    source, equation : str
        Row of the ledger that decides now.
    statement : str
    before : str
        What was said of it.
    why : str
    """

    source: str
    equation: str
    statement: str
    before: str
    why: str

    @property
    def now(self) -> str:
        """Verdict of the row."""
        return str(next(e.verdict for e in ledger_of(self.source).entries if e.equation == self.equation))


_REGIONS = "friction falls with the speed in regions 1 and 2"
REVISED = (
    Revision(
        "handbook",
        "(19.106) regions 1 and 2, b = 0",
        _REGIONS,
        "corrected, whatever b",
        "without viscous damping it falls at every speed",
    ),
    Revision(
        "handbook",
        "(19.106) region 1, b > 0",
        _REGIONS,
        "true in the figure 19.15",
        "with f_d = .8, v_c = .3, b = .35 the slope is +.35 at rest and positive up to v = .01986",
    ),
    Revision(
        "handbook",
        "(19.107) regions 1 and 2, b = 0",
        _REGIONS,
        "corrected, whatever b",
        "without viscous damping it falls at every speed",
    ),
    Revision(
        "rolling_isolation",
        "Section 5.1 underestimate",
        "the underestimated ratio is just the model scale",
        "false in figure 7",
        "it is said of gravity, and holds for it: 1/L",
    ),
    Revision(
        "rolling_isolation",
        "Section 3.1 fixed steps",
        "figures 4 and 6: what RR lacks of 1 comes from the fixed step",
        "true",
        "the step scales along: with exact factors RR is 1 to rounding; the printed digits of them leave up to 3e-3",
    ),
    Revision(
        "rolling_isolation",
        "after Table 2 second condition",
        "condition on a_e and C (v_e - v_s)/m for coming to rest",
        "corrected",
        "its error C mu g dt/m vanishes with the step",
    ),
    Revision(
        "rolling_isolation",
        "Section 5.1 RVRR, DRR",
        "RVRR rises with PGA, the relative DRR tends to 1",
        NONE,
        "the records are not named; not so with those at hand",
    ),
    Revision(
        "rolling_isolation",
        "Section 6.1 close to 1",
        "at 1:10 all ratios are always close to 1",
        NONE,
        "the records are not named; with those at hand so for the acceleration only",
    ),
    Revision(
        "guida",
        "Section IV, slope mu2",
        "stable if the slope of the second section is above 1",
        "corrected",
        "true if the slope is mu2, the ordinate of the figures: no threshold from 1 on",
    ),
    Revision(
        "guida",
        "Section IV, slope",
        "stable if the slope of the second section is above 1",
        "corrected",
        "still false if the slope is the tangent of the drawn line, 2 mu2: both readings are given",
    ),
    Revision(
        "guida",
        "(27)",
        "bound on -mu, of which two denominators are lost",
        "corrected, as if they were printed",
        "that both are r is an assumption, and is said to be one",
    ),
    Revision(
        "guida",
        "after (20), mu1, fixed speed",
        "the error rises as mu1 falls",
        "corrected, at fixed speed",
        "the source reads it off its figures, which are at fixed lambda, where it is true; at fixed speed it is beyond "
        "the source",
    ),
    Revision(
        "guida",
        "after (27) zero speed",
        "with the support at rest the slides come to rest in a finite time",
        NONE,
        "their relative motion does; the common one decays exponentially",
    ),
    Revision(
        "younes_ashour",
        "Figure 10 linear",
        "the decay time of the steel rod varies linearly with the energy",
        "false in the model",
        "a statement about measured records, which no model can refute",
    ),
    Revision(
        "thomsen",
        "(6)",
        "regularised friction",
        "taken for that of `Law.regularised`",
        "(6) has its minimum at v_m, the other one at v_m + v_s: it is `symfric.laws.thomsen_regularised`",
    ),
    Revision(
        "thomsen",
        "2.3 v_s",
        "no difference in results for v_s <= 1e-4",
        NONE,
        "the largest displacement changes by 8.7e-5, in the fourth digit",
    ),
    Revision(
        "thomsen",
        "after figure 6, eta near 1",
        "the agreement remains quite good for eta near 1",
        NONE,
        "(20) is off by .4 % near the onset, and by 9.3 % towards sticking",
    ),
)


def revised() -> list[tuple[str, ...]]:
    """Return the table: source, equation, statement, before, now, why."""
    return [(r.source, r.equation, r.statement, r.before, r.now, r.why) for r in REVISED]
