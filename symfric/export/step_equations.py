"""Smooth functions of one scene from which a step of fixed length is made, see `symfric.export.step_function`."""

import casadi as ca

from symfric.lower.automaton import Automaton
from symfric.lower.clocks import Clocks
from symfric.lower.constraint_forces import hold
from symfric.lower.contact_dynamics import ContactDynamics
from symfric.lower.crossings import PAIR
from symfric.lower.mode_layout import JUST_AFTER, backward, forward

_AT_REST = 1e-12  # slip, or an expression that crosses zero, relative to its terms below which it is zero at the start
_MOVED = 1e-10  # change of these relative to their terms above which they jumped
_TIE = 1e-10  # slip acceleration relative to that by the static friction below which its direction is open
_ROUNDING = 64 * 2.0**-52


class StepEquations:
    """Functions of state y, time t, data p and mode m, and the rules at events.

    Parameters
    ----------
    model : ContactDynamics
    automaton : Automaton
        Of the model.

    Attributes
    ----------
    rate, guards : casadi.Function
        ``(y, t, p, m) -> y'`` and ``-> guards``, shape (n_g,).
    held : casadi.Function
        ``(y, t, p, m) -> y`` with the slips of sticking contacts at zero.
    watched : list of int
        The guards that end a mode; those of the loads do not.
    clocks : Clocks or None
        Of held variables and resets.
    """

    def __init__(self, model: ContactDynamics, automaton: Automaton) -> None:
        self.model, self.automaton, self.layout = model, automaton, automaton.layout
        self.n_c = len(automaton.contacts)
        self.loads = list(range(self.layout.first_load, self.layout.first_other))
        self.watched = [g for g in range(self.layout.n_guards) if g not in self.loads]
        self.clocks = next((e for e in model.springs if isinstance(e, Clocks)), None)
        self._m = ca.SX.sym("m", self.layout.n_mode)
        self._at = [model.y, model.t, model.p]
        self._rate, self._guards, _ = automaton.field(*self._at, self._m)
        self._w, self._size, self._pull, *_ = gauge = automaton.gauge(*self._at)
        self._slip_after = self._w  # steps in time that are due have been taken
        if automaton.steps:
            signs = [*model.switches.signs, *(other.variables for other in model.springs)]
            self._w = ca.substitute(model.slip, ca.vertcat(model.s, model.d, *signs), self._m)
        self._forces, self._coupling = gauge[5], ca.diag(ca.reshape(gauge[6], self.n_c, self.n_c))
        self.rate = ca.Function("rate", [*self._at, self._m], [self._rate])
        self.guards = ca.Function("guards", [*self._at, self._m], [self._guards])
        self.held = ca.Function("held", [*self._at, self._m], [self._at_zero(self._m[: self.n_c] > 0.5)])
        crossings = 0 if self.clocks is None else len(self.clocks.crossings)
        self._sides = list(range(self.layout.n_mode - crossings, self.layout.n_mode))
        first = self.layout.n_guards - PAIR * crossings
        self._pairs = [(first + PAIR * k, first + PAIR * k + 1) for k in range(crossings)]
        self._values, self._sizes = self._crossings()

    @property
    def _soon(self) -> ca.SX:
        return JUST_AFTER * (ca.fabs(self.model.t) + self.model.horizon)

    def _crossings(self) -> tuple[ca.SX, ca.SX]:
        """Return the expressions whose zeros are events, and the sums of the magnitudes of their terms."""
        open_ = ca.SX(self._m)
        for side in self._sides:
            open_[side] = 0  # on which the first guard is the expression
        values = ca.substitute(self._guards[[g for g, _ in self._pairs]], self._m, open_)
        sizes = ca.SX.zeros(len(self._pairs))
        for e in self._at:
            sizes += ca.fabs(ca.jacobian(values, e)) @ ca.fabs(e)
        return values, sizes

    def drifts(self) -> bool:
        """Whether the formula leaves the slips of sticking contacts at zero only within its error."""
        anchored = all(index >= 0 for index, _ in self.automaton.anchors)
        return not (anchored and self.model.drift.is_zero())

    def _at_zero(self, sticks: ca.SX) -> ca.SX:
        """Return the state after impulses that set the slips of some contacts to zero."""
        y, n = ca.SX(self.model.y), self.model.u.numel()
        if not self.n_c:
            return y
        J = self.model.slopes
        _, change, _ = hold(J, self.model.spread, self.model.u, self._w - J @ self.model.u, sticks, tested=False)
        y[n : 2 * n] += change
        for i, (index, factor) in enumerate(self.automaton.anchors):
            if index >= 0:  # exact
                y[index] = ca.if_else(sticks[i], self.model.y[index] - self._w[i] / factor, y[index])
        return y

    def first_mode(self) -> ca.Function:
        """Return ``(y, t, p) -> (y, m, zero, fresh)``: a mode to begin with, and which contacts are at rest.

        `fresh` marks the guards of expressions that begin at zero: where they leave it, they have crossed.
        """
        rests = ca.fabs(self._slip_after) <= _AT_REST * self._size
        able = ca.DM([float(e) for e in self.automaton.sticks])
        mode = [*ca.vertsplit(rests * able), *(ca.if_else(w < 0, -1, 1) for w in ca.vertsplit(self._slip_after))]
        mode += [ca.SX(1)] * self.layout.switches
        mode += [ca.SX(0)] * (self.layout.n_mode - len(mode))
        for j in range(self.layout.switches):  # a switch may depend on earlier ones
            value = ca.substitute(self._guards[self.layout.switch(j)], self._m, ca.vertcat(*mode))
            if j in self.automaton.steps:
                value = ca.substitute(value, self.model.t, self.model.t + self._soon)
            mode[self.layout.sign(j)] = ca.if_else(value < 0, -1, 1)
        m, fresh = ca.vertcat(*mode), ca.SX.zeros(self.layout.n_guards)
        if self.clocks is not None:
            first = self.layout.n_mode - self.clocks.variables.numel()
            m[first : first + self.clocks.begun.numel()] = self.clocks.begun
        values, sizes = (ca.substitute(e, self._m, m) for e in (self._values, self._sizes))
        for k, (side, pair) in enumerate(zip(self._sides, self._pairs, strict=True)):
            zero = ca.fabs(values[k]) <= _AT_REST * sizes[k]
            m[side] = ca.if_else(zero, 0, ca.if_else(values[k] < 0, -1, 1))
            fresh[list(pair)] = zero
        return ca.Function("first", self._at, [self.held(*self._at, m), m, ca.SX(rests), fresh])

    def due(self) -> ca.Function:
        """Return ``(y, t, p, m) -> hit``: the clocks and values on their way whose instant is now."""
        hit, first = ca.SX.zeros(self.layout.n_guards), self.layout.first_clock
        if self.clocks is not None:
            variable, n_clocks = self.layout.n_mode - self.clocks.variables.numel(), self.clocks.counters.numel()
            for k in range(n_clocks + len(self.clocks.queues)):
                some = k < n_clocks or self._m[variable + k] > 1.5  # values are on their way
                hit[first + k] = ca.logic_and(some, self._guards[first + k] <= self._soon)
        return ca.Function("due", [*self._at, self._m], [ca.densify(hit)])

    def told(self) -> ca.Function:
        """Return ``(y, t, p, m, fresh) -> (m, fresh)``: the mode after a change of state or data from outside."""
        fresh, m = ca.SX.sym("fresh", self.layout.n_guards), ca.SX(self._m)
        after = ca.SX(fresh)
        for i in range(self.n_c):
            moved = ca.fabs(self._w[i]) > _MOVED * self._size[i]
            m[i] = ca.if_else(moved, 0, m[i])
            m[self.n_c + i] = ca.if_else(moved, ca.if_else(self._w[i] < 0, -1, 1), m[self.n_c + i])
            after[backward(i)] = ca.if_else(moved, 0, fresh[backward(i)])
        return ca.Function("told", [*self._at, self._m, fresh], [m, after])

    def crossed(self) -> ca.Function:
        """Return ``(y, t, p, m, hit, still) -> (y, m, zero, fresh)``: state and trial mode after guards were hit.

        Contacts whose slip reached zero stick, those that reached their bound slip, switches change their sign, and
        contacts behind springs do what is said of them. `still` marks the guards that are at zero before, `zero` the
        contacts with slip zero, `fresh` the guards that start the mode at zero.
        """
        layout, n_c = self.layout, self.n_c
        hit, still = ca.SX.sym("hit", layout.n_guards), ca.SX.sym("still", layout.n_guards)
        y, m = ca.SX(self.model.y), ca.SX(self._m)
        fresh, zero = ca.SX.zeros(layout.n_guards), ca.SX.zeros(n_c)
        if self.automaton.transition is not None:
            own = slice(layout.first_other, layout.n_guards)
            y, m, fresh[own] = self.automaton.transition(*self._at, m, hit[own], ca.SX.zeros(own.stop - own.start))
        for j in range(layout.switches):
            k, g = layout.sign(j), layout.switch(j)
            m[k], fresh[g] = ca.if_else(hit[g], -m[k], m[k]), hit[g]
        for i, able in enumerate(self.automaton.sticks):
            sticks, d, back, forth = self._m[i] > 0.5, self._m[n_c + i], hit[backward(i)], hit[forward(i)]
            zero[i] = ca.logic_or(sticks, back)
            released = ca.logic_or(back, forth)
            m[i] = ca.if_else(sticks, 1 - released, back) if able else 0
            turned = d if able else ca.if_else(back, -d, d)
            m[n_c + i] = ca.if_else(ca.logic_and(sticks, released), ca.if_else(back, -1, 1), turned)
        if self.clocks is not None or self.automaton.steps:
            self._jumped(y, m, zero)
            self._turned(y, m, hit, still, fresh)
        args = [*self._at, self._m, hit, still]
        trial = ca.Function("trial", args, [y, m, zero, fresh])
        y, m, zero, fresh = trial(*args)
        return ca.Function("crossed", args, [self.held(y, *self._at[1:], m), m, zero, fresh])

    def _jumped(self, y: ca.SX, m: ca.SX, zero: ca.SX) -> None:
        """Give contacts whose slip jumped to that at state y and mode m the mode of the slip after; changes m, zero."""
        before, after = ca.vertcat(self.model.y, self._m), ca.vertcat(y, m)
        w, size = (ca.substitute(e, before, after) for e in (self._w, self._size))
        for i, able in enumerate(self.automaton.sticks):
            jumped = ca.fabs(w[i] - self._w[i]) > _MOVED * (self._size[i] + size[i])
            rests = ca.fabs(w[i]) <= _AT_REST * size[i]
            zero[i] = ca.if_else(jumped, rests, zero[i])
            m[i] = ca.if_else(jumped, ca.logic_and(rests, able), m[i])
            way = ca.if_else(w[i] < 0, -1, 1)
            m[self.n_c + i] = ca.if_else(ca.logic_and(jumped, ca.logic_not(rests)), way, m[self.n_c + i])

    def _turned(self, y: ca.SX, m: ca.SX, hit: ca.SX, still: ca.SX, fresh: ca.SX) -> None:
        """Give crossings the side on which the event leaves them at the state y; changes m and fresh.

        One that is at zero then is decided by what follows. Where its own event made it jump back, that is no crossing;
        a jump by another event is one, which the next piece of the step finds.
        """
        values, sizes = (ca.substitute(e, self.model.y, y) for e in (self._values, self._sizes))
        for k, (side, (fall, rise)) in enumerate(zip(self._sides, self._pairs, strict=True)):
            moved = ca.fabs(values[k] - self._values[k]) > _MOVED * (self._sizes[k] + sizes[k])
            there = ca.fabs(values[k]) <= _AT_REST * sizes[k]
            zero = ca.if_else(moved, there, ca.if_else(self._m[side] >= 0, still[fall], still[rise]))
            back = ca.logic_and(ca.logic_or(hit[fall], hit[rise]), ca.logic_and(moved, ca.logic_not(zero)))
            m[side] = ca.if_else(back, ca.if_else(values[k] < 0, -1, 1), m[side])
            fresh[fall], fresh[rise] = ca.logic_and(zero, m[side] >= 0), ca.logic_and(zero, m[side] <= 0)

    def judged(self) -> ca.Function:
        """Return ``(y, t, p, m, zero) -> (m, changed)``: the mode with the contact changed that contradicts it most.

        Of the contacts at slip zero, one that sticks must not exceed its bound, and one that slips must not accelerate
        against its direction.
        """
        n_c, zero, m = self.n_c, ca.SX.sym("zero", self.n_c), ca.SX(self._m)
        args = [*self._at, self._m, zero]
        if not n_c:
            return ca.Function("judged", args, [m, ca.SX(0)])
        y, t, _ = self._at
        drift = ca.jtimes(self._w, y, self._rate) + ca.jtimes(self._w, t, ca.SX(1))
        worst, which, side, able = ca.SX(0), ca.SX(-1), ca.SX(0), self.automaton.sticks
        for i in range(n_c):
            back, forth = self._guards[backward(i)], self._guards[forward(i)]
            size = _TIE * self._pull[i] + _ROUNDING * self._forces[i]
            beyond, against = ca.fmax(-back, -forth) * self._coupling[i], -self._m[n_c + i] * drift[i]
            wrong = ca.if_else(self._m[i] > 0.5, beyond, against)
            excess = ca.if_else(ca.logic_and(zero[i], wrong > size), wrong, 0)
            way = ca.if_else(self._m[i] > 0.5, ca.if_else(back < forth, -1, 1), 0 if able[i] else -self._m[n_c + i])
            worse = excess > worst
            worst, which = ca.if_else(worse, excess, worst), ca.if_else(worse, i, which)
            side = ca.if_else(worse, way, side)
        for i in range(n_c):
            here = which == i
            m[i] = ca.if_else(here, side == 0, m[i])
            m[n_c + i] = ca.if_else(ca.logic_and(here, side != 0), side, m[n_c + i])
        return ca.Function("judged", args, [m, worst > 0])

    def freshly(self) -> ca.Function:
        """Return ``(m, zero, fresh) -> fresh`` with the slips that start at zero."""
        zero, fresh = ca.SX.sym("zero", self.n_c), ca.SX.sym("fresh", self.layout.n_guards)
        after = ca.SX(fresh)
        for i in range(self.n_c):
            after[backward(i)] = ca.logic_and(zero[i], self._m[i] < 0.5)
        return ca.Function("freshly", [self._m, zero, fresh], [after])

    def shown(self) -> ca.Function:
        """Return ``(y, t, p, m) -> (rows, modes)``: the observables, and -1, 0 or 1 for every contact of the scene."""
        rows = self.automaton.field(*self._at, self._m)[2]
        entries = {}
        for i, name in enumerate(self.layout.lines):
            entries[name] = ca.if_else(self._m[i] > 0.5, 0, self._m[self.n_c + i])
        first = self.layout.first_variable
        for other in self.layout.others:
            entries[other.name] = self._m[first]  # what a run shows of it
            first += other.variables
        names = [*self.layout.lines, *(other.name for other in self.layout.others if not other.clocks)]
        modes = ca.vertcat(*(entries[n] for n in names)) if names else ca.SX(0, 1)
        return ca.Function("shown", [*self._at, self._m], [rows, modes])
