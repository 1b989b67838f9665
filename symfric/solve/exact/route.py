"""The route `exact`: closed forms for scenes that are linear between events."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from types import MappingProxyType
from typing import ClassVar

from symfric.codegen.functions import compile_functions
from symfric.codegen.loop_loader import load_loop
from symfric.errors import NoRoute, SceneError
from symfric.lower.linear_modes import Oscillator
from symfric.model.scene import Scene
from symfric.solve.exact.classify import Form, ModalForm, form_of
from symfric.solve.exact.oscillator.workspace import LEFT, SHARED, make_arrays
from symfric.solve.exact.record.observables import Recorded
from symfric.solve.exact.record.program import record_model
from symfric.solve.loop.compiled_model import CompiledModel
from symfric.solve.loop.model import series_model
from symfric.solve.loop.run_arrays import limit
from symfric.solve.loop.stepping.linear_series import linear_series
from symfric.solve.lowered import LoweredScene
from symfric.solve.observables import wanted_of
from symfric.solve.program import Compiled, Numbers, check_tolerance
from symfric.solve.protocol import Answer, Program, Route

ORDER = 28  # highest power of a matrix
ROUNDED = 1e-16  # truncation error of a step by powers, relative to the variation of a state


@dataclass(frozen=True)
class Exact:
    """Settings of the route `exact`.

    Attributes
    ----------
    max_steps, max_events : int
        Budgets; a run that needs more ends with a status.
    general : Route, optional
        Route for parameter values, zero when compiled, with which the scene is no longer linear between events; without
        it these raise `NoRoute`.

    Examples
    --------
    >>> import symfric as sf
    >>> oscillator = sf.scenes.coulomb_oscillator(0.1)
    >>> run = sf.simulate(oscillator, route=sf.Exact())
    >>> run.route
    'exact'
    """

    name: ClassVar[str] = "exact"
    max_steps: int = 100_000_000
    max_events: int = 20_000_000
    general: Route | None = field(default=None, repr=False, compare=False)

    def __post_init__(self):
        if self.max_steps < 1 or self.max_events < 1:
            raise SceneError("the budgets max_steps and max_events must be positive")

    def answer(self, scene: LoweredScene) -> Answer:
        """Return whether this route takes a scene: if it is linear between events.

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
        >>> sf.Exact().answer(lowered).takes
        True
        """
        try:
            form = scene.once(form_of)
        except NoRoute as reason:
            return Answer(False, False, str(reason))
        return Answer(True, form.cheapest, form.words)

    def build(self, scene: LoweredScene, tolerance: float) -> "ExactProgram":
        """Compile a scene; raise `NoRoute` if it is not linear between events.

        Parameters
        ----------
        scene : LoweredScene
        tolerance : float
            See `sf.prepare`.

        Returns
        -------
        ExactProgram

        Raises
        ------
        NoRoute
            If this route cannot take the scene.

        Examples
        --------
        >>> import symfric as sf
        >>> from symfric.solve.lowered import LoweredScene
        >>> lowered = LoweredScene(sf.scenes.coulomb_oscillator(0.1))
        >>> sf.Exact().build(lowered, 1e-9).run().status.name
        'OK'
        """
        return ExactProgram(scene.scene, tolerance, self, scene.varied, scene)


class ExactProgram(Compiled):
    """A scene compiled to closed forms; `run` repeats it with other numbers, from any thread."""

    _extra: Mapping[str, float] = MappingProxyType({})

    def __init__(
        self,
        scene: Scene,
        tolerance: float,
        settings: Exact,
        varied: frozenset[str] = frozenset(),
        lowered: LoweredScene | None = None,
    ):
        self.scene, self.tolerance, self.settings = scene, check_tolerance(tolerance), settings
        self.varied = varied
        lowered = LoweredScene(scene, varied) if lowered is None else lowered
        self.built_in = lowered.built_in
        self.wider: dict[frozenset[str], Program] = {}
        form = lowered.once(form_of)
        self._model = _model(form, settings, len(scene.system.states))
        self._numbers = Numbers(form.scene, form.parameters, self.built_in)

    def __reduce__(self):
        """Pickle as the arguments of `prepare`."""
        return ExactProgram, (self.scene, self.tolerance, self.settings, self.varied)

    def remade(self, varied: frozenset[str]) -> Program:
        """Return the program with the parameters `varied` free instead of built in; the scene may then be nonlinear."""
        lowered = LoweredScene(self.scene, varied)
        try:
            return self.settings.build(lowered, self.tolerance)
        except NoRoute:
            if self.settings.general is None:
                raise
            return self.settings.general.build(lowered, self.tolerance)


def _model(form: Form, settings: Exact, n_x: int) -> CompiledModel:
    """Compile the loop of a form."""
    budgets = settings.max_steps, settings.max_events
    match form.problem:
        case Oscillator() as problem:
            return _closed_model(form.scene, problem, budgets, n_x)
        case Recorded() as problem:
            return record_model(form.scene, problem, budgets, n_x)
        case ModalForm(automaton, matrices):
            variant, fine = linear_series(matrices, len(automaton.states), ORDER), (ROUNDED, LEFT)
            return series_model(form.scene, automaton, [variant], wanted_of(form.scene), budgets, fine, n_x=n_x)


def _closed_model(scene: Scene, problem: Oscillator, budgets: tuple[int, int], n_x: int) -> CompiledModel:
    """Compile the loop of the closed forms."""
    wanted = wanted_of(scene)
    code = compile_functions([problem.data])
    first = make_arrays(problem, code.addresses["data"])
    first.clock.t_end = scene.horizon
    limit(first.limits, budgets, wanted)
    first.limits.branches, first.limits.sticks, first.limits.rows = problem.branches, problem.sticks, problem.rows
    loop = load_loop("symfric.solve.exact.oscillator.entry", "the closed forms of an oscillator")
    return CompiledModel(loop, code, first, SHARED, wanted, n_x, scene.horizon)
