"""A scene with its equations in CasADi, shared by all routes."""

from collections.abc import Callable
from functools import cached_property
from typing import Any, TypeVar

from symfric.lower.automaton import Automaton, automaton_of
from symfric.lower.contact_dynamics import ContactDynamics
from symfric.model.constant_parameters import constants
from symfric.model.scene import Scene
from symfric.solve.observables import Wanted, wanted_of

T = TypeVar("T")


class LoweredScene:
    """The equations of a scene; each form is derived at its first use.

    Parameters
    ----------
    scene : Scene
    varied : frozenset of str
        Parameters that will change although their values could be built into the equations.
    """

    def __init__(self, scene: Scene, varied: frozenset[str] = frozenset()):
        self.scene, self.varied = scene, varied
        self._forms: dict[Callable, Any] = {}

    @cached_property
    def wanted(self) -> Wanted:
        """The observables of the scene."""
        return wanted_of(self.scene)

    @property
    def dynamics(self) -> ContactDynamics:
        """The equations of motion, a copy that the caller may extend."""
        return self._dynamics.copy()

    @cached_property
    def _dynamics(self) -> ContactDynamics:
        return ContactDynamics.of(self.scene, constants(self.scene, self.varied))

    @cached_property
    def automaton(self) -> Automaton:
        """The hybrid automaton with the observables."""
        return automaton_of(self.dynamics, [r.expr for r in self.wanted.rows])

    def once(self, form: Callable[["LoweredScene"], T]) -> T:
        """Return the value of a function of this object, cached after its first call."""
        if form not in self._forms:
            self._forms[form] = form(self)
        return self._forms[form]

    @cached_property
    def built_in(self) -> dict[str, float]:
        """The parameters that are built into the equations as numbers."""
        return {s.name: float(v) for s, v in constants(self.scene, self.varied).items()}
