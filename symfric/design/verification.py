"""Verification of a design, which determines its status.

A design is "optimal" (or an "infimum") only if two conditions were verified by computation: the requirement holds on
the full model, and the neighbouring designs are worse or violate a condition. Failures are reported as text.
"""

from collections.abc import Sequence
from dataclasses import asdict, dataclass

from symfric.design.result import Checked, Curve, Design
from symfric.model.results import Result
from symfric.model.scene import Scene

BETTER = 1e-7  # relative gain of the objective below which a neighbour is not better
UNVERIFIED, BEST_FOUND = "unverified", "best found"


@dataclass(frozen=True)
class Neighbour:
    """A neighbouring design of an optimum.

    Attributes
    ----------
    change : str
        Difference from the optimum, such as "beta smaller by 1 %".
    objective : float
        NaN if it has none.
    violation : float
        Largest relative violation of a condition; not positive if all hold.
    """

    change: str
    objective: float
    violation: float

    def beats(self, objective: float, sense: int) -> bool:
        """Whether this design meets the conditions with a better objective; sense -1 where it is maximised."""
        gain = sense * (objective - self.objective)
        return self.violation <= 0 and gain > BETTER * abs(objective)


def judged(
    claim: str, check: Checked, neighbours: Sequence[Neighbour], objective: float, sense: int = 1
) -> tuple[str, tuple[str, ...]]:
    """Return the status of a design and the reasons for doubt.

    Parameters
    ----------
    claim : {"optimal", "infimum", "best found"}
        Claim of the search.
    check : Checked
    neighbours : sequence of Neighbour
    objective : float
    sense : {1, -1}
        1 where the objective is minimised.

    Returns
    -------
    (str, tuple of str)
        "unverified" where the full model disagrees; "best found" where a neighbour is better or none was computed, or
        where the search says so; else the claim.
    """
    doubts = list(check.disagreements)
    if not check.agrees:
        return UNVERIFIED, tuple(doubts or ["the full model disagrees"])
    if not neighbours:
        doubts.append("no design beside it was computed")
    doubts += [f"{n.change} has the objective {n.objective:.9g}" for n in neighbours if n.beats(objective, sense)]
    return (BEST_FOUND if doubts else claim), tuple(doubts)


@dataclass(frozen=True)
class Interrupted(Result):
    """What stands in the place of a verification that an interrupt prevented."""

    _told = ("agrees", "disagreements")

    @property
    def agrees(self) -> bool:
        """False."""
        return False

    @property
    def disagreements(self) -> tuple[str, ...]:
        """The reason."""
        return ("the design was interrupted; this is the best one until then, and it is not verified",)

    def __str__(self) -> str:
        return self.disagreements[0]


def design(
    values: dict[str, float],
    objective: float,
    active: Sequence[str],
    scene: Scene,
    check: Checked,
    curve: Curve,
    *,
    claim: str,
    neighbours: Sequence[Neighbour],
    sense: int = 1,
    corrected: dict[str, float] | None = None,
) -> Design:
    """Return a design with the status from its verification; see `judged` and `symfric.design.Design`."""
    status, doubts = judged(claim, check, neighbours, objective, sense)
    beside = tuple(asdict(n) for n in neighbours)
    return Design(values, objective, tuple(active), scene, check, status, curve, corrected, doubts, beside)
