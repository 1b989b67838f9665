"""Work arrays of the loop over a record."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from symfric.codegen.array_table import Integers, Matrix, Reals, Scalars
from symfric.lower.sampled_oscillator import Record
from symfric.solve.loop.run_arrays import Clock, Limits, RunArrays, common

ORDER = 18  # largest order of the series over a part of a sample, on which |root| t <= 1

SHARED = frozenset({"code", "samples", "record", "times", "limits"})  # constant arrays, shared by all runs


class Sampling(Scalars):
    """Constants of a record."""

    dt: float  # time between samples


class Place(Scalars, kind=int):
    """Current position of the loop."""

    parts: int  # number of parts of a sample
    order: int  # order of the series over a part
    where: int  # index of the current cell
    gaps: int  # whether friction would be negative anywhere


class Sizes(Scalars):
    """Scales that limit the parts of a sample."""

    stiffest: float


@dataclass(frozen=True, eq=False, kw_only=True)
class RecordArrays(RunArrays):
    """Arrays of one run; the machine code is that of `data`, the state u, w and time."""

    data: Reals  # coefficients of the equations, see `symfric.lower.sampled_oscillator.Record`
    samples: Reals
    record: Sampling
    place: Place
    sizes: Sizes
    force: Reals  # the first entries of `data`
    cells: Matrix  # (n_c, 4)
    rows: Matrix  # (n_e, 5)
    grip: Reals  # largest static friction over the mass against a slip backwards and forwards, largest |u| at rest
    kinds: Integers  # kind of every cell, by its slope; then one cell of each kind, (2 n_c,)
    tables: Matrix  # transition of each kind of cell, backwards and forwards, (2 n_c, 9)
    now: Matrix  # observables in the current mode: slopes in u, w and the input, constant, (n_e, 4)
    cu: Reals  # coefficients of u, w and an observable
    cw: Reals
    cr: Reals


def make_arrays(problem: Record, address: int, times: Sequence[Sequence[float]]) -> RecordArrays:
    """Allocate the arrays of a program."""
    n_c, n_e = problem.cells, len(times)
    arrays = RecordArrays(
        **common(2, len(problem.parameters), times, ORDER, 1),
        clock=Clock.zeros(),
        code=np.array([address], dtype=np.int64),
        p=np.zeros(problem.data.nnz_in(0) + 1),
        limits=Limits.zeros(),
        data=np.zeros(problem.data.nnz_out(0)),
        samples=problem.signal.samples.copy(),
        record=Sampling.zeros(),
        place=Place.zeros(),
        sizes=Sizes.zeros(),
        force=np.zeros(6),
        cells=np.zeros((n_c, 4)),
        rows=np.zeros((n_e, 5)),
        grip=np.zeros(3),
        kinds=np.zeros(2 * n_c, dtype=np.int64),
        tables=np.zeros((2 * n_c, 9)),
        now=np.zeros((n_e, 4)),
        cu=np.zeros(ORDER + 1),
        cw=np.zeros(ORDER + 1),
        cr=np.zeros(ORDER + 1),
    )
    arrays.record.dt = problem.signal.dt
    arrays.place.parts = arrays.place.order = 1
    return arrays
