"""Scenes for other programs: steps of fixed length, C code for hardware in the loop, units for co-simulation."""

from symfric.export.c_code import Exported, write_c
from symfric.export.fmu import write_fmu
from symfric.export.stepper import Stepper, stepper
from symfric.model.offering import offer

__all__ = ["Exported", "Stepper", "stepper", "write_c", "write_fmu"]

offer(__name__)
