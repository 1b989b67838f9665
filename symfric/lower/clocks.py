"""Held variables and resets as a contact of another kind: its guards are times left and crossings.

Clock j has a counter and the guard ``first_j + k T_j - t``. Where one clock strikes, so do those whose instant is the
same to rounding, in this order: delayed values act, values are computed, states are reset. Sampled values on their way
stand in a queue of states, which moves on at every sample: the one that acts was sampled so many samples ago as the
delay has periods. Values computed at crossings have their times left as states, see `symfric.lower.crossings`. So the
states at the end of a period are all that the next one needs.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass

import casadi as ca
import sympy as sp

from symfric.lower.at_instants import evaluated
from symfric.lower.crossings import PAIR, Crossing, Queue, chosen
from symfric.lower.mode_layout import JUST_AFTER, OtherContact
from symfric.lower.printer import Printer, Switches
from symfric.model.held import EMPTY, Held, at_side
from symfric.model.resets import Reset
from symfric.model.scene import Scene

_MARGIN = 1e-12  # difference up to which a delay is a whole number of periods
_SIDE = sp.Symbol("side of a crossing", real=True)


@dataclass(frozen=True, eq=False)
class Clocks:
    """All held variables and resets as CasADi graphs, with the attributes of `symfric.lower.spring_sliders.Spring`.

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
    queues : dict of str to Queue
        Of the variables computed at crossings that have a delay.
    crossings : dict of Held or Reset to Crossing
        Those of held variables come first.
    """

    held: tuple[Held, ...]
    resets: tuple[Reset, ...]
    symbols: Mapping[sp.Symbol, ca.SX]
    places: Mapping[str, int]
    t: ca.SX
    horizon: float
    counters: ca.SX
    queues: dict[str, Queue]
    crossings: dict[Held | Reset, Crossing]

    name = "clocks"
    moving_limit = ca.SX(0, 1)

    @classmethod
    def of(
        cls,
        scene: Scene,
        symbols: Mapping[sp.Symbol, ca.SX],
        constants: Mapping[sp.Symbol, sp.Expr],
        t: ca.SX,
        read: Callable[[sp.Expr], ca.SX],
    ) -> "Clocks":
        """Return those of a scene, whose symbols have these graphs, or are numbers; `read` prints with modes."""
        symbols = {**symbols, **{s: ca.SX(float(v)) for s, v in constants.items()}}
        n = sum(2 if h.late else 1 for h in scene.held if h.when is None) + sum(r.guard is None for r in scene.resets)
        places = {s.name: i for i, s in enumerate(scene.system.states)}
        queues = {
            h.name: Queue(tuple(s.name for s in h.queue), tuple(s.name for s in h.left))
            for h in scene.held
            if h.when is not None and h.late
        }
        crossings = {part: Crossing(read(part.crossing)) for part in scene.clocks if part.crossing is not None}
        counters = ca.SX.sym("strikes", n)
        return cls(scene.held, scene.resets, symbols, places, t, scene.horizon, counters, queues, crossings)

    @property
    def variables(self) -> ca.SX:
        """Their part of the mode."""
        waiting, sides = (q.waiting for q in self.queues.values()), (c.side for c in self.crossings.values())
        return ca.vertcat(self.counters, *waiting, *sides)

    @property
    def layout(self) -> OtherContact:
        """What they own of mode and guards."""
        pairs = PAIR * len(self.crossings)
        n = self.counters.numel() + len(self.queues)
        resets = PAIR * sum(isinstance(part, Reset) for part in self.crossings)
        return OtherContact(self.name, n + len(self.crossings), n + pairs, clocks=True, crossings=pairs, resets=resets)

    @property
    def rates(self) -> list[tuple[int, ca.SX]]:
        """Places and rates of the times left."""
        return [rate for queue in self.queues.values() for rate in queue.rates(self.places)]

    @property
    def guards(self) -> list[ca.SX]:
        """The times left of clocks and of values on their way, and the guards of crossings."""
        arrivals = [ca.if_else(queue.waiting > 1.5, self._now[queue.left[0]], 0) for queue in self.queues.values()]
        return [*self._times_left, *arrivals, *(g for c in self.crossings.values() for g in c.guards)]

    @property
    def _times_left(self) -> list[ca.SX]:
        show = Printer(dict(self.symbols), set(), Switches())
        counts, left = iter(ca.vertsplit(self.counters)), []
        for h in (h for h in self.held if h.when is None):
            first, period = show(h.offset), show(h.every)
            left.append(first + next(counts) * period - self.t)
            if h.late:
                first = first + show(h.delay)
                left.append(first + (next(counts) - self._earlier(h)) * period - self.t)
        for reset, k in zip((r for r in self.resets if r.guard is None), counts, strict=True):
            if reset.every is not None:
                left.append(show(reset.offset) + k * show(reset.every) - self.t)
            else:
                left.append(chosen(k, [show(e) - self.t for e in reset.at], ca.SX(self.horizon)))
        return left

    @property
    def struck_before(self) -> ca.SX:
        """Number of strikes of every clock before t, for a run that begins at any time."""
        show, soon = Printer(dict(self.symbols), set(), Switches()), JUST_AFTER * (ca.fabs(self.t) + self.horizon)

        def before(first: ca.SX, period: ca.SX) -> ca.SX:
            return ca.fmax(0, ca.ceil((self.t - first - soon) / period))

        counts = []
        for h in (h for h in self.held if h.when is None):
            first, period = show(h.offset), show(h.every)
            counts.append(before(first, period))
            if h.late:
                counts.append(before(first + show(h.delay) - self._earlier(h) * period, period))
        for reset in (r for r in self.resets if r.guard is None):
            if reset.every is not None:
                counts.append(before(show(reset.offset), show(reset.every)))
            else:
                counts.append(sum((ca.SX(show(e) < self.t - soon) for e in reset.at), ca.SX(0)))
        return ca.vertcat(*counts)

    @property
    def begun(self) -> ca.SX:
        """The variables of a run that begins at t with the present states, without the sides of crossings."""
        counts = [ca.substitute(queue.begun(self._now, EMPTY), queue.waiting, 0) for queue in self.queues.values()]
        return ca.vertcat(self.struck_before, *(count + 1 for count in counts))

    def after(self, hit: ca.SX, zero: ca.SX) -> tuple[list[tuple[int, ca.SX]], ca.SX, ca.SX]:
        """Return states with their places, variables, and guards that start at zero, after some of them were hit.

        Of crossings the loop decides which guards start at zero.
        """
        return _Instant(self, self._happening(hit), ca.mmax(hit) > 0.5).result()

    def _happening(self, hit: ca.SX) -> ca.SX:
        """Return what is hit without crossings that something else makes jump back at the same instant.

        Such an expression reaches zero and does not pass it, as the saw-tooth of a pulse width of the whole period.
        What its own part changes is the work of the crossing. Crossings are judged one after the other.
        """
        first = self.counters.numel() + len(self.queues)
        for k, crossing in enumerate(self.crossings.values()):
            own = slice(first + PAIR * k, first + PAIR * (k + 1))
            others = ca.vertcat(hit[: own.start], ca.SX.zeros(hit.numel() - own.start))
            now = _Instant(self, others, ca.mmax(hit) > 0.5).states()
            before = self._now
            moved = ca.substitute(crossing.value, ca.vertcat(*before.values()), ca.vertcat(*(now[n] for n in before)))
            falls, rises = hit[own.start] > 0.5, hit[own.start + 1] > 0.5
            back = ca.logic_or(ca.logic_and(falls, moved > 0), ca.logic_and(rises, moved < 0))
            returns = ca.logic_and(moved != crossing.value, back)
            hit = ca.vertcat(hit[: own.start], ca.if_else(returns, 0, hit[own]), hit[own.stop :])
        return hit

    def after_reset(self, reset: Reset, entry: int) -> dict[int, ca.SX]:
        """Return what a reset alone makes of the states that it sets, by their places; `entry`: which of its times."""
        after = _Instant(self, ca.SX.zeros(self.layout.guards), ca.SX(0)).alone(reset, entry)
        return {self.places[n]: e for n, e in after.items()}

    def guard_of(self, reset: Reset) -> ca.SX:
        """Return the expression at whose zeros a reset acts."""
        assert reset.guard is not None
        return _Instant(self, ca.SX.zeros(self.layout.guards), ca.SX(0))._read(reset.guard, {})

    def _earlier(self, h: Held) -> ca.SX:
        """Return how many values act before that of the first sample; they stand in the queue at the start.

        Where the first sample comes later than one period, nothing acts in the whole periods before.
        """
        show = Printer(dict(self.symbols), set(), Switches())
        offset, delay, every = show(h.offset), show(h.delay), show(h.every)
        return ca.floor((offset + delay) / every + _MARGIN) - ca.floor(offset / every + _MARGIN)

    @property
    def _now(self) -> dict[str, ca.SX]:
        """The states by name, before an event."""
        return {s.name: e for s, e in self.symbols.items() if s.name in self.places}


class _Instant:
    """What happens at one instant: states by name that change in place, step by step.

    Parameters
    ----------
    clocks : Clocks
    hit : SX
        Which of its guards were hit.
    happens : SX
        Whether anything was hit, so that all that is due at this instant happens as well.
    """

    def __init__(self, clocks: Clocks, hit: ca.SX, happens: ca.SX):
        n_clocks, n_queues = clocks.counters.numel(), len(clocks.queues)
        self._clocks, self._hit = clocks, hit
        self._soon = JUST_AFTER * (ca.fabs(clocks.t) + clocks.horizon)
        self._any = happens
        flags = ca.vertsplit(hit)
        pairs = zip(flags[n_clocks : n_clocks + n_queues], clocks.queues.items(), strict=True)
        timed = zip(flags[:n_clocks], clocks._times_left, strict=True)
        self._strikes = [self._struck(flag, left) for flag, left in timed]
        self._crossed = {
            part: hit[n_clocks + n_queues + PAIR * k : n_clocks + n_queues + PAIR * (k + 1)]
            for k, part in enumerate(clocks.crossings)
        }
        self.now = clocks._now
        self._arrives, self._counts = {}, {}
        for flag, (name, queue) in pairs:
            count = self._counts[name] = queue.begun(self.now, EMPTY)
            self._arrives[name] = ca.logic_and(count > 0.5, self._struck(flag, self.now[queue.left[0]]))
        self._counters = ca.vertsplit(clocks.counters) if n_clocks else []
        clock = iter(range(n_clocks))
        self._clock_of = {h.name: (next(clock), next(clock) if h.late else -1) for h in clocks.held if h.when is None}
        self._of_resets = {r: next(clock) for r in clocks.resets if r.guard is None}
        self._struck_out: dict[int, ca.SX] = {}

    def _struck(self, flag: ca.SX, left: ca.SX) -> ca.SX:
        """Whether a time is over: now, or at the same instant to rounding."""
        return ca.logic_or(flag > 0.5, ca.logic_and(self._any, left <= self._soon))

    def result(self) -> tuple[list[tuple[int, ca.SX]], ca.SX, ca.SX]:
        """Return states with their places, variables, and guards that start at zero."""
        clocks = self._clocks
        self.states()
        counters = [k + s for k, s in zip(self._counters, self._strikes, strict=True)]
        for j, fault in self._struck_out.items():
            counters[j] = ca.if_else(fault, ca.SX.nan(), counters[j])
        sides = [crossing.after(self._crossed[part]) for part, crossing in clocks.crossings.items()]
        waiting = [self._counts[name] + 1 for name in clocks.queues]
        variables = ca.vertcat(*counters, *waiting, *sides)
        return [(clocks.places[n], e) for n, e in self.now.items()], variables, ca.SX.zeros(self._hit.numel())

    def states(self) -> dict[str, ca.SX]:
        """Return the states by name after it."""
        clocks = self._clocks
        behind = {h.name: self._arrive(h) for h in clocks.held if h.late}
        previous = {h.previous: self._previous(h) for h in clocks.held}
        for h in clocks.held:
            self._compute(h, previous, behind.get(h.name))
        for reset in clocks.resets:
            self._reset(reset)
        return self.now

    def _set(self, when: ca.SX, changes: Mapping[str, ca.SX]) -> None:
        self.now = self.now | {n: ca.if_else(when, e, self.now[n]) for n, e in changes.items()}

    def _arrive(self, h: Held) -> ca.SX:
        """Let a value act that was on its way; return whether it is that of a sample at this instant."""
        if h.when is not None:
            queue, arrives = self._clocks.queues[h.name], self._arrives[h.name]
            self._set(arrives, {h.name: self.now[queue.values[0]], **queue.without_first(self.now, EMPTY)})
            self._counts[h.name] -= arrives
            return ca.SX(0)
        samples, acts = self._clock_of[h.name]
        ago = self._counters[samples] - self._counters[acts] + self._clocks._earlier(h)
        impossible = ca.logic_or(ca.logic_or(ago < 0, ago > h.late), self._read(h.delay, {}) < 0)
        self._struck_out[acts] = ca.logic_and(self._strikes[acts], impossible)
        arrived = chosen(ago - 1, [self.now[s.name] for s in h.queue])
        self._set(ca.logic_and(self._strikes[acts], ago > 0), {h.name: arrived})
        return ca.logic_and(self._strikes[acts], ago == 0)

    def _previous(self, h: Held) -> ca.SX:
        """Return the value computed before."""
        if h.name in self._clocks.queues:
            return self._clocks.queues[h.name].newest(self.now, self._counts[h.name], self.now[h.name])
        return self.now[h.queue[0].name if h.late else h.name]

    def _compute(self, h: Held, previous: Mapping[sp.Symbol, ca.SX], acts: ca.SX | None) -> None:
        """Compute a variable if it is its instant; `acts` says whether a value with a delay acts at once."""
        if h.when is None:
            clock = self._clock_of[h.name][0]
            when, update, known = self._strikes[clock], h.update, dict(previous)
            self._struck_out[clock] = ca.logic_and(when, self._impossible(h.every, h.offset))
        else:
            hit = self._crossed[h]
            when, update = ca.mmax(hit) > 0.5, at_side(h.update, h.when, _SIDE)
            known = {**previous, _SIDE: ca.if_else(hit[0] > 0.5, -1, 1)}
        value = self._read(update, known)
        if h.step is not None:
            step = self._read(h.step, {})
            value = step * ca.floor(value / step + 0.5)
        if h.name in self._clocks.queues:
            self._put(h, when, value)
            return
        names = [s.name for s in h.queue] or [h.name]
        self._set(when, dict(zip(names, [value, *(self.now[n] for n in names[:-1])], strict=True)))
        if acts is not None:
            self._set(acts, {h.name: self.now[names[0]]})

    def _put(self, h: Held, when: ca.SX, value: ca.SX) -> None:
        """Put a value on its way; more than there are places for, or a negative delay, leave no number of them."""
        queue, count, delay = self._clocks.queues[h.name], self._counts[h.name], self._read(h.delay, {})
        self._set(when, queue.with_last(self.now, count, value, delay))
        impossible = ca.logic_and(when, ca.logic_or(count > h.late - 0.5, delay < 0))
        self._counts[h.name] = ca.if_else(impossible, ca.SX.nan(), count + when)
        for k, (behind, left) in enumerate(zip(queue.values, queue.left, strict=True)):
            empty = self._counts[h.name] < k + 0.5
            self._set(ca.logic_and(self._any, empty), {behind: ca.SX(0), left: ca.SX(EMPTY)})

    def _reset(self, reset: Reset) -> None:
        if reset.guard is not None:
            when, k, known = self._crossed[reset][0] > 0.5, ca.SX(0), {_SIDE: ca.SX(-1)}
        else:
            j = self._of_resets[reset]
            when, k, known = self._strikes[j], self._counters[j], {}
            if reset.every is None:
                early = self._clocks._times_left[j] < -self._soon  # before the start, or before the time before
            else:
                early = self._impossible(reset.every, reset.offset)
            self._struck_out[j] = ca.logic_and(when, early)
        turned = {n: [self._at_guard(e, reset) for e in es] for n, es in reset.set.items()}
        self._set(when, {n: chosen(k, [self._read(e, known) for e in es]) for n, es in turned.items()})

    def _impossible(self, every: sp.Expr, offset: sp.Expr) -> ca.SX:
        """Whether values of parameters leave no regular instants."""
        return ca.logic_or(self._read(every, {}) <= 0, self._read(offset, {}) < 0)

    def alone(self, reset: Reset, entry: int) -> dict[str, ca.SX]:
        """Return what a reset alone makes of the states that it sets."""
        known = {} if reset.guard is None else {_SIDE: ca.SX(-1)}
        chosen_ones = {n: self._at_guard(es[min(entry, len(es) - 1)], reset) for n, es in reset.set.items()}
        return {n: self._read(e, known) for n, e in chosen_ones.items()}

    @staticmethod
    def _at_guard(e: sp.Expr, reset: Reset) -> sp.Expr:
        return e if reset.guard is None else at_side(e, reset.guard, _SIDE)

    def _read(self, e: sp.Expr, known: Mapping[sp.Symbol, ca.SX]) -> ca.SX:
        """Return the graph of an expression of the present states."""
        states = {s: self.now[s.name] for s in self._clocks.symbols if s.name in self._clocks.places}
        symbols = {**self._clocks.symbols, **states, **known}
        return evaluated(e, symbols, self._clocks.t + self._soon)
