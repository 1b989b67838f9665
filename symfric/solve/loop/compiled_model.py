"""A compiled event loop, shared by all threads, and the workspaces of its runs."""

import math
from collections import deque
from collections.abc import Callable
from dataclasses import replace
from typing import Any, NamedTuple

import numpy as np

from symfric.codegen.array_table import Table
from symfric.codegen.functions import MachineCode
from symfric.codegen.loop_loader import Loop
from symfric.locks import SYMBOLIC, alone
from symfric.long_calls import long_call, tell_of_run
from symfric.model.rows import CROSSINGS, INTEGRAL, RANGE, Row
from symfric.solve.loop.run_arrays import RunArrays, Stored
from symfric.solve.observables import Observables
from symfric.solve.path import Path
from symfric.solve.run import Raw
from symfric.solve.status import EVENTS_FULL, PATH_FULL, Status
from symfric.time_limit import check_time

PATH_BYTES = 2**30  # largest trajectory; a run that needs more ends with a status
_CHUNK_BYTES = 2**26  # largest piece of a trajectory or of a list of events; such pieces are returned to the system
_SMALL_BYTES = 2**20  # a workspace with larger pieces is kept only if there is no other
_KEPT = 16  # most workspaces that a model keeps for further runs
_STATUS = tuple(Status)
# Steps after which fast compiled code has lost the time of compiling it for speed, whatever its length: by measurement
# .08 ns for each of its instructions and steps, against 29 us for each instruction.
_ENOUGH = 300_000

Found = tuple[np.ndarray, float, dict[str, float], Raw]  # final state, its time, counts, and unprocessed results


class CompiledModel:
    """An event loop compiled for a scene: machine code and the initial arrays of every run.

    It is immutable, so that any number of threads may run it; only the addresses of code that was compiled fast are
    exchanged, once, for those of code with the same results. Each run has its own workspace: one that an earlier run
    has left, or a new one. A deque gives and takes without a lock, and a run that was interrupted leaves nothing.

    Parameters
    ----------
    loop : Loop
        From `symfric.codegen.loop_loader`.
    code : MachineCode
        Of the scene.
    first : RunArrays
    shared : frozenset of str
        Fields that no run changes: all workspaces have the same arrays there.
    wanted : Observables
    n_x : int
        States of the motion; what follows them in `y` is no part of results.
    horizon : float
    """

    def __init__(
        self,
        loop: Loop,
        code: MachineCode,
        first: Any,
        shared: frozenset[str],
        wanted: Observables,
        n_x: int,
        horizon: float,
    ):
        self.loop, self.first, self.shared = loop, first, shared
        self.wanted, self.n_x, self.horizon = wanted, n_x, horizon
        self._code, self._steps = code, 0
        self.draft = code.draft
        self._idle: deque[Workspace] = deque(maxlen=_KEPT)
        self.path_rows = path_rows(first)
        for _, array in first.items():
            array.setflags(write=False)

    def pausing(self) -> "CompiledModel":
        """Return the same with a pause after every step, at which `progress` is called."""
        limits = self.first.limits.copy()
        limits.chunk = 1
        first = replace(self.first, limits=limits)
        return CompiledModel(self.loop, self._code, first, self.shared, self.wanted, self.n_x, self.horizon)

    def worked(self, steps: int) -> None:
        """Count the steps that a draft has made; replace it where its code has cost what compiling it again does."""
        self._steps += steps
        if self._steps >= _ENOUGH:
            self._exchange()

    @alone(SYMBOLIC)
    def _exchange(self) -> None:
        """Put the code that is compiled for speed in the place of the draft, unless another thread has."""
        if not self.draft:
            return
        again, code = self.draft.improved(), self.first.code
        code.setflags(write=True)  # every workspace has this array; a run takes one address after the other
        code[:] = [again.get(address, address) for address in code.tolist()]
        code.setflags(write=False)
        self.draft = None

    def workspace(self) -> "Workspace":
        """Borrow a workspace for one run, to be returned by `give_back`."""
        try:
            return self._idle.pop()
        except IndexError:
            return Workspace(self)

    def give_back(self, workspace: "Workspace") -> None:
        """Return a workspace after its run, for use by another one."""
        if not (workspace.large and self._idle):
            self._idle.append(workspace)

    def run(self, y: np.ndarray, p: np.ndarray, progress: Callable[[float], None] | None) -> "tuple[Status, Found]":
        """Run from state y at t = 0 with parameters p; return the status and the result of `Workspace.collect`."""
        try:
            workspace = self._idle.pop()
        except IndexError:
            workspace = Workspace(self)
        status = workspace.drive(y, p, progress)
        collected = workspace.collect()
        if not (workspace.large and self._idle):
            self._idle.append(workspace)
        return status, collected


class _Kept(NamedTuple):
    """Full pieces of a trajectory or of a list of events, in order."""

    pieces: list[tuple[np.ndarray, ...]]
    rows: int


_NONE = _Kept([], 0)


class Workspace:
    """The memory of one run; used by one thread at a time.

    Attributes
    ----------
    arrays : RunArrays
        Work arrays of compiled code.
    large : bool
        Whether it holds so much memory that only one is kept.
    """

    __slots__ = (
        "_extended",
        "_given_p",
        "_given_y",
        "_launch",
        "_log",
        "_model",
        "_path",
        "_state",
        "_table",
        "arrays",
        "large",
    )

    def __init__(self, model: CompiledModel):
        self._model, self._launch = model, model.loop.launch
        self._set(model.first.copy(model.shared))
        self.large, self._extended, self._path, self._log = False, False, _NONE, _NONE
        self._given_y: np.ndarray | None = None
        self._given_p: np.ndarray | None = None

    def _set(self, arrays: Any) -> None:
        self.arrays, self._table = arrays, Table(arrays)
        self._state = arrays.y[: self._model.n_x]  # slicing takes as long as copying

    def drive(self, y: np.ndarray, p: np.ndarray, progress: Callable[[float], None] | None) -> Status:
        """Run to the end, from state y at t = 0 with parameters p."""
        if self._given_y is not y or self._given_p is not p:  # unchanged if the scene's own values are run repeatedly
            w = self.arrays
            w.given_y[:], w.given_p[:] = y, p
            self._given_y, self._given_p = y, p
        check_time()
        code = self._launch(self._table, True)
        status = _STATUS[code] if code >= 0 else self._go_on(code, progress)
        if self._model.draft:
            self._model.worked(self.arrays.counts.steps)
        return status

    def _go_on(self, code: int, progress: Callable[[float], None] | None) -> Status:
        """Continue a run that paused, since it is long or needs memory for its trajectory."""
        with long_call("run"):
            return self._to_the_end(code, progress)

    def _to_the_end(self, code: int, progress: Callable[[float], None] | None) -> Status:
        told = 0
        while code < 0:
            check_time()
            if code == PATH_FULL:
                if not self._extend_path():
                    return Status.STEP_BUDGET
            elif code == EVENTS_FULL:
                self._extend_log()
            w = self.arrays
            if w.counts.steps - told >= w.limits.chunk:
                told, done = w.counts.steps, min(1.0, float(w.y[-1]) / self._model.horizon)
                tell_of_run(done)
                if progress is not None:
                    progress(done)
            code = self._launch(self._table, False)
        return _STATUS[code]

    def lend(self) -> tuple[int, int, int]:
        """Return the addresses of the table, of the result of a call and of the reason of a failure.

        Compiled code may then set start and parameters and call the loop.
        """
        self._given_y = self._given_p = None
        return self._table.address, self._table.result, self._table.trouble

    def collect(self) -> Found:
        """Return copies of the results of the run."""
        w, wanted = self.arrays, self._model.wanted
        steps, events, kinks, grazes, kept, logged, *_ = w.counts.tolist()  # the first of `Counts`
        path, log = None, None
        if self._extended:
            path, log = self._take_path(kept) if wanted.path else None, self.take_log()
        else:  # the usual case, kept fast
            if wanted.path:
                path = Path(*(a.copy() for a in self._stored_path(kept)))
            if wanted.events:
                log = w.stored.event_t[:logged].copy(), w.stored.event_i[:logged].copy()
        values: dict[str, Any] = {}
        if wanted.row:
            total = w.observed.total.tolist()
            for name, k in wanted.row.items():
                row, (low, high, value, _) = wanted.rows[k], total[k]
                if row.kind == RANGE:
                    values[name] = _range(row, low, high)
                elif row.kind == INTEGRAL:
                    values[name] = value
                elif row.kind == CROSSINGS:
                    values[name] = low, high, value
                else:
                    values[name] = w.observed.seen[w.times.first[k] : w.times.first[k + 1]].copy()
        raw = Raw(values, w.clock.rest, path, log)
        stats = {"steps": steps, "events": events, "kinks": kinks, "grazes": grazes}
        return self._state.copy(), w.y.item(-1), stats, raw

    def _stored_path(self, kept: int) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
        """Return starts, lengths, coefficients and modes of the present piece of the trajectory, not copied."""
        s = self.arrays.stored
        return s.path_t[:kept, 0], s.path_t[:kept, 1], s.path_c[:kept, : self._model.n_x], s.path_m[:kept]

    def _take_path(self, kept: int) -> Path:
        """Return the trajectory; large arrays are handed over without copying."""
        w, last = self.arrays, self._stored_path(kept)
        before, self._path = self._path, _NONE
        if before.rows or w.stored.path_c.nbytes <= _CHUNK_BYTES:
            return Path(*_joined(before, last))
        self._set(replace(w, stored=_piece(w.stored, "path", len(self._model.first.stored.path_t))))
        return Path(*last)

    def take_log(self) -> tuple[np.ndarray, np.ndarray]:
        """Return times and changes of the events of the run."""
        w = self.arrays
        kept = w.counts.kept_events
        before, self._log, self._extended = self._log, _NONE, False
        times, changes = _joined(before, (w.stored.event_t[:kept], w.stored.event_i[:kept]))
        return times, changes

    def _extend_path(self) -> bool:
        """Store the full piece of the trajectory and start another; return False if the memory limit is reached."""
        w, model, self._extended = self.arrays, self._model, True
        kept, rows = w.counts.kept_steps, len(w.stored.path_t)
        if kept > rows:  # the loop repeats the step, with as many rows as it has counted
            size = kept
        else:
            self._path = _with(self._path, self._stored_path(kept), kept)
            w.counts.kept_steps = 0
            most = rows if kept and w.stored.path_c.nbytes > _CHUNK_BYTES // 2 else 2 * rows
            size = min(most, model.path_rows - self._path.rows)
        if size <= 0 or (kept == 0 and size <= rows):
            return False
        self._set(replace(w, stored=_piece(w.stored, "path", size)))
        self.large = self.large or self.arrays.stored.path_c.nbytes > _SMALL_BYTES
        return True

    def _extend_log(self) -> None:
        """Store the full piece of the list of events and start another."""
        w, self._extended = self.arrays, True
        kept, rows = w.counts.kept_events, len(w.stored.event_t)
        if kept > rows:
            size = kept
        else:
            self._log = _with(self._log, (w.stored.event_t[:kept], w.stored.event_i[:kept]), kept)
            w.counts.kept_events = 0
            size = rows if kept and w.stored.event_i.nbytes > _CHUNK_BYTES // 2 else 2 * rows
        self._set(replace(w, stored=_piece(w.stored, "event", size)))
        self.large = self.large or self.arrays.stored.event_i.nbytes > _SMALL_BYTES


def path_rows(first: RunArrays) -> int:
    """Return the largest number of steps of a trajectory."""
    return PATH_BYTES // first.stored.path_c[0].nbytes


def _piece(stored: Stored, prefix: str, rows: int) -> Stored:
    """Return the same with another piece of a trajectory (path) or of a list of events (event), of so many rows."""
    old = {name: a for name, a in stored.items() if name.startswith(prefix)}
    return replace(stored, **{name: np.empty((rows, *a.shape[1:]), a.dtype) for name, a in old.items()})


def _with(kept: _Kept, piece: tuple[np.ndarray, ...], rows: int) -> _Kept:
    return _Kept([*kept.pieces, piece], kept.rows + rows) if rows else kept


def _joined(kept: _Kept, last: tuple[np.ndarray, ...]) -> list[np.ndarray]:
    """Concatenate the pieces; each is freed as soon as it is copied."""
    end = kept.rows + len(last[0])
    whole = [np.empty((end, *a.shape[1:]), a.dtype) for a in last]
    pieces = [*kept.pieces, last]
    kept.pieces.clear()
    while pieces:
        piece = pieces.pop()
        begin = end - len(piece[0])
        for target, part in zip(whole, piece, strict=True):
            target[begin:end] = part
        end = begin
    return whole


def _range(row: Row, low: float, high: float) -> tuple[float, float]:
    if low > high:  # the run failed before it counted
        return math.nan, math.nan
    return (max(low, -high, 0.0), max(-low, high)) if row.magnitude else (low, high)
