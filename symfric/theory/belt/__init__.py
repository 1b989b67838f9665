"""Closed forms for one mass on a moving belt with the cubic law, Thomsen; each takes `sf.scenes.mass_on_belt`.

Every function returns a float for a scene, or the formula in `SYMBOLS` with ``symbolic=True``.
"""

from typing import TYPE_CHECKING

from symfric.model.public_names import names_of
from symfric.theory.belt.effective import (
    effective_cubic,
    effective_damping,
    effective_friction,
    effective_slope,
    law_coefficients,
    least_damping_intensity,
    quasi_equilibrium_position,
)
from symfric.theory.belt.excited import excited_amplitude, excited_growth
from symfric.theory.belt.quench import (
    energy_ratio,
    mean_power,
    quench_intensity,
    quench_intensity_at,
    quench_intensity_below,
    quench_intensity_for,
    unstable_speeds,
)
from symfric.theory.belt.scene import SYMBOLS
from symfric.theory.belt.sliding import (
    damping_polynomial,
    damping_slope,
    equilibrium_position,
    friction_difference,
    onset_speed,
)
from symfric.theory.belt.slip import (
    largest_pure_slip_amplitude,
    pure_slip_amplitude,
    pure_slip_frequency,
    release_position,
    slip_arc,
    slow_belt_amplitude,
    stick_slip_amplitude,
    stick_slip_frequency,
    stick_speed,
)

__all__ = [
    "SYMBOLS",
    "damping_polynomial",
    "damping_slope",
    "effective_cubic",
    "effective_damping",
    "effective_friction",
    "effective_slope",
    "energy_ratio",
    "equilibrium_position",
    "excited_amplitude",
    "excited_growth",
    "friction_difference",
    "largest_pure_slip_amplitude",
    "law_coefficients",
    "least_damping_intensity",
    "mean_power",
    "onset_speed",
    "pure_slip_amplitude",
    "pure_slip_frequency",
    "quasi_equilibrium_position",
    "quench_intensity",
    "quench_intensity_at",
    "quench_intensity_below",
    "quench_intensity_for",
    "release_position",
    "slip_arc",
    "slow_belt_amplitude",
    "stick_slip_amplitude",
    "stick_slip_frequency",
    "stick_speed",
    "unstable_speeds",
]

if not TYPE_CHECKING:
    __dir__, __getattr__ = names_of(__name__)
