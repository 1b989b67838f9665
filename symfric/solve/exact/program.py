"""The route `exact`: closed forms between events, for scenes that are linear there."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass

import sympy as sp

from symfric.errors import NoRoute, SceneError
from symfric.lower.automaton import constants
from symfric.lower.linear import oscillator
from symfric.model.names import Key
from symfric.model.scene import Scene
from symfric.solve.compiled import INTEGRAL, PATH_BYTES, Loop, Numbers, Wanted, check_tolerance, wanted_of
from symfric.solve.exact.entry import launch
from symfric.solve.exact.record_program import record_loop
from symfric.solve.exact.room import make_room
from symfric.solve.run import Run
from symfric.solve.taylor.jit import compile_functions
from symfric.solve.taylor.program import Taylor, TaylorProgram
from symfric.solve.widened import widened


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


def rows_in_closed_form(wanted: Wanted) -> list[sp.Expr]:
    """Return the expressions of which extremes are wanted.

    Raises
    ------
    NoRoute
        If an integral is wanted.
    """
    if any(kind == INTEGRAL for kind, _ in wanted.rows):
        raise NoRoute("an integral is wanted")
    return [e for _, e in wanted.rows]


class ExactProgram:
    """A scene in closed form; `run` repeats it with other numbers. Not to be shared between threads."""

    route = "exact"

    def __init__(self, scene: Scene, tolerance: float, settings: Exact, varied: frozenset[str] = frozenset()):
        self.scene, self.tolerance, self.settings = scene, check_tolerance(tolerance), settings
        self.varied = varied
        self.general: ExactProgram | TaylorProgram | None = None
        self.built_in = {s.name: float(v) for s, v in constants(scene, varied).items()}
        if scene.inputs:
            self._code, self._loop, problem = record_loop(scene, settings, varied)
            self._numbers = Numbers(scene, problem.parameters, self.built_in)
            return
        wanted = wanted_of(scene)
        problem = oscillator(scene, rows_in_closed_form(wanted), varied)
        self._code = compile_functions([problem.data])
        room = make_room(problem, self._code.addresses["data"])
        steps = PATH_BYTES // room.path_c[0].nbytes if wanted.path else settings.max_steps
        room.clock[4:] = scene.horizon, self.tolerance
        limits = min(settings.max_steps, steps), settings.max_events, 1_000_000, wanted.path, wanted.events, 1, 0, 0
        room.limits[:] = (*limits, problem.branches, problem.sticks, problem.rows)
        self._numbers = Numbers(scene, problem.parameters, self.built_in)
        self._loop = Loop(launch, room, wanted, scene.horizon)

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

    def run(
        self,
        values: Mapping[Key, float] | None = None,
        initial: Mapping[Key, float] | None = None,
        progress: Callable[[float], None] | None = None,
    ) -> Run:
        """Run with other parameter values or another start; see `TaylorProgram.run`."""
        values = {} if values is None else values
        initial = {} if initial is None else initial
        y, p = self._numbers.start
        if values or initial:
            general = widened(self, values)
            if general is not None:
                return general.run(values, initial, progress)
            y, p = self._numbers.changed(values, initial)
        status = self._loop.drive(y, p, progress)
        final, t_final, stats, raw = self._loop.collect()
        return Run(
            self.scene, dict(values), dict(initial), self.route, self.tolerance, final, t_final, status, stats, raw
        )
