"""Programs of the route `taylor`, without derivatives."""

import math
from dataclasses import replace
from typing import TYPE_CHECKING

import casadi as ca

from symfric.lower.automaton import Automaton
from symfric.solve.loop.model import series_model
from symfric.solve.loop.stepping.series import Series
from symfric.solve.lowered import LoweredScene
from symfric.solve.program import Numbers
from symfric.solve.taylor.expansion import is_branching, is_long
from symfric.solve.taylor.kept_series import kept_series
from symfric.solve.taylor.laned import Laned

if TYPE_CHECKING:
    from symfric.solve.taylor.route import Taylor

MARGIN = 0.2  # tolerance of a step relative to that of the run, so that the error of a run stays below it


class TaylorProgram(Laned):
    """A scene compiled for one tolerance; `run` repeats it with other numbers, from any thread."""

    def __init__(self, lowered: LoweredScene, tolerance: float, settings: "Taylor"):
        super().__init__(lowered, tolerance, settings)
        self.automaton = lowered.automaton
        order, self._variants = series_of(self.automaton, self.tolerance, settings.order, len(self.scene.system.states))
        self._extra = {"order": order}
        budgets = settings.max_steps, settings.max_events
        fine = MARGIN * self.tolerance
        self._model = series_model(
            self.scene, self.automaton, self._variants, lowered.observables, budgets, (fine, fine)
        )
        self._numbers = Numbers(self.scene, self.automaton.parameters, self.built_in)
        self._given = self._numbers.start


def series_of(automaton: Automaton, tolerance: float, order: int | None, n_states: int) -> tuple[int, list[Series]]:
    """Return the order, the best one unless it is given, and the series of a motion with so many states."""
    order = order or order_for(tolerance, n_states, is_branching(automaton.field))
    alone = sum(automaton.sticks) == 1 and not automaton.layout.openings
    sticker = automaton.sticks.index(True) if alone else -1
    return order, variants_of(automaton, order, sticker)


def order_for(tolerance: float, n_states: int, branching: bool = False) -> int:
    """Return the order of least cost.

    Half the logarithm of the tolerance is best for long smooth runs (Jorba and Zou, 2005). Events, whose cost does not
    depend on the length of a step, make more orders pay: by measurement 6 for one mass on a belt, from 1e-6 to 1e-13,
    and 4 for ten, where a step costs more. Twice as many where a root or a logarithm is taken of what moves: near its
    singularity short series can end in ever shorter steps.
    """
    extra = 6 if n_states <= 4 else 4
    return math.ceil(-0.5 * math.log(tolerance)) + (2 * extra if branching else extra)


def variants_of(automaton: Automaton, order: int, sticker: int) -> list[Series]:
    """Return one series for all modes or, if only one contact can stick, one for slip and one for stick.

    Two without conditions are faster than one with the mode as data (by a quarter for one mass on a belt), but their
    number would double with every contact. In a long series conditions take a negligible part of the time.
    """
    if sticker < 0 or is_long(automaton.field, order, automaton.varied):
        return [kept_series(automaton.field, order, varied=automaton.varied)]
    series = []
    for stick, name in ((0, "_slip"), (1, "_stick")):
        varied = automaton.varied
        if varied is not None:
            varied = replace(varied, field=_fixed(varied.field, sticker, stick))
        series.append(kept_series(_fixed(automaton.field, sticker, stick), order, name, varied))
    return series


def _fixed(field: ca.Function, entry: int, number: float) -> ca.Function:
    """Return the field with one entry of the mode fixed."""
    arguments = [ca.SX.sym(name, field.nnz_in(i)) for i, name in enumerate(field.name_in())]
    mode = ca.SX(arguments[3])
    mode[entry] = number
    return ca.Function("field", arguments, list(field(*arguments[:3], mode)))
