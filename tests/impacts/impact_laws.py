"""Impacts from their definition: the impulses of contacts that touch, found by enumeration, by Lemke's pivots and by phases.

Everything acts on rates ``z = (w, a)`` of slips w and gaps a, which impulses ``r = (Q, P)`` change by ``W r``.
"""

import itertools
from dataclasses import dataclass

import numpy as np

APART, STICK, FORWARD, BACKWARD = range(4)
TIE = 1e-10  # margin relative to the rates down to which a combination is admissible
CLEAR = 1e-6  # the same beyond which one is right without a look at the others


class NotUnique(Exception):
    """Two admissible impulses with different velocities behind them."""


class NoSolution(Exception):
    """No admissible impulse."""


@dataclass(frozen=True)
class Touching:
    """Contacts that take part: the friction rows of W come first, in the order of `lines`.

    Attributes
    ----------
    W : array (f + n, f + n)
    lines : list of int
        For every friction row, the contact it belongs to.
    mu, mu_s : array (n,)
        Coefficients of sliding, and of sticking in this impact: those of rest for contacts without slip only.
    e : array (n,)
    """

    W: np.ndarray
    lines: list[int]
    mu: np.ndarray
    mu_s: np.ndarray
    e: np.ndarray

    def row(self, k):
        """Return the friction row of contact k, None without friction."""
        return self.lines.index(k) if k in self.lines else None


def enumerated(c: Touching, z, share=1.0):
    """Return the impulses of ``0 <= P, a+ >= share e |a-|`` with friction on the slip after the impact."""
    return chosen(c, z, share)[1]


def chosen(c: Touching, z, share=1.0, guess=None):
    """Return what every contact does, and the impulses; a guess that is right beyond doubt is not compared with others."""
    n, f = len(c.e), len(c.lines)
    target = share * c.e * np.maximum(-z[f:], 0.0)
    scale = np.max(np.abs(z)) + 1e-300
    if guess is not None:
        one = of_combination(c, z, target, scale, guess)
        if one is not None and one[0] > CLEAR * scale:
            return guess, one[1]
    kinds = [(APART, STICK, FORWARD, BACKWARD) if k in c.lines else (APART, STICK) for k in range(n)]
    found = [
        (*one, choice)
        for choice in itertools.product(*kinds)
        if (one := of_combination(c, z, target, scale, choice)) is not None and one[0] >= -TIE * scale
    ]
    if not found:
        raise NoSolution(f"rates {z}, W {c.W}")
    clear = [one for one in found if one[0] > 1e-6 * scale]
    if clear:  # what static friction can hold stays
        stay = [sum(kind == STICK and c.mu_s[k] > c.mu[k] for k, kind in enumerate(one[3])) for one in clear]
        found = [one for one, held in zip(clear, stay, strict=True) if held == max(stay)]
    best = max(found, key=lambda one: one[0])
    for margin, _, after, _ in found:
        if margin > 1e-6 * scale and np.max(np.abs(after - best[2])) > 1e-6 * scale:
            raise NotUnique(f"rates {z}: {after} and {best[2]}")
    return best[3], best[1]


def of_combination(c: Touching, z, target, scale, choice):
    """Return margin, impulses and rates after them, of one combination; None if it has no impulses."""
    n, f = len(c.e), len(c.lines)
    A, b = np.eye(f + n), np.zeros(f + n)
    for k, kind in enumerate(choice):
        if kind == APART:
            continue
        A[f + k], b[f + k] = c.W[f + k], target[k] - z[f + k]
        i = c.row(k)
        if i is None:
            continue
        if kind == STICK:
            A[i], b[i] = c.W[i], -z[i]
        else:
            A[i, f + k] = c.mu[k] if kind == FORWARD else -c.mu[k]
    r, _, _, singular = np.linalg.lstsq(A, b, rcond=1e-11)
    if np.max(np.abs(A @ r - b)) > TIE * scale:
        return None
    loose = singular[-1] < 1e-11 * singular[0]
    after = z + c.W @ r
    margin = np.inf
    for k, kind in enumerate(choice):
        i, p = c.row(k), r[f + k] * c.W[f + k, f + k]
        margin = min(margin, after[f + k] - target[k] if kind == APART else p)
        if kind == STICK and i is not None:
            margin = min(margin, (c.mu_s[k] * r[f + k] - abs(r[i])) * c.W[i, i])
        if kind in (FORWARD, BACKWARD):
            margin = min(margin, after[i] if kind == FORWARD else -after[i])
    if loose and margin < -TIE * scale:
        return None  # other shares of the load may do; another combination has the same velocities
    return margin, r, after


def by_pivots(c: Touching, z, share=1.0):
    """Return the same impulses from the linear complementarity problem of Stewart and Trinkle, for ``mu = mu_s``."""
    n, f = len(c.e), len(c.lines)
    size = n + 3 * f  # P, Q forward, Q backward, bound of the slip
    T, N = c.W[:f], c.W[f:]
    M, q = np.zeros((size, size)), np.zeros(size)
    signs = np.zeros((f + n, size))
    signs[f:, :n] = np.eye(n)
    signs[:f, n : n + f], signs[:f, n + f : n + 2 * f] = np.eye(f), -np.eye(f)
    M[:n], q[:n] = N @ signs, z[f:] - share * c.e * np.maximum(-z[f:], 0.0)
    M[n : n + f], q[n : n + f] = T @ signs, z[:f]
    M[n + f : n + 2 * f], q[n + f : n + 2 * f] = -T @ signs, -z[:f]
    M[n : n + f, n + 2 * f :] = M[n + f : n + 2 * f, n + 2 * f :] = np.eye(f)
    for i, k in enumerate(c.lines):
        M[n + 2 * f + i, [k, n + i, n + f + i]] = c.mu[k], -1.0, -1.0
    return signs @ lemke(M, q)


def lemke(M, q):
    """Solve ``0 <= x, M x + q >= 0`` complementary, by Lemke's pivots with lexicographic ties."""
    n = len(q)
    if np.all(q >= 0):
        return np.zeros(n)
    # columns: slacks, x, cover, right side
    table = np.hstack([np.eye(n), -M, -np.ones((n, 1)), q[:, None]])
    basis = list(range(n))
    entering, row = 2 * n, int(np.argmin(q))
    for _ in range(50 * n):
        leaving = basis[row]
        table[row] /= table[row, entering]
        others = [i for i in range(n) if i != row]
        table[others] -= np.outer(table[others, entering], table[row])
        basis[row] = entering
        if leaving == 2 * n:
            x = np.zeros(2 * n + 1)
            x[basis] = table[:, -1]
            return x[n : 2 * n]
        entering = leaving + n if leaving < n else leaving - n
        column = table[:, entering]
        possible = [i for i in range(n) if column[i] > 1e-11]
        if not possible:
            raise NoSolution("Lemke's pivots end on a ray")
        ratios = np.array([table[i, -1] / column[i] for i in possible])
        least = ratios.min()
        ties = [i for i, r in zip(possible, ratios, strict=True) if r <= least + 1e-12 * (1 + abs(least))]
        cover = [i for i in ties if basis[i] == 2 * n]
        row = cover[0] if cover else min(ties, key=lambda i: tuple(table[i, :n] / column[i]))
    raise NoSolution("Lemke's pivots do not end")


def energy_gained(W, z, r):
    """Return the kinetic energy that impulses r bring."""
    return float(r @ (z + 0.5 * W @ r))


def several(c: Touching, z):
    """Return the impulses of several contacts: Newton's rule, or the largest share of it that gains no energy."""
    r = enumerated(c, z)
    size = np.abs(r) @ (np.abs(z) + np.abs(z + c.W @ r)) + 1e-300
    if energy_gained(c.W, z, r) <= 1e-11 * size:
        return r
    low, high = 0.0, 1.0
    for _ in range(60):
        middle = 0.5 * (low + high)
        if energy_gained(c.W, z, enumerated(c, z, middle)) <= 0:
            low = middle
        else:
            high = middle
    return enumerated(c, z, low)


def single(W, z, mu, mu_s, e):
    """Return the impulses (Q, P) of one contact, followed phase by phase along its normal impulse (Routh).

    It ends where the gap opens at e times the rate it closed with; if that gains energy, where the work of the normal
    impulse in restitution is e^2 times that of compression (Stronge).
    """
    W, z = np.asarray(W, dtype=float), np.asarray(z, dtype=float)
    (tt, tn), nn = W[0], W[1, 1]

    def phases():
        """Yield direction in (Q, P) and length in P of every phase."""
        w = z[0]
        if abs(w) > 1e-12 * (abs(w) + abs(z[1])):
            d = np.sign(w)
            change = tn - d * mu * tt
            if d * change >= 0:
                yield -d * mu, np.inf
                return
            yield -d * mu, -w / change
        if abs(tn) <= mu_s * tt:
            yield -tn / tt, np.inf
        else:
            yield -np.sign(tn) * mu, np.inf

    def until(stop):
        """Return the impulses at which ``stop(rate at the start of a phase, its slope)`` says the impact ends."""
        r = np.zeros(2)
        for q, length in phases():
            a, slope = (z + W @ r)[1], nn + tn * q
            end = stop(a, slope, length)
            r = r + min(end, length) * np.array([q, 1.0])
            if end <= length:
                return r
        raise NoSolution("the impact does not end")

    def newton(a, slope, length):
        end = (-e * z[1] - a) / slope if slope else np.inf
        return end if end >= 0 else np.inf

    r = until(newton)
    if energy_gained(W, z, r) <= 1e-12 * float(np.abs(r) @ np.abs(z)):
        return r
    work = {"in": 0.0, "out": 0.0}

    def stronge(a, slope, length):
        if a < 0:
            end = min(-a / slope if slope > 0 else np.inf, length)
            work["in"] += -(a + 0.5 * slope * end) * end
            if end == length:
                return np.inf
            a, used = 0.0, end
        else:
            used = 0.0
        left = e * e * work["in"] - work["out"]
        rest = (-a + np.sqrt(a * a + 2 * slope * left)) / slope  # of a x + slope x^2/2 = left
        if used + rest > length:
            x = length - used
            work["out"] += a * x + 0.5 * slope * x * x
            return np.inf
        return used + rest

    return until(stronge)
