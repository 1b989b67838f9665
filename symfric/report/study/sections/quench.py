"""One motion without and with the designed fast excitation, asked by [design.quench]."""

from collections.abc import Mapping
from dataclasses import dataclass

from symfric.design.plan import Designed
from symfric.errors import SceneError
from symfric.model.scene import Scene
from symfric.report.html.elements import Picture
from symfric.report.html.words import measure
from symfric.report.study.drawing.axes import GREEN, GREY, Axes, label, legend, new_axes, tidy, to_svg
from symfric.report.study.measurement import SampledMotion, motion
from symfric.report.study.section import Progress, Section, StudyResult
from symfric.scenefile import SceneFile, belt_speeds


@dataclass(frozen=True, eq=False)
class QuenchResult:
    """The designed excitation and one motion without and with it.

    Attributes
    ----------
    design : Designed
    excited : Scene
        With the excitation.
    speed : str
        Name of the belt speed.
    shown : float
        Its value in the two motions.
    before, after : SampledMotion
    """

    design: Designed
    excited: Scene
    speed: str
    shown: float
    before: SampledMotion
    after: SampledMotion


def _compute(study: StudyResult, _tell: Progress) -> QuenchResult:
    scene, made = study.file.scene, next(d for d in study.designs.found if d.plan.excites)
    design, speeds = made.design.found, belt_speeds(scene)
    if not speeds:
        raise SceneError("no contact has a belt speed, so there is nothing to show the design at")
    shown = 0.5 * sum(made.plan.arguments["speeds"])
    still, excited = scene.where({speeds[0].name: shown, "a": 0.0}), made.plan.excited(scene, design)
    shaken = excited.where({speeds[0].name: shown})
    return QuenchResult(design, excited, speeds[0].name, shown, motion(still), motion(shaken))


def before_after(result: QuenchResult, q: str, file: SceneFile) -> Picture:
    """Draw a coordinate in the motions without and with the designed excitation."""
    at = measure(result.shown, result.speed, file)
    caption = f"At {result.speed} = {at}, without and with the designed excitation."
    ax = plot_before_after(result.before, result.after, q, file.units)
    return Picture(to_svg(ax), f"{q} against time. {caption}", caption)


def plot_before_after(
    before: SampledMotion, after: SampledMotion, coordinate: str, units: Mapping[str, str], ax: Axes | None = None
) -> Axes:
    """Draw one coordinate against time without and with the fast excitation."""
    ax = new_axes() if ax is None else ax
    for moved, colour, words, width in ((before, GREY, "without", 1.0), (after, GREEN, "with", 1.2)):
        x = moved.x[moved.names.index(coordinate)]
        ax.plot(moved.t, x, color=colour, linewidth=width, label=f"{words} the fast excitation")
    ax.set_xlim(before.t[0], before.t[-1])
    ax.set_xlabel(label("t", units))
    ax.set_ylabel(label(coordinate, units))
    legend(ax)
    return tidy(ax)


QUENCH = Section(
    "quench",
    _compute,
    topic="quench",
    asked=lambda file: file.plan("quench") is not None,
    key="quench",
    data=lambda _study, result: result.design.to_dict(),
)
