"""Friction curve of each contact, with the effective curve under a fast excitation."""

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
import sympy as sp
from markupsafe import Markup

from symfric.errors import NotFound, SceneError
from symfric.locks import SYMBOLIC, alone
from symfric.model.excitation import is_excited
from symfric.model.laws import Law
from symfric.model.numeric import numeric_function
from symfric.model.scene import Scene
from symfric.model.symbols import TIME
from symfric.model.system import Contact
from symfric.report.html.elements import Picture, gallery, heading
from symfric.report.study.drawing.axes import (
    BLUE,
    COLOURS,
    GREY,
    Axes,
    in_brackets,
    label,
    legend,
    new_axes,
    tidy,
    to_svg,
)
from symfric.report.study.measurement import SampledMotion
from symfric.report.study.section import Progress, Section, StudyResult
from symfric.report.study.sections.motion import MOTION
from symfric.report.study.sections.quench import QUENCH
from symfric.report.study.sections.stability import EQUILIBRIUM
from symfric.scenefile import SceneFile
from symfric.theory.equilibrium import Equilibrium
from symfric.theory.separation import separate

Slow = list[tuple[str, Scene]]  # words on an excitation, and the scene of slow motions under it

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


def friction_curves(
    scene: Scene, motion: SampledMotion | None, equilibrium: Equilibrium | None, excited: Scene | None
) -> tuple[FrictionCurve, ...]:
    """Return one curve for each contact, over the sliding speeds that occur.

    Parameters
    ----------
    motion : SampledMotion or None
    equilibrium : Equilibrium or None
    excited : Scene or None
        With a designed fast excitation.
    """
    shaken, note = [], ""
    if is_excited(scene):
        shaken.append(("under the excitation", scene))
    if excited is not None:
        shaken.append(("under the designed excitation", excited))
    slow: Slow = []
    for words, moving in shaken:
        try:
            slow.append((words, separate(moving)))
        except SceneError as error:
            note = str(error)
    shown = list(range(len(scene.contacts))) if scene.system.linear is None else _different(scene)
    shown = [i for i in shown if not scene.contacts[i].frictionless]
    return tuple(_curve(scene, i, motion, equilibrium, slow, note) for i in shown)


def _different(scene: Scene) -> list[int]:
    """Return the first contact of each law: the contacts of a structure are many and alike."""
    laws = [c.law for c in scene.contacts]
    return [i for i, law in enumerate(laws) if law not in laws[:i]]


def _place(scene: Scene, contact: Contact, law: Law) -> sp.Symbol | None:
    """Return the only coordinate on which the friction of a contact depends, if the sliding speed changes nothing."""
    coordinates = [q for q in scene.system.q if contact.profile.has(q)]
    constant = law.kinetic.is_number and law.kinetic == law.stick and not law.memory
    return coordinates[0] if constant and len(coordinates) == 1 and not contact.profile.has(TIME) else None


def _range(x: np.ndarray) -> tuple[float, float]:
    low, high = float(np.min(x)), float(np.max(x))
    return (low, high) if high > low else (low - 1.0, high + 1.0)


@alone(SYMBOLIC)
def _curve(
    scene: Scene, i: int, motion: SampledMotion | None, equilibrium: Equilibrium | None, slow: Slow, note: str
) -> FrictionCurve:
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
        if contact.in_plane:
            written = sp.sqrt(sp.Add(*(w**2 for w in contact.slips)))
        slip = numeric_function((*states, *parameters), written) if not written.has(TIME) else None
        if slip is not None:
            x = motion.x[: len(states)]
            reached.append(1.05 * float(np.max(np.abs(slip(*x, *scene.values.values())))))
    top = max(reached) or 1.0
    speed = np.linspace(top * 1e-9, top, POINTS)
    effective = tuple((words, s.contacts[i].law.where(s.values)(speed)) for words, s in slow)
    stick = float(law.stick)
    force = contact.normal * contact.profile == 1
    return FrictionCurve(contact.name, speed, law(speed), stick, effective, operating, note, force)


def _compute(study: StudyResult, _tell: Progress) -> tuple[FrictionCurve, ...]:
    if all(c.frictionless for c in study.file.scene.contacts):
        raise NotFound("the scene has no contacts with friction")
    quench = study[QUENCH].value
    excited = None if quench is None else quench.excited
    return friction_curves(study.file.scene, study[MOTION].value, study[EQUILIBRIUM].value, excited)


def _page(study: StudyResult) -> Iterator[Markup]:
    curves = study[FRICTION].value
    if curves:
        yield heading("Friction and effective friction" if study[EFFECTIVE].value else "Friction", "friction")
        yield gallery(lambda: [_picture(curve, study.file) for curve in curves], study.said)


def _picture(curve: FrictionCurve, file: SceneFile) -> Picture:
    velocities = {file.units.get(u.name, "") for u in file.scene.system.u}
    unit = file.units.get(curve.place, "") if curve.place else ""
    ax = plot_friction(curve, unit or (velocities.pop() if len(velocities) == 1 else ""))
    what = "Force" if curve.is_force else "Coefficient"
    alt = f"{what} of friction of contact {curve.contact} against {curve.place or 'sliding speed'}"
    if curve.effective:
        alt += ", and the effective one under fast excitation"
    return Picture(to_svg(ax), alt, f"Friction of contact {curve.contact}.")


def plot_friction(curve: FrictionCurve, unit: str = "", ax: Axes | None = None) -> Axes:
    """Draw the coefficient of friction of a contact against sliding speed or place, and the one when shaken."""
    ax = new_axes() if ax is None else ax
    ax.plot(curve.speed, curve.coefficient, color=BLUE, label="friction law")
    if not curve.place:
        ax.plot(0, curve.stick, "o", color=BLUE, markersize=5, label="largest while sticking")
    for (name, values), colour in zip(curve.effective, COLOURS[1:], strict=False):
        ax.plot(curve.speed, values, color=colour, linestyle=(0, (6, 2)), label=name)
    if curve.operating is not None:
        ax.axvline(curve.operating, color=GREY, linewidth=0.9, linestyle=(0, (4, 3)), label="steady sliding")
    ax.set_xlim(left=min(-0.02 * curve.speed[-1], curve.speed[0]), right=curve.speed[-1])
    ax.set_ylim(bottom=min(0.0, float(np.nanmin(curve.coefficient))))
    ax.set_xlabel(label(curve.place, {}, unit) if curve.place else "sliding speed" + in_brackets(unit))
    ax.set_ylabel("friction force" if curve.is_force else "coefficient of friction")
    legend(ax)
    return tidy(ax)


def _effective(study: StudyResult, _tell: Progress) -> bool:
    """Whether a curve of effective friction is shown; the reason is raised if not."""
    curves = study[FRICTION].found
    if not any(c.effective for c in curves):
        note = next((c.note for c in curves if c.note), "")
        still = "the scene is not shaken, and the file designs no shaking"
        raise NotFound(note if is_excited(study.file.scene) and note else still)
    return True


FRICTION = Section("friction", _compute, topic="friction", place=60, page=_page)
EFFECTIVE = Section("effective", _effective, topic="effective friction", asked=lambda file: bool(file.scene.contacts))
