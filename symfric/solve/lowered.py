"""A scene together with its equations in CasADi, which are written once however many routes look at them."""

from functools import cached_property

from symfric.lower.automaton import Automaton, lower
from symfric.lower.constant_parameters import constants
from symfric.model.scene import Scene
from symfric.solve.observables import Wanted, wanted_of


class LoweredScene:
    """The equations of a scene, each form of them made at its first use.

    Parameters
    ----------
    scene : Scene
    varied : frozenset of str
        Parameters that will change although their values could be built into the equations.
    """

    def __init__(self, scene: Scene, varied: frozenset[str] = frozenset()):
        self.scene, self.varied = scene, varied

    @cached_property
    def wanted(self) -> Wanted:
        """The observables of the scene."""
        return wanted_of(self.scene)

    @cached_property
    def automaton(self) -> Automaton:
        """The hybrid automaton with the observables as rows."""
        return lower(self.scene, [r.expr for r in self.wanted.rows], self.varied)

    @cached_property
    def built_in(self) -> dict[str, float]:
        """The parameters that the equations contain as numbers."""
        return {s.name: float(v) for s, v in constants(self.scene, self.varied).items()}
