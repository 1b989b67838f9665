"""Losses of stability of random structures against a count of growing eigenvalues on a fine grid, refined by bisection."""

import numpy as np
import pytest
from stability_boundaries import KINDS, differences, random_structure

import symfric as sf

st = sf.structures
SPAN = (0.0, 1.5)


def check(seed, kind, n, points):
    s = random_structure(seed, n, kind)
    exact, wrong = differences(s, st.flutter(s, SPAN, count=n), *SPAN, points)
    assert not wrong
    return len(exact)


@pytest.mark.parametrize("kind", KINDS)
def test_no_loss_of_stability_is_missing_or_false(kind):
    assert sum(check(seed, kind, n, 60) for seed, n in ((0, 2), (1, 2), (2, 3), (3, 5))) > 0


@pytest.mark.long(beside="test_no_loss_of_stability_is_missing_or_false")
@pytest.mark.parametrize("seed", range(100, 600))
def test_no_loss_of_stability_is_missing_or_false_in_many(seed):
    n = int(np.random.default_rng(seed).integers(2, 11 if seed % 10 else 31))
    check(seed, KINDS[seed % len(KINDS)], n, 200 if n <= 10 else 100)


@pytest.mark.parametrize("unit", [1e-6, 1.0, 1e6])
def test_divergence_is_a_zero_of_the_determinant_in_any_unit_of_time(unit):
    K, F = np.diag([1.0, 3.0]), np.array([[-1.0, 0.3], [-0.2, 0.1]])
    s = st.Structure(np.eye(2), K / unit**2, 0.02 * np.eye(2) / unit, F / unit**2)
    (point,) = st.flutter(s, (0.0, 2.0), count=2).critical
    roots = np.roots([F[0, 0] * F[1, 1] - F[0, 1] * F[1, 0], 3 * F[0, 0] + F[1, 1], 3.0])
    assert point.mu == pytest.approx(np.min(roots[roots > 0]), rel=1e-12)
    assert (point.omega, point.kind) == (0.0, "divergence")


def test_points_at_the_ends_of_the_range_and_growth_before_it():
    s = st.Structure(np.eye(2), np.diag([1.0, 3.0]), 0.1 * np.eye(2), np.diag([-1.0, 0.0]))
    for span in ((0.0, 1.0), (1.0, 2.0)):
        (point,) = st.flutter(s, span, count=2).critical
        assert point.mu == pytest.approx(1.0, abs=1e-12)
    after = st.flutter(s, (1.5, 2.0), count=2)
    assert (after.critical, after.regained) == ((), ())
    assert np.max(after.eigenvalues[:, 0].real) > 0


def test_growth_of_a_structure_that_is_already_unstable_ends():
    s = st.Structure(np.eye(2), np.diag([-1.0, 3.0]), 0.1 * np.eye(2), np.diag([1.0, 0.0]))
    found = st.flutter(s, (0.0, 2.0), count=2)
    assert found.critical == ()
    (end,) = found.regained
    assert (end.mu, end.kind) == (pytest.approx(1.0, abs=1e-12), "divergence")


@pytest.mark.parametrize("damping", [0.0, 0.1])
def test_equal_frequencies_under_a_circulatory_force(damping):
    """``lambda^2 + c lambda + 1 +- i mu = 0``: a pair grows from ``mu = c`` on."""
    s = st.Structure(np.eye(2), np.eye(2), damping * np.eye(2), [[0.0, 1.0], [-1.0, 0.0]])
    (point,) = st.flutter(s, (0.0, 2.0), count=2).critical
    assert point.mu == pytest.approx(damping, abs=1e-10)
    assert (point.omega, point.kind) == (pytest.approx(1.0, abs=1e-6), "flutter")


@pytest.mark.parametrize("damped", [False, True])
def test_a_band_much_narrower_than_a_step(damped):
    eps = 1e-5
    s = st.Structure(np.eye(2), np.diag([1.0, 1.5]), 1e-8 * np.eye(2) if damped else None, [[1.0, eps], [-eps, 0.0]])
    found = st.flutter(s, (0.0, 1.01), count=2)
    assert found.critical[0].mu == pytest.approx(0.5 / (1 + 2 * eps), rel=1e-8)
    assert found.regained[0].mu == pytest.approx(0.5 / (1 - 2 * eps), rel=1e-8)
    assert len(found.critical) == len(found.regained) == 1


def test_an_undamped_part_beside_a_damped_one():
    F = np.array([[0.0, 0.5, 0.0], [-0.5, 0.0, 0.0], [0.0, 0.0, -1.0]])
    s = st.Structure(np.eye(3), np.diag([1.0, 1.5, 2.0]), np.diag([0.0, 0.0, 0.1]), F)
    found = st.flutter(s, (0.0, 3.0), count=3)
    assert [(p.kind, round(p.mu, 8)) for p in found.critical] == [("flutter", 0.5), ("divergence", 2.0)]
    assert found.regained == ()


@pytest.mark.parametrize("damping", [0.0, 0.1])
def test_divergence_of_a_body_that_can_move_as_a_whole(damping):
    K = np.array([[1.0, -1.0, 0.0], [-1.0, 2.0, -1.0], [0.0, -1.0, 1.0]])
    F = -np.array([[1.0, -1.0, 0.0], [-1.0, 1.0, 0.0], [0.0, 0.0, 0.0]])
    (point,) = st.flutter(st.Structure(np.eye(3), K, damping * K, F), (0.0, 3.0), count=3).critical
    assert (point.mu, point.kind) == (pytest.approx(1.0, abs=1e-9), "divergence")


def test_divergence_of_a_large_structure_whatever_modes_are_followed():
    chain = st.chain(90, damping=0.01)
    F = np.zeros((90, 90))
    F[44, 44] = -1.0
    s = st.Structure(chain.M, chain.K, chain.C, F)
    found = st.flutter(s, (0.0, 0.1), count=2, near=1.0, grid=2)
    (point,) = found.critical
    assert point.mu == pytest.approx(91 / (45 * 46), rel=1e-9)  # the flexibility of the chain at mass 45
    assert (point.kind, point.pair) == ("divergence", (-1, -1))
    assert np.argmax(np.abs(found.shapes[0])) == 44


def test_buckling_of_a_beam_with_more_rows_of_friction_than_one_block():
    s = st.beam(500, load="axial", left="pinned", right="pinned")
    found = st.flutter(s, (0.0, 50.0), count=3, grid=3).critical
    assert [p.mu for p in found] == pytest.approx([np.pi**2, 4 * np.pi**2], rel=1e-5)
    assert {p.kind for p in found} == {"divergence"}


def test_a_map_tells_the_first_loss_of_stability():
    make = lambda k: st.Structure(np.eye(2), np.diag([k, 3.0]), 0.02 * np.eye(2), np.diag([-1.0, 0.0]))  # noqa: E731
    found = st.flutter_map(make, [0.5, 1.0], (0.0, 2.0), count=2)
    assert found.mu == pytest.approx(found.values, rel=1e-10)
    assert found.omega.tolist() == [0.0, 0.0]


def test_damping_ratios_have_the_sign_of_the_decay():
    modes = st.Structure([[1.0]], [[4.0]], [[0.4]]).complex_modes(1)
    assert modes.damping == pytest.approx([0.1])  # c/(2 sqrt(k m))
    assert st.Structure([[1.0]], [[4.0]], [[-0.4]]).complex_modes(1).damping == pytest.approx([-0.1])
