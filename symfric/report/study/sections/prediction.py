"""Predicted amplitudes over a range of values: averaging and closed forms."""

from dataclasses import dataclass

import numpy as np
import sympy as sp

from symfric.errors import NotFound, SceneError
from symfric.locks import SYMBOLIC, alone
from symfric.model.excitation import is_excited
from symfric.model.numeric import numeric_function
from symfric.model.scene import Scene
from symfric.report.study.section import Progress, Section, StudyResult, answer
from symfric.report.study.sections.stability import SLOW
from symfric.scenefile import SceneFile
from symfric.theory import belt
from symfric.theory.averaging import average
from symfric.theory.belt.scene import SYMBOLS, numbers
from symfric.theory.slow_flow import SlowFlow, evaluator, stationary

FINE = 201  # most points of a curve
RARE = 16  # most values for numeric slow flows, each built anew; a symbolic one serves all values


@dataclass(frozen=True, eq=False)
class PredictionCurve:
    """A curve of predicted amplitudes.

    Attributes
    ----------
    label : str
    source : str
        The formula.
    values, amplitude : ndarray, shape (n,)
        NaN where the formula gives no vibration.
    """

    label: str
    source: str
    values: np.ndarray
    amplitude: np.ndarray

    def __call__(self, value: float) -> float:
        """Return the amplitude at one of `values`, or between two of them."""
        return float(np.interp(value, self.values, self.amplitude))


@alone(SYMBOLIC)
def averaged_curves(scene: Scene, parameter: str, values: np.ndarray) -> list[PredictionCurve]:
    """Return the stable and, where there are any, the unstable amplitudes of first-order averaging."""
    flow = average(scene)
    if parameter not in {s.name for s in flow.values}:
        values = np.linspace(values[0], values[-1], RARE)
    elif flow.rate.has(sp.Integral):
        values = values[::4]
    amplitudes = [_amplitudes(scene, flow, parameter, float(v)) for v in values]
    source = "sf.average, first order"
    stable = np.array([max((a for a, good in pairs if good), default=np.nan) for pairs in amplitudes])
    unstable = np.array([max((a for a, good in pairs if not good), default=np.nan) for pairs in amplitudes])
    curves = []
    if _has_a_line(stable):
        curves.append(PredictionCurve("averaging", source, values, stable))
    if _has_a_line(unstable):
        curves.append(PredictionCurve("averaging, unstable", source, values, unstable))
    if not curves:
        raise NotFound("averaging finds no vibration on this range")
    return curves


def _has_a_line(amplitude: np.ndarray) -> bool:
    """Whether two neighbouring values have an amplitude, so that something would be drawn."""
    finite = np.isfinite(amplitude)
    return bool((finite[1:] & finite[:-1]).any())


def _amplitudes(scene: Scene, flow: SlowFlow, parameter: str, value: float) -> list[tuple[float, bool]]:
    """Return the stationary amplitudes at one value; none where the formulas do not hold."""
    try:
        if parameter not in {s.name for s in flow.values}:
            flow = average(scene.where({parameter: value}))
            pairs = flow.amplitudes, flow.stable
        else:
            numbers = {parameter: value}
            pairs = stationary(evaluator(flow, flow.rate, numbers), _edges(flow, numbers))
    except (SceneError, NotFound):
        return []
    return [(float(a), bool(s)) for a, s in zip(*pairs, strict=True)]


def _edges(flow: SlowFlow, changed: dict[str, float]) -> tuple[float, ...]:
    """Return the amplitudes at which the rate changes its formula."""
    numbers = {s: changed.get(s.name, v) for s, v in flow.values.items()}
    edges = set()
    for relation in flow.rate.atoms(sp.core.relational.Relational):
        for side in (relation.lhs, relation.rhs):
            edge = side.subs(numbers)
            if edge.is_number:
                edges.add(float(edge))
    return tuple(sorted(edges))


@alone(SYMBOLIC)
def belt_curves(scene: Scene, values: np.ndarray) -> list[PredictionCurve]:
    """Return the belt's closed forms of first and second order over belt speeds."""
    given = dict(zip(SYMBOLS, numbers(scene), strict=True))
    speed = SYMBOLS.v_b
    del given[speed]
    curves = []
    for order, words, source in ((1, "first", "Thomsen (20), (28)"), (2, "second", "(20), (28) to second order")):
        parts = (f(order=order, symbolic=True) for f in (belt.stick_slip_amplitude, belt.pure_slip_amplitude))
        sticking, slipping = (numeric_function((speed,), sp.sympify(f).subs(given))(values) for f in parts)
        low, high = belt.stick_speed(scene, order=order), belt.onset_speed(scene)
        amplitude = np.where(values <= low, sticking, np.where(values < high, slipping, np.nan))
        curves.append(PredictionCurve(f"closed form, {words} order", source, values, amplitude))
    return curves


def closed_forms_apply(file: SceneFile) -> bool:
    """Whether the belt's closed forms apply: the ready scene with the cubic law, not excited."""
    cubic = not file.laws or file.laws[0].law == "cubic"
    return file.model == "mass_on_belt" and cubic and not is_excited(file.scene)


def _compute(study: StudyResult, _tell: Progress) -> tuple[PredictionCurve, ...]:
    file, plan = study.file, study.file.sweep
    if plan is None or study.sweep.value is None:  # said of the sweep
        return ()
    slow = study[SLOW].found
    q = slow.system.q
    if file.structure is not None and len(q) > 1:
        raise NotFound(f"averaging takes one coordinate and its velocity, and the structure has {len(q)}")
    if plan.coordinate != q[0].name:
        raise NotFound(f"averaging speaks of the coordinate {q[0].name}, not of {plan.coordinate}")
    fine = np.linspace(plan.start, plan.stop, min(4 * plan.number - 3, FINE))
    averaged = answer(averaged_curves, slow, plan.parameter, fine)
    curves, reason = list(averaged.value or ()), averaged.note
    if closed_forms_apply(file) and plan.parameter == "v_b":
        closed = answer(belt_curves, slow, fine)
        curves += closed.value or ()
        reason = reason or closed.note
    if not curves:
        raise NotFound(reason)
    return tuple(curves)


CURVES = Section("curves", _compute, topic="predicted amplitudes")
