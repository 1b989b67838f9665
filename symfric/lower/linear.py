"""What is linear between events, found out once and written down as numbers that follow from the parameters.

A kink is a choice by the mode, so a force with an `Abs` or a law of straight lines is linear in every mode.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import casadi as ca
import sympy as sp

from symfric.errors import NoRoute
from symfric.lower.automaton import Automaton, Lowering, constants
from symfric.model.laws import Law
from symfric.model.names import SPEED
from symfric.model.outputs import friction_force, slip
from symfric.model.scene import Scene


@dataclass(frozen=True)
class Oscillator:
    """One mass without drive, with one contact at the most, as numbers.

    Attributes
    ----------
    data : casadi.Function
        ``(p, unused) -> numbers``: a_x, a_u, a_0 (the acceleration without friction is a_x x + a_u u + a_0), J/m, J and
        c (the slip is J u + c), load, static coefficient; for each branch of the law the speed where it ends and the
        two numbers of ``mu_0 + mu_1 v``; for each wanted row its value at 0 and its slopes in x, u and the friction.
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


def oscillator(scene: Scene, rows: Sequence[sp.Expr] = (), varied: frozenset[str] = frozenset()) -> Oscillator:
    """Write a scene down as one oscillator.

    Parameters
    ----------
    scene : Scene
    rows : sequence of Expr
        Expressions of which extremes are wanted.
    varied : frozenset of str
        Parameters that will change although they are exactly zero; see `symfric.lower.automaton.constants`.

    Raises
    ------
    NoRoute
        If the scene is something else; the message says what.
    """
    system, contacts = scene.system, scene.contacts
    if len(system.q) > 1 or system.z:
        raise NoRoute(f"{len(system.states)} states, the closed form is for one mass")
    if len(contacts) > 1:
        raise NoRoute(f"{len(contacts)} contacts, the closed form is for one")
    if scene.inputs:
        raise NoRoute("a sampled input")
    lines = [line for c in contacts for line in _lines(c.law)]
    low = Lowering(scene, constants(scene, varied))
    x, u = low.y[0], low.y[1]
    force, mass = low.sx(system.force[0]), low.sx(system.mass[0, 0])
    _refuse(low, mass, "the mass changes")
    a_x, a_u, a_0 = _plane(low, force / mass, [x, u], "the force")
    numbers = [a_x, a_u, a_0]
    if contacts:
        numbers += _contact(low, mass, lines)
    friction = ca.SX.sym("friction")
    for c in contacts:
        low.symbols[friction_force(c.name)], low.symbols[slip(c.name)] = friction, low.w[0]
        low.moving |= {friction_force(c.name), slip(c.name)}
    for e in rows:
        *slopes, rest = _plane(low, low.sx(e), [x, u, friction], f"the output {e}")
        numbers += [rest, *slopes]
    data = ca.Function("data", [low.p, ca.SX.sym("unused")], [ca.densify(ca.vertcat(*numbers))])
    sticks = any(not c.law.smooth for c in contacts)
    return Oscillator(data, low.parameters, len(lines), sticks, len(rows))


def _contact(low: Lowering, mass: ca.SX, lines: list[tuple[sp.Expr, sp.Expr, sp.Expr]]) -> list[ca.SX]:
    """Return the numbers of the contact."""
    (contact,) = low.scene.contacts
    J, c = _plane(low, low.w[0], [low.y[1]], "the slip")
    _refuse(low, low.load, "the normal load changes")
    numbers = [J / mass, J, c, low.load[0], low.sx(contact.law.stick)]
    for line in lines:
        numbers += [low.sx(e) for e in line]
    return numbers


def _plane(low: Lowering, e: ca.SX, variables: list[ca.SX], what: str) -> list[ca.SX]:
    """Return the slopes of a linear expression in the variables, and its value where they are zero."""
    v, signs = ca.vertcat(*variables), ca.vertcat(*low.switches.signs)
    slopes = ca.densify(ca.jacobian(e, v))
    rest = ca.substitute(e, v, ca.SX.zeros(v.numel()))
    if ca.depends_on(e, signs):
        raise NoRoute(f"{what} has a kink")
    if any(ca.depends_on(slopes, m) for m in (low.y, low.t, v)):
        raise NoRoute(f"{what} is not linear")
    if ca.depends_on(rest, low.t):
        raise NoRoute(f"{what} depends on time")
    if ca.depends_on(rest, low.y):
        raise NoRoute(f"{what} depends on the position")
    return [*ca.horzsplit(slopes), rest]


def _refuse(low: Lowering, e: ca.SX, what: str) -> None:
    if ca.depends_on(e, ca.vertcat(low.y, low.t, *low.switches.signs)):
        raise NoRoute(what)


def _lines(law: Law) -> list[tuple[sp.Expr, sp.Expr, sp.Expr]]:
    """Return for every branch of a law the speed where it ends, and the two numbers of ``mu_0 + mu_1 v``."""
    kinetic = law.kinetic
    if kinetic.has(sp.Integral):
        raise NoRoute("the friction law is a mean over fast vibration, not straight lines")
    pieces = kinetic.args if isinstance(kinetic, sp.Piecewise) else [(kinetic, sp.true)]
    found = []
    for k, (e, condition) in enumerate(pieces):
        end = law.breaks[k] if k < len(pieces) - 1 and k < len(law.breaks) else sp.oo
        slope = sp.diff(e, SPEED)
        if SPEED in slope.free_symbols or e.has(sp.Abs, sp.Max, sp.Min, sp.Piecewise):
            raise NoRoute("the friction law is not made of straight lines")
        if condition != sp.true and condition not in (SPEED < end, end > SPEED, SPEED <= end, end >= SPEED):
            raise NoRoute("the branches of the friction law do not follow its breaks")
        found.append((end, e.subs(SPEED, 0), slope))
    return found


def why_not_linear(automaton: Automaton) -> str:
    """Return what keeps the scene from being linear in the state in every mode; empty if nothing does."""
    field = automaton.field
    arguments = [ca.SX.sym(name, field.nnz_in(i)) for i, name in enumerate(field.name_in())]
    y, t = arguments[:2]
    rate, guards, _ = field(*arguments)
    for e, what in ((rate, "the forces or a friction law are"), (guards, "a guard is")):
        if ca.depends_on(ca.jacobian(e, y), ca.vertcat(y, t)):
            return f"{what} not linear between events"
    return ""
