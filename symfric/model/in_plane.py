"""Contacts in the plane: what takes those along a line only says so, and the two lines along which one is drawn."""

from collections.abc import Sequence
from dataclasses import replace

from symfric.errors import SceneError
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
