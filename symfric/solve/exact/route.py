"""The route `exact`: closed forms between events, for scenes that are linear there."""

from collections.abc import Mapping
from dataclasses import dataclass
from types import MappingProxyType

from symfric.codegen.functions import compile_functions
from symfric.codegen.loop_loader import open_door
from symfric.errors import NoRoute, SceneError
from symfric.lower.automaton import constants
from symfric.lower.linear_modes import Oscillator
from symfric.model.scene import Scene
from symfric.solve.exact.classify import Form, Modes, form_of
from symfric.solve.exact.oscillator.workspace import FOLDERS, LEFT, SHARED, make_room
from symfric.solve.exact.record.observables import Recorded
from symfric.solve.exact.record.program import record_model
from symfric.solve.loop.compiled_model import CompiledModel
from symfric.solve.loop.linear_series import linear_series
from symfric.solve.loop.workspace import T_END
from symfric.solve.observables import wanted_of
from symfric.solve.program import Compiled, Numbers, check_tolerance
from symfric.solve.taylor.route import Taylor, TaylorProgram, series_model

ORDER = 28  # of the powers of a matrix
ROUNDED = 1e-16  # of the variation of a state: what the powers leave out of a step


@dataclass(frozen=True)
class Exact:
    """Settings of the route `exact`.

    Attributes
    ----------
    max_steps, max_events : int
        Budgets; a run that needs more ends with a status.
    """

    max_steps: int = 100_000_000
    max_events: int = 20_000_000

    def __post_init__(self):
        if self.max_steps < 1 or self.max_events < 1:
            raise SceneError("the budgets max_steps and max_events must be positive")


class ExactProgram(Compiled):
    """A scene in closed form; `run` repeats it with other numbers, from any thread."""

    route = "exact"
    _extra: Mapping[str, float] = MappingProxyType({})

    def __init__(
        self,
        scene: Scene,
        tolerance: float,
        settings: Exact,
        varied: frozenset[str] = frozenset(),
        form: Form | None = None,
    ):
        self.scene, self.tolerance, self.settings = scene, check_tolerance(tolerance), settings
        self.varied = varied
        self.built_in = {s.name: float(v) for s, v in constants(scene, varied).items()}
        self.wider: dict[frozenset[str], ExactProgram | TaylorProgram] = {}
        form = form_of(scene, varied) if form is None else form
        self._model = _model(form, settings, len(scene.system.states))
        self._numbers = Numbers(form.scene, form.parameters, self.built_in)

    def __reduce__(self):
        """Pickle as what it was prepared from."""
        return ExactProgram, (self.scene, self.tolerance, self.settings, self.varied)

    def remade(self, varied: frozenset[str]) -> "ExactProgram | TaylorProgram":
        """Return the program in which the parameters `varied` may be anything: what they multiply may not be linear."""
        try:
            return ExactProgram(self.scene, self.tolerance, self.settings, varied)
        except NoRoute:
            budgets = Taylor(max_steps=self.settings.max_steps, max_events=self.settings.max_events)
            return TaylorProgram(self.scene, self.tolerance, budgets, varied)


def _model(form: Form, settings: Exact, n_x: int) -> CompiledModel:
    """Compile what a form needs."""
    budgets = settings.max_steps, settings.max_events
    match form.problem:
        case Oscillator() as problem:
            return _closed_model(form.scene, problem, budgets, n_x)
        case Recorded() as problem:
            return record_model(form.scene, problem, budgets, n_x)
        case Modes(automaton, matrices):
            variant, fine = linear_series(matrices, len(automaton.states), ORDER), (ROUNDED, LEFT)
            return series_model(form.scene, automaton, [variant], wanted_of(form.scene), budgets, fine, n_x=n_x)


def _closed_model(scene: Scene, problem: Oscillator, budgets: tuple[int, int], n_x: int) -> CompiledModel:
    """Compile what the closed forms need."""
    wanted = wanted_of(scene)
    code = compile_functions([problem.data])
    first = make_room(problem, code.addresses["data"])
    first.clock[T_END] = scene.horizon
    limits = *budgets, 1_000_000, wanted.path, wanted.events, 1, 0, 0, 0
    first.limits[:] = (*limits, problem.branches, problem.sticks, problem.rows)
    launch = open_door("symfric.solve.exact.oscillator.entry", "the closed forms of an oscillator", *FOLDERS)
    return CompiledModel(launch, code, first, SHARED, wanted, n_x, scene.horizon)
