"""Independent references: SciPy's DOP853 with its own event handling, written out for one mass on a belt."""

import numpy as np
import pytest
from scipy import integrate, optimize

TOLERANCE = {"rtol": 1e-11, "atol": 1e-13, "method": "DOP853"}


class Belt:
    """Cubic law, friction difference eta, damping beta, gamma2 = 1, v_m = 1/2, mu_s = 0.4."""

    def __init__(self, eta, beta, v_b):
        self.beta, self.v_b = beta, v_b
        self.mu_s, self.v_m = 0.4, 0.5
        self.drop = 2 * eta * self.v_m / 3
        self.mu_m = self.mu_s - self.drop
        self.rest = self.mu(v_b)

    def mu(self, v):
        s = v / self.v_m
        return self.mu_s - 1.5 * self.drop * (s - s**3 / 3)

    def slip(self, t, y):
        return y[1], -2 * self.beta * y[1] - y[0] + self.mu(self.v_b - y[1])

    def pure_slip_cycle(self, guess):
        """Return half range, period and largest velocity of the cycle in pure slip."""

        def turn(_t, y):
            return y[1]

        turn.direction = -1
        turn.terminal = True

        def one(x):
            run = integrate.solve_ivp(self.slip, (0, 20), [x, -1e-300], events=turn, dense_output=True, **TOLERANCE)
            times, states = run.t_events[0], run.y_events[0]
            return times[-1], states[-1][0], run

        def gap(x):
            return one(x)[1] - x

        x = optimize.brentq(gap, self.rest + 0.7 * guess, self.rest + 1.6 * guess, xtol=1e-14)
        period, _, run = one(x)
        t = np.linspace(0, period, 20001)
        y = run.sol(t)
        return (x - _peak(t, -y[0], run, 0, -1)) / 2, period, _peak(t, y[1], run, 1, 1)

    def stick_slip_cycle(self):
        """Return half range, period and stick time of the cycle with sticking."""
        start = self.mu_s - 2 * self.beta * self.v_b

        def caught(_t, y):
            return y[1] - self.v_b

        caught.direction, caught.terminal = 1, True

        def turn(_t, y):
            return y[1]

        run = integrate.solve_ivp(self.slip, (0, 20), [start, self.v_b], events=(caught, turn), **TOLERANCE)
        turns = [y[0] for y in run.y_events[1]]
        landing = run.y_events[0][0][0]
        stick = (start - landing) / self.v_b
        return (max(turns) - min(turns)) / 2, run.t_events[0][0] + stick, stick


def _peak(t, y, run, row, side):
    """Return the extreme of a smooth curve, polished from its largest sample; with side -1 the smallest."""
    k = int(np.argmax(y))
    found = optimize.minimize_scalar(
        lambda s: -side * float(run.sol(s)[row]),
        bounds=(t[max(k - 1, 0)], t[min(k + 1, len(t) - 1)]),
        method="bounded",
        options={"xatol": 1e-10},
    )
    return -side * found.fun


@pytest.fixture
def reference():
    """The class of reference belts."""
    return Belt
