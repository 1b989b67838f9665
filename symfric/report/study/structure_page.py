"""What a study page shows of a structure."""

import math
from collections.abc import Iterable
from dataclasses import dataclass, replace

import sympy as sp
from markupsafe import Markup

from symfric.model.symbols import TIME
from symfric.model.system import Contact
from symfric.report.study import structure_captions as drawn
from symfric.report.study import structure_words as words
from symfric.report.study.captions import Picture
from symfric.report.study.quantities import measured
from symfric.report.study.study import StudyResult
from symfric.scenefile import SceneFile
from symfric.structures.contacts import RowLoad

_SUM = "<munder><mo>∑</mo><mi>i</mi></munder>"


@dataclass(frozen=True)
class StructureParts:
    """Texts, tables and pictures of a structure.

    Attributes
    ----------
    sentence, reduction : str
    sketch, flutter, shapes, contacts : list of Picture
    equations : list of Markup
    flutter_note : str
        Why there is no flutter map.
    lines : list of str
        On the flutter.
    modes_head : list of str
    modes, shares : list of list of str
        Rows of the tables of frequencies and of contacts.
    shares_head : list of str
    """

    sentence: str
    reduction: str
    sketch: list[Picture]
    equations: list[Markup]
    flutter_note: str
    lines: list[str]
    flutter: list[Picture]
    shapes: list[Picture]
    modes_head: list[str]
    modes: list[list[str]]
    contacts: list[Picture]
    shares_head: list[str]
    shares: list[list[str]]


def parts_of_structure(result: StudyResult) -> StructureParts | None:
    """Return what the page shows of the structure; None if the scene is none."""
    found, file = result.structure, result.file
    if found is None:
        return None
    mesh, units = drawn.mesh_picture(result), file.units
    modes = found.modes.value
    hertz = math.isfinite(units.hertz)
    load = units.of(file.scene.contacts[0].normal) if file.scene.contacts else ""
    energy = units.of(file.scene.contacts[0].normal * file.scene.contacts[0].slip * TIME) if load else ""
    return StructureParts(
        sentence=words.scene_in_words(found.plan, file),
        reduction=words.reduction(found.plan, file),
        sketch=[mesh] if mesh else [],
        equations=[_equation(file)],
        flutter_note=found.flutter.note,
        lines=words.flutter(found, file),
        flutter=drawn.flutter_pictures(result),
        shapes=drawn.shape_pictures(result),
        modes_head=[
            "mode",
            "angular frequency" + (f" [{units.angular}]" if units.angular else ""),
            *(["[Hz]"] * hertz),
        ],
        modes=[]
        if modes is None
        else [[str(k + 1), *words.frequency(float(w), file)] for k, w in enumerate(modes.frequency)],
        contacts=drawn.contact_picture(result),
        shares_head=[
            "contact",
            "sticks [%]",
            "least load" + (f" [{load}]" if load else ""),
            "energy dissipated" + (f" [{energy}]" if energy else ""),
        ],
        shares=[
            [
                s.contact,
                measured(100 * s.sticks, ""),
                "0 (opens)" if s.least <= 0 else measured(s.least, ""),
                measured(s.dissipated, ""),
            ]
            for s in found.shares
        ],
    )


def _equation(file: SceneFile) -> Markup:
    """Return the equation of motion of matrices: forces, friction along slip rows, and loads that push."""
    plan, part = file.structure, file.scene.system.linear
    assert plan is not None
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


def _along_rows(contact: Contact) -> Contact:
    """Return a contact with short letters for its rows: u_slip for the velocity, n_load for what adds to the load."""
    letters = {s: sp.Symbol("u_slip", real=True) for s in contact.slip.free_symbols if s.name.startswith("slip row")}
    letters |= {s: sp.Symbol("n_load", real=True) for s in contact.normal.free_symbols if s.name.startswith("load row")}
    return replace(contact, slip=contact.slip.xreplace(letters), normal=contact.normal.xreplace(letters))


def shown_contacts(file: SceneFile) -> dict[str, Contact]:
    """Return the contacts whose friction a page writes out, by heading: of a structure one for each law."""
    contacts = file.scene.contacts
    if file.structure is None:
        return {c.name: c for c in contacts}
    found: dict[str, Contact] = {}
    for c in contacts:
        alike = [other.name for other in contacts if other.law == c.law]
        if alike[0] == c.name:
            rest = f" and {len(alike) - 1} more of the same law" if len(alike) > 1 else ""
            found[c.name + rest] = _along_rows(c)
    return found


def shown_states(file: SceneFile, known: Iterable[str]) -> list[str]:
    """Return the states whose values a page writes out: of a structure the points that are coordinates."""
    if file.structure is None:
        return list(known)
    return [name for name in file.structure.points if name in known]
