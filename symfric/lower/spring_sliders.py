"""Contacts behind springs: rates, guards, and what their events do; see `symfric.model.springs`.

The slider sticks (e = 0) or moves forwards or backwards (e = 1, -1) and has four guards: what is left to the limit
forwards and backwards while it sticks, its speed forwards and backwards while it moves; those that play no part are
zero. With the slip w, the spring z of stiffness k and the limit L(q, t),

    e = 0:    force = -k z,   z' = w,         guards L - k z, L + k z
    e = +-1:  force = -e L,   z' = e L'/k,    guard e w - L'/k, the speed of the slider in its direction

At each event the slider is at its limit, k z = +-L, which the transition sets exactly. The guard of the limit at which
a slider comes to rest starts at zero.
"""

import itertools
from collections.abc import Sequence
from dataclasses import dataclass, field, replace

import casadi as ca

from symfric.lower.clocks import Clocks
from symfric.lower.mode_layout import OtherContact
from symfric.lower.planes import Plane
from symfric.lower.slider_sets import SliderSet
from symfric.lower.unilateral import Opening
from symfric.model.outputs import friction_force
from symfric.model.system import Contact, System

GUARDS = 4  # of a contact behind a spring


@dataclass(frozen=True, eq=False)
class Spring:
    """A contact behind a spring as CasADi graphs.

    Attributes
    ----------
    name : str
    place : int
        Index of z among the states.
    z, w, limit, rising, stiffness : SX
        Elongation, slip, limit L of the force and its rate L', k.
    mode : SX
        e.
    """

    name: str
    place: int
    z: ca.SX
    w: ca.SX
    limit: ca.SX
    rising: ca.SX
    stiffness: ca.SX
    mode: ca.SX = field(default_factory=lambda: ca.SX.sym("e"))

    @property
    def variables(self) -> ca.SX:
        """Its part of the mode."""
        return self.mode

    @property
    def moving_limit(self) -> ca.SX:
        """What decides when the slider moves."""
        return self.limit

    @property
    def shown(self) -> ca.SX:
        """The variable that a run shows."""
        return self.mode

    @property
    def rates(self) -> list[tuple[int, ca.SX]]:
        """Place and rate of the elongation."""
        return [(self.place, self.rate)]

    @property
    def layout(self) -> OtherContact:
        """What it owns of mode and guards."""
        return OtherContact(self.name, 1, GUARDS)

    @property
    def force(self) -> ca.SX:
        """The friction force on the body."""
        return ca.if_else(self.mode == 0, -self.stiffness * self.z, -self.mode * self.limit)

    @property
    def rate(self) -> ca.SX:
        """The rate of the elongation."""
        return ca.if_else(self.mode == 0, self.w, self.mode * self.rising / self.stiffness)

    @property
    def guards(self) -> list[ca.SX]:
        """The four guards."""
        e, pull, slow = self.mode, self.stiffness * self.z, self.rising / self.stiffness
        return [
            ca.if_else(e == 0, self.limit - pull, 0),
            ca.if_else(e == 0, self.limit + pull, 0),
            ca.if_else(e == 1, self.w - slow, 0),
            ca.if_else(e == -1, -self.w - slow, 0),
        ]

    def after(self, hit: ca.SX, zero: ca.SX) -> tuple[list[tuple[int, ca.SX]], ca.SX, ca.SX]:
        """Return elongation with its place, mode, and guards that start at zero, after some of its guards were hit."""
        forwards, backwards = ca.logic_or(hit[0], hit[2]), ca.logic_or(hit[1], hit[3])
        side = ca.if_else(forwards, 1, -1)
        taken = ca.logic_or(forwards, backwards)
        starts = ca.logic_or(hit[0], hit[1])
        start = ca.if_else(starts, ca.SX.zeros(GUARDS), ca.vertcat(hit[2], hit[3], 0, 0))
        return (
            [(self.place, ca.if_else(taken, side * self.limit / self.stiffness, self.z))],
            ca.if_else(taken, ca.if_else(starts, side, 0), self.mode),
            ca.if_else(taken, start, zero),
        )


def with_forces(system: System, contacts: Sequence[Contact]) -> System:
    """Return the system with the forces of contacts behind springs, by their symbols, among the applied ones."""
    force, part = list(system.force), system.linear
    for contact in contacts:
        symbol, slopes = friction_force(contact.name), system.slopes(contact.slip)
        if part is not None and not isinstance(slopes, list):
            part = replace(part, loads=(*part.loads, (symbol, slopes)))
        else:
            force = [e + s * symbol if s != 0 else e for e, s in zip(force, slopes, strict=True)]
    return system if not contacts else replace(system, force=force, linear=part)


def transition_of(
    springs: Sequence[Spring | SliderSet | Opening | Plane | Clocks], y: ca.SX, t: ca.SX, p: ca.SX, mode: ca.SX
) -> ca.Function | None:
    """Return what the events of contacts behind springs do; see `symfric.lower.automaton.Automaton.transition`."""
    if not springs:
        return None
    guards = [0, *itertools.accumulate(spring.layout.guards for spring in springs)]
    first = mode.numel() - sum(spring.layout.variables for spring in springs)
    hit, zero, y_after = ca.SX.sym("hit", guards[-1]), ca.SX.sym("zero", guards[-1]), ca.SX(y)
    variables, zeros = [ca.vertsplit(mode, [0, first, mode.numel()])[0]], []
    for spring, its_hit, its_zero in zip(springs, ca.vertsplit(hit, guards), ca.vertsplit(zero, guards), strict=True):
        z, variable, begins = spring.after(its_hit, its_zero)
        variables.append(variable)
        zeros.append(begins)
        for place, value in z:
            y_after[place] = value
    after = [y_after, ca.vertcat(*variables), ca.vertcat(*zeros)]
    arguments, names = [y, t, p, mode, hit, zero], ["y", "t", "p", "m", "hit", "zero"]
    return ca.Function(
        "transition", arguments, [ca.densify(e) for e in after], names, ["y_after", "m_after", "zero_after"]
    )
