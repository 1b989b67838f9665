"""The steady vibration over a range of one parameter, asked by [sweep]: computed, predicted, and followed."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from markupsafe import Markup

from symfric.errors import NotFound
from symfric.orbits.steady_state import Vibration
from symfric.report.html.elements import Picture, gallery, heading, paragraph
from symfric.report.html.words import measure
from symfric.report.study.drawing.axes import COLOURS, GREY, RED, Axes, label, legend, new_axes, tidy, to_svg
from symfric.report.study.measurement import vibrations
from symfric.report.study.section import Progress, Section, StudyResult, csv_text
from symfric.report.study.sections.branch import BRANCH, BranchResult, branch_in_words, draw_branch
from symfric.report.study.sections.onset import HOPF, SAFE
from symfric.report.study.sections.prediction import CURVES, PredictionCurve
from symfric.report.study.sections.quench import QUENCH
from symfric.scenefile import SceneFile, belt_speeds


@dataclass(frozen=True, eq=False)
class SweepResult:
    """Steady vibration over a range of one parameter.

    Attributes
    ----------
    parameter, coordinate : str
    values : ndarray, shape (n,)
    computed : tuple of Vibration
    marks : dict of str to float
        Special values.
    """

    parameter: str
    coordinate: str
    values: np.ndarray
    computed: tuple[Vibration, ...]
    marks: Mapping[str, float]

    @property
    def half_range(self) -> np.ndarray:
        """Computed half range, shape (n,)."""
        return np.array([v.half_range for v in self.computed])


def _compute(study: StudyResult, tell: Progress) -> SweepResult:
    plan, onset, safe = study.file.sweep, study[HOPF].value, study[SAFE].value
    if plan is None:
        raise NotFound("the file has no [sweep]; add one to see the amplitude against a parameter")
    values = np.linspace(plan.start, plan.stop, plan.number)
    told = lambda f: tell("sweep", 0.2 + 0.4 * f)  # noqa: E731
    computed = vibrations(study.file.scene, plan.parameter, values, plan, told)
    marks = {} if onset is None else {"onset of vibration": onset.value}
    if safe is not None and safe.overhangs and safe.ended:
        marks["quiet from here on"] = safe.value
    return SweepResult(plan.parameter, plan.coordinate, values, tuple(computed), marks)


def _quenched(study: StudyResult, tell: Progress) -> np.ndarray:
    """Return the half range over the sweep with the designed excitation, shape (n,)."""
    shaken, sweep = study[QUENCH].found.excited, study[SWEEP].found
    told = lambda f: tell("sweep with design", 0.7 + 0.2 * f)  # noqa: E731
    return np.array([v.half_range for v in vibrations(shaken, sweep.parameter, sweep.values, study.plan, told)])


def _page(study: StudyResult) -> Iterator[Markup]:
    sweep, branch, file = study[SWEEP].value, study[BRANCH].value, study.file
    if sweep is None:
        return
    belts = file.model is not None or any("belt" in c.name for c in file.scene.contacts)
    is_speed = sweep.parameter in {s.name for s in belt_speeds(file.scene)}
    over = "belt speed" if belts and is_speed else sweep.parameter
    yield heading(study.said(f"Amplitude against {over}"), "amplitude")
    curves = study[CURVES].value or ()
    lines = [*sweep_in_words(sweep, curves, file), *([] if curves else [f"No prediction: {study[CURVES].note}."])]
    lines += [] if branch is None else branch_in_words(branch, file)
    yield from (paragraph(study.said(line)) for line in lines)
    yield gallery(lambda: pictures(study), study.said)


def sweep_in_words(sweep: SweepResult, curves: Sequence[PredictionCurve], file: SceneFile) -> Iterator[str]:
    """Yield the sentences on computed and predicted half ranges."""
    half = sweep.half_range
    failed = int(np.sum(~np.isfinite(half)))
    if np.isfinite(half).any():
        k = int(np.nanargmax(half))
        value, at = measure(half[k], sweep.coordinate, file), measure(sweep.values[k], sweep.parameter, file)
        yield f"The largest of the computed half ranges is {value}, at {sweep.parameter} = {at}."
    if failed:
        yield f"{failed} of {half.size} runs ended early and are left out."
    unsettled = sum(not v.settled for v in sweep.computed)
    if unsettled:
        yield f"{unsettled} of {half.size} motions had not settled; shown is their range so far."
    for curve in curves:
        predicted = np.array([curve(v) for v in sweep.values])
        both = np.isfinite(predicted) & np.isfinite(half) & (half > 1e-3 * np.nanmax(half, initial=0.0))
        if both.any() and "unstable" not in curve.label:
            off = 100 * np.abs(predicted[both] / half[both] - 1)
            name = curve.label[0].upper() + curve.label[1:]
            yield f"{name} ({curve.source}) is off by {np.median(off):.3g} % (median), {np.max(off):.3g} % at most."


def pictures(study: StudyResult) -> Iterator[Picture]:
    """Draw the vibration over the sweep; none without one."""
    sweep, curves = study[SWEEP].value, study[CURVES].value or ()
    if sweep is None:
        return
    ax = plot_amplitudes(sweep, study.file.units, curves, study[BRANCH].value, study[QUENCHED].value)
    names = ", ".join(c.label for c in curves) or "no prediction"
    alt = f"Half range of {sweep.coordinate} against {sweep.parameter}: computed points, curves: {names}"
    caption = "Steady vibration: curves predicted, points computed." if curves else "Steady vibration, computed."
    yield Picture(to_svg(ax), alt, caption)


def plot_amplitudes(
    sweep: SweepResult,
    units: Mapping[str, str],
    curves: Sequence[PredictionCurve] = (),
    branch: BranchResult | None = None,
    quenched: np.ndarray | None = None,
    ax: Axes | None = None,
) -> Axes:
    """Draw half range against the swept parameter: predicted curves, limit cycles, computed points, special values."""
    ax = new_axes() if ax is None else ax
    if branch is not None and branch.values.size:
        draw_branch(branch, ax)
    for curve, colour, dash in zip(curves, COLOURS, ((0, (5, 2)), "-", "-", "-."), strict=False):
        ax.plot(curve.values, curve.amplitude, color=colour, linestyle=dash, linewidth=1.4, label=curve.label)
    ax.plot(sweep.values, sweep.half_range, "o", color="black", fillstyle="none", markersize=4.5, label="computed")
    if quenched is not None:
        ax.plot(sweep.values, quenched, "x", color=RED, markersize=5, label="computed, with the fast excitation")
    for (name, value), dash in zip(sweep.marks.items(), ((0, (4, 3)), (0, (1, 2))), strict=False):
        ax.axvline(value, color=GREY, linewidth=0.9, linestyle=dash, label=name)
    ax.set_ylim(bottom=0)
    ax.set_xlabel(label(sweep.parameter, units))
    ax.set_ylabel(f"half range of {label(sweep.coordinate, units)}")
    legend(ax)
    return tidy(ax)


def _data(study: StudyResult, sweep: SweepResult) -> dict[str, object]:
    curves = study[CURVES].value or ()
    return {
        "parameter": sweep.parameter,
        "coordinate": sweep.coordinate,
        "values": sweep.values,
        "half_range": sweep.half_range,
        "largest": [v.largest for v in sweep.computed],
        "smallest": [v.smallest for v in sweep.computed],
        "half_range_quenched": study[QUENCHED].value,
        "predicted": [
            {"label": c.label, "formula": c.source, "values": c.values, "half_range": c.amplitude} for c in curves
        ],
        "marks": dict(sweep.marks),
    }


def _tables(study: StudyResult, sweep: SweepResult) -> dict[str, str]:
    curves, quenched = study[CURVES].value or (), study[QUENCHED].value
    columns = [
        (sweep.parameter, sweep.values),
        ("half_range", sweep.half_range),
        ("largest", [v.largest for v in sweep.computed]),
        ("smallest", [v.smallest for v in sweep.computed]),
        *((c.label, [c(value) for value in sweep.values]) for c in curves),
        *([] if quenched is None else [("half_range with excitation", quenched)]),
    ]
    head, rows = (name for name, _ in columns), zip(*(values for _, values in columns), strict=True)
    return {"amplitude.csv": csv_text(head, rows)}


SWEEP = Section("sweep", _compute, topic="sweep", place=70, page=_page, key="sweep", data=_data, tables=_tables)
QUENCHED = Section("quenched", _quenched)
