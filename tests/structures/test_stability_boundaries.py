"""Losses of stability of random structures against a count of growing eigenvalues on a fine grid, refined by bisection."""

import numpy as np
import pytest
import scipy.sparse as sps
from stability_boundaries import KINDS, apart, differences, large_structure, random_structure

import symfric as sf

st = sf.structures
SPAN = (0.0, 1.5)


def check(seed, kind, n, points):
    s = random_structure(seed, n, kind)
    exact, wrong = differences(s, st.flutter(s, SPAN, count=n), *SPAN, points)
    assert not wrong
    return len(exact)


@pytest.mark.one_in(8)
@pytest.mark.parametrize("kind", KINDS)
def test_no_loss_of_stability_is_missing_or_false(kind):
    assert sum(check(seed, kind, n, 60) for seed, n in ((0, 2), (1, 2), (2, 3), (3, 5))) > 0


@pytest.mark.long(beside="test_no_loss_of_stability_is_missing_or_false")
@pytest.mark.parametrize("seed", range(100, 600))
def test_no_loss_of_stability_is_missing_or_false_in_many(seed):
    n = int(np.random.default_rng(seed).integers(2, 11 if seed % 10 else 31))
    check(seed, KINDS[seed % len(KINDS)], n, 200 if n <= 10 else 100)


def check_large(seed, kind, n, points=60, grid=33):
    """Return the number of losses of stability that have to be found: those of modes that keep apart from the others."""
    s, draw = large_structure(seed, n, kind), np.random.default_rng([seed, 77])
    near = 0.0 if draw.random() < 0.4 else float(draw.uniform(5, 15))
    mus = np.linspace(0.0, 1.0, points)
    count, reach, gap = apart(s, near, mus)
    within = lambda mu, omega: gap > 0.02 and abs(omega - near) <= np.interp(mu, mus, reach) * (1 + 1e-6)  # noqa: E731
    found = st.flutter(s, (0.0, 1.0), count=count, near=near, grid=grid)
    exact, wrong = differences(s, found, 0.0, 1.0, points, known=within)
    assert wrong == []
    return len(exact)


@pytest.mark.one_in(2)
@pytest.mark.parametrize(("seed", "kind", "n"), [(5, "undamped", 61), (2, "damped", 61)])
def test_no_loss_of_stability_of_modes_followed_is_missing_or_false(seed, kind, n):
    """Of more degrees of freedom than those all of whose eigenvalues are searched."""
    assert check_large(seed, kind, n, 15, 9) > 0


@pytest.mark.long(beside="test_no_loss_of_stability_of_modes_followed_is_missing_or_false")
@pytest.mark.parametrize("seed", range(140))
def test_no_loss_of_stability_of_modes_followed_is_missing_or_false_in_many(seed):
    n = int(np.random.default_rng(seed).integers(61, 80 if seed % 10 else 151))
    check_large(seed, KINDS[seed % len(KINDS)], n)


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


@pytest.mark.one_in(2)
@pytest.mark.parametrize(("damping", "unit"), [(0.0, 1.0), (0.1, 1.0), (0.1, 1e5), (0.1, 1e-5)])
def test_divergence_of_a_body_that_can_move_as_a_whole(damping, unit):
    """Mu is a coefficient in any unit, such as a load."""
    K = np.array([[1.0, -1.0, 0.0], [-1.0, 2.0, -1.0], [0.0, -1.0, 1.0]])
    F = -np.array([[1.0, -1.0, 0.0], [-1.0, 1.0, 0.0], [0.0, 0.0, 0.0]]) / unit
    (point,) = st.flutter(st.Structure(np.eye(3), K, damping * K, F), (0.0, 3.0 * unit), count=3).critical
    assert (point.mu, point.kind) == (pytest.approx(unit, rel=1e-9), "divergence")


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


@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_divergence_at_an_end_of_a_range_about_zero_hides_no_other(sign):
    s = st.Structure(np.eye(2), np.diag([1.0, 3.0]), 0.1 * np.eye(2), sign * np.diag([1.0, -4.0]))
    found = st.flutter(s, (-1.0, 1.0), count=2)
    begins, ends = (found.critical, found.regained) if sign > 0 else (found.regained, found.critical)
    assert [p.mu for p in begins] == pytest.approx([0.75 * sign], abs=1e-9)
    assert [p.mu for p in ends] == pytest.approx([-sign], abs=1e-9)


def many(n, low, damping, pair):
    """Uncoupled masses, but for what is given of the first ones; more than all of whose eigenvalues are searched."""
    squares = np.concatenate([low, np.linspace(20.0, 60.0, n - len(low))])
    F = sps.lil_array((n, n))
    F[: len(pair), : len(pair)] = pair
    C = None if damping is None else sps.diags_array(np.concatenate([damping, np.full(n - len(damping), 0.1)]))
    return squares, C, sps.csr_array(F)


def test_a_mode_without_damping_in_a_large_damped_structure_neither_gains_nor_loses_stability():
    squares, C, F = many(70, [1.0, 1.5, 2.0], [0.0, 0.1, 0.1], [[0.0, 0.0, 0.0], [0.0, 0.0, 0.3], [0.0, -0.2, 0.0]])
    s = st.Structure(sps.eye_array(70), sps.diags_array(squares), C, F)
    found = st.flutter(s, (0.0, 0.5), count=3, near=1.0, grid=9)
    assert np.max(np.abs(found.eigenvalues.real[0])) < 1e-12
    assert (found.critical, found.regained) == ((), ())


@pytest.mark.long(beside="test_no_loss_of_stability_of_modes_followed_is_missing_or_false")
@pytest.mark.parametrize("unit", [1e-4, 1.0, 1e4])
def test_flutter_of_a_large_structure_beside_a_mode_that_takes_no_part_in_any_unit_of_time(unit):
    """``1 + mu`` and 1.5 merge at ``0.5/(1 + 2 eps)`` and part at ``0.5/(1 - 2 eps)``, at squares near to 1.5."""
    eps = 0.1
    squares, _, F = many(
        70, [1.0, 1.5, 1.25 + 73 / 352], None, [[1.0, eps], [-eps, 0.0]]
    )  # just before they merge their mean
    s = st.Structure(sps.eye_array(70), sps.diags_array(squares) / unit**2, None, F / unit**2)
    found = st.flutter(s, (0.0, 1.0), count=3, near=1.2 / unit, grid=12)
    assert [p.mu for p in found.critical] == pytest.approx([0.5 / (1 + 2 * eps)], rel=1e-8)
    assert [p.mu for p in found.regained] == pytest.approx([0.5 / (1 - 2 * eps)], rel=1e-8)
    for point in (*found.critical, *found.regained):
        assert (point.omega * unit) ** 2 == pytest.approx(0.5 * (1 + point.mu + 1.5), rel=1e-6)


@pytest.mark.parametrize("n", [3, 70])
def test_steps_over_which_shapes_turn_are_halved_within_the_range(n):
    squares, _, F = many(n, [1.0, 1.5, 4.0], None, [[1.0, 0.3, 0.0], [0.3, 0.0, 0.01], [0.0, 0.01, -1.0]])
    s = st.Structure(sps.eye_array(n), sps.diags_array(squares), None, F)
    found = st.flutter(s, (0.2, 2.0), count=3, near=1.0, grid=4)
    assert found.mu.size > 4
    assert found.mu[[0, -1]].tolist() == [0.2, 2.0]
    assert np.all(np.diff(found.mu) > 0)
    for k, mu in enumerate(found.mu):
        exact = np.sqrt(np.linalg.eigvals((s.K + mu * s.friction).toarray()).real)
        assert np.max(np.min(np.abs(found.eigenvalues[:, k].imag[:, None] - exact), axis=1)) < 1e-9


@pytest.mark.one_in(3)
@pytest.mark.parametrize(
    ("seed", "n", "span", "modes"),
    [
        (57, 62, (0.0, 0.03125), (20, 10.0)),  # the growing mode and the one it nearly merged with take turns
        (82, 74, (0.046875, 0.09375), (10, 11.0)),  # a mode passes one of a pair that grows already
        (52, 79, (0.59375, 0.65625), (20, 10.0)),  # a mode is taken for another one that begins to grow
    ],
)
def test_modes_taken_for_each_other_are_no_loss_of_stability(seed, n, span, modes):
    s, (count, near) = large_structure(seed, n, KINDS[seed % len(KINDS)]), modes
    exact, wrong = differences(s, st.flutter(s, span, count=count, near=near, grid=5), *span, 5)
    assert exact
    assert wrong == []
