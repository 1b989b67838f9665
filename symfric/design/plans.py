"""The designs that a scene file can ask for, in the order of the page."""

from symfric.design.absorber.plan import AbsorberPlan, SprungFoundationPlan
from symfric.design.contact_damper.plan import ContactDamperPlan
from symfric.design.controller.plan import ControllerPlan
from symfric.design.damper.plan import DamperPlan
from symfric.design.isolator.plan import IsolatorPlan
from symfric.design.optimal_control.plan import CollocationPlan
from symfric.design.plan import DesignPlan
from symfric.design.positioning.plan import PositioningPlan
from symfric.design.quench.plan import QuenchPlan

PLANS: tuple[type[DesignPlan], ...] = (
    QuenchPlan,
    DamperPlan,
    PositioningPlan,
    AbsorberPlan,
    IsolatorPlan,
    ContactDamperPlan,
    SprungFoundationPlan,
    CollocationPlan,
    ControllerPlan,
)
