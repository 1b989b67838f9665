"""One self-contained HTML page of a study, without scripts or external files."""

import math

import numpy as np
import sympy as sp
from markupsafe import Markup

from symfric.report.html.mathml import (
    equations_of_motion,
    friction_of_contact,
    inline,
    law_in_letters,
    number_in_letters,
)
from symfric.report.html.versions import used
from symfric.report.study import designs, narrative
from symfric.report.study.captions import Picture, designs_shown, pictures
from symfric.report.study.study import DesignResult, StudyResult
from symfric.templates import render


def page(result: StudyResult) -> str:
    """Return the page as HTML."""
    route = result.explanation.note if result.explanation.value is None else str(result.explanation.value)
    drawn = designs_shown(result)
    return render(
        "study.html",
        title=result.file.title or "A scene with dry friction",
        result=result,
        file=result.file,
        words=narrative,
        shown=pictures(result),
        comparison=[
            [r.quantity, number(r.predicted), number(r.computed), narrative.percent(r.difference), r.formula]
            for r in result.rows
        ],
        equations=equations_of_motion(result.file.scene),
        contacts=_contacts(result),
        values=_values(result),
        averaged=result.slow.value is not None and result.slow.value is not result.file.scene,
        balance=_balance(result),
        stability=_stability(result),
        outputs=_outputs(result),
        no_effective=_no_effective(result),
        made=[_design(result, d, drawn[d.plan.kind]) for d in result.designs],
        route=[line for line in route.splitlines() if line.strip()],
        skipped=result.skipped(),
        used=used(result.versions),
    )


def number(value: float, digits: int = 6) -> str:
    """Return a number as text."""
    if not math.isfinite(value):
        return "–"
    mantissa, _, exponent = f"{value:.{digits}g}".replace("-", "−").partition("e")
    power = str(int(exponent.replace("−", "-"))).replace("-", "−") if exponent else ""
    return Markup("{}·10<sup>{}</sup>").format(mantissa, power) if power else mantissa


def inline_name(name: str) -> Markup:
    """Return a name as inline mathematics."""
    return inline(sp.Symbol(name))


def _contacts(result: StudyResult) -> list[dict]:
    """Return each contact with its equations and the coefficients that the file gives."""
    specs = {spec.contact: spec for spec in result.file.laws}
    found = []
    for contact in result.file.scene.contacts:
        spec = specs.get(contact.name)
        coefficients = {} if spec is None else spec.coefficients
        found.append(
            {
                "name": contact.name,
                "law": None if spec is None else spec.law,
                "equations": friction_of_contact(contact, law_in_letters(spec, contact)),
                "coefficients": [(inline_name(k), narrative.shown(v)) for k, v in coefficients.items()],
            }
        )
    return found


def _values(result: StudyResult) -> list[list[str]]:
    file = result.file
    return [
        [inline(s), number(v), file.units.get(s.name, ""), narrative.role(s, file)]
        for s, v in file.scene.parameter_values().items()
    ]


def _balance(result: StudyResult) -> dict | None:
    """Return the equilibrium and the sliding speeds there."""
    at = result.equilibrium.value
    if at is None:
        return None
    return {
        "position": [(inline_name(n), number(v)) for n, v in zip(at.names, at.x, strict=True)],
        "sliding": [(n, number(w)) for n, w in at.sliding.items()],
    }


def _stability(result: StudyResult) -> dict | None:
    found = result.stability.value
    if found is None:
        return None
    return {
        "definiteness": found.definiteness,
        "reason": found.reason,
        "stable": found.stable,
        "growth": number(-found.margin),
        "matrices": [
            (n, [[number_in_letters(v) for v in row] for row in np.atleast_2d(getattr(found, n))]) for n in "MBK"
        ],
        "eigenvalues": [[number(v.real), number(v.imag)] for v in found.eigenvalues],
    }


def _outputs(result: StudyResult) -> list[list[str]]:
    motion = result.motion.value
    return [] if motion is None else [[k, number(v, 9)] for k, v in motion.outputs.items()]


def _no_effective(result: StudyResult) -> str:
    """Return why no curve of effective friction is shown; empty if one is."""
    if any(c.effective for c in result.friction):
        return ""
    shaken = "the scene is not shaken, and the file designs no shaking"
    return next((c.note for c in result.friction if c.note), shaken)


def _design(result: StudyResult, made: DesignResult, shown: list[Picture]) -> dict:
    head = {"heading": designs.heading(made.plan), "kind": made.plan.kind, "asked": designs.asked(made.plan)}
    design = made.design.value
    if design is None:
        return {**head, "note": made.design.note.rstrip(".")}
    names = list(design.values)
    rows = [
        [inline_name(name) if name in names else name, number(value), unit]
        for name, value, unit in designs.rows(made.plan, design, result.file)
    ]
    return {**head, "note": "", "found": designs.found(design), "rows": rows, "shown": shown}
