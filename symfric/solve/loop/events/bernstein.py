"""Tables that convert polynomials to Bernstein form; see `symfric.solve.loop.events.polynomials`."""

import numpy as np

DEPTH = 52  # depth of subdivision, down to 2^-52 of a step


def bernstein_table(order: int) -> np.ndarray:
    """Return the tables ``C(j, k) / C(n, k)`` for every degree n <= order, shape (order+1, order+1, order+1)."""
    binomial = np.zeros((order + 1, order + 1))
    for j in range(order + 1):
        binomial[j, 0] = 1
        for k in range(1, j + 1):
            binomial[j, k] = binomial[j - 1, k - 1] + binomial[j - 1, k]
    table = np.zeros((order + 1, order + 1, order + 1))
    for n in range(order + 1):
        for j in range(n + 1):
            table[n, j, : j + 1] = binomial[j, : j + 1] / binomial[n, : j + 1]
    return table


def bernstein_columns(order: int, block: int) -> np.ndarray:
    """Return the table of the highest degree, powers as rows, (order + 1, whole blocks); the last column repeats."""
    table = bernstein_table(order)[order].T
    more = -(order + 1) % block
    return np.ascontiguousarray(np.hstack([table, np.repeat(table[:, -1:], more, axis=1)]))
