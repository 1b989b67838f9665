"""Many cases of one compiled scene on any number of threads, without Python between them."""

import threading
from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np

from symfric.codegen.array_table import Table
from symfric.codegen.loop_loader import load_loop
from symfric.model.outputs import INTEGRAL, RANGE
from symfric.solve.loop.case_arrays import CaseArrays, Place, make_arrays
from symfric.solve.loop.compiled_model import CompiledModel
from symfric.solve.observables import Wanted

_BLOCK = 512  # most cases that a thread takes at once
_INTERVAL = 0.1  # time between two reports of the progress, s


def run_cases(
    model: CompiledModel, y: np.ndarray, p: np.ndarray, threads: int, progress: Callable[[float], None] | None
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

    Returns
    -------
    CaseArrays
        In the order of the cases; a case depends on nothing but its own start and parameters.
    """
    n = len(y)
    arrays = make_arrays(y, p, model.first.total.shape[0], model.first.seen.size)
    work = _Work(model, arrays, max(1, min(_BLOCK, n // (4 * threads))))
    if threads == 1 or n <= 1:
        work.go_on(progress)
        return arrays
    crew = [threading.Thread(target=work.go_on_apart, daemon=True) for _ in range(min(threads, n))]
    try:
        for thread in crew:
            thread.start()
        for thread in crew:
            while thread.is_alive():
                thread.join(_INTERVAL)
                if progress is not None:
                    progress(work.done / n)
    finally:
        work.halted = True
        for thread in crew:
            if thread.ident is not None:
                thread.join()
    if work.failures:
        raise work.failures[0]
    return arrays


class _Work:
    """Queue of the remaining cases, in blocks."""

    def __init__(self, model: CompiledModel, arrays: CaseArrays, block: int):
        self._loop = load_loop("symfric.solve.loop.case_loop", "the loop over many cases")
        self._model, self._arrays, self._block = model, arrays, block
        self._lock, self._next, self._size = threading.Lock(), 0, len(arrays.status)
        self.done, self.halted = 0, False
        self.failures: list[BaseException] = []

    def _take(self) -> tuple[int, int]:
        with self._lock:
            begin = self._next
            self._next = min(self._size, begin + self._block)
            return begin, self._next

    def go_on(self, progress: Callable[[float], None] | None = None) -> None:
        """Run blocks of cases until the queue is empty."""
        workspace = self._model.workspace()
        own = replace(self._arrays, place=Place.zeros())
        place, table = own.place, Table(own)
        place.loop = self._model.loop.address
        place.table, place.result, place.trouble = workspace.lend()
        while not self.halted:
            place.next, place.end = begin, end = self._take()
            if begin == end:
                break
            fresh = True
            while self._loop.launch(table, fresh):
                fresh = False
                if self.halted:
                    return
                if progress is not None:
                    progress((self.done + place.next - begin) / self._size)
            with self._lock:
                self.done += end - begin
            if progress is not None:
                progress(self.done / self._size)
        self._model.give_back(workspace)

    def go_on_apart(self) -> None:
        """Run blocks in a thread, and store an exception."""
        try:
            self.go_on()
        except BaseException as failure:
            self.failures.append(failure)
            self.halted = True


def rows_of(wanted: Wanted, arrays: CaseArrays) -> dict[str, Any]:
    """Return the observable of every output, as `Workspace.collect` does, with the cases as last axis."""
    found: dict[str, Any] = {}
    first = np.cumsum([0, *(len(row.times) for row in wanted.rows)])
    for name, k in wanted.row.items():
        row = wanted.rows[k]
        if row.kind == RANGE:
            low, high = arrays.total[:, k, 0], arrays.total[:, k, 1]
            least = np.maximum(np.maximum(low, -high), 0.0)
            found[name] = (least, np.maximum(-low, high)) if row.magnitude else (low, high)
        elif row.kind == INTEGRAL:
            found[name] = arrays.total[:, k, 2]
        else:
            found[name] = arrays.seen[:, first[k] : first[k + 1]].T
    return found
