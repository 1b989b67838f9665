"""The arrays of many cases of one scene: what each starts with, and what it leaves."""

from dataclasses import dataclass

import numpy as np

from symfric.codegen.array_table import ArraySet, Cube, IntegerMatrix, Integers, Matrix, Reals, Scalars
from symfric.solve.status import Status

COUNTS = "steps", "events", "kinks", "grazes"


class Place(Scalars, kind=int):
    """Where a thread stands among its cases."""

    loop: int  # address of the event loop
    table: int  # of the workspace of this thread, and where its loop leaves its result and the reason of a failure
    result: int
    trouble: int
    next: int  # case
    end: int  # behind the last
    paused: int  # whether the next case has begun


@dataclass(frozen=True, eq=False, kw_only=True)
class CaseArrays(ArraySet):
    """Arrays of all cases, and the place of one thread among them."""

    place: Place
    given_y: Matrix  # state and parameters at the start, (n, ...)
    given_p: Matrix
    y: Matrix  # last state and time, (n, n_x + 1)
    total: Cube  # as in `RunArrays`, (n, n_e, 4)
    seen: Matrix  # (n, n_t)
    counted: IntegerMatrix  # (n, 4)
    rest: Reals
    status: Integers


def make_arrays(given_y: np.ndarray, given_p: np.ndarray, rows: int, times: int) -> CaseArrays:
    """Allocate the arrays of the cases that start with these states (n, ...) and parameters (n, ...).

    A case that starts with what is no number has its status now; the loop leaves it out.
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
        status=np.where(begins, int(Status.OK), int(Status.NOT_FINITE)),
    )
