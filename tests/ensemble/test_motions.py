"""Motions: scaling, resampling, spectra against an independent method, and motions from nothing."""

import math

import numpy as np
import pytest
from scipy import signal

import symfric as sf

RANDOM = np.random.default_rng(7)
NOISE = sf.motions.Motion(RANDOM.standard_normal(120).cumsum(), 0.02, name="noise")


def test_units_and_peaks():
    motion = sf.motions.Motion([0.0, -0.5, 0.25], 0.1, "g", "three")
    assert motion.unit == "m/s^2"
    assert motion.pga == 0.5 * 9.81
    assert motion.pga_g == 0.5
    assert motion.duration == pytest.approx(0.2)
    assert motion.scaled(pga=0.3, unit="g").pga_g == pytest.approx(0.3, rel=1e-15)
    assert motion.scaled(pga=2.0).pga == pytest.approx(2.0, rel=1e-15)
    assert motion.final_velocity == pytest.approx(-0.5 * 9.81 * 0.1 + 0.5 * 0.25 * 9.81 * 0.1)
    assert repr(motion) == "Motion(three, 3 samples, dt=0.1 s, PGA 0.5 g)"
    assert motion.to_dict()["npts"] == 3
    assert motion.to_xarray().sel(t=0.1).item() == -0.5 * 9.81
    assert motion.plot().get_xlabel() == "time t [s]"
    with pytest.raises(ValueError, match="read-only"):
        motion.samples[0] = 1.0


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda: sf.motions.Motion([1.0], 0.1), "at least two"),
        (lambda: sf.motions.Motion([[1.0, 2.0]], 0.1), "shape"),
        (lambda: sf.motions.Motion([1.0, math.nan], 0.1), "sample 1 of motion is not finite"),
        (lambda: sf.motions.Motion([1.0, 2.0], 0.0), "must be positive"),
        (lambda: sf.motions.Motion([1.0, 2.0], 0.1, "cm/s"), "a velocity"),
        (lambda: sf.motions.Motion("ab", 0.1), "no numbers"),
        (lambda: NOISE.scaled(0.0), "must be positive"),
        (lambda: NOISE.scaled(1.0, "kg"), "no unit of acceleration"),
        (lambda: sf.motions.Motion([0.0, 0.0], 0.1).scaled(1.0), "zero throughout"),
        (lambda: NOISE.resampled(-1.0), "resampled"),
        (lambda: NOISE.resampled(100.0), "resampled"),
        (lambda: NOISE.spectrum([0.0005]), "shorter than a tenth of the step"),
        (lambda: NOISE.spectrum([1.0], damping=1.0), "damping is 1.0"),
        (lambda: NOISE.spectrum([-1.0]), "not negative"),
        (lambda: NOISE.spectrum("a"), "no numbers"),
        (lambda: sf.motions.scaled_set([NOISE], 1.0, by="mean"), "by 'mean spectrum' or by 'record'"),
        (lambda: sf.motions.scaled_set(NOISE, 1.0), "a list of"),
        (lambda: sf.motions.scaled_set([], 1.0), "a list of"),
        (lambda: sf.motions.synthetic([1.0, 2.0], seed=1), "both, or neither"),
        (lambda: sf.motions.synthetic([2.0, 1.0], [1.0, 1.0], seed=1), "increasing"),
        (lambda: sf.motions.synthetic([0.01, 1.0], [1.0, 1.0], seed=1), "at least four samples"),
        (lambda: sf.motions.synthetic(seed=1, duration=5.0), "twice the longest period"),
        (lambda: sf.motions.sine_burst(1.0, 0.0), "positive"),
        (lambda: sf.motions.sine_burst(1.0, 1.0, 3, ramp=2), "fit into"),
        (lambda: sf.motions.sine_burst(1.0, 1.0, dt=0.5), "four samples"),
        (lambda: sf.motions.eurocode8([1.0], "F"), "ground is 'F'"),
    ],
)
def test_bad_requests_name_the_cure(make, message):
    with pytest.raises(sf.SceneError, match=message):
        make()


@pytest.mark.parametrize("parts", [2, 3, 7])
def test_resampling_is_exact_at_refinement(parts):
    fine = NOISE.resampled(NOISE.dt / parts)
    np.testing.assert_array_equal(fine.samples[::parts], NOISE.samples)
    np.testing.assert_allclose(fine.samples, np.interp(fine.t, NOISE.t, NOISE.samples), rtol=0, atol=1e-12)
    np.testing.assert_array_equal(fine.resampled(NOISE.dt).samples, NOISE.samples)
    assert NOISE.resampled(0.03).samples.size == 79 + 1


def test_a_motion_is_the_input_of_a_scene():
    import sympy as sp

    x, u, a_g = sp.symbols("x u a_g", real=True)
    scene = sf.Scene(
        system=sf.System(q=[x], u=[u], mass=[[1]], force=[-40 * x - 0.6 * u - a_g]),
        inputs={a_g: NOISE.signal()},
        initial={x: 0.0, u: 0.0},
        horizon=NOISE.duration,
        outputs={"high": sf.Max(x), "low": sf.Min(x)},
    )
    outputs = sf.simulate(scene, tolerance=1e-12).checked().outputs
    omega = math.sqrt(40.0)
    found = NOISE.spectrum([2 * math.pi / omega], 0.3 / omega).displacement[0]
    assert found == pytest.approx(max(outputs["high"], -outputs["low"]), rel=1e-9)


@pytest.mark.one_in(3)
@pytest.mark.parametrize("period", [0.03, 0.4, 3.0, 30.0])
@pytest.mark.parametrize("damping", [0.0, 0.05, 0.7])
def test_spectrum_is_that_of_a_simulation(period, damping):
    omega = 2 * math.pi / period
    fine = NOISE.resampled(NOISE.dt / max(1, math.ceil(200 * NOISE.dt / period)))
    oscillator = signal.StateSpace([[0, 1], [-(omega**2), -2 * damping * omega]], [[0], [-1]], [[1, 0]], [[0]])
    _, during, state = signal.lsim(oscillator, fine.samples, fine.t)
    after = np.linspace(0, 0.5 * period, 400)
    _, later, _ = signal.lsim(oscillator, np.zeros(400), after, state[-1])
    sampled = max(np.max(np.abs(during)), np.max(np.abs(later)))
    found = NOISE.spectrum([period], damping)
    assert -1e-9 < found.displacement[0] / sampled - 1 < 2e-4  # a sampled peak is lower, by up to (omega dt)^2/8
    assert found.pseudo_acceleration[0] == pytest.approx(omega**2 * found.displacement[0])


def test_spectrum_at_its_ends():
    found = NOISE.spectrum([0.0, 0.004, 1.0, 300.0])
    assert found.displacement[0] == 0.0
    assert found.pseudo_acceleration[0] == NOISE.pga
    assert found.pseudo_acceleration[1] == pytest.approx(NOISE.pga, rel=1e-2)
    assert list(found.to_xarray().period.values) == [0.0, 0.004, 1.0, 300.0]
    assert found.to_dict()["damping"] == 0.05
    assert "4 periods" in repr(found)
    assert found.plot().get_xlabel() == "period T [s]"


def test_sampled_peaks_alone_would_be_too_low():
    burst = sf.motions.sine_burst(1.0, 1.0, 10, dt=0.05)
    once = burst.spectrum([0.25]).displacement[0]
    assert burst.resampled(0.05 / 64).spectrum([0.25]).displacement[0] == pytest.approx(once, rel=1e-10)
    state_space = signal.StateSpace([[0, 1], [-((8 * np.pi) ** 2), -0.8 * np.pi]], [[0], [-1]], [[1, 0]], [[0]])
    _, x, _ = signal.lsim(state_space, burst.samples, burst.t)
    assert np.max(np.abs(x)) < once * (1 - 1e-4)


def test_sets_are_scaled_as_one_or_each():
    motions = [NOISE, NOISE.times(3.0), sf.motions.sine_burst(1.0, 2.0)]
    each = sf.motions.scaled_set(motions, 0.4, "g", by="record")
    assert [m.pga_g for m in each] == pytest.approx([0.4] * 3, rel=1e-15)
    one = sf.motions.scaled_set(motions, 0.4, "g")
    assert sf.motions.mean_spectrum(one, [0.0, 1.0]).pseudo_acceleration[0] == pytest.approx(0.4 * 9.81, rel=1e-15)
    assert one[1].pga == pytest.approx(3 * one[0].pga, rel=1e-15)


def test_sine_burst():
    burst = sf.motions.sine_burst(0.3, 2.0, 10, unit="g")
    assert burst.pga_g == 0.3
    assert burst.duration == pytest.approx(5.0)
    assert burst.samples[0] == burst.samples[-1] == 0.0
    assert abs(burst.final_velocity) < 1e-12
    plain = sf.motions.sine_burst(1.0, 1.0, 3, ramp=0, dt=0.01)
    np.testing.assert_allclose(plain.samples, np.sin(2 * np.pi * plain.t), atol=1e-12)


def test_synthetic_motions_follow_their_target():
    periods = np.geomspace(0.1, 4.0, 60)
    target = 2.0 * sf.motions.eurocode8(periods)
    for seed in range(2):
        motion = sf.motions.synthetic(seed=seed, pga=2.0)
        off = sf.motions.misfit(motion, periods, target)
        assert off.largest < 0.2
        assert off.mean < 0.05
        assert f"within {100 * off.largest:.1f} % of its target" in motion.note
        assert abs(motion.final_velocity) < 1e-12
        assert motion.samples[0] == motion.samples[-1] == 0.0


def test_synthetic_motions_are_their_seeds():
    arguments = {"pga": 0.3, "unit": "g", "iterations": 5}
    one, again, other = (sf.motions.synthetic(seed=s, **arguments) for s in (5, 5, 6))
    np.testing.assert_array_equal(one.samples, again.samples)
    assert abs(np.corrcoef(one.samples, other.samples)[0, 1]) < 0.2


def test_synthetic_motion_of_a_given_target():
    periods, values = np.geomspace(0.2, 2.0, 30), np.full(30, 0.1)
    motion = sf.motions.synthetic(periods, values, seed=1, unit="g", damping=0.02, duration=20.0, dt=0.02)
    assert sf.motions.misfit(motion, periods, values * 9.81, damping=0.02).largest < 0.25
    assert motion.duration == pytest.approx(20.0)


def test_spectrum_of_eurocode_8():
    shape = sf.motions.eurocode8([0.0, 0.15, 0.3, 0.5, 1.0, 2.0, 4.0], "B")
    assert shape == pytest.approx([1.0, 2.5, 2.5, 2.5, 1.25, 0.625, 0.15625])


def test_a_signal_begins_at_zero_unless_told():
    assert NOISE.signal().t0 == 0.0
    assert NOISE.signal(2.5).t0 == 2.5
    assert np.array_equal(NOISE.signal(2.5).samples, NOISE.samples)
