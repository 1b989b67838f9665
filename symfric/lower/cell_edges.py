"""Friction at rest on the edge of a cell: the cell that bears the force depends on the direction of impending slip.

Let h(q) be the quantity of a switch of a profile that jumps. Where h is zero and stays so, because what would move it
sticks, the switch has no sign; its entry in the mode is then ``+-ON_EDGE``. A contact that slips moves h by

    rho = dh/dq v,   v = the velocities of a unit slip of it (and of what is parallel) while the other contacts stick,

so its friction in the direction d, and the largest that it carries before it slips in that direction, is that of the
side ``d sgn(rho)``. Where rho is zero the slip follows the edge, and the sign stays as it was.
"""

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import casadi as ca
import sympy as sp

from symfric.lower.constraint_forces import HOLDS, hold
from symfric.lower.linear_part import applied_in
from symfric.model.validation import made_of_cells

if TYPE_CHECKING:
    from symfric.lower.contact_dynamics import ContactDynamics

ON_EDGE = 2.0  # magnitude of the mode entry of a switch that is on an edge and has no sign
_ROUNDING = 64 * 2.0**-52  # relative distance from an edge that counts as zero
_ALONG = 1e-12  # size of rho relative to its terms below which it is zero


@dataclass(frozen=True)
class Edges:
    """The switches at which friction profiles jump.

    Attributes
    ----------
    signs : tuple of SX
        Signs of all switches of the scene.
    among : tuple of tuple of int
        For each contact, the switches of its profile; none unless the profile jumps.
    sides : tuple of tuple of SX
        For each of these, the sign that the switch takes where the contact slips forwards; 0 along the edge.
    switches : tuple of int
        All of them, increasing.
    near : tuple of SX
        Whether the state lies on their edges, to rounding.
    sizes : SX
        For each of `switches` the sum of the magnitudes of the terms of h, then those of h', then those of h'': the
        scales of zero tests.
    """

    signs: tuple[ca.SX, ...]
    among: tuple[tuple[int, ...], ...]
    sides: tuple[tuple[ca.SX, ...], ...]
    switches: tuple[int, ...]
    near: tuple[ca.SX, ...]
    sizes: ca.SX

    def towards(self, i: int, way: ca.SX, expr: ca.SX) -> ca.SX:
        """Return an expression of the load of contact i for slip in the direction `way`."""
        if not self.among[i]:
            return expr
        olds = [self.signs[j] for j in self.among[i]]
        news = []
        for sign, side in zip(olds, self.sides[i], strict=True):
            crossed = ca.if_else(side == 0, sign, way * side)
            news.append(ca.if_else(ca.fabs(sign) == ON_EDGE, crossed, sign))
        return ca.substitute(expr, ca.vertcat(*olds), ca.vertcat(*news))

    def widest(self, expr: ca.SX) -> ca.SX:
        """Return the larger of the magnitudes of an expression of loads on both sides of an edge."""
        if not self.switches:
            return ca.fabs(expr)
        signs = ca.vertcat(*(self.signs[j] for j in self.switches))
        sides = [
            ca.vertcat(*(ca.if_else(n, s, sign) for n, sign in zip(self.near, ca.vertsplit(signs), strict=True)))
            for s in (-1, 1)
        ]
        return ca.fmax(*(ca.fabs(ca.substitute(expr, signs, side)) for side in sides))


def edges_of(model: "ContactDynamics") -> Edges:
    """Find the switches at which friction profiles jump."""
    contacts, signs = model.contacts, tuple(model.switches.signs)
    among: list[tuple[int, ...]] = []
    for i, c in enumerate(contacts):
        jumps = signs and not c.law.smooth and made_of_cells(c.profile)
        inside = ca.which_depends(model.load[i], ca.vertcat(*signs), 1) if jumps else ()
        among.append(tuple(j for j, depends in enumerate(inside) if depends))
    switches = sorted({j for group in among for j in group})
    if not switches:
        return Edges(signs, tuple(among), tuple(() for _ in among), (), (), ca.SX(0, 1))
    q, u = model.q, model.u
    h = ca.vertcat(*model.switches.quantities)
    slopes, still = ca.jacobian(h, q), ca.substitute(h, q, ca.SX.zeros(q.numel()))
    steep, still = ca.fabs(slopes[switches, :]), ca.fabs(still[switches])
    place = steep @ ca.fabs(q) + still
    near = ca.vertsplit(ca.fabs(h[switches]) <= _ROUNDING * (place + ca.mmax(still)))
    sides = tuple(tuple(_sides(model, i, slopes, group)) if group else () for i, group in enumerate(among))
    edges = Edges(signs, tuple(among), sides, tuple(switches), tuple(near), ca.SX(0, 1))
    able = ca.fabs(model.solve(ca.SX.eye(q.numel())))
    forces = able @ _applied(model) + ca.fabs(model.spread) @ _bounds(model, edges)
    sizes = [ca.densify(ca.vertcat(place, steep @ ca.fabs(u), steep @ forces))]
    return replace(edges, sizes=model.unswitched(sizes)[0])


def _sides(model: "ContactDynamics", i: int, slopes: ca.SX, among: tuple[int, ...]) -> list[ca.SX]:
    """Return sgn(rho) for the switches `among` and contact i."""
    contacts, groups = model.contacts, [k for k, _ in model.parallels]
    others = [k for k in range(len(contacts)) if groups[k] != groups[i] and not contacts[k].law.smooth]
    order = [i, *others]  # if not all others can stick while this one slips, the first ones do
    sticks = ca.vertcat(1, *(model.s[k] == HOLDS for k in others))
    pushed = ca.SX([-1.0, *(0.0 for _ in others)])
    J, still = model.slopes[order, :], ca.SX.zeros(model.u.numel())
    _, v, _ = hold(J, model.spread[:, order], still, pushed, sticks, tested=True)
    rows = slopes[list(among), :]
    rho, size = ca.densify(rows @ v), ca.densify(ca.fabs(rows) @ ca.fabs(v))
    way = ca.if_else(rho < 0, -1, 1)
    return [ca.if_else(ca.fabs(rho[k]) <= _ALONG * size[k], 0, way[k]) for k in range(len(among))]


def _applied(model: "ContactDynamics") -> ca.SX:
    """Return the sums of the magnitudes of the applied forces."""
    terms = [sp.Add.make_args(e) for e in model.system.force]
    total = ca.vertcat(*(sum(ca.fabs(model.read(term)) for term in es) for es in terms))
    part = model.system.linear
    return total if part is None else total + applied_in(part, model.read, model.q, model.u)


def _bounds(model: "ContactDynamics", edges: Edges) -> ca.SX:
    """Return the largest static friction of each contact."""
    return ca.vertcat(*(edges.widest(e) for e in ca.vertsplit(model.load * model.static)))
