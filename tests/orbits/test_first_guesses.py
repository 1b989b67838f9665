"""First guesses of cycles against motions whose periods are known: oscillators whose frequencies have whole ratios."""

import numpy as np
import pytest
import sympy as sp

import symfric as sf
from symfric.orbits.guess import guess_of
from symfric_evidence.bench.stick_slip_branch import BranchProblem
from tests.orbits.test_sampled_multipliers import drawn

X, U, Y, V = sp.symbols("X U Y V", real=True)
MOST = 16  # turns up to which a cycle is sought


def motion(turns, middle, horizon):
    """Return the run of an oscillator of period 2 pi about `middle`, with states that take `turns` times as long."""
    system = sf.System([X], [U], [[1]], [middle - X], z=[Y, V], z_rate=[V, -Y / turns**2])
    start = {X: middle + 0.4, Y: 0.3, U: 0.1, V: 0.2}
    return sf.simulate(sf.Scene(system, [], {}, start, horizon, {"path": sf.Trajectory()}), 1e-12)


@pytest.mark.one_in(3)
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


@pytest.mark.one_in(2)
@pytest.mark.parametrize("other", ["decays", "drifts", "hardly moves"])
def test_the_coordinate_whose_range_lasts_tells_the_period(other):
    """Beside it one that is at rest in the end, one that never comes back, or one that has stopped at its largest."""
    force, start, horizon = {
        "decays": (-Y - 2 * V, {Y: 5.0, V: 0.0}, 2 * np.pi * 40.3),
        "drifts": (0, {Y: 0.0, V: 3.0}, 2 * np.pi * 40.3),
        "hardly moves": (-Y / 400 - V / 2, {Y: 5.0, V: 0.0}, 2 * np.pi * 60.3),
    }[other]
    for first in (True, False):
        q, u, forces = [X, Y], [U, V], [-X, force]
        if not first:
            q, u, forces = q[::-1], u[::-1], forces[::-1]
        scene = sf.Scene(sf.System(q, u, sp.eye(2), forces), [], {}, {X: 0.4, U: 0.1, **start}, horizon)
        guess = guess_of(sf.simulate(scene, 1e-12), None)
        assert guess.turns == 1
        assert guess.period == pytest.approx(2 * np.pi, rel=1e-6)


@pytest.mark.one_in(12)
@pytest.mark.parametrize("tolerance", [1e-3, 1e-4, 1e-6, 1e-7])
@pytest.mark.parametrize("load", [1.1, 1.2, 1.25])
def test_a_cycle_has_its_least_period_at_every_tolerance(load, tolerance):
    """The motion spirals in, a fifth of a turn in each cycle, and comes nearest to itself after five."""
    scene = BranchProblem(loads=(1.0, load)).scene()
    cycle, close = sf.limit_cycle(scene, tolerance=tolerance), sf.limit_cycle(scene, tolerance=1e-12)
    assert len(close.events) == 4
    assert cycle.period == pytest.approx(close.period, rel=10 * tolerance)


@pytest.mark.parametrize("friction", [0.0, 0.2])
def test_a_motion_that_grows_beyond_bounds_is_no_cycle(friction):
    rail = [sf.Contact("rail", U, 1, sf.laws.coulomb(friction))] if friction else []
    scene = sf.Scene(sf.System([X], [U], [[1]], [-X + U / 10]), rail, {}, {X: 20.0, U: 0.0}, 300.0)
    with pytest.raises(sf.NotFound, match="grows beyond any bound"):
        sf.limit_cycle(scene)


@pytest.mark.one_in(2)
@pytest.mark.parametrize("seed", [5, 66])
def test_the_unstable_cycle_under_a_controller_is_not_taken_for_rest_at_the_largest_numbers(seed):
    """The sampled loop is unstable: near the largest number friction seemed to hold the mass."""
    orbit = sf.limit_cycle(drawn(seed))
    assert not orbit.stable
    assert np.max(np.abs(orbit.start)) < 100
