"""Whatever a file holds, a command ends with 0, 1 or 2 and one line, and a reader raises errors of the package only."""

import io
import json
import shutil
import sys
import warnings
import zipfile
from pathlib import Path
from random import Random

import numpy as np
import pytest
from click.testing import CliRunner

import symfric as sf
from symfric.cli import main
from symfric.codegen import object_cache, shipped_loops
from symfric.codegen.loop_loader import sources
from symfric.ensemble.store import Store
from symfric.identification.records import read_channels
from symfric.scenefile.places import read_places
from symfric.scenefile.starters import starter
from tests.files.mutants import mutant, mutant_inside

EXAMPLES = Path(__file__).parents[2] / "examples"
MINE = sf.SceneError, sf.NotFound, sf.NoRoute, sf.RunFailed
M, K = np.diag([1.0, 2.0, 3.0]), np.array([[3.0, -1, 0], [-1, 3.0, -1], [0, -1, 3.0]])
MTX = "%%MatrixMarket matrix coordinate real symmetric\n% a chain\n3 3 5\n1 1 3\n2 2 3\n3 3 3\n2 1 -1\n3 2 -1\n"
UNIT = "%%MatrixMarket matrix array real general\n3 3\n" + "1.0 0 0 0 2.0 0 0 0 3.0".replace(" ", "\n") + "\n"
AT2 = "PEER STRONG MOTION RECORD\nA quake\nACCELERATION IN UNITS OF G\nNPTS=   10, DT=   .0100 SEC\n" + " .1 -.2E-1" * 5
STRUCTURE = '[scene]\nstructure = "FILE"\nhorizon = 1.0\n'


def packed(**entries):
    found = io.BytesIO()
    with zipfile.ZipFile(found, "w", zipfile.ZIP_DEFLATED) as file:
        for name, text in entries.items():
            file.writestr(name.replace("__", "."), text)
    return found.getvalue()


def saved(save, *arrays, **named):
    found = io.BytesIO()
    save(found, *arrays, **named)
    return found.getvalue()


def sparse():
    with_parts = {"M": sf.structures.Structure(M, K).M, "K": sf.structures.Structure(M, K).K}
    parts = {f"{n}_{p}": getattr(e, p) for n, e in with_parts.items() for p in ("data", "indices", "indptr")}
    parts |= {f"{n}_shape": np.array([3, 3]) for n in "MK"}
    return saved(np.savez, names=np.array(["a", "b", "c"]), **parts)


def command(*words):
    done = CliRunner().invoke(main, [str(w) for w in words])
    assert done.exception is None or isinstance(done.exception, SystemExit), repr(done.exception)
    assert done.exit_code in (0, 1, 2)
    assert "Traceback" not in done.output
    if done.exit_code:
        assert done.stderr.strip().count("\n") == 0, done.stderr
        assert done.stderr.strip().isprintable()


def explained(name):
    def run(data, folder):
        (folder / name).write_bytes(data)
        command("explain", folder / name)

    return run


def structure(name):
    def run(data, folder):
        (folder / name).parent.mkdir(exist_ok=True)
        (folder / name).write_bytes(data)
        if name.endswith(".mtx"):
            (folder / name).with_name("K.mtx").write_text(MTX)
        origin = folder / Path(name).parts[0]
        found = sf.structures.read(origin)
        assert found.n >= 1
        assert np.all(np.isfinite(found.K.data))

    return run


def command_on_structure(data, folder):
    (folder / "m.npz").write_bytes(data)
    (folder / "s.toml").write_text(STRUCTURE.replace("FILE", "m.npz"))
    command("explain", folder / "s.toml")


def record(name, numbered=False):
    scene = sf.scenes.mass_on_belt(v_b=0.2)
    observed = {"c1": scene.system.q[0]} if numbered else None

    def run(data, folder):
        (folder / name).write_bytes(data)
        for channel in read_channels({"": scene}, folder / name, observed, None):
            assert np.all(np.isfinite(channel.y))

    return run


def motion(read, name, **given):
    def run(data, folder):
        (folder / name).write_bytes(data)
        assert np.all(np.isfinite(read(folder / name, **given).samples))

    return run


def places(data, folder):
    (folder / "p.csv").write_bytes(data)
    read_places(folder / "p.csv", ["a", "b"], "scene.places")


def cached(data, folder):
    place = folder / f"key{object_cache.CODE}"
    place.write_bytes(data)
    place.chmod(0o600)
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("SYMFRIC_CACHE_DIR", str(folder))
        found = object_cache.load("key")
    assert found in (None, CODE)
    if found is None:
        raise sf.SceneError("not taken")


def object_on_disk(folder):
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("SYMFRIC_CACHE_DIR", str(folder))
        object_cache.store("key", CODE)
    return (folder / f"key{object_cache.CODE}").read_bytes()


class Sweeps:
    """Stores of one sweep, finished and half finished, and its right result."""

    def __init__(self, folder):
        base = sf.scenes.coulomb_oscillator(0.1, horizon=5.0)
        self.scene, self.grid = base.wanting({"top": sf.Max(base.system.q[0])}), {"delta": [0.05, 0.1, 0.2]}
        self.folder, self.right = folder, self.run(folder / "done")
        (folder / "half").mkdir()
        shutil.copy(folder / "done" / "sweep.json", folder / "half")
        about = json.loads((folder / "half" / "sweep.json").read_text())
        half = Store(folder / "half", {k: about[k] for k in ("sweep", "code")}, 1)
        half.open()
        half.append(np.array([0, 2]), self.right.status.values[[0, 2]], self.right.top.values[[0, 2], None])
        half.close()

    def run(self, place):
        return sf.sweep(self.scene, self.grid, store=place, jobs=1)

    def file(self, kind, name):
        """Return a reader of the store with another content of a file, and the right content."""

        def read(data, folder):
            shutil.copytree(self.folder / kind, folder / "store")
            (folder / "store" / name).write_bytes(data)
            found = self.run(folder / "store")
            assert [found[v].values.tobytes() for v in found] == [self.right[v].values.tobytes() for v in self.right]

        return read, (self.folder / kind / name).read_bytes()


CODE = b"code" * 100
NUMBERED = saved(np.save, np.array([[0.0, 1.0], [0.1, 2.0], [0.2, 1.5]]))
NAMED = saved(np.save, np.array([(0.0, 1.0), (0.1, 2.0)], [("t", "<f8"), ("x", "<f4")]))
CSV = b"t,x,u\n" + b"".join(b"%g,%g,%g\n" % (0.1 * k, k % 3, k % 2) for k in range(20))
ZIP, NPZ = (
    packed(M__mtx=UNIT, K__mtx=MTX, names__txt="a\nb\nc\n"),
    saved(np.savez, M=M, K=K, names=np.array(["a", "b", "c"])),
)
TEXTS = {
    "scene of a belt": (explained("s.toml"), (EXAMPLES / "belt.toml").read_bytes()),
    "scene of own equations": (explained("s.toml"), starter("own").encode()),
    "scene of a structure": (explained("s.toml"), starter("structure").encode()),
    "npz of a scene": (command_on_structure, NPZ),
}
FILES = {
    "npz": (structure("m.npz"), NPZ),
    "sparse npz": (structure("m.npz"), sparse()),
    "folder, coordinates": (structure("m/M.mtx"), MTX.encode()),
    "folder, array": (structure("m/M.mtx"), UNIT.encode()),
    "zip": (structure("m.zip"), ZIP),
    "csv record": (record("r.csv"), CSV),
    "record apart by blanks": (record("r.txt"), CSV.replace(b",", b"  ")),
    "npy record": (record("r.npy", numbered=True), NUMBERED),
    "npy record with names": (record("r.npy"), NAMED),
    "AT2": (motion(sf.motions.read_at2, "r.at2"), AT2.encode()),
    "motion of two columns": (motion(sf.motions.read_text, "r.txt", unit="g"), b"0.0 0.1\n0.1 -0.2\n0.2 0.3\n0.3 0\n"),
    "motion of one column": (motion(sf.motions.read_text, "r.txt", unit="g", dt=0.1), b"# acc\n0.1\n-0.2\n0.1\n" * 4),
    "places": (places, b"name,x,y,direction\na,0,1,x\nb,2,1.5,y\n"),
}
INSIDE = {"npz": FILES["npz"], "sparse npz": FILES["sparse npz"], "zip": FILES["zip"]}


def tried(reader, data, seeds, make, tmp_path):
    """Run a reader on mutants; return how many it took and refused."""
    taken = refused = 0
    for seed in seeds:
        folder = tmp_path / "one"
        folder.mkdir(mode=0o700)
        changed = make(data, Random(seed))
        message = ""
        try:
            with warnings.catch_warnings():
                warnings.simplefilter("ignore")  # of gaps in a record
                reader(changed, folder)
            taken += 1
        except MINE as error:
            refused, message = refused + 1, str(error)
        except BaseException as error:
            error.add_note(f"the mutant of seed {seed!r}")
            raise
        assert message.isprintable(), (seed, message)
        assert len(message) < 1000, (seed, message)
        shutil.rmtree(folder)
    return taken, refused


def seeds(kind, count):
    return [f"{kind} {k}" for k in range(count)]


FEW, MANY, MANY_SCENES = 6, 140, 170
KINDS = [*((kind, mutant) for kind in FILES), *((kind, mutant_inside) for kind in INSIDE)]
STORES = [("done", "result.nc"), ("done", "sweep.json"), ("half", "sweep.json"), ("half", "cases-0000.bin")]
ONCE_AND_LONG = [FEW, pytest.param(MANY, marks=pytest.mark.long)]


def peak():
    """Return the most memory that this process has held, in bytes."""
    if sys.platform == "win32":
        return 0
    import resource

    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * (1 if sys.platform == "darwin" else 1024)


def check(kind, reader, data, make, count, tmp_path):
    """Run a reader on the file as it is and on mutants, in bounded memory; return how many it took."""
    before = peak()
    assert tried(reader, data, [f"{kind} as it is"], lambda same, _: same, tmp_path) == (1, 0)
    taken, refused = tried(reader, data, seeds(f"{kind} {make.__name__}", count), make, tmp_path)
    assert taken + refused == count
    assert peak() - before < 600e6
    return taken


@pytest.mark.parametrize("count", ONCE_AND_LONG)
@pytest.mark.parametrize(("kind", "make"), KINDS, ids=lambda e: getattr(e, "__name__", e))
def test_mutants_of_a_file(kind, make, count, tmp_path):
    assert check(kind, *FILES[kind], make, count, tmp_path) < count


@pytest.mark.parametrize("count", [3, pytest.param(MANY_SCENES, marks=pytest.mark.long)])
@pytest.mark.parametrize("kind", TEXTS)
def test_mutants_of_a_scene_file(kind, count, tmp_path):
    check(kind, *TEXTS[kind], mutant, count, tmp_path)


@pytest.mark.parametrize("count", ONCE_AND_LONG)
def test_mutants_of_a_cached_object(count, tmp_path):
    (tmp_path / "right").mkdir(mode=0o700)
    assert check("object", cached, object_on_disk(tmp_path / "right"), mutant, count, tmp_path) < count


@pytest.mark.parametrize("count", ONCE_AND_LONG)
@pytest.mark.parametrize("place", [shipped_loops.place, shipped_loops.machine_code_place])
def test_mutants_of_a_shipped_loop(place, count, tmp_path, monkeypatch):
    loop = "symfric.solve.loop.case_loop"
    if not place(loop).is_file():
        pytest.skip("no loop is shipped for this family of processors")
    content = place(loop).read_bytes()

    def code_of(data, folder):
        monkeypatch.setattr(shipped_loops, "FOLDER", folder)
        place(loop).write_bytes(data)
        return shipped_loops.shipped_object(loop, sources(loop))

    (tmp_path / "right").mkdir()
    right = code_of(content, tmp_path / "right")
    if right is None:
        pytest.skip("the shipped loops are for other processors or versions of LLVM, or wait to be written anew")

    def read(data, folder):
        code = code_of(data, folder)
        assert code in (None, right)
        if code is None:
            raise sf.SceneError("not taken")

    assert check("shipped loop", read, content, mutant, count, tmp_path) < count


@pytest.fixture(scope="module")
def sweeps(tmp_path_factory):
    return Sweeps(tmp_path_factory.mktemp("sweeps"))


@pytest.mark.parametrize("count", [3, pytest.param(60, marks=pytest.mark.long)])
@pytest.mark.parametrize("store", STORES, ids="-".join)
def test_mutants_of_the_store_of_a_sweep(store, count, sweeps, tmp_path):
    check(f"store {store}", *sweeps.file(*store), mutant, count, tmp_path)
