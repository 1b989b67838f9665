"""Taylor coefficients of linear equations by powers of their matrix."""

import numpy as np

from symfric.codegen.array_table import IntegerMatrix, Matrix, Reals
from symfric.codegen.numba_types import compiled
from symfric.solve.loop.records import Powers


@compiled
def gather(aux: Reals, pattern: IntegerMatrix, n_x: int, p: Powers) -> None:
    """List the matrix entries that are nonzero in the current mode, those of the rates first; set their number."""
    count = p.filled
    count[0] = count[1] = 0
    for e in range(pattern.shape[0]):
        if aux[e] != 0.0:
            p.entry[count[1]], p.row[count[1]], p.column[count[1]] = aux[e], pattern[e, 0], pattern[e, 1]
            count[1] += 1
            count[0] += pattern[e, 0] < n_x


@compiled(fused=True)
def powers(aux: Reals, p: Powers, y: Reals, c: Matrix) -> None:
    """Compute the coefficients of all rows at state and time y, as many as `c` holds.

    With what `gather` found, and the ends of `aux`, see `symfric.lower.linear_modes.Matrices`. Indices are unsigned: of
    others numba looks whether they count from the end, which takes as long as the sums.
    """
    n_x, n_r, orders = np.uint64(y.size - 1), np.uint64(c.shape[0]), np.uint64(c.shape[1])
    slope, rest = aux[aux.size - 2 * c.shape[0] :], aux[aux.size - c.shape[0] :]
    now, new, t, row, column, entry = p.newest[0], p.newest[1], y[n_x], p.row, p.column, p.entry
    of_rates, of_all = np.uint64(p.filled[0]), np.uint64(p.filled[1])
    for i in range(n_x):
        now[i] = y[i]
    for k in range(orders):
        for r in range(n_x):
            c[r, k] = now[r]
        if k > 1:
            new[:] = 0.0
        else:
            for r in range(n_x):
                new[r] = slope[r] * t + rest[r] if k == 0 else slope[r]
        for e in range(of_rates):
            new[np.uint64(row[e])] += entry[e] * now[np.uint64(column[e])]
        inverse = 1.0 / np.float64(k + np.uint64(1))
        for r in range(n_x):
            new[r] *= inverse
        now, new = new, now
    for r in range(n_x, n_r):
        for k in range(orders):
            c[r, k] = 0.0
        c[r, 0], c[r, 1] = slope[r] * t + rest[r], slope[r]
    for e in range(of_rates, of_all):
        of, to, factor = c[np.uint64(column[e])], c[np.uint64(row[e])], entry[e]
        for k in range(orders):
            to[k] += factor * of[k]


@compiled(fused=True)
def reach_of(c: Matrix, h: float, far: float, n_x: int, out: Reals) -> None:
    """Compute the change of the states over h, and bounds of the change of the other rows over `far`."""
    orders, last = np.uint64(c.shape[1] - 1), n_x - 1
    for r in range(0, n_x, 4):  # four rows at once, as each waits for its last product; the last ones once more
        a, b = c[np.uint64(r)], c[np.uint64(min(r + 1, last))]
        d, e = c[np.uint64(min(r + 2, last))], c[np.uint64(min(r + 3, last))]
        w, x, y, z = 0.0, 0.0, 0.0, 0.0
        for k in range(orders):
            n = orders - k
            w, x, y, z = w * h + a[n], x * h + b[n], y * h + d[n], z * h + e[n]
        out[r], out[min(r + 1, last)] = w * h, x * h
        out[min(r + 2, last)], out[min(r + 3, last)] = y * h, z * h
    last = out.size - 1
    for r in range(n_x, out.size, 4):
        a, b = c[np.uint64(r)], c[np.uint64(min(r + 1, last))]
        d, e = c[np.uint64(min(r + 2, last))], c[np.uint64(min(r + 3, last))]
        w, x, y, z = 0.0, 0.0, 0.0, 0.0
        for k in range(orders):
            n = orders - k
            w, x = w * far + abs(a[n]), x * far + abs(b[n])
            y, z = y * far + abs(d[n]), z * far + abs(e[n])
        out[r], out[min(r + 1, last)] = w * far, x * far
        out[min(r + 2, last)], out[min(r + 3, last)] = y * far, z * far
