"""Shifted clocks and outliers of records are told by name, and robust losses keep errors honest."""

import numpy as np
import pytest
import sympy as sp

import symfric as sf
from symfric.identification.loss import LOSSES, sandwich
from symfric.identification.sensor_faults import _small_first, limit, outliers_of

X, U = sp.symbols("x u", real=True)
MU_S, MU_K, V_S, V_B = sp.symbols("mu_s mu_k v_s v_b", positive=True)
T = np.linspace(0.0, 60.0, 201)[1:]
TRUTH = {"mu_s": 0.4, "mu_k": 0.25, "v_s": 0.1}
BOUNDS = {"mu_s": (0.1, 0.8), "mu_k": (0.05, 0.6), "v_s": (1e-3, 1.0)}
NOISE = 0.01


def rig(**values):
    belt = sf.Contact("belt", U - V_B, 1, sf.laws.stribeck(MU_S, MU_K, V_S))
    numbers = {MU_S: 0.4, MU_K: 0.25, V_S: 0.1, V_B: 0.2}
    scene = sf.Scene(sf.System([X], [U], [[1]], [-X - U / 20]), [belt], numbers, {X: 0.0, U: 0.0}, 60.0)
    return scene.where(values) if values else scene


@pytest.fixture(scope="module")
def path():
    run = sf.simulate(rig().until(65.0), 1e-10)
    return lambda t: run(t)[0]


def record(path, generator, shift=0.0, outliers=0):
    """Return a noisy record with a clock that is ahead, and the indices of its outliers."""
    t = T[max(shift, 0.0) < T]
    y = path(t - shift) + NOISE * generator.standard_normal(t.size)
    chosen = np.sort(generator.choice(t.size, outliers, replace=False))
    y[chosen] += generator.choice([-1.0, 1.0], outliers) * generator.uniform(0.1, 0.5, outliers)
    return (t, y), chosen


def told(fit, word):
    return [n for n in fit.notes if word in n]


@pytest.mark.one_in(2)
@pytest.mark.parametrize("shift", [0.4, 0.05, pytest.param(-0.7, marks=pytest.mark.long)])
def test_a_shift_is_told_with_its_size(path, shift):
    (t, y), _ = record(path, np.random.default_rng(1), shift)
    fit = sf.identify(rig(), {"x": (t, y)}, BOUNDS, starts=2)
    assert fit.faults.shifts["x"].dt == pytest.approx(shift, abs=4 * fit.faults.shifts["x"].error)
    assert fit.faults.shifts["x"].error < 0.02
    (note,) = told(fit, "seems shifted")
    assert f"dt = {fit.faults.shifts['x'].dt:.3g}" in note
    assert fit.faults.outliers == {}
    assert fit.to_dict()["shifts"]["x"]["dt"] == fit.faults.shifts["x"].dt
    late = t > shift  # the cure that the note names
    mended = sf.identify(rig(), {"x": (t[late] - shift, y[late])}, BOUNDS, starts=2)
    assert mended.faults.shifts == {}
    assert mended.sigma["x"] == pytest.approx(NOISE, rel=0.2)


@pytest.mark.long(beside="test_a_shift_is_told_with_its_size")
def test_each_of_several_records_has_its_own_shift(path):
    generator = np.random.default_rng(2)
    (t, y), _ = record(path, generator, -0.5)
    (other, z), _ = record(lambda t: 3 * path(t), generator, 0.0)
    fit = sf.identify(rig(), {"x": (t, y), "y": (other, z)}, BOUNDS, {"y": 3 * X}, starts=2)
    assert set(fit.faults.shifts) == {"x"}
    assert fit.faults.shifts["x"].dt == pytest.approx(-0.5, abs=4 * fit.faults.shifts["x"].error)


def test_outliers_are_told_with_their_places(path):
    (t, y), chosen = record(path, np.random.default_rng(3), outliers=7)
    fit = sf.identify(rig(), {"x": (t, y)}, BOUNDS, starts=2)
    assert fit.faults.outliers["x"].tolist() == chosen.tolist()
    (note,) = told(fit, "outliers")
    assert note.startswith(f"7 samples of x are outliers: samples {chosen[0]} (t = {t[chosen[0]]:.6g})")
    assert ", ...; leave them out" in note
    robust = sf.identify(rig(), {"x": (t, y)}, BOUNDS, starts=2, loss="cauchy")
    for name, true in TRUTH.items():
        assert abs(robust.values[name] - true) < 3 * robust.standard_errors[name] < 0.05
    assert robust.sigma["x"] == pytest.approx(NOISE, rel=0.2)
    assert "counts them less" in told(robust, "outliers")[0]
    assert robust.loss == "cauchy"
    low, high = robust.profile("mu_s").interval
    assert (low, high) == pytest.approx(robust.interval("mu_s"), abs=0.3 * (high - low))


@pytest.mark.long(beside="test_outliers_are_told_with_their_places")
@pytest.mark.parametrize("shift", [0.45, -0.45])
def test_outliers_at_the_start_of_a_shifted_record_are_told(path, shift):
    """They are too early for shifts that were tried, not for the one that was found."""
    (t, y), _ = record(path, np.random.default_rng(9), shift)
    y[[0, 2, 50]] += [0.4, -0.3, 0.2]
    fit = sf.identify(rig(), {"x": (t, y)}, BOUNDS, starts=2)
    assert fit.faults.shifts["x"].dt == pytest.approx(shift, abs=4 * fit.faults.shifts["x"].error)
    assert fit.faults.outliers["x"].tolist() == [0, 2, 50]


def test_a_clean_record_has_no_fault(path):
    (t, y), _ = record(path, np.random.default_rng(4))
    fit = sf.identify(rig(), {"x": (t, y)}, BOUNDS, starts=1)
    assert fit.faults.shifts == fit.faults.outliers == {}
    assert fit.notes == ()


def test_shifts_to_try_are_the_small_ones_among_the_lowest():
    trials = np.linspace(-2.0, 2.0, 401)
    off = 2 + np.cos(2 * np.pi * (trials - 0.3))  # lowest at -0.2, 0.8, -1.2 and 1.8
    assert _small_first(trials, off) == pytest.approx([-0.2, 0.8, -1.2, 1.8])
    assert _small_first(trials, np.where(trials < 0, np.inf, off))[:3] == pytest.approx([0.0, 0.8, 1.8])
    assert _small_first(trials, (trials - 0.5) ** 2) == pytest.approx([0.5] * 4)
    assert np.all(_small_first(trials, np.full(401, np.inf)) == 0.0)


def test_short_records_are_not_judged(path):
    (t, y), _ = record(path, np.random.default_rng(4), -0.7)
    short = sf.identify(rig(), {"x": (t, y), "y": (t[:12], 3 * y[:12])}, BOUNDS, {"y": 3 * X}, starts=1)
    assert short.faults.shifts == short.faults.outliers == {}


@pytest.mark.long(beside="test_a_clean_record_has_no_fault")
def test_a_law_that_is_wrong_is_no_shifted_clock(path):
    """Friction without a drop of its coefficient cannot stick and slip; the residuals are as large as the record."""
    belt = sf.Contact("belt", U - V_B, 1, sf.laws.exponential(MU_S, V_S))
    system = sf.System([X], [U], [[1]], [-X - U / 20])
    scene = sf.Scene(system, [belt], {MU_S: 0.4, V_S: 0.5, V_B: 0.2}, {X: 0.0, U: 0.0}, 60.0)
    data, _ = record(path, np.random.default_rng(10))
    fit = sf.identify(scene, {"x": data}, {"mu_s": (0.1, 0.8), "v_s": (0.05, 2.0)}, starts=1)
    assert fit.faults.shifts == {}
    assert not fit.diagnostics["x"].is_white


@pytest.mark.parametrize("name", LOSSES)
def test_derivatives_of_losses(name):
    loss = LOSSES[name]
    r, h = np.array([-7.3, -2.0, -0.4, 0.0, 0.7, 1.1, 3.0, 50.0]), 1e-6
    cost = lambda r: loss.cost(r[None])  # noqa: E731
    assert loss.slope(r) == pytest.approx((cost(r + h) - cost(r - h)) / (2 * h), abs=1e-6)
    assert loss.curvature(r) == pytest.approx((loss.slope(r + h) - loss.slope(r - h)) / (2 * h), abs=1e-6)
    assert loss.root(r) ** 2 * r == pytest.approx(loss.slope(r))
    assert cost(np.array([1e-3])) == pytest.approx(0.5e-6, rel=1e-5)


@pytest.mark.one_in(2)
@pytest.mark.parametrize("name", [n for n in LOSSES if n != "linear"])
def test_the_sandwich_is_the_spread_of_estimates(name):
    """Lines through points, a tenth of which has ten times the noise; and 95 % efficiency for normal noise."""
    loss, generator, count = LOSSES[name], np.random.default_rng(5), 150
    J = np.column_stack([np.ones(120), np.linspace(-1.0, 1.0, 120)])
    for wild in (0.0, 0.1):
        found, errors, rises = [], [], []
        for _ in range(count):
            noise = generator.standard_normal(120) * np.where(generator.random(120) < wild, 10.0, 1.0)
            values = np.zeros(2)
            for _ in range(25):
                rest = J @ values - noise
                root = loss.root(rest)
                values = values - np.linalg.lstsq(root[:, None] * J, root * rest, rcond=None)[0]
            told = sandwich(loss, J @ values - noise, J)
            found.append(values)
            errors.append(np.sqrt(np.diag(np.linalg.inv(told.root.T @ told.root))))
            rises.append((loss.cost(-noise) - loss.cost(J @ values - noise)) / told.inflation)
        assert np.mean(errors, axis=0) == pytest.approx(np.std(found, axis=0), rel=0.2)
        assert 2 * np.mean(rises) == pytest.approx(2.0, rel=0.25)  # chi-square with two degrees of freedom
        if wild == 0.0:
            exact = np.sqrt(np.diag(np.linalg.inv(J.T @ J)))
            assert np.mean(errors, axis=0) == pytest.approx(exact / np.sqrt(0.95), rel=0.03)


def test_the_limit_of_outliers_holds_for_normal_noise():
    generator = np.random.default_rng(6)
    false = sum(outliers_of(generator.standard_normal(150)).size > 0 for _ in range(2000))
    assert false < 20
    assert 3.9 < limit(20) < limit(10_000) < 6.0
    assert outliers_of(np.r_[np.zeros(15), 9.0]).size == 0  # too few samples, and no scale


def test_outliers_differ_from_their_neighbours_where_residuals_are_smooth():
    t = np.linspace(0.0, 20.0, 400)
    peaks = np.exp(-(((t - 10.0) / 1.5) ** 2)) + 0.02 * np.random.default_rng(7).standard_normal(t.size)
    assert np.max(peaks) > 1.5 * limit(400) * 1.4826 * np.median(np.abs(peaks))
    assert outliers_of(peaks).size == 0
    peaks[[50, 200]] += [-1.0, 1.0]
    assert outliers_of(peaks).tolist() == [50, 200]


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"loss": "cauchi"}, "did you mean cauchy"),
        ({"loss": None}, "loss is None"),
        ({"loss": "huber", "segments": 3}, "leave out segments"),
    ],
)
def test_bad_losses(change, message):
    with pytest.raises(sf.SceneError, match=message):
        sf.identify(rig(), {"x": (T, np.sin(T))}, BOUNDS, **change)


@pytest.mark.long(beside="test_a_clean_record_has_no_fault")
@pytest.mark.parametrize("kind", ["clean", "shift", "outliers", "both"])
def test_how_often_faults_are_found(path, kind):
    """100 records of a kind: shifts of 0.05 to 0.8 and one to ten outliers are told, clean records have none."""
    shifted = found = exact = near = 0
    for seed in range(100):
        generator = np.random.default_rng([8, ["clean", "shift", "outliers", "both"].index(kind), seed])
        shift = generator.choice([-1, 1]) * generator.uniform(0.05, 0.8) if kind in ("shift", "both") else 0.0
        count = int(generator.integers(1, 11)) if kind in ("outliers", "both") else 0
        data, chosen = record(path, generator, shift, count)
        fit = sf.identify(rig(), {"x": data}, BOUNDS, starts=2)
        told_shift, told_outliers = fit.faults.shifts.get("x"), fit.faults.outliers.get("x", np.zeros(0, dtype=int))
        shifted += told_shift is not None
        near += told_shift is not None and abs(told_shift.dt - shift) < 4 * told_shift.error
        found += told_outliers.size > 0
        exact += told_outliers.tolist() == chosen.tolist()
    print(f"{kind}: shift told {shifted}, right {near}, outliers told {found}, all places right {exact} of 100")
    if kind in ("shift", "both"):
        assert near >= 95
    else:
        assert shifted <= 2
    assert found >= 97 if kind in ("outliers", "both") else found <= 2
    assert exact >= 90
