"""Drawings of a structure: its mesh, and a shape of it over its mesh, a line or its degrees of freedom."""

from collections.abc import Mapping, Sequence

import numpy as np
import scipy.sparse as sps

from symfric.report.html.elements import Picture
from symfric.report.study.drawing.axes import (
    BLUE,
    COLOURS,
    GREEN,
    GREY,
    ORANGE,
    RED,
    Axes,
    label,
    legend,
    new_axes,
    plain_name,
    tidy,
    to_svg,
)
from symfric.scenefile import StructurePlan
from symfric.structures.rows import row_in

NAMED = 14  # degrees of freedom up to which the axis of a shape shows their names
_SWING = 0.06  # of the larger side of a mesh: largest displacement drawn
_WIDE = (7.0, 2.9)
_NEAR = 1.25  # of the shortest distance of coupled nodes: longest line of a mesh
Edges = Sequence[tuple[int, int]]


def mesh_picture(plan: StructurePlan) -> Picture | None:
    """Draw the structure with its contacts and points; None if it is not known where they are."""
    if plan.places is None or not plan.places.plane:
        return None
    nodes, moves = plan.places.nodes()
    node_of = {int(d): k for k, pair in enumerate(moves) for d in pair if d >= 0}
    rubbing = {node_of[int(d)] for c in plan.contacts for d in np.flatnonzero(row_in(plan.full, c.row)) if d in node_of}
    order = {name: i for i, name in enumerate(plan.full.names)}
    points = {}
    for name, row in plan.points.items():
        own = [node_of[order[dof]] for dof in row if order[dof] in node_of]
        if own:
            points[name] = np.mean(nodes[own], axis=0)
    ax = plot_mesh(nodes, _edges(plan, nodes, moves), sorted(rubbing), points)
    words = f"{len(nodes)} nodes, {len(plan.contacts)} contacts"
    return Picture(to_svg(ax), f"The structure: {words}", f"The structure: {words}, and where it is looked at.")


def shape_picture(plan: StructurePlan, shape: np.ndarray, words: str) -> Picture:
    """Draw a complex shape of a structure, shape (n,)."""
    places = plan.places
    if places is not None and places.plane:
        nodes, moves = places.nodes()
        moved = np.where(moves >= 0, shape[moves], 0.0)
        ax = plot_displaced(nodes, _edges(plan, nodes, moves), moved)
        return Picture(to_svg(ax), f"{words}: the displaced structure", f"{words}; displacements enlarged.")
    ax = plot_shape(None if places is None else places.at[:, 0], plan.full.names, shape)
    return Picture(to_svg(ax), f"{words}, over the degrees of freedom", f"{words}.")


def _edges(plan: StructurePlan, nodes: np.ndarray, moves: np.ndarray) -> Edges:
    """Return pairs of near nodes that the stiffness matrix couples."""
    node = np.full(plan.full.n, -1)
    for k, pair in enumerate(moves):
        node[pair[pair >= 0]] = k
    coupled = sps.coo_array(plan.full.K)
    ends = np.stack([node[coupled.coords[0]], node[coupled.coords[1]]])
    ends = np.unique(ends[:, (ends[0] < ends[1]) & (ends[0] >= 0)], axis=1)
    apart = np.linalg.norm(nodes[ends[0]] - nodes[ends[1]], axis=1)
    positive = apart > 1e-9 * np.max(apart, initial=0.0)
    if not positive.any():
        return []
    near = positive & (apart <= _NEAR * np.min(apart[positive]))
    return [(int(a), int(b)) for a, b in ends[:, near].T]


def plot_mesh(
    nodes: np.ndarray,
    edges: Edges,
    rubbing: Sequence[int],
    points: Mapping[str, np.ndarray],
    ax: Axes | None = None,
) -> Axes:
    """Draw the nodes of a structure, where its contacts act, and the points that are looked at."""
    ax = new_axes(_sized(nodes)) if ax is None else ax
    _net(ax, nodes, edges, GREY, 0.9)
    ax.plot(*nodes[list(rubbing)].T, "o", color=ORANGE, markersize=4.5, label="in contact")
    for (name, place), colour in zip(points.items(), (BLUE, GREEN, RED, *COLOURS), strict=False):
        ax.plot(*place, "s", color=colour, markersize=6, label=label(name, {}))
    legend(ax, 4, above=1.0)
    return _bare(ax)


def plot_displaced(nodes: np.ndarray, edges: Edges, shape: np.ndarray, ax: Axes | None = None) -> Axes:
    """Draw a complex shape, (m, 2): the structure at rest, and displaced at two instants a quarter period apart."""
    ax = new_axes(_sized(nodes)) if ax is None else ax
    size = _SWING * float(np.max(np.ptp(nodes, axis=0))) / (float(np.max(np.abs(shape))) or 1.0)
    _net(ax, nodes, edges, "0.85", 0.9)
    _net(ax, nodes + size * shape.real, edges, BLUE, 1.3, "at one instant")
    _net(ax, nodes - size * shape.imag, edges, ORANGE, 1.1, "a quarter period later")
    legend(ax, above=1.0)
    return _bare(ax)


def plot_shape(at: np.ndarray | None, names: Sequence[str], shape: np.ndarray, ax: Axes | None = None) -> Axes:
    """Draw a complex shape over places on a line, or over the degrees of freedom."""
    ax = new_axes() if ax is None else ax
    places = np.arange(len(names)) if at is None else at
    order = np.argsort(places, kind="stable")
    order = order[np.isfinite(places[order])]
    shape = shape / (np.max(np.abs(shape)) or 1.0)
    ax.axhline(0.0, color="black", linewidth=0.8)
    for part, colour, words in (
        (shape.real, BLUE, "at one instant"),
        (-shape.imag, ORANGE, "a quarter period later"),
    ):
        ax.plot(places[order], part[order], color=colour, label=words, marker="o", markersize=3, linewidth=1.2)
    named = at is None and len(names) <= NAMED
    dof = "degree of freedom" if named else "number of the degree of freedom"
    ax.set_xlabel(dof if at is None else "place")
    ax.set_ylabel("shape")
    legend(ax, above=1.0)
    tidy(ax)
    if named:
        ax.set_xticks(places, [plain_name(n) for n in names])
    return ax


def _net(ax: Axes, nodes: np.ndarray, edges: Edges, colour: str, width: float, words: str | None = None) -> None:
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


def _bare(ax: Axes) -> Axes:
    ax.set_aspect("equal")
    ax.axis("off")
    return ax
