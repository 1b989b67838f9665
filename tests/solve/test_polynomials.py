"""First roots and ranges of polynomials on [0, 1] against NumPy's companion matrices and closed forms."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.polynomial import Polynomial

from symfric.codegen.array_table import VECTOR
from symfric.solve.loop.events.bernstein import DEPTH, bernstein_columns, bernstein_table
from symfric.solve.loop.events.polynomials import (
    extend_range,
    first_crossing,
    polish,
    roots,
    value,
    value_and_slope,
)

ORDER = 30
TABLE, COLUMNS = bernstein_table(ORDER), bernstein_columns(ORDER, VECTOR)
derandomized = settings(derandomize=True, deadline=None, max_examples=150)
inside = st.floats(0.01, 0.99)


def padded(b):
    return np.concatenate([np.asarray(b, dtype=float), np.zeros(ORDER + 2 - len(b))])


def room():
    return np.zeros((DEPTH + 4, ORDER + 4)), np.zeros(ORDER + 2)


def all_roots(b, most=ORDER):
    stack, found = room()
    count = roots(padded(b), len(b) - 1, most, TABLE, stack, found)
    return found[:count].copy()


def crossing(b):
    stack, found = room()
    b, n = padded(b), len(b) - 1
    total, own = np.sum(np.abs(b[1:])), np.zeros(ORDER + 5)
    return first_crossing(b, n, 1.0, b[0], total, COLUMNS, TABLE, stack, found, own)


@pytest.mark.long(beside="test_polish_survives_a_vanishing_slope")
def test_a_guard_that_starts_at_zero_without_a_slope():
    assert crossing([0.0, 0.0, 1.0, -0.5]) == 2.0
    assert crossing([0.0, 0.0, -1.0, 0.5]) == pytest.approx(0.0, abs=1e-15)


def span(b, low=math.inf, high=-math.inf):
    stack, found = room()
    return extend_range(padded(b), len(b) - 1, low, high, TABLE, stack, found, np.zeros(ORDER + 2))


def with_roots(where, lead=1.0):
    return lead * Polynomial.fromroots(where).coef


def sampled_crossing(b, n=64):
    """The first sign change between n samples: what a plain event detector sees."""
    s = np.linspace(0, 1, n)
    below = np.flatnonzero(Polynomial(b)(s) < 0)
    return s[below[0]] if below.size else 2.0


def test_table_turns_powers_into_bernstein_coefficients():
    n, k = 7, 4
    s = np.linspace(0, 1, 11)
    bernstein = sum(TABLE[n, j, k] * math.comb(n, j) * s**j * (1 - s) ** (n - j) for j in range(n + 1))
    assert bernstein == pytest.approx(s**k, abs=1e-14)


@derandomized
@given(b=st.lists(st.floats(-5, 5), min_size=2, max_size=12), s=st.floats(1e-3, 1))
def test_values_and_slopes(b, s):
    truth = Polynomial(b)
    assert value(np.array(b), len(b) - 1, s) == pytest.approx(float(truth(s)), abs=1e-12)
    f, slope = value_and_slope(padded(b), len(b) - 1, s)
    assert f == pytest.approx(float(truth(s)), abs=1e-12)
    assert slope == pytest.approx(float(truth.deriv()(s)), abs=1e-10)


@pytest.mark.one_in(4)
@pytest.mark.parametrize("degree", [3, 8, 15, 24])
def test_sign_changes_of_random_polynomials_agree_with_numpy(degree):
    rng = np.random.default_rng(degree)
    compared = 0
    for _ in range(400):
        b = rng.normal(size=degree + 1)
        found = np.roots(b[::-1])
        real = np.sort(found.real[(abs(found.imag) < 1e-9) & (found.real > 0) & (found.real < 1)])
        near = np.min(np.abs(np.concatenate([[1.0], np.abs(found - 0.0), np.abs(found - 1.0)])))
        gaps = np.diff(real)
        if near < 1e-6 or np.any(gaps < 1e-5) or np.any((abs(found.imag) > 1e-12) & (abs(found.imag) < 1e-5)):
            continue  # companion matrices lose these; they have tests of their own
        mine = all_roots(b)
        assert mine == pytest.approx(real, abs=1e-9)
        compared += real.size
    assert compared > 50


@derandomized
@given(where=st.lists(inside, min_size=1, max_size=6, unique=True), lead=st.sampled_from([-3.0, 1.0, 1e-8, 1e8]))
def test_simple_roots_are_found_to_rounding(where, lead):
    where = np.sort(where)
    if np.any(np.diff(where) < 1e-3):
        where = where[:1]
    b = with_roots(where, lead)
    slope = np.abs(Polynomial(b).deriv()(where))
    rounding = 1e-15 * np.sum(np.abs(b)) * len(b)
    mine = all_roots(b)
    assert mine.size == where.size
    assert np.all(np.abs(mine - where) <= 10 * rounding / slope + 1e-15)


@derandomized
@given(where=inside, others=st.lists(st.floats(1.05, 4) | st.floats(-4, -0.05), max_size=5))
def test_first_crossing_of_a_falling_guard(where, others):
    b = with_roots([where, *others])
    if b[0] < 0:
        b = -b
    assert crossing(b) == pytest.approx(where, abs=1e-9)


@derandomized
@given(where=inside, depth=st.floats(1e-12, 1e-2))
def test_a_dip_is_found_however_shallow(where, depth):
    # (s - where)^2 - depth: below zero from where - sqrt(depth) on
    half = math.sqrt(depth)
    found = crossing([where**2 - depth, -2 * where, 1.0])
    if where - half <= 0:
        return
    assert found == pytest.approx(where - half, abs=1e-15 / half + 1e-15)


@derandomized
@given(where=inside, gap=st.floats(1e-12, 1e-2))
def test_a_near_miss_is_no_crossing(where, gap):
    assert crossing([where**2 + gap, -2 * where, 1.0]) == 2.0


@pytest.mark.parametrize("where", [0.25, 0.5, 0.3, 1 / 3, 0.7])
def test_a_double_root_is_either_no_crossing_or_in_its_place(where):
    found = crossing(with_roots([where, where]))
    assert found == 2.0 or found == pytest.approx(where, abs=1e-7)


@pytest.mark.parametrize("where", [0.1, 0.5, 1 / 3])
def test_a_triple_root_is_a_crossing(where):
    assert crossing(-with_roots([where] * 3)) == pytest.approx(where, abs=1e-4)


def test_the_first_of_many_roots_is_returned():
    rng = np.random.default_rng(3)
    for _ in range(100):
        where = np.sort(rng.uniform(0.02, 1, 7))
        if np.min(np.diff(where)) < 0.01:
            continue
        b = -with_roots(where)
        b = b if b[0] > 0 else -b
        assert crossing(b) == pytest.approx(where[0], abs=1e-8)
        assert all_roots(b, most=2) == pytest.approx(where[:2], abs=1e-8)


def test_ends_of_the_interval():
    assert crossing([1.0, -1.0]) == 2.0  # zero at the end counts as positive
    assert crossing([1.0, -1.0 - 1e-12]) == pytest.approx(1.0, abs=1e-11)
    assert crossing([0.0, 1.0]) == 2.0  # starts at zero and rises
    assert crossing([0.0, 1.0, -2.0]) == pytest.approx(0.5, abs=1e-15)
    assert crossing([1.0, 0.0]) == 2.0


@derandomized
@given(lo=st.floats(0, 0.4), hi=st.floats(0.6, 1), where=st.floats(0.41, 0.59))
def test_polish_stays_in_its_bracket_and_finds_the_last_bits(lo, hi, where):
    b = with_roots([where, 1.5, -0.7])
    f = Polynomial(b)
    found = polish(b, 3, lo, hi, float(f(lo)), float(f(hi)))
    assert found == pytest.approx(where, abs=4e-15)


def test_polish_survives_a_vanishing_slope():
    b = with_roots([0.5, 0.5, 0.5])
    assert polish(b, 3, 0.0, 1.0, b[0], 0.125) == pytest.approx(0.5, abs=1e-5)


@pytest.mark.long(beside="test_range_grows_only")
@derandomized
@given(b=st.lists(st.floats(-5, 5), min_size=2, max_size=10))
def test_range_contains_every_sample_and_is_attained(b):
    low, high = span(b)
    s = np.linspace(0, 1, 2001)
    f = Polynomial(b)(s)
    size = 1e-13 * (1 + np.sum(np.abs(b)))
    assert low <= f.min() + size
    assert high >= f.max() - size
    curve = np.sum(np.abs(Polynomial(b).deriv(2).coef)) / 2000**2 if len(b) > 2 else 0.0
    assert low >= f.min() - curve - size
    assert high <= f.max() + curve + size


def test_range_grows_only():
    assert span([0.0, 1.0], -3.0, 5.0) == (-3.0, 5.0)
    assert span([0.0, 4.0, -4.0], 0.0, 0.5) == (0.0, 1.0)


def decay(rate):
    """Series of exp(-rate s), of which the terms alternate and cancel."""
    return [(-rate) ** k / math.factorial(k) for k in range(ORDER + 1)]


@pytest.mark.parametrize("rate", [0.5, 3.0, 8.0])
def test_a_decaying_guard_crosses_in_its_place_or_not_at_all(rate):
    left = math.exp(-rate)
    for level in (0.25, 0.5, 0.9):
        b = decay(rate)
        b[0] -= left + level * (1 - left)
        assert crossing(b) == pytest.approx(-math.log(left + level * (1 - left)) / rate, abs=1e-13)
        b[0] += (1.0 + level) * (1 - left)  # stays above zero by a multiple of what is left
        assert crossing(b) == 2.0


def test_columns_are_those_of_the_highest_degree():
    assert np.array_equal(COLUMNS[:, : ORDER + 1], TABLE[ORDER].T)
    assert COLUMNS.shape[1] % VECTOR == 0
    assert np.all(COLUMNS[:, ORDER + 1 :] == 1.0)


def test_bare_sign_sampling_would_miss_the_graze():
    missed = 0
    rng = np.random.default_rng(7)
    for where in rng.uniform(0.05, 0.95, 200):
        b = [where**2 - 1e-6, -2 * where, 1.0]
        assert crossing(b) == pytest.approx(where - 1e-3, abs=1e-10)
        missed += sampled_crossing(b) == 2.0
    assert missed > 100


@pytest.mark.parametrize("beyond", [0.0, 1e-13, 1e-11, -1e-13])
def test_a_root_at_the_end_of_a_subdivision_does_not_hide_the_one_before_it(beyond):
    b = with_roots([0.01, 0.5 + beyond])  # the subdivision splits at 1/2
    assert crossing(b) == pytest.approx(0.01, abs=1e-12)
    assert all_roots(b) == pytest.approx([0.01, 0.5 + beyond], abs=1e-12)
