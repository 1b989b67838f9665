"""When a motion passes a level, in closed form."""

import numpy as np
import pytest
import sympy as sp

import symfric as sf
from symfric.orbits.recurrence import passages

X, U = sp.symbols("x u", real=True)
K = sp.Symbol("k", positive=True)


@pytest.mark.parametrize(("size", "rate"), [(1e-6, 1e3), (1.0, 1.0), (1e6, 1e-3)])
@pytest.mark.parametrize("level", [0.0, 0.4])
def test_passages_of_a_level_near_the_middle_in_any_units(level, size, rate):
    """``x = size cos(rate t)`` rises through ``level size`` once in a turn, and so does the rate."""
    scene = sf.Scene(sf.System([X], [U], [[1]], [-K * X]), [], {K: rate**2}, {X: size, U: 0.0}, 40.0 / rate)
    run = sf.simulate(scene, 1e-15)
    turns = 2 * np.pi * np.arange(7)
    times = 2 * np.pi - np.arccos(level) + turns
    times = times[times < 40.0]
    found = passages(run, np.array([1.0, 0.0]), level * size)
    assert found * rate == pytest.approx(times, abs=2e-13 * 40)
    assert passages(run, np.array([1.0, 0.0]), level * size, 2) == pytest.approx(found[-2:], rel=0)
    faster = passages(run, np.array([0.0, 1.0]), level * size * rate)
    at = np.pi + np.arcsin(level) + turns
    assert faster * rate == pytest.approx(at[at < 40.0], abs=2e-13 * 40)
