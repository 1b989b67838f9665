"""Reduced structures against the full ones, within the errors that are said."""

import numpy as np
import pytest
import scipy.sparse as sps

import symfric as sf

st = sf.structures


def plate(n=14):
    """A membrane of springs, held at two edges, without symmetry."""
    one = st.chain(n).K
    K = sps.kron(one, sps.eye_array(n)) + 1.3 * sps.kron(sps.eye_array(n), one)
    M = sps.diags_array(1 + 0.3 * np.sin(np.arange(n * n)))
    return st.Structure(M, K, 0.01 * K)


FULL = {
    "beam": st.beam(60, load="follower"),
    "membrane": plate(),
    "free chain": st.chain(150, ends="free"),
}


@pytest.mark.parametrize("name", FULL)
@pytest.mark.parametrize("kept", [0, 1, 3])
def test_frequencies_are_within_the_error_that_is_said(name, kept):
    full = FULL[name]
    keep = [int(i) for i in np.linspace(5, full.n - 1, kept)]
    small = full.reduced(keep, modes=12)
    told = small.error
    exact = full.modes(told.frequency.size).frequency
    off = np.abs(told.frequency - exact) / np.where(exact > 0, exact, 1.0)
    rounding = np.where(
        exact > 0, 1e-9, 2 * np.sqrt(np.finfo(float).eps)
    )  # of a zero: the root of that of K, of norm 4
    assert np.all(off <= 1.5 * told.frequency_error + rounding)
    if kept:
        assert np.all(off >= 0.3 * told.frequency_error - rounding)  # nor is it a guess that says nothing


def test_static_response_to_loads_on_kept_rows_is_exact():
    full = plate()
    rng = np.random.default_rng(2)
    rows = rng.standard_normal((3, full.n))
    small = full.reduced(list(rows), modes=2)
    assert small.names[:4] == ("row1", "row2", "row3", "p1")
    for row in rows:
        q = np.linalg.solve(full.K.toarray(), row)
        y = np.linalg.solve(small.K.toarray(), small.row(row))
        assert small.expand(y) == pytest.approx(q, abs=1e-9 * np.max(np.abs(q)))


def test_kept_coordinates_are_the_rows_themselves():
    full = FULL["beam"]
    row = np.zeros(full.n)
    row[[3, 40]] = 1.0, -2.0
    small = full.reduced(["w30", row, {"w10": 0.5}], modes=4)
    y = np.arange(1.0, small.n + 1)
    q = small.expand(y)
    assert [q[full.names.index("w30")], row @ q, 0.5 * q[full.names.index("w10")]] == pytest.approx(y[:3], rel=1e-9)
    assert small.row(row) == pytest.approx(np.eye(small.n)[1], abs=1e-9)
    assert small.row("w30") == pytest.approx(np.eye(small.n)[0])


def test_all_modes_are_no_reduction():
    full = st.chain(20, damping=0.1)
    same = full.reduced(["x3"], modes=19)
    assert same.modes(20).frequency == pytest.approx(full.modes(20).frequency, rel=1e-10)
    assert same.error.worst < 1e-9


def test_rows_that_follow_from_others_are_left_out():
    small = st.chain(80).reduced(["x3", "x9", {"x3": 1, "x9": -1}, 2], modes=3)
    assert small.names == ("x3", "x9", "p1", "p2", "p3")


def test_copies_of_modes_with_held_rows_are_kept():
    one = st.chain(60)
    s = st.Structure(sps.block_diag([one.M] * 3), sps.block_diag([one.K] * 3))
    small = s.reduced([], modes=6)
    assert small.modes(6).frequency == pytest.approx(s.modes(6).frequency, rel=1e-9)


def test_diagonal_coordinates():
    small = FULL["beam"].reduced(["w60"], modes=6)
    found = small.diagonal()
    assert found.K.nnz == found.M.nnz == found.n
    tip = np.zeros(120)
    tip[118] = 1.0
    y = np.linspace(1, 2, found.n)
    assert found.row(tip) @ y == pytest.approx(found.expand(y)[118], rel=1e-10)
    a, b = (st.flutter(e, (0, 30), count=3).critical[0] for e in (small, found))
    assert a.mu == pytest.approx(b.mu, rel=1e-9)


def test_flutter_of_the_reduced_column_converges():
    full = FULL["beam"]
    exact = st.flutter(full, (0, 30), count=3).critical[0]
    apart = []
    for modes in (4, 8, 16):
        point = st.flutter(full.reduced(["w60", "r60"], modes=modes), (0, 30), count=3).critical[0]
        apart.append(abs(point.mu - exact.mu))
    assert apart[0] > 4 * apart[1] > 16 * apart[2]
    assert apart[2] < 1e-3


FAULTS = {
    "name": (lambda s: s.reduced(["tpi"]), "no degree of freedom 'tpi'"),
    "number": (lambda s: s.reduced([500]), "no degree of freedom 500"),
    "length": (lambda s: s.reduced([np.ones(3)]), "kept row 1 has 3 entries"),
    "modes": (
        lambda s: s.reduced([0], modes=500),
        "the number of modes with 1 rows held is 500; give a whole number from 0 to 149",
    ),
    "expand": (lambda s: s.reduced([0], modes=3).expand(np.ones(7)), "its first axis needs 4 entries"),
}


@pytest.mark.parametrize("fault", FAULTS)
def test_one_line_names_the_fault(fault):
    make, words = FAULTS[fault]
    with pytest.raises(sf.SceneError, match=words):
        make(FULL["free chain"])


@pytest.mark.parametrize("modes", [1, 4, 9])
def test_the_error_of_a_response_is_that_of_the_flexibilities(modes):
    """Against inverses of dense matrices on a fine grid: what is told is reached, and relative to the largest value."""
    full, rows = FULL["free chain"], ["x20", "x101"]
    small = full.reduced(rows, modes=modes)
    told, units = small.error, np.array([full.row(name) for name in rows])
    inside = np.array([small.row(name) for name in rows])

    def flexibility(s, at, omega):
        return np.sum(at * np.linalg.solve((s.K - omega**2 * s.M).toarray(), at.T).T, axis=1)

    pairs = [
        [flexibility(s, at, part * told.upto) for s, at in ((full, units), (small, inside))]
        for part in (0.31, 0.62, 0.97)
    ]
    exact, own = np.moveaxis(np.array(pairs), 1, 0)
    off = np.max(np.abs(exact - own), axis=0) / np.max(np.abs(exact), axis=0)
    assert told.response == pytest.approx(off, rel=1e-6)
    assert np.all(told.response > 1e-9)
