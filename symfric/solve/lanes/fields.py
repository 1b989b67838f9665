"""The fields of a lane: what of a run is kept in vectors."""

import hashlib
from dataclasses import dataclass

from symfric.lower.automaton import Automaton
from symfric.lower.mode_layout import backward
from symfric.model.rows import FOLLOW, Row
from symfric.solve.loop.stepping.decay_weights import weights
from symfric.solve.loop.stepping.series import Series

# words of the masks: lanes that a kernel left as they were or whose run or input ends, lanes that stick now, those that
# it is called for, those that are at an event, those of which a row was left; next, of which row that is
LEFT, HELD, CALLED, MET, OWED, OWED_OF = range(6)
# notes of a step: its length, its start, then of every wanted row the coefficients and the scale before the step
LENGTH, TIME, TIME_LOW, NOTED = range(4)
WANTING = -4  # what the loop over lanes returns to get more cases; see `symfric.solve.status` for the others


@dataclass(frozen=True)
class Plan:
    """A scene that runs in lanes.

    Attributes
    ----------
    automaton : Automaton
    variants : tuple of Series
        One for all modes, or one for slipping and one for sticking.
    rows : tuple of Row
    tolerance, doubt : float
        See `symfric.solve.loop.workspace.LoopClock`.
    horizon : float
    exact : int
        Order to which weighted steps are accurate, 0 without them; see `symfric.solve.loop.stepping.decay_weights`.
    selects_mode : bool
        Whether the mode after an event is chosen in lanes; otherwise the event loop does that.
    """

    automaton: Automaton
    variants: tuple[Series, ...]
    rows: tuple[Row, ...]
    tolerance: float
    doubt: float
    horizon: float
    exact: int
    selects_mode: bool

    @property
    def n_x(self) -> int:
        """Number of states."""
        return len(self.automaton.states)

    @property
    def n_g(self) -> int:
        """Number of guards."""
        return self.automaton.layout.n_guards

    @property
    def n_r(self) -> int:
        """Number of rows with coefficients: states, guards, wanted ones."""
        return self.n_x + self.n_g + len(self.rows)

    @property
    def order(self) -> int:
        """Of the series."""
        return self.variants[0].order

    def followers(self, e: int) -> tuple[int, ...]:
        """Return the rows that hold the derivatives of a row at its extremes."""
        return tuple(f for f, row in enumerate(self.rows) if row.kind == FOLLOW and row.follows == e)

    @property
    def follows(self) -> bool:
        """Whether there are such rows."""
        return any(row.kind == FOLLOW for row in self.rows)

    @property
    def noted(self) -> int:
        """Number of notes of one row."""
        return self.order + 2

    @property
    def n_aux(self) -> int:
        """Largest number of values that depend on parameters and mode alone."""
        return max(v.prelude.nnz_out(0) for v in self.variants)

    @property
    def n_p(self) -> int:
        """Number of parameters that the machine code takes."""
        return self.variants[0].prelude.nnz_in(0)

    def key(self) -> str:
        """Return a hash of all that kernels are written from."""
        automaton = self.automaton
        parts = [str(self.tolerance), str(self.doubt), str(self.horizon), str(self.selects_mode), str(self.order)]
        parts += [str(self.exact), str(weights(self.order))] if self.exact else []
        parts += [str(automaton.layout), str(automaton.anchors), str(automaton.n_q), automaton.gauge.serialize()]
        parts += [str([(row.kind, row.follows) for row in self.rows]), str(self.n_x)]
        for v in self.variants:
            functions = [f.serialize() for f in (v.prelude, v.series, v.probe, v.unseen) if f is not None]
            parts += [*functions, str(v.exposed)]
        return hashlib.sha256("\n".join(parts).encode()).hexdigest()

    @property
    def starting(self) -> tuple[int, ...]:
        """Guards that may start a mode at zero."""
        return (backward(0),) if self.selects_mode else tuple(range(self.n_g))

    def names(self) -> dict[str, int]:
        """Return the place of every field.

        They are states, time, its rounding rest, the last step, where it ends (the run, or the slope of an input),
        counts of steps and at which of them the event loop looks whether the run advances, starts of the states, scales
        of the rows, two numbers of every wanted row, at which count of steps new extremes of a row with derivatives
        were seen last, values that depend on parameters and mode; whether guards start at zero, and what acceleration
        of a slip counts as none. Where the event loop chooses the mode after an event, by how much loads are shifted,
        and the guard that an event has reached. Where lanes do, the number of events and at which of them the event
        loop looks whether time advances, that of grazes, the mode, the direction of the last slip, the time of rest,
        scales of the guards in the other mode, parameters.
        """
        e, g, layout = len(self.rows), self.n_g, self.automaton.layout
        fields = [*_many("y", self.n_x), "t", "t_low", "h_last", "end", "steps", "mark_steps"]
        fields += [*_many("start", self.n_x), *_many("scale", self.n_r), *_many("first", e), *_many("second", e)]
        fields += [*_many("seen", e * self.follows), *_many("aux", self.n_aux), *(f"fresh{i}" for i in self.starting)]
        fields += _many("little", len(layout.lines))
        if self.selects_mode:
            fields += ["events", "mark_events", "grazes", "mode", "way", "rest", *_many("other", g)]
            fields += _many("p", self.n_p)
        else:
            fields += [*_many("slack", len(layout.loads)), "which"]
        return {name: k for k, name in enumerate(fields)}


def _many(name: str, n: int) -> list[str]:
    return [f"{name}{k}" for k in range(n)]
