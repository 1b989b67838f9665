"""Onset, amplitudes and frequencies of one mass on a belt: closed form, linearisation, and simulated cycles."""

import numpy as np
import pytest
import sympy as sp
from scipy import optimize

import symfric as sf
from symfric.theory import belt
from symfric.theory.averaging import average
from symfric.theory.hopf import hopf
from symfric.theory.second_order import expansion
from symfric.theory.stability import stability

ETAS = (0.4, 0.2, 0.1)


def scene(eta, v_b, beta=None):
    """A belt with v_m = 1/2, mu_s = 0.4, gamma2 = 1, and v_b1 the same for every eta unless beta is given."""
    return sf.scenes.mass_on_belt(
        sf.laws.cubic(0.4, 0.4 - eta / 3, 0.5), v_b=v_b, beta=eta / 9 if beta is None else beta
    )


def observed_order(errors):
    """Order of the errors in eta, which halves from one to the next."""
    return np.log2(np.abs(errors[:-1]) / np.abs(errors[1:]))


def test_onset_speed_is_where_the_linearised_damping_vanishes():
    default = sf.scenes.mass_on_belt(v_b=0.2)
    value = belt.onset_speed(default)
    assert value == pytest.approx(0.44095855184409843, rel=1e-14)
    assert hopf(default, "v_b", (0.3, 0.6)).value == pytest.approx(value, rel=1e-12)
    assert stability(default.where({"v_b": value})).B[0, 0] == pytest.approx(0.0, abs=1e-15)


def test_formulas_agree_with_the_scene_s_own_force():
    default = sf.scenes.mass_on_belt(v_b=0.2)
    law = default.contacts[0].law
    h1, h2, h3 = belt.damping_polynomial(default)
    for u in (-0.1, 0.05, 0.15):
        h = 2 * 0.05 * u + law(u - 0.2) - law(-0.2)
        assert h1 * u + h2 * u**2 + h3 * u**3 == pytest.approx(h, rel=1e-13)
    assert belt.equilibrium_position(default) == pytest.approx(law(0.2), rel=1e-15)
    assert belt.damping_slope(default) == pytest.approx(h1, rel=1e-14)
    assert belt.friction_difference(default) == pytest.approx(1.5 * 0.15 / 0.5, rel=1e-14)
    assert belt.release_position(default) == pytest.approx(0.4 - 0.1 * 0.2, rel=1e-15)


@pytest.mark.one_in(2)
@pytest.mark.parametrize(("order", "expected"), [(1, 2), (2, 4)])
def test_pure_slip_amplitude_and_frequency_reach_their_order(reference, order, expected):
    amplitude, frequency = [], []
    for eta in ETAS:
        s = scene(eta, 0.42)
        half_range, period, _ = reference(eta, eta / 9, 0.42).pure_slip_cycle(belt.pure_slip_amplitude(s))
        amplitude.append(belt.pure_slip_amplitude(s, order) / half_range - 1)
        frequency.append(belt.pure_slip_frequency(s, order) * period / (2 * np.pi) - 1)
    assert observed_order(amplitude) == pytest.approx(expected, abs=0.1)
    assert observed_order(frequency) == pytest.approx(expected, abs=0.1)
    assert abs(amplitude[-1]) < (1e-3, 1e-6)[order - 1]


@pytest.mark.long(beside="test_second_order_joins_at_the_first_stick_speed")
@pytest.mark.parametrize(("order", "expected"), [(1, 2), (2, 4)])
def test_stick_speed_is_where_the_cycle_grazes_the_belt(reference, order, expected):
    errors = []
    for eta in ETAS:
        s = scene(eta, 0.3)

        def clearance(v, eta=eta, s=s):
            guess = 2 * np.sqrt(belt.onset_speed(s) ** 2 - v**2)
            return reference(eta, eta / 9, v).pure_slip_cycle(guess)[2] - v

        errors.append(belt.stick_speed(s, order) / optimize.brentq(clearance, 0.39, 0.41, xtol=1e-11) - 1)
    assert observed_order(errors) == pytest.approx(expected, abs=0.2)


def test_stick_slip_amplitude_gains_an_order(reference):
    first, second = [], []
    for eta in (0.05, 0.025, 0.0125):
        s = scene(eta, 0.2)
        half_range = reference(eta, eta / 9, 0.2).stick_slip_cycle()[0]
        first.append(belt.stick_slip_amplitude(s) / half_range - 1)
        second.append(belt.stick_slip_amplitude(s, order=2) / half_range - 1)
    assert observed_order(first) == pytest.approx(1, abs=0.1)
    assert observed_order(second) == pytest.approx(2, abs=0.1)
    assert abs(second[0]) < 5e-4


def test_stick_slip_against_known_cycles(reference):
    half_range, period, stick = reference(0.45, 0.05, 0.2).stick_slip_cycle()
    assert (half_range, period, stick) == pytest.approx(
        (0.286208719045775, 6.7994214444721576, 1.629558444940024), rel=1e-10
    )
    default = sf.scenes.mass_on_belt(v_b=0.2)
    assert belt.stick_slip_amplitude(default, order=2) == pytest.approx(half_range, rel=0.02)
    assert belt.stick_slip_frequency(default, order=2) == pytest.approx(2 * np.pi / period, rel=0.005)
    assert belt.stick_slip_frequency(default) == pytest.approx(2 * np.pi / period, rel=0.08)


def test_stick_slip_frequency_improves_with_order(reference):
    for eta in (0.2, 0.05):
        s = scene(eta, 0.2)
        exact = 2 * np.pi / reference(eta, eta / 9, 0.2).stick_slip_cycle()[1]
        errors = [abs(belt.stick_slip_frequency(s, order) / exact - 1) for order in (1, 2)]
        assert errors[1] < 0.1 * errors[0]


def test_slip_arc_starts_at_the_release_with_the_belt_s_velocity():
    default = sf.scenes.mass_on_belt(v_b=0.2)
    amplitude, phase = belt.slip_arc(default)
    position = belt.equilibrium_position(default) + amplitude * np.sin(phase)
    assert position == pytest.approx(belt.release_position(default), rel=1e-14)
    assert amplitude * np.cos(phase) == pytest.approx(0.2, rel=1e-14)
    assert amplitude == pytest.approx(belt.stick_slip_amplitude(default), rel=1e-14)


def test_second_order_joins_at_the_first_stick_speed():
    s = scene(0.1, 0.3)
    edge = belt.stick_speed(s)
    near = s.where({"v_b": edge * (1 - 1e-9)})
    assert belt.stick_slip_amplitude(near, order=2) == pytest.approx(edge, rel=1e-7)
    assert belt.largest_pure_slip_amplitude(s) == pytest.approx(edge, rel=1e-15)
    slow = s.where({"v_b": 1e-6})
    assert belt.stick_slip_amplitude(slow, order=2) == pytest.approx(belt.slow_belt_amplitude(slow, order=2), rel=1e-9)


def test_closed_forms_of_second_order_follow_from_the_expansion():
    A, x, y = sp.symbols("A v_b v_b1", positive=True)
    found = expansion(((0, 1), (0, 2), (0, 3)))
    eta, v_m = sp.symbols("eta v_m", positive=True)
    h = (-eta * (y**2 - x**2) / v_m**2, -eta * x / v_m**2, eta / (3 * v_m**2))
    put = dict(zip(found.coefficients, h, strict=True))
    f1, f2, f3 = (e.subs(put) for e in found.rates)
    first = 2 * sp.sqrt(y**2 - x**2)
    assert sp.simplify(f1.subs(A, first)) == 0
    assert f2 == 0
    shift = (-f3 / f1.diff(A)).subs(A, first)
    high, low = (found.position[k][2].subs(put).subs(A, first) for k in (0, 2))
    claimed = eta**2 * (y**2 - x**2) * (207 * x**2 + 17 * y**2) / (192 * v_m**4)
    assert sp.simplify((shift + (high - low) / 2) / first - claimed) == 0
    frequency = found.frequencies[1].subs(put).subs(A, first)
    assert sp.simplify(frequency + eta**2 * (y**2 - x**2) * (29 * x**2 + 3 * y**2) / (48 * v_m**4)) == 0
    # the largest velocity A0 (1 + d) meets v_b at sqrt(4/5) v_b1 (1 + d/5)
    fastest = (shift + found.velocity[3][2].subs(put).subs(A, first)) / first
    fastest = fastest.subs(x, sp.sqrt(sp.Rational(4, 5)) * y)
    assert sp.simplify(fastest / 5 - sp.Rational(3461, 120000) * eta**2 * y**4 / v_m**4) == 0


def test_order_two_average_equals_the_closed_form():
    s = scene(0.4, 0.42)
    flow = average(s, order=2)
    assert flow.amplitudes == pytest.approx([belt.pure_slip_amplitude(s, order=2)], rel=1e-12)
    assert flow.stable.tolist() == [True]


def test_symbolic_forms_take_the_scene_s_values():
    default = sf.scenes.mass_on_belt(v_b=0.42)
    law = {belt.SYMBOLS.mu_s: 0.4, belt.SYMBOLS.mu_m: 0.25, belt.SYMBOLS.v_m: 0.5}
    for question in (belt.onset_speed, belt.stick_speed, belt.pure_slip_amplitude, belt.equilibrium_position):
        formula = question(symbolic=True).subs(default.values).subs(law)
        assert float(formula) == pytest.approx(question(default), rel=1e-13)
    h1 = belt.damping_polynomial(symbolic=True)[0]
    assert sp.simplify(h1.subs(belt.SYMBOLS.v_b, belt.onset_speed(symbolic=True))) == 0


def test_law_is_recognised_by_its_formula():
    v = sf.SPEED
    law = sf.laws.custom(0.4 - 0.45 * v + 0.6 * v**3, 0.4)
    assert belt.onset_speed(sf.scenes.mass_on_belt(law, v_b=0.2)) == pytest.approx(0.44095855184409843, rel=1e-13)
    open_law = sf.laws.cubic(*sp.symbols("mu_s mu_m v_m", positive=True))
    s = sf.scenes.mass_on_belt(open_law, v_b=0.2).where({"mu_s": 0.4, "mu_m": 0.25, "v_m": 0.5})
    assert belt.onset_speed(s) == pytest.approx(0.44095855184409843, rel=1e-13)


@pytest.mark.parametrize(
    ("law", "message"),
    [
        (sf.laws.stribeck(0.4, 0.25, 0.3), "is not laws.cubic"),
        (sf.laws.coulomb(0.4, 0.3), "sticks up to 0.4"),
        (sf.laws.custom(0.4 - 0.4 * sf.SPEED + 0.3 * sf.SPEED**2, 0.4), "is not laws.cubic"),
        (sf.laws.custom(0.4 - 0.45 * sf.SPEED + 0.6 * sf.SPEED**3, 0.5), "sticks up to 0.5"),
    ],
)
def test_other_laws_are_refused(law, message):
    with pytest.raises(sf.SceneError, match=message):
        belt.onset_speed(sf.scenes.mass_on_belt(law, v_b=0.2))


def test_other_questions_without_an_answer():
    with pytest.raises(sf.SceneError, match="mass_on_belt"):
        belt.onset_speed(sf.scenes.coulomb_oscillator(0.1))
    with pytest.raises(sf.SceneError, match="no scene"):
        belt.onset_speed()
    with pytest.raises(sf.SceneError, match="order is 3"):
        belt.pure_slip_amplitude(scene(0.4, 0.42), order=3)
    with pytest.raises(sf.SceneError, match=r"v_b is -0\.2"):
        belt.onset_speed(sf.scenes.mass_on_belt(v_b=-0.2))
    with pytest.raises(sf.NotFound, match="stable at every belt speed"):
        belt.onset_speed(sf.scenes.mass_on_belt(v_b=0.2, beta=0.3))
    with pytest.raises(sf.NotFound, match="stable at every belt speed"):
        belt.onset_speed(sf.scenes.mass_on_belt(sf.laws.coulomb(0.4), v_b=0.2, beta=0.0))
    with pytest.raises(sf.NotFound, match="stick-slip"):
        belt.pure_slip_amplitude(scene(0.4, 0.2))
    with pytest.raises(sf.NotFound, match="steady sliding"):
        belt.pure_slip_amplitude(scene(0.4, 0.45))
    with pytest.raises(sf.NotFound, match="sticks below"):
        belt.stick_slip_amplitude(scene(0.4, 0.42))
