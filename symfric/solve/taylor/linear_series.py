"""The Taylor series of linear equations: powers of their matrix, applied to the state, as straight-line functions."""

import casadi as ca

from symfric.lower.automaton import Automaton
from symfric.solve.taylor.jets import PROBED, Series

MOST = 120  # entries of the matrices, in all modes together, beyond which loops over those of one mode are faster


def linear_series(automaton: Automaton, prelude: ca.Function, order: int) -> Series:
    """Return the series that follow from `symfric.lower.linear.matrices`; large ones are left to `powers`."""
    n_x, n_r = len(automaton.states), prelude.nnz_out(0) // (len(automaton.states) + 2)
    numbers = prelude(*(ca.SX.sym(name, prelude.nnz_in(i)) for i, name in enumerate("pm")))
    aux, state = ca.SX.sym("aux", numbers.numel()), ca.SX.sym("y", n_x + 1)
    entry = [None if numbers[i].is_zero() else aux[i] for i in range(numbers.numel())]
    columns = [entry[j * n_r : (j + 1) * n_r] for j in range(n_x + 2)]
    if sum(e is not None for column in columns[:n_x] for e in column) > MOST:
        return Series(prelude=prelude, series=None, probe=None, order=order, entire=True)

    def flat(name: str, last: int) -> ca.Function:
        now, rows = ca.vertsplit(state[:n_x]), [[] for _ in range(n_r)]
        for k in range(last + 1):
            drive = [state[n_x], ca.SX(1)] if k == 0 else [ca.SX(1) if k == 1 else ca.SX(0), ca.SX(0)]
            new = [
                sum((e[r] * v for e, v in zip(columns, [*now, *drive], strict=True) if e[r] is not None), ca.SX(0))
                for r in range(n_r)
            ]
            for r in range(n_r):
                rows[r].append(now[r] if r < n_x else new[r])
            now = [e * (1 / (k + 1)) for e in new[:n_x]]
        return ca.Function(name, [state, aux], [ca.densify(ca.vertcat(*(c for row in rows for c in row)))])

    return Series(prelude, flat("series", order), flat("probe", PROBED), order, True)
