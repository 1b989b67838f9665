"""Whether a combination of what contacts do in an impact is right, whether it is another answer, and what stays."""

import numpy as np

from symfric.codegen.numba_types import compiled
from symfric.lower.impacts import STICKS
from symfric.solve.loop.events.impacts import (
    FEASIBLE,
    FIRST,
    KINETIC,
    SECOND,
    STATIC,
    after_fields,
    ask,
    field_of,
    told,
)
from symfric.solve.loop.modes.holding import NO_DROP
from symfric.solve.loop.workspace import LoopArrays

DISTINCT = 1e-6  # margin, relative to the largest rate of a gap, beyond which a second combination is another answer
HALVINGS = 60  # most bisections of the part of restitutions with which an impact gains no energy


@compiled
def gains(w: LoopArrays, least: float) -> bool:
    """Whether the impact adds energy, by more than a part of its terms."""
    return w.impacts.answer[after_fields(w)] > least * w.impacts.answer[after_fields(w) + 1]


@compiled
def least_margin(w: LoopArrays) -> float:
    """Return the least margin of the contacts that touch; less than all others if the impact has no solution."""
    least = np.inf
    for k in range(w.openings.variable.size):
        if w.impacts.touches[k]:
            for what in (FIRST, SECOND):
                margin = told(w, what, k)
                if not abs(margin) < np.inf:
                    return -np.inf
                least = min(least, margin)
    return least


@compiled
def is_best(w: LoopArrays) -> bool:
    """Whether the velocities after the impact are those of the best combination so far."""
    n_q = w.limits.n_q
    for r in range(n_q):
        new, best, old = w.impacts.answer[n_q + r], w.impacts.rates[r], w.y[n_q + r]
        if abs(new - best) > DISTINCT * (abs(new - old) + abs(best - old)) + FEASIBLE * (abs(new) + abs(best)):
            return False
    return True


@compiled
def keep(w: LoopArrays) -> None:
    """Keep the data of the impact and the velocities after it."""
    for r in range(w.impacts.asked.size):
        w.impacts.best[r] = w.impacts.asked[r]
    for r in range(w.limits.n_q):
        w.impacts.rates[r] = w.impacts.answer[w.limits.n_q + r]


@compiled
def restore(w: LoopArrays) -> None:
    """Compute the impact with the data that were kept."""
    for r in range(w.impacts.asked.size):
        w.impacts.asked[r] = w.impacts.best[r]
    ask(w)


@compiled
def staying(w: LoopArrays) -> int:
    """Return how many contacts without slip stick that could slip under less friction."""
    count = 0
    for k in range(w.openings.variable.size):
        count += may_stay(w, k) and w.impacts.asked[field_of(w, 0, k)] == STICKS
    return count


@compiled(inline=True)
def may_stay(w: LoopArrays, k: int) -> bool:
    """Whether contact k touches without slip, and friction drops once it slips."""
    rests = w.impacts.asked[field_of(w, 4, k)] == 0.0 and w.impacts.asked[field_of(w, 5, k)] == 0.0
    return w.impacts.touches[k] != 0 and rests and told(w, STATIC, k) > told(w, KINETIC, k) * (1.0 + NO_DROP)
