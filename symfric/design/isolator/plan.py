"""The table ``[design.isolator]`` of a scene file."""

from dataclasses import dataclass, replace
from typing import Annotated, Any, ClassVar, Literal, Self

from pydantic import Field

from symfric.design.isolator.design import isolator
from symfric.design.plan import DesignPlan, Spans, TableReader, given
from symfric.design.wording import Wording
from symfric.fields import Positive
from symfric.motions.table import Ground

MAX_MOTIONS = 50
UNITS = {"acceleration": "m/s²", "velocity": "m/s"}


@dataclass(frozen=True)
class IsolatorLimits:
    """Keys of ``[design.isolator.limits]``.

    Attributes
    ----------
    acceleration
        Largest peak acceleration.
    velocity
        Largest peak velocity.
    displacement
        Largest peak displacement.
    residual
        Largest displacement left at the end.
    """

    acceleration: Positive | None = None
    velocity: Positive | None = None
    displacement: Positive | None = None
    residual: Positive | None = None


@dataclass(frozen=True)
class IsolatorPlan(DesignPlan):
    """Keys of ``[design.isolator]``.

    Attributes
    ----------
    motions
        Records, or tables of artificial motions.
    bounds
        Bounds of each number that is varied.
    limits
        Bounds of other results.
    minimise
        Which result is made small.
    over
        Whether the worst motion or the mean of all counts.
    """

    kind: ClassVar[str] = "isolator"
    function = staticmethod(isolator)
    heading: ClassVar[str] = "Damping and friction of the isolator"
    model: ClassVar[str | None] = "rolling_isolator"

    motions: Annotated[list[Ground], Field(min_length=1, max_length=MAX_MOTIONS)]
    bounds: Spans
    limits: IsolatorLimits | None = None
    minimise: Literal["acceleration", "velocity", "displacement", "residual"] = "acceleration"
    over: Literal["worst", "mean"] = "worst"

    @property
    def varied(self) -> tuple[str, ...]:
        return tuple(self.bounds)

    def read(self, reader: TableReader) -> Self:
        """Return the plan with motions in the place of their tables."""
        reader.parameters("bounds", self.bounds)
        places = (f"{reader.place}.motions[{i}]" for i in range(len(self.motions)))
        read: dict[str, Any] = {"motions": [*map(reader.motion, self.motions, places)]}
        return replace(self, **read)

    def question(self, wording: Wording) -> str:
        count = len(self.motions)
        over = f"the {self.over} of {count} motions" if count > 1 else "one motion"
        words = f"{wording.bounds(self.bounds)} for the least {self.minimise}, {over}"
        return words + wording.limits(given(self.limits))

    def objective(self, wording: Wording) -> tuple[str, str]:
        return f"{self.over} {self.minimise}", UNITS.get(self.minimise, "m")
