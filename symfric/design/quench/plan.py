"""The table ``[design.quench]`` of a scene file."""

from dataclasses import dataclass
from typing import Annotated, ClassVar, Literal, Self

from pydantic import Field

from symfric.design.plan import ClosedForm, Designed, DesignPlan, Span, TableReader, given
from symfric.design.quench.design import quench
from symfric.design.quench.multipliers import MultiplierCheck
from symfric.design.wording import Wording
from symfric.errors import NotFound, SceneError
from symfric.fields import Number, Positive
from symfric.model.scene import Scene
from symfric.theory import belt

OBJECTIVES = {  # words, and the quantity whose unit it has
    "intensity": ("intensity a Ω", "velocity"),
    "power": ("mean power", "power"),
    "force": ("acceleration a Ω²", "acceleration"),
}


@dataclass(frozen=True)
class QuenchLimits:
    """Keys of ``[design.quench.limits]``.

    Attributes
    ----------
    friction
        Least share of the friction that is left as the mean, 0 to 1.
    acceleration
        Largest amplitude of the acceleration, a Omega^2.
    power
        Largest mean power.
    """

    friction: Positive | None = None
    acceleration: Positive | None = None
    power: Positive | None = None


@dataclass(frozen=True)
class QuenchPlan(DesignPlan):
    """Keys of ``[design.quench]``.

    Attributes
    ----------
    speeds
        Belt speeds at which it shall be quiet.
    Omega
        Bounds of the angular frequency of the shaking.
    a
        Bounds of its amplitude.
    minimise
        What is made small.
    margin
        Least damping of the slow motion; 0 is the limit of stability.
    limits
        Further bounds.
    follow
        Whether the intensity follows the measured belt speed, a Omega = k v_b.
    k
        Bounds of that ratio.
    """

    kind: ClassVar[str] = "quench"
    function = staticmethod(quench)
    heading: ClassVar[str] = "Stopping the vibration by a fast excitation"
    excites: ClassVar[bool] = True

    speeds: Span
    Omega: Span
    a: Span
    minimise: Literal["intensity", "power", "force"] = "intensity"
    margin: Number = 0.0
    limits: QuenchLimits | None = None
    follow: Annotated[bool, Field(strict=True)] = False
    k: Span | None = None

    @property
    def varied(self) -> tuple[str, ...]:
        return "a", "Omega"

    def read(self, reader: TableReader) -> Self:
        """Raise unless the scene is excited and the numbers are in their range."""
        if self.margin < 0:
            reader.refuse("margin", f"is {self.margin:g}; it must not be negative")
        if self.k is not None and not self.follow:
            reader.refuse("k", "is the ratio a Omega/v_b; it needs follow = true")
        names = {s.name for s in reader.scene.parameters}
        missing = next((name for name in self.varied if name not in names), None)
        if missing:
            raise SceneError(
                f"{reader.place}: the scene has no value {missing}; it needs an excitation a*Omega**2*sin(Omega*t)"
            )
        return self

    def question(self, wording: Wording) -> str:
        words = f"the smallest {self.minimise} that stops the vibration for speeds from {wording.speeds(self.speeds)}"
        words += ", in proportion to the measured belt speed" if self.follow else ""
        words += f", with a damping of {self.margin:g} left" if self.margin else ""
        return words + wording.limits(given(self.limits))

    def objective(self, wording: Wording) -> tuple[str, str]:
        words, quantity = OBJECTIVES[self.minimise]
        return words + (" at the highest speed" if self.follow else ""), wording.quantities[quantity]

    def told(self, values: str, wording: Wording) -> str:
        return f"{values} keep it quiet for speeds from {wording.speeds(self.speeds)}"

    def axis_unit(self, label: str, wording: Wording) -> str:
        """Return the unit of the damping of the slow motion."""
        return wording.quantities["damping"]

    def working(self, design: Designed) -> tuple[dict[str, float], float]:
        """Return the amplitude, or the ratio, with which the full model was found stable."""
        values, check = dict(design.corrected or design.values), design.check
        name = next(iter(values))
        if not (isinstance(check, MultiplierCheck) and values[name]):
            return values, 0.0
        return {**values, name: values[name] * (1 + check.step)}, check.step

    def excited(self, scene: Scene, design: Designed) -> Scene:
        """Return the scene with the excitation."""
        return design.scene if self.follow else scene.where(design.values)

    def closed_forms(self, scene: Scene, design: Designed) -> list[ClosedForm]:
        """Return the smallest intensity at the worst belt speed; (57) is largest at v_b = a Omega*."""
        if self.minimise != "intensity" or self.margin or self.limits or self.follow:
            return []
        low, high = self.speeds
        try:
            worst = min(max(float(belt.quench_intensity(scene)), low), high)
            formula = float(belt.quench_intensity_at(scene, worst))
        except (SceneError, NotFound):
            return []
        return [ClosedForm("intensity a*Omega that quenches", formula, design.objective, "Thomsen (56)-(58)")]
