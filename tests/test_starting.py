"""A user of the wheel has something to run: scene files to start from, `sf.read`, ``python -m symfric``."""

import subprocess
import sys
from types import ModuleType

import pytest
from click.testing import CliRunner

import symfric as sf
from symfric.cli import main
from symfric.scenefile import ready_scenes
from symfric.scenefile.starters import starter, starters
from tests.longer import longer


def call(*arguments):
    return CliRunner().invoke(main, [str(a) for a in arguments])


def test_every_ready_scene_has_a_file_to_start_from():
    assert starters() == sorted(["own", "structure", *ready_scenes()])


@pytest.mark.one_in(4)
@pytest.mark.parametrize("model", longer(starters(), ["friction_pendulum", "rocking_block"]))
def test_a_new_file_runs_as_it_is(model, tmp_path):
    place = tmp_path / "scene.toml"
    assert call("new", model, place).exit_code == 0
    scene = sf.read(place)
    assert sf.simulate(scene.until(min(scene.horizon, 10.0), {"end": sf.End()})).status == sf.Status.OK
    assert f"symfric study {place}" in place.read_text(encoding="utf-8")


def test_without_a_model_the_file_has_own_equations(tmp_path):
    found = call("new", tmp_path / "mine.toml")
    assert found.exit_code == 0
    assert "symfric study" in found.output
    assert "coordinates" in (tmp_path / "mine.toml").read_text(encoding="utf-8")


def test_a_file_is_not_replaced_unasked(tmp_path):
    place = tmp_path / "a.toml"
    place.write_text("mine", encoding="utf-8")
    assert call("new", place).exit_code == 2
    assert place.read_text(encoding="utf-8") == "mine"
    assert call("new", place, "--force").exit_code == 0


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (["mass_on_bel", "a.toml"], "did you mean mass_on_belt?"),
        (["a.txt"], "ends in .toml"),
        ([], "name the file"),
        (["a", "b", "c"], "name the file"),
    ],
)
def test_bad_words_are_one_line(words, said):
    found = call("new", *words)
    assert found.exit_code == 2
    assert said in found.output
    assert found.output.count("\n") == 1


def test_the_package_runs_as_a_module():
    done = subprocess.run([sys.executable, "-m", "symfric", "--version"], capture_output=True, text=True, timeout=60)
    assert done.stdout.startswith("symfric ")
    assert isinstance(sf, ModuleType)


@pytest.mark.parametrize("key", ["coordinates", "velocities", "force", "initial", "horizon", "mass", "slip", "normal"])
def test_a_misspelt_key_that_is_needed_names_the_right_one(key, tmp_path):
    text = starter("own")
    assert f"\n{key} = " in text
    path = tmp_path / "wrong.toml"
    path.write_text(text.replace(f"\n{key} = ", f"\n{key[:-1]} = "), encoding="utf-8")
    with pytest.raises(sf.SceneError, match=rf"did you mean {key}\?|{key} is missing; is {key[:-1]} meant"):
        sf.read(path)
