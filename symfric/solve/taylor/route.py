"""The route `taylor`: settings, and which scenes it takes."""

from dataclasses import dataclass
from typing import ClassVar

from symfric.model.arguments import whole
from symfric.model.symbols import counted
from symfric.solve.integrators.stiffness import MANY, explicit_steps, pays
from symfric.solve.lowered import LoweredScene
from symfric.solve.protocol import Route
from symfric.solve.taylor.derivatives import DerivativesProgram
from symfric.solve.taylor.program import TaylorProgram
from symfric.spelling import spelt


@spelt
@dataclass(frozen=True)
class Taylor(Route):
    """Settings of the route `taylor`: adaptive Taylor series, with events as roots of their polynomials.

    Attributes
    ----------
    order : int or None
        Order of the Taylor series, from the tolerance unless given.
    max_steps, max_events : int
        Budgets; a run that needs more ends with a status.

    Examples
    --------
    >>> import symfric as sf
    >>> oscillator = sf.scenes.coulomb_oscillator(0.1)
    >>> run = sf.simulate(oscillator, route=sf.Taylor())
    >>> run.route
    'taylor'
    """

    name: ClassVar[str] = "taylor"
    order: int | None = None
    max_steps: int = 100_000_000
    max_events: int = 20_000_000

    def __post_init__(self) -> None:
        if self.order is not None:
            whole(self.order, "order", 3, 60)
        for name in ("max_steps", "max_events"):
            whole(getattr(self, name), name)

    def declines(self, scene: LoweredScene) -> str:
        return ""  # it takes every scene, though not every one fast

    def _merits(self, scene: LoweredScene) -> tuple[bool, str]:
        if scene.directions:
            stiff = scene.order == 1 and pays(scene)
            return not stiff, f"derivatives with the motion{', but stiff' if stiff else ''}"
        automaton, stiff = scene.automaton, explicit_steps(scene) > MANY
        contacts, kinks = sum(automaton.sticks), automaton.layout.switches
        opening = len(scene.scene.contacts_that_open)
        contacts += sum(not c.clocks for c in automaton.layout.others) - opening - 2 * len(automaton.planes)
        kind = "piecewise analytic" if contacts or kinks or opening else "smooth"
        sticking = f"{counted(contacts, 'contact')} that can stick, "
        sticking += f"{counted(opening, 'contact')} that can open, " if opening else ""
        sticking += counted(kinks - len(automaton.steps), "kink")
        sticking += f", {counted(len(automaton.steps), 'switch')} at known times" if automaton.steps else ""
        return not stiff, f"{kind} right-hand side, {sticking}{', but stiff' if stiff else ''}"

    def build(self, scene: LoweredScene, tolerance: float) -> TaylorProgram | DerivativesProgram:
        return (DerivativesProgram if scene.directions else TaylorProgram)(scene, tolerance, self)
