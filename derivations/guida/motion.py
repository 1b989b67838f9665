"""Motion of Guida's two slides between events by matrix exponentials: for the statements that rest on figures 14-16."""

from functools import cache

import numpy as np
from scipy import linalg, optimize

R, ZETA = 0.5, 2.0
STEP, CHUNK = 0.02, 500
TERMS = 12  # (STEP |A|)^12/12! is below 1e-23 for |A| up to 3, that of two dampers above critical
AWAY = 1e-6  # time after a release before a return to w = 0 is looked for; there w is zero to rounding
SLIP = np.array([0.0, 0.0, 1.0, -1.0])  # w = eta1' - eta2' + 1 for the state (eta1, eta2, eta1', eta2')


class Phase:
    """Linear motion ``y' = A (y - rest)``."""

    def __init__(self, A, rest):
        self.A, self.rest = A, np.asarray(rest, dtype=float)
        powers = [np.eye(4)]
        step = linalg.expm(STEP * A)
        for _ in range(CHUNK):
            powers.append(step @ powers[-1])
        self.powers = np.array(powers)

    def at(self, y, s):
        """Return the state a time s <= STEP after y, by the series of the exponential."""
        term = path = y - self.rest
        for k in range(1, TERMS):
            term = s / k * (self.A @ term)
            path = path + term
        return self.rest + path

    def leave(self, y, left, end):
        """Return time and state at which ``left(state)`` turns positive, or those at the end.

        The state is sampled every 0.02: a touch shorter than that is missed, and none of the statements hangs on one.
        """
        elapsed = 0.0
        while elapsed < end:
            path = self.rest + self.powers @ (y - self.rest)
            late = np.flatnonzero(left(path[1:].T) > 0)
            if late.size:
                before = path[late[0]]
                s = optimize.brentq(lambda s, y=before: left(self.at(y, s)), 0.0, STEP, xtol=1e-15)
                return elapsed + late[0] * STEP + s, self.at(before, s)
            elapsed, y = elapsed + CHUNK * STEP, path[-1]
        return elapsed, y


@cache
def sticks(s1, d2, fs1, *, fc1=1.0, start=(0.0, 0.0, -1.0, 0.0), horizon=600.0):
    """Return the sticks of a run as tuples (start, end); it begins at `start` and lasts for the horizon.

    Parameters
    ----------
    s1, d2 : float
        Damping ratios over omega1; the mass and frequency ratios are those of the figures.
    fs1, fc1 : float
    start : tuple of 4 floats
        eta1, eta2, eta1', eta2'; the default is the source's kind of start, sticking with eta1' = -1.
    """
    dampers = np.array([[1.0, 0.0, 2 * s1, 0.0], [0.0, 1 / ZETA**2, 0.0, 2 * d2]])
    slip = np.vstack([np.eye(2, 4, 2), -dampers])
    # sticking, both slides have the acceleration of r (24)_1 + (24)_2, in which the friction cancels
    common = -(R * dampers[0] + dampers[1]) / (1 + R)
    stick = Phase(np.vstack([np.eye(2, 4, 2), common, common]), np.zeros(4))
    sliding = {sign: Phase(slip, [-sign * fc1, sign * R * ZETA**2 * fc1, 0.0, 0.0]) for sign in (1, -1)}
    friction = (dampers[1] - dampers[0]) / (1 + R)  # from w' = 0
    t, y, found = 0.0, np.array(start), []
    mode = 0 if abs(SLIP @ y + 1) < 1e-12 else int(np.sign(SLIP @ y + 1))
    while t < horizon:
        if mode == 0:
            s, y = stick.leave(y, lambda x: np.abs(friction @ x) - fs1, horizon - t)
            found.append((t, t + s))
            mode = int(np.sign(friction @ y))
        else:
            y = sliding[mode].at(y, AWAY)
            s, y = sliding[mode].leave(y, lambda x, m=mode: -m * (SLIP @ x + 1), horizon - t)
            s += AWAY
            mode = 0 if abs(friction @ y) <= fs1 else int(np.sign(friction @ y))
        t += s
    return tuple(found)


def vibrates(s1, d2, fs1, **given):
    """Return 1 if a stick begins in the last quarter of a long run, otherwise 0.

    A stick lasts up to about 3 fs1, and so does the one at the start; the run is long against that.
    """
    horizon = 600.0 + 20.0 * fs1
    return int(any(begin > 0.75 * horizon for begin, _ in sticks(s1, d2, fs1, horizon=horizon, **given)))
