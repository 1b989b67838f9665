"""Create matplotlib figures from any thread."""

import threading
from typing import TYPE_CHECKING, Any, TypeAlias, cast

import sympy as sp

from symfric.errors import SceneError

if TYPE_CHECKING:
    from matplotlib.axes import Axes as Axes
else:
    Axes: TypeAlias = Any  # matplotlib is loaded with the first figure


def axes_for(ax: Axes | None = None, **options: Any) -> Axes:
    """Return the Axes to draw on: those given, else those of a new figure.

    Parameters
    ----------
    ax : matplotlib Axes, optional
    **options
        Of a new figure.

    Raises
    ------
    SceneError
        If something else is given.
    """
    if ax is None:
        return new_axes(**options)
    from matplotlib import axes

    if not isinstance(ax, axes.Axes):
        raise SceneError(f"ax is {ax!r}; plot takes the matplotlib Axes to draw on, or nothing for a new figure")
    return ax


def new_axes(**options: Any) -> Axes:
    """Return the Axes of a new figure.

    In the main thread the figure belongs to pyplot, so that ``plt.show()`` shows it. Other threads must not open
    windows; they get a figure without global state.

    Parameters
    ----------
    **options
        For the figure, such as ``layout``.
    """
    options = {"layout": "constrained", **options}  # labels and legends lie within the figure
    if threading.current_thread() is threading.main_thread():
        import matplotlib.pyplot as plt

        return cast(Axes, plt.subplots(**options)[1])
    from matplotlib.figure import Figure

    return Figure(**options).add_subplot()


def in_letters(name: str) -> str:
    """Return the name of a symbol as matplotlib's mathematics; plain words and letters stay as they are.

    Parameters
    ----------
    name : str
    """
    tex = sp.latex(sp.Symbol(name))
    return name if tex == name or not name.isidentifier() else f"${tex}$"


def legend_above(ax: Axes, columns: int = 2) -> None:
    """Put the legend of an Axes above it, where it covers no data.

    Parameters
    ----------
    ax : matplotlib Axes
    columns : int
    """
    ax.legend(loc="lower center", bbox_to_anchor=(0.5, 1.02), ncols=columns, frameon=False, fontsize="small")
