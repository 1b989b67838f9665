"""Comparison of many cases at once with single runs, whose bits they have to have."""

from functools import lru_cache

import numpy as np

from symfric.model.outputs import End
from symfric.solve.batch import Batch
from symfric.solve.status import Status
from symfric_evidence.stress.comparison import Comparison, chosen
from symfric_evidence.stress.random_scenes import Draw
from symfric_evidence.stress.verdict import Verdict

TOLERANCES = (1e-6, 1e-9, 1e-12)
_TOGETHER = 12  # cases in one call


class LaneComparison(Comparison):
    """Comparison of `map` with `run` for one structure."""

    def __init__(self, name: str, seed: int):
        super().__init__(name, seed)
        self.tolerance = TOLERANCES[seed % len(TOLERANCES)]
        self.program = chosen(self.structure.scene.wanting({"end": End()}), self.tolerance)
        self._together = lru_cache(maxsize=1)(self._batch)

    def compared(self, number: int, draw: Draw) -> Verdict:
        """Run one case alone and among others; any difference of bits, status or time of the end is a failure."""
        run, batch = self.program.run(draw.values, draw.initial), self._together(number // _TOGETHER)
        i = number % _TOGETHER
        alike = batch.status[i] == run.status and batch.t_final[i] == run.t_final
        off = 0.0
        if run.status == Status.OK:
            off = float(np.max(np.abs(batch.final[:, i] - run.final)))
            alike = alike and np.array_equal(batch.final[:, i], run.final)
        verdict, note = (
            ("agrees" if run.status == Status.OK else "status", "")
            if alike
            else ("silent failure", "map differs from run")
        )
        return self.said(number, draw, verdict, run.route, run.status.name, second=off, note=note)

    def _batch(self, block: int) -> Batch:
        draws = [self.draw(number) for number in range(block * _TOGETHER, (block + 1) * _TOGETHER)]
        values = {k: np.array([d.values[k] for d in draws]) for k in draws[0].values}
        return self.program.map(values, {k: np.array([d.initial[k] for d in draws]) for k in draws[0].initial})
