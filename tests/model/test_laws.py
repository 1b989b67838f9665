"""Friction laws against the formulas of their sources, and effective laws against SciPy's quadrature."""

import itertools
import math
import pickle

import numpy as np
import pytest
import sympy as sp
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy import integrate

import symfric as sf

L = sf.laws
v = sf.SPEED
LAWS = {
    "coulomb": (L.coulomb(0.4, 0.3), lambda s: 0.3 + 0 * s, 0.4),
    "lorentz": (L.lorentz(0.3, 0.5, mu_s=0.4, b=0.02), lambda s: 0.3 / (1 + (s / 0.5) ** 2) + 0.02 * s, 0.4),
    "gauss": (L.gauss(0.3, 0.5, b=0.02), lambda s: 0.3 * np.exp(-((s / 0.5) ** 2)) + 0.02 * s, 0.3),
    "square root": (L.square_root(0.3, -0.1, mu_s=0.35, b=0.02), lambda s: 0.3 - 0.1 * np.sqrt(s) + 0.02 * s, 0.35),
    "stribeck": (L.stribeck(0.4, 0.25, 0.2, b=0.02), lambda s: 0.25 + 0.15 * np.exp(-s / 0.2) + 0.02 * s, 0.4),
    "cubic": (L.cubic(0.4, 0.25, 0.5), lambda s: 0.4 - 1.5 * 0.15 * (s / 0.5 - (s / 0.5) ** 3 / 3), 0.4),
    "exponential": (L.exponential(0.3, 1.5), lambda s: 0.3 * np.exp(-s / 1.5), 0.3),
    "piecewise": (
        L.piecewise_linear(0.4, [0, 0.2, 0.5], [0.35, 0.25, 0.3]),
        lambda s: np.where(s < 0.2, 0.35 - 0.5 * s, 0.25 + (s - 0.2) / 6),
        0.4,
    ),
    "piecewise, last slope": (
        L.piecewise_linear(0.4, [0, 0.2, 0.5], [0.35, 0.25, 0.3], last_slope=-0.1),
        lambda s: np.interp(s, [0, 0.2, 0.5], [0.35, 0.25, 0.3]) - 0.1 * np.maximum(0, s - 0.5),
        0.4,
    ),
    "one line": (L.piecewise_linear(0.4, [0], [0.35], last_slope=0.1), lambda s: 0.35 + 0.1 * s, 0.4),
    "custom": (L.custom(0.3 / (1 + v), 0.35), lambda s: 0.3 / (1 + s), 0.35),
}
speeds = np.concatenate([[1e-12, 1e-3], np.linspace(0.01, 3, 101), [50.0]])


@pytest.mark.parametrize("name", LAWS)
def test_law_is_the_formula_of_its_source(name):
    law, formula, static = LAWS[name]
    assert law(speeds) == pytest.approx(formula(speeds), rel=1e-14, abs=1e-15)
    assert float(law.stick) == static
    assert float(law.at_rest) == pytest.approx(float(formula(np.float64(0))), abs=1e-15)
    assert law.source
    assert not law.smooth


def test_a_law_is_shown_on_one_short_line():
    assert repr(L.coulomb(0.4, 0.3)) == "Law(kinetic=0.3, stick=0.4, source='handbook (19.104)')"
    assert "breaks=(0.2, 0.5)" in repr(L.piecewise_linear(0.4, [0, 0.2, 0.5], [0.35, 0.25, 0.3], last_slope=0))
    for law in (L.iwan(1.0, 0.0, 0.01, elements=40), L.maxwell_slip([10.0] * 30, [0.01] * 30)):
        assert "states=" in repr(law)
        assert len(repr(law)) < 160


@pytest.mark.parametrize("name", LAWS)
def test_evaluation_is_odd_and_zero_at_rest(name):
    law, _, _ = LAWS[name]
    assert np.array_equal(law(-speeds), -law(speeds))
    assert law(0) == law(0.0) == law(-0.0) == 0
    assert isinstance(law(0.3), float)
    assert law(speeds.reshape(2, -1)).shape == (2, speeds.size // 2)
    assert law([-1, 0, 1])[1] == 0


def test_cubic_law_has_its_minimum_where_it_says():
    law = L.cubic(0.4, 0.25, 0.5)
    slope = sp.lambdify(v, law.kinetic.diff(v))
    assert law(0.5) == pytest.approx(0.25, abs=1e-15)
    assert slope(0.5) == pytest.approx(0, abs=1e-14)
    assert slope(0) == pytest.approx(-1.5 * 0.15 / 0.5)


def test_symbols_of_a_law_are_filled_by_symbol_or_name():
    mu, alpha = sp.symbols("mu alpha", real=True)
    law = L.square_root(mu, alpha)
    assert law.free_symbols == {mu, alpha}
    full = law.where({mu: 0.3, "alpha": -0.1})
    assert full(0.25) == pytest.approx(0.25)
    assert law.free_symbols == {mu, alpha}


def test_laws_are_frozen_and_pickle():
    for law, _, _ in LAWS.values():
        again = pickle.loads(pickle.dumps(law))
        assert again == law
        assert np.array_equal(again(speeds), law(speeds))
        with pytest.raises(AttributeError):
            law.stick = 1


@pytest.mark.parametrize("v_s", [1e-2, 1e-4])
@pytest.mark.parametrize("name", LAWS)
def test_linear_regularisation_rises_to_the_static_coefficient_and_shifts_the_law(name, v_s):
    law, _, static = LAWS[name]
    smooth = law.regularised(v_s)
    edge = v_s if float(law.at_rest) == pytest.approx(static, abs=1e-15) else 2 * v_s
    assert smooth.smooth
    inside = np.linspace(0.01, 0.99, 9) * v_s
    assert smooth(inside) == pytest.approx(static * inside / v_s, rel=1e-12)
    assert smooth(edge + speeds) == pytest.approx(law(speeds), abs=1e-9)  # the difference rounds the speed 1e-12
    assert smooth(v_s) == pytest.approx(static, rel=1e-12)
    near = np.array([v_s, edge, *[edge + float(b) for b in law.breaks]])
    assert smooth(near * (1 - 1e-12)) == pytest.approx(smooth(near * (1 + 1e-12)), abs=1e-6)


def test_regularised_cubic_law_is_thomsen_6_shifted():
    v_s, s = 0.01, speeds[speeds > 0.011]
    expected = 0.4 - 0.225 * ((s - v_s) / 0.5 - ((s - v_s) / 0.5) ** 3 / 3)
    assert L.cubic(0.4, 0.25, 0.5).regularised(v_s)(s) == pytest.approx(expected, rel=1e-13)


def _closing_by_an_integrator(law, orbit):
    """Distance between start and end of an orbit of the belt with a smooth law, followed by a general integrator."""

    def field(_t, y):
        return y[1], -0.1 * y[1] - y[0] - law(y[1] - 0.2)

    run = integrate.solve_ivp(field, (0, orbit.period), orbit.start, "Radau", rtol=1e-9, atol=1e-11)
    return np.linalg.norm(run.y[:, -1] - orbit.start)


@pytest.mark.long(beside="test_regularised_cubic_law_is_thomsen_6_shifted")
@pytest.mark.parametrize("v_s", [0.01, 0.03])
def test_thomsen_6_is_another_law_than_the_moved_one(v_s):
    thomsen, moved = L.thomsen_regularised(0.4, 0.25, 0.5, v_s), L.cubic(0.4, 0.25, 0.5).regularised(v_s)
    fine = np.linspace(v_s, 0.7, 200001)
    assert fine[np.argmin(thomsen(fine))] == pytest.approx(0.5, abs=1e-5)
    assert fine[np.argmin(moved(fine))] == pytest.approx(0.5 + v_s, abs=1e-5)
    assert thomsen(0.5) == pytest.approx(0.25, rel=1e-13)
    assert moved(0.5 + v_s) == pytest.approx(0.25, rel=1e-13)
    assert thomsen.smooth
    assert thomsen.source == "Thomsen (6)"
    assert "Thomsen (6)" not in moved.source
    orbits = {law: sf.limit_cycle(sf.scenes.mass_on_belt(law, v_b=0.2)) for law in (thomsen, moved)}
    if v_s == 0.01:
        assert orbits[thomsen].period == pytest.approx(6.8110308, abs=1e-7)
        assert orbits[moved].period == pytest.approx(6.806459, abs=1e-6)
    for law, orbit in orbits.items():
        assert _closing_by_an_integrator(law, orbit) < 1e-6


@pytest.mark.parametrize("v_s", [0.0, -0.1, 0.5, 0.7])
def test_thomsen_6_needs_a_speed_below_that_of_the_minimum(v_s):
    with pytest.raises(sf.SceneError, match="must be above 0 and below v_m"):
        L.thomsen_regularised(0.4, 0.25, 0.5, v_s)


@pytest.mark.parametrize(("shape", "step"), [("arctan", lambda r: 2 / np.pi * np.arctan(r)), ("tanh", np.tanh)])
@pytest.mark.parametrize("name", LAWS)
def test_smooth_regularisations_multiply_the_law(name, shape, step):
    law, _, _ = LAWS[name]
    smooth = law.regularised(0.01, shape)
    assert smooth.smooth
    assert smooth(speeds) == pytest.approx(law(speeds) * step(speeds / 0.01), rel=1e-12, abs=1e-15)


def mean(formula, s, q, levels=(0.0,)):
    """<sgn(w) mu(|w|)>, w = s - q cos(theta), by adaptive quadrature split where w passes the levels."""
    split = sorted(math.acos((s - w) / q) for w in levels if abs(s - w) < q) or None
    f = lambda theta: np.sign(s - q * np.cos(theta)) * formula(abs(s - q * np.cos(theta)))  # noqa: E731
    return integrate.quad(f, 0, np.pi, points=split, limit=400, epsabs=1e-12, epsrel=1e-11)[0] / np.pi


@pytest.mark.one_in(6)
@pytest.mark.parametrize(
    ("name", "q"),
    [*((name, 0.3) for name in LAWS), *((name, q) for name in ("coulomb", "cubic", "stribeck") for q in (0.01, 1.0))],
)
def test_effective_law_agrees_with_quadrature(name, q):
    law, formula, _ = LAWS[name]
    averaged = law.averaged(q)
    s = q * np.array([0.03, 0.4, 0.9, 1.3, 2.0, 7.0])
    breaks = [float(b) for b in law.breaks]
    expected = [mean(formula, x, q, [0.0, *breaks, *(-b for b in breaks)]) for x in s]
    accuracy = 1e-7 if name == "square root" else 1e-9
    assert averaged(s) == pytest.approx(expected, abs=accuracy)
    assert averaged(-s) == pytest.approx(-averaged(s), abs=0)
    assert averaged.smooth


@pytest.mark.one_in(2)
@pytest.mark.parametrize("name", ["linear", "arctan", "tanh"])
def test_effective_law_of_a_regularised_law(name):
    law = L.stribeck(0.4, 0.25, 0.2).regularised(0.02, name)
    formula = lambda s: law(float(s))  # noqa: E731
    averaged = law.averaged(0.3)
    for s in (0.05, 0.2, 0.45):
        assert averaged(s) == pytest.approx(mean(formula, s, 0.3), abs=1e-5)


@pytest.mark.one_in(2)
@pytest.mark.parametrize(
    "law",
    [
        L.piecewise_linear(0.4, [0, 0.2, 0.4], [0.4, 0.25, 0.25], last_slope=0),
        L.piecewise_linear(0.4, [0, 0.2, 0.4], [0.4, 0.4, 0.4], last_slope=-0.1),
        L.piecewise_linear(0.4, [0, 0.2, 0.4], [0.4, 0.4, 0.4]),
        L.piecewise_linear(0.4, [0, 0.2], [0.4, 0.3], last_slope=0).regularised(0.05, "tanh"),
    ],
    ids=["flat at the end", "flat at first", "flat", "a product"],
)
def test_effective_law_where_branches_are_equal_or_multiplied(law):
    averaged = law.averaged(0.3)
    levels = [0.0, *map(float, law.breaks), *(-float(b) for b in law.breaks)]
    for s in (0.05, 0.25, 0.45, 0.9):
        assert averaged(s) == pytest.approx(mean(law, s, 0.3, levels), abs=1e-8)


def test_closed_forms_of_effective_laws():
    s = np.linspace(0.01, 0.29, 15)
    assert L.coulomb(0.4).averaged(0.3)(s) == pytest.approx(0.4 * 2 / np.pi * np.arcsin(s / 0.3), rel=1e-13)
    assert L.coulomb(0.4).averaged(0.3)(0.3 + s) == pytest.approx(0.4 + 0 * s, rel=1e-14)
    from scipy.special import i0

    above = 0.3 + s
    exponential = L.exponential(0.4, 0.8).averaged(0.3)
    assert exponential(above) == pytest.approx(0.4 * np.exp(-above / 0.8) * i0(0.3 / 0.8), rel=1e-13)
    from scipy.special import dawsn

    slope = 0.3 * (2 / (np.pi * 0.3) - 4 * dawsn(0.3 / 0.5) / (np.pi * 0.5))
    assert L.gauss(0.3, 0.5).averaged(0.3)(1e-6) / 1e-6 == pytest.approx(slope, rel=1e-6)


@pytest.mark.one_in(6)
@pytest.mark.parametrize("name", LAWS)
def test_without_vibration_the_law_is_itself(name):
    law, _, _ = LAWS[name]
    assert law.averaged(0) is law
    s = np.array([0.05, 0.1, 0.35, 1.0])
    assert law.averaged(1e-5)(s) == pytest.approx(law(s), abs=1e-9)  # the difference is mu'' q^2 / 4


@settings(derandomize=True, deadline=None, max_examples=15)
@given(q=st.floats(0.01, 2), s=st.floats(0, 3))
def test_effective_coefficient_never_exceeds_the_largest_one(q, s):
    averaged = L.cubic(0.4, 0.25, 0.5).averaged(sp.Float(q))
    highest = max(0.4, L.cubic(0.4, 0.25, 0.5)(s + q))
    assert -1e-12 <= averaged(s) <= highest + 1e-12


def test_effective_law_with_a_symbol_for_the_intensity():
    q = sp.Symbol("q", positive=True)
    law = L.cubic(0.4, 0.25, 0.5).averaged(q)
    assert law.free_symbols == {q}
    s = np.array([0.1, 0.29, 0.31, 1.0])
    assert law.where({q: 0.3})(s) == pytest.approx(L.cubic(0.4, 0.25, 0.5).averaged(0.3)(s), rel=1e-13)


def test_the_mean_of_a_mean_without_closed_form_is_refused():
    once = sf.laws.stribeck(0.4, 0.25, 0.2).averaged(0.3)
    with pytest.raises(sf.SceneError, match="average the law itself, once"):
        once.averaged(0.2)


@pytest.mark.parametrize("zero", [0, 0.0, sp.Float(0)])
def test_a_law_under_no_vibration_is_the_law_itself(zero):
    law = sf.laws.cubic(0.4, 0.25, 0.5)
    assert law.averaged(zero) is law


@pytest.mark.parametrize("power", range(1, 8))
def test_means_of_powers_of_the_speed(power):
    """(1/pi) integral of sign(w) |w|^n with w = s - q cos(theta), over half a period."""
    averaged = L.custom(sp.Rational(1, 10) + v**power, 0.2).averaged(0.5)

    def integrand(theta, s):
        w = s - 0.5 * math.cos(theta)
        return math.copysign(0.1 + abs(w) ** power, w) / math.pi

    for s in (0.1, 0.49, 0.7):
        ends = [0.0, *([math.acos(s / 0.5)] if s < 0.5 else []), math.pi]
        parts = [integrate.quad(integrand, *part, args=(s,), epsabs=1e-13)[0] for part in itertools.pairwise(ends)]
        assert averaged(s) == pytest.approx(sum(parts), abs=1e-9)
