"""The route `exact`: closed forms for scenes that are linear between events."""

from dataclasses import dataclass, field
from typing import ClassVar

from symfric.codegen.functions import compile_functions
from symfric.codegen.loop_loader import load_loop
from symfric.errors import NoRoute, SceneError
from symfric.lower.linear_modes import Oscillator
from symfric.lower.sampled_oscillator import Record
from symfric.model.arguments import whole
from symfric.model.symbols import shortened
from symfric.solve.exact.classify import Form, ModalForm, form_of
from symfric.solve.exact.oscillator.workspace import LEFT, SHARED, make_arrays
from symfric.solve.exact.record.program import record_model
from symfric.solve.loop.compiled_model import CompiledModel
from symfric.solve.loop.model import series_model
from symfric.solve.loop.run_arrays import limit
from symfric.solve.loop.stepping.linear_series import linear_series
from symfric.solve.lowered import LoweredScene
from symfric.solve.program import Compiled, Numbers
from symfric.solve.protocol import Program, Route
from symfric.spelling import spelt

ORDER = 28  # highest power of a matrix
ROUNDED = 1e-16  # truncation error of a step by powers, relative to the variation of a state


@spelt
@dataclass(frozen=True)
class Exact(Route):
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

    def __post_init__(self) -> None:
        for name in ("max_steps", "max_events"):
            whole(getattr(self, name), name)
        if self.general is not None and not isinstance(self.general, Route):
            raise SceneError(f"general is {shortened(self.general)}; give the settings of a route, such as sf.Taylor()")

    def declines(self, scene: LoweredScene) -> str:
        if scene.directions:
            return "computes no derivatives"
        try:
            scene.once(form_of)
        except NoRoute as reason:
            return str(reason)
        return ""

    def _merits(self, scene: LoweredScene) -> tuple[bool, str]:
        form = scene.once(form_of)
        return form.cheapest, form.words

    def build(self, scene: LoweredScene, tolerance: float) -> "ExactProgram":
        return ExactProgram(scene, tolerance, self)


class ExactProgram(Compiled):
    """A scene compiled to closed forms; `run` repeats it with other numbers, from any thread."""

    settings: Exact

    def __init__(self, lowered: LoweredScene, tolerance: float, settings: Exact):
        super().__init__(lowered, tolerance, settings)
        form = lowered.once(form_of)
        self._model = _model(form, settings, len(self.scene.system.states))
        self._numbers = Numbers(form.scene, form.parameters, self.built_in)
        self._given = self._numbers.start

    def _rebuilt(self, lowered: LoweredScene) -> Program:
        """Return the program with more parameters free, with which the scene may be nonlinear between events."""
        general = self.settings.general
        if general is not None and self.settings.declines(lowered):
            return general.build(lowered, self.tolerance)
        return self.settings.build(lowered, self.tolerance)


def _model(form: Form, settings: Exact, n_x: int) -> CompiledModel:
    """Compile the loop of a form."""
    budgets = settings.max_steps, settings.max_events
    match form.problem:
        case Oscillator() as problem:
            return _closed_model(form, problem, budgets, n_x)
        case Record() as problem:
            return record_model(form.scene, problem, form.observables, budgets, n_x)
        case ModalForm(automaton, matrices):
            variant, fine = linear_series(matrices, len(automaton.states), ORDER), (ROUNDED, LEFT)
            return series_model(form.scene, automaton, [variant], form.observables, budgets, fine, n_x=n_x)


def _closed_model(form: Form, problem: Oscillator, budgets: tuple[int, int], n_x: int) -> CompiledModel:
    """Compile the loop of the closed forms."""
    code = compile_functions([problem.data])
    first = make_arrays(problem, code.addresses["data"])
    first.clock.t_end = form.scene.horizon
    limit(first.limits, budgets, form.observables)
    first.limits.branches, first.limits.sticks, first.limits.rows = problem.branches, problem.sticks, problem.rows
    loop = load_loop("symfric.solve.exact.oscillator.entry", "the closed forms of an oscillator")
    return CompiledModel(loop, code, first, SHARED, form.observables, n_x, form.scene.horizon)
