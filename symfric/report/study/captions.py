"""Figures of a study, with captions and alternative texts."""

from dataclasses import dataclass

import sympy as sp

from symfric.report.study import designs, figures
from symfric.report.study import narrative as sentences
from symfric.report.study.quantities import measured
from symfric.report.study.study import DesignResult, StudyResult
from symfric.scenefile import belt_speeds

MOST_COORDINATES = 6


@dataclass(frozen=True)
class Picture:
    """A figure of the page.

    Attributes
    ----------
    uri : str
        Data URI of an SVG.
    alt, caption : str
    """

    uri: str
    alt: str
    caption: str


def pictures(result: StudyResult) -> dict[str, list[Picture]]:
    """Draw the figures of a result, by section of the page."""
    makers = {
        "stability": _stability,
        "motion": _motion,
        "friction": _friction,
        "amplitude": _amplitude,
    }
    return {section: make(result) for section, make in makers.items()}


def _stability(result: StudyResult) -> list[Picture]:
    found = result.stability.value
    if found is None:
        return []
    ax = figures.plot_eigenvalues(found, result.file.units)
    values = ", ".join(f"{v:.4g}" for v in found.eigenvalues)
    return [
        Picture(figures.to_svg(ax), f"Eigenvalues in the complex plane: {values}", "Eigenvalues of steady sliding.")
    ]


def _motion(result: StudyResult) -> list[Picture]:
    motion, file = result.motion.value, result.file
    if motion is None:
        return []
    system = file.scene.system
    pairs = _looked_at(result)
    names = [q for q, _ in pairs][:MOST_COORDINATES]
    count = sum(len(v) for v in motion.sticks.values())
    ax = figures.plot_time_history(motion, names, file.units)
    words = f"{', '.join(names)} against time from 0 to {motion.t[-1]:.4g}"
    shown = [
        Picture(
            figures.to_svg(ax),
            f"{words}; {sentences.counted(count, 'interval')} of sticking",
            "The motion; sticking is shaded." if count else "The motion.",
        )
    ]
    speeds = belt_speeds(file.scene)
    single = len(file.scene.contacts) == 1 and len(system.q) == 1 and len(speeds) == 1
    drive = file.scene.values[speeds[0]] if single else None
    for q, u in pairs[:2]:
        rubbing = [c.name for c in file.scene.contacts if not c.slip.diff(sp.Symbol(u, real=True)).is_zero]
        ax = figures.plot_phase_portrait(motion, q, u, rubbing, file.units, drive)
        alt = f"Phase portrait: {u} against {q}, sticking marked"
        shown.append(Picture(figures.to_svg(ax), alt, f"Velocity {u} against {q}."))
    return shown


def _looked_at(result: StudyResult) -> list[tuple[str, str]]:
    """Return what is drawn, with its velocities: the coordinates, or the points of a structure."""
    file, system = result.file, result.file.scene.system
    if file.structure is not None and file.structure.points:
        return [(name, f"d_{name}") for name in file.structure.points]
    return [(q.name, u.name) for q, u in zip(system.q, system.u, strict=True)]


def _friction(result: StudyResult) -> list[Picture]:
    shown = []
    for curve in result.friction:
        velocities = {result.file.units.get(u.name, "") for u in result.file.scene.system.u}
        unit = result.file.units.get(curve.place, "") if curve.place else ""
        ax = figures.plot_friction(curve, unit or (velocities.pop() if len(velocities) == 1 else ""))
        what = "Force" if curve.is_force else "Coefficient"
        alt = f"{what} of friction of contact {curve.contact} against {curve.place or 'sliding speed'}"
        if curve.effective:
            alt += ", and the effective one under fast excitation"
        shown.append(Picture(figures.to_svg(ax), alt, f"Friction of contact {curve.contact}."))
    return shown


def _amplitude(result: StudyResult) -> list[Picture]:
    sweep = result.sweep.value
    if sweep is None:
        return []
    ax = figures.plot_amplitudes(sweep, result.file.units, result.branch.value)
    names = ", ".join(c.label for c in sweep.curves) or "no prediction"
    alt = f"Half range of {sweep.coordinate} against {sweep.parameter}: computed points, curves: {names}"
    caption = "Steady vibration: curves predicted, points computed." if sweep.curves else "Steady vibration, computed."
    return [Picture(figures.to_svg(ax), alt, caption)]


def designs_shown(result: StudyResult) -> dict[str, list[Picture]]:
    """Draw every design, by its kind."""
    return {d.plan.kind: _design(result, d) for d in result.designs}


def _design(result: StudyResult, made: DesignResult) -> list[Picture]:
    design = made.design.value
    if design is None:
        return []
    ax, caption = design.plot(figures.new_axes()), "What limits the design; dashed: the level at which it does."
    alt = f"{ax.get_ylabel()} against {ax.get_xlabel()}. {caption}"  # before names are set as mathematics
    ax.set_xlabel(figures.with_units(ax.get_xlabel(), result.file.units))
    ax.set_ylabel(designs.axis(made.plan, ax.get_ylabel(), result.file))
    figures.tidy(ax)
    limit = Picture(figures.to_svg(ax), alt, caption)
    found = result.quench.value
    if made.plan.kind != "quench" or found is None:
        return [limit]
    q = result.plan.coordinate
    ax = figures.plot_before_after(found.before, found.after, q, result.file.units)
    at = measured(found.shown, result.file.units.get(found.speed, ""))
    caption = f"At {found.speed} = {at}, without and with the designed excitation."
    return [Picture(figures.to_svg(ax), f"{q} against time. {caption}", caption), limit]
