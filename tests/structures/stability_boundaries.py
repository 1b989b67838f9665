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


def differences(s, found, low, high, points=300, neutral=None):
    """Return what the count says and `found` does not, and the other way round."""
    if neutral is None:
        neutral = 1e-7 if s.C is None or abs(s.C + s.C.T).max() < 1e-13 else 0.0
    exact, size = changes(s, low, high, points, neutral), np.max(np.abs(spectrum(s, low)))
    said = [(p.mu, p.omega, 1, p.kind) for p in found.critical] + [(p.mu, p.omega, -1, p.kind) for p in found.regained]
    width, near = 1e-7 * (high - low), 1e-3 * size
    wrong = []
    for mu, omega, change in exact:
        still = abs(change) == 1
        here = [p for p in said if abs(p[0] - mu) <= width and np.sign(p[2]) == np.sign(change)]
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
