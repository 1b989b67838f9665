"""Shapes of mechanical sketches: walls, springs, dampers, bodies, rollers and arrows."""

import numpy as np

from symfric.report.study.drawing.axes import BLUE, GREY, ORANGE, Axes

INK = "black"


def wall(ax: Axes, x: float, low: float, high: float, side: int = -1) -> None:
    """Draw a vertical wall, hatched on one side."""
    ax.plot([x, x], [low, high], color=INK, linewidth=1.4)
    for y in np.arange(low, high - 0.05, 0.2):
        ax.plot([x, x + 0.12 * side], [y + 0.12, y], color=GREY, linewidth=0.8)


def ground(ax: Axes, y: float, left: float, right: float) -> None:
    """Draw the ground, hatched below."""
    ax.plot([left, right], [y, y], color=INK, linewidth=1.4)
    for x in np.arange(left, right - 0.05, 0.2):
        ax.plot([x + 0.12, x], [y, y - 0.12], color=GREY, linewidth=0.8)


def spring(ax: Axes, start: float, end: float, y: float, name: str = "", colour: str = INK) -> None:
    """Draw a horizontal spring with its name above."""
    straight = min(0.25, 0.15 * (end - start))
    x = np.concatenate([[start], np.linspace(start + straight, end - straight, 12), [end]])
    up = np.concatenate([[0.0], 0.12 * (-1.0) ** np.arange(12), [0.0]])
    up[1] = up[-2] = 0.0
    ax.plot(x, y + up, color=colour, linewidth=1.1)
    ax.text(0.5 * (start + end), y + 0.2, name, ha="center", va="bottom")


def damper(ax: Axes, start: float, end: float, y: float, name: str = "", colour: str = INK) -> None:
    """Draw a horizontal damper with its name above."""
    middle, half = 0.5 * (start + end), min(1.0, 2.5 * (end - start))
    cup = half * np.array([0.2, -0.15, -0.15, 0.2])
    ax.plot([start, middle + cup[1]], [y, y], color=colour, linewidth=1.1)
    ax.plot(middle + cup, y + 0.13 * np.array([1, 1, -1, -1]), color=colour)
    ax.plot([middle + 0.05 * half] * 2, [y - 0.1, y + 0.1], color=colour)
    ax.plot([middle + 0.05 * half, end], [y, y], color=colour, linewidth=1.1)
    ax.text(middle, y + 0.16, name, ha="center", va="bottom")


def slider(ax: Axes, start: float, end: float, y: float, name: str = "", colour: str = INK) -> None:
    """Draw a friction element, two plates that slide on each other, with its name above."""
    middle, half = 0.5 * (start + end), 0.28 * (end - start)
    ax.plot([start, middle + half], [y - 0.03, y - 0.03], color=colour, linewidth=1.4)
    ax.plot([middle - half, end], [y + 0.03, y + 0.03], color=colour, linewidth=1.4)
    for x in np.linspace(middle - half, middle + 0.6 * half, 5):
        ax.plot([x + 0.08, x], [y - 0.03, y - 0.11], color=GREY, linewidth=0.8)
    ax.text(middle, y + 0.12, name, ha="center", va="bottom")


def gap(ax: Axes, start: float, end: float, y: float, name: str = "", colour: str = INK) -> None:
    """Draw a stop, two plates that may touch and part, with its name above."""
    middle, half = 0.5 * (start + end), 0.08 * (end - start)
    for edge, x in ((start, middle - half), (end, middle + half)):
        ax.plot([edge, x], [y, y], color=colour, linewidth=1.1)
        ax.plot([x, x], [y - 0.12, y + 0.12], color=colour, linewidth=2.0)
    ax.text(middle, y + 0.16, name, ha="center", va="bottom")


def block(ax: Axes, left: float, low: float, width: float, height: float, name: str, colour: str = BLUE) -> None:
    """Draw a body with its name inside."""
    from matplotlib.patches import Rectangle

    ax.add_patch(Rectangle((left, low), width, height, facecolor=colour, alpha=0.25, edgecolor=INK))
    ax.text(left + 0.5 * width, low + 0.5 * height, name, ha="center", va="center")


def arrow(ax: Axes, x: float, y: float, dx: float, dy: float, name: str, colour: str = ORANGE) -> None:
    """Draw an arrow with its name above, or beside it if it is vertical."""
    ax.annotate("", (x + dx, y + dy), (x, y), arrowprops={"arrowstyle": "->", "color": colour})
    ax.update_datalim([(x, y - 0.1), (x + dx, y + max(dy, 0.0) + 0.35)])  # limits of the drawing, without its labels
    ax.text(
        x + 0.5 * dx, y + 0.5 * dy + (0.06 if dy == 0 else 0), name, ha="center" if dy == 0 else "left", va="bottom"
    )


def roller(ax: Axes, x: float, y: float, radius: float = 0.15) -> None:
    """Draw a roller."""
    from matplotlib.patches import Circle

    ax.add_patch(Circle((x, y), radius, facecolor="white", edgecolor=INK))
