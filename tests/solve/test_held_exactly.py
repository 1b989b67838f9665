"""Piecewise constant control of linear bodies against matrix exponentials in 40 digits, by all routes."""

import mpmath as mp
import numpy as np
import pytest
import sympy as sp
from longer import longer

import symfric as sf

x, y, u, v = sp.symbols("x y u v", real=True)
STATES = (x, y, u, v)
PIECES = 8  # between instants, in each of which at most one event is looked for
MOST, SLIDING = 0.5, 0.375  # coefficients of friction, of the first body


class Plan:
    """Random numbers, all exact in binary, of two bodies under a sampled command, of which the first may have friction."""

    def __init__(self, seed, friction):
        rng = np.random.default_rng(seed)
        draw = lambda low, high, *n: np.round(rng.uniform(low, high, n) * 64) / 64  # noqa: E731
        k, c = draw(0.5, 3, 3), draw(0.0, 0.3, 3)
        self.force = np.zeros((2, 4))
        for j, e in enumerate((k, c)):
            self.force[:, 2 * j : 2 * j + 2] = [[-e[0] - e[2], e[2]], [e[2], -e[1] - e[2]]]
        self.push, self.gains, self.memory = draw(0.5, 1.5, 2), draw(-0.8, 0.8, 4), float(draw(-0.5, 0.5))
        self.reference, self.start = float(draw(0.5, 1.0)), np.array([*draw(-1, 1, 2), *draw(-1, 1, 2)])
        self.every, self.delay, self.offset = 0.25, float(rng.integers(0, 24)) / 64, float(rng.integers(0, 16)) / 64
        self.kick, self.kicked, self.friction, self.horizon = float(draw(0.5, 1)), 2.0 + 1 / 64, friction, 6.0

    def scene(self):
        state = sp.Matrix(STATES)
        c = sp.Symbol("c.previous", real=True)
        update = self.reference + self.memory * c + (sp.Matrix(self.gains).T @ state)[0]
        held = sf.Held("c", update=update, every=self.every, offset=self.offset, delay=self.delay)
        force = sp.Matrix(self.force) @ state + held.symbol * sp.Matrix(self.push)
        contacts = [sf.Contact("floor", u, 1, sf.laws.coulomb(MOST, SLIDING))] if self.friction else []
        kick = sf.Reset(at=[self.kicked], set={u: u + self.kick})
        initial = dict(zip(STATES, self.start.tolist(), strict=True))
        system = sf.System([x, y], [u, v], sp.eye(2), list(force))
        return sf.Scene(system, contacts, {}, initial, self.horizon, held=[held], resets=[kick])

    def instants(self):
        """Return times and what happens then: 0 a value acts, 1 one is sampled, 2 the kick."""
        count = int((self.horizon - self.offset) / self.every) + 1
        samples = [self.offset + k * self.every for k in range(count)]
        found = [(t, 1) for t in samples] + [(self.kicked, 2)]
        found += [(t + self.delay, 0) for t in samples] if self.delay else []
        return sorted(e for e in found if e[0] < self.horizon)


class Motion:
    """The motion of a plan, its state ``[x, y, u, v, c, 1]``."""

    def __init__(self, plan):
        self.plan, self.z = plan, mp.matrix([*plan.start.tolist(), 0.0, 1.0])
        self.steps, self.mode, self.waiting, self.newest, self.events = {}, None, [], mp.mpf(0), 0
        self.mode = self.chosen() if plan.friction else 2

    def matrix(self, mode):
        """Return that of the equations; the modes are -1, 1, 0 for rest and 2 without friction."""
        a = mp.zeros(6)
        a[0, 2] = a[1, 3] = 1
        for i in range(2):
            for j in range(4):
                a[2 + i, j] = self.plan.force[i, j]
            a[2 + i, 4] = self.plan.push[i]
        if mode in (-1, 1):
            a[2, 5] = -mode * mp.mpf(SLIDING)
        if mode == 0:
            for j in range(6):
                a[2, j] = a[0, j] = 0
        return a

    def pull(self, z):
        """Return the force on the first body without friction."""
        return (self.matrix(2) * z)[2]

    def chosen(self):
        if self.z[2] != 0:
            return int(mp.sign(self.z[2]))
        pull = self.pull(self.z)
        return 0 if abs(pull) <= MOST else int(mp.sign(pull))

    def after(self, h):
        known = (self.mode, h)
        if known not in self.steps:
            self.steps[known] = mp.expm(self.matrix(self.mode) * h)
        return self.steps[known] * self.z

    def room(self, z):
        """Return what is positive while the mode stays."""
        return MOST - abs(self.pull(z)) if self.mode == 0 else self.mode * z[2]

    def advance(self, h):
        for _ in range(PIECES):
            left = h / PIECES
            while self.mode != 2 and self.room(self.after(left)) < 0:
                low, high, a = mp.mpf(0), left, self.matrix(self.mode)
                if self.room(self.z) <= 0:  # the mode began here
                    low = left / 2**20
                    assert self.room(mp.expm(a * low) * self.z) > 0
                root = lambda t, a=a: self.room(mp.expm(a * t) * self.z)  # noqa: E731
                at = mp.findroot(root, (low, high), solver="anderson", tol=mp.mpf(10) ** -60, maxsteps=100)
                self.z = mp.expm(a * at) * self.z
                if self.mode != 0:
                    self.z[2] = mp.mpf(0)
                leaves, self.mode = self.mode, 2
                self.mode = int(mp.sign(self.pull(self.z))) if leaves == 0 else self.chosen()
                assert self.mode != leaves
                self.events, left = self.events + 1, left - at
            self.z = self.after(left)

    def happen(self, what):
        plan = self.plan
        if what == 0:
            self.z[4] = self.waiting.pop(0)
        elif what == 1:
            gains = sum(mp.mpf(g) * e for g, e in zip(plan.gains, self.z, strict=False))
            self.newest = plan.reference + mp.mpf(plan.memory) * self.newest + gains
            if plan.delay:
                self.waiting.append(self.newest)
            else:
                self.z[4] = self.newest
        else:
            self.z[2] += plan.kick
        if plan.friction:
            before, self.mode = self.mode, self.chosen()
            self.events += before != self.mode

    def run(self):
        now = 0.0
        for t, what in [*self.plan.instants(), (self.plan.horizon, None)]:
            if t > now:
                self.advance(mp.mpf(t) - mp.mpf(now))
            now = t
            if what is not None:
                self.happen(what)
        return [self.z[i] for i in range(5)]


@pytest.mark.one_in(4)
@pytest.mark.parametrize("friction", [False, True])
@pytest.mark.parametrize("seed", longer(range(24), range(2, 24)))
def test_routes_agree_with_matrix_exponentials(seed, friction):
    plan = Plan(seed, friction)
    with mp.workdps(40):
        motion = Motion(plan)
        reference = np.array(motion.run(), dtype=float)
    scene = plan.scene()
    for route in ("exact", "taylor", "integrators"):
        tolerance, allowed = (1e-15, 1e-14) if route != "integrators" else (1e-10, 3e-10)
        run = sf.simulate(scene, tolerance, route=route).checked()
        size = np.max(np.abs(run.x[:4]), axis=1)
        off = np.abs(run.final[:5] - reference) / np.append(size, 1.0)
        assert run.route == route
        assert np.max(off) < allowed, (route, off)
        if friction:
            assert run.stats["events"] == motion.events
