"""Equilibria with springs with sliders: Maxwell slip, Iwan, a contact behind a spring.

During steady sliding every slider moves: ``z = sign(w) limit`` as long as the slip keeps its direction, whatever small
motion comes with it, so that the contact is linearised as one of Coulomb's law with a constant coefficient (and the
viscous part of the law). At rest every slider that is not at its limit sticks: the contact is its springs, ``z' = w``.
"""

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import NamedTuple

import sympy as sp

from symfric.errors import SceneError
from symfric.model.contact_states import coefficient, with_states, without_states
from symfric.model.system import Contact, System


class Spring(NamedTuple):
    """The state of a spring with a slider and its largest magnitude.

    Attributes
    ----------
    contact : str
    state : Symbol
    limit : Expr
    way : Expr
        The slip, whose sign is that of the state while the slider moves.
    """

    contact: str
    state: sp.Symbol
    limit: sp.Expr
    way: sp.Expr


class Replaced(NamedTuple):
    """A system with smooth equations in place of springs with sliders.

    Attributes
    ----------
    system : System
    contacts : tuple of Contact
    moving, held : tuple of Spring
        Those whose sliders move, which are no states any more, and those whose sliders stick.
    """

    system: System
    contacts: tuple[Contact, ...]
    moving: tuple[Spring, ...]
    held: tuple[Spring, ...]


def springs_of(contact: Contact) -> tuple[Spring, ...]:
    """Return the springs with sliders of a contact."""
    if contact.stiffness is not None:
        most = contact.normal * contact.profile * contact.law.stick / contact.stiffness
        return (Spring(contact.name, contact.states[0], most, contact.slip),)
    limits = contact.law.memory.limits if contact.law.memory else ()
    return tuple(Spring(contact.name, z, e, contact.slip) for z, e in zip(contact.states, limits, strict=bool(limits)))


def replaced(system: System, contacts: Sequence[Contact], values: Mapping[sp.Symbol, float]) -> Replaced:
    """Return the equations near steady sliding, or near rest of those contacts that do not slip while u = 0.

    Parameters
    ----------
    system : System
        With the states of all contacts.
    contacts : sequence of Contact
    values : mapping
        Of the parameters; they tell which contacts rest.
    """
    behind = {c.name for c in contacts if not c.along_line}
    if not behind:
        return Replaced(system, tuple(contacts), (), ())
    at_rest = [c for c in contacts if c.name in behind and _rests(c, system, values)]
    gone = {s.state for c in contacts for s in springs_of(c)}
    own = without_states(system)
    kept = [(z, e) for z, e in zip(own.z, own.z_rate, strict=True) if z not in gone]
    force = list(system.force)
    for contact in at_rest:
        pull = contact.stiffness * contact.states[0] if contact.stiffness is not None else (
            contact.normal * contact.profile * coefficient(contact, sp.Integer(1))
        )  # fmt: skip
        force = [f - contact.slip.diff(u) * pull for f, u in zip(force, system.u, strict=True)]
        kept += [(z, contact.slip) for z in contact.states]
    left = tuple(_sliding(c) for c in contacts if c not in at_rest)
    z, rates = zip(*kept, strict=True) if kept else ((), ())
    smooth = with_states(replace(own, force=force, z=z, z_rate=rates), left)
    moving = tuple(s for c in contacts if c not in at_rest for s in springs_of(c))
    return Replaced(smooth, left, moving, tuple(s for c in at_rest for s in springs_of(c)))


def _sliding(contact: Contact) -> Contact:
    """Return a contact with the law of its steady sliding in place of springs with sliders."""
    if contact.along_line:
        return contact
    return replace(contact, law=replace(contact.law, memory=None), stiffness=None)


def _rests(contact: Contact, system: System, values: Mapping[sp.Symbol, float]) -> bool:
    slip = contact.slip.xreplace(dict.fromkeys(system.u, sp.S.Zero)).xreplace(dict(values))
    return bool(slip == 0)


def check_held(held: Sequence[Spring], values: Mapping[sp.Symbol, float]) -> None:
    """Raise if a slider that was taken to stick is at its limit: it would slide one way and stick the other."""
    for spring in held:
        z, limit = (float(e.subs(values)) for e in (spring.state, spring.limit))
        if abs(z) >= limit * (1 - 1e-9):
            raise SceneError(
                f"contact {spring.contact!r} rests with {spring.state} = {z:.6g}, at the limit {limit:.6g} of its "
                "slider or beyond: it slides one way and sticks the other, and no linearisation holds; start the "
                "scene with less elongation, or let the contact slip (a belt that moves)"
            )
