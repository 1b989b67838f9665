"""Symbols of the forces, slips and energies of contacts for outputs, and the error where a contact lacks one."""

import sympy as sp

from symfric.model.outputs import OF_CONTACTS, friction_force


def vector_words(output: str, contact: str) -> str:
    """Return the error where a friction force lacks a component, ``name, 0``, or a line contact is given one."""
    line = contact.removesuffix(", 0").removesuffix(", 1")
    if line != contact:
        return (
            f"output {output!r} asks for a component of the friction force of contact {line!r}, which slides along a "
            f"line; write sf.friction_force({line!r})"
        )
    return (
        f"output {output!r} uses the friction force of contact {contact!r}, which is a vector; write "
        f"sf.friction_force({contact!r}, 0) or (..., 1) for its components"
    )


def observables_of(contact: str, in_plane: bool) -> list[sp.Symbol]:
    """Return the symbols of a contact that outputs may contain."""
    symbols = [make(contact) for make in OF_CONTACTS.values()]
    if in_plane:
        symbols[0] = friction_force(contact, 0)
        symbols.append(friction_force(contact, 1))
    return symbols
