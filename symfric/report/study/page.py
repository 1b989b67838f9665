"""One self-contained HTML page of a study, without scripts or external files."""

import math
import re
from collections.abc import Callable, Collection, Iterable, Mapping
from dataclasses import replace
from functools import partial

import numpy as np
import sympy as sp
from markupsafe import Markup, escape
from sympy.core.alphabets import greeks

from symfric.report.html.mathml import (
    equations_of_motion,
    friction_of_contact,
    inline,
    law_in_letters,
    number_in_letters,
)
from symfric.report.html.versions import used
from symfric.report.study import designs, narrative, structure_words
from symfric.report.study.captions import Picture, designs_shown, pictures
from symfric.report.study.data import data_files
from symfric.report.study.quantities import powers_of_ten
from symfric.report.study.sketch import picture
from symfric.report.study.structure_page import parts_of_structure, shown_contacts, shown_states
from symfric.report.study.study import DesignResult, StudyResult
from symfric.scenefile.units import output_unit
from symfric.templates import render

_MINUS = re.compile(r"(?<=[ (])-(?=\d)")  # of a number


def page(result: StudyResult) -> str:
    """Return the page as HTML."""
    drawn = designs_shown(result)
    system = result.file.scene.system
    scene = result.file.scene
    names = [s.name for s in (*system.states, *system.rows, *scene.parameters)]
    expressions = [e for c in scene.contacts for e in (c.slip, c.normal, c.profile)]
    routes, left_out = narrative.route(result)
    said = partial(typeset, names=names, expressions=expressions)
    structure = parts_of_structure(result)
    return render(
        "study.html",
        typeset=said,
        title=result.file.title or "A scene with dry friction",
        result=result,
        file=result.file,
        words=narrative,
        shown={section: _captioned(shown, said) for section, shown in pictures(result).items()},
        comparison=[
            [
                said(r.quantity + (f" [{r.unit}]" if r.unit else "")),
                number(r.predicted),
                number(r.computed),
                narrative.percent(r.difference),
                said(r.formula),
            ]
            for r in result.rows
        ],
        structure=structure,
        branch=[] if result.branch.value is None else structure_words.branch(result.branch.value, result.file),
        sketch=(structure.sketch if structure else []) or [p for p in [picture(scene)] if p],
        equations=equations_of_motion(scene) if structure is None else structure.equations,
        contacts=_contacts(result),
        values=_without_empty(_values(result), 2),
        averaged=result.slow.value is not None and result.slow.value is not result.file.scene,
        balance=_balance(result),
        stability=_stability(result),
        outputs=_without_empty(_outputs(result), 2),
        no_effective=_no_effective(result),
        made=[_design(result, d, _captioned(drawn[d.plan.kind], said)) for d in result.designs],
        routes=routes,
        left_out=left_out,
        skipped=narrative.without_answer(result),
        data=list(data_files(result)),
        used=used(result.versions),
    )


MANY = 8  # coordinates, contacts and pairs of eigenvalues up to which all are shown


def _captioned(shown: list[Picture], said: Callable[[str], Markup]) -> list[Picture]:
    """Return pictures with the names of symbols in their captions set as mathematics."""
    return [replace(p, caption=said(p.caption)) for p in shown]


def typeset(text: str, names: Iterable[str], expressions: Iterable[sp.Expr] = ()) -> Markup:
    """Return a sentence with the names of symbols set as mathematics, and powers of ten.

    A name of one or two plain letters may be a word; it counts where a number follows, as in "a = 2". Of `expressions`,
    each counts where a sentence on contacts has it.
    """
    formulas = {str(e): e for e in expressions if not e.is_number}
    known = sorted({n for n in names if n.isidentifier()}, key=len, reverse=True)
    odd = [n for n in known if "_" in n or n[-1].isdigit() or n.lower() in (*greeks, "lambda")]
    forms = [
        rf"(?<={place} ){re.escape(n)}(?=[ ,.;]|$)"
        for n in sorted(formulas, key=len, reverse=True)
        for place in ("slipping at", "load", "profile")
    ]
    forms += [rf"{re.escape(n)}(?= = )" for n in known] + [rf"{re.escape(n)}(?![\w(])" for n in odd]
    forms += [rf"(?<={place} ){re.escape(n)}(?!\w)" for n in known for place in ("half range of", "mean of", "against")]
    forms += [rf"(?<=Velocity ){re.escape(n)}(?!\w)" for n in known]
    forms += [rf"\b{re.escape(n)}(?= (?:at rest|comes to rest|lies between)\b)" for n in known]
    text = _MINUS.sub("−", powers_of_ten(text)).replace("M^-1 B", "M⁻¹B")
    if not forms:
        return escape(text)
    parts = re.split(r"(?<![\w.])(" + "|".join(forms) + ")", text)
    set_in_letters = (
        (inline(formulas[p]) if p in formulas else inline_name(p)) if k % 2 else escape(p) for k, p in enumerate(parts)
    )
    return Markup("").join(set_in_letters)


def number(value: float, digits: int = 6) -> str:
    """Return a number as text."""
    if not math.isfinite(value):
        return "–"
    mantissa, _, exponent = f"{value:.{digits}g}".replace("-", "−").partition("e")
    power = str(int(exponent.replace("−", "-"))).replace("-", "−") if exponent else ""
    return Markup("{}·10<sup>{}</sup>").format(mantissa, power) if power else mantissa


def with_unit(value: str, unit: str) -> str:
    """Return a number with its unit."""
    return Markup("{} {}").format(value, unit) if unit else value


def _coefficient_unit(result: StudyResult, contact: str, name: str, value) -> str:
    """Return the unit of a coefficient that is a number; one that is a value of the scene has its own line."""
    return "" if isinstance(value, str) else result.file.units.of_coefficient(contact, name)


def inline_name(name: str) -> Markup:
    """Return a name as inline mathematics."""
    return inline(sp.Symbol(name))


def _contacts(result: StudyResult) -> list[dict]:
    """Return each contact with its equations and the coefficients that the file gives."""
    specs = {spec.contact: spec for spec in result.file.laws}
    scene, found = result.file.scene, []
    taken = {s.name for s in (*scene.system.states, *scene.parameters)}
    for name, contact in shown_contacts(result.file).items():
        spec = specs.get(contact.name)
        coefficients = {} if spec is None else spec.coefficients
        found.append(
            {
                "name": name,
                "law": None if spec is None else spec.law,
                "equations": friction_of_contact(contact, law_in_letters(spec, contact), taken),
                "coefficients": [
                    (inline_name(k), with_unit(_coefficient(v, taken), _coefficient_unit(result, contact.name, k, v)))
                    for k, v in coefficients.items()
                    if k != v
                ],
            }
        )
    return found


def _coefficient(value, names: Collection[str]) -> str:
    """Return a coefficient as the file gives it, the name of a value set as mathematics."""
    return inline_name(value) if isinstance(value, str) and value in names else narrative.shown(value)


def _values(result: StudyResult) -> list[list[str]]:
    file = result.file
    return [
        [inline(s), number(v), file.units.get(s.name, ""), narrative.role(s, file)]
        for s, v in file.scene.parameter_values().items()
    ]


def _without_empty(rows: list[list[str]], column: int) -> list[list[str]]:
    """Return rows without a column that is empty throughout."""
    if any(row[column] for row in rows):
        return rows
    return [[*row[:column], *row[column + 1 :]] for row in rows]


def _balance(result: StudyResult) -> dict | None:
    """Return the equilibrium and the sliding speeds there."""
    at = result.equilibrium.value
    if at is None:
        return None
    units, contacts = result.file.units, result.file.scene.contacts
    slips, one = {c.name: c.slip for c in contacts}, contacts[0].slip if contacts else sp.S.Zero
    known = dict(zip(at.names, at.x, strict=True))
    return {
        "position": [
            (inline_name(n), with_unit(number(known[n]), units.get(n, ""))) for n in shown_states(result.file, known)
        ],
        "sliding": [(n, with_unit(number(w), units.of(slips.get(n, one)))) for n, w in _alike(at.sliding).items()],
    }


def _alike(sliding: Mapping[str, float]) -> dict[str, float]:
    """Return one entry for all contacts if they are many and slide alike."""
    speeds = list(sliding.values())
    if len(speeds) > 3 and np.ptp(speeds) <= 1e-9 * np.max(np.abs(speeds)):
        return {"every contact": speeds[0]}
    return dict(sliding)


def _stability(result: StudyResult) -> dict | None:
    found, hertz = result.stability.value, result.file.units.hertz
    if found is None:
        return None
    return {
        "definiteness": found.definiteness,
        "reason": found.reason.replace("M^-1 B", "M⁻¹B"),
        "stable": found.stable,
        "growth": with_unit(number(-found.margin), result.file.units.rate),
        "head": _eigenvalue_head(result.file.units),
        "matrices": [
            (n, [[number_in_letters(v) for v in row] for row in np.atleast_2d(getattr(found, n))]) for n in "MBK"
        ]
        if len(found.eigenvalues) <= 2 * MANY
        else [],
        "eigenvalues": [
            [number(v.real), number(v.imag), *([number(abs(v.imag) * hertz)] if math.isfinite(hertz) else [])]
            for v in _leading(found.eigenvalues)
        ],
        "left": len(found.eigenvalues) - len(_leading(found.eigenvalues)),
    }


def _leading(eigenvalues: np.ndarray) -> np.ndarray:
    """Return the eigenvalues, of many the pairs that grow most or decay least."""
    if len(eigenvalues) <= 2 * MANY:
        return eigenvalues
    upper = eigenvalues[eigenvalues.imag >= 0]
    return upper[np.argsort(-upper.real, kind="stable")[:MANY]]


def _eigenvalue_head(units) -> list[str]:
    """Return the heading of the table of eigenvalues, with a column for Hz where time has a unit."""
    if not units.rate:
        return ["eigenvalue: real", "imaginary"]
    frequency = ["[Hz]"] if math.isfinite(units.hertz) else []
    return [f"eigenvalue: real [{units.rate}]", f"imaginary [{units.angular}]", *frequency]


def _outputs(result: StudyResult) -> list[list[str]]:
    motion, asked = result.motion.value, result.file.scene.outputs
    if motion is None:
        return []
    unit = lambda name: output_unit(result.file.units, asked[name]) if name in asked else ""  # noqa: E731
    return [[k, number(v, 9), unit(k)] for k, v in motion.outputs.items()]


def _no_effective(result: StudyResult) -> str:
    """Return why no curve of effective friction is shown; empty if one is."""
    return result.skipped().get("effective friction", "")


def _design(result: StudyResult, made: DesignResult, shown: list[Picture]) -> dict:
    head = {
        "heading": designs.heading(made.plan),
        "kind": made.plan.kind,
        "asked": designs.asked(made.plan, result.file),
    }
    design = made.design.value
    if design is None:
        return {**head, "note": made.design.note.rstrip(".")}
    names = list(design.values)
    rows = [
        [inline_name(name) if name in names else name, number(value), unit]
        for name, value, unit in designs.rows(made.plan, design, result.file)
    ]
    rows = _without_empty(rows, 2)
    return {**head, "note": "", "found": designs.found(design, result.file), "rows": rows, "shown": shown}
