"""Contacts in the plane: what takes those along a line only says so."""

from collections.abc import Sequence

from symfric.errors import SceneError
from symfric.model.system import Contact


def refuse_planes(contacts: Sequence[Contact], what: str) -> None:
    """Raise if a contact slides in the plane; `what` says what takes contacts along a line only."""
    for c in contacts:
        if c.in_plane:
            raise SceneError(f"contact {c.name!r} slides in the plane; {what} takes contacts along a line")
