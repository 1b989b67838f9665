"""The variational equations of an automaton, and the saltation of their solutions at events.

With ``V = dy/ds`` for every direction s, a parameter or the start of a state,

    V' = df/dy V + df/ds,   V(0) = dy_0/ds.

At an event of the guard g its time moves by ``tau = -(dg/dy V + dg/ds)/g'`` and the states by ``(f_- - f_+) tau``: the
saltation of Aizerman and Gantmacher (1958), see Leine and Nijmeijer, Dynamics and Bifurcations of Non-Smooth Mechanical
Systems, section 7.5. A contact that sticks from there on holds its slip at zero, whatever brought it there:
``J V_u + dw/dq V_q + dw/ds = 0`` is enforced by the impulses that do it, which is what the saltation amounts to.
"""

import itertools
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import casadi as ca
import sympy as sp

from symfric.lower.automaton import Automaton, VariedField, arguments_of
from symfric.lower.constraint_forces import FOLLOWS, HOLDS, hold
from symfric.lower.mode_layout import direction
from symfric.lower.planes import STARTS
from symfric.lower.printer import Printer, Switches
from symfric.lower.unilateral import DEPENDENT, GUARDS, eliminated
from symfric.model.scene import Scene

MANY = 24  # states of a motion beyond which derivatives are taken direction by direction


@dataclass(frozen=True)
class Variations:
    """An automaton with its derivatives in some directions.

    Attributes
    ----------
    automaton : Automaton
        Its states are ``[y; V_1; V_2; ...]``, its rows those of the original and then the derivatives, at a fixed time,
        of the first ones that are followed, row by row, one for each direction.
    jump : casadi.Function
        ``([y; V; t], [p; m_before; m_after; hit; given; limit; impact]) -> (V, tau, rows, slope, mismatch, slip)``
        with the flags of the guards that were hit, what feet that give way tell of their limit surface, see
        `_room_of_feet`, and the data of the impact of contacts that open: the derivatives after the
        event; those of its time, (n_s,); what it adds to those of the integrals of the rows followed, (n_f, n_s), row
        by row; the rate of every guard before the event and by how much (relative) its own time moves otherwise than
        tau; the derivatives of the slips before they are held, (n_c, n_s), row by row; how far (relative) a direction
        moves the state off zero of each gap, and off the edge of each switch at which a load jumps; the rate at which
        feet lose their room. If there are crossings or contacts behind springs, `given` is [1; tau] where the
        derivatives of the time are those of an event before, which made a guard jump across zero, and zero otherwise.
    start : casadi.Function
        ``p -> V(0)``, all columns.
    directions : tuple of str
    pairs : tuple of (int, int)
        Directions of the second derivatives, whose columns follow those of the first; no event changes them.
    followed : int
    """

    automaton: Automaton
    jump: ca.Function
    start: ca.Function
    directions: tuple[str, ...]
    pairs: tuple[tuple[int, int], ...]
    followed: int

    @property
    def columns(self) -> int:
        """Number of columns of derivatives."""
        return len(self.directions) + len(self.pairs)


def varied(
    automaton: Automaton,
    scene: Scene,
    directions: Sequence[str],
    followed: int,
    second: bool = False,
    constrained: bool = False,
) -> Variations:
    """Append the variational equations of an automaton.

    Parameters
    ----------
    automaton : Automaton
    scene : Scene
        The scene of the automaton.
    directions : sequence of str
        Names of parameters in ``automaton.parameters``, or of states (for their initial values).
    followed : int
        Number of observables with derivatives.
    second : bool
        Whether second derivatives are appended; they hold as long as no event occurs.
    constrained : bool
        Whether gaps that are closed at the start stay closed, as on an orbit, whatever the direction; else there are no
        derivatives in a direction that opens one.
    """
    field, n_s = automaton.field, len(directions)
    y, t, p, m = arguments_of(field)
    n_x, n_p = y.numel(), p.numel()
    V = ca.SX.sym("V", n_x, n_s)
    names = [s.name for s in automaton.parameters]
    chosen = ca.SX(n_p, n_s)
    for k, name in enumerate(directions):
        if name in names:
            chosen[names.index(name), k] = 1

    def along(e: ca.SX) -> ca.SX:
        """Return the derivatives of an expression in all directions."""
        if n_x <= MANY:
            return ca.jacobian(e, y) @ V + ca.jacobian(e, p) @ chosen
        both = ca.vertcat(y, p)  # a matrix of slopes would have more entries than the graph has operations
        return ca.jtimes(e, both, ca.vertcat(V, chosen)) if n_s else ca.SX(e.numel(), 0)

    rate, guards, rows = field(y, t, p, m)

    def flat(e: ca.SX) -> ca.SX:
        """Return the entries row by row."""
        return ca.vec(ca.densify(e).T)

    pairs = tuple(itertools.combinations_with_replacement(range(n_s), 2)) if second else ()
    W = ca.SX.sym("W", n_x, len(pairs))

    def columns(e: ca.SX) -> ca.SX:
        """Return the first and second derivatives of an expression of y, one column each."""
        first = ca.densify(along(e))
        parts = [first]
        for k, (i, j) in enumerate(pairs):
            e_i = first[:, i]
            rise = ca.jacobian(e_i, y) @ V[:, j] + ca.jacobian(e_i, p) @ chosen[:, j] + ca.jacobian(e, y) @ W[:, k]
            parts.append(ca.densify(rise))
        return ca.horzcat(*parts)

    state = ca.vertcat(y, ca.vec(V), ca.vec(W))
    out = [ca.vertcat(rate, ca.vec(columns(rate))), guards, ca.vertcat(rows, flat(columns(rows[:followed])))]
    wide = ca.Function("field", [state, t, p, m], out, field.name_in(), field.name_out())
    gauge = automaton.gauge(y, t, p)
    names_out = automaton.gauge.name_out()
    return Variations(
        automaton=replace(
            automaton,
            field=wide,
            gauge=ca.Function("gauge", [state, t, p], list(gauge), ["y", "t", "p"], names_out),
            states=(*automaton.states, *(f"d{x}/d{s}" for s in [*directions, *pairs] for x in automaton.states)),
            varied=None if pairs or n_x > MANY else VariedField(field, _indices(names, directions), followed),
        ),
        jump=_jump(automaton, y, V, W, t, p, along, flat, followed, constrained),
        start=starts_of(automaton, scene, directions, pairs),
        directions=tuple(directions),
        pairs=pairs,
        followed=followed,
    )


def _indices(parameters: Sequence[str], directions: Sequence[str]) -> tuple[int, ...]:
    """Return the index of the parameter of every direction, -1 for a state."""
    return tuple(parameters.index(name) if name in parameters else -1 for name in directions)


def _jump(
    automaton: Automaton,
    y: ca.SX,
    V: ca.SX,
    W: ca.SX,
    t: ca.SX,
    p: ca.SX,
    along: Callable[[ca.SX], ca.SX],
    flat: Callable[[ca.SX], ca.SX],
    followed: int,
    constrained: bool,
) -> ca.Function:
    layout, n_c = automaton.layout, len(automaton.contacts)
    n_m, n_g = layout.n_mode, layout.n_guards
    before, after, hit = ca.SX.sym("before", n_m), ca.SX.sym("after", n_m), ca.SX.sym("hit", n_g)
    then = y  # the state after the event
    if automaton.transition:
        own = hit[layout.first_other :]
        then = automaton.transition(y, t, p, before, own, ca.SX.zeros(own.numel()))[0]
    struck = ca.SX.sym("struck", automaton.impact.numel_in(3) if automaton.impact else 0)
    if automaton.impact:
        then = automaton.impact(then, t, p, struck)[0]
    rate, guards, rows = automaton.field(y, t, p, before)
    next_rate, _, next_rows = automaton.field(then, t, p, after)
    if y.numel() <= MANY:
        slope = ca.jacobian(guards, y) @ rate + ca.jacobian(guards, t)
    else:
        slope = ca.jtimes(guards, ca.vertcat(y, t), ca.vertcat(rate, 1)) if n_g else ca.SX(0, 1)
    gain = ca.densify(along(guards))
    firsts, any_before = [], ca.SX(0)
    for g in range(n_g):
        firsts.append(ca.if_else(any_before > 0.5, 0, hit[g]))
        any_before = ca.fmax(any_before, hit[g])
    first = ca.vertcat(*firsts) if firsts else ca.SX(0, 1)
    divisor = ca.dot(first, slope) if n_g else ca.SX(0)
    tau, moves = ca.SX.zeros(1, V.shape[1]), any_before > 0.5
    if n_g:
        tau = -(first.T @ gain) / ca.if_else(moves, divisor, 1)
    limit = ca.SX.sym("limit", 3 * n_c if automaton.has_feet else 0)
    falls = ca.SX(0, 1)
    if automaton.has_feet:
        room = _room_of_feet(automaton, y, t, p, before, limit)
        falls = ca.jacobian(room, y) @ rate + ca.jacobian(room, t)
        ends = ca.sumsqr(limit[:n_c]) > 0
        tau = ca.if_else(ends, -ca.densify(along(room)) / ca.if_else(ends, falls, 1), tau)
    given = ca.SX.sym("given", 1 + V.shape[1] + W.shape[1] if layout.may_jump else 0)
    if given.numel():
        tau = ca.if_else(given[0] > 0.5, given[1 : 1 + V.shape[1]].T, tau)
        moves = ca.logic_or(moves, given[0] > 0.5)
    tau = ca.if_else(moves, tau, 0)  # outermost: rates that are no numbers, at the start, then do not count
    moved = along(then) + (ca.jtimes(then, y, rate) + ca.jacobian(then, t) - next_rate) @ tau
    jumps = (rows - next_rows)[:followed] @ tau
    both = slope @ tau
    apart, size = ca.fabs(both + gain), ca.fabs(both) + ca.fabs(gain)
    mismatch = ca.vertcat(*(ca.mmax(apart[g, :]) / (ca.mmax(size[g, :]) + 1e-300) for g in range(n_g)))
    gauge = dict(zip(automaton.gauge.name_out(), automaton.gauge(y, t, p), strict=True))
    slips = ca.substitute(ca.densify(along(gauge["w"])), V, moved) if n_c else ca.SX(0, V.shape[1])
    n_u = automaton.n_q
    u = slice(automaton.n_q, automaton.n_q + n_u)
    if automaton.impact:
        slips, held = _held_after_impact(automaton, y, V, t, p, after, (then, moved), along)
        moved[u, :] += held
    elif n_c:
        J, back = ca.jacobian(gauge["w"], y)[:, u], ca.reshape(gauge["spread"], n_c, n_u).T
        rest, stick = ca.SX.zeros(n_u), after[:n_c] == HOLDS
        for k in range(V.shape[1]):
            moved[u, k] += hold(J, back, rest, slips[:, k], stick, tested=False)[1]
    state = ca.vertcat(y, ca.vec(V), ca.vec(W), t)
    data = ca.vertcat(p, before, after, hit, given, limit, struck)
    n_w = W.shape[1]  # zero for columns without second derivatives
    tau = ca.vertcat(tau.T, ca.SX.zeros(n_w))
    jumps, slips = (ca.horzcat(e, ca.SX.zeros(e.shape[0], n_w)) for e in (jumps, slips))
    borders = guards[[layout.switch(j) for j in automaton.at_edges]]
    if automaton.impact:
        borders = ca.vertcat(_of_impact(automaton, "gap", y, t, p), borders)
    off = []
    if borders.numel():
        away, most = ca.densify(along(borders)), ca.fabs(ca.jacobian(borders, y)) @ ca.fabs(V)
        off = [ca.mmax(ca.fabs(away[k, :])) / (ca.mmax(most[k, :]) + 1e-300) for k in range(borders.numel())]
    if constrained:
        off[: len(layout.openings)] = [ca.SX(0)] * len(layout.openings)
    out = ca.vertcat(ca.vec(moved), ca.vec(W), tau, flat(jumps), slope, mismatch, flat(slips), *off, falls)
    return ca.Function("jump", [state, data], [ca.densify(out)], {"cse": True})


def _room_of_feet(automaton: Automaton, y: ca.SX, t: ca.SX, p: ca.SX, before: ca.SX, limit: ca.SX) -> ca.SX:
    """Return how far feet that stick are inside their limit surface, in the motion in which they give way.

    Any forces within the bounds do less work in it than the largest ones, ``sum_i b_i |z_i|`` with the slips z: with
    the slip accelerations a without forces of the feet, ``z = A eta`` and ``A = J M^-1 J^T``, the room is

        sum_i b_i |z_i| - eta^T a = -eta^T (a + A lambda),

    where the forces lambda are on their bounds against the slip, and any that hold for contacts without one. It is zero
    at the end of the sticking, and least in this motion, whose change therefore does not move that end. Closed gaps
    hold the bodies, and press with forces that are the same however friction is shared, as long as all stick.

    Parameters
    ----------
    automaton : Automaton
    y, t, p : SX
    before : SX
        The mode in which they stick.
    limit : SX, shape (3 n_c,)
        eta; the forces that are on their bounds, divided by these; the others.
    """
    n_c = len(automaton.contacts)
    gauge = dict(zip(automaton.gauge.name_out(), automaton.gauge(y, t, p), strict=True))
    flags = ca.if_else(before[:n_c] > 0.5, FOLLOWS, before[:n_c])
    rate = automaton.field(y, t, p, ca.vertcat(flags, before[n_c:]))[0]
    bounds = ca.SX(gauge["limits"][:n_c])
    free = ca.jtimes(gauge["w"], y, rate) + ca.jacobian(gauge["w"], t)
    eta, part, fixed = ca.vertsplit(limit, n_c)
    if not automaton.impact:
        return -ca.dot(eta, free + ca.reshape(gauge["coupling"], n_c, n_c) @ (part * bounds + fixed))
    layout, static = automaton.layout, _of_impact(automaton, "static", y, t, p)
    guards, n = automaton.field(y, t, p, before)[1], len(layout.openings)
    for k, i in enumerate(layout.lines_of_openings):
        for row in [i, i + 1] if i in automaton.planes else [i] if i >= 0 else []:
            bounds[row] = static[k] * guards[layout.first_opening + GUARDS * k + 1]
    forces, closed = part * bounds + fixed, 1 - before[layout.openings]
    coupling = ca.reshape(_of_impact(automaton, "coupling", y, t, p), n_c + n, n_c + n)
    across, among = coupling[:n_c, n_c:], coupling[n_c:, n_c:]
    held = closed @ closed.T * among + ca.diag(1 - closed)
    pressed = eliminated(held, closed * (across.T @ forces), DEPENDENT)
    return -ca.dot(eta, free + coupling[:n_c, :n_c] @ forces - across @ (closed * pressed))


def _held_after_impact(
    automaton: Automaton,
    y: ca.SX,
    V: ca.SX,
    t: ca.SX,
    p: ca.SX,
    after: ca.SX,
    arrived: tuple[ca.SX, ca.SX],
    along: Callable[[ca.SX], ca.SX],
) -> tuple[ca.SX, ca.SX]:
    """Return the derivatives of the slips after an event, and velocities that keep slips and gaps that are held.

    Slips and rates of gaps that are moved off zero return to it in a time and a way as small as they are. Whatever the
    bounces on this way, their impulses add up to those that make both zero, with the friction of contacts that slip.

    Parameters
    ----------
    automaton : Automaton
        With contacts that open.
    y, V, t, p, after : SX
        State, derivatives, time, parameters, and the mode after the event.
    arrived : (SX, SX)
        State and derivatives after the event.
    along : callable
        The derivatives of an expression of y along V.
    """
    layout, n_u = automaton.layout, automaton.n_q
    w = automaton.gauge(y, t, p)[0]
    rows = ca.vertcat(w, _of_impact(automaton, "rate", y, t, p))
    slopes = ca.jacobian(rows, y)[:, n_u : 2 * n_u]
    spread = ca.reshape(_of_impact(automaton, "spread", y, t, p), n_u, rows.numel())
    friction = _of_impact(automaton, "friction", y, t, p)
    local = ca.Function("held", [y, V, t, p], [ca.densify(along(rows)), slopes, spread, friction, w])
    gained, J, back, mu, slips_now = local(*arrived[:1], arrived[1], t, p)
    ways = {}  # of slips in the plane, given if they start
    for i in automaton.planes:
        v, moves = layout.planes[i], ca.sumsqr(slips_now[i : i + 2]) > 0
        length = ca.sqrt(ca.if_else(moves, ca.sumsqr(slips_now[i : i + 2]), 1))
        ways[i] = ca.if_else(after[i] == STARTS, after[v : v + 2], slips_now[i : i + 2] / length)
    sticks = [after[i] == HOLDS for i in range(w.numel())]  # a comparison of no numbers would be one number
    held = ca.vertcat(*sticks, *(1 - after[place] for place in layout.openings))
    coupled = ca.densify(back)  # with the friction of what slips
    for k, i in enumerate(layout.lines_of_openings):
        if i in automaton.planes:
            way, slips = ways[i], after[i] <= 0.5
            coupled[:, w.numel() + k] -= slips * mu[k] * back[:, i : i + 2] @ way
        elif i >= 0:
            slips = ca.logic_not(after[i])
            coupled[:, w.numel() + k] -= slips * after[direction(i, w.numel())] * mu[k] * back[:, i]
    active = ca.diag(held)
    impulses = eliminated(active @ J @ coupled @ active + ca.diag(1 - held), -active @ gained, DEPENDENT)
    added = coupled @ active @ impulses
    gained += J @ added
    rest = ca.SX.zeros(n_u)
    held_columns = [hold(J, back, rest, gained[:, k], held, tested=True)[1] for k in range(V.shape[1])]
    return gained[: w.numel(), :], added + ca.horzcat(*held_columns) if held_columns else ca.SX(n_u, 0)


def _of_impact(automaton: Automaton, what: str, y: ca.SX, t: ca.SX, p: ca.SX) -> ca.SX:
    """Return an output of the impact in which no contact takes part."""
    assert automaton.impact is not None
    still = ca.SX.zeros(automaton.impact.numel_in(3))
    return automaton.impact(y, t, p, still)[automaton.impact.index_out(what)]


def starts_of(
    automaton: Automaton, scene: Scene, directions: Sequence[str], pairs: tuple[tuple[int, int], ...] = ()
) -> ca.Function:
    """Return ``p -> V(0)``, the derivatives of the initial state in the directions and by their pairs."""
    p = ca.SX.sym("p", len(automaton.parameters))
    symbols = {s: p[i] for i, s in enumerate(automaton.parameters)}
    of = {s.name: s for s in scene.values}
    show = Printer(symbols, set(), Switches())
    fixed = {s: v for s, v in scene.parameter_values().items() if s not in symbols}
    columns = []
    for name in directions:
        if name in automaton.states:
            columns.append(ca.SX([float(s.name == name) for s in scene.system.states]))
        else:
            columns.append(ca.vertcat(*(show(_slope(e, [of[name]], fixed)) for e in scene.initial.values())))
    for names in ([directions[k] for k in pair] for pair in pairs):
        if any(name in automaton.states for name in names):
            columns.append(ca.SX.zeros(len(automaton.states)))
        else:
            twice = [of[name] for name in names]
            columns.append(ca.vertcat(*(show(_slope(e, twice, fixed)) for e in scene.initial.values())))
    return ca.Function("start", [p], [ca.densify(ca.vertcat(*columns))])


def _slope(e: Any, symbols: Sequence[sp.Symbol], fixed: Mapping[sp.Symbol, float]) -> sp.Expr:
    return sp.sympify(e).diff(*symbols).xreplace({s: sp.Float(v) for s, v in fixed.items()})
