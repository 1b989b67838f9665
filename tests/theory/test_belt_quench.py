"""Effective friction and quenching of one mass on a belt, against quadrature, linearisation and the full motion."""

import itertools

import numpy as np
import pytest
import sympy as sp
from scipy import integrate

import symfric as sf
from symfric.theory import belt
from symfric.theory.separation import separate
from symfric.theory.stability import stability


def shaken(q, v_b=0.2, **other):
    """The default belt under intensity q at Omega = 50."""
    return sf.scenes.mass_on_belt(v_b=v_b, a=q / 50, Omega=50.0, **other)


def mean(function, v, q):
    """Mean of a function of the relative velocity over one fast period, split where that vanishes."""
    split = [np.arccos(np.clip(v / q, -1, 1))]
    edges = [0.0, *split, np.pi]
    parts = [
        integrate.quad(lambda t: function(v - q * np.cos(t)), a, b, epsabs=1e-13)[0]
        for a, b in itertools.pairwise(edges)
    ]
    return sum(parts) / np.pi


@pytest.mark.parametrize("v", [0.05, 0.2, 0.29, 0.31, 0.6])
def test_effective_friction_is_the_mean(v):
    law = sf.laws.cubic(0.4, 0.25, 0.5)
    s = shaken(0.3, v)
    expected = mean(law, v, 0.3)
    assert belt.effective_friction(s)(v) == pytest.approx(expected, abs=1e-12)
    assert belt.quasi_equilibrium_position(s) == pytest.approx(expected, abs=1e-12)
    step = 1e-5
    slope = (mean(law, v + step, 0.3) - mean(law, v - step, 0.3)) / (2 * step)
    assert belt.effective_slope(s) == pytest.approx(slope, abs=1e-6)


def test_polynomial_of_the_effective_friction_at_rest():
    law, q = sf.laws.cubic(0.4, 0.25, 0.5), 0.3
    s = shaken(q)
    alpha0, alpha1, alpha3 = belt.law_coefficients(s)
    for w in (-0.3, 0.1, 0.7):
        assert alpha0 * np.sign(w) + alpha1 * w + alpha3 * w**3 == pytest.approx(law(w), rel=1e-13)
    errors = []
    for v in (0.08, 0.04, 0.02):
        errors.append(abs(mean(law, v, q) - belt.effective_damping(s) * v - belt.effective_cubic(s) * v**3))
    assert np.log2(errors[0] / errors[1]) == pytest.approx(5, abs=0.2)
    assert np.log2(errors[1] / errors[2]) == pytest.approx(5, abs=0.2)


def test_least_damping_intensity_is_a_minimum():
    best = belt.least_damping_intensity(shaken(0.3))
    at, below, above = (belt.effective_damping(shaken(q)) for q in (best, 0.999 * best, 1.001 * best))
    assert at < below
    assert at < above
    numbers = dict(zip(belt.SYMBOLS, (0.2, 0.05, 1.0, 1.0, 1.0, 0.4, 0.25, 0.5), strict=True))
    slope = belt.effective_damping(symbolic=True).diff(belt.SYMBOLS.a)  # Omega = 1, so a is the intensity
    assert float(slope.subs({**numbers, belt.SYMBOLS.a: best})) == pytest.approx(0, abs=1e-14)
    assert float(belt.least_damping_intensity(symbolic=True).subs(numbers)) == pytest.approx(best, rel=1e-14)


def vibrates(q, v):
    """Whether the slow scene's steady sliding is unstable."""
    return not stability(separate(shaken(q, v))).stable


@pytest.mark.parametrize("q", [0.1, 0.2, 0.3, 0.35])
def test_unstable_speeds_are_where_the_slow_scene_is_unstable(q):
    low, high = belt.unstable_speeds(shaken(q))
    assert low == pytest.approx(q, rel=1e-15)
    for v in (low * (1 + 1e-9), (low + high) / 2, high * (1 - 1e-9)):
        assert vibrates(q, v)
    for v in (0.3 * low, low * (1 - 1e-9), high * (1 + 1e-9), 2 * high):
        assert not vibrates(q, v)


def test_quench_intensities_are_the_least():
    s = sf.scenes.mass_on_belt(v_b=0.2)
    star = belt.quench_intensity(s)
    assert belt.unstable_speeds(shaken(star * (1 + 1e-12))) is None
    assert belt.unstable_speeds(shaken(star * (1 - 1e-12))) is not None
    assert belt.energy_ratio() == pytest.approx((star / belt.stick_speed(s)) ** 2, rel=1e-14)
    for v in (0.1, 0.3, 0.38, 0.43):
        q = belt.quench_intensity_at(s, v)
        assert vibrates(q * (1 - 1e-9), v)
        assert not vibrates(q * (1 + 1e-9), v)
        below = belt.quench_intensity_below(s, v)
        assert below == pytest.approx(min(v, star), rel=1e-15)
        speeds = np.linspace(0.01, v, 5)
        assert not any(vibrates(below * (1 + 1e-9), w) for w in speeds)
    assert belt.quench_intensity_at(s, 0.45) == 0.0
    assert belt.quench_intensity(sf.scenes.mass_on_belt(v_b=0.2, beta=0.3)) == 0.0


def test_excitation_free_range_is_the_paper_s():
    s = sf.scenes.mass_on_belt(v_b=0.2)
    assert belt.unstable_speeds(s) == pytest.approx((0.0, belt.onset_speed(s)), rel=1e-15)


def test_laws_that_fall_too_fast_are_refused():
    steep = sf.laws.cubic(0.4, 0.02, 0.5)  # mu_m/mu_s below 1 - sqrt(6)/pi
    s = sf.scenes.mass_on_belt(steep, v_b=0.2, beta=0.0, a=0.45 / 50, Omega=50.0)
    assert stability(separate(s.where({"v_b": 0.001}))).margin < 0
    for question in (belt.quench_intensity, belt.unstable_speeds):
        with pytest.raises(sf.SceneError, match="closed forms do not hold"):
            question(s)
    with pytest.raises(sf.SceneError, match="no excitation"):
        belt.effective_damping(sf.scenes.mass_on_belt(v_b=0.2))
    with pytest.raises(sf.SceneError, match="must be positive"):
        belt.quench_intensity_at(s, -1.0)
    with pytest.raises(sf.SceneError, match="no belt speed"):
        belt.quench_intensity_below(s)


@pytest.mark.parametrize("v", [0.1, 0.25, 0.31, 0.5])
def test_mean_power_is_the_mean_of_force_times_velocity(v):
    law, q = sf.laws.cubic(0.4, 0.25, 0.5), 0.3
    # x' = -q cos t, relative velocity x' - v
    edges = [0.0, np.arccos(np.clip(-v / q, -1, 1)), np.pi]
    power = (
        sum(
            integrate.quad(lambda t: -q * np.cos(t) * (-2 * 0.05 * q * np.cos(t) + law(-q * np.cos(t) - v)), a, b)[0]
            for a, b in itertools.pairwise(edges)
        )
        / np.pi
    )
    assert belt.mean_power(shaken(q, v)) == pytest.approx(power, abs=1e-12)


def test_symbolic_forms():
    v = belt.quench_intensity_at(symbolic=True)
    assert v.atoms(sp.Piecewise)
    assert belt.quench_intensity_below(symbolic=True).has(sp.Min)
    low, high = belt.unstable_speeds(symbolic=True)
    star = belt.quench_intensity(symbolic=True)
    meeting = (high**2 - low**2).subs(belt.SYMBOLS.a, star / belt.SYMBOLS.Omega)
    assert sp.simplify(meeting) == 0
