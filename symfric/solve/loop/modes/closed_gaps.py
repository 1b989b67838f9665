"""What closed gaps do to contacts at rest: they hold the bodies, and press with forces that bound their friction.

With the slips and the closed gaps, ``[A C; C^T K] = J M^-1 J^T``, forces along the slips accelerate these by

    (A - C K^-1 C^T) lambda,

one gap after the other eliminated. The bounds are ``mu N`` with the normal forces N of the present mode.
"""

from symfric.codegen.numba_types import compiled
from symfric.solve.loop.codes import COUPLING
from symfric.solve.loop.events.impacts import (
    KINETIC,
    LEAST,
    RESPONSE,
    STATIC,
    after_fields,
    ask_exactly,
    is_open,
    told_exactly,
)
from symfric.solve.loop.precision import ROUNDING
from symfric.solve.loop.stepping.calls import measure
from symfric.solve.loop.workspace import LoopArrays

_DEPENDENT = 1e-13  # pivot of a gap, relative to its coupling, below which its rate follows from those of others


@compiled
def measure_held(w: LoopArrays, n_c: int) -> bool:
    """Compute slips, their scales, and the couplings of the contacts as closed gaps hold the bodies.

    Return whether the normal forces that bound friction are unique.
    """
    measure(w, w.y, w.gauge)
    n, unique = w.openings.variable.size, True
    if n == 0:
        return True
    ask_exactly(w, w.y)
    for k in range(n):
        if not is_open(w, k) and not _eliminate(w, n_c, k):
            unique = unique and w.openings.line[k] < 0
    size, n_q, first = n_c + n, _responses(w), after_fields(w) + 2
    for i in range(n_c):
        for j in range(n_c):
            w.gauge[COUPLING + j, i] = w.impacts.exact[first + size * i + j]
        for r in range(n_q):
            w.gauge[COUPLING + n_c + r, i] = w.impacts.exact[first + size * size + n_q * i + r]
    return unique


@compiled(inline=True)
def _responses(w: LoopArrays) -> int:
    """Return how many velocities the impact tells the responses of: all if there may be feet, else none."""
    return w.limits.n_q if w.feet.limit.size else 0


@compiled
def _eliminate(w: LoopArrays, n_c: int, k: int) -> bool:
    """Hold closed gap k in the couplings of the impact; return whether it is independent of those before."""
    size, n_q, first = n_c + w.openings.variable.size, _responses(w), after_fields(w) + 2
    own, back = first + size * (n_c + k), first + size * size + n_q * (n_c + k)
    pivot = w.impacts.exact[own + n_c + k]
    if not pivot > _DEPENDENT * told_exactly(w, RESPONSE, k):
        return False
    for a in range(size):
        part = w.impacts.exact[own + a] / pivot
        if a == n_c + k or part == 0.0:
            continue
        for b in range(size):
            if b != n_c + k:
                w.impacts.exact[first + size * a + b] -= part * w.impacts.exact[own + b]
        for r in range(n_q):
            w.impacts.exact[first + size * size + n_q * a + r] -= part * w.impacts.exact[back + r]
    for a in range(size):
        w.impacts.exact[own + a], w.impacts.exact[first + size * a + n_c + k] = 0.0, 0.0
    for r in range(n_q):
        w.impacts.exact[back + r] = 0.0
    return True


@compiled
def take_bounds(w: LoopArrays, n_x: int, n_c: int) -> bool:
    """Set the largest forces of contacts at rest; return whether these differ from before, by more than rounding.

    Those of contacts that open follow from the normal forces in ``w.probe``. One that starts to slip by these presses
    otherwise than at rest, and is held again by its kinetic bound alone.
    """
    p, changed = w.planes, False
    row = COUPLING + n_c + w.limits.n_q + w.limits.coupled
    for i in range(n_c):
        k, static, kinetic = w.contacts.opens[i], w.gauge[row, i], w.gauge[row + 1, i]
        if k >= 0:
            static, kinetic = static_bound(w, n_x, i), told_exactly(w, KINETIC, k) * _pressed(w, n_x, k)
            static = kinetic if p.slides[i] else static
            least = ROUNDING * told_exactly(w, LEAST, k) * told_exactly(w, STATIC, k)
            changed = changed or not max(abs(static - p.static[i]), abs(kinetic - p.kinetic[i])) <= least
        p.static[i], p.kinetic[i] = static, kinetic
    return changed


@compiled
def static_bound(w: LoopArrays, n_x: int, i: int) -> float:
    """Return the largest force of contact i at rest."""
    k = w.contacts.opens[i]
    if k >= 0:
        return told_exactly(w, STATIC, k) * _pressed(w, n_x, k)
    return float(w.gauge[COUPLING + w.contacts.sticks.size + w.limits.n_q + w.limits.coupled, i])


@compiled(inline=True)
def _pressed(w: LoopArrays, n_x: int, k: int) -> float:
    """Return the normal force of contact k that opens, zero if it is open."""
    return 0.0 if is_open(w, k) else max(w.probe[n_x + w.limits.first_opening + 2 * k + 1, 0], 0.0)
