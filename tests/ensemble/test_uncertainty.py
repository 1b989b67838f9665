"""Sweeps over tables of parameter sets: draws, quantiles, probabilities with their errors, random forcing."""

import numpy as np
import pytest
import scipy.signal
import scipy.stats
import sympy as sp
import xarray as xr

import symfric as sf

X, U = sp.symbols("x u", real=True)
W = sp.Symbol("w", real=True)
ONE = {"mu": scipy.stats.uniform(0.2, 0.1)}


def half_range(v_b=0.2, horizon=60.0):
    scene = sf.scenes.mass_on_belt(v_b=v_b, horizon=horizon)
    return scene.wanting({"half": sf.HalfRange(scene.system.q[0]), "end": sf.End()})


def test_a_table_is_its_single_runs():
    table = sf.CaseTable({"v_b": [0.1, 0.2, 0.3, 0.4], "beta": [0.01, 0.02, 0.03, 0.05]})
    assert table["v_b"].tolist() == table[sp.Symbol("v_b")].tolist() == [0.1, 0.2, 0.3, 0.4]
    with pytest.raises(sf.SceneError, match="mu is no column of the cases; there are v_b, beta"):
        table["mu"]
    found = sf.sweep(half_range(), table)
    assert found["half"].dims == ("case",)
    assert found["end"].dims == ("case", "state")
    program = sf.prepare(half_range())
    for k in range(4):
        run = program.run({n: v[k] for n, v in table.columns.items()})
        assert found["half"].values[k] == run["half"]
    assert found["beta"].values.tolist() == [0.01, 0.02, 0.03, 0.05]
    assert found["beta"].dims == ("case",)


def test_a_table_times_a_grid_and_motions(tmp_path):
    shaken = sf.Scene(
        sf.System([X], [U], [[1]], [-X + W]),
        [sf.Contact("floor", U, 1, sf.laws.coulomb(sp.Symbol("mu", positive=True)))],
        {"mu": 0.1},
        {X: 0.0, U: 0.0},
        8.0,
        {"top": sf.Max(X)},
        {W: sf.Signal([0.0, 0.0], 10.0)},
    )
    forces = sf.motions.random_forcing(8.0, (0.1, 0.5), 1.0, number=3, seed=1)
    table = sf.CaseTable({"mu": [0.05, 0.1]})
    grid = {"case": table, "w": {f"force {k}": s for k, s in enumerate(forces)}}
    found = sf.sweep(shaken, grid, store=tmp_path / "store")
    assert found["top"].sizes == {"case": 2, "w": 3}
    single = sf.simulate(sf.Scene(**{**vars(shaken), "inputs": {W: forces[2]}}).where({"mu": 0.1}))
    assert found["top"].values[1, 2] == pytest.approx(single["top"], abs=1e-9)
    assert np.all(found["top"].values[0] > found["top"].values[1])
    assert sf.sweep(shaken, grid, store=tmp_path / "store").identical(found)
    with pytest.raises(sf.SceneError, match="another sweep"):
        sf.sweep(shaken, {**grid, "case": sf.CaseTable({"mu": [0.05, 0.11]})}, store=tmp_path / "store")


def test_draws_follow_their_distributions():
    laws = {"a": scipy.stats.norm(0.4, 0.02), "b": scipy.stats.uniform(1.0, 2.0), "c": scipy.stats.lognorm(0.3)}
    for method in ("sobol", "latin", "random"):
        table = sf.draw(laws, 1024, seed=4, method=method)
        again = sf.draw(laws, 1024, seed=4, method=method)
        for name, law in laws.items():
            assert np.array_equal(table.columns[name], again.columns[name])
            assert scipy.stats.kstest(table.columns[name], law.cdf).pvalue > 1e-3
        other = sf.draw(laws, 1024, seed=5, method=method)
        assert not np.array_equal(other.columns["a"], table.columns["a"])


def test_correlated_draws():
    laws = {"a": scipy.stats.norm(1.0, 0.1), "b": scipy.stats.norm(0.0, 2.0)}
    table = sf.draw(laws, 4096, correlation=[[1.0, -0.8], [-0.8, 1.0]])
    assert np.corrcoef(table.columns["a"], table.columns["b"])[0, 1] == pytest.approx(-0.8, abs=0.01)
    assert np.std(table.columns["b"]) == pytest.approx(2.0, rel=0.02)


def test_the_probability_of_vibration_against_its_closed_form():
    """A belt vibrates below the speed at which steady sliding is stable: a uniform speed vibrates with a known share."""
    onset = sf.theory.belt.onset_speed(sf.scenes.mass_on_belt(v_b=0.2))
    scene = sf.scenes.mass_on_belt(v_b=0.2, horizon=400.0)
    still = sf.equilibrium(scene.where({"v_b": 0.3})).x[0]
    q, u = scene.system.q[0], scene.system.u[0]
    near = scene.starting({q: still + 1e-3, u: 0.0}).wanting({"half": sf.HalfRange(u)})
    width = 0.2
    speeds = {"v_b": scipy.stats.uniform(onset - 0.7 * width, width)}
    found = sf.sweep(near, sf.draw(speeds, 256, seed=2, repeats=4))
    share = sf.probability(found["half"], above=0.05)
    assert float(share.cases) == 1024
    assert abs(float(share.probability) - 0.7) < 0.03
    assert float(share.standard_error) < np.sqrt(0.21 / 1024)  # Sobol points in one dimension do better
    assert float(share.low) < float(share.probability) < float(share.high)


def test_the_error_of_a_probability_is_that_of_many_sweeps():
    rng, found = np.random.default_rng(0), []
    for _ in range(150):
        found.append(sf.probability(xr.DataArray(rng.random(200), dims="case"), below=0.3))
    values = np.array([float(f.probability) for f in found])
    assert np.std(values) == pytest.approx(np.mean([float(f.standard_error) for f in found]), rel=0.15)
    held = np.mean([float(f.low) < 0.3 < float(f.high) for f in found])
    assert held == pytest.approx(0.95, abs=0.04)
    none = sf.probability(xr.DataArray([0.1, np.nan], dims="case"), above=1.0)
    assert (float(none.probability), int(none.cases), int(none.lost)) == (0.0, 1, 1)
    assert float(none.high) > 0.5


def test_spread_of_outputs():
    found = sf.sweep(half_range(), sf.draw({"v_b": scipy.stats.uniform(0.1, 0.2)}, 64))
    told = sf.spread(found, [0.1, 0.9])
    assert told["quantiles"].sel(output="half").values.ravel()[0] > 0
    one = sf.spread(found["half"], [0.1, 0.9])
    assert one["quantiles"].values == pytest.approx(np.quantile(found["half"].values, [0.1, 0.9]))
    assert float(one["mean"]) == pytest.approx(np.mean(found["half"].values))
    assert float(one["standard_error"]) == pytest.approx(np.std(found["half"].values, ddof=1) / 8)


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (lambda: sf.CaseTable({}), "at least one"),
        (lambda: sf.CaseTable({"a": [1.0, 2.0], "b": [1.0]}), "different lengths"),
        (lambda: sf.CaseTable({"a": [1.0, np.nan]}), "not finite"),
        (lambda: sf.CaseTable({"a": "soon"}), "not numbers"),
        (lambda: sf.CaseTable({"a": [1.0]}, repeat=[0.5]), "whole number"),
        (lambda: sf.draw({}, 8), "at least one"),
        (lambda: sf.draw({"a": scipy.stats.gamma}, 8), "frozen"),
        (lambda: sf.draw({"a": 0.3}, 8), "frozen"),
        (lambda: sf.draw(ONE, 0), "number is 0"),
        (lambda: sf.draw(ONE, 10**7, repeats=10), "draw fewer"),
        (lambda: sf.draw(ONE, 8, method="grid"), "method"),
        (lambda: sf.draw(ONE, 8, correlation=[[2.0]]), "ones on its diagonal"),
        (lambda: sf.sweep(half_range(), {"case": sf.CaseTable({"v_b": [0.1]}), "v_b": [0.1]}), "two axes"),
        (lambda: sf.sweep(half_range(), sf.CaseTable({"q": [0.1]})), "no parameter"),
        (lambda: sf.probability([1.0], above=0), "no output"),
        (lambda: sf.probability(sf.sweep(half_range(), {"v_b": [0.2]})["half"], above=0), "no dimension"),
        (lambda: sf.probability(sf.sweep(half_range(), sf.CaseTable({"v_b": [0.2]}))["half"]), "give a limit"),
        (lambda: sf.spread(sf.sweep(half_range(), {"v_b": [0.2]})), "no output has"),
        (lambda: sf.spread(sf.sweep(half_range(), sf.CaseTable({"v_b": [0.2]})), [2.0]), "between 0 and 1"),
    ],
)
def test_bad_input_is_one_line(call, message):
    with pytest.raises(sf.SceneError, match=message) as told:
        call()
    assert "\n" not in str(told.value)


def test_random_forcing_has_the_spectrum_it_says():
    signals = sf.motions.random_forcing(200.0, (0.5, 2.0), 3.0, number=40, seed=7)
    dt = signals[0].dt
    samples = np.array([s.samples for s in signals])
    assert np.sqrt(np.mean(samples**2)) == pytest.approx(3.0, rel=0.03)
    frequency, density = scipy.signal.periodogram(samples, 1 / dt, axis=1)
    mean = np.mean(density, axis=0)
    inside = (frequency > 0.55) & (frequency < 1.95)
    assert np.mean(mean[inside]) == pytest.approx(9.0 / 1.5, rel=0.05)
    assert np.max(mean[(frequency > 2.2) | (frequency < 0.4)]) < 0.05 * 9.0 / 1.5
    assert scipy.stats.kurtosis(samples.ravel()) == pytest.approx(0.0, abs=0.2)
    fewer = sf.motions.random_forcing(200.0, (0.5, 2.0), 3.0, number=2, seed=7)
    assert np.array_equal(fewer[1].samples, signals[1].samples)
    assert not np.array_equal(signals[0].samples, signals[1].samples)


@pytest.mark.parametrize("count", [0, 1, 7, 20])
def test_the_interval_of_a_probability_is_wilsons(count):
    values = xr.DataArray(np.where(np.arange(20) < count, 1.0, 0.0), dims="case")
    found = sf.probability(values, above=0.5)
    known = scipy.stats.binomtest(count, 20).proportion_ci(method="wilson")
    assert [float(found[name]) for name in ("probability", "low", "high")] == pytest.approx(
        [count / 20, known.low, known.high], abs=1e-14
    )


@pytest.mark.parametrize("band", [(1.0, 1.2), (0.8, 1.0), (0.7, 1.3)])
def test_both_ends_of_the_band_belong_to_it(band):
    """Of the multiples of half a hertz that 1 s has, the bands hold that of 1 Hz alone."""
    (signal,) = sf.motions.random_forcing(1.0, band, 2.0, dt=0.05, seed=4)
    assert np.ptp(signal.samples) > 0.1
    assert signal.samples[10:] == pytest.approx(-signal.samples[:-10], abs=1e-13)


@pytest.mark.parametrize(
    ("given", "message"),
    [
        ({"duration": -1.0}, "positive"),
        ({"band": (2.0, 1.0)}, "smaller"),
        ({"band": 1.0}, "two numbers"),
        ({"number": 0}, "number is 0"),
        ({"dt": 1.0}, "four samples"),
        ({"band": (0.51, 0.52), "duration": 1.0}, "narrower"),
        ({"duration": 1e9}, "take fewer"),
    ],
)
def test_bad_forcing(given, message):
    with pytest.raises(sf.SceneError, match=message):
        sf.motions.random_forcing(**{"duration": 10.0, "band": (0.5, 2.0), "rms": 1.0, **given})
