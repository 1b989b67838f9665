"""Create matplotlib figures from any thread."""

import threading

from symfric.errors import SceneError


def axes_for(ax=None, **options):
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
    from matplotlib.axes import Axes

    if not isinstance(ax, Axes):
        raise SceneError(f"ax is {ax!r}; plot takes the matplotlib Axes to draw on, or nothing for a new figure")
    return ax


def new_axes(**options):
    """Return the Axes of a new figure.

    In the main thread the figure belongs to pyplot, so that ``plt.show()`` shows it. Other threads must not open
    windows; they get a figure without global state.

    Parameters
    ----------
    **options
        For the figure, such as ``layout``.
    """
    if threading.current_thread() is threading.main_thread():
        import matplotlib.pyplot as plt

        return plt.subplots(**options)[1]
    from matplotlib.figure import Figure

    return Figure(**options).add_subplot()
