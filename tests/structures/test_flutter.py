"""Onset of flutter against closed forms and published numbers."""

import matplotlib
import numpy as np
import pytest

import symfric as sf

st = sf.structures
BECK = 20.050953618974, 11.015557640923


def test_beck_is_approached_at_the_order_of_the_element():
    errors = []
    for elements in (4, 8, 16):
        (point,) = st.flutter(st.beam(elements, load="follower"), mu=(0, 30), count=3).critical
        errors.append([point.mu - BECK[0], point.omega - BECK[1]])
    orders = np.log2(np.array(errors)[:-1] / np.array(errors)[1:])
    assert orders == pytest.approx(np.full((2, 2), 4.0), abs=0.3)
    extrapolated = (16 * np.array(errors[2]) - np.array(errors[1])) / 15
    assert np.abs(extrapolated) == pytest.approx(0, abs=1e-4)


@pytest.mark.parametrize("length", [0.5, 3.0])
def test_beck_in_other_units(length):
    s = st.beam(12, length=length, EI=7.0, rhoA=0.4, load="follower")
    (point,) = st.flutter(s, mu=(0, 30 * 7 / length**2), count=3).critical
    assert point.mu * length**2 / 7 == pytest.approx(BECK[0], rel=1e-4)
    assert point.omega * length**2 * np.sqrt(0.4 / 7) == pytest.approx(BECK[1], rel=1e-4)


def test_a_column_under_an_axial_load_buckles():
    s = st.beam(16, load="axial", left="pinned", right="pinned")
    first = st.flutter(s, mu=(0, 15), count=3).critical[0]
    assert first.mu == pytest.approx(np.pi**2, rel=1e-5)
    assert first.omega == 0


def test_ziegler_without_damping():
    found = st.flutter(st.ziegler(), mu=(0, 3), count=2)
    (point,) = found.critical
    assert point.mu == pytest.approx(3.5 - np.sqrt(2), rel=1e-11)
    assert point.omega == pytest.approx(2**-0.25, rel=1e-6)
    mu, omega, pair = point
    assert (mu, omega, set(pair)) == (point.mu, point.omega, {0, 1})


@pytest.mark.parametrize("damping", [1e-4, 1e-2, 1.0])
def test_ziegler_with_damping_is_less_stable(damping):
    (point,) = st.flutter(st.ziegler(damping=damping), mu=(0, 3), count=2).critical
    assert point.mu == pytest.approx(41 / 28 + damping**2 / 2, rel=1e-8)


@pytest.mark.parametrize("damping", [0.0, 2e-4])
def test_flutter_between_two_points_of_the_grid(damping):
    eps = 0.002
    s = st.Structure(np.eye(2), np.diag([1.0, 1.5]), damping * np.eye(2), [[1.0, eps], [-eps, 0.0]])
    found = st.flutter(s, mu=(0, 1.01), count=2)
    # theta_1,2 = m +- sqrt(((mu - .5)/2)^2 - (eps mu)^2); with damping c the growth is sqrt of that over 2 omega, less c/2
    if not damping:
        assert found.critical[0].mu == pytest.approx(0.5 / (1 + 2 * eps), rel=1e-9)
        assert found.regained[0].mu == pytest.approx(0.5 / (1 - 2 * eps), rel=1e-9)
    else:
        assert 0.5 / (1 + 2 * eps) < found.critical[0].mu < 0.5 < found.regained[0].mu < 0.5 / (1 - 2 * eps)
        growth = max(s.complex_modes(2, mu=found.critical[0].mu).eigenvalues.real)
        assert growth == pytest.approx(0, abs=1e-12)


def test_modes_that_cross_are_followed_by_their_shapes():
    s = st.Structure(np.eye(3), np.diag([1.0, 1.5, 4.0]), None, np.diag([1.0, 0.0, -1.0]))
    found = st.flutter(s, mu=(0, 2.5), count=3)
    assert found.critical == ()
    squares = found.eigenvalues.imag**2
    assert squares[0] == pytest.approx(1 + found.mu, rel=1e-9)
    assert squares[1] == pytest.approx(np.full(found.mu.size, 1.5), rel=1e-9)
    assert squares[2] == pytest.approx(4 - found.mu, rel=1e-9)


def test_a_map_over_a_second_parameter():
    found = st.flutter_map(lambda c: st.ziegler(damping=c), [0.1, 0.5, 1.0], mu=(0.5, 3.0), count=2, name="c")
    assert found.mu == pytest.approx(41 / 28 + found.values**2 / 2, rel=1e-8)
    assert found.to_xarray()["mu"].sel(c=0.5) == pytest.approx(found.mu[1])


def test_pictures_show_the_numbers():
    matplotlib.use("Agg")
    found = st.flutter(st.ziegler(), mu=(0, 3), count=2)
    ax = found.plot()
    upper, lower = ax.figure.axes
    assert upper.lines[0].get_ydata() == pytest.approx(found.eigenvalues[0].imag)
    assert lower.lines[0].get_ydata() == pytest.approx(found.eigenvalues[0].real)
    modes = st.chain(30).modes(3)
    assert len(modes.plot().lines) == 3
    assert len(st.ziegler().complex_modes(2, mu=1.0).plot().lines) == 2
