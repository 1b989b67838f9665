"""Comparison of limit cycles and branches with the reference simulator."""

import math

import numpy as np

from symfric.errors import NotFound
from symfric.model.scene import Scene
from symfric.orbits.continuation.branch import Branch, Special, continue_cycle
from symfric.orbits.cycle import Orbit, limit_cycle
from symfric_evidence.event_reference import ReferenceSimulator
from symfric_evidence.stress.comparison import Comparison
from symfric_evidence.stress.families.family import Units
from symfric_evidence.stress.random_scenes import Draw
from symfric_evidence.stress.verdict import Verdict

PARAMETER, SPAN = "F", (0.25, 1.4)  # parameter of a branch, and its span relative to the initial value
ALLOWED = 1e-6  # largest gap of an orbit in the reference, relative to its size
_CHECKED = 6  # number of orbits of a branch that are checked
_HALVINGS = 5  # halvings of the bracket of an onset of sticking


class OrbitComparison(Comparison):
    """Comparison of the limit cycles of one structure."""

    tolerance = ALLOWED

    def __init__(self, name: str, seed: int):
        super().__init__(name, seed)
        self.reference = ReferenceSimulator(self.structure.scene, 1e-11)

    def compared(self, number: int, draw: Draw) -> Verdict:
        """Find the limit cycle or the branch of one draw and compare it."""
        try:
            off, note = self._cycle(number, draw) if self.family.sought == "cycle" else self._branch(draw)
        except NotFound as reason:
            return self.said(number, draw, "status", self.route, "NotFound", note=str(reason))
        verdict = "agrees" if off <= ALLOWED and not note else "silent failure"
        if off != off and not note:
            verdict = "unconfirmed"
        return self.said(number, draw, verdict, self.route, "OK", second=off, note=note)

    def _cycle(self, number: int, draw: Draw) -> tuple[float, str]:
        units = self.structure.units(self.seed, number)
        values, initial = self.structure.in_units(draw, units)
        scene = self.structure.scene.where(values).starting(initial)
        orbit = limit_cycle(scene.until(scene.horizon * units[2]))
        return self.misfit(orbit, draw.values, units)

    def misfit(self, orbit: Orbit, values: dict[str, float], units: Units = (1.0, 1.0, 1.0)) -> tuple[float, str]:
        """Return by how much the reference misses the start after a period, or the time of sticking, and a note.

        An error of the start grows by the multipliers; it is not held against orbits that repel strongly.
        """
        state_units, period = self.structure.state_units(units), orbit.period / units[2]
        names = [s.name for s in self.structure.scene.system.states]
        start = orbit.start / state_units
        initial = dict(zip(names, start.tolist(), strict=True))
        judge = self.reference.run(values, initial, horizon=period)
        if judge.reason:
            return math.nan, ""
        size = np.max(orbit.half_range / state_units)
        off = float(np.max(np.abs(judge.x[:, -1] - start))) / size / max(1.0, float(np.max(np.abs(orbit.multipliers))))
        times = np.array([*(t for t, _ in judge.events), period])
        sticks = np.array([0 in modes for _, modes in judge.events])
        apart = abs(float(np.sum(np.diff(times)[sticks])) - orbit.stick_time / units[2]) / period
        return max(off, 1e-3 * apart), ""  # a time of sticking may begin and end with little speed

    def _branch(self, draw: Draw) -> tuple[float, str]:
        scene = self.structure.scene.where(draw.values).starting(draw.initial)
        low, high = (part * draw.values[PARAMETER] for part in SPAN)
        branch = continue_cycle(scene, PARAMETER, (low, high))
        outside = [v for v in (*branch.values, *(s.value for s in branch.special)) if not low <= v <= high]
        if outside:
            return math.nan, f"{PARAMETER} = {outside[0]:.9g} lies outside the span"
        special = np.array([s.value for s in branch.special])
        clear = [o for o, v in zip(branch.orbits, branch.values, strict=True) if np.all(np.abs(special - v) > 1e-4 * v)]
        worst = math.nan
        for orbit in clear[:: max(1, len(clear) // _CHECKED)]:
            worst = float(np.fmax(worst, self.misfit(orbit, _values(orbit))[0]))
        for onset in (s for s in branch.special if s.kind == "stick-onset" and not s.jump):
            note = self._bisected(scene, branch, onset)
            if note:
                return worst, note
        return worst, ""

    def _bisected(self, scene: Scene, branch: Branch, onset: Special) -> str:
        """Narrow the bracket of an onset by limit cycles confirmed by the reference; report if it is wrong."""
        values, sticks = branch.values, [_sticks(o) for o in branch.orbits]
        brackets = [
            (i, i + 1)
            for i in range(len(values) - 1)
            if sticks[i] != sticks[i + 1] and min(values[i : i + 2]) <= onset.value <= max(values[i : i + 2])
        ]
        if not brackets:
            return f"no orbits around the onset at {onset.value:.9g} differ in their sticking"
        one, other = (branch.orbits[i] for i in brackets[0])
        for _ in range(_HALVINGS):
            middle = 0.5 * (_values(one)[PARAMETER] + _values(other)[PARAMETER])
            try:
                orbit = limit_cycle(scene.where({PARAMETER: middle}), (one.start, one.period))
            except NotFound:
                return ""
            if self.misfit(orbit, _values(orbit))[0] > ALLOWED:
                return f"the orbit at {middle:.9g} does not close"
            one, other = (orbit, other) if _sticks(orbit) == _sticks(one) else (one, orbit)
        ends = sorted(_values(o)[PARAMETER] for o in (one, other))
        slack = 1e-5 * onset.value
        if ends[0] - slack <= onset.value <= ends[1] + slack:
            return ""
        return f"an onset of sticking lies between {ends[0]:.9g} and {ends[1]:.9g}, not at {onset.value:.9g}"


def _sticks(orbit: Orbit) -> int:
    """Return how often contacts begin to stick in a period."""
    return sum(event.after == 0 for event in orbit.events)


def _values(orbit: Orbit) -> dict[str, float]:
    return {s.name: v for s, v in orbit.scene.parameter_values().items()}
