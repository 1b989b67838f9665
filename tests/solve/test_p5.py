"""A sweep over belt speeds through the onset of sticking: no graze missed at any tolerance from 1e-6."""

import numpy as np
import pytest
import sympy as sp
from scipy import integrate

import symfric as sf

SPEEDS = np.linspace(0.02, 0.45, 1000)
X = sp.Symbol("x", real=True)
ONSET = 0.39579028879783


def sweep(tolerance):
    """Run every speed to t = 150, then on to 200: events of both parts, half range over the second."""
    belt = sf.scenes.mass_on_belt(v_b=0.2)
    first = sf.prepare(belt.until(150.0).wanting({"events": sf.Events()}), tolerance)
    second = sf.prepare(belt.until(50.0).wanting({"events": sf.Events(), "half": sf.HalfRange(X)}), tolerance)
    runs = []
    for v_b in SPEEDS:
        begin = first.run({"v_b": v_b}).checked()
        end = second.run({"v_b": v_b}, dict(zip("xu", begin.final, strict=True))).checked()
        runs.append((begin, end))
    return runs


def modes(runs):
    return [[(e.before, e.after) for part in pair for e in part.events] for pair in runs]


@pytest.fixture(scope="module")
def fine():
    return sweep(1e-13)


@pytest.mark.one_in(3)
@pytest.mark.parametrize("tolerance", [1e-6, 1e-8, 1e-10])
def test_no_graze_is_missed(fine, tolerance):
    runs = sweep(tolerance)
    assert modes(runs) == modes(fine)
    half = np.array([[end.outputs["half"] for _, end in pairs] for pairs in (runs, fine)])
    assert np.max(np.abs(half[0] - half[1])) < 20 * tolerance


def test_half_ranges_at_known_speeds(fine):
    for v_b, half in ((0.05, 0.0866300783987), (0.3, 0.3593047079249), (0.4, 0.3793362344878)):
        program = sf.prepare(
            sf.scenes.mass_on_belt(v_b=v_b, horizon=20.0).wanting({"half": sf.HalfRange(X)}), tolerance=1e-13
        )
        slow = sf.simulate(sf.scenes.mass_on_belt(v_b=v_b, horizon=2000.0).wanting({"end": sf.End()}), 1e-13)
        run = program.run(initial=dict(zip("xu", slow.final, strict=True)))
        assert run.outputs["half"] == pytest.approx(half, abs=2e-12)


def test_sticking_ends_at_the_onset(fine):
    sticks = np.array([end.stats["events"] > 0 for _, end in fine])
    last = SPEEDS[np.flatnonzero(sticks)[-1]]
    assert 0 <= ONSET - last < SPEEDS[1] - SPEEDS[0]
    assert np.all(sticks[SPEEDS < last])


@pytest.mark.parametrize("tolerance", [1e-6, 1e-8, 1e-10, 1e-12])
def test_the_speed_at_which_others_lose_events(tolerance):
    run = sf.simulate(sf.scenes.mass_on_belt(v_b=0.39534, horizon=200.0), tolerance).checked()
    assert run.stats["events"] == 46


def stick_slip(v_b, horizon):
    """Final state and number of events by SciPy's DOP853 from event to event, in steps short enough for the graze."""
    mu = lambda w: 0.4 - 0.45 * w + 0.6 * w**3  # noqa: E731
    rate = lambda t, y: (y[1], -0.1 * y[1] - y[0] + mu(v_b - y[1]))  # noqa: E731
    caught = lambda t, y: v_b - y[1]  # noqa: E731
    caught.terminal, caught.direction = True, -1
    t, y, events, release = 0.0, np.array([0.0, 0.0]), 0, 0.4 - 0.1 * v_b
    while True:
        slide = integrate.solve_ivp(
            rate,
            (t, horizon),
            y,
            method="DOP853",
            rtol=1e-12,
            atol=1e-13,
            max_step=0.02,
            first_step=1e-3,
            events=caught,
        )
        t, x = slide.t[-1], slide.y[0, -1]
        if slide.status == 0:
            return events, slide.y[:, -1]
        leave = t + (release - x) / v_b
        if leave >= horizon:
            return events + 1, np.array([x + v_b * (horizon - t), v_b])
        events += 2
        t, y = leave, np.array([release, v_b])


@pytest.mark.one_in(6)
@pytest.mark.parametrize("v_b", [0.06, 0.1, 0.2, 0.37, 0.39, 0.395])
def test_agrees_with_a_hand_written_loop_over_scipy(v_b):
    events, end = stick_slip(v_b, 100.0)
    run = sf.simulate(sf.scenes.mass_on_belt(v_b=v_b).wanting({"end": sf.End()}), 1e-12).checked()
    assert run.final == pytest.approx(end, abs=1e-8)
    assert run.stats["events"] == events
