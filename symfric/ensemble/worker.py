"""Worker of a sweep: runs some cases of a prepared program, in this process or another."""

import logging
import math
import pickle
import sys
import threading
import time
from collections import OrderedDict
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from symfric.ensemble.grid import fingerprint
from symfric.errors import NoRoute, RunFailed, SceneError
from symfric.locks import SYMBOLIC, alone
from symfric.model.scene import Scene
from symfric.solve.case_values import NOT_COMPUTED
from symfric.solve.protocol import Program
from symfric.solve.routes import RouteName, Settings, prepare
from symfric.solve.status import Status

REFUSED, ERROR = -1, -2  # codes besides those of Status, for cases without a run
CODES = {NOT_COMPUTED: "NOT_COMPUTED", REFUSED: "REFUSED", ERROR: "ERROR", **{int(s): s.name for s in Status}}
KEPT = 8  # most programs kept in a process, and in one of an executor
_HERE = threading.local()
_made: dict[tuple[object, ...], Program] = {}  # the last ones at the end


class Halted(BaseException):
    """Raised inside a case when the sweep is interrupted."""


@dataclass(frozen=True, eq=False)
class Task:
    """Common data of the cases of one scene.

    Attributes
    ----------
    scene : Scene
    tolerance : float
    route : str, settings or None
    names : tuple of str
        Parameters that vary.
    width : tuple of int
        Number of values of each output.
    starts : tuple of str
        States whose initial values vary.
    """

    scene: Scene
    tolerance: float
    route: RouteName | Settings | None
    names: tuple[str, ...]
    width: tuple[int, ...]
    starts: tuple[str, ...] = ()


@alone(SYMBOLIC)
def make_program(task: Task) -> Program:
    """Prepare the program of a task, also the one in which all varied parameters are free.

    The last ones are kept, since a program may be shared: a sweep that is repeated does not wait for its own again.
    """
    key = fingerprint(task.scene), task.tolerance, repr(task.route), task.names
    program = _made.pop(key, None)
    if program is None:
        program = prepare(task.scene, task.tolerance, task.route)
        program.widened(dict.fromkeys(task.names, math.nan))  # NaN differs from every value
    _made[key] = program
    while len(_made) > KEPT:
        del _made[next(iter(_made))]
    return program


def run_cases(
    program: Program | str, task: Task, numbers: np.ndarray, halt: Callable[[float], None] | None = None
) -> tuple[np.ndarray, np.ndarray]:
    """Run some cases; return their status (n,) and values (n, width), NaN unless the status is OK.

    Parameters
    ----------
    program : Program or str
        A string is the reason why there is no program.
    task : Task
    numbers : ndarray, shape (n, varied)
        Values of ``task.names``, and then of ``task.starts``.
    halt : callable, optional
        Called repeatedly with the fraction done; may raise `Halted`.
    """
    n, width = len(numbers), sum(task.width)
    if isinstance(program, str):
        return np.full(n, REFUSED), np.full((n, width), np.nan)
    columns = np.ascontiguousarray(numbers.T)
    values, starts = columns[: len(task.names)], columns[len(task.names) :]
    try:
        batch = program.map(
            dict(zip(task.names, values, strict=True)), dict(zip(task.starts, starts, strict=True)), progress=halt
        )
    except Exception:  # raised by one of the cases, which the single runs below identify
        if n > 1:
            parts = [run_cases(program, task, row[None], halt) for row in numbers]
            return np.concatenate([s for s, _ in parts]), np.concatenate([v for _, v in parts])
        return np.array([_failure(numbers[0])]), np.full((1, width), np.nan)
    status = np.where(np.isnan(batch.t_final), REFUSED, batch.status)  # a start that is not a number
    rows = [np.reshape(output, (-1, len(batch))) for output in batch.outputs.values()]
    table = np.concatenate(rows).T if rows else np.zeros((len(batch), 0))
    return np.broadcast_to(status, n), np.broadcast_to(table, (n, width))


def _failure(numbers: np.ndarray) -> int:
    """Return the status code of an exception of a case; unexpected ones are logged."""
    if isinstance(sys.exception(), SceneError | NoRoute | RunFailed):
        return REFUSED
    logging.getLogger("symfric").exception("a case of a sweep failed: %s", numbers.tolist())
    return ERROR


def program_or_reason(task: Task) -> Program | str:
    """Prepare a program, or return the reason why it cannot be prepared."""
    try:
        return make_program(task)
    except (SceneError, NoRoute) as reason:
        return str(reason) or type(reason).__name__


def run_chunk(key: str, task: bytes, numbers: np.ndarray) -> tuple[np.ndarray, np.ndarray, float]:
    """Run some cases in the process of an executor, which keeps the program for the next chunk.

    Parameters
    ----------
    key : str
        Hash of the task.
    task : bytes
        The pickled task.
    numbers : ndarray, shape (n, number of parameters)

    Returns
    -------
    status : ndarray of int, shape (n,)
    values : ndarray, shape (n, numbers of a case)
    seconds : float
        Without the time to prepare the program.
    """
    kept: OrderedDict[str, tuple[Task, Program | str]] = _HERE.__dict__.setdefault("programs", OrderedDict())
    if key not in kept:
        made: Task = pickle.loads(task)
        kept[key] = made, program_or_reason(made)
        while len(kept) > KEPT:
            kept.popitem(last=False)
    kept.move_to_end(key)
    own, program = kept[key]
    begin = time.perf_counter()
    status, values = run_cases(program, own, numbers)
    return status, values, time.perf_counter() - begin
