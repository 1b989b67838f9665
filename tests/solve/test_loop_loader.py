"""Event loops on disk, compiled or shipped: what they are made from is part of the key under which they are kept."""

import os
import re
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

import symfric as sf
from symfric.codegen import ship, shipped_loops
from symfric.codegen.loop_loader import LOOPS, sources, sources_key

LOADED = "import sys, {}; print(*(m.__file__ for n, m in sys.modules.items() if n.startswith('symfric.')), sep=chr(10))"


@pytest.mark.one_in(6)
@pytest.mark.parametrize("loop", LOOPS)
def test_every_compiled_function_that_a_loop_loads_is_among_its_sources(loop):
    code = LOADED.format(loop)
    loaded = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True).stdout.split()
    compiled = {f for f in loaded if "@compiled" in Path(f).read_text(encoding="utf-8")}
    assert len(compiled) >= 2
    assert compiled - {str(f) for f in sources(loop)} == set()


def test_the_key_changes_with_a_source(tmp_path, monkeypatch):
    monkeypatch.syspath_prepend(str(tmp_path))
    file = tmp_path / "loop_with_a_key.py"
    file.write_text("LEFT = 1")
    before = sources_key("loop_with_a_key")
    assert sources_key("loop_with_a_key") == before
    file.write_text("LEFT = 2")
    assert sources_key("loop_with_a_key") != before


def test_every_loop_of_the_package_is_among_those_that_are_shipped():
    package = Path(sf.__file__).parent
    loaded = [re.findall(r'load_loop\("([\w.]+)"', f.read_text(encoding="utf-8")) for f in package.rglob("*.py")]
    assert sorted(name for names in loaded for name in names) == sorted(LOOPS)


def needs_shipped(loop):
    if not shipped_loops.place(loop).is_file():
        pytest.skip("no loop is shipped for this family of processors")
    if shipped_loops.shipped_header(loop)["made for"] != shipped_loops.conditions():
        pytest.skip("the shipped loops are for another version of LLVM")


@pytest.mark.one_in(4)
@pytest.mark.parametrize("loop", LOOPS)
def test_the_shipped_loops_belong_to_the_present_sources(loop):
    needs_shipped(loop)
    made = shipped_loops.shipped_header(loop)
    assert made["sources"] == shipped_loops.meaning(sources(loop)), "run python -m symfric.codegen.ship"
    assert made["bytes"] == shipped_loops.content_key(sources(loop)), "run python -m symfric.codegen.ship, some seconds"


def test_comments_docstrings_and_layout_have_no_meaning(tmp_path):
    file = tmp_path / "loop.py"

    def meaning(text):
        file.write_text(text)
        return shipped_loops.meaning([file])

    assert meaning("def f(x):\n    return x + 1") == meaning('"""T"""\n\ndef f(x):  # why\n    "D"\n    return (x+1)')
    assert meaning("def f(x):\n    return x + 1") != meaning("def f(x):\n    return x + 2")


SAMPLE = """
def f(x: float, *more, flag=None):
    for k, v in (x[1, 2], x[(0,)]):
        x[k] += -v if flag is None and not more else 1e-3
    return [a for a in more if a > 0.0], lambda t: (t, x)
"""


def test_the_meaning_is_the_same_in_every_version_of_python(tmp_path):
    (tmp_path / "sample.py").write_text(SAMPLE)
    assert shipped_loops.meaning([tmp_path / "sample.py"])[:16] == "3520a5740fb6bd09"


FIRST = """
import sys
sys.modules["numba"] = None  # whoever imports it fails
import symfric as sf
scene = sf.scenes.mass_on_belt(v_b=0.2).wanting({"end": sf.End()})
for route in ("taylor", "exact"):
    if route == "exact":
        scene = sf.scenes.mass_on_belt(sf.laws.coulomb(0.4, 0.3), v_b=0.2).wanting({"end": sf.End()})
    print(*sf.simulate(scene, 1e-10, route).checked().final)
"""


def test_a_first_result_needs_no_compiler(tmp_path):
    for loop in LOOPS:
        needs_shipped(loop)
    environment = {**os.environ, "SYMFRIC_CACHE_DIR": str(tmp_path / "empty")}
    done = subprocess.run([sys.executable, "-c", FIRST], capture_output=True, text=True, env=environment, check=True)
    found = np.array([line.split() for line in done.stdout.splitlines()], dtype=float)
    smooth = sf.scenes.mass_on_belt(v_b=0.2)
    dry = sf.scenes.mass_on_belt(sf.laws.coulomb(0.4, 0.3), v_b=0.2)
    kept = [sf.simulate(s, 1e-10, r).final for s, r in ((smooth, "taylor"), (dry, "exact"))]
    assert found == pytest.approx(np.array(kept), rel=1e-12, abs=1e-14)


def test_a_shipped_loop_that_is_damaged_or_of_other_sources_is_not_used(tmp_path, monkeypatch):
    loop = LOOPS[1]
    needs_shipped(loop)
    content = shipped_loops.place(loop).read_bytes()
    monkeypatch.setattr(shipped_loops, "FOLDER", tmp_path)
    assert shipped_loops.shipped_object(loop, sources(loop)) is None  # missing
    shipped_loops.place(loop).write_bytes(content)
    assert shipped_loops.shipped_object(loop, sources(loop)) is not None
    assert shipped_loops.shipped_object(loop, sources(LOOPS[2])) is None
    shipped_loops.place(loop).write_bytes(content[: len(content) // 2])
    assert shipped_loops.shipped_object(loop, sources(loop)) is None
    shipped_loops.place(loop).write_bytes(content)
    monkeypatch.setattr(shipped_loops, "conditions", lambda: ["1", "another-system"])
    assert shipped_loops.shipped_object(loop, sources(loop)) is None


@pytest.fixture
def small_loop(tmp_path, monkeypatch):
    """Shipped files of a small loop, and its source."""
    source = tmp_path / "loop.py"
    source.write_text("LEFT = 1\n")
    monkeypatch.setattr(shipped_loops, "FOLDER", tmp_path)
    code = "define i64 @launch(i64 %x) {\n  ret i64 %x\n}\n"
    shipped_loops.write_shipped("one.loop", [source], "launch", code)
    return source


def test_machine_code_is_taken_where_the_processor_runs_it_and_made_elsewhere(small_loop, monkeypatch):
    if shipped_loops.family() is None:
        pytest.skip("no machine code is shipped for this family of processors")
    own = shipped_loops.family()
    made, original = [], shipped_loops.target_machine
    monkeypatch.setattr(shipped_loops, "target_machine", lambda opt: made.append(opt) or original(opt))
    assert shipped_loops.shipped_object("one.loop", [small_loop]).startswith(b"launch\n")
    assert made == ([] if own.needs <= shipped_loops.processor_features() else [3])
    monkeypatch.setattr(shipped_loops, "processor_features", lambda: own.needs - {"fma"})
    made.clear()
    assert shipped_loops.shipped_object("one.loop", [small_loop]).startswith(b"launch\n")
    assert made == [3]
    small_loop.write_text("LEFT = 2\n")
    assert shipped_loops.shipped_object("one.loop", [small_loop]) is None


def test_other_comments_are_other_bytes_with_the_same_meaning(small_loop, monkeypatch):
    asked, original = [], shipped_loops.meaning
    monkeypatch.setattr(shipped_loops, "meaning", lambda files: asked.append(files) or original(files))
    assert shipped_loops.shipped_object("one.loop", [small_loop]) is not None
    assert asked == []
    small_loop.write_text("LEFT = 1  # again\n")
    assert shipped_loops.shipped_object("one.loop", [small_loop]) is not None
    assert len(asked) == 1


def test_machine_code_of_another_loop_is_found(tmp_path, monkeypatch):
    made = _Made(tmp_path, monkeypatch)
    if shipped_loops.family() is None:
        pytest.skip("no machine code is shipped for this family of processors")
    made.write()
    place = shipped_loops.machine_code_place("one.loop")
    right = place.read_bytes()
    made.text = made.text.replace("ret i64 %x", "ret i64 7")
    made.write()
    place.write_bytes(right)
    (fault,) = ship.check(("one.loop",))
    assert place.name in fault


class _Made:
    """A loop whose intermediate code is a text, for the check of the shipped files."""

    def __init__(self, folder, monkeypatch):
        self.source, self.text = folder / "loop.py", "define i64 @launch(i64 %x) {\n  ret i64 %x\n}\n"
        self.source.write_text("LEFT = 1\n")
        monkeypatch.setattr(shipped_loops, "FOLDER", folder)
        monkeypatch.setattr(ship, "optimised", lambda _: ("launch", self.text))

    def write(self):
        return shipped_loops.write_shipped("one.loop", [self.source], "launch", self.text)


def test_a_file_with_other_code_than_its_sources_give_is_found_whatever_its_header_says(tmp_path, monkeypatch, capsys):
    made = _Made(tmp_path, monkeypatch)
    made.write()
    assert ship.check(("one.loop",)) == []
    assert capsys.readouterr().out == "one.loop: the same\n"
    made.text = made.text.replace("ret i64 %x", "ret i64 7")  # as after a change of the sources
    (fault,) = ship.check(("one.loop",))
    assert "other code" in fault
    monkeypatch.setattr(shipped_loops, "meaning", lambda _: "a hash written without compiling")
    made.text = made.text.replace("7", "8")
    content, *_ = made.write()
    made.text = made.text.replace("8", "9")
    assert len(ship.check(("one.loop",))) == 1
    content.write_bytes(b"damaged")
    (fault,) = ship.check(("one.loop",))
    assert "cannot be read" in fault


def test_files_made_with_other_compilers_are_not_compared(tmp_path, monkeypatch):
    made = _Made(tmp_path, monkeypatch)
    made.write()
    monkeypatch.setattr(ship, "compilers", lambda: {"python": "3.99", "llvmlite": "9", "numba": "9"})
    (fault,) = ship.check(("one.loop",))
    assert "made with python" in fault
    assert "python 3.99" in fault


@pytest.mark.long(beside="test_the_shipped_loops_belong_to_the_present_sources")
def test_the_shipped_loops_are_what_their_sources_give():
    for loop in LOOPS:
        needs_shipped(loop)
    made = shipped_loops.shipped_header(LOOPS[0]).get("made with")
    if made is not None and made != shipped_loops.compilers():
        pytest.skip("the shipped loops were made with other versions of Python, numba or llvmlite")
    done = subprocess.run([sys.executable, "-m", "symfric.codegen.ship", "--check"], capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    assert done.stdout.count(": the same\n") == len(LOOPS)


def test_other_comments_change_the_key_of_the_bytes_alone(small_loop, monkeypatch):
    header, code = shipped_loops.shipped_header("one.loop"), shipped_loops.shipped_code("one.loop")
    small_loop.write_text("LEFT = 1  # another comment\n")
    assert shipped_loops.renewed("one.loop", [small_loop])
    assert shipped_loops.shipped_header("one.loop") == {**header, "bytes": shipped_loops.content_key([small_loop])}
    assert shipped_loops.shipped_code("one.loop") == code
    small_loop.write_text("LEFT = 2\n")
    assert not shipped_loops.renewed("one.loop", [small_loop])
    small_loop.write_text("LEFT = 1\n")
    monkeypatch.setattr(shipped_loops, "compilers", lambda: {"numba": "another"})
    assert not shipped_loops.renewed("one.loop", [small_loop])
    shipped_loops.place("one.loop").unlink()
    assert not shipped_loops.renewed("one.loop", [small_loop])
