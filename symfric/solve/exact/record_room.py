"""The arrays that one run under a sampled input works on."""

from typing import NamedTuple

import numpy as np
from numba import njit

from symfric.lower.record import Record
from symfric.solve.exact.phi import ORDER
from symfric.solve.memory import cube, integer_matrix, integers, matrix, reals


class RecordRoom(NamedTuple):
    """Arrays of one run; counts, clock, limits, events and path as in `symfric.solve.taylor.workspace`."""

    code: np.ndarray  # address of the machine code of `data`
    start: np.ndarray  # u and w
    y: np.ndarray  # u, w and time
    p: np.ndarray  # parameters
    data: np.ndarray  # what they make of the equations, see `symfric.lower.record.Record`
    samples: np.ndarray
    dt: np.ndarray  # between samples, (1,)
    parts: np.ndarray  # of a sample, (1,)
    order: np.ndarray  # of the series over a part, (1,)
    force: np.ndarray  # the first entries of `data`
    cells: np.ndarray  # (n_c, 4)
    rows: np.ndarray  # (n_e, 5)
    at: np.ndarray  # time at which a row is wanted, negative if its range is, (n_e,)
    where: np.ndarray  # the present cell, (1,)
    kinds: np.ndarray  # of every cell, by its slope; then one cell of each kind, (2 n_c,)
    tables: np.ndarray  # transition of each kind of cell, backwards and forwards, (2 n_c, 9)
    stiffest: np.ndarray  # (1,)
    now: np.ndarray  # what the rows are in the present mode: slopes in u, w and the input, constant, (n_e, 4)
    cu: np.ndarray  # coefficients of u, w and a row
    cw: np.ndarray
    cr: np.ndarray
    total: np.ndarray  # (n_e, 4)
    counts: np.ndarray
    clock: np.ndarray
    limits: np.ndarray
    event_t: np.ndarray
    event_i: np.ndarray
    path_t: np.ndarray
    path_c: np.ndarray
    path_m: np.ndarray


def make_record_room(problem: Record, address: int, at: list[float]) -> RecordRoom:
    """Allocate the arrays of a program."""
    n_c, n_e = problem.cells, problem.rows
    return RecordRoom(
        code=np.array([address], dtype=np.int64),
        start=np.zeros(2),
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


@njit(nogil=True)
def at_addresses(table):
    """Return the room that `memory.addresses` described, without owning it; in the order of its fields."""
    return RecordRoom(
        integers(table, 0),  # code
        reals(table, 1),  # start
        reals(table, 2),  # y
        reals(table, 3),  # p
        reals(table, 4),  # data
        reals(table, 5),  # samples
        reals(table, 6),  # dt
        integers(table, 7),  # parts
        integers(table, 8),  # order
        reals(table, 9),  # force
        matrix(table, 10),  # cells
        matrix(table, 11),  # rows
        reals(table, 12),  # at
        integers(table, 13),  # where
        integers(table, 14),  # kinds
        matrix(table, 15),  # tables
        reals(table, 16),  # stiffest
        matrix(table, 17),  # now
        reals(table, 18),  # cu
        reals(table, 19),  # cw
        reals(table, 20),  # cr
        matrix(table, 21),  # total
        integers(table, 22),  # counts
        reals(table, 23),  # clock
        integers(table, 24),  # limits
        reals(table, 25),  # event_t
        integer_matrix(table, 26),  # event_i
        matrix(table, 27),  # path_t
        cube(table, 28),  # path_c
        integer_matrix(table, 29),  # path_m
    )
