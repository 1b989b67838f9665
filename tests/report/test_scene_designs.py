"""Designs in scene files: what a table means, what is wrong with it in one line, and what the page shows of it."""

import json
import re

import numpy as np
import pytest

import symfric as sf
from symfric.report.study.data import to_dict
from symfric.report.study.page import page
from symfric.report.study.sections.comparison import of_design
from symfric.report.study.study import study
from symfric.scenefile import read_scene_file, read_scene_text

BELT = '[scene]\nmodel = "mass_on_belt"\nhorizon = 50\n[values]\nv_b = 0.2\nbeta = 0.05\n'
SLIDE = '[scene]\nmodel = "drive_slide"\n[values]\nmu1 = -0.5\nmu2 = 0.1\np_star = -0.2\nepsilon = 1.0\nsigma = 0.0\n'
ROD = '[scene]\nmodel = "contact_damper"\n[values]\nf_n = 5\nmu_m = 0.1\n'
ABSORBER = '[scene]\nmodel = "absorber"\n[values]\nmass_ratio = 0.1\ntuning = 0.9\ndamping = 0.2\n'
BURST = '{ kind = "sine_burst", pga = 0.2, frequency = 1.5, unit = "g" }'
HOUSE = f'[scene]\nmodel = "rolling_isolator"\nprofile = 0.01\nmotion = {BURST}\n[values]\nC = 1e5\nm = 3e5\n'
BLOCK = (
    '[scene]\ncoordinates = "x"\nvelocities = "u"\nmass = 1\nforce = "w"\ninitial = { x = 0, u = 0 }\nhorizon = 1\n'
    "[values]\nw = 0\n[design.collocation]\ncontrols = { w = [-1, 1] }\nend = { x = 1, u = 0 }\ntime = [0.1, 10]\n"
)
QUENCH = "[design.quench]\nspeeds = [0.1, 0.4]\nOmega = [20, 60]\na = [0, 0.05]\n"
DAMPER = '[design.damper]\nparameter = "beta"\nbounds = [0, 1]\n'
DISH = f'[scene]\nmodel = "friction_pendulum"\nmotions = [{BURST}, {BURST}]\n[values]\nR = 2\nmu = 0.06\nm = 1\n'
BEARING = "[design.isolator]\nbounds = { mu = [0.01, 0.1] }\n"
ISOLATOR = "[design.isolator]\nbounds = { C = [1e3, 1e6], mu = [0.001, 0.1] }\n"


def test_a_table_is_the_call_of_its_function():
    file = read_scene_text(
        BELT + QUENCH + "[design.quench.limits]\nfriction = 0.2\npower = 1\n" + DAMPER + "settle = 9\n"
    )
    limits = {"friction": 0.2, "power": 1.0}
    assert [p.kind for p in file.designs] == ["quench", "damper"]
    expected = {
        "speeds": (0.1, 0.4),
        "Omega": (20.0, 60.0),
        "a": (0.0, 0.05),
        "minimise": "intensity",
        "margin": 0.0,
        "follow": False,
    }
    assert file.plan("quench").arguments == {**expected, "limits": limits}
    expected = {"parameter": "beta", "bounds": (0.0, 1.0), "half_range": 0.0, "sticking": True, "settle": 9.0}
    assert file.plan("damper").arguments == expected
    assert file.plan("damper").varied == ("beta",)


@pytest.mark.long(beside="test_a_table_is_the_call_of_its_function")
def test_a_table_gives_the_design_of_its_function():
    belt = sf.scenes.mass_on_belt(v_b=0.2)
    found = read_scene_text(BELT + DAMPER + "speeds = [0.3, 0.45]\n").plan("damper")(belt)
    assert found.values == sf.design.damper(belt, "beta", (0, 1), (0.3, 0.45)).values


@pytest.mark.long(beside="test_designs_are_in_the_data")
def test_ready_scenes_are_designed_from_files():
    tables = {
        SLIDE + '[design.positioning]\nparameter = "sigma"\nbounds = [0, 1]\nspeeds = [1.25, 5]\n': {"sigma": 0.154719},
        SLIDE.replace("-0.5", "0.1").replace("1.0", "0.05")
        + '[design.positioning]\nparameter = "ramp"\nbounds = [0, 10]\nspeeds = [0.5, 0.5]\n': {"ramp": 6.3817},
        ABSORBER + "[design.absorber]\n": {"tuning": 0.909058, "damping": 0.185470},
        BELT + '[design.absorber]\nmass_ratio = 0.1\ncriterion = "h2"\n': {"tuning": 0.931541, "damping": 0.152540},
    }
    for text, values in tables.items():
        file = read_scene_text(text)
        (plan,) = file.designs
        assert plan(file.scene).values == pytest.approx(values, rel=1e-3)


def test_motions_come_from_tables_and_from_records_beside_the_file(tmp_path):
    burst = sf.motions.sine_burst(0.2, 1.5, unit="g")
    samples = np.round(burst.samples[::5], 9)
    (tmp_path / "quake.txt").write_text("".join(f"{k * 5 * burst.dt:.9f} {a:.9f}\n" for k, a in enumerate(samples)))
    record = '{ file = "quake.txt", unit = "m/s^2" }'
    path = tmp_path / "house.toml"
    path.write_text(
        HOUSE.replace(BURST, record) + ISOLATOR + f"motions = [{BURST}, {record}]\nlimits.displacement = 0.1\n"
    )
    file = read_scene_file(path)
    plan = file.plan("isolator")
    assert np.array_equal(plan.arguments["motions"][0].samples, burst.samples)
    assert plan.arguments["motions"][1].samples == pytest.approx(samples)
    found = plan(file.scene)
    assert found.check.agrees
    assert found.check.worst["displacement"] <= 0.1 * (1 + 1e-6)
    assert set(found.values) == {"C", "mu"}


@pytest.mark.long(beside="test_motions_come_from_tables_and_from_records_beside_the_file")
def test_pairs_of_motions_shake_an_isolator_in_two_directions():
    other = BURST.replace("1.5", "1.0").replace("0.2", "0.1")
    file = read_scene_text(DISH + BEARING + f"motions = [[{BURST}, {other}]]\nlimits.displacement = 0.2\n")
    plan = file.plan("isolator")
    ((x, y),) = plan.arguments["motions"]
    assert (max(abs(x.samples)), max(abs(y.samples))) == pytest.approx((0.2 * 9.80665, 0.1 * 9.80665), rel=1e-3)
    assert (plan.arguments["bounds"], plan.arguments["limits"]) == ({"mu": (0.01, 0.1)}, {"displacement": 0.2})
    answered = study(file)
    (made,) = answered.designs.value
    found = made.design.value
    assert found.check.agrees
    assert found.check.worst["displacement"] <= 0.2 * (1 + 1e-6)
    told = page(answered)
    assert "for the least acceleration, one pair" in re.sub("<[^>]*>", "", told)


BAD = [
    (
        DISH + BEARING + f"motions = [{BURST}]\n",
        "motions[0] is one motion; friction_pendulum moves in two directions: w",
    ),
    (HOUSE + ISOLATOR + f"motions = [[{BURST}, {BURST}]]\n", "motions[0] is a pair of motions; rolling_isolator moves"),
    (
        DISH + BEARING + f"motions = [[{BURST}]]\n",
        "design.isolator.motions[0] has 1 motions; a pair has two, along x a",
    ),
    (DISH + BEARING + "motions = [[3, 4]]\n", "design.isolator.motions[0][0] is a number; write a section"),
    (DISH + BEARING + f'motions = [[{BURST}, {{ kind = "noise" }}]]\n', "motions[0][1].kind is 'noise'; it must be"),
    (DISH + BEARING + f"motions = [[{BURST}, {{ pga = 1 }}]]\n", "design.isolator.motions[0][1] needs one of file"),
    (BELT + "[design.dampr]\nspeeds = [0, 1]\n", "[design] has no key 'dampr'; did you mean damper?"),
    (BELT + '[design.damper]\nparameter = "beta"\n', "design.damper.bounds is missing"),
    (BELT + DAMPER.replace("beta", "betta"), "design.damper.parameter: no value 'betta'; did you mean beta?"),
    (BELT + DAMPER + 'speed = "w"\n', "design.damper.speed: no value 'w'"),
    (BELT + DAMPER.replace("[0, 1]", "[1, 0]"), "design.damper.bounds is [1, 0]; write [smallest, largest]"),
    (BELT + DAMPER.replace("[0, 1]", "[0, 1, 2]"), "design.damper.bounds"),
    (BELT + DAMPER + "settle = -1\n", "design.damper.settle is -1; it must be positive"),
    (BELT + DAMPER + 'sticking = "no"\n', "design.damper.sticking is 'no'"),
    (BELT + DAMPER + "speeds = 0.2\n", "design.damper.speeds is 0.2"),
    (
        BELT + QUENCH + "limits = { frction = 0.5 }\n",
        "[design.quench.limits] has no key 'frction'; did you mean friction?",
    ),
    (BELT + QUENCH + "limits = { power = 0 }\n", "design.quench.limits.power is 0; it must be positive"),
    (BELT + QUENCH + 'limits = { power = "1 W" }\n', "design.quench.limits.power is the string '1 W', not a number"),
    (BELT + QUENCH + "limits = 3\n", "write a section [design.quench.limits]"),
    (BELT + QUENCH + "margin = -1\n", "design.quench.margin is -1"),
    (
        BELT + '[design.positioning]\nparameter = "sigma"\nbounds = [0, 1]\nspeeds = [1, 2]\n',
        "takes the ready scene drive_slide",
    ),
    (
        SLIDE + '[design.positioning]\nparameter = "mu3"\nbounds = [0, 1]\nspeeds = [1, 2]\n',
        "parameter is 'mu3'; it must be",
    ),
    (BELT + "[design.absorber]\n", "design.absorber.mass_ratio is missing"),
    (BELT + '[design.absorber]\nmass_ratio = 0.1\ncriterion = "h3"\n', "criterion is 'h3'; it must be"),
    (BELT + QUENCH + "k = [1, 2]\n", "design.quench.k is the ratio a Omega/v_b; it needs follow = true"),
    (BELT + QUENCH + 'follow = "yes"\n', "design.quench.follow is 'yes'"),
    (BELT + QUENCH.replace("[20, 60]", "[20]"), "design.quench.Omega is [20]; write [smallest, largest]"),
    (BELT + DAMPER + 'coordinate = "y"\n', "design.damper.coordinate: no state 'y'"),
    (BELT + "[design.sprung_foundation]\n", "design.sprung_foundation.mass_ratio is missing"),
    (
        BELT + "[design.sprung_foundation]\nmass = 1\n",
        "[design.sprung_foundation] has no key 'mass'; did you mean mass_ra",
    ),
    (BELT + "[design.sprung_foundation]\nmass_ratio = 0\n", "design.sprung_foundation.mass_ratio is 0; it must be pos"),
    (
        BELT + "[design.sprung_foundation]\nmass_ratio = 1\nleast_stiffness = -1\n",
        "design.sprung_foundation.least_stiffness is -1; it must not be negative",
    ),
    (BLOCK.replace("{ w =", "{ v ="), "design.collocation.controls: no value 'v'"),
    (BLOCK.replace("[-1, 1]", "[1, -1]"), "design.collocation.controls.w is [1, -1]; write [smallest, largest]"),
    (BLOCK.replace("u = 0 }\nt", "v = 0 }\nt"), "design.collocation.end: no state 'v'"),
    (BLOCK.replace("u = 0 }\nt", 'u = "0" }\nt'), "design.collocation.end.u is the string '0', not a number"),
    (BLOCK.replace("[0.1", "[-0.1"), "design.collocation.time is [-0.1, 10]; write [smallest, largest], not negative"),
    (BLOCK + 'minimise = "w**2 + y"\n', "design.collocation.minimise: unknown name y"),
    (BLOCK + "elements = 0\n", "design.collocation.elements is 0"),
    (BLOCK + "degree = 2\n", "design.collocation.degree is 2; it must be 0 or 1"),
    ("[design]\nquench = 3\n" + BELT, "design.quench is a number; write a section [design.quench]"),
    (BELT.replace("[scene]", "design = 3\n[scene]"), "design is a number; write a section [design]"),
    (ROD + "[design.contact_damper]\nbounds = {}\n", "design.contact_damper.bounds"),
    (ROD + "[design.contact_damper]\nbounds = { f = [4, 9] }\n", "bounds: no value 'f'"),
    (ROD + "[design.contact_damper]\nbounds = { f_n = [9, 4] }\n", "design.contact_damper.bounds.f_n is [9, 4]"),
    (ROD + ISOLATOR + f"motions = [{BURST}]\n", "[design.isolator] takes the ready scene rolling_isolator"),
    (HOUSE + ISOLATOR, "design.isolator.motions is missing"),
    (HOUSE + ISOLATOR + "motions = []\n", "design.isolator.motions"),
    (HOUSE + ISOLATOR + 'motions = ["a.at2"]\n', "motions[0].file: a record's path is relative to a scene file"),
    (HOUSE + ISOLATOR + "motions = [{ pga = 1 }]\n", "design.isolator.motions[0] needs one of file"),
    (HOUSE + ISOLATOR + 'motions = [{ kind = "noise" }]\n', "motions[0].kind is 'noise'; it must be"),
    (HOUSE + ISOLATOR + 'motions = [{ kind = "synthetic", sed = 1 }]\n', "no argument 'sed'; did you mean seed?"),
    (HOUSE + ISOLATOR + 'motions = [{ kind = "synthetic" }]\n', "motions[0] needs seed"),
    (HOUSE + ISOLATOR + f"motions = [{BURST.replace('1.5', '1.5, cycles = 1e9')}]\n", "take fewer"),
    (HOUSE + ISOLATOR + 'motions = [{ kind = "synthetic", seed = 1, iterations = 1e6 }]\n', "take fewer"),
    (HOUSE + ISOLATOR + f"motions = [{BURST.replace('0.2', '-0.2')}]\n", "design.isolator.motions[0]: a burst of pga"),
    (HOUSE.replace(f"motion = {BURST}\n", ""), "scene.motion is missing"),
    (HOUSE.replace(BURST, "3"), "scene.motion is a number; write a section"),
    (BELT.replace("horizon", f"motion = {BURST}\nhorizon"), "mass_on_belt has no argument 'motion'"),
]


@pytest.mark.one_in(3)
@pytest.mark.parametrize(("text", "part"), BAD, ids=[f"{k}-{b[1][:30]}" for k, b in enumerate(BAD)])
def test_a_bad_table_ends_in_one_clear_line(text, part):
    with pytest.raises(sf.SceneError) as error:
        read_scene_text(text)
    message = str(error.value)
    assert part in message
    assert "\n" not in message
    assert "pydantic" not in message


def test_a_record_that_is_not_there(tmp_path):
    path = tmp_path / "house.toml"
    path.write_text(HOUSE.replace(BURST, '"gone.at2"'))
    with pytest.raises(sf.SceneError, match=r"house\.toml: scene\.motion: .*gone\.at2.*no such file"):
        read_scene_file(path)


@pytest.fixture(scope="module")
def rod():
    """The study of a rod with two designs, one of which cannot be met."""
    impossible = '[design.damper]\nparameter = "mu_m"\nbounds = [0.01, 0.3]\nsettle = 0.01\n'
    units = '[units]\nf_n = "Hz"\n'
    return study(read_scene_text(ROD + "[design.contact_damper]\nbounds = { f_n = [4, 9] }\n" + impossible + units))


@pytest.mark.long(beside="test_designs_are_in_the_data")
def test_the_page_shows_every_design(rod):
    text = page(rod)
    assert text.index('id="damper"') < text.index('id="contact_damper"') < text.index('id="how"')
    assert re.search("Asked: the smallest <math>.*?</math> from 0.01 to 0.3 with which the motion is at rest by", text)
    assert "Not designed: no motion within the bounds (0.01, 0.3) of mu_m settles by t = 0.01" in text
    assert re.search("Asked: <math>.*?</math> from 4 to 9 Hz for the soonest rest.", text)
    assert ">Hz</td>" in text
    assert re.search('alt="decay time[^"$]* against f_n', text)
    assert "Stopping the vibration" not in text
    (row,) = [r for r in rod.comparison.value if r.quantity == "decay time"]
    assert row.predicted == pytest.approx(row.computed, rel=1e-9)
    assert "design damper" in rod.skipped()


def test_designs_are_in_the_data(rod):
    data = json.loads(json.dumps(to_dict(rod), allow_nan=False))
    assert data["designs"]["damper"] is None
    found = data["designs"]["contact_damper"]
    assert found["check"]["agrees"]
    assert set(found["values"]) == {"f_n"}


@pytest.mark.long(beside="test_designs_are_in_the_data")
def test_a_damper_is_compared_with_thomsen():
    file = read_scene_text(BELT + DAMPER + "speeds = [0.3, 0.45]\n")
    made = file.plan("damper")(file.scene)

    (row,) = of_design(file, file.plan("damper"), made)
    assert row.formula == "Thomsen (19)"
    assert row.predicted == pytest.approx(0.3, rel=1e-9)
    assert row.computed == pytest.approx(0.3, rel=1e-12)
