"""The scene of a structure: its matrices, their reduction, its mesh, and what its contacts have in common."""

from collections.abc import Iterator
from dataclasses import replace

import numpy as np
import sympy as sp
from markupsafe import Markup

from symfric.model.symbols import counted
from symfric.model.system import Contact
from symfric.report.html.elements import gallery, heading, paragraph
from symfric.report.html.words import angular_frequency, listed, measure
from symfric.report.study.drawing.mesh import mesh_picture
from symfric.report.study.drawing.sketch import picture
from symfric.report.study.section import Progress, Section, StudyResult
from symfric.report.study.sections.scene import contacts_and_values
from symfric.scenefile import SceneFile, StructurePlan
from symfric.structures.contacts import RowLoad

_SUM = "<munder><mo>∑</mo><mi>i</mi></munder>"


def is_structure(file: SceneFile) -> bool:
    """Whether the equations of a file are matrices."""
    return file.structure is not None


def plan_of(file: SceneFile) -> StructurePlan:
    """Return what a file says of its structure, which it must have."""
    assert file.structure is not None
    return file.structure


def values_of(file: SceneFile) -> dict[str, float]:
    """Return the numbers of a file's parameters by name."""
    return {s.name: v for s, v in file.scene.parameter_values().items()}


def scene_in_words(file: SceneFile) -> str:
    """Return the sentences on matrices, reduction, contacts and start."""
    plan, scene = plan_of(file), file.scene
    full, small = plan.full, plan.small
    parts = [n for n, e in (("M", full.M), ("K", full.K), ("C", full.C), ("friction", full.friction)) if e is not None]
    text = f"The matrices {', '.join(parts)} of {plan.origin} have {counted(full.n, 'degree')} of freedom"
    if small is not full:
        text += (
            f", reduced to {small.n} coordinates: what contacts, forces and points act on, and modes with these held"
        )
    contacts = [c.name for c in scene.contacts]
    text += f". {counted(len(contacts), 'dry contact') if contacts else 'No dry contact'}"
    text += f": {listed(contacts)}. " if contacts else ". "
    if plan.points:
        text += f"It is looked at in {listed(list(plan.points))}. "
    numbers = scene.numbers()
    moved = [f"{s.name} = {measure(float(numbers[s]), s.name, file)}" for s in scene.system.states if numbers[s]]
    start = f"with {listed(moved)}, otherwise at rest" if moved else "at rest"
    return text + f"The motion starts {start}, and is followed to t = {measure(scene.horizon, 't', file)}."


def reduction(file: SceneFile) -> str:
    """Return what the reduction costs; empty without one."""
    error = plan_of(file).small.error
    if error is None:
        return ""
    worst = float(np.max(error.frequency_error, initial=0.0))
    response = float(np.max(error.response, initial=0.0))
    return (
        f"What the reduction costs, estimated: frequencies up to {angular_frequency(0.5 * error.cut, file)} change by "
        f"{_percent(worst)} at most. The response of what is kept to a force along itself changes by "
        f"{_percent(response)} at worst, beside a resonance that shifts. More modes make both smaller."
    )


def _percent(part: float) -> str:
    return f"{100 * part:.0f} %" if part >= 0.1 else f"{100 * part:.2g} %"


def _equation(file: SceneFile) -> Markup:
    """Return the equation of motion of matrices: forces, friction along slip rows, and loads that push."""
    plan, part = plan_of(file), file.scene.system.linear
    assert part is not None
    damping = [f"{_mi('C')}{_over('q', '˙')}"] if part.C is not None else []
    left = [f"{_mi('M')}{_over('q', '¨')}", *damping, f"{_mi('K')}{_mi('q')}"]
    pushing = [c for c in plan.contacts if isinstance(c.normal, RowLoad) and c.normal.push is not None]
    right = [f"{_mi('f')}<mo>(</mo>{_mi('t')}<mo>)</mo>"] if len(part.loads) > len(pushing) else []
    if plan.contacts:
        right.append(f"{_SUM}{_row('s')}{_sub('F')}")
    if pushing:
        right.append(f"{_SUM}{_row('p')}<mo>(</mo>{_sub('N')}<mo>−</mo>{_sub('N', '0i')}<mo>)</mo>")
    both = "<mo>+</mo>".join(left) + "<mo>=</mo>" + ("<mo>+</mo>".join(right) or "<mn>0</mn>")
    return Markup(
        '<math display="block" aria-label="equation of motion of the matrices"><mrow>{}</mrow></math>'
    ).format(Markup(both))


def _mi(letter: str) -> str:
    return f"<mi>{letter}</mi>"


def _over(letter: str, dots: str) -> str:
    return f"<mover>{_mi(letter)}<mo>{dots}</mo></mover>"


def _sub(letter: str, index: str = "i") -> str:
    return f"<msub>{_mi(letter)}{_mi(index)}</msub>"


def _row(letter: str) -> str:
    return f"<msubsup>{_mi(letter)}{_mi('i')}{_mi('T')}</msubsup>"


def _one_of_each_law(file: SceneFile) -> dict[str, Contact]:
    """Return one contact for each law, by its heading."""
    contacts, shown = file.scene.contacts, {}
    for c in contacts:
        alike = [other.name for other in contacts if other.law == c.law]
        if alike[0] == c.name:
            rest = f" and {len(alike) - 1} more of the same law" if len(alike) > 1 else ""
            shown[c.name + rest] = _along_rows(c)
    return shown


def _along_rows(contact: Contact) -> Contact:
    """Return a contact with short letters for its rows: u_slip for the velocity, n_load for what adds to the load."""
    letters = {s: sp.Symbol("u_slip", real=True) for s in contact.slip.free_symbols if s.name.startswith("slip row")}
    letters |= {s: sp.Symbol("n_load", real=True) for s in contact.normal.free_symbols if s.name.startswith("load row")}
    return replace(contact, slip=contact.slip.xreplace(letters), normal=contact.normal.xreplace(letters))


def _compute(study: StudyResult, _tell: Progress) -> dict[str, object]:
    plan = plan_of(study.file)
    error = plan.small.error
    return {
        "matrices": plan.origin,
        "degrees_of_freedom": plan.full.n,
        "coordinates": plan.small.n,
        "points": {name: dict(row) for name, row in plan.points.items()},
        "reduction": None if error is None else error.to_dict(),
    }


def _page(study: StudyResult) -> Iterator[Markup]:
    file = study.file
    yield heading("The scene", "scene")
    yield paragraph(study.said(scene_in_words(file)))
    if cost := reduction(file):
        yield paragraph(study.said(cost))
    yield gallery(lambda: [mesh_picture(plan_of(file)) or picture(file.scene)])
    yield _equation(file)
    yield from contacts_and_values(study, _one_of_each_law(file))


MATRICES = Section(
    "matrices",
    _compute,
    asked=is_structure,
    place=20,
    page=_page,
    key="structure",
    data=lambda _study, matrices: matrices,
)
