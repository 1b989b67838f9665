"""Verification of a design: the one place where its status is decided.

A design is "optimal" (or an "infimum") only if two things were computed: the requirement holds on the full model, and
the designs beside it are worse or violate a condition. Whatever fails is said in words.
"""

from collections.abc import Sequence
from dataclasses import asdict, dataclass

from symfric.design.result import Checked, Curve, Design
from symfric.model.scene import Scene

BETTER = 1e-7  # of the objective: gain below which a neighbour is no better
UNVERIFIED, BEST_FOUND = "unverified", "best found"


@dataclass(frozen=True)
class Neighbour:
    """A design beside an optimum.

    Attributes
    ----------
    change : str
        How it differs, such as "beta smaller by 1 %".
    objective : float
        NaN where it has none.
    violation : float
        By how much the conditions are violated at the most, relative to each; not positive where all hold.
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
    """Return the status of a design and the doubts that it rests on.

    Parameters
    ----------
    claim : {"optimal", "infimum", "best found"}
        What the search says of itself.
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
    """Return a design with the status that its verification allows; see `judged` and `symfric.design.Design`."""
    status, doubts = judged(claim, check, neighbours, objective, sense)
    beside = tuple(asdict(n) for n in neighbours)
    return Design(values, objective, tuple(active), scene, check, status, curve, corrected, doubts, beside)
