"""Closed forms of Guida, Nilvetti and Pappalardo for one driven slide and for two slides in contact."""

from typing import TYPE_CHECKING

from symfric.model.public_names import names_of
from symfric.theory.drive.grazing import (
    two_slides_cycle,
    two_slides_onset,
    two_slides_threshold,
    two_slides_thresholds,
)
from symfric.theory.drive.slides import (
    SYMBOLS,
    SlopeLimits,
    damping_matrix,
    definite_condition,
    hurwitz_conditions,
    slope_limits,
)
from symfric.theory.drive.slides_cycle import SlidesCycle
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
    "SlidesCycle",
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
    "two_slides_cycle",
    "two_slides_onset",
    "two_slides_threshold",
    "two_slides_thresholds",
    "type_limit",
]

if not TYPE_CHECKING:
    __dir__, __getattr__ = names_of(__name__)
