"""One step of fixed length as CasADi functions: Runge and Kutta's formula between events, events inside the step.

In a step the motion follows the smooth equations of its mode, see `symfric.lower.automaton`, by the classical formula
of order four. If a guard is negative at its end, the first time at which one is zero is found by repeating the formula
over shorter times; there the mode changes, and the rest of the step follows in the new one. A slip that reached zero is
set to zero, so sticking is exact. The number of events in a step is bounded, and with it the time that a step takes:
after the last one the rest of the step ignores the guards, and slips that changed their direction in it end at zero, as
by the impulse of Moreau's scheme. Held variables and resets are events, too; those whose instant is the end of a step
belong to it.

Everything is a graph without loops of unknown length, so that CasADi writes it as C code. Branches are evaluated only
when they are taken.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import casadi as ca
import sympy as sp

from symfric.errors import SceneError
from symfric.export.step_equations import StepEquations
from symfric.lower.automaton import Automaton, automaton_of
from symfric.lower.contact_dynamics import ContactDynamics
from symfric.model.constant_parameters import averaged_over
from symfric.model.scene import Scene

OK, MANY_EVENTS, LOST_CONTACT, NOT_FINITE = 0, 1, 2, 3  # results of a step
_FAR = 1e300  # beyond it a number is not finite
_UNDEFINED = -2.0  # for the least guard over its size, which is not less than -1
_NEAR = 1e-3  # least guard over its size near the edge of the domain of a law, where it counts as reached
_ZERO = 1e-12  # guard relative to its change over a step that is zero
_NO_PART = 1e-300  # size of a guard that plays no part
_FOUND = 1e-14  # relative precision of the time of an event
_NARROWINGS = (4, 4, 3)  # most evaluations of the formula for one event: their product
_BISECT = 3  # every third narrowing halves the bracket


@dataclass(frozen=True, eq=False)
class StepFunctions:
    """The functions of a scene's step.

    The state is y, the memory between steps m, the time t, the parameters p; v and dv are the sampled inputs at t and
    their slopes.

    Attributes
    ----------
    start : casadi.Function
        ``(y, t, p, v, dv) -> (y, m)``: the mode at a state.
    advance : casadi.Function
        ``(y, m, t, p, v, dv, h) -> (y, m, status)``: the state a time h later.
    look : casadi.Function
        ``(y, m, t, p, v) -> (rows, modes)``: the outputs, and the mode of every contact: -1, 0, 1.
    automaton : Automaton
    """

    start: ca.Function
    advance: ca.Function
    look: ca.Function
    automaton: Automaton


def step_functions(scene: Scene, rows: Sequence[sp.Expr], events: int) -> StepFunctions:
    """Build the functions of a scene.

    Parameters
    ----------
    scene : Scene
    rows : sequence of Expr
        Outputs; may contain `friction_force` and `slip`.
    events : int
        Most events in one step, 1 or more.

    Raises
    ------
    SceneError
        If contacts can hold the same motion, a friction profile jumps, or a law has an infinite slope.
    """
    model = ContactDynamics.of(scene, averaged_over(scene))
    automaton = automaton_of(model, rows)
    _refuse(scene, automaton)
    return _Builder(StepEquations(model, automaton), events).functions()


def _refuse(scene: Scene, automaton: Automaton) -> None:
    for c in scene.contacts_that_open:
        raise SceneError(
            f"contact {c.name!r} opens and strikes, which is not exported; leave it out, and give its load as an input"
        )
    for c in scene.contacts:
        if c.law.steep:
            raise SceneError(
                f"the law of contact {c.name!r} has an infinite slope at a speed, which a step of fixed length does "
                "not take; give the law without averaging it"
            )
    names = automaton.contacts
    for i, (k, depends) in enumerate(zip(automaton.parallels, automaton.dependent, strict=True)):
        if depends or k != i:
            other = names[k] if k != i else next(n for n in names if n != names[i])
            raise SceneError(
                f"contacts {names[i]!r} and {other!r} can hold the same motion, and a step of fixed length does not "
                "share the load between them; join them into one contact"
            )
    if automaton.at_edges:
        raise SceneError(
            "a friction profile jumps from cell to cell, which a step of fixed length does not take; "
            "give a continuous profile"
        )


class _Builder:
    """Makes the functions; every method one, from those before it."""

    def __init__(self, equations: StepEquations, events: int) -> None:
        self.eq, self.events, self.automaton = equations, events, equations.automaton
        layout = equations.layout
        self.n_m, self.n_g, self.n_c = layout.n_mode, layout.n_guards, equations.n_c
        self.n_y, self.n_p = equations.model.y.numel(), len(self.automaton.parameters)
        self.n_v = len(self.automaton.inputs)
        self.formula = self._formula()
        self.event = self._event()

    def functions(self) -> StepFunctions:
        """Return the functions."""
        return StepFunctions(self._start(), self._advance(), self._look(), self.automaton)

    def _state(self) -> list[ca.MX]:
        n_p = self.n_p + 3 * self.n_v
        return [ca.MX.sym(*e) for e in (("y", self.n_y), ("t", 1), ("p", n_p), ("m", self.n_m))]

    def _formula(self) -> ca.Function:
        """Return ``(y, t, p, m, h) -> y``: one step in one mode."""
        y, t, p, m = self._state()
        h, f = ca.MX.sym("h"), self.eq.rate
        k1 = f(y, t, p, m)
        k2 = f(y + h / 2 * k1, t + h / 2, p, m)
        k3 = f(y + h / 2 * k2, t + h / 2, p, m)
        k4 = f(y + h * k3, t + h, p, m)
        after = y + h / 6 * (k1 + 2 * k2 + 2 * k3 + k4)
        if self.eq.drifts():
            after = self.eq.held(after, t + h, p, m)
        return ca.Function("formula", [y, t, p, m, h], [after])

    def _agreeing(self) -> ca.Function:
        """Return ``(y, t, p, m, zero) -> m``: modes of contacts at slip zero that agree with the forces."""
        y, t, p, m = self._state()
        zero, go, judged = ca.MX.sym("zero", self.n_c), ca.MX.sym("go"), self.eq.judged()
        args = [m, go, y, t, p, zero]
        once = ca.Function("once", args, list(judged(y, t, p, m, zero)))
        once = _if(go, once, ca.Function("same", args, [m, go]), args)
        mode, changed = m, ca.MX(1)
        for _ in range(2 * self.n_c + 1 if self.n_c else 0):
            mode, changed = once(mode, changed, y, t, p, zero)
        return ca.Function("settled", [y, t, p, m, zero], [mode])

    def _event(self) -> ca.Function:
        """Return ``(y, t, p, m, hit, still) -> (y, m, fresh)``: state and mode after guards were hit.

        `still` marks those that are zero.
        """
        y, t, p, m = self._state()
        hit, still = ca.MX.sym("hit", self.n_g), ca.MX.sym("still", self.n_g)
        self.agreeing, self.freshly = self._agreeing(), self.eq.freshly()
        after, mode, zero, fresh = self.eq.crossed()(y, t, p, m, hit, still)
        mode = self.agreeing(after, t, p, mode, zero)
        return ca.Function("event", [y, t, p, m, hit, still], [after, mode, self.freshly(mode, zero, fresh)])

    def _least(self) -> ca.Function:
        """Return ``(y, t, p, m, fresh, size, c) -> least``: the least guard after a time c, over the sizes.

        Those that start at zero are divided by c. `_UNDEFINED` if the formula left the domain of a law.
        """
        y, t, p, m = self._state()
        fresh, size, c = ca.MX.sym("fresh", self.n_g), ca.MX.sym("size", self.n_g), ca.MX.sym("c")
        there = self.formula(y, t, p, m, c)
        g = self.eq.guards(there, t + c, p, m)
        no_part = ca.logic_and(g == 0, ca.logic_or(fresh > 0.5, size <= _NO_PART))
        scaled = g / (size * ca.if_else(fresh > 0.5, c, 1))
        least = ca.mmin(ca.if_else(no_part, 1, scaled)[self.eq.watched])
        least = ca.if_else(least < -1, -1, least)  # those that start at zero may begin steeply
        return ca.Function("least", [y, t, p, m, fresh, size, c], [ca.if_else(_finite(there), least, _UNDEFINED)])

    def _smallest(self, g: ca.MX) -> ca.MX:
        return ca.mmin(ca.if_else(g == 0, 1, g)[self.eq.watched])  # guards that play no part are zero

    def _narrow(self) -> ca.Function:
        """Return ``(bracket, data) -> bracket``: one narrowing of the time of an event, by Illinois or by halving.

        A bracket is ``[a, fa, b, fb, value at b, last end that moved, count]``.
        """
        y, t, p, m = self._state()
        fresh, size, r = ca.MX.sym("fresh", self.n_g), ca.MX.sym("size", self.n_g), ca.MX.sym("r")
        data, B = [y, t, p, m, fresh, size, r], ca.MX.sym("B", 7)
        a, fa, b, fb, value, last, count = ca.vertsplit(B)
        halve = ca.fmod(count, _BISECT) == _BISECT - 1
        c = ca.if_else(halve, (a + b) / 2, (a * fb - b * fa) / (fb - fa))
        f = self._least()(*data[:-1], c)
        low = f <= 0
        now = ca.if_else(low, 1.0, -1.0)
        other = ca.if_else(last == now, 0.5, 1.0)
        after = ca.if_else(
            low,
            ca.vertcat(a, fa * other, c, f, f, now, count + 1),
            ca.vertcat(c, f, b, fb * other, value, now, count + 1),
        )
        args = [B, *data]
        once = ca.Function("narrow", args, [after])
        open_ = ca.logic_and(value < -_FOUND, b - a > _FOUND * r)
        return _if(open_, once, ca.Function("found", args, [B]), args)

    def _located(self) -> ca.Function:
        """Return ``(B, y, t, p, m, fresh, size, r) -> B``: the bracket of an event after all narrowings."""
        narrow = self._narrow()
        for times in _NARROWINGS:
            args = [ca.MX.sym(narrow.name_in(k), narrow.sparsity_in(k)) for k in range(narrow.n_in())]
            B = args[0]
            for _ in range(times):
                B = narrow(B, *args[1:])
            narrow = ca.Function("located", args, [B])
        return narrow

    def _watched(self, wrong: ca.MX) -> ca.MX:
        """Return marks of guards with zeros for those that end no mode."""
        keep = ca.DM.zeros(self.n_g)
        keep[self.eq.watched] = 1
        return wrong * keep

    def _piece(self) -> ca.Function:
        """Return ``(y, m, fresh, t, r, p) -> (y, m, fresh, t, r)``: up to the next event or the end of the step."""
        y, t, p, m = self._state()
        fresh, r = ca.MX.sym("fresh", self.n_g), ca.MX.sym("r")
        args, none = [y, m, fresh, t, r, p], ca.DM.zeros(self.n_g)
        idle = ca.Function("idle", args, [y, m, fresh, t, r])
        if not self.eq.watched:
            return ca.Function("piece", args, [self.formula(y, t, p, m, r), m, none, t + r, 0])
        g = self.eq.guards(y, t, p, m)
        end = self.formula(y, t, p, m, r)
        last = self.eq.guards(ca.if_else(_finite(end), end, y), t + r, p, m)

        def rounding(last: ca.MX) -> ca.MX:  # what is zero to rounding is judged by the end of the step
            return _ZERO * (ca.fabs(g) + ca.fabs(last))

        def wrong(last: ca.MX) -> ca.MX:
            return self._watched(ca.logic_and(g < -rounding(last), fresh < 0.5))

        more = [ca.MX.sym("end", self.n_y), ca.MX.sym("last", self.n_g)]
        still = ca.fabs(g) <= rounding(more[1])
        at_once = ca.Function("at_once", [*args, *more], [*self.event(y, t, p, m, wrong(more[1]), still), t, r])
        chosen = _chosen(ca.mmax(wrong(last)) > 0, at_once, self._march(args, more, g), [*args, end, last])
        return _if(r > 0, ca.Function("inner", args, chosen), idle, args)

    def _march(self, args: list[ca.MX], more: list[ca.MX], g: ca.MX) -> ca.Function:
        """Return the same for a step that begins in the right mode, with the state and the guards at its end."""
        y, m, fresh, t, r, p = args
        smooth = ca.Function("smooth", [*args, *more], [more[0], m, ca.DM.zeros(self.n_g), t + r, ca.MX(0)])
        size = ca.if_else(fresh > 0.5, ca.fabs(more[1]) / r, ca.fabs(g) + ca.fabs(more[1])) + _NO_PART
        defined = _finite(more[0])
        below = ca.if_else(defined, self._smallest(more[1] / (size * ca.if_else(fresh > 0.5, r, 1))), _UNDEFINED)
        above = ca.if_else(ca.mmax(fresh) > 0.5, -below, ca.fmax(0, self._smallest(g / size)))
        B = self._located()(ca.vertcat(0, above, r, below, below, 0, 0), y, t, p, m, fresh, size, r)
        c = ca.if_else(B[4] > _UNDEFINED, B[2], B[0])  # not beyond the domain of a law
        there = self.formula(y, t, p, m, c)
        left = self.eq.guards(there, t + c, p, m)
        least = self._smallest(left / size)
        near = ca.logic_and(left / size <= least * (1 + _NEAR), least < _NEAR)
        exactly = ca.logic_and(ca.logic_and(B[4] == 0, left == 0), ca.logic_and(fresh < 0.5, size > _NO_PART))
        hit = self._watched(ca.if_else(B[4] > _UNDEFINED, ca.logic_or(left < 0, exactly), near))
        still = ca.fabs(left) <= _ZERO * size * ca.if_else(fresh > 0.5, r, 1)
        cut = ca.Function("cut", [*args, *more], [*self.event(there, t + c, p, m, hit, still), t + c, r - c])
        crossed = ca.logic_or(ca.mmax(self._watched(more[1] < 0)), 1 - defined)
        return _if(crossed, cut, smooth, [*args, *more])

    def _rest(self) -> ca.Function:
        """Return ``(y, m, fresh, t, r, p, status) -> (y, m, fresh, t, r, status)``: the rest after too many events."""
        y, t, p, m = self._state()
        fresh, r, status = ca.MX.sym("fresh", self.n_g), ca.MX.sym("r"), ca.MX.sym("status")
        args = [y, m, fresh, t, r, p, status]
        end = self.formula(y, t, p, m, r)
        hit, none = self._watched(self.eq.guards(end, t + r, p, m) < 0), ca.DM.zeros(self.n_g)
        rest = ca.Function(
            "rest", args, [*self.event(end, t + r, p, m, hit, none), t + r, ca.MX(0), ca.MX(MANY_EVENTS)]
        )
        return _if(r > 0, rest, ca.Function("idle", args, [y, m, fresh, t, r, status]), args)

    def _struck(self) -> ca.Function:
        """Return ``(y, t, p, m, fresh) -> (y, m, fresh)``: the updates of the clocks that are due."""
        y, t, p, m = self._state()
        fresh = ca.MX.sym("fresh", self.n_g)
        args = [y, t, p, m, fresh]
        idle = ca.Function("idle", args, [y, m, fresh])
        if self.eq.clocks is None:
            return idle
        hit = self.eq.due()(y, t, p, m)
        return _if(ca.mmax(hit) > 0, ca.Function("struck", args, list(self.event(y, t, p, m, hit, fresh))), idle, args)

    def _data(self) -> tuple[list[ca.MX], ca.MX]:
        """Return symbols t, p, v, dv, and the data of the automaton."""
        t, p = ca.MX.sym("t"), ca.MX.sym("p", self.n_p)
        v, dv = ca.MX.sym("v", self.n_v), ca.MX.sym("dv", self.n_v)
        sampled = [e for k in range(self.n_v) for e in (t, v[k], dv[k])]
        return [t, p, v, dv], ca.vertcat(p, *sampled)

    def _start(self) -> ca.Function:
        y, (given, data) = ca.MX.sym("y", self.n_y), self._data()
        after, m, zero, fresh = self.eq.first_mode()(y, given[0], data)
        m = self.agreeing(after, given[0], data, m, zero)
        fresh = self.freshly(m, zero, fresh)
        after, m, fresh = self._struck()(after, given[0], data, m, fresh)
        memory = ca.vertcat(m, fresh)
        return ca.Function("start", [y, *given], _dense(after, memory), ["y", "t", "p", "v", "dv"], ["y_after", "m"])

    def _advance(self) -> ca.Function:
        y, memory, h = ca.MX.sym("y", self.n_y), ca.MX.sym("m", self.n_m + self.n_g), ca.MX.sym("h")
        given, data = self._data()
        m, fresh = memory[: self.n_m], memory[self.n_m :]
        m, fresh = self.eq.told()(y, given[0], data, m, fresh)
        state, piece = [y, m, fresh, given[0], h], self._piece()
        for _ in range(1 + self.events if self.eq.watched else 1):
            state = list(piece(*state, data))
        after, m, fresh, t, _, status = self._rest()(*state, data, OK)
        after, m, fresh = self._struck()(after, t, data, m, fresh)
        if self.eq.loads:
            lost = ca.mmin(self.eq.guards(after, t, data, m)[self.eq.loads]) < 0
            status = ca.if_else(lost, LOST_CONTACT, status)
        good = ca.logic_and(_finite(after), _finite(m))
        status = ca.if_else(good, status, NOT_FINITE)
        names = ["y", "m", "t", "p", "v", "dv", "h"]
        out = _dense(after, ca.vertcat(m, fresh), status)
        return ca.Function("advance", [y, memory, *given, h], out, names, ["y_after", "m_after", "status"])

    def _look(self) -> ca.Function:
        y, memory, (given, data) = ca.MX.sym("y", self.n_y), ca.MX.sym("m", self.n_m + self.n_g), self._data()
        rows, modes = self.eq.shown()(y, given[0], data, memory[: self.n_m])
        still = ca.substitute([rows, modes], [given[3]], [ca.DM.zeros(self.n_v)]) if self.n_v else [rows, modes]
        names = ["y", "m", "t", "p", "v"], ["rows", "modes"]
        return ca.Function("look", [y, memory, *given[:3]], _dense(*still), *names)


def _if(condition: ca.MX, yes: ca.Function, no: ca.Function, args: list[ca.MX]) -> ca.Function:
    """Return a function of the same arguments that evaluates one of two."""
    return ca.Function("branch", args, _chosen(condition, yes, no, args))


def _chosen(condition: ca.MX, yes: ca.Function, no: ca.Function, args: list[ca.MX]) -> list[ca.MX]:
    """Return what one of two functions gives; only that one is evaluated."""
    graphs = ca.Function.if_else("either", yes, no)(condition, *args)
    return list(graphs) if isinstance(graphs, tuple | list) else [graphs]


def _finite(y: ca.MX) -> ca.MX:
    return ca.sum1(ca.fabs(y)) < _FAR  # false if something is not a number


def _dense(*out: ca.MX) -> list[ca.MX]:
    return [ca.densify(e) for e in out]
