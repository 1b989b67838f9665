"""Plots of bifurcation diagrams and basins."""

from typing import TYPE_CHECKING

import matplotlib.pyplot as plt
import numpy as np

from symfric.axes import axes_for, legend_above
from symfric.locks import DRAWING, alone
from symfric.solve.plotting import labelled

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from symfric.ensemble.attractors import Attractor
    from symfric.ensemble.basins import Basins
    from symfric.ensemble.bifurcation_diagram import BifurcationDiagram


@alone(DRAWING)
def plot_diagram(diagram: "BifurcationDiagram", ax: "Axes | None" = None) -> "Axes":
    """Draw the first coordinate on the section against the parameter; return the Axes."""
    ax = axes_for(ax)
    ax.plot(diagram.values[diagram.case], diagram.states[0], ",", color="k")
    ax.set_xlabel(labelled(diagram.parameter, diagram.units))
    ax.set_ylabel(labelled(diagram.names[0], diagram.units))
    ax.set_title(diagram.about, fontsize="small")
    return ax


@alone(DRAWING)
def plot_basins(basins: "Basins", ax: "Axes | None" = None) -> "Axes":
    """Draw every start in the colour of its attractor, starts without one in white; return the Axes."""
    ax = axes_for(ax)
    (name, row), *others = basins.axes.items()
    colours = plt.get_cmap("tab10")(np.arange(10))[:, :3]
    for k, attractor in enumerate(basins.attractors):
        ax.plot([], [], "s", color=colours[k % 10], label=_in_words(attractor))
    if others:
        other, column = others[0]
        shown = np.array([*colours, (1.0, 1.0, 1.0)])[np.where(basins.label < 0, 10, basins.label % 10)]
        ax.pcolormesh(row, column, shown.transpose(1, 0, 2), shading="nearest")
        ax.set_ylabel(labelled(other, basins.units))
    else:
        ax.plot(row, basins.label, ".", color="k")
        ax.set_ylabel("attractor")
    ax.set_xlabel(labelled(name, basins.units))
    legend_above(ax, 1)
    return ax


def _in_words(attractor: "Attractor") -> str:
    """Return the name of an attractor for a legend; of an equilibrium with its first coordinate."""
    if attractor.orbit is not None:
        return f"limit cycle, period {attractor.orbit.period:.6g}"
    if attractor.kind == "equilibrium":
        return f"equilibrium at {attractor.points[0, 0]:.4g}"
    return {"rest": "at rest", "irregular": "irregular motion"}.get(attractor.kind, attractor.kind)
