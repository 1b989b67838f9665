"""The picture of a scattered output: the probability that it lies above a level, over all levels."""

from typing import TYPE_CHECKING

import numpy as np

from symfric.axes import Axes, axes_for
from symfric.ensemble.statistics import CASE, interval, probability
from symfric.errors import SceneError
from symfric.locks import DRAWING, alone

if TYPE_CHECKING:
    import xarray as xr

LEVELS, MOST = 200, 8  # levels of a curve; curves of a picture


@alone(DRAWING)
def plot_probability(values: "xr.DataArray", *, over: str = CASE, ax: Axes | None = None) -> Axes:
    """Draw the probability that an output of a sweep lies above a level, over the level, with its interval of 95 %.

    Parameters
    ----------
    values : xarray.DataArray
        An output of a sweep over a `CaseTable`, perhaps along one more dimension; cases that failed (NaN) do not count.
    over : str
        Dimension of the cases.
    ax : matplotlib Axes, optional

    Returns
    -------
    matplotlib Axes
        A curve for each value of the other dimension.

    Raises
    ------
    SceneError
        If there is no such dimension, more than one other, more than eight curves, or no number at all.

    Notes
    -----
    Probability and interval are those of `probability` with ``above=`` the level.

    Examples
    --------
    >>> import symfric as sf
    >>> scene = sf.scenes.mass_on_belt(v_b=0.2, horizon=60.0)
    >>> cases = sf.CaseTable({"v_b": [0.3, 0.35, 0.4, 0.45, 0.5]})
    >>> found = sf.sweep(scene.wanting({"half": sf.HalfRange(scene.system.q[0])}), cases)
    >>> sf.plot_probability(found["half"]).get_xlabel()
    'half'
    """
    probability(values, above=0.0, over=over)  # refuses what is no output over cases
    others = [d for d in values.dims if d != over]
    count = int(np.prod([values.sizes[d] for d in others])) if others else 1
    if len(others) > 1 or count > MOST:
        raise SceneError(
            f"{count} curves over {', '.join(map(str, others))} are too many; select some with .sel or .isel"
        )
    known = values.values[np.isfinite(values.values)]
    if not known.size:
        raise SceneError("no case has a number; every one failed")
    room = 0.02 * (float(np.ptp(known)) or abs(float(known[0])) or 1.0)
    levels = np.linspace(known.min() - room, known.max() + room, LEVELS)
    ax = axes_for(ax)
    for k in range(count):
        part = values.isel({others[0]: k}) if others else values
        own = np.sort(part.values[np.isfinite(part.values)])
        n = float(own.size) or np.nan
        p = (own.size - np.searchsorted(own, levels, side="right")) / n
        low, high = interval(p, n)
        name = f"{others[0]} = {_said(part[others[0]].item())}" if others and others[0] in part.coords else None
        (line,) = ax.plot(levels, p, label=name)
        ax.fill_between(levels, low, high, color=line.get_color(), alpha=0.2, linewidth=0)
    ax.set(xlabel=str(values.name or "level"), ylabel="probability to lie above", ylim=(0, 1))
    if count > 1:
        ax.legend(frameon=False)
    return ax


def _said(value: object) -> str:
    return f"{value:.4g}" if isinstance(value, float) else str(value)
