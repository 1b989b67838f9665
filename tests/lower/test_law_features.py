"""Features of laws: none is missed however narrow, and the bounds that find them hold."""

import numpy as np
import pytest
import sympy as sp

import symfric as sf
from symfric.lower.law_features import features, narrow
from symfric.lower.speed_intervals import Unbounded, enclosure
from symfric.model.symbols import SPEED

X = SPEED


@pytest.mark.parametrize(
    "expr",
    [
        X**3 - X / 2,
        sp.exp(-((X - 0.3) ** 2) / 0.01) * sp.sin(7 * X),
        sp.cos(9 * X) / (1 + X**4),
        sp.sqrt(X + 0.1) * sp.tanh((X - 0.4) / 0.05),
        sp.log(1 + X) ** 2 - sp.atan(X / 0.1),
        sp.Abs(X - 0.5) ** 3 + sp.Max(X, 0.2) - sp.Min(X**2, 0.3),
        1 / sp.cosh((X - 0.4) / 0.1) + sp.erf(5 * X),
        (X + 0.2) ** (-sp.Rational(3, 2)),
    ],
)
def test_bounds_contain_the_values_and_tend_to_them(expr):
    value, bound = sp.lambdify(X, expr, ["scipy", "numpy"]), enclosure(expr, X)
    draw = np.random.default_rng(3)
    for width in (0.3, 1e-2, 1e-4):
        a = draw.uniform(0, 1, 200)
        b = a + width * draw.uniform(0, 1, 200)
        low, high = bound(a, b)
        inner = value(a + (b - a) * draw.uniform(0, 1, (20, 200)))
        assert np.all(inner >= low - 1e-12 * (1 + np.abs(low)))
        assert np.all(inner <= high + 1e-12 * (1 + np.abs(high)))
    assert np.max(high - low) < 0.05


def test_an_unknown_function_is_named():
    with pytest.raises(Unbounded, match="besselj"):
        enclosure(sp.besselj(0, X), X)(np.array([0.0]), np.array([1.0]))


@pytest.mark.one_in(6)
@pytest.mark.parametrize("width", [0.1, 1e-2, 1e-4, 1e-6])
@pytest.mark.parametrize("inner", [X - 0.2713, sp.log(X / 0.2713), sp.sin(X - 0.2713), X**2 - 0.2713**2])
def test_the_extrema_of_the_slope_of_a_bump(inner, width):
    """exp(-(f/w)^2) has its steepest slopes at f = +-w/sqrt(2), nearly, where f' is nearly constant."""
    law = sf.laws.custom(0.4 - 0.05 * X + 0.02 * sp.exp(-((inner / width) ** 2)), 0.4)
    found = features(law, 0.0, 1.0, orders=(2,))
    bend = sp.lambdify(X, sp.diff(law.kinetic, X, 2), "numpy")
    grid = 0.2713 + width * np.linspace(-8, 8, 40001) / max(1.0, abs(float(sp.diff(inner, X).subs(X, 0.2713))))
    grid = grid[(grid > 0) & (grid < 1)]
    signs = np.sign(bend(grid))
    changes = grid[1:][signs[1:] * signs[:-1] < 0]
    near = found[(found >= grid[0]) & (found <= grid[-1])]
    assert near.size >= 2
    assert near.size == changes.size
    assert near == pytest.approx(changes, abs=2e-3 * width)


def test_laws_of_the_handbook_are_resolved_by_equal_steps():
    for law in (sf.laws.coulomb(0.4, 0.3), sf.laws.cubic(0.4, 0.25, 0.5), sf.laws.exponential(0.4, 0.05)):
        assert narrow(law, 0.0, 1.0, 0.05).size == 0
    assert features(sf.laws.piecewise_linear(0.4, [0, 0.2, 0.3], [0.4, 0.3, 0.35]), 0.0, 1.0) == pytest.approx([0.2])


def test_many_features_are_all_found():
    law = sf.laws.custom(0.4 + 1e-3 * sp.sin(200 * X), 0.4)
    assert features(law, 0.0, 1.0, orders=(2,)) == pytest.approx(np.pi * np.arange(1, 64) / 200, rel=1e-9)


def test_a_kink_inside_a_function_is_a_feature():
    law = sf.laws.custom(0.4 - 0.05 * X + 0.02 * sp.exp(-sp.Abs(X - 0.3) / 1e-3), 0.4)
    assert np.min(np.abs(features(law, 0.0, 1.0) - 0.3)) < 1e-8
