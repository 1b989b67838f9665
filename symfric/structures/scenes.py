"""Scenes from matrices: their entries stay numbers, contacts and loads act along rows."""

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
import sympy as sp

from symfric.errors import SceneError
from symfric.locks import SYMBOLIC, alone
from symfric.model.linear_part import LinearPart, Row
from symfric.model.outputs import Output
from symfric.model.scene import Scene
from symfric.model.symbols import Key, expression, finite, listed, name_of, nearest
from symfric.model.system import Contact, Signal, System
from symfric.structures.contacts import RowContact, RowLoad
from symfric.structures.rows import row_in

if TYPE_CHECKING:
    from symfric.structures.structure import Structure


_SAME = 1e-6  # difference of two friction matrices that are the same, relative to one of them


@alone(SYMBOLIC)
def scene_of(
    structure: "Structure",
    contacts: Sequence[RowContact],
    force: Any,
    values: Mapping[Key, float | None],
    initial: Any,
    outputs: Mapping[str, Output] | None,
    horizon: float,
    mu: Any,
    observe: Mapping[str, object],
    inputs: Mapping[Key, Signal],
) -> Scene:
    """Return the scene of a structure; see `Structure.scene`."""
    q, u = structure.symbols
    rows: dict[sp.Symbol, Row] = {}
    loads: list[tuple[sp.Expr, np.ndarray]] = []
    known: dict[bytes, sp.Symbol] = {}

    def named(name: str, of: Any, weights: np.ndarray) -> sp.Symbol:
        """Return the symbol of a row; the same one for the same row, so that parallel contacts are known as such."""
        key = of.encode() + weights.tobytes()
        if key not in known:
            known[key] = sp.Symbol(name, real=True)
            rows[known[key]] = Row(of, weights)
        return known[key]

    if not isinstance(observe, Mapping):
        raise SceneError(f"observe is {observe!r}; give a mapping of names to rows")
    taken = {s.name for s in (*q, *u)}
    for name, entries in observe.items():
        if not isinstance(name, str) or not taken.isdisjoint((name, f"d_{name}")):
            raise SceneError(f"the name {name!r} in observe is taken, or no string; choose another")
        weights = row_in(structure, entries, f"the row {name!r}")
        for symbol, of in ((sp.Symbol(name, real=True), "q"), (sp.Symbol(f"d_{name}", real=True), "u")):
            rows[symbol] = Row("q" if of == "q" else "u", weights)
    made = []
    for c in contacts:
        if not isinstance(c, RowContact):
            raise SceneError(f"{c!r} in contacts is no sf.structures.RowContact")
        slip = named(f"slip row of {c.name}", "u", row_in(structure, c.row, f"the row of contact {c.name!r}"))
        normal = c.normal
        if isinstance(normal, RowLoad):
            weights = row_in(structure, normal.row, f"the row of the load of contact {c.name!r}")
            start = expression(normal.N0, f"N0 of contact {c.name!r}")
            normal = sp.Max(0, start + named(f"load row of {c.name}", "q", weights))
            if c.normal.push is not None:
                along = row_in(structure, c.normal.push, f"push of the load of contact {c.name!r}")
                loads.append((normal - start, along))
        speed = expression(c.speed, f"the speed of contact {c.name!r}")
        made.append(Contact(c.name, slip - speed, normal, c.law, c.profile, c.stiffness))
    loads += _forces(structure, force)
    if mu is None and structure.friction is not None and not made:
        raise SceneError("the structure has a friction matrix, and the scene no contacts; give mu (0: leave it out)")
    scaled = () if mu is None else ((expression(mu, "mu"), _friction_of(structure)),)
    part = LinearPart(structure.M, structure.K, structure.C, scaled, rows, tuple(loads))
    system = System(q, u, None, (sp.S.Zero,) * len(q), linear=part)
    own = [s.name for c in made for s in c.states]
    return Scene(system, made, values, _start(structure, initial, own), horizon, outputs, inputs)


def doubt_of_friction(structure: "Structure", contacts: Sequence[RowContact], mu: Any) -> str | None:
    """Return what may be wrong with the friction of a scene that has contacts and a friction matrix; None if nothing.

    The loads of contacts bring the matrix of steady sliding themselves: ``+-row (load row)`` of each. If the friction
    matrix is their sum, it belongs to `flutter` and not to the scene, and leaving it out needs no word.
    """
    if structure.friction is None or not contacts or mu == 0:
        return None
    same = _is_that_of(structure, contacts)
    if mu is None and not same:
        return (
            "the friction matrix of the structure is not part of this scene, whose contacts bring friction of their "
            "own; give mu to add it, or mu=0 if that is meant"
        )
    if mu is not None and same:
        return (
            "mu adds the friction matrix of the structure, and the loads of the contacts bring the same friction: it "
            "counts twice; leave mu out"
        )
    return None


def _is_that_of(structure: "Structure", contacts: Sequence[RowContact]) -> bool:
    """Whether the friction matrix is the sum of what the loads of contacts that slide steadily bring."""
    import scipy.sparse as sps  # slow to import

    left = structure.friction
    assert left is not None
    size = np.linalg.norm(left.data)
    for c in contacts:
        if isinstance(c.normal, RowLoad):
            slip, load = row_in(structure, c.row), row_in(structure, c.normal.row)
            brought = sps.csr_array(slip.reshape(-1, 1)) @ sps.csr_array(load.reshape(1, -1))
            way = np.sign((structure.friction * brought).sum())  # the direction of sliding is not known here
            left = left - way * brought
    return bool(np.linalg.norm(left.data) <= _SAME * size)


def _friction_of(structure: "Structure") -> Any:
    if structure.friction is None:
        raise SceneError("mu is given and the structure has no friction matrix; give it as `friction`")
    return structure.friction


def _forces(structure: "Structure", force: Any) -> list[tuple[sp.Expr, np.ndarray]]:
    """Return forces and the rows along which they act."""
    if force is None:
        return []
    if isinstance(force, Mapping):
        pairs = [(name_of(k) if isinstance(k, sp.Symbol) else k, e) for k, e in force.items()]
    else:
        pairs = list(listed(force, "force"))
        if len(pairs) == structure.n and not any(isinstance(e, tuple | list) for e in pairs):
            pairs = [(i, e) for i, e in enumerate(pairs)]
        elif not all(isinstance(e, tuple | list) and len(e) == 2 for e in pairs):
            raise SceneError(
                f"force is no mapping of names to expressions, no pairs (row, expression), no {structure.n} expressions"
            )
    forces = []
    for k, (row, e) in enumerate(pairs):
        load = expression(e, f"force {k + 1}")
        if load != 0:
            forces.append((load, row_in(structure, row, f"the row of force {k + 1}")))
    return forces


def _start(structure: "Structure", initial: Any, springs: Sequence[str]) -> dict[str, object]:
    """Return the start of every state; zero unless given."""
    names = [*(s.name for group in structure.symbols for s in group), *springs]
    start: dict[str, object] = dict.fromkeys(names, 0.0)
    if initial is None:
        return start
    if isinstance(initial, Mapping):
        for key, value in initial.items():
            name = name_of(key)
            if name not in start:
                raise SceneError(f"{name} in initial is no state{nearest(name, names)}")
            start[name] = value
        return start
    try:
        array = np.asarray(initial, dtype=float).ravel()
    except (TypeError, ValueError):
        raise SceneError(f"initial is {initial!r}; give a mapping of states to numbers, or an array") from None
    if array.size not in (structure.n, 2 * structure.n):
        raise SceneError(
            f"initial has {array.size} entries; give {structure.n} coordinates, or {2 * structure.n} states"
        )
    return start | {
        name: finite(float(v), f"the initial value of {name}") for name, v in zip(names, array, strict=False)
    }
