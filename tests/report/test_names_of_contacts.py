"""States of contacts whose names are no words: start values, outputs and unknowns in scene files."""

import json

import pytest
import sympy as sp

import symfric as sf
from symfric.scenefile import read_scene_text

FILE = """
[scene]
horizon = 5.0
coordinates = ["x"]
velocities = ["u"]
force = ["-x"]
mass = [["1"]]
[scene.initial]
x = 0.1
u = 0.0
{start}
[values]
v_b = 0.2
[outputs]
bent = {output}
[friction.{name}]
slip = "u - v_b"
normal = "1"
law = "dahl"
mu_c = 0.3
sigma = 10.0
"""
NAMES = ["left pad", "left-pad", "pad.1", "1st", "Ä b", "it's"]


def scene_of(name, start, output):
    quoted = json.dumps(name, ensure_ascii=False)
    return read_scene_text(FILE.format(name=quoted, start=start, output=json.dumps(output, ensure_ascii=False))).scene


@pytest.mark.parametrize("name", ["belt", *NAMES])
def test_a_quoted_name_starts_a_state_and_stands_in_outputs(name):
    key = json.dumps(f"{name}.z", ensure_ascii=False)
    for quoted in {repr(f"{name}.z"), json.dumps(f"{name}.z", ensure_ascii=False)}:
        scene = scene_of(name, f"{key} = 0.01", f"max(2 * {quoted} - x)")
        z = sp.Symbol(f"{name}.z", real=True)
        assert scene.numbers()[z] == 0.01
        assert scene.outputs["bent"].expr == 2 * z - sp.Symbol("x", real=True)


@pytest.mark.parametrize(("name", "key"), [("left-pad", "left-pad.z"), ("pad.1", "pad.1.z"), ("a.b.c", "a.b.c.z")])
def test_a_bare_key_of_tables_inside_tables_is_the_same_name(name, key):
    scene = scene_of(name, f"{key} = 0.02", f"max('{name}.z')")
    assert scene.numbers()[sp.Symbol(f"{name}.z", real=True)] == 0.02


def test_a_word_needs_no_quotes():
    assert scene_of("belt", "belt.z = 0.02", "max(belt.z)").outputs["bent"].expr == sp.Symbol("belt.z", real=True)


@pytest.mark.parametrize(
    ("output", "words"),
    [("max('left pad.q')", "string 'left pad.q'"), ("max('right pad.z')", "string 'right pad.z'")],
)
def test_other_strings_are_refused(output, words):
    with pytest.raises(sf.SceneError, match=words):
        scene_of("left pad", '"left pad.z" = 0.0', output)
