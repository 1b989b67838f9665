"""Scene files with held variables and resets: examples, round trip, equations, refusals."""

import json
from pathlib import Path

import numpy as np
import pytest
import sympy as sp
from click.testing import CliRunner

import symfric as sf
from symfric.cli import main
from symfric.scenefile import read_scene_file, read_scene_text
from symfric.scenefile.writing import read_tables, tables_of, with_friction_values, written

FOLDER = Path(__file__).parents[2] / "examples" / "controllers"
FILES = sorted(FOLDER.glob("*.toml"))
KNOWN = {
    "delayed_relay": "half range of \n0.80434 in x and a period of 5.5355.",
    "sampled_stage": "has not settled to a periodic one",
}


def test_every_example_is_known():
    assert [p.stem for p in FILES] == sorted(KNOWN)


@pytest.mark.one_in(2)
@pytest.mark.parametrize("path", FILES, ids=lambda p: p.stem)
def test_the_examples_are_explained_and_studied(path, tmp_path):
    found = CliRunner().invoke(main, ["explain", str(path)])
    assert found.exit_code == 0
    assert "taylor: takes it" in found.stdout
    text = path.read_text().replace("number = 11", "number = 3")
    file = tmp_path / path.name
    file.write_text(text)
    found = CliRunner().invoke(main, ["study", str(file), "-o", str(tmp_path / "out")])
    assert found.exit_code == 0, found.output
    assert KNOWN[path.stem] in found.output
    shown = (tmp_path / "out" / "study.html").read_text()
    assert "what happens at instants" in shown
    assert "queue1" not in shown
    data = json.loads((tmp_path / "out" / "study.json").read_text())
    assert data["motion"]["status"] == "OK"


@pytest.mark.one_in(2)
@pytest.mark.parametrize("path", FILES, ids=lambda p: p.stem)
def test_a_file_and_what_is_written_of_it_are_the_same_scene(path):
    tables = tables_of(read_scene_file(path))
    for text in (written(tables), written(with_friction_values(tables, str(path)))):
        again = read_scene_text(text)
        assert np.array_equal(sf.simulate(again.scene).final, sf.simulate(sf.read(path)).final)
    assert read_tables(tables, str(path)).scene.held[0].name == sf.read(path).held[0].name


OWN = """
[scene]
coordinates = "x"
velocities = "u"
mass = 1
force = "-x + cmd"
initial = {x = 1, u = 0}
horizon = 5.2
[values]
T = 0.5
h = 0.25
[held.cmd]
update = "-x/2 + cmd.previous/4 - sign(u)/8"
every = "T"
offset = 0.25
delay = 0.75
step = 0.01
initial = 0.125
[[reset]]
at = [1.0, "4*h + 2"]
set = { u = ["u + h", "u - h"], x = "x" }
[[reset]]
guard = "x + 1/2"
[reset.set]
u = "u/2"
[[reset]]
every = 2
offset = 1
set.u = 0
"""


def test_a_file_is_the_scene_of_python():
    x, u, T, h = sp.symbols("x u T h", real=True)
    before = sp.Symbol("cmd.previous", real=True)
    cmd = sf.Held("cmd", -x / 2 + before / 4 - sp.sign(u) / 8, T, 0.25, 0.75, 0.125, 0.01)
    resets = [
        sf.Reset(at=[1.0, 4 * h + 2], set={u: [u + h, u - h], x: x}),
        sf.Reset(guard=x + sp.Rational(1, 2), set={u: u / 2}),
        sf.Reset(every=2, offset=1, set={u: 0}),
    ]
    system = sf.System([x], [u], [[1]], [-x + cmd.symbol])
    scene = sf.Scene(system, [], {T: 0.5, h: 0.25}, {x: 1, u: 0}, 5.2, held=[cmd], resets=resets)
    read = read_scene_text(OWN).scene
    assert np.array_equal(sf.simulate(read).final, sf.simulate(scene).final)
    assert repr(read) == "Scene(1 coordinate, contacts: none; held: cmd; 3 resets; T=0.5, h=0.25; horizon 5.2)"
    assert [str(e) for e in read.equations()[2:]] == [
        "Eq(t_cmd, T*n + 0.25)",
        "Eq(cmd(t_cmd + 0.75), 0.01*floor(25.0*cmd(-T + t_cmd + 0.75) - 50.0*x(t_cmd) - 12.5*sign(u(t_cmd)) + 1/2))",
        "Eq(t_1,1, 1)",
        "Eq(u(t_1,1^+), h + u(t_1,1))",
        "Eq(x(t_1,1^+), x(t_1,1))",
        "Eq(t_1,2, 4*h + 2)",
        "Eq(u(t_1,2^+), -h + u(t_1,2))",
        "Eq(x(t_1,2^+), x(t_1,2))",
        "Eq(x(t_2) + 1/2, 0)",
        "Eq(u(t_2^+), u(t_2)/2)",
        "Eq(t_3, 2*n + 1)",
        "Eq(u(t_3^+), 0)",
    ]
    assert r"{cmd}{\left(t_{cmd} + 0.75 \right)}" in read._repr_latex_()


@pytest.mark.parametrize(
    ("before", "after", "match"),
    [
        ('update = "-x/2', 'update = "-y/2', r"held\.cmd\.update: unknown name y"),
        ("cmd.previous", "other.previous", r"held\.cmd\.update: a dot after a name"),
        ('every = "T"', 'evry = "T"', r"\[held\.cmd\] has no key 'evry'; did you mean every"),
        ('every = "T"', 'every = "x"', "may depend on parameters only, not on x"),
        ('every = "T"', "every = -1", r"held\.cmd: every of 'cmd' is -1; it must exceed 0"),
        ('every = "T"', 'every = "T"\nwhen = "x"', r"held\.cmd: 'cmd' needs either"),
        ("step = 0.01", "waiting = 0", r"held\.cmd\.waiting"),
        ("[held.cmd]", "[held]\na = 1\n[held.cmd]", r"held\.a is a number; write a section"),
        ("[held.cmd]", "[held.T]\nupdate = 1\nevery = 1\n[held.cmd]", "held.T is also one of values; rename one"),
        ('set = { u = ["u + h", "u - h"], x = "x" }', "", r"reset\[0\]\.set is missing"),
        ('x = "x" }', 'y = "x" }', "a reset sets y, which is no state"),
        ('"u - h"', '"u - h", 0', r"reset\[0\]: a reset has 2 times and 3 values of u"),
        ('guard = "x + 1/2"', 'guard = "1/2"', r"reset\[1\]: the guard of a reset is 1/2"),
        ('guard = "x + 1/2"', 'guard = "x + 1/2"\nat = 1', r"reset\[1\]: a reset needs either its times"),
        ("offset = 1\n", "offset = 1\nwhen = 2\n", r"\[reset\[2\]\] has no key 'when'"),
    ],
)
def test_what_is_wrong_is_one_line(before, after, match):
    assert OWN.count(before) == 1
    with pytest.raises(sf.SceneError, match=match) as error:
        read_scene_text(OWN.replace(before, after))
    assert "\n" not in str(error.value)


def test_ready_models_take_none():
    with pytest.raises(sf.SceneError, match=r"\[\[reset\]\] belongs to own equations"):
        read_scene_text('[scene]\nmodel = "mass_on_belt"\n[[reset]]\nat = 1\nset = {u = 0}\n')


def test_units_of_held_variables_are_checked():
    units = '\n[units]\nx = "mm"\nu = "mm/s"\nt = "s"\nT = "s"\n'
    relay = OWN.partition("[values]")[0] + "[values]\nT = 0.5\n[held.cmd]\n"
    good = relay + 'update = "-x*sign(x)"\nwhen = "x"\ndelay = "T"\n'
    assert read_scene_text(good + units).scene.units["cmd.left1"] == "s"
    with pytest.raises(sf.SceneError, match=r"held\.cmd: T\*x is in 0\.001 m s and cmd is in mm"):
        read_scene_text(good.replace("-x*sign(x)", "T*x") + units)
    with pytest.raises(sf.SceneError, match=r"held\.cmd: T is in mm and t is in s"):
        read_scene_text(good + units.replace('T = "s"', 'T = "mm"'))
