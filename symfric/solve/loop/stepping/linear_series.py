"""Taylor series of linear equations by powers of their matrix, as straight-line functions."""

import casadi as ca

from symfric.lower.linear_modes import Matrices
from symfric.lower.structure_modes import StructureMatrices
from symfric.scalars import scalar
from symfric.solve.loop.stepping.series import PROBED, Series

MOST = 50  # number of matrix entries, over all modes, from where loops over those of one mode take hardly longer


def linear_series(matrices: Matrices, n_x: int, order: int) -> Series:
    """Return the series of linear equations of n_x states; for large ones `powers` is used instead."""
    n_r, count = matrices.n_r, len(matrices.rows)
    if count > MOST or isinstance(matrices, StructureMatrices):
        return Series(matrices.data, None, None, order, matrices=matrices)
    numbers = matrices.data(*(ca.SX.sym(name, matrices.data.nnz_in(i)) for i, name in enumerate("pm")))
    aux, state = ca.SX.sym("aux", numbers.numel()), ca.SX.sym("y", n_x + 1)
    known = ca.vertcat(*(ca.SX(0) if numbers[i].is_zero() else aux[i] for i in range(numbers.numel())))
    slope, rest = known[count : count + n_r], known[count + n_r :]

    def flat(name: str, last: int) -> ca.Function:
        now, entries = ca.vertsplit(state[:n_x]), [scalar(e) for e in ca.vertsplit(aux)]
        rows: list[list[ca.SX]] = [[] for _ in range(n_r)]
        for k in range(last + 1):
            new = ca.vertsplit(slope * state[n_x] + rest if k == 0 else slope if k == 1 else ca.SX(n_r, 1))
            for e, (r, j) in enumerate(zip(matrices.rows, matrices.columns, strict=True)):
                new[r] = new[r] + entries[e] * now[j]
            for r in range(n_r):
                rows[r].append(now[r] if r < n_x else new[r])
            now = [e * (1 / (k + 1)) for e in new[:n_x]]
        return ca.Function(name, [state, aux], [ca.densify(ca.vertcat(*(c for row in rows for c in row)))])

    return Series(matrices.data, flat("series", order), flat("probe", PROBED), order)
