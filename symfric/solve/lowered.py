"""A scene with its equations in CasADi, shared by all routes."""

from collections.abc import Callable, Mapping, Sequence
from functools import cached_property
from typing import Any, TypeVar

import sympy as sp

from symfric.errors import SceneError
from symfric.lower.automaton import Automaton, automaton_of
from symfric.lower.contact_dynamics import ContactDynamics
from symfric.model.arguments import is_one_of, items
from symfric.model.constant_parameters import constants
from symfric.model.outputs import Output
from symfric.model.scene import Scene
from symfric.model.symbols import Key, name_of, nearest, shortened
from symfric.solve.observables import Observables
from symfric.solve.observed import observables_of

T = TypeVar("T")


class LoweredScene:
    """The equations of a scene, and by what its motion is differentiated; each form is derived at its first use.

    Parameters
    ----------
    scene : Scene
    varied : frozenset of str
        Parameters that will change although their values could be built into the equations.
    directions : tuple of str
        Parameters, and states for their initial values, to differentiate by; from `directions_of`.
    order : int
        Of the derivatives.

    Attributes
    ----------
    scene, directions, order
        As given.
    varied : frozenset of str
        Those given, and the directions that are parameters.
    """

    def __init__(
        self,
        scene: Scene,
        varied: frozenset[str] = frozenset(),
        directions: tuple[str, ...] = (),
        order: int = 1,
    ):
        self.scene, self.directions, self.order = scene, directions, order
        self.varied = varied | (frozenset(directions) - {s.name for s in scene.system.states})
        self._forms: dict[Callable[[LoweredScene], Any], Any] = {}
        self._automata: dict[tuple[sp.Expr, ...], Automaton] = {}

    def wanting(self, outputs: Mapping[str, Output]) -> "LoweredScene":
        """Return the motion alone with other outputs; the equations are shared unless the parameters are others."""
        other = LoweredScene(self.scene.wanting(outputs), self.varied)
        if other.scene.parameters == self.scene.parameters:
            other._dynamics = self._dynamics
        return other

    @cached_property
    def observables(self) -> Observables:
        """The observables of the scene."""
        return observables_of(self.scene)

    @property
    def dynamics(self) -> ContactDynamics:
        """The equations of motion, a copy that the caller may extend."""
        return self._dynamics.copy()

    @cached_property
    def _dynamics(self) -> ContactDynamics:
        return ContactDynamics.of(self.scene, constants(self.scene, self.varied))

    @property
    def automaton(self) -> Automaton:
        """The hybrid automaton with the observables."""
        return self.automaton_with([r.expr for r in self.observables.rows])

    def automaton_with(self, rows: Sequence[sp.Expr]) -> Automaton:
        """Return the hybrid automaton with these expressions as observables."""
        rows = tuple(rows)
        if rows not in self._automata:
            self._automata[rows] = automaton_of(self.dynamics, rows)
        return self._automata[rows]

    def once(self, form: Callable[["LoweredScene"], T]) -> T:
        """Return the value of a function of this object, cached after its first call."""
        if form not in self._forms:
            self._forms[form] = form(self)
        return self._forms[form]

    @cached_property
    def built_in(self) -> dict[str, float]:
        """The parameters that are built into the equations as numbers."""
        return {s.name: float(v) for s, v in constants(self.scene, self.varied).items()}


def directions_of(scene: Scene, names: Sequence[Key], order: int) -> tuple[str, ...]:
    """Check by what, and how often, to differentiate; return the names.

    Raises
    ------
    SceneError
        If a name is neither a parameter nor a state, or occurs twice, or the order is neither 1 nor 2.
    """
    directions = tuple(name_of(n) for n in items(names, "sensitivities"))
    known = [*(s.name for s in scene.parameters), *(s.name for s in scene.system.states)]
    for name in directions:
        if name not in known:
            raise SceneError(f"{name} is neither a parameter nor a state{nearest(name, known)}")
        if directions.count(name) > 1:
            raise SceneError(f"{name} occurs twice in sensitivities")
    if not is_one_of(order, (1, 2)):
        raise SceneError(f"order is {shortened(order)}; derivatives are of order 1 or 2")
    return directions
