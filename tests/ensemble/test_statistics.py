"""Statistics of sweeps against closed forms, definitions and other programs."""

import warnings

import numpy as np
import pytest
import scipy.stats
import xarray as xr

import symfric as sf


def cases(values, repeats=None):
    array = xr.DataArray(np.asarray(values, dtype=float), dims="case", name="out")
    return array if repeats is None else array.assign_coords(repeat=("case", repeats))


@pytest.mark.parametrize(("hits", "n"), [(0, 12), (1, 12), (5, 12), (11, 12), (12, 12), (30, 100), (1, 1)])
def test_the_interval_is_that_of_wilson(hits, n):
    found = sf.probability(cases(np.r_[np.ones(hits), -np.ones(n - hits)]), above=0.0)
    low, high = scipy.stats.binomtest(hits, n).proportion_ci(0.95, method="wilson")
    assert float(found.low) == pytest.approx(low, abs=1e-12)
    assert float(found.high) == pytest.approx(high, abs=1e-12)
    assert float(found.probability) == hits / n
    assert float(found.standard_error) == pytest.approx(np.sqrt(hits / n * (1 - hits / n) / n))
    assert (int(found.cases), int(found.lost)) == (n, 0)


def test_limits_are_strict_and_failed_cases_do_not_count():
    values = cases([0.0, 1.0, 2.0, 3.0, np.nan, np.inf])
    assert float(sf.probability(values, above=1.0).probability) == 0.5
    assert float(sf.probability(values, below=1.0).probability) == 0.25
    both = sf.probability(values, above=0.0, below=3.0)
    assert float(both.probability) == 0.5
    assert (int(both.cases), int(both.lost)) == (4, 2)
    none = sf.probability(cases([np.nan, np.nan]), above=0.0)
    assert np.isnan(float(none.probability))
    assert (int(none.cases), int(none.lost)) == (0, 2)


def test_errors_of_several_draws_are_those_of_their_means():
    values = np.array([1.0, 1, 0, 0, 1, 1, 1, 0, 0, 0, 0, 1])
    found = sf.probability(cases(values, np.repeat([0, 1, 2], 4)), above=0.5)
    means = np.array([0.5, 0.75, 0.25])
    assert float(found.standard_error) == pytest.approx(np.std(means, ddof=1) / np.sqrt(3))
    alone = sf.probability(cases(values, np.zeros(12, dtype=int)), above=0.5)
    assert float(alone.standard_error) == pytest.approx(np.sqrt(0.25 / 12))


def test_spread_by_its_definitions():
    values = np.array([3.0, 1.0, 4.0, 1.0, 5.0, np.nan])
    there = values[:5]
    found = sf.spread(cases(values), [0.0, 0.25, 1.0])
    assert float(found["mean"]) == pytest.approx(2.8)
    assert float(found["deviation"]) == pytest.approx(np.std(there, ddof=1))
    assert float(found["standard_error"]) == pytest.approx(np.std(there, ddof=1) / np.sqrt(5))
    assert found["quantiles"].values.tolist() == [1.0, 1.0, 5.0]
    assert int(found["lost"]) == 1
    several = sf.spread(cases(there[:4], [0, 0, 1, 1]))
    assert float(several["standard_error"]) == pytest.approx(np.std([2.0, 2.5], ddof=1) / np.sqrt(2))
    assert several["quantile"].values.tolist() == [0.05, 0.5, 0.95]


def test_spread_of_a_whole_sweep_takes_its_outputs():
    table = xr.Dataset(
        {
            "a": cases([1.0, 2.0, 3.0]),
            "b": cases([2.0, 4.0, np.nan]),
            "status": ("case", [0.0, 0.0, 1.0]),
            "count": ("case", [1, 2, 3]),
            "alone": 3.0,
        }
    )
    found = sf.spread(table)
    assert found["output"].values.tolist() == ["a", "b"]
    assert found["mean"].values.tolist() == [2.0, 3.0]
    assert found["lost"].values.tolist() == [0, 1]


def test_cases_without_a_number_have_no_spread():
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        found = sf.spread(cases([np.nan, np.nan]))
    assert found["lost"] == 2
    assert np.isnan(found["mean"])
    assert np.isnan(found["quantiles"]).all()


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (lambda: sf.probability(cases([1.0])), "give a limit"),
        (lambda: sf.probability(cases([1.0]), above=np.nan), "above"),
        (lambda: sf.probability(cases([1.0]), below=np.inf), "below"),
        (lambda: sf.probability([1.0], above=0.0), "list is no output"),
        (lambda: sf.probability(cases([1.0]), above=0.0, over="run"), "no dimension 'run' but case"),
        (lambda: sf.spread(cases([1.0]), [1.1]), "between 0 and 1"),
        (lambda: sf.spread(cases([1.0]), [-0.1]), "between 0 and 1"),
        (lambda: sf.spread(cases([1.0]), []), "between 0 and 1"),
        (lambda: sf.spread(cases([1.0]), [[0.5]]), "between 0 and 1"),
        (lambda: sf.spread(cases([])), "no entry along 'case'"),
        (lambda: sf.probability(cases([]), above=0.0), "no entry along 'case'"),
        (lambda: sf.spread(xr.Dataset({"status": cases([1.0])})), "no output has the dimension 'case'"),
    ],
)
def test_bad_arguments(call, message):
    with pytest.raises(sf.SceneError, match=message):
        call()


def test_the_picture_of_a_probability_is_its_complement_of_the_distribution():
    rng = np.random.default_rng(3)
    drawn = scipy.stats.norm(2.0, 0.5).ppf((rng.permutation(60) + 0.5) / 60)
    values = cases(np.r_[drawn, np.nan])
    ax = sf.plot_probability(values)
    level, p = ax.lines[0].get_data()
    assert p[0] == 1.0
    assert p[-1] == 0.0
    assert np.all(np.diff(p) <= 0)
    assert p == pytest.approx(scipy.stats.norm(2.0, 0.5).sf(level), abs=0.06)
    band = ax.collections[0].get_paths()[0].vertices
    for k in (0, 60, 130, 199):  # the rule for one level
        one = sf.probability(values, above=float(level[k]))
        assert p[k] == one.probability
        at = np.sort(band[np.isclose(band[:, 0], level[k], atol=1e-12), 1])
        assert at[[0, -1]] == pytest.approx([float(one.low), float(one.high)], abs=1e-12)
    assert band[:, 1].min() >= 0
    assert band[:, 1].max() <= 1
    few = values[:20]
    two = xr.concat([few, few + 1], xr.DataArray([0.1, 0.2], dims="v_b", name="v_b"))
    assert [text.get_text() for text in sf.plot_probability(two).get_legend().get_texts()] == ["v_b = 0.1", "v_b = 0.2"]
    with pytest.raises(sf.SceneError, match="no case has a number"):
        sf.plot_probability(cases([np.nan]))
    with pytest.raises(sf.SceneError, match="too many"):
        sf.plot_probability(xr.concat([values] * 9, "v_b"))
