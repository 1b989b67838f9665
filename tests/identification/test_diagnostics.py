"""Tests of residuals against their definitions, and on noise of known correlation."""

import itertools

import numpy as np
import pytest
import scipy.stats

from symfric.identification.diagnostics import Diagnostics, _runs, diagnose


def noise(n, seed, correlation=0.0):
    """Return autoregressive noise of unit variance."""
    found = np.random.default_rng(seed).standard_normal(n)
    for k in range(1, n):
        found[k] = correlation * found[k - 1] + np.sqrt(1 - correlation**2) * found[k]
    return found


@pytest.mark.parametrize("n", [20, 37, 60, 500])
def test_statistics_by_their_definitions(n):
    e = noise(n, n, 0.3) + 0.7
    found = diagnose(e)
    c = [np.sum((e[k:] - e.mean()) * (e[: n - k] - e.mean())) / n for k in range(11)]
    lags = min(10, n // 5)
    q = n * (n + 2) * sum((c[k] / c[0]) ** 2 / (n - k) for k in range(1, lags + 1))
    assert found.rms == pytest.approx(np.sqrt(np.mean(e**2)), rel=1e-14)
    assert found.autocorrelation == pytest.approx(c[1] / c[0], rel=1e-12)
    assert found.white == pytest.approx(scipy.stats.chi2.sf(q, lags), rel=1e-10)


def test_runs_by_counting_all_orders():
    """Mean and variance of the number of runs over all orders of 4 positive and 5 negative signs."""
    orders = [np.where(np.isin(range(9), k), 1.0, -1.0) for k in itertools.combinations(range(9), 4)]
    runs = np.array([1 + np.count_nonzero(np.diff(o)) for o in orders])
    for order, count in zip(orders[::17], runs[::17], strict=True):
        expected = 2 * scipy.stats.norm.sf(abs(count - runs.mean()) / runs.std())
        assert _runs(order) == pytest.approx(expected, rel=1e-12)
    assert _runs(np.ones(30)) == _runs(-np.ones(30)) == 0.0
    assert _runs(np.array([1.0, -1.0])) == 1.0  # two runs of two samples in any order
    assert _runs(np.array([1.0, 0.0, 1.0, 0.0])) == _runs(np.array([1.0, -1.0, 1.0, -1.0]))


def test_white_noise_passes_and_other_noise_does_not():
    assert sum(not diagnose(noise(200, seed)).is_white for seed in range(300)) <= 4
    for correlation in (0.6, -0.6):
        assert not any(diagnose(noise(200, seed, correlation)).is_white for seed in range(30))
    white = [diagnose(noise(100, seed)).white for seed in range(400)]
    assert scipy.stats.kstest(white, "uniform").pvalue > 0.001


def test_each_of_the_two_tests_counts():
    assert Diagnostics(1.0, 0.0, 0.5, 0.5).is_white
    assert Diagnostics(1.0, 0.0, 0.0011, 0.0011).is_white
    assert not Diagnostics(1.0, 0.0, 0.0009, 0.5).is_white
    assert not Diagnostics(1.0, 0.0, 0.5, 0.0009).is_white
    assert Diagnostics(1.0, np.nan, np.nan, np.nan).is_white


def test_too_few_samples_say_nothing():
    e = noise(30, 0)
    assert np.isnan(diagnose(e[:19]).white)
    assert np.isfinite(diagnose(e[:20]).white)
    assert np.isfinite(diagnose(e, 15).white)
    assert np.isnan(diagnose(e, 16).white)
    assert diagnose(e[:19]).rms == pytest.approx(np.sqrt(np.mean(e[:19] ** 2)))
    flat = diagnose(np.full(30, 2.0))
    assert flat.rms == 2.0
    assert np.isnan(flat.autocorrelation)
    assert flat.is_white
