"""One slide drawn by a drive, two slides in friction: closed forms of Guida, Nilvetti and Pappalardo."""

from symfric.theory.drive.slides import (
    SYMBOLS,
    SlopeLimits,
    damping_matrix,
    definite_condition,
    hurwitz_conditions,
    slope_limits,
)
from symfric.theory.drive.stick_slip import threshold
from symfric.theory.drive.stop import (
    PositioningError,
    excess,
    positioning_error,
    single_section_error,
    steep_error,
    type_limit,
)

__all__ = [
    "SYMBOLS",
    "PositioningError",
    "SlopeLimits",
    "damping_matrix",
    "definite_condition",
    "excess",
    "hurwitz_conditions",
    "positioning_error",
    "single_section_error",
    "slope_limits",
    "steep_error",
    "threshold",
    "type_limit",
]
