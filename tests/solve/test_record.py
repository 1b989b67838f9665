"""The march through a sampled input, against the series and against what must not change."""

import numpy as np
import pytest
import sympy as sp
from hypothesis import given, settings
from hypothesis import strategies as st

import symfric as sf

U, W, A = sp.symbols("u w a", real=True)
PROFILES = {
    "uniform": 0.02,
    "concave": (0.01, 0.2),
    "cells": ([-0.05, -0.01, 0.001, 0.02, 0.03], [0.03, 0.01, 0.02, 0.005]),
    "lines": ([-0.05, -0.01, 0.02, 0.03], [0.03, 0.01, 0.02, 0.005]),
    "none": 0.0,
}


def isolated(samples, dt=0.02, profile="uniform", **changes):
    numbers = {"C": 0.5, "m": 1.0, "horizon": 2.0, **changes}
    return sf.scenes.rolling_isolator(motion=sf.Signal(samples, dt), profile=PROFILES[profile], **numbers)


def shaking(seed, n=60, size=1.0):
    rng = np.random.default_rng(seed)
    return size * np.cumsum(rng.normal(size=n)) / np.sqrt(n) + 0.3 * size * rng.normal(size=n)


def compared(scene, tolerance=1e-10):
    exact, series = sf.simulate(scene, route="exact"), sf.simulate(scene, 1e-13, route="taylor")
    assert exact.route == "exact"
    assert exact.checked().final == pytest.approx(series.checked().final, abs=tolerance)
    assert exact.outputs == pytest.approx(series.outputs, abs=tolerance)
    return exact, series


@pytest.mark.one_in(12)
@pytest.mark.parametrize("profile", PROFILES)
@pytest.mark.parametrize("seed", range(4))
def test_every_profile_agrees_with_the_series(profile, seed):
    exact, series = compared(isolated(shaking(seed), profile=profile))
    assert exact.stats["events"] == series.stats["events"]


@pytest.mark.parametrize("profile", PROFILES)
def test_every_profile_is_taken_in_closed_form(profile):
    scene = isolated(shaking(0), profile=profile)
    assert "from sample to sample in closed form" in sf.explain(scene).answers["exact"]


@pytest.mark.long(beside="test_a_long_record_keeps_its_accuracy_when_the_step_is_cut")
@settings(max_examples=25, deadline=None)
@given(seed=st.integers(0, 10**6), dt=st.sampled_from([0.005, 0.02, 0.3]), C=st.sampled_from([0.0, 0.1, 3.0, 20.0]))
def test_random_records_and_dampings(seed, dt, C):
    compared(isolated(shaking(seed, 30), dt, "concave", C=C, horizon=20 * dt), 1e-9)


def test_two_crossings_inside_one_sample_are_found():
    # one long sample: the ground slows down, stands and speeds up again, so that the slip only just changes its sign
    for depth in (1e-3, 1e-6, 1e-9):
        slope = 2.0
        start = np.sqrt(2 * slope * (0.5 + depth)) / np.sqrt(slope)
        samples = [start * slope / 2, -start * slope / 2]
        scene = isolated(samples, 1.0, "none", C=0.0, horizon=1.0)
        run = sf.simulate(scene.wanting({"low": sf.Min(W), "high": sf.Max(W), "end": sf.End()}), route="exact")
        t = np.linspace(0, 1, 100001)
        w = -(samples[0] * t + (samples[1] - samples[0]) * t**2 / 2)
        assert run["low"] == pytest.approx(w.min(), abs=1e-9)
        assert run["high"] == pytest.approx(w.max(), abs=1e-9)


def test_a_record_that_starts_above_the_friction_slips_at_once():
    run = sf.simulate(isolated([-1.0, -1.0, 0.0]).wanting({"all": sf.Trajectory()}), route="exact")
    assert run.mode[0, 0] == 1
    assert run(1e-3)[1] > 0


def test_the_dense_output_is_that_of_the_series():
    scene = isolated(shaking(3), profile="lines").wanting({"all": sf.Trajectory()})
    exact, series = sf.simulate(scene, route="exact"), sf.simulate(scene, 1e-13, route="taylor")
    t = np.linspace(0, 2.0, 777)
    assert exact(t) == pytest.approx(series(t), abs=1e-10)
    assert [e.after for e in exact.events] == [e.after for e in series.events]
    assert [e.t for e in exact.events] == pytest.approx([e.t for e in series.events], abs=1e-9)
    assert exact.energy_residual() < 1e-9


def test_runs_of_one_program_follow_the_values():
    scene = isolated(shaking(5), profile="concave")
    program = sf.prepare(scene, route="exact")
    for changes in ({"C": 2.0}, {"m": 3.0, "R": 0.0}, {"mu0": 0.05}):
        once = sf.simulate(scene.where(changes), route="exact")
        assert program.run(changes).outputs == once.outputs


def test_a_long_record_keeps_its_accuracy_when_the_step_is_cut():
    samples, dt = shaking(7, 400), 0.02
    fine = np.interp(np.arange(0, 399 * 4 + 1) / 4, np.arange(400), samples)
    coarse = sf.simulate(isolated(samples, dt, "concave", horizon=10.0), route="exact")
    cut = sf.simulate(isolated(fine, dt / 4, "concave", horizon=10.0), route="exact")
    assert coarse.outputs == pytest.approx(cut.outputs, abs=1e-11)


def test_what_the_march_does_not_take_goes_by_series():
    scene = isolated(shaking(1))
    wanted = scene.wanting({"work": sf.Integral(W)})
    assert sf.explain(wanted).route == "taylor"
    assert "an integral is wanted" in sf.explain(wanted).answers["exact"]
    assert sf.simulate(wanted, 1e-12)["work"] == pytest.approx(sf.simulate(scene)["residual"], abs=1e-10)


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"profile": -0.1}, "mu is -0.1"),
        ({"profile": (0.1, 0.2, 0.3)}, "profile has 3 parts"),
        ({"profile": ([0, 1], [1, 2, 3])}, "2 edges and 3 values"),
        ({"profile": ([0, 0, 1], [1, 2])}, "must increase"),
        ({"profile": ([0, 1], [-1])}, "value 0 of the profile is negative"),
        ({"motion": [1, 2, 3]}, "give a sf.Signal"),
        ({"C": float("nan")}, "C"),
    ],
)
def test_bad_input_is_named(changes, message):
    arguments = {"C": 1.0, "m": 1.0, "motion": sf.Signal([0.0, 1.0], 0.1), "profile": 0.01, **changes}
    with pytest.raises(sf.SceneError, match=message):
        sf.scenes.rolling_isolator(**arguments)


@pytest.mark.one_in(2)
@pytest.mark.parametrize("seed", [2, 4])
def test_a_release_late_in_a_record_is_no_chatter(seed):
    """A rounding of time is more than a tie of the acceleration there: the series must still see a release."""
    motion = sf.motions.synthetic(seed=seed, pga=0.3, unit="g")
    scene = sf.scenes.rolling_isolator(C=24924.3, m=3e5, motion=motion, profile=0.001)
    march, series = (sf.simulate(scene, 1e-11, route=route).checked() for route in ("exact", "taylor"))
    for name in ("peak_acceleration", "peak_displacement", "residual"):
        assert series[name] == pytest.approx(march[name], rel=1e-10)
    assert series.stats["events"] == march.stats["events"]
