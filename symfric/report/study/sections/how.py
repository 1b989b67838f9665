"""How the study was computed, what was left out and why, and the data beside the page."""

from collections.abc import Iterator

from markupsafe import Markup

from symfric.report.html.elements import bullets, can_draw, heading, paragraph, table
from symfric.report.html.versions import used
from symfric.report.study.measurement import as_run, contact_outputs
from symfric.report.study.section import Progress, Section, StudyResult
from symfric.solve.routes import Explanation, explain


def _compute(study: StudyResult, _tell: Progress) -> Explanation:
    scene = study.file.scene
    return explain(as_run(scene.wanting({**scene.outputs, **contact_outputs(scene)})))


def without_answer(study: StudyResult) -> list[str]:
    """Return one line for each reason why parts of the study have no result."""
    topics: dict[str, list[str]] = {}
    for topic, reason in study.skipped().items():
        topics.setdefault(reason, []).append(topic)
    lines = [f"{', '.join(names)}: {reason}" for reason, names in topics.items()]
    return lines if can_draw() else ["pictures: python -m pip install matplotlib adds them", *lines]


def _text(study: StudyResult) -> str:
    answered = study[EXPLANATION]
    return answered.note if answered.value is None else str(answered.value)


def _page(study: StudyResult) -> Iterator[Markup]:
    lines = [line.strip().partition(": ") for line in _text(study).splitlines() if line.strip()]
    rows = [[name.rstrip(":"), text] for name, _, text in lines]
    names = [name for name, _ in rows]
    end = names.index("skipped") if "skipped" in names else len(names)
    yield heading("How it was computed, and what was not", "how")
    yield table(["route", "why, or why not"], [row for row in rows[:end] if row[0] != "route"])
    if rows[end + 1 :]:
        yield table(["left out of the run", "because"], rows[end + 1 :])
    if skipped := without_answer(study):
        yield paragraph("Without an answer:") + bullets(study.said(line) for line in skipped)
    links = Markup(", ").join(
        Markup('<a href="{}">{}</a>').format(name, name) for name in ("study.json", *study.tables())
    )
    yield paragraph(Markup("Data beside this page: {}.").format(links))
    yield Markup("<footer>From <code>{}</code> in {} s with {}.</footer>").format(
        study.file.path, f"{study.seconds:.1f}", used(study.versions)
    )


def _data(_study: StudyResult, explanation: Explanation) -> str:
    return str(explanation)


EXPLANATION = Section("explanation", _compute, place=90, page=_page, key="explanation", data=_data)
