"""Some cases of a sweep: a prepared program, numbers in, codes and numbers out; here and in other processes."""

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

from symfric.errors import NoRoute, RunFailed, SceneError
from symfric.model.scene import Scene
from symfric.solve.routes import Program, Settings, prepare
from symfric.solve.status import Status
from symfric.solve.widened import widened

REFUSED, ERROR = -1, -2  # beside the codes of Status: no run was made
CODES = {REFUSED: "REFUSED", ERROR: "ERROR", **{int(s): s.name for s in Status}}
KEPT = 8  # programs that a process of an executor keeps
_HERE = threading.local()


class Halted(BaseException):
    """The sweep was interrupted inside a case."""


@dataclass(frozen=True, eq=False)
class Task:
    """What the cases of one scene have in common.

    Attributes
    ----------
    scene : Scene
    tolerance : float
    route : str, settings or None
    names : tuple of str
        Parameters that vary.
    width : tuple of int
        How many numbers each output has.
    starts : tuple of str
        States whose starts vary.
    """

    scene: Scene
    tolerance: float
    route: str | Settings | None
    names: tuple[str, ...]
    width: tuple[int, ...]
    starts: tuple[str, ...] = ()


def make_program(task: Task) -> Program:
    """Prepare a task's program, its form for other values of parameters that are built in included."""
    program = prepare(task.scene, task.tolerance, task.route)
    widened(program, dict.fromkeys(task.names, math.nan))  # NaN differs from every value
    return program


def run_cases(
    program: Program | str, task: Task, numbers: np.ndarray, halt: Callable[[float], None] | None = None
) -> tuple[np.ndarray, np.ndarray]:
    """Return the status (n,) of some cases and their numbers (n, width), NaN unless the status is OK.

    Parameters
    ----------
    program : Program or str
        The reason why there is none stands for a program.
    task : Task
    numbers : ndarray, shape (n, varied)
        Values of ``task.names``, and then of ``task.starts``.
    halt : callable, optional
        Called now and then with the fraction done; may raise `Halted`.
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
    except Exception:  # of one of them: it is found by itself
        if n > 1:
            parts = [run_cases(program, task, row[None], halt) for row in numbers]
            return np.concatenate([s for s, _ in parts]), np.concatenate([v for _, v in parts])
        return np.array([_failure(numbers[0])]), np.full((1, width), np.nan)
    status = np.where(np.isnan(batch.t_final), REFUSED, batch.status)  # a start that is no number
    rows = [np.reshape(found, (-1, len(batch))) for found in batch.outputs.values()]
    found = np.concatenate(rows).T if rows else np.zeros((len(batch), 0))
    return np.broadcast_to(status, n), np.broadcast_to(found, (n, width))


def _failure(numbers: np.ndarray) -> int:
    """Return the code of the exception that a case ends in; one that nobody foresaw goes to the log."""
    if isinstance(sys.exception(), SceneError | NoRoute | RunFailed):
        return REFUSED
    logging.getLogger("symfric").exception("a case of a sweep failed: %s", numbers.tolist())
    return ERROR


def program_or_reason(task: Task) -> Program | str:
    """Prepare, or return the reason why that is refused."""
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
    kept: OrderedDict[str, tuple] = _HERE.__dict__.setdefault("programs", OrderedDict())
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
