"""Bodies with contacts in the plane that open, by time stepping: a reference of first order that shares nothing with the package.

A step goes from velocities to velocities (Moreau's midpoint rule). Contacts whose gap is closed at its middle take part
with Newton's rule ``P >= 0``, ``a+ + e a- >= 0`` and with Coulomb's law for the slip at the end of the step, ``Q = -mu P w+/|w+|`` or
``w+ = 0`` with ``|Q| <= mu P``. There are no events and no modes. Several contacts are solved one after the other until they agree.
"""

from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np
from scipy.optimize import brentq

STILL = 1e-12  # speed that is no slip
GRID = np.linspace(0.0, 2 * np.pi, 73) + 0.1


@dataclass(frozen=True)
class Sliding:
    """A contact: slips (0, 1 or 2 rows of n), normal row or a given load, shift(t) and its rate under it, e, mu_s and mu."""

    slips: np.ndarray
    mu: float
    mu_s: float
    normal: np.ndarray | None = None
    load: float = 0.0
    e: float = 0.0
    shift: Callable = field(default=lambda t: (0.0, 0.0))


def directions(W, z, bound, rest):
    """Yield impulses ``[Q; P]`` of slips (1 or 2) against their directions, with the rate `rest` of the gap after it."""

    def impulse(e):
        P = (rest - z[-1]) / (W[-1, -1] - bound * W[-1, :-1] @ e)
        return np.append(-bound * P * e, P)

    if len(z) == 2:
        choices = [np.array([1.0]), np.array([-1.0])]
    else:

        def across(angle):
            e, r = np.array([np.cos(angle), np.sin(angle)]), impulse(np.array([np.cos(angle), np.sin(angle)]))
            w = (z + W @ r)[:2] / r[-1]
            return e[0] * w[1] - e[1] * w[0]

        values = [across(a) for a in GRID]
        found = [
            brentq(across, a, b, xtol=1e-15)
            for a, b, f, g in zip(GRID, GRID[1:], values, values[1:], strict=False)
            if f * g < 0
        ]
        choices = [np.array([np.cos(a), np.sin(a)]) for a in found]
    for e in choices:
        r = impulse(e)
        if r[-1] >= 0 and (z + W @ r)[:-1] @ e >= 0:
            yield r


def answers(W, z, rate, e, mu, mu_s):
    """Yield all impulses ``[Q; P]`` of one contact with slips and rate z; `rate` is that of the gap before the impact."""
    rest = -e * min(rate, 0.0)
    if z[-1] >= rest:
        yield np.zeros(len(z))
        return
    r = -np.linalg.solve(W, z - np.append(np.zeros(len(z) - 1), rest))
    if np.linalg.norm(r[:-1]) <= mu_s * r[-1]:
        yield r
    if len(z) > 1:
        yield from directions(W, z, mu, rest)


class Stepping:
    """Motions of ``M u' = force(t, q, u)`` with contacts, in steps of one length."""

    def __init__(self, M, force, contacts):
        self.force, self.contacts, self.inverse = force, contacts, np.linalg.inv(M)
        self.rows = [np.vstack([c.slips, c.normal]) if c.normal is not None else c.slips for c in contacts]
        self.W = [rows @ self.inverse @ rows.T for rows in self.rows]

    def run(self, start, horizon, steps, shown):
        """Return the coordinates at `shown` equal times up to the horizon, shape (shown, n)."""
        n, h, path = len(start) // 2, horizon / steps, []
        q, u = np.array(start[:n], dtype=float), np.array(start[n:], dtype=float)
        self.kept = [np.zeros(len(W)) for W in self.W]
        for k in range(steps):
            q, u = self.step(k * h + h / 2, q + h / 2 * u, u, h)
            if (k + 1) % (steps // shown) == 0:
                path.append(q.copy())
        return np.array(path)

    def step(self, t, q, u, h):
        """Return the state at the end of a step whose middle is given."""
        near = []
        for k, c in enumerate(self.contacts):
            at, speed = c.shift(t)
            if c.normal is None or c.normal @ q - at <= 0.0:
                near.append((k, c, speed if c.normal is not None else 0.0))
            else:
                self.kept[k][:] = 0.0
        new = (
            u
            + h * self.inverse @ self.force(t, q, u)
            + sum(self.inverse @ self.rows[k].T @ self.kept[k] for k, *_ in near)
        )
        for _ in range(300):
            moved = 0.0
            for k, c, speed in near:
                r, rows, W = self.kept[k], self.rows[k], self.W[k]
                z = rows @ new - W @ r
                slips = np.linalg.norm(c.slips @ u) > STILL
                if c.normal is None:
                    bound = h * c.load * (c.mu if slips else c.mu_s)
                    own = prox(W, z, bound)
                else:
                    z[-1] -= speed
                    rate = c.normal @ u - speed
                    own = next(answers(W, z, rate, c.e, c.mu, c.mu if slips else c.mu_s))
                new = new + self.inverse @ rows.T @ (own - r)
                self.kept[k], moved = own, max(moved, np.max(np.abs(own - r)))
            if moved <= 1e-13:
                break
        return q + h / 2 * new, new


def prox(W, z, bound):
    """Return the friction impulse of a given bound: it holds the slip, or opposes it."""
    r = -np.linalg.solve(W, z)
    if np.linalg.norm(r) <= bound:
        return r
    low, high = 0.0, 1.0
    size = lambda kappa: np.linalg.norm(np.linalg.solve(kappa * np.eye(len(z)) + W, z)) - bound  # noqa: E731
    while size(high) > 0:
        high *= 2
    return -np.linalg.solve(brentq(size, low, high, xtol=1e-16) * np.eye(len(z)) + W, z)
