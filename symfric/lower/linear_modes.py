"""Detect equations that are linear between events, and express them by numbers that depend on the parameters.

The mode fixes the side of each kink, so that a force with an `Abs` or a piecewise linear law is linear in every mode.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import casadi as ca
import sympy as sp

from symfric.errors import NoRoute
from symfric.lower.automaton import Automaton
from symfric.lower.contact_dynamics import ContactDynamics
from symfric.model.laws import Law
from symfric.model.outputs import OutputOfExpression, friction_force, slip
from symfric.model.scene import Scene
from symfric.model.symbols import SPEED, TIME
from symfric.model.system import System
from symfric.model.tables import table_of


@dataclass(frozen=True)
class Oscillator:
    """Coefficients of one free mass with at most one contact.

    Attributes
    ----------
    data : casadi.Function
        ``(p, unused) -> numbers``: a_x, a_u, a_0 (the acceleration without friction is a_x x + a_u u + a_0), J/m, J and
        c (the slip is J u + c), load, static coefficient; for each branch of the law the speed where it ends and the
        two numbers of ``mu_0 + mu_1 v``; for each observable its value at 0 and its slopes in x, u and the friction.
    parameters : tuple of Symbol
        Order of the entries of p.
    branches : int
        0 without a contact.
    sticks : bool
        Whether the contact can.
    rows : int
    """

    data: ca.Function
    parameters: tuple[sp.Symbol, ...]
    branches: int
    sticks: bool
    rows: int


def oscillator(model: ContactDynamics, rows: Sequence[sp.Expr] = ()) -> Oscillator:
    """Express contact dynamics as one oscillator.

    Parameters
    ----------
    model : ContactDynamics
        The friction force is defined in it.
    rows : sequence of Expr
        Observables, extremes of expressions.

    Raises
    ------
    NoRoute
        If the scene has another form; the message says why.
    """
    system, contacts = model.system, model.contacts
    if len(system.q) > 1 or system.z:
        raise NoRoute(f"{len(system.states)} states, the closed form is for one mass")
    if system.linear is not None:
        raise NoRoute("the equations are given by matrices")
    if len(contacts) > 1:
        raise NoRoute(f"{len(contacts)} contacts, the closed form is for one")
    if model.inputs:
        raise NoRoute("a sampled input")
    lines = [line for c in contacts for line in lines_of(c.law)]
    x, u = model.y[0], model.y[1]
    force, mass = model.read(system.force[0]), model.read(system.mass[0, 0])
    refuse_if_moving(model, mass, "the mass changes")
    a_x, a_u, a_0 = plane(model, force / mass, [x, u], "the force")
    numbers = [a_x, a_u, a_0]
    numbers += _contact(model, mass, lines) if contacts else [ca.SX(0)] * 5
    friction = ca.SX.sym("friction")
    for c in contacts:
        model.define(friction_force(c.name), friction)
        model.define(slip(c.name), model.slip[0])
    for e in rows:
        *slopes, rest = plane(model, model.read(e), [x, u, friction], f"the output {e}")
        numbers += [rest, *slopes]
    data = ca.Function("data", [model.p, ca.SX.sym("unused")], [ca.densify(ca.vertcat(*numbers))])
    sticks = any(not c.law.smooth for c in contacts)
    return Oscillator(data, model.parameters, len(lines), sticks, len(rows))


def _contact(model: ContactDynamics, mass: ca.SX, lines: list[tuple[sp.Expr, sp.Expr, sp.Expr]]) -> list[ca.SX]:
    """Return the coefficients of the contact."""
    (contact,) = model.contacts
    J, c = plane(model, model.slip[0], [model.y[1]], "the slip")
    refuse_if_moving(model, model.load, "the normal load changes")
    numbers = [J / mass, J, c, model.load[0], model.read(contact.law.stick)]
    for line in lines:
        numbers += [model.read(e) for e in line]
    return numbers


def plane(model: ContactDynamics, e: ca.SX, variables: list[ca.SX], what: str) -> list[ca.SX]:
    """Return the slopes of a linear expression in the variables, and its value at zero."""
    v, signs = ca.vertcat(*variables), ca.vertcat(*model.switches.signs)
    slopes = ca.densify(ca.jacobian(e, v))
    rest = ca.substitute(e, v, ca.SX.zeros(v.numel()))
    if ca.depends_on(e, signs):
        raise NoRoute(f"{what} has a kink")
    if any(ca.depends_on(slopes, m) for m in (model.y, model.t, v)):
        raise NoRoute(f"{what} is not linear")
    if ca.depends_on(rest, model.t):
        raise NoRoute(f"{what} depends on time")
    if ca.depends_on(rest, model.y):
        raise NoRoute(f"{what} depends on the position")
    return [*ca.horzsplit(slopes), rest]


def refuse_if_moving(model: ContactDynamics, e: ca.SX, what: str) -> None:
    if ca.depends_on(e, ca.vertcat(model.y, model.t, *model.switches.signs)):
        raise NoRoute(what)


def lines_of(law: Law) -> list[tuple[sp.Expr, sp.Expr, sp.Expr]]:
    """Return for every branch of a law the speed where it ends, and the two numbers of ``mu_0 + mu_1 v``."""
    if law.memory:
        raise NoRoute("a friction law has memory")
    kinetic = law.kinetic
    if kinetic.has(sp.Integral):
        raise NoRoute("the friction law is a mean over fast vibration, not straight lines")
    table = table_of(kinetic) if isinstance(kinetic, sp.Piecewise) else None
    if table is not None and table.argument == SPEED and table.lines is not None:
        return [(end, *line) for end, line in zip((*table.breaks, sp.oo), table.lines, strict=True)]
    pieces = kinetic.args if isinstance(kinetic, sp.Piecewise) else [(kinetic, sp.true)]
    lines = []
    for k, (e, condition) in enumerate(pieces):
        end = law.breaks[k] if k < len(pieces) - 1 and k < len(law.breaks) else sp.oo
        slope = sp.diff(e, SPEED)
        if SPEED in slope.free_symbols or e.has(sp.Abs, sp.Max, sp.Min, sp.Piecewise):
            raise NoRoute("the friction law is not made of straight lines")
        if condition != sp.true and condition not in (SPEED < end, end > SPEED, SPEED <= end, end >= SPEED):
            raise NoRoute("the branches of the friction law do not follow its breaks")
        lines.append((end, e.subs(SPEED, 0), slope))
    return lines


@dataclass(frozen=True)
class Matrices:
    """Equations that are linear between events, ``x' = A x + a t + b``, guards and observables likewise.

    Attributes
    ----------
    data : casadi.Function
        ``(p, m) -> numbers``: the entries of the matrices that are not zero in every mode, then the slopes of all rows
        in time, and their rest.
    rows, columns : tuple of int
        Of the entries: those of the rates first, column by column; states and observables as in `Automaton.field`.
    n_r : int
        Number of rows.
    """

    data: ca.Function
    rows: tuple[int, ...]
    columns: tuple[int, ...]
    n_r: int


def matrices(automaton: Automaton) -> Matrices:
    """Return the slopes of rates, guards and observables in every state and in time, and their constants.

    Raises
    ------
    NoRoute
        If something is not linear in state and time in every mode.
    """
    field = automaton.field
    y, t, p, m = (ca.SX.sym(name, field.nnz_in(i)) for i, name in enumerate(field.name_in()))
    rate, guards, rows = field(y, t, p, m)
    parts = [(rate, "the forces or a friction law are"), (guards, "a guard is"), (rows, "a wanted output is")]
    return matrices_of(parts, y, t, p, m)


def matrices_of(
    parts: Sequence[tuple[ca.SX, str]], y: ca.SX, t: ca.SX, p: ca.SX, m: ca.SX, more: ca.SX | None = None
) -> Matrices:
    """Return the slopes of graphs in the variables y and in time, and their constants.

    Parameters
    ----------
    parts : sequence of (SX, str)
        Graphs, the entries of the first of which come first, and what they are.
    y, t, p, m : SX
        Variables, time, parameters and mode.
    more : SX, optional
        Further numbers at the end of the data.

    Raises
    ------
    NoRoute
        If something is not linear in the variables and time in every mode.
    """
    slopes, in_time, rest, state, n_x = [], [], [], ca.vertcat(y, t), y.numel()
    for e, name in parts:
        jacobian = ca.jacobian(e, state)
        if ca.depends_on(jacobian, state):
            raise NoRoute(f"{name} not linear between events")
        slopes.append(jacobian[:, :n_x])
        in_time.append(jacobian[:, n_x])
        rest.append(ca.substitute(e, state, ca.SX.zeros(state.numel())))
    first, others = slopes[0], ca.vertcat(*slopes[1:])
    entries = [ca.reshape(e.nz[:], e.nnz(), 1) for e in (first, others)]  # a column also where there are none
    numbers = ca.vertcat(*entries, *(ca.densify(ca.vertcat(*e)) for e in (in_time, rest)))
    if more is not None:
        numbers = ca.vertcat(numbers, ca.densify(more))
    n_r = first.rows()
    rows = (*first.sparsity().row(), *(n_r + r for r in others.sparsity().row()))
    columns = (*first.sparsity().get_col(), *others.sparsity().get_col())
    data = ca.Function("prelude", [p, m], [ca.densify(numbers)], {"cse": True})
    return Matrices(data, rows, columns, n_r + others.rows())


def without_harmonics(scene: Scene) -> Scene:
    """Return the scene with sines, cosines and powers of time as additional first-order states.

    Their equations are linear: ``c' = -Omega s``, ``s' = Omega c`` and ``p_k' = k p_(k-1)``. Time itself stays.

    Raises
    ------
    NoRoute
        If a slip depends on time other than linearly, the load of a contact behind a spring is a harmonic, a harmonic
        depends on the state, or there are held variables or resets.
    """
    for c in scene.contacts:
        if TIME in c.slip.diff(TIME).free_symbols:
            raise NoRoute(f"the slip of contact {c.name!r} depends on time, not linearly")
        if not c.along_line and TIME in c.normal.diff(TIME).free_symbols:
            raise NoRoute(f"the load of contact {c.name!r}, which is behind a spring, depends on time, not linearly")
    clock = _Clock({*scene.system.states, *scene.system.rows, *scene.inputs})
    system = scene.system
    linear = system.linear
    if linear is not None:
        scaled = tuple((clock.read(e), A) for e, A in linear.scaled)
        linear = replace(linear, scaled=scaled, loads=tuple((clock.read(e), row) for e, row in linear.loads))
    force, z_rate = ([clock.read(e) for e in es] for es in (system.force, system.z_rate))
    contacts = tuple(replace(c, normal=clock.read(c.normal), profile=clock.read(c.profile)) for c in scene.contacts)
    scalar = {n: o for n, o in scene.outputs.items() if isinstance(o, OutputOfExpression)}
    outputs = {**scene.outputs, **{n: replace(o, expr=clock.read(o.expr)) for n, o in scalar.items()}}
    if not clock.states:
        return scene
    if scene.clocks:
        raise NoRoute("held variables and resets beside functions of time are for the route 'taylor'")
    rates = [*z_rate, *(rate for _, rate in clock.states.values())]
    system = System(system.q, system.u, system.mass, force, [*system.z, *clock.states], rates, linear)
    starts = {z: start for z, (start, _) in clock.states.items()}
    initial = {**scene.initial, **starts}
    return replace(scene, system=system, contacts=contacts, outputs=outputs, initial=initial)


_MOST = 40  # most functions of time; larger matrices are much slower than Taylor series


class _Clock:
    """Additional states for functions of time, with their start and rate."""

    def __init__(self, moving: set[sp.Symbol]) -> None:
        self._moving = moving
        self.states: dict[sp.Symbol, tuple[float, sp.Expr]] = {}

    def read(self, e: sp.Expr) -> sp.Expr:
        """Replace functions of time in an expression by states."""
        e = sp.sympify(e)
        if TIME not in e.free_symbols:
            return e
        graph = self._read(e)
        if any(not p.free_symbols.isdisjoint(self.states) for p in graph.atoms(sp.Piecewise)):
            raise NoRoute("a Piecewise holds functions of time, which would be states and continuous with time only")
        return graph

    def _read(self, e: sp.Expr) -> sp.Expr:
        waves = {w: self._wave(w) for w in e.atoms(sp.sin, sp.cos) if TIME in w.free_symbols}
        e = e.xreplace(waves)
        if not e.has(sp.Pow) or TIME not in e.free_symbols:
            return e
        power = lambda a: a.is_Pow and a.base == TIME and a.exp.is_Integer and a.exp > 1  # noqa: E731
        return sp.expand(e).replace(power, lambda a: self._power(int(a.exp)))

    def _wave(self, wave: sp.Expr) -> sp.Expr:
        angle = wave.args[0]
        Omega, phase = sp.diff(angle, TIME), angle.subs(TIME, 0)
        if TIME in Omega.free_symbols or (Omega.free_symbols | phase.free_symbols) & self._moving:
            raise NoRoute(f"{wave} is no harmonic of time")
        if len(self.states) >= _MOST:
            raise NoRoute(f"more than {_MOST} functions of time, each of which would be a state")
        c, s = (sp.Symbol(f"{name}({Omega}*t)", real=True) for name in ("cos", "sin"))
        self.states[c], self.states[s] = (1.0, -Omega * s), (0.0, Omega * c)
        if wave.func == sp.sin:
            return sp.sin(phase) * c + sp.cos(phase) * s
        return sp.cos(phase) * c - sp.sin(phase) * s

    def _power(self, k: int) -> sp.Symbol:
        if k == 1:
            return TIME
        z = sp.Symbol(f"t**{k}", real=True)
        self.states[z] = 0.0, k * self._power(k - 1)
        return z
