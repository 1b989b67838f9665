"""Friction in the plane typed as a force is answered with the contact; forces that only look alike are taken."""

import pytest
import sympy as sp

import symfric as sf
from symfric.scenefile import read_scene_text

x, y, u, w = sp.symbols("x y u w", real=True)
mu, N, v, k = sp.symbols("mu N v_b k", positive=True)
LENGTH = sp.sqrt(u**2 + w**2)


def system(*force):
    return sf.System([x, y], [u, w], sp.eye(2), force)


@pytest.mark.parametrize(
    ("force", "slips"),
    [
        ((-mu * N * u / LENGTH, -mu * N * w / LENGTH), "u, w"),
        ((-k * x - mu * N * u / LENGTH, 0), "u, w"),
        ((0, 1 - (mu + sp.exp(-LENGTH)) * N * w / LENGTH), "u, w"),
        ((-mu * (u - v) / sp.sqrt((u - v) ** 2 + w**2), 0), "u - v_b, w"),
        ((-mu * (v - u) / sp.sqrt((u - v) ** 2 + w**2), 0), "-u \\+ v_b, w|u - v_b, w"),
    ],
)
def test_it_is_named_with_its_cure(force, slips):
    with pytest.raises(sf.SceneError, match=rf"has the direction of \(({slips})\).* sf\.Contact\(name, slip="):
        system(*force)


@pytest.mark.parametrize(
    "force",
    [
        (-k * u * LENGTH, -k * w * LENGTH),  # drag
        (-x / sp.sqrt(x**2 + y**2) ** 3, -y / sp.sqrt(x**2 + y**2) ** 3),  # gravity
        (-x / sp.sqrt(x**2 + y**2), 0),  # a string under constant tension
        (-mu * u / sp.sqrt(u**2 + w**2 + v**2), 0),  # regularised
        (-u / sp.sqrt(1 + u**2), 0),
    ],
)
def test_others_are_taken(force):
    assert system(*force).force == tuple(map(sp.sympify, force))


def test_a_scene_file_says_so():
    text = """
[scene]
coordinates = ["x", "y"]
velocities = ["u", "w"]
mass = ["m", "m"]
force = ["-mu*m*9.81*u/sqrt(u**2 + w**2)", "-mu*m*9.81*w/sqrt(u**2 + w**2)"]
initial = { x = 0, y = 0, u = 1, w = 0 }
horizon = 1
[values]
m = 1
mu = 0.3
"""
    with pytest.raises(sf.SceneError, match=r"force\[0\] has the direction of \(u, w\)"):
        read_scene_text(text, "typed.toml")
