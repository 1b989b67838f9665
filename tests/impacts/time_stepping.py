"""Moreau's time stepping of bodies with contacts that open: a reference of first order without events.

A step goes from velocities to velocities. Contacts whose gap is closed at the middle of the step, or that pressed in the
last one, take part, with what `impact_laws` says of an impact: first those that approach, with their restitution; then
all of them in what the forces add in the step, without restitution, so that impulses hold contacts that rest. It looks
for no event and chooses no mode, and rests, bounces and bounces that die out are all the same to it.
"""

import numpy as np

from tests.impacts.impact_laws import Touching, chosen, several, single
from tests.impacts.impact_reference import NEAR, Equations

STILL = 1e-12  # rate, relative to the velocities, that is no approach


class TimeStepping:
    """Motions in steps of one length; `values` in the order of the parameters."""

    def __init__(self, equations: Equations, values):
        self.e, self.values, self.n = equations, tuple(map(float, values)), equations.n
        numbers = np.array(equations._coefficients(*self.values), dtype=float).reshape(3, -1)
        self.restitution, self.mu, self.mu_s = numbers
        self.n_c = len(equations.touches)
        self.done = {}

    def run(self, start, horizon, steps, shown):
        """Return the coordinates at `shown` equal times up to the horizon, shape (shown, n); it must divide `steps`."""
        y, h, path = np.array(start, dtype=float), horizon / steps, []
        gaps, _, slips = self.e.watched(0.0, y, self.values)
        self.still, self.pressed = self._still(slips), gaps <= NEAR
        for k in range(steps):
            y = self.step(k * h, y, h)
            if (k + 1) % (steps // shown) == 0:
                path.append(y[: self.n].copy())
        return np.array(path)

    def step(self, t, y, h):
        """Return the state one step later."""
        e, n = self.e, self.n
        middle, q, u = t + h / 2, y[:n] + h / 2 * y[n:], y[n:]
        M, f, Jn, _, Jt, _, load = e.core(middle, np.concatenate([q, u]), self.values)
        gaps, rates, slips = e.watched(middle, np.concatenate([q, u]), self.values)
        free = h * np.linalg.solve(M, f)
        moved = h * (h + np.max(np.abs(free)))  # by forces in a step, so far may a contact part that goes on pressing
        near = [k for k in range(self.n_c) if e.unilateral[k] and gaps[k] <= NEAR + self.pressed[k] * moved]
        rubs = [k for k in range(self.n_c) if not e.unilateral[k]]
        lines = [k for k in near if e.frictional[k]]
        rows = np.array([*(Jt[k] for k in lines), *(Jn[k] for k in near), *(Jt[k] for k in rubs)]).reshape(-1, n)
        back = np.linalg.solve(M, rows.T)
        a, m = len(lines), len(lines) + len(near)
        z = np.concatenate([slips[lines], rates[near]])
        if near and np.any(rates[near] < -STILL * (np.max(np.abs(u)) + np.max(np.abs(rates[near])))):
            c = self._touching(rows[:m] @ back[:, :m], near, lines)
            r = single(c.W, z, c.mu[0], c.mu_s[0], c.e[0]) if len(near) == len(lines) == 1 else several(c, z)
            u = u + back[:, :m] @ r
            slips = slips + Jt @ back[:, :m] @ r
            z = z + c.W @ r
        if near and not rubs:
            r = self._held_by(self._held(rows @ back, near, lines), z + rows @ free, near)
        else:
            r = self._given(z, slips, near, lines, rubs, rows, back, free, h * load)
        u = u + free + back @ r
        self.pressed = np.isin(np.arange(self.n_c), [k for k, load in zip(near, r[a:m], strict=True) if load > 0])
        self.still = self._still(e.watched(middle, np.concatenate([q, u]), self.values)[2])
        return np.concatenate([y[:n] + h / 2 * (y[n:] + u), u])

    def _given(self, z, slips, near, lines, rubs, rows, back, free, load):
        """Return the impulses of contacts that touch and of those with a given load."""
        W, m = rows @ back, len(lines) + len(near)
        c = self._held(W[:m, :m], near, lines)
        z = np.concatenate([z, slips[rubs]]) + rows @ free
        r = np.zeros(len(z))
        for _ in range(200):  # one after the other, until they agree
            old = r.copy()
            if near:
                r[:m] = self._held_by(c, z[:m] + W[:m, m:] @ r[m:], near)
            for i, k in enumerate(rubs, start=m):
                bound = load[k] * self.mu[k]
                rest = z[i] + W[i] @ r - W[i, i] * r[i]
                r[i] = min(max(-rest / W[i, i], -bound), bound)
            if np.max(np.abs(r - old), initial=0.0) <= 1e-14 * np.max(np.abs(r), initial=1e-300):
                break
        return r

    def _held_by(self, c, z, near):
        """Return the impulses of what the forces add in a step; most often contacts do what they did in the last one."""
        key = tuple(near)
        self.done[key], r = chosen(c, z, share=0.0, guess=self.done.get(key))
        return r

    def _touching(self, W, near, lines):
        """Return the contacts that touch, as the laws of impacts take them."""
        return Touching(W, [near.index(k) for k in lines], self.mu[near], self.mu_s[near], self.restitution[near])

    def _still(self, slips):
        """Return which contacts do not slip."""
        return np.abs(slips) <= STILL * (1 + np.max(np.abs(slips)))

    def _held(self, W, near, lines):
        """Return them for forces: static friction holds what is at rest, sliding friction what slips."""
        c = self._touching(W, near, lines)
        bound = np.where(self.still[near], c.mu_s, c.mu)
        return Touching(c.W, c.lines, bound, bound, c.e)
