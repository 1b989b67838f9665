"""The fields of a lane: what of a run is kept in vectors."""

from dataclasses import dataclass

from symfric.lower.automaton import Automaton
from symfric.model.outputs import Row
from symfric.solve.loop.series import Series

# words of the masks: lanes that a kernel left as they were, lanes that stick now, and those that it is called for
LEFT, HELD, CALLED = range(3)
MASKS = 8  # words
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
    events : bool
        Whether events are found and settled in lanes; otherwise the event loop does that.
    """

    automaton: Automaton
    variants: tuple[Series, ...]
    rows: tuple[Row, ...]
    tolerance: float
    doubt: float
    horizon: float
    events: bool

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

    @property
    def n_aux(self) -> int:
        """Largest number of values that depend on parameters and mode alone."""
        return max(v.prelude.nnz_out(0) for v in self.variants)

    @property
    def n_p(self) -> int:
        """Number of parameters that the machine code takes."""
        return self.variants[0].prelude.nnz_in(0)

    def names(self) -> dict[str, int]:
        """Return the place of every field.

        They are states, time, its rounding rest, the last step, where it ends, counts (steps, the number of them at
        which the event loop looks whether the run advances, events, the number of them at which it does so, grazes),
        starts of the states, scales of the rows, two numbers of every wanted row, values that depend on parameters and
        mode; and where events are settled in lanes, the mode, the direction of the last slip, whether a slip begins and
        what acceleration of it counts as none, the time of rest, scales of the guards in the other mode, parameters.
        """
        e, g = len(self.rows), self.n_g
        found = [*_many("y", self.n_x), "t", "t_low", "h_last", "end"]
        found += ["steps", "mark_steps", "events", "mark_events", "grazes"]
        found += [*_many("start", self.n_x), *_many("scale", self.n_r), *_many("first", e), *_many("second", e)]
        found += _many("aux", self.n_aux)
        if self.events:
            found += ["mode", "way", "fresh", "little", "rest", *_many("other", g), *_many("p", self.n_p)]
        return {name: k for k, name in enumerate(found)}


def _many(name: str, n: int) -> list[str]:
    return [f"{name}{k}" for k in range(n)]
