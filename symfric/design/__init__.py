"""Optimal design of excitation and dampers; every result is checked on the full event-driven model."""

from symfric.design.absorber import absorber
from symfric.design.collocation import Profile, collocation
from symfric.design.contact_damper import contact_damper
from symfric.design.damper import damper
from symfric.design.isolator import isolator
from symfric.design.positioning import positioning
from symfric.design.quench import quench
from symfric.design.result import Curve, Design

__all__ = [
    "Curve",
    "Design",
    "Profile",
    "absorber",
    "collocation",
    "contact_damper",
    "damper",
    "isolator",
    "positioning",
    "quench",
]
