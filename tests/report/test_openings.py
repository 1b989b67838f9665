"""Scene files with contacts that open: what they say, what their study shows, and what is wrong in them in one line."""

import json
import tomllib

import numpy as np
import pytest
import sympy as sp
from click.testing import CliRunner

import symfric as sf
from symfric.cli import main
from symfric.report.explorer.views import explorer
from symfric.report.study.drawing.diagram import GROUND, diagram_of
from symfric.report.study.drawing.sketch import in_words, plot_system
from symfric.report.study.measurement import motion
from symfric.report.study.page import page
from symfric.report.study.sections.motion import plot_phase_portrait, plot_time_history
from symfric.report.study.study import study
from symfric.scenefile import read_scene_file, read_scene_text
from symfric.scenefile.writing import read_tables, with_friction_values, written

FILE = """
title = "A part between a shaken track and a stop"
[scene]
coordinates = ["x", "y"]
velocities = ["u", "v"]
mass = ["m", "m"]
force = ["-0.1*normal_force('track')", "-m*g"]
initial = { x = 0.0, y = 0.02, u = 0.8, v = 0.0 }
horizon = 1.5
[values]
m = 0.1
g = 9.81
a = 0.001
w = 70.0
e = 0.4
[friction.track]
slip = "u"
gap = "y - a*sin(w*t)"
restitution = "e"
law = "coulomb"
mu_s = 0.1
[friction."end stop"]
gap = "0.05 - x"
restitution = 0.5
[friction.guide]
slip = "u - 0.5"
normal = "0.2*normal_force('track')"
law = "coulomb"
mu_s = 0.2
[outputs]
pressed = 'max(normal_force("track"))'
rubbed = 'integral(friction_force("track")*u)'
"""


@pytest.fixture(scope="module")
def result():
    return study(read_scene_text(FILE))


def as_scene():
    x, y, u, v = sp.symbols("x y u v", real=True)
    m, g, a, w, e = sp.symbols("m g a w e", real=True)
    N = sf.normal_force
    return sf.Scene(
        system=sf.System([x, y], [u, v], sp.diag(m, m), [-N("track") / 10, -m * g]),
        contacts=[
            sf.Contact("track", u, sf.Unilateral(y - a * sp.sin(w * sf.TIME), e), sf.laws.coulomb(0.1)),
            sf.Contact("end stop", None, sf.Unilateral(0.05 - x, 0.5)),
            sf.Contact("guide", u - sp.Float(0.5), N("track") / 5, sf.laws.coulomb(0.2)),
        ],
        values={m: 0.1, g: 9.81, a: 0.001, w: 70.0, e: 0.4},
        initial={x: 0.0, y: 0.02, u: 0.8, v: 0.0},
        horizon=1.5,
        outputs={"pressed": sf.Max(N("track")), "rubbed": sf.Integral(sf.friction_force("track") * u)},
    )


def test_a_file_and_its_scene_in_python_are_one():
    read, made = read_scene_text(FILE).scene, as_scene()
    assert [c.unilateral for c in read.contacts] == [c.unilateral for c in made.contacts]
    one, other = (sf.simulate(s) for s in (read, made))
    assert one["pressed"] == pytest.approx(other["pressed"], rel=1e-12)
    assert one["rubbed"] == pytest.approx(other["rubbed"], rel=1e-12)


@pytest.mark.long(beside="test_the_sketch_shows_open_contacts")
def test_the_page_shows_gaps_impacts_and_the_contacts(result):
    assert result.motion.value.status == "OK"
    shares = result.openings.value
    assert shares["track"].impacts > 3
    assert shares["end stop"].impacts >= 1
    assert 0 < shares["track"].open < 1
    assert shares["track"].sticks + shares["track"].open <= 1 + 1e-12
    text = page(result)
    for words in (
        "restitution",
        "in an impact",
        "What the contacts do",
        "largest normal force",
        "gap and normal force",
    ):
        assert words in text
    assert "normal_force(" not in text.split("What the file asks for")[0]
    assert "friction of contact end stop" not in text  # a stop has no friction
    data = json.loads(json.dumps(result.motion.value.outputs))
    assert set(data) == {"pressed", "rubbed"}
    assert result.motion.value.energy_residual < 1e-8


def test_sections_that_do_not_apply_leave_themselves_out(result):
    for topic, reason in result.skipped().items():
        assert "\n" not in reason, topic
        assert not any(word in reason for word in ("casadi", "Traceback", "<class")), topic
    text = page(result)
    assert text.count("Contacts open and strike: no steady sliding") == 1
    assert [c.contact for c in result.friction.value] == ["track", "guide"]
    assert "opens" in result.skipped()["stability"]


def test_impacts_are_jumps_in_pictures():
    """No line between two samples of a velocity is longer than its acceleration allows, vertical ones apart."""
    m = motion(read_scene_text(FILE).scene)
    for name in ("u", "v"):
        v = m.x[m.names.index(name)]
        dt, dv = np.diff(m.t), np.abs(np.diff(v))
        assert np.max(dv[dt == 0.0]) > 0.1
        assert np.max(dv[dt > 0] / dt[dt > 0]) < 60.0
    assert np.all(np.diff(m.t) >= 0)
    for ax in (plot_time_history(m, ["v"], {}), plot_phase_portrait(m, "y", "v", ["track"], {})):
        assert ax.lines
    run = sf.simulate(sf.scenes.impact_oscillator(e=0.7, zeta=0.05, Omega=2.2, horizon=30.0))
    x, u = sf.limit_cycle(sf.scenes.impact_oscillator(e=0.7, zeta=0.05, Omega=2.2)).plot().lines[0].get_data()
    slanted = np.abs(np.diff(u)) > 0.5
    assert slanted.sum() == 1
    assert abs(np.diff(x)[slanted][0]) < 1e-9
    assert run.plot().lines


def test_the_sketch_shows_open_contacts():
    diagram = diagram_of(read_scene_text(FILE).scene)
    gaps = {link.name: (link.first, link.second) for link in diagram.links if link.kind == "gap"}
    assert gaps == {"track": (1, GROUND), "end stop": (0, GROUND)}
    assert {s.name for s in diagram.surfaces} == {"track", "guide"}
    assert "gap of contact end stop between x and the ground" in in_words(diagram)
    written_ = {text.get_text() for text in plot_system(diagram).texts}
    assert "end stop" in written_
    x, u, x2, u2 = sp.symbols("x u x2 u2", real=True)
    play = sf.Scene(
        sf.System([x, x2], [u, u2], sp.eye(2), [0, 0]),
        sf.stops(x2 - x, -1, 1),
        {},
        dict.fromkeys((x, x2, u, u2), 0),
        1.0,
    )
    assert [(k.first, k.second) for k in diagram_of(play).links] == [(0, 1), (0, 1)]


def test_the_explorer_moves_restitution_and_shows_laws_of_contacts_with_friction(tmp_path):
    place = tmp_path / "part.toml"
    place.write_text(FILE, encoding="utf-8")
    made = explorer(read_scene_file(place))
    assert [c.name for c in made.rubbing] == ["track", "guide"]
    values = {r.name: r.value for r in made.ranges}
    assert {"e", "restitution", "mu_s"} <= set(values)
    one, other = made.view(values), made.view({**values, "e": 0.9})
    assert one.status == other.status == ""
    assert not np.array_equal(one.x, other.x)
    assert 'restitution = "e"' in made.toml({**values, "e": 0.9}, {r.name: r.value for r in made.starts})


def test_tables_go_to_a_file_and_back():
    tables = tomllib.loads(FILE)
    again = read_tables(tables, "part.toml")
    assert again.scene.contacts == read_scene_text(FILE).scene.contacts
    opened = with_friction_values(tables, "part.toml")
    assert opened["values"]["restitution"] == 0.5
    assert written(opened)


def test_commands_take_such_files(tmp_path):
    place = tmp_path / "part.toml"
    place.write_text(FILE, encoding="utf-8")
    explained = CliRunner().invoke(main, ["explain", str(place)])
    assert explained.exit_code == 0
    assert "2 contacts that can open" in explained.output
    exported = CliRunner().invoke(main, ["export", str(place), "--to", "c", "--step", "0.01"])
    assert exported.exit_code == 2
    assert "opens and strikes" in exported.output
    swept = CliRunner().invoke(main, ["sweep", str(place), "-o", str(tmp_path / "out"), "--quiet"])
    assert swept.exit_code == 2  # the file has no grid
    assert "Traceback" not in swept.output


def changed(old, new):
    assert FILE.count(old) == 1
    return FILE.replace(old, new)


@pytest.mark.parametrize(
    ("text", "said"),
    [
        (changed('gap = "0.05 - x"\n', ""), r"friction.end stop.slip is missing"),
        (changed('gap = "0.05 - x"', 'gap = "0.05 - u"'), "gap of contact 'end stop' is 0.05 - u; it may depend on"),
        (changed('gap = "0.05 - x"', 'gap = "0.05 - a"'), "it contains no coordinate"),
        (changed('gap = "0.05 - x"', 'gap = "-0.05 - x"'), "gap of contact 'end stop' is -0.05 at the start"),
        (
            changed('gap = "0.05 - x"', 'gap = "0.05 - x"\nlaw = "coulomb"\nmu_s = 0.1'),
            "friction.end stop.law needs a slip",
        ),
        (changed('gap = "0.05 - x"', 'gap = "0.05 - x"\nnormal = 1'), "friction.end stop.normal: the normal force"),
        (changed("restitution = 0.5", "restitution = 1.5"), "restitution of a unilateral contact is 1.5"),
        (changed("restitution = 0.5", 'restitution = "x"'), "restitution of contact 'end stop' is x"),
        (changed("e = 0.4", "e = 1.4"), "restitution of contact 'track' is 1.4"),
        (
            changed('slip = "u - 0.5"', 'slip = "u - 0.5"\nrestitution = 0.1'),
            "friction.guide.restitution is for contacts that open",
        ),
        (changed("0.2*normal_force('track')", "normal_force('stop')"), "friction.guide.normal: no contact 'stop'"),
        (changed("0.2*normal_force('track')", "normal_force('guide')"), "friction.guide.normal: no contact 'guide'"),
        (changed("-0.1*normal_force('track')", "-0.1*friction_force('track')"), "is allowed in \\[outputs\\] only"),
        (changed('law = "coulomb"\nmu_s = 0.1', ""), "friction.track.law is missing"),
        (changed("restitution = 0.5", "restitutio = 0.5"), "restitutio"),
    ],
)
def test_what_is_wrong_is_one_line(text, said):
    with pytest.raises(sf.SceneError, match=said) as error:
        read_scene_text(text)
    assert "\n" not in str(error.value)


@pytest.mark.parametrize("model", ["mass_on_belt", "coulomb_oscillator"])
def test_ready_scenes_and_structures_have_no_gaps_of_a_file(model):
    with pytest.raises(sf.SceneError, match="friction.gap: contacts that open are for own equations"):
        read_scene_text(f'[scene]\nmodel = "{model}"\n[friction]\nlaw = "coulomb"\nmu_s = 0.3\ngap = "x"')
