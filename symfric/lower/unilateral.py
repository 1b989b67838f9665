"""Contacts that open: their part of mode and guards.

The mode of such a contact is o = 1 while it is open and 0 while it is closed. It has two guards, of which the one that
plays no part is zero:

    open:    guard gap g(q, t),       normal force N = 0
    closed:  guard normal force N,    g'' = J u' + c = 0,   J = dg/dq,   c = d(J u + dg/dt)/dq u + d(J u + dg/dt)/dt
"""

from dataclasses import dataclass, field

import casadi as ca

from symfric.lower.mode_layout import OtherContact

DEPENDENT = 1e-12  # relative pivot below which a slip or a gap is held by those before it
GUARDS = 2  # of a contact that opens: its gap, and its normal force


@dataclass(frozen=True, eq=False)
class Opening:
    """A contact that opens, as CasADi graphs, with the attributes of `symfric.lower.spring_sliders.Spring`.

    Attributes
    ----------
    name : str
    line : int
        Index of its friction among the contacts along a line, -1 without friction.
    gap, size : SX
        g, and the sum of the magnitudes of its terms, the scale of its rounding.
    restitution : SX
    force : SX
        Symbol of N.
    mode : SX
        o.
    """

    name: str
    line: int
    gap: ca.SX
    size: ca.SX
    restitution: ca.SX
    force: ca.SX
    mode: ca.SX = field(default_factory=lambda: ca.SX.sym("open"))

    rates = ()
    moving_limit = ca.SX(0, 1)

    @property
    def variables(self) -> ca.SX:
        """Its part of the mode."""
        return self.mode

    @property
    def shown(self) -> ca.SX:
        """The variable that a run shows."""
        return self.mode

    @property
    def closed(self) -> ca.SX:
        """1 while it is closed, 0 while it is open."""
        return 1 - self.mode

    @property
    def layout(self) -> OtherContact:
        """What it owns of mode and guards."""
        return OtherContact(self.name, 1, GUARDS, line=self.line, opens=True)

    @property
    def guards(self) -> list[ca.SX]:
        """The two guards."""
        return [ca.if_else(self.mode > 0.5, self.gap, 0), ca.if_else(self.mode > 0.5, 0, self.force)]

    def after(self, hit: ca.SX, zero: ca.SX) -> tuple[list[tuple[int, ca.SX]], ca.SX, ca.SX]:
        """Return the same state and mode: the loop selects them, see `symfric.solve.loop.modes.opening_selection`."""
        return [], self.mode, zero


def approach(gaps: ca.SX, q: ca.SX, u: ca.SX, t: ca.SX) -> tuple[ca.SX, ca.SX, ca.SX]:
    """Return slopes J, rates ``g' = J u + dg/dt`` and their change at constant velocities c of gaps g(q, t)."""
    J = ca.jacobian(gaps, q)
    rate = J @ u + ca.jacobian(gaps, t)
    return J, rate, ca.jacobian(rate, q) @ u + ca.jacobian(rate, t)


def eliminated(A: ca.SX, b: ca.SX, least: float = 0.0) -> ca.SX:
    """Return the solution of ``A x = b`` by Gauss's elimination without exchanges of rows; b may have many columns.

    An unknown whose pivot is not above `least`, relative to its entry on the diagonal, is zero, and its row is dropped.
    """
    n = A.shape[0]
    rows = [[A[i, j] for j in range(n)] for i in range(n)]
    right = [b[i, :] for i in range(n)]
    inverse = []
    for k in range(n):
        pivot = rows[k][k]
        if least > 0.0:
            own = ca.fabs(pivot) > least * ca.fabs(A[k, k])
            inverse.append(own / ca.if_else(own, pivot, 1))
        else:
            inverse.append(1 / pivot)
        for i in range(k + 1, n):
            if rows[i][k].is_zero():
                continue
            factor = rows[i][k] * inverse[k]
            rows[i] = [rows[i][j] - factor * rows[k][j] for j in range(n)]
            right[i] = right[i] - factor * right[k]
    x: list[ca.SX] = [ca.SX(0)] * n
    for i in reversed(range(n)):
        rest = sum((rows[i][j] * x[j] for j in range(i + 1, n) if not rows[i][j].is_zero()), ca.SX(0))
        x[i] = (right[i] - rest) * inverse[i]
    return ca.vertcat(*x)
