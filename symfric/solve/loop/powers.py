"""Taylor coefficients of linear equations by powers of their matrix."""

from symfric.codegen.numba_types import compiled


@compiled
def gather(aux, pattern, n_x, count, row, column, entry):
    """List the matrix entries that are nonzero in the current mode, those of the rates first; set their number."""
    count[0] = count[1] = 0
    for e in range(pattern.shape[0]):
        if aux[e] != 0.0:
            entry[count[1]], row[count[1]], column[count[1]] = aux[e], pattern[e, 0], pattern[e, 1]
            count[1] += 1
            count[0] += pattern[e, 0] < n_x


@compiled(fused=True)
def powers(aux, count, row, column, entry, newest, y, c):
    """Compute the coefficients of all rows at state and time y, as many as `c` holds.

    With what `gather` found, and the ends of `aux`, see `symfric.lower.linear_modes.Matrices`.
    """
    n_x, n_r = y.size - 1, c.shape[0]
    slope, rest = aux[aux.size - 2 * n_r :], aux[aux.size - n_r :]
    now, new = newest[0], newest[1]
    for i in range(n_x):
        now[i] = y[i]
    for k in range(c.shape[1]):
        for r in range(n_x):
            c[r, k] = now[r]
            new[r] = slope[r] * y[n_x] + rest[r] if k == 0 else slope[r] if k == 1 else 0.0
        for e in range(count[0]):
            new[row[e]] += entry[e] * now[column[e]]
        inverse = 1.0 / (k + 1)
        for r in range(n_x):
            new[r] *= inverse
        now, new = new, now
    for r in range(n_x, n_r):
        for k in range(2, c.shape[1]):
            c[r, k] = 0.0
        c[r, 0], c[r, 1] = slope[r] * y[n_x] + rest[r], slope[r]
    for e in range(count[0], count[1]):
        of, to, factor = c[column[e]], c[row[e]], entry[e]
        for k in range(c.shape[1]):
            to[k] += factor * of[k]


@compiled(fused=True)
def reach_of(c, h, far, n_x, out):
    """Compute the change of the states over h, and bounds of the change of the other rows over `far`."""
    for r in range(0, n_x, 4):  # four rows at once, as each waits for its last product; the last ones once more
        i, j, k = min(r + 1, n_x - 1), min(r + 2, n_x - 1), min(r + 3, n_x - 1)
        w, x, y, z = 0.0, 0.0, 0.0, 0.0
        for n in range(c.shape[1] - 1, 0, -1):
            w, x, y, z = w * h + c[r, n], x * h + c[i, n], y * h + c[j, n], z * h + c[k, n]
        out[r], out[i], out[j], out[k] = w * h, x * h, y * h, z * h
    last = out.size - 1
    for r in range(n_x, out.size, 4):
        i, j, k = min(r + 1, last), min(r + 2, last), min(r + 3, last)
        w, x, y, z = 0.0, 0.0, 0.0, 0.0
        for n in range(c.shape[1] - 1, 0, -1):
            w, x = w * far + abs(c[r, n]), x * far + abs(c[i, n])
            y, z = y * far + abs(c[j, n]), z * far + abs(c[k, n])
        out[r], out[i], out[j], out[k] = w * far, x * far, y * far, z * far
