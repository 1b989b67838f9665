"""Matrices with a fault: one line each that names it; and files."""

import zipfile

import numpy as np
import pytest
import scipy.io
import scipy.sparse as sps

import symfric as sf

st = sf.structures
M, K = np.diag([1.0, 2.0]), np.array([[2.0, -1.0], [-1.0, 2.0]])
HOLE = np.array([[1.0, np.nan], [np.nan, 1.0]])
FAULTS = {
    "not square": (lambda: st.Structure(np.ones((2, 3)), K), r"M has shape \(2, 3\); it must be square"),
    "sizes differ": (lambda: st.Structure(M, np.eye(3)), r"K has shape \(3, 3\), and M has \(2, 2\)"),
    "size of C": (lambda: st.Structure(M, K, np.eye(3)), "C has shape"),
    "size of friction": (lambda: st.Structure(M, K, None, np.eye(1)), "friction has shape"),
    "not finite": (lambda: st.Structure(M, HOLE), r"K has 2 entries that are not finite, the first at \(0, 1\)"),
    "infinite": (lambda: st.Structure(np.diag([np.inf, 1]), K), "M has 1 entries that are not finite"),
    "complex": (lambda: st.Structure(M, 1j * K), "K is complex"),
    "words": (lambda: st.Structure(M, [["a", "b"], ["c", "d"]]), "K is no matrix of numbers"),
    "ragged": (lambda: st.Structure(M, [[1.0, 2.0], [3.0]]), "K cannot be read"),
    "empty": (lambda: st.Structure(np.zeros((0, 0)), np.zeros((0, 0))), "M is empty"),
    "M not symmetric": (lambda: st.Structure([[1, 0.5], [0, 1]], K), r"M is not symmetric: its entries \(0, 1\)"),
    "K not symmetric": (lambda: st.Structure(M, [[2, -1], [0, 2]]), "K is not symmetric.*give .*as `friction`"),
    "no mass": (lambda: st.Structure(np.diag([1.0, 0.0]), K, names=["a", "b"]), "its diagonal entry of 'b'"),
    "negative mass": (lambda: st.Structure(np.diag([-1.0, 1.0]), K), "M is not positive definite"),
    "indefinite mass": (lambda: st.Structure([[1.0, 2.0], [2.0, 1.0]], K), "M is not positive definite"),
    "singular mass": (lambda: st.Structure([[1.0, 1.0], [1.0, 1.0]], K), "M is not positive definite"),
    "names": (lambda: st.Structure(M, K, names=["a"]), "1 names for 2"),
    "double names": (lambda: st.Structure(M, K, names=["a", "a"]), "two degrees of freedom are called 'a'"),
    "too many modes": (lambda: st.Structure(M, K).modes(3), "whole number from 1 to 2"),
    "no friction": (lambda: st.flutter(st.Structure(M, K), (0, 1)), "no friction matrix"),
    "mu without friction": (lambda: st.Structure(M, K).complex_modes(1, mu=0.3), "no friction matrix"),
    "friction left out": (lambda: st.Structure(M, K, friction=[[0, 1], [0, 0]]).scene(), "give mu"),
    "range": (lambda: st.flutter(st.ziegler(), (2, 1)), "give the lower end first"),
    "no range": (lambda: st.flutter(st.ziegler(), 1.0), "give two numbers, mu="),
    "row": (lambda: st.Structure(M, K).row([1.0]), "has 1 entries; the structure has 2"),
    "row name": (lambda: st.Structure(M, K, names=["tip", "root"]).row({"tpi": 1}), "did you mean tip"),
    "zero row": (lambda: st.Structure(M, K).row([0, 0]), "zero throughout"),
}


@pytest.mark.parametrize("fault", FAULTS)
def test_one_line_names_the_fault(fault):
    make, words = FAULTS[fault]
    with pytest.raises(sf.SceneError, match=words) as raised:
        make()
    assert "\n" not in str(raised.value)


def test_a_large_mass_matrix_with_a_fault_deep_inside():
    mass = sps.lil_array(sps.eye_array(500))
    mass[250, 251] = mass[251, 250] = 1.5
    with pytest.raises(sf.SceneError, match=r"M is not positive definite: .*'q25[12]'"):
        st.Structure(mass, sps.eye_array(500))


def test_digits_of_a_file_are_no_lack_of_symmetry():
    s = st.Structure(M, K + np.array([[0, 1e-9], [0, 0]]))
    assert abs(s.K - s.K.T).max() == 0


def same(a, b):
    return all(
        (x is None and y is None) or abs(x - y).max() == 0
        for x, y in ((getattr(a, n), getattr(b, n)) for n in ("M", "K", "C", "friction"))
    )


def test_files_give_back_what_was_written(tmp_path):
    s = st.beam(5, load="follower", damping=0.01)
    st.write(s, tmp_path / "beam.npz")
    again = st.read(tmp_path / "beam.npz")
    assert same(s, again)
    assert again.names == s.names
    folder = tmp_path / "market"
    folder.mkdir()
    for name in ("M", "K", "C", "friction"):
        scipy.io.mmwrite(folder / f"{name}.mtx", sps.coo_matrix(getattr(s, name)), precision=17)
    (folder / "names.txt").write_text("\n".join(s.names))
    assert same(s, st.read(folder))
    with zipfile.ZipFile(tmp_path / "all.zip", "w") as file:
        for part in folder.iterdir():
            file.write(part, f"export/{part.name}")
    assert same(s, st.read(tmp_path / "all.zip"))
    assert st.read(str(tmp_path / "all.zip")).names == s.names


def test_dense_and_coordinate_arrays_in_npz(tmp_path):
    coo = sps.coo_array(K)
    parts = {"K_data": coo.data, "K_row": coo.coords[0], "K_col": coo.coords[1], "K_shape": coo.shape}
    np.savez(tmp_path / "a.npz", M=M, **parts)
    assert same(st.read(tmp_path / "a.npz"), st.Structure(M, K))


FILES = {
    "missing": (lambda p: p / "none.npz", "there is no file or folder"),
    "no M": (lambda p: written(p, K=K), "holds no matrix M; it holds: K"),
    "text": (lambda p: text(p, "a.txt", "hello"), "neither .npz nor a folder or zip"),
    "no npz": (lambda p: text(p, "a.npz", "hello"), "cannot be read"),
    "no market": (lambda p: text(p, "M.mtx", "hello").parent, "M.mtx is no Matrix Market file"),
}


def written(folder, **arrays):
    np.savez(folder / "s.npz", **arrays)
    return folder / "s.npz"


def text(folder, name, words):
    (folder / name).write_text(words)
    return folder / name


@pytest.mark.parametrize("fault", FILES)
def test_files_with_a_fault(fault, tmp_path):
    make, words = FILES[fault]
    with pytest.raises(sf.SceneError, match=words) as raised:
        st.read(make(tmp_path))
    assert "\n" not in str(raised.value)


def test_a_friction_matrix_beside_contacts_is_logged(caplog):
    s = st.Structure(M, K, friction=[[0, 1], [0, 0]])
    pad = st.RowContact("pad", [1, 0], 1.0, sf.laws.coulomb(0.3), speed=0.1)
    s.scene([pad])
    assert "give mu to add it, or mu=0" in caplog.text
    caplog.clear()
    s.scene([pad], mu=0)
    s.scene([pad], mu=0.2)
    assert not caplog.text
