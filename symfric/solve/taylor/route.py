"""The route `taylor`: settings, and programs compiled from a scene."""

import math
from dataclasses import dataclass
from typing import ClassVar

import casadi as ca

from symfric.errors import SceneError
from symfric.lower.automaton import Automaton
from symfric.model.scene import Scene
from symfric.model.symbols import counted
from symfric.solve.integrators.stiffness import MANY, explicit_steps
from symfric.solve.loop.model import series_model
from symfric.solve.loop.stepping.series import Series
from symfric.solve.lowered import LoweredScene
from symfric.solve.program import Numbers, check_tolerance
from symfric.solve.protocol import Answer
from symfric.solve.taylor.expansion import expand, is_branching, is_long
from symfric.solve.taylor.laned import Laned

MARGIN = 0.2  # tolerance of a step relative to that of the run, so that the error of a run stays below it


@dataclass(frozen=True)
class Taylor:
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

    def __post_init__(self):
        if self.order is not None and not 3 <= self.order <= 60:
            raise SceneError(f"the order of the Taylor series is {self.order}; it must lie between 3 and 60")
        if self.max_steps < 1 or self.max_events < 1:
            raise SceneError("the budgets max_steps and max_events must be positive")

    def answer(self, scene: LoweredScene) -> Answer:
        """Return whether this route takes a scene: it takes every one, though not every one fast.

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
        >>> sf.Taylor().answer(lowered).takes
        True
        """
        automaton = scene.automaton
        contacts, kinks = sum(automaton.sticks) + len(automaton.layout.others), automaton.layout.switches
        kind = "piecewise analytic" if contacts or kinks else "smooth"
        stiff = explicit_steps(scene) > MANY
        sticking = f"{counted(contacts, 'contact')} that can stick, {counted(kinks, 'kink')}"
        return Answer(True, not stiff, f"{kind} right-hand side, {sticking}{', but stiff' if stiff else ''}")

    def build(self, scene: LoweredScene, tolerance: float) -> "TaylorProgram":
        """Compile a scene.

        Parameters
        ----------
        scene : LoweredScene
        tolerance : float
            See `sf.prepare`.

        Returns
        -------
        TaylorProgram

        Examples
        --------
        >>> import symfric as sf
        >>> from symfric.solve.lowered import LoweredScene
        >>> lowered = LoweredScene(sf.scenes.coulomb_oscillator(0.1))
        >>> sf.Taylor().build(lowered, 1e-9).run().status.name
        'OK'
        """
        return TaylorProgram(scene.scene, tolerance, self, scene.varied, scene)


def order_for(tolerance: float, n_states: int, branching: bool = False) -> int:
    """Return the order of least cost.

    Half the logarithm of the tolerance is best for long smooth runs (Jorba and Zou, 2005). Events, whose cost does not
    depend on the length of a step, make more orders pay: by measurement 6 for one mass on a belt, from 1e-6 to 1e-13,
    and 4 for ten, where a step costs more. Twice as many where a root or a logarithm is taken of what moves: near its
    singularity short series can end in ever shorter steps.
    """
    extra = 6 if n_states <= 4 else 4
    return math.ceil(-0.5 * math.log(tolerance)) + (2 * extra if branching else extra)


class TaylorProgram(Laned):
    """A scene compiled for one tolerance; `run` repeats it with other numbers, from any thread."""

    def __init__(
        self,
        scene: Scene,
        tolerance: float,
        settings: Taylor,
        varied: frozenset[str] = frozenset(),
        lowered: LoweredScene | None = None,
    ):
        self.scene, self.tolerance, self.settings = scene, check_tolerance(tolerance), settings
        self.varied = varied
        lowered = LoweredScene(scene, varied) if lowered is None else lowered
        wanted, self.automaton = lowered.wanted, lowered.automaton
        states = len(scene.system.states)
        self.order = order = settings.order or order_for(self.tolerance, states, is_branching(self.automaton.field))
        self._extra = {"order": order}
        sticker = self.automaton.sticks.index(True) if sum(self.automaton.sticks) == 1 else -1
        self._variants = variants_of(self.automaton, order, sticker)
        budgets = settings.max_steps, settings.max_events
        fine = MARGIN * self.tolerance
        self._model = series_model(scene, self.automaton, self._variants, wanted, budgets, (fine, fine))
        self._lane_models = []
        self.wider: dict[frozenset[str], TaylorProgram] = {}
        self.built_in = lowered.built_in
        self._numbers = Numbers(scene, self.automaton.parameters, self.built_in)

    def __reduce__(self):
        """Pickle as the arguments of `prepare`; machine code is compiled or loaded when unpickled."""
        return TaylorProgram, (self.scene, self.tolerance, self.settings, self.varied)

    def remade(self, varied: frozenset[str]) -> "TaylorProgram":
        """Return the program with the parameters `varied` free instead of built in."""
        return TaylorProgram(self.scene, self.tolerance, self.settings, varied)


def variants_of(automaton: Automaton, order: int, sticker: int) -> list[Series]:
    """Return one series for all modes or, if only one contact can stick, one for slip and one for stick.

    Two without conditions are faster than one with the mode as data (by a quarter for one mass on a belt), but their
    number would double with every contact. In a long series conditions take a negligible part of the time.
    """
    if sticker < 0 or is_long(automaton.field, order):
        return [expand(automaton.field, order)]
    return [
        expand(_fixed(automaton.field, sticker, stick), order, name) for stick, name in ((0, "_slip"), (1, "_stick"))
    ]


def _fixed(field: ca.Function, entry: int, number: float) -> ca.Function:
    """Return the field with one entry of the mode fixed."""
    arguments = [ca.SX.sym(name, field.nnz_in(i)) for i, name in enumerate(field.name_in())]
    mode = ca.SX(arguments[3])
    mode[entry] = number
    return ca.Function("field", arguments, list(field(*arguments[:3], mode)))
