"""Compute the study of a scene file; drawing and writing use its result alone."""

import time
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from symfric.errors import SceneError
from symfric.model.excitation import is_excited
from symfric.model.scene import Scene
from symfric.orbits.steady_state import Vibration, schedule, vibration
from symfric.report.html.versions import versions
from symfric.report.study.answers import StudyAnswer, answer, out_of_time, within
from symfric.report.study.branches import BranchResult, followed
from symfric.report.study.comparison import ComparisonRow, closed_forms_apply, compare
from symfric.report.study.friction_curves import FrictionCurve, friction_curves
from symfric.report.study.measurement import (
    SampledMotion,
    as_run,
    motion,
    vibrations,
)
from symfric.report.study.prediction import PredictionCurve, averaged_curves, belt_curves
from symfric.report.study.safe_speed import SafeSpeed, safe_speed
from symfric.report.study.structural import StructureResult, contact_outputs, onset_rows, structure_result
from symfric.scenefile import DesignPlan, SceneFile, SweepPlan, belt_speeds
from symfric.time_limit import time_limit

if TYPE_CHECKING:
    from symfric.design.result import Design
    from symfric.solve.routes import Explanation
    from symfric.theory.equilibrium import Equilibrium
    from symfric.theory.hopf import HopfPoint
    from symfric.theory.stability import Stability

Progress = Callable[[str, float], None]
FINE = 201  # most points of a predicted curve
LIMIT = 20.0  # longest time for one part, s
LONGER = 10  # factor of that time for designs and limit cycles


@dataclass(frozen=True, eq=False)
class SweepResult:
    """Steady vibration over a range of one parameter.

    Attributes
    ----------
    parameter, coordinate : str
    values : ndarray, shape (n,)
    computed : tuple of Vibration
    curves : tuple of PredictionCurve
        Predictions.
    curves_note : str
        Why there is none.
    marks : dict of str to float
        Special values.
    quenched : ndarray, shape (n,), or None
        Half range with the designed excitation.
    """

    parameter: str
    coordinate: str
    values: np.ndarray
    computed: tuple[Vibration, ...]
    curves: tuple[PredictionCurve, ...]
    curves_note: str
    marks: Mapping[str, float]
    quenched: np.ndarray | None = None

    @property
    def half_range(self) -> np.ndarray:
        """Computed half range, shape (n,)."""
        return np.array([v.half_range for v in self.computed])


@dataclass(frozen=True, eq=False)
class DesignResult:
    """One design of the file.

    Attributes
    ----------
    plan : DesignPlan
    design : StudyAnswer
        Of a Design.
    """

    plan: DesignPlan
    design: StudyAnswer["Design"]


@dataclass(frozen=True, eq=False)
class QuenchResult:
    """The designed excitation and one motion without and with it.

    Attributes
    ----------
    design : Design
    speed : str
        Name of the belt speed.
    shown : float
        Its value in the two motions.
    before, after : SampledMotion
    """

    design: "Design"
    speed: str
    shown: float
    before: SampledMotion
    after: SampledMotion


@dataclass(frozen=True, eq=False)
class StudyResult:
    """All results of a study.

    Attributes
    ----------
    file : SceneFile
    structure : StructureResult or None
        Of a scene whose equations are matrices.
    branch : StudyAnswer
        Limit cycles from the onset of vibration.
    slow : StudyAnswer
        The scene of slow motions if the file's scene is excited, else the scene itself.
    equilibrium, stability, hopf, safe, motion, steady, sweep, quench, explanation : StudyAnswer
        The quench with its motions; its design is among `designs` too.
    designs : tuple of DesignResult
        All that the file asks for.
    friction : tuple of FrictionCurve
    rows : tuple of ComparisonRow
    versions : dict of str to str
    seconds : float
    """

    file: SceneFile
    structure: StructureResult | None
    branch: StudyAnswer[BranchResult]
    slow: StudyAnswer[Scene]
    equilibrium: StudyAnswer["Equilibrium"]
    stability: StudyAnswer["Stability"]
    hopf: StudyAnswer["HopfPoint"]
    safe: StudyAnswer[SafeSpeed]
    motion: StudyAnswer[SampledMotion]
    steady: StudyAnswer[Vibration]
    sweep: StudyAnswer[SweepResult]
    quench: StudyAnswer[QuenchResult]
    designs: tuple[DesignResult, ...]
    explanation: StudyAnswer["Explanation"]
    friction: tuple[FrictionCurve, ...]
    rows: tuple[ComparisonRow, ...]
    versions: Mapping[str, str]
    seconds: float

    @property
    def plan(self) -> SweepPlan:
        """The file's sweep, or a default measurement without one."""
        return measuring(self.file)

    def skipped(self) -> dict[str, str]:
        """Return the parts without a result, with reasons."""
        topics = ["slow", "equilibrium", "stability", "hopf", "motion", "steady", "sweep"]
        if self.file.plan("quench") is not None:
            topics.append("quench")
        if self.structure is not None:
            notes = {"modes": self.structure.modes.note, "flutter": self.structure.flutter.note}
            notes["limit cycles"] = self.branch.note
        else:
            notes = {"limit cycles": self.branch.note if self.plan.branch is not None else ""}
        words = {"slow": "slow motion", "hopf": "onset of vibration", "steady": "steady vibration"}
        found = {words.get(t, t): getattr(self, t).note for t in topics if getattr(self, t).value is None}
        found |= {topic: note for topic, note in notes.items() if note}
        others = (d for d in self.designs if d.plan.kind != "quench" and d.design.value is None)
        found |= {f"design {d.plan.kind}": d.design.note for d in others}
        if self.sweep.value is not None and self.sweep.value.curves_note:
            found["predicted amplitudes"] = self.sweep.value.curves_note
        if not self.rows:
            found["comparison"] = "no formula applies to this scene"
        if not self.file.scene.contacts:
            found["friction"] = "the scene has no contacts"
        elif not any(c.effective for c in self.friction):
            note = next((c.note for c in self.friction if c.note), "")
            shaken = "the scene is not shaken, and the file designs no shaking"
            found["effective friction"] = note if is_excited(self.file.scene) and note else shaken
        if not self.designs:
            found["design"] = "the file has no [design]"
        return found


def measuring(file: SceneFile) -> SweepPlan:
    """Return the file's sweep, or a default measurement without one."""
    if file.sweep is not None:
        return file.sweep
    return SweepPlan("", 0.0, 0.0, 0, file.coordinate)


def study(file: SceneFile, progress: Progress | None = None, limit: float = LIMIT) -> StudyResult:
    """Compute the study of a scene file.

    Parameters
    ----------
    file : SceneFile
    progress : callable ``(stage, fraction) -> None``, optional
    limit : float
        Longest time for the runs of one part, s; designs and limit cycles may take ten times as long. What takes longer
        is left out, with this reason; what builds on it is not tried.

    Returns
    -------
    StudyResult
        A part without a value holds the reason; no exception is raised.
    """
    from symfric.solve.routes import explain
    from symfric.theory.equilibrium import equilibrium
    from symfric.theory.separation import separate
    from symfric.theory.stability import stability

    started = time.monotonic()
    tell = progress or (lambda _stage, _fraction: None)
    scene, plan = file.scene, measuring(file)
    tell("steady sliding and its stability", 0.0)
    slow = answer(separate, scene) if is_excited(scene) else StudyAnswer(scene)
    base = slow.value or scene
    at_rest, stable = answer(equilibrium, base), answer(stability, base)
    onset = within(limit, _onset, file, base)
    safe = within(LONGER * limit, _safe, file, onset)
    tell("motion", 0.1)
    moved = within(limit, answer, motion, scene, contact_outputs(scene))
    long = limit if out_of_time(moved) else LONGER * limit
    if file.structure is not None:
        tell("modes and flutter", 0.12)
    structure = structure_result(file, moved.value, at_rest.value)
    tell("steady vibration", 0.15)
    steady = _unless(moved, lambda: within(limit, answer, _steady, scene, plan))
    swept = within(limit, _swept, file, slow, onset, safe, lambda f: tell("sweep", 0.2 + 0.4 * f))
    if file.sweep is not None and file.sweep.branch is not None:
        tell("limit cycles", 0.6)
    branch = within(long, followed, file, onset)
    designs = within(long, _designs, file, lambda f: tell("design", 0.6 + 0.1 * f))
    quenched = within(limit, _quench, file, designs)
    if quenched.value is not None and swept.value is not None:
        told = lambda f: tell("sweep with design", 0.7 + 0.2 * f)  # noqa: E731
        swept = within(limit, _with_excitation, scene, plan, quenched.value, swept.value, told)
    tell("comparison", 0.95)
    shaken = None if quenched.value is None else quenched.value.design
    curves = friction_curves(scene, moved.value, at_rest.value, shaken)
    with time_limit(limit):
        rows = answer(compare, file, base, at_rest.value, onset.value, moved.value, steady.value, designs).value or ()
    return StudyResult(
        file,
        structure,
        branch,
        slow,
        at_rest,
        stable,
        onset,
        safe,
        moved,
        steady,
        swept,
        quenched,
        designs,
        answer(explain, as_run(scene.wanting({**scene.outputs, **contact_outputs(scene)}))),
        curves,
        (*onset_rows(file, base, structure, onset.value), *rows),
        versions(),
        time.monotonic() - started,
    )


def _unless(moved: StudyAnswer, part: Callable[[], StudyAnswer]) -> StudyAnswer:
    """Return the answer of a part, or why a motion that is shorter than the part's was stopped."""
    return StudyAnswer(None, moved.note) if out_of_time(moved) else part()


def _steady(scene: Scene, plan: SweepPlan) -> Vibration:
    return vibration(scene, plan.coordinate, schedule(scene, plan.settle, plan.window))


def _onset(file: SceneFile, base: Scene) -> StudyAnswer["HopfPoint"]:
    """Return the Hopf point on the range of the sweep."""
    from symfric.theory.hopf import hopf

    if file.sweep is None:
        return StudyAnswer(None, "the file has no [sweep], which says where to look for the onset of vibration")
    plan = file.sweep
    return answer(hopf, base, plan.parameter, (plan.start, plan.stop))


def _safe(file: SceneFile, onset: StudyAnswer["HopfPoint"]) -> StudyAnswer[SafeSpeed]:
    """Return the speed above which nothing vibrates, if vibration ends with the belt speed."""
    if onset.value is None or file.sweep is None:
        return StudyAnswer(None, onset.note)
    if is_excited(file.scene) or onset.value.parameter not in {s.name for s in belt_speeds(file.scene)}:
        return StudyAnswer(None, "asked of belt speeds only, without excitation")
    return answer(safe_speed, file.scene, file.sweep, onset.value.value)


def _swept(
    file: SceneFile,
    slow: StudyAnswer[Scene],
    onset: StudyAnswer["HopfPoint"],
    safe: StudyAnswer[SafeSpeed],
    progress: Callable[[float], None],
) -> StudyAnswer[SweepResult]:
    """Return computed and predicted amplitudes over the range of the sweep."""
    if file.sweep is None:
        return StudyAnswer(None, "the file has no [sweep]; add one to see the amplitude against a parameter")
    plan, scene = file.sweep, file.scene
    values = np.linspace(plan.start, plan.stop, plan.number)
    computed = answer(vibrations, scene, plan.parameter, values, plan, progress)
    if computed.value is None:
        return StudyAnswer(None, computed.note)
    curves, note = _curves(file, plan, slow)
    marks = {} if onset.value is None else {"onset of vibration": onset.value.value}
    if safe.value is not None and safe.value.overhangs and safe.value.ended:
        marks["quiet from here on"] = safe.value.value
    return StudyAnswer(SweepResult(plan.parameter, plan.coordinate, values, tuple(computed.value), curves, note, marks))


def _curves(file: SceneFile, plan: SweepPlan, slow: StudyAnswer[Scene]) -> tuple[tuple[PredictionCurve, ...], str]:
    """Return the predictions that apply, and why there is none."""
    if slow.value is None:
        return (), slow.note
    if file.structure is not None and len(slow.value.system.q) > 1:
        return (), f"averaging takes one coordinate and its velocity, and the structure has {len(slow.value.system.q)}"
    if plan.coordinate != slow.value.system.q[0].name:
        return (), f"averaging speaks of the coordinate {slow.value.system.q[0].name}, not of {plan.coordinate}"
    fine = np.linspace(plan.start, plan.stop, min(4 * plan.number - 3, FINE))
    averaged = answer(averaged_curves, slow.value, plan.parameter, fine)
    curves, note = list(averaged.value or ()), averaged.note
    if closed_forms_apply(file) and plan.parameter == "v_b":
        closed = answer(belt_curves, slow.value, fine)
        curves += closed.value or ()
        note = note or closed.note
    return tuple(curves), "" if curves else note


def _designs(file: SceneFile, progress: Callable[[float], None]) -> tuple[DesignResult, ...]:
    """Compute every design of the file."""
    found = []
    for k, plan in enumerate(file.designs):
        progress(k / len(file.designs))
        found.append(DesignResult(plan, answer(plan, file.scene)))
    return tuple(found)


def _quench(file: SceneFile, designs: tuple[DesignResult, ...]) -> StudyAnswer[QuenchResult]:
    """Return the designed excitation, with one motion without and one with it."""
    found = next((d for d in designs if d.plan.kind == "quench"), None)
    if found is None:
        return StudyAnswer(None, "the file has no [design.quench]")
    if found.design.value is None:
        return StudyAnswer(None, found.design.note)
    return answer(_shown, file.scene, found.plan, found.design.value)


def _shown(scene: Scene, plan: DesignPlan, design: "Design") -> QuenchResult:
    speeds = belt_speeds(scene)
    if not speeds:
        raise SceneError("no contact has a belt speed, so there is nothing to show the design at")
    shown = 0.5 * sum(plan.arguments["speeds"])
    still = scene.where({speeds[0].name: shown, "a": 0.0})
    shaken = scene.where({speeds[0].name: shown, **design.values})
    return QuenchResult(design, speeds[0].name, shown, motion(still), motion(shaken))


def _with_excitation(
    scene: Scene, plan: SweepPlan, quenched: QuenchResult, swept: SweepResult, progress: Callable[[float], None]
) -> StudyAnswer[SweepResult]:
    """Return the sweep with the additional half range under the designed excitation."""
    shaken = scene.where(quenched.design.values)
    found = answer(vibrations, shaken, plan.parameter, swept.values, plan, progress)
    if found.value is None:
        return StudyAnswer(swept)
    return StudyAnswer(replace(swept, quenched=np.array([v.half_range for v in found.value])))
