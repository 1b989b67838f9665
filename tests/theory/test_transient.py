"""The exact stop against the motion itself and the event-driven solver; the averaged decay against integration."""

import math
from fractions import Fraction

import mpmath
import numpy as np
import pytest
import sympy as sp
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy import integrate, special

import symfric as sf
from symfric.theory import transient
from symfric.theory.transient.stop import _simplest

POSITIVE = st.fractions(min_value=Fraction(1, 1000), max_value=10, max_denominator=1000)
G = 9.81
UNHURRIED = settings(max_examples=40, deadline=None)


def walk(delta, delta_s, x0):
    """Half cycles and rest, one turning point after the other, in exact numbers."""
    n, x = 0, x0
    while abs(x) > delta_s:
        n, x = n + 1, -x + (2 * delta if x > 0 else -2 * delta)
    return n, x


def turning_point(f_n, mu_m, halves):
    """Size of x after some half cycles."""
    return abs(decay(f_n, mu_m, halves=halves)[2])


def decay(f_n, mu_m, *, zeta=0.0, x0=0.01, v0=0.0, halves=10**6):
    """Time, half cycles and x at rest of x'' + 2 zeta w x' + w^2 x = -sgn(x') mu_m g exp(-|x'|), by DOP853."""
    omega, t, n, x = 2 * np.pi * f_n, 0.0, 0, x0
    delta = mu_m * G / omega**2

    def turn(_t, y, _side):
        return y[1]

    turn.terminal = True
    velocity = v0
    while n < halves and (velocity != 0 or abs(x) > delta):
        side = np.sign(velocity) if velocity != 0 else -np.sign(x)
        turn.direction = -side

        def rhs(_t, y, side):
            friction = side * mu_m * G * np.exp(-abs(y[1]))
            return y[1], -2 * zeta * omega * y[1] - omega**2 * y[0] - friction

        start = [x, velocity] if velocity != 0 else [x, 1e-14 * side]
        run = integrate.solve_ivp(rhs, (0, 2 / f_n), start, "DOP853", events=turn, args=(side,), rtol=1e-11, atol=1e-14)
        t, n, x, velocity = t + run.t_events[0][0], n + 1, run.y_events[0][0][0], 0.0
    return t, n, x


# --- The exact stop ----------------------------------------------------------------------------------------------


@UNHURRIED
@given(
    delta=POSITIVE,
    ratio=st.fractions(min_value=1, max_value=5, max_denominator=20),
    x0=st.fractions(-20, 20, max_denominator=100),
)
def test_half_cycles_and_rest_are_those_of_the_motion(delta, ratio, x0):
    n, x = walk(delta, ratio * delta, x0)
    assert transient.half_cycles(delta, ratio * delta, x0) == n
    assert transient.stop_position(delta, ratio * delta, x0) == x
    assert transient.stop_time(delta, ratio * delta, x0, Fraction(1, 3)) == pytest.approx(3 * math.pi * n, rel=1e-15)


@UNHURRIED
@given(delta=POSITIVE, ratio=st.fractions(min_value=1, max_value=5, max_denominator=20), n=st.integers(0, 200))
def test_a_turning_point_on_the_static_bound_is_a_stop(delta, ratio, n):
    x0 = ratio * delta + 2 * n * delta
    tiny = Fraction(1, 10**40)
    assert transient.half_cycles(delta, ratio * delta, x0) == n
    assert transient.half_cycles(delta, ratio * delta, x0 - tiny) == n
    assert transient.half_cycles(delta, ratio * delta, x0 + tiny) == n + 1


@UNHURRIED
@given(delta=POSITIVE, ratio=st.sampled_from([1, Fraction(3, 2), 2, Fraction(7, 3)]), n=st.integers(0, 50))
def test_floats_decide_ties_like_the_fractions_they_came_from(delta, ratio, n):
    static, x0 = ratio * delta, ratio * delta + 2 * n * delta
    assert transient.half_cycles(float(delta), float(static), float(x0)) == n
    assert transient.stop_position(float(delta), float(static), float(x0)) == float((-1) ** n * static)


@UNHURRIED
@given(p=st.integers(1, 10**7), q=st.integers(1, 10**7))
def test_the_simplest_fraction_gives_a_fraction_back(p, q):
    assert _simplest(p / q) == Fraction(p, q)
    assert _simplest(-p / q) == -Fraction(p, q)


@UNHURRIED
@given(x=st.floats(allow_nan=False, allow_infinity=False))
def test_the_simplest_fraction_rounds_to_the_float(x):
    found = _simplest(x)
    assert float(found) == x
    assert found.denominator <= Fraction(x).denominator


@pytest.mark.parametrize("n", range(1, 60))
def test_bits_of_the_float_would_make_a_half_cycle_more(n):
    delta = 1 / (2 * n + 1)
    assert transient.half_cycles(delta) == n
    assert transient.half_cycles(Fraction(delta)) in (n, n + 1)
    assert transient.half_cycles(Fraction(1 / 3)) == 2  # what the rule for floats avoids


@pytest.mark.parametrize(
    ("delta", "n", "x"), [(0.03, 17, 0.02), (0.1, 5, 0.0), (1 / 3, 1, -1 / 3), (1.0, 0, 1.0), (2.0, 0, 1.0)]
)
def test_handbook_oscillator(delta, n, x):
    scene = sf.scenes.coulomb_oscillator(delta)
    for data in (delta, scene):
        assert transient.half_cycles(data) == n
        assert transient.stop_position(data) == x
        assert transient.stop_time(data) == pytest.approx(n * math.pi, rel=1e-15)


@pytest.mark.one_in(3)
@pytest.mark.parametrize(
    "data",
    [
        {"delta": 0.07},
        {"delta": 0.07, "delta_s": 0.16},
        {"delta": 0.07, "delta_s": 0.3, "x0": -2.0, "omega_n": 3.0},
        {"delta": 1 / 7, "delta_s": 3 / 7, "x0": 1.0},
        {"delta": 0.2, "delta_s": 0.5, "x0": -0.4},
    ],
)
def test_the_event_driven_solver_stops_there(data):
    scene = sf.scenes.coulomb_oscillator(**data)
    run = sf.simulate(scene, tolerance=1e-10).checked()
    assert (
        run.stats["events"]
        == transient.half_cycles(scene)
        == transient.half_cycles(data["delta"], data.get("delta_s"), data.get("x0", 1))
    )
    assert run.final[0] == pytest.approx(transient.stop_position(scene), abs=1e-8)
    assert run.outputs["stop_time"] == pytest.approx(transient.stop_time(scene), abs=1e-8)


def test_types_follow_the_numbers_given():
    assert transient.stop_position(Fraction(3, 100)) == Fraction(1, 50)
    assert isinstance(transient.stop_position(Fraction(3, 100)), Fraction)
    assert isinstance(transient.stop_position(sp.Rational(3, 100), x0=2), Fraction)
    assert type(transient.stop_position(0.03)) is float
    assert type(transient.stop_time(Fraction(3, 100))) is float
    assert type(transient.half_cycles(0.03)) is int
    root = sp.sqrt(2)
    assert transient.half_cycles(root / 3, x0=root) == 1
    assert transient.stop_position(root / 3, x0=root) == pytest.approx(-math.sqrt(2) / 3, rel=1e-15)


def test_formulas_give_the_numbers():
    values = dict(zip(transient.SYMBOLS, (sp.Rational(1, 10), sp.Rational(3, 10), -2, 4), strict=True))
    assert transient.half_cycles(symbolic=True).subs(values) == 9 == transient.half_cycles(0.1, 0.3, -2)
    assert transient.stop_position(symbolic=True).subs(values) == sp.Rational(1, 5)
    assert transient.stop_position(0.1, 0.3, -2) == 0.2
    assert transient.stop_time(symbolic=True).subs(values) == 9 * sp.pi / 4


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({}, "no delta"),
        ({"delta": -0.1}, "delta is -0.1"),
        ({"delta": 0.2, "delta_s": 0.1}, "delta_s is 0.1, below"),
        ({"delta": math.nan}, "delta is nan"),
        ({"delta": 0.1, "x0": "1"}, "x0 is '1'"),
        ({"delta": 0.1, "omega_n": 0}, "omega_n is 0"),
        ({"delta": sf.scenes.coulomb_oscillator(0.1), "x0": 2}, "scene.where"),
        ({"delta": sf.scenes.mass_on_belt(v_b=0.1)}, "coulomb_oscillator"),
        ({"delta": sf.scenes.coulomb_oscillator(0.1).starting({"u": 1.0})}, "from rest"),
    ],
)
def test_wrong_input_is_refused_by_name(arguments, message):
    with pytest.raises(sf.SceneError, match=message):
        transient.stop_time(**arguments)


def test_without_friction_it_never_stops_unless_it_rests():
    with pytest.raises(sf.NotFound, match="delta is 0"):
        transient.half_cycles(0)
    assert transient.half_cycles(0, 1, Fraction(1, 2)) == 0
    assert transient.stop_position(0, x0=0) == 0


# --- The averaged decay ------------------------------------------------------------------------------------------


@pytest.mark.parametrize("a", [0.0, 1e-8, 0.1, 1.0, 5.0, 20.0, 44.9, 45.1, 300.0, 1e4, 1e8])
def test_mean_friction_is_the_integral_at_every_size(a):
    with mpmath.workdps(30):
        knots = [mpmath.asin(min(1, k / max(a, 1))) for k in (0, 1, 3, 10, 30, 100)]
        knots = [*sorted(set(knots)), mpmath.pi / 2]
        exact = mpmath.quad(lambda p: mpmath.sin(p) * mpmath.exp(-a * mpmath.sin(p)), knots)
    assert transient.mean_friction(a) == pytest.approx(float(exact), rel=2e-14)


def test_mean_friction_is_the_struve_form_where_that_has_digits():
    a = np.linspace(0, 3, 31)
    struve = 1 + np.pi / 2 * (special.modstruve(1, a) - special.i1(a))
    np.testing.assert_allclose(transient.mean_friction(a), struve, rtol=1e-13)
    lost = 1 + np.pi / 2 * (special.modstruve(1, 50.0) - special.i1(50.0))
    assert abs(lost / transient.mean_friction(50.0) - 1) > 1
    formula = transient.mean_friction(symbolic=True).subs({"A": 2, transient.DAMPER.A: 2})
    number = formula.subs({transient.DAMPER.omega_n: 3, transient.DAMPER.v_c: 4}).evalf(20)
    assert transient.mean_friction(1.5) == pytest.approx(float(number), rel=1e-14)


@pytest.mark.one_in(2)
@pytest.mark.parametrize(
    ("f_n", "mu_m", "t", "n"),
    [
        (3.5, 0.05, 0.71432458228639, 5),
        (3.5, 0.1, 0.42866708245224, 3),
        (5.0, 0.2, 0.30012385106254, 3),
        (10.0, 0.1, 1.3000278279274, 26),
        (20.0, 0.05, 6.7500063539546, 270),
    ],
)
def test_averaged_decay_time_is_within_half_of_a_half_cycle_of_the_motion(f_n, mu_m, t, n):
    time, halves, _ = decay(f_n, mu_m)
    assert (time, halves) == (pytest.approx(t, rel=1e-9), n)
    assert abs(transient.averaged_decay_time(f_n, mu_m) - time) < 0.25 / f_n


@pytest.mark.parametrize(("zeta", "v0"), [(0.009, 0.0), (0.05, 0.0), (0.005, 0.4)])
def test_averaged_decay_time_with_damping_and_velocity(zeta, v0):
    time, _, _ = decay(8.0, 0.05, zeta=zeta, v0=v0)
    averaged = transient.averaged_decay_time(8.0, 0.05, zeta=zeta, v0=v0)
    assert abs(averaged - time) < 0.25 / 8.0


def test_averaged_amplitude_follows_the_turning_points_to_second_order():
    errors = []
    for halves, mu in ((5, 0.1), (10, 0.05), (20, 0.025)):
        x = turning_point(10.0, mu, halves)
        passed = transient.averaged_decay_time(10.0, mu) - transient.averaged_decay_time(10.0, mu, x0=x)
        errors.append(abs(passed * 20.0 / halves - 1))
    assert errors[0] < 1e-3
    assert np.log2(np.array(errors[:-1]) / errors[1:]) == pytest.approx(2.0, abs=0.2)


@UNHURRIED
@given(zeta=st.floats(1e-4, 0.2), f_n=st.floats(1, 50), x0=st.floats(1e-4, 0.1))
def test_averaged_decay_time_with_friction_that_does_not_fall(zeta, f_n, x0):
    omega, mu = 2 * np.pi * f_n, 0.1
    y = np.pi * zeta * omega**2 * x0 / (2 * mu * G)
    found = transient.averaged_decay_time(f_n, mu, zeta=zeta, x0=x0, v_c=1e12)
    assert found == pytest.approx(np.log1p(y) / (zeta * omega), rel=1e-9)


@pytest.mark.parametrize("x0", [1e-3, 1.0, 1e3])
def test_without_damping_only_the_velocity_counts(x0):
    slow, fast = (transient.averaged_decay_time(f, 0.1, x0=x0 / f) for f in (1.0, 7.0))
    assert slow == pytest.approx(fast, rel=1e-11)
    moving = transient.averaged_decay_time(7.0, 0.1, x0=0.0, v0=2 * np.pi * x0)
    assert moving == pytest.approx(fast, rel=1e-11)


def test_averaged_decay_time_of_the_formula():
    d = transient.DAMPER
    values = {d.omega_n: 2 * sp.pi * 10, d.mu_m: 0.1, d.zeta: 0.02, d.r: 1, d.x0: 0.01, d.v0: 0, d.g: 9.81, d.v_c: 1}
    integral = transient.averaged_decay_time(symbolic=True).subs(values)
    ((variable, low, high),) = integral.limits
    number = mpmath.quad(sp.lambdify(variable, integral.function, "mpmath"), [float(low), float(high)])
    assert transient.averaged_decay_time(10, 0.1, zeta=0.02) == pytest.approx(float(number), rel=1e-12)


@pytest.mark.parametrize(
    ("arguments", "error", "message"),
    [
        ({}, sf.SceneError, "no f_n"),
        ({"f_n": 1.0}, sf.SceneError, "no mu_m"),
        ({"f_n": -1.0, "mu_m": 0.1}, sf.SceneError, "f_n is -1"),
        ({"f_n": 1.0, "mu_m": 0.1, "zeta": -0.1}, sf.SceneError, "zeta is -0.1"),
        ({"f_n": 1.0, "mu_m": 0.1, "x0": math.inf}, sf.SceneError, "x0 is inf"),
        ({"f_n": 1.0, "mu_m": 0.0, "zeta": 0.1}, sf.NotFound, "without friction"),
        ({"f_n": 1e300, "mu_m": 0.1}, sf.NotFound, "too small at the start"),
    ],
)
def test_wrong_damper_is_refused_by_name(arguments, error, message):
    with pytest.raises(error, match=message):
        transient.averaged_decay_time(**arguments)


def test_no_start_needs_no_time():
    assert transient.averaged_decay_time(1.0, 0.1, x0=0.0) == 0.0
