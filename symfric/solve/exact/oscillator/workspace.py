"""The arrays that one run of an oscillator works on."""

from typing import NamedTuple

import numpy as np

from symfric.codegen.array_table import Cube, IntegerMatrix, Integers, Matrix, Reals
from symfric.lower.linear_modes import Oscillator

# entries of `data`, then three for each branch of the law (its end, mu_0, mu_1) and four for each wanted row
A_X, A_U, A_0, PULL, J, SHIFT, LOAD, STATIC, BRANCH = range(9)
# entries of `m`
STILL, STARTED, DIRECTION, WHERE = range(4)
# entries of `v`
SPEED, RATE = range(2)
# entries of `limits` behind those of the event loop of series
BRANCHES, STICKS, ROWS = range(9, 12)
LEFT = 5e-14  # of the largest acceleration: what rounding leaves of it after many events
ORDER = 26  # of a kept piece, on which |root| t <= 2

SHARED = frozenset({"code", "limits"})  # arrays that no run changes


class Room(NamedTuple):
    """Arrays of one run; counts, clock, limits, events and path as in `symfric.solve.loop.workspace`."""

    code: Integers  # address of the machine code of `data`
    given_y: Reals  # state and parameters at the start of a run
    given_p: Reals
    y: Reals  # x, u and time
    p: Reals  # parameters
    data: Reals  # what they make of the equations, see `symfric.lower.linear_modes.Oscillator`
    m: Integers  # whether it sticks; how a slip begins; its direction; branch of the law
    v: Reals  # sliding speed and acceleration at the beginning of the present interval
    largest: Reals  # |x| and |u| so far
    total: Matrix  # smallest and largest value of every wanted row
    counts: Integers
    clock: Reals
    limits: Integers
    event_t: Reals
    event_i: IntegerMatrix
    path_t: Matrix
    path_c: Cube
    path_m: IntegerMatrix


def make_room(problem: Oscillator, address: int) -> Room:
    """Allocate the arrays of a program."""
    return Room(
        code=np.array([address], dtype=np.int64),
        given_y=np.zeros(2),
        given_p=np.zeros(len(problem.parameters)),
        y=np.zeros(3),
        p=np.zeros(problem.data.nnz_in(0) + 1),
        data=np.zeros(problem.data.nnz_out(0)),
        m=np.zeros(4, dtype=np.int64),
        v=np.zeros(2),
        largest=np.zeros(2),
        total=np.zeros((problem.rows, 4)),
        counts=np.zeros(11, dtype=np.int64),
        clock=np.zeros(7),
        limits=np.zeros(12, dtype=np.int64),
        event_t=np.zeros(64),
        event_i=np.zeros((64, 3), dtype=np.int64),
        path_t=np.zeros((64, 2)),
        path_c=np.zeros((64, 2, ORDER + 1)),
        path_m=np.zeros((64, min(problem.branches, 1)), dtype=np.int64),
    )
