"""What the study of a structure holds beside that of its scene: modes, flutter, and what its contacts do."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
import sympy as sp

from symfric.model.outputs import Integral, Min, Output, dissipated_power
from symfric.model.scene import Scene
from symfric.model.symbols import SPEED
from symfric.report.study.answers import StudyAnswer, answer
from symfric.report.study.comparison import ComparisonRow
from symfric.report.study.measurement import SampledMotion
from symfric.scenefile import SceneFile, StructurePlan

if TYPE_CHECKING:
    from symfric.structures.flutter import Flutter
    from symfric.structures.real_modes import Modes
    from symfric.theory.equilibrium import Equilibrium
    from symfric.theory.hopf import HopfPoint

MODES = 6  # of the table of frequencies
MOST_CONTACTS = 40  # of which the loads and the energies are computed
_ALIKE = 1e-9  # relative difference of coefficients of friction that are the same


@dataclass(frozen=True)
class ContactShare:
    """What a contact does during the motion.

    Attributes
    ----------
    contact : str
    sticks : float
        Fraction of the time.
    least : float
        Smallest normal load; zero if it opens.
    dissipated : float
        Energy.
    """

    contact: str
    sticks: float
    least: float
    dissipated: float


@dataclass(frozen=True, eq=False)
class StructureResult:
    """Results of a structure.

    Attributes
    ----------
    plan : StructurePlan
    modes : StudyAnswer
        The lowest modes with the contacts closed, without friction and damping.
    flutter : StudyAnswer
    shares : tuple of ContactShare
    opened : tuple of str
        Contacts that are open in steady sliding.
    torn : tuple of tuple of str
        For each critical point of the flutter map the contacts that would be under tension in steady sliding there.
    factor : str
        What multiplies the friction matrix, if it is no coefficient of friction but a load.
    """

    plan: StructurePlan
    modes: StudyAnswer["Modes"]
    flutter: StudyAnswer["Flutter"]
    shares: tuple[ContactShare, ...]
    opened: tuple[str, ...] = ()
    torn: tuple[tuple[str, ...], ...] = ()
    factor: str = ""

    @property
    def followed(self) -> "Flutter":
        """The flutter map, which must exist."""
        return self.flutter.found


def structure_result(
    file: SceneFile, motion: SampledMotion | None, at_rest: "Equilibrium | None"
) -> StructureResult | None:
    """Return the results of the file's structure; None if it has none."""
    from symfric import structures

    plan = file.structure
    if plan is None:
        return None
    values = {s.name: v for s, v in file.scene.parameter_values().items()}
    closed = answer(structures.sliding, plan.full, plan.contacts, values)
    modes = answer((closed.value or plan.full).modes, min(MODES, plan.full.n))
    if plan.flutter is None:
        map_of: StudyAnswer[Flutter] = StudyAnswer(
            None, "the file has no [flutter], which says over which coefficients of friction"
        )
    elif closed.value is None:
        map_of = StudyAnswer(None, closed.note)
    else:
        asked = plan.flutter
        map_of = answer(
            structures.flutter, closed.value, (asked.mu[0], asked.mu[1]), asked.modes, asked.near, asked.grid
        )
    opened = () if at_rest is None else tuple(open_contacts(file.scene, at_rest))
    torn = () if map_of.value is None else tuple(_torn(plan, values, p.mu) for p in map_of.value.critical)
    return StructureResult(plan, modes, map_of, _shares(file.scene, motion), opened, torn, _factor(file.scene))


def _factor(scene: Scene) -> str:
    part = scene.system.linear
    return "" if scene.contacts or part is None or not part.scaled else str(part.scaled[0][0])


def _torn(plan: StructurePlan, values: Mapping[str, float], mu: float) -> tuple[str, ...]:
    """Return the contacts that open before steady sliding comes to a coefficient of friction; none if not known."""
    from symfric.structures.sliding import steady_loads

    if plan.loaded or plan.full.friction is not None:
        return ()
    loads = answer(steady_loads, plan.full, plan.contacts, values, mu).value or {}
    return tuple(name for name, load in loads.items() if load <= 0)


def contact_outputs(scene: Scene) -> dict[str, Output]:
    """Return outputs of the motion that say what the contacts of a structure do."""
    found: dict[str, Output] = {}
    if scene.system.linear is None or len(scene.contacts) > MOST_CONTACTS:
        return found
    for c in scene.contacts:
        found[f"least load of contact {c.name}"] = Min(sp.sympify(c.normal))
        found[f"energy dissipated in contact {c.name}"] = Integral(dissipated_power(c.name))
    return found


def _shares(scene: Scene, motion: SampledMotion | None) -> tuple[ContactShare, ...]:
    if motion is None or not contact_outputs(scene):
        return ()
    end = float(motion.t[-1])
    return tuple(
        ContactShare(
            c.name,
            sum(b - a for a, b in motion.sticks[c.name]) / end,
            motion.also[f"least load of contact {c.name}"],
            motion.also[f"energy dissipated in contact {c.name}"],
        )
        for c in scene.contacts
    )


def coefficient_at(scene: Scene, equilibrium: "Equilibrium") -> float:
    """Return the coefficient of friction in steady sliding, or the load in its place; NaN if contacts differ in it."""
    values, part = scene.parameter_values(), scene.system.linear
    if not scene.contacts and part is not None and part.scaled:
        return float(part.scaled[0][0].subs(values))
    found = [
        float(c.law.where(values)(abs(equilibrium.sliding[c.name]))) * float(sp.sympify(c.profile).subs(values))
        for c in scene.contacts
        if sp.sympify(c.profile).free_symbols <= set(values)
    ]
    if len(found) < max(1, len(scene.contacts)) or np.ptp(found) > _ALIKE * max(found):
        return float("nan")
    return found[0]


def open_contacts(scene: Scene, equilibrium: "Equilibrium") -> list[str]:
    """Return the contacts whose load is zero in steady sliding: there the flutter map does not hold."""
    part, n = scene.system.linear, len(scene.system.q)
    if part is None:
        return []
    rows = part.values(equilibrium.x[:n], np.zeros(n))
    numbers = {**scene.parameter_values(), **dict(zip(scene.system.q, equilibrium.x, strict=False)), **rows}
    loads = {c.name: sp.sympify(c.normal).subs(numbers) for c in scene.contacts}
    return [name for name, load in loads.items() if load.is_number and float(load) <= 0]


def onset_rows(
    file: SceneFile, base: Scene, found: StructureResult | None, onset: "HopfPoint | None"
) -> list[ComparisonRow]:
    """Compare the onset by the full matrices with the Hopf point of the scene."""
    from symfric.theory.equilibrium import equilibrium

    if found is None or found.flutter.value is None or onset is None or not found.followed.critical:
        return []
    scene = base.where({onset.parameter: onset.value})
    at = answer(equilibrium, scene)
    if at.value is None:
        return []
    mu = coefficient_at(scene, at.value)
    opened = open_contacts(scene, at.value)
    near = min(found.followed.critical, key=lambda p: abs(p.mu - mu) if np.isfinite(mu) else abs(p.omega - onset.omega))
    words = "full matrices; computed: Hopf point"
    if opened:
        words += f"; made for closed contacts, and {opened[0]} is open there"
    elif any(c.law.kinetic.free_symbols & {SPEED} for c in scene.contacts):
        words += "; made without the slope of the law"
    return [
        ComparisonRow(f"{found.factor or 'coefficient of friction'} at the onset", near.mu, mu, words),
        ComparisonRow("angular frequency at the onset", near.omega, onset.omega, words, file.units.angular),
    ]
