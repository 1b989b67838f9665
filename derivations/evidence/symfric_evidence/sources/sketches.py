"""Sketches of the sources' systems, each with its equation of motion."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

from symfric.report.study.drawing.axes import GREY, ORANGE
from symfric.report.study.drawing.shapes import INK, arrow, block, damper, ground, roller, spring, wall
from symfric_evidence.sources.registry import Entry, title


@dataclass(frozen=True)
class Sketch:
    """A system to draw.

    Attributes
    ----------
    name, equation : str
        The equation as matplotlib's mathematics.
    draw : callable ``(ax) -> None``
    """

    name: str
    equation: str
    draw: Callable[[Any], None]


def plot_sketch(sketch: Sketch, ax: Any = None) -> Any:
    """Draw a system; return the Axes."""
    if ax is None:
        from matplotlib.figure import Figure

        ax = Figure(figsize=(6.4, 3.4), layout="constrained").add_subplot()
    sketch.draw(ax)
    ax.autoscale_view()
    ax.set_aspect("equal")
    ax.axis("off")
    ax.set_title(title(sketch.name), fontsize=10)
    ax.text(0.5, -0.02, sketch.equation, transform=ax.transAxes, ha="center", va="top", fontsize=11)
    return ax


def _belt(ax: Any) -> None:
    wall(ax, 0.0, 0.3, 1.9)
    spring(ax, 0.0, 1.6, 1.3, "$K$")
    damper(ax, 0.0, 1.6, 0.7, "$C$")
    block(ax, 1.6, 0.4, 1.3, 1.2, "$M$")
    for x in (0.6, 4.2):
        roller(ax, x, 0.15, 0.22)
    ax.plot([0.6, 4.2], [0.39, 0.39], color=INK, linewidth=1.4)
    ax.plot([0.6, 4.2], [-0.08, -0.08], color=INK, linewidth=1.4)
    arrow(ax, 3.1, 0.55, 0.8, 0, "$V_b$")
    arrow(ax, 2.2, 1.75, 0.8, 0, "$X(t)$")
    arrow(ax, 3.0, 1.15, 0.9, 0, r"$m r \tilde\Omega^2 \sin\tilde\Omega t$")


def _drawn_slide(ax: Any) -> None:
    ground(ax, 0.0, 0.0, 4.8)
    block(ax, 0.6, 0.02, 1.3, 1.0, "$m$")
    spring(ax, 1.9, 3.5, 0.75, "$k$")
    damper(ax, 1.9, 3.5, 0.25, "$c$")
    block(ax, 3.5, 0.1, 0.3, 0.9, "", ORANGE)
    arrow(ax, 3.9, 0.55, 0.8, 0, "$v$")
    arrow(ax, 0.9, 1.15, 0.8, 0, "$X$")


def _two_slides(ax: Any) -> None:
    ground(ax, 0.0, 0.0, 5.6)
    for x in (1.6, 2.6):
        roller(ax, x, 0.12, 0.12)
    wall(ax, 0.0, 0.0, 1.4)
    spring(ax, 0.0, 1.2, 1.05, "$k_2$")
    damper(ax, 0.0, 1.2, 0.42, "$c_2$")
    block(ax, 1.2, 0.24, 1.9, 1.0, "$m_2$")
    block(ax, 1.6, 1.24, 1.1, 1.1, "$m_1$", ORANGE)
    spring(ax, 2.7, 4.2, 2.1, "$k_1$")
    damper(ax, 2.7, 4.2, 1.5, "$c_1$")
    block(ax, 4.2, 1.35, 0.3, 0.9, "", GREY)
    arrow(ax, 4.6, 1.8, 0.8, 0, "$v$")
    arrow(ax, 1.8, 2.45, 0.7, 0, "$X_1$")
    arrow(ax, 3.2, 0.6, 0.7, 0, "$X_2$")


def _oscillator(ax: Any) -> None:
    ground(ax, 0.0, 0.0, 4.2)
    wall(ax, 0.0, 0.0, 1.2)
    spring(ax, 0.0, 1.8, 0.5, "$k$")
    block(ax, 1.8, 0.02, 1.2, 1.0, "$m$")
    arrow(ax, 2.0, 1.15, 0.8, 0, "$x$")
    arrow(ax, 3.2, 0.08, 0.6, 0, r"$\mu m g$")


def _isolator(ax: Any) -> None:
    ground(ax, 0.0, 0.0, 5.0)
    for x in (1.6, 2.8):
        roller(ax, x, 0.15)
    block(ax, 1.2, 0.3, 2.0, 0.9, "$m$")
    wall(ax, 4.8, 0.0, 1.2, side=1)
    damper(ax, 3.2, 4.8, 0.75, "$C$")
    arrow(ax, 1.8, 1.35, 0.8, 0, "$a_s, v_s, d_s$")
    arrow(ax, 0.2, -0.45, 0.8, 0, "$a_e, v_e, d_e$")
    ax.text(2.2, 0.06, r"$\mu$", ha="center", va="bottom")


def _rod(ax: Any) -> None:
    from matplotlib.patches import Circle

    wall(ax, 0.0, 0.4, 1.9)
    spring(ax, 0.0, 1.4, 1.5, "$k$")
    damper(ax, 0.0, 1.4, 0.9, "$c$")
    block(ax, 1.4, 0.85, 2.6, 0.8, "$m$")
    ax.add_patch(Circle((2.7, 0.3), 0.55, facecolor="0.9", edgecolor=INK))
    ax.text(2.7, 0.3, "disk", ha="center", va="center", fontsize=9)
    arrow(ax, 2.7, 2.25, 0, -0.5, "$N$")
    arrow(ax, 3.2, 1.75, 0.8, 0, "$x$")


SYSTEMS = {
    "thomsen-1": (
        "A mass on a moving belt.",
        _belt,
        r"$\ddot x + 2\beta\dot x + x + \gamma^2\mu(\dot x - v_b) = a\Omega^2\sin\Omega\tau$",
    ),
    "handbook-19.16": (
        "An object that slides against Coulomb friction.",
        _oscillator,
        r"$m\ddot x + k x + \mu m g\,\mathrm{sgn}\,\dot x = 0$",
    ),
    "guida-1": (
        "A slide drawn by a drive.",
        _drawn_slide,
        r"$m\ddot X + F_a(\dot X) + c(\dot X - v) + k(X - v t) = 0$",
    ),
    "guida-12": (
        "Two slides in friction, the upper one drawn by a drive.",
        _two_slides,
        r"$m_1\ddot X_1 + c_1(\dot X_1 - v) + k_1(X_1 - v t) + F = 0$, "
        r"$m_2\ddot X_2 + c_2\dot X_2 + k_2 X_2 - F = 0$",
    ),
    "younes-1": (
        "A rod on a spring, braked by a disk.",
        _rod,
        r"$\ddot x + 2\zeta\omega_n\dot x + \omega_n^2 x = -\mathrm{sgn}(\dot x)\,\mu_m e^{-|\dot x|} r g$",
    ),
    "rolling-1": (
        "A structure isolated by rollers and a damper.",
        _isolator,
        r"$m a_s = -\mathrm{sgn}(v_s - v_e)\,\mu(u)\, m g + C(v_e - v_s)$",
    ),
}


def _entry(name: str, caption: str, draw: Callable[[Any], None], equation: str) -> Entry[Sketch]:
    sketch = Sketch(name, equation, draw)
    return Entry(caption, lambda _inputs: sketch, plot_sketch)


FIGURES = {name: _entry(name, *system) for name, system in SYSTEMS.items()}
