"""Create matplotlib figures from any thread."""

import threading


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
