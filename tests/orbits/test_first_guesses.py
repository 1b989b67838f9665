"""First guesses of cycles against motions whose periods are known: oscillators whose frequencies have whole ratios."""

import numpy as np
import pytest
import sympy as sp

import symfric as sf
from symfric.orbits.guess import guess_of

X, U, Y, V = sp.symbols("X U Y V", real=True)
MOST = 16  # turns up to which a cycle is sought


def motion(turns, middle, horizon):
    """Return the run of an oscillator of period 2 pi about `middle`, with states that take `turns` times as long."""
    system = sf.System([X], [U], [[1]], [middle - X], z=[Y, V], z_rate=[V, -Y / turns**2])
    start = {X: middle + 0.4, Y: 0.3, U: 0.1, V: 0.2}
    return sf.simulate(sf.Scene(system, [], {}, start, horizon, {"path": sf.Trajectory()}), 1e-12)


@pytest.mark.parametrize("middle", [-3.0, 0.0, 0.7])
@pytest.mark.parametrize("turns", [1, 2, 5, MOST])
def test_a_free_motion_returns_after_its_turns_through_the_middle(turns, middle):
    guess = guess_of(motion(turns, middle, 2 * np.pi * 48.3), None)
    assert guess.turns == turns
    assert guess.period == pytest.approx(2 * np.pi * turns, rel=1e-9)
    assert guess.start[0] == pytest.approx(middle, abs=0.1)  # the range is that at the ends of steps
    assert guess.start[1] > 0


@pytest.mark.parametrize("turns", [1, 2, 5, MOST])
def test_a_forced_motion_returns_after_its_turns(turns):
    guess = guess_of(motion(turns, 0.7, 2 * np.pi * 48.5), 2 * np.pi)
    assert guess.turns == guess.multiple == turns


@pytest.mark.parametrize("forcing", [None, 2 * np.pi])
def test_more_turns_are_not_sought(forcing):
    assert guess_of(motion(MOST + 1, 0.7, 2 * np.pi * 60.5), forcing).turns <= MOST
