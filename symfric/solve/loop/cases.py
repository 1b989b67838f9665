"""Many cases of one compiled scene on any number of threads, without Python between them."""

import threading
from collections.abc import Callable, Iterator
from dataclasses import replace
from typing import Any

import numpy as np

from symfric.codegen.array_table import Table
from symfric.codegen.loop_loader import load_loop
from symfric.long_calls import tell, until_interrupted
from symfric.model.rows import CROSSINGS, INTEGRAL, RANGE
from symfric.solve.case_values import NOT_COMPUTED
from symfric.solve.loop.case_arrays import COUNTS, CaseArrays, Place, make_arrays
from symfric.solve.loop.codes import OK
from symfric.solve.loop.compiled_model import CompiledModel
from symfric.solve.observables import Observables
from symfric.time_limit import check_time

_BLOCK = 512  # most cases that a thread takes at once
_STEPS = COUNTS.index("steps")
_INTERVAL = 0.1  # time between two reports of the progress, s


def run_cases(
    model: CompiledModel,
    y: np.ndarray,
    p: np.ndarray,
    threads: int,
    progress: Callable[[float], None] | None,
    directions: int = 0,
) -> CaseArrays:
    """Run every case from its state at t = 0 with its parameters.

    Parameters
    ----------
    model : CompiledModel
        Without trajectories and lists of events.
    y, p : ndarray, shape (n, states) and (n, parameters)
    threads : int
        Number of threads, each with its own workspace.
    progress : callable or None
        Called with the fraction of the cases that are done, in this thread; what it raises ends all.
    directions : int
        Number of directions of differentiation.

    Returns
    -------
    CaseArrays
        In the order of the cases; a case depends on nothing but its own start and parameters.
    """
    loop = load_loop("symfric.solve.loop.case_loop", "the loop over many cases")

    def work(share: "Share") -> Iterator[int]:
        workspace = model.workspace()
        own = replace(share.arrays, place=Place.zeros())
        place, table = own.place, Table(own)
        place.loop = model.loop.address
        place.table, place.result, place.trouble = workspace.lend()
        while (block := share.take())[0] < block[1]:
            place.next, place.end = block
            fresh = True
            while loop.launch(table, fresh):
                fresh = False
                yield 0
            if model.draft:
                model.worked(int(share.arrays.counted[block[0] : block[1], _STEPS].sum()))
            yield block[1] - block[0]
        model.give_back(workspace)

    observed = model.first.observed
    arrays = make_arrays(y, p, observed.total.shape[0], observed.seen.size, directions)
    return share_out(arrays, work, threads, progress)


class Share:
    """The cases that are left, handed out in blocks."""

    def __init__(self, arrays: CaseArrays, block: int):
        self.arrays, self._block, self._size = arrays, block, len(arrays.status)
        self._lock, self._next = threading.Lock(), 0

    def take(self) -> tuple[int, int]:
        """Return the first and the last but one of the next cases; an empty range if none is left."""
        with self._lock:
            begin = self._next
            self._next = min(self._size, begin + self._block)
            return begin, self._next


def share_out(
    arrays: CaseArrays,
    work: Callable[[Share], Iterator[int]],
    threads: int,
    progress: Callable[[float], None] | None,
) -> CaseArrays:
    """Let threads do the work on shares of some cases; each yields now and then how many more are done.

    A case without an end, since the map was interrupted, gets the status `NOT_COMPUTED`.
    """
    with until_interrupted("map"):
        _share_out(arrays, work, threads, progress)
        return arrays
    arrays.status[(arrays.status == OK) & np.isnan(arrays.y[:, -1])] = NOT_COMPUTED
    return arrays


def _share_out(
    arrays: CaseArrays,
    work: Callable[[Share], Iterator[int]],
    threads: int,
    progress: Callable[[float], None] | None,
) -> None:
    n = len(arrays.status)
    if n == 0:
        return
    share = Share(arrays, max(1, min(_BLOCK, n // (4 * threads))))
    if threads == 1 or n <= 1:
        done = 0
        for more in work(share):
            check_time()
            done += more
            tell("", done / n)
            if progress is not None:
                progress(done / n)
        return
    counts, failures, halted = [0] * min(threads, n), [], threading.Event()

    def apart(k: int) -> None:
        try:
            for more in work(share):
                counts[k] += more
                if halted.is_set():
                    return
        except BaseException as failure:
            failures.append(failure)
            halted.set()

    crew = [threading.Thread(target=apart, args=(k,), daemon=True) for k in range(len(counts))]
    try:
        for thread in crew:
            thread.start()
        for thread in crew:
            while thread.is_alive():
                thread.join(_INTERVAL)
                check_time()
                tell("", sum(counts) / n)
                if progress is not None:
                    progress(sum(counts) / n)
    finally:
        halted.set()
        for thread in crew:
            if thread.ident is not None:
                thread.join()
    if failures:
        raise failures[0]


def rows_of(wanted: Observables, arrays: CaseArrays) -> dict[str, Any]:
    """Return the observable of every output, as `Workspace.collect` does, with the cases as last axis."""
    values: dict[str, Any] = {}
    first = np.cumsum([0, *(len(row.times) for row in wanted.rows)])
    for name, k in wanted.row.items():
        row = wanted.rows[k]
        if row.kind == RANGE:
            low, high = arrays.total[:, k, 0], arrays.total[:, k, 1]
            least = np.maximum(np.maximum(low, -high), 0.0)
            values[name] = (least, np.maximum(-low, high)) if row.magnitude else (low, high)
        elif row.kind == INTEGRAL:
            values[name] = arrays.total[:, k, 2]
        elif row.kind == CROSSINGS:
            values[name] = tuple(arrays.total[:, k, :3].T)
        else:
            values[name] = arrays.seen[:, first[k] : first[k + 1]].T
    return values
