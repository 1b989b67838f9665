"""Results of one case among those of all."""

from symfric.codegen.numba_types import compiled
from symfric.solve.loop.case_arrays import COUNTS, CaseArrays
from symfric.solve.loop.run_arrays import RunArrays

_COUNTED = len(COUNTS)


@compiled
def take(b: CaseArrays, w: RunArrays, k: int) -> None:
    """Copy the results of a case."""
    for i in range(w.y.size):
        b.y[k, i] = w.y[i]
    for e in range(w.observed.total.shape[0]):
        for i in range(w.observed.total.shape[1]):
            b.total[k, e, i] = w.observed.total[e, i]
    for i in range(w.observed.seen.size):
        b.seen[k, i] = w.observed.seen[i]
    b.rest[k] = w.clock.rest
    for i in range(b.slopes.shape[1]):
        b.slopes[k, i] = w.rest[i]
    c = w.counts
    b.doubts[k] = c.doubts
    counts = (c.steps, c.events, c.kinks, c.grazes)
    for i in range(_COUNTED):
        b.counted[k, i] = counts[i]
