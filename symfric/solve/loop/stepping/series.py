"""Taylor series of the motion, as functions that the event loop calls."""

from dataclasses import dataclass
from functools import lru_cache

import casadi as ca

from symfric.codegen.columns import WithColumns
from symfric.codegen.llvm_ir import Written
from symfric.lower.linear_modes import Matrices

PROBED = 3  # order of the short series for mode selection; for slip that starts at a kink, order 3 is decisive


@dataclass(frozen=True)
class Series:
    """Functions that compute Taylor coefficients.

    Attributes
    ----------
    prelude : casadi.Function
        ``(p, m) -> aux``: everything that depends on parameters and mode alone.
    series : casadi.Function
        ``([y; t], aux) -> coefficients``, row by row (states, guards, observables), each of order 0 to `order`.
    probe : casadi.Function
        The same up to order `PROBED`.
    order : int
    unseen : casadi.Function, optional
        ``([middles; radii] of y and t, aux) -> bounds``: what a step within that box may do that its coefficients do
        not show, for every row; see `symfric.solve.taylor.enclosure`. Without it there is nothing: only sums, products,
        sines and cosines of moving quantities occur.
    terms : casadi.Function, optional
        Of the same arguments: how large the terms of every row are.
    exposed : tuple of int
        Rows with a bound that is not zero.
    matrices : Matrices, optional
        Of linear equations that need neither series nor probe: the prelude computes the entries.
    room : int
        Length of what series and probe need behind the fixed values in aux.
    """

    prelude: ca.Function
    series: ca.Function | Written | WithColumns | None
    probe: ca.Function | Written | WithColumns | None
    order: int
    unseen: ca.Function | None = None
    terms: ca.Function | None = None
    exposed: tuple[int, ...] = ()
    matrices: Matrices | None = None
    room: int = 0


@lru_cache(maxsize=64)
def reach(n_x: int, n_g: int, order: int) -> ca.Function:
    """Return ``([h; far], coefficients) -> (gain, size)``: change of states over h, and of guards over `far`.

    Both are sums of the terms 1 to `order`, of their magnitudes for the guards; rows as in `Series`.
    """
    step = ca.SX.sym("h", 2)
    c = ca.SX.sym("c", (n_x + n_g) * (order + 1))
    out = []
    for r in range(n_x + n_g):
        row = ca.vertsplit(c[r * (order + 1) : (r + 1) * (order + 1)])
        h, row = (step[0], row) if r < n_x else (step[1], [ca.fabs(e) for e in row])
        square = h * h
        # four interleaved sums, which are faster than one chain
        part = [_horner(row[first::4], square * square) for first in range(1, 5)]
        out.append(h * ((part[0] + h * part[1]) + square * (part[2] + h * part[3])))
    return ca.Function("reach", [step, c], [ca.vertcat(*out)], {"cse": True})


def _horner(coefficients: list[ca.SX], x: ca.SX) -> ca.SX:
    total = ca.SX(0)
    for c in reversed(coefficients):
        total = total * x + c
    return total
