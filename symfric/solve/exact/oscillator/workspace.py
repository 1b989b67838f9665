"""Work arrays of the oscillator loop."""

from dataclasses import dataclass

import numpy as np

from symfric.codegen.array_table import Reals, Scalars
from symfric.lower.linear_modes import Oscillator
from symfric.solve.loop.run_arrays import Clock, Limits, RunArrays, common

# entries of `data`, then three for each branch of the law (its end, mu_0, mu_1) and four for each observable
A_X, A_U, A_0, PULL, J, SHIFT, LOAD, STATIC, BRANCH = range(9)
LEFT = 5e-14  # rounding error after many events, relative to the largest acceleration
ORDER = 26  # order of a stored piece, on which |root| t <= 2

SHARED = frozenset({"code", "limits"})  # constant arrays, shared by all runs


class Mode(Scalars, kind=int):
    """The mode of the contact."""

    still: int  # whether the contact sticks
    started: int  # how the slip started
    direction: int  # direction of the slip
    where: int  # index of the branch of the law


class Sliding(Scalars):
    """The slip at the start of the current interval."""

    speed: float
    rate: float


class OscillatorLimits(Limits, kind=int):
    """Budgets of a run and constants of the scene."""

    branches: int  # number of branches of the law
    sticks: int  # whether the contact can stick
    rows: int  # number of observables


@dataclass(frozen=True, eq=False, kw_only=True)
class OscillatorArrays(RunArrays):
    """Arrays of one run; the machine code is that of `data`."""

    limits: OscillatorLimits
    data: Reals  # coefficients of the equations, see `symfric.lower.linear_modes.Oscillator`
    m: Mode
    v: Sliding
    largest: Reals  # |x| and |u| so far


def make_arrays(problem: Oscillator, address: int) -> OscillatorArrays:
    """Allocate the arrays of a program."""
    return OscillatorArrays(
        **common(2, len(problem.parameters), [()] * problem.rows, ORDER, min(problem.branches, 1)),
        clock=Clock.zeros(),
        code=np.array([address], dtype=np.int64),
        p=np.zeros(problem.data.nnz_in(0) + 1),
        limits=OscillatorLimits.zeros(),
        data=np.zeros(problem.data.nnz_out(0)),
        m=Mode.zeros(),
        v=Sliding.zeros(),
        largest=np.zeros(2),
    )
