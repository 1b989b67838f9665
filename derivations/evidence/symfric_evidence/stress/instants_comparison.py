"""Comparison of one random structure with steps, held variables and kicks with the foreign reference."""

import math
from dataclasses import replace
from functools import cached_property

import numpy as np

from symfric.errors import NoRoute, SceneError
from symfric.solve.protocol import Program
from symfric.solve.run import Run
from symfric.solve.status import ADVICE, Status
from symfric_evidence.event_reference.known_instants import NoAnswer
from symfric_evidence.stress.comparison import Comparison, chosen
from symfric_evidence.stress.families.instants import InstantsStructure
from symfric_evidence.stress.random_scenes import Draw
from symfric_evidence.stress.scene_comparison import CHANGE, WRONG, difference
from symfric_evidence.stress.verdict import Verdict

TOLERANCES = (1e-8, 1e-10)
_TIMES = 8  # at which states are compared
_SHORTER = (0.05, 0.01)  # steps of the reference where it differs, relative to its usual ones
_FINER = 1e-2  # tolerance of a second run, relative to the first


class InstantsComparison(Comparison):
    """Comparison of the motions of one structure."""

    def __init__(self, name: str, seed: int):
        super().__init__(name, seed)
        assert isinstance(self.structure, InstantsStructure)
        self.plan = self.structure
        self.scene, self.tolerance = self.structure.scene, TOLERANCES[seed % len(TOLERANCES)]
        self.times = np.linspace(0, self.scene.horizon, _TIMES + 1)[1:]
        self.chosen = chosen(self.scene, self.tolerance)

    @cached_property
    def fine(self) -> Program | None:
        """The same at a finer tolerance."""
        try:
            return chosen(self.scene, _FINER * self.tolerance)
        except (NoRoute, SceneError):
            return None

    def compared(self, number: int, draw: Draw) -> Verdict:
        """Run one draw and compare it with the reference at several times."""
        run = self.chosen.run(draw.values, draw.initial)
        if run.status != Status.OK:
            verdict = "status" if ADVICE[run.status] else "silent failure"
            return self.said(number, draw, verdict, run.route, run.status.name)
        states, sizes = self._states(run), np.maximum(np.max(np.abs(run.x[: 2 * self.plan.masses]), axis=1), 1e-3)
        theirs, note = self._reference(draw)
        second = difference(states, theirs, sizes)
        allowed, finer, change = WRONG * self.tolerance, math.nan, math.nan
        for shorter in _SHORTER:  # the reference may have skipped a short stick, or hung at a slow reversal
            if not second <= allowed:
                theirs, note = self._reference(draw, shorter)
                second = difference(states, theirs, sizes)
        verdict = "agrees" if second <= allowed else "unconfirmed" if second != second else "silent failure"
        if verdict == "silent failure":
            fine = None if self.fine is None else self.fine.run(draw.values, draw.initial)
            finer = math.nan if fine is None else difference(states, self._states(fine), sizes)
            change = self._change(draw, states, theirs, sizes)
            verdict = "sensitive" if second <= CHANGE * change else verdict
        return self.said(
            number, draw, verdict, run.route, run.status.name, second=second, finer=finer, change=change, note=note
        )

    def _states(self, run: Run) -> np.ndarray:
        """Return coordinates and velocities at the times of comparison, from before what happens then."""
        return np.asarray(run(self.times))[: 2 * self.plan.masses]

    def _reference(self, draw: Draw, shorter: float = 1.0) -> tuple[np.ndarray | None, str]:
        """Return the states of the reference, with steps so much shorter, and what it says if there are none."""
        names = [s.name for s in self.scene.system.states[: 2 * self.plan.masses]]
        try:
            system = self.plan.reference(draw)
            system = replace(system, longest=shorter * system.longest)
            return system.run([draw.initial[n] for n in names], self.times.tolist()), ""
        except NoAnswer as error:
            return None, str(error)

    def _change(self, draw: Draw, states: np.ndarray, theirs: np.ndarray | None, sizes: np.ndarray) -> float:
        """Return by how much the same small perturbations change run and reference; the smaller of the largest."""
        rng = np.random.default_rng(0)
        ours, others = [], []
        for _ in range(4):
            start = {k: v + self.tolerance * float(rng.choice([-1, 1])) for k, v in draw.initial.items()}
            values = {k: v * (1 + self.tolerance * float(rng.choice([-1, 1]))) for k, v in draw.values.items()}
            moved = Draw(draw.kind, values, start)
            run = self.chosen.run(values, start)
            ours.append(difference(self._states(run) if run.status == Status.OK else None, states, sizes))
            others.append(difference(self._reference(moved)[0], theirs, sizes))
        return float(min(np.fmax.reduce(ours), np.fmax.reduce(others)))
