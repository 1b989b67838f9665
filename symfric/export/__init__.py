"""Scenes for other programs: steps of fixed length, C code for hardware in the loop, units for co-simulation."""

from typing import TYPE_CHECKING

from symfric.export.c_code import Exported, write_c
from symfric.export.fmu import write_fmu
from symfric.export.stepper import Stepper, stepper
from symfric.model.public_names import names_of

__all__ = ["Exported", "Stepper", "stepper", "write_c", "write_fmu"]

if not TYPE_CHECKING:
    __dir__, __getattr__ = names_of(__name__)
