"""Optimal design of excitations, dampers, isolators and controls, each verified on the event-driven model."""

from typing import TYPE_CHECKING

from symfric.design.absorber.classic import absorber
from symfric.design.absorber.foundation import sprung_foundation
from symfric.design.contact_damper.design import contact_damper
from symfric.design.controller.design import controller
from symfric.design.damper.design import damper
from symfric.design.isolator.design import isolator
from symfric.design.optimal_control.collocation import Profile, collocation
from symfric.design.positioning.design import positioning
from symfric.design.quench.design import quench
from symfric.design.result import Curve, Design
from symfric.model.public_names import names_of

__all__ = [
    "Curve",
    "Design",
    "Profile",
    "absorber",
    "collocation",
    "contact_damper",
    "controller",
    "damper",
    "isolator",
    "positioning",
    "quench",
    "sprung_foundation",
]

if not TYPE_CHECKING:
    __dir__, __getattr__ = names_of(__name__)
