"""Forced and parametrically excited oscillators with cubic stiffness, with a variational Newton method of their own."""

from typing import NamedTuple

import numpy as np
import sympy as sp
from scipy.integrate import solve_ivp
from scipy.optimize import brentq

import symfric as sf

X, U = sp.symbols("x u", real=True)
A = sp.Symbol("A", positive=True)


class Oscillator(NamedTuple):
    """``x'' + c x' + (k + e A cos w t) x + q x^2 + x^3 = b + (1 - e) A cos w t``; e is 0 (forced) or 1 (parametric)."""

    c: float
    k: float
    w: float = 1.0
    q: float = 0.0
    b: float = 0.0
    e: int = 0

    @property
    def period(self):
        return 2 * np.pi / self.w

    @property
    def scene(self):
        swing = A * sp.cos(self.w * sf.TIME)
        force = -self.c * U - (self.k + self.e * swing) * X - self.q * X**2 - X**3 + self.b + (1 - self.e) * swing
        return sf.Scene(sf.System([X], [U], [[1]], [force]), [], {A: 0.5}, {X: 0, U: 0}, 300.0)

    def rates(self, t, y, a):
        swing = a * np.cos(self.w * t)
        x, u, V = y[0], y[1], y[2:].reshape(2, 2)
        slope = -(self.k + self.e * swing) - 2 * self.q * x - 3 * x**2
        force = -self.c * u - (self.k + self.e * swing) * x - self.q * x**2 - x**3 + self.b + (1 - self.e) * swing
        return np.concatenate([[u, force], (np.array([[0, 1], [slope, -self.c]]) @ V).ravel()])

    def mapped(self, y, a, times=1, tolerance=1e-11):
        """Return the state after some periods of the excitation and its derivatives by the start."""
        start = np.concatenate([y, np.eye(2).ravel()])
        end = solve_ivp(
            self.rates, (0, times * self.period), start, "DOP853", args=(a,), rtol=tolerance, atol=0.1 * tolerance
        ).y[:, -1]
        return end[:2], end[2:].reshape(2, 2)

    def periodic(self, y, a, times=1):
        """Return the periodic state near a guess and the monodromy matrix; None if Newton's method fails."""
        y = np.array(y, dtype=float)
        for _ in range(12):
            end, M = self.mapped(y, a, times)
            step = np.linalg.solve(np.eye(2) - M, end - y)
            y = y + step
            if np.max(np.abs(step)) < 1e-9:
                return y, self.mapped(y, a, times)[1]
            if not np.max(np.abs(step)) < 10:
                return None
        return None

    def symmetric(self, y, a):
        """Return a cycle with ``y(t + T/2) = -y(t)`` near a guess, and the derivatives N of -y(T/2) by the start."""
        y = np.array(y, dtype=float)
        for _ in range(15):
            end, V = self.mapped(y, a, 0.5)
            step = np.linalg.solve(np.eye(2) + V, -end - y)
            y = y + step
            if np.max(np.abs(step)) < 1e-10:
                break
        return y, -self.mapped(y, a, 0.5)[1]

    def pitchforks(self, y, values):
        """Return where symmetric cycles from a guess lose their symmetry: N has the eigenvalue -1, N^2 that of 1."""
        found, before = [], None
        for a in values:
            y, N = self.symmetric(y, a)
            now = a, y, np.linalg.det(np.eye(2) + N)
            if before is not None and before[2] * now[2] < 0:
                test = lambda v, y=y: np.linalg.det(np.eye(2) + self.symmetric(y, v)[1])  # noqa: E731
                found.append(brentq(test, before[0], a, xtol=1e-11))
            before = now
        return found
