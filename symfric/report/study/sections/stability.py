"""Steady sliding of the scene, or of its slow motion if it is excited, and its stability."""

import math
from collections.abc import Iterator, Mapping

import numpy as np
import sympy as sp
from markupsafe import Markup

from symfric.model.excitation import is_excited
from symfric.model.scene import Scene
from symfric.model.units import Units
from symfric.report.html.elements import Picture, gallery, heading, matrix, note, paragraph, table
from symfric.report.html.mathml import number_in_letters
from symfric.report.html.words import inline_name, measure, number, with_unit
from symfric.report.study.drawing.axes import GREEN, RED, Axes, in_brackets, legend, new_axes, tidy, to_svg
from symfric.report.study.section import Progress, Section, StudyResult
from symfric.report.study.sections.motion import STEADY, rests
from symfric.scenefile import belt_speeds
from symfric.theory.equilibrium import Equilibrium, equilibrium
from symfric.theory.separation import separate
from symfric.theory.stability import Stability, stability

NEUTRAL = 1e-10  # growth over the largest eigenvalue below which it is rounding
MANY = 8  # pairs of eigenvalues up to which all are shown, and the matrices


def base(study: StudyResult) -> Scene:
    """Return the scene of slow motions if the file's scene is excited and has one, else the scene itself."""
    return study[SLOW].value or study.file.scene


def _slow(study: StudyResult, tell: Progress) -> Scene:
    tell("steady sliding and its stability", 0.0)
    scene = study.file.scene
    return separate(scene) if is_excited(scene) else scene


def _equilibrium(study: StudyResult, _tell: Progress) -> Equilibrium:
    return equilibrium(base(study))


def _stability(study: StudyResult, _tell: Progress) -> Stability:
    return stability(base(study))


def _summary(study: StudyResult, judged: Stability) -> Iterator[str]:
    file = study.file
    speeds = belt_speeds(file.scene)
    at = f" at {speeds[0].name} = {measure(file.scene.numbers()[speeds[0]], speeds[0].name, file)}" if speeds else ""
    verdict = "is stable: a small disturbance dies out" if judged.stable else "is not stable: a small disturbance grows"
    if abs(judged.margin) <= NEUTRAL * np.max(np.abs(judged.eigenvalues), initial=0.0):
        verdict = "is on the edge: a small disturbance neither grows nor dies out"
    settled = study[STEADY].value
    vibrates = settled is not None and settled.settled and not rests(settled) and not is_excited(file.scene)
    more = ". A large one need not: from its start the scene vibrates" if judged.stable and vibrates else ""
    yield f"{what_slides(file.scene)}{at} {verdict}{more}."


def what_slides(scene: Scene) -> str:
    """Return the name of the state whose stability is told, at the begin of a sentence."""
    return "Steady sliding" if scene.contacts else "The equilibrium"


def _page(study: StudyResult) -> Iterator[Markup]:
    scene, answered = study.file.scene, study[STABILITY]
    yield heading(f"{what_slides(scene)} and its stability", "stability")
    if scene.contacts_that_open:
        yield note("Contacts open and strike: no steady sliding under given loads, whose stability could be told.")
        return
    if study[SLOW].value is not None and study[SLOW].value is not scene:
        if scene.contacts:
            yield note("The scene is shaken; what follows holds for the slow motion, with the effective friction.")
        else:
            yield note("The scene is excited; what follows holds without the excitation.")
    at = study[EQUILIBRIUM]
    yield note(f"No steady sliding: {at.note}") if at.value is None else paragraph(_balance(study, at.value))
    if answered.value is not None:
        yield from _details(study, answered.value)
    elif at.value is not None:
        yield note(f"Stability: {answered.note}")


def _balance(study: StudyResult, at: Equilibrium) -> Markup:
    """Return the sentences on the equilibrium, of a structure its points, and on the sliding speeds there."""
    file, contacts = study.file, study.file.scene.contacts
    known, structure = dict(zip(at.names, at.x, strict=True)), file.structure
    names = known if structure is None else [name for name in structure.points if name in known]
    position = [(inline_name(n), with_unit(number(known[n]), file.units.get(n, ""))) for n in names]
    slips, one = {c.name: c.slip for c in contacts}, contacts[0].slip if contacts else sp.S.Zero
    sliding = [(n, with_unit(number(w), file.units.of(slips.get(n, one)))) for n, w in _alike(at.sliding).items()]
    text = Markup("")
    if position:
        shown = Markup(", ").join(Markup("{} = {}").format(*pair) for pair in position)
        text += Markup("The forces balance at {}.").format(shown)
    if sliding:
        shown = Markup(", ").join(Markup("{}: {}").format(*pair) for pair in sliding)
        text += Markup(" Sliding velocity: {}.").format(shown)
    return text


def _alike(sliding: Mapping[str, float]) -> dict[str, float]:
    """Return one entry for all contacts if they are many and slide alike."""
    speeds = list(sliding.values())
    if len(speeds) > 3 and np.ptp(speeds) <= 1e-9 * np.max(np.abs(speeds)):
        return {"every contact": speeds[0]}
    return dict(sliding)


def _details(study: StudyResult, judged: Stability) -> Iterator[Markup]:
    """Yield verdict, matrices and eigenvalues, beside their picture."""
    scene, units = study.file.scene, study.file.units
    yield Markup(
        "<p>Small motions about it obey <i>M q″ + B q′ + K q = 0</i>{}. Matrices: <strong>{}</strong> ({}). "
        "Eigenvalues: {} is <strong>{}</strong>, growth rate {}.</p>"
    ).format(
        ", friction included" if scene.contacts else "",
        judged.definiteness,
        study.said(judged.reason.replace("M^-1 B", "M⁻¹B")),
        "steady sliding" if scene.contacts else "the equilibrium",
        "stable" if judged.stable else "not stable",
        with_unit(number(-judged.margin), units.rate),
    )
    yield Markup('<div class="pair"><div>')
    if len(judged.eigenvalues) <= 2 * MANY:
        for name, entries in (("M", judged.M), ("B", judged.B), ("K", judged.K)):
            yield matrix(name, [[number_in_letters(v) for v in row] for row in np.atleast_2d(entries)])
    shown = _leading(judged.eigenvalues)
    hertz = units.hertz
    rows = [
        [number(v.real), number(v.imag), *([number(abs(v.imag) * hertz)] if math.isfinite(hertz) else [])]
        for v in shown
    ]
    yield table(_eigenvalue_head(units), rows, [0, 1, 2])
    if len(shown) < len(judged.eigenvalues):
        yield note(f"Of {len(judged.eigenvalues)} eigenvalues those that grow most or decay least.")
    values = ", ".join(f"{v:.4g}" for v in judged.eigenvalues)
    alt = f"Eigenvalues in the complex plane: {values}"

    def draw() -> list[Picture]:
        return [Picture(to_svg(plot_eigenvalues(judged.eigenvalues, units)), alt, "Eigenvalues of steady sliding.")]

    yield Markup("</div>{}</div>").format(gallery(draw, study.said))


def _leading(eigenvalues: np.ndarray) -> np.ndarray:
    """Return the eigenvalues, of many the pairs that grow most or decay least."""
    if len(eigenvalues) <= 2 * MANY:
        return eigenvalues
    upper = eigenvalues[eigenvalues.imag >= 0]
    return upper[np.argsort(-upper.real, kind="stable")[:MANY]]


def _eigenvalue_head(units: Units) -> list[str]:
    """Return the heading of the table of eigenvalues, with a column for Hz where time has a unit."""
    if not units.rate:
        return ["eigenvalue: real", "imaginary"]
    frequency = ["[Hz]"] if math.isfinite(units.hertz) else []
    return [f"eigenvalue: real [{units.rate}]", f"imaginary [{units.angular}]", *frequency]


def plot_eigenvalues(eigenvalues: np.ndarray, units: Mapping[str, str], ax: Axes | None = None) -> Axes:
    """Draw the eigenvalues of steady sliding in the complex plane; the right half means growth."""
    ax = new_axes() if ax is None else ax
    values = np.asarray(eigenvalues)
    growing = values.real > 0
    ax.axvline(0.0, color="black", linewidth=0.8)
    if growing.any():
        ax.plot(values.real[growing], values.imag[growing], "x", color=RED, markersize=8, label="growing")
    if not growing.all():
        ax.plot(values.real[~growing], values.imag[~growing], "x", color=GREEN, markersize=8, label="decaying")
    reach = 1.3 * (max(np.max(np.abs(values.real)), 1e-12 * np.max(np.abs(values))) or 1.0)
    ax.set_xlim(-reach, reach)
    time = units.get("t")
    ax.set_xlabel("rate of growth" + in_brackets(time and f"1/{time}"))
    ax.set_ylabel("angular frequency" + in_brackets(time and f"rad/{time}"))
    legend(ax)
    return tidy(ax)


SLOW = Section("slow", _slow, topic="slow motion")
EQUILIBRIUM = Section("equilibrium", _equilibrium, topic="equilibrium", key="equilibrium")
STABILITY = Section(
    "stability", _stability, topic="stability", place=40, page=_page, rank=1, summary=_summary, key="stability"
)
