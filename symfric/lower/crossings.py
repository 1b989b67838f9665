"""Expressions at whose zeros something happens: held variables computed there, and resets.

Each has a side, and two guards that are positive while the expression keeps it:

    side =  1:  guards e, 0        side = -1:  guards 0, -e        side = 0:  guards e, -e

The side 0 is that of a run which starts at a zero: it is left as soon as the expression leaves the zero, and this
counts as a crossing. A guard that is hit changes the side; what the loop does if the expression returns at once, or
has jumped, see `symfric.solve.loop.events.crossings`.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

import casadi as ca

PAIR = 2  # guards of a crossing: against falling, against rising


@dataclass(frozen=True, eq=False)
class Crossing:
    """One such expression as a CasADi graph.

    Attributes
    ----------
    value : SX
        The expression.
    side : SX
        Its sign as data, 0 at the start of a run.
    """

    value: ca.SX
    side: ca.SX = field(default_factory=lambda: ca.SX.sym("side"))

    @property
    def guards(self) -> list[ca.SX]:
        """The guards against falling and rising."""
        return [ca.if_else(self.side >= 0, self.value, 0), ca.if_else(self.side <= 0, -self.value, 0)]

    def after(self, hit: ca.SX) -> ca.SX:
        """Return the side after some of its guards were hit."""
        return ca.if_else(hit[0] > 0.5, -1, ca.if_else(hit[1] > 0.5, 1, self.side))


@dataclass(frozen=True, eq=False)
class Queue:
    """Values on their way of a variable that is computed at crossings, the first to act in front.

    Attributes
    ----------
    values, left : tuple of str
        States: the values, and the times until they act.
    waiting : SX
        One more than the number on their way; 0 before the run has begun.
    """

    values: tuple[str, ...]
    left: tuple[str, ...]
    waiting: ca.SX = field(default_factory=lambda: ca.SX.sym("waiting"))

    @property
    def count(self) -> ca.SX:
        """The number on their way."""
        return self.waiting - 1

    def rates(self, places: Mapping[str, int]) -> list[tuple[int, ca.SX]]:
        """Return places and rates of the times left."""
        return [(places[n], ca.if_else(self.count > k, -1, 0)) for k, n in enumerate(self.left)]

    def begun(self, now: Mapping[str, ca.SX], empty: float) -> ca.SX:
        """Return the number on their way, from the times left before the run has begun."""
        occupied = sum((now[n] > empty / 2 for n in self.left), ca.SX(0))
        return ca.if_else(self.waiting < 0.5, occupied, self.count)

    def without_first(self, now: Mapping[str, ca.SX], empty: float) -> dict[str, ca.SX]:
        """Return the states after the first value has acted."""
        after: dict[str, ca.SX] = {}
        for names, last in ((self.values, 0.0), (self.left, empty)):
            after |= dict(zip(names, [*(now[n] for n in names[1:]), ca.SX(last)], strict=True))
        return after

    def with_last(self, now: Mapping[str, ca.SX], count: ca.SX, value: ca.SX, delay: ca.SX) -> dict[str, ca.SX]:
        """Return the states after another value was put behind those on their way."""
        rows = ((self.values, value), (self.left, delay))
        return {n: ca.if_else(count == k, new, now[n]) for names, new in rows for k, n in enumerate(names)}

    def newest(self, now: Mapping[str, ca.SX], count: ca.SX, otherwise: ca.SX) -> ca.SX:
        """Return the last value on its way, or another one if there is none."""
        return chosen(count, [otherwise, *(now[n] for n in self.values)])


def chosen(k: ca.SX, entries: Sequence[ca.SX], otherwise: ca.SX | None = None) -> ca.SX:
    """Return the entry k, and behind the last one this or `otherwise`."""
    value = entries[-1] if otherwise is None else otherwise
    last = len(entries) - (otherwise is None)
    for i in reversed(range(last)):
        value = ca.if_else(k == i, entries[i], value)
    return value
