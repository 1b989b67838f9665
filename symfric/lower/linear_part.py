"""The matrices of a system as CasADi graphs: constants in them, no symbols."""

from collections.abc import Callable
from typing import Any

import casadi as ca
import numpy as np
import sympy as sp

from symfric.model.linear_part import LinearPart


def rows_in(part: LinearPart, q: ca.SX, u: ca.SX) -> dict[sp.Symbol, ca.SX]:
    """Return what the symbols of the rows stand for."""
    return {s: _numbers(r.weights.reshape(1, -1)) @ (q if r.of == "q" else u) for s, r in part.rows.items()}


def mass_in(part: LinearPart) -> ca.SX:
    """Return M, sparse, shape (n, n)."""
    return ca.SX(_numbers(part.M))


def force_in(part: LinearPart, read: Callable[[sp.Expr], ca.SX], q: ca.SX, u: ca.SX) -> ca.SX:
    """Return what the matrices and the loads along rows add to the forces, shape (n,)."""
    total = -(_numbers(part.K) @ q)
    if part.C is not None:
        total -= _numbers(part.C) @ u
    for factor, matrix in part.scaled:
        total -= read(factor) * (_numbers(matrix) @ q)
    for load, row in part.loads:
        total += read(load) * _numbers(row.reshape(-1, 1))
    return total


def applied_in(part: LinearPart, read: Callable[[sp.Expr], ca.SX], q: ca.SX, u: ca.SX) -> ca.SX:
    """Return the sums of the magnitudes of the terms of `force_in`, shape (n,)."""
    total = _numbers(abs(part.K)) @ ca.fabs(q)
    if part.C is not None:
        total += _numbers(abs(part.C)) @ ca.fabs(u)
    for factor, matrix in part.scaled:
        total += ca.fabs(read(factor)) * (_numbers(abs(matrix)) @ ca.fabs(q))
    for load, row in part.loads:
        size = sum((ca.fabs(read(term)) for term in sp.Add.make_args(load)), ca.SX(0))
        total += size * _numbers(np.abs(row).reshape(-1, 1))
    return total


def _numbers(matrix: Any) -> ca.DM:
    """Return a matrix of numbers, sparse."""
    import scipy.sparse as sps  # slow to import

    return ca.DM(sps.csc_matrix(matrix))
