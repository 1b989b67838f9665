"""Plots of a run."""

import numpy as np

from symfric.axes import axes_for
from symfric.locks import DRAWING, alone


@alone(DRAWING)
def plot_run(run, ax=None):
    """Draw every coordinate against time, with a bar along the bottom where a contact sticks; return the Axes."""
    ax = axes_for(ax, layout="constrained")
    t = np.union1d(np.linspace(0, run.t_final, 2000), run.t)
    x = run(t)
    for i, q in enumerate(run.scene.system.q):
        ax.plot(t, x[i], lw=1, label=q.name)
    sticking = (run.mode == 0).any(axis=0)
    if sticking.any():
        floor = ax.get_ylim()[0]
        on = np.where(sticking[np.clip(np.searchsorted(run.t, t, side="right") - 1, 0, run.t.size - 1)], floor, np.nan)
        ax.plot(t, on, color="0.35", lw=3, solid_capstyle="butt", label="a contact sticks")
    ax.set_xlabel("time t")
    ax.set_ylabel("coordinate")
    ax.legend(loc="best", fontsize="small")
    return ax
