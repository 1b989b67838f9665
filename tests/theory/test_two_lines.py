"""Two straight lines through points of friction: exact ones come back, and noise is weighed as many records say."""

import json

import numpy as np
import pytest
from scipy.optimize import least_squares

import symfric as sf
from symfric.theory import two_lines

GEAR = sf.laws.piecewise_linear(0.05, [0.0, 2.0], [0.05, 0.014], last_slope=0.0012)
V = np.linspace(0.2, 10.0, 25)


@pytest.mark.parametrize("corner", [0.9, 2.0, 3.3, 7.7])
@pytest.mark.parametrize("slopes", [(-0.018, 0.0012), (-0.002, -0.001), (0.01, -0.01), (-5.0, 1e-6)])
@pytest.mark.parametrize("speeds", [V, np.array([8.0, 0.1, 0.5, 8.3, 9.0]), np.linspace(0.0, 10.0, 11)], ids=len)
def test_exact_points_give_the_corner_and_both_slopes_back(corner, slopes, speeds):
    y = 0.05 + slopes[0] * speeds + (slopes[1] - slopes[0]) * np.maximum(speeds - corner, 0)
    if min(np.unique(speeds[speeds < corner]).size, np.unique(speeds[speeds > corner]).size) < 2:
        pytest.skip("one point on a side")
    fit = two_lines(speeds, y)
    scale = max(map(abs, slopes))
    assert fit.corner == pytest.approx(corner, rel=1e-10)
    assert (fit.slope_below, fit.slope_above) == pytest.approx(slopes, abs=1e-10 * scale)
    assert fit.at_rest == pytest.approx(0.05, abs=1e-10 * scale * corner)


@pytest.mark.parametrize("corner", [1.4, 3.7])
def test_two_points_are_enough_on_either_side(corner):
    speeds = np.arange(6.0)
    fit = two_lines(speeds, 0.05 - 0.01 * speeds + 0.03 * np.maximum(speeds - corner, 0))
    assert fit.corner == pytest.approx(corner, rel=1e-10)
    assert (fit.slope_below, fit.slope_above) == pytest.approx((-0.01, 0.02), abs=1e-12)


def test_noise_is_told_as_many_records_have_it():
    rng = np.random.default_rng(3)
    fits = [two_lines(V, GEAR(V) + rng.normal(0, 4e-4, V.size)) for _ in range(200)]
    for name, true in (("corner", 2.0), ("slope_below", -0.018), ("slope_above", 0.0012), ("at_rest", 0.05)):
        found = np.array([getattr(f, name) for f in fits])
        errors = np.array([f.standard_errors[name] for f in fits])
        assert np.std(found) == pytest.approx(np.mean(errors), rel=0.15)
        assert abs(np.mean(found) - true) < 5 * np.std(found) / np.sqrt(len(fits))
        share = np.mean(np.abs(found - true) < 2 * errors)
        assert 0.9 < share < 0.98
    assert np.sqrt(np.mean([f.deviation**2 for f in fits])) == pytest.approx(4e-4, rel=0.05)


@pytest.mark.one_in(3)
@pytest.mark.parametrize("seed", range(12))
def test_no_corner_of_a_dense_grid_fits_better(seed):
    rng = np.random.default_rng(seed)
    v = np.sort(rng.uniform(0, 10, rng.integers(6, 30)))
    y, sigma = rng.normal(0, 1, v.size) + np.abs(v - 4), rng.uniform(0.5, 2, v.size)
    fit = two_lines(v, y, sigma)

    def misfit(p):
        return (p[0] + p[1] * v + (p[2] - p[1]) * np.maximum(v - p[3], 0) - y) / sigma

    mine = np.sum(misfit((fit.at_rest, fit.slope_below, fit.slope_above, fit.corner)) ** 2)
    for corner in np.linspace(v[0], v[-1], 2001)[1:-1]:
        rows = np.column_stack([np.ones_like(v), v, np.maximum(v - corner, 0)]) / sigma[:, None]
        rest = np.linalg.lstsq(rows, y / sigma, rcond=None)[1]
        assert not rest.size or mine <= rest[0] * (1 + 1e-9)
    polished = least_squares(misfit, (fit.at_rest, fit.slope_below, fit.slope_above, fit.corner), xtol=1e-14)
    assert mine <= 2 * polished.cost * (1 + 1e-9)


def test_it_makes_a_law_and_tells_what_it_found():
    fit = two_lines(V, GEAR(V), sigma=1e-3)
    assert fit.law(V) == pytest.approx(GEAR(V), rel=1e-9)
    assert fit.law.stick == pytest.approx(0.05)
    assert fit.standard_errors["corner"] == pytest.approx(
        two_lines(V, GEAR(V), sigma=2e-3).standard_errors["corner"] / 2
    )
    json.dumps(fit.to_dict())
    assert "corner = 2 +-" in repr(fit)
    assert len(fit.plot().get_lines()) == 2
    belt = sf.scenes.mass_on_belt(fit.law, v_b=1.0, beta=0.001, gamma2=1.0)
    assert not sf.stability(belt).stable
    assert sf.stability(belt.where({"v_b": 3.0})).stable


@pytest.mark.parametrize(
    ("speed", "friction", "sigma", "error", "message"),
    [
        ([1, 2, 3], [1, 2, 3], None, sf.SceneError, "four or more"),
        ([1, 2, 3, 4], [1, 2, 3], None, sf.SceneError, "four or more"),
        ([1, 2, 3, -4], [1, 2, 3, 4], None, sf.SceneError, "not negative"),
        ([1, 2, 3, 4, 5], [1, 2, 3, 4, 5], None, sf.NotFound, "one straight line"),
        ([1, 1, 2, 2], [1, 2, 3, 4], None, sf.SceneError, "each side"),
        ([1, 2, 3, 4], [1, 0, 1, 2], 0.0, sf.SceneError, "sigma"),
    ],
)
def test_bad_points(speed, friction, sigma, error, message):
    with pytest.raises(error, match=message):
        two_lines(speed, friction, sigma)
