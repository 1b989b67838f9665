"""What contacts that open do during the motion: sticking, open, impacts, largest normal force."""

from collections.abc import Iterator
from dataclasses import asdict, dataclass

from markupsafe import Markup

from symfric.report.html.elements import Picture, gallery, note, subheading, table
from symfric.report.html.words import measured
from symfric.report.study.drawing.axes import to_svg
from symfric.report.study.measurement import SampledMotion, largest_load
from symfric.report.study.section import Progress, Section, StudyResult
from symfric.report.study.sections.contacts import plot_contacts
from symfric.report.study.sections.motion import MOTION
from symfric.scenefile import SceneFile


@dataclass(frozen=True)
class OpeningShare:
    """What a contact of a scene with contacts that open does during the motion.

    Attributes
    ----------
    sticks, open : float
        Fractions of the time.
    impacts : int
    largest_load : float
        Largest normal force, impacts apart.
    """

    sticks: float
    open: float
    impacts: int
    largest_load: float


def _asked(file: SceneFile) -> bool:
    return bool(file.scene.contacts_that_open)


def _compute(study: StudyResult, _tell: Progress) -> dict[str, OpeningShare]:
    motion, scene = study[MOTION].found, study.file.scene
    end = float(motion.t[-1])
    return {
        c.name: OpeningShare(
            sum(b - a for a, b in motion.sticks[c.name]) / end,
            sum(b - a for a, b in motion.opens[c.name]) / end,
            motion.impacts.get(c.name, 0),
            motion.also[largest_load(c.name)],
        )
        for c in scene.contacts
    }


def _page(study: StudyResult) -> Iterator[Markup]:
    shares = study[OPENINGS].value
    if not shares:
        return
    unit = study.file.units.of(study.file.scene.contacts_that_open[0].normal)
    head = ["contact", "sticks [%]", "open [%]", "impacts", "largest normal force" + (f" [{unit}]" if unit else "")]
    rows = [
        [name, measured(100 * s.sticks), measured(100 * s.open), str(s.impacts), measured(s.largest_load)]
        for name, s in shares.items()
    ]
    yield subheading("What the contacts do")
    yield gallery(lambda: [_picture(study, study[MOTION].found)])
    yield table(head, rows, [1, 2, 3, 4])
    yield note("The normal force is that between impacts; a landing after bounces that die out counts as one impact.")


def _picture(study: StudyResult, motion: SampledMotion) -> Picture:
    """Draw when the contacts stick and are open over the motion."""
    states = {name: (motion.sticks[name], motion.opens[name]) for name in motion.opens}
    span = float(motion.t[0]), float(motion.t[-1])
    return Picture(
        to_svg(plot_contacts(states, span, study.file.units, "closed")),
        f"When each of {len(states)} contacts sticks, is closed without sticking, and is open",
        "The contacts over the motion: sticking, closed without sticking, open.",
    )


OPENINGS = Section(
    "openings",
    _compute,
    asked=_asked,
    place=51,
    page=_page,
    key="contacts",
    data=lambda _study, shares: {name: asdict(s) for name, s in shares.items()},
)
