"""Large structures: matrices in, modes, flutter, reduction, and scenes with contacts."""

from symfric.structures.complex_modes import ComplexModes
from symfric.structures.files import read, write
from symfric.structures.flutter import Critical, Flutter, FlutterMap, flutter, flutter_map
from symfric.structures.makers import beam, chain, ziegler
from symfric.structures.real_modes import Modes
from symfric.structures.structure import Structure

__all__ = [
    "ComplexModes",
    "Critical",
    "Flutter",
    "FlutterMap",
    "Modes",
    "Structure",
    "beam",
    "chain",
    "flutter",
    "flutter_map",
    "read",
    "write",
    "ziegler",
]
