"""Plot functions of the page of a structure. Each takes ``ax=None`` and returns the Axes."""

import math
from collections.abc import Mapping, Sequence

import numpy as np

from symfric.report.study.figures import BLUE, COLOURS, GREEN, GREY, ORANGE, RED, in_brackets, label, new_axes, tidy

NAMED = 14  # degrees of freedom up to which the axis of a shape shows their names
_SWING = 0.06  # of the larger side of a mesh: largest displacement drawn
_WIDE = (7.0, 2.9)
_LONGEST = 16  # letters of a name on an axis
_LEGEND = {"loc": "lower center", "bbox_to_anchor": (0.5, 1.0), "frameon": False}


def plot_frequencies(flutter, units, factor: str = "", ax=None):
    """Draw the frequencies of modes against the coefficient of friction; those that grow in colour."""
    ax = new_axes() if ax is None else ax
    hertz = units.hertz
    scale, unit = (hertz, "Hz") if math.isfinite(hertz) else (1.0, units.angular)
    _lines(flutter, scale * flutter.eigenvalues.imag, ax)
    for point in flutter.critical:
        ax.plot(point.mu, scale * point.omega, "o", color="black", markersize=5)
    ax.set_ylim(bottom=0)
    ax.set_ylabel(("frequency" if math.isfinite(hertz) else "angular frequency") + in_brackets(unit))
    return _over_mu(flutter, factor, ax)


def plot_growth(flutter, units, factor: str = "", ax=None):
    """Draw the rates of growth of modes against the coefficient of friction."""
    ax = new_axes() if ax is None else ax
    ax.axhline(0.0, color="black", linewidth=0.8)
    _lines(flutter, flutter.eigenvalues.real, ax)
    for point in flutter.critical:
        ax.plot(point.mu, 0.0, "o", color="black", markersize=5)
    ax.set_ylabel("rate of growth" + in_brackets(units.rate))
    return _over_mu(flutter, factor, ax)


def _lines(flutter, values: np.ndarray, ax) -> None:
    pairs = {mode: k for k, point in reversed(list(enumerate(flutter.critical))) for mode in point.pair}
    for mode, row in sorted(enumerate(values), key=lambda e: e[0] in pairs):
        number = pairs.get(mode)
        colour = GREY if number is None else COLOURS[(2 * number + (mode == flutter.critical[number].pair[1])) % 6]
        ax.plot(flutter.mu, row, color=colour, linewidth=1.0 if number is None else 1.8)


def _over_mu(flutter, factor: str, ax):
    for k, point in enumerate(flutter.critical):
        words = "a mode begins to grow" if k == 0 else None
        ax.axvline(point.mu, color="black", linewidth=0.8, linestyle=(0, (4, 3)), label=words)
    for k, point in enumerate(flutter.regained):
        ax.axvline(point.mu, color=GREEN, linewidth=0.8, linestyle=":", label="stops growing" if k == 0 else None)
    ax.set_xlim(flutter.mu[0], flutter.mu[-1])
    ax.set_xlabel(label(factor, {}) if factor else "coefficient of friction")
    if flutter.critical or flutter.regained:
        ax.legend(ncols=2, **_LEGEND)
    return tidy(ax)


def plot_mesh(nodes: np.ndarray, edges: Sequence[tuple[int, int]], rubbing: Sequence[int], points: Mapping, ax=None):
    """Draw the nodes of a structure, where its contacts act, and the points that are looked at."""
    ax = new_axes(_sized(nodes)) if ax is None else ax
    _net(ax, nodes, edges, GREY, 0.9)
    ax.plot(*nodes[list(rubbing)].T, "o", color=ORANGE, markersize=4.5, label="in contact")
    for (name, place), colour in zip(points.items(), (BLUE, GREEN, RED, *COLOURS), strict=False):
        ax.plot(*place, "s", color=colour, markersize=6, label=label(name, {}))
    ax.legend(ncols=4, **_LEGEND)
    return _bare(ax)


def plot_displaced(nodes: np.ndarray, edges, shape: np.ndarray, ax=None):
    """Draw a complex shape, (m, 2): the structure at rest, and displaced at two instants a quarter period apart."""
    ax = new_axes(_sized(nodes)) if ax is None else ax
    size = _SWING * float(np.max(np.ptp(nodes, axis=0))) / (float(np.max(np.abs(shape))) or 1.0)
    _net(ax, nodes, edges, "0.85", 0.9)
    _net(ax, nodes + size * shape.real, edges, BLUE, 1.3, "at one instant")
    _net(ax, nodes - size * shape.imag, edges, ORANGE, 1.1, "a quarter period later")
    ax.legend(ncols=2, **_LEGEND)
    return _bare(ax)


def plot_shape(at: np.ndarray | None, names: Sequence[str], shape: np.ndarray, ax=None):
    """Draw a complex shape over places on a line, or over the degrees of freedom."""
    ax = new_axes() if ax is None else ax
    places = np.arange(len(names)) if at is None else at
    order = np.argsort(places, kind="stable")
    order = order[np.isfinite(places[order])]
    shape = shape / (np.max(np.abs(shape)) or 1.0)
    style = {"marker": "o", "markersize": 3, "linewidth": 1.2}
    ax.axhline(0.0, color="black", linewidth=0.8)
    ax.plot(places[order], shape[order].real, color=BLUE, label="at one instant", **style)
    ax.plot(places[order], -shape[order].imag, color=ORANGE, label="a quarter period later", **style)
    if at is None and len(names) <= NAMED:
        ax.set_xlabel("degree of freedom")
    elif at is None:
        ax.set_xlabel("number of the degree of freedom")
    else:
        ax.set_xlabel("place")
    ax.set_ylabel("shape")
    ax.legend(ncols=2, **_LEGEND)
    named = at is None and len(names) <= NAMED
    ax = tidy(ax)
    if named:
        ax.set_xticks(places, [_plain(n) for n in names])
    return ax


def plot_contacts(states: Mapping[str, tuple[Sequence, Sequence]], span: tuple[float, float], units, ax=None):
    """Draw when contacts stick and when they are open, one line for each."""
    ax = new_axes((5.4, 1.3 + 0.3 * len(states))) if ax is None else ax
    for k, (sticks, opens) in enumerate(states.values()):
        ax.barh(k, span[1] - span[0], left=span[0], height=0.72, color="0.92", label="" if k else "slips")
        for intervals, colour, word in ((sticks, ORANGE, "sticks"), (opens, BLUE, "open")):
            parts = [(max(a, span[0]), min(b, span[1])) for a, b in intervals if b > span[0] and a < span[1]]
            ax.broken_barh([(a, b - a) for a, b in parts], (k - 0.36, 0.72), color=colour, linewidth=0)
            if k == 0:
                ax.barh(k, 0.0, left=span[0], color=colour, label=word)
    ax.set_yticks(range(len(states)), [_plain(name) for name in states])
    ax.set_xlim(span)
    ax.set_ylim(len(states) - 0.4, -0.6)
    ax.set_xlabel(label("t", units))
    ax.legend(ncols=3, **_LEGEND)
    for side in ("top", "right", "left"):
        ax.spines[side].set_visible(False)
    ax.tick_params(axis="y", length=0)
    return ax


def _plain(name: str) -> str:
    """Return a name that is no mathematics, whatever is in it, short enough for an axis."""
    return (name if len(name) <= _LONGEST else name[: _LONGEST - 1] + "…").replace("$", r"\$")


def _net(ax, nodes: np.ndarray, edges, colour: str, width: float, words: str | None = None) -> None:
    """Draw the edges of a mesh as one line with gaps, or its nodes where there are no edges."""
    if not len(edges):
        ax.plot(*nodes.T, ".", color=colour, markersize=3, label=words)
        return
    ends = nodes[np.asarray(edges)]
    line = np.concatenate([ends, np.full((len(ends), 1, 2), np.nan)], axis=1).reshape(-1, 2)
    ax.plot(*line.T, color=colour, linewidth=width, label=words)


def _sized(nodes: np.ndarray) -> tuple[float, float]:
    """Return the size of a figure with the proportions of a mesh."""
    wide, high = np.maximum(np.ptp(nodes, axis=0), 1e-12)
    return _WIDE[0], float(np.clip(_WIDE[0] * 1.25 * high / wide + 0.8, 1.6, 6.0))


def _bare(ax):
    ax.set_aspect("equal")
    ax.axis("off")
    return ax
