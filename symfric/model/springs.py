"""Contacts behind a spring: a slider without mass whose force is that of the spring, set-valued friction included.

The spring of stiffness k is stretched by z, a first-order state called ``<contact>.z``. With the slip w of the contact
as the rate at which its two ends move apart, and the limit L = N mu,

    force on the body = -k z,   z' = w  while |k z| < L,   k z = +-L  while the slider moves that way.

In parallel to nothing else this is the element of Jenkins (1962), also called elastic-perfectly plastic, or the stop
operator of hysteresis.
"""

from collections.abc import Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, Any

import sympy as sp

from symfric.errors import SceneError
from symfric.model.symbols import SPEED, expression, refuse_speed

if TYPE_CHECKING:
    from symfric.model.laws import Law
    from symfric.model.system import Contact, System


def spring_of(name: str) -> sp.Symbol:
    """Return the state of the spring of a contact: how far it is stretched."""
    return sp.Symbol(f"{name}.z", real=True)


def in_order(contacts: "Sequence[Contact]") -> "tuple[Contact, ...]":
    """Return contacts as the loops number them: along a line, behind springs, stops without friction.

    One in the plane is there twice, once for each component of its slip.
    """
    behind = [c for c in contacts if not c.along_line]
    stops = [c for c in behind if c.frictionless]
    return (*(c for c in contacts if c.along_line for _ in c.slips), *(c for c in behind if not c.frictionless), *stops)


def with_springs(system: "System", contacts: "Sequence[Contact]") -> "System":
    """Return the system with the springs of its contacts among the first-order states.

    Their rates are those while the slider sticks; what the slider does is decided in `symfric.lower`.
    """
    known = {s.name for s in system.states}
    new = [c for c in contacts if c.stiffness is not None and spring_of(c.name).name not in known]
    if not new:
        return system
    z, rate = (spring_of(c.name) for c in new), (c.slip for c in new)
    return replace(system, z=(*system.z, *z), z_rate=(*system.z_rate, *rate))


def stop_rate(contact: "Contact") -> tuple[sp.Symbol, sp.Expr]:
    """Return the state of the spring of a contact and its rate for a limit that does not change, for reading."""
    z = spring_of(contact.name)
    free = sp.Abs(contact.stiffness * z) < contact.normal * contact.profile * contact.law.stick
    return z, sp.Piecewise((contact.slip, sp.Or(free, z * contact.slip < 0)), (0, True))


def read_stiffness(stiffness: Any, law: "Law", name: str) -> sp.Expr:
    """Return the stiffness of the spring of a contact.

    Raises
    ------
    SceneError
        If it is not positive, or the law is not Coulomb's.
    """
    what = f"stiffness of contact {name!r}"
    spring = expression(stiffness, what)
    refuse_speed(spring, what)
    if spring.is_number and not spring > 0:
        raise SceneError(f"{what} is {spring}; it must be positive, or None for a contact without a spring")
    if law.memory or SPEED in law.kinetic.free_symbols or (law.kinetic - law.stick).expand() != 0:
        raise SceneError(
            f"the law of contact {name!r} is {law.kinetic}, with the static coefficient {law.stick}; the slider behind "
            "a spring has no mass, and only Coulomb's law with one coefficient determines its motion: use "
            "sf.laws.coulomb(mu)"
        )
    return spring
