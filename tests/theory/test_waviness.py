"""Mass on a wavy belt: the averages over a wave against forced motions of the full model and their multipliers."""

import numpy as np
import pytest
from scipy.optimize import brentq

import symfric as sf
from symfric.theory import waviness

LIMIT = 0.25 * (1 - 0.1 / 0.45)  # v_b1 squared of the scene's values


def guess(v, hill, k, place):
    """State at t = 0 of the fast motion about a mean position, from the averages."""
    n = 4096
    w, phase = waviness.slip_over_a_wave(v, hill, n), (np.arange(n) + 0.5) * 2 * np.pi / n
    way = v * (np.cumsum(1 / w) - 0.5 / w) * 2 * np.pi / n
    mean = np.mean((phase - way) / w) / np.mean(1 / w)
    at = np.interp((k * place - mean) % (2 * np.pi), way, phase, period=2 * np.pi)
    return place + (at - np.interp(at, phase, way) - mean) / k, v - np.interp(at, phase, w)


def forced(v, hill, k):
    """Growth rate of areas about the forced motion of the full model, its mean position and mean square of the slip."""
    period = 2 * np.pi / (k * v)
    scene = sf.scenes.wavy_belt(v_b=v, F=hill * k, k=k).until(period)
    program = sf.prepare(scene, 1e-13, sensitivities=["x", "u"])
    start = np.array(guess(v, hill, k, waviness.drag(scene)))
    for _ in range(12):
        run = program.run(initial=dict(zip("xu", start, strict=True))).checked()
        slopes = np.column_stack([run.sensitivities[name] for name in "xu"])
        gap = run.final - start
        if np.max(np.abs(gap)) < 1e-12:
            break
        start = start - np.linalg.solve(slopes - np.eye(2), gap)
    else:
        raise AssertionError("no forced motion")
    t = np.linspace(0, period, 1601)
    x, u = run(t)
    square = np.trapezoid((v - u) ** 2, t) / period
    return np.log(abs(np.linalg.det(slopes))) / period, np.trapezoid(x, t) / period, square


@pytest.mark.long(beside="test_force_and_growth_on_the_full_model")
def test_the_limit_of_the_full_model_tends_to_the_averaged_one():
    scene = sf.scenes.wavy_belt(v_b=0.3, F=10.0, k=100.0)
    averaged = waviness.onset_speed(scene)
    assert averaged == pytest.approx(0.4116527574, abs=1e-9)
    errors = []
    for k in (100.0, 200.0):
        onset = brentq(lambda v, k=k: forced(v, 0.1, k)[0], 0.405, 0.42, xtol=1e-9)
        assert forced(onset, 0.1, k)[2] == pytest.approx(LIMIT, rel=1e-6)  # exactly, whatever k
        errors.append(onset - averaged)
    assert abs(errors[0]) < 2e-3
    assert 3 < errors[0] / errors[1] < 5  # falls with 1/k^2
    harmonic = waviness.sinusoidal_onset_speed(scene)
    assert abs(harmonic - averaged) > 3 * abs(errors[0])  # waves as strong as these are not weak


@pytest.mark.parametrize(("v", "hill"), [(0.45, 0.1), (0.3, 0.03), (0.6, 0.2)])
def test_force_and_growth_on_the_full_model(v, hill):
    scene = sf.scenes.wavy_belt(v_b=v, F=200.0 * hill, k=200.0)
    growth, place, square = forced(v, hill, 200.0)
    w = waviness.slip_over_a_wave(v, hill)
    assert 1 / np.mean(1 / w) == pytest.approx(v, rel=1e-12)
    assert place == pytest.approx(waviness.drag(scene), abs=1e-4)
    assert square == pytest.approx(v * np.mean(w), rel=1e-3)
    assert growth == pytest.approx(-1.8 * (v * np.mean(w) - LIMIT), abs=1e-3)


def test_weak_waves_are_the_excitation_that_the_source_takes_them_for():
    errors = []
    for F in (4.0, 2.0, 1.0):
        scene = sf.scenes.wavy_belt(v_b=0.3, F=F, k=100.0)
        q = F / 100 / waviness.sinusoidal_onset_speed(scene)
        shaken = sf.scenes.mass_on_belt(v_b=0.3, a=q / 50, Omega=50.0)
        low, high = sf.theory.belt.unstable_speeds(shaken)
        assert low < waviness.sinusoidal_onset_speed(scene) == pytest.approx(high, rel=1e-12)
        errors.append(waviness.onset_speed(scene) - waviness.sinusoidal_onset_speed(scene))
    assert errors[0] / errors[1] == pytest.approx(16, rel=0.1)  # of the fourth power of F
    assert errors[1] / errors[2] == pytest.approx(16, rel=0.1)


def test_without_waves_the_belt_is_that_of_thomsen():
    scene = sf.scenes.wavy_belt(v_b=0.3, F=0.0, k=100.0)
    even = sf.scenes.mass_on_belt(v_b=0.3)
    onset = sf.theory.belt.onset_speed(even)
    assert waviness.onset_speed(scene) == pytest.approx(onset, rel=1e-14)
    assert waviness.sinusoidal_onset_speed(scene) == pytest.approx(onset, rel=1e-14)
    assert waviness.drag(scene) == pytest.approx(sf.theory.belt.equilibrium_position(even), rel=1e-14)
    assert waviness.onset_speed(scene.where({"beta": 0.3})) == 0.0
    assert sf.simulate(scene).final == pytest.approx(sf.simulate(even).final, abs=1e-8)


def test_waves_shrink_the_vibration_and_slow_belts_stick_on_them():
    scene = sf.scenes.wavy_belt(v_b=0.43, F=10.0, k=100.0, horizon=800.0)
    program = sf.prepare(scene)
    ranges = {}
    for F in (0.0, 10.0):
        x, u = guess(0.43, F / 100, 100.0, waviness.drag(scene.where({"F": F})) + 0.02)
        run = program.run({"F": F}, {"x": x, "u": u}).checked()
        ranges[F] = np.ptp(run(np.linspace(760, 800, 4001))[0])
    assert ranges[0.0] > 0.2  # an even belt shakes the mass at this speed
    assert ranges[10.0] < 0.02
    caught = sf.simulate(scene.where({"v_b": 0.1}).until(120.0)).checked()
    assert any(event.kind == "stick" for event in caught.events)
    assert np.max(caught(np.linspace(0, 120, 2001))[0]) > 0.95 * 10  # held by a wave up to the force F


def test_what_it_does_not_take():
    even = sf.scenes.mass_on_belt(v_b=0.3)
    wavy = sf.scenes.wavy_belt(v_b=0.3, F=30.0, k=100.0)
    for function in (waviness.onset_speed, waviness.sinusoidal_onset_speed, waviness.drag):
        with pytest.raises(sf.SceneError, match="hold for sf.scenes.wavy_belt"):
            function(even)
    with pytest.raises(sf.NotFound, match="see onset_speed"):
        waviness.sinusoidal_onset_speed(wavy)
    with pytest.raises(sf.SceneError, match="give F >= 0 and k > 0"):
        sf.scenes.wavy_belt(v_b=0.3, F=1.0, k=0.0)
    with pytest.raises(sf.SceneError, match="a belt that moves"):
        waviness.drag(wavy.where({"v_b": 0.0}))
