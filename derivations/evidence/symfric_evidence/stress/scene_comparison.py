"""Comparison of one random structure, run by the automatic route, with the reference simulator."""

import math
from functools import cached_property, partial

import numpy as np
import sympy as sp

from symfric.errors import NoRoute, SceneError
from symfric.lower.energy import energy_functions
from symfric.model.symbols import SPEED
from symfric.solve.energy import imbalance
from symfric.solve.lowered import LoweredScene
from symfric.solve.protocol import Program
from symfric.solve.routes import prepare
from symfric.solve.run import Run
from symfric.solve.status import ADVICE, Status
from symfric_evidence.event_reference import ReferenceSimulator
from symfric_evidence.stress.comparison import BUDGETS, Comparison, chosen
from symfric_evidence.stress.families.family import Units
from symfric_evidence.stress.random_scenes import Draw
from symfric_evidence.stress.verdict import Verdict

TOLERANCES = (1e-6, 1e-8, 1e-10)  # the first for laws with an infinite slope, for which no route is much more accurate
WRONG = 1000.0  # largest difference of two runs, in tolerances
CHANGE = 10.0  # largest difference of two runs, in units of the change by a perturbation
_FINER = 1e-3  # tolerance of a third run, relative to the first
_REFERENCE, _REFEREE = 1e-10, 1e-12  # tolerances of the reference, and of its repetition after a disagreement
_TIMES = 8  # number of times at which runs are compared
_PERTURBATION = 1e-12  # relative perturbation of the start, besides one by the tolerance


class SceneComparison(Comparison):
    """Comparison of the motions of one structure."""

    def __init__(self, name: str, seed: int):
        super().__init__(name, seed)
        self.scene = self.structure.scene
        steep = any(c.law.kinetic.has(sp.sqrt(SPEED), sp.asin) for c in self.scene.contacts)
        self.tolerance = TOLERANCES[0 if steep else seed % len(TOLERANCES)]
        self.times = np.linspace(0, self.scene.horizon, _TIMES + 1)[1:]
        stated = self.scene.until(self.scene.horizon * self.structure.time_unit)
        self.chosen = chosen(stated, self.tolerance)
        self.fine = BUDGETS.build(LoweredScene(stated), max(_FINER * self.tolerance, 1e-13))
        self.reference = ReferenceSimulator(self.scene, _REFERENCE)
        self.energies = energy_functions(stated)
        self.symbols = {s.name: s for s in stated.parameters}

    def compared(self, number: int, draw: Draw) -> Verdict:
        """Run one draw and compare it with a finer tolerance, the reference and the energies."""
        units = self.structure.units(self.seed, number)
        values, initial = self.structure.in_units(draw, units)
        run = self.chosen.run(values, initial)
        states = self.states(run, units)
        if states is None:
            verdict = "status" if ADVICE[run.status] and np.isfinite(run.t_final) else "silent failure"
            sizes = np.ones(len(self.scene.system.states))
            reference = self.reference.run(draw.values, draw.initial, times=self.times, sizes=sizes)
            note = reference.reason or "the reference runs to the end"
            return self.said(number, draw, verdict, run.route, run.status.name, note=note)
        sizes, allowed = self.sizes(run, units), WRONG * self.tolerance
        finer = difference(states, self.states(self.fine.run(values, initial), units), sizes)
        second, unique, note = self.second(draw, states, sizes, allowed)
        energy = imbalance(run, *self.energies, {self.symbols[k]: v for k, v in values.items()})
        change, differ = math.nan, np.nanmax([finer, second, 0.0])
        if second != second or max(differ, energy) > allowed:
            third = difference(states, self.third(values, initial, units), sizes)
            note += f"{note and '; '}{third:.1e} from the route integrators"
            if second != second:
                second = third
                differ = np.fmax(differ, third)
        if differ > allowed:
            change = self.change(number, draw, run, sizes)
        verdict = judged((finer, second, energy, change), allowed, unique)
        differences = {"finer": finer, "second": second, "energy": energy, "change": change}
        return self.said(number, draw, verdict, run.route, run.status.name, **differences, note=note)

    def states(self, run: Run, units: Units) -> np.ndarray | None:
        """Return the states at the times of comparison in the units of the structure; None if the run failed."""
        if run.status != Status.OK:
            return None
        return np.asarray(run(self.times * units[2]) / self.structure.state_units(units)[:, None])

    def sizes(self, run: Run, units: Units) -> np.ndarray:
        """Return the size of every state, by its largest value."""
        size = np.max(np.abs(run.x), axis=1) / self.structure.state_units(units)
        n, horizon = len(self.scene.system.q), self.scene.horizon
        q, u, z = np.split(size, [n, 2 * n])
        way, speed = np.max(q), np.max(u)
        # states below a millionth of the largest of their kind, or of what the others make of it, count as noise
        q, u = (
            np.maximum(part, 1e-6 * least)
            for part, least in ((q, max(way, speed * horizon)), (u, max(speed, way / horizon)))
        )
        z = np.maximum(z, 1e-6 * np.max(z, initial=0.0))
        size = np.concatenate([q, u, z])
        return np.asarray(np.maximum(size, max(1e-12 * np.max(size), 1e-300)))

    def second(self, draw: Draw, states: np.ndarray, sizes: np.ndarray, allowed: float) -> tuple[float, bool, str]:
        """Return the difference from the reference, whether it holds for its first choice of modes, and a note.

        The difference is NaN if the reference has no answer. Where it is too large the reference runs again at a finer
        tolerance; and where several modes were admissible, with another choice among them.
        """
        note, least = "", math.nan
        for tolerance, preference in ((None, 0), (_REFEREE, 0), (_REFEREE, 1)):
            reference = self.reference.run(
                draw.values, draw.initial, times=self.times, sizes=sizes, tolerance=tolerance, preference=preference
            )
            if reference.reason:
                note = reference.reason
                if "too many" in note and math.isnan(least):
                    break
                continue
            note, least = "", np.fmin(least, difference(states, reference.x, sizes))
            if least <= allowed or (tolerance is not None and not reference.alternatives):
                return float(least), preference == 0, ""
        return float(least), True, note

    @cached_property
    def _integrators(self) -> Program | None:
        try:
            return prepare(self.chosen.scene, max(self.tolerance * _FINER, 1e-12), "integrators")
        except (NoRoute, SceneError):
            return None

    def third(self, values: dict[str, float], initial: dict[str, float], units: Units) -> np.ndarray | None:
        """Return the states by the route integrators, which shares neither series nor event loop with the others."""
        return None if self._integrators is None else self.states(self._integrators.run(values, initial), units)

    def change(self, number: int, draw: Draw, run: Run, sizes: np.ndarray) -> float:
        """Return by how much perturbations at the level of the tolerance, and far below it, change run and reference.

        The smaller of the largest changes of the two; NaN if one of them has none.
        """
        refereed = partial(self.reference.run, times=self.times, sizes=sizes, tolerance=_REFEREE)
        units = self.structure.units(self.seed, number)
        base, states = refereed(draw.values, draw.initial), self.states(run, units)
        rng = np.random.default_rng(0)
        names = [s.name for s in self.scene.system.states]
        ours, theirs = [], []
        for part in (*[_PERTURBATION] * 2, *[self.tolerance] * 6):
            moved = part * sizes * rng.choice([-1, 1], len(names))
            start = {k: draw.initial.get(k, 0.0) + float(d) for k, d in zip(names, moved, strict=True)}
            values = {k: v * (1 + part * rng.choice([-1, 1])) for k, v in draw.values.items()}
            for given, drawn in ((start, draw.initial), (values, draw.values)):
                given |= {k: v for k, v in drawn.items() if k in self.structure.exact}
            perturbed = Draw(draw.kind, values, start)
            own = self.chosen.run(*self.structure.in_units(perturbed, units))
            ours.append(difference(self.states(own, units), states, sizes))
            other = refereed(values, start)
            theirs.append(math.nan if other.reason or base.reason else difference(other.x, base.x, sizes))
        return float(min(np.fmax.reduce(ours), np.fmax.reduce(theirs)))


def judged(differences: tuple[float, float, float, float], allowed: float, unique: bool) -> str:
    """Return the verdict on a run that ended well.

    Parameters
    ----------
    differences : tuple of float
        Differences from a finer tolerance and from what is independent, residual of the energies, change by
        perturbations; NaN where there is none.
    allowed : float
        Largest difference of runs that agree.
    unique : bool
        Whether the reference agrees with its first choice of modes.
    """
    finer, second, energy, change = differences
    if not energy <= allowed:
        return "silent failure"
    differ = np.fmax(finer, second)
    if differ > allowed:
        return "sensitive" if differ <= CHANGE * change else "silent failure"
    if not second <= allowed:
        return "unconfirmed"
    return "agrees" if unique else "not unique"


def difference(a: np.ndarray | None, b: np.ndarray | None, sizes: np.ndarray) -> float:
    """Return the largest difference of two runs, each state relative to its size; NaN if one failed."""
    if a is None or b is None:
        return math.nan
    return float(np.max(np.abs(a - b) / sizes[:, None]))
