"""The onset of vibration, asked by [sweep]: the Hopf point, and the speed above which nothing vibrates."""

from collections.abc import Iterator
from dataclasses import asdict, dataclass
from typing import Any

from markupsafe import Markup

from symfric.errors import NoRoute, NotFound, SceneError
from symfric.model.excitation import is_excited
from symfric.model.outputs import Max, Min
from symfric.model.scene import Scene
from symfric.orbits.continuation.branch import continue_cycle
from symfric.orbits.steady_state import END, Settling, schedule
from symfric.report.html.elements import paragraph
from symfric.report.html.words import angular_frequency, measure
from symfric.report.study.section import Progress, Section, StudyResult
from symfric.report.study.sections.stability import base, what_slides
from symfric.scenefile import SceneFile, SweepPlan, belt_speeds
from symfric.theory.hopf import HopfPoint, hopf

_FACTOR, _MOST = 1.05, 60  # steps up, and how many of them
_HALVINGS = 12
_SLOW = 0.02  # beyond the onset, relative to it
_GONE = 1e-3  # half range, relative to that of the vibration at the start, that counts as none
_HOW = {
    "supercritical": "gently: small stable vibrations exist beside the onset",
    "subcritical": "by a jump: beside the onset only large vibrations are stable",
    "degenerate": "as sticking and lift-off decide: the cubic terms vanish",
}


def _compute(study: StudyResult, _tell: Progress) -> HopfPoint:
    plan = study.file.sweep
    if plan is None:
        raise NotFound("the file has no [sweep], which says where to look for the onset of vibration")
    return hopf(base(study), plan.parameter, (plan.start, plan.stop))


def onset_in_words(point: HopfPoint, file: SceneFile) -> str:
    """Return the sentence on the Hopf point."""
    how = _HOW[point.kind]
    if point.kind == "degenerate" and not file.scene.contacts:
        how = "as terms beyond the cubic ones decide: those vanish"
    return (
        f"{what_slides(file.scene)} changes its stability at {point.parameter} = "
        f"{measure(point.value, point.parameter, file)} with the angular frequency "
        f"{angular_frequency(point.omega, file)} ({point.kind} Hopf point); vibration sets in {how}."
    )


def _page(study: StudyResult) -> Iterator[Markup]:
    answered = study[HOPF]
    if answered.value is not None:
        yield paragraph(study.said(onset_in_words(answered.value, study.file)))
    elif study.file.sweep is not None:
        yield paragraph(study.said(f"Onset of vibration: {answered.note}."))


def _summary(study: StudyResult, point: HopfPoint) -> list[str]:
    return [onset_in_words(point, study.file)]


HOPF = Section("hopf", _compute, topic="onset of vibration", place=41, page=_page, rank=4, summary=_summary, key="hopf")


@dataclass(frozen=True)
class SafeSpeed:
    """Where a vibration that is followed to higher speeds ends.

    Attributes
    ----------
    parameter : str
    value : float
        The lowest speed at which it was not found any more.
    onset : float
        Speed at which steady sliding becomes stable.
    ended : bool
        Whether it ended; if not, `value` is the highest speed that was tried.
    """

    parameter: str
    value: float
    onset: float
    ended: bool = True

    @property
    def overhangs(self) -> bool:
        """Whether vibrations go on beyond the onset of small ones; just beyond, they die too slowly to tell."""
        return self.value > (1 + _SLOW) * self.onset

    def to_dict(self) -> dict[str, object]:
        """Return plain data."""
        return {**asdict(self), "overhangs": self.overhangs}


def safe_speed(scene: Scene, plan: SweepPlan, onset: float) -> SafeSpeed:
    """Follow the vibration of a scene to higher speeds until it ends.

    Parameters
    ----------
    scene : Scene
        Vibrates at the value it has of the plan's parameter.
    plan : SweepPlan
    onset : float
        Where steady sliding becomes stable.

    Raises
    ------
    NotFound
        If it does not vibrate at the value it has.
    """
    (coordinate,) = (s for s in scene.system.states if s.name == plan.coordinate)
    settling = Settling(
        scene, schedule(scene, plan.settle, plan.window), {"low": Min(coordinate), "high": Max(coordinate)}
    )

    def after(value: float, start: dict[str, Any] | None) -> tuple[float, dict[str, Any]]:
        run = settling.measured({plan.parameter: value}, start)
        return 0.5 * float(run["high"] - run["low"]), settling.start(run[END])

    low = float(scene.numbers()[scene.parameter(plan.parameter)])
    size, state = after(low, None)
    if not low > 0 or size <= 1e-9 * abs(state[plan.coordinate]):
        raise NotFound(f"nothing vibrates at {plan.parameter} = {low:g}")
    high = low
    for _ in range(_MOST):
        high *= _FACTOR
        left, settled = after(high, state)
        if left <= _GONE * size:
            break
        low, state = high, settled
    else:
        return SafeSpeed(plan.parameter, low, onset, ended=False)
    for _ in range(_HALVINGS):
        middle = 0.5 * (low + high)
        left, settled = after(middle, state)
        if left <= _GONE * size:
            high = middle
        else:
            low, state = middle, settled
    return SafeSpeed(plan.parameter, max(high, _end_of_orbits(scene, plan, high)), onset)


def _end_of_orbits(scene: Scene, plan: SweepPlan, expected: float) -> float:
    """Return the largest speed with a stable orbit on the branch of one mass, from which motions fall away before."""
    if len(scene.system.q) > 1:
        return 0.0
    now = float(scene.numbers()[scene.parameter(plan.parameter)])
    try:
        branch = continue_cycle(scene, plan.parameter, (now, 1.5 * max(now, expected)))
    except (NotFound, SceneError, NoRoute, NotImplementedError):
        return 0.0
    return max((float(v) for v, o in zip(branch.values, branch.orbits, strict=True) if o.stable), default=0.0)


def _safe(study: StudyResult, _tell: Progress) -> SafeSpeed:
    file, onset = study.file, study[HOPF].found
    plan = file.sweep
    if plan is None or is_excited(file.scene) or onset.parameter not in {s.name for s in belt_speeds(file.scene)}:
        raise NotFound("asked of belt speeds only, without excitation")
    return safe_speed(file.scene, plan, onset.value)


def safe_in_words(safe: SafeSpeed, file: SceneFile) -> str:
    """Return the sentence on the speed above which nothing vibrates."""
    if not safe.overhangs:
        value = measure(safe.onset, safe.parameter, file)
        return f"Quiet above {safe.parameter} = {value}: the vibration ends where steady sliding becomes stable."
    value = measure(float(f"{safe.value:.3g}"), safe.parameter, file)
    if not safe.ended:
        return (
            f"No speed is quiet as far as was tried, up to {safe.parameter} = {value}: there small disturbances "
            "die out, but a vibration that has started goes on."
        )
    return (
        f"Quiet from about {safe.parameter} = {value}: up to there a vibration that has started goes on, though "
        "small disturbances die out before. The speed to stay above is this one, not the onset."
    )


def _safe_summary(study: StudyResult, safe: SafeSpeed) -> list[str]:
    return [safe_in_words(safe, study.file)]


SAFE = Section("safe", _safe, longer=True, rank=5, summary=_safe_summary, key="safe_speed")
