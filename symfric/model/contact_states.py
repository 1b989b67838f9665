"""States that contacts with memory bring into a system: ``<contact>.z``, or ``<contact>.z1``, ... if there are several.

They are the last first-order states of the system of a scene, in the order of its contacts. Their rates in
``System.z_rate`` are for reading; solvers take them from the law itself, in which the direction of slip is data.
"""

from collections.abc import Sequence
from dataclasses import replace

import sympy as sp

from symfric.model.held import Held
from symfric.model.laws.memory import SIDE, SLIP
from symfric.model.springs import with_springs
from symfric.model.symbols import SPEED
from symfric.model.system import Contact, System


def in_contact(contact: Contact, side: sp.Expr | None = None) -> dict[sp.Symbol, sp.Expr]:
    """Return what the symbols inside a law with memory stand for in a contact; `side` is the direction of slip."""
    w = contact.slip
    symbols = contact.law.memory.symbols if contact.law.memory else ()
    known = dict(zip(symbols, contact.states, strict=True))
    if side is None:
        return {**known, SLIP: w, SPEED: sp.Abs(w), SIDE: sp.sign(w)}
    return {**known, SLIP: w, SPEED: side * w, SIDE: side}


def coefficient(contact: Contact, side: sp.Expr | None = None) -> sp.Expr:
    """Return friction over normal load as an expression of the states, against the slip if positive."""
    assert contact.law.memory is not None
    return contact.law.memory.force.xreplace(in_contact(contact, side))


def opposing(contact: Contact, side: sp.Expr) -> sp.Expr:
    """Return friction over normal load, positive against a slip in the given direction, with any law."""
    if contact.law.memory is None:
        return contact.law.kinetic.subs(SPEED, side * contact.slip)
    return side * coefficient(contact, side)


def rates(contact: Contact, side: sp.Expr | None = None) -> list[sp.Expr]:
    """Return the rates of the states of a contact."""
    if contact.law.memory is None:
        return []
    known, memory = in_contact(contact, side), contact.law.memory
    free = [e.xreplace(known) for e in memory.rates]
    if not memory.limits:
        return free
    stops = zip(free, contact.states, memory.limits, strict=True)
    return [sp.Piecewise((e, sp.Or(sp.Abs(z) < limit, z * contact.slip < 0)), (0, True)) for e, z, limit in stops]


def with_states(system: System, contacts: Sequence[Contact], held: Sequence[Held] = ()) -> System:
    """Return the system with the states of its contacts and its held variables, in place of those that it had."""
    system = with_springs(without_states(system), contacts)
    own = [s for c in contacts if c.law.memory for s in c.states]
    still = [s for h in held for s in h.states]
    if not own and not still:
        return system
    changes = [*(e for c in contacts for e in rates(c)), *([sp.S.Zero] * len(still))]
    return replace(system, z=(*system.z, *own, *still), z_rate=(*system.z_rate, *changes), made=len(own) + len(still))


def without_states(system: System) -> System:
    """Return the system without the states of contacts."""
    if not system.made:
        return system
    kept = len(system.z) - system.made
    return replace(system, z=system.z[:kept], z_rate=system.z_rate[:kept], made=0)


def rates_by_side(system: System, contacts: Sequence[Contact], sides: Sequence[sp.Expr]) -> list[sp.Expr]:
    """Return the rates of all first-order states, those of contacts with the directions of slip given."""
    own = [e for c, side in zip(contacts, sides, strict=True) for e in rates(c, side)]
    return [*system.z_rate[: len(system.z) - system.made], *own]
