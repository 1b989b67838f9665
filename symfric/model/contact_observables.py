"""What outputs may ask of a contact: the symbols of its force, slip and energies, and words for those it has not."""

import sympy as sp

from symfric.model.outputs import OF_CONTACTS, friction_force


def vector_words(output: str, contact: str) -> str:
    """Return why an output cannot have a friction force: all of a vector, or a component, ``name, 0``, of no vector."""
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
    found = [make(contact) for make in OF_CONTACTS.values()]
    if in_plane:
        found[0] = friction_force(contact, 0)
        found.append(friction_force(contact, 1))
    return found
