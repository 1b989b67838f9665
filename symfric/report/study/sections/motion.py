"""The motion of the scene, the vibration into which it settles, and the [outputs] that the file asks for."""

import math
from collections.abc import Iterator, Mapping, Sequence

import numpy as np
import sympy as sp
from markupsafe import Markup

from symfric.errors import NotFound
from symfric.model.excitation import is_excited
from symfric.model.symbols import counted
from symfric.orbits.steady_state import Vibration, schedule, vibration
from symfric.report.html.elements import Picture, gallery, heading, note, paragraph, subheading, table
from symfric.report.html.words import measure, number, powers_of_ten
from symfric.report.study.drawing.axes import (
    BLUE,
    COLOURS,
    GREY,
    ORANGE,
    Axes,
    in_brackets,
    label,
    legend,
    new_axes,
    tidy,
    to_svg,
)
from symfric.report.study.measurement import SampledMotion, contact_outputs, motion
from symfric.report.study.section import Progress, Section, StudyResult, csv_text
from symfric.report.study.sections.plane_path import path_picture, paths_in_plane
from symfric.scenefile import SceneFile, belt_speeds
from symfric.scenefile.units import output_unit
from symfric.solve.plotting import acting

MOST_COORDINATES = 6
MANY, FEW = 25, 5  # periods from which on a motion fills its picture, and those of its end that another one shows
STILL = 1e-4  # half range over the largest displacement below which a motion counts as at rest


def _compute(study: StudyResult, tell: Progress) -> SampledMotion:
    tell("motion", 0.1)
    return motion(study.file.scene, contact_outputs(study.file.scene))


def _steady(study: StudyResult, tell: Progress) -> Vibration:
    tell("steady vibration", 0.15)
    if study[MOTION].out_of_time:  # the motion is the shorter one
        raise NotFound(study[MOTION].note)
    scene, plan = study.file.scene, study.plan
    return vibration(scene, plan.coordinate, schedule(scene, plan.settle, plan.window))


def rests(v: Vibration) -> bool:
    """Whether a settled motion is at rest."""
    size = max(abs(v.largest), abs(v.smallest), 1e-300)
    return v.half_range < STILL * size or not math.isfinite(v.period)


def _settled(study: StudyResult, v: Vibration) -> Iterator[str]:
    name, file = study.plan.coordinate, study.file
    if not v.settled:
        low, high = measure(v.smallest, name, file), measure(v.largest, name, file)
        yield f"The motion has not settled to a periodic one: {v.note}. {name} lies between {low} and {high} so far."
    elif rests(v):
        yield f"The motion settles: {name} comes to rest at {measure(0.5 * (v.largest + v.smallest), name, file)}."
    else:
        kind = "stick-slip vibration" if v.stick_fraction > 0 else "vibration without sticking"
        if is_excited(file.scene):
            kind = "forced vibration"
        text = f"The motion settles into {kind} with a half range of {measure(v.half_range, name, file)} in {name}"
        text += f" and a period of {measure(v.period, 't', file)}"
        if v.stick_fraction > 0:
            text += f"; it sticks for {100 * v.stick_fraction:.3g} % of the time"
        yield text + "."


def motion_in_words(m: SampledMotion, file: SceneFile) -> str:
    """Return the sentences on the motion: route, status and accuracy."""
    sticks = sum(len(v) for v in m.sticks.values())
    text = f"Computed with the route {m.route}"
    if file.scene.contacts:
        text += f": {counted(m.events, 'change')} of mode, {counted(sticks, 'interval')} of sticking"
    off = powers_of_ten(f"{m.energy_residual:.1e}") if m.energy_residual else "0"
    text += f". The energies balance to {off}."
    return text + (f" It ended early ({m.status}): {m.advice}." if m.advice else "")


def _page(study: StudyResult) -> Iterator[Markup]:
    answered = study[MOTION]
    yield heading("The motion", "motion")
    if answered.value is None:
        yield note(f"Not computed: {answered.note}")
    else:
        yield paragraph(study.said(motion_in_words(answered.value, study.file)))
        steady = study[STEADY].value
        period = steady.period if steady is not None and steady.settled and not rests(steady) else math.nan
        yield gallery(lambda: pictures(answered.found, study.file, period), study.said)


def pictures(motion: SampledMotion, file: SceneFile, period: float = math.nan) -> Iterator[Picture]:
    """Draw a motion against time, and velocities against the first coordinates or points of a structure.

    Of a motion of many periods, its last ones once more.
    """
    scene = file.scene
    pairs = [(q.name, u.name) for q, u in zip(scene.system.q, scene.system.u, strict=True)]
    if file.structure is not None and file.structure.points:
        pairs = [(name, f"d_{name}") for name in file.structure.points]
    names = [q for q, _ in pairs][:MOST_COORDINATES]
    count = sum(len(v) for v in motion.sticks.values())
    alt = f"{', '.join(names)} against time from 0 to {motion.t[-1]:.4g}; {counted(count, 'interval')} of sticking"
    caption = "The motion; sticking is shaded." if count else "The motion."
    yield Picture(to_svg(plot_time_history(motion, names, file.units)), alt, caption)
    if motion.t[-1] > MANY * period:
        begin = motion.t[-1] - FEW * period
        ax = plot_time_history(motion, names, file.units, begin=begin)
        alt = f"{', '.join(names)} against time in the last {FEW} periods, from {begin:.4g} to {motion.t[-1]:.4g}"
        yield Picture(to_svg(ax), alt, f"The last {FEW} periods.")
    speeds = belt_speeds(scene)
    single = len(scene.contacts) == 1 and len(scene.system.q) == 1 and len(speeds) == 1
    drive = scene.values[speeds[0]] if single else None
    for q, u in pairs[:2]:
        rubbing = [c.name for c in scene.contacts if any(w.has(sp.Symbol(u, real=True)) for w in c.slips)]
        ax = plot_phase_portrait(motion, q, u, rubbing, file.units, drive)
        yield Picture(to_svg(ax), f"Phase portrait: {u} against {q}, sticking marked", f"Velocity {u} against {q}.")
    for path in paths_in_plane(scene):
        yield path_picture(motion, path, file.units)
    if held := [h.name for h in acting(scene)][:MOST_COORDINATES]:
        ax = plot_held(motion, held, file.units)
        yield Picture(to_svg(ax), f"{', '.join(held)} against time, in steps", "Held variables.")


def plot_held(motion: SampledMotion, names: Sequence[str], units: Mapping[str, str], ax: Axes | None = None) -> Axes:
    """Draw held variables against time."""
    ax = new_axes() if ax is None else ax
    for name, colour in zip(names, COLOURS, strict=False):
        ax.plot(motion.t, motion.x[motion.names.index(name)], color=colour, linewidth=1.0, label=label(name, {}))
    ax.set_xlim(motion.t[0], motion.t[-1])
    ax.set_xlabel(label("t", units))
    shared = {units.get(n, "") for n in names}
    unit = shared.pop() if len(shared) == 1 else ""
    ax.set_ylabel(label(names[0], units) if len(names) == 1 else "held variables" + in_brackets(unit))
    if len(names) > 1:
        legend(ax, 6)
    return tidy(ax)


def plot_time_history(
    motion: SampledMotion,
    coordinates: Sequence[str],
    units: Mapping[str, str],
    ax: Axes | None = None,
    begin: float = 0.0,
) -> Axes:
    """Draw coordinates against time, from a time on; stick intervals are shaded."""
    ax = new_axes() if ax is None else ax
    late = motion.t >= begin
    shaded, word = False, "sticking" if len(motion.sticks) < 2 else "a contact sticks"
    for intervals in motion.sticks.values():
        for start, end in ((a, b) for a, b in intervals if b >= begin):
            ax.axvspan(max(start, begin), end, color="0.85", linewidth=0, label=None if shaded else word)
            shaded = True
    for name, colour in zip(coordinates, COLOURS, strict=False):
        y = motion.x[motion.names.index(name), late]
        ax.plot(motion.t[late], y, color=colour, linewidth=1.1, label=label(name, {}))
    ax.set_xlim(begin, motion.t[-1])
    ax.set_xlabel(label("t", units))
    single = len(coordinates) == 1
    shared = {units.get(n, "") for n in coordinates}
    unit = shared.pop() if len(shared) == 1 else ""
    ax.set_ylabel(label(coordinates[0], units) if single else "displacement" + in_brackets(unit))
    if shaded or not single:
        legend(ax, 6)
    return tidy(ax)


def plot_phase_portrait(
    motion: SampledMotion,
    q: str,
    u: str,
    contacts: Sequence[str],
    units: Mapping[str, str],
    drive: float | None = None,
    ax: Axes | None = None,
) -> Axes:
    """Draw velocity against displacement, sticking of the contacts in another colour; `drive`: velocity of sticking."""
    ax = new_axes() if ax is None else ax
    x, v = motion.x[motion.names.index(q)], motion.x[motion.names.index(u)]
    on, inside = motion.sticking(contacts), motion.sticking(contacts, ends=False)
    if drive is not None:
        ax.axhline(drive, color=GREY, linewidth=0.9, linestyle=(0, (4, 3)), label="no sliding")
    words = "slipping" if contacts else None
    ax.plot(x, np.where(inside, np.nan, v), color=BLUE, linewidth=0.9, label=words)
    if on.any():  # a wait at one place is a dot
        ax.plot(
            x,
            np.where(on, v, np.nan),
            color=ORANGE,
            linewidth=2.4,
            label="sticking",
            solid_capstyle="round",
            marker="o",
            markersize=2.0,
        )
    ax.plot(x[0], v[0], "o", color="black", markersize=5, fillstyle="none", label="start")
    ax.set_xlabel(label(q, units))
    ax.set_ylabel(label(u, units))
    legend(ax)
    return tidy(ax)


def _data(_study: StudyResult, m: SampledMotion) -> dict[str, object]:
    return {
        **{name: getattr(m, name) for name in ("route", "status", "events", "energy_residual", "outputs", "sticks")},
        "final": dict(zip(m.names, m.x[:, -1], strict=True)),
    }


def _steady_data(study: StudyResult, v: Vibration) -> dict[str, object]:
    names = ("half_range", "largest", "smallest", "mean", "period", "stick_fraction", "settled", "note")
    return {"coordinate": study.plan.coordinate, **{name: getattr(v, name) for name in names}}


def _tables(_study: StudyResult, m: SampledMotion) -> dict[str, str]:
    return {"motion.csv": csv_text(["t", *m.names], np.column_stack([m.t, m.x.T]))}


def _outputs(study: StudyResult, _tell: Progress) -> Mapping[str, float]:
    return study[MOTION].found.outputs


def _outputs_page(study: StudyResult) -> Iterator[Markup]:
    values, asked, units = study[OUTPUTS].value, study.file.scene.outputs, study.file.units
    if values:
        yield subheading("What the file asks for")
        rows = [
            [name, number(v, 9), output_unit(units, asked[name]) if name in asked else ""] for name, v in values.items()
        ]
        yield table(["output", "value", "unit"], rows, [1])


MOTION = Section("motion", _compute, topic="motion", place=50, page=_page, key="motion", data=_data, tables=_tables)
STEADY = Section("steady", _steady, topic="steady vibration", rank=3, summary=_settled, key="steady", data=_steady_data)
OUTPUTS = Section("outputs", _outputs, place=52, page=_outputs_page)
