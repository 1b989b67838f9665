"""Taylor coefficients of linear equations: powers of their matrix, applied to the state."""

from numba import njit

from symfric.solve.taylor.polynomials import FUSED


@njit(nogil=True, _nrt=False)
def gather(w):
    """Collect the entries of the matrices that are not zero, row by row; few are not."""
    n_x, n_r = w.y.size - 1, w.c.shape[0]
    count = 0
    for r in range(n_r):
        w.begin[r] = count
        for j in range(n_x):
            if w.aux[j * n_r + r] != 0.0:
                w.entry[count], w.column[count] = w.aux[j * n_r + r], j
                count += 1
    w.begin[n_r] = count


@njit(nogil=True, _nrt=False, fastmath=FUSED)
def powers(w, y, c):
    """Compute the coefficients of all rows at state and time y, as many as `c` holds.

    With ``w.aux`` from `symfric.lower.linear.matrices`: ``x' = A x + a t + b``, the other rows likewise.
    """
    n_x, n_r = y.size - 1, c.shape[0]
    slope, rest = w.aux[n_x * n_r :], w.aux[(n_x + 1) * n_r :]
    now, new = w.newest[0], w.newest[1]
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
            for e in range(w.begin[r], w.begin[r + 1]):
                total += w.entry[e] * now[w.column[e]]
            if r < n_x:
                c[r, k] = now[r]
                new[r] = total * inverse
            else:
                c[r, k] = total
        now, new = new, now


@njit(nogil=True, _nrt=False, fastmath=FUSED)
def reach_of(c, h, n_x, out):
    """Compute what h adds to the states, and by how much it can change the other rows that `out` has room for."""
    for r in range(out.size):
        total = 0.0
        if r < n_x:
            for k in range(c.shape[1] - 1, 0, -1):
                total = total * h + c[r, k]
        else:
            for k in range(c.shape[1] - 1, 0, -1):
                total = total * h + abs(c[r, k])
        out[r] = total * h
