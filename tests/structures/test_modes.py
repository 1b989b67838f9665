"""Real and complex modes of large structures: closed forms, dense computations, copies and rigid bodies."""

import numpy as np
import pytest
import scipy.linalg as sla
import scipy.sparse as sps

import symfric as sf
from symfric.structures.factors import negative_pivots

st = sf.structures


def dense_squares(s, mu=0.0):
    return sla.eigvals(s.stiffness(mu).toarray(), s.M.toarray())


def upper(s, mu):
    """All eigenvalues in the upper half plane by a dense computation."""
    n, C = s.n, np.zeros((s.n, s.n)) if s.C is None else s.C.toarray()
    Z, one = np.zeros((n, n)), np.eye(n)
    left = np.block([[Z, one], [-s.stiffness(mu).toarray(), -C]])
    found = sla.eigvals(left, sla.block_diag(one, s.M.toarray()))
    return found[found.imag >= -1e-9 * np.abs(found)]


def distance(a, b):
    """Largest relative distance of the elements of either set from the other."""
    apart = np.abs(np.subtract.outer(a, b))
    return max(np.max(np.min(apart, axis=1) / np.abs(a)), np.max(np.min(apart, axis=0) / np.abs(b)))


def ring(n):
    """Equal masses in a ring: every frequency but two occurs twice, one motion is rigid."""
    K = sps.lil_array(sps.diags_array([np.full(n, 2.0), -np.ones(n - 1), -np.ones(n - 1)], offsets=[0, 1, -1]))
    K[0, n - 1] = K[n - 1, 0] = -1
    return st.Structure(sps.eye_array(n), K)


@pytest.mark.parametrize("n", [40, 300])
@pytest.mark.parametrize("near", [0.0, 0.7, 2.0])
def test_a_chain_in_closed_form(n, near):
    exact = 2 * np.sin(np.arange(1, n + 1) * np.pi / (2 * (n + 1)))
    exact = np.sort(exact[np.argsort(np.abs(exact - near), kind="stable")[:9]])
    s = st.chain(n)
    modes = s.modes(9, near=near)
    assert modes.frequency == pytest.approx(exact, rel=1e-11)
    assert modes.complete
    assert np.max(modes.residuals) < 1e-12
    assert modes.shapes.T @ s.M @ modes.shapes == pytest.approx(np.eye(9), abs=1e-10)
    assert s.complex_modes(9, near=near).frequency == pytest.approx(exact, rel=1e-9)


@pytest.mark.parametrize("near", [0.0, 0.5, 1.0])
def test_pairs_of_a_ring_are_all_there(near):
    n = 200
    exact = 2 * np.sin(np.arange(n) * np.pi / n)
    exact = np.sort(exact[np.argsort(np.abs(exact - near), kind="stable")[:9]])
    assert ring(n).modes(9, near=near).frequency == pytest.approx(exact, abs=1e-10)
    found = np.sort(ring(n).complex_modes(9, near=near).frequency)
    assert found == pytest.approx(exact, abs=1e-7 if near == 0 else 1e-10)


def test_three_equal_chains_have_every_mode_three_times():
    one = st.chain(70)
    s = st.Structure(sps.block_diag([one.M] * 3), sps.block_diag([one.K] * 3))
    exact = np.repeat(2 * np.sin(np.arange(1, 5) * np.pi / (2 * 71)), 3)
    assert s.modes(12).frequency == pytest.approx(exact, rel=1e-10)
    assert np.sort(s.complex_modes(12).frequency) == pytest.approx(exact, rel=1e-8)


def test_rigid_bodies():
    free = st.beam(60, left="free", right="free").modes(5)
    assert free.rigid == 2
    assert free.frequency[2:] == pytest.approx([22.3732854, 61.6728229, 120.9033916], rel=2e-6)
    two = sps.block_diag([st.chain(80, ends="free").K, st.chain(50, ends="free").K])
    s = st.Structure(sps.eye_array(130), two, 0.01 * two)
    assert s.modes(4).rigid == 2
    assert np.sum(s.complex_modes(4).eigenvalues == 0) == 2


@pytest.mark.one_in(4)
@pytest.mark.parametrize("near", [0.0, 0.4, 1.7])
@pytest.mark.parametrize("damped", [False, True])
def test_shift_and_invert_equals_a_dense_computation(near, damped):
    s, rng = st.chain(220), np.random.default_rng(5)
    F = 0.02 * sps.random_array((s.n, s.n), density=0.01, rng=rng)
    s = st.Structure(s.M, s.K, 1e-2 * s.K + 0.01 * s.M if damped else None, F)
    if damped:
        exact = upper(s, 0.3)
    else:
        exact = np.sqrt(-dense_squares(s, 0.3).astype(complex))
        exact = np.where(exact.imag < 0, -exact, exact)
    exact = exact[np.argsort(np.abs(exact - 1j * near))[:10]]
    found = s.complex_modes(10, mu=0.3, near=near)
    assert distance(found.eigenvalues, exact) < 1e-9
    assert np.max(found.residuals) < 1e-9


def test_thousands_of_states():
    n = 4000
    F = sps.lil_array((n, n))
    F[1000, 2000], F[2000, 1000], F[1000, 1000] = 0.3, -0.3, 0.2
    chain = st.chain(n, damping=0.02)
    found = st.Structure(chain.M, chain.K, chain.C, F).complex_modes(12, mu=0.1)
    assert np.max(found.residuals) < 1e-9
    assert found.eigenvalues.size == 12


def test_signs_of_pivots_count_eigenvalues():
    s = st.chain(150)
    exact = (2 * np.sin(np.arange(1, 151) * np.pi / 302)) ** 2
    for shift in (0.013, 0.8, 2.7, 3.99):
        assert negative_pivots(s.K - shift * s.M) == np.sum(exact < shift)


@pytest.mark.one_in(2)
@pytest.mark.parametrize("n", [8, 100])
def test_definiteness_where_it_decides(n):
    proved = st.chain(n, damping=0.1)
    assert proved.definiteness().definiteness == "stable"
    assert st.chain(n).definiteness().definiteness == "undecided"
    buckled = st.Structure(proved.M, proved.K - 0.5 * sps.eye_array(n), proved.C)
    assert buckled.definiteness().definiteness == "unstable"
    F = sps.diags_array([np.ones(n - 1), -np.ones(n - 1)], offsets=[1, -1])
    heavy = st.Structure(proved.M, proved.K + sps.eye_array(n), proved.C + 0.3 * sps.eye_array(n), F)
    words = {heavy.definiteness(mu).definiteness for mu in (0.01, 0.1)}
    assert words == {"stable"}
    for mu in np.linspace(0.05, 1.0, 8):  # never proved where a mode grows
        if heavy.definiteness(mu).definiteness == "stable":
            assert np.max(upper(heavy, mu).real) < 0
    assert heavy.definiteness(1.0).definiteness == "undecided"


CIRCULATORY = [[0.0, 1.0], [-1.0, 0.0]]


def test_no_stability_is_proved_without_damping_or_with_a_driving_one():
    """Large damping of the wrong sign outweighs circulatory forces in size alone."""
    K = np.diag([4.0, 5.0])
    driven, undamped, damped = (
        st.Structure(np.eye(2), K, c, CIRCULATORY) for c in (-3 * np.eye(2), None, 3 * np.eye(2))
    )
    assert driven.definiteness(0.1).definiteness == undamped.definiteness(0.1).definiteness == "undecided"
    assert np.max(upper(driven, 0.1).real) > 0
    assert damped.definiteness(0.1).definiteness == "stable"
