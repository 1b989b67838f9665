"""Texts and table rows of the designs of a study, as plain text that the page escapes."""

from collections.abc import Mapping

from symfric.design.result import Design
from symfric.scenefile import DesignPlan, SceneFile

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


def interval(pair) -> str:
    """Return a range as text."""
    return f"{pair[0]:g} to {pair[1]:g}"


def heading(plan: DesignPlan) -> str:
    """Return the heading of a design."""
    return HEADINGS[plan.kind]


def asked(plan: DesignPlan) -> str:
    """Return the design problem as a sentence."""
    return f"Asked: {_QUESTIONS[plan.kind](plan.arguments)}{_limits(plan.arguments)}."


def _quench(given: Mapping) -> str:
    words = (
        f"the smallest {given['minimise']} that stops the vibration for belt speeds from {interval(given['speeds'])}"
    )
    return words + (f", with a damping of {given['margin']:g} left" if given["margin"] else "")


def _damper(given: Mapping) -> str:
    words = f"the smallest {given['parameter']} from {interval(given['bounds'])} with which "
    at = f" at speeds from {interval(given['speeds'])}" if "speeds" in given else ""
    most = f"a half range of at most {given['half_range']:g}"
    if "settle" in given:
        words += f"{most} is left" if given["half_range"] else "the motion is at rest"
        return f"{words} by t = {given['settle']:g}{at}"
    words += f"the vibration has {most}" if given["half_range"] else "nothing vibrates"
    return words + ("" if given["sticking"] else ", without sticking") + at


def _positioning(given: Mapping) -> str:
    return (
        f"{given['parameter']} from {interval(given['bounds'])} for the least positioning error without stick-slip at "
        f"speeds from {interval(given['speeds'])}"
    )


def _absorber(given: Mapping) -> str:
    words = f"tuning and damping for {CRITERIA[given['criterion']]}, with the mass ratio {given['mass_ratio']:g}"
    return words + (f" and dry friction {given['friction']:g}" if "contact" in given else "")


def _bounds(given: Mapping) -> str:
    return " and ".join(f"{name} from {interval(pair)}" for name, pair in given["bounds"].items())


def _isolator(given: Mapping) -> str:
    count = len(given["motions"])
    over = f"the {given['over']} of {count} motions" if count > 1 else "one motion"
    return f"{_bounds(given)} for the least {given['minimise']}, {over}"


def _contact_damper(given: Mapping) -> str:
    words = f"{_bounds(given)} for the soonest rest"
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


def _limits(given: Mapping) -> str:
    words = [f"{'at least' if n == 'friction' else 'at most'} {v:g} of {n}" for n, v in given.get("limits", {}).items()]
    return f"; {', '.join(words)}" if words else ""


def found(design: Design) -> list[str]:
    """Return the result of a design and of its verification as sentences."""
    active = ", ".join(design.active)
    lines = [f"Status: {STATUS.get(design.status, design.status)}."]
    lines[0] += f" Active bounds and conditions: {active}." if active else ""
    if design.corrected:
        values = ", ".join(f"{k} = {v:.6g}" for k, v in design.corrected.items())
        lines.append(f"Corrected on the full model: {values}.")
    return [*lines, f"The full model at the optimum: {str(design.check).rstrip('.')}."]


def rows(plan: DesignPlan, design: Design, file: SceneFile) -> list[tuple[str, float, str]]:
    """Return name, value and unit of the design parameters and of the objective."""
    made = [(name, value, file.units.get(name, "")) for name, value in design.values.items()]
    label, unit = objective(plan, file)
    return [*made, (label, design.objective, unit)]


def objective(plan: DesignPlan, file: SceneFile) -> tuple[str, str]:
    """Return the name of the objective and its unit, as far as known."""
    given = plan.arguments
    match plan.kind:
        case "quench":
            return {"intensity": "a*Omega", "power": "mean power", "force": "a*Omega**2"}[given["minimise"]], ""
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


def sentence(plan: DesignPlan, design: Design, file: SceneFile) -> str:
    """Return the sentence of the summary."""
    pairs = ((k, v, file.units.get(k, "")) for k, v in design.values.items())
    values = ", ".join(f"{k} = {v:.5g}{' ' + unit if unit else ''}" for k, v, unit in pairs)
    if plan.kind == "quench":
        speeds = interval(plan.arguments["speeds"])
        return f"The excitation {values} is designed to keep it quiet for belt speeds from {speeds}."
    return f"{heading(plan)}: {values}."
