"""The tables ``[design.absorber]`` and ``[design.sprung_foundation]`` of a scene file."""

from dataclasses import dataclass, replace
from typing import ClassVar, Literal, Self

from symfric.design.absorber.classic import absorber
from symfric.design.absorber.foundation import sprung_foundation
from symfric.design.plan import DesignPlan, Span, TableReader
from symfric.design.result import Design
from symfric.design.wording import Wording
from symfric.fields import Number, Positive
from symfric.model.scene import Scene

CRITERIA = {
    "hinf": "the least peak of the amplitude",
    "h2": "the least mean square under white noise",
    "decay": "the fastest decay",
    "self-excited": "the most self-excitation that is still stable",
}


@dataclass(frozen=True)
class AbsorberPlan(DesignPlan):
    """Keys of ``[design.absorber]``; the mass ratio may stand in ``[values]`` of the ready scene.

    Attributes
    ----------
    mass_ratio
        Mass of the absorber over the main mass.
    criterion
        What is made best.
    contact
        Where dry friction acts, if anywhere.
    friction
        Kinetic friction of that contact, over the amplitude of the force.
    static_friction
        Its static friction; the kinetic one unless given.
    band
        Frequencies, over that of the main mass, in which the peak counts.
    """

    kind: ClassVar[str] = "absorber"
    heading: ClassVar[str] = "A tuned mass damper"

    mass_ratio: Positive | None = None
    criterion: Literal["hinf", "h2", "decay", "self-excited"] = "hinf"
    contact: Literal["absorber", "main"] | None = None
    friction: Number = 0.0
    static_friction: Number | None = None
    band: Span | None = None

    @property
    def varied(self) -> tuple[str, ...]:
        return "tuning", "damping"

    def read(self, reader: TableReader) -> Self:
        """Return the plan with a mass ratio."""
        return replace(self, mass_ratio=mass_ratio_of(self.mass_ratio, reader, self.kind))

    def __call__(self, scene: Scene) -> Design:
        """Compute the design, which does not depend on the scene."""
        return absorber(**self.arguments)

    def question(self, wording: Wording) -> str:
        words = f"tuning and damping for {CRITERIA[self.criterion]}, with the mass ratio {self.mass_ratio:g}"
        return words + ("" if self.contact is None else f" and dry friction {self.friction:g}")

    def objective(self, wording: Wording) -> tuple[str, str]:
        return CRITERIA[self.criterion].removeprefix("the "), ""


@dataclass(frozen=True)
class SprungFoundationPlan(DesignPlan):
    """Keys of ``[design.sprung_foundation]``; the mass ratio may stand in ``[values]`` of the ready scene.

    Attributes
    ----------
    mass_ratio
        Mass of the foundation over the main mass.
    least_stiffness
        Smallest stiffness of its mount, over that of the main spring.
    """

    kind: ClassVar[str] = "sprung_foundation"
    heading: ClassVar[str] = "The mount of a foundation mass"

    mass_ratio: Positive | None = None
    least_stiffness: Number = 0.0

    @property
    def varied(self) -> tuple[str, ...]:
        return "stiffness", "damping"

    def read(self, reader: TableReader) -> Self:
        """Return the plan with a mass ratio."""
        if self.least_stiffness < 0:
            reader.refuse("least_stiffness", f"is {self.least_stiffness:g}; it must not be negative")
        return replace(self, mass_ratio=mass_ratio_of(self.mass_ratio, reader, self.kind))

    def __call__(self, scene: Scene) -> Design:
        """Compute the design, which does not depend on the scene."""
        return sprung_foundation(**self.arguments)

    def question(self, wording: Wording) -> str:
        words = f"stiffness and damping of the mount for {CRITERIA['self-excited']}, with the mass ratio"
        least = f" and a stiffness of at least {self.least_stiffness:g}" if self.least_stiffness else ""
        return f"{words} {self.mass_ratio:g}{least}"

    def objective(self, wording: Wording) -> tuple[str, str]:
        return CRITERIA["self-excited"].removeprefix("the "), ""


def mass_ratio_of(given: float | None, reader: TableReader, model: str) -> float:
    """Return the mass ratio of a table, or that of the ready scene."""
    if given is not None:
        return given
    if reader.model != model:
        reader.refuse("mass_ratio", "is missing; add it")
    return float(reader.scene.parameter_values()[reader.scene.parameter("mass_ratio")])
