"""Fits to records: closed forms, exact derivatives, what records do not fix, edges of the cost, bad records."""

import mpmath as mp
import numpy as np
import pytest
import sympy as sp
import xarray as xr

import symfric as sf
from symfric.identification.prediction import Predictor
from symfric.identification.records import read_channels
from symfric.identification.tables import read_table
from symfric.identification.unknowns import read_unknowns
from tests.identification.rigs import BOUNDS, MU_K, MU_S, V_B, V_S, T, U, X, rig
from tests.reference_cases import values_of

W, F = sp.symbols("w f", positive=True)


def decaying(f=0.043):
    floor = sf.Contact("floor", U, 1, sf.laws.coulomb(F))
    return sf.Scene(sf.System([X], [U], [[1]], [-(W**2) * X]), [floor], {W: 1.0, F: f}, {X: 1.0, U: 0.0}, 40.0)


def measured(scene, t=T, noise=0.01, seed=0, of=0):
    return sf.simulate(scene, 1e-11)(t)[of] + noise * np.random.default_rng(seed).standard_normal(t.size)


@pytest.fixture(scope="module")
def fit():
    return sf.identify(rig(), {"x": (T, measured(rig()))}, BOUNDS, sigma=0.01, starts=4)


def test_the_reference_case():
    known = values_of("ident_coulomb")
    i = np.arange(1, 161)
    y = sf.simulate(decaying(), 1e-13)(0.25 * i)[0] + 0.01 * np.sin(i**2)
    fit = sf.identify(decaying(), {"x": (0.25 * i, y)}, {"w": (0.5, 2.0), "f": (0.001, 0.2)}, sigma=0.01)
    assert fit.values["w"] == pytest.approx(known["w"], abs=1e-9)
    assert fit.values["f"] == pytest.approx(known["f"], abs=1e-9)
    assert np.sum(fit.residuals["x"] ** 2) == pytest.approx(known["r.r"], abs=1e-10)
    assert fit.covariance == pytest.approx(1e-4 * np.linalg.inv(known["JTJ_at_truth"]), abs=1e-6, rel=0.01)
    exact = sf.identify(
        decaying(), {"x": (0.25 * i, y - 0.01 * np.sin(i**2))}, {"w": (0.5, 2.0), "f": (0.001, 0.2)}, sigma=0.01
    )
    assert exact.values == pytest.approx({"w": 1.0, "f": 0.043}, abs=1e-10)
    assert exact.covariance == pytest.approx(1e-4 * np.linalg.inv(known["JTJ_at_truth"]), rel=1e-6)


def decay(t, w, f):
    """Return x of ``x'' = -w^2 x - f sgn x'``, x(0) = 1 at rest: cosines about centres -+f/w^2, in many digits."""
    amplitude, side, left = mp.mpf(1), mp.mpf(1), mp.mpf(t)
    centre = f / w**2
    while left > mp.pi / w:
        amplitude, side, left = amplitude - 2 * centre, -side, left - mp.pi / w
    return side * ((amplitude - centre) * mp.cos(w * left) + centre)


def test_derivatives_against_thirty_digits():
    t = np.linspace(0.5, 30.0, 40)
    channels = read_channels({"": decaying()}, {"x": (t, np.cos(t))}, None, None)
    unknowns = read_unknowns({"w": (0.5, 2.0), "f": (0.01, 0.1)}, {"": decaying()}, channels)
    found = Predictor({"": decaying()}, channels, unknowns, 1e-12).at(np.array([1.0, 0.043]))
    with mp.workdps(30):
        step = mp.mpf(10) ** -10
        for k, time in enumerate(t):
            for j, (dw, df) in enumerate(((step, 0), (0, step))):
                w, f = mp.mpf(1), mp.mpf("0.043")
                slope = (decay(time, w + dw, f + df) - decay(time, w - dw, f - df)) / (2 * step)
                assert found.slopes[k, j] == pytest.approx(float(slope), rel=1e-7, abs=1e-9)


def stick_slip(t, mu_s, mu_k, v_b):
    """Return x of ``x'' = -x`` on a belt with two coefficients, from x = 0 at rest, in closed form piece by piece."""
    left, stop = mp.mpf(t), mp.asin(v_b / mu_k)
    if left <= stop:
        return mu_k * (1 - mp.cos(left))
    left, x, a = left - stop, mu_k * (1 - mp.cos(stop)), mu_s - mu_k
    stroke = 2 * mp.pi - 2 * mp.atan(a / v_b)
    while True:
        stick = (mu_s - x) / v_b
        if left <= stick:
            return x + v_b * left
        left -= stick
        if left <= stroke:
            return mu_k + a * mp.cos(left) + v_b * mp.sin(left)
        left, x = left - stroke, mu_k + a * mp.cos(stroke) + v_b * mp.sin(stroke)


def test_derivatives_through_stick_and_slip_against_thirty_digits():
    belt = sf.Contact("belt", U - V_B, 1, sf.laws.coulomb(MU_S, MU_K))
    numbers = {MU_S: 0.4, MU_K: 0.25, V_B: 0.2}
    scene = sf.Scene(sf.System([X], [U], [[1]], [-X]), [belt], numbers, {X: 0.0, U: 0.0}, 60.0)
    t = np.linspace(0.37, 60.0, 60)
    channels = read_channels({"": scene}, {"x": (t, np.cos(t))}, None, None)
    unknowns = read_unknowns({"mu_s": (0.3, 0.5), "mu_k": (0.2, 0.3), "v_b": (0.1, 0.3)}, {"": scene}, channels)
    found = Predictor({"": scene}, channels, unknowns, 1e-12).at(np.array([0.4, 0.25, 0.2]))
    assert len(found.sequence[0]) > 12
    with mp.workdps(30):
        true, step = [mp.mpf("0.4"), mp.mpf("0.25"), mp.mpf("0.2")], mp.mpf(10) ** -10
        for k, time in enumerate(t):
            assert found.y[k] == pytest.approx(float(stick_slip(time, *true)), abs=1e-10)
            for j in range(3):
                sides = [[v + way * step * (i == j) for i, v in enumerate(true)] for way in (1, -1)]
                slope = (stick_slip(time, *sides[0]) - stick_slip(time, *sides[1])) / (2 * step)
                assert found.slopes[k, j] == pytest.approx(float(slope), rel=1e-7, abs=1e-8)


def test_the_law_of_a_rig_from_noise(fit):
    for name, true in (("mu_s", 0.4), ("mu_k", 0.25), ("v_s", 0.1)):
        assert abs(fit.values[name] - true) < 3 * fit.standard_errors[name] < 0.06
    assert fit.scene.values[MU_S] == fit.values["mu_s"]
    assert fit.cost == pytest.approx(150, rel=0.3)
    assert fit.diagnostics["x"].is_white
    assert fit.unidentifiable == ()
    run = fit.runs[0]
    assert run["x"] == pytest.approx(fit.predictions["x"], abs=1e-8)
    assert fit.residuals["x"] + fit.predictions["x"] == pytest.approx(fit.records["x"][1])
    assert fit.to_dict()["samples"] == 300
    assert fit.to_xarray()["x residual"].shape == (300,)
    assert fit.plot().get_lines()
    assert "mu_s" in str(fit)
    assert "mu_s" in repr(fit)


def test_a_profile_is_that_of_the_costs(fit):
    profile = fit.profile("v_s")
    low, high = profile.interval
    assert low < fit.values["v_s"] < high
    assert np.min(profile.cost) == pytest.approx(fit.cost, rel=1e-9)
    for end in (low, high):  # the cost rises by half of 3.84 there, whoever fits the others
        others = {n: b for n, b in BOUNDS.items() if n != "v_s"}
        held = sf.identify(rig(v_s=end), {"x": fit.records["x"]}, others, sigma=0.01, starts=2)
        assert held.cost - fit.cost == pytest.approx(3.8415 / 2, rel=1e-3)
    assert profile.plot().get_lines()
    near = fit.interval("v_s")
    assert profile.interval == pytest.approx(near, rel=0.1)


def test_directions_that_are_not_fixed():
    smooth = rig(v_b=1.5).starting({"x": 0.5})
    y = measured(smooth, noise=0.002)
    found = sf.identify(smooth, {"x": (T, y)}, {"mu_s": (0.3, 0.8), "mu_k": (0.1, 0.29), "v_s": (0.01, 0.2)}, starts=3)
    assert {tuple(d) for d in found.unidentifiable} == {("mu_s",), ("v_s",)}
    assert np.isinf(found.standard_errors["mu_s"])
    assert any("do not fix mu_s" in n for n in found.notes)
    # only the product of two factors of the friction is felt
    n_0, mu = sp.symbols("n_0 mu", positive=True)
    floor = sf.Contact("floor", U, n_0, sf.laws.coulomb(mu))
    scene = sf.Scene(sf.System([X], [U], [[1]], [-X]), [floor], {n_0: 0.5, mu: 0.08}, {X: 1.0, U: 0.0}, 30.0)
    t = np.linspace(0.1, 30, 200)
    found = sf.identify(scene, {"x": (t, measured(scene, t))}, {"n_0": (0.1, 0.9), "mu": (0.01, 0.2)}, starts=2)
    (direction,) = found.unidentifiable
    relative = [direction[n] / found.values[n] for n in ("n_0", "mu")]
    assert relative[0] == pytest.approx(-relative[1], rel=1e-3)
    assert "only in a combination" in str(direction)
    assert found.values["n_0"] * found.values["mu"] == pytest.approx(0.04, rel=0.01)


def test_several_scenes_sensors_and_starts():
    scenes = {"slow": rig(v_b=0.1), "fast": rig()}
    records = {
        "slow": {"x": (T, measured(scenes["slow"], seed=1))},
        "fast": {"y": (T, 2 * measured(rig(), seed=2) + 0.3)},
    }
    unknowns = {**BOUNDS, "y.scale": (0.5, 4.0), "fast.y.offset": (-1.0, 1.0), "fast.x": (-0.1, 0.1)}
    found = sf.identify(scenes, records, unknowns, observed={"y": X}, starts=4)
    truth = {"mu_s": 0.4, "mu_k": 0.25, "v_s": 0.1, "y.scale": 2.0, "fast.y.offset": 0.3, "fast.x": 0.0}
    for name, true in truth.items():
        assert abs(found.values[name] - true) < 4 * found.standard_errors[name], name
    assert set(found.residuals) == {"slow.x", "fast.y"}
    assert found.sigma["fast.y"] == pytest.approx(0.02, rel=0.2)
    assert found.scenes["slow"].initial[X] == 0.0 != found.scenes["fast"].initial[X]
    with pytest.raises(sf.SceneError, match=r"fit\.scenes"):
        _ = found.scene


def test_weights_leave_out_what_they_do_not_trust():
    y = measured(rig())
    y[100:120] += 5.0
    sigma = np.full(T.size, 0.01)
    sigma[100:120] = 1e6
    found = sf.identify(rig(), {"x": (T, y)}, BOUNDS, sigma=sigma, starts=2)
    assert abs(found.values["mu_s"] - 0.4) < 3 * found.standard_errors["mu_s"]


def test_a_law_without_derivatives():
    """The slope of the square-root law is infinite at rest: the fit takes differences, and says so."""
    belt = sf.Contact("belt", U - V_B, 1, sf.laws.square_root(MU_K, -V_S, MU_S))
    numbers = {MU_S: 0.4, MU_K: 0.35, V_S: 0.2, V_B: 0.2}
    scene = sf.Scene(sf.System([X], [U], [[1]], [-X - U / 20]), [belt], numbers, {X: 0.0, U: 0.0}, 60.0)
    t = T[:187]
    found = sf.identify(
        scene, {"x": (t, measured(scene, t, 0.005))}, {"mu_k": (0.2, 0.39), "v_s": (0.1, 0.4)}, starts=1
    )
    for name, true in (("mu_k", 0.35), ("v_s", 0.2)):
        assert abs(found.values[name] - true) < 3 * found.standard_errors[name] < 0.1 * true
    assert any("differences" in n for n in found.notes)


def test_a_record_of_many_samples():
    t = np.linspace(0.0, 96.0, 50_001)
    found = sf.identify(rig(), {"x": (t, measured(rig(), t))}, {"mu_s": (0.3, 0.6), "v_s": (0.05, 0.2)}, starts=1)
    assert abs(found.values["mu_s"] - 0.4) < 3 * found.standard_errors["mu_s"] < 1e-3


def test_at_a_bound():
    found = sf.identify(rig(), {"x": (T, measured(rig()))}, {"mu_s": (0.1, 0.8), "mu_k": (0.05, 0.24)}, starts=2)
    assert found.active == ("mu_k",)
    assert found.values["mu_k"] == 0.24
    assert np.isnan(found.standard_errors["mu_k"])
    assert found.standard_errors["mu_s"] < 0.1
    assert "at its bound" in found.notes[0]


def test_over_the_jumps_of_the_cost():
    """From a start in a mode with fewer strokes the fit gets over the edges to the truth."""
    start = rig(mu_s=0.7, mu_k=0.5, v_s=0.5)
    found = sf.identify(start, {"x": (T, measured(rig()))}, BOUNDS, starts=8, seed=3)
    assert found.values["mu_s"] == pytest.approx(0.4, abs=0.02)
    assert max(m.changes for m in found.tries) > 0


def test_where_the_cost_is_not_smooth():
    """A body that nearly does not start again: its last stroke is there or not, within one standard error."""
    scene = decaying(1 / 19 + 1e-4)  # it rests from |x| <= f on, after 9 strokes; with f < 1/19 after 10
    t = np.linspace(0.2, 40.0, 100)
    found = sf.identify(scene, {"x": (t, measured(scene, t, noise=0.03))}, {"f": (0.01, 0.2)}, starts=2)
    (edge,) = found.crossings
    assert abs(edge.events[0] - edge.events[1]) == 1
    assert edge.values["f"] == pytest.approx(1 / 19, abs=1e-7)
    assert abs(edge.jump) < 1e-4  # the additional stroke begins with length zero
    assert any("number of events" in n for n in found.notes)


def test_a_scene_without_values_and_cheap_starts():
    open_ = rig(mu_s=None, mu_k=None, v_s=None)
    once = sf.identify(open_, {"x": (T, measured(rig()))}, BOUNDS, seed=1)
    again = sf.identify(open_, {"x": (T, measured(rig()))}, BOUNDS, seed=1)
    assert once.values == again.values
    assert once.values["mu_s"] == pytest.approx(0.4, abs=0.02)
    assert once.evaluations < 500


def test_records_in_other_forms(tmp_path):
    y = measured(rig())
    place = tmp_path / "record.csv"
    place.write_text("t,x\n" + "\n".join(f"{a},{b}" for a, b in zip(T, y, strict=True)))
    array = xr.DataArray(y, {"t": T}, ["t"])
    unknowns = {"mu_k": (0.05, 0.39)}
    found = [
        sf.identify(rig(), records, unknowns, starts=1).values["mu_k"]
        for records in ({"x": (T, y)}, {"x": array}, array.to_dataset(name="x"), str(place), {X: (list(T), list(y))})
    ]
    assert found == [found[0]] * 5
    spread = xr.DataArray(y, {"t": (T * 1e9).astype("timedelta64[ns]")}, ["t"])
    assert sf.identify(rig(), {"x": spread}, unknowns, starts=1).values["mu_k"] == pytest.approx(found[0], abs=1e-7)
    assert read_table(place)["x"][1] == pytest.approx(y)


Y = np.sin(T)
HOLE = np.r_[0:100, 200:300]


def with_(k, value):
    y = Y.copy()
    y[k] = value
    return y


@pytest.mark.parametrize(
    ("record", "message"),
    [
        ((T, with_(5, np.nan)), r"y\[5\] = nan; leave out"),
        ((with_(5, np.inf), Y), r"t\[5\] = inf"),
        ((T[::-1], Y), "not in the order of t"),
        ((np.repeat(T[:150], 2), Y), r"has t = .* twice \(samples 0 and 1\); keep one"),
        ((T + 1e3, Y), "begins at t = .*after the horizon"),
        ((T, np.ma.masked_greater(Y, np.median(Y))), "masked in part"),
        ((T, np.median(Y) > Y), "not real numbers"),
        (([f"{e}" for e in T], Y), "not real numbers"),
        ((T.astype("datetime64[s]"), Y), "dates or durations"),
        ({"t": T, "y": Y}, "is dict; give times and values"),
        ((T, np.full(300, 0.3)), "constant"),
        (([], []), "no samples"),
        (([1.0], [1.0]), "1 sample;"),
        ((T, Y[:-1]), "300 times and 299 values"),
        ((T, 1e5 * Y), "convert the record"),
        ((T, 1e-5 * Y), "convert the record"),
        ((1e3 * T, Y), "convert the times"),
        ((T - 5, Y), "before the run"),
        (Y, "give times and values"),
        ((T, ["a"] * 300), "not real numbers"),
        ((T, np.stack([Y, Y])), "shape"),
        (xr.DataArray(Y, {"t": ("t", T, {"units": "ms"})}, ["t"]), "in 'ms'; convert"),
        (xr.DataArray(np.ones((2, 2)), dims=["a", "b"]), "dimensions"),
    ],
)
def test_a_bad_record_is_one_clear_line(record, message):
    with pytest.raises(sf.SceneError, match=message) as told:
        sf.identify(rig(), {"x": record}, {"mu_s": (0.3, 0.8)})
    assert "\n" not in str(told.value)
    assert "record x" in str(told.value)


def test_a_gap_is_told_and_used():
    y = measured(rig())[HOLE]
    with pytest.warns(UserWarning, match="gap from t = 32 to 64"):
        found = sf.identify(rig(), {"x": (T[HOLE], y)}, {"mu_s": (0.3, 0.8)}, starts=1)
    assert abs(found.values["mu_s"] - 0.4) < 4 * found.standard_errors["mu_s"]


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"parameters": {"mu": (1, 2)}}, "no value, state, offset or scale"),
        ({"parameters": {"mu_s": (2, 1)}}, "must be smaller"),
        ({"parameters": {"mu_s": 1}}, "smallest, largest"),
        ({"parameters": {}}, "at least one unknown"),
        ({"parameters": {"mu_s": (0, np.inf)}}, "finite"),
        ({"parameters": {"x.offset": (-1, 1), "mu_s": (0.3, 0.8), MU_S: (0.3, 0.8)}}, "twice"),
        ({"records": {}}, "no records"),
        ({"records": None}, "give a mapping"),
        ({"records": {"z": (T, Y)}}, "no state"),
        ({"records": "nowhere.csv"}, "nowhere.csv: cannot be read"),
        ({"scene": "belt"}, "neither a sf.Scene"),
        ({"scene": {"a": rig()}}, "by its label"),
        ({"sigma": 0.0}, "not positive"),
        ({"sigma": [1.0, 2.0]}, "has shape"),
        ({"sigma": {"y": 1.0}}, "no entry"),
        ({"observed": {"y": X}}, "no record"),
        ({"starts": 0}, "starts is 0"),
    ],
)
def test_bad_arguments(change, message):
    given = {"scene": rig(), "records": {"x": (T, Y)}, "parameters": {"mu_s": (0.3, 0.8)}, **change}
    with pytest.raises(sf.SceneError, match=message):
        sf.identify(**given)


def test_no_run_at_all():
    """Static friction below kinetic friction: no combination of sticking and slipping exists."""
    torn = decaying()
    torn = sf.Scene(
        torn.system, [sf.Contact("a", U, 1, sf.laws.coulomb(MU_S, 0.2))], {W: 1.0, MU_S: 0.3}, {X: 1.0, U: 0.0}, 96.0
    )
    with pytest.raises(sf.NotFound, match="no run between the bounds"):
        sf.identify(torn, {"x": (T, Y)}, {"mu_s": (0.01, 0.1)}, starts=2)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("", "names"),
        ("1,2\n3,4\n", "names"),
        ("t,x\n1,a\n", "line 2 holds in column 2 is not a number"),
        ("t,x\n1\n", "line 2 has 1 fields"),
        ("t,x,x\n1,2,3\n", "same name"),
    ],
)
def test_bad_files(tmp_path, text, message):
    place = tmp_path / "record.csv"
    place.write_text(text)
    with pytest.raises(sf.SceneError, match=message):
        read_table(place)


def test_other_separators_and_empty_fields(tmp_path):
    place = tmp_path / "record.csv"
    place.write_text("t;x;y\n1;2;3\n2;;4\n3;4;5\n")
    found = read_table(place)
    assert found["x"][0].tolist() == [1.0, 3.0]
    assert found["y"][1].tolist() == [3.0, 4.0, 5.0]


@pytest.mark.long(beside="test_the_law_of_a_rig_from_noise")
def test_intervals_hold_the_truth_as_often_as_they_say():
    truth, held, within = {"mu_s": 0.4, "mu_k": 0.25, "v_s": 0.1}, 0, 0
    count = 200
    for seed in range(count):
        found = sf.identify(rig(), {"x": (T, measured(rig(), noise=0.005, seed=seed))}, BOUNDS, starts=1)
        held += sum(found.interval(n)[0] < v < found.interval(n)[1] for n, v in truth.items())
        within += all(abs(found.values[n] - v) < 3 * found.standard_errors[n] for n, v in truth.items())
    share = held / (3 * count)
    assert abs(share - 0.95) < 3 * np.sqrt(0.95 * 0.05 / count)  # the three are not independent
    assert within >= 0.95 * count
