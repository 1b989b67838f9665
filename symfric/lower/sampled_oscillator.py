"""One mass on a rough floor under a sampled input, expressed by numbers that depend on the parameters."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import casadi as ca
import sympy as sp

from symfric.errors import NoRoute
from symfric.lower.contact_dynamics import ContactDynamics
from symfric.lower.linear_modes import lines_of, plane, refuse_if_moving
from symfric.model.outputs import friction_force, slip
from symfric.model.system import Signal


@dataclass(frozen=True)
class Record:
    """One mass with one sampled input and one contact, whose friction may depend on the position.

    Attributes
    ----------
    data : casadi.Function
        ``(p, unused) -> numbers``: damping, stiffness, input, constant force, kinetic and static friction, all over the
        mass; for each cell of the friction profile its edges, and the coefficient at u = 0 and the slope of its line;
        for each observable its slopes in u, w, friction over the mass and input, and its constant.
    parameters : tuple of Symbol
        Order of the entries of p.
    signal : Signal
    cells, rows : int
    """

    data: ca.Function
    parameters: tuple[sp.Symbol, ...]
    signal: Signal
    cells: int
    rows: int


def record(model: ContactDynamics, signals: Mapping[sp.Symbol, Signal], rows: Sequence[sp.Expr] = ()) -> Record:
    """Express contact dynamics as one mass under a sampled input.

    Parameters
    ----------
    model : ContactDynamics
        Input and friction force are defined in it.
    signals : mapping of Symbol to Signal
        The sampled inputs.
    rows : sequence of Expr
        Observables.

    Raises
    ------
    NoRoute
        If the scene has another form; the message says why.
    """
    system, contacts = model.system, model.contacts
    if len(system.q) > 1 or system.z:
        raise NoRoute(f"{len(system.states)} states, the closed form is for one mass")
    if len(contacts) != 1 or len(signals) != 1:
        raise NoRoute(f"{len(contacts)} contacts and {len(signals)} inputs, the closed form is for one of each")
    (contact,), ((symbol, signal),) = contacts, signals.items()
    if signal.t0 != 0:
        raise NoRoute("the input does not start at t = 0")
    if signal.hold:
        raise NoRoute("the input is held from sample to sample, the closed form is for lines between samples")
    if contact.slip != system.u[0]:
        raise NoRoute("the floor moves; write the motion relative to it")
    law = lines_of(contact.law)
    if len(law) > 1 or not law[0][2].is_zero:
        raise NoRoute("the friction depends on the sliding speed")
    u, w = model.y[0], model.y[1]
    a, friction = ca.SX.sym("a"), ca.SX.sym("friction")
    model.define(symbol, a)
    if system.linear is not None:
        raise NoRoute("the equations are given by matrices")
    mass = model.read(system.mass[0, 0])
    refuse_if_moving(model, mass, "the mass changes")
    stiff, damp, gain, rest = plane(model, model.read(system.force[0]) / mass, [u, w, a], "the force")
    load = model.read(contact.normal)
    if ca.depends_on(load, ca.vertcat(model.y, model.t, a)):
        raise NoRoute("the normal load changes")
    numbers = [
        -damp,
        -stiff,
        gain,
        rest,
        load * model.read(law[0][1]) / mass,
        load * model.read(contact.law.stick) / mass,
    ]
    cells = profile_lines(contact.profile, system.q[0])
    for edges_and_line in cells:
        numbers += [ca.SX(float(e)) if e.is_infinite else model.read(e) for e in edges_and_line]
    model.define(friction_force(contact.name), mass * friction)
    model.define(slip(contact.name), w)
    for e in rows:
        numbers += plane(model, model.read(e), [u, w, friction, a], f"the output {e}")
    data = ca.Function("data", [model.p, ca.SX.sym("unused")], [ca.densify(ca.vertcat(*numbers))])
    return Record(data, model.parameters, signal, len(cells), len(rows))


def profile_lines(profile: sp.Expr, q: sp.Symbol) -> list[tuple[sp.Expr, sp.Expr, sp.Expr, sp.Expr]]:
    """Return for every cell of a profile, from left to right, its edges and the coefficients of ``mu + slope q``.

    Raises
    ------
    NoRoute
        If the profile is not made of straight lines over intervals of q.
    """
    whole = profile.replace(sp.Abs, lambda e: _folded(e, q))
    if isinstance(profile, sp.Add | sp.Mul) and whole.has(sp.Piecewise):
        whole = sp.piecewise_fold(whole)
    pieces = whole.args if isinstance(whole, sp.Piecewise) else [(whole, sp.true)]
    cells, edge = [], -sp.oo
    for line, condition in pieces:
        end = _upper_edge(condition, q)
        slope = sp.diff(line, q)
        if q in slope.free_symbols or line.has(sp.Piecewise, sp.Abs) or end is None:
            raise NoRoute("the profile of the friction is not made of straight lines from left to right")
        cells.append((edge, end, line.subs(q, 0), slope))
        edge = end
    return cells


def _folded(e: sp.Expr, q: sp.Symbol) -> sp.Expr:
    """Return the magnitude of ``q - c`` as branches from left to right."""
    if sp.diff(e, q) != 1:
        return sp.Abs(e)
    return sp.Piecewise((-e, q < q - e), (e, True))


def _upper_edge(condition: sp.Basic, q: sp.Symbol) -> sp.Expr | None:
    """Return the edge below which a branch holds, None if its condition has another form."""
    if condition == sp.true:
        return sp.oo
    if isinstance(condition, sp.StrictLessThan | sp.LessThan) and condition.lhs == q:
        return condition.rhs
    if isinstance(condition, sp.StrictGreaterThan | sp.GreaterThan) and condition.rhs == q:
        return condition.lhs
    return None
