"""A scene as a hybrid automaton: smooth CasADi functions in which the mode is data.

The mode of contact i is a stick flag s_i (1 sticks, 0 slips) and a direction d_i = +-1 of its slip w_i; of switch j a
sign sigma_j. With f the applied forces, J = dw/du and lambda the friction forces,

    M u' = f + J^T lambda,   lambda_i = -d_i N_i mu(d_i w_i) where i slips,   w_i' = 0 where i sticks.

A contact that cannot slip while others stick has no constraint of its own: then s_i is 2, and it carries nothing, or 4,
and it carries its static bound, ``-d_i N_i mu_s``, or 3 if it is parallel to one of the others (two on the same body),
and they share the force in proportion to their bounds. The motion is the same for every distribution of the forces; the
end of the sticking is where no distribution is left, see `symfric.solve.loop.modes.sticking_basis`.

The sticking forces follow from ``S A S lambda_S = -S (J M^-1 (f + J^T lambda_D) + dJ/dt u + dc/dt)`` with
``A = J M^-1 J^T`` and ``S = diag(s == 1)``, see `symfric.lower.constraint_forces`: one graph serves every mode, and for
a constant mass matrix everything that depends on the mode alone is computed once per mode, not once per step.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import casadi as ca
import sympy as sp

from symfric.lower.clocks import Clocks
from symfric.lower.constraint_forces import AT_BOUND, FOLLOWS
from symfric.lower.contact_dynamics import ContactDynamics
from symfric.lower.impacts import impact_of
from symfric.lower.linear_part import applied_in
from symfric.lower.load_sharing import rooms_left
from symfric.lower.mode_layout import ModeLayout
from symfric.lower.normal_forces import least_normal_forces, with_normal_forces
from symfric.lower.spring_sliders import transition_of
from symfric.model.constant_parameters import constants
from symfric.model.in_plane import with_speeds
from symfric.model.outputs import dissipated_power, friction_force, normal_force, slip, stored_energy
from symfric.model.scene import Scene


@dataclass(frozen=True)
class VariedField:
    """A field whose states are followed by columns of derivatives, in the field made from it.

    Attributes
    ----------
    field : casadi.Function
        ``(y, t, p, m) -> (rate, guards, rows)`` without derivatives.
    directions : tuple of int
        For each column the index in p of the parameter, -1 for the start of a state.
    followed : int
        Number of rows, the first ones, whose derivatives follow the rows.
    """

    field: ca.Function
    directions: tuple[int, ...]
    followed: int


@dataclass(frozen=True)
class Automaton:
    """Smooth functions of a scene and the layout of their arguments.

    Attributes
    ----------
    field : casadi.Function
        ``(y, t, p, m) -> (rate, guards, rows)``: state derivative (n_x,), guards (n_g,), observables (n_e,).
        Guards are positive while the mode is right. Those of a contact are ``d w`` and 1 while it slips,
        ``N mu_s -+ lambda`` while it sticks, ``+-w`` while its force is given.
    gauge : casadi.Function
        ``(y, t, p) -> (w, scale, pull, load, margin, forces, coupling, spread)``. The first six are (n_c,): slips, the
        sum of the magnitudes of their terms, and the slip acceleration that the largest static friction can cause, the
        scales of zero tests; then the normal load times the profile, and static minus kinetic coefficient at rest,
        neither of which may be negative; then the slip acceleration if no force cancelled another, the scale of its
        rounding. Then ``J M^-1 J^T``, (n_c, n_c), and ``M^-1 J^T``, (n_u, n_c), row by row, and ``J^T`` likewise
        unless no two slips have a mass in common; the sizes of `symfric.lower.cell_edges.Edges`; last, if there are
        contacts in the plane, the largest friction of every contact at rest and just after its release.
    states : tuple of str
        Names.
    layout : ModeLayout
        Where m and the guards have what belongs to a contact.
    sticks : tuple of bool
        Whether each contact can stick; a smooth law cannot.
    planes : tuple of int
        Of every contact in the plane the index of its first row among the contacts along a line.
    parameters : tuple of Symbol
        Order of the first entries of p; then, for each input, start, value and slope of its current sample interval.
    inputs : tuple of Symbol
    n_q : int
        Number of coordinates.
    at_edges : tuple of int
        The switches at which a load jumps; see `symfric.lower.cell_edges`.
    steps : tuple of int
        The switches of conditions on time alone, at which forces, slips, loads and laws may jump.
    autonomous : bool
        Whether time appears nowhere.
    anchors : tuple of (int, float)
        For each contact the index of the one velocity it depends on and its factor, or (-1, 0) if there are several.
    parallels : tuple of int
        For each contact the first one whose slip is a multiple of its own.
    dependent : tuple of bool
        Whether the slip of each contact may follow from those of others that are not multiples of it.
    transition : casadi.Function, optional
        ``(y, t, p, m, hit, zero) -> (y, m, zero)``: what the events of the contacts of other kinds do, with 1 for each
        of their guards that is hit and 0 for the others, and 1 for each that starts the mode at zero. Needed if the
        layout has such contacts.
    impact : casadi.Function, optional
        What contacts that open do when they strike, see `symfric.lower.impacts.impact_of`.
    varied : VariedField, optional
        What the field was made from, if its states hold first derivatives.
    """

    field: ca.Function
    gauge: ca.Function
    states: tuple[str, ...]
    layout: ModeLayout
    sticks: tuple[bool, ...]
    parameters: tuple[sp.Symbol, ...]
    inputs: tuple[sp.Symbol, ...]
    n_q: int
    at_edges: tuple[int, ...]
    steps: tuple[int, ...]
    autonomous: bool
    anchors: tuple[tuple[int, float], ...]
    parallels: tuple[int, ...]
    dependent: tuple[bool, ...]
    transition: ca.Function | None = None
    impact: ca.Function | None = None
    planes: tuple[int, ...] = ()
    varied: VariedField | None = None

    @property
    def contacts(self) -> tuple[str, ...]:
        """Names of the contacts that slip along a line."""
        return self.layout.lines

    @property
    def n_y(self) -> int:
        """Number of states of the motion, without appended derivatives."""
        return self.gauge.size1_in(0) if self.transition is None else self.transition.size1_in(0)

    @property
    def coupled(self) -> bool:
        """Whether the forces of one contact accelerate the slip of another."""
        return self.gauge.nnz_out("slopes") > 0

    @property
    def has_feet(self) -> bool:
        """Whether contacts in the plane may be feet of one body, which `symfric.solve.loop.modes.feet` decides on."""
        depend = self.impact is None or any(self.dependent[i] for i in self.planes)
        return len(self.planes) > 0 and self.coupled and depend

    @property
    def impact_answers(self) -> int:
        """The number of outputs of the impact that a run needs; the others are for derivatives."""
        if self.impact is None:
            return 0
        return self.impact.index_out("spread") + self.has_feet


def arguments_of(field: ca.Function) -> tuple[ca.SX, ca.SX, ca.SX, ca.SX]:
    """Return symbols ``(y, t, p, m)`` for the arguments of a field."""
    y, t, p, m = (ca.SX.sym(name, field.nnz_in(k)) for k, name in enumerate(("y", "t", "p", "m")))
    return y, t, p, m


def lower(scene: Scene, rows: Sequence[sp.Expr] = (), varied: frozenset[str] = frozenset()) -> Automaton:
    """Build the automaton of a scene.

    Parameters
    ----------
    scene : Scene
    rows : sequence of Expr
        Observables; may contain `friction_force` and `slip`.
    varied : frozenset of str
        Parameters that will change, and are therefore not built into the equations although `constants` has them.

    Raises
    ------
    SceneError
        If an expression has no CasADi form.
    """
    return automaton_of(ContactDynamics.of(scene, constants(scene, varied)), rows)


def automaton_of(model: ContactDynamics, rows: Sequence[sp.Expr] = ()) -> Automaton:
    """Build the automaton of contact dynamics; defines the forces and slips that observables may contain."""
    rate, friction = model.accelerations(tested=False)
    guards, observables, loads = observed(model, friction, rows)
    rate, (z_rate, guards, observables) = with_normal_forces(model, rate, [model.z_rate, guards, observables])
    out = [ca.densify(e) for e in (ca.vertcat(model.u, rate, z_rate), guards, observables)]
    mode = ca.vertcat(model.s, model.d, *model.switches.signs, *(spring.variables for spring in model.springs))
    others = tuple(spring.layout for spring in model.springs)
    names = ["rate", "guards", "rows"]
    field = ca.Function("field", [model.y, model.t, model.p, mode], out, ["y", "t", "p", "m"], names)
    return Automaton(
        field=field,
        gauge=_gauge(model),
        states=tuple(s.name for s in model.system.states),
        layout=ModeLayout(tuple(c.name for c in model.contacts), len(model.switches.signs), loads, others),
        sticks=tuple(not c.law.smooth for c in model.contacts),
        parameters=model.parameters,
        inputs=model.inputs,
        n_q=model.q.numel(),
        at_edges=model.edges.switches,
        steps=tuple(sorted(model.switches.steps)),
        autonomous=not ca.depends_on(ca.vertcat(*out), model.t),
        anchors=tuple(model.anchor(i) for i in range(len(model.contacts))),
        parallels=tuple(k for k, _ in model.parallels),
        dependent=tuple(model.dependent),
        transition=transition_of(model.springs, model.y, model.t, model.p, mode),
        impact=impact_of(model),
        planes=tuple(plane.row for plane in model.planes),
    )


def observed(model: ContactDynamics, friction: ca.SX, rows: Sequence[sp.Expr]) -> tuple[ca.SX, ca.SX, tuple[str, ...]]:
    """Return the guards, the observables, and the contacts whose load has a guard; defines what observables contain.

    Parameters
    ----------
    model : ContactDynamics
    friction : SX, shape (n_c,)
        The friction forces, of which parallel contacts share the sum.
    rows : sequence of Expr
    """
    contacts, w, load, s, d = model.contacts, model.slip, model.load, model.s, model.d
    guards: list[ca.SX] = []
    friction, rooms = rooms_left(model, friction)
    opens = {e.line: e.mode for e in model.openings}
    planes = {plane.row: plane for plane in model.planes}
    for i, (behind, ahead) in enumerate(rooms):
        if i in planes:
            guards += planes[i].row_guards(load[i] * model.static[i], friction[planes[i].rows])
        elif i - 1 in planes:
            continue
        elif contacts[i].law.smooth:
            guards += [d[i] * w[i], ca.SX(1)]
        else:
            sticks, idle = s[i] > 0.5, s[i] == FOLLOWS
            if model.dependent[i]:
                idle = ca.logic_or(idle, s[i] == AT_BOUND)
            own = [ca.if_else(idle, w[i], ca.if_else(sticks, behind, d[i] * w[i]))]
            own += [ca.if_else(idle, -w[i], ca.if_else(sticks, ahead, 1))]
            guards += [e if i not in opens else ca.if_else(opens[i] > 0.5, 0, e) for e in own]
    for i, c in enumerate(contacts):
        if i in planes:
            plane = planes[i]
            force = friction[plane.rows] if plane.factors is None else friction[plane.rows] * plane.factors
            model.define(friction_force(c.name, 0), force[0])
            model.define(friction_force(c.name, 1), force[1])
            model.define(normal_force(c.name), model.read(c.normal))
            model.define(slip(c.name), ca.if_else(plane.rests, 0, plane.slip_speed))
            model.define(stored_energy(c.name), ca.SX(0))
            model.define(dissipated_power(c.name), -ca.dot(friction[plane.rows], plane.w))
        if i in planes or i - 1 in planes:
            continue
        model.define(friction_force(c.name), friction[i])
        if c.unilateral is None:
            model.define(normal_force(c.name), model.read(c.normal))
        model.define(slip(c.name), w[i])
        stored, gained = model.energy(i)
        model.define(stored_energy(c.name), load[i] * stored)
        model.define(dissipated_power(c.name), -friction[i] * w[i] - load[i] * gained)
    for i in (i for i in planes if contacts[i].unilateral is None):  # of one that opens it is no speed in flight
        factors = contacts[i].ellipse or (1, 1)
        across = contacts[i].across
        assert across is not None
        slips = (contacts[i].slip / factors[0], across / factors[1])
        rows = [with_speeds(expr, contacts[i].name, slips) for expr in rows]
    observables = model.vector(list(rows))
    _ = model.z_rate  # its kinks are switches with guards, too
    lifting = [
        i
        for i, c in enumerate(contacts)
        if c.unilateral is None and i - 1 not in planes
        if _may_lift((c.normal * c.profile).xreplace(model.constants), model)
    ]
    guards += model.switches.guards
    guards += [load[i] for i in lifting]
    guards += [guard for spring in model.springs for guard in spring.guards]
    return (ca.vertcat(*guards) if guards else ca.SX(0, 1)), observables, tuple(contacts[i].name for i in lifting)


def _gauge(model: ContactDynamics) -> ca.Function:
    w, u, n_c, edges = model.slip, model.u, model.slip.numel(), model.edges
    J, spread = model.slopes, model.spread
    still = ca.substitute(w, u, ca.SX.zeros(u.numel())) if n_c else w
    terms = ca.fabs(J) @ ca.fabs(u) + ca.fabs(still)
    bounds = model.load * (model.static + ca.fabs(model.at_rest))
    drop = model.static * (1 + 1e-12) - model.at_rest
    margin = ca.if_else(model.at_rest < -1e-12 * model.static, model.at_rest, drop)  # negative if a law decides nothing
    coupling = J @ spread
    reach = ca.vertcat(*(edges.widest(e) for e in ca.vertsplit(bounds))) if n_c else w
    pull = ca.diag(coupling) * reach
    applied = [sum(ca.fabs(model.read(term)) for term in sp.Add.make_args(e)) for e in model.system.force]
    pushed = ca.vertcat(*applied)
    if model.system.linear is not None:
        pushed += applied_in(model.system.linear, model.read, model.q, model.u)
    forces = ca.fabs(spread).T @ pushed + ca.fabs(coupling) @ reach
    coupled = ca.sparsify(coupling).nnz() > n_c
    slopes = ca.vec(ca.densify(J)) if coupled else ca.SX(0, 1)
    limits = ca.vertcat(model.load * model.static, model.load * model.at_rest) if model.planes else ca.SX(0, 1)
    out = (w, terms, pull, model.load, margin, forces, ca.vec(coupling), ca.vec(spread.T), slopes, edges.sizes, limits)
    names = ["w", "scale", "pull", "load", "margin", "forces", "coupling", "spread", "slopes", "edges", "limits"]
    shown = [ca.densify(e) for e in out]
    if model.openings:
        pressed = [e.force for e in model.openings]
        shown = ca.substitute(shown, pressed, ca.vertsplit(least_normal_forces(model)))
    moving = [
        e for s in model.springs if not isinstance(s, Clocks) for e in ca.vertsplit(s.variables)
    ]  # then their forces are largest; those of contacts that are pressed depend on them
    if moving:
        shown = ca.substitute([ca.densify(e) for e in shown], moving, [ca.SX(1)] * len(moving))
    shown = model.unswitched([ca.densify(e) for e in shown])
    return ca.Function("gauge", [model.y, model.t, model.p], shown, ["y", "t", "p"], names)


def _may_lift(load: sp.Expr, model: ContactDynamics) -> bool:
    """Whether a load varies and may become negative; one such as Max(..., 0) may not."""
    return bool(load.free_symbols & model.moving) and not load.is_nonnegative
