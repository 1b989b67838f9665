"""Sliding in the plane: drag under vibration across and along, spinning discs, balls, blocks on inclines, damping.

Friction opposes a slip vector, so that a motion across the sliding direction turns it, and takes it from the sliding.
Derived in derivations/plane.
"""

from typing import TYPE_CHECKING

from symfric.model.public_names import names_of
from symfric.theory.plane.ball import BallRolls, ball_rolls
from symfric.theory.plane.comparison import VibrationComparison, compare_vibration, equal_drag_ratio
from symfric.theory.plane.damping import steady_power, transverse_damping
from symfric.theory.plane.disc import (
    DiscStop,
    disc_expressions,
    disc_stop,
    disc_stop_ratio,
    spinning_disc_friction,
)
from symfric.theory.plane.incline import InclineState, incline_least_speed, incline_motion, incline_stop
from symfric.theory.plane.quenching import QuenchComparison, compare_quenching
from symfric.theory.plane.vibration import (
    lateral_vibration_drag,
    lateral_vibration_power,
    longitudinal_vibration_drag,
    longitudinal_vibration_power,
)

__all__ = [
    "BallRolls",
    "DiscStop",
    "InclineState",
    "QuenchComparison",
    "VibrationComparison",
    "ball_rolls",
    "compare_quenching",
    "compare_vibration",
    "disc_expressions",
    "disc_stop",
    "disc_stop_ratio",
    "equal_drag_ratio",
    "incline_least_speed",
    "incline_motion",
    "incline_stop",
    "lateral_vibration_drag",
    "lateral_vibration_power",
    "longitudinal_vibration_drag",
    "longitudinal_vibration_power",
    "spinning_disc_friction",
    "steady_power",
    "transverse_damping",
]

if not TYPE_CHECKING:
    __dir__, __getattr__ = names_of(__name__)
