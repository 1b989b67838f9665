"""Friction curve of each contact, with the effective curve under a fast excitation."""

from dataclasses import dataclass

import numpy as np

from symfric.errors import SceneError
from symfric.locks import SYMBOLIC, alone
from symfric.model.excitation import is_excited
from symfric.model.numeric import numeric_function
from symfric.model.scene import Scene
from symfric.model.symbols import TIME
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
    """

    contact: str
    speed: np.ndarray
    coefficient: np.ndarray
    stick: float
    effective: tuple[tuple[str, np.ndarray], ...]
    operating: float | None
    note: str = ""
    is_force: bool = False


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
        words = ", ".join(f"{k} = {v:.4g}" for k, v in design.values.items())
        shaken.append((f"designed: {words}", scene.where(design.values)))
    slow = []
    for words, excited in shaken:
        from symfric.theory.separation import separate

        try:
            slow.append((words, separate(excited)))
        except SceneError as error:
            note = str(error)
    return tuple(_curve(scene, i, motion, equilibrium, slow, note) for i in range(len(scene.contacts)))


@alone(SYMBOLIC)
def _curve(scene: Scene, i: int, motion, equilibrium, slow, note: str) -> FrictionCurve:
    contact = scene.contacts[i]
    law = contact.law.where(scene.parameter_values())
    operating = None if equilibrium is None else abs(equilibrium.sliding[contact.name])
    reached = [2.0 * (operating or 0.0), *(1.2 * float(b) for b in law.breaks)]
    if motion is not None:
        states, parameters = scene.system.states, scene.parameters
        slip = numeric_function((*states, *parameters), contact.slip) if not contact.slip.has(TIME) else None
        if slip is not None:
            reached.append(1.05 * float(np.max(np.abs(slip(*motion.x, *scene.values.values())))))
    top = max(reached) or 1.0
    speed = np.linspace(top * 1e-9, top, POINTS)
    effective = tuple((words, s.contacts[i].law.where(s.values)(speed)) for words, s in slow)
    stick = float(law.stick)
    force = contact.normal * contact.profile == 1
    return FrictionCurve(contact.name, speed, law(speed), stick, effective, operating, note, force)
