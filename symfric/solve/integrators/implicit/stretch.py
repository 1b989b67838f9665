"""Slip velocities over many orders of magnitude, integrated as their logarithms.

A law that depends on the logarithm of the slip velocity w needs w with a small error relative to itself, from creep to
fast slip. In place of one of the velocities in w, ``s = asinh(w/U)`` is integrated, U far below every speed that
matters: a logarithm on either side of rest, and smooth through it. The equations then take w from s: as the difference
of the velocity of a body and that of its belt it would have the rounding errors of these.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import casadi as ca
import numpy as np

from symfric.lower.automaton import Automaton, arguments_of
from symfric.lower.contact_dynamics import ContactDynamics
from symfric.solve.integrators.implicit.graph_nodes import nodes_given
from symfric.solve.integrators.integrated_piece import IntegratedPiece, SegmentStart

SIZE = 10.0  # of s, for absolute tolerances
_SAME = 1e-10  # difference of velocities, relative to the largest, within which a slip is the one before
_PIVOT = 1e-6  # smallest slope of a slip over the velocity that is left out for it, relative to its other slopes


@dataclass(frozen=True)
class Stretch:
    """A change of variables of some states.

    Attributes
    ----------
    places : tuple of int
        Indices of the replaced velocities among the states.
    outer, inner : casadi.Function
        ``(s, t, p) -> y`` and ``(y, t, p) -> s``, for all states.
    slips : casadi.Function
        ``(y, t, p) -> w`` of the contacts, in the order of `places`.
    units : casadi.Function
        ``p -> U`` of them.
    """

    places: tuple[int, ...]
    outer: ca.Function
    inner: ca.Function
    slips: ca.Function
    units: ca.Function

    def inside(self, state: np.ndarray, t: float, p: np.ndarray, before: np.ndarray | None = None) -> np.ndarray:
        """Return the integrated variables of a state with integrals behind it, shape (n,).

        Those `before`, if they belong to the same velocities, tell slips that are lost in the rounding of these.
        """
        n, places = self.inner.size1_in(0), list(self.places)
        integrated = np.append(np.array(self.inner(state[:n], t, p)).ravel(), state[n:])
        if before is not None:
            kept = integrated.copy()
            kept[places] = before[places]
            there = self.outside(kept[:, None], np.array([t]), p)[:n, 0]
            speeds = np.max(np.abs(np.concatenate([there[places], state[places]])))
            if np.all(np.abs(there - state[:n])[places] <= _SAME * speeds):
                return kept
        return integrated

    def outside(self, integrated: np.ndarray, t: np.ndarray, p: np.ndarray) -> np.ndarray:
        """Return states with integrals behind them from the integrated variables, shape (n, n_t)."""
        n, integrated = self.inner.size1_in(0), integrated.copy()
        integrated[:n] = np.array(self.outer(integrated[:n], np.reshape(t, (1, -1)), p))
        return integrated


def stretch_of(model: ContactDynamics, automaton: Automaton) -> Stretch | None:
    """Return the change of variables of a scene; None if no law depends on the logarithm of the speed.

    Of contacts whose slips depend on each other, those first in the scene are changed.
    """
    n, n_u = automaton.n_q, model.u.numel()
    y, t, p = ca.SX.sym("y", automaton.n_y), ca.SX.sym("t"), ca.SX.sym("p", automaton.field.nnz_in(2))
    logarithmic = [(i, c.law.memory.slowest) for i, c in enumerate(model.contacts) if c.law.memory]
    logarithmic = [(i, slowest) for i, slowest in logarithmic if slowest is not None]
    if not logarithmic:
        return None
    slips = automaton.gauge(y, t, p)[0][[i for i, _ in logarithmic]]
    slopes = ca.jacobian(slips, y)[:, n : n + n_u]
    held = {k - n for (k, _), sticks in zip(automaton.anchors, automaton.sticks, strict=True) if sticks}
    chosen = _pivots(slopes, held)
    kept, columns = list(chosen), [n + k for k in chosen.values()]
    slips, slopes = slips[kept], slopes[kept, list(chosen.values())]
    units = ca.vertcat(*(ca.substitute(model.read(logarithmic[j][1]), model.p, p) for j in kept))
    others = ca.substitute(slips, y[columns], ca.SX.zeros(len(columns)))
    outer, inner = ca.SX(y), ca.SX(y)
    inner[columns] = ca.asinh(slips / units)
    outer[columns] = ca.solve(ca.densify(slopes), units * ca.sinh(y[columns]) - others)
    return Stretch(
        tuple(columns),
        ca.Function("outer", [y, t, p], [ca.densify(outer)]),
        ca.Function("inner", [y, t, p], [ca.densify(inner)]),
        ca.Function("slips", [y, t, p], [ca.densify(slips)]),
        ca.Function("units", [p], [ca.densify(units)]),
    )


def _pivots(slopes: ca.SX, held: set[int]) -> dict[int, int]:
    """Return for each row that is independent of those before it a velocity of its own, by elimination.

    Preferred are velocities that no contact can hold at rest, and those whose slopes are numbers.

    Slopes that are no numbers count as their values at arguments that satisfy no relation by chance.
    """
    free = ca.symvar(slopes)
    look = ca.Function("look", free, [ca.densify(slopes)])
    rows = np.array(look.call([np.sqrt(2.0 + k) for k in range(len(free))])[0])
    sure = np.array([[not ca.symvar(e) for e in ca.horzsplit(row)] for row in ca.vertsplit(ca.densify(slopes))])
    free_to_move = np.array([k not in held for k in range(rows.shape[1])])
    chosen: dict[int, int] = {}
    for i, row in enumerate(rows):
        left = row.copy()
        for j, k in chosen.items():
            left -= rows[j] * (left[k] / rows[j, k])
        large = np.abs(left) > _PIVOT * np.max(np.abs(row), initial=0.0)
        if not np.any(large):
            continue
        rows[i] = left
        chosen[i] = int(np.argmax(large * (1 + sure[i] + 2 * free_to_move)))
    return chosen


def stretched(field: ca.Function, stretch: Stretch | None) -> ca.Function:
    """Return a field ``(y, t, p, m) -> (rate, guards, rows)`` as one of the integrated variables."""
    if stretch is None:
        return field
    y, t, p, m = arguments_of(field)
    s = ca.SX.sym("s", y.numel())
    places, units = list(stretch.places), stretch.units(p)
    slips, out = stretch.slips(y, t, p), list(field(y, t, p, m))
    faster = ca.jtimes(slips, y, out[0]) + ca.jtimes(slips, t, ca.SX(1))
    rate = ca.SX(out[0])
    rate[places] = faster / (units * ca.cosh(s[places]))
    exact = nodes_given(slips, units * ca.sinh(s[places]), [rate, *out[1:]])
    inside: Sequence[ca.SX] = ca.substitute(exact, [y], [stretch.outer(s, t, p)])
    return ca.Function("field", [s, t, p, m], [ca.densify(e) for e in inside])


def inside(stretch: Stretch | None, start: SegmentStart) -> SegmentStart:
    """Return a start in the integrated variables."""
    if stretch is None:
        return start
    state = stretch.inside(start.state, start.t, start.p, start.inner)
    return replace(start, state=state, size=sizes_of(stretch, start.size))


def outside(stretch: Stretch | None, piece: IntegratedPiece, p: np.ndarray) -> IntegratedPiece:
    """Return a piece in the states."""
    if stretch is None:
        return piece
    return replace(piece, state=stretch.outside(piece.state, piece.t, p), inner=piece.state[:, -1])


def sizes_of(stretch: Stretch | None, size: np.ndarray) -> np.ndarray:
    """Return the sizes of the integrated variables from those of the states."""
    if stretch is None:
        return size
    stretched_sizes = size.copy()
    stretched_sizes[list(stretch.places)] = SIZE
    return stretched_sizes
