"""Comparison of one random structure, run by the automatic route, with the reference simulator."""

import math

import numpy as np
import sympy as sp

from symfric.bench.event_reference import ReferenceSimulator
from symfric.bench.stress.families import family
from symfric.bench.stress.random_scenes import Draw
from symfric.bench.stress.verdict import Verdict
from symfric.lower.energy import energy_functions
from symfric.model.scene import Scene
from symfric.model.symbols import SPEED
from symfric.solve.energy import imbalance
from symfric.solve.exact.route import Exact
from symfric.solve.routes import Program, explain, prepare
from symfric.solve.run import Run
from symfric.solve.status import ADVICE, Status
from symfric.solve.taylor.route import Taylor, TaylorProgram

TOLERANCES = (1e-6, 1e-8, 1e-10)  # the first for laws with an infinite slope, for which no route is much more accurate
WRONG = 1000.0  # largest difference of two runs, in tolerances
CHANGE = 10.0  # largest difference of two runs, in units of the change by a perturbation
_FINER = 1e-3  # tolerance of a third run, relative to the first
_STEPS, _EVENTS = 20_000, 5_000  # budgets of a run, about a second of computing
_REFERENCE, _REFEREE = 1e-10, 1e-12  # tolerances of the reference, and of its repetition after a disagreement
_TIMES = 8  # number of times at which runs are compared
_PERTURBATION = 1e-12  # relative perturbation of the start, besides one by the tolerance


class SceneComparison:
    """One structure of a family, compiled once.

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
        self.scene = self.structure.scene
        steep = any(c.law.kinetic.has(sp.sqrt(SPEED), sp.asin) for c in self.scene.contacts)
        self.tolerance = TOLERANCES[0 if steep else seed % len(TOLERANCES)]
        self.times = np.linspace(0, self.scene.horizon, _TIMES + 1)[1:]
        stated = self.scene.until(self.scene.horizon * self.structure.time_unit)
        self.chosen = _chosen(stated, self.tolerance)
        budgets = Taylor(max_steps=_STEPS, max_events=_EVENTS)
        self.fine = TaylorProgram(stated, max(_FINER * self.tolerance, 1e-13), budgets)
        self.reference = ReferenceSimulator(self.scene, _REFERENCE)
        self.energies = energy_functions(stated)
        self.symbols = {s.name: s for s in stated.parameters}

    def verdict(self, number: int) -> Verdict:
        """Run one draw and compare; a run that raises is a failure too."""
        draw = self.structure_draw(number)
        try:
            return self._compared(number, draw)
        except Exception as error:  # a failure of the package, since the numbers of a family are valid
            none, reason = (math.nan, math.nan, math.nan, math.nan), f"{type(error).__name__}: {error}"
            return self._verdict(number, draw.kind, "silent failure", "", "raised", none, reason)

    def _compared(self, number: int, draw: Draw) -> Verdict:
        units = self.structure.units(self.seed, number)
        values, initial = self.structure.in_units(draw, units)
        run, fine = (p.run(values, initial) for p in (self.chosen, self.fine))
        states, finer_states = self.states(run, units), self.states(fine, units)
        sizes = self.sizes(run, units)
        finer = difference(states, finer_states, sizes)
        second, energy, change = math.nan, math.nan, math.nan
        allowed = WRONG * self.tolerance
        note = ""
        if states is None:
            verdict = "status" if ADVICE[run.status] and np.isfinite(run.t_final) else "silent failure"
            options = {"times": self.times, "sizes": np.ones(len(self.scene.system.states))}
            note = self.reference.run(draw.values, draw.initial, **options).reason or "the reference runs to the end"
        else:
            second, note = self.second(draw, states, sizes, allowed)
            energy = imbalance(run, *self.energies, {self.symbols[k]: v for k, v in values.items()})
            if energy <= allowed and not (finer > allowed or second > allowed):
                verdict = "agrees" if second == second else "alone" if finer == finer else "unconfirmed"
            elif second <= allowed and energy <= allowed:
                verdict = "agrees"  # the finer run is the wrong one; it has scenes of its own
            else:
                change = self.change(draw, sizes)
                within = energy <= allowed and np.nanmax([finer, second, 0.0]) <= CHANGE * change  # not if it is NaN
                verdict = "sensitive" if within else "silent failure"
        found = finer, second, energy, change
        return self._verdict(number, draw.kind, verdict, run.route, run.status.name, found, note)

    def _verdict(
        self, number: int, kind: str, verdict: str, route: str, status: str, found: tuple[float, ...], note: str
    ) -> Verdict:
        name, (finer, second, energy, change) = f"{self.family.name}/{self.seed}/{number}", found
        known = self.family.name, name, kind, verdict, route, status, self.tolerance
        return Verdict(*known, finer, second, energy, change, note)

    def structure_draw(self, number: int) -> Draw:
        """Return the numbers of one run."""
        return self.family.draw(self.structure, self.seed, number)

    def states(self, run: Run, units) -> np.ndarray | None:
        """Return the states at the times of comparison in the units of the structure; None if the run failed."""
        if run.status != Status.OK:
            return None
        return run(self.times * units[2]) / self.structure.state_units(units)[:, None]

    def sizes(self, run: Run, units) -> np.ndarray:
        """Return the size of every state, by its largest value."""
        size = np.max(np.abs(run.x), axis=1) / self.structure.state_units(units)
        n = len(self.scene.system.q)
        # states below a millionth of the largest of their kind count as noise
        for part in np.split(np.arange(size.size), [n, 2 * n]):
            if part.size:
                size[part] = np.maximum(size[part], 1e-6 * np.max(size[part]))
        return np.maximum(size, max(1e-12 * np.max(size), 1e-300))

    def second(self, draw: Draw, states: np.ndarray, sizes: np.ndarray, allowed: float) -> tuple[float, str]:
        """Return the difference from the reference, NaN if that has no answer, and a note.

        Where it is too large the reference runs again at a finer tolerance; and where several modes were admissible,
        with another choice among them.
        """
        note, found = "", math.nan
        for tolerance, preference in ((None, 0), (_REFEREE, 0), (_REFEREE, 1)):
            options = {"times": self.times, "sizes": sizes, "tolerance": tolerance, "preference": preference}
            reference = self.reference.run(draw.values, draw.initial, **options)
            if reference.reason:
                note = reference.reason
                if "too many" in note and math.isnan(found):
                    break
                continue
            note, found = "", np.fmin(found, difference(states, reference.x, sizes))
            if found <= allowed or (tolerance is not None and not reference.alternatives):
                break
        return float(found), note

    def change(self, draw: Draw, sizes: np.ndarray) -> float:
        """Return the largest change of the reference when start and values change by a tolerance, or by far less."""
        options = {"times": self.times, "sizes": sizes, "tolerance": _REFEREE}
        base = self.reference.run(draw.values, draw.initial, **options)
        rng = np.random.default_rng(0)
        names, changes = [s.name for s in self.scene.system.states], []
        for part in (_PERTURBATION, _PERTURBATION, self.tolerance, self.tolerance):
            moved = part * sizes * rng.choice([-1, 1], len(names))
            start = {k: draw.initial[k] + float(d) for k, d in zip(names, moved, strict=True)}
            values = {k: v * (1 + part * rng.choice([-1, 1])) for k, v in draw.values.items()}
            for given, drawn in ((start, draw.initial), (values, draw.values)):
                given |= {k: v for k, v in drawn.items() if k in self.structure.exact}
            other = self.reference.run(values, start, **options)
            if not (other.reason or base.reason):
                changes.append(difference(other.x, base.x, sizes))
        return max((c for c in changes if c == c), default=math.nan)


def difference(a: np.ndarray | None, b: np.ndarray | None, sizes: np.ndarray) -> float:
    """Return the largest difference of two runs, each state relative to its size; NaN if one failed."""
    if a is None or b is None:
        return math.nan
    return float(np.max(np.abs(a - b) / sizes[:, None]))


def _chosen(scene: Scene, tolerance: float) -> Program:
    """Prepare the route that `prepare` would choose, within the budgets."""
    settings = Exact if explain(scene).route == "exact" else Taylor
    return prepare(scene, tolerance, settings(max_steps=_STEPS, max_events=_EVENTS))
