"""The route `integrators`: CasADi's integrators, an independent check of the other routes.

The law with its jump runs through `erk` or `rosenbrock`, mode by mode up to the first guard that falls (`pieces`); the
next mode is decided by the forces (`next_mode`). Continuous laws may also run through `cvodes`, `idas` and
`collocation`, with the signs of kinks evaluated instead of held.
"""

import math
from dataclasses import dataclass, replace
from typing import ClassVar

from symfric.errors import SceneError
from symfric.model.arguments import is_one_of, whole
from symfric.model.symbols import positive, shortened
from symfric.solve.integrators.mode_functions import CONTINUOUS, ONE_STEP
from symfric.solve.integrators.program import IntegratorsProgram
from symfric.solve.integrators.refusals import declines
from symfric.solve.integrators.stiffness import MANY, explicit_steps, pays
from symfric.solve.integrators.variational_program import VariationalProgram
from symfric.solve.lowered import LoweredScene
from symfric.solve.protocol import Route
from symfric.spelling import spelt


@spelt
@dataclass(frozen=True)
class Integrators(Route):
    """Settings of the route `integrators`.

    Attributes
    ----------
    plugin : str, optional
        "erk" or "rosenbrock" for any scene; "cvodes", "idas" or "collocation" for scenes without sticking. If
        None, "cvodes" for stiff laws with memory, otherwise "erk".
    max_step : float
        Longest step of the adaptive plugins.
    elements : int
        Most equal steps of "collocation". It has no error control, so their number is doubled until the result stays.
    max_events, max_steps : int
        Budgets of a run; it takes some 20 000 steps in a second.

    Examples
    --------
    >>> import symfric as sf
    >>> oscillator = sf.scenes.coulomb_oscillator(0.1)
    >>> run = sf.simulate(oscillator.wanting({'end': sf.End()}), route=sf.Integrators())
    >>> run.route
    'integrators'
    """

    name: ClassVar[str] = "integrators"
    plugin: str | None = None
    max_step: float = math.inf
    elements: int = 256_000
    max_events: int = 50_000
    max_steps: int = 2_000_000

    def __post_init__(self) -> None:
        if self.plugin is not None and not is_one_of(self.plugin, ONE_STEP + CONTINUOUS):
            raise SceneError(f"no integrator {shortened(self.plugin)}; there are {', '.join(ONE_STEP + CONTINUOUS)}")
        if not is_one_of(self.max_step, (math.inf,)):
            positive(self.max_step, "max_step")
        for name in ("elements", "max_events", "max_steps"):
            whole(getattr(self, name), name)

    def declines(self, scene: LoweredScene) -> str:
        if scene.directions and self.plugin not in (None, "cvodes"):
            return f"{self.plugin} computes no derivatives, cvodes does"
        refusal = declines(scene.automaton, self._resolved(scene).plugin, scene.scene, bool(scene.directions))
        return refusal or ("computes no second derivatives" if scene.directions and scene.order > 1 else "")

    def _merits(self, scene: LoweredScene) -> tuple[bool, str]:
        if scene.directions:
            return pays(scene), "derivatives with the motion, by cvodes, for stiff laws with memory"
        steps = explicit_steps(scene)
        if steps > MANY:
            return True, f"a law with memory is stiff: explicit steps would be about {steps:.1g}; by cvodes, implicit"
        return False, "by one to three orders of magnitude; kept as an independent check"

    def _resolved(self, scene: LoweredScene) -> "Integrators":
        """Return the settings with the plugin for a scene."""
        if self.plugin:
            return self
        implicit = bool(scene.directions) or explicit_steps(scene) > MANY
        return replace(self, plugin="cvodes" if implicit else "erk")

    def build(self, scene: LoweredScene, tolerance: float) -> IntegratorsProgram | VariationalProgram:
        program = VariationalProgram if scene.directions else IntegratorsProgram
        return program(scene, tolerance, self._resolved(scene))
