"""Texts and table rows of the designs of a study, as plain text that the page escapes."""

import math
import re
from collections.abc import Mapping

from symfric.design.damper.design import DamperCheck
from symfric.design.quench.multipliers import MultiplierCheck
from symfric.design.result import Design
from symfric.model.symbols import TIME
from symfric.report.study.drawing.axes import in_brackets
from symfric.scenefile import DesignPlan, SceneFile, belt_speeds

_NUMBER = r"([-−]?\d++(?:\.\d++)?+(?:e[+-]?\d++)?+)"
HEADINGS = {
    "quench": "Stopping the vibration by a fast excitation",
    "damper": "The smallest damper",
    "positioning": "The least positioning error",
    "absorber": "A tuned mass damper",
    "isolator": "Damping and friction of the isolator",
    "contact_damper": "The soonest rest by a contact",
}
CRITERIA = {
    "hinf": "the least peak of the amplitude",
    "h2": "the least mean square under white noise",
    "decay": "the fastest decay",
    "self-excited": "the most self-excitation that is still stable",
}
STATUS = {
    "infimum": "infimum (anything beyond these values will do, however little; these values themselves will not)",
}


def interval(pair, unit: str = "") -> str:
    """Return a range as text."""
    return f"{pair[0]:g} to {number(pair[1], unit)}"


def number(value: float, unit: str = "") -> str:
    """Return a number with its unit."""
    return f"{value:g} {unit}" if unit else f"{value:g}"


def heading(plan: DesignPlan) -> str:
    """Return the heading of a design."""
    return HEADINGS[plan.kind]


def asked(plan: DesignPlan, file: SceneFile) -> str:
    """Return the design problem as a sentence."""
    return f"Asked: {_QUESTIONS[plan.kind](plan.arguments, file)}{_limits(plan.arguments, file)}."


def _speeds(given: Mapping, file: SceneFile) -> str:
    """Return the range of speeds with its unit."""
    name = given.get("speed") or next((s.name for s in belt_speeds(file.scene)), "")
    return interval(given["speeds"], file.units.get(name, ""))


def _quench(given: Mapping, file: SceneFile) -> str:
    words = f"the smallest {given['minimise']} that stops the vibration for speeds from {_speeds(given, file)}"
    return words + (f", with a damping of {given['margin']:g} left" if given["margin"] else "")


def _damper(given: Mapping, file: SceneFile) -> str:
    coordinate = file.sweep.coordinate if file.sweep else file.scene.system.q[0].name
    bounds = interval(given["bounds"], file.units.get(given["parameter"], ""))
    words = f"the smallest {given['parameter']} from {bounds} with which "
    at = f" at speeds from {_speeds(given, file)}" if "speeds" in given else ""
    most = f"a half range of at most {number(given['half_range'], file.units.get(coordinate, ''))}"
    if "settle" in given:
        words += f"{most} is left" if given["half_range"] else "the motion is at rest"
        return f"{words} by t = {number(given['settle'], file.units.get('t', ''))}{at}"
    words += f"the vibration has {most}" if given["half_range"] else "nothing vibrates"
    return words + ("" if given["sticking"] else ", without sticking") + at


def _positioning(given: Mapping, file: SceneFile) -> str:
    bounds = interval(given["bounds"], file.units.get(given["parameter"], ""))
    return (
        f"{given['parameter']} from {bounds} for the least positioning error without stick-slip at "
        f"speeds from {_speeds(given, file)}"
    )


def _absorber(given: Mapping, file: SceneFile) -> str:
    words = f"tuning and damping for {CRITERIA[given['criterion']]}, with the mass ratio {given['mass_ratio']:g}"
    return words + (f" and dry friction {given['friction']:g}" if "contact" in given else "")


def _bounds(given: Mapping, file: SceneFile) -> str:
    return " and ".join(
        f"{name} from {interval(pair, file.units.get(name, ''))}" for name, pair in given["bounds"].items()
    )


def _isolator(given: Mapping, file: SceneFile) -> str:
    count = len(given["motions"])
    over = f"the {given['over']} of {count} motions" if count > 1 else "one motion"
    return f"{_bounds(given, file)} for the least {given['minimise']}, {over}"


def _contact_damper(given: Mapping, file: SceneFile) -> str:
    words = f"{_bounds(given, file)} for the soonest rest"
    words += f", within {given['residual']:g} of the middle" if "residual" in given else ""
    return words + (f", by {100 * given['margin']:g} % within the stick limit" if given["margin"] else "")


_QUESTIONS = {
    "quench": _quench,
    "damper": _damper,
    "positioning": _positioning,
    "absorber": _absorber,
    "isolator": _isolator,
    "contact_damper": _contact_damper,
}


def _limits(given: Mapping, file: SceneFile) -> str:
    units = quantities(file)
    words = [
        f"at least {100 * v:g} % of the friction is left"
        if n == "friction"
        else f"{n} at most {number(v, units.get(n, ''))}"
        for n, v in given.get("limits", {}).items()
    ]
    return f"; {', '.join(words)}" if words else ""


def quantities(file: SceneFile) -> dict[str, str]:
    """Return the units of what designs report, as far as known."""
    system, units = file.scene.system, file.units
    coordinate = file.sweep.coordinate if file.sweep else system.q[0].name
    u, power = system.u[0], system.mass[0, 0] * system.u[0] ** 2 / TIME
    return {
        "half range": units.get(coordinate, ""),
        "displacement": units.get(system.q[0].name, ""),
        "velocity": units.get(u.name, ""),
        "acceleration": units.of(u / TIME),
        "force": units.of(system.mass[0, 0] * u / TIME),
        "power": units.of(power),
        "rate": units.rate,
        "damping": units.of(1 / TIME),
        "time of rest": units.get("t", ""),
    }


def with_all_units(text: str, file: SceneFile) -> str:
    """Return a sentence of a design with units behind its numbers, those of symbols and those of named quantities."""
    units = quantities(file)
    known = {**{f"{name} =": unit for name, unit in file.units.items()}, **units}
    for words, unit in known.items():
        if unit:
            text = re.sub(
                rf"(?<!\w)({re.escape(words)}(?:(?: of [a-z ]+| at [^:;()]+)?:)? ){_NUMBER}(?! ?[\w/%])",
                rf"\1\2 {unit}",
                text,
            )
    return text


def found(design: Design, file: SceneFile) -> list[str]:
    """Return the result of a design and of its verification as sentences."""
    active = ", ".join(design.active)
    lines = [f"Status: {STATUS.get(design.status, design.status)}."]
    lines[0] += f" Active bounds and conditions: {active}." if active else ""
    if design.corrected:
        values = ", ".join(f"{k} = {v:.6g}" for k, v in design.corrected.items())
        lines.append(f"Corrected on the full model: {values}.")
    lines.append(f"The full model at the optimum: {str(design.check).rstrip('.')}.")
    return [with_all_units(line, file) for line in lines]


def axis(plan: DesignPlan, text: str, file: SceneFile) -> str:
    """Return the label of the vertical axis of a design's picture, with its unit as far as known."""
    if plan.kind in ("absorber", "positioning", "isolator"):  # dimensionless, or with its unit
        return text
    unit = next((u for words, u in quantities(file).items() if text.startswith(words)), "")
    name = text.rpartition(" ")[2]
    unit = unit or (file.units.get(name, "") if text.startswith("required") else "")
    return text + in_brackets(unit)


def rows(plan: DesignPlan, design: Design, file: SceneFile) -> list[tuple[str, float, str]]:
    """Return name, value and unit of the design parameters and of the objective."""
    made = [(name, value, file.units.get(name, "")) for name, value in design.values.items()]
    if plan.kind == "damper" and list(design.values.values()) == [design.objective]:
        return made
    label, unit = objective(plan, file)
    return [*made, (label, design.objective, unit)]


def objective(plan: DesignPlan, file: SceneFile) -> tuple[str, str]:
    """Return the name of the objective and its unit, as far as known."""
    given = plan.arguments
    match plan.kind:
        case "quench":
            words = {"intensity": "intensity a Ω", "power": "mean power", "force": "acceleration a Ω²"}
            unit = {"intensity": "velocity", "power": "power", "force": "acceleration"}[given["minimise"]]
            return words[given["minimise"]], quantities(file)[unit]
        case "damper":
            return f"least {given['parameter']}", file.units.get(given["parameter"], "")
        case "positioning":
            return "positioning error", "v*/omega_n"
        case "absorber":
            return CRITERIA[given["criterion"]].removeprefix("the "), ""
        case "contact_damper":
            return "time of rest", "s"
    unit = {"acceleration": "m/s²", "velocity": "m/s"}.get(given["minimise"], "m")
    return f"{given['over']} {given['minimise']}", unit


def working(plan: DesignPlan, design: Design) -> tuple[dict[str, float], float]:
    """Return values with which the requirement was met on the full model, and by how much they exceed the optimum."""
    check, values = design.check, dict(design.corrected or design.values)
    if isinstance(check, MultiplierCheck) and values.get("a"):
        return {**values, "a": values["a"] * (1 + check.step)}, check.step
    if isinstance(check, DamperCheck):
        (name,) = design.values
        least = design.values[name]
        return {name: check.above.damping}, check.above.damping / least - 1 if least else math.inf
    if plan.kind == "damper":
        return {name: _rounded_up(value) for name, value in values.items()}, 0.0
    return values, 0.0


def _rounded_up(value: float) -> float:
    """Return a number with five digits that is not smaller."""
    unit = 10.0 ** (math.floor(math.log10(abs(value))) - 4) if value else 1.0
    return math.ceil(value / unit) * unit


def sentence(plan: DesignPlan, design: Design, file: SceneFile) -> str:
    """Return the sentence of the summary, with values that the full model confirms."""
    found, margin = working(plan, design)
    values = ", ".join(f"{k} = {with_unit(v, file.units.get(k, ''))}" for k, v in found.items())
    head = heading(plan)
    if not design.check.agrees:
        return f"{head}: {values} by the design's own model; the full model does not confirm it, see below."
    more = f", {100 * margin:.2g} % more than the least that will do" if 0 < margin < math.inf else ""
    if plan.kind == "quench":
        return f"{head}: {values} keep it quiet for speeds from {_speeds(plan.arguments, file)}{more}."
    if plan.kind == "damper":
        _, _, purpose = _damper(plan.arguments, file).partition(" with which ")
        return f"{head}: with {values} {purpose}{more}."
    return f"{head}: {values}{more}."


def with_unit(value: float, unit: str) -> str:
    """Return a number of five digits with its unit."""
    return f"{value:.5g} {unit}" if unit else f"{value:.5g}"
