"""Plot functions of a study. Each takes ``ax=None`` and returns the Axes."""

import base64
import io
import logging
import warnings
from collections.abc import Mapping, Sequence

import numpy as np
import sympy as sp

from symfric.locks import DRAWING, alone
from symfric.report.html.letters import letter

BLUE, ORANGE, GREEN, RED, GREY = "#1f5fa8", "#d9730d", "#2b8a3e", "#b3261e", "#6b7280"
COLOURS = (BLUE, ORANGE, GREEN, "#7048a8", RED, "#0b7285")
SIZE = (5.4, 3.5)  # inches, so that letters stay legible on a narrow screen
WIDE = (7.0, 4.2)  # of figures that a page shows in their full size


def label(name: str, units: Mapping[str, str], unit: str | None = None) -> str:
    """Return a name set as mathematics, with its unit if there is one."""
    return f"${sp.latex(letter(sp.Symbol(name)))}$" + in_brackets(units.get(name) if unit is None else unit)


def in_brackets(unit: str | None) -> str:
    """Return a unit in brackets, with dollar signs escaped."""
    return " [" + unit.replace("$", r"\$") + "]" if unit else ""


def with_units(text: str, units: Mapping[str, str]) -> str:
    """Return the label of an axis with the name of a symbol at its end set as mathematics, with its unit."""
    words, _, name = text.rpartition(" ")
    return f"{words} {label(name, units)}".strip() if name in units else text


def new_axes(size: tuple[float, float] = SIZE):
    """Return the Axes of a new figure without global state."""
    from matplotlib.figure import Figure

    return Figure(figsize=size, layout="constrained").add_subplot()


def legend(ax, columns: int = 2) -> None:
    """Put the legend above the axes and above the power of ten of their ticks."""
    if ax.get_legend_handles_labels()[1]:
        ax.legend(loc="lower center", bbox_to_anchor=(0.5, 1.06), ncols=columns, frameon=False)


def tidy(ax):
    """Apply the common style of ticks, grid and spines; return the Axes."""
    from matplotlib.ticker import MaxNLocator

    from symfric.report.html.ticks import Ticks

    if ax.get_xscale() == ax.get_yscale() == "linear":
        ax.xaxis.set_major_locator(MaxNLocator(7, steps=[1, 2, 2.5, 5, 10]))
        for axis in (ax.xaxis, ax.yaxis):
            axis.set_major_formatter(Ticks(useMathText=True))
        ax.ticklabel_format(style="sci", scilimits=(-2, 4))
    ax.grid(True, color="0.9", linewidth=0.8)
    ax.set_axisbelow(True)
    for side in ("top", "right"):
        ax.spines[side].set_visible(False)
    return ax


def plot_time_history(motion, coordinates: Sequence[str], units: Mapping[str, str], ax=None):
    """Draw coordinates against time; stick intervals are shaded."""
    ax = new_axes() if ax is None else ax
    shaded, word = False, "sticking" if len(motion.sticks) < 2 else "a contact sticks"
    for intervals in motion.sticks.values():
        for start, end in intervals:
            ax.axvspan(start, end, color="0.85", linewidth=0, label=None if shaded else word)
            shaded = True
    for name, colour in zip(coordinates, COLOURS, strict=False):
        ax.plot(motion.t, motion.x[motion.names.index(name)], color=colour, linewidth=1.1, label=label(name, {}))
    ax.set_xlim(motion.t[0], motion.t[-1])
    ax.set_xlabel(label("t", units))
    single = len(coordinates) == 1
    ax.set_ylabel(label(coordinates[0], units) if single else _shared(coordinates, units, "displacement"))
    if shaded or not single:
        legend(ax, 6)
    return tidy(ax)


def _shared(names: Sequence[str], units: Mapping[str, str], word: str) -> str:
    found = {units.get(n, "") for n in names}
    unit = found.pop() if len(found) == 1 else ""
    return word + in_brackets(unit)


def plot_phase_portrait(motion, q: str, u: str, contacts: Sequence[str], units: Mapping[str, str], drive=None, ax=None):
    """Draw velocity against displacement, sticking of the contacts in another colour; `drive`: velocity of sticking."""
    ax = new_axes() if ax is None else ax
    x, v = motion.x[motion.names.index(q)], motion.x[motion.names.index(u)]
    on, inside = motion.sticking(contacts), motion.sticking(contacts, ends=False)
    if drive is not None:
        ax.axhline(drive, color=GREY, linewidth=0.9, linestyle=(0, (4, 3)), label="no sliding")
    words = "slipping" if contacts else None
    ax.plot(x, np.where(inside, np.nan, v), color=BLUE, linewidth=0.9, label=words)
    if on.any():
        waits = {"solid_capstyle": "round", "marker": "o", "markersize": 2.0}  # a wait at one place is a dot
        ax.plot(x, np.where(on, v, np.nan), color=ORANGE, linewidth=2.4, label="sticking", **waits)
    ax.plot(x[0], v[0], "o", color="black", markersize=5, fillstyle="none", label="start")
    ax.set_xlabel(label(q, units))
    ax.set_ylabel(label(u, units))
    legend(ax)
    return tidy(ax)


def plot_friction(curve, unit: str = "", ax=None):
    """Draw the coefficient of friction of a contact against sliding speed or place, and the one when shaken."""
    ax = new_axes() if ax is None else ax
    ax.plot(curve.speed, curve.coefficient, color=BLUE, label="friction law")
    if not curve.place:
        ax.plot(0, curve.stick, "o", color=BLUE, markersize=5, label="largest while sticking")
    for (name, values), colour in zip(curve.effective, COLOURS[1:], strict=False):
        ax.plot(curve.speed, values, color=colour, linestyle=(0, (6, 2)), label=name)
    if curve.operating is not None:
        ax.axvline(curve.operating, color=GREY, linewidth=0.9, linestyle=(0, (4, 3)), label="steady sliding")
    ax.set_xlim(left=min(-0.02 * curve.speed[-1], curve.speed[0]), right=curve.speed[-1])
    ax.set_ylim(bottom=min(0.0, float(np.nanmin(curve.coefficient))))
    ax.set_xlabel(label(curve.place, {}, unit) if curve.place else "sliding speed" + in_brackets(unit))
    ax.set_ylabel("friction force" if curve.is_force else "coefficient of friction")
    legend(ax)
    return tidy(ax)


def plot_amplitudes(sweep, units: Mapping[str, str], branch=None, ax=None):
    """Draw half range against the swept parameter: predicted curves, limit cycles, computed points, special values."""
    ax = new_axes() if ax is None else ax
    if branch is not None and branch.values.size:
        for good, style, words in ((True, "-", "limit cycles"), (False, "--", "unstable limit cycles")):
            if np.any(branch.stable == good):
                shown = np.where(branch.stable == good, branch.half_range, np.nan)
                ax.plot(branch.values, shown, color=ORANGE, linestyle=style, linewidth=1.6, label=words)
        order = np.argsort(branch.values)
        for k, lift in enumerate(branch.lift_off):
            size = np.interp(lift.value, branch.values[order], branch.half_range[order])
            word = "" if k else "a contact lifts off"
            ax.plot(lift.value, size, "D", color=ORANGE, markersize=5, label=word)
    for curve, colour, dash in zip(sweep.curves, COLOURS, ((0, (5, 2)), "-", "-", "-."), strict=False):
        ax.plot(curve.values, curve.amplitude, color=colour, linestyle=dash, linewidth=1.4, label=curve.label)
    ax.plot(sweep.values, sweep.half_range, "o", color="black", fillstyle="none", markersize=4.5, label="computed")
    if sweep.quenched is not None:
        ax.plot(sweep.values, sweep.quenched, "x", color=RED, markersize=5, label="computed, with the fast excitation")
    for (name, value), dash in zip(sweep.marks.items(), ((0, (4, 3)), (0, (1, 2))), strict=False):
        ax.axvline(value, color=GREY, linewidth=0.9, linestyle=dash, label=name)
    ax.set_ylim(bottom=0)
    ax.set_xlabel(label(sweep.parameter, units))
    ax.set_ylabel(f"half range of {label(sweep.coordinate, units)}")
    legend(ax)
    return tidy(ax)


def plot_before_after(before, after, coordinate: str, units: Mapping[str, str], ax=None):
    """Draw one coordinate against time without and with the fast excitation."""
    ax = new_axes() if ax is None else ax
    for motion, colour, words, width in ((before, GREY, "without", 1.0), (after, GREEN, "with", 1.2)):
        x = motion.x[motion.names.index(coordinate)]
        ax.plot(motion.t, x, color=colour, linewidth=width, label=f"{words} the fast excitation")
    ax.set_xlim(before.t[0], before.t[-1])
    ax.set_xlabel(label("t", units))
    ax.set_ylabel(label(coordinate, units))
    legend(ax)
    return tidy(ax)


def plot_eigenvalues(stability, units: Mapping[str, str], ax=None):
    """Draw the eigenvalues of steady sliding in the complex plane; the right half means growth."""
    ax = new_axes() if ax is None else ax
    values = np.asarray(stability.eigenvalues)
    growing = values.real > 0
    ax.axvline(0.0, color="black", linewidth=0.8)
    if growing.any():
        ax.plot(values.real[growing], values.imag[growing], "x", color=RED, markersize=8, label="growing")
    if not growing.all():
        ax.plot(values.real[~growing], values.imag[~growing], "x", color=GREEN, markersize=8, label="decaying")
    reach = 1.3 * (max(np.max(np.abs(values.real)), 1e-12 * np.max(np.abs(values))) or 1.0)
    ax.set_xlim(-reach, reach)
    time = units.get("t")
    ax.set_xlabel("rate of growth" + in_brackets(time and f"1/{time}"))
    ax.set_ylabel("angular frequency" + in_brackets(time and f"rad/{time}"))
    legend(ax)
    return tidy(ax)


def to_svg(ax) -> str:
    """Return the figure of an Axes as a data URI; text as shapes, so that it looks the same everywhere."""
    content = _saved(ax.figure, "svg", metadata={"Date": None, "Creator": None})
    return "data:image/svg+xml;base64," + base64.b64encode(content).decode("ascii")


def png(figure) -> bytes:
    """Return a figure as the content of a PNG file."""
    return _saved(figure, "png", dpi=120)


@alone(DRAWING)
def _saved(figure, kind: str, **options) -> bytes:
    """Return the content of a figure file, without warnings on letters that the font lacks."""
    from matplotlib import rc_context

    stream, log = io.BytesIO(), logging.getLogger("matplotlib.mathtext")
    level = log.level
    log.setLevel(logging.ERROR)
    try:
        # a permanent filter: restoring the previous ones would not be thread-safe
        warnings.filterwarnings("ignore", r"Glyph \d+ .*missing from", UserWarning)
        with rc_context({"svg.fonttype": "path", "svg.hashsalt": "symfric", "path.simplify_threshold": 0.3}):
            figure.savefig(stream, format=kind, **options)
    finally:
        log.setLevel(level)
    return stream.getvalue()
