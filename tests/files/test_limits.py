"""Files from elsewhere: what they claim is checked before memory is taken, and what they are before they are opened."""

import io
import os
import stat
import zipfile

import numpy as np
import pytest
import scipy.io
import scipy.sparse as sps
from click.testing import CliRunner

import symfric as sf
from symfric.array_files import array_of
from symfric.cli import main
from symfric.files import open_regular, read_regular, write_new
from symfric.identification import tables
from symfric.identification.tables import read_table
from symfric.scenefile.places import read_places
from symfric.structures import archives, matrix_market, stored_arrays
from symfric.structures.matrix_market import market

K = np.array([[2.0, -1.0], [-1.0, 2.0]])
WHOLE = {"data": np.ones(2), "indices": np.array([0, 1]), "indptr": np.array([0, 1, 2]), "shape": np.array([2, 2])}
PAIRS = {"data": np.ones(2), "row": np.array([0, 1]), "col": np.array([0, 1]), "shape": np.array([2, 2])}
posix = pytest.mark.skipif(os.name != "posix", reason="pipes and devices of POSIX")

FAULTS = {
    "an index beyond the shape": {"indices": np.array([0, 50_000_000])},
    "an index at the shape": {"indices": np.array([0, 2])},
    "a negative index": {"indices": np.array([-1, 1])},
    "an index of 64 bits": {"indices": np.array([0, 2**63], np.uint64)},
    "indices that are no whole numbers": {"indices": np.array([0.0, 1.0])},
    "fewer indices than data": {"indices": np.array([0])},
    "more indices than data": {"indices": np.array([0, 1, 1])},
    "indptr beyond the data": {"indptr": np.array([0, 99_999_999, 2])},
    "indptr that decreases": {"indptr": np.array([0, 2, 1])},
    "indptr that begins later": {"indptr": np.array([1, 1, 2])},
    "indptr that ends before the data": {"indptr": np.array([0, 1, 1])},
    "indptr too short": {"indptr": np.array([0, 2])},
    "indptr empty": {"indptr": np.array([], int)},
    "indptr of another shape": {"shape": np.array([3, 3])},
    "a shape of one number": {"shape": np.int64(2)},
    "a shape of three": {"shape": np.array([2, 2, 2])},
    "a negative shape": {"shape": np.array([-2, 2])},
    "a shape that is not finite": {"shape": np.array([np.inf, 2])},
    "a huge shape": {"shape": np.array([10**12, 10**12])},
    "a table of data": {"data": np.ones((2, 1))},
    "data that are text": {"data": np.array(["a", "b"])},
    "an unknown format": {"format": np.array("bsr")},
    "a format that is a table": {"format": np.zeros((3, 3))},
}


def npz(place, **entries):
    np.savez(place, K=K, **{f"M_{name}": value for name, value in entries.items()})
    return place


def refused(place):
    with pytest.raises(sf.SceneError) as raised:
        sf.structures.read(place)
    assert str(raised.value).isprintable()
    return str(raised.value)


@pytest.mark.parametrize("kind", ["csr", "csc"])
@pytest.mark.parametrize("fault", FAULTS)
def test_sparse_parts_that_disagree_are_refused(fault, kind, tmp_path):
    place = npz(tmp_path / "m.npz", **{**WHOLE, "format": np.array(kind), **FAULTS[fault]})
    assert "M in m.npz" in refused(place)


@pytest.mark.parametrize("part", ["indices", "indptr", "shape"])
@pytest.mark.parametrize("number", [2**63, 2**64 - 1])
def test_numbers_beyond_whole_ones_are_told_as_they_stand(part, number, tmp_path):
    huge = np.array([0, number], np.uint64)
    assert f"{number}, which is too large" in refused(npz(tmp_path / "m.npz", **{**WHOLE, part: huge}))


@pytest.mark.parametrize("part", ["row", "col"])
@pytest.mark.parametrize("value", [[0, 2], [-1, 0], [0], [0.0, 1.0]])
def test_pairs_of_indices_are_checked(part, value, tmp_path):
    refused(npz(tmp_path / "m.npz", **{**PAIRS, part: np.array(value)}))


@pytest.mark.parametrize("kind", ["csr", "csc"])
def test_right_parts_are_read(kind, tmp_path):
    matrix = sps.random_array((7, 7), density=0.4, rng=np.random.default_rng(1), format="csr")
    matrix = (matrix + matrix.T + 8 * sps.eye_array(7)).asformat(kind)
    for order in (np.int32, np.int64, np.uint16, ">i4"):
        parts = {n: getattr(matrix, n) for n in ("data", "indices", "indptr")}
        parts = {n: e if n == "data" else e.astype(order) for n, e in parts.items()}
        place = tmp_path / "m.npz"
        np.savez(place, K=np.eye(7), **{f"M_{n}": e for n, e in parts.items()}, M_shape=[7, 7], M_format=kind)
        assert abs(sf.structures.read(place).M - matrix).max() < 1e-15
    unsorted = {**WHOLE, "data": np.ones(3), "indices": np.array([0, 0, 1]), "indptr": np.array([0, 2, 3])}
    assert sf.structures.read(npz(tmp_path / "twice.npz", **unsorted)).M.diagonal().tolist() == [2.0, 1.0]


def header(said, version=1):
    text = said.encode()
    return b"\x93NUMPY" + bytes([version, 0]) + len(text).to_bytes(2 if version == 1 else 4, "little") + text


@pytest.mark.parametrize("version", [1, 2, 3])
@pytest.mark.parametrize(
    "said",
    [
        "{'descr':'<f8','fortran_order':False,'shape':(1000000,1000000)}",
        "{'descr':'<f8','fortran_order':False,'shape':(-1,-1)}",
        "{'descr':'<f8','fortran_order':False,'shape':(2,2",
        "{'descr':'|O','fortran_order':False,'shape':(1,)}",
        "{'descr':[('t','|O')],'fortran_order':False,'shape':(1,)}",
        "{'descr':'<f3','fortran_order':False,'shape':(1,)}",
        "{'descr':'<f8','fortran_order':False,'shape':[1]}",
        "{'descr':'<f8','fortran_order':False}",
        "__import__('os').system('true')",
        "(" * 5000,
        "",
    ],
)
def test_headers_of_arrays_are_checked_before_memory_is_taken(said, version):
    with pytest.raises(sf.SceneError, match="m.npy"):
        array_of(header(said, version) + b"\0" * 8, "m.npy")


def test_arrays_are_those_of_numpy():
    for given in (np.arange(6.0).reshape(2, 3), np.asfortranarray(np.eye(3, 2)), np.array(["a", "bc"]), np.int8(3)):
        stream = io.BytesIO()
        np.save(stream, given)
        assert np.array_equal(array_of(stream.getvalue(), "a"), given)
    stream = io.BytesIO()
    np.save(stream, np.array([{}], dtype=object))
    with pytest.raises(sf.SceneError, match="Python objects"):
        array_of(stream.getvalue(), "a")


def zipped(place, entries, mode=zipfile.ZIP_DEFLATED):
    with zipfile.ZipFile(place, "w", mode) as file:
        for name, data in entries:
            file.writestr(name, data)
    return place


def coordinate(n, entries, body="1 1 1\n"):
    return f"%%MatrixMarket matrix coordinate real general\n{n} {n} {entries}\n{body}"


UNIT = coordinate(2, 2, "1 1 1\n2 2 1\n")


def test_an_entry_that_nothing_refers_to_is_not_unpacked(tmp_path, monkeypatch):
    monkeypatch.setattr(archives, "MAX_FILE", 100_000)
    place = zipped(tmp_path / "m.zip", [("M.mtx", UNIT), ("K.mtx", UNIT), ("notes.txt", b"\0" * 10_000_000)])
    assert sf.structures.read(place).n == 2


@pytest.mark.parametrize("name", ["M.mtx", "M.mtx.gz", "names.txt"])
def test_what_unpacks_to_more_than_allowed_is_refused(name, tmp_path, monkeypatch):
    for module in (archives, matrix_market):
        monkeypatch.setattr(module, "MAX_FILE", 1 << 20)
    monkeypatch.setattr(archives.content, "__defaults__", (1 << 20,))
    import gzip

    bomb = b" " * (3 << 20)
    data = gzip.compress(bomb) if name.endswith(".gz") else bomb
    entries = {"M.mtx": UNIT, "K.mtx": UNIT, name: data}
    if name == "M.mtx.gz":
        del entries["M.mtx"]
    assert "larger than 1 MiB" in refused(zipped(tmp_path / "m.zip", entries.items()))


@pytest.mark.parametrize(
    "text",
    [
        coordinate(10**9, 1),
        coordinate(2, 9 * 10**12),
        coordinate(2, 40_000_000),
        coordinate("9" * 30, 1),
        "%%MatrixMarket matrix array real general\n200000 200000\n1\n",
        "%%MatrixMarket matrix array real general\n5000 5000\n1\n",
        "%%MatrixMarket matrix array real general\n2 2\n1\n0\n0\n1\n5\n6\n",
        "%%MatrixMarket matrix coordinate real general\n-2 2 1\n1 1 1\n",
        coordinate(2, 1, "3 1 1\n"),
        coordinate(2, 1, "0 1 1\n"),
        coordinate(2, 1, "1.5 1 1\n"),
        coordinate(2, 1, "nan 1 1\n"),
        coordinate(2, 1, "1 1\n"),
        coordinate(2, 1, "1 1 1\n2 2 1\n"),
        "%%MatrixMarket matrix coordinate real symmetric\n2 3 1\n1 1 1\n",
        "%%MatrixMarket matrix coordinate complex general\n1 1 1\n1 1 1 1\n",
        "%%MatrixMarket vector coordinate real general\n2 1\n1 1\n",
        "",
    ],
)
def test_matrix_market_files_are_checked_before_they_are_read(text, tmp_path):
    refused(zipped(tmp_path / "m.zip", [("M.mtx", text), ("K.mtx", UNIT)]))


@pytest.mark.parametrize("seed", range(6))
@pytest.mark.parametrize("symmetry", ["general", "symmetric", "skew-symmetric"])
@pytest.mark.parametrize("form", ["coordinate", "array"])
def test_matrix_market_files_are_those_of_scipy(form, symmetry, seed):
    rnd = np.random.default_rng(seed)
    n = int(rnd.integers(1, 9))
    full = rnd.normal(size=(n, n)) * (rnd.random((n, n)) < 0.6)
    full = {"general": full, "symmetric": full + full.T, "skew-symmetric": full - full.T}[symmetry]
    stream = io.BytesIO()
    scipy.io.mmwrite(stream, sps.coo_array(full) if form == "coordinate" else full, precision=17, symmetry=symmetry)
    data = stream.getvalue().replace(b"\n", b"\r\n") if seed == 3 else stream.getvalue()
    found = market(data, "M.mtx")
    assert np.array_equal(found.toarray() if sps.issparse(found) else found, full)


def test_archives_with_several_of_one_name_links_and_other_folders_are_refused(tmp_path):
    right = [("M.mtx", UNIT), ("K.mtx", UNIT)]
    assert sf.structures.read(zipped(tmp_path / "a.zip", [("sub/" + n, d) for n, d in right])).n == 2
    assert "keep one" in refused(zipped(tmp_path / "b.zip", [*right, ("other/M.mtx", UNIT)]))
    assert "leaves it" in refused(zipped(tmp_path / "c.zip", [right[0], ("../K.mtx", UNIT)]))
    assert "leaves it" in refused(zipped(tmp_path / "d.zip", [right[0], ("/K.mtx", UNIT)]))
    assert "too deep" in refused(zipped(tmp_path / "e.zip", [right[0], ("a/" * 30 + "K.mtx", UNIT)]))
    link = zipfile.ZipInfo("K.mtx")
    link.external_attr = (stat.S_IFLNK | 0o777) << 16
    assert "as a link" in refused(zipped(tmp_path / "f.zip", [right[0], (link, "/etc/passwd")]))
    many = [(f"{k:0>200}", b"") for k in range(6000)]
    assert "too many" in refused(zipped(tmp_path / "g.zip", [*right, *many], zipfile.ZIP_STORED))


def test_the_numbers_of_entries_and_rows_are_limited(tmp_path, monkeypatch):
    monkeypatch.setattr(stored_arrays, "MAX_ROWS", 1)
    assert "at most 1 degrees" in refused(npz(tmp_path / "m.npz", **WHOLE))
    monkeypatch.setattr(stored_arrays, "MAX_ROWS", 2)
    monkeypatch.setattr(stored_arrays, "MAX_ENTRIES", 1)
    assert "at most 1 are read" in refused(npz(tmp_path / "m.npz", **WHOLE))


@posix
@pytest.mark.parametrize("what", ["pipe", "device", "folder", "socket"])
def test_what_is_no_regular_file_is_never_waited_for(what, tmp_path, monkeypatch):
    place = tmp_path / "r.csv"
    if what == "pipe":
        os.mkfifo(place)
    elif what == "device":
        place.symlink_to("/dev/zero")
    elif what == "folder":
        place.mkdir()
    else:
        import socket

        server = socket.socket(socket.AF_UNIX)
        monkeypatch.chdir(tmp_path)
        server.bind("r.csv")
        server.close()
    with pytest.raises(OSError, match="folder" if what == "folder" else "regular file"):
        open_regular(place)
    for read in (
        read_table,
        lambda p: read_places(p, ["a"], "scene.places"),
        lambda p: sf.motions.read_text(p, unit="g", dt=0.1),
        sf.motions.read_at2,
        sf.read,
    ):
        with pytest.raises(sf.SceneError, match="r.csv|regular|folder"):
            read(place)
    for name in ("m.npz", "m.zip"):
        (tmp_path / name).symlink_to(place)
        if what != "folder":
            refused(tmp_path / name)


def test_files_are_read_up_to_a_size(tmp_path, monkeypatch):
    place = tmp_path / "r.csv"
    place.write_bytes(b"t,x\n" + b"0,1\n" * 1000)
    monkeypatch.setattr(tables, "MAX_BYTES", 1000)
    with pytest.raises(sf.SceneError, match="larger than"):
        read_table(place)
    assert len(read_regular(place, 10)) > 10
    with pytest.raises(OSError, match="null"):
        open_regular("a\0b")


SECRETS = ("api_key,TOPSECRET-1234\nhunter2,password!\n", "TOPSECRET,hunter2\n1,2\n", "TOPSECRET\n", '"TOPSECRET\n')
IDENTIFY = """[scene]
coordinates = "x"
velocities = "u"
mass = "1.0"
force = "-k*x"
initial = { x = 0.1, u = 0.0 }
horizon = 3
[values]
k = 1.0
[friction]
law = "coulomb"
slip = "u"
normal = "1.0"
mu_s = 0.3
[identify]
record = "secret.txt"
[identify.unknowns]
k = [0.1, 2.0]
"""


@pytest.mark.parametrize("observed", ["", '[identify.observed]\ngauge = "x"\n'])
@pytest.mark.parametrize("text", SECRETS)
def test_messages_do_not_quote_a_record(text, observed, tmp_path):
    (tmp_path / "secret.txt").write_text(text)
    (tmp_path / "s.toml").write_text(IDENTIFY + observed)
    done = CliRunner().invoke(main, ["identify", str(tmp_path / "s.toml"), "-q", "-o", str(tmp_path / "out")])
    assert done.exit_code == 2
    assert not any(word in done.output for word in ("TOPSECRET", "hunter2", "password"))
    scene = sf.scenes.mass_on_belt(v_b=0.2)
    with pytest.raises(sf.SceneError) as raised:
        sf.identify(scene, tmp_path / "secret.txt", {"v_b": (0.1, 0.3)})
    assert not any(word in str(raised.value) for word in ("TOPSECRET", "hunter2", "password"))


def test_records_of_numpy_are_those_of_text(tmp_path):
    t, x = 0.1 * np.arange(20), np.sin(np.arange(20.0))
    np.save(tmp_path / "plain.npy", np.column_stack((t, x)))
    named = np.empty(20, [("time", "<f8"), ("x", "<f8")])
    named["time"], named["x"] = t, x
    np.save(tmp_path / "named.npy", named)
    for split in (",", ";", "\t", "  "):
        (tmp_path / "r.txt").write_text(f"t{split}x\n" + "".join(f"{a}{split}{b}\n" for a, b in zip(t, x, strict=True)))
        found = [read_table(tmp_path / name) for name in ("plain.npy", "named.npy", "r.txt")]
        for one, name in zip(found, ("c1", "x", "x"), strict=True):
            assert np.array_equal(one[name], (t, x))
    np.save(tmp_path / "objects.npy", np.array([[{}, {}]]), allow_pickle=True)
    with pytest.raises(sf.SceneError, match="Python objects"):
        read_table(tmp_path / "objects.npy")


def test_a_new_file_is_written_by_one_process(tmp_path):
    place = tmp_path / "a"
    assert write_new(place, b"first")
    assert not write_new(place, b"second")
    assert place.read_bytes() == b"first"
    assert list(tmp_path.iterdir()) == [place]
