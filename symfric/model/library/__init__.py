"""Ready scenes of the sources; symbols carry the argument's name, so ``scene.where({"v_b": .3})`` works."""

from symfric.model.library.absorber import absorber
from symfric.model.library.belt import mass_on_belt
from symfric.model.library.damper import contact_damper
from symfric.model.library.isolator import rolling_isolator
from symfric.model.library.oscillators import coulomb_oscillator
from symfric.model.library.slides import drive_slide, drive_stop, two_slides

__all__ = [
    "absorber",
    "contact_damper",
    "coulomb_oscillator",
    "drive_slide",
    "drive_stop",
    "mass_on_belt",
    "rolling_isolator",
    "two_slides",
]
