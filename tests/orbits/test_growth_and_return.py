"""Periods and growth rates of made motions, whose answers are known: no run of a scene is part of it."""

from types import SimpleNamespace

import numpy as np
import pytest

from symfric.orbits import lyapunov, recurrence


def made(functions, end, coefficients=None, h=0.25):
    """Return what `recurrence` reads of a run: states as functions of time, (n_t,) each, and the path of the first."""
    t = np.arange(0.0, end, h)
    states = lambda s: np.array([f(np.asarray(s)) for f in functions])  # noqa: E731
    path = SimpleNamespace(
        t=t, h=np.append(np.diff(t), end - t[-1]), coefficients=coefficients(t) if coefficients else None
    )
    half = len(functions) // 2
    base = SimpleNamespace(system=SimpleNamespace(q=(None,) * half))
    return Made(states, path, end, base)


class Made:
    def __init__(self, states, path, end, base):
        self._states, self.path, self.t_final, self.base = states, path, end, base
        self.final = states(end)

    def __call__(self, t):
        return self._states(t)


def sines(t):
    """Return the Taylor coefficients of sin and cos, (steps, 2, 15)."""
    k = np.arange(15)
    factorials = np.cumprod(np.append(1.0, k[1:]))
    rows = [np.sin(t[:, None] + 0.5 * np.pi * (k + shift)) / factorials for shift in (0, 1)]
    return np.stack(rows, axis=1)


def swing(rate):
    return [lambda t: np.sin(rate * t + 0.3), lambda t: rate * np.cos(rate * t + 0.3)]


@pytest.mark.parametrize("level", [-0.7, 0.0, 0.4, 0.99])
def test_passages_rise_through_a_level(level):
    run = made([np.sin, np.cos], 40.0, sines)
    turns = np.arange(-1, 8)
    expected = np.arcsin(level) + 2 * np.pi * turns
    expected = expected[(expected > 1e-9) & (expected < 40.0)]
    found = recurrence.passages(run, np.array([1.0, 0.0]), level)
    assert np.allclose(found, expected, rtol=0, atol=1e-12)
    last = recurrence.passages(run, np.array([1.0, 0.0]), level, 3)
    assert np.array_equal(last, found[-3:])
    falls = recurrence.passages(run, np.array([-1.0, 0.0]), -level)
    assert np.all(np.abs(np.cos(falls) + np.cos(np.arcsin(level))) < 1e-12)


def test_a_return_is_the_first_close_one_or_the_closest():
    states = np.array([[0.0, 1.0, 3.0, 0.0, 1.0, 3.0, 0.0, 1.0, 3.0]])
    assert recurrence.nearest_return(states, np.array([3.0])) == 3
    assert recurrence.nearest_return(states + np.linspace(0, 0.02, 9), np.array([3.0])) == 3
    assert recurrence.nearest_return(np.array([[5.0, 2.0, 0.5, 2.2, 2.1]]), np.array([1.0])) == 1
    assert recurrence.nearest_return(np.array([[2.0, 9.0, 2.0008, 2.1, 2.0]]), np.array([1.0])) == 2
    assert recurrence.nearest_return(np.array([[2.0, 9.0, 2.0012, 2.1, 2.0]]), np.array([1.0])) == 4
    assert recurrence.nearest_return(np.array([[2.0, 9.0, 2.0012, 2.1, 2.0]]), np.array([1000.0])) == 1


@pytest.mark.parametrize("turns", range(1, 9))
def test_a_forced_period_is_up_to_eight_of_the_excitation(turns):
    run = made(swing(1 / turns), 2 * np.pi * (4 * turns + 0.5))
    found = recurrence.period_of(run, 2 * np.pi, np.zeros(0))
    assert found.period == pytest.approx(2 * np.pi * turns, rel=1e-12)
    assert not found.note
    short = made(swing(1 / turns), 2 * np.pi * (4 * turns - 0.5))
    assert np.isnan(recurrence.period_of(short, 2 * np.pi, np.zeros(0)).period)


def test_nine_turns_are_no_period():
    run = made(swing(1 / 9), 2 * np.pi * 72.5)
    found = recurrence.period_of(run, 2 * np.pi, np.zeros(0))
    assert np.isnan(found.period)
    assert "not yet" in found.note


@pytest.mark.parametrize("part", range(1, 8))
def test_a_period_may_be_a_sixth_of_the_excitation(part):
    run = made(swing(part), 2 * np.pi * 10.5)
    found = recurrence.period_of(run, 2 * np.pi, np.zeros(0))
    assert found.period == pytest.approx(2 * np.pi / (part if part <= 6 else 1), rel=1e-12)


@pytest.mark.parametrize(("rate", "settles"), [(-0.5, True), (-1e-4, False), (1e-3, False), (1e-2, False)])
def test_a_motion_that_fades_or_grows_has_no_period_yet(rate, settles):
    run = made([lambda t, f=f: f(t) * (1 + np.exp(rate * t)) for f in swing(1.0)], 2 * np.pi * 20.5)
    assert np.isfinite(recurrence.period_of(run, 2 * np.pi, np.zeros(0)).period) == settles


@pytest.mark.parametrize("state", [0, 1])
def test_one_state_that_fades_fast_has_settled(state):
    functions = swing(1.0)
    functions[state] = lambda t, f=functions[state]: f(t) * (1 + np.exp(-0.3 * t))
    run = made(functions, 2 * np.pi * 12.5)
    assert recurrence.period_of(run, 2 * np.pi, np.zeros(0)).period == pytest.approx(2 * np.pi)


def test_two_frequencies_have_no_period():
    run = made([lambda t: np.sin(t) + 0.3 * np.sin(np.sqrt(2) * t), lambda t: np.cos(t)], 2 * np.pi * 60.5)
    assert np.isnan(recurrence.period_of(run, 2 * np.pi, np.zeros(0)).period)


@pytest.mark.parametrize("turns", [1, 2, 3, 8])
def test_a_free_period_in_passages(turns):
    """A motion that passes its middle several times in a period."""
    functions = [
        lambda t: np.sin(t) + 0.3 * np.sin(t / turns + 0.2),
        lambda t: np.cos(t) + 0.3 / turns * np.cos(t / turns),
    ]
    times = 2 * np.pi * np.arange(1, 4 * turns + 2)
    run = made(functions, times[-1] + 3.0)
    assert recurrence.period_of(run, 0.0, times).period == pytest.approx(2 * np.pi * turns, rel=1e-12)
    few = recurrence.period_of(run, 0.0, times[:-1])
    assert np.isnan(few.period)
    assert few.note == recurrence.FEW


def test_reasons_for_no_free_period():
    functions = [lambda t: np.sin(t) + 0.3 * np.sin(np.sqrt(2) * t), lambda t: np.cos(t)]
    for count, note in ((33, False), (32, True), (0, True)):
        times = 2 * np.pi * np.arange(1, count + 1)
        found = recurrence.period_of(made(functions, 250.0), 0.0, times)
        assert np.isnan(found.period)
        assert (found.note == recurrence.FEW) == note


@pytest.mark.parametrize(("away", "settled"), [(0.4e-3, True), (1.6e-3, False)])
def test_the_whole_period_is_compared(away, settled):
    """A pulse in one of the last periods, between the times at which the states are compared."""
    end = 2 * np.pi * 10.5
    pulse = lambda t: 2 * away * np.exp(-(((t - end + 9.0) / 0.5) ** 2))  # noqa: E731
    run = made([lambda t: np.sin(t) + pulse(t), np.cos], end)
    assert np.isfinite(recurrence.period_of(run, 2 * np.pi, np.zeros(0)).period) == settled


def test_growth_of_known_maps():
    turn = np.array([[0.6, -0.8], [0.8, 0.6]])
    maps = np.array([turn @ np.diag([2.0, 0.5]) @ turn.T] * 40)
    growth = lyapunov._growth_of(maps)
    assert np.allclose(growth[-5:], [np.log(2.0), np.log(0.5)], atol=1e-9)
    assert np.allclose(np.sum(growth, axis=1), 0.0, atol=1e-12)
    lost = lyapunov._growth_of(np.array([np.diag([1.0, 1e-10]), np.diag([1.0, 1e-12])]))
    assert np.isfinite(lost[0]).all()
    assert lost[1, 1] == -np.inf


def test_sums_and_spread_of_growth():
    rng = np.random.default_rng(5)
    times = np.cumsum(np.full(400, 0.5))
    steps = 0.1 + rng.normal(0.0, 0.2, 400)
    found = lyapunov._summed(np.stack([np.full(400, -0.3), steps], axis=1), times, np.zeros(2), 3)
    assert found.exponent == pytest.approx(np.sum(steps) / 200.0)
    assert found.exponents == pytest.approx([found.exponent, -0.6])
    assert found.history == pytest.approx(np.cumsum(steps) / times)
    means = steps.reshape(20, 20).sum(axis=1) / 10.0
    error = np.sqrt(np.sum((means - means.mean()) ** 2) / 19 / 20)
    level = np.append(0.0, np.cumsum(steps) - found.exponent * times)
    assert found.spread == pytest.approx(max(error, np.ptp(level) / 200.0), rel=1e-12)
    assert found.doubtful == 3


def test_spread_of_batches_and_swings():
    times = np.arange(1.0, 101.0)
    assert lyapunov._spread(0.2 * times, times) == pytest.approx(0.0, abs=1e-12)
    assert lyapunov._spread(np.array([0.2]), np.array([1.0])) == np.inf
    assert lyapunov._spread(0.2 * times + np.sin(2 * np.pi * times / 5), times) == pytest.approx(0.0190, abs=2e-4)
    jump = np.where(times > 95, 10.0, 0.0)  # in one batch of twenty
    assert lyapunov._spread(jump, times) == pytest.approx(0.1, rel=1e-9)  # sqrt((2^2 - 0.2)/19/20)
    uneven = np.cumsum(np.where(np.arange(100) % 2, 0.5, 1.5))
    assert lyapunov._spread(0.7 * uneven, uneven) == pytest.approx(0.0, abs=1e-12)


@pytest.mark.parametrize(("exponent", "spread", "end", "chaotic"), [
    (0.1, 0.033, 70.0, True),
    (0.1, 0.034, 70.0, False),
    (0.1, 0.01, 69.0, False),
    (-0.1, 0.0, 700.0, False),
])  # fmt: skip
def test_chaos_is_growth_beyond_the_spread_and_a_thousand(exponent, spread, end, chaotic):
    found = lyapunov.Lyapunov(exponent, spread, np.array([exponent]), np.array([end]), np.array([0.0]), np.zeros(1), 0)
    assert found.chaotic is chaotic
    assert ("pieces without" in repr(found)) is False


def test_lengths_vary_about_their_mean_and_meet_all_phases():
    for n in (3, 80, 400):
        lengths = lyapunov._varied(2.0, n)
        assert np.sum(lengths) == pytest.approx(2.0 * n)
        assert np.min(lengths) > 0.7
        assert np.max(lengths) < 3.7
        assert len(np.unique(lengths.round(9))) == n
    assert lyapunov._varied(2.0, 0).size == 0
    phases = np.sort(np.cumsum(lyapunov._varied(1.0, 400)) % 1.0)
    assert np.max(np.diff(phases)) < 0.05
    assert 0.49 < np.min(lyapunov._varied(1.0, 400)) < 0.51
    assert 1.49 < np.max(lyapunov._varied(1.0, 400)) < 1.51


class Flow:
    """The map of x' = a x over a time, with extremes; the third piece has no derivatives."""

    def __init__(self, rates):
        self.rates = np.array(rates)
        self.scene = SimpleNamespace(system=SimpleNamespace(q=(None,)))

    def run(self, y, values, time):
        end = y * np.exp(self.rates * time)
        low, high = np.minimum(y, end), np.maximum(y, end)
        return SimpleNamespace(
            end=end, by_start=np.diag(np.exp(self.rates * time)), low=low, high=high, doubtful=time > 2
        )


def test_growth_after_the_transient():
    lengths = np.array([1.0, 3.0, 0.5, 2.5, 1.5])
    growth, end, doubtful = lyapunov._grow(Flow([0.2, -0.4]), {}, np.array([1.0, 2.0]), lengths, 2)
    assert growth == pytest.approx(np.outer(lengths[2:], [0.2, -0.4]))
    assert end == pytest.approx([np.exp(0.2 * 8.5), 2 * np.exp(-0.4 * 8.5)])
    assert doubtful == 1


class Shear:
    """Maps that add a multiple of the first state to the second one; the states move between 1 and 5, and 10 and 18."""

    scene = SimpleNamespace(system=SimpleNamespace(q=(None,)))

    def run(self, y, values, time):
        low, high = np.array([1.0, 10.0]), np.array([5.0, 18.0])
        return SimpleNamespace(end=y, by_start=np.array([[1.0, 0.0], [3.0, 1.0]]), low=low, high=high, doubtful=False)


def test_growth_is_that_of_lengths_in_units_of_the_ranges():
    growth, _, _ = lyapunov._grow(Shear(), {}, np.array([1.0, 10.0]), np.array([20.0]), 0)
    assert growth[0] == pytest.approx(np.log(np.hypot(1.0, 3.0 * 4.0 / 8.0)) * np.array([1.0, -1.0]))
