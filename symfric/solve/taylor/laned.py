"""Programs of the event loop that run many cases in lanes of vectors."""

from collections.abc import Callable
from typing import TYPE_CHECKING

import numpy as np

from symfric.locks import SYMBOLIC
from symfric.lower.automaton import Automaton
from symfric.solve.loop.case_arrays import CaseArrays
from symfric.solve.loop.cases import run_cases
from symfric.solve.loop.stepping.series import Series
from symfric.solve.lowered import LoweredScene
from symfric.solve.program import Compiled
from symfric.solve.protocol import Route

if TYPE_CHECKING:
    from symfric.solve.lanes.model import LaneModel

LEAST = 1000  # cases for which lanes are compiled, which takes as long as some thousands of them; the bits are the same
FEWEST = 16  # cases that pay in lanes that there are


class Laned(Compiled):
    """Base of the programs of the event loop; a program sets `automaton` and `_variants`."""

    automaton: Automaton
    _variants: list[Series]

    def __init__(self, lowered: LoweredScene, tolerance: float, settings: Route):
        super().__init__(lowered, tolerance, settings)
        self._lane_models: list[LaneModel | None] = []  # one, once many cases have been run

    def _run_cases(
        self, y: np.ndarray, p: np.ndarray, threads: int, progress: Callable[[float], None] | None
    ) -> CaseArrays:
        """Run many cases in lanes of vectors where the scene can, as long as compiling the lanes pays."""
        self._get_ready(len(y))
        lanes = self._lane_models[0] if self._lane_models and len(y) >= FEWEST else None
        if lanes is None:
            return run_cases(self._model, y, p, threads, progress, len(self.directions))
        from symfric.solve.lanes.cases import run_in_lanes  # numba: not for a single run

        return run_in_lanes(lanes, y, p, threads, progress, len(self.directions))

    def _get_ready(self, cases: int) -> None:
        if cases >= LEAST:
            self._lanes()

    def _lanes(self) -> "LaneModel | None":
        from symfric.solve.lanes.model import LaneModel, plan_of

        if not self._lane_models:
            with SYMBOLIC:
                if not self._lane_models:
                    plan = plan_of(self._model, self.automaton, self._variants, self.scene.horizon)
                    self._lane_models.append(LaneModel(plan, self._model) if plan else None)
        return self._lane_models[0]
