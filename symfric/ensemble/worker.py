"""One case of a sweep: a prepared program, its numbers in, a status and numbers out; here and in other processes."""

import logging
import math
import pickle
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


def run_case(program: Program | str, task: Task, numbers: list[float], halt: Callable) -> tuple[int, list[float]]:
    """Return the status of one case and its numbers, NaN unless the status is OK.

    Parameters
    ----------
    program : Program or str
        The reason why there is none stands for a program.
    task : Task
    numbers : list of float
        Values of ``task.names``, and then of ``task.starts``.
    halt : callable
        Called with the fraction done, about once for every million steps; may raise `Halted`.
    """
    if not isinstance(program, str):
        try:
            values = dict(zip(task.names, numbers, strict=False))
            start = dict(zip(task.starts, numbers[len(task.names) :], strict=True)) if task.starts else None
            run = program.run(values, start, halt)
            if run.status != Status.OK:
                return int(run.status), [math.nan] * sum(task.width)
            found: list[float] = []
            for value in run.outputs.values():
                if np.ndim(value) == 0:
                    found.append(value)
                else:
                    found += value.tolist()
            return 0, found
        except (SceneError, NoRoute, RunFailed):
            pass
        except Exception:
            logging.getLogger("symfric").exception("a case of a sweep failed: %s", numbers)
            return ERROR, [math.nan] * sum(task.width)
    return REFUSED, [math.nan] * sum(task.width)


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
    rows = [run_case(program, own, row, _ignore) for row in numbers.tolist()]
    status = np.array([s for s, _ in rows], dtype=np.int64)
    return status, np.array([v for _, v in rows], dtype=float), time.perf_counter() - begin


def _ignore(_fraction: float) -> None:
    """Take no notice of progress inside a case."""
