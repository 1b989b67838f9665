"""Table of predictions: each applicable formula and the computed value of the same quantity."""

import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from functools import partial

import numpy as np
import sympy as sp
from markupsafe import Markup

from symfric.design.comparison import Comparison
from symfric.design.plan import Designed, DesignPlan
from symfric.errors import NotFound, SceneError
from symfric.model.excitation import is_excited
from symfric.model.outputs import Max
from symfric.model.scene import Scene
from symfric.model.symbols import SPEED
from symfric.orbits.steady_state import SETTLE, Schedule, Settling, Vibration
from symfric.report.html.elements import heading, paragraph, table
from symfric.report.html.words import number, percent
from symfric.report.study.designs import wording
from symfric.report.study.section import Progress, Section, StudyResult, answer
from symfric.report.study.sections.closed_forms import closed_forms
from symfric.report.study.sections.designs import DESIGNS
from symfric.report.study.sections.flutter import FLUTTER, FlutterResult, open_contacts
from symfric.report.study.sections.motion import MOTION, STEADY
from symfric.report.study.sections.onset import HOPF
from symfric.report.study.sections.prediction import closed_forms_apply
from symfric.report.study.sections.stability import EQUILIBRIUM, base
from symfric.scenefile import SceneFile
from symfric.theory import belt
from symfric.theory.averaging import average
from symfric.theory.equilibrium import Equilibrium, equilibrium
from symfric.theory.hopf import HopfPoint

_ALIKE = 1e-9  # relative difference of coefficients of friction that are the same


@dataclass(frozen=True)
class ComparisonRow:
    """One line of predicted against computed.

    Attributes
    ----------
    quantity, formula : str
    predicted, computed : float
    unit : str
        Of both; "" if none is known.
    caution : str
        Why the formula is not made for this motion, so that the difference is no check; "" if it is.
    """

    quantity: str
    predicted: float
    computed: float
    formula: str
    unit: str = ""
    caution: str = ""

    @property
    def difference(self) -> float:
        """``predicted / computed - 1``; NaN where the computed value is zero."""
        return self.predicted / self.computed - 1 if self.computed else float("nan")


def _compute(study: StudyResult, tell: Progress) -> tuple[ComparisonRow, ...]:
    tell("comparison", 0.95)
    file, onset = study.file, study[HOPF].value
    steady = study[STEADY].value
    if steady is not None and not steady.settled:  # cannot be compared
        steady = None
    rows: list[ComparisonRow] = []
    if steady is not None:
        rows += _of_vibration(file, base(study), study[EQUILIBRIUM].value, steady)
    if closed_forms_apply(file):
        rows += _of_belt(file.scene, onset, steady)
    forms = closed_forms(file, study[MOTION].value, steady)
    rows += [ComparisonRow(what, one, two, source, file.units.get(name, "")) for what, one, two, source, name in forms]
    for made in study[DESIGNS].value or ():
        if made.design.value is not None:
            rows += of_design(file, made.plan, made.design.value)
    first = {r.quantity: i for i, r in reversed(list(enumerate(rows)))}
    rows.sort(key=lambda r: (first[r.quantity], bool(r.caution)))  # grouped by quantity, what applies first
    rows = [r for r in rows if math.isfinite(r.predicted) and math.isfinite(r.computed)]
    flutter = study[FLUTTER].value
    if flutter is not None and onset is not None:
        rows[:0] = of_flutter(file, base(study), flutter, onset)
    if not rows:
        raise NotFound("no formula applies to this scene")
    return tuple(rows)


def _try(formula: Callable[[], float]) -> float:
    """Return a number, NaN where the formula does not apply."""
    try:
        return float(formula())
    except (SceneError, NotFound):
        return math.nan


def _of_vibration(
    file: SceneFile, base: Scene, equilibrium: Equilibrium | None, steady: Vibration
) -> list[ComparisonRow]:
    """Compare averaging with the steady vibration, or the equilibrium position if there is no vibration."""
    name = file.sweep.coordinate if file.sweep else base.system.q[0].name
    try:
        flow = average(base)
        stable = flow.amplitudes[flow.stable]
    except (SceneError, NotFound):
        return []
    if name != base.system.q[0].name:
        return []
    if not stable.size:
        vibrates = steady.half_range > 1e-3 * max(abs(steady.largest), abs(steady.smallest))
        if equilibrium is None or (vibrates and not is_excited(file.scene)):
            return []
        place = float(equilibrium.x[equilibrium.names.index(name)])
        words = "of the slow motion" if is_excited(file.scene) else "of steady sliding"
        return [ComparisonRow(f"mean of {name}", place, steady.mean, f"equilibrium {words}", file.units.get(name, ""))]
    if is_excited(file.scene):
        return []
    amplitude = float(stable[-1])
    period = 2 * math.pi / float(flow.frequency_at(amplitude))
    words, units = "averaging, first order", file.units
    caution = "made for motion without sticking, and this one sticks" if steady.stick_fraction > 0 else ""
    return [
        ComparisonRow(f"half range of {name}", amplitude, steady.half_range, words, units.get(name, ""), caution),
        ComparisonRow("period", period, steady.period, words, units.get("t", ""), caution),
    ]


def _of_belt(scene: Scene, onset: HopfPoint | None, steady: Vibration | None) -> list[ComparisonRow]:
    """Compare the belt's closed forms with eigenvalues and motions."""
    rows = []
    if onset is not None and onset.parameter == "v_b":
        formula = _try(lambda: belt.onset_speed(scene))
        rows.append(
            ComparisonRow(
                "belt speed where vibration starts", formula, onset.value, "Thomsen (19); computed: eigenvalues"
            )
        )
    sticks = steady is not None and steady.stick_fraction > 0
    amplitude = belt.stick_slip_amplitude if sticks else belt.pure_slip_amplitude
    frequency = belt.stick_slip_frequency if sticks else belt.pure_slip_frequency
    sources = (
        ("Thomsen (28), (29), first order", "(28), (29) to second order")
        if sticks
        else ("Thomsen (20), (16), first order", "(20) to second order")
    )
    for order, source in zip((1, 2), sources, strict=True):
        if steady is None:
            break
        half, rate = (_try(partial(formula, scene, order=order)) for formula in (amplitude, frequency))
        rows.append(ComparisonRow("half range of x", half, steady.half_range, source))
        rows.append(ComparisonRow("period", 2 * math.pi / rate, steady.period, source))
    first = _try(lambda: belt.stick_speed(scene))
    if math.isfinite(first):
        computed = _try(lambda: stick_onset(scene, 0.8 * first, 1.1 * first))
        words = "belt speed below which it sticks"
        rows.append(ComparisonRow(words, first, computed, "Thomsen (21)"))
        rows.append(
            ComparisonRow(words, _try(lambda: belt.stick_speed(scene, order=2)), computed, "(21) to second order")
        )
    return rows


def stick_onset(scene: Scene, low: float, high: float) -> float:
    """Return the belt speed between two at which the steady vibration just reaches the belt's speed, by bisection.

    Raises
    ------
    NotFound
        If it sticks at both ends or at none.
    """
    (u,) = scene.system.u
    settling = Settling(scene, Schedule(SETTLE * scene.horizon, scene.horizon), {"fastest": Max(u)})

    def sticks(v_b: float) -> bool:
        return float(settling.measured({"v_b": v_b})["fastest"]) > v_b * (1 - 1e-12)

    if not sticks(low) or sticks(high):
        raise NotFound(f"sticking does not start between v_b = {low:g} and {high:g}")
    while high - low > 1e-9 * high:
        middle = 0.5 * (low + high)
        low, high = (middle, high) if sticks(middle) else (low, middle)
    return 0.5 * (low + high)


def of_design(file: SceneFile, plan: DesignPlan, design: Designed) -> list[ComparisonRow]:
    """Compare a design with closed forms and with its verification on the event-driven model."""
    rows = []
    if closed_forms_apply(file):
        rows += [ComparisonRow(*form) for form in plan.closed_forms(file.scene, design)]
    if isinstance(design.check, Comparison):
        words, told = f"[design.{plan.kind}]; computed: event-driven", wording(file)
        unit = file.units.get((file.sweep.coordinate if file.sweep else file.scene.system.q[0].name), "")
        rows += [
            ComparisonRow(
                told.with_units(r.quantity),
                r.predicted,
                r.computed,
                words,
                unit if "half range" in r.quantity else "",
            )
            for r in design.check.rows
        ]
    return rows


def of_flutter(file: SceneFile, base: Scene, flutter: FlutterResult, onset: HopfPoint) -> list[ComparisonRow]:
    """Compare the onset by the full matrices with the Hopf point of the scene."""
    if not flutter.map.critical:
        return []
    scene = base.where({onset.parameter: onset.value})
    at = answer(equilibrium, scene)
    if at.value is None:
        return []
    mu = coefficient_at(scene, at.value)
    opened = open_contacts(scene, at.value)
    near = min(flutter.map.critical, key=lambda p: abs(p.mu - mu) if np.isfinite(mu) else abs(p.omega - onset.omega))
    words, caution = "full matrices; computed: Hopf point", ""
    if opened:
        caution = f"made for closed contacts, and {opened[0]} is open there"
    elif any(c.law.kinetic.free_symbols & {SPEED} for c in scene.contacts):
        caution = "made without the slope of the law"
    what = f"{flutter.factor or 'coefficient of friction'} at the onset"
    return [
        ComparisonRow(what, near.mu, mu, words, caution=caution),
        ComparisonRow("angular frequency at the onset", near.omega, onset.omega, words, file.units.angular, caution),
    ]


def coefficient_at(scene: Scene, equilibrium: Equilibrium) -> float:
    """Return the coefficient of friction in steady sliding, or the load in its place; NaN if contacts differ in it."""
    values, part = scene.parameter_values(), scene.system.linear
    if not scene.contacts and part is not None and part.scaled:
        return float(part.scaled[0][0].subs(values))
    coefficients = [
        float(c.law.where(values)(abs(equilibrium.sliding[c.name]))) * float(sp.sympify(c.profile).subs(values))
        for c in scene.contacts
        if sp.sympify(c.profile).free_symbols <= set(values)
    ]
    if len(coefficients) < max(1, len(scene.contacts)) or np.ptp(coefficients) > _ALIKE * max(coefficients):
        return float("nan")
    return coefficients[0]


def _page(study: StudyResult) -> Iterator[Markup]:
    comparisons = study[COMPARISON].value
    if not comparisons:
        return
    yield heading("Predicted and computed", "comparison")
    for formula, why in dict.fromkeys((r.formula, r.caution) for r in comparisons if r.caution):
        text = f"{formula[0].upper()}{formula[1:]}: {why}. The table tells how far off it then is; it is no check."
        yield paragraph(study.said(text))
    rows = [
        [
            study.said(r.quantity + (f" [{r.unit}]" if r.unit else "")),
            number(r.predicted),
            number(r.computed),
            percent(r.difference),
            study.said("; ".join(filter(None, (r.formula, r.caution)))),
        ]
        for r in comparisons
    ]
    yield table(["quantity", "predicted", "computed", "difference", "formula"], rows, [1, 2, 3])


def _data(_study: StudyResult, rows: tuple[ComparisonRow, ...]) -> list[dict[str, object]]:
    names = ("quantity", "predicted", "computed", "difference", "formula", "unit", "caution")
    return [{name: getattr(r, name) for name in names} for r in rows]


COMPARISON = Section(
    "comparison", _compute, topic="comparison", place=10, page=_page, key="comparison", data=_data, without=()
)
