"""Friction curve of each contact, with the effective curve under a fast excitation."""

from dataclasses import dataclass

import numpy as np
import sympy as sp

from symfric.errors import SceneError
from symfric.locks import SYMBOLIC, alone
from symfric.model.excitation import is_excited
from symfric.model.laws import Law
from symfric.model.numeric import numeric_function
from symfric.model.scene import Scene
from symfric.model.symbols import TIME
from symfric.model.system import Contact
from symfric.report.study.measurement import SampledMotion

POINTS = 500


@dataclass(frozen=True, eq=False)
class FrictionCurve:
    """Coefficient of friction of one contact against sliding speed.

    Attributes
    ----------
    contact : str
    speed, coefficient : ndarray, shape (n,)
    stick : float
    effective : tuple of (label, ndarray (n,))
        Under fast excitations.
    operating : float or None
        Sliding speed of steady sliding.
    note : str
        Why an effective curve is missing, if one was expected.
    is_force : bool
        Whether the normal load is one, so that the law itself gives the force.
    place : str
        Name of the coordinate that `speed` holds instead, of a contact whose friction depends on the place alone.
    """

    contact: str
    speed: np.ndarray
    coefficient: np.ndarray
    stick: float
    effective: tuple[tuple[str, np.ndarray], ...]
    operating: float | None
    note: str = ""
    is_force: bool = False
    place: str = ""


def friction_curves(scene: Scene, motion: SampledMotion | None, equilibrium, design) -> tuple[FrictionCurve, ...]:
    """Return one curve for each contact, over the sliding speeds that occur.

    Parameters
    ----------
    motion : SampledMotion or None
    equilibrium : Equilibrium or None
    design : Design or None
        Of a fast excitation.
    """
    shaken, note = [], ""
    if is_excited(scene):
        shaken.append(("under the excitation", scene))
    if design is not None:
        shaken.append(("under the designed excitation", scene.where(design.values)))
    slow = []
    for words, excited in shaken:
        from symfric.theory.separation import separate

        try:
            slow.append((words, separate(excited)))
        except SceneError as error:
            note = str(error)
    shown = range(len(scene.contacts)) if scene.system.linear is None else _different(scene)
    return tuple(_curve(scene, i, motion, equilibrium, slow, note) for i in shown)


def _different(scene: Scene) -> list[int]:
    """Return the first contact of each law: the contacts of a structure are many and alike."""
    laws = [c.law for c in scene.contacts]
    return [i for i, law in enumerate(laws) if law not in laws[:i]]


def _place(scene: Scene, contact: Contact, law: Law) -> sp.Symbol | None:
    """Return the only coordinate on which the friction of a contact depends, if the sliding speed changes nothing."""
    found = [q for q in scene.system.q if contact.profile.has(q)]
    constant = law.kinetic.is_number and law.kinetic == law.stick and not law.memory
    return found[0] if constant and len(found) == 1 and not contact.profile.has(TIME) else None


def _range(x: np.ndarray) -> tuple[float, float]:
    low, high = float(np.min(x)), float(np.max(x))
    return (low, high) if high > low else (low - 1.0, high + 1.0)


@alone(SYMBOLIC)
def _curve(scene: Scene, i: int, motion, equilibrium, slow, note: str) -> FrictionCurve:
    contact = scene.contacts[i]
    law = contact.law.where(scene.parameter_values())
    over = _place(scene, contact, law)
    if over is not None and motion is not None:
        at = np.linspace(*_range(motion.x[motion.names.index(over.name)]), POINTS)
        profile = numeric_function((over,), contact.profile.subs(scene.parameter_values()))(at)
        coefficient = float(law.stick) * np.broadcast_to(profile, at.shape)
        return FrictionCurve(contact.name, at, coefficient, float(law.stick), (), None, note, place=over.name)
    operating = None if equilibrium is None else abs(equilibrium.sliding[contact.name])
    reached = [2.0 * (operating or 0.0), *(1.2 * float(b) for b in law.breaks)]
    if motion is not None:
        states, parameters = scene.system.states, scene.parameters
        written = contact.slip.xreplace(scene.system.row_values())
        slip = numeric_function((*states, *parameters), written) if not contact.slip.has(TIME) else None
        if slip is not None:
            x = motion.x[: len(states)]
            reached.append(1.05 * float(np.max(np.abs(slip(*x, *scene.values.values())))))
    top = max(reached) or 1.0
    speed = np.linspace(top * 1e-9, top, POINTS)
    effective = tuple((words, s.contacts[i].law.where(s.values)(speed)) for words, s in slow)
    stick = float(law.stick)
    force = contact.normal * contact.profile == 1
    return FrictionCurve(contact.name, speed, law(speed), stick, effective, operating, note, force)
