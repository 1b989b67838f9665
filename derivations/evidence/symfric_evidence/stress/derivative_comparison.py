"""Comparison of derivatives of the final state with differences of the reference simulator."""

import math

import numpy as np

from symfric.model.outputs import End
from symfric.solve.routes import prepare
from symfric.solve.status import Status
from symfric.solve.taylor.route import Taylor
from symfric_evidence.event_reference import ReferenceSimulator
from symfric_evidence.stress.families import family
from symfric_evidence.stress.random_scenes import Draw
from symfric_evidence.stress.verdict import Verdict

TOLERANCE = 1e-10
ALLOWED = 1e-4  # largest difference from the derivative, relative to the largest entry of it and of the state
_REFERENCE = 1e-12
_STEPS = (1e-3, 1e-4, 1e-5)  # of the differences
_DIRECTIONS = 4
_BUDGETS = Taylor(max_steps=20_000, max_events=5_000)


class DerivativeComparison:
    """Comparison of the derivatives of one structure.

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
        scene = self.structure.scene
        states, parameters = ([s.name for s in part] for part in (scene.system.states, scene.parameters))
        rng = np.random.default_rng([seed, 3])
        n = len(scene.system.q)
        self.directions = [states[0], states[n], *rng.permutation(sorted(parameters))[: _DIRECTIONS - 2].tolist()]
        self.program = prepare(scene.wanting({"end": End()}), TOLERANCE, _BUDGETS, self.directions)
        self.reference = ReferenceSimulator(scene, _REFERENCE)

    def verdict(self, number: int) -> Verdict:
        """Compare the derivative by one of the directions."""
        draw = self.family.draw(self.structure, self.seed, number)
        direction = self.directions[number % len(self.directions)]
        name, none = f"{self.family.name}/{self.seed}/{number}", math.nan
        try:
            run = self.program.run(draw.values, draw.initial)
            if run.status != Status.OK:
                found, status, note, off, change = "status", run.status.name, "", none, none
            else:
                found, note, off, change = self.compared(run.sensitivities[direction], run.final, draw, direction)
                status = "OK"
        except Exception as error:  # a failure of the package, since the numbers of a family are valid
            found, status, note = "silent failure", "raised", f"{type(error).__name__}: {error}"
            off = change = none
        return Verdict(
            self.family.name, name, draw.kind, found, "taylor", status, TOLERANCE, none, off, none, change, note
        )

    def compared(self, derivative: np.ndarray, final: np.ndarray, draw: Draw, direction: str):
        """Return the verdict, a note, the difference and the scatter of the differences over their steps."""
        size = max(float(np.max(np.abs(derivative))), float(np.max(np.abs(final))))
        slopes = [self._slope(draw, direction, step) for step in _STEPS]
        found = [s for s in slopes if s is not None]
        if not found:
            return "unconfirmed", f"by {direction}: the reference has no answer", math.nan, math.nan
        off = min(float(np.max(np.abs(s - derivative))) for s in found) / size
        scatter = max((float(np.max(np.abs(a - b))) / size for a in found for b in found), default=0.0)
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
            found = self.reference.run(values, initial)
            if found.reason:
                return None
            ends.append(found.x[:, -1])
        return (ends[0] - ends[1]) / (2 * step)
