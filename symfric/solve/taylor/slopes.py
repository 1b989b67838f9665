"""Slopes of a motion, from which its derivatives follow.

The rates and observables of a motion are sums ``c a + d`` with fixed coefficients of atoms a: states, and nonlinear
operations. Derivatives V of the states change them by ``L V + c (G V) + b``, with the slopes G of the nonlinear atoms,
which several rates may contain, as those of a bristle and of the mass that it pulls; or, if fewer entries of it change
in time, by ``A V + b`` with ``A = L + c G``.
"""

import casadi as ca

from symfric.lower.automaton import VariedField
from symfric.solve.taylor.affine_forms import affine


def slopes_of(varied: VariedField, n_y: int) -> ca.Function:
    """Return the function ``(y, t, p, m) -> (L, c, G, b)``; row by row of rates, then of the observables followed.

    Parameters
    ----------
    varied : VariedField
    n_y : int
        Number of states with derivatives; those of the motion are the first ones.
    """
    field = varied.field
    whole = [ca.SX.sym(name, field.nnz_in(i)) for i, name in enumerate("ytpm")]
    y, t, p, _ = whole
    n_x, n_s = y.numel(), len(varied.directions)
    first = n_x + field.nnz_out(1)
    c, atoms, rest = affine(field, whole, [*range(n_x), *range(first, first + varied.followed)])
    moved = sorted({k for k in varied.directions if k >= 0})
    values = ca.vertcat(*(p[k] for k in moved)) if moved else ca.SX(0, 1)
    by_all = ca.jacobian(atoms, ca.vertcat(y, values))  # at once, so that both parts have the same products
    G, by_value = by_all[:, :n_x], ca.SX(c.shape[0], n_s)
    of_values = c @ by_all[:, n_x:] + ca.jacobian(rest, values) if moved else None
    for s, k in enumerate(varied.directions):
        if of_values is not None and k >= 0:
            by_value[:, s] = of_values[:, moved.index(k)] + ca.reshape(ca.jacobian(c, p[k]), c.shape) @ atoms
    moving = ca.vertcat(y, t)
    nonlinear = [a for a in range(atoms.numel()) if _moving(G[a, :], moving)]
    linear = [a for a in range(atoms.numel()) if a not in nonlinear]
    L = c[:, linear] @ G[linear, :]
    c, G = c[:, nonlinear], G[nonlinear, :]
    A = L + c @ G
    if _moving(A, moving) <= _moving(G, moving):
        L, c, G = A, ca.SX(A.shape[0], 0), ca.SX(0, n_x)
    state = ca.SX.sym("y", n_y)
    out = [ca.substitute(e, y, state[:n_x]) for e in (L, c, G, by_value)]
    return ca.Function(
        "slopes", [state, *whole[1:]], [ca.densify(e.T) for e in out], ["y", "t", "p", "m"], ["L", "c", "G", "b"]
    )


def _moving(e: ca.SX, moving: ca.SX) -> int:
    """Return how many entries change in time."""
    entries = ca.vertsplit(ca.vec(ca.densify(e))) if e.numel() else []
    return sum(ca.depends_on(entry, moving) for entry in entries)
