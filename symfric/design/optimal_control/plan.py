"""The table ``[design.collocation]`` of a scene file."""

from dataclasses import dataclass, replace
from typing import Annotated, Any, ClassVar, Literal, Self

from pydantic import Field

from symfric.design.optimal_control.collocation import collocation
from symfric.design.plan import DesignPlan, Numbers, SignedSpans, Span, TableReader
from symfric.design.wording import Wording
from symfric.fields import Text

MAX_ELEMENTS = 100


@dataclass(frozen=True)
class CollocationPlan(DesignPlan):
    """Keys of ``[design.collocation]``.

    Attributes
    ----------
    controls
        Bounds of each value that becomes a function of time.
    end
        State to reach, by names of coordinates and velocities.
    time
        Bounds of the duration; equal ones fix it.
    minimise
        ``time``, or an expression of states and values whose integral is made small.
    elements
        Largest number of pieces of the controls.
    degree
        0 for controls that are constant in a piece, 1 for linear ones.
    """

    kind: ClassVar[str] = "collocation"
    function = staticmethod(collocation)
    heading: ClassVar[str] = "The optimal control"
    caption: ClassVar[str] = "The controls over time."

    controls: SignedSpans
    end: Numbers
    time: Span
    minimise: Text = "time"
    elements: Annotated[int, Field(ge=1, le=MAX_ELEMENTS, strict=True)] = 6
    degree: Literal[0, 1] = 0

    @property
    def varied(self) -> tuple[str, ...]:
        return tuple(self.controls)

    def read(self, reader: TableReader) -> Self:
        """Return the plan with the integrand as an expression."""
        reader.parameters("controls", self.controls)
        reader.states("end", self.end)
        if self.minimise == "time":
            return self
        read: dict[str, Any] = {"minimise": reader.expression(self.minimise, f"{reader.place}.minimise")}
        return replace(self, **read)

    def _end(self, wording: Wording) -> str:
        return " and ".join(f"{name} = {wording.number(value, name)}" for name, value in self.end.items())

    def question(self, wording: Wording) -> str:
        cost = "in the least time" if self.minimise == "time" else f"with the least integral of {self.minimise}"
        return f"{wording.bounds(self.controls)} as functions of time that reach {self._end(wording)} {cost}"

    def told(self, values: str, wording: Wording) -> str:
        return f"{self._end(wording)} at {values}"

    def objective(self, wording: Wording) -> tuple[str, str]:
        if self.minimise == "time":
            return "least time", wording.units.get("t", "")
        return f"integral of {self.minimise}", ""
