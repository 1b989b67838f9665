"""Texts and table rows of the designs of a study, as plain text that the page escapes."""

import math

from symfric.design.plan import Designed, DesignPlan
from symfric.design.wording import Wording, with_unit
from symfric.report.study.drawing.axes import in_brackets
from symfric.scenefile import SceneFile

STATUS = {
    "infimum": "infimum (anything beyond these values will do, however little; these values themselves will not)",
}


def wording(file: SceneFile) -> Wording:
    """Return what sentences on the designs of a file need of its scene."""
    return Wording(file.scene, file.sweep.coordinate if file.sweep else file.scene.system.q[0].name)


def asked(plan: DesignPlan, file: SceneFile) -> str:
    """Return the design problem as a sentence."""
    return f"Asked: {plan.question(wording(file))}."


def result_in_words(design: Designed, file: SceneFile) -> list[str]:
    """Return the result of a design and of its verification as sentences."""
    active = ", ".join(design.active)
    lines = [f"Status: {STATUS.get(design.status, design.status)}."]
    lines[0] += f" Active bounds and conditions: {active}." if active else ""
    if design.corrected:
        values = ", ".join(f"{k} = {v:.6g}" for k, v in design.corrected.items())
        lines.append(f"Corrected on the full model: {values}.")
    lines.append(f"The full model at the optimum: {str(design.check).rstrip('.')}.")
    told = wording(file)
    return [told.with_units(line) for line in lines]


def axis(plan: DesignPlan, text: str, file: SceneFile) -> str:
    """Return the label of the vertical axis of a design's picture, with its unit as far as known."""
    return text + in_brackets(plan.axis_unit(text, wording(file)))


def rows(plan: DesignPlan, design: Designed, file: SceneFile) -> list[tuple[str, float, str]]:
    """Return name, value and unit of the design parameters and of the objective, if it is none of them."""
    made = [(name, value, file.units.get(name, "")) for name, value in design.values.items()]
    if list(design.values.values()) == [design.objective]:
        return made
    label, unit = plan.objective(wording(file))
    return [*made, (label, design.objective, unit)]


def sentence(plan: DesignPlan, design: Designed, file: SceneFile) -> str:
    """Return the sentence of the summary, with values that the full model confirms."""
    working, margin = plan.working(design)
    values = ", ".join(f"{k} = {with_unit(f'{v:.5g}', file.units.get(k, ''))}" for k, v in working.items())
    if not design.check.agrees:
        return f"{plan.heading}: {values} by the design's own model; the full model does not confirm it, see below."
    more = f", {100 * margin:.2g} % more than the least that will do" if 0 < margin < math.inf else ""
    return f"{plan.heading}: {plan.told(values, wording(file))}{more}."
