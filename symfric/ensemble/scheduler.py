"""Scheduler of a sweep: hands its cases to threads of this process or to the workers of an executor."""

import hashlib
import pickle
import threading
import time
from collections import OrderedDict
from collections.abc import Callable, Iterable
from concurrent import futures

import numpy as np

from symfric.ensemble.grid import Grid
from symfric.ensemble.progress import INTERVAL, Meter
from symfric.ensemble.store import Store
from symfric.ensemble.worker import NOT_COMPUTED, Halted, Task, program_or_reason, run_cases, run_chunk
from symfric.errors import RunFailed
from symfric.solve.program import Compiled
from symfric.solve.protocol import Program

# time of work that a thread, or a worker of an executor, takes at once; so much is lost if the sweep is killed
BLOCK_SECONDS, CHUNK_SECONDS = 0.05, 0.5
LARGEST = 10_000  # most cases taken at once
Chunk = futures.Future[tuple[np.ndarray, np.ndarray, float]]
GROWTH = 8  # by how much more cases than the last time, which may have been quick ones


class Results:
    """The results so far, in memory and in a store on disk.

    Attributes
    ----------
    status : ndarray of int, shape (n,)
    values : ndarray, shape (n, numbers of a case)
    left : ndarray of int
        Indices of the cases that were unfinished at the beginning.
    done : int
        Finished cases.
    """

    def __init__(self, size: int, width: int, store: Store | None = None):
        self._store = store
        if store is None:
            finished = np.zeros(size, dtype=bool)
            self.status, self.values = np.full(size, NOT_COMPUTED, dtype=np.int32), np.full((size, width), np.nan)
        else:
            finished, self.status, self.values = store.read(size)
            self.status[~finished] = NOT_COMPUTED
        self.left = np.flatnonzero(~finished)
        self.done = size - self.left.size
        self._counting = threading.Lock()
        if store is not None and self.left.size:
            store.open()

    def keep(self, cases: np.ndarray, status: np.ndarray, values: np.ndarray) -> None:
        """Write the results of cases to the store, if there is one, and then count them as done."""
        if self._store is not None:
            self._store.append(cases, status, values)
        self.status[cases], self.values[cases] = status, values
        with self._counting:
            self.done += cases.size

    def close(self) -> None:
        """Close the store's file."""
        if self._store is not None:
            self._store.close()


class Queue:
    """Queue of the remaining cases, scene by scene, so that few programs are prepared."""

    def __init__(self, grid: Grid, left: np.ndarray, workers: int):
        scene = grid.scene_of[left]
        self._rest = {int(k): left[scene == k] for k in np.unique(scene)}
        self._taken: dict[int, int] = dict.fromkeys(self._rest, 0)
        self._workers, self._lock = workers, threading.Lock()

    def left(self, scene: int) -> int:
        """Return how many cases of a scene are left."""
        return int(self._rest[scene].size)

    def next(self, present: int | None, size: int) -> tuple[int, np.ndarray] | None:
        """Return a scene and some of its cases, from the current scene if it has any left; None if the queue is empty.

        At most `size` cases, and fewer near the end, so that all workers stay busy.
        """
        with self._lock:
            open_scenes = [k for k, cases in self._rest.items() if cases.size]
            if not open_scenes:
                return None
            if present in open_scenes:
                k = present
            else:
                k = min(open_scenes, key=lambda k: (self._taken[k], -self._rest[k].size))
                self._taken[k] += 1
            cases = self._rest[k]
            size = max(1, min(size, cases.size // (2 * self._workers)) if self._workers > 1 else size)
            self._rest[k] = cases[size:]
            return k, cases[:size]


def next_size(size: int, seconds: float, target: float) -> int:
    """Return how many cases take a given time, from the last number and its time; at most about `GROWTH` times it."""
    return int(min(max(1.0, target * size / max(seconds, 1e-9)), GROWTH * (size + 1.0), LARGEST))


def run_on_threads(
    grid: Grid, task_of: Callable[[int], Task], results: Results, jobs: int, meter: Meter, ready: dict[int, Program]
) -> None:
    """Run the remaining cases on threads, which share the program of a scene; `ready` holds existing programs."""
    queue, halt, failures = Queue(grid, results.left, jobs), threading.Event(), []
    programs: OrderedDict[int, Program | str] = OrderedDict(ready)
    preparing = threading.Lock()

    def program_of(scene: int, task: Task) -> Program | str:
        with preparing:
            if scene not in programs:
                programs[scene] = program_or_reason(task)
                while len(programs) > jobs:
                    programs.popitem(last=False)
            program = programs[scene]
            if isinstance(program, Compiled):
                program.expect(task.names, queue.left(scene))
            return program

    def stop_if_halted(_fraction: float) -> None:
        if halt.is_set():
            raise Halted

    def work() -> None:
        try:
            present, task, program, size = None, None, None, 1
            while not halt.is_set() and (block := queue.next(present, size)) is not None:
                scene, cases = block
                if task is None or program is None or scene != present:
                    present, task = scene, task_of(scene)
                    program = program_of(scene, task)
                begin = time.perf_counter()
                results.keep(cases, *run_cases(program, task, grid.numbers(cases), stop_if_halted))
                size = next_size(cases.size, time.perf_counter() - begin, BLOCK_SECONDS)
        except Halted:
            return
        except BaseException as failure:
            failures.append(failure)
            halt.set()

    threads = [threading.Thread(target=work, daemon=True) for _ in range(min(jobs, results.left.size))]
    try:
        for thread in threads:
            thread.start()
        for thread in threads:
            while thread.is_alive():
                thread.join(INTERVAL)
                meter(results.done)
    finally:
        halt.set()
        for thread in threads:
            if thread.ident is not None:
                thread.join()
    if failures:
        raise failures[0]
    meter(results.done, last=True)


def run_on_executor(
    grid: Grid, task_of: Callable[[int], Task], results: Results, executor: futures.Executor, workers: int, meter: Meter
) -> None:
    """Run the remaining cases on an executor, in chunks of about half a second of work."""
    queue, packed = Queue(grid, results.left, workers), dict[int, tuple[str, bytes]]()
    running: dict[Chunk, np.ndarray] = {}
    present, size = None, 1

    def submit() -> bool:
        nonlocal present
        block = queue.next(present, min(size, max(1, (grid.size - results.done) // (2 * workers))))
        if block is None:
            return False
        present, cases = block
        if present not in packed:
            data = pickle.dumps(task_of(present))
            packed[present] = hashlib.sha256(data).hexdigest(), data
        running[executor.submit(run_chunk, *packed[present], grid.numbers(cases))] = cases
        return True

    def collect(finished: Iterable[Chunk]) -> None:
        nonlocal size
        for future in finished:
            cases = running[future]
            status, values, seconds = future.result()
            results.keep(cases, status, values)
            del running[future]  # last, so that an interrupted collection is repeated
            size = min(next_size(cases.size, seconds, CHUNK_SECONDS), GROWTH * (size + 1))

    try:
        while True:
            while len(running) < 2 * workers and submit():
                pass
            if not running:
                break
            collect(futures.wait(running, INTERVAL, futures.FIRST_COMPLETED).done)
            meter(results.done)
    except RunFailed:
        raise
    except Exception as failure:
        raise RunFailed(
            f"the executor failed ({type(failure).__name__}: {failure}); finished cases are in the store, if there is "
            "one: run the sweep again"
        ) from failure
    finally:
        _give_up(running, collect)
    meter(results.done, last=True)


def _give_up(running: Iterable[Chunk], collect: Callable[[Iterable[Chunk]], None]) -> None:
    """Collect the finished chunks and cancel the others."""
    for future in list(running):
        if not future.cancel() and future.done() and future.exception() is None:
            collect([future])
