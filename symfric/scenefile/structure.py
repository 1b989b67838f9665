"""Scenes of structures: matrices from a file or a maker, and contacts along rows."""

import inspect
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any

import sympy as sp

from symfric.errors import SceneError
from symfric.model.laws import Law
from symfric.model.scene import Scene
from symfric.model.symbols import TIME, nearest, shorten
from symfric.scenefile.arguments import (
    as_expr,
    call,
    call_at,
    check_arguments,
    exact,
    exact_numbers,
    finite_value,
    real_symbols,
)
from symfric.scenefile.contact_tables import RowFriction
from symfric.scenefile.laws import LawSpec, contact_name, contact_place, law_of, spec_of
from symfric.scenefile.places import Places, read_places
from symfric.scenefile.schema import Document
from symfric.scenefile.structure_tables import FlutterTable, Source, StructureScene

if TYPE_CHECKING:  # slow to import, and few files have a structure
    from symfric.structures.contacts import RowContact
    from symfric.structures.structure import Structure

Given = str | float  # an expression, or a number
MAKERS = ("beam", "chain", "disc_and_pad", "ziegler")
MOST_MADE = 3000  # largest number that a maker takes for the size of what it makes
MOST_KEPT = 200  # degrees of freedom up to which a structure is not reduced


@dataclass(frozen=True, eq=False)
class StructurePlan:
    """What the page of a structure needs beside its scene.

    Attributes
    ----------
    origin : str
        File or maker.
    full : Structure
        As it is given.
    small : Structure
        Of the scene; `full` itself if it is not reduced.
    contacts : tuple of RowContact
    points : dict of str to dict of str to float
        What is looked at, by its name in the scene: weights of degrees of freedom.
    places : Places or None
    flutter : FlutterTable or None
    loaded : bool
        Whether forces act beside those of the contacts.
    """

    origin: str
    full: "Structure"
    small: "Structure"
    contacts: "tuple[RowContact, ...]"
    points: Mapping[str, Mapping[str, float]]
    places: Places | None
    flutter: FlutterTable | None
    loaded: bool = False


@dataclass
class _Source:
    """Matrices, with what a maker knows of their contacts and places."""

    structure: "Structure"
    origin: str
    pairs: Callable[..., "list[RowContact]"] | None = None
    places: Places | None = None


@dataclass
class _Names:
    """Names that expressions over a structure may contain.

    `states` are the coordinates and velocities of degrees of freedom and points by name, `known` also the parameters.
    """

    states: dict[str, sp.Expr]
    known: dict[str, sp.Expr]
    of: dict[sp.Symbol, tuple[str, str]] = field(default_factory=dict)  # kind, "q" or "u", and name of a state

    def row(self, given: Given | Mapping[str, float], place: str, kind: str = "q") -> dict[str, float]:
        """Return the weights of a row that is an expression or a table."""
        if isinstance(given, Mapping):
            return dict(given)
        weights, rest = self.parts(given, place, kind)
        if rest != 0:
            raise SceneError(f"{place} is {shorten(given, 60)}; it must be a sum of degrees of freedom with numbers")
        return weights

    def parts(self, given: Given, place: str, kind: str) -> tuple[dict[str, float], sp.Expr]:
        """Return the weights in a linear expression, and what is left without the degrees of freedom."""
        e = as_expr(given, place, self.known)
        used = sorted((s for s in e.free_symbols if s in self.of), key=str)
        word = {"q": "coordinates", "u": "velocities"}[kind]
        weights = {}
        for s in used:
            own, name = self.of[s]
            slope = e.diff(s)
            if own != kind or not slope.is_number:
                raise SceneError(f"{place} is {shorten(given, 60)}; it must be linear in {word}, with numbers")
            weights[name] = float(slope)
        return weights, sp.expand(e.xreplace(dict.fromkeys(used, sp.S.Zero)))


def build_structure(
    document: Document, section: StructureScene, folder: Path | None
) -> tuple[Scene, tuple[LawSpec, ...], StructurePlan]:
    """Return the scene of a structure, its laws for display, and what its page needs; without the file's outputs."""
    source = _source(section.structure, folder)
    full = source.structure
    parameters = real_symbols(document.values)
    names = _names(full, section, parameters)
    contacts, specs = _contacts(document, source, names, parameters)
    points = {name: names.row(row, f"scene.points.{shorten(name, 40)}") for name, row in section.points.items()}
    for name, row in points.items():
        _known(row, full, f"scene.points.{shorten(name, 40)}")
    pushed = {name: points.get(name, {name: 1.0}) for name in section.force}
    for name, row in pushed.items():
        _known(row, full, f"scene.force.{shorten(name, 40)}")
    small = full
    if section.modes is not None:
        kept = [_kept(row) for row in (*points.values(), *pushed.values())]
        small = call("scene.modes", full.reduced, {"keep": [*kept, *contacts], "modes": section.modes})
    elif full.n > MOST_KEPT:
        raise SceneError(
            f"scene.modes is missing: the structure has {full.n} degrees of freedom; say how many modes are kept, as 20"
        )
    own = {s.name: s for group in small.symbols for s in group}
    observed = {name: row for name, row in points.items() if not (name in own and row == {name: 1.0})}
    own |= {n: s for name in observed for n, s in real_symbols([name, f"d_{name}"]).items()}
    usable = {**own, **parameters, TIME.name: TIME}
    force = [
        (row, as_expr(section.force[name], f"scene.force.{shorten(name, 40)}", usable)) for name, row in pushed.items()
    ]
    mu = None if section.mu is None else as_expr(section.mu, "scene.mu", parameters)
    if mu is None and full.friction is not None and contacts:
        mu = sp.S.Zero
    scene = call(
        "[scene]",
        small.scene,
        {
            "contacts": contacts,
            "force": force or None,
            "values": {s: document.values[n] for n, s in parameters.items()},
            "initial": dict(section.initial),
            "horizon": section.horizon,
            "mu": mu,
            "observe": observed,
        },
    )
    places = source.places
    if section.places is not None:
        places = read_places(_beside(folder, section.places, "scene.places"), full.names, "scene.places")
    plan = StructurePlan(source.origin, full, small, tuple(contacts), points, places, document.flutter, bool(force))
    return scene, specs, plan


def _beside(folder: Path | None, path: str, place: str) -> Path:
    if folder is None:
        raise SceneError(f"{place}: a path is relative to a scene file; this scene was given as text")
    return folder / path


def _source(table: Source, folder: Path | None) -> _Source:
    """Return the matrices of a file or a maker."""
    from symfric import structures

    place, given = "scene.structure", dict(table.__pydantic_extra__)
    if (table.file is None) == (table.maker is None):
        raise SceneError(f"{place} needs one of file, the path of matrices, and maker")
    if table.file is not None:
        if given:
            raise SceneError(f"{place} has no key {shorten(next(iter(given)), 40)!r}; a file has no arguments")
        path = _beside(folder, table.file, place)
        try:
            return _Source(structures.read(path), table.file)
        except SceneError as error:
            raise SceneError(f"{place}: {error}") from None
    maker = str(table.maker)
    if maker not in MAKERS:
        raise SceneError(f"{place}.maker: no maker {shorten(maker, 40)!r}{nearest(maker, MAKERS)}")
    function = getattr(structures, maker)
    given = exact_numbers(given)
    check_arguments(place, function, given)
    for name, value in given.items():
        counts = inspect.signature(function).parameters[name].annotation is int
        if counts and isinstance(value, int) and value > MOST_MADE:
            raise SceneError(f"{place}.{name} is {value}; at most {MOST_MADE} are made")
    made = call_at(place, function, given)
    if isinstance(made, structures.Brake):
        along = tuple(name[-1] for name in made.apart.names)
        return _Source(made.apart, maker, made.contacts, Places(made.places, along))
    return _Source(made, maker)


def _names(full: "Structure", section: StructureScene, parameters: Mapping[str, sp.Symbol]) -> _Names:
    """Return the names that expressions may contain; points stand for their rows."""
    q, u = full.symbols
    of = {s: ("q", n) for s, n in zip(q, full.names, strict=True)}
    of |= {s: ("u", n) for s, n in zip(u, full.names, strict=True)}
    states: dict[str, sp.Expr] = {s.name: s for s in (*q, *u)}
    for name in section.points:
        if not name.isidentifier() or name in parameters or name == TIME.name:
            raise SceneError(f"scene.points: {shorten(name, 40)!r} is taken or no name; use letters, digits and _")
    both = next((n for n in parameters if n in states), None)
    if both is not None:
        raise SceneError(f"values.{both} is also a degree of freedom of the structure; rename it")
    names = _Names(states, {**states, **parameters, TIME.name: TIME}, of)
    for name, given in section.points.items():
        row = names.row(given, f"scene.points.{shorten(name, 40)}")
        for before, part in (("", q), ("d_", u)):
            at = dict(zip(full.names, part, strict=True))
            _known(row, full, f"scene.points.{shorten(name, 40)}")
            names.known[before + name] = sp.Add(*(exact(w) * at[n] for n, w in row.items()))
    return names


def _known(row: Mapping[str, float], full: "Structure", place: str) -> None:
    """Raise on a row with a name that is none."""
    for name in row:
        if name not in full.names:
            raise SceneError(f"{place}: no degree of freedom {shorten(name, 40)!r}{nearest(name, full.names)}")


def _kept(row: Mapping[str, float]) -> str | dict[str, float]:
    """Return a row for a reduction: a degree of freedom by its name, so that it is called so."""
    (name, weight), *more = row.items()
    return name if not more and weight == 1 else dict(row)


def _contacts(
    document: Document, source: _Source, names: _Names, parameters: Mapping[str, sp.Symbol]
) -> "tuple[list[Any], tuple[LawSpec, ...]]":
    """Return the contacts and their laws for display; a maker's own ones where a contact has no slip."""
    contacts: list[Any] = []
    specs: list[LawSpec] = []
    for i, friction in enumerate(document.friction):
        assert isinstance(friction, RowFriction)
        place = contact_place(document, i)
        law = law_of(friction, place, parameters, document.values)
        given = {k: getattr(friction, k) for k in ("speed", "profile", "spring")}
        timed = {**parameters, TIME.name: TIME}
        own = {k: as_expr(v, f"{place}.{k}", timed) for k, v in given.items() if v is not None}
        if friction.slip is None:
            made = _made(friction, place, source, law, own, parameters)
            specs += [spec_of(friction, c.name) for c in made]
            contacts += made
            continue
        name = contact_name(document, i)
        contacts.append(_contact(friction, name, place, law, own, names, source.structure))
        specs.append(spec_of(friction, name))
    for contact in contacts:
        numbers = {parameters[n]: v for n, v in document.values.items()}
        if contact.speed.free_symbols <= set(numbers):
            finite_value(contact.speed, numbers, f"the speed of contact {contact.name!r}")
    return contacts, tuple(specs)


def _made(
    friction: RowFriction,
    place: str,
    source: _Source,
    law: Law,
    own: Mapping[str, sp.Expr],
    parameters: Mapping[str, sp.Symbol],
) -> "list[RowContact]":
    """Return the contacts of a maker."""
    if source.pairs is None:
        raise SceneError(f"{place}.slip is missing; it says where the contact acts, as {_example(source.structure)}")
    for key in ("name", "push", "spring", "profile"):
        if getattr(friction, key) is not None:
            raise SceneError(f"{place}.{key}: {source.origin} defines its contacts; remove {key}, or give a slip")
    for key in ("normal", "speed"):
        if getattr(friction, key) is None:
            raise SceneError(f"{place}.{key} is missing; add it")
    assert friction.normal is not None
    preload = as_expr(friction.normal, f"{place}.normal", parameters)
    return source.pairs(preload, law, own["speed"])


def _example(structure: "Structure") -> str:
    return f'slip = "d_{structure.names[0]} - v"'


def _contact(
    friction: RowFriction,
    name: str,
    place: str,
    law: Law,
    own: Mapping[str, sp.Expr],
    names: _Names,
    full: "Structure",
) -> "RowContact":
    from symfric.structures.contacts import RowContact, RowLoad

    assert friction.slip is not None  # else the contacts are those of the maker
    if friction.normal is None:
        raise SceneError(f"{place}.normal is missing; add the normal load")
    if isinstance(friction.slip, Mapping):
        slip, rest = dict(friction.slip), sp.S.Zero
    else:
        slip, rest = names.parts(friction.slip, f"{place}.slip", "u")
        if not slip:
            raise SceneError(f"{place}.slip names no velocity; write {_example(full)}")
    _known(slip, full, f"{place}.slip")
    speed = (sp.S.Zero if friction.speed is None else own["speed"]) - rest
    row, start = names.parts(friction.normal, f"{place}.normal", "q")
    push = None if friction.push is None else names.row(friction.push, f"{place}.push")
    if push is not None:
        _known(push, full, f"{place}.push")
        if not row:
            raise SceneError(f"{place}.push: the normal load does not follow the structure; remove push")
    normal = RowLoad(start, row, push) if row else start
    profile = 1 if friction.profile is None else own["profile"]
    spring = None if friction.spring is None else own["spring"]
    arguments = {"name": name, "row": slip, "normal": normal, "law": law, "speed": speed}
    made: RowContact = call(f"[{place}]", RowContact, {**arguments, "profile": profile, "stiffness": spring})
    return made


def plan_of(scene: Scene) -> StructurePlan:
    """Return the plan of a scene that was made from matrices in Python; without points, places and flutter map."""
    from symfric.structures.contacts import RowContact, RowLoad
    from symfric.structures.structure import Structure

    part, system = scene.system.linear, scene.system
    assert part is not None
    whole = Structure(part.M, part.K, part.C, None, [q.name for q in system.q])
    contacts = []
    for c in scene.contacts:
        row, normal = system.slopes(c.slip), c.normal
        speed = -c.slip.subs(dict.fromkeys([*system.u, *part.rows], 0))
        rows = [s for s in normal.free_symbols if s in part.rows]
        if len(rows) == 1 and isinstance(normal, sp.Max) and len(normal.args) == 2 and sp.S.Zero in normal.args:
            start = next(e for e in normal.args if e != 0).subs(rows[0], 0)
            push = next((along for e, along in part.loads if sp.expand(e - normal + start) == 0), None)
            normal = RowLoad(start, part.rows[rows[0]].weights, push)
        contacts.append(RowContact(c.name, row, normal, c.law, speed, c.profile, c.stiffness))
    points = {
        s.name: {n: float(w) for n, w in zip(whole.names, row.weights, strict=True) if w}
        for s, row in part.rows.items()
        if s.name.isidentifier() and row.of == "q"
    }
    return StructurePlan("Python", whole, whole, tuple(contacts), points, None, None)
