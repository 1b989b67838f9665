"""What the equations say without running them: equilibrium, stability, Hopf points, averaging, separation."""

from symfric.theory import belt, drive, scaling, transient
from symfric.theory.averaging import average
from symfric.theory.equilibrium import Equilibrium, equilibrium
from symfric.theory.hopf import HopfPoint, hopf
from symfric.theory.separation import separate
from symfric.theory.slow_flow import SlowFlow
from symfric.theory.stability import Stability, stability

__all__ = [
    "Equilibrium",
    "HopfPoint",
    "SlowFlow",
    "Stability",
    "average",
    "belt",
    "drive",
    "equilibrium",
    "hopf",
    "scaling",
    "separate",
    "stability",
    "transient",
]
