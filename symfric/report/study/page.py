"""One self-contained HTML page of a study, without scripts or external files."""

from markupsafe import Markup

from symfric.report.html.elements import bullets
from symfric.report.study.section import StudyResult
from symfric.templates import render


def summary(study: StudyResult) -> list[str]:
    """Return the main findings as sentences."""
    ranked = sorted(study.answered, key=lambda pair: pair[0].rank)
    lines = [line for section, value in ranked for line in section.summary(study, value)]
    return lines or ["Nothing could be said of this scene; the reasons are at the end of the page."]


def page(study: StudyResult) -> str:
    """Return the page as HTML."""
    return render(
        "study.html",
        title=study.file.title or "A scene with dry friction",
        paragraphs=[" ".join(p.split()) for p in study.file.description.split("\n\n") if p.strip()],
        summary=bullets(study.said(line) for line in summary(study)),
        parts=[Markup("\n").join(section.page(study)) for section in sorted(study.asked, key=lambda s: s.place)],
    )
