"""Van der Pol averaging of one coordinate about steady sliding: amplitude rate and stationary amplitudes."""

from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import sympy as sp

from symfric.errors import NotFound, SceneError
from symfric.locks import SYMBOLIC, alone
from symfric.long_calls import logged
from symfric.model.arguments import is_one_of
from symfric.model.numeric import numeric
from symfric.model.scene import Scene, check_given_loads, check_scene
from symfric.model.symbols import SPEED, shortened
from symfric.model.system import Contact
from symfric.theory.equilibrium import rests_smoothly, solve
from symfric.theory.harmonics import Arc, arc_mean, ranges
from symfric.theory.sliding import branches, field_of
from symfric.theory.slow_flow import SlowFlow, stationary

AMPLITUDE = sp.Symbol("A", positive=True)


@logged
@alone(SYMBOLIC)
def average(scene: Scene, order: int = 1) -> SlowFlow:
    r"""Average the motion of one coordinate about steady sliding over its period.

    Parameters
    ----------
    scene : Scene
        One coordinate with constant mass and a restoring stiffness; damping, friction and everything else is taken
        as small beside them. Slips depend on the velocity only. A contact without sliding speed (a free oscillator on
        a floor) is averaged about the middle of its band of rest.
    order : {1, 2}
        1: any law, also where the mass overhauls the contact. 2: forces and laws that are polynomials in pure slip.

    Returns
    -------
    SlowFlow
        In the scene's symbols; in numbers where the law has branches or the equilibrium no closed form.

    Raises
    ------
    SceneError
        If the scene has several coordinates, first-order states, a time-dependent force, or a force outside the order.
    NotFound
        If steady sliding does not exist or has no restoring stiffness.

    Notes
    -----
    With :math:`x = \bar x + A\sin\psi`, :math:`x' = \omega A\cos\psi` and the rest of the acceleration -h,
    :math:`A' = -\langle h\cos\psi\rangle/\omega`, :math:`\psi' = \omega + \langle h\sin\psi\rangle/(\omega A)`:
    Thomsen (11)-(13). The integrals are split where the slip velocity changes its sign, as in Thomsen (45), (46);
    sticking, which then fills a part of the period, is an effect of first order. Order 2 carries the expansion of
    Krylov, Bogoliubov and Mitropolsky as far as relative errors of second order in the amplitude need.

    Examples
    --------
    >>> import symfric as sf
    >>> belt = sf.scenes.mass_on_belt(v_b=0.2)
    >>> sf.average(belt)
    SlowFlow(order 1; stationary amplitudes: 0.20106 stable)
    """
    if not is_one_of(order, (1, 2)):
        raise SceneError(f"order is {shortened(order)}; averaging is carried to order 1 or 2")
    oscillator = _oscillator(scene)
    if order == 2:
        from symfric.theory.second_order import second_order

        return second_order(oscillator)
    return _first_order(oscillator)


@dataclass(frozen=True, eq=False)
class Friction:
    """Friction of one contact in an oscillator, with slip ``side (W + V cos theta)``, ``V = |J| omega A``.

    Attributes
    ----------
    contact : Contact
    W, pull : Expr
        Sliding speed and |J|, both >= 0.
    flip : int
        ``cos psi = flip cos theta``.
    """

    contact: Contact
    W: sp.Expr
    pull: sp.Expr
    flip: int


@dataclass(frozen=True, eq=False)
class AveragedOscillator:
    """A scene of one coordinate about steady sliding, in symbols or numbers.

    Attributes
    ----------
    q, u : Symbol
    position, omega, mass : Expr
        Of the equilibrium, natural frequency, mass.
    force : Expr
        Force without the contacts, in q and u.
    frictions : tuple of Friction
    values : dict of Symbol to float
        Of the parameters that remain.
    """

    q: sp.Symbol
    u: sp.Symbol
    position: sp.Expr
    omega: sp.Expr
    mass: sp.Expr
    force: sp.Expr
    frictions: tuple[Friction, ...]
    values: dict[sp.Symbol, float]

    @property
    def rest(self) -> sp.Expr:
        """The small part -h of the acceleration without friction, with q measured from the equilibrium."""
        return (self.force.subs(self.q, self.position + self.q) / self.mass + self.omega**2 * self.q).expand()


def _oscillator(scene: Scene) -> AveragedOscillator:
    """Check the scene, find its equilibrium and split it into oscillator and rest."""
    check_scene(scene)
    check_given_loads(scene, "averaging")
    scene = scene.written_out()
    system = scene.system
    if len(system.q) != 1 or system.z:
        raise SceneError(
            f"the scene has {len(system.states)} states; averaging takes one coordinate and its velocity "
            "(use sf.hopf for the onset of vibration in larger scenes)"
        )
    field = field_of(scene)
    (q,), (u,), system = system.q, system.u, field.system
    _refuse_kinks(system.force[0], "force[0]")
    if q in system.mass[0].free_symbols:
        raise SceneError(f"the mass is {system.mass[0]}; averaging takes a constant mass")
    contacts = [_checked(c, q, u) for c in field.contacts]
    values = scene.parameter_values()
    sliding = tuple(c for c in contacts if not (c.slip.subs(u, 0).is_zero and not rests_smoothly(c.law, values)))
    balanced = field_of(replace(scene.wanting({}), contacts=sliding, values=_used(scene, sliding)))
    start = np.array([scene.numbers()[s] for s in (q, u)])
    x = solve(balanced, balanced.vector(values), start)
    signs = dict(zip(balanced.signs, map(int, balanced.directions(x, balanced.vector(values))), strict=True))
    total = balanced.parts[0].subs(signs).subs(u, 0)
    numbers = {k: sp.Float(v) for k, v in values.items()}
    symbolic = not any(c.law.breaks for c in contacts) and not total.has(sp.Integral)
    line = sp.expand(total)
    if symbolic and line.is_polynomial(q) and sp.degree(line, q) < 2:
        numbers = {}
        stiffness, position = -line.coeff(q, 1), line.coeff(q, 0)
        position = sp.Integer(0) if position.is_zero else position / stiffness
    elif symbolic and line.subs(q, 0).is_zero and abs(x[0]) <= 1e-12 * abs(start[0]):
        numbers, position = {}, sp.Integer(0)
        stiffness = -line.diff(q).subs(q, 0)
    else:
        total = total.subs(numbers)
        position = sp.Float(float(x[0]))
        stiffness = -total.diff(q).subs(q, position).doit()
    mass = system.mass[0].subs(numbers)
    _check_stiffness(stiffness, scene)
    frictions = tuple(_friction(c, u, numbers, scene) for c in contacts)
    force = system.force[0].subs(numbers)
    remaining = {} if numbers else values
    return AveragedOscillator(q, u, position, sp.sqrt(stiffness / mass), mass, force, frictions, remaining)


def _used(scene: Scene, contacts: tuple[Contact, ...]) -> dict[sp.Symbol, float | None]:
    known = set().union(*(e.free_symbols for e in scene.system.expressions), *(c.free_symbols for c in contacts))
    starts = [v.free_symbols for v in scene.initial.values() if isinstance(v, sp.Expr)]
    known = known.union(*starts)
    return {k: v for k, v in scene.values.items() if k in known}


def _checked(contact: Contact, q: sp.Symbol, u: sp.Symbol) -> Contact:
    if q in contact.slip.free_symbols:
        raise SceneError(
            f"slip of contact {contact.name!r} is {contact.slip}; averaging takes slips that depend on u only"
        )
    _refuse_kinks(contact.normal * contact.profile, f"normal or profile of contact {contact.name!r}")
    return contact


def _refuse_kinks(expr: sp.Expr, what: str) -> None:
    if expr.has(sp.Abs, sp.Max, sp.Min, sp.Piecewise):
        raise SceneError(f"{what} is {expr}; averaging takes forces without kinks (sf.limit_cycle takes any)")


def _check_stiffness(stiffness: sp.Expr, scene: Scene) -> None:
    value = float(stiffness.subs(scene.values))
    if not value > 0:
        raise NotFound(f"the stiffness at the equilibrium is {value:.6g}; averaging needs a restoring one")


def _friction(contact: Contact, u: sp.Symbol, numbers: dict[Any, Any], scene: Scene) -> Friction:
    slip = sp.expand(contact.slip).subs(numbers)
    J, w = slip.coeff(u, 1), slip.coeff(u, 0)
    turn = -1 if float(J.subs(scene.values)) < 0 else 1
    side = -1 if float(w.subs(scene.values)) < 0 else 1
    loaded = replace(
        contact,
        law=contact.law.where(numbers) if numbers else contact.law,
        normal=contact.normal.subs(numbers),
        profile=contact.profile.subs(numbers),
    )
    return Friction(loaded, side * w, turn * J, side * turn)


def _first_order(o: AveragedOscillator) -> SlowFlow:
    A = AMPLITUDE
    sine_part, cosine_part = (_smooth_mean(o, weight) for weight in (0, 1))
    edges, positive = [], []
    for friction in o.frictions:
        edge, sine, cosine = _friction_means(o, friction)
        edges += edge
        sine_part, cosine_part = sine_part + sine, cosine_part + cosine
        positive += [] if friction.W.is_zero else [friction.W]
        positive.append(friction.pull)
    rate = cosine_part / o.omega
    frequency = o.omega - sine_part / (o.omega * A)
    rate, frequency = (_tidy(e) for e in (rate, frequency))
    evaluate = numeric((A, *o.values), (rate,))
    numbers = tuple(o.values.values())
    limits = tuple(float(e.subs(o.values)) for e in edges)
    amplitudes, stable = stationary(lambda a: evaluate(a, *numbers)[0], limits)
    return SlowFlow(A, rate, frequency, amplitudes, stable, 1, dict(o.values), tuple(positive))


def _tidy(expr: sp.Expr) -> sp.Expr:
    """Expand polynomials; integrals and branches are left unchanged."""
    return sp.expand(expr) if not expr.has(sp.Integral) else expr


def _smooth_mean(o: AveragedOscillator, weight: int) -> sp.Expr:
    """Return the mean of the acceleration -h without friction times sin psi (weight 0) or cos psi (weight 1)."""
    A = AMPLITUDE

    def body(_: Any, sine: sp.Expr, cosine: sp.Expr) -> Any:
        rest = o.rest.subs({o.q: A * sine, o.u: o.omega * A * cosine}, simultaneous=True)
        return sp.expand(rest * (cosine if weight else sine))

    whole = Arc(sp.Integer(0), sp.pi, sp.Integer(0), 1)
    return arc_mean(body, whole, sp.Integer(0), sp.Integer(0))


def _friction_means(o: AveragedOscillator, friction: Friction) -> Any:
    """Return the amplitudes at which the formula changes, and the two means of the acceleration by friction."""
    A, contact = AMPLITUDE, friction.contact
    V = friction.pull * o.omega * A
    load = contact.normal * contact.profile * friction.pull / o.mass
    load = load.subs(o.q, o.position + o.q)

    def body(weight: Any) -> Any:
        def integrand(law: sp.Expr, sine: sp.Expr, cosine: sp.Expr) -> sp.Expr:
            at = {o.q: A * friction.flip * sine, o.u: o.omega * A * friction.flip * cosine}
            product = -load.subs(at, simultaneous=True) * law * (cosine if weight else sine)
            return sp.expand(product) if product.is_polynomial(sine, cosine) else product

        return integrand

    kinetic = branches(contact.law.kinetic, (SPEED,))
    parts: tuple[list[Any], list[Any]] = ([], [])
    edges: list[sp.Expr] = []
    for top, arcs in ranges(kinetic, contact.law.breaks, friction.W, V):
        edge = top / (friction.pull * o.omega) if top != sp.oo else sp.oo
        for weight in (0, 1):
            mean = sp.Add(*(arc_mean(body(weight), arc, friction.W, V) for arc in arcs))
            parts[weight].append((_tidy(mean), edge > A if edge != sp.oo else True))
        edges += [] if edge == sp.oo else [edge]
    sine, cosine = (sp.Piecewise(*p) if len(p) > 1 else p[0][0] for p in parts)
    return edges, sine, cosine
