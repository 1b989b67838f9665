"""Drawn scenes with friction regularised over a small speed, compiled: cheap enough for hundreds of scenes.

The equations are those of `plane_reference.regularised`, of which the tests prove this one a copy; the integrator is
Radau's of order five with the error estimate of Hairer and Wanner and its own Jacobian by differences, since those of SciPy
spend nearly all of their time in Python.
"""

import math

import numba
import numpy as np

_ROOT = math.sqrt(6.0)
A = np.array(
    [
        [(88 - 7 * _ROOT) / 360, (296 - 169 * _ROOT) / 1800, (-2 + 3 * _ROOT) / 225],
        [(296 + 169 * _ROOT) / 1800, (88 + 7 * _ROOT) / 360, (-2 - 3 * _ROOT) / 225],
        [(16 - _ROOT) / 36, (16 + _ROOT) / 36, 1 / 9],
    ]
)
NODES = np.array([(4 - _ROOT) / 10, (4 + _ROOT) / 10, 1.0])
ERROR = np.array([-13 - 7 * _ROOT, -13 + 7 * _ROOT, -1.0]) / 3
REAL = 3 + 3 ** (2 / 3) - 3 ** (1 / 3)
NEWTON = 7  # most iterations of a step
FINE = 0.3  # largest step times norm of the Jacobian where friction falls with the speed


@numba.njit(cache=False)
def _rates(t, y, eps, M, swing, K, D, f, pull, w, rows, numbers, out):
    """Set the rates; `numbers` of each contact: load, swell, belt (2), shake (2), mu_s, mu_k, v_s or 0."""
    n = pull.size
    wave = math.cos(w * t)
    force = pull + f * wave - K @ y[:n] - D @ y[n:]
    for k in range(rows.shape[0]):
        load, swell, b0, b1, s0, s1, mu_s, mu_k, v_s = numbers[k]
        a = rows[k, 0] @ y[n:] - b0 - s0 * wave
        b = rows[k, 1] @ y[n:] - b1 - s1 * wave
        v = math.hypot(a, b)
        if v_s > 0.0:
            size = (mu_k + (mu_s - mu_k) * math.exp(-v / v_s)) / math.hypot(v, eps)
        elif mu_s == mu_k:
            size = mu_k / math.hypot(v, eps)
        elif v < eps:
            size = mu_s / eps
        else:
            size = (mu_k + (mu_s - mu_k) * max(0.0, 2.0 - v / eps)) / v
        size *= load * (1.0 + swell * wave)
        force -= (rows[k, 0] * a + rows[k, 1] * b) * size
    mass = M.copy()
    for i in range(n):
        mass[i, i] += swing * M[i, i] * math.sin(y[0])
    out[:n], out[n:] = y[n:], np.linalg.solve(mass, force)


@numba.njit(cache=False)
def _jacobian(t, y, eps, rate, J, other, *scene):
    n = y.size // 2
    for r in range(y.size):
        step = 1e-7 if r < n else 1e-4 * eps
        before = y[r]
        y[r] = before + step
        _rates(t, y, eps, *scene, other)
        y[r] = before
        J[:, r] = (other - rate) / step


@numba.njit(cache=False)
def _falls(t, y, eps, w, rows, numbers):
    """Tell whether a contact creeps on the part of its law where friction falls from its bound at rest."""
    wave = math.cos(w * t)
    u = y[y.size // 2 :]
    for k in range(rows.shape[0]):
        _, _, b0, b1, s0, s1, mu_s, mu_k, v_s = numbers[k]
        if v_s == 0.0 and mu_s > mu_k:
            v = math.hypot(rows[k, 0] @ u - b0 - s0 * wave, rows[k, 1] @ u - b1 - s1 * wave)
            if eps < v < 2.0 * eps:
                return True
    return False


@numba.njit(cache=False)
def _radau(y, horizon, eps, tolerance, *scene):
    n = y.size
    J, rate, other = np.zeros((n, n)), np.zeros(n), np.zeros(n)
    stages, F = np.zeros((3, n)), np.zeros((3, n))
    t, h, steps = 0.0, 1e-6, 0
    size = tolerance * (eps + np.abs(y))
    while t < horizon and steps < 2_000_000:
        h = min(h, horizon - t)
        _rates(t, y, eps, *scene, rate)
        _jacobian(t, y, eps, rate, J, other, *scene)
        inverse = np.linalg.inv(np.eye(3 * n) - h * np.kron(A, J))
        stages[:] = 0.0
        size = tolerance * (eps + np.abs(y))
        converged, before, rating = False, np.inf, 1.0
        for k in range(NEWTON):
            for i in range(3):
                _rates(t + NODES[i] * h, y + stages[i], eps, *scene, other)
                F[i] = other
            change = (inverse @ (h * (A @ F) - stages).copy().reshape(3 * n)).reshape(3, n)
            stages += change
            moved = math.sqrt(np.mean((change / size) ** 2))
            if k > 0:
                rating = moved / before
                if rating > 0.9:
                    break
            if moved < 1e-3 or (k > 0 and moved * rating / (1.0 - rating) < 1e-3):
                converged = True
                break
            before = moved
        steps += 1
        if not converged:
            h *= 0.4
            continue
        combined = (ERROR[0] * stages[0] + ERROR[1] * stages[1] + ERROR[2] * stages[2]) / h
        real = REAL / h * np.eye(n) - J
        error = np.linalg.solve(real, rate + combined)
        norm = math.sqrt(np.mean((error / size) ** 2))
        if norm > 1.0:
            _rates(t, y + error, eps, *scene, other)
            error = np.linalg.solve(real, other + combined)
            norm = math.sqrt(np.mean((error / size) ** 2))
        if norm > 1.0:
            h *= max(0.2, 0.9 * norm**-0.25)
            continue
        # long steps of a method as stable as this one stay on the falling part, which no motion does
        fine = FINE / np.abs(J).sum(axis=1).max()
        if h > fine and (_falls(t, y, eps, *scene[6:]) or _falls(t + h, y + stages[2], eps, *scene[6:])):
            h = fine
            continue
        y = y + stages[2]
        t += h
        h *= min(8.0, 0.9 * max(norm, 1e-12) ** -0.25)
    return y, steps


def arrays_of(scene):
    """Return the numbers of a drawn scene in the order of `_rates`."""
    numbers = [[c.load, c.swell, *c.belt, *c.shake, c.mu_s, c.mu_k, c.v_s or 0.0] for c in scene.tables]
    rows = np.array([c.rows for c in scene.tables])
    given = (scene.K, scene.D + scene.G, scene.f, scene.pull)
    return (
        np.ascontiguousarray(scene.M),
        float(scene.swing),
        *(np.ascontiguousarray(a, dtype=float) for a in given),
        float(scene.w),
        rows,
        np.array(numbers, dtype=float),
    )


def regularised(scene, eps, tolerance=1e-9):
    """Return the state at the horizon of a drawn scene with friction regularised over the speed eps."""
    y, steps = _radau(scene.start.copy(), scene.horizon, eps, tolerance, *arrays_of(scene))
    assert steps < 2_000_000
    return y
