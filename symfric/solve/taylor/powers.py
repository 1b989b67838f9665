"""Taylor coefficients of linear equations: powers of their matrix, applied to the state."""

from numba import njit

from symfric.solve.native import INNER
from symfric.solve.taylor.polynomials import FUSED


@njit(**INNER)
def gather(aux, n_x, begin, column, entry):
    """Collect the entries of the matrices that are not zero, row by row; few are not."""
    n_r, count = begin.size - 1, 0
    for r in range(n_r):
        begin[r] = count
        for j in range(n_x):
            if aux[j * n_r + r] != 0.0:
                entry[count], column[count] = aux[j * n_r + r], j
                count += 1
    begin[n_r] = count


@njit(**INNER, fastmath=FUSED)
def powers(aux, begin, column, entry, newest, y, c):
    """Compute the coefficients of all rows at state and time y, as many as `c` holds.

    With `aux` from `symfric.lower.linear.matrices`: ``x' = A x + a t + b``, the other rows likewise.
    """
    n_x, n_r = y.size - 1, c.shape[0]
    slope, rest = aux[n_x * n_r :], aux[(n_x + 1) * n_r :]
    now, new = newest[0], newest[1]
    for i in range(n_x):
        now[i] = y[i]
    for k in range(c.shape[1]):
        inverse = 1.0 / (k + 1)
        for r in range(n_r):
            total = 0.0
            if k == 0:
                total = slope[r] * y[n_x] + rest[r]
            elif k == 1:
                total = slope[r]
            for e in range(begin[r], begin[r + 1]):
                total += entry[e] * now[column[e]]
            if r < n_x:
                c[r, k] = now[r]
                new[r] = total * inverse
            else:
                c[r, k] = total
        now, new = new, now


@njit(**INNER, fastmath=FUSED)
def reach_of(c, h, far, n_x, out):
    """Compute what h adds to the states, and by how much `far` can change the other rows that `out` has room for."""
    for r in range(out.size):
        total = 0.0
        if r < n_x:
            for k in range(c.shape[1] - 1, 0, -1):
                total = total * h + c[r, k]
            out[r] = total * h
        else:
            for k in range(c.shape[1] - 1, 0, -1):
                total = total * far + abs(c[r, k])
            out[r] = total * far
