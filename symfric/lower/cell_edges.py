"""Friction at rest on the edge of a cell: which cell carries the force depends on the way the contact would slip.

Let h(q) be the quantity of a switch of a profile that jumps. Where h is zero and stays so, because what would move it
sticks, the switch has no sign; its entry in the mode is then ``+-ON_EDGE``. A contact that slips moves h by

    rho = dh/dq v,   v = the velocities of a unit slip of it (and of what is parallel) while the other contacts stick,

so its friction in the direction d, and the largest that it carries before it slips in that direction, is that of the
side ``d sgn(rho)``. Where rho is zero the slip follows the edge, and the sign stays as it was.
"""

from dataclasses import dataclass, replace

import casadi as ca
import sympy as sp

from symfric.lower.constraint_forces import hold
from symfric.model.validation import made_of_cells

ON_EDGE = 2.0  # magnitude of the entry of a switch that has no sign
_ROUNDING = 64 * 2.0**-52  # of a place that is on an edge
_ALONG = 1e-12  # of the sum of its terms below which rho is zero


@dataclass(frozen=True)
class Edges:
    """The switches at which loads jump.

    Attributes
    ----------
    signs : tuple of SX
        Of all switches of the scene.
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
        """Return an expression of the load of contact i for its slip in the direction `way`."""
        if not self.among[i]:
            return expr
        olds = [self.signs[j] for j in self.among[i]]
        news = []
        for sign, side in zip(olds, self.sides[i], strict=True):
            crossed = ca.if_else(side == 0, sign, way * side)
            news.append(ca.if_else(ca.fabs(sign) == ON_EDGE, crossed, sign))
        return ca.substitute(expr, ca.vertcat(*olds), ca.vertcat(*news))

    def widest(self, expr: ca.SX) -> ca.SX:
        """Return the larger of the magnitudes that an expression of loads has on both sides of where the state lies."""
        if not self.switches:
            return ca.fabs(expr)
        signs = ca.vertcat(*(self.signs[j] for j in self.switches))
        sides = [
            ca.vertcat(*(ca.if_else(n, s, sign) for n, sign in zip(self.near, ca.vertsplit(signs), strict=True)))
            for s in (-1, 1)
        ]
        return ca.fmax(*(ca.fabs(ca.substitute(expr, signs, side)) for side in sides))


def edges_of(low, mass: ca.SX, parallels: list[int]) -> Edges:
    """Find the switches at which loads jump.

    Parameters
    ----------
    low : symfric.lower.automaton.Lowering
    mass : SX
        The mass matrix.
    parallels : list of int
        For each contact the first one of which its slip is a multiple.
    """
    contacts, signs = low.scene.contacts, tuple(low.switches.signs)
    among: list[tuple[int, ...]] = []
    for i, c in enumerate(contacts):
        jumps = signs and not c.law.smooth and made_of_cells(c.profile)
        inside = ca.which_depends(low.load[i], ca.vertcat(*signs), 1) if jumps else ()
        among.append(tuple(j for j, depends in enumerate(inside) if depends))
    switches = sorted({j for group in among for j in group})
    if not switches:
        return Edges(signs, tuple(among), tuple(() for _ in among), (), (), ca.SX(0, 1))
    n = len(low.scene.system.q)
    q, u = low.y[:n], low.y[n : 2 * n]
    h = ca.vertcat(*low.switches.quantities)
    slopes, still = ca.jacobian(h, q), ca.substitute(h, q, ca.SX.zeros(n))
    J, factors = ca.jacobian(low.w, u), ca.ldl(mass)
    spread = ca.ldl_solve(J.T, *factors)
    steep, still = ca.fabs(slopes[switches, :]), ca.fabs(still[switches])
    place = steep @ ca.fabs(q) + still
    near = ca.vertsplit(ca.fabs(h[switches]) <= _ROUNDING * (place + ca.mmax(still)))
    sides = tuple(
        tuple(_sides(low, i, J, spread, parallels, slopes, group)) if group else () for i, group in enumerate(among)
    )
    found = Edges(signs, tuple(among), sides, tuple(switches), tuple(near), ca.SX(0, 1))
    forces = ca.fabs(ca.ldl_solve(ca.SX.eye(n), *factors)) @ _applied(low) + ca.fabs(spread) @ _bounds(low, found)
    sizes = [ca.densify(ca.vertcat(place, steep @ ca.fabs(u), steep @ forces))]
    return replace(found, sizes=low.unswitched(sizes)[0])


def _sides(low, i, J, spread, parallels, slopes, among) -> list[ca.SX]:
    """Return sgn(rho) for the switches `among` and contact i."""
    contacts = low.scene.contacts
    others = [k for k in range(len(contacts)) if parallels[k] != parallels[i] and not contacts[k].law.smooth]
    order = [i, *others]  # of others that cannot all stick while this one slips, those in front do
    sticks = ca.vertcat(1, *(low.s[k] == 1 for k in others))
    pushed = ca.SX([-1.0, *(0.0 for _ in others)])
    _, v, _ = hold(J[order, :], spread[:, order], ca.SX.zeros(J.shape[1]), pushed, sticks, tested=True)
    rows = slopes[list(among), :]
    rho, size = ca.densify(rows @ v), ca.densify(ca.fabs(rows) @ ca.fabs(v))
    way = ca.if_else(rho < 0, -1, 1)
    return [ca.if_else(ca.fabs(rho[k]) <= _ALONG * size[k], 0, way[k]) for k in range(len(among))]


def _applied(low) -> ca.SX:
    """Return the sums of the magnitudes of the applied forces."""
    return ca.vertcat(*(sum(ca.fabs(low.sx(term)) for term in sp.Add.make_args(e)) for e in low.scene.system.force))


def _bounds(low, edges: Edges) -> ca.SX:
    """Return the largest static friction of each contact."""
    return ca.vertcat(*(edges.widest(low.load[i] * low.sx(c.law.stick)) for i, c in enumerate(low.scene.contacts)))
