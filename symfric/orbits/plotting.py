"""Plots of orbits, branches and sections."""

from collections.abc import Mapping
from typing import TYPE_CHECKING

import numpy as np

from symfric.axes import Axes, axes_for, legend_above
from symfric.locks import DRAWING, alone
from symfric.solve.plotting import labelled, motion_to_draw

if TYPE_CHECKING:
    from symfric.orbits.continuation.branch import Branch
    from symfric.orbits.continuation.codim1 import Curve
    from symfric.orbits.cycle import Orbit
    from symfric.orbits.lyapunov import Lyapunov
    from symfric.orbits.poincare import PoincareSection

_MARKS = {
    "hopf": "o",
    "fold": "s",
    "branch-point": "+",
    "flip": "v",
    "neimark-sacker": "^",
    "stick-onset": "D",
    "slip-onset": "d",
    "grazing": "x",
}
_POINTS = 600  # points drawn of an orbit


@alone(DRAWING)
def plot_orbit(orbit: "Orbit", ax: Axes | None = None) -> Axes:
    """Draw coordinate against velocity over one period, sticking in bold; return the Axes."""
    ax = axes_for(ax)
    t = np.union1d(np.linspace(0, orbit.period, _POINTS), orbit.run.t)
    _, x, on = motion_to_draw(orbit.run, t)
    n = len(orbit.base.system.q)
    ax.plot(x[0], x[n], linestyle="-" if orbit.stable else "--", label="stable" if orbit.stable else "unstable")
    if on.any():
        held = np.where(on | np.roll(on, 1), x[n], np.nan)
        ax.plot(x[0], held, linewidth=3.5, solid_capstyle="butt", color="C1", label="a contact sticks")
        ax.legend(loc="lower center", bbox_to_anchor=(0.5, 1.0), ncols=2, frameon=False)
    ax.set_xlabel(labelled(orbit.names[0], orbit.base.units))
    ax.set_ylabel(labelled(orbit.names[n], orbit.base.units))
    return ax


@alone(DRAWING)
def plot_branch(branch: "Branch", ax: Axes | None = None) -> Axes:
    """Draw the half range of the first coordinate, stable parts full and unstable ones dashed; return the Axes."""
    ax = axes_for(ax)
    size = np.array([o.half_range[0] for o in branch.orbits])
    stable = np.array([o.stable for o in branch.orbits])
    for which, style, color, label in ((stable, "-", "C0", "stable"), (~stable, "--", "C3", "unstable")):
        drawn = np.where(_with_neighbours(which), size, np.nan)
        if np.any(np.isfinite(drawn)):
            ax.plot(branch.values, drawn, style, color=color, label=label)
    for kind in dict.fromkeys(s.kind for s in branch.special):
        there = [s for s in branch.special if s.kind == kind]
        height = [0.0 if kind == "hopf" else s.orbit.half_range[0] for s in there]
        ax.plot([s.value for s in there], height, _MARKS[kind], color="k", fillstyle="none", label=kind)
    units = branch.orbits[0].base.units
    ax.set_xlabel(labelled(branch.parameter, units))
    ax.set_ylabel(f"half range of {labelled(branch.orbits[0].names[0], units)}")
    ax.set_ylim(bottom=0)
    legend_above(ax, 3)
    return ax


@alone(DRAWING)
def plot_curve(curve: "Curve", units: Mapping[str, str], ax: Axes | None = None) -> Axes:
    """Draw the second parameter against the first; return the Axes."""
    ax = axes_for(ax)
    ax.plot(*curve.values, label=curve.kind)
    ax.set_xlabel(labelled(curve.parameters[0], units))
    ax.set_ylabel(labelled(curve.parameters[1], units))
    legend_above(ax)
    return ax


@alone(DRAWING)
def plot_section(section: "PoincareSection", ax: Axes | None = None) -> Axes:
    """Draw the first velocity against the first coordinate; return the Axes."""
    ax = axes_for(ax)
    x, u = section.drawn
    ax.plot(section[x], section[u], ".", markersize=2)
    ax.set_xlabel(labelled(x, section.units))
    ax.set_ylabel(labelled(u, section.units))
    ax.set_title(section.about, fontsize="small")
    return ax


@alone(DRAWING)
def plot_lyapunov(result: "Lyapunov", ax: Axes | None = None) -> Axes:
    """Draw the estimate of the largest exponent against time, with a band of its spread; return the Axes."""
    ax = axes_for(ax)
    ax.plot(result.times, result.history)
    ax.axhspan(result.exponent - result.spread, result.exponent + result.spread, alpha=0.2)
    ax.axhline(0, color="k", linewidth=0.5)
    ax.set_xlabel("time since the transient")
    ax.set_ylabel("largest Lyapunov exponent")
    return ax


def _with_neighbours(mask: np.ndarray) -> np.ndarray:
    """Return the mask widened by one point, so that the parts of a line touch."""
    wide = mask.copy()
    wide[1:] |= mask[:-1]
    return wide
