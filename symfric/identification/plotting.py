"""Pictures of fits: records with predictions and residuals, profiles."""

from typing import TYPE_CHECKING

import numpy as np

from symfric.axes import Axes, in_letters, new_axes
from symfric.locks import DRAWING, alone

if TYPE_CHECKING:
    from symfric.identification.fit import Fit
    from symfric.identification.profile import Profile


@alone(DRAWING)
def plot_fit(fit: "Fit", ax: Axes | None = None) -> Axes:
    """Draw records as dots, predictions as lines, and residuals in a panel below; return the Axes of the records."""
    from mpl_toolkits.axes_grid1 import make_axes_locatable

    ax = new_axes() if ax is None else ax
    below = make_axes_locatable(ax).append_axes("bottom", size="35%", pad=0.1, sharex=ax)
    for name, (t, y) in fit.records.items():
        (dots,) = ax.plot(t, y, ".", markersize=2.5, alpha=0.6, label=name)
        ax.plot(t, fit.predictions[name], "-", color=dots.get_color(), linewidth=1.0)
        below.plot(t, fit.residuals[name], ".", markersize=2.0, color=dots.get_color())
    below.axhline(0.0, color="0.6", linewidth=0.8)
    ax.tick_params(labelbottom=False)
    ax.legend()
    below.set_ylabel("residual")
    below.set_xlabel("t")
    return ax


@alone(DRAWING)
def plot_profile(profile: "Profile", ax: Axes | None = None) -> Axes:
    """Draw the cost over one unknown, with the threshold of the interval; return the Axes."""
    ax = new_axes() if ax is None else ax
    shown = np.isfinite(profile.cost)
    ax.plot(profile.values[shown], profile.cost[shown], "o-", markersize=3, linewidth=1.0)
    ax.axhline(profile.threshold, color="0.6", linestyle="--", linewidth=0.8)
    for end in profile.interval:
        if np.isfinite(end):
            ax.axvline(end, color="0.6", linestyle=":", linewidth=0.8)
    ax.set_xlabel(in_letters(profile.name))
    ax.set_ylabel("cost")
    return ax
