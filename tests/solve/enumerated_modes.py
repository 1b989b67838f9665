"""References for linear systems with Coulomb friction under constant loads, with nothing of the package's solvers.

`stepped` makes small steps and tries all combinations of sticking and slipping in each, until one agrees with the law.
`failures` looks whether a motion obeys the equations of its modes, and these the law, to the last digits. Velocities
are reduced to those that the sticking rows leave free, by a basis of their null space: rows that nearly agree are held
as exactly as any others. `holding_more` lists what else could stick beside the contacts that do.
"""

import itertools
from dataclasses import dataclass, replace

import numpy as np
from scipy import integrate, linalg, optimize


@dataclass(frozen=True)
class Friction:
    """``m u' = f(q, u, t) + J^T lambda`` with the slips ``J u - belts`` and the bounds of lambda, at rest and in slip.

    Surfaces that move with the place, ``S q`` in the slips, are known to `agrees` and `holding_more`.
    """

    mass: np.ndarray
    stiffness: np.ndarray
    damping: np.ndarray
    constant: np.ndarray
    drive: np.ndarray
    Omega: float
    J: np.ndarray
    belts: np.ndarray
    static: np.ndarray
    kinetic: np.ndarray
    S: np.ndarray | float = 0.0

    def moving(self, u):
        """Return the accelerations of the surfaces."""
        return np.zeros(len(self.belts)) + (self.S @ u if np.ndim(self.S) else 0.0)

    def applied(self, q, u, t):
        """Return the forces without friction."""
        return self.constant + self.drive * np.sin(self.Omega * t) - self.stiffness @ q - self.damping @ u


def agrees(friction, mode, resting, q, u, t, lead=1e-5):
    """Return whether a mode agrees with the law a short time after t, when ties at the bounds are decided.

    The slips in `resting` are zero at t: those that stick need forces within their bounds, the others start in their
    directions.
    """
    acceleration = held(friction, mode, friction.applied(q, u, t), friction.moving(u))[1]
    slipping, surfaces = resting & (mode != 0), friction.moving(u)
    if np.any((mode * (friction.J @ acceleration - surfaces))[slipping] < -1e-6):
        return False
    exact = replace(friction, static=friction.static * (1 - 1e-7) + 2e-9)
    middle = q + lead * u + 0.5 * lead**2 * acceleration, u + lead * acceleration
    holds, later = held(exact, mode, friction.applied(*middle, t + lead), friction.moving(middle[1]))
    gained = 0.5 * lead * (friction.J @ (acceleration + later) - surfaces - friction.moving(middle[1]))
    return holds and not np.any((mode * gained)[slipping] < -1e-3 * lead**2)


def holding_more(friction, mode, resting, q, u, t):
    """Return the modes that agree with the law in which all that stick still do, and others at zero slip too."""
    free = np.flatnonzero(resting & (mode != 0))
    found = []
    for new in itertools.product((0, -1, 1), repeat=free.size):
        trial = mode.copy()
        trial[free] = new
        if 0 in new and agrees(friction, trial, resting, q, u, t):
            found.append(trial)
    return found


def held(friction, mode, force, moving=None):
    """Return whether the sticking contacts can hold each other, and the accelerations then."""
    stick, root = mode == 0, np.sqrt(friction.mass)
    force = force - friction.J[~stick].T @ (mode * friction.kinetic)[~stick]
    if not np.any(stick):
        return True, force / friction.mass
    left, size, right = linalg.svd(friction.J[stick] / root)
    rank = int(np.sum(size > 1e-14 * size[0]))
    rates = left.T @ (np.zeros(np.sum(stick)) if moving is None else moving[stick])
    part, driven = right[:rank] @ (force / root), rates[:rank] / size[:rank]
    acceleration = (right[rank:].T @ (right[rank:] @ (force / root)) + right[:rank].T @ driven) / root
    if np.any(np.abs(rates[rank:]) > 1e-9):
        return False, acceleration  # surfaces that part
    carried = left[:, :rank] @ ((driven - part) / size[:rank])
    bounds = friction.static[stick]
    if np.all(np.abs(carried) <= bounds * (1 + 1e-7)) or rank == len(bounds):
        return bool(np.all(np.abs(carried) <= bounds * (1 + 1e-7))), acceleration
    spare = left[:, rank:]  # forces that hold each other
    rows = np.vstack([spare, -spare])
    limits = np.concatenate([bounds - carried, bounds + carried]) + 1e-7 * np.tile(bounds, 2)
    found = optimize.linprog(np.zeros(spare.shape[1]), A_ub=rows, b_ub=limits, bounds=(None, None))
    return found.status == 0, acceleration


def stepped(friction, q, u, horizon, steps):
    """Return the state at the end, from implicit steps in each of which the combinations of modes are tried.

    The slips at the end of a step agree with the law: zero with an impulse within the static bound, or in the direction
    against which kinetic friction acted.
    """
    n_c, h = len(friction.belts), horizon / steps
    q, u, mode = q.copy(), u.copy(), np.sign(friction.J @ u - friction.belts).astype(int)
    every = sorted(itertools.product((0, -1, 1), repeat=n_c), key=np.count_nonzero)
    for k in range(steps):
        t = (k + 0.5) * h
        for trial in (mode, *map(np.array, every)):
            force = friction.applied(q + 0.5 * h * u, u, t) - friction.J.T @ (trial * friction.kinetic)
            new = u + h * force / friction.mass
            stick, holds = trial == 0, True
            if np.any(stick):
                root = np.sqrt(friction.mass)
                left, size, right = linalg.svd(friction.J[stick] / root, full_matrices=False)
                rank = int(np.sum(size > 1e-14 * size[0]))
                gap = left[:, :rank].T @ (friction.belts - friction.J @ new)[stick]
                new = new + right[:rank].T @ (gap / size[:rank]) / root
                impulse = left[:, :rank] @ (gap / size[:rank] ** 2)
                holds = np.all(np.abs(impulse) <= h * friction.static[stick] * (1 + 1e-9))
            slip = friction.J @ new - friction.belts
            if holds and np.all((trial * slip)[~stick] >= 0):
                break
        else:
            raise AssertionError("no combination of modes agrees with the law")
        q, u, mode = q + 0.5 * h * (u + new), new, trial
    return np.concatenate([q, u])


def failures(friction, run, tolerance):
    """Return what in a run contradicts the equations of motion or the law of friction."""
    n, found = friction.mass.size, []
    for k in range(run.t.size - 1):
        begin, end = run.t[k], run.t[k + 1]
        if end - begin < 1e-9:
            continue
        start, mode = run(begin), run.mode[:, k]
        middle = run(0.5 * (begin + end))
        force = friction.applied(middle[:n], middle[n:], 0.5 * (begin + end))
        slip = friction.J @ middle[n:] - friction.belts
        if np.any(np.abs(slip[mode == 0]) > tolerance) or np.any((mode * slip)[mode != 0] < -tolerance):
            found.append((begin, "slip", mode, slip))
        if not held(friction, mode, force)[0]:
            found.append((begin, "bound", mode))

        def rate(t, y, mode=mode):
            return np.concatenate([y[n:], held(friction, mode, friction.applied(y[:n], y[n:], t))[1]])

        there = integrate.solve_ivp(rate, (begin, end), start, rtol=1e-11, atol=1e-12, method="DOP853").y[:, -1]
        if np.max(np.abs(there - run(end))) > tolerance:
            found.append((begin, "motion", mode, there - run(end)))
    return found
