"""The table ``[design.isolator]`` of a scene file."""

from dataclasses import dataclass, replace
from typing import Annotated, Any, ClassVar, Literal, Self

from pydantic import Field

from symfric.design.isolator.design import isolator
from symfric.design.plan import DesignPlan, Spans, TableReader, given
from symfric.design.wording import Wording
from symfric.fields import Positive
from symfric.motions.motion import Motion
from symfric.motions.table import GroundOrPair, MotionTable

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
        Records, or tables of artificial motions; for the ready scene friction_pendulum pairs of them, each a list of
        the motions along x and along y.
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
    models: ClassVar[tuple[str, ...]] = ("rolling_isolator", "friction_pendulum")

    motions: Annotated[list[GroundOrPair], Field(min_length=1, max_length=MAX_MOTIONS)]
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
        read: dict[str, Any] = {"motions": [_read(reader, motion, i) for i, motion in enumerate(self.motions)]}
        return replace(self, **read)

    def question(self, wording: Wording) -> str:
        count = len(self.motions)
        one, many = ("pair", "pairs") if isinstance(self.motions[0], tuple) else ("motion", "motions")
        over = f"the {self.over} of {count} {many}" if count > 1 else f"one {one}"
        words = f"{wording.bounds(self.bounds)} for the least {self.minimise}, {over}"
        return words + wording.limits(given(self.limits))

    def objective(self, wording: Wording) -> tuple[str, str]:
        return f"{self.over} {self.minimise}", UNITS.get(self.minimise, "m")


def _read(
    reader: TableReader, motion: MotionTable | tuple[MotionTable, MotionTable], i: int
) -> Motion | tuple[Motion, ...]:
    """Return a motion of the table, or a pair where the ground moves in two directions."""
    key = f"motions[{i}]"
    if isinstance(motion, tuple) != (len(reader.scene.inputs) == 2):
        if isinstance(motion, tuple):
            reader.refuse(key, f"is a pair of motions; {reader.model} moves along a line: give one motion")
        reader.refuse(key, f"is one motion; {reader.model} moves in two directions: write [along x, along y]")
    if not isinstance(motion, tuple):
        return reader.motion(motion, f"{reader.place}.{key}")
    return tuple(reader.motion(part, f"{reader.place}.{key}[{k}]") for k, part in enumerate(motion))
