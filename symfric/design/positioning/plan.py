"""The table ``[design.positioning]`` of a scene file."""

from dataclasses import dataclass
from typing import ClassVar, Literal

from symfric.design.plan import DesignPlan, SignedSpan, Span
from symfric.design.positioning.design import positioning
from symfric.design.wording import Wording


@dataclass(frozen=True)
class PositioningPlan(DesignPlan):
    """Keys of ``[design.positioning]``.

    Attributes
    ----------
    parameter
        Which number of the drive is varied; ``ramp`` is the time in which the drive stops.
    bounds
        Its bounds.
    speeds
        Feeds at which it must not stick and slip.
    """

    kind: ClassVar[str] = "positioning"
    function = staticmethod(positioning)
    heading: ClassVar[str] = "The least positioning error"
    models: ClassVar[tuple[str, ...]] = ("drive_slide",)

    parameter: Literal["sigma", "mu1", "mu2", "epsilon", "ramp"]
    bounds: SignedSpan
    speeds: Span

    @property
    def varied(self) -> tuple[str, ...]:
        return (self.parameter,)

    def question(self, wording: Wording) -> str:
        return (
            f"{self.parameter} from {wording.interval(self.bounds, self.parameter)} for the least positioning error "
            f"without stick-slip at speeds from {wording.speeds(self.speeds)}"
        )

    def objective(self, wording: Wording) -> tuple[str, str]:
        return "positioning error", "v*/omega_n"
