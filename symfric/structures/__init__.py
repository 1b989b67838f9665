"""Large structures: matrices in, modes, flutter, reduction, and scenes with contacts."""

from typing import TYPE_CHECKING

from symfric.model.public_names import names_of
from symfric.structures.brake import Brake, disc_and_pad
from symfric.structures.complex_modes import ComplexModes
from symfric.structures.contacts import RowContact, RowLoad
from symfric.structures.files import read, write
from symfric.structures.flutter import Flutter, flutter
from symfric.structures.flutter_map import FlutterMap, flutter_map
from symfric.structures.followed_crossings import Critical
from symfric.structures.makers import beam, chain, ziegler
from symfric.structures.onset import LiftOff, Onset, onset
from symfric.structures.real_modes import Modes
from symfric.structures.reduction import ReductionError
from symfric.structures.sliding import sliding
from symfric.structures.structure import Structure

__all__ = [
    "Brake",
    "ComplexModes",
    "Critical",
    "Flutter",
    "FlutterMap",
    "LiftOff",
    "Modes",
    "Onset",
    "ReductionError",
    "RowContact",
    "RowLoad",
    "Structure",
    "beam",
    "chain",
    "disc_and_pad",
    "flutter",
    "flutter_map",
    "onset",
    "read",
    "sliding",
    "write",
    "ziegler",
]

if not TYPE_CHECKING:
    __dir__, __getattr__ = names_of(__name__)
