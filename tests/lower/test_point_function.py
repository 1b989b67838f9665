"""Compiled functions at many points against CasADi's own evaluation."""

from concurrent.futures import ThreadPoolExecutor

import casadi as ca
import numpy as np
import pytest

from symfric.codegen.point_function import PointFunction

X, Y = ca.SX.sym("x"), ca.SX.sym("y")


def sum_of(terms):
    """Return a function of that many terms."""
    return ca.Function("f", [X, Y], [sum(ca.tanh(k * X) * ca.cos(Y / k) for k in range(1, terms + 1))])


@pytest.mark.parametrize("terms", [1, 40])
@pytest.mark.parametrize("shape", [(), (0,), (7,), (3, 5)])
def test_values_are_those_of_casadi(terms, shape):
    rng, function = np.random.default_rng(3), sum_of(terms)
    x, y = rng.normal(size=shape), rng.normal(size=shape)
    x, y = np.asarray(x), np.asarray(y)
    found = PointFunction(function)(x, y)
    assert found.shape == shape
    assert found.ravel() == pytest.approx([float(function(a, b)) for a, b in zip(x.ravel(), y.ravel(), strict=True)])


def test_points_may_lie_apart_in_memory_and_threads_may_share_it():
    function = PointFunction(sum_of(40))
    grid = np.random.default_rng(4).normal(size=(6, 50))
    alone = [function(row, grid[::2, :][0]) for row in grid]
    with ThreadPoolExecutor(4) as pool:
        found = list(pool.map(lambda row: function(row[:], grid[0, :]), list(grid) * 20))
    assert np.array_equal(np.array(found), np.array(alone * 20))
    assert np.array_equal(function(grid[:, ::2], grid[:, ::2]), function(grid, grid)[:, ::2])
