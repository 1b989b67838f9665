"""The route `taylor`: a scene compiled once, run many times."""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import casadi as ca

from symfric.codegen.functions import compile_functions
from symfric.codegen.loop_loader import open_door
from symfric.errors import SceneError
from symfric.lower.automaton import Automaton, constants, lower
from symfric.lower.variational_equations import Variations
from symfric.model.scene import Scene
from symfric.solve.input_segments import segments
from symfric.solve.loop.compiled_model import CompiledModel
from symfric.solve.loop.workspace import SHARED, T_END, make_workspace
from symfric.solve.observables import Wanted, wanted_of
from symfric.solve.program import Compiled, Numbers, check_tolerance
from symfric.solve.taylor.expansion import Series, expand, is_branching, is_long, reach

MARGIN = 0.2  # of the tolerance that a step may spend, so that the error of a run stays below it


@dataclass(frozen=True)
class Taylor:
    """Settings of the route `taylor`.

    Attributes
    ----------
    order : int or None
        Order of the Taylor series, from the tolerance unless given.
    max_steps, max_events : int
        Budgets; a run that needs more ends with a status.
    """

    order: int | None = None
    max_steps: int = 100_000_000
    max_events: int = 20_000_000

    def __post_init__(self):
        if self.order is not None and not 3 <= self.order <= 60:
            raise SceneError(f"the order of the Taylor series is {self.order}; it must lie between 3 and 60")
        if self.max_steps < 1 or self.max_events < 1:
            raise SceneError("the budgets max_steps and max_events must be positive")


def order_for(tolerance: float, n_states: int, branching: bool = False) -> int:
    """Return the order that costs least.

    Half the logarithm of the tolerance is best for long smooth runs (Jorba and Zou, 2005). Events, whose cost does not
    depend on the length of a step, make more orders pay: by measurement 6 for one mass on a belt, from 1e-6 to 1e-13,
    and 4 for ten, where a step costs more. Twice as many where a root or a logarithm is taken of what moves: near its
    singularity short series can end in ever shorter steps.
    """
    extra = 6 if n_states <= 4 else 4
    return math.ceil(-0.5 * math.log(tolerance)) + (2 * extra if branching else extra)


class TaylorProgram(Compiled):
    """A scene compiled for one tolerance; `run` repeats it with other numbers, from any thread."""

    route = "taylor"

    def __init__(self, scene: Scene, tolerance: float, settings: Taylor, varied: frozenset[str] = frozenset()):
        self.scene, self.tolerance, self.settings = scene, check_tolerance(tolerance), settings
        self.varied = varied
        wanted = wanted_of(scene)
        self.automaton: Automaton = lower(scene, [r.expr for r in wanted.rows], varied)
        states = len(scene.system.states)
        self.order = order = settings.order or order_for(self.tolerance, states, is_branching(self.automaton.field))
        self._extra = {"order": order}
        sticker = self.automaton.sticks.index(True) if sum(self.automaton.sticks) == 1 else -1
        variants = variants_of(self.automaton, order, sticker)
        budgets = settings.max_steps, settings.max_events
        fine = MARGIN * self.tolerance
        self._model = series_model(scene, self.automaton, variants, wanted, budgets, (fine, fine))
        self.wider: dict[frozenset[str], TaylorProgram] = {}
        self.built_in = {s.name: float(v) for s, v in constants(scene, varied).items()}
        self._numbers = Numbers(scene, self.automaton.parameters, self.built_in)

    def __reduce__(self):
        """Pickle as what it was prepared from; machine code is compiled, or loaded from the cache, where it arrives."""
        return TaylorProgram, (self.scene, self.tolerance, self.settings, self.varied)

    def remade(self, varied: frozenset[str]) -> "TaylorProgram":
        """Return the program in which the parameters `varied` may be anything."""
        return TaylorProgram(self.scene, self.tolerance, self.settings, varied)


def series_model(
    scene: Scene,
    automaton: Automaton,
    variants: Sequence[Series],
    wanted: Wanted,
    budgets: tuple[int, int],
    tolerances: tuple[float, float],
    variations: Variations | None = None,
    n_x: int | None = None,
) -> CompiledModel:
    """Compile what the event loop needs of a scene.

    Parameters
    ----------
    scene : Scene
    automaton : Automaton
    variants : sequence of Series
        As for `make_workspace`; those without a series are linear equations.
    wanted : Wanted
    budgets : (int, int)
        Most steps and events.
    tolerances : (float, float)
        Of a step, and the part of an acceleration by which errors may falsify a decision to stick.
    variations : Variations, optional
        From which the automaton was taken, if its states hold derivatives.
    n_x : int, optional
        States that results have; those of the scene unless given.
    """
    linear = variants[0].matrices is not None
    functions = [f for v in variants for f in (v.prelude, v.series, v.probe, v.unseen, v.terms) if f]
    if not linear:
        functions.append(reach(len(automaton.states), automaton.n_guards, variants[0].order))
    jump = variations.jump if variations else None
    functions += [jump] if jump else []
    code = compile_functions([*functions, _joined_gauge(automaton.gauge)])
    pieces = segments([scene.inputs[i] for i in automaton.inputs], scene.horizon)
    first = make_workspace(automaton, variants, code.addresses, wanted.rows, pieces, jump)
    first.clock[T_END:] = scene.horizon, *tolerances
    sticker = automaton.sticks.index(True) if len(variants) > 1 else -1
    limits = *budgets, 1_000_000, wanted.path, wanted.events, automaton.n_q, first.exposed.size > 0
    derivatives = (variations.columns, variations.followed) if variations else (0, 0)
    first.limits[:] = (
        *limits,
        sticker,
        linear,
        *derivatives,
        len(automaton.at_edges),
        automaton.n_q * automaton.coupled,
    )
    launch = open_door("symfric.solve.loop.entry", "the event loop", Path(__file__).parent)
    n_x = len(scene.system.states) if n_x is None else n_x
    return CompiledModel(launch, code, first, SHARED, wanted, n_x, scene.horizon)


def variants_of(automaton: Automaton, order: int, sticker: int) -> list[Series]:
    """Return one series for all modes; if one contact alone can stick, one for its slipping and one for its sticking.

    Two that choose nothing are faster than one in which the mode is data (by a quarter for one mass on a belt), but
    their number would double with every contact. In a long series the choices take no part of the time.
    """
    if sticker < 0 or is_long(automaton.field, order):
        return [expand(automaton.field, order)]
    return [
        expand(_fixed(automaton.field, sticker, stick), order, name) for stick, name in ((0, "_slip"), (1, "_stick"))
    ]


def _fixed(field: ca.Function, entry: int, number: float) -> ca.Function:
    """Return the field with one entry of its mode fixed."""
    arguments = [ca.SX.sym(name, field.nnz_in(i)) for i, name in enumerate(field.name_in())]
    mode = ca.SX(arguments[3])
    mode[entry] = number
    return ca.Function("field", arguments, list(field(*arguments[:3], mode)))


def _joined_gauge(gauge: ca.Function) -> ca.Function:
    """Return the gauge as a function of ([y; t], p) with one output, the calling convention of the machine code."""
    state, p = ca.SX.sym("y", gauge.nnz_in(0) + 1), ca.SX.sym("p", gauge.nnz_in(2))
    return ca.Function("gauge", [state, p], [ca.vertcat(*gauge(state[:-1], state[-1], p))])
