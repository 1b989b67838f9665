"""The table ``[design.controller]`` of a scene file."""

from dataclasses import dataclass
from typing import Annotated, ClassVar, Self

from pydantic import Field

from symfric.design.controller.design import controller
from symfric.design.plan import DesignPlan, Span, TableReader
from symfric.design.wording import Wording
from symfric.fields import MAX_TABLES, Number, Positive, Text

_Numbers = Annotated[tuple[Number, ...], Field(min_length=1, max_length=MAX_TABLES)]


@dataclass(frozen=True)
class ControllerPlan(DesignPlan):
    """Keys of ``[design.controller]``.

    Attributes
    ----------
    parameter
        Name of the gain, sampling period or dead time in ``[values]``, which is to be as large as possible.
    bounds
        Its bounds.
    periods
        Sampling periods at each of which the motion must come to rest; that of the file unless given.
    half_range
        By which the first coordinate may still move; 0 for rest.
    period
        Name of the sampling period.
    settle
        Time by which the motion must have come to rest; half of the horizon unless given.
    starts
        Start values of states from which motions begin; those of the file, and parts of them, unless given.
    """

    kind: ClassVar[str] = "controller"
    function = staticmethod(controller)
    heading: ClassVar[str] = "The largest gain without hunting"

    parameter: Text
    bounds: Span
    periods: Span | None = None
    half_range: Number = 0.0
    period: Text | None = None
    settle: Positive | None = None
    starts: dict[str, _Numbers] | None = None

    @property
    def varied(self) -> tuple[str, ...]:
        return (self.parameter,)

    def read(self, reader: TableReader) -> Self:
        """Raise unless the scene has what is named."""
        reader.parameters("parameter", [self.parameter])
        reader.parameters("period", [self.period])
        reader.states("starts", self.starts or ())
        return self

    def question(self, wording: Wording) -> str:
        most = f"a half range of at most {wording.number(self.half_range, wording.coordinate)} is left"
        until = "" if self.settle is None else f" by t = {wording.number(self.settle, 't')}"
        purpose = most if self.half_range else "the motion comes to rest"
        period = self.period or "T"
        over = "" if self.periods is None else f" for {period} from {wording.interval(self.periods, period)}"
        bounds = wording.interval(self.bounds, self.parameter)
        return f"the largest {self.parameter} from {bounds} with which {purpose}{until}{over}"

    def objective(self, wording: Wording) -> tuple[str, str]:
        return f"largest {self.parameter}", wording.units.get(self.parameter, "")
