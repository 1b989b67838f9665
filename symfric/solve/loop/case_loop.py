"""Compiled loop over cases around any event loop; see `symfric.solve.loop.entry`."""

from symfric.codegen.loop_calls import FAILED, call_loop
from symfric.codegen.numba_types import compiled, opener
from symfric.solve.loop.case_arrays import CaseArrays
from symfric.solve.loop.case_results import take
from symfric.solve.loop.codes import NOT_FINITE, OK
from symfric.solve.loop.run_arrays import RunArrays
from symfric.solve.status import PAUSED

_MOST_STEPS = 100_000  # steps of some cases together, about 0.01 s, after which Python may report or stop
_cases_at, _run_at = opener(CaseArrays), opener(RunArrays)  # the fields of `RunArrays` come first in every workspace


@compiled
def launch(address: int, fresh: int) -> int:
    """Run cases until all are done, or return `PAUSED`; the event loop resets the workspace for every case."""
    b = _cases_at(address)
    w = _run_at(b.place.table)
    steps = 0
    if fresh:
        b.place.paused = 0
    while b.place.next < b.place.end:
        k = b.place.next
        if b.status[k] != OK:  # not a valid start
            b.place.next = k + 1
            continue
        if b.place.paused == 0:
            for i in range(w.given_y.size):
                w.given_y[i] = b.given_y[k, i]
            for i in range(w.given_p.size):
                w.given_p[i] = b.given_p[k, i]
        code = call_loop(b.place.loop, b.place.result, b.place.trouble, b.place.table, 1 - b.place.paused)
        if code < 0 and code != FAILED:
            b.place.paused = 1
            return PAUSED
        b.place.paused = 0
        take(b, w, k)
        b.status[k] = NOT_FINITE if code == FAILED else code
        b.place.next = k + 1
        steps += w.counts.steps
        if steps > _MOST_STEPS:
            return PAUSED
    return OK
