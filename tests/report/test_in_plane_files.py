"""Scene files with contacts in the plane: what they say, what their study shows, and what is wrong in them in one line."""

import json
import tomllib

import numpy as np
import pytest
import sympy as sp
from click.testing import CliRunner

import symfric as sf
from symfric.cli import main
from symfric.report.explorer.views import explorer
from symfric.report.study.drawing.diagram import diagram_of
from symfric.report.study.drawing.sketch import in_words
from symfric.report.study.measurement import motion
from symfric.report.study.page import page
from symfric.report.study.sections.plane_path import paths_in_plane, plot_path
from symfric.report.study.sections.scene import scene_in_words
from symfric.report.study.study import study
from symfric.scenefile import read_scene_file, read_scene_text
from symfric.scenefile.writing import read_tables, with_friction_values, written

FILE = """
title = "Two bodies in the plane"
[scene]
coordinates = ["x", "y", "X", "Y"]
velocities = ["u", "w", "U", "W"]
mass = ["m", "m", 2, 2]
force = ["a*cos(Omega*t)", "-k*y", "-k*X", "-k*Y"]
initial = { x = 0.1, y = 0, X = 0, Y = 0.2, u = 0.5, w = 0, U = 0, W = 0 }
horizon = 6
[values]
m = 1.0
N = 1.0
a = 3.0
k = 2.0
Omega = 2.5
v_b = 0.2
[friction.between]
slip = ["u - U", "w - W"]
normal = "N"
law = "stribeck"
mu_s = 0.5
mu_k = 0.3
v_s = 0.1
[friction.belt]
slip = ["U - v_b", "W"]
normal = 2
law = "coulomb"
mu_s = 0.3
[friction.rail]
slip = "u"
normal = 0.5
law = "coulomb"
mu_s = 0.2
[outputs]
lost = 'integral(friction_force("belt", 0)*U + friction_force("belt", 1)*W)'
fastest = "max(slip('between'))"
[units]
t = "s"
x = "m"
y = "m"
X = "m"
Y = "m"
u = "m/s"
w = "m/s"
U = "m/s"
W = "m/s"
m = "kg"
v_b = "m/s"
"""


@pytest.fixture(scope="module")
def path(tmp_path_factory):
    at = tmp_path_factory.mktemp("plane") / "two_bodies.toml"
    at.write_text(FILE)
    return at


def test_a_file_means_the_scene_in_python(path):
    x, y, X, Y, u, w, U, W = sp.symbols("x y X Y u w U W", real=True)
    m, N, a, k, Omega, v_b = sp.symbols("m N a k Omega v_b", real=True)
    system = sf.System(
        [x, y, X, Y], [u, w, U, W], sp.diag(m, m, 2, 2), [a * sp.cos(Omega * sf.TIME), -k * y, -k * X, -k * Y]
    )
    contacts = [
        sf.Contact("between", (u - U, w - W), N, sf.laws.stribeck(0.5, 0.3, 0.1)),
        sf.Contact("belt", (U - v_b, W), 2, sf.laws.coulomb(0.3)),
        sf.Contact("rail", u, 0.5, sf.laws.coulomb(0.2)),
    ]
    start = dict(zip((x, y, X, Y, u, w, U, W), (0.1, 0, 0, 0.2, 0.5, 0, 0, 0), strict=True))
    own = sf.Scene(
        system, contacts, dict(zip((m, N, a, k, Omega, v_b), (1, 1, 3, 2, 2.5, 0.2), strict=True)), start, 6.0
    )
    run = sf.simulate(read_scene_file(path).scene)
    assert run.final == pytest.approx(sf.simulate(own).final, abs=1e-11)
    assert run["fastest"] > 0.1


def test_a_file_is_read_again_as_it_is_written():
    tables = tomllib.loads(FILE)
    again = read_tables(tables, "two_bodies.toml").scene
    first = read_scene_text(FILE, "two_bodies.toml").scene
    assert [c.slips for c in again.contacts] == [c.slips for c in first.contacts]
    assert tomllib.loads(written(tables)) == tables
    opened = with_friction_values(tables, "two_bodies.toml")
    assert opened["values"]["v_s"] == 0.1
    assert read_tables(opened, "two_bodies.toml").scene.contacts[0].in_plane


@pytest.fixture(scope="module")
def studied(path, tmp_path_factory):
    """The folder that the command writes."""
    folder = tmp_path_factory.mktemp("page")
    done = CliRunner().invoke(main, ["study", str(path), "-o", str(folder), "-q"])
    assert done.exit_code == 0, done.output
    return folder


@pytest.mark.long(beside="test_paths_are_those_of_the_coordinates_that_slip")
def test_the_page_shows_vectors_and_the_path(path, studied):
    shown = (studied / "study.html").read_text(encoding="utf-8")
    assert scene_in_words(read_scene_file(path)).count("in the plane") == 2
    assert "Path in the plane of contact between" in shown
    assert "Path in the plane of contact belt" in shown
    assert "friction of contact belt while it sticks" in shown
    for k in (0, 1):
        assert f"<msub><mi>F</mi><mtext>belt, {k}</mtext></msub>" in shown
    assert "drawn once for each of its two directions" in shown
    assert json.loads((studied / "study.json").read_text())["motion"]["outputs"]["fastest"] > 0.1


def test_paths_are_those_of_the_coordinates_that_slip(path):
    scene = read_scene_file(path).scene
    x, y, X, Y = sp.symbols("x y X Y", real=True)
    paths = paths_in_plane(scene)
    assert [(p.contacts, p.across, p.up) for p in paths] == [(("between",), x - X, y - Y), (("belt",), X, Y)]
    moved = motion(scene)
    line = plot_path(moved, paths[0], {}).get_lines()[0].get_xydata()
    at = [moved.x[moved.names.index(n)] for n in ("x", "X", "y", "Y")]
    assert line == pytest.approx(np.column_stack([at[0] - at[1], at[2] - at[3]]), abs=1e-15)


def test_paths_of_feet_that_turn_are_their_places():
    """Where a foot goes follows from its slip: the place whose rate that is, with the angle."""
    x, y, phi, u, v, omega = sp.symbols("x y phi u v omega", real=True)
    a, b = sp.symbols("a b", positive=True)
    turned = u - omega * (a * sp.sin(phi) + b * sp.cos(phi)), v + omega * (a * sp.cos(phi) - b * sp.sin(phi))
    steered = u * sp.cos(phi) + v * sp.sin(phi), v * sp.cos(phi) - u * sp.sin(phi)  # of no place
    law = sf.laws.coulomb(0.3)
    feet = [sf.Contact("foot", turned, 1, law), sf.Contact("wheel", steered, 1, law)]
    system = sf.System([x, y, phi], [u, v, omega], sp.eye(3), [0, 0, 0])
    scene = sf.Scene(system, feet, {a: 0.5, b: 0.25}, dict.fromkeys([*system.q, *system.u], 0), 1.0)
    (path,) = paths_in_plane(scene)
    assert path.contacts == ("foot",)
    assert sp.simplify(path.across - (x + 0.5 * sp.cos(phi) - 0.25 * sp.sin(phi))) == 0
    assert sp.simplify(path.up - (y + 0.5 * sp.sin(phi) + 0.25 * sp.cos(phi))) == 0


def test_the_sketch_has_each_direction(path):
    diagram = diagram_of(read_scene_file(path).scene)
    assert {s.name for s in diagram.surfaces} == {"belt, 0", "belt, 1", "rail"}
    assert {(e.first, e.second, e.name) for e in diagram.links if e.kind == "friction"} == {
        (0, 2, "between, 0"),
        (1, 3, "between, 1"),
    }
    assert "contact between, 0" in in_words(diagram)


def test_units_of_both_directions_are_checked():
    said = FILE.replace("[units]", "[units]\na = 'N'\nk = 'N/m'\nOmega = '1/s'")
    read_scene_text(said, "f")
    with pytest.raises(sf.SceneError, match="slip"):
        read_scene_text(said.replace('["U - v_b", "W"]', '["U - v_b", "W*Omega"]'), "f")


@pytest.mark.parametrize(
    ("old", "new", "words"),
    [
        ('["U - v_b", "W"]', '["U"]', "friction.belt.slip has 1 entries"),
        ('["U - v_b", "W"]', '["U", "W", "u"]', "has 3 entries"),
        ('["U - v_b", "W"]', '["U", true]', "true or false"),
        ('["U - v_b", "W"]', '["U", ["W"]]', "is a list"),
        ('["U - v_b", "W"]', '["U", "V"]', "friction.belt.slip[1]: unknown name V"),
        ('["U - v_b", "W"]', '["U", "3*U"]', "parallel"),
        ('["U - v_b", "W"]', '["U", "Y"]', "no velocity"),
        ('["U - v_b", "W"]', '["U", "W/(m - 1)"]', "component 1"),
        ("normal = 2", "gap = 'u'", "may depend on the coordinates"),
        ('law = "stribeck"\nmu_s = 0.5\nmu_k = 0.3\nv_s = 0.1', 'law = "dahl"\nmu_c = 0.3\nsigma = 9', "dry law"),
        ('friction_force("belt", 0)', 'friction_force("belt", 2)', "component k = 0 or 1"),
        ('friction_force("belt", 0)', 'friction_force("belt")', "is a vector"),
        ('friction_force("belt", 0)', 'friction_force("rail", 0)', "along a line"),
        ("slip('between')", "slip('between', 1)", "name of a contact alone"),
    ],
)
def test_what_is_wrong_is_one_line(old, new, words):
    assert old in FILE
    with pytest.raises(sf.SceneError) as caught:
        read_scene_text(FILE.replace(old, new), "bad.toml")
    line = str(caught.value)
    assert line.startswith("bad.toml: ")
    assert words in line
    assert "\n" not in line


def test_what_ready_scenes_and_structures_say():
    ready = '[scene]\nmodel = "mass_on_belt"\n[values]\nv_b = 0.2\n[friction]\nlaw = "coulomb"\nmu_s = 0.3\nslip = ["u", "w"]'
    with pytest.raises(sf.SceneError, match="slip"):
        read_scene_text(ready, "bad.toml")


@pytest.mark.parametrize("to", ["c", "fmu"])
def test_an_export_is_refused_in_one_line(path, tmp_path, to):
    out = tmp_path / f"out.{to}"
    done = CliRunner().invoke(main, ["export", str(path), "--to", to, "--step", "0.01", "-o", str(out)])
    assert done.exit_code != 0
    assert "contact 'between' slides in the plane; an exported model takes contacts along a line" in done.output
    assert not out.exists()


def test_commands_take_such_files(path, tmp_path):
    swept = tmp_path / "swept.toml"
    swept.write_text(FILE + "[sweep.grid]\na = [1.0, 3.0]\n")
    run = CliRunner()
    assert "slides in the plane" in run.invoke(main, ["explain", str(path)]).output
    done = run.invoke(main, ["sweep", str(swept), "-o", str(tmp_path / "grid"), "--json"])
    assert done.exit_code == 0, done.output


@pytest.mark.long(beside="test_the_sketch_has_each_direction")
def test_the_explorer_shows_such_a_scene(path):
    assert explorer(read_scene_file(path))


PENDULUM = "[scene]\nmodel = 'friction_pendulum'\n{motions}\n[values]\nR = 2.0\nmu = 0.05\nm = 1.0\n"
BURST = "{kind = 'sine_burst', pga = 2.0, frequency = 1.0, cycles = 5}"


def test_a_ready_scene_takes_two_motions():
    scene = read_scene_text(PENDULUM.format(motions=f"motions = [{BURST}, {BURST}]"), "f").scene
    assert sf.simulate(scene)["peak_displacement"] > 0.001


@pytest.mark.parametrize(
    ("motions", "words"),
    [
        ("", "scene.motions is missing; give two"),
        (f"motions = [{BURST}]", "scene.motions"),
        (f"motion = {BURST}\nmotions = [{BURST}, {BURST}]", "motion"),
        ("motions = ['a.at2', 'b.at2']", "scene.motions[0]"),
    ],
)
def test_wrong_motions_are_one_line(motions, words):
    with pytest.raises(sf.SceneError) as caught:
        read_scene_text(PENDULUM.format(motions=motions), "bad.toml")
    assert words in str(caught.value)
    assert "\n" not in str(caught.value)


TRAY = """
title = "A part hops on a tray"
[scene]
coordinates = ["x", "y", "z"]
velocities = ["u", "w", "v"]
mass = ["m", "m", "m"]
force = [0, "p*m", "-g*m"]
initial = { x = 0, y = 0, z = 0.001, u = 0, w = 0, v = 0 }
horizon = 0.4
[values]
m = 1.0
a = 0.002
Omega = 90.0
e = 0.3
p = 0.5
g = 9.81
[friction.tray]
slip = ["u - 0.1", "w"]
gap = "z - a*sin(Omega*t)"
restitution = "e"
law = "coulomb"
mu_s = 0.4
[outputs]
press = 'max(normal_force("tray"))'
way = 'integral(slip("tray"))'
[units]
t = "s"
x = "m"
y = "m"
z = "m"
u = "m/s"
w = "m/s"
v = "m/s"
a = "m"
m = "kg"
p = "m/s^2"
g = "m/s^2"
Omega = "1/s"
"""


@pytest.mark.long(beside="test_a_file_means_the_scene_in_python")
def test_a_file_of_a_contact_in_the_plane_that_opens(tmp_path):
    file = tmp_path / "tray.toml"
    file.write_text(TRAY)
    read = read_scene_file(file)
    x, y, z, u, w, v = sp.symbols("x y z u w v", real=True)
    tray = sf.Unilateral(z - 0.002 * sp.sin(90 * sf.TIME), 0.3)
    contact = sf.Contact("tray", (u - 0.1, w), tray, sf.laws.coulomb(0.4))
    start = dict(zip((x, y, z, u, w, v), (0, 0, 0.001, 0, 0, 0), strict=True))
    own = sf.Scene(sf.System([x, y, z], [u, w, v], sp.eye(3), [0, 0.5, -9.81]), [contact], {}, start, 0.4)
    run = sf.simulate(read.scene, tolerance=1e-12).checked()
    assert run.final == pytest.approx(sf.simulate(own, tolerance=1e-12).final, abs=1e-11)
    assert run["press"] > 9.81
    shown = page(study(read))
    assert "in the plane with the gap" in scene_in_words(read)
    for words in (
        "impact of contact tray",
        "friction of contact tray while it sticks",
        "Path in the plane of contact tray",
    ):
        assert words in shown
