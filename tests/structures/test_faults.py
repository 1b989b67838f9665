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


CHAIN, LAW = st.chain(6), sf.laws.coulomb(0.4, 0.3)


def scene(row=None, **more):
    pad = st.RowContact("pad", {"x1": 1.0} if row is None else row, 1.0, LAW, speed=0.1)
    return CHAIN.scene([pad], **more)


CALLS = {
    "a velocity's name": (
        lambda: st.Structure(np.eye(2), K, names=["a", "d_a"]),
        "called 'd_a', as the velocity of 'a'",
    ),
    "no list of contacts": (lambda: CHAIN.scene(st.RowContact("pad", {"x1": 1.0}, 1.0, LAW)), "give a list, contacts="),
    "contacts None": (lambda: CHAIN.scene(None), "contacts is None; give a list"),
    "row too long": (lambda: scene(np.ones(7)), "the row of contact 'pad' has 7 entries; the structure has 6"),
    "row of two rows": (lambda: scene(np.ones((2, 3))), r"has shape \(2, 3\); give one row"),
    "row of nothing": (lambda: scene(np.zeros(6)), "is zero throughout"),
    "empty row": (lambda: scene({}), "is zero throughout"),
    "row not finite": (lambda: scene({"x1": np.nan}), "the weight of x1 .* is nan"),
    "force is a number": (lambda: scene(force=1.0), "force is 1.0; give a list"),
    "start of words": (lambda: scene(initial="rest"), "initial is 'rest'; give a mapping"),
    "start of another length": (lambda: scene(initial=np.ones(4)), "initial has 4 entries; give 6 coordinates, or 12"),
    "observe a list": (lambda: scene(observe=["tip"]), "give a mapping of names to rows"),
    "observe a velocity": (lambda: scene(observe={"d_x1": np.ones(6)}), "the name 'd_x1' in observe is taken"),
    "no modes": (lambda: CHAIN.modes(0), "give a whole number from 1 to 6"),
    "more modes than there are": (lambda: CHAIN.modes(7), "give a whole number from 1 to 6"),
    "near words": (lambda: CHAIN.complex_modes(2, near="a"), "near is 'a'; give a frequency"),
    "keep a number": (lambda: CHAIN.reduced(1.5), "keep is 1.5; give a list"),
    "keep nothing, no modes": (lambda: CHAIN.reduced([], modes=0), "with 0 rows held is 0; give a whole number from 1"),
    "half a mode": (lambda: CHAIN.reduced(["x1"], modes=1.5), "is 1.5; give a whole number from 0 to 5"),
    "too many modes": (lambda: CHAIN.reduced(["x1"], modes=6), "is 6; give a whole number from 0 to 5"),
    "keep a name that is none": (lambda: CHAIN.reduced(["y1"]), "no degree of freedom 'y1'"),
    "keep nothing of a row": (lambda: CHAIN.reduced([np.zeros(6)]), "kept row 1 is zero throughout"),
}


@pytest.mark.parametrize("fault", CALLS)
def test_calls_with_a_fault(fault):
    call, words = CALLS[fault]
    with pytest.raises(sf.SceneError, match=words) as raised:
        call()
    assert "\n" not in str(raised.value)


def test_edges_that_are_none():
    assert CHAIN.reduced(None, modes=3).n == CHAIN.reduced([], modes=3).n == 3
    assert CHAIN.reduced(["x1", "x1"], modes=0).n == 1
    assert CHAIN.reduced(CHAIN.names, modes=0).n == 6
    one = st.Structure(2.0, 8.0, names=["x"])
    assert one.modes(1).frequency == pytest.approx([2.0])
    assert [one.reduced(*how).K.sum() for how in ((["x"], 0), ([], 1))] == pytest.approx([8.0, 4.0])
    floor = st.RowContact("floor", "x", 1.0, sf.laws.coulomb(0.4))  # loses 0.1 in half a cycle, holds up to 0.05
    for route in ("exact", "taylor"):
        run = sf.simulate(one.scene([floor], initial=[0.93], horizon=20.0), 1e-13, route)
        assert run.final == pytest.approx([-0.03, 0.0], abs=1e-13)


def test_a_friction_matrix_beside_contacts():
    """Left out or added in silence only where it is clear: the loads of the contacts bring it, or they do not."""
    s = st.Structure(M, K, friction=[[0, 1], [0, 0]])
    law = sf.laws.coulomb(0.3)
    other = st.RowContact("pad", [1, 0], 1.0, law, speed=0.1)
    same = [st.RowContact("pad", [1, 0], st.RowLoad(1.0, [0, load]), law, speed=0.1) for load in (1.0, -1.0)]
    with pytest.warns(UserWarning, match="give mu to add it, or mu=0"):
        s.scene([other])
    with pytest.warns(UserWarning, match="it counts twice; leave mu out"):
        s.scene(same[:1], mu=0.2)
    for contacts, mu in (([other], 0), ([other], 0.2), (same[:1], None), (same[1:], None), (same[:1], 0)):
        s.scene(contacts, mu=mu)  # a warning would be an error here
    with pytest.raises(sf.SceneError, match="give mu .0: leave it out."):
        s.scene()
    brake = st.disc_and_pad()
    small = brake.structure.reduced([*brake.slips, *brake.loads], modes=5)
    small.scene(brake.contacts(0.01, law, 0.02))


def test_a_structure_tells_its_size():
    said = sf.structures.Structure(np.eye(3), np.diag([1.0, 2.0, 3.0]) - 0.1).to_dict()
    assert said == {"degrees_of_freedom": 3, "entries": {"M": 3, "K": 9, "C": 0, "friction": 0}}
