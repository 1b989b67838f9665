"""The route `exact`: closed forms between events, for scenes that are linear there."""

from dataclasses import dataclass
from typing import ClassVar

from symfric.errors import NoRoute, SceneError
from symfric.lower.automaton import constants
from symfric.model.scene import Scene
from symfric.solve.compiled import PATH_BYTES, Compiled, Loop, Numbers, check_tolerance
from symfric.solve.door import open_door
from symfric.solve.exact.form import Form, form_of
from symfric.solve.exact.record_program import record_loop
from symfric.solve.exact.room import FOLDERS, LEFT, make_room
from symfric.solve.taylor.jit import MachineCode, compile_functions
from symfric.solve.taylor.linear_series import linear_series
from symfric.solve.taylor.program import Taylor, TaylorProgram, series_loop
from symfric.solve.taylor.workspace import T_END
from symfric.solve.wanted import wanted_of

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
    """A scene in closed form; `run` repeats it with other numbers. Not to be shared between threads."""

    route = "exact"
    _extra: ClassVar[dict[str, float]] = {}

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
        self.general: ExactProgram | TaylorProgram | None = None
        form = form_of(scene, varied) if form is None else form
        build = _closed_loop if form.closed else _record_loop if form.record else _linear_loop
        self._code, self._loop = build(form, settings)
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


def _closed_loop(form: Form, settings: Exact) -> tuple[MachineCode, Loop]:
    """Compile what the closed forms need."""
    problem, wanted = form.closed, wanted_of(form.scene)
    code = compile_functions([problem.data])
    room = make_room(problem, code.addresses["data"])
    room.clock[T_END] = form.scene.horizon
    limits = settings.max_steps, settings.max_events, 1_000_000, wanted.path, wanted.events, 1, 0, 0, 0
    pieces = PATH_BYTES // (2 * room.path_c[0].nbytes)
    room.limits[:] = (*limits, problem.branches, problem.sticks, problem.rows, pieces)
    launch = open_door("symfric.solve.exact.oscillator_loop", "the closed forms of an oscillator", *FOLDERS)
    return code, Loop(launch, room, wanted, form.scene.horizon)


def _record_loop(form: Form, settings: Exact) -> tuple[MachineCode, Loop]:
    """Compile what the march through a record needs."""
    return record_loop(form.scene, form.record, (settings.max_steps, settings.max_events))


def _linear_loop(form: Form, settings: Exact) -> tuple[MachineCode, Loop]:
    """Compile the matrices of every mode."""
    variant = linear_series(form.matrices, len(form.automaton.states), ORDER)
    budgets = settings.max_steps, settings.max_events
    return series_loop(form.scene, form.automaton, [variant], wanted_of(form.scene), budgets, (ROUNDED, LEFT))
