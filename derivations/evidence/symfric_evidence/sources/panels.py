"""Figures made of panels of curves: their data, and functions that draw them."""

import re
import textwrap
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

from symfric.report.study.data import plain
from symfric.report.study.drawing.axes import COLOURS, GREY, WIDE, new_axes, tidy
from symfric_evidence.sources.registry import Entry, Finding, Inputs, title

PANEL = (4.4, 3.2)  # inches; two panels side by side are legible at the width of a page
MOST_COLUMNS = 2
HANDLE, LETTER = 0.6, 0.075  # inches in a legend
DASHES = {"solid": "-", "dashed": (0, (4, 2)), "dotted": (0, (1, 1.5)), "none": "none"}
WIDTHS = {"solid": 1.1, "dashed": 1.1, "dotted": 1.0, "none": 1.0}


@dataclass(frozen=True, eq=False)
class PanelCurve:
    """One curve of a panel.

    Attributes
    ----------
    label : str
        "" for a curve that needs no name.
    x, y : ndarray, shape (n,)
    group : int
        Curves of one group share a colour.
    closest : ndarray, shape (n,), or None
        Margin of the closest decision of each run; where it is near 0 the curve jumps.
    dash : str
        "solid", "dashed", "dotted", or "none" for markers alone.
    steps : bool
        Whether the curve is constant between jumps, as the time of a decay by half cycles is.
    marker : str
        As matplotlib has it; "" for none.
    """

    label: str
    x: np.ndarray
    y: np.ndarray
    group: int = 0
    closest: np.ndarray | None = None
    dash: str = "solid"
    steps: bool = False
    marker: str = ""


@dataclass(frozen=True)
class Panel:
    """Curves over common axes.

    Attributes
    ----------
    title, x_label, y_label : str
    curves : tuple of PanelCurve
    log : {"", "y", "both"}
        Which axes are logarithmic.
    x_range, y_range : (float or None, float or None) or None
        What is shown; all where None.
    marks : tuple of (str, float)
        Named values of the horizontal axis.
    levels : tuple of (str, float)
        Named values of the vertical axis.
    """

    title: str
    x_label: str
    y_label: str
    curves: tuple[PanelCurve, ...]
    log: str = ""
    x_range: tuple[float | None, float | None] | None = None
    y_range: tuple[float | None, float | None] | None = None
    marks: tuple[tuple[str, float], ...] = ()
    levels: tuple[tuple[str, float], ...] = ()


@dataclass(frozen=True)
class FigureData:
    """One figure of a source.

    Attributes
    ----------
    name, caption : str
    panels : tuple of Panel
    columns : int
        Panels side by side.
    findings : tuple of Finding
    """

    name: str
    caption: str
    panels: tuple[Panel, ...]
    columns: int = 2
    findings: tuple[Finding, ...] = ()

    def to_dict(self) -> dict[str, object]:
        """Return plain numbers and lists."""
        panels = [
            {
                "title": p.title,
                "x": p.x_label,
                "y": p.y_label,
                "curves": [{"label": c.label, "x": c.x, "y": c.y, "closest": c.closest} for c in p.curves],
            }
            for p in self.panels
        ]
        told: dict[str, object] = plain({"figure": self.name, "caption": self.caption, "panels": panels})
        return told

    def __repr__(self) -> str:
        return f"FigureData({self.name}, {len(self.panels)} panels)"


def panels_entry(make: Callable[[], FigureData]) -> Entry[FigureData]:
    """Return the entry of a function that computes panels; its docstring's first line is the caption."""
    return figure_entry(first_line(make), lambda _inputs: make())


def figure_entry(
    caption: str, compute: Callable[[Inputs], FigureData], *, takes_records: bool = False
) -> Entry[FigureData]:
    """Return the entry of a figure that brings its findings."""
    return Entry(caption, compute, plot_figure, findings=lambda data: data.findings, takes_records=takes_records)


def first_line(function: Callable[..., object]) -> str:
    """Return the first line of a docstring."""
    return (function.__doc__ or "").strip().splitlines()[0]


def plot_panel(panel: Panel, ax: Any = None) -> Any:
    """Draw the curves of one panel; return the Axes."""
    from matplotlib.ticker import MaxNLocator

    ax = new_axes(WIDE) if ax is None else ax
    named = {""}
    for curve in panel.curves:
        label = curve.label if curve.label not in named else None
        named.add(curve.label)
        steps = "steps-mid" if curve.steps else "default"
        style = {"color": COLOURS[curve.group], "linestyle": DASHES[curve.dash], "linewidth": WIDTHS[curve.dash]}
        points = {"marker": curve.marker, "markersize": 4.5, "fillstyle": "none"}
        ax.plot(curve.x, curve.y, label=label, drawstyle=steps, **style, **points)
    for axis, name in ((ax.xaxis, "x"), (ax.yaxis, "y")):
        if panel.log in ("both", name):
            ax.set(**{f"{name}scale": "log"})
            plain_ticks(axis)
        else:
            axis.set_major_locator(MaxNLocator(6, steps=[1, 2, 2.5, 5, 10]))
    limits = {"xlim": panel.x_range, "ylim": panel.y_range}  # None would switch off autoscaling
    ax.set(title=panel.title, xlabel=panel.x_label, ylabel=panel.y_label, **{k: v for k, v in limits.items() if v})
    ax.title.set_fontsize(10)
    _note_values(ax, panel)
    return tidy(ax)


def legend_below(axes: Any) -> None:
    """Draw one legend of all panels below them; equal curves of several panels are named once."""
    from matplotlib.lines import Line2D

    shown: dict[tuple[Any, ...], tuple[Any, str]] = {}
    for ax in np.ravel(axes):
        for handle, name in zip(*ax.get_legend_handles_labels(), strict=True):
            line = isinstance(handle, Line2D)
            look = (handle.get_color(), handle.get_linestyle(), handle.get_marker()) if line else ()
            shown.setdefault((name, *look), (handle, name))
    if not shown:
        return
    handles, names = zip(*shown.values(), strict=True)
    figure = np.ravel(axes)[0].figure
    longest = max(len(re.sub(r"\\[a-z]+", "m", name)) for name in names)
    columns = int(figure.get_figwidth() / (HANDLE + LETTER * longest))
    options = {"ncols": max(1, min(columns, len(names))), "frameon": False, "fontsize": 9}
    figure.legend(handles, names, loc="outside lower center", **options)


def _note_values(ax: Any, panel: Panel) -> None:
    """Draw the named values of both axes, with their names at the upper and the right edge."""
    for name, value in panel.marks:
        ax.axvline(value, color=GREY, linewidth=0.9, linestyle=DASHES["dashed"], zorder=1)
        place = {"xy": (value, 1), "xycoords": ("data", "axes fraction"), "ha": "right", "va": "top"}
        ax.annotate(name, xytext=(-2, -1), textcoords="offset points", fontsize=8, color=GREY, **place)
    for name, value in panel.levels:
        ax.axhline(value, color=GREY, linewidth=0.9, linestyle=DASHES["dashed"], zorder=1)
        place = {"xy": (1, value), "xycoords": ("axes fraction", "data"), "ha": "right", "va": "bottom"}
        ax.annotate(name, xytext=(-2, 1), textcoords="offset points", fontsize=8, color=GREY, **place)


def plot_figure(data: FigureData, axes: Any = None) -> np.ndarray:
    """Draw a figure with all its panels; return the Axes, of a new figure without global state unless given."""
    if axes is None:
        from matplotlib.figure import Figure

        columns = min(data.columns, MOST_COLUMNS)
        rows = -(-len(data.panels) // columns)
        figure = Figure(figsize=(columns * PANEL[0], rows * PANEL[1] + 0.6), layout="constrained")
        axes = figure.subplots(rows, columns, squeeze=False)
        for ax in axes.flat[len(data.panels) :]:
            ax.remove()
        figure.suptitle(_filled(f"{title(data.name)}. {data.caption}", 66 * columns), fontsize=9)
    axes = np.ravel(axes)[: len(data.panels)]
    for panel, ax in zip(data.panels, axes, strict=True):
        plot_panel(panel, ax)
    legend_below(axes)
    return np.asarray(axes)


def _filled(text: str, width: int) -> str:
    """Break lines between words, but not within mathematics."""
    whole = re.sub(r"\$[^$]*\$", lambda formula: formula[0].replace(" ", "\0"), text)
    return textwrap.fill(whole, width).replace("\0", " ")


def plain_ticks(axis: Any) -> None:
    """Label 1, 2 and 5 of every decade of a logarithmic axis with plain numbers."""
    from matplotlib.ticker import FuncFormatter, LogLocator, NullFormatter

    axis.set_major_locator(LogLocator(subs=(1.0, 2.0, 5.0)))
    axis.set_major_formatter(FuncFormatter(lambda value, _place: f"{value:g}"))
    axis.set_minor_formatter(NullFormatter())
