"""Flutter of a structure, asked by [flutter]: where modes begin to grow over the coefficient of friction."""

import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass

import numpy as np
import sympy as sp
from markupsafe import Markup

from symfric import structures
from symfric.errors import NotFound
from symfric.model.scene import Scene
from symfric.model.units import Units
from symfric.report.html.elements import Picture, gallery, heading, note, paragraph
from symfric.report.html.words import angular_frequency, listed
from symfric.report.study.drawing.axes import (
    COLOURS,
    GREEN,
    GREY,
    Axes,
    in_brackets,
    label,
    legend,
    new_axes,
    tidy,
    to_svg,
)
from symfric.report.study.section import Progress, Section, StudyResult, answer, csv_text
from symfric.report.study.sections.matrices import is_structure, plan_of, values_of
from symfric.report.study.sections.stability import EQUILIBRIUM
from symfric.scenefile import SceneFile, StructurePlan
from symfric.structures.flutter import Flutter
from symfric.structures.sliding import steady_loads
from symfric.theory.equilibrium import Equilibrium


@dataclass(frozen=True, eq=False)
class FlutterResult:
    """The flutter map of a structure, and where it does not hold.

    Attributes
    ----------
    map : Flutter
    torn : tuple of tuple of str
        For each critical point the contacts that would be under tension in steady sliding there.
    factor : str
        What multiplies the friction matrix, if it is no coefficient of friction but a load.
    """

    map: Flutter
    torn: tuple[tuple[str, ...], ...] = ()
    factor: str = ""


def _compute(study: StudyResult, _tell: Progress) -> FlutterResult:
    scene, plan = study.file.scene, plan_of(study.file)
    asked = plan.flutter
    if asked is None:
        raise NotFound("the file has no [flutter], which says over which coefficients of friction")
    values = values_of(study.file)
    closed = structures.sliding(plan.full, plan.contacts, values)
    flutter_map = structures.flutter(closed, (asked.mu[0], asked.mu[1]), asked.modes, asked.near, asked.grid)
    torn = tuple(_torn(plan, values, p.mu) for p in flutter_map.critical)
    part = scene.system.linear
    factor = "" if scene.contacts or part is None or not part.scaled else str(part.scaled[0][0])
    return FlutterResult(flutter_map, torn, factor)


def _opened(study: StudyResult, _tell: Progress) -> list[str]:
    at = study[EQUILIBRIUM].value
    return [] if at is None else open_contacts(study.file.scene, at)


def _torn(plan: StructurePlan, values: Mapping[str, float], mu: float) -> tuple[str, ...]:
    """Return the contacts that open before steady sliding comes to a coefficient of friction; none if not known."""
    if plan.loaded or plan.full.friction is not None:
        return ()
    loads = answer(steady_loads, plan.full, plan.contacts, values, mu).value or {}
    return tuple(name for name, load in loads.items() if load <= 0)


def open_contacts(scene: Scene, equilibrium: Equilibrium) -> list[str]:
    """Return the contacts whose load is zero in steady sliding: there the flutter map does not hold."""
    part, n = scene.system.linear, len(scene.system.q)
    if part is None:
        return []
    rows = part.values(equilibrium.x[:n], np.zeros(n))
    numbers = {**scene.parameter_values(), **dict(zip(scene.system.q, equilibrium.x, strict=False)), **rows}
    loads = {c.name: sp.sympify(c.normal).subs(numbers) for c in scene.contacts}
    return [name for name, load in loads.items() if load.is_number and float(load) <= 0]


def flutter_in_words(result: FlutterResult, opened: list[str], file: SceneFile) -> list[str]:
    """Return the sentences on where modes begin to grow, the first of them for the summary."""
    flutter = result.map
    low, high = f"{flutter.mu[0]:g}", f"{flutter.mu[-1]:g}"
    if not flutter.critical:
        grows = bool(np.any(flutter.eigenvalues[:, 0].real > 1e-9 * np.max(np.abs(flutter.eigenvalues))))
        words = "A mode already grows at its lower end" if grows else "No mode begins to grow"
        return [f"{words} for {result.factor or 'coefficients of friction'} from {low} to {high}.", *_on_open(opened)]
    name = f"{result.factor} =" if result.factor else "the coefficient of friction"
    lines = []
    for k, point in enumerate(flutter.critical):
        at = f"{name} {point.mu:.5g}"
        if point.omega == 0:
            lines.append(f"At {at} the structure diverges without vibration.")
            continue
        how = "two modes couple" if point.pair[0] != point.pair[1] else "a mode loses its damping"
        lines.append(
            f"From {at} on, small vibrations grow with the angular frequency {angular_frequency(point.omega, file)}: "
            f"{how}."
        )
        if torn := list(result.torn[k]):
            lines[-1] += (
                f" Steady sliding there needs tension in {listed(torn)}, which "
                f"{'opens' if len(torn) == 1 else 'open'} instead: the point does not hold."
            )
    lines += [f"The growth ends at {point.mu:.5g}." for point in flutter.regained]
    return [*lines, *_on_open(opened)]


def _on_open(opened: list[str]) -> list[str]:
    """Return the sentence on contacts that are open in steady sliding."""
    if not opened:
        return []
    names = f"{listed(opened)} {'is' if len(opened) == 1 else 'are'}"
    return [
        f"This holds with all contacts closed. With the values of the file {names} open in steady sliding: trust the "
        "eigenvalues there, in the next section."
    ]


def _summary(study: StudyResult, result: FlutterResult) -> list[str]:
    return flutter_in_words(result, study[OPENED].value or [], study.file)[:1]


def _page(study: StudyResult) -> Iterator[Markup]:
    answered = study[FLUTTER]
    yield heading("Modes and flutter", "flutter")
    if answered.value is None:
        yield note(f"No flutter map: {answered.note}.")
        return
    lines = flutter_in_words(answered.value, study[OPENED].value or [], study.file)
    yield from (paragraph(study.said(line)) for line in lines)
    yield gallery(lambda: _pictures(answered.found, study.file.units))


def _pictures(result: FlutterResult, units: Units) -> list[Picture]:
    """Draw frequencies and growth over the coefficient of friction."""
    at = ", ".join(f"{p.mu:.4g}" for p in result.map.critical) or "none"
    over, count = result.factor or "the coefficient of friction", len(result.map.eigenvalues)
    return [
        Picture(
            to_svg(plot_frequencies(result, units)),
            f"Frequencies of {count} modes against {over}; one grows from {at}",
            "Frequencies of the modes; in colour those that couple.",
        ),
        Picture(
            to_svg(plot_growth(result, units)),
            f"Rates of growth of {count} modes against {over}",
            "Their rates of growth: above zero a small vibration grows.",
        ),
    ]


def plot_frequencies(result: FlutterResult, units: Units, ax: Axes | None = None) -> Axes:
    """Draw the frequencies of modes against the coefficient of friction; those that grow in colour."""
    ax = new_axes() if ax is None else ax
    flutter, hertz = result.map, units.hertz
    scale, unit = (hertz, "Hz") if math.isfinite(hertz) else (1.0, units.angular)
    _lines(flutter, scale * flutter.eigenvalues.imag, ax)
    for point in flutter.critical:
        ax.plot(point.mu, scale * point.omega, "o", color="black", markersize=5)
    ax.set_ylim(bottom=0)
    ax.set_ylabel(("frequency" if math.isfinite(hertz) else "angular frequency") + in_brackets(unit))
    return _over_mu(result, ax)


def plot_growth(result: FlutterResult, units: Units, ax: Axes | None = None) -> Axes:
    """Draw the rates of growth of modes against the coefficient of friction."""
    ax = new_axes() if ax is None else ax
    ax.axhline(0.0, color="black", linewidth=0.8)
    _lines(result.map, result.map.eigenvalues.real, ax)
    for point in result.map.critical:
        ax.plot(point.mu, 0.0, "o", color="black", markersize=5)
    ax.set_ylabel("rate of growth" + in_brackets(units.rate))
    return _over_mu(result, ax)


def _lines(flutter: Flutter, values: np.ndarray, ax: Axes) -> None:
    pairs = {mode: k for k, point in reversed(list(enumerate(flutter.critical))) for mode in point.pair}
    for mode, row in sorted(enumerate(values), key=lambda e: e[0] in pairs):
        number = pairs.get(mode)
        colour = GREY if number is None else COLOURS[(2 * number + (mode == flutter.critical[number].pair[1])) % 6]
        ax.plot(flutter.mu, row, color=colour, linewidth=1.0 if number is None else 1.8)


def _over_mu(result: FlutterResult, ax: Axes) -> Axes:
    flutter = result.map
    for k, point in enumerate(flutter.critical):
        words = "a mode begins to grow" if k == 0 else None
        ax.axvline(point.mu, color="black", linewidth=0.8, linestyle=(0, (4, 3)), label=words)
    for k, point in enumerate(flutter.regained):
        ax.axvline(point.mu, color=GREEN, linewidth=0.8, linestyle=":", label="stops growing" if k == 0 else None)
    ax.set_xlim(flutter.mu[0], flutter.mu[-1])
    ax.set_xlabel(label(result.factor, {}) if result.factor else "coefficient of friction")
    legend(ax, above=1.0)
    return tidy(ax)


def _tables(study: StudyResult, result: FlutterResult) -> dict[str, str]:
    flutter = result.map
    head = [f"{part}_{k + 1}" for k in range(len(flutter.eigenvalues)) for part in ("growth", "frequency")]
    columns = (e for row in flutter.eigenvalues for e in (row.real, row.imag))
    files = {"flutter.csv": csv_text(["mu", *head], zip(flutter.mu, *columns, strict=True))}
    if flutter.critical:
        head = [f"{part}_{k + 1}" for k in range(len(flutter.critical)) for part in ("real", "imaginary")]
        parts = (e for shape in flutter.shapes for e in (shape.real, shape.imag))
        names = plan_of(study.file).full.names
        files["shapes.csv"] = csv_text(["name", *head], zip(names, *parts, strict=True))
    return files


OPENED = Section(
    "opened", _opened, asked=is_structure, key="structure.open_in_steady_sliding", data=lambda _study, names: names
)
FLUTTER = Section(
    "flutter",
    _compute,
    topic="flutter",
    asked=is_structure,
    place=30,
    page=_page,
    rank=2,
    summary=_summary,
    key="structure.flutter",
    data=lambda _study, result: result.map.to_dict(),
    tables=_tables,
)
