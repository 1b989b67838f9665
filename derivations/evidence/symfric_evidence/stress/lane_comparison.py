"""Comparison of many cases at once with single runs, whose bits they have to have."""

import math
from functools import lru_cache

import numpy as np

from symfric.model.outputs import End
from symfric.solve.batch import Batch
from symfric.solve.exact.route import Exact
from symfric.solve.routes import explain, prepare
from symfric.solve.status import Status
from symfric.solve.taylor.route import Taylor
from symfric_evidence.stress.families import family
from symfric_evidence.stress.verdict import Verdict

TOLERANCES = (1e-6, 1e-9, 1e-12)
_TOGETHER = 12  # cases in one call
_STEPS, _EVENTS = 20_000, 5_000  # budgets of a run


class LaneComparison:
    """Comparison of `map` with `run` for one structure.

    Parameters
    ----------
    name : str
        Of the family.
    seed : int
        Of the structure.
    """

    def __init__(self, name: str, seed: int):
        self.family, self.seed = family(name), seed
        self.structure = self.family.build(seed)
        self.tolerance = TOLERANCES[seed % len(TOLERANCES)]
        scene = self.structure.scene.wanting({"end": End()})
        settings = Exact if explain(scene).route == "exact" else Taylor
        self.program = prepare(scene, self.tolerance, settings(max_steps=_STEPS, max_events=_EVENTS))
        self._together = lru_cache(maxsize=1)(self._batch)

    def verdict(self, number: int) -> Verdict:
        """Run one case alone and among others; any difference of bits, status or time of the end is a failure."""
        draw = self.family.draw(self.structure, self.seed, number)
        name, none = f"{self.family.name}/{self.seed}/{number}", math.nan
        known = (self.family.name, name, draw.kind)
        try:
            run, batch = self.program.run(draw.values, draw.initial), self._together(number // _TOGETHER)
        except Exception as error:  # a failure of the package, since the numbers of a family are valid
            note = f"{type(error).__name__}: {error}"
            return Verdict(*known, "silent failure", "", "raised", self.tolerance, none, none, none, none, note)
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
        return Verdict(*known, verdict, run.route, run.status.name, self.tolerance, none, off, none, none, note)

    def _batch(self, block: int) -> Batch:
        numbers = range(block * _TOGETHER, (block + 1) * _TOGETHER)
        draws = [self.family.draw(self.structure, self.seed, number) for number in numbers]
        values = {k: np.array([d.values[k] for d in draws]) for k in draws[0].values}
        return self.program.map(values, {k: np.array([d.initial[k] for d in draws]) for k in draws[0].initial})
