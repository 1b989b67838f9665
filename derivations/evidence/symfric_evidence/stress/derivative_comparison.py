"""Comparison of derivatives of the final state with differences of the reference simulator."""

import math

import numpy as np

from symfric.model.outputs import End
from symfric.solve.routes import prepare
from symfric.solve.status import Status
from symfric_evidence.event_reference import ReferenceSimulator
from symfric_evidence.stress.comparison import BUDGETS, Comparison
from symfric_evidence.stress.random_scenes import Draw
from symfric_evidence.stress.verdict import Verdict

TOLERANCE = 1e-10
ALLOWED = 1e-4  # largest difference from the derivative, relative to the largest entry of it and of the state
_REFERENCE = 1e-12
_STEPS = (1e-3, 1e-4, 1e-5)  # of the differences
_DIRECTIONS = 4


class DerivativeComparison(Comparison):
    """Comparison of the derivatives of one structure."""

    route, tolerance = "taylor", TOLERANCE

    def __init__(self, name: str, seed: int):
        super().__init__(name, seed)
        scene = self.structure.scene
        states, parameters = ([s.name for s in part] for part in (scene.system.states, scene.parameters))
        rng = np.random.default_rng([seed, 3])
        n = len(scene.system.q)
        self.directions = [states[0], states[n], *rng.permutation(sorted(parameters))[: _DIRECTIONS - 2].tolist()]
        self.program = prepare(scene.wanting({"end": End()}), TOLERANCE, BUDGETS, self.directions)
        self.reference = ReferenceSimulator(scene, _REFERENCE)

    def compared(self, number: int, draw: Draw) -> Verdict:
        """Compare the derivative by one of the directions."""
        direction = self.directions[number % len(self.directions)]
        run = self.program.run(draw.values, draw.initial)
        if run.status != Status.OK:
            return self.said(number, draw, "status", self.route, run.status.name)
        verdict, note, off, change = self.judged(run.sensitivities[direction], run.final, draw, direction)
        return self.said(number, draw, verdict, self.route, "OK", second=off, change=change, note=note)

    def judged(
        self, derivative: np.ndarray, final: np.ndarray, draw: Draw, direction: str
    ) -> tuple[str, str, float, float]:
        """Return the verdict, a note, the difference and the scatter of the differences over their steps."""
        size = max(float(np.max(np.abs(derivative))), float(np.max(np.abs(final))))
        slopes = [self._slope(draw, direction, step) for step in _STEPS]
        known = [s for s in slopes if s is not None]
        if not known:
            return "unconfirmed", f"by {direction}: the reference has no answer", math.nan, math.nan
        off = min(float(np.max(np.abs(s - derivative))) for s in known) / size
        scatter = max((float(np.max(np.abs(a - b))) / size for a in known for b in known), default=0.0)
        if off <= ALLOWED:
            return "agrees", "", off, scatter
        # an event that the smallest steps add or remove: the differences have no limit at these steps
        return ("sensitive" if off <= scatter else "silent failure"), f"by {direction}", off, scatter

    def _slope(self, draw: Draw, direction: str, step: float) -> np.ndarray | None:
        """Return the difference by the reference over a step to both sides, with its second order removed."""
        one, two = (self._difference(draw, direction, part) for part in (step, step / 2))
        return None if one is None or two is None else (4 * two - one) / 3

    def _difference(self, draw: Draw, direction: str, step: float) -> np.ndarray | None:
        ends = []
        for way in (1, -1):
            values, initial = dict(draw.values), dict(draw.initial)
            numbers = initial if direction in initial else values
            numbers[direction] += way * step
            reference = self.reference.run(values, initial)
            if reference.reason:
                return None
            ends.append(reference.x[:, -1])
        return np.asarray((ends[0] - ends[1]) / (2 * step))
