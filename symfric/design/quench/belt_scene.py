"""Recognise the scenes that `quench` accepts: one mass on one belt with a fast harmonic force.

Several contacts between mass and belt, such as pads on a disc, are replaced by one with the sum of their friction.
"""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any, TypeAlias

import sympy as sp

from symfric.errors import SceneError
from symfric.locks import SYMBOLIC, alone
from symfric.model import laws
from symfric.model.in_plane import refuse_planes
from symfric.model.laws import Law
from symfric.model.outputs import End
from symfric.model.scene import Scene, check_given_loads, check_scene
from symfric.model.symbols import TIME, name_of
from symfric.theory.separation import separate

Given: TypeAlias = Mapping[sp.Symbol, Any]  # value of each parameter that is not designed
SPEED_NAME, AMPLITUDE, FREQUENCY = "v_b", "a", "Omega"
RATIOS = ("k", "k_v", "k_follow")  # names of a Omega/v_b where the excitation follows; the first that is free


@dataclass(frozen=True, eq=False)
class Belt:
    """``m x'' + c x' + k x + N mu(x' - v_b) = F(a, Omega, t)`` in numbers.

    Attributes
    ----------
    scene : Scene
        The given scene.
    mass, damping, stiffness, normal : float
        m, c, k > 0 and N, the last with the contact's profile; of several contacts the sum.
    law : Law
        In numbers; of several contacts ``sum N_i mu_i / sum N_i``.
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
    def single(self) -> Scene:
        """The scene with one equivalent contact: simultaneous events of several contacts have no derivatives."""
        if len(self.scene.contacts) == 1:
            return self.scene
        scene = self.scene.wanting({"end": End()})
        contact = replace(scene.contacts[0], normal=self.normal, profile=1, law=self.law)
        starts = (sp.sympify(e) for e in scene.initial.values())
        used = contact.free_symbols.union(*(e.free_symbols for e in (*scene.system.expressions, *starts)))
        return replace(scene, contacts=(contact,), values={k: v for k, v in scene.values.items() if k in used})

    @property
    def ratio(self) -> str:
        """Name of a Omega over v_b where the excitation follows the belt speed."""
        taken = {s.name for s in self.scene.values}
        return next(name for name in RATIOS if name not in taken)

    @property
    def frequency(self) -> float:
        """Natural frequency, rad/time."""
        return float((self.stiffness / self.mass) ** 0.5)

    @alone(SYMBOLIC)
    def fast_start(self, a: float, Omega: float) -> tuple[float, float]:
        """Return the fast part of position and velocity at t = 0."""
        at = {self.scene.parameter(AMPLITUDE): a, self.scene.parameter(FREQUENCY): Omega}
        x, u = (float(e.subs(at)) for e in self.start)
        return x, u


@alone(SYMBOLIC)
def read_belt(scene: Scene) -> Belt:
    """Read a scene with the parameters v_b, a and Omega.

    Raises
    ------
    SceneError
        If it is no mass on a belt with linear spring and damper under a harmonic force proportional to ``a Omega^2``,
        or if one of several contacts slips otherwise than ``u - v_b``.
    """
    check_scene(scene)
    check_given_loads(scene, "quench")
    scene = scene.written_out()
    _check_shape(scene)
    named = {s.name: s for s in scene.values}
    designed = {named[n] for n in (SPEED_NAME, AMPLITUDE, FREQUENCY)}
    given = {k: v for k, v in scene.values.items() if k not in designed}
    for k, v in given.items():
        if v is None:
            raise SceneError(f"no value for {k.name}; add it to Scene.values, or scene.where({{'{k.name}': ...}})")
    slow = _slow(scene, designed)
    (x,), (u,), (force,) = scene.system.q, scene.system.u, slow.system.force
    numbers = {
        "the mass": scene.system.mass[0],
        "the damping": -force.diff(u),
        "the stiffness": -force.diff(x),
    }
    mass, damping, stiffness = (_constant(e, given, what) for what, e in numbers.items())
    if not stiffness > 0:
        raise SceneError(f"the stiffness is {stiffness:g}; quench needs a positive one")
    normal, law = _together(scene, given)
    (q,) = slow.contacts[0].law.breaks
    start = tuple(sp.sympify(-slow.initial[s]).subs(given) for s in (x, u))
    return Belt(scene, mass, damping, stiffness, normal, law, _gain(q, given, named), start)


def _together(scene: Scene, given: Given) -> tuple[float, Law]:
    """Return load and law of the single contact that is equivalent to all contacts."""
    loads, frictions = [], []
    for contact in scene.contacts:
        what = f"the normal load of contact {contact.name!r}, with its profile,"
        loads.append(_constant(contact.normal * contact.profile, given, what))
        if loads[-1] < 0 or (loads[-1] == 0 and len(scene.contacts) == 1):
            raise SceneError(f"{what} is {loads[-1]:g}; it must be positive, or there is no friction")
        law = contact.law.where({k: v for k, v in given.items() if k in contact.law.free_symbols})
        if law.free_symbols:
            names = ", ".join(sorted(s.name for s in law.free_symbols))
            raise SceneError(f"the law of contact {contact.name!r} depends on {names}; quench needs it in numbers")
        frictions.append(law)
    normal = sum(loads)
    if not normal > 0:
        raise SceneError("the normal loads of all contacts are 0; at least one must be positive")
    if len(frictions) == 1:
        return normal, frictions[0]
    parts = [(load / normal, law) for load, law in zip(loads, frictions, strict=True) if load > 0]
    breaks, steep = ({b for _, law in parts for b in getattr(law, name)} for name in ("breaks", "steep"))
    together = Law(
        kinetic=sum((share * law.kinetic for share, law in parts), sp.Integer(0)),
        stick=sum((share * law.stick for share, law in parts), sp.Integer(0)),
        breaks=tuple(_apart(breaks)),
        steep=tuple(_apart(steep)),
    )
    return normal, together


def _apart(speeds: set[sp.Expr]) -> list[sp.Expr]:
    """Return sorted numbers without those that are equal up to rounding."""
    return [e for _, e in sorted({float(e): e for e in speeds}.items())]


def _check_shape(scene: Scene) -> None:
    system = scene.system
    if len(system.q) != 1 or system.z or not scene.contacts:
        raise SceneError(
            f"the scene has {len(system.q)} coordinates, {len(system.z)} first-order states and {len(scene.contacts)} "
            "contacts; quench takes one mass with contacts on one belt"
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
    (u,), v_b = system.u, scene.parameter(SPEED_NAME)
    refuse_planes(scene.contacts, "quench")
    for contact in scene.contacts:
        if sp.expand(contact.slip - (u - v_b)) != 0 and sp.expand(contact.slip + (u - v_b)) != 0:
            raise SceneError(
                f"the slip of contact {contact.name!r} is {contact.slip}; quench takes {u} - {v_b} for every contact"
            )


def _slow(scene: Scene, designed: set[sp.Symbol]) -> Scene:
    """Separate fast and slow motion with the Coulomb law, whose average has its break at the intensity q."""
    contact = replace(scene.contacts[0], law=laws.coulomb(1), normal=1, profile=1)
    used = set().union(contact.free_symbols, *(e.free_symbols for e in scene.system.expressions))
    for s in designed:
        if s not in used:
            raise SceneError(f"no force and no slip contains {name_of(s)}; quench varies it")
    values = {k: 1.0 if k in designed else v for k, v in scene.values.items() if k in used}
    still = dict.fromkeys(scene.system.states, 0.0)
    return separate(Scene(scene.system, [contact], values, still, scene.horizon, {"end": End()}))


def _constant(expr: sp.Expr, given: Given, what: str) -> float:
    value = sp.simplify(expr.subs(given))
    if not value.is_number:
        moving = ", ".join(sorted(s.name for s in value.free_symbols))
        what_now = "time" if TIME in value.free_symbols else moving
        raise SceneError(f"{what} depends on {what_now}; quench takes a linear spring and damper and a constant load")
    return float(value)


def _gain(q: sp.Expr, given: Given, named: Mapping[str, sp.Symbol]) -> float:
    """Return the amplitude of the fast slip over a Omega."""
    a, Omega = sp.symbols("a Omega", positive=True)
    ratio = sp.simplify(q.subs(given).subs({named[AMPLITUDE]: a, named[FREQUENCY]: Omega}) / (a * Omega))
    if not ratio.is_number:
        raise SceneError(
            f"the fast velocity is {q}, not proportional to a*Omega; write the force as a*Omega**2*sin(...)"
        )
    return float(ratio)
