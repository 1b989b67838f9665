"""Reading the one kind of scene that `quench` designs for: one mass, one belt, one fast harmonic force."""

from dataclasses import dataclass, replace

import sympy as sp

from symfric.errors import SceneError
from symfric.model import laws
from symfric.model.laws import Law
from symfric.model.names import TIME, name_of
from symfric.model.outputs import End
from symfric.model.scene import Scene
from symfric.theory.separation import separate

SPEED_NAME, AMPLITUDE, FREQUENCY = "v_b", "a", "Omega"


@dataclass(frozen=True, eq=False)
class Belt:
    """``m x'' + c x' + k x + N mu(x' - v_b) = F(a, Omega, t)`` in numbers.

    Attributes
    ----------
    scene : Scene
        The one given.
    mass, damping, stiffness, normal : float
        m, c, k > 0 and N, the last with the contact's profile.
    law : Law
        In numbers.
    gain : float
        Amplitude of the fast slip over ``a Omega``; 1 for `symfric.scenes.mass_on_belt`.
    start : tuple of Expr
        Fast part of position and velocity at t = 0, in a and Omega.
    """

    scene: Scene
    mass: float
    damping: float
    stiffness: float
    normal: float
    law: Law
    gain: float
    start: tuple[sp.Expr, sp.Expr]

    @property
    def frequency(self) -> float:
        """Natural frequency, rad/time."""
        return (self.stiffness / self.mass) ** 0.5

    def fast_start(self, a: float, Omega: float) -> tuple[float, float]:
        """Return the fast part of position and velocity at t = 0."""
        at = {self.scene.parameter(AMPLITUDE): a, self.scene.parameter(FREQUENCY): Omega}
        x, u = (float(e.subs(at)) for e in self.start)
        return x, u


def read_belt(scene: Scene) -> Belt:
    """Read a scene with the parameters v_b, a and Omega.

    Raises
    ------
    SceneError
        If it is no mass on a belt with linear spring and damper under a harmonic force proportional to ``a Omega^2``.
    """
    if not isinstance(scene, Scene):
        raise SceneError(f"{scene!r} is no sf.Scene; quench takes sf.scenes.mass_on_belt(...) and scenes like it")
    _check_shape(scene)
    named = {s.name: s for s in scene.values}
    designed = {named[n] for n in (SPEED_NAME, AMPLITUDE, FREQUENCY)}
    given = {k: v for k, v in scene.values.items() if k not in designed}
    for k, v in given.items():
        if v is None:
            raise SceneError(f"no value for {k.name}; add it to Scene.values, or scene.where({{'{k.name}': ...}})")
    (contact,) = scene.contacts
    slow = _slow(scene, designed)
    (x,), (u,), (force,) = scene.system.q, scene.system.u, slow.system.force
    numbers = {
        "the mass": scene.system.mass[0],
        "the damping": -force.diff(u),
        "the stiffness": -force.diff(x),
        "the normal load with its profile": contact.normal * contact.profile,
    }
    mass, damping, stiffness, normal = (_constant(e, given, what) for what, e in numbers.items())
    if not stiffness > 0:
        raise SceneError(
            f"the stiffness is {stiffness:g}; quench needs a spring, so that there is something to vibrate"
        )
    if not normal > 0:
        raise SceneError(f"the normal load of contact {contact.name!r} is {normal:g}; without it nothing rubs")
    (q,) = slow.contacts[0].law.breaks
    start = tuple(sp.sympify(-slow.initial[s]).subs(given) for s in (x, u))
    law = contact.law.where({k: v for k, v in given.items() if k in contact.law.free_symbols})
    if law.free_symbols:
        names = ", ".join(sorted(s.name for s in law.free_symbols))
        raise SceneError(f"the law of contact {contact.name!r} depends on {names}; quench needs it in numbers")
    return Belt(scene, mass, damping, stiffness, normal, law, _gain(q, given, named), start)


def _check_shape(scene: Scene) -> None:
    system = scene.system
    if len(system.q) != 1 or system.z or len(scene.contacts) != 1:
        raise SceneError(
            f"the scene has {len(system.q)} coordinates, {len(system.z)} first-order states and {len(scene.contacts)} "
            "contacts; quench takes one mass with one contact"
        )
    if scene.inputs:
        raise SceneError(f"the scene has the sampled input {next(iter(scene.inputs)).name}; quench takes none")
    names = [s.name for s in scene.values]
    roles = {SPEED_NAME: "the belt speed", AMPLITUDE: "the amplitude", FREQUENCY: "the frequency of the excitation"}
    for name, role in roles.items():
        if name not in names:
            raise SceneError(
                f"the scene has no parameter {name}, {role}; quench takes scenes with v_b, a and Omega, as "
                "sf.scenes.mass_on_belt has them"
            )
    (contact,), (u,) = scene.contacts, system.u
    v_b = scene.parameter(SPEED_NAME)
    if sp.expand(contact.slip - (u - v_b)) != 0 and sp.expand(contact.slip + (u - v_b)) != 0:
        raise SceneError(f"the slip of contact {contact.name!r} is {contact.slip}; quench takes {u} - {v_b}")


def _slow(scene: Scene, designed: set[sp.Symbol]) -> Scene:
    """Separate the motions with the simplest law, which shows the intensity in its break."""
    contact = replace(scene.contacts[0], law=laws.coulomb(1), normal=1, profile=1)
    used = set().union(contact.free_symbols, *(e.free_symbols for e in scene.system.expressions))
    for s in designed:
        if s not in used:
            raise SceneError(f"no force and no slip contains {name_of(s)}; quench varies it")
    values = {k: 1.0 if k in designed else v for k, v in scene.values.items() if k in used}
    still = dict.fromkeys(scene.system.states, 0.0)
    return separate(Scene(scene.system, [contact], values, still, scene.horizon, {"end": End()}))


def _constant(expr: sp.Expr, given: dict, what: str) -> float:
    value = sp.simplify(expr.subs(given))
    if not value.is_number:
        moving = ", ".join(sorted(s.name for s in value.free_symbols))
        what_now = "time" if TIME in value.free_symbols else moving
        raise SceneError(f"{what} depends on {what_now}; quench takes a linear spring and damper and a constant load")
    return float(value)


def _gain(q: sp.Expr, given: dict, named: dict) -> float:
    """Return the amplitude of the fast slip over a Omega."""
    a, Omega = sp.symbols("a Omega", positive=True)
    ratio = sp.simplify(q.subs(given).subs({named[AMPLITUDE]: a, named[FREQUENCY]: Omega}) / (a * Omega))
    if not ratio.is_number:
        raise SceneError(
            f"the fast velocity is {q}, not proportional to a*Omega; write the force as a*Omega**2*sin(...)"
        )
    return float(ratio)
