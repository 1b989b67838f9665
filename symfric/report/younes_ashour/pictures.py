"""Pictures of the figures of Younes and Ashour; nothing is computed here."""

from symfric.report.figures import COLOURS, new_axes, tidy
from symfric.report.younes_ashour.figures import FigureData, Panel

PANEL = (5.2, 3.6)  # inches
DASHES = {"solid": "-", "dashed": (0, (4, 2)), "dotted": (0, (1, 1.5))}
WIDTHS = {"solid": 1.1, "dashed": 1.1, "dotted": 1.0}


def plot_panel(panel: Panel, ax=None):
    """Draw the curves of one panel; return the Axes."""
    ax = new_axes() if ax is None else ax
    named = set()
    for curve in panel.curves:
        label = curve.label if curve.label not in named else None
        named.add(curve.label)
        steps = "steps-mid" if curve.steps else "default"
        style = {"color": COLOURS[curve.group], "linestyle": DASHES[curve.dash], "linewidth": WIDTHS[curve.dash]}
        ax.plot(curve.x, curve.y, label=label, drawstyle=steps, **style)
    if panel.log:
        ax.set_xscale("log")
        ax.set_yscale("log")
        for axis in (ax.xaxis, ax.yaxis):
            _plain_ticks(axis)
    ax.set_title(panel.title, fontsize=10)
    ax.set_xlabel(panel.x_label)
    ax.set_ylabel(panel.y_label)
    ax.legend(frameon=False, fontsize=8)
    return tidy(ax)


def draw(data: FigureData):
    """Draw a figure with all its panels; return the matplotlib Figure, which no global state knows."""
    from matplotlib.figure import Figure

    rows = -(-len(data.panels) // data.columns)
    figure = Figure(figsize=(data.columns * PANEL[0], rows * PANEL[1] + 0.4), layout="constrained")
    axes = figure.subplots(rows, data.columns, squeeze=False)
    for panel, ax in zip(data.panels, axes.flat, strict=True):
        plot_panel(panel, ax)
    figure.suptitle(f"Younes and Ashour, figure {data.name}. {data.caption}", fontsize=9)
    return figure


def _plain_ticks(axis) -> None:
    """Label 1, 2 and 5 of every decade of a logarithmic axis with plain numbers."""
    from matplotlib.ticker import FuncFormatter, LogLocator, NullFormatter

    axis.set_major_locator(LogLocator(subs=(1.0, 2.0, 5.0)))
    axis.set_major_formatter(FuncFormatter(lambda value, _place: f"{value:g}"))
    axis.set_minor_formatter(NullFormatter())
