"""The constraint forces of sticking contacts, from equations in which the mode is data.

The forces ``lambda`` of the contacts that stick make ``J (a + M^-1 J^T lambda) + d = 0``. The rows of J are made
orthogonal to each other in the sense of ``J M^-1 J^T``, by Gram and Schmidt's method, instead of factorising this
matrix: where two rows nearly agree, it holds only the square of their difference, which rounding destroys, and the
difference of ``J a`` has to be that of the rows times a.
"""

from dataclasses import dataclass

import casadi as ca

# marks of a contact in a mode: what determines its force while it sticks, see `symfric.lower.automaton`; 0 slips
HOLDS, FOLLOWS, SHARES, AT_BOUND = 1.0, 2.0, 3.0, 4.0
DISTINCT = 64 * 2.0**-52  # relative difference of two rows below which their slips differ only by rounding
REDUNDANT = DISTINCT**2  # pivot of the coupling relative to its diagonal below which it is zero


@dataclass(frozen=True, eq=False)
class ConstraintBasis:
    """The rows of sticking contacts, made orthogonal to each other.

    Attributes
    ----------
    rows, columns : list of SX, shape (1, n_u) and (n_u, 1)
        Of each contact, of J and of ``M^-1 J^T``.
    parts : list of (int, int, SX)
        What was subtracted, in this order: from row i (first) so many times row j (second).
    reciprocals : list of SX
        1 over the square of each row, 0 for contacts without a constraint of their own.
    own : list of SX
        1 for contacts that stick and do not follow from earlier ones.
    """

    rows: list[ca.SX]
    columns: list[ca.SX]
    parts: list[tuple[int, int, ca.SX]]
    reciprocals: list[ca.SX]
    own: list[ca.SX]

    def forces(self, a: ca.SX, d: ca.SX) -> tuple[ca.SX, ca.SX]:
        """Return the constraint forces, zero for contacts that do not stick, and the accelerations by them.

        Parameters
        ----------
        a : SX, shape (n_u,)
            The accelerations without these forces.
        d : SX, shape (n_c,)
            The slip accelerations if all velocities stay as they are.
        """
        n = len(self.rows)
        drift = [d[i] for i in range(n)]
        factor = [[ca.SX(0)] * n for _ in range(n)]
        for i, j, part in self.parts:
            drift[i], factor[j][i] = drift[i] - part * drift[j], factor[j][i] + part
        x = [-(self.rows[i] @ a + drift[i]) * self.reciprocals[i] for i in range(n)]
        # sum of forces, which may be large and cancel
        gain = sum((self.columns[i] * x[i] for i in range(n)), ca.SX(self.rows[0].numel() if n else 0, 1))
        for i in reversed(range(n)):
            x[i] -= sum((factor[i][j] * x[j] for j in range(i + 1, n) if not factor[i][j].is_zero()), ca.SX(0))
        return ca.vertcat(*x), gain

    def remainder(self, z: ca.SX) -> tuple[ca.SX, ca.SX]:
        """Return what the constraints leave of velocities z, and the magnitudes of the terms that cancel in it."""
        parts = [c * (r @ z) * q for c, r, q in zip(self.columns, self.rows, self.reciprocals, strict=True)]
        none = ca.SX(z.numel(), 1)
        return z - sum(parts, none), ca.fabs(z) + sum((ca.fabs(e) for e in parts), none)


def constraint_basis(J: ca.SX, spread: ca.SX, sticks: ca.SX, tested: bool) -> ConstraintBasis:
    """Return the orthogonal rows of contacts.

    Parameters
    ----------
    J, spread : SX, shape (n_c, n_u) and (n_u, n_c)
        Slopes of the slips, and ``M^-1 J^T``.
    sticks : SX, shape (n_c,)
    tested : bool
        Whether a contact whose row depends on those before it gets no force; otherwise there is none such.
    """
    n = J.rows()
    J, spread = ca.sparsify(J), ca.sparsify(spread)
    rows, columns = [J[i, :] for i in range(n)], [spread[:, i] for i in range(n)]
    parts: list[tuple[int, int, ca.SX]] = []
    reciprocals: list[ca.SX] = []
    holds: list[ca.SX] = []
    for i in range(n):
        size = rows[i] @ columns[i]
        for _ in range(2):  # twice, because once leaves an error of rounding over the difference of the rows
            for j in range(i):
                part = ca.sparsify(rows[j] @ columns[i])
                if part.nnz() == 0:
                    continue
                part = part * reciprocals[j]
                rows[i], columns[i] = rows[i] - part * rows[j], columns[i] - part * columns[j]
                parts.append((i, j, part))
        pivot, own = rows[i] @ columns[i], sticks[i]
        if tested:
            own = ca.logic_and(own, pivot > REDUNDANT * size)
        holds.append(own)
        reciprocals.append(own / (1 - own + own * pivot))  # without a condition, which would prevent gathering of sums
    return ConstraintBasis(rows, columns, parts, reciprocals, holds)


def hold(J: ca.SX, spread: ca.SX, a: ca.SX, d: ca.SX, sticks: ca.SX, tested: bool) -> tuple[ca.SX, ca.SX, ca.SX]:
    """Return the constraint forces of sticking contacts, zero for the others, and the accelerations by them.

    The third result marks contacts with a constraint of their own: 1 if they stick and do not follow from earlier ones.

    Parameters
    ----------
    J, spread, sticks, tested
        See `constraint_basis`.
    a, d
        See `ConstraintBasis.forces`.
    """
    basis = constraint_basis(J, spread, sticks, tested)
    return *basis.forces(a, d), ca.vertcat(*basis.own)
