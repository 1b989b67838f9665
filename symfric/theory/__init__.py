"""What the equations say without running them: equilibrium, stability, Hopf points, averaging, separation."""

from typing import TYPE_CHECKING

from symfric.model.public_names import names_of
from symfric.theory import (
    absorber,
    belt,
    decay_record,
    drive,
    foundation,
    plane,
    presliding,
    scaling,
    transient,
    waviness,
)
from symfric.theory.averaging import average
from symfric.theory.broken_line import TwoLines, two_lines
from symfric.theory.equilibrium import Equilibrium, equilibrium
from symfric.theory.falling import falling_speeds
from symfric.theory.hopf import HopfPoint, hopf
from symfric.theory.hunting import Hunting, hunting
from symfric.theory.hurwitz import symbolic_hurwitz, symbolic_hurwitz_of_matrices
from symfric.theory.root_locus import RootLocus, damper_loop, root_locus
from symfric.theory.separation import separate
from symfric.theory.slow_flow import SlowFlow
from symfric.theory.stability import Stability, stability, stability_of_matrices

__all__ = [
    "Equilibrium",
    "HopfPoint",
    "Hunting",
    "RootLocus",
    "SlowFlow",
    "Stability",
    "TwoLines",
    "absorber",
    "average",
    "belt",
    "damper_loop",
    "decay_record",
    "drive",
    "equilibrium",
    "falling_speeds",
    "foundation",
    "hopf",
    "hunting",
    "plane",
    "presliding",
    "root_locus",
    "scaling",
    "separate",
    "stability",
    "stability_of_matrices",
    "symbolic_hurwitz",
    "symbolic_hurwitz_of_matrices",
    "transient",
    "two_lines",
    "waviness",
]

if not TYPE_CHECKING:
    __dir__, __getattr__ = names_of(__name__)
