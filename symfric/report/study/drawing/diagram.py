"""Read a scene as bodies, springs, dampers, contacts and loads, for its sketch."""

from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import dataclass
from functools import partial

import sympy as sp

from symfric.locks import SYMBOLIC, alone
from symfric.model.in_plane import along_lines
from symfric.model.scene import Scene
from symfric.model.symbols import TIME
from symfric.model.system import Contact, System
from symfric.model.written_equations import reaction

GROUND = -1
MOST = 24  # coordinates up to which a scene has a diagram
_LONGEST = 4000  # operations in the forces up to which they are taken apart


@dataclass(frozen=True)
class DrawnBody:
    """A coordinate with its inertia.

    Attributes
    ----------
    coordinate : Symbol
    mass : Expr
        Diagonal entry of the mass matrix.
    """

    coordinate: sp.Symbol
    mass: sp.Expr


@dataclass(frozen=True)
class Link:
    """A force between two bodies, or between a body and the ground.

    Attributes
    ----------
    kind : {"stiffness", "damping", "friction", "gap", "coupling"}
        A gap is that of a contact that opens. A coupling is any other dependence: of the inertia, or forces without
        their reaction.
    first, second : int
        Numbers of the bodies; `GROUND` for the second of a link to the ground.
    size : Expr
        Tangent stiffness or damping; the relative drive of a contact; the gap.
    absent : bool
        Whether it vanishes with the values of the scene.
    name : str
        Of the contact.
    """

    kind: str
    first: int
    second: int
    size: sp.Expr
    absent: bool = False
    name: str = ""


@dataclass(frozen=True)
class Surface:
    """A surface on which a body slides.

    Attributes
    ----------
    body : int
    name : str
        Of the contact.
    velocity : Expr
        Of the surface.
    load : Expr
        Normal force.
    sprung : bool
        Whether a spring is in series with the contact.
    """

    body: int
    name: str
    velocity: sp.Expr
    load: sp.Expr
    sprung: bool


@dataclass(frozen=True)
class Load:
    """The part of the force on a body that neither its position nor its velocity makes.

    Attributes
    ----------
    body : int
    force : Expr
    absent : bool
        Whether it vanishes with the values of the scene.
    """

    body: int
    force: sp.Expr
    absent: bool


@dataclass(frozen=True)
class Diagram:
    """What a sketch of a scene shows.

    Attributes
    ----------
    bodies : tuple of DrawnBody
    links : tuple of Link
    surfaces : tuple of Surface
    loads : tuple of Load
    states : tuple of Symbol
        First-order states other than those of contacts.
    """

    bodies: tuple[DrawnBody, ...]
    links: tuple[Link, ...]
    surfaces: tuple[Surface, ...]
    loads: tuple[Load, ...]
    states: tuple[sp.Symbol, ...]


@alone(SYMBOLIC)
def diagram_of(scene: Scene) -> Diagram | None:
    """Return the diagram of a scene; None if it is too large to be drawn.

    Notes
    -----
    The force on body i is taken apart into terms. Terms with a velocity make the damping ``-d f_i / d u_j``, other
    terms with a coordinate the stiffness ``-d f_i / d q_j``. Entries that are equal on both sides of the diagonal are
    links between bodies, what remains of the row is a link to the ground. All other terms are loads.
    """
    if len(scene.system.q) > MOST or sum(e.count_ops() for e in scene.system.force) > _LONGEST:
        return None
    if scene.system.linear is not None and len(scene.system.q) > 6:
        return None
    scene = scene.written_out()
    system = scene.system
    numbers = {s: v for s, v in scene.values.items() if v is not None}
    absent = partial(_vanishes, numbers)
    driven = {TIME, *scene.inputs, *system.z}
    springs, dampers, loads = _taken_apart(system, driven)
    links = [*_links("stiffness", springs, absent), *_links("damping", dampers, absent), *_inertia(system)]
    surfaces = []
    for contact in scene.contacts:
        if contact.unilateral is not None:
            links.extend(_gap(contact, contact.unilateral.gap, system))
        if contact.frictionless:
            continue
        load = sp.expand(contact.normal) if contact.unilateral is None else reaction(contact)
        for line in along_lines(contact):
            surface = _surface(line, load, system)
            if surface is None:
                links.extend(_between(line, system))
            else:
                surfaces.append(surface)
    made = {s for c in scene.contacts for s in c.states}
    return Diagram(
        tuple(DrawnBody(q, system.mass[i, i]) for i, q in enumerate(system.q)),
        tuple(links),
        tuple(surfaces),
        tuple(Load(i, f, absent(f)) for i, f in enumerate(loads) if f != 0),
        tuple(z for z in system.z if z not in made),
    )


def _vanishes(numbers: Mapping[sp.Symbol, float], e: sp.Expr) -> bool:
    return sp.expand(e.xreplace(numbers)).is_zero is True


def _taken_apart(system: System, driven: set[sp.Symbol]) -> tuple[sp.Matrix, sp.Matrix, list[sp.Expr]]:
    """Return stiffness, damping and loads of a system."""
    parts: list[list[sp.Expr]] = [[], [], []]
    moving, placed = set(system.u), set(system.q)
    for force in system.force:
        terms: list[list[sp.Expr]] = [[], [], []]
        for term in sp.Add.make_args(sp.expand(force)):
            symbols = term.free_symbols
            kind = 2 if symbols & driven or not symbols & (moving | placed) else int(bool(symbols & moving))
            terms[kind].append(term)
        for part, own in zip(parts, terms, strict=True):
            part.append(sp.Add(*own))
    return -_slopes(parts[0], system.q), -_slopes(parts[1], system.u), parts[2]


def _slopes(forces: list[sp.Expr], states: Iterable[sp.Symbol]) -> sp.Matrix:
    return sp.Matrix([[sp.expand(sp.diff(f, s)) for s in states] for f in forces])


def _links(kind: str, A: sp.Matrix, absent: Callable[[sp.Expr], bool]) -> Iterator[Link]:
    """Yield the links of a stiffness or damping matrix."""
    n = A.rows
    for i in range(n):
        row = A[i, i]
        for j in range(n):
            if j == i or (A[i, j].is_zero and A[j, i].is_zero):
                continue
            alike = (A[i, j] - A[j, i]).expand().is_zero
            row += A[i, j] if alike else 0
            if j > i:
                size = -A[i, j]
                yield Link(kind if alike else "coupling", i, j, size if alike else sp.S.Zero, bool(absent(size)))
        row = sp.expand(row)
        if not row.is_zero:
            yield Link(kind, i, GROUND, row, absent(row))


def _inertia(system: System) -> Iterator[Link]:
    """Yield the couplings by the mass matrix."""
    n = len(system.q)
    for i in range(n):
        for j in range(i + 1, n):
            if not sp.sympify(system.mass[i, j]).is_zero:
                yield Link("coupling", i, j, sp.S.Zero)


def _slopes_of_slip(contact: Contact, system: System) -> dict[int, sp.Expr]:
    slopes = {i: sp.expand(sp.diff(contact.slip, u)) for i, u in enumerate(system.u)}
    return {i: s for i, s in slopes.items() if not s.is_zero}


def _surface(contact: Contact, load: sp.Expr, system: System) -> Surface | None:
    """Return the surface of a contact of a single body under a load; None if several bodies move in it."""
    slopes = _slopes_of_slip(contact, system)
    if len(slopes) != 1:
        return None
    ((body, slope),) = slopes.items()
    velocity = sp.expand(system.u[body] - contact.slip / slope)
    return Surface(body, contact.name, velocity, load, not contact.along_line)


def _gap(contact: Contact, gap: sp.Expr, system: System) -> Iterator[Link]:
    """Yield the links of a contact that opens: from a body to the ground, or from the first to each of the others."""
    first, *others = [i for i, q in enumerate(system.q) if not gap.diff(q).is_zero]
    for other in others or [GROUND]:
        yield Link("gap", first, other, gap, name=contact.name)


def _between(contact: Contact, system: System) -> Iterator[Link]:
    """Yield the links of a contact of several bodies: from the first to each of the others."""
    slopes = _slopes_of_slip(contact, system)
    own = sp.Add(*(s * system.u[i] for i, s in slopes.items()))
    first, *others = slopes or {0: sp.S.One}
    for other in others:
        yield Link("friction", first, other, sp.expand(contact.slip - own), name=contact.name)
