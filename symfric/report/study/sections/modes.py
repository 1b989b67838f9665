"""The lowest modes of a structure with the contacts closed, and the shapes that begin to grow."""

import math
from collections.abc import Iterator

import numpy as np
from markupsafe import Markup

from symfric.report.html.elements import gallery, note, paragraph, table
from symfric.report.html.words import measured
from symfric.report.study.drawing.mesh import shape_picture
from symfric.report.study.section import Progress, Section, StudyResult, answer
from symfric.report.study.sections.flutter import FLUTTER
from symfric.report.study.sections.matrices import is_structure, plan_of, values_of
from symfric.structures import sliding
from symfric.structures.real_modes import Modes

COUNT = 6  # of the table of frequencies
SHAPES = 2  # shapes that are shown


def _compute(study: StudyResult, tell: Progress) -> Modes:
    tell("modes and flutter", 0.6)
    plan = plan_of(study.file)
    closed = answer(sliding, plan.full, plan.contacts, values_of(study.file))
    return (closed.value or plan.full).modes(min(COUNT, plan.full.n))


def _shapes(study: StudyResult) -> Iterator[tuple[np.ndarray, str]]:
    """Yield the shapes that begin to grow, or the lowest modes if none does."""
    flutter, modes = study[FLUTTER].value, study[MODES].value
    if flutter is not None and flutter.map.critical:
        for shape, point in zip(flutter.map.shapes, flutter.map.critical[:SHAPES], strict=False):
            yield shape, f"What begins to grow at {point.mu:.4g}"
    elif modes is not None:
        for k in range(min(SHAPES, modes.frequency.size)):
            yield modes.shapes[:, k].astype(complex), f"Mode {k + 1}"


def _page(study: StudyResult) -> Iterator[Markup]:
    plan, answered, units = plan_of(study.file), study[MODES], study.file.units
    yield gallery(lambda: (shape_picture(plan, shape, words) for shape, words in _shapes(study)))
    if answered.value is None:
        yield note(f"Modes: {answered.note}")
        return
    in_hertz = math.isfinite(units.hertz)
    head = ["mode", "angular frequency" + (f" [{units.angular}]" if units.angular else ""), *(["[Hz]"] * in_hertz)]
    rows = [
        [str(k + 1), measured(w), *([f"{w * units.hertz:.5g}"] * in_hertz)]
        for k, w in enumerate(answered.value.frequency)
    ]
    yield paragraph("The lowest modes with the contacts closed, without friction and damping:")
    yield table(head, rows, [0, 1, 2])


MODES = Section(
    "modes",
    _compute,
    topic="modes",
    asked=is_structure,
    place=31,
    page=_page,
    key="structure.modes",
    data=lambda _study, modes: modes.frequency,
)
