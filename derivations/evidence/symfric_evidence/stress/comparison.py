"""Base of the comparisons of random structures: prepares one, draws its numbers, and turns failures into verdicts."""

import math
from abc import ABC, abstractmethod
from typing import ClassVar

from symfric.model.scene import Scene
from symfric.solve.exact.route import Exact
from symfric.solve.protocol import Program
from symfric.solve.routes import explain, prepare
from symfric.solve.taylor.route import Taylor
from symfric_evidence.stress.families import family
from symfric_evidence.stress.random_scenes import Draw
from symfric_evidence.stress.verdict import Verdict

STEPS, EVENTS = 20_000, 5_000  # budgets of a run, about a second of computing
BUDGETS = Taylor(max_steps=STEPS, max_events=EVENTS)


class Comparison(ABC):
    """One structure of a family, with what is compared of its runs.

    Parameters
    ----------
    name : str
        Of the family.
    seed : int
        Of the structure.
    """

    route: ClassVar[str] = ""  # of a run that raises, if there is only one
    tolerance: float

    def __init__(self, name: str, seed: int):
        self.family, self.seed = family(name), seed
        self.structure = self.family.build(seed)

    @abstractmethod
    def compared(self, number: int, draw: Draw) -> Verdict:
        """Run one draw and compare."""

    def draw(self, number: int) -> Draw:
        """Return the numbers of one run."""
        return self.family.draw(self.structure, self.seed, number)

    def verdict(self, number: int) -> Verdict:
        """Run one draw and compare; a run that raises is a failure too."""
        draw = self.draw(number)
        try:
            return self.compared(number, draw)
        except Exception as error:  # a failure of the package, since the numbers of a family are valid
            reason = f"{type(error).__name__}: {error}"
            return self.said(number, draw, "silent failure", self.route, "raised", note=reason)

    def said(
        self,
        number: int,
        draw: Draw,
        verdict: str,
        route: str,
        status: str,
        *,
        finer: float = math.nan,
        second: float = math.nan,
        energy: float = math.nan,
        change: float = math.nan,
        note: str = "",
    ) -> Verdict:
        """Return the verdict on one draw."""
        known = self.family.name, f"{self.family.name}/{self.seed}/{number}", draw.kind, verdict, route, status
        return Verdict(*known, self.tolerance, finer, second, energy, change, note)


def chosen(scene: Scene, tolerance: float) -> Program:
    """Prepare the route that `prepare` would choose, within the budgets."""
    settings = Exact if explain(scene).route == "exact" else Taylor
    return prepare(scene, tolerance, settings(max_steps=STEPS, max_events=EVENTS))
