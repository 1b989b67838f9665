"""The common style of figures: colours, labels with units, ticks, legends, files."""

import base64
import io
import logging
import warnings
from collections.abc import Callable, Mapping
from typing import TYPE_CHECKING, Any

import sympy as sp

from symfric.locks import DRAWING, alone
from symfric.report.html.letters import letter

if TYPE_CHECKING:  # slow to import
    from matplotlib.axes import Axes as Axes
    from matplotlib.figure import Figure as Figure
else:
    Axes = Figure = Any

BLUE, ORANGE, GREEN, RED, GREY = "#1f5fa8", "#d9730d", "#2b8a3e", "#b3261e", "#6b7280"
COLOURS = (BLUE, ORANGE, GREEN, "#7048a8", RED, "#0b7285")
SIZE = (5.4, 3.5)  # inches, so that letters stay legible on a narrow screen
WIDE = (7.0, 4.2)  # of figures that a page shows in their full size
_LONGEST = 16  # letters of a name on an axis
_DOTS = 120  # of a PNG, per inch


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


def new_axes(size: tuple[float, float] = SIZE) -> Axes:
    """Return the Axes of a new figure without global state."""
    from matplotlib.figure import Figure

    return Figure(figsize=size, layout="constrained").add_subplot()


def legend(ax: Axes, columns: int = 2, above: float = 1.06) -> None:
    """Put the legend above the axes, and above the power of ten of their ticks."""
    if ax.get_legend_handles_labels()[1]:
        ax.legend(loc="lower center", bbox_to_anchor=(0.5, above), ncols=columns, frameon=False)


def tidy(ax: Axes) -> Axes:
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


def to_svg(ax: Axes) -> str:
    """Return the figure of an Axes as a data URI; text as shapes, so that it looks the same everywhere."""
    content = _saved(ax.figure, _svg)
    return "data:image/svg+xml;base64," + base64.b64encode(content).decode("ascii")


def png(figure: Figure) -> bytes:
    """Return a figure as the content of a PNG file."""
    return _saved(figure, _png)


def _svg(figure: Any, stream: io.BytesIO) -> None:
    from matplotlib.backends.backend_svg import FigureCanvasSVG

    FigureCanvasSVG(figure).print_svg(stream, metadata={"Date": None, "Creator": None})


def _png(figure: Any, stream: io.BytesIO) -> None:
    from matplotlib.backends.backend_agg import FigureCanvasAgg

    figure.set_dpi(_DOTS)
    FigureCanvasAgg(figure).print_png(stream)


@alone(DRAWING)
def _saved(figure: Any, write: Callable[[Any, io.BytesIO], None]) -> bytes:
    """Return the content of a figure file, without warnings on letters that the font lacks.

    The canvas writes it, since `savefig` draws a figure with a layout twice.
    """
    from matplotlib import rc_context

    stream, log = io.BytesIO(), logging.getLogger("matplotlib.mathtext")
    level = log.level
    log.setLevel(logging.ERROR)
    try:
        # a permanent filter: restoring the previous ones would not be thread-safe
        warnings.filterwarnings("ignore", r"Glyph \d+ .*missing from", UserWarning)
        with rc_context({"svg.fonttype": "path", "svg.hashsalt": "symfric", "path.simplify_threshold": 0.3}):
            write(figure, stream)
    finally:
        log.setLevel(level)
    return stream.getvalue()


def plain_name(name: str) -> str:
    """Return a name that is no mathematics, whatever is in it, short enough for an axis."""
    return (name if len(name) <= _LONGEST else name[: _LONGEST - 1] + "…").replace("$", r"\$")
