"""Names that cannot be shown are refused; all others come out whole in C, XML, CSV, HTML and scene files."""

import csv
import html
import io
import json
import re
import subprocess
import zipfile
from xml.etree import ElementTree

import pytest
import sympy as sp
from click.testing import CliRunner

import symfric as sf
from symfric.cli import main
from symfric.export.fmu import compiler

X, U, A = sp.Symbol("x", real=True), sp.Symbol("u", real=True), sp.Symbol("k", positive=True)
HOSTILE = (
    'a"b',
    "a'b",
    "a<b>&c",
    "a;b,c",
    "a\\b",
    "*/ #error",
    "@VALUES@",
    "scene_ SCENE_",
    "ключ θ",
    "]]>",
    "%s{0}",
    "$(x)",
)
UNSEEN = ("\n", "\r", "\t", "\0", "\x1b", "\x7f", "\x85", "\u2028", "\u202e", "\ufffe", "\ud800", "\u200b")


def scene(contact="belt", state="x", parameter="k", output="top"):
    x, k = sp.Symbol(state, real=True), sp.Symbol(parameter, positive=True)
    return sf.Scene(
        sf.System([x], [U], [[1]], [-k * x]),
        [sf.Contact(contact, U, 1, sf.laws.coulomb(0.1))],
        {k: 1.0},
        {x: 1.0, U: 0.0},
        5.0,
        {output: sf.Max(x)},
    )


@pytest.mark.parametrize("what", ["contact", "state", "parameter", "output"])
@pytest.mark.parametrize("unseen", UNSEEN, ids=ascii)
def test_names_that_cannot_be_shown_are_refused(what, unseen):
    for name in (f"a{unseen}b", unseen):
        with pytest.raises(sf.SceneError, match="cannot be shown|is empty|must be a string") as raised:
            scene(**{what: name})
        assert str(raised.value).isprintable()


@pytest.mark.parametrize("unseen", UNSEEN, ids=ascii)
def test_degrees_of_freedom_have_names_that_can_be_shown(unseen):
    with pytest.raises(sf.SceneError, match="cannot be shown"):
        sf.structures.Structure([[1.0]], [[1.0]], names=[f"a{unseen}"])


def variables(place):
    with zipfile.ZipFile(place) as file:
        root = ElementTree.fromstring(file.read("modelDescription.xml"))
    return [e.get("name") for e in root.iter("ScalarVariable")]


@pytest.mark.one_in(3)
@pytest.mark.parametrize(
    "name", [pytest.param(n, marks=pytest.mark.long) if k % 4 else n for k, n in enumerate(HOSTILE)]
)
def test_names_come_out_whole_in_units_for_co_simulation(name, tmp_path):
    unit = sf.export.write_fmu(scene(contact=name, output="y"), tmp_path / "u.fmu", 0.1, {f"{name} out": X})
    assert {f"{name}.mode", f"{name} out", "x", "u", "k"} <= set(variables(unit.files[0]))


@pytest.mark.parametrize("taken", ["status", "belt.mode"])
def test_two_variables_of_one_name_are_refused(taken, tmp_path):
    with pytest.raises(sf.SceneError, match="two variables"):
        sf.export.write_fmu(scene(), tmp_path / "u.fmu", 0.1, {taken: X})
    with pytest.raises(sf.SceneError, match="two variables"):
        sf.export.write_fmu(scene(), tmp_path / "u.fmu", 0.1, {"x": X})


FILES = [
    "scene",
    "my_scene",
    "SCENE",
    "a__b_",
    *(pytest.param(n, marks=pytest.mark.long) for n in ("scene_", "jac", "a_scene_b", "Scene", "casadi")),
]


@pytest.mark.one_in(2)
@pytest.mark.skipif(compiler() is None, reason="no C compiler")
@pytest.mark.parametrize(
    "name", [*FILES, *(pytest.param(n, marks=pytest.mark.long) for n in ("step", "fmi2", "x" * 61))]
)
def test_c_code_of_any_file_name_compiles(name, tmp_path):
    made = scene(contact="scene_ SCENE_", state="SCENE_x", parameter="scene_k")
    sf.export.write_c(made, tmp_path / f"{name}.c", 0.1)
    header = (tmp_path / f"{name}.h").read_text()
    assert f"{name.upper()}_X_SCENE_x" in header
    assert f"{name.upper()}_P_scene_k" in header
    assert f"int {name}_step(" in header
    done = subprocess.run([compiler(), "-std=c99", "-c", f"{name}.c"], cwd=tmp_path, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr


TOML = """title = "names"
[scene]
coordinates = "x"
velocities = "u"
mass = "1.0"
force = "-k*x"
initial = { x = 1.0, u = 0.0 }
horizon = 2
[values]
k = 1.0
[friction.%s]
law = "coulomb"
slip = "u"
normal = "1.0"
mu_s = 0.1
[outputs]
%s = "max(x)"
[sweep.grid]
k = [1.0, 2.0]
"""


def call(*words):
    done = CliRunner().invoke(main, [str(w) for w in words])
    assert done.exit_code == 0, done.output
    return done


@pytest.mark.long(beside="test_names_come_out_whole_in_units_for_co_simulation")
@pytest.mark.parametrize("name", HOSTILE)
def test_names_come_out_whole_in_pages_and_tables(name, tmp_path):
    (tmp_path / "s.toml").write_text(TOML % (json.dumps(name), json.dumps("top")), encoding="utf-8")
    call("study", tmp_path / "s.toml", "-o", tmp_path / "out", "-q")
    page = (tmp_path / "out" / "study.html").read_text(encoding="utf-8")
    shown = re.sub(r"(?s)<script.*?</script>", "", page)
    assert "a<b>&c" not in shown
    assert name in html.unescape(shown)
    rows = list(csv.reader(io.StringIO((tmp_path / "out" / "motion.csv").read_text(encoding="utf-8"))))
    assert {len(row) for row in rows} == {len(rows[0])}
    (tmp_path / "s.toml").write_text((TOML % ("belt", '"top"')).replace("top", "top_of_x"), encoding="utf-8")
    call("sweep", tmp_path / "s.toml", "-o", tmp_path / "sweep", "-q")
    assert "top_of_x" in (tmp_path / "sweep" / "sweep.csv").read_text()


@pytest.mark.parametrize("unseen", ["\\n", "\\t", "\\u202E", "\\u001B"])
def test_a_scene_file_with_a_name_that_cannot_be_shown_is_refused(unseen, tmp_path):
    (tmp_path / "s.toml").write_text(TOML % (f'"a{unseen}b"', '"top"'), encoding="utf-8")
    done = CliRunner().invoke(main, ["explain", str(tmp_path / "s.toml")])
    assert done.exit_code == 2
    assert done.stderr.strip().isprintable()
