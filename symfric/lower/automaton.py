"""A scene as a hybrid automaton: smooth CasADi functions in which the mode is data.

The mode of contact i is a stick flag s_i (1 sticks, 0 slips) and a direction d_i = +-1 of its slip w_i; of switch j a
sign sigma_j. With f the applied forces, J = dw/du and lambda the friction forces,

    M u' = f + J^T lambda,   lambda_i = -d_i N_i mu(d_i w_i) where i slips,   w_i' = 0 where i sticks.

A contact that cannot slip while the ones before it stick has no constraint of its own: then s_i is 2, and it carries
nothing, or 3 if it is parallel to one of those (two on the same body), and they share the force in proportion to their
bounds. The motion is the same for every distribution of the forces, the end of the sticking is not.

The sticking forces follow from ``S A S lambda_S = -S (J M^-1 (f + J^T lambda_D) + dJ/dt u + dc/dt)`` with
``A = J M^-1 J^T`` and ``S = diag(s == 1)``, see `symfric.lower.constraint_forces`: one graph serves every mode, and for
a constant mass matrix everything that depends on the mode alone is computed once per mode, not once per step.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import casadi as ca
import sympy as sp

from symfric.lower.averaged_series import without_integrals
from symfric.lower.cell_edges import Edges, edges_of
from symfric.lower.constraint_forces import hold
from symfric.lower.load_sharing import parallels, rooms_left
from symfric.lower.printer import Printer, Switches
from symfric.model.laws import Law
from symfric.model.outputs import friction_force, slip
from symfric.model.scene import Scene
from symfric.model.symbols import SPEED, TIME

# part of the speed on either side of an infinite slope that a line replaces; with less, orders overflow
BRIDGE = 1e-9


@dataclass(frozen=True)
class Automaton:
    """Smooth functions of a scene and the layout of their arguments.

    Attributes
    ----------
    field : casadi.Function
        ``(y, t, p, m) -> (rate, guards, rows)``: state derivative (n_x,), guards (n_g,), wanted expressions (n_e,).
        Guards are positive while the mode is right. Contact i owns rows 2i and 2i+1: ``d w`` and 1 while it slips,
        ``N mu_s -+ lambda`` while it sticks, ``+-w`` while it sticks without a force; then one row for each switch;
        then one for each of `loads`.
    gauge : casadi.Function
        ``(y, t, p) -> (w, scale, pull, load, margin, forces, coupling, spread)``. The first six are (n_c,): slips, the
        sum of the magnitudes of their terms, and the slip acceleration that the largest static friction can cause, the
        scales of zero tests; then the normal load times the profile, and static minus kinetic coefficient at rest,
        neither of which may be negative; then the slip acceleration if no force cancelled another, the scale of its
        rounding. Then ``J M^-1 J^T``, (n_c, n_c), and ``M^-1 J^T``, (n_u, n_c), row by row, and ``J^T`` likewise
        unless no two slips have a mass in common; last the sizes of `symfric.lower.cell_edges.Edges`.
    states, contacts, loads : tuples of str
        Names; `loads` lists the contacts whose normal load varies and may become negative.
    sticks : tuple of bool
        Whether each contact can stick; a smooth law cannot.
    parameters : tuple of Symbol
        Order of the first entries of p; then, for each input, start, value and slope of its current sample interval.
    inputs : tuple of Symbol
    n_q, n_switches : int
        Number of coordinates and of switches.
    at_edges : tuple of int
        The switches at which a load jumps; see `symfric.lower.cell_edges`.
    autonomous : bool
        Whether time appears nowhere.
    anchors : tuple of (int, float)
        For each contact the index of the one velocity it depends on and its factor, or (-1, 0) if there are several.
    parallels : tuple of int
        For each contact the first one whose slip is a multiple of its own.
    """

    field: ca.Function
    gauge: ca.Function
    states: tuple[str, ...]
    contacts: tuple[str, ...]
    loads: tuple[str, ...]
    sticks: tuple[bool, ...]
    parameters: tuple[sp.Symbol, ...]
    inputs: tuple[sp.Symbol, ...]
    n_q: int
    n_switches: int
    at_edges: tuple[int, ...]
    autonomous: bool
    anchors: tuple[tuple[int, float], ...]
    parallels: tuple[int, ...]

    @property
    def n_mode(self) -> int:
        """Length of the mode vector ``m = [s; d; sigma]``."""
        return 2 * len(self.contacts) + self.n_switches

    @property
    def coupled(self) -> bool:
        """Whether two slips have a mass in common."""
        return self.gauge.nnz_out("slopes") > 0

    @property
    def n_guards(self) -> int:
        """Number of guard rows."""
        return 2 * len(self.contacts) + self.n_switches + len(self.loads)


def constants(scene: Scene, varied: frozenset[str] = frozenset()) -> dict[sp.Symbol, sp.Expr]:
    """Return the parameters that the equations take as numbers, `varied` ones excepted.

    They are those that are exactly zero, and those inside an integral of a law, whose series holds for one value each.
    """
    return {**averaged_over(scene, varied), **vanishing(scene, varied)}


def averaged_over(scene: Scene, varied: frozenset[str] = frozenset()) -> dict[sp.Symbol, sp.Float]:
    """Return the parameters inside an integral of a law, `varied` ones excepted."""
    integrals = [e for c in scene.contacts for e in c.law.kinetic.atoms(sp.Integral)]
    inside = set().union(*(e.free_symbols for e in integrals))
    return {s: sp.Float(v) for s, v in scene.values.items() if s in inside and v and s.name not in varied}


def vanishing(scene: Scene, varied: frozenset[str] = frozenset()) -> dict[sp.Symbol, sp.Integer]:
    """Return the parameters that are exactly zero and may be dropped from the equations, `varied` ones excepted."""
    zero = {s: sp.Integer(0) for s, v in scene.values.items() if v == 0 and s.name not in varied}
    kept = dict(zero)
    for symbol in zero:
        changed = [e.xreplace({symbol: sp.Integer(0)}) for e in _expressions(scene) if symbol in e.free_symbols]
        if any(e.has(sp.nan, sp.zoo, sp.oo, -sp.oo) for e in changed):
            del kept[symbol]
    return kept


def _expressions(scene: Scene) -> list[sp.Expr]:
    parts = [*scene.system.expressions]
    for c in scene.contacts:
        parts += [c.slip, c.normal, c.profile, c.law.kinetic, c.law.stick, *c.law.breaks]
    return parts


class Lowering:
    """The symbols and graphs of one lowering: state, time, parameters, mode, and the printer that connects them."""

    def __init__(self, scene: Scene, constants: dict[sp.Symbol, sp.Expr]):
        system = scene.system
        self.scene, self.constants = scene, constants
        self.y = ca.SX.sym("y", len(system.states))
        self.t = ca.SX.sym("t")
        self.parameters = tuple(s for s in scene.parameters if s not in constants)
        self.inputs = tuple(scene.inputs)
        self.p = ca.SX.sym("p", len(self.parameters) + 3 * len(self.inputs))
        self.switches = Switches()
        self.symbols = {TIME: self.t}
        self.symbols.update({s: self.y[i] for i, s in enumerate(system.states)})
        self.symbols.update({s: self.p[i] for i, s in enumerate(self.parameters)})
        for k, s in enumerate(self.inputs):
            start, value, slope = ca.vertsplit(self.p[len(self.parameters) + 3 * k : len(self.parameters) + 3 * k + 3])
            self.symbols[s] = value + slope * (self.t - start)
        self.moving = {*system.states, TIME, *self.inputs}
        self.print = Printer(self.symbols, self.moving, self.switches)
        n = len(scene.contacts)
        self.s, self.d = ca.SX.sym("s", n), ca.SX.sym("d", n)
        parts = [self._contact(i) for i in range(n)]
        self.w, self.load, self.sliding = (
            ca.vertcat(*(p[k] for p in parts)) if parts else ca.SX(0, 1) for k in range(3)
        )

    def sx(self, expr: sp.Expr) -> ca.SX:
        return self.print(sp.sympify(expr).xreplace(self.constants))

    def vector(self, exprs) -> ca.SX:
        return ca.vertcat(*(self.sx(e) for e in exprs)) if len(exprs) else ca.SX(0, 1)

    def mass(self) -> ca.SX:
        """Return the mass matrix, sparse."""
        rows = self.scene.system.mass.tolist()
        return ca.sparsify(ca.vertcat(*(ca.horzcat(*(self.sx(e) for e in row)) for row in rows)))

    def unswitched(self, out: list[ca.SX]) -> list[ca.SX]:
        """Return expressions in which the signs of the kinks are those of their quantities, no longer data."""
        if not self.switches.signs:
            return out
        signs, quantities = ca.vertcat(*self.switches.signs), ca.vertcat(*self.switches.quantities)
        nested = ca.which_depends(quantities, signs, 1, True)
        for k in (k for k in reversed(range(len(nested))) if nested[k]):
            out = ca.substitute(out, [signs[k]], [ca.if_else(quantities[k] < 0, -1, 1)])
        plain = [k for k, depends in enumerate(nested) if not depends]
        if plain:
            out = ca.substitute(out, [signs[plain]], [ca.if_else(quantities[plain] < 0, -1, 1)])
        return out

    def _contact(self, i: int) -> tuple[ca.SX, ca.SX, ca.SX]:
        """Return slip, load times profile, and the friction of contact i while it slips."""
        c = self.scene.contacts[i]
        w = self.sx(c.slip)
        load = self.sx(c.normal * c.profile)
        inside = {**self.symbols, SPEED: self.d[i] * w}
        law = Printer(inside, {*self.moving, SPEED}, self.switches, scope=c.name)
        return w, load, -self.d[i] * load * law(_bridged(c.law.where(self.constants)))


def _bridged(law: Law) -> sp.Expr:
    """Return the kinetic coefficient without integrals, with a straight line across every speed in `steep`.

    The slope of an effective law behaves like 1/sqrt(q - v); a motion that hovers at v = q has no Taylor series there.
    """
    kinetic = without_integrals(law.kinetic)
    if not law.steep:
        return kinetic
    bridged = []
    for k, (expr, condition) in enumerate(kinetic.args):
        speed = next((s for s in law.steep if condition in (SPEED < s, s > SPEED)), None)
        if speed is None:
            bridged.append((expr, condition))
            continue
        above = kinetic.args[k + 1].expr
        begin, end = speed * (1 - BRIDGE), speed * (1 + BRIDGE) if _has_ends(above) else speed
        low, high = expr.subs(SPEED, begin), above.subs(SPEED, end)
        line = low + (high - low) * (SPEED - begin) / (end - begin)
        bridged += [(expr, SPEED < begin), (line, SPEED < end)]
    return sp.Piecewise(*bridged)


def _has_ends(expr: sp.Expr) -> bool:
    """Whether an expression may hold only from some speed on: inverse functions and roots do."""
    roots = [e for e in expr.atoms(sp.Pow) if not e.exp.is_Integer and SPEED in e.base.free_symbols]
    return bool(roots or expr.atoms(sp.asin, sp.acos))


def lower(scene: Scene, rows: Sequence[sp.Expr] = (), varied: frozenset[str] = frozenset()) -> Automaton:
    """Build the automaton of a scene.

    Parameters
    ----------
    scene : Scene
    rows : sequence of Expr
        Expressions wanted along the run; may contain `friction_force` and `slip`.
    varied : frozenset of str
        Parameters that will change although `constants` has them; the others there are built into the equations.

    Raises
    ------
    SceneError
        If an expression has no CasADi form.
    """
    low = Lowering(scene, constants(scene, varied))
    system, n = scene.system, len(scene.system.q)
    u, w, load = low.y[n : 2 * n], low.w, low.load
    f, mass = low.vector(system.force), low.mass()
    groups = [k for k, _ in parallels(scene)]
    edges = edges_of(low, mass, groups)
    for i in range(len(scene.contacts)):
        low.sliding[i] = edges.towards(i, low.d[i], low.sliding[i])
    rate, friction = accelerations(low, f, mass, tested=False)
    guards = []
    friction, rooms = rooms_left(low, friction, edges)
    for i, (behind, ahead) in enumerate(rooms):
        if scene.contacts[i].law.smooth:
            guards += [low.d[i] * w[i], ca.SX(1)]
        else:
            sticks, idle = low.s[i] > 0.5, low.s[i] == 2
            guards += [ca.if_else(idle, w[i], ca.if_else(sticks, behind, low.d[i] * w[i]))]
            guards += [ca.if_else(idle, -w[i], ca.if_else(sticks, ahead, 1))]
    for i, c in enumerate(scene.contacts):
        low.symbols[friction_force(c.name)], low.symbols[slip(c.name)] = friction[i], w[i]
        low.moving |= {friction_force(c.name), slip(c.name)}
    wanted = low.vector(list(rows))
    z_rate = low.vector(system.z_rate)
    loads = tuple(c.name for c in scene.contacts if _may_lift((c.normal * c.profile).xreplace(low.constants), low))
    guards += low.switches.guards
    guards += [load[i] for i, c in enumerate(scene.contacts) if c.name in loads]
    out = [ca.vertcat(u, rate, z_rate), ca.vertcat(*guards) if guards else ca.SX(0, 1), wanted]
    out = [ca.densify(e) for e in out]
    mode = ca.vertcat(low.s, low.d, *low.switches.signs)
    field = ca.Function("field", [low.y, low.t, low.p, mode], out, ["y", "t", "p", "m"], ["rate", "guards", "rows"])
    return Automaton(
        field=field,
        gauge=_gauge(low, u, mass, edges),
        states=tuple(s.name for s in system.states),
        contacts=tuple(c.name for c in scene.contacts),
        loads=loads,
        sticks=tuple(not c.law.smooth for c in scene.contacts),
        parameters=low.parameters,
        inputs=low.inputs,
        n_q=n,
        n_switches=len(low.switches.signs),
        at_edges=edges.switches,
        autonomous=not ca.depends_on(ca.vertcat(*out), low.t),
        anchors=tuple(_anchor(scene, c) for c in scene.contacts),
        parallels=tuple(groups),
    )


def accelerations(low: Lowering, f: ca.SX, mass: ca.SX, tested: bool) -> tuple[ca.SX, ca.SX]:
    """Return u' and the friction forces of all contacts in the mode held by (s, d).

    `tested` says whether the graph itself finds out which sticking contacts are redundant, by conditions on the state;
    otherwise the mode says it.
    """
    n, nc, w = f.numel(), low.w.numel(), low.w
    u, q = low.y[n : 2 * n], low.y[:n]
    D, LT, order = ca.ldl(mass)
    solve = lambda b: ca.ldl_solve(b, D, LT, order)  # noqa: E731
    if nc == 0:
        return solve(f), ca.SX(0, 1)
    J = ca.jacobian(w, u)
    slipping = ca.SX(low.sliding)
    for i, c in enumerate(low.scene.contacts):
        if not c.law.smooth:
            slipping[i] = ca.if_else(low.s[i] > 0.5, 0, low.sliding[i])
    free = solve(f + J.T @ slipping)
    sticking = [i for i, c in enumerate(low.scene.contacts) if not c.law.smooth]
    if not sticking:
        return free, slipping
    Jk, s = J[sticking, :], low.s[sticking] == 1
    pull = solve(Jk.T)
    drift = ca.jacobian(w, q)[sticking, :] @ u + ca.jacobian(w, low.t)[sticking, :]
    held, gain, own = hold(Jk, pull, free, drift, s, tested)
    friction, rate = ca.SX(slipping), ca.densify(free + gain)
    for k, i in enumerate(sticking):
        friction[i] = slipping[i] + held[k]
        index, factor = _anchor(low.scene, low.scene.contacts[i])
        if index >= 0:  # a body held by the ground follows it exactly, not to rounding
            rate[index - n] = ca.if_else(own[k], -drift[k] / factor, rate[index - n])
    return rate, friction


def _gauge(low: Lowering, u: ca.SX, mass: ca.SX, edges: Edges) -> ca.Function:
    w, load, n_c = low.w, low.load, low.w.numel()
    J = ca.jacobian(w, u) if n_c else ca.SX(0, u.numel())
    still = ca.substitute(w, u, ca.SX.zeros(u.numel())) if n_c else w
    terms = ca.fabs(J) @ ca.fabs(u) + ca.fabs(still)
    laws = [c.law for c in low.scene.contacts]
    stick, rest = ([low.sx(e) for e in es] for es in ([a.stick for a in laws], [a.at_rest for a in laws]))
    bounds = [load[i] * (stick[i] + ca.fabs(rest[i])) for i in range(n_c)]
    margin = ca.vertcat(*(stick[i] * (1 + 1e-12) - rest[i] for i in range(n_c))) if n_c else w
    spread = ca.ldl_solve(J.T, *ca.ldl(mass)) if n_c else ca.SX(u.numel(), 0)
    coupling = J @ spread
    reach = ca.vertcat(*map(edges.widest, bounds)) if n_c else w
    pull = ca.diag(coupling) * reach
    applied = [sum(ca.fabs(low.sx(term)) for term in sp.Add.make_args(e)) for e in low.scene.system.force]
    forces = ca.fabs(spread).T @ ca.vertcat(*applied) + ca.fabs(coupling) @ reach
    coupled = ca.sparsify(coupling).nnz() > n_c
    slopes = ca.vec(ca.densify(J)) if coupled else ca.SX(0, 1)
    out = (w, terms, pull, load, margin, forces, ca.vec(coupling), ca.vec(spread.T), slopes, edges.sizes)
    names = ["w", "scale", "pull", "load", "margin", "forces", "coupling", "spread", "slopes", "edges"]
    shown = low.unswitched([ca.densify(e) for e in out])
    return ca.Function("gauge", [low.y, low.t, low.p], shown, ["y", "t", "p"], names)


def _may_lift(load: sp.Expr, low: Lowering) -> bool:
    """Whether a load varies and may become negative; one like Max(..., 0) only touches zero, to rounding."""
    return bool(load.free_symbols & low.moving) and not load.is_nonnegative


def _anchor(scene: Scene, contact) -> tuple[int, float]:
    slopes = [contact.slip.diff(u) for u in scene.system.u]
    present = [i for i, e in enumerate(slopes) if e != 0]
    if len(present) == 1 and slopes[present[0]].is_number:
        return len(scene.system.q) + present[0], float(slopes[present[0]])
    return -1, 0.0
