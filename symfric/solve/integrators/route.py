"""The route `integrators`: CasADi's integrators, an independent check of the other routes.

The law with its jump runs through `erk` or `rosenbrock`, mode by mode up to the first guard that falls (`pieces`); the
next mode is decided by the forces (`next_mode`). Continuous laws may also run through `cvodes`, `idas` and
`collocation`, with the signs of kinks evaluated instead of held.
"""

import math
from dataclasses import dataclass, replace
from typing import ClassVar

from symfric.errors import SceneError
from symfric.solve.integrators.mode_functions import CONTINUOUS, ONE_STEP
from symfric.solve.integrators.program import IntegratorsProgram
from symfric.solve.integrators.refusals import declines
from symfric.solve.integrators.stiffness import MANY, explicit_steps
from symfric.solve.lowered import LoweredScene
from symfric.solve.protocol import Answer


@dataclass(frozen=True)
class Integrators:
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

    def __post_init__(self):
        if self.plugin is not None and self.plugin not in ONE_STEP + CONTINUOUS:
            raise SceneError(f"no integrator {self.plugin!r}; there are {', '.join(ONE_STEP + CONTINUOUS)}")
        if not self.max_step > 0:
            raise SceneError(f"max_step is {self.max_step}; it must be positive")
        if min(self.elements, self.max_events, self.max_steps) < 1:
            raise SceneError("elements and the budgets max_events and max_steps must be positive")

    def answer(self, scene: LoweredScene) -> Answer:
        """Return whether the plugin can run a scene; preferred only if a law with memory is stiff.

        Parameters
        ----------
        scene : LoweredScene

        Returns
        -------
        Answer

        Examples
        --------
        >>> import symfric as sf
        >>> from symfric.solve.lowered import LoweredScene
        >>> lowered = LoweredScene(sf.scenes.coulomb_oscillator(0.1))
        >>> sf.Integrators().answer(lowered).takes
        True
        """
        steps = explicit_steps(scene)
        stiff = steps > MANY
        refusal = declines(scene.automaton, self.resolved(stiff).plugin, scene.scene)
        words = "by one to three orders of magnitude; kept as an independent check"
        if stiff:
            words = f"a law with memory is stiff: explicit steps would be about {steps:.1g}; by cvodes, implicit"
        return Answer(not refusal, stiff and not refusal, refusal or words)

    def resolved(self, stiff: bool) -> "Integrators":
        """Return the settings with a plugin, as `answer` and `build` use them.

        Parameters
        ----------
        stiff : bool

        Returns
        -------
        Integrators

        Examples
        --------
        >>> import symfric as sf
        >>> sf.Integrators().resolved(stiff=True).plugin
        'cvodes'
        """
        return self if self.plugin else replace(self, plugin="cvodes" if stiff else "erk")

    def build(self, scene: LoweredScene, tolerance: float) -> "IntegratorsProgram":
        """Compile a scene.

        Parameters
        ----------
        scene : LoweredScene
        tolerance : float
            See `sf.prepare`.

        Returns
        -------
        IntegratorsProgram

        Raises
        ------
        NoRoute
            If this route cannot take the scene.

        Examples
        --------
        >>> import symfric as sf
        >>> from symfric.solve.lowered import LoweredScene
        >>> lowered = LoweredScene(sf.scenes.coulomb_oscillator(0.1))
        >>> sf.Integrators().build(lowered, 1e-9).run().status.name
        'OK'
        """
        settings = self.resolved(explicit_steps(scene) > MANY)
        return IntegratorsProgram(scene.scene, tolerance, settings, scene.varied, scene)
