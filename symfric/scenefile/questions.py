"""The tables of ``[design]``: the arguments of the functions in ``sf.design`` as data."""

from typing import Annotated, Any, Literal

from pydantic import BeforeValidator, ConfigDict, Field

from symfric.scenefile.fields import MAX_TABLES, Number, Option, Positive, Range, Section, Text

MAX_MOTIONS = 50
Ranges = Annotated[dict[str, Range], Field(min_length=1, max_length=MAX_TABLES)]


def _path_as_table(value: Any) -> Any:
    """Convert the path of a record to a table."""
    return {"file": value} if isinstance(value, str) else value


class MotionTable(Section):
    """A ground motion: the path of a record, or ``kind`` with the arguments of a function in ``sf.motions``.

    Attributes
    ----------
    file
        Path of a record in the format AT2.
    kind
        Maker of an artificial motion; its arguments are further keys.
    """

    model_config = ConfigDict(extra="allow", frozen=True)
    __pydantic_extra__: dict[str, Option]

    file: Text | None = None
    kind: Literal["synthetic", "sine_burst"] | None = None


Ground = Annotated[MotionTable, BeforeValidator(_path_as_table)]


class QuenchLimits(Section):
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


class Quench(Section):
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
    """

    speeds: Range
    Omega: Range
    a: Range
    minimise: Literal["intensity", "power", "force"] = "intensity"
    margin: Number = 0.0
    limits: QuenchLimits | None = None


class DamperTable(Section):
    """Keys of ``[design.damper]``.

    Attributes
    ----------
    parameter
        Name of the damping in ``[values]``.
    bounds
        Its bounds.
    speeds
        Belt speeds at which the vibration is limited; the speed of the file unless given.
    half_range
        Largest half range of the vibration; 0 for none at all.
    sticking
        Whether contacts may stick.
    speed
        Name of the belt speed, if there are several.
    settle
        Time in which the motion must be over, instead of a limit on the vibration.
    """

    parameter: Text
    bounds: Range
    speeds: Range | None = None
    half_range: Number = 0.0
    sticking: Annotated[bool, Field(strict=True)] = True
    speed: Text | None = None
    settle: Positive | None = None


class Positioning(Section):
    """Keys of ``[design.positioning]``.

    Attributes
    ----------
    parameter
        Which number of the drive is varied.
    bounds
        Its bounds.
    speeds
        Feeds at which it must not stick and slip.
    """

    parameter: Literal["sigma", "mu1", "mu2", "epsilon", "ramp"]
    bounds: Range
    speeds: Range


class Absorber(Section):
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

    mass_ratio: Positive | None = None
    criterion: Literal["hinf", "h2", "decay", "self-excited"] = "hinf"
    contact: Literal["absorber", "main"] | None = None
    friction: Number = 0.0
    static_friction: Number | None = None
    band: Range | None = None


class ContactDamper(Section):
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

    bounds: Ranges
    residual: Positive | None = None
    margin: Number = 0.0


class IsolatorLimits(Section):
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


class Isolator(Section):
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

    motions: Annotated[list[Ground], Field(min_length=1, max_length=MAX_MOTIONS)]
    bounds: Ranges
    limits: IsolatorLimits | None = None
    minimise: Literal["acceleration", "velocity", "displacement", "residual"] = "acceleration"
    over: Literal["worst", "mean"] = "worst"


class Designs(Section):
    """``[design]``: one table for each design, named like the function in ``sf.design``.

    Attributes
    ----------
    quench
        Weakest fast shaking that keeps the mass quiet.
    damper
        Least damping.
    positioning
        Least error of position without stick-slip.
    absorber
        Tuned mass damper.
    isolator
        Rolling isolation.
    contact_damper
        Soonest rest.
    """

    quench: Quench | None = None
    damper: DamperTable | None = None
    positioning: Positioning | None = None
    absorber: Absorber | None = None
    isolator: Isolator | None = None
    contact_damper: ContactDamper | None = None
