"""The normal load of a friction damper with the smallest peak of a forced response."""

import importlib

import numpy as np
import pytest
import sympy as sp

import symfric as sf
from symfric.design.damper.best_load import Peaks
from tests.longer import longer

module = importlib.import_module("symfric.design.damper.best_load")
x, u = sp.symbols("x u", real=True)
W, N = sp.symbols("W N", positive=True)
C, K = 0.04, 0.5


def forced(size=1.0):
    system = sf.System([x], [u], [[1]], [-x - C * u + size * sp.cos(W * sf.TIME)])
    joint = sf.Contact("joint", u, N, sf.laws.coulomb(0.3), stiffness=K)
    return sf.Scene(system, [joint], {W: 1.05, N: 1.0}, {x: 0, u: 0}, horizon=60.0)


@pytest.mark.long(beside="test_a_best_load_between_an_end_and_its_neighbour")
def test_every_more_load_is_worse_above_the_best():
    """The best is below the least load that is allowed; its peak is that of settled motions."""
    best = sf.design.damper(forced(), "N", bounds=(6, 11), speeds=(1.0, 1.2), speed="W")
    assert best.values == pytest.approx({"N": 6.0})
    peaks = settled_peaks([6.0, 7.0, 9.0, 11.0])
    assert peaks[0] == pytest.approx(best.objective, rel=1e-3)
    assert np.all(np.diff(peaks) > 0)


def settled_peaks(loads, low=1.0, high=1.2):
    late = sf.Samples(x, np.linspace(290.0, 300.0, 501))
    program = sf.prepare(forced().until(300.0).wanting({"late": late}), 1e-8)
    load, frequency = np.meshgrid(loads, np.linspace(low, high, 41), indexing="ij")
    settled = program.map(values={"N": load.ravel(), "W": frequency.ravel()}).outputs["late"]
    return np.max(np.abs(settled), axis=0).reshape(load.shape).max(axis=1)


@pytest.mark.parametrize("bounds", longer([(3.9, 4.6), (3.7, 4.4)], [(3.7, 4.4)]))
def test_a_best_load_between_an_end_and_its_neighbour(monkeypatch, bounds):
    """The survey alone has its smallest peak at an end of the bounds, beside which it falls."""
    monkeypatch.setattr(module, "_SURVEY", 2)
    monkeypatch.setattr(module, "_CLOSE", 3e-3)
    best = sf.design.damper(forced(), "N", bounds=bounds, speeds=(1.08, 1.16), speed="W")
    low, peak, high = settled_peaks([bounds[0], best.values["N"], bounds[1]], 1.1, 1.14)
    assert bounds[0] < best.values["N"] < bounds[1]
    assert best.objective == pytest.approx(peak, rel=1e-3)
    assert peak < min(low, high)


@pytest.fixture(scope="module")
def found():
    return sf.design.damper(forced(), "N", bounds=(1, 40), speeds=(0.9, 1.4), speed="W")


@pytest.mark.long(beside="test_a_best_load_between_an_end_and_its_neighbour")
def test_the_curve_of_turbine_engineers(found):
    assert found.status == "optimal"
    assert found.check.agrees
    at, size = found.values["N"], found.objective
    for share in (0.9, 1.1):
        beside = sf.frequency_response(forced().where({N: share * at}), W, (0.9, 1.4), tolerance=1e-10).peak
        assert beside.half_range > size
    curve = found.curve
    low, high = curve.y[curve.x < at], curve.y[curve.x > at]
    assert np.all(np.diff(low) < 0)
    assert np.all(np.diff(high) > 0)
    stuck = 1 / (C * np.sqrt(1 + K - C**2 / 4))
    assert high[-1] == pytest.approx(stuck, rel=1e-6)
    assert found.scene.values[W] == pytest.approx(float(found.active[-1].split("= ")[1]), rel=1e-5)
    found.plot()


@pytest.mark.long(beside="test_a_best_load_between_an_end_and_its_neighbour")
def test_response_and_best_load_grow_with_the_force(found):
    """All forces times two: displacements and the best load as well, the peak's frequency stays."""
    double = sf.design.damper(forced(2.0), "N", bounds=(4, 16), speeds=(0.9, 1.4), speed="W")
    assert double.objective == pytest.approx(2 * found.objective, rel=1e-6)
    assert double.values["N"] == pytest.approx(2 * found.values["N"], rel=1e-3)


FAULTS = {
    "frequency": ({"speeds": (0.9, 1.4)}, "v_b is not its frequency; give speed='W'"),
    "itself": ({"speeds": (0.9, 1.4), "speed": "W", "parameter": "W"}, "is the frequency of the excitation"),
    "range": ({"speed": "W"}, "give the speeds"),
    "state": ({"speeds": (0.9, 1.4), "speed": "W", "coordinate": "y"}, "y is no state"),
}


@pytest.mark.parametrize("name", FAULTS)
def test_wrong_arguments(name):
    arguments, words = FAULTS[name]
    with pytest.raises(sf.SceneError, match=words):
        sf.design.damper(forced(), **({"parameter": "N", "bounds": (1, 2)} | arguments))


def test_coordinate_is_for_forced_scenes():
    with pytest.raises(sf.SceneError, match="coordinate is for forced scenes"):
        sf.design.damper(sf.scenes.mass_on_belt(v_b=0.2), "beta", (0, 1), (0.1, 0.4), coordinate="u")


@pytest.mark.one_in(3)
@pytest.mark.parametrize("value", [3.2, 5.5, 9.0])
def test_followed_peaks_are_those_of_whole_responses(value):
    """Between two loads whose whole responses are known, as far apart as in a survey."""
    peaks = Peaks(forced(), "N", "W", (0.9, 1.4), "x")
    for known in (0.85 * value, 1.2 * value):
        peaks(known)
    followed, whole = peaks.followed(value), Peaks(forced(), "N", "W", (0.9, 1.4), "x")(value)
    assert followed.half_range == pytest.approx(whole.half_range, rel=1e-8)
    assert followed.value == pytest.approx(whole.value, rel=1e-4)
    assert len(peaks.whole) == 2


@pytest.mark.long(beside="test_followed_peaks_are_those_of_whole_responses")
def test_a_peak_that_was_not_followed_is_found_on_whole_responses(monkeypatch):
    """The design with the local peaks spoilt, so that they miss the highest one, is the same as without them."""
    arguments = {"parameter": "N", "bounds": (5.0, 7.0), "speeds": (1.0, 1.2), "speed": "W"}
    monkeypatch.setattr(module, "_SURVEY", 3)
    monkeypatch.setattr(module, "_CLOSE", 1e-2)
    right = sf.design.damper(forced(), **arguments)
    lower = lambda self, value, before: before._replace(half_range=0.9 * before.half_range)  # noqa: E731
    monkeypatch.setattr(Peaks, "_moved", lower)
    spoilt = sf.design.damper(forced(), **arguments)
    assert spoilt.objective == pytest.approx(right.objective, rel=1e-4)
    assert spoilt.check.agrees
