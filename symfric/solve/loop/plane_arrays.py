"""Arrays of contacts in the plane, and of the feet of bodies that can turn."""

from symfric.lower.automaton import Automaton
from symfric.lower.planes import SINCE
from symfric.solve.loop.events.direction_sizes import MOST_ANGLES, SAMPLES
from symfric.solve.loop.records import Feet, Planes


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
        turning=(n_p, n_p),
        axes=(n_p, n_p),
        weight=n_p,
        idle=n_p,
        order=n_p,
        part=n_p,
        left=n_p,
        turn=n_p,
        limit=3 * n if automaton.has_feet else 0,
    )
