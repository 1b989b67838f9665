"""Arrays of many cases of one scene: their starts and results."""

from dataclasses import dataclass

import numpy as np

from symfric.codegen.array_table import ArraySet, Cube, IntegerMatrix, Integers, Matrix, Reals, Scalars
from symfric.solve.loop.codes import NOT_FINITE, OK

COUNTS = "steps", "events", "kinks", "grazes"


class Place(Scalars, kind=int):
    """Position of a thread among its cases."""

    loop: int  # address of the event loop
    table: int  # address of the workspace of this thread; next, those of the loop's result and reason of failure
    result: int
    trouble: int
    next: int  # index of the next case
    end: int  # index after the last case
    paused: int  # whether the next case has started


@dataclass(frozen=True, eq=False, kw_only=True)
class CaseArrays(ArraySet):
    """Arrays of all cases, and the position of one thread among them."""

    place: Place
    given_y: Matrix  # state and parameters at the start, (n, ...)
    given_p: Matrix
    y: Matrix  # last state and time, (n, n_x + 1)
    total: Cube  # as in `RunArrays`, (n, n_e, 4)
    seen: Matrix  # (n, n_t)
    counted: IntegerMatrix  # (n, 4)
    rest: Reals
    slopes: Matrix  # derivatives of that time, (n, n_s)
    doubts: Integers  # number of events after which derivatives do not exist
    status: Integers


def make_arrays(given_y: np.ndarray, given_p: np.ndarray, rows: int, times: int, directions: int = 0) -> CaseArrays:
    """Allocate the arrays of the cases that start with these states (n, ...) and parameters (n, ...).

    A case whose start is not a number gets its status here; the loop skips it.
    """
    n, n_x = given_y.shape
    begins = np.all(np.isfinite(given_y), axis=1)
    return CaseArrays(
        place=Place.zeros(),
        given_y=given_y,
        given_p=given_p,
        y=np.full((n, n_x + 1), np.nan),
        total=np.full((n, rows, 4), np.nan),
        seen=np.full((n, times), np.nan),
        counted=np.zeros((n, len(COUNTS)), dtype=np.int64),
        rest=np.full(n, np.nan),
        slopes=np.full((n, directions), np.nan),
        doubts=np.zeros(n, dtype=np.int64),
        status=np.where(begins, OK, NOT_FINITE),
    )
