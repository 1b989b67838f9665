"""A second method for structures with Coulomb contacts: matrix exponentials, and every mode tried at an event.

It shares nothing with the package: steps of a fixed length, guards looked at there, events by bisection, and of all
combinations of sticking and slipping the consistent one with the most contacts at rest.
"""

import itertools

import numpy as np
import scipy.linalg as sla

STEP, CLOSE = 0.02, 1e-13


class Exponentials:
    """``M q'' + C q' + K q = f_0 + f_1 cos(W t) + J^T lambda`` with slips ``J q' - v``.

    The state is (q, q', 1, cos W t, sin W t).
    """

    def __init__(self, M, C, K, J, loads, static, kinetic, speeds, f_0, f_1, W):
        self.n, self.J, self.loads = len(M), np.asarray(J), np.asarray(loads)
        self.static, self.kinetic, self.speeds = static, kinetic, np.asarray(speeds)
        forces = np.column_stack([-K, -C, f_0, f_1, np.zeros(self.n)])
        self.free = np.linalg.solve(M, forces)
        self.spread = np.linalg.solve(M, self.J.T)
        self.W, self.known = W, {}

    def laws(self, mode):
        """Return the matrix of the motion and that of the contact forces."""
        if mode not in self.known:
            n, c = self.n, len(self.J)
            forces = np.zeros((c, 2 * n + 3))
            for i, way in enumerate(mode):
                forces[i, 2 * n] = -way * self.loads[i] * self.kinetic
            stuck = [i for i, way in enumerate(mode) if way == 0]
            if stuck:
                J = self.J[stuck]
                felt = J @ (self.free + self.spread @ forces)
                forces[stuck] = -np.linalg.solve(J @ self.spread[:, stuck], felt)
            A = np.zeros((2 * n + 3, 2 * n + 3))
            A[:n, n : 2 * n] = np.eye(n)
            A[n : 2 * n] = self.free + self.spread @ forces
            A[2 * n + 1, 2 * n + 2], A[2 * n + 2, 2 * n + 1] = -self.W, self.W
            self.known[mode] = A, forces, sla.expm(A * STEP)
        return self.known[mode]

    def guards(self, y, mode):
        """Return one number of every contact that is positive while the mode is right."""
        slip, forces = self.J @ y[self.n : 2 * self.n] - self.speeds, self.laws(mode)[1] @ y
        bounds = self.loads * self.static
        return np.where(np.array(mode) == 0, bounds - abs(forces), np.array(mode) * slip)

    def select(self, y, zero, mode, torn=()):
        """Return the consistent mode with the most contacts at rest; `zero` may rest, those `torn` off must slip."""
        best = None
        for ways in itertools.product(*((1, -1) if i in torn else (0, 1, -1) for i in zero)):
            trial = list(mode)
            for i, way in zip(zero, ways, strict=True):
                trial[i] = way
            A, forces, _ = self.laws(tuple(trial))
            rate, force = self.J @ (A @ y)[self.n : 2 * self.n], forces @ y
            later = self.J @ (A @ A @ y)[self.n : 2 * self.n]
            right = all(
                abs(force[i]) <= self.loads[i] * self.static * (1 + 1e-9)
                and not (
                    abs(force[i]) > self.loads[i] * self.static * (1 - 1e-9) and force[i] * (forces @ A @ y)[i] > 0
                )
                if trial[i] == 0
                else trial[i] * (rate[i] if abs(rate[i]) > 1e-9 else later[i]) > 0
                for i in zero
            )
            if right and (best is None or trial.count(0) > best.count(0)):
                best = trial
        return tuple(best)

    def run(self, start, horizon):
        """Return the state at the end and the events as (time, contact, before, after)."""
        y = np.concatenate([start, np.zeros(2 * self.n - len(start)), [1.0, 1.0, 0.0]])
        slip = self.J @ y[self.n : 2 * self.n] - self.speeds
        zero = [i for i in range(len(slip)) if abs(slip[i]) < 1e-12]
        mode, t, events = self.select(y, zero, [int(np.sign(s)) for s in slip]), 0.0, []
        while t < horizon - 1e-12:
            A, _, whole = self.laws(mode)
            h = min(STEP, horizon - t)
            new = (whole if h == STEP else sla.expm(A * h)) @ y
            fresh = self.guards(y, mode) < 1e-9  # that begin at zero
            low = np.flatnonzero((self.guards(new, mode) < 0) & ~fresh)
            if not low.size:
                y, t = new, t + h
                continue
            a, b = 0.0, h
            while b - a > CLOSE:
                m = 0.5 * (a + b)
                there = np.any(self.guards(sla.expm(A * m) @ y, mode)[low] < 0)
                a, b = (a, m) if there else (m, b)
            y, t = sla.expm(A * b) @ y, t + b
            hit = [i for i in low if self.guards(y, mode)[i] <= 1e-9]
            zero = sorted({*hit, *(i for i, way in enumerate(mode) if way == 0)})
            after = self.select(y, zero, mode, [i for i in hit if mode[i] == 0])
            events += [(t, i, mode[i], after[i]) for i in range(len(mode)) if mode[i] != after[i]]
            mode = after
        return y[: 2 * self.n], events
