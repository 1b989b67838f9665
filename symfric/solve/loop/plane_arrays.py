"""Arrays of contacts in the plane, and of the feet of bodies that can turn."""

import casadi as ca
import numpy as np

from symfric.lower.automaton import Automaton
from symfric.lower.planes import SINCE
from symfric.solve.loop.events.direction_sizes import MOST_ANGLES, SAMPLES
from symfric.solve.loop.records import Feet, Planes, Starts

_NODES = 8  # most nodes of a start, whose length the tolerance sets


def plane_arrays(automaton: Automaton) -> Planes:
    """Return the arrays of contacts in the plane, empty without them."""
    layout, n_p = automaton.layout, len(automaton.planes)
    n_c = len(layout.lines) if n_p else 0
    room = Planes.zeros(
        since=n_c,
        row=n_p,
        arrived=n_p,
        rests=n_p,
        variable=n_c,
        leaves=n_c,
        slides=n_c,
        returned=n_c,
        stands=n_c,
        turned=n_c,
        free=n_c,
        static=n_c,
        kinetic=n_c,
        bound=n_c,
        force=n_c,
        gain=n_c,
        coupling=(n_p, n_p),
        turning=(n_p, n_p + 1),
        across=n_p,
        aimed=1,
        weights=SAMPLES,
        samples=SAMPLES,
        series=SAMPLES,
        angles=MOST_ANGLES,
    )
    room.row[:] = automaton.planes
    room.variable[:] = layout.planes[:n_c]
    room.since[:] = [first + SINCE if first >= 0 else -1 for first in layout.planes[:n_c]]
    return room


def foot_arrays(automaton: Automaton) -> Feet:
    """Return the arrays of feet of bodies that can turn, empty where no two slips share a body."""
    shared = len(automaton.planes) > 0 and automaton.coupled
    n, n_x = (len(automaton.layout.lines), len(automaton.states)) if shared else (0, -1)
    n_p = len(automaton.planes) if shared else 0
    return Feet.zeros(
        among=n,
        used=n,
        pivot=n,
        rank=1,
        sticks=n,
        yields=n,
        factor=(n, n),
        size=n,
        target=n,
        offset=n,
        scale=1,
        point=(3, n),
        slope=n,
        matrix=(n, n),
        step=n,
        kept=(n, n),
        place=n,
        hold=n,
        before=n,
        mark=n,
        entry_y=n_x + 1,
        turning=(n_p, n_p + 1),
        axes=(n_p, n_p),
        weight=n_p,
        idle=n_p,
        order=n_p,
        left=n_p,
        turn=n_p,
        limit=3 * n if automaton.has_feet else 0,
    )


def start_arrays(automaton: Automaton, rows: int, order: int) -> Starts:
    """Return the arrays of derivatives over a start, with rows of observables; empty without planes or derivatives."""
    n_y = automaton.n_y
    n_s = len(automaton.states) // n_y - 1
    if not automaton.planes or n_s == 0:
        return Starts.zeros(nodes=0, rates=(0, 0), powers=(0, 0), inner=(0, 0), equations=(0, 0), rows=(0, 0))
    d = min(_NODES, order)
    nodes = np.array([0.0, *ca.collocation_points(d, "radau")])
    room = Starts.zeros(
        nodes=d + 1,
        rates=(d, d + 1),
        powers=(d + 1, d + 1),
        inner=(d, d),
        equations=(d * n_y, d * n_y + n_s),
        rows=(rows, d),
    )
    room.nodes[:] = nodes
    room.powers[:] = np.linalg.inv(np.vander(nodes, increasing=True))
    room.rates[:] = np.vander(nodes, increasing=True)[1:, :-1] * np.arange(1, d + 1) @ room.powers[1:]
    room.inner[:] = np.linalg.inv(np.vander(nodes[1:], increasing=True))
    return room
