"""Figures of the page of a structure, with captions and alternative texts."""

import numpy as np
import scipy.sparse as sps

from symfric.model.scene import Scene
from symfric.report.study import figures
from symfric.report.study import structure_figures as drawn
from symfric.report.study.captions import Picture
from symfric.report.study.study import StudyResult
from symfric.scenefile import StructurePlan
from symfric.structures.contacts import RowContact
from symfric.structures.rows import row_in

SHAPES = 2  # critical points whose shapes are shown
PERIODS = 4.0  # of the last stretch of the motion
_NEAR = 1.25  # of the shortest distance of coupled nodes: longest line of a mesh


def flutter_pictures(result: StudyResult) -> list[Picture]:
    """Draw frequencies and growth over the coefficient of friction."""
    found = result.structure
    if found is None or found.flutter.value is None:
        return []
    flutter, units = found.flutter.value, result.file.units
    at = ", ".join(f"{p.mu:.4g}" for p in flutter.critical) or "none"
    over = found.factor or "the coefficient of friction"
    return [
        Picture(
            figures.to_svg(drawn.plot_frequencies(flutter, units, found.factor)),
            f"Frequencies of {len(flutter.eigenvalues)} modes against {over}; one grows from {at}",
            "Frequencies of the modes; in colour those that couple.",
        ),
        Picture(
            figures.to_svg(drawn.plot_growth(flutter, units, found.factor)),
            f"Rates of growth of {len(flutter.eigenvalues)} modes against {over}",
            "Their rates of growth: above zero a small vibration grows.",
        ),
    ]


def shape_pictures(result: StudyResult) -> list[Picture]:
    """Draw the shapes that begin to grow, or the lowest modes if none does."""
    found = result.structure
    if found is None:
        return []
    flutter, modes = found.flutter.value, found.modes.value
    if flutter is not None and flutter.critical:
        points = flutter.critical[:SHAPES]
        shapes = [(s, f"What begins to grow at {p.mu:.4g}") for s, p in zip(flutter.shapes, points, strict=False)]
    elif modes is not None:
        shapes = [
            (modes.shapes[:, k].astype(complex), f"Mode {k + 1}") for k in range(min(SHAPES, modes.frequency.size))
        ]
    else:
        return []
    return [_shape(found.plan, shape, words) for shape, words in shapes]


def _shape(plan: StructurePlan, shape: np.ndarray, words: str) -> Picture:
    places = plan.places
    if places is not None and places.plane:
        nodes, moves = places.nodes()
        moved = np.where(moves >= 0, shape[moves], 0.0)
        ax = drawn.plot_displaced(nodes, _edges(plan, nodes, moves), moved)
        return Picture(figures.to_svg(ax), f"{words}: the displaced structure", f"{words}; displacements enlarged.")
    at = None if places is None else places.at[:, 0]
    ax = drawn.plot_shape(at, plan.full.names, shape)
    return Picture(figures.to_svg(ax), f"{words}, over the degrees of freedom", f"{words}.")


def mesh_picture(result: StudyResult) -> Picture | None:
    """Draw the structure with its contacts and points; None if it is not known where they are."""
    plan = None if result.structure is None else result.structure.plan
    if plan is None or plan.places is None or not plan.places.plane:
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
    ax = drawn.plot_mesh(nodes, _edges(plan, nodes, moves), sorted(rubbing), points)
    words = f"{len(nodes)} nodes, {len(plan.contacts)} contacts"
    return Picture(figures.to_svg(ax), f"The structure: {words}", f"The structure: {words}, and where it is looked at.")


def _edges(plan: StructurePlan, nodes: np.ndarray, moves: np.ndarray) -> list[tuple[int, int]]:
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


def contact_picture(result: StudyResult) -> list[Picture]:
    """Draw when the contacts stick and open, over the last periods of the motion."""
    found, motion = result.structure, result.motion.value
    if found is None or motion is None or not found.shares:
        return []
    t, end = motion.t, float(motion.t[-1])
    begin = last_stretch(result, end)
    states = {c.name: (motion.sticks[c.name], _open(result.file.scene, motion, c)) for c in found.plan.contacts}
    ax = drawn.plot_contacts(states, (begin, end), result.file.units)
    what = "over the last periods" if begin > t[0] else "over the motion"
    return [
        Picture(
            figures.to_svg(ax),
            f"When each of {len(states)} contacts sticks, slips and opens, {what}",
            f"The contacts {what}: sticking, slipping, open.",
        )
    ]


def last_stretch(result: StudyResult, end: float) -> float:
    """Return where the last periods of the motion begin; its start if it has none."""
    steady = result.steady.value
    if steady is None or not np.isfinite(steady.period):
        return 0.0
    return max(0.0, end - PERIODS * steady.period)


def _open(scene: Scene, motion, contact: RowContact) -> list[tuple[float, float]]:
    """Return the intervals in which the load of a contact is zero, to the samples of the motion."""
    from symfric.model.numeric import numeric_function

    found = next(c for c in scene.contacts if c.name == contact.name)
    used = sorted(found.normal.free_symbols & set(scene.system.rows), key=str)
    part = scene.system.linear
    if not used or part is None:
        return []
    n = len(scene.system.q)
    rows = [part.rows[s].weights @ (motion.x[:n] if part.rows[s].of == "q" else motion.x[n : 2 * n]) for s in used]
    values = scene.parameter_values()
    known = [s for s in found.normal.free_symbols if s in values]
    if set(found.normal.free_symbols) - set(used) - set(known):
        return []
    plain = {s: f"row{k}" for k, s in enumerate(used)}
    letters = tuple(type(s)(name, real=True) for s, name in plain.items())
    written = found.normal.xreplace(dict(zip(used, letters, strict=True)))
    load = numeric_function((*letters, *known), written)(*rows, *(float(values[s]) for s in known))
    shut = np.concatenate([[False], load <= 0, [False]])
    starts, ends = np.flatnonzero(shut[1:] & ~shut[:-1]), np.flatnonzero(~shut[1:] & shut[:-1]) - 1
    return [(float(motion.t[a]), float(motion.t[b])) for a, b in zip(starts, ends, strict=True)]
