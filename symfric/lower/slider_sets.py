"""Sliders of one law behind springs in parallel: rates, guards, and what their events do; see `sf.laws.maxwell_slip`.

All springs are stretched by the same slip w; slider k sticks (e_k = 0), or moves (e_k = 1) like the others that move in
the direction D:

    z_k' = (1 - e_k) w,   guards: limit_k^2 - z_k^2 while slider k sticks, D w while any moves.

A slider that reaches its limit moves from there, at z_k = D limit_k exactly; when w turns, all stick, and the guards of
those that moved start at zero. The first variable of the mode is what a run shows: D while all sliders move, else 0.
"""

from dataclasses import dataclass
from functools import cached_property

import casadi as ca

from symfric.lower.mode_layout import OtherContact

_SHOWN, _SIDE, _FLAGS = 0, 1, 2  # places among the variables


@dataclass(frozen=True, eq=False)
class SliderSet:
    """The sliders of one contact as CasADi graphs.

    Attributes
    ----------
    name : str
    places : tuple of int
        Indices of the elongations among the states.
    z, limits : SX, shape (n,)
        The elongations, and their largest magnitudes.
    w, force : SX
        Slip, and friction force on the body.
    """

    name: str
    places: tuple[int, ...]
    z: ca.SX
    limits: ca.SX
    w: ca.SX
    force: ca.SX

    @cached_property
    def variables(self) -> ca.SX:
        """Its part of the mode."""
        return ca.SX.sym("slider", _FLAGS + len(self.places))

    @property
    def shown(self) -> ca.SX:
        """The variable that a run shows."""
        return self.variables[_SHOWN]

    @property
    def moving_limit(self) -> ca.SX:
        """What decides when sliders move."""
        return self.limits

    @property
    def layout(self) -> OtherContact:
        """What it owns of mode and guards."""
        return OtherContact(self.name, _FLAGS + len(self.places), 1 + len(self.places))

    @property
    def rates(self) -> list[tuple[int, ca.SX]]:
        """Places and rates of the elongations."""
        return [(k, (1 - e) * self.w) for k, e in zip(self.places, ca.vertsplit(self.variables[_FLAGS:]), strict=True)]

    @property
    def guards(self) -> list[ca.SX]:
        """The slip in the direction of the sliders that move, and what is left to the limit of those that stick."""
        flags, left = ca.vertsplit(self.variables[_FLAGS:]), ca.vertsplit(self.limits**2 - self.z**2)
        turns = ca.if_else(ca.mmax(self.variables[_FLAGS:]) > 0.5, self.variables[_SIDE] * self.w, 1)
        return [turns, *(ca.if_else(e > 0.5, 1, g) for e, g in zip(flags, left, strict=True))]

    def after(self, hit: ca.SX, zero: ca.SX) -> tuple[list[tuple[int, ca.SX]], ca.SX, ca.SX]:
        """Return elongations with their places, variables, and guards that start at zero, after guards were hit."""
        moved, side = self.variables[_FLAGS:], self.variables[_SIDE]
        turns, reached = hit[0], ca.if_else(hit[0], ca.SX.zeros(len(self.places)), hit[1:])
        any_reached = ca.mmax(reached) > 0.5
        towards = ca.if_else(ca.dot(reached, self.z) < 0, -1, 1)
        side = ca.if_else(any_reached, towards, side)
        moves = ca.if_else(turns, ca.SX.zeros(len(self.places)), ca.fmax(moved, reached))
        variables = ca.vertcat(ca.if_else(ca.mmin(moves) > 0.5, side, 0), side, moves)
        z = ca.if_else(reached, side * self.limits, self.z)
        begin = ca.if_else(turns, ca.vertcat(0, moved), ca.if_else(any_reached, ca.SX.zeros(hit.numel()), zero))
        return list(zip(self.places, ca.vertsplit(z), strict=True)), variables, begin
