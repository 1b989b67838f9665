"""The table ``[design.contact_damper]`` of a scene file."""

from dataclasses import dataclass
from typing import ClassVar, Self

from symfric.design.contact_damper.design import contact_damper
from symfric.design.plan import DesignPlan, Spans, TableReader
from symfric.design.wording import Wording
from symfric.fields import Number, Positive


@dataclass(frozen=True)
class ContactDamperPlan(DesignPlan):
    """Keys of ``[design.contact_damper]``.

    Attributes
    ----------
    bounds
        Bounds of each number that is varied.
    residual
        Largest distance from the middle at which the rod may stay.
    margin
        Share by which the last turning point lies within the stick limit, 0 to 1.
    """

    kind: ClassVar[str] = "contact_damper"
    function = staticmethod(contact_damper)
    heading: ClassVar[str] = "The soonest rest by a contact"
    models: ClassVar[tuple[str, ...]] = ("contact_damper",)

    bounds: Spans
    residual: Positive | None = None
    margin: Number = 0.0

    @property
    def varied(self) -> tuple[str, ...]:
        return tuple(self.bounds)

    def read(self, reader: TableReader) -> Self:
        """Raise unless the scene has what is varied."""
        reader.parameters("bounds", self.bounds)
        return self

    def question(self, wording: Wording) -> str:
        words = f"{wording.bounds(self.bounds)} for the soonest rest"
        words += "" if self.residual is None else f", within {self.residual:g} of the middle"
        return words + (f", by {100 * self.margin:g} % within the stick limit" if self.margin else "")

    def objective(self, wording: Wording) -> tuple[str, str]:
        return "time of rest", "s"
