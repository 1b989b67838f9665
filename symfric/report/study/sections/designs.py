"""The designs that the file asks for, one for each table of [design]."""

from collections.abc import Iterator
from dataclasses import dataclass
from functools import partial

from markupsafe import Markup

from symfric.design.plan import Designed, DesignPlan
from symfric.errors import NotFound
from symfric.report.html.elements import Picture, gallery, heading, note, paragraph, table
from symfric.report.html.words import inline_name, number
from symfric.report.study import designs
from symfric.report.study.drawing.axes import new_axes, tidy, to_svg, with_units
from symfric.report.study.section import Progress, Section, StudyAnswer, StudyResult, answer
from symfric.report.study.sections.quench import QUENCH, before_after


@dataclass(frozen=True, eq=False)
class DesignResult:
    """One design of the file.

    Attributes
    ----------
    plan : DesignPlan
    design : StudyAnswer
        Of a design.
    """

    plan: DesignPlan
    design: StudyAnswer[Designed]


Made = tuple[DesignResult, ...]


def _compute(study: StudyResult, tell: Progress) -> Made:
    results, file = [], study.file
    for k, plan in enumerate(file.designs):
        tell("design", 0.6 + 0.1 * k / len(file.designs))
        results.append(DesignResult(plan, answer(plan, file.scene)))
    return tuple(results)


def _missing(_study: StudyResult, made: Made) -> dict[str, str]:
    others = (d for d in made if not d.plan.excites and d.design.value is None)
    return {f"design {d.plan.kind}": d.design.note for d in others}


def _summary(study: StudyResult, made: Made) -> list[str]:
    return [designs.sentence(d.plan, d.design.value, study.file) for d in made if d.design.value is not None]


def _page(study: StudyResult) -> Iterator[Markup]:
    file = study.file
    for made in study[DESIGNS].value or ():
        plan, design = made.plan, made.design.value
        yield heading(plan.heading, plan.kind)
        yield paragraph(study.said(designs.asked(plan, file)))
        if design is None:
            yield note(f"Not designed: {made.design.note.rstrip('.')}.")
            continue
        yield from (paragraph(study.said(line)) for line in designs.result_in_words(design, file))
        rows = [
            [inline_name(name) if name in design.values else name, number(value), unit]
            for name, value, unit in designs.rows(plan, design, file)
        ]
        yield table(["name", "value", "unit"], rows, [1])
        yield gallery(partial(_pictures, study, plan, design), study.said)


def _pictures(study: StudyResult, plan: DesignPlan, design: Designed) -> list[Picture]:
    quench = study[QUENCH].value
    motions = [before_after(quench, study.plan.coordinate, study.file)] if plan.excites and quench else []
    return [*motions, _picture(study, plan, design)]


def _picture(study: StudyResult, plan: DesignPlan, design: Designed) -> Picture:
    ax, caption = design.plot(new_axes()), plan.caption
    alt = f"{ax.get_ylabel()} against {ax.get_xlabel()}. {caption}"  # before names are set as mathematics
    ax.set_xlabel(with_units(ax.get_xlabel(), study.file.units))
    ax.set_ylabel(designs.axis(plan, ax.get_ylabel(), study.file))
    return Picture(to_svg(tidy(ax)), alt, caption)


def _data(_study: StudyResult, made: Made) -> dict[str, object]:
    return {d.plan.kind: None if d.design.value is None else d.design.value.to_dict() for d in made}


def _none(study: StudyResult, _tell: Progress) -> None:
    raise NotFound("the file has no [design]")


DESIGNS = Section(
    "designs",
    _compute,
    longer=True,
    place=80,
    page=_page,
    rank=6,
    summary=_summary,
    key="designs",
    data=_data,
    missing=_missing,
)
NO_DESIGN = Section("no_design", _none, topic="design", asked=lambda file: not file.designs)
