"""Contacts in the plane: their part of the mode, and the direction of their friction.

Such a contact has two slips, the components of a vector w, which are rows among the contacts along a line. While it
sticks both are held at zero, by any force within the disc of its static bound B. While it slips,

    lambda = -N mu(|w|) w/|w|,

which is smooth as long as ``|w| > 0``. Where it starts from rest the quotient has no series: over a short first step
the direction is given instead, as a unit vector that turns,

    e(t) = e_0 + e_1 tau + e_2 tau^2 + ...,   tau = t - t_0,

see `symfric.solve.loop.stepping.release_in_plane`. The flag of both rows is `STARTS` then.

With an ellipse of factors ``E = diag(e_0, e_1)`` the rows are those of ``E w``, and their forces ``E^-1 f``: in these
the friction is the one above, with the disc of the bound and the same power ``f^T w``. Only the law depends on the
speed |w| of the slip itself.

The guards of the two rows, in the order of `symfric.lower.mode_layout`:

    slips:                       |w|,              1;   1,     1
    sticks:                      B^2 - |lambda|^2, 1;   1,     1
    starts, or has no force:     w_1,           -w_1;   w_2, -w_2
    open:                        0,                0;   0,     0
"""

from dataclasses import dataclass, field, replace

import casadi as ca

from symfric.lower.constraint_forces import FOLLOWS
from symfric.lower.mode_layout import OtherContact
from symfric.model.system import Contact

STARTS = -1.0  # mark of a contact in the plane whose direction is given
TURNS = 8  # order to which it is given
SINCE = 2 * (TURNS + 1)  # place of t_0 in the variables of a contact, behind e_0, e_1, ...


def rows_of(contact: Contact) -> list[Contact]:
    """Return a contact along a line as it is, and one in the plane as the two components of its slip.

    Those of a contact with an ellipse are scaled by its factors.
    """
    if contact.across is None:
        return [contact]
    if contact.ellipse is not None:
        first, second = contact.ellipse
        contact = replace(contact, slip=first * contact.slip, across=second * contact.across)
    return [contact, replace(contact, name=f"{contact.name}[1]", slip=contact.across, across=None, ellipse=None)]


@dataclass(frozen=True, eq=False)
class Plane:
    """A contact in the plane, as CasADi graphs, with the attributes of `symfric.lower.spring_sliders.Spring`.

    Attributes
    ----------
    name : str
    row : int
        Index of its first component among the contacts along a line; the second follows.
    w : SX, shape (2,)
        Slip.
    flag, time : SX
        The mark of its rows in the mode, and time.
    factors : SX or None, shape (2,)
        Those of an ellipse, with which the slip is scaled.
    opens : SX or None
        Of a contact that opens, whether it is open: then it has no friction, and its slip may be zero.
    variables : SX, shape (SINCE + 1,)
        Its part of the mode: e_0, e_1, ..., t_0.
    """

    name: str
    row: int
    w: ca.SX
    flag: ca.SX
    time: ca.SX
    factors: ca.SX | None = None
    opens: ca.SX | None = None
    variables: ca.SX = field(default_factory=lambda: ca.SX.sym("plane", SINCE + 1))

    rates = ()
    guards = ()
    moving_limit = ca.SX(0, 1)

    @property
    def shown(self) -> ca.SX:
        """The variables that a run shows: none, its rows have its mode."""
        return ca.SX(0, 1)

    @property
    def layout(self) -> OtherContact:
        """What it owns of mode and guards beside its rows."""
        return OtherContact(self.name, self.variables.numel(), 0, line=self.row, in_plane=True)

    def after(self, hit: ca.SX, zero: ca.SX) -> tuple[list[tuple[int, ca.SX]], ca.SX, ca.SX]:
        """Return the same state and mode: the loop selects them, see `symfric.solve.loop.modes.planes`."""
        return [], self.variables, zero

    @property
    def rows(self) -> slice:
        """Its rows among the contacts along a line."""
        return slice(self.row, self.row + 2)

    @property
    def starts(self) -> ca.SX:
        """Whether its direction is given."""
        return self.flag < -0.5

    @property
    def rests(self) -> ca.SX:
        """Whether it has no speed of sliding: it sticks, or is open."""
        return self.flag > 0.5 if self.opens is None else ca.logic_or(self.flag > 0.5, self.opens > 0.5)

    @property
    def _slips(self) -> ca.SX:
        """Whether it slips in the direction of its slip."""
        slips = ca.logic_and(self.flag < 0.5, ca.logic_not(self.starts))
        return slips if self.opens is None else ca.logic_and(slips, self.opens < 0.5)

    @property
    def speed(self) -> ca.SX:
        """The speed of its slip, 1 while it sticks or is open, where no friction law is evaluated."""
        square = ca.if_else(self._slips, ca.sumsqr(self.w), 1)
        return ca.if_else(self.starts, ca.dot(self.given, self.w), ca.sqrt(square))

    @property
    def slip_speed(self) -> ca.SX:
        """The speed of the slip before it is scaled, of which the law is a function."""
        if self.factors is None:
            return self.speed
        own = ca.sumsqr(self.w / self.factors)
        return ca.if_else(
            self.starts,
            ca.dot(self.given, self.w) * ca.norm_2(ca.if_else(self.starts, self.given / self.factors, 1)),
            ca.sqrt(ca.if_else(self._slips, own, 1)),
        )

    @property
    def given(self) -> ca.SX:
        """The direction that is given."""
        tau, given = self.time - self.variables[SINCE], ca.SX.zeros(2)
        for k in reversed(range(TURNS + 1)):
            given = self.variables[2 * k : 2 * k + 2] + given * tau
        return given

    @property
    def told(self) -> ca.SX:
        """The force that it is told while it sticks, zero while its slip has not been decided on."""
        told = self.variables[:2] + self.variables[2:4] * (self.time - self.variables[SINCE])
        return ca.if_else(ca.logic_and(self.flag > 0.5, self.flag != FOLLOWS), told, 0)

    @property
    def direction(self) -> ca.SX:
        """The unit vector of its slip while it slips."""
        return ca.if_else(self.starts, self.given, self.w / ca.if_else(self.starts, 1, self.speed))

    def row_guards(self, bound: ca.SX, friction: ca.SX) -> list[ca.SX]:
        """Return the four guards of its rows.

        Parameters
        ----------
        bound : SX
            Largest friction at rest.
        friction : SX, shape (2,)
        """
        free = ca.logic_or(self.starts, self.flag == FOLLOWS)
        sticks = self.flag > 0.5
        own = ca.if_else(sticks, bound**2 - ca.sumsqr(friction), self.speed)
        shown = [own, ca.SX(1), ca.SX(1), ca.SX(1)]
        slips = [self.w[0], -self.w[0], self.w[1], -self.w[1]]
        guards = [ca.if_else(free, a, b) for a, b in zip(slips, shown, strict=True)]
        return guards if self.opens is None else [ca.if_else(self.opens > 0.5, 0, e) for e in guards]
