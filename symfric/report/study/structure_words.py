"""Text of the study of a structure, as plain sentences that the page escapes."""

import math

import numpy as np

from symfric.model.symbols import counted
from symfric.report.study.branches import BranchResult
from symfric.report.study.quantities import angular_frequency, measure, measured
from symfric.report.study.structural import StructureResult
from symfric.scenefile import SceneFile, StructurePlan

_LISTED = 6  # names in a sentence


def scene_in_words(plan: StructurePlan, file: SceneFile) -> str:
    """Return the sentences on matrices, reduction, contacts and start."""
    full, small, scene = plan.full, plan.small, file.scene
    parts = [n for n, e in (("M", full.M), ("K", full.K), ("C", full.C), ("friction", full.friction)) if e is not None]
    text = f"The matrices {', '.join(parts)} of {plan.origin} have {counted(full.n, 'degree')} of freedom"
    if small is not full:
        text += (
            f", reduced to {small.n} coordinates: what contacts, forces and points act on, and modes with these held"
        )
    contacts = [c.name for c in scene.contacts]
    text += f". {counted(len(contacts), 'dry contact') if contacts else 'No dry contact'}"
    text += f": {_listed(contacts)}. " if contacts else ". "
    if plan.points:
        text += f"It is looked at in {_listed(list(plan.points))}. "
    numbers = scene.numbers()
    moved = [f"{s.name} = {measure(float(numbers[s]), s.name, file)}" for s in scene.system.states if numbers[s]]
    start = f"with {_listed(moved)}, otherwise at rest" if moved else "at rest"
    return text + f"The motion starts {start}, and is followed to t = {measure(scene.horizon, 't', file)}."


def _listed(names: list[str]) -> str:
    more = len(names) - _LISTED
    return ", ".join(names[:_LISTED]) + (f" and {more} more" if more > 0 else "")


def reduction(plan: StructurePlan, file: SceneFile) -> str:
    """Return what the reduction costs; empty without one."""
    error = plan.small.error
    if error is None:
        return ""
    worst = float(np.max(error.frequency_error, initial=0.0))
    response = float(np.max(error.response, initial=0.0))
    return (
        f"What the reduction costs, estimated: frequencies up to {angular_frequency(0.5 * error.cut, file)} change by "
        f"{_percent(worst)} at most. The response of what is kept to a force along itself changes by "
        f"{_percent(response)} at worst, beside a resonance that shifts. More modes make both smaller."
    )


def _percent(part: float) -> str:
    return f"{100 * part:.0f} %" if part >= 0.1 else f"{100 * part:.2g} %"


def flutter(found: StructureResult, file: SceneFile) -> list[str]:
    """Return the sentences on where modes begin to grow, the first of them for the summary."""
    flutter = found.flutter.value
    if flutter is None:
        return []
    low, high = f"{flutter.mu[0]:g}", f"{flutter.mu[-1]:g}"
    if not flutter.critical:
        grows = bool(np.any(flutter.eigenvalues[:, 0].real > 1e-9 * np.max(np.abs(flutter.eigenvalues))))
        words = "already grows at its lower end" if grows else "begins to grow"
        none = "A mode" if grows else "No mode"
        return [
            f"{none} {words} for {found.factor or 'coefficients of friction'} from {low} to {high}.",
            *_opened(found),
        ]
    name = f"{found.factor} =" if found.factor else "the coefficient of friction"
    at = lambda mu: f"{name} {mu:.5g}"  # noqa: E731
    lines = []
    for k, point in enumerate(flutter.critical):
        if point.omega == 0:
            lines.append(f"At {at(point.mu)} the structure diverges without vibration.")
            continue
        how = "two modes couple" if point.pair[0] != point.pair[1] else "a mode loses its damping"
        lines.append(
            f"From {at(point.mu)} on, small vibrations grow with the angular frequency "
            f"{angular_frequency(point.omega, file)}: {how}."
        )
        torn = list(found.torn[k]) if k < len(found.torn) else []
        if torn:
            lines[-1] += (
                f" Steady sliding there needs tension in {_listed(torn)}, which "
                f"{'opens' if len(torn) == 1 else 'open'} instead: the point does not hold."
            )
    lines += [f"The growth ends at {point.mu:.5g}." for point in flutter.regained]
    return [*lines, *_opened(found)]


def _opened(found: StructureResult) -> list[str]:
    """Return the sentence on contacts that are open in steady sliding."""
    if not found.opened:
        return []
    names = f"{_listed(list(found.opened))} {'is' if len(found.opened) == 1 else 'are'}"
    return [
        f"This holds with all contacts closed. With the values of the file {names} open in steady sliding: trust the "
        "eigenvalues there, in the next section."
    ]


def branch(found: BranchResult, file: SceneFile) -> list[str]:
    """Return the sentences on the limit cycles."""
    if not found.branch.orbits:
        return ["No limit cycle was found."]
    order = np.argsort(found.values)
    low, high = (measure(float(found.values[k]), found.parameter, file) for k in order[[0, -1]])
    begin = "from the onset on" if found.from_onset else "from the settled motion on"
    stable = int(np.sum(found.stable))
    kinds = "all stable" if stable == found.stable.size else f"{stable} of them stable"
    lines = [
        f"{counted(found.values.size, 'limit cycle')} from {found.parameter} = {low} to {high}, "
        f"followed {begin}; {kinds}."
    ]
    if found.cut:
        lines[0] += f" It goes on: no more than {found.cut} were computed."
    for lift in found.lift_off[:_LISTED]:
        size = float(np.interp(lift.value, found.values[order], found.half_range[order]))
        at = measure(lift.value, found.parameter, file)
        lines.append(
            f"Contact {lift.contact} first lifts off at {found.parameter} = {at}, where the half range of "
            f"{found.coordinate} is about {measure(size, found.coordinate, file)}."
        )
    for special in found.branch.special:
        if special.kind != "hopf" and math.isfinite(special.value):
            at = measure(float(special.value), found.parameter, file)
            lines.append(f"{_KINDS.get(special.kind, special.kind)} at {found.parameter} = {at}.")
    return lines


_KINDS = {
    "fold": "The branch turns back",
    "flip": "The period doubles",
    "neimark-sacker": "A second frequency begins",
    "stick-onset": "Sticking begins",
    "grazing": "A contact touches zero slip",
}


def frequency(omega: float, file: SceneFile) -> list[str]:
    """Return an angular frequency, and in Hz where time has a unit."""
    hertz = file.units.hertz
    return [measured(omega, ""), *([f"{omega * hertz:.5g}"] if math.isfinite(hertz) else [])]
