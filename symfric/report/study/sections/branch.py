"""Limit cycles over the swept parameter, asked by sweep.branch: from the onset of vibration or the settled motion."""

import math
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from symfric.errors import NotFound
from symfric.model.outputs import HalfRange
from symfric.model.scene import Scene
from symfric.model.symbols import counted
from symfric.orbits.continuation.branch import Branch, continue_cycle
from symfric.orbits.steady_state import state_symbol
from symfric.report.html.words import LISTED, measure
from symfric.report.study.drawing.axes import ORANGE, Axes
from symfric.report.study.section import Progress, Section, StudyResult, csv_text
from symfric.report.study.sections.onset import HOPF
from symfric.scenefile import SceneFile, SweepPlan
from symfric.solve.routes import prepare
from symfric.structures.onset import LiftOff, lift_offs, onset
from symfric.theory.hopf import HopfPoint

FEW, SMALL = 60, 20  # limit cycles in each direction, and states up to which there are more
MOST = 250
_KINDS = {
    "fold": "The branch turns back",
    "flip": "The period doubles",
    "neimark-sacker": "A second frequency begins",
    "stick-onset": "Sticking begins",
    "grazing": "A contact touches zero slip",
}


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
    branch: Branch
    half_range: np.ndarray
    stable: np.ndarray
    lift_off: tuple[LiftOff, ...]
    from_onset: bool
    cut: int = 0

    @property
    def values(self) -> np.ndarray:
        """Values of the parameter, shape (n,)."""
        return np.asarray(self.branch.values, dtype=float)


def _compute(study: StudyResult, tell: Progress) -> BranchResult:
    plan = study.file.sweep
    if plan is None or plan.branch is None:
        raise NotFound("the file has no sweep.branch, the range over which limit cycles are followed")
    tell("limit cycles", 0.6)
    return _branch(study.file.scene, plan, plan.branch, study[HOPF].value)


def _branch(scene: Scene, plan: SweepPlan, span: tuple[float, float], hopf: HopfPoint | None) -> BranchResult:
    most = MOST if len(scene.system.states) <= SMALL else FEW
    grows = hopf is not None and hopf.kind != "degenerate" and span[0] <= hopf.value <= span[1]
    if grows and hopf is not None:
        cycles = onset(scene, plan.parameter, hopf, span, most)
        branch, lifts = cycles.branch, cycles.lift_off
    else:
        branch = continue_cycle(scene, plan.parameter, span, None, most)
        lifts = lift_offs(scene, plan.parameter, branch)
    sizes = _half_ranges(scene, plan, branch)
    stable = np.array([bool(orbit.stable) for orbit in branch.orbits])
    cut = most if len(branch.orbits) >= most else 0
    return BranchResult(plan.parameter, plan.coordinate, branch, sizes, stable, lifts, grows, cut)


def _half_ranges(scene: Scene, plan: SweepPlan, branch: Branch) -> np.ndarray:
    if not branch.orbits or plan.coordinate in branch.orbits[0].names:
        return np.array([float(o.half_range[o.names.index(plan.coordinate)]) for o in branch.orbits])
    longest = max(orbit.period for orbit in branch.orbits)
    outputs = {"size": HalfRange(state_symbol(scene, plan.coordinate))}
    program = prepare(scene.until(1.01 * longest, outputs))
    sizes = []
    for value, orbit in zip(branch.values, branch.orbits, strict=True):
        start = dict(zip(orbit.names, orbit.start.tolist(), strict=True))
        sizes.append(float(program.run({plan.parameter: float(value)}, start).checked()["size"]))
    return np.array(sizes)


def branch_in_words(result: BranchResult, file: SceneFile) -> Iterator[str]:
    """Yield the sentences on the limit cycles."""
    if not result.branch.orbits:
        yield "No limit cycle was found."
        return
    order = np.argsort(result.values)
    low, high = (measure(float(result.values[k]), result.parameter, file) for k in order[[0, -1]])
    begin = "from the onset on" if result.from_onset else "from the settled motion on"
    stable = int(np.sum(result.stable))
    kinds = "all stable" if stable == result.stable.size else f"{stable} of them stable"
    count = counted(result.values.size, "limit cycle")
    more = f" It goes on: no more than {result.cut} were computed." if result.cut else ""
    yield f"{count} from {result.parameter} = {low} to {high}, followed {begin}; {kinds}.{more}"
    for lift in result.lift_off[:LISTED]:
        size = float(np.interp(lift.value, result.values[order], result.half_range[order]))
        at = measure(lift.value, result.parameter, file)
        yield (
            f"Contact {lift.contact} first lifts off at {result.parameter} = {at}, where the half range of "
            f"{result.coordinate} is about {measure(size, result.coordinate, file)}."
        )
    for special in result.branch.special:
        if special.kind != "hopf" and math.isfinite(special.value):
            at = measure(float(special.value), result.parameter, file)
            yield f"{_KINDS.get(special.kind, special.kind)} at {result.parameter} = {at}."


def draw_branch(branch: BranchResult, ax: Axes) -> None:
    """Draw the half range of limit cycles against the parameter, and where contacts lift off."""
    for good, style, words in ((True, "-", "limit cycles"), (False, "--", "unstable limit cycles")):
        if np.any(branch.stable == good):
            shown = np.where(branch.stable == good, branch.half_range, np.nan)
            ax.plot(branch.values, shown, color=ORANGE, linestyle=style, linewidth=1.6, label=words)
    order = np.argsort(branch.values)
    for k, lift in enumerate(branch.lift_off):
        size = np.interp(lift.value, branch.values[order], branch.half_range[order])
        word = "" if k else "a contact lifts off"
        ax.plot(lift.value, size, "D", color=ORANGE, markersize=5, label=word)


def _data(_study: StudyResult, result: BranchResult) -> dict[str, object]:
    return {
        "parameter": result.parameter,
        "coordinate": result.coordinate,
        "values": result.values,
        "half_range": result.half_range,
        "stable": result.stable,
        "special": [{"kind": s.kind, "value": s.value} for s in result.branch.special],
        "lift_off": {lift.contact: lift.value for lift in result.lift_off},
    }


def _tables(_study: StudyResult, result: BranchResult) -> dict[str, str]:
    periods = [orbit.period for orbit in result.branch.orbits]
    rows = zip(result.values, result.half_range, periods, result.stable.astype(int), strict=True)
    head = [result.parameter, f"half_range of {result.coordinate}", "period", "stable"]
    return {"cycles.csv": csv_text(head, rows)}


def _asked(file: SceneFile) -> bool:
    return file.structure is not None or (file.sweep is not None and file.sweep.branch is not None)


BRANCH = Section(
    "branch", _compute, topic="limit cycles", asked=_asked, longer=True, key="limit_cycles", data=_data, tables=_tables
)
