"""Limit cycles over the swept parameter, from the onset of vibration or from the settled motion."""

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from symfric.model.outputs import HalfRange
from symfric.model.scene import Scene
from symfric.orbits.steady_state import state_symbol
from symfric.report.study.answers import StudyAnswer, answer
from symfric.scenefile import SceneFile, SweepPlan

if TYPE_CHECKING:
    from symfric.orbits.continuation.branch import Branch
    from symfric.structures.onset import LiftOff
    from symfric.theory.hopf import HopfPoint

FEW, SMALL = 60, 20  # limit cycles in each direction, and states up to which there are more
MOST = 250


@dataclass(frozen=True, eq=False)
class BranchResult:
    """Limit cycles over a parameter.

    Attributes
    ----------
    parameter, coordinate : str
    branch : Branch
    half_range : ndarray, shape (n,)
        Of the coordinate.
    stable : ndarray of bool, shape (n,)
    lift_off : tuple of LiftOff
    from_onset : bool
        Whether it begins at the Hopf point; otherwise at the settled motion.
    cut : int
        Most limit cycles that are computed, if the branch goes on; otherwise 0.
    """

    parameter: str
    coordinate: str
    branch: "Branch"
    half_range: np.ndarray
    stable: np.ndarray
    lift_off: "tuple[LiftOff, ...]"
    from_onset: bool
    cut: int = 0

    @property
    def values(self) -> np.ndarray:
        """Values of the parameter, shape (n,)."""
        return np.asarray(self.branch.values, dtype=float)


def followed(file: SceneFile, onset: StudyAnswer["HopfPoint"]) -> StudyAnswer[BranchResult]:
    """Return the limit cycles that the file asks for."""
    plan = file.sweep
    if plan is None or plan.branch is None:
        return StudyAnswer(None, "the file has no sweep.branch, the range over which limit cycles are followed")
    return answer(_branch, file.scene, plan, plan.branch, onset.value)


def _branch(scene: Scene, plan: SweepPlan, span: tuple[float, float], hopf: "HopfPoint | None") -> BranchResult:
    from symfric.orbits.continuation.branch import continue_cycle
    from symfric.structures.onset import lift_offs, onset

    most = MOST if len(scene.system.states) <= SMALL else FEW
    grows = hopf is not None and hopf.kind != "degenerate" and span[0] <= hopf.value <= span[1]
    if grows and hopf is not None:
        found = onset(scene, plan.parameter, hopf, span, most)
        branch, lifts = found.branch, found.lift_off
    else:
        branch = continue_cycle(scene, plan.parameter, span, None, most)
        lifts = lift_offs(scene, plan.parameter, branch)
    sizes = _half_ranges(scene, plan, branch)
    stable = np.array([bool(orbit.stable) for orbit in branch.orbits])
    cut = most if len(branch.orbits) >= most else 0
    return BranchResult(plan.parameter, plan.coordinate, branch, sizes, stable, lifts, grows, cut)


def _half_ranges(scene: Scene, plan: SweepPlan, branch: "Branch") -> np.ndarray:
    from symfric.solve.routes import prepare

    if not branch.orbits or plan.coordinate in branch.orbits[0].names:
        return np.array([float(o.half_range[o.names.index(plan.coordinate)]) for o in branch.orbits])
    longest = max(orbit.period for orbit in branch.orbits)
    wanted = {"size": HalfRange(state_symbol(scene, plan.coordinate))}
    program = prepare(scene.until(1.01 * longest, wanted))
    found = []
    for value, orbit in zip(branch.values, branch.orbits, strict=True):
        start = dict(zip(orbit.names, orbit.start.tolist(), strict=True))
        found.append(float(program.run({plan.parameter: float(value)}, start).checked()["size"]))
    return np.array(found)
