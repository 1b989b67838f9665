"""Tables of the contacts of a scene file."""

from typing import Annotated, Any

from pydantic import BeforeValidator, ConfigDict

from symfric.fields import Coefficient, Factors, Section, Slip, Term, Text, kind_of, number
from symfric.model.symbols import shorten


def as_row(value: object) -> str | dict[str, float]:
    """Return a row over the degrees of freedom: an expression linear in their names, or a table of weights."""
    if isinstance(value, str):
        return value
    if not isinstance(value, dict):
        raise ValueError(f"is {kind_of(value)}, not a row; write an expression, or a table of names and weights")
    if not value:
        raise ValueError("is an empty table; name at least one degree of freedom")
    return {shorten(name, 100): number(weight) for name, weight in value.items()}


Row = Annotated[Any, BeforeValidator(as_row)]


class FrictionTable(Section):
    """One contact: the law with its coefficients and, for own equations, where it acts.

    Attributes
    ----------
    law
        Name of a friction law, see ``symfric scenes``; its coefficients are further keys.
    name
        Name of the contact.
    slip
        Relative velocity, linear in the velocities; for own equations.
    normal
        Normal load; for own equations.
    profile
        Factor of the coefficient that depends on the coordinates; 1 unless given.
    """

    model_config = ConfigDict(extra="allow", frozen=True)
    __pydantic_extra__: dict[str, Coefficient]

    law: Text
    name: Text | None = None
    slip: Term | None = None
    normal: Term | None = None
    profile: Term | None = None


class OwnFriction(FrictionTable):
    """One contact of own equations; with a gap it opens and strikes, and without slip and law it is a stop.

    Attributes
    ----------
    law
        Name of a friction law; not needed with a gap and without slip.
    name
        Name of the contact.
    slip
        Relative velocity, linear in the velocities; a list of two is the slip vector of a contact in the plane.
    normal
        Normal load, in which ``normal_force("name")`` is that of a contact with a gap; not given beside a gap.
    profile
        Factor of the coefficient that depends on the coordinates; 1 unless given.
    gap
        Distance to what the body strikes, >= 0, of coordinates and ``t``; the normal force is unknown then.
    restitution
        Of an impact, from 0 to 1; 0 unless given.
    ellipse
        Factors of the coefficient along both slips of a contact in the plane, a list of two; equal unless given.
    """

    law: Text | None = None  # type: ignore[assignment]  # that of a stop
    slip: Slip | None = None
    gap: Term | None = None
    restitution: Term | None = None
    ellipse: Factors | None = None


class RowFriction(FrictionTable):
    """One contact of a structure; its normal load may follow the structure, and is zero where it is open.

    Attributes
    ----------
    law
        Name of a friction law.
    name
        Name of the contact.
    slip
        Relative velocity: an expression linear in the velocities ``d_<name>``, or a row, from which ``speed`` is
        subtracted; not needed with a maker that has contacts.
    normal
        Normal load, linear in the names of the degrees of freedom.
    profile
        Factor of the coefficient.
    speed
        Speed of what it slides on, if the slip is a row.
    push
        How the load moves the structure, linear in the names of the degrees of freedom; without it the stiffness of the
        contact is part of the matrices.
    spring
        Stiffness of a spring in series with the contact.
    """

    slip: Row | None = None
    speed: Term | None = None
    push: Row | None = None
    spring: Term | None = None
