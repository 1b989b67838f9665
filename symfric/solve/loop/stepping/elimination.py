"""Small systems of linear equations of starts in the plane."""

import numpy as np

from symfric.codegen.array_table import Matrix
from symfric.codegen.numba_types import compiled


@compiled
def solve_in_place(equations: Matrix, n: int, sides: int) -> None:
    """Solve n equations, with right sides behind them, by elimination with exchange of rows.

    The solutions take the places of the right sides; they are not numbers where the equations have none.
    """
    for k in range(n):
        best = k
        for a in range(k + 1, n):
            if abs(equations[a, k]) > abs(equations[best, k]):
                best = a
        if not abs(equations[best, k]) > 0.0:
            equations[:n, n : n + sides] = np.nan
            return
        if best != k:
            for b in range(k, n + sides):
                equations[k, b], equations[best, b] = equations[best, b], equations[k, b]
        for a in range(k + 1, n):
            factor = equations[a, k] / equations[k, k]
            if factor != 0.0:
                for b in range(k + 1, n + sides):
                    equations[a, b] -= factor * equations[k, b]
    for k in range(n - 1, -1, -1):
        for b in range(n, n + sides):
            total = equations[k, b]
            for a in range(k + 1, n):
                total -= equations[k, a] * equations[a, b]
            equations[k, b] = total / equations[k, k]
