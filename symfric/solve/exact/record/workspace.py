"""The arrays that one run under a sampled input works on."""

from typing import NamedTuple

import numpy as np

from symfric.codegen.array_table import Cube, IntegerMatrix, Integers, Matrix, Reals
from symfric.lower.sampled_oscillator import Record

ORDER = 18  # at the most, of the series over a part of a sample, on which |root| t <= 1

SHARED = frozenset({"code", "samples", "dt", "at", "limits"})  # arrays that no run changes


class RecordRoom(NamedTuple):
    """Arrays of one run; counts, clock, limits, events and path as in `symfric.solve.loop.workspace`."""

    code: Integers  # address of the machine code of `data`
    given_y: Reals  # u and w, and parameters, at the start of a run
    given_p: Reals
    y: Reals  # u, w and time
    p: Reals  # parameters
    data: Reals  # what they make of the equations, see `symfric.lower.sampled_oscillator.Record`
    samples: Reals
    dt: Reals  # between samples, (1,)
    parts: Integers  # of a sample, (1,)
    order: Integers  # of the series over a part, (1,)
    force: Reals  # the first entries of `data`
    cells: Matrix  # (n_c, 4)
    rows: Matrix  # (n_e, 5)
    at: Reals  # time at which a row is wanted, negative if its range is, (n_e,)
    where: Integers  # the present cell, (1,)
    grip: Reals  # largest static friction over the mass against a slip backwards and forwards, largest |u| at rest
    kinds: Integers  # of every cell, by its slope; then one cell of each kind, (2 n_c,)
    tables: Matrix  # transition of each kind of cell, backwards and forwards, (2 n_c, 9)
    stiffest: Reals  # (1,)
    now: Matrix  # what the rows are in the present mode: slopes in u, w and the input, constant, (n_e, 4)
    cu: Reals  # coefficients of u, w and a row
    cw: Reals
    cr: Reals
    total: Matrix  # (n_e, 4)
    counts: Integers
    clock: Reals
    limits: Integers
    event_t: Reals
    event_i: IntegerMatrix
    path_t: Matrix
    path_c: Cube
    path_m: IntegerMatrix


def make_record_room(problem: Record, address: int, at: list[float]) -> RecordRoom:
    """Allocate the arrays of a program."""
    n_c, n_e = problem.cells, problem.rows
    return RecordRoom(
        code=np.array([address], dtype=np.int64),
        given_y=np.zeros(2),
        given_p=np.zeros(len(problem.parameters)),
        y=np.zeros(3),
        p=np.zeros(problem.data.nnz_in(0) + 1),
        data=np.zeros(problem.data.nnz_out(0)),
        samples=problem.signal.samples.copy(),
        dt=np.array([problem.signal.dt]),
        parts=np.ones(1, dtype=np.int64),
        order=np.ones(1, dtype=np.int64),
        force=np.zeros(6),
        cells=np.zeros((n_c, 4)),
        rows=np.zeros((n_e, 5)),
        at=np.array(at, dtype=float),
        grip=np.zeros(3),
        where=np.zeros(1, dtype=np.int64),
        kinds=np.zeros(2 * n_c, dtype=np.int64),
        tables=np.zeros((2 * n_c, 9)),
        stiffest=np.zeros(1),
        now=np.zeros((n_e, 4)),
        cu=np.zeros(ORDER + 1),
        cw=np.zeros(ORDER + 1),
        cr=np.zeros(ORDER + 1),
        total=np.zeros((n_e, 4)),
        counts=np.zeros(11, dtype=np.int64),
        clock=np.zeros(7),
        limits=np.zeros(12, dtype=np.int64),
        event_t=np.zeros(64),
        event_i=np.zeros((64, 3), dtype=np.int64),
        path_t=np.zeros((64, 2)),
        path_c=np.zeros((64, 2, ORDER + 1)),
        path_m=np.zeros((64, 1), dtype=np.int64),
    )
