"""Every public design can be asked for in a scene file: an example for each, from the table to the page."""

import re
from pathlib import Path

import pytest

import symfric as sf
from symfric.design.plans import PLANS
from symfric.report.study import designs
from symfric.report.study.page import page
from symfric.report.study.study import study
from symfric.scenefile import read_scene_file

FOLDER = Path(__file__).parents[2] / "examples" / "designs"
KINDS = [plan.kind for plan in PLANS]
SHOWN = {
    "quench": r"Asked: the smallest intensity .* in proportion to the measured belt speed\.",
    "damper": r"for the smallest peak of .* over .* from 1 to 1\.2\.",
    "controller": r"Asked: the largest .* with which a half range of at most 0\.1 is left by .* = .*150.*",
    "sprung_foundation": r"an absorber of equal mass stabilises",
    "collocation": r"functions of time that reach <math>.*in the least time\.",
}
SUMMARY = {
    "positioning": "The least positioning error: sigma = 0.15472.",
    "absorber": "A tuned mass damper: tuning = 0.93154, damping = 0.15254.",
    "isolator": "Damping and friction of the isolator: C = 1000.",
    "contact_damper": "The soonest rest by a contact: f_n = 4.4515 Hz.",
}


def test_every_public_design_has_a_table_and_an_example():
    functions = {n for n in sf.design.__all__ if not isinstance(getattr(sf.design, n), type)}
    assert functions == set(KINDS) == {path.stem for path in FOLDER.glob("*.toml")} == {*SHOWN, *SUMMARY}


@pytest.mark.one_in(4)
@pytest.mark.parametrize("kind", SUMMARY)
def test_a_design_of_a_file(kind):
    file = read_scene_file(FOLDER / f"{kind}.toml")
    (plan,) = file.designs
    found = plan(file.scene)
    assert found.check.agrees
    assert designs.sentence(plan, found, file) == SUMMARY[kind]
    assert {name for name, _, _ in designs.rows(plan, found, file)} > set(plan.varied)


@pytest.mark.long(beside="test_a_design_of_a_file")
@pytest.mark.parametrize("kind", SHOWN)
def test_a_design_on_a_page(kind):
    result = study(read_scene_file(FOLDER / f"{kind}.toml"))
    (made,) = result.designs.value
    assert made.design.value.check.agrees
    text = page(result)
    assert re.search(SHOWN[kind], text)
    assert f'id="{kind}"' in text
    assert made.plan.caption in text


def test_the_scene_of_a_quench_that_follows_the_belt_is_shown():
    file = read_scene_file(FOLDER / "quench.toml")
    (plan,) = file.designs
    found = plan(file.scene)
    assert "k" in {s.name for s in plan.excited(file.scene, found).parameters}
    assert plan.working(found)[0]["k"] > found.values["k"]


def test_an_integrand_is_an_expression_of_the_scene():
    text = (FOLDER / "collocation.toml").read_text(encoding="utf-8").replace("[0.1, 10]", "[3, 3]")
    file = sf.scenefile.read_scene_text(text + 'minimise = "w**2"\ndegree = 1\n')
    (plan,) = file.designs
    assert plan(file.scene).objective == pytest.approx(0.714444, rel=1e-4)
