"""The constraint forces of sticking contacts, from equations in which the mode is data.

The forces ``lambda`` of the contacts that stick make ``J (a + M^-1 J^T lambda) + d = 0``. The rows of J are made
orthogonal to each other in the sense of ``J M^-1 J^T``, by Gram and Schmidt's method, instead of factorising this
matrix: where two rows nearly agree, it holds only the square of their difference, which rounding destroys, and the
difference of ``J a`` has to be that of the rows times a.
"""

import casadi as ca

# marks of a contact in a mode: what determines its force while it sticks, see `symfric.lower.automaton`; 0 slips
HOLDS, FOLLOWS, SHARES, AT_BOUND = 1.0, 2.0, 3.0, 4.0
DISTINCT = 64 * 2.0**-52  # relative difference of two rows below which their slips differ only by rounding
REDUNDANT = DISTINCT**2  # pivot of the coupling relative to its diagonal below which it is zero


def hold(J: ca.SX, spread: ca.SX, a: ca.SX, d: ca.SX, sticks: ca.SX, tested: bool) -> tuple[ca.SX, ca.SX, ca.SX]:
    """Return the constraint forces of sticking contacts, zero for the others, and the accelerations by them.

    The third result marks contacts with a constraint of their own: 1 if they stick and do not follow from earlier ones.

    Parameters
    ----------
    J, spread : SX, shape (n_c, n_u) and (n_u, n_c)
        Slopes of the slips, and ``M^-1 J^T``.
    a : SX, shape (n_u,)
        The accelerations without these forces.
    d : SX, shape (n_c,)
        The slip accelerations if all velocities stay as they are.
    sticks : SX, shape (n_c,)
    tested : bool
        Whether a contact whose row depends on those before it gets no force; otherwise there is none such.
    """
    n = d.numel()
    J, spread = ca.sparsify(J), ca.sparsify(spread)
    rows, columns = [J[i, :] for i in range(n)], [spread[:, i] for i in range(n)]
    drift = [d[i] for i in range(n)]
    factor = [[ca.SX(0)] * n for _ in range(n)]
    x: list[ca.SX] = []
    reciprocal: list[ca.SX] = []
    holds: list[ca.SX] = []
    for i in range(n):
        size = rows[i] @ columns[i]
        for _ in range(2):  # twice, because once leaves an error of rounding over the difference of the rows
            for j in range(i):
                part = ca.sparsify(rows[j] @ columns[i])
                if part.nnz() == 0:
                    continue
                part = part * reciprocal[j]
                rows[i], columns[i] = rows[i] - part * rows[j], columns[i] - part * columns[j]
                drift[i], factor[j][i] = drift[i] - part * drift[j], factor[j][i] + part
        pivot, own = rows[i] @ columns[i], sticks[i]
        if tested:
            own = ca.logic_and(own, pivot > REDUNDANT * size)
        holds.append(own)
        reciprocal.append(own / (1 - own + own * pivot))  # without a condition, which would prevent gathering of sums
        x.append(-(rows[i] @ a + drift[i]) * reciprocal[i])
    # sum of forces, which may be large and cancel
    gain = sum((columns[i] * x[i] for i in range(n)), ca.SX(J.shape[1], 1))
    for i in reversed(range(n)):
        x[i] -= sum((factor[i][j] * x[j] for j in range(i + 1, n) if not factor[i][j].is_zero()), ca.SX(0))
    return ca.vertcat(*x), gain, ca.vertcat(*holds)
