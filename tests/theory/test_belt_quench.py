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


@pytest.mark.one_in(4)
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
    assert belt.quench_intensity_at(s, 0.45) == 0.0
    assert belt.quench_intensity(sf.scenes.mass_on_belt(v_b=0.2, beta=0.3)) == 0.0


@pytest.mark.one_in(4)
@pytest.mark.parametrize("v", [0.1, 0.3, 0.38, 0.43])
def test_quench_intensities_of_a_speed_are_the_least(v):
    s = sf.scenes.mass_on_belt(v_b=0.2)
    q = belt.quench_intensity_at(s, v)
    assert vibrates(q * (1 - 1e-9), v)
    assert not vibrates(q * (1 + 1e-9), v)
    below = belt.quench_intensity_below(s, v)
    assert below == pytest.approx(min(v, belt.quench_intensity(s)), rel=1e-15)
    speeds = np.linspace(0.01, v, 5)
    assert not any(vibrates(below * (1 + 1e-9), w) for w in speeds)


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


@pytest.mark.parametrize("beta", [0.0, 0.05, 0.12])
@pytest.mark.parametrize("speeds", [(0.0, 0.2), (0.1, 0.5), (0.38, 0.5), (0.42, np.inf), (0.3, 0.3), (0.44, 0.9)])
def test_a_range_of_speeds_needs_the_most_that_one_of_them_needs(beta, speeds):
    scene = sf.scenes.mass_on_belt(sf.laws.cubic(0.45, 0.2, 0.5), v_b=0.3, beta=beta)
    v = np.linspace(speeds[0], min(speeds[1], 1.0), 400001)
    onset = 0.5 * np.sqrt(max(0.0, 1 - 2 * beta / (1.5 * 0.25 / 0.5)))
    single = np.minimum(v, np.sqrt(2 * np.maximum(onset**2 - v**2, 0.0)))  # above it (55) has no speed
    found = sf.theory.belt.quench_intensity_for(scene, speeds)
    assert found == pytest.approx(np.max(single), abs=1e-5)
    assert found >= np.max(single) - 1e-12


def test_the_range_of_the_source_and_its_special_cases():
    scene = sf.scenes.mass_on_belt(v_b=0.3)
    belt = sf.theory.belt
    assert belt.quench_intensity_for(scene, (0.38, 0.5)) == pytest.approx(0.3163683, abs=5e-8)
    assert belt.quench_intensity_for(scene, (0.0, 0.9)) == belt.quench_intensity(scene)
    for v in (0.1, 0.4, 0.43):
        assert belt.quench_intensity_for(scene, (v, v)) == pytest.approx(belt.quench_intensity_at(scene, v), rel=1e-14)
        assert belt.quench_intensity_for(scene, (0.0, v)) == pytest.approx(
            belt.quench_intensity_below(scene, v), rel=1e-14
        )
    design = sf.design.quench(scene, (0.38, 0.5), Omega=(40.0, 60.0), a=(0.0, 0.02))
    assert design.objective == pytest.approx(belt.quench_intensity_for(scene, (0.38, 0.5)), rel=1e-8)


@pytest.mark.parametrize(
    ("speeds", "message"), [((0.5, 0.4), "lower one comes first"), ((0, 0), "at rest"), (0.3, "give the lowest")]
)
def test_a_range_that_is_none(speeds, message):
    with pytest.raises(sf.SceneError, match=message):
        sf.theory.belt.quench_intensity_for(sf.scenes.mass_on_belt(v_b=0.3), speeds)


@pytest.mark.one_in(3)
@pytest.mark.parametrize(("v_b", "mu_m", "beta"), [(0.3, 0.25, 0.05), (0.25, 0.25, 0.02), (0.3, 0.35, 0.01)])
def test_cycles_that_enter_slow_slips_have_the_amplitude_of_the_full_motion(v_b, mu_m, beta):
    q, Omega = 0.2, 60.0
    law = sf.laws.cubic(0.4, mu_m, 0.5)
    scene = sf.scenes.mass_on_belt(law, v_b=v_b, beta=beta, a=q / Omega, Omega=Omega, horizon=100.0)
    found = sf.theory.belt.excited_amplitude(scene)
    assert found > v_b - q
    t = np.linspace(80.0, 100.0, 60001)
    slow = sf.simulate(scene)(t)[0] + q / Omega * np.sin(Omega * t)
    assert np.ptp(slow) / 2 == pytest.approx(found, rel=3e-3)


def test_cycles_outside_have_the_closed_form_and_stable_sliding_has_none():
    scene = sf.scenes.mass_on_belt(v_b=0.41, a=0.004, Omega=50.0)
    onset = sf.theory.belt.onset_speed(scene)
    assert sf.theory.belt.excited_amplitude(scene) == pytest.approx(2 * np.sqrt(onset**2 - 0.41**2 - 0.02), rel=1e-13)
    assert sf.theory.belt.excited_growth(scene, sf.theory.belt.excited_amplitude(scene)) == pytest.approx(0, abs=1e-15)
    for v in (0.15, 0.43):
        with pytest.raises(sf.NotFound, match="no self-excited vibration"):
            sf.theory.belt.excited_amplitude(scene.where({"v_b": v}))
    with pytest.raises(sf.SceneError, match="no excitation"):
        sf.theory.belt.excited_amplitude(sf.scenes.mass_on_belt(v_b=0.3))
