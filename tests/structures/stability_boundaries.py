"""Random structures, and where they lose stability by a count of growing eigenvalues, apart from the package."""

import numpy as np
import scipy.linalg as sla

import symfric as sf

KINDS = ("damped", "nearly undamped", "gyroscopic", "proportional", "symmetric", "undamped", "conservative gyroscopic")


def random_structure(seed: int, n: int, kind: str):
    """Return a structure of some kind, and how far mu goes."""
    draw = np.random.default_rng([seed, n, KINDS.index(kind)])
    root = np.eye(n) + 0.3 * draw.standard_normal((n, n)) / np.sqrt(n)
    M, K = root @ root.T, root @ np.diag(draw.uniform(1, 6, n)) @ root.T
    F = draw.standard_normal((n, n)) * 3 / np.sqrt(n)
    half = 0.3 * draw.standard_normal((n, n)) / np.sqrt(n)
    skew = draw.standard_normal((n, n)) / np.sqrt(n)
    C = half @ half.T + 0.01 * np.eye(n)
    if kind == "nearly undamped":
        C = C * 10.0 ** draw.uniform(-6, -3)
    elif kind == "gyroscopic":
        C = C + skew - skew.T
    elif kind == "proportional":
        C = 0.01 * M + 0.02 * K
    elif kind == "undamped":
        C = None
    elif kind == "conservative gyroscopic":
        C = 2 * (skew - skew.T)
    if kind in ("symmetric", "conservative gyroscopic"):
        F = F + F.T
    return sf.structures.Structure(M, K, C, F)


def large_structure(seed: int, n: int, kind: str):
    """Return a structure with some low modes apart from the others, of every fourth seed among them.

    Friction couples all modes, through few rows or through all of them.
    """
    draw = np.random.default_rng([seed, n, KINDS.index(kind), 9])
    root = np.eye(n) + 0.3 * draw.standard_normal((n, n)) / np.sqrt(n)
    few = int(draw.integers(4, 13))
    omega = np.concatenate([np.sort(draw.uniform(5, 15, few)), 30 + np.cumsum(draw.uniform(1, 6, n - few))])
    if seed % 4 == 0:
        omega = 5 + np.cumsum(draw.uniform(0.2, 2, n))
    rank = int(draw.integers(1, 5)) if draw.random() < 0.5 else n
    F = draw.standard_normal((n, rank)) @ draw.standard_normal((rank, n)) / np.sqrt(rank) * draw.uniform(10, 50)
    half, skew = (draw.standard_normal((n, n)) / np.sqrt(n) for _ in range(2))
    C, turn = 0.05 * half @ half.T + 0.01 * np.eye(n), 0.5 * (skew - skew.T)
    if kind == "nearly undamped":
        C = C * 10.0 ** draw.uniform(-6, -3)
    elif kind == "gyroscopic":
        C = C + turn
    elif kind == "proportional":
        C = 0.01 * np.eye(n) + 0.002 * np.diag(omega**2)
    elif kind == "undamped":
        C = None
    elif kind == "conservative gyroscopic":
        C = turn
    if kind in ("symmetric", "conservative gyroscopic"):
        F = F + F.T
    M, K, C, F = (None if e is None else root @ e @ root.T for e in (np.eye(n), np.diag(omega**2), C, F))
    return sf.structures.Structure(M, K, C, F)


def apart(s, near, mus):
    """Return how many of the modes nearest to a frequency no other comes near to over the values of mu, at best.

    And how far from the frequency the last of them is, shape (n_mu,), and how much farther the next one, relatively.
    """
    found = [spectrum(s, mu) for mu in mus]
    found = [e[(e.imag > 0) | ((e.imag == 0) & (e.real >= 0))] for e in found]
    reach = np.array([np.sort(np.abs(e - 1j * near))[:17] for e in found])
    gaps = np.min((reach[:, 3:] - reach[:, 2:-1]) / reach[:, 3:], axis=0)
    best = int(np.argmax(gaps))
    return 3 + best, reach[:, 2 + best], float(gaps[best])


def spectrum(s, mu):
    n, M = s.n, s.M.toarray()
    if s.C is None:
        squares = sla.eigvals(s.stiffness(mu).toarray(), M)
        root = np.sqrt(-squares.astype(complex))
        return np.concatenate([root, -root])
    block = np.block([[np.zeros((n, n)), np.eye(n)], [-s.stiffness(mu).toarray(), -s.C.toarray()]])
    return np.linalg.eigvals(np.linalg.solve(sla.block_diag(np.eye(n), M), block))


def growing(s, mu, neutral):
    """Return the number of eigenvalues that grow."""
    found = spectrum(s, mu)
    return int(np.sum(found.real > neutral * np.max(np.abs(found))))


def changes(s, low, high, points, neutral):
    """Return (mu, omega, change of the number that grow) by bisection between the points of a grid."""
    mus = np.linspace(low, high, points)
    counts, found = [growing(s, mu, neutral) for mu in mus], []
    for a, b, m, n in zip(mus[:-1], mus[1:], counts[:-1], counts[1:], strict=True):
        todo = [(a, b, m, n)] if m != n else []
        while todo:
            a, b, m, n = todo.pop()
            if b - a < 1e-11 * (high - low):
                inside = spectrum(s, b if n > m else a)
                inside = inside[inside.imag >= -1e-12]
                grown = inside[inside.real > neutral * np.max(np.abs(inside))]
                value = grown[np.argmin(grown.real)]
                found.append((0.5 * (a + b), float(value.imag), n - m))
                continue
            c = 0.5 * (a + b)
            k = growing(s, c, neutral)
            todo += [e for e in ((a, c, m, k), (c, b, k, n)) if e[2] != e[3]]
    return sorted(found)


def neutral_to_rounding(s, mu, omega):
    """Whether the growth of the eigenvalue next to ``i omega`` is no more than the error of eigenvalues."""
    values = spectrum(s, mu)
    return abs(values[np.argmin(np.abs(values - 1j * omega))].real) < 1e-15 * np.max(np.abs(values))


def differences(s, found, low, high, points=300, neutral=None, known=lambda mu, omega: True):
    """Return what the count says and `found` does not, and the other way round; `known`: which flutter has to be found."""
    if neutral is None:
        neutral = 1e-7 if s.C is None or abs(s.C + s.C.T).max() < 1e-13 else 0.0
    exact, size = changes(s, low, high, points, neutral), np.max(np.abs(spectrum(s, low)))
    exact = [e for e in exact if abs(e[2]) == 1 or known(*e[:2])]
    said = [(p.mu, p.omega, 1, p.kind) for p in found.critical] + [(p.mu, p.omega, -1, p.kind) for p in found.regained]
    width, wrong = 1e-7 * (high - low), []
    for mu, omega, change in exact:
        near = 1e-3 * min(size, 10 * omega + 1)
        still = abs(change) == 1
        here = [p for p in said if abs(p[0] - mu) <= 100 * width and np.sign(p[2]) == np.sign(change)]
        here = [p for p in here if abs(p[0] - mu) <= width or neutral_to_rounding(s, *p[:2])]
        if not any(
            p[3] == ("divergence" if still else "flutter") and abs(p[1] - (0 if still else omega)) <= near for p in here
        ):
            wrong.append(("missing", mu, omega, change))
    for mu, omega, change, kind in said:
        step = min(1e-6 * (high - low), 0.3 * min([abs(e[0] - mu) for e in said if e[0] != mu], default=1.0))
        if low < mu - step and mu + step < high:
            by = growing(s, mu + step, neutral) - growing(s, mu - step, neutral)
            if by * change <= 0:
                wrong.append(("false", mu, omega, change, kind))
    return exact, wrong
