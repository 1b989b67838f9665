"""A contact that sticks touches zero slip a second time: branches of two masses on a belt against runs of SciPy."""

import numpy as np
import pytest
import sympy as sp
from scipy.integrate import solve_ivp

import symfric as sf

V = sp.Symbol("v_b", positive=True)


class TwoMasses:
    """``m_i x_i'' = -k_i x_i - k (x_i - x_j) - c_i x_i' + friction`` on a belt, Stribeck friction without a peak."""

    def __init__(self, seed):
        r = np.random.default_rng(seed)
        k1, k2, k = r.uniform(0.5, 2, 3)
        self.c, self.N = r.uniform(0.01, 0.1, 2), r.uniform(0.5, 1.5, 2)
        self.law = tuple(float(r.uniform(*ends)) for ends in ((0.4, 0.7), (0.1, 0.3), (0.1, 0.4)))
        self.m = np.array([1.0, float(r.uniform(0.5, 2))])
        self.K = np.array([[k1 + k, -k], [-k, k2 + k]])

    @property
    def scene(self):
        q, u = sp.symbols("x1 x2", real=True), sp.symbols("u1 u2", real=True)
        force = [-sum(self.K[i, j] * q[j] for j in (0, 1)) - self.c[i] * u[i] for i in (0, 1)]
        law = sf.laws.stribeck(*self.law)
        contacts = [sf.Contact("ab"[i], slip=u[i] - V, normal=float(self.N[i]), law=law) for i in (0, 1)]
        start = {q[0]: 0.1, q[1]: 0, u[0]: 0, u[1]: 0}
        return sf.Scene(sf.System(list(q), list(u), np.diag(self.m), force), contacts, {V: 0.3}, start, 200.0)

    def kinetic(self, speed):
        mu_s, mu_k, v_s = self.law
        return mu_k + (mu_s - mu_k) * np.exp(-speed / v_s)

    def returned(self, start, period, v):
        """Return the state after a period, and how often each mass begins to stick; both slip behind the belt first."""
        y, t, mode, count = np.array(start), 0.0, np.array([-1.0, -1.0]), [0, 0]
        force = lambda y: -self.K @ y[:2] - self.c * y[2:]  # noqa: E731

        def rates(t, y):
            slips = -mode * self.N * self.kinetic(np.maximum(mode * (y[2:] - v), 0.0))
            push = np.where(mode == 0, -force(y), slips)
            return np.concatenate([np.where(mode == 0, v, y[2:]), (force(y) + push) / self.m])

        def left(t, y, i):
            return self.N[i] * self.law[0] - abs(force(y)[i]) if mode[i] == 0 else mode[i] * (y[2 + i] - v)

        events = [lambda t, y, i=i: left(t, y, i) for i in (0, 1)]
        for event in events:
            event.terminal, event.direction = True, -1
        for _ in range(50):
            found = solve_ivp(rates, (t, period), y, "DOP853", events=events, rtol=1e-11, atol=1e-13, max_step=0.01)
            y, t = found.y[:, -1].copy(), found.t[-1]
            if found.status == 0:
                return y, count
            i = next(k for k in (0, 1) if found.t_events[k].size)
            pull, y[2 + i] = force(y)[i], v
            holds = mode[i] != 0 and abs(pull) <= self.N[i] * self.law[0]
            mode[i] = 0.0 if holds else np.sign(pull)
            count[i] += holds
        raise AssertionError("too many events")


def check(own, orbit):
    """Compare an orbit with a run of SciPy from its start, where both masses slip."""
    end, count = own.returned(orbit.start, orbit.period, orbit.values["v_b"])
    assert np.max(np.abs(end - orbit.start) / orbit.half_range) < 1e-6
    assert count == [sum(e.contact == c and e.after == 0 for e in orbit.events) for c in "ab"]


def rounded(branch):
    """Return the special points at which the branch turns at a touch."""
    folds = {s.value for s in branch.special if s.kind == "fold"}
    return [s for s in branch.special if s.kind == "grazing" and s.value in folds]


def sides(branch, value, width):
    """Return the orbits of both arms next to a turn at a value, not nearer than a width."""
    turn = int(np.argmin(np.abs(branch.values - value)))
    one = next(o for o in branch.orbits[turn::-1] if abs(o.values["v_b"] - value) > width)
    two = next(o for o in branch.orbits[turn:] if abs(o.values["v_b"] - value) > width)
    return one, two


def stuck(orbit):
    return sum(e.after == 0 for e in orbit.events)


@pytest.fixture(scope="module")
def four():
    return TwoMasses(4), sf.continue_cycle(TwoMasses(4).scene.where({V: 0.422}), V, (0.4215, 0.424))


def test_a_branch_goes_round_a_touch(four):
    own, branch = four
    (touch,) = rounded(branch)
    assert branch.ends == ("span", "span")
    one, two = sides(branch, touch.value, 1e-4)
    assert (one.values["v_b"] - touch.value) * (two.values["v_b"] - touch.value) > 0
    assert abs(stuck(one) - stuck(two)) == 1
    check(own, one)
    check(own, two)


def test_a_branch_goes_round_a_touch_from_the_other_arm(four):
    """Started on the orbits beyond, the walk meets the touch where a short stick vanishes."""
    own, branch = four
    (touch,) = rounded(branch)
    one, two = sides(branch, touch.value, 2e-4)
    for start, other in ((one, two), (two, one)):
        value = start.values["v_b"]
        back = sf.continue_cycle(own.scene.where({V: value}), V, (value - 1e-5, 0.424), start=start)
        (again,) = rounded(back)
        assert again.value == pytest.approx(touch.value, abs=1e-8)
        assert {stuck(o) for o in back.orbits} == {stuck(start), stuck(other)}


def test_the_orbit_at_a_touch_just_touches(four):
    _, branch = four
    (touch,) = rounded(branch)
    run = touch.orbit.run
    t = np.linspace(0, touch.orbit.period, 20001)
    slip = touch.value - run(t)[2 + "ab".index(touch.contact)]
    inner = np.flatnonzero((slip[1:-1] <= slip[:-2]) & (slip[1:-1] < slip[2:]) & (slip[1:-1] > 1e-12)) + 1
    assert 0 <= np.min(slip[inner]) < 1e-4 * np.ptp(slip)
