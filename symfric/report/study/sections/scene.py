"""The scene: its words, its sketch, its equations, its contacts and its values."""

from collections.abc import Collection, Iterator

import sympy as sp
from markupsafe import Markup

from symfric.model.symbols import counted
from symfric.model.system import Contact
from symfric.report.html.elements import gallery, heading, paragraph, subheading, table
from symfric.report.html.mathml import (
    equations_of_motion,
    friction_of_contact,
    inline,
    law_in_letters,
    opening_of_contact,
)
from symfric.report.html.words import inline_name, measure, number, with_unit
from symfric.report.study.drawing.sketch import picture
from symfric.report.study.section import Progress, Section, StudyResult
from symfric.scenefile import LawSpec, SceneFile, belt_speeds


def scene_in_words(file: SceneFile) -> str:
    """Return a sentence on coordinates, contacts, start and horizon."""
    scene = file.scene
    q, u = scene.system.q, scene.system.u
    pairs = [f"{a.name} (velocity {b.name})" for a, b in zip(q, u, strict=True)]
    numbers = scene.numbers()
    queued = {s for h in scene.held for s in h.states[1:]}
    shown = (s for s in scene.system.states if s not in queued)
    start = ", ".join(f"{s.name} = {measure(float(numbers[s]), s.name, file)}" for s in shown)
    origin = f"The ready scene {file.model}" if file.model else "Own equations"
    count = counted(len(q), "coordinate")
    rubs = ", ".join(_contact_in_words(c) for c in scene.contacts)
    kind = "contact" if scene.contacts_that_open else "dry contact"
    contacts = {0: f"No {kind}", 1: f"One {kind}"}.get(len(scene.contacts), f"{len(scene.contacts)} {kind}s")
    end = measure(scene.horizon, "t", file)
    return (
        f"{origin}: {count}, {', '.join(pairs)}. {contacts}{': ' + rubs if rubs else ''}. "
        f"The motion starts at {start} and is followed to t = {end}."
    )


def _contact_in_words(contact: Contact) -> str:
    """Return name, slip, load or gap of a contact."""
    text = contact.name
    if not contact.frictionless:
        shown = ", ".join(map(str, contact.slips))
        text += f", slipping at ({shown}) in the plane" if contact.in_plane else f", slipping at {shown}"
    if contact.unilateral is None:
        text += f" under the normal load {contact.normal}"
    else:
        text += (
            f"{',' if contact.frictionless else ''} with the gap {contact.unilateral.gap} "
            f"and the restitution {contact.unilateral.restitution}"
        )
    return text + (f" with the profile {contact.profile}" if contact.profile != 1 else "")


def contacts_and_values(study: StudyResult, contacts: dict[str, Contact]) -> Iterator[Markup]:
    """Yield the equations of contacts, by their headings, with coefficients, and the table of values."""
    file, scene = study.file, study.file.scene
    specs = {spec.contact: spec for spec in file.laws}
    taken = {s.name for s in (*scene.system.states, *scene.parameters)}
    for name, contact in contacts.items():
        spec = specs.get(contact.name)
        yield subheading(f"Contact {name}" + ("" if spec is None else f" ({spec.law} law)"))
        if contact.unilateral is not None:
            yield from opening_of_contact(contact)
        if not contact.frictionless:
            yield from friction_of_contact(contact, law_in_letters(spec, contact), taken)
        coefficients = [] if spec is None else list(_coefficients(spec, file, taken))
        if coefficients:
            yield paragraph(Markup("with {}").format(Markup(", ").join(coefficients)))
    yield subheading("Values")
    values = [
        [inline(s), number(v), file.units.get(s.name, ""), role(s, file)] for s, v in scene.parameter_values().items()
    ]
    yield table(["name", "value", "unit", ""], values, [1])


def _coefficients(spec: LawSpec, file: SceneFile, names: Collection[str]) -> Iterator[Markup]:
    """Yield the coefficients as the file gives them; the name of a value is mathematics and has its own line."""
    for name, value in spec.coefficients.items():
        if name != value:
            unit = "" if isinstance(value, str) else file.units.of_coefficient(spec.contact, name)
            text = inline_name(value) if isinstance(value, str) and value in names else shown(value)
            yield Markup("{} = {}").format(inline_name(name), with_unit(text, unit))


def shown(value: float | str | list[float | str]) -> str:
    """Return a number, an expression, or a list of them as text."""
    if isinstance(value, list):
        return "[" + ", ".join(shown(v) for v in value) + "]"
    return value if isinstance(value, str) else f"{value:g}"


def role(symbol: sp.Symbol, file: SceneFile) -> str:
    """Return the role of a value in the scene, as far as known."""
    roles = []
    if symbol in belt_speeds(file.scene):
        roles.append("drives a contact")
    if file.sweep is not None and file.sweep.parameter == symbol.name:
        low, high = f"{file.sweep.start:g}", measure(file.sweep.stop, symbol.name, file)
        roles.append(f"swept from {low} to {high}")
    if any(symbol.name in plan.varied for plan in file.designs):
        roles.append("designed")
    return ", ".join(roles)


def _compute(study: StudyResult, _tell: Progress) -> dict[str, object]:
    """Return what the scene is as plain data."""
    file, scene = study.file, study.file.scene
    numbers = scene.numbers()
    return {
        "model": file.model,
        "coordinates": [q.name for q in scene.system.q],
        "values": {s.name: v for s, v in scene.values.items()},
        "initial": {s.name: numbers[s] for s in scene.system.states},
        "horizon": scene.horizon,
        "units": dict(file.units),
    }


def _page(study: StudyResult) -> Iterator[Markup]:
    scene = study.file.scene
    if study.file.structure is not None:  # see matrices.py
        return
    yield heading("The scene", "scene")
    yield paragraph(study.said(scene_in_words(study.file)))
    yield gallery(lambda: [picture(scene)])
    yield from equations_of_motion(scene)
    yield from contacts_and_values(study, {c.name: c for c in scene.contacts})


SCENE = Section("scene", _compute, place=20, page=_page, key="scene", data=lambda _study, scene: scene)
