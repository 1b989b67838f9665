"""The table ``[design.damper]`` of a scene file."""

import math
from dataclasses import dataclass
from typing import Annotated, ClassVar, Self

from pydantic import Field

from symfric.design.damper.design import DamperCheck, damper
from symfric.design.plan import ClosedForm, Designed, DesignPlan, Span, TableReader
from symfric.design.wording import Wording
from symfric.errors import NotFound, SceneError
from symfric.fields import Number, Positive, Text
from symfric.model.excitation import is_excited
from symfric.model.scene import Scene
from symfric.theory import belt


@dataclass(frozen=True)
class DamperPlan(DesignPlan):
    """Keys of ``[design.damper]``.

    Attributes
    ----------
    parameter
        Name of the damping in ``[values]``; of a forced scene, of the load of a friction damper or the like.
    bounds
        Its bounds.
    speeds
        Belt speeds at which the vibration is limited; the speed of the file unless given. Of a forced scene, the range
        of the frequency of the force.
    half_range
        Largest half range of the vibration; 0 for none at all.
    sticking
        Whether contacts may stick.
    speed
        Name of the belt speed, if there are several; of a forced scene, of the frequency.
    settle
        Time in which the motion must be over, instead of a limit on the vibration.
    coordinate
        State whose peak is made small, of a forced scene; the first unless given.
    """

    kind: ClassVar[str] = "damper"
    function = staticmethod(damper)
    heading: ClassVar[str] = "The smallest damper"

    parameter: Text
    bounds: Span
    speeds: Span | None = None
    half_range: Number = 0.0
    sticking: Annotated[bool, Field(strict=True)] = True
    speed: Text | None = None
    settle: Positive | None = None
    coordinate: Text | None = None

    @property
    def varied(self) -> tuple[str, ...]:
        return (self.parameter,)

    def read(self, reader: TableReader) -> Self:
        """Raise unless the scene has what is named."""
        reader.parameters("parameter", [self.parameter])
        reader.parameters("speed", [self.speed])
        reader.states("coordinate", [self.coordinate])
        return self

    def _forced(self, wording: Wording) -> bool:
        """Whether the peak of a forced response is made small."""
        return self.settle is None and is_excited(wording.scene)

    def _looked_at(self, wording: Wording) -> str:
        return self.coordinate or wording.scene.system.states[0].name

    def _purpose(self, wording: Wording) -> str:
        at = "" if self.speeds is None else f" at speeds from {wording.speeds(self.speeds, self.speed)}"
        most = f"a half range of at most {wording.number(self.half_range, wording.coordinate)}"
        if self.settle is not None:
            words = f"{most} is left" if self.half_range else "the motion is at rest"
            return f"{words} by t = {wording.number(self.settle, 't')}{at}"
        words = f"the vibration has {most}" if self.half_range else "nothing vibrates"
        return words + ("" if self.sticking else ", without sticking") + at

    def question(self, wording: Wording) -> str:
        bounds = wording.interval(self.bounds, self.parameter)
        if self._forced(wording) and self.speeds is not None:
            over = f"{self.speed} from {wording.speeds(self.speeds, self.speed)}"
            return f"{self.parameter} from {bounds} for the smallest peak of {self._looked_at(wording)} over {over}"
        return f"the smallest {self.parameter} from {bounds} with which {self._purpose(wording)}"

    def objective(self, wording: Wording) -> tuple[str, str]:
        if self._forced(wording):
            state = self._looked_at(wording)
            return f"largest half range of {state}", wording.units.get(state, "")
        return f"least {self.parameter}", wording.units.get(self.parameter, "")

    def told(self, values: str, wording: Wording) -> str:
        if self._forced(wording):
            return f"{values} for the smallest peak of {self._looked_at(wording)}"
        return f"with {values} {self._purpose(wording)}"

    def axis_unit(self, label: str, wording: Wording) -> str:
        """Return the unit of what is drawn: of the required damping, of a time, or of a half range."""
        known = next((u for words, u in wording.quantities.items() if label.startswith(words)), "")
        return known or (wording.units.get(self.parameter, "") if label.startswith("required") else "")

    def working(self, design: Designed) -> tuple[dict[str, float], float]:
        """Return the damping with which the full model met the requirement, of a time of rest one rounded up."""
        check, ((name, least),) = design.check, design.values.items()
        if isinstance(check, DamperCheck):
            return {name: check.above.damping}, check.above.damping / least - 1 if least else math.inf
        return {name: least if self.settle is None else _rounded_up(least)}, 0.0

    def closed_forms(self, scene: Scene, design: Designed) -> list[ClosedForm]:
        """Return the onset of vibration under the designed damping, if stability was limiting."""
        if self.parameter != "beta" or not any("stability" in words for words in design.active):
            return []
        try:
            formula = float(belt.onset_speed(design.scene))
        except (SceneError, NotFound):
            return []
        v_b = float(design.scene.parameter_values()[design.scene.parameter("v_b")])
        return [ClosedForm("onset speed with the designed damper", formula, v_b, "Thomsen (19)")]


def _rounded_up(value: float) -> float:
    """Return a number with five digits that is not smaller."""
    unit = 10.0 ** (math.floor(math.log10(abs(value))) - 4) if value else 1.0
    return math.ceil(value / unit) * unit
