"""Layout of the mode and guard vectors: indices of the discrete variables and guards of every contact.

The mode of a scene is one vector, and so are its guards, which are positive while the mode is right:

    m      = [stick flags; directions; signs of the switches; variables of the other contacts]
    guards = [two for each contact that slips along a line; switches; loads; those of the other contacts]

The flag of contact i along a line is m[i]. The two guards of such a contact belong to its slip backwards and forwards.
While it sticks they are what is left to the bound that it reaches before it slips that way; while it slips, the first
is the slip in its direction, and the second plays no part. What follows from them the loop decides itself, see
`symfric.solve.loop.modes.mode_selection`.

Every other kind of contact brings a function that says what its events do to state and mode: `Automaton.transition`.
One that opens and closes has the guard of its gap, and resets a velocity; one that slides in a plane has that of the
disc of its friction.
"""

from dataclasses import dataclass

import numpy as np

OPEN = 2  # the mode that runs show of a contact that is open
LINE_GUARDS = 2  # number of guards of a contact that slips along a line
JUST_AFTER = 1e-13  # time, relative to t plus the horizon, after which a step in time at t has surely occurred
GAPS = 3  # rows of such a contact in `symfric.lower.relaxed_guards`: its slip, and the reserve to either bound


def direction(i: int, n_c: int) -> int:
    """Return the index in m of the direction of contact i."""
    return n_c + i


def sign(j: int, n_c: int) -> int:
    """Return the index in m of the sign of switch j."""
    return 2 * n_c + j


def backward(i: int) -> int:
    """Return the index of the guard of contact i against backward slip; while it slips, of its slip."""
    return LINE_GUARDS * i


def forward(i: int) -> int:
    """Return the index of the guard of contact i against forward slip."""
    return LINE_GUARDS * i + 1


def contact_of(g: int) -> int:
    """Return the contact along a line to which a guard belongs, if any."""
    return g // LINE_GUARDS


def is_slip(g: int) -> bool:
    """Whether a guard of a contact along a line is the guard of its slip."""
    return g % LINE_GUARDS == 0


def switch(j: int, n_c: int) -> int:
    """Return the index of the guard of switch j."""
    return LINE_GUARDS * n_c + j


@dataclass(frozen=True)
class OtherContact:
    """A contact that does not slip along a line.

    Attributes
    ----------
    name : str
    variables, guards : int
        Their numbers.
    clocks : bool
        Whether these are clocks, which come last, and whose events are none of contacts.
    line : int
        Index of the contact along a line whose normal direction this is, or which is its first component, or -1.
    opens : bool
        Whether it opens; such contacts come after those behind springs. See `symfric.lower.unilateral`.
    in_plane : bool
        Whether it slides in the plane, with rows `line` and `line` + 1. See `symfric.lower.planes`.
    crossings, resets : int
        How many of the last guards are those of crossings, see `symfric.lower.crossings`, whose sides are the last
        variables; and how many of the last ones are those of resets.
    """

    name: str
    variables: int
    guards: int
    clocks: bool = False
    line: int = -1
    opens: bool = False
    in_plane: bool = False
    crossings: int = 0
    resets: int = 0


@dataclass(frozen=True)
class ModeLayout:
    """The layout of one scene.

    Attributes
    ----------
    lines : tuple of str
        Names of the contacts that slip along a line.
    switches : int
    loads : tuple of str
        Contacts whose normal load varies and may become negative.
    others : tuple of OtherContact
    """

    lines: tuple[str, ...]
    switches: int
    loads: tuple[str, ...] = ()
    others: tuple[OtherContact, ...] = ()

    @property
    def n_mode(self) -> int:
        """Length of m."""
        return self.first_variable + sum(c.variables for c in self.others)

    @property
    def n_guards(self) -> int:
        """Number of guards."""
        return self.first_other + sum(c.guards for c in self.others)

    @property
    def first_variable(self) -> int:
        """Index in m of the first variable of the other contacts."""
        return sign(self.switches, len(self.lines))

    @property
    def first_load(self) -> int:
        """Index of the first guard of the loads."""
        return switch(self.switches, len(self.lines))

    @property
    def first_other(self) -> int:
        """Index of the first guard of the other contacts."""
        return self.first_load + len(self.loads)

    @property
    def first_opening(self) -> int:
        """Index of the first guard of contacts that open; where those would be without them."""
        return self.first_clock - sum(c.guards for c in self.others if c.opens)

    @property
    def first_plane(self) -> int:
        """Index of the first guard of the others that is none of a contact behind a spring."""
        return self.first_other + sum(c.guards for c in self.others if not (c.in_plane or c.opens or c.clocks))

    @property
    def may_jump(self) -> bool:
        """Whether there are guards that the event of another may move across zero at its instant."""
        return self.first_other < self.first_plane or self.first_crossing < self.n_guards

    @property
    def partners(self) -> list[int]:
        """For every contact along a line, the other component of one in the plane, or -1."""
        partner_of = [-1] * len(self.lines)
        for c in (c for c in self.others if c.in_plane):
            partner_of[c.line], partner_of[c.line + 1] = c.line + 1, c.line
        return partner_of

    @property
    def planes(self) -> list[int]:
        """For every contact along a line, the index in m of the first variable of its plane, or -1."""
        first_of = [-1] * len(self.lines)
        for first, c in self._places:
            if c.in_plane:
                first_of[c.line], first_of[c.line + 1] = first, first
        return first_of

    @property
    def n_gaps(self) -> int:
        """Number of rows of `symfric.lower.relaxed_guards`: those of contacts along lines, then gaps."""
        return slip_gap(len(self.lines)) + len(self.openings)

    @property
    def openings(self) -> list[int]:
        """Index in m of the variable of every contact that opens."""
        return [first for first, c in self._places if c.opens]

    @property
    def lines_of_openings(self) -> list[int]:
        """For every contact that opens, its index among those along a line, or -1."""
        return [c.line for c in self.others if c.opens]

    @property
    def shown_openings(self) -> list[int]:
        """For every contact that opens, the number under which runs show it."""
        alone = [k for k, c in enumerate(c for c in self.others if c.line < 0) if c.opens]
        numbers = iter(alone)
        return [c.line if c.line >= 0 else len(self.lines) + next(numbers) for c in self.others if c.opens]

    @property
    def _places(self) -> list[tuple[int, OtherContact]]:
        """The other contacts, each with the index of its first variable in m."""
        places, first = [], self.first_variable
        for contact in self.others:
            places.append((first, contact))
            first += contact.variables
        return places

    @property
    def first_clock(self) -> int:
        """Index of the first guard of clocks; the number of guards without them."""
        return self.n_guards - sum(c.guards for c in self.others if c.clocks)

    @property
    def first_crossing(self) -> int:
        """Index of the first guard of crossings; the number of guards without them."""
        return self.n_guards - sum(c.crossings for c in self.others)

    @property
    def first_reset(self) -> int:
        """Index of the first guard of the crossings of resets; the number of guards without them."""
        return self.n_guards - sum(c.resets for c in self.others)

    @property
    def other_guards(self) -> list[tuple[int, int]]:
        """For each guard of the other contacts, the index of the contact and of its first variable in m, or -1."""
        owners, first = [], self.first_variable
        for k, contact in enumerate(self.others):
            owners += [(k, first if contact.variables else -1)] * contact.guards
            first += contact.variables
        return owners

    @property
    def slips(self) -> slice:
        """The guards of contacts along a line."""
        return slice(0, backward(len(self.lines)))

    @property
    def sticking(self) -> slice:
        """The stick flags in m."""
        return slice(0, len(self.lines))

    @property
    def directions(self) -> slice:
        """The directions in m."""
        return slice(direction(0, len(self.lines)), sign(0, len(self.lines)))

    @property
    def signs(self) -> slice:
        """The signs of the switches in m."""
        return slice(sign(0, len(self.lines)), self.first_variable)

    def modes(self, m: np.ndarray) -> np.ndarray:
        """Return -1, 0 or +1 for each contact that slips backwards, sticks, or slips forwards.

        The first variables of the other contacts follow; 2 stands for a contact that is open.
        """
        lines = np.where(m[self.sticking] > 0.5, 0, m[self.directions])
        modes = np.concatenate([lines, m[self.shown]]).astype(np.int64)
        for place, number in zip(self.openings, self.shown_openings, strict=True):
            modes[number] = OPEN if m[place] > 0.5 else (modes[number] if number < len(self.lines) else 0)
        return modes

    @property
    def shown(self) -> list[int]:
        """Indices in m of the first variable of every other contact that has one."""
        alone = (e for e in self._places if e[1].variables and not e[1].clocks and e[1].line < 0)
        return [first for first, _ in alone]

    def is_along_line(self, g: int) -> bool:
        """Whether a guard is one of a contact that slips along a line."""
        return g < backward(len(self.lines))

    def is_switch(self, g: int) -> bool:
        """Whether a guard is that of a switch."""
        return switch(0, len(self.lines)) <= g < self.first_load

    def sign(self, j: int) -> int:
        """Return the index in m of the sign of switch j."""
        return sign(j, len(self.lines))

    def switch(self, j: int) -> int:
        """Return the index of the guard of switch j."""
        return switch(j, len(self.lines))

    def direction(self, i: int) -> int:
        """Return the index in m of the direction of contact i."""
        return direction(i, len(self.lines))

    def load(self, name: str) -> int:
        """Return the index of the guard of a contact's load, -1 if it has none."""
        return self.first_load + self.loads.index(name) if name in self.loads else -1


def slip_gap(i: int) -> int:
    """Return the row of the slip of contact i among the relaxed guards."""
    return GAPS * i


def gaps(i: int) -> range:
    """Return all rows of contact i among the relaxed guards."""
    return range(GAPS * i, GAPS * (i + 1))


def contact_of_gap(k: int) -> int:
    """Return the contact to which a row of the relaxed guards belongs."""
    return k // GAPS


def is_slip_gap(k: int) -> bool:
    """Whether a row of the relaxed guards is that of a slip."""
    return k % GAPS == 0
