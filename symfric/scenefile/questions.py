"""The tables of ``[design]``: the arguments of the functions in ``sf.design`` as data."""

from typing import Annotated, Literal

from pydantic import BeforeValidator, ConfigDict, Field

from symfric.scenefile.fields import MAX_TABLES, Number, Option, Positive, Range, Section, Text

MAX_MOTIONS = 50
Ranges = Annotated[dict[str, Range], Field(min_length=1, max_length=MAX_TABLES)]


def _path_as_table(value):
    """Convert the path of a record to a table."""
    return {"file": value} if isinstance(value, str) else value


class MotionTable(Section):
    """A ground motion: the path of a record, or ``kind`` with the arguments of a function in ``sf.motions``."""

    model_config = ConfigDict(extra="allow", frozen=True)
    __pydantic_extra__: dict[str, Option]

    file: Text | None = None
    kind: Literal["synthetic", "sine_burst"] | None = None


Ground = Annotated[MotionTable, BeforeValidator(_path_as_table)]


class QuenchLimits(Section):
    """Keys of ``[design.quench.limits]``."""

    friction: Positive | None = None
    acceleration: Positive | None = None
    power: Positive | None = None


class Quench(Section):
    """Keys of ``[design.quench]``."""

    speeds: Range
    Omega: Range
    a: Range
    minimise: Literal["intensity", "power", "force"] = "intensity"
    margin: Number = 0.0
    limits: QuenchLimits | None = None


class DamperTable(Section):
    """Keys of ``[design.damper]``."""

    parameter: Text
    bounds: Range
    speeds: Range | None = None
    half_range: Number = 0.0
    sticking: Annotated[bool, Field(strict=True)] = True
    speed: Text | None = None
    settle: Positive | None = None


class Positioning(Section):
    """Keys of ``[design.positioning]``."""

    parameter: Literal["sigma", "mu1", "mu2", "epsilon", "ramp"]
    bounds: Range
    speeds: Range


class Absorber(Section):
    """Keys of ``[design.absorber]``; the mass ratio may stand in ``[values]`` of the ready scene."""

    mass_ratio: Positive | None = None
    criterion: Literal["hinf", "h2", "decay", "self-excited"] = "hinf"
    contact: Literal["absorber", "main"] | None = None
    friction: Number = 0.0
    static_friction: Number | None = None
    band: Range | None = None


class ContactDamper(Section):
    """Keys of ``[design.contact_damper]``."""

    bounds: Ranges
    residual: Positive | None = None
    margin: Number = 0.0


class IsolatorLimits(Section):
    """Keys of ``[design.isolator.limits]``."""

    acceleration: Positive | None = None
    velocity: Positive | None = None
    displacement: Positive | None = None
    residual: Positive | None = None


class Isolator(Section):
    """Keys of ``[design.isolator]``."""

    motions: Annotated[list[Ground], Field(min_length=1, max_length=MAX_MOTIONS)]
    bounds: Ranges
    limits: IsolatorLimits | None = None
    minimise: Literal["acceleration", "velocity", "displacement", "residual"] = "acceleration"
    over: Literal["worst", "mean"] = "worst"


class Designs(Section):
    """``[design]``: one table for each design, named like the function in ``sf.design``."""

    quench: Quench | None = None
    damper: DamperTable | None = None
    positioning: Positioning | None = None
    absorber: Absorber | None = None
    isolator: Isolator | None = None
    contact_damper: ContactDamper | None = None
