"""Structures in scene files: what is read, what is refused in one line, and what the page says of them."""

import json

import numpy as np
import pytest
import scipy.io
import scipy.sparse as sps
from click.testing import CliRunner

import symfric as sf
from symfric.cli import main
from symfric.report.study.measurement import motion
from symfric.report.study.page import page
from symfric.report.study.sections import EQUILIBRIUM, FLUTTER, OPENED, SLOW
from symfric.report.study.sections.flutter import flutter_in_words
from symfric.report.study.study import study
from symfric.scenefile import read_scene_file, read_scene_text
from symfric.scenefile.places import read_places
from symfric.scenefile.starters import companions, starter

PAD = """
[scene]
structure = "two"
points = { top = "0.5*x - y", x = "x" }
initial = { y = -0.5 }
horizon = 60.0
[values]
mu = 0.225
v_b = 1.0
[friction.pad]
slip = "d_x - v_b"
normal = "1 + y"
push = "-y"
law = "coulomb"
mu_s = "mu"
"""
MADE = """
[scene]
structure = { maker = "disc_and_pad", columns = 8, width = 2, height = 2, damping = 0.3 }
modes = 4
points = "p0_2x"
initial = { p0_2x = 0.02 }
horizon = 60.0
[values]
mu = 0.3
v_b = 0.02
N0 = 0.01
[friction]
law = "coulomb"
mu_s = "mu"
normal = "N0"
speed = "v_b"
[flutter]
mu = [0.0, 0.6]
modes = 3
grid = 4
"""


@pytest.fixture
def two(tmp_path):
    """A folder of Matrix Market files of two degrees of freedom, and the folder that holds it."""
    place = tmp_path / "two"
    place.mkdir()
    for name, a in (("M", np.eye(2)), ("K", [[1.05, 0.2], [0.2, 0.0]]), ("C", 0.02 * np.eye(2))):
        scipy.io.mmwrite(place / f"{name}.mtx", sps.coo_array(np.array(a)))
    (place / "names.txt").write_text("x\ny\n")
    return tmp_path


def test_a_file_gives_the_scene_that_python_gives(two):
    read = read_scene_text(PAD, "pad.toml", two)
    s = sf.structures.read(two / "two")
    load = sf.structures.RowLoad(1.0, {"y": 1.0}, push={"y": -1.0})
    pad = sf.structures.RowContact("pad", {"x": 1.0}, load, sf.laws.coulomb(0.225), speed=1.0)
    written = s.scene([pad], initial={"y": -0.5}, horizon=60.0)
    one, other = (sf.simulate(e.wanting({"end": sf.End()}))["end"] for e in (read.scene, written))
    assert np.allclose(one, other, rtol=0, atol=1e-12)
    assert read.coordinate == "top"
    top = sf.simulate(read.scene.wanting({"top": sf.At(next(r for r in read.scene.system.rows if r.name == "top"))}))
    assert top["top"] == pytest.approx(0.5 * one[0] - one[1], abs=1e-9)


def test_contacts_of_a_maker_are_those_of_the_file_that_writes_them_out(tmp_path):
    brake = sf.structures.disc_and_pad(8, width=2, height=2, damping=0.3)
    sf.structures.write(brake.apart, tmp_path / "b.npz")
    begin = (8 - 2) // 2
    pairs = "".join(
        f'[friction.pair{i + 1}]\nslip = "d_p{i}_0x - d_d{begin + i}_2x - v_b"\nlaw = "coulomb"\nmu_s = "mu"\n'
        f'normal = "N0 + 0.05*(d{begin + i}_2y - p{i}_0y)"\npush = "p{i}_0y - d{begin + i}_2y"\n'
        for i in range(3)
    )
    head, rest = MADE.split("[friction]")
    text = head.replace('{ maker = "disc_and_pad", columns = 8, width = 2, height = 2, damping = 0.3 }', '"b.npz"')
    file = read_scene_text(text + pairs + "[flutter]" + rest.split("[flutter]")[1], "b.toml", tmp_path)
    made = read_scene_text(MADE)
    ends = [sf.simulate(f.scene.wanting({"end": sf.End()}))["end"] for f in (file, made)]
    assert np.allclose(*ends, rtol=0, atol=1e-9)
    found, known = (
        sf.structures.sliding(f.structure.full, f.structure.contacts, f.scene.parameter_values()) for f in (file, made)
    )
    assert abs(found.K - brake.structure.K).max() < 1e-15
    assert abs(found.friction - known.friction).max() == 0 == abs(known.friction - brake.structure.friction).max()


def test_points_of_a_reduced_structure_are_those_of_the_full_one():
    """A point that is a row is the same combination of the expanded motion."""
    text = MADE.replace('points = "p0_2x"', 'points = { p0_2x = "p0_2x", lean = "p0_2x - p2_2x" }')
    file = read_scene_text(text)
    plan, found = file.structure, motion(file.scene)
    full = plan.small.expand(found.x[: plan.small.n])
    order = {n: i for i, n in enumerate(plan.full.names)}
    lean = found.x[found.names.index("lean")]
    assert np.allclose(lean, full[order["p0_2x"]] - full[order["p2_2x"]], rtol=0, atol=1e-9 * np.max(np.abs(full)))


@pytest.mark.parametrize(
    ("change", "said"),
    [
        (('"two"', '"none"'), "there is no file or folder"),
        (('structure = "two"', "structure = {}"), "needs one of file"),
        (('structure = "two"', 'structure = { maker = "dics_and_pad" }'), "did you mean disc_and_pad"),
        (('structure = "two"', 'structure = { maker = "chain", n = 1000000 }'), "at most 3000"),
        (('structure = "two"', 'structure = { maker = "chain", m = 3 }'), "no argument 'm'"),
        (("d_x - v_b", "d_x*d_x - v_b"), "linear in velocities"),
        (("d_x - v_b", "x - v_b"), "linear in velocities"),
        (("d_x - v_b", "v_b"), "names no velocity"),
        (("d_x - v_b", "d_z - v_b"), "d_z"),
        (('slip = "d_x - v_b"', "slip = { z = 1.0 }\nspeed = 1.0"), "no degree of freedom 'z'"),
        (('slip = "d_x - v_b"\n', ""), "slip is missing"),
        (('normal = "1 + y"\n', ""), "normal is missing"),
        (("1 + y", "1 + mu*y"), "linear in coordinates, with numbers"),
        (("1 + y", "1 + y**2"), "linear in coordinates, with numbers"),
        (('push = "-y"', 'push = "-d_y"'), "linear in coordinates"),
        (('push = "-y"', 'push = "-z"'), "push: unknown name z"),
        (('normal = "1 + y"', "normal = 1.0"), "does not follow the structure"),
        (('top = "0.5*x - y"', 'mu = "x"'), "'mu' is taken"),
        (('top = "0.5*x - y"', 'top = "z"'), "points.top: unknown name z"),
        (("mu = 0.225", "mu = 0.225\ny = 1.0"), "also a degree of freedom"),
        (("y = -0.5", "z = -0.5"), "z in initial is no state"),
        (("horizon = 60.0", 'horizon = 60.0\nforce = { z = "sin(t)" }'), "'z'"),
        (("horizon = 60.0", 'horizon = 60.0\nmu = "mu"'), "no friction matrix"),
        (("horizon = 60.0", 'horizon = 60.0\nplaces = "p.csv"'), "cannot be read"),
        (("horizon = 60.0", "horizon = 60.0\nmodes = 9"), "modes"),
        (("horizon = 60.0", "horizon = 60.0\nforse = 1"), "did you mean force"),
    ],
)
def test_faults_are_one_line(two, change, said):
    assert change[0] in PAD
    with pytest.raises(sf.SceneError, match="(?s).*") as error:
        read_scene_text(PAD.replace(*change), "pad.toml", two)
    assert said in str(error.value)
    assert "\n" not in str(error.value)


def test_a_flutter_map_needs_a_structure():
    with pytest.raises(sf.SceneError, match=r"\[flutter\] is about structures"):
        read_scene_text('[scene]\nmodel = "mass_on_belt"\n[values]\nv_b = 0.2\n[flutter]\nmu = [0, 1]')


def test_matrices_of_hundreds_are_not_taken_whole():
    with pytest.raises(sf.SceneError, match="scene.modes is missing: the structure has 300 degrees"):
        read_scene_text('[scene]\nstructure = { maker = "chain", n = 300 }\nhorizon = 1.0')


def test_places_are_read_and_checked(tmp_path):
    place = tmp_path / "p.csv"
    place.write_text("name,x,y,direction\na,0,1,x\nb,0,1,y\nc,0,1,x\n")
    places = read_places(place, ["a", "b", "c", "d"], "scene.places")
    nodes, moves = places.nodes()
    assert nodes.tolist() == [[0, 1], [0, 1]]  # two nodes that touch
    assert moves.tolist() == [[0, 1], [2, -1]]
    for text, said in (
        ("x,y\n", "first line"),
        ("name,x\ne,1\n", "no degree of freedom 'e'"),
        ("name,x\na,one\n", "no finite numbers"),
        ("name,x\na,1,2\n", "3 cells"),
        ("name,x,y,direction\na,1,2,z\n", "direction is 'z'"),
    ):
        place.write_text(text)
        with pytest.raises(sf.SceneError, match=said):
            read_places(place, ["a"], "scene.places")


@pytest.mark.long(beside="test_the_page_of_a_made_brake_draws_its_mesh_and_says_which_contacts_open")
def test_the_page_of_the_starter(tmp_path):
    """From the file to start from to the page: flutter in Hz, Hopf point, limit cycles to lift-off, and the data."""
    call = CliRunner().invoke
    place = tmp_path / "pad.toml"
    assert call(main, ["new", "structure", str(place)]).exit_code == 0
    assert call(main, ["new", "structure", str(place)]).exit_code == 2  # nothing is replaced unasked
    text = place.read_text().replace("number = 11", "number = 3").replace("horizon = 0.4", "horizon = 0.2")
    place.write_text(text.replace("[0.2, 0.25]", "[0.2, 0.226]"))
    found = sf.read(place).study()
    branch = found.result.branch.value
    (point,) = found.result.flutter.value.map.critical
    mu, omega, _ = 0.2051745, 1012.42, None  # of the undamped pair with equal dampers: mu where it grows
    assert point.mu == pytest.approx(mu, rel=1e-5)
    assert point.omega == pytest.approx(omega, rel=1e-5)
    hopf = found.result.hopf.value
    assert hopf.kind == "supercritical"
    assert branch.from_onset
    assert branch.stable.all()
    assert branch.values[0] == pytest.approx(hopf.value, abs=1e-6)
    (lift,) = branch.lift_off
    assert lift.value == pytest.approx(0.222984, abs=1e-5)
    settled = found.result.sweep.value
    near = np.interp(settled.values[1], branch.values, branch.half_range)  # simulated beside continued
    assert settled.half_range[1] == pytest.approx(near, rel=1e-3) or settled.values[1] < hopf.value
    (share,) = found.result.contacts.value
    assert share.contact == "pad"
    page = found.html()
    assert "161.1 Hz" in page
    assert "two modes couple" in page
    assert "first lifts off at" in page
    assert "made without the slope of the law" in page
    assert found.write(tmp_path / "out").name == "study.html"
    names = {"study.html", "study.json", "motion.csv", "amplitude.csv", "flutter.csv", "shapes.csv", "cycles.csv"}
    assert {p.name for p in (tmp_path / "out").iterdir()} == names
    data = json.loads((tmp_path / "out" / "study.json").read_text())
    assert data["structure"]["flutter"]["critical"][0]["mu"] == pytest.approx(mu, rel=1e-5)
    assert companions("structure").keys() == {"M.mtx", "K.mtx", "C.mtx", "names.txt"}
    assert "FILE-matrices" in starter("structure")


def test_the_page_of_a_made_brake_draws_its_mesh_and_says_which_contacts_open():
    """At mu = 0.6 a pair is open in steady sliding: the flutter map, which has all closed, does not hold there."""
    result = study(read_scene_text(MADE.replace("mu = 0.3\n", "mu = 0.6\n")))
    html = page(result)
    assert result.modes.value.frequency.size == 6
    assert "33 nodes, 3 contacts" in html
    assert "every contact" in html or html.count("pair3: ") == 1
    assert "<mtable>" not in html  # no matrices of many coordinates
    assert html.count("sweep.branch") == 1  # folded into one line
    assert result.opened.value == ["pair3"]
    assert "pair3 is open in steady sliding: trust the eigenvalues there" in html


def test_a_critical_point_that_steady_sliding_cannot_reach_is_said():
    """With contacts closed two modes couple at 0.708; one pair opens before, and the scene is stable at 0.85 again."""
    text = MADE.replace("columns = 8, width = 2", "columns = 24, width = 3").replace("mu = 0.3\n", "mu = 0.85\n")
    file = read_scene_text(text.replace("[0.0, 0.6]", "[0.6, 0.8]").replace("modes = 4", "modes = 8"))
    result = study(file, sections=(SLOW, EQUILIBRIUM, OPENED, FLUTTER))
    found = result.flutter.value
    (point,) = found.map.critical
    assert point.mu == pytest.approx(0.70789, abs=1e-4)
    assert found.torn == (("pair4",),)
    assert result.opened.value == ["pair3", "pair4"]
    assert sf.stability(file.scene).stable
    assert "the point does not hold" in flutter_in_words(found, [], file)[0]


@pytest.mark.long(beside="test_the_page_of_a_made_brake_draws_its_mesh_and_says_which_contacts_open")
def test_a_scene_made_in_python_has_a_study():
    s = sf.structures.chain(8, ends="fixed-free", damping=0.05)
    pad = sf.structures.RowContact("pad", {"x8": 1.0}, 1.0, sf.laws.coulomb(0.4, 0.3), speed=0.2)
    found = s.scene([pad], horizon=30.0, observe={"stretch": {"x8": 1.0, "x7": -1.0}}).study()
    assert found.result.motion.value.names[-2:] == ("stretch", "d_stretch")
    assert "stretch" in found.html()
    assert "flutter" in found.result.skipped()


@pytest.mark.long(beside="test_the_page_of_a_made_brake_draws_its_mesh_and_says_which_contacts_open")
def test_a_follower_load_is_no_coefficient_of_friction():
    """Ziegler's column with equal small dampers loses its stability under P = 41/28, by both ways."""
    text = """
        [scene]
        structure = { maker = "ziegler", damping = 1.0e-4 }
        mu = "P"
        horizon = 5.0
        [values]
        P = 1.0
        [flutter]
        mu = [0.0, 3.0]
        modes = 2
        [sweep]
        parameter = "P"
        from = 0.5
        to = 2.0
        number = 2
    """
    result = study(read_scene_text("\n".join(line.strip() for line in text.splitlines())))
    (row,) = (r for r in result.comparison.value if r.quantity == "P at the onset")
    assert row.predicted == pytest.approx(41 / 28, abs=1e-6)
    assert row.computed == pytest.approx(row.predicted, rel=1e-8)
    (first,) = flutter_in_words(result.flutter.value, [], result.file)
    assert first.startswith("From P = 1.4643 on")
    assert "coefficient of friction" not in page(result)


@pytest.mark.long(beside="test_the_page_of_a_made_brake_draws_its_mesh_and_says_which_contacts_open")
def test_names_from_other_programs_are_text(two):
    """Names of nodes and contacts may hold anything: they are neither mathematics nor HTML."""
    (two / "two" / "names.txt").write_text("<b>1:UX$_{\nn$2 & y\n")
    text = PAD.replace('points = { top = "0.5*x - y", x = "x" }', 'points = { top = { "<b>1:UX$_{" = 1.0 } }')
    text = text.replace("[friction.pad]", '[friction."<i>$a_{"]').replace("initial = { y = -0.5 }\n", "")
    text = text.replace('slip = "d_x - v_b"', 'slip = { "<b>1:UX$_{" = 1.0 }\nspeed = "v_b"').replace(
        'push = "-y"\n', ""
    )
    html = page(study(read_scene_text(text.replace('"1 + y"', "1.0"), "pad.toml", two)))
    assert "<b>1:UX" not in html
    assert "<i>$a" not in html
    assert "&lt;i&gt;$a" in html


def test_units_of_points_and_their_rates(two):
    good = PAD + '[units]\nt = "s"\ntop = "mm"\nx = "mm"\nv_b = "mm/s"\n'
    units = read_scene_text(good, "pad.toml", two).units
    assert units["d_top"] == units["d_x"] == "mm/s"
    with pytest.raises(sf.SceneError, match="units"):
        read_scene_text(good.replace('v_b = "mm/s"', 'v_b = "mm/s"\nd_x = "kg"'), "pad.toml", two)


def test_the_example_reads():
    file = read_scene_file("examples/disc_brake.toml")
    assert file.structure.full.n == 184
    assert len(file.scene.contacts) == 5
