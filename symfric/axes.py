"""New figures for pictures, from any thread."""

import threading


def new_axes(**options):
    """Return the Axes of a new figure.

    pyplot knows a figure of the main thread, so that ``plt.show()`` shows it; other threads must not open windows, and
    get a figure that no global state knows.

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
