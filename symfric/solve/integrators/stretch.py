"""Velocities over many orders of magnitude, integrated as their logarithms.

A law that depends on the logarithm of the slip velocity w needs w with a small error relative to itself, from creep to
fast slip. In its place ``s = asinh(w/U)`` is integrated, U far below every speed that matters: a logarithm on either
side of rest, and smooth through it.
"""

from dataclasses import dataclass

import casadi as ca
import numpy as np

from symfric.errors import NoRoute
from symfric.lower.automaton import Automaton
from symfric.lower.contact_dynamics import ContactDynamics

SIZE = 10.0  # of s, for absolute tolerances


@dataclass(frozen=True)
class Stretch:
    """A change of variables of some states.

    Attributes
    ----------
    places : tuple of int
        Indices of the velocities among the states.
    outer, inner : casadi.Function
        ``(s, p) -> y`` and ``(y, p) -> s``, for all states.
    slope : casadi.Function
        ``(s, p) -> dy/ds``, state by state.
    """

    places: tuple[int, ...]
    outer: ca.Function
    inner: ca.Function
    slope: ca.Function


def stretch_of(model: ContactDynamics, automaton: Automaton) -> Stretch | None:
    """Return the change of variables of a scene; None if no law depends on the logarithm of the speed.

    Raises
    ------
    NoRoute
        If such a contact slips otherwise than with one velocity.
    """
    y, p = ca.SX.sym("y", automaton.n_y), ca.SX.sym("p", automaton.field.nnz_in(2))
    slips = automaton.gauge(ca.SX.zeros(y.numel()), 0, p)[0]
    outer, inner, slope, places = ca.SX(y), ca.SX(y), ca.SX.ones(y.numel()), []
    for i, contact in enumerate(model.contacts):
        memory = contact.law.memory
        if memory is None or memory.slowest is None:
            continue
        k, factor = automaton.anchors[i]
        moving = ca.jacobian(model.slip[i], ca.vertcat(model.q, model.t))
        if k < 0 or k in places or moving.nnz():
            raise NoRoute(f"the slip of contact {contact.name!r} is not that of one velocity, less a constant one")
        unit = ca.substitute(model.read(memory.slowest), model.p, p)
        places.append(k)
        outer[k] = (unit * ca.sinh(y[k]) - slips[i]) / factor
        inner[k] = ca.asinh((factor * y[k] + slips[i]) / unit)
        slope[k] = unit * ca.cosh(y[k]) / factor
    if not places:
        return None
    functions = (ca.Function("map", [y, p], [ca.densify(e)]) for e in (outer, inner, slope))
    return Stretch(tuple(places), *functions)


def sizes_of(stretch: Stretch, size: np.ndarray) -> np.ndarray:
    """Return the sizes of the integrated variables from those of the states."""
    found = size.copy()
    found[list(stretch.places)] = SIZE
    return found
