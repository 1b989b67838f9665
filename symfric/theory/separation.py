"""Direct separation of motions: the slow scene under a fast harmonic force, with effective friction laws."""

from dataclasses import dataclass, replace
from typing import Any

import sympy as sp

from symfric.errors import SceneError
from symfric.locks import SYMBOLIC, alone
from symfric.long_calls import logged
from symfric.model.excitation import frequency_of
from symfric.model.in_plane import refuse_planes
from symfric.model.laws import Law
from symfric.model.outputs import OutputOfExpression
from symfric.model.scene import Scene, check_given_loads, check_scene
from symfric.model.symbols import SPEED, TIME
from symfric.model.system import Contact, System

_SIN, _COS = sp.Dummy("sin", real=True), sp.Dummy("cos", real=True)


@logged
@alone(SYMBOLIC)
def separate(scene: Scene) -> Scene:
    r"""Replace a fast harmonic force by its mean effect on the slow motion.

    Parameters
    ----------
    scene : Scene
        Constant mass matrix; forces hold any linear combination of sines and cosines of one frequency, in any
        coordinates, with amplitudes free of the states. Other forces may depend on velocities as polynomials.

    Returns
    -------
    Scene
        Without excitation; its states are the slow motion. Contacts that the force shakes carry ``law.averaged(q)``,
        q the amplitude of their fast slip: in the scene's symbols for polynomial laws, in numbers for others.

    Raises
    ------
    SceneError
        If there is no harmonic force, it has several frequencies or depends on the states, the mass matrix or a slip's
        direction changes with position, or a normal load depends on velocity or time.

    Notes
    -----
    With the force :math:`F_s\sin\Omega t + F_c\cos\Omega t` the fast velocity is
    :math:`M^{-1}(F_c\sin\Omega t - F_s\cos\Omega t)/\Omega`, and the slow motion starts from what it leaves of the
    given start; for one mass under :math:`a\Omega^2\sin\Omega t` this is Thomsen (37)-(42), q = a Omega. Errors are of
    order 1/Omega in velocities, with times of the slow motion as unit: the frequency has to be far above those of the
    scene.

    Examples
    --------
    >>> import symfric as sf
    >>> shaken = sf.scenes.mass_on_belt(v_b=0.2, a=0.01, Omega=50.0)
    >>> slow = sf.separate(shaken)
    >>> sf.stability(slow).stable
    True
    """
    check_scene(scene)
    scene = scene.written_out()
    fast = _harmonic_force(scene)
    system = scene.system
    velocity_sine, velocity_cosine = fast.velocity
    force = [_mean(e, f"force[{i}]", fast, system) for i, e in enumerate(fast.steady)]
    own = len(system.z) - system.made  # the scene takes the other rates from its contacts
    rates = [_mean(e, f"z_rate[{i}]", fast, system) for i, e in enumerate(system.z_rate[:own])]
    rates += system.z_rate[own:]
    refuse_planes(scene.contacts, "direct separation of motions")
    contacts = tuple(_effective(c, fast, scene) for c in scene.contacts)
    start = dict(scene.initial)
    for i, (q, u) in enumerate(zip(system.q, system.u, strict=True)):
        # at t = 0 the fast part of the velocity is its cosine, that of the position -(velocity's sine)/Omega
        start[u] = _plus(start[u], -velocity_cosine[i])
        start[q] = _plus(start[q], velocity_sine[i] / fast.frequency)
    slow = replace(system, force=force, z_rate=rates)
    return _rebuilt(scene, slow, contacts, start)


@dataclass(frozen=True, eq=False)
class HarmonicForce:
    """A harmonic force of one frequency.

    Attributes
    ----------
    frequency : Expr
    steady : tuple of Expr, length n
        The forces without the harmonic part.
    velocity : pair of Matrix (n, 1)
        Fast velocity as coefficients of sine and cosine.
    """

    frequency: sp.Expr
    steady: tuple[sp.Expr, ...]
    velocity: tuple[sp.Matrix, sp.Matrix]


def _harmonic_force(scene: Scene) -> HarmonicForce:
    """Split the forces into the steady part and the harmonic one."""
    system = scene.system
    if scene.clocks:
        raise SceneError("separate takes a scene without held variables and resets")
    check_given_loads(scene, "separate")
    values = {**scene.values, TIME: sp.Integer(0)}
    scene.numbers()
    for i, e in enumerate(system.z_rate):
        _refuse_time(e, f"z_rate[{i}]")
    if any(e.free_symbols & set(system.states) for e in system.mass):
        raise SceneError("the mass matrix depends on the position; separate takes a constant one")
    waves = set()
    for e in system.force:
        for piecewise in e.atoms(sp.Piecewise):
            if any(TIME in condition.free_symbols for _, condition in piecewise.args):
                raise SceneError(f"a force contains {piecewise}; separate takes time only in sin and cos, not in steps")
        waves |= {w for w in e.atoms(sp.sin, sp.cos) if TIME in w.free_symbols}
    rates = {_rate(w) for w in waves}
    if not rates:
        _refuse_any_time(system)
        raise SceneError("the scene has no harmonic excitation: no force contains sin or cos of a frequency times time")
    if len(rates) > 1:
        names = ", ".join(sorted(str(r) for r in rates))
        raise SceneError(f"the forces have the frequencies {names}; separate takes one, written with the same symbol")
    (frequency,) = rates
    steady, sine, cosine = zip(*(_split(e, i, frequency, system) for i, e in enumerate(system.force)), strict=True)
    if all(float(c.subs(values)) == 0 for c in (*sine, *cosine)):
        raise SceneError(
            "the harmonic excitation has amplitude zero; give it an amplitude and a frequency with where()"
        )
    if not abs(float(frequency.subs(values))) > 0:
        raise SceneError(f"the frequency {frequency} of the excitation is zero; give it a value with where()")
    inverse = system.mass.inv()
    fast = inverse * sp.Matrix(cosine) / frequency, -inverse * sp.Matrix(sine) / frequency
    return HarmonicForce(frequency, steady, tuple(m.applyfunc(sp.simplify) for m in fast))


def _rate(wave: sp.Expr) -> sp.Expr:
    """Return the frequency of sin or cos of an argument linear in time; SymPy keeps the sign of a symbol apart."""
    rate, others = frequency_of(wave, {TIME})
    if any(TIME in e.free_symbols for e in others) or rate.is_zero:
        raise SceneError(f"the excitation contains {wave}, whose argument is not linear in time")
    return -rate if rate.could_extract_minus_sign() else rate


def _split(force: sp.Expr, i: int, frequency: sp.Expr, system: System) -> Any:
    """Return the part of a force without time and its coefficients of sine and cosine."""

    def rewrite(wave: sp.Expr) -> sp.Expr:
        phase = sp.expand(wave.args[0])
        turn = 1 if (phase.diff(TIME) - frequency).is_zero or sp.simplify(phase.diff(TIME) - frequency) == 0 else -1
        shift = phase.subs(TIME, 0)
        if wave.func is sp.sin:
            return turn * _SIN * sp.cos(shift) + _COS * sp.sin(shift)
        return _COS * sp.cos(shift) - turn * _SIN * sp.sin(shift)

    flat = force.replace(lambda e: e.func in (sp.sin, sp.cos) and TIME in e.free_symbols, rewrite)
    sine, cosine = sp.diff(flat, _SIN), sp.diff(flat, _COS)
    steady = flat.subs({_SIN: 0, _COS: 0})
    for e in (sine, cosine):
        moving = sorted((e.free_symbols & {*system.states}), key=str)
        if moving:
            raise SceneError(
                f"the excitation in force[{i}] is multiplied by a function of {moving[0]}; separate takes forces only"
            )
        if e.free_symbols & {_SIN, _COS, TIME}:
            raise SceneError(
                f"force[{i}] is {force}; separate takes a linear combination of sin and cos of one frequency"
            )
    _refuse_time(steady, f"force[{i}]")
    return steady, sine, cosine


def _refuse_time(expr: sp.Expr, what: str) -> None:
    if TIME in expr.free_symbols:
        raise SceneError(f"{what} is {expr}; separate takes time only in sin and cos of one frequency in the forces")


def _refuse_any_time(system: System) -> None:
    for i, e in enumerate(system.force):
        _refuse_time(e, f"force[{i}]")


def _mean(expr: sp.Expr, what: str, fast: HarmonicForce, system: System) -> sp.Expr:
    """Average a force over the fast velocities; positions change by O(1/Omega) only."""
    shaken = [i for i, u in enumerate(system.u) if not (fast.velocity[0][i].is_zero and fast.velocity[1][i].is_zero)]
    shaken = [i for i in shaken if system.u[i] in expr.free_symbols]
    if not shaken or all(_linear(expr, [system.u[i] for i in shaken])):
        return expr
    velocities = [system.u[i] for i in shaken]
    if not expr.is_polynomial(*velocities):
        raise SceneError(
            f"{what} is {expr}, no polynomial of {velocities[0]}; separate averages forces that are polynomials of the "
            "velocities"
        )
    moved = expr.subs(
        {
            u: u + fast.velocity[0][i] * _SIN + fast.velocity[1][i] * _COS
            for i, u in zip(shaken, velocities, strict=True)
        },
        simultaneous=True,
    )
    total = sp.Integer(0)
    for (m, n), coefficient in sp.Poly(sp.expand(moved), _SIN, _COS).terms():
        if m % 2 == 0 and n % 2 == 0:
            total += coefficient * sp.factorial2(m - 1) * sp.factorial2(n - 1) / sp.factorial2(m + n)
    return sp.expand(total)


def _linear(expr: sp.Expr, velocities: list[sp.Symbol]) -> Any:
    """Yield whether the second derivatives with respect to the velocities vanish."""
    for u in velocities:
        slope = expr.diff(u)
        yield all(slope.diff(w).is_zero for w in velocities)


def _effective(contact: Contact, fast: HarmonicForce, scene: Scene) -> Contact:
    """Return the contact with its law averaged over its fast slip."""
    q = _fast_slip(contact, fast, scene.system)
    if q.is_zero:
        return contact
    if contact.normal.free_symbols & set(scene.system.u):
        raise SceneError(
            f"normal of contact {contact.name!r} depends on velocity, which shakes; separate takes other loads"
        )
    return replace(contact, law=_averaged(contact.law, q, scene))


@alone(SYMBOLIC)
def fast_slips(scene: Scene) -> dict[str, sp.Expr]:
    """Return the amplitude of the fast slip of each contact, in the scene's symbols.

    Raises
    ------
    SceneError
        As `separate`.
    """
    fast = _harmonic_force(scene)
    return {c.name: _fast_slip(c, fast, scene.system) for c in scene.contacts}


def _fast_slip(contact: Contact, fast: HarmonicForce, system: System) -> sp.Expr:
    laws = [("law", e) for e in contact.law.expressions]
    for what, expr in (("slip", contact.slip), ("normal", contact.normal), *laws):
        if TIME in expr.free_symbols:
            raise SceneError(
                f"{what} of contact {contact.name!r} depends on time; separate takes time in the forces only"
            )
    directions = sp.Matrix([[contact.slip.diff(u) for u in system.u]])
    sine, cosine = ((directions * v)[0] for v in fast.velocity)
    if (sine.free_symbols | cosine.free_symbols) & set(system.states):
        raise SceneError(
            f"the fast slip of contact {contact.name!r} depends on the position; separate takes a constant one"
        )
    single = sine.is_zero or cosine.is_zero
    return sp.Abs(sine + cosine) if single else sp.sqrt(sine**2 + cosine**2)


def _averaged(law: Law, q: sp.Expr, scene: Scene) -> Law:
    if not law.breaks and law.kinetic.is_polynomial(SPEED):
        return law.averaged(q)
    values = scene.parameter_values()
    return law.where(values).averaged(float(q.subs(values)))


def _plus(value: Any, change: sp.Expr) -> Any:
    if change.is_zero:
        return value
    return sp.sympify(value) + change if not (isinstance(value, float) and value == 0) else change


def _rebuilt(scene: Scene, system: System, contacts: tuple[Contact, ...], start: dict[Any, Any]) -> Scene:
    """Return the scene with only the values that its expressions use."""
    used = set().union(*(e.free_symbols for e in system.expressions), *(c.free_symbols for c in contacts))
    used = used.union(*(v.free_symbols for v in start.values() if isinstance(v, sp.Expr)))
    outputs = [o.expr.free_symbols for o in scene.outputs.values() if isinstance(o, OutputOfExpression)]
    used = used.union(*outputs)
    values = {k: v for k, v in scene.values.items() if k in used}
    inputs = {k: s for k, s in scene.inputs.items() if k in used}
    return replace(scene, system=system, contacts=contacts, values=values, initial=start, inputs=inputs)
