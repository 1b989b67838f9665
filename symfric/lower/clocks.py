"""Held variables and resets as a contact of another kind: its guards are the times left, its events change states.

Clock j has a counter and the guard ``first_j + k T_j - t``. Where one clock strikes, so do those whose instant is the
same to rounding, in this order: delayed values act, samples are taken, states are reset. Values on their way stand in
a queue of states, which moves on at every sample: the one that acts is always the last. So the states at the end of a
period are all that the next one needs.
"""

from collections.abc import Mapping
from dataclasses import dataclass

import casadi as ca
import sympy as sp

from symfric.lower.mode_layout import JUST_AFTER, OtherContact
from symfric.lower.printer import Printer, Switches
from symfric.model.held import Held, Reset
from symfric.model.scene import Scene


@dataclass(frozen=True, eq=False)
class Clocks:
    """All clocks of a scene as CasADi graphs, with the attributes of `symfric.lower.spring_sliders.Spring`.

    Attributes
    ----------
    held : tuple of Held
        In the order in which they are computed.
    resets : tuple of Reset
    symbols : mapping of Symbol to SX
        Graph of every symbol.
    places : mapping of str to int
        Indices of the states.
    t : SX
    horizon : float
    counters : SX
        Number of strikes of every clock.
    """

    held: tuple[Held, ...]
    resets: tuple[Reset, ...]
    symbols: Mapping[sp.Symbol, ca.SX]
    places: Mapping[str, int]
    t: ca.SX
    horizon: float
    counters: ca.SX

    name = "clocks"
    rates = ()
    moving_limit = ca.SX(0, 1)

    @classmethod
    def of(
        cls, scene: Scene, symbols: Mapping[sp.Symbol, ca.SX], constants: Mapping[sp.Symbol, sp.Expr], t: ca.SX
    ) -> "Clocks":
        """Return the clocks of a scene, whose symbols have these graphs, or are numbers."""
        symbols = {**symbols, **{s: ca.SX(float(v)) for s, v in constants.items()}}
        n = sum(2 if h.late else 1 for h in scene.held) + len(scene.resets)
        places = {s.name: i for i, s in enumerate(scene.system.states)}
        return cls(scene.held, scene.resets, symbols, places, t, scene.horizon, ca.SX.sym("strikes", n))

    @property
    def variables(self) -> ca.SX:
        """Their part of the mode."""
        return self.counters

    @property
    def layout(self) -> OtherContact:
        """What they own of mode and guards."""
        n = self.counters.numel()
        return OtherContact(self.name, n, n, clocks=True)

    @property
    def guards(self) -> list[ca.SX]:
        """The times left."""
        show = Printer(dict(self.symbols), set(), Switches())
        counts, left = iter(ca.vertsplit(self.counters)), []
        for h in self.held:
            first, period = show(h.offset), show(h.every)
            left.append(first + next(counts) * period - self.t)
            if h.late:
                first = first + show(h.delay)
                left.append(first + (next(counts) - self._earlier(h)) * period - self.t)
        for reset, k in zip(self.resets, counts, strict=True):
            if reset.every is not None:
                left.append(show(reset.offset) + k * show(reset.every) - self.t)
            else:
                left.append(_chosen(k, [show(e) - self.t for e in reset.at], ca.SX(self.horizon)))
        return left

    def after(self, hit: ca.SX, zero: ca.SX) -> tuple[list[tuple[int, ca.SX]], ca.SX, ca.SX]:
        """Return states with their places, variables, and guards that start at zero, after some clocks struck."""
        soon = JUST_AFTER * (ca.fabs(self.t) + self.horizon)
        left, any_hit = self.guards, ca.mmax(hit) > 0.5
        strikes = [
            ca.logic_or(h > 0.5, ca.logic_and(any_hit, g <= soon)) for h, g in zip(ca.vertsplit(hit), left, strict=True)
        ]
        now = {n: self.symbols[s] for n, s in self._states.items()}
        counts, clock = ca.vertsplit(self.counters), iter(range(len(strikes)))
        places = {h.name: (next(clock), next(clock) if h.late else -1) for h in self.held}
        for h in (h for h in self.held if h.late):
            samples, acts = places[h.name]
            right = counts[samples] - counts[acts] + self._earlier(h) == h.late
            arrived = ca.if_else(right, now[h.states[-1].name], ca.SX.nan())
            now[h.name] = ca.if_else(strikes[acts], arrived, now[h.name])
        previous = {h.previous: now[h.states[h.late > 0].name] for h in self.held}
        for h in self.held:
            value = self._read(h.update, now, previous)
            if h.step is not None:
                step = self._read(h.step, now, {})
                value = step * ca.floor(value / step + 0.5)
            names = [s.name for s in h.states[h.late > 0 :]]
            moved = zip(names, [value, *(now[n] for n in names[:-1])], strict=True)
            now |= {n: ca.if_else(strikes[places[h.name][0]], e, now[n]) for n, e in moved}
        for reset, j in zip(self.resets, clock, strict=True):
            new = {n: _chosen(counts[j], [self._read(e, now, {}) for e in es]) for n, es in reset.set.items()}
            now |= {n: ca.if_else(strikes[j], e, now[n]) for n, e in new.items()}
        struck = self.counters + ca.vertcat(*strikes)
        return [(self.places[n], e) for n, e in now.items()], struck, ca.SX.zeros(hit.numel())

    def _earlier(self, h: Held) -> ca.SX:
        """Return how many values act before that of the first sample; they stand in the queue at the start."""
        show = Printer(dict(self.symbols), set(), Switches())
        return ca.floor((show(h.offset) + show(h.delay)) / show(h.every))

    @property
    def _states(self) -> dict[str, sp.Symbol]:
        """The states by name."""
        return {s.name: s for s in self.symbols if s.name in self.places}

    def _read(self, e: sp.Expr, now: Mapping[str, ca.SX], previous: Mapping[sp.Symbol, ca.SX]) -> ca.SX:
        """Return the graph of an expression of the present states; its kinks and jumps are evaluated."""
        known = {**self.symbols, **{s: now[n] for n, s in self._states.items()}, **previous}
        return Printer(known, set(), Switches())(e.replace(sp.sign, _side))


def _side(a: sp.Expr) -> sp.Expr:
    """Return the sign of an expression as branches."""
    return sp.Piecewise((-1, a < 0), (1, a > 0), (0, True))


def _chosen(k: ca.SX, entries: list[ca.SX], otherwise: ca.SX | None = None) -> ca.SX:
    """Return the entry k, and behind the last one this or `otherwise`."""
    found = entries[-1] if otherwise is None else otherwise
    last = len(entries) - (otherwise is None)
    for i in reversed(range(last)):
        found = ca.if_else(k == i, entries[i], found)
    return found
