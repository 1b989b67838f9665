"""Text of a study, as plain sentences that the page escapes."""

import math

import numpy as np
import sympy as sp

from symfric.model.excitation import is_excited
from symfric.model.symbols import counted
from symfric.report.study import designs, structure_words
from symfric.report.study.quantities import angular_frequency, measure, powers_of_ten
from symfric.report.study.study import StudyResult
from symfric.scenefile import SceneFile, belt_speeds

NEUTRAL = 1e-10  # growth over the largest eigenvalue below which it is rounding
STILL = 1e-4  # half range over the largest displacement below which a motion counts as at rest


def paragraphs(text: str) -> list[str]:
    """Return the paragraphs of a description."""
    return [" ".join(p.split()) for p in text.split("\n\n") if p.strip()]


def shown(value) -> str:
    """Return a number, an expression, or a list of them as text."""
    if isinstance(value, list):
        return "[" + ", ".join(shown(v) for v in value) + "]"
    return value if isinstance(value, str) else f"{value:g}"


def percent(value: float) -> str:
    """Return a relative difference as a percentage."""
    if not math.isfinite(value):
        return "–"
    if abs(value) < 1e-12:
        return "< 10⁻¹²"
    size = 100 * value
    text = f"{size:+.2f} %" if abs(size) >= 0.01 else f"{size:+.2g} %"
    return powers_of_ten(text).replace("-", "−")


def scene_in_words(file: SceneFile) -> str:
    """Return a sentence on coordinates, contacts, start and horizon."""
    scene = file.scene
    q, u = scene.system.q, scene.system.u
    pairs = [f"{a.name} (velocity {b.name})" for a, b in zip(q, u, strict=True)]
    numbers = scene.numbers()
    start = ", ".join(f"{s.name} = {measure(float(numbers[s]), s.name, file)}" for s in scene.system.states)
    origin = f"The ready scene {file.model}" if file.model else "Own equations"
    count = counted(len(q), "coordinate")
    rubs = ", ".join(
        f"{c.name}, slipping at {c.slip} under the normal load {c.normal}"
        + (f" with the profile {c.profile}" if c.profile != 1 else "")
        for c in scene.contacts
    )
    contacts = {0: "No dry contact", 1: "One dry contact"}.get(
        len(scene.contacts), f"{len(scene.contacts)} dry contacts"
    )
    end = measure(scene.horizon, "t", file)
    return (
        f"{origin}: {count}, {', '.join(pairs)}. {contacts}{': ' + rubs if rubs else ''}. "
        f"The motion starts at {start} and is followed to t = {end}."
    )


def role(symbol: sp.Symbol, file: SceneFile) -> str:
    """Return the role of a value in the scene, as far as known."""
    roles = []
    if symbol in belt_speeds(file.scene):
        roles.append("drives a contact")
    if file.sweep is not None and file.sweep.parameter == symbol.name:
        low, high = f"{file.sweep.start:g}", measure(file.sweep.stop, symbol.name, file)
        roles.append(f"swept from {low} to {high}")
    if any(symbol.name in plan.varied for plan in file.designs):
        roles.append("designed")
    return ", ".join(roles)


def summary(result: StudyResult) -> list[str]:
    """Return the summary, three or four sentences."""
    file, lines = result.file, []
    speeds = belt_speeds(file.scene)
    at = f" at {speeds[0].name} = {measure(file.scene.numbers()[speeds[0]], speeds[0].name, file)}" if speeds else ""
    stability = result.stability.value
    if stability is not None:
        what = "Steady sliding" if file.scene.contacts else "The equilibrium"
        grows = "is not stable: a small disturbance grows"
        verdict = "is stable: a small disturbance dies out" if stability.stable else grows
        if abs(stability.margin) <= NEUTRAL * np.max(np.abs(stability.eigenvalues), initial=0.0):
            verdict = "is on the edge: a small disturbance neither grows nor dies out"
        more = (
            ". A large one need not: from its start the scene vibrates"
            if stability.stable and _vibrates(result)
            else ""
        )
        lines.append(f"{what}{at} {verdict}{more}.")
    if result.structure is not None:
        lines += structure_words.flutter(result.structure, file)[:1]
    if result.steady.value is not None:
        lines.append(_settled(result))
    if result.hopf.value is not None:
        lines.append(onset(result))
    if result.safe.value is not None:
        lines.append(safe(result))
    made = ((d.plan, d.design.value) for d in result.designs if d.design.value is not None)
    lines += [designs.sentence(plan, design, file) for plan, design in made]
    return lines or ["Nothing could be said of this scene; the reasons are at the end of the page."]


def _vibrates(result: StudyResult) -> bool:
    """Whether the scene settles to a vibration by itself."""
    v = result.steady.value
    return v is not None and v.settled and not _rests(v) and not is_excited(result.file.scene)


def _rests(v) -> bool:
    size = max(abs(v.largest), abs(v.smallest), 1e-300)
    return v.half_range < STILL * size or not math.isfinite(v.period)


def _settled(result: StudyResult) -> str:
    v, name, file = result.steady.found, result.plan.coordinate, result.file
    if not v.settled:
        low, high = measure(v.smallest, name, file), measure(v.largest, name, file)
        return f"The motion has not settled to a periodic one: {v.note}. {name} lies between {low} and {high} so far."
    if _rests(v):
        return f"The motion settles: {name} comes to rest at {measure(0.5 * (v.largest + v.smallest), name, file)}."
    kind = "stick-slip vibration" if v.stick_fraction > 0 else "vibration without sticking"
    if is_excited(file.scene):
        kind = "forced vibration"
    text = f"The motion settles into {kind} with a half range of {measure(v.half_range, name, file)} in {name}"
    text += f" and a period of {measure(v.period, 't', file)}"
    if v.stick_fraction > 0:
        text += f"; it sticks for {100 * v.stick_fraction:.3g} % of the time"
    return text + "."


def onset(result: StudyResult) -> str:
    """Return the sentence on the Hopf point."""
    found = result.hopf.value
    if found is None:
        return f"Onset of vibration: {result.hopf.note}."
    how = {
        "supercritical": "gently: small stable vibrations exist beside the onset",
        "subcritical": "by a jump: beside the onset only large vibrations are stable",
        "degenerate": "as sticking and lift-off decide: the cubic terms vanish",
    }[found.kind]
    if found.kind == "degenerate" and not result.file.scene.contacts:
        how = "as terms beyond the cubic ones decide: those vanish"
    value = measure(found.value, found.parameter, result.file)
    what = "Steady sliding" if result.file.scene.contacts else "The equilibrium"
    return (
        f"{what} changes its stability at {found.parameter} = {value} with the angular frequency "
        f"{angular_frequency(found.omega, result.file)} ({found.kind} Hopf point); vibration sets in {how}."
    )


def safe(result: StudyResult) -> str:
    """Return the sentence on the speed above which nothing vibrates."""
    found, file = result.safe.found, result.file
    if found.overhangs:
        value = measure(float(f"{found.value:.3g}"), found.parameter, file)
        if not found.ended:
            return (
                f"No speed is quiet as far as was tried, up to {found.parameter} = {value}: there small disturbances "
                "die out, but a vibration that has started goes on."
            )
        return (
            f"Quiet from about {found.parameter} = {value}: up to there a vibration that has started goes on, though "
            "small disturbances die out before. The speed to stay above is this one, not the onset."
        )
    value = measure(found.onset, found.parameter, file)
    return f"Quiet above {found.parameter} = {value}: the vibration ends where steady sliding becomes stable."


def motion(result: StudyResult) -> str:
    """Return the sentences on the motion: route, status and accuracy."""
    m = result.motion.found
    sticks = sum(len(v) for v in m.sticks.values())
    text = f"Computed with the route {m.route}"
    if result.file.scene.contacts:
        text += f": {counted(m.events, 'change')} of mode, {counted(sticks, 'interval')} of sticking"
    text += ". "
    text += f"The energies balance to {powers_of_ten(f'{m.energy_residual:.1e}')}."
    return text + (f" It ended early ({m.status}): {m.advice}." if m.advice else "")


def stability_heading(result: StudyResult) -> str:
    """Return the heading of the stability."""
    return f"{'Steady sliding' if result.file.scene.contacts else 'The equilibrium'} and its stability"


def route(result: StudyResult) -> tuple[list[list[str]], list[list[str]]]:
    """Return each route with its verdict, and what the computation leaves out with the reason, as rows."""
    note = result.explanation.note if result.explanation.value is None else str(result.explanation.value)
    lines = [line.strip().partition(": ") for line in note.splitlines() if line.strip()]
    names = [name.rstrip(":") for name, _, _ in lines]
    end = names.index("skipped") if "skipped" in names else len(names)
    rows = [[name, text] for name, (_, _, text) in zip(names, lines, strict=True)]
    return [row for row in rows[:end] if row[0] != "route"], rows[end + 1 :]


def without_answer(result: StudyResult) -> list[str]:
    """Return one line for each reason why parts of the study have no result."""
    topics: dict[str, list[str]] = {}
    for topic, reason in result.skipped().items():
        topics.setdefault(reason, []).append(topic)
    return [f"{', '.join(names)}: {reason}" for reason, names in topics.items()]


def amplitude_heading(result: StudyResult) -> str:
    """Return the heading of the sweep."""
    sweep, file = result.sweep.value, result.file
    if sweep is None:
        return "Amplitude"
    belts = file.model is not None or any("belt" in c.name for c in file.scene.contacts)
    is_speed = sweep.parameter in {s.name for s in belt_speeds(file.scene)}
    return f"Amplitude against {'belt speed' if belts and is_speed else sweep.parameter}"


def amplitude(result: StudyResult) -> list[str]:
    """Return the sentences on the sweep."""
    sweep, half = result.sweep.found, result.sweep.found.half_range
    lines = []
    failed = int(np.sum(~np.isfinite(half)))
    if np.isfinite(half).any():
        k = int(np.nanargmax(half))
        value = measure(half[k], sweep.coordinate, result.file)
        at = measure(sweep.values[k], sweep.parameter, result.file)
        lines.append(f"The largest of the computed half ranges is {value}, at {sweep.parameter} = {at}.")
    if failed:
        lines.append(f"{failed} of {half.size} runs ended early and are left out.")
    unsettled = sum(not v.settled for v in sweep.computed)
    if unsettled:
        lines.append(f"{unsettled} of {half.size} motions had not settled; shown is their range so far.")
    for curve in sweep.curves:
        predicted = np.array([curve(v) for v in sweep.values])
        both = np.isfinite(predicted) & np.isfinite(half) & (half > 1e-3 * np.nanmax(half, initial=0.0))
        if both.any() and "unstable" not in curve.label:
            off = 100 * np.abs(predicted[both] / half[both] - 1)
            name = curve.label[0].upper() + curve.label[1:]
            lines.append(
                f"{name} ({curve.source}) is off by {np.median(off):.3g} % (median), {np.max(off):.3g} % at most."
            )
    if sweep.curves_note:
        lines.append(f"No prediction: {sweep.curves_note}.")
    return lines
