"""Ready scenes of the sources; symbols carry the argument's name, so ``scene.where({"v_b": .3})`` works."""

from typing import TYPE_CHECKING

from symfric.model.public_names import names_of
from symfric.model.scenes.absorber import absorber
from symfric.model.scenes.belt import mass_on_belt, wavy_belt
from symfric.model.scenes.damper import contact_damper
from symfric.model.scenes.foundation import sprung_foundation
from symfric.model.scenes.impacts import (
    brake_pad,
    cam_follower,
    impact_oscillator,
    mass_with_stops,
    vibratory_conveyor,
)
from symfric.model.scenes.isolator import rolling_isolator
from symfric.model.scenes.oscillators import coulomb_oscillator
from symfric.model.scenes.plane import block_on_incline, friction_pendulum
from symfric.model.scenes.rocking import rocking_block
from symfric.model.scenes.slides import drive_slide, drive_stop, two_slides
from symfric.model.scenes.stage import positioning_stage

__all__ = [
    "absorber",
    "block_on_incline",
    "brake_pad",
    "cam_follower",
    "contact_damper",
    "coulomb_oscillator",
    "drive_slide",
    "drive_stop",
    "friction_pendulum",
    "impact_oscillator",
    "mass_on_belt",
    "mass_with_stops",
    "positioning_stage",
    "rocking_block",
    "rolling_isolator",
    "sprung_foundation",
    "two_slides",
    "vibratory_conveyor",
    "wavy_belt",
]

if not TYPE_CHECKING:
    __dir__, __getattr__ = names_of(__name__)
