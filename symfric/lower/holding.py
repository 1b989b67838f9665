"""The forces of sticking contacts: a symmetric system of equations in which the mode is data."""

import casadi as ca

REDUNDANT = 1e-11  # part of its diagonal below which a pivot of the coupling vanishes


def hold(A: ca.SX, b: ca.SX, tested: bool) -> ca.SX:
    """Solve A x = b by Cholesky's method without roots; if `tested`, a pivot that vanishes makes its unknown zero."""
    n = b.numel()
    rows = [[A[i, j] for j in range(i + 1)] for i in range(n)]  # becomes L times D below the diagonal
    reciprocal: list[ca.SX] = []
    for j in range(n):
        pivot = rows[j][j] - sum((rows[j][k] * rows[j][k] * reciprocal[k] for k in range(j)), ca.SX(0))
        reciprocal.append(ca.if_else(pivot > REDUNDANT * rows[j][j], 1 / pivot, 0) if tested else 1 / pivot)
        for i in range(j + 1, n):
            rows[i][j] -= sum((rows[i][k] * rows[j][k] * reciprocal[k] for k in range(j)), ca.SX(0))
    x = [b[i] for i in range(n)]
    for i in range(n):
        x[i] -= sum((rows[i][k] * reciprocal[k] * x[k] for k in range(i)), ca.SX(0))
    x = [x[i] * reciprocal[i] for i in range(n)]
    for i in reversed(range(n)):
        x[i] -= sum((rows[k][i] * reciprocal[i] * x[k] for k in range(i + 1, n)), ca.SX(0))
    return ca.vertcat(*x)
