"""The arrays that one run of an oscillator works on."""

from dataclasses import dataclass

import numpy as np

from symfric.codegen.array_table import Reals, Scalars
from symfric.lower.linear_modes import Oscillator
from symfric.solve.loop.run_arrays import Limits, RunArrays, common

# entries of `data`, then three for each branch of the law (its end, mu_0, mu_1) and four for each wanted row
A_X, A_U, A_0, PULL, J, SHIFT, LOAD, STATIC, BRANCH = range(9)
LEFT = 5e-14  # of the largest acceleration: what rounding leaves of it after many events
ORDER = 26  # of a kept piece, on which |root| t <= 2

SHARED = frozenset({"code", "limits"})  # arrays that no run changes


class Mode(Scalars, kind=int):
    """The mode of the contact."""

    still: int  # whether it sticks
    started: int  # how a slip begins
    direction: int  # of the slip
    where: int  # branch of the law


class Sliding(Scalars):
    """The slip at the beginning of the present interval."""

    speed: float
    rate: float


class OscillatorLimits(Limits, kind=int):
    """And what the scene is like."""

    branches: int  # of the law
    sticks: int  # whether the contact can stick
    rows: int  # wanted


@dataclass(frozen=True, eq=False, kw_only=True)
class OscillatorArrays(RunArrays):
    """Arrays of one run; the machine code is that of `data`."""

    limits: OscillatorLimits
    data: Reals  # what the parameters make of the equations, see `symfric.lower.linear_modes.Oscillator`
    m: Mode
    v: Sliding
    largest: Reals  # |x| and |u| so far


def make_arrays(problem: Oscillator, address: int) -> OscillatorArrays:
    """Allocate the arrays of a program."""
    return OscillatorArrays(
        **common(2, len(problem.parameters), [()] * problem.rows, ORDER, min(problem.branches, 1)),
        code=np.array([address], dtype=np.int64),
        p=np.zeros(problem.data.nnz_in(0) + 1),
        limits=OscillatorLimits.zeros(),
        data=np.zeros(problem.data.nnz_out(0)),
        m=Mode.zeros(),
        v=Sliding.zeros(),
        largest=np.zeros(2),
    )
