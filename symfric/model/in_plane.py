"""Contacts that slide in the plane: their refusal by other functions, their lines for drawing, their speed."""

from collections.abc import Sequence
from dataclasses import replace

import sympy as sp

from symfric.errors import SceneError
from symfric.model.outputs import slip
from symfric.model.system import Contact


def refuse_planes(contacts: Sequence[Contact], what: str) -> None:
    """Raise if a contact slides in the plane; `what` says what takes contacts along a line only."""
    for c in contacts:
        if c.in_plane:
            raise SceneError(f"contact {c.name!r} slides in the plane; {what} takes contacts along a line")


def along_lines(contact: Contact) -> tuple[Contact, ...]:
    """Return a contact along each of its slips, for drawing and reading; in the plane "name, 0" and "name, 1"."""
    if not contact.in_plane:
        return (contact,)
    return tuple(
        replace(contact, name=f"{contact.name}, {k}", slip=w, across=None, ellipse=None)
        for k, w in enumerate(contact.slips)
    )


def with_speeds(expr: sp.Expr, name: str, slips: tuple[sp.Expr, sp.Expr]) -> sp.Expr:
    """Return an expression in which the length of the slip vector of a contact is its speed ``sf.slip(name)``.

    As a root, such as ``sqrt(u**2 + w**2)``, it has no series where the contact is at rest; the speed has.
    """
    square = sp.expand(slips[0] ** 2 + slips[1] ** 2)
    roots = [e for e in expr.atoms(sp.Pow) if e.base.is_Add and (2 * e.exp).is_odd]
    rule: dict[sp.Pow, sp.Expr] = {}
    for root in roots:
        factor = sp.cancel(sp.expand(root.base) / square) if root.free_symbols >= square.free_symbols else square
        if factor.is_number and factor.is_positive:
            rule[root] = sp.Pow(factor, root.exp) * slip(name) ** (2 * root.exp)
    return expr.xreplace(rule)
