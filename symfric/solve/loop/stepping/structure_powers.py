"""Taylor coefficients of a structure with contacts by powers: its own accelerations, and a few forces along rows.

See `symfric.lower.structure_modes`; a coefficient costs the entries of the structure's matrices and of the rows.
"""

from symfric.codegen.array_table import IntegerMatrix, Matrix, Reals
from symfric.codegen.numba_types import compiled
from symfric.lower.constraint_forces import HOLDS
from symfric.solve.loop.workspace import LoopArrays


@compiled
def gather_structure(w: LoopArrays) -> None:
    """List the entries of D that are nonzero in the current mode, and combine the operators of the accelerations."""
    p, pattern, operators = w.powers, w.matrices.pattern, w.matrices.operators
    count, first_felt = 0, p.given.size - w.limits.felt
    p.filled[1] = 0
    for e in range(pattern.shape[0]):
        if w.aux[e] != 0.0:
            p.entry[count], p.row[count], p.column[count] = w.aux[e], pattern[e, 0], pattern[e, 1]
            p.filled[1] += pattern[e, 1] >= first_felt
            count += 1
    p.filled[0] = count
    if operators.shape[0] == 1:
        return
    first_factor = pattern.shape[0] + 2 * p.answers.size
    for e in range(p.combined.size):
        total = operators[0, e]
        for k in range(1, operators.shape[0]):
            total += w.aux[first_factor + k - 1] * operators[k, e]
        p.combined[e] = total


@compiled(inline=True, fused=True)
def _product(rows: Matrix, r: int, n: int, x: Reals, first: int) -> float:
    """Return the product of row r with n entries of x, in four sums that do not wait for each other."""
    row = rows[r]
    a, b, c, d = 0.0, 0.0, 0.0, 0.0
    whole = n - n % 4
    for i in range(0, whole, 4):
        a += row[i] * x[first + i]
        b += row[i + 1] * x[first + i + 1]
        c += row[i + 2] * x[first + i + 2]
        d += row[i + 3] * x[first + i + 3]
    for i in range(whole, n):
        a += row[i] * x[first + i]
    return (a + b) + (c + d)


@compiled(fused=True)
def _accelerate(entries: Reals, places: IntegerMatrix, now: Reals, n: int, a: Reals) -> None:
    """Compute the accelerations of the structure alone."""
    a[:] = 0.0
    if places.shape[0]:
        for e in range(places.shape[0]):
            a[places[e, 0]] += entries[e] * now[places[e, 1]]
        return
    states = entries.size // n
    for j in range(0, states, 4):  # four at once, so that a is read and written a quarter as often
        first, end = j * n, min(4, states - j)
        if end < 4:
            for k in range(end):
                x = now[j + k]
                for i in range(n):
                    a[i] += entries[first + k * n + i] * x
            return
        w, x, y, z = now[j], now[j + 1], now[j + 2], now[j + 3]
        one, two = entries[first : first + n], entries[first + n : first + 2 * n]
        three, four = entries[first + 2 * n : first + 3 * n], entries[first + 3 * n : first + 4 * n]
        for i in range(n):
            a[i] += (one[i] * w + two[i] * x) + (three[i] * y + four[i] * z)


@compiled(fused=True)
def structure_powers(w: LoopArrays, c: Matrix) -> None:
    """Compute the coefficients of all rows at the state and time of a workspace, as many as `c` holds."""
    n, n_x, n_r, n_c = w.limits.n_q, w.y.size - 1, w.powers.answers.size, w.contacts.sticks.size
    along_q, along_u, felt, pushes = w.limits.along_q, w.limits.along_u, w.limits.felt, w.limits.pushes
    states, owned = along_q + along_u, w.matrices.own.size
    held = pushes + n_x - 2 * n
    joint = held + n_c
    others, count, some = joint + 2 * w.matrices.joint.size, w.powers.filled[0], w.powers.filled[1] > 0
    base = w.matrices.pattern.shape[0]
    slope, rest = w.aux[base : base + n_r], w.aux[base + n_r : base + 2 * n_r]
    p, weights, own, anchor = w.powers, w.matrices.weights, w.matrices.own, w.contacts.anchor
    given, answers, a, entry, row, column = p.given, p.answers, p.pushed, p.entry, p.row, p.column
    now, new = p.newest[0], p.newest[1]
    for i in range(n_x):
        now[i] = w.y[i]
    for k in range(c.shape[1]):
        for r in range(n_x):
            c[r, k] = now[r]
        _accelerate(p.combined, w.matrices.places, now, n, a)
        for r in range(states):
            given[r] = _product(weights, r, n, now, 0 if r < along_q else n)
        for j in range(owned):
            given[states + j] = now[own[j]]
        if some:
            for r in range(felt):
                given[states + owned + r] = _product(weights, states + r, n, a, 0)
        for r in range(n_r):
            answers[r] = slope[r] * w.y[n_x] + rest[r] if k == 0 else slope[r] if k == 1 else 0.0
        for e in range(count):
            answers[row[e]] += entry[e] * given[column[e]]
        for j in range(pushes):
            force = answers[j]
            if force != 0.0:
                push = weights[states + felt + j]
                for i in range(n):
                    a[i] += force * push[i]
        for i in range(w.matrices.joint.size):  # exact, so that what is held does not creep by rounding
            if rest[joint + 2 * i] != 0.0:
                a[w.matrices.joint[i]] = answers[joint + 2 * i + 1]
        for i in range(n_c):
            if anchor[i] >= 0 and w.m[i] == HOLDS:
                a[anchor[i] - n] = answers[held + i]
        inverse = 1.0 / (k + 1)
        for i in range(n):
            new[i], new[n + i] = now[n + i] * inverse, a[i] * inverse
        for i in range(2 * n, n_x):
            new[i] = answers[pushes + i - 2 * n] * inverse
        for r in range(others, n_r):
            c[n_x + r - others, k] = answers[r]
        now, new = new, now
