"""Shortest decay: Coulomb's closed form, random searches, the jumps, and what cannot be met."""

import json
import re
from math import pi, sqrt

import numpy as np
import pytest

import symfric as sf
from symfric.design import contact_damper
from tests.longer import longer

G, X0 = 9.81, 0.01


def rod(**changes):
    """The rod of the source, released from 10 mm."""
    return sf.scenes.contact_damper(**{"f_n": 3.5, "mu_m": 0.1, **changes})


@pytest.mark.one_in(4)
@pytest.mark.parametrize(("low", "turns", "load"), [(2.0, 1, 1.0), (4.0, 3, 1.0), (3.0, 1, 2.0), (1.5, 1, 0.5)])
def test_constant_friction_has_a_closed_form(low, turns, load):
    # N half cycles of pi/omega end within delta = mu r g/omega^2 if x0 <= (2 N + 1) delta: the stiffest such spring
    found = contact_damper(rod(v_c=1e9, r=load), {"f_n": (low, 12.0)})
    omega = sqrt(0.1 * load * G * (2 * turns + 1) / X0)
    assert low < omega / (2 * pi)
    assert found.values["f_n"] == pytest.approx(omega / (2 * pi), rel=1e-8)
    assert found.objective == pytest.approx(turns * pi / omega, rel=1e-8)
    assert found.check.agrees, str(found.check)
    assert f"turning point {turns} just sticks" in found.active[0]
    # a hair stiffer and it takes half a cycle more
    beyond = sf.simulate(rod(v_c=1e9, r=load, f_n=found.values["f_n"] * (1 + 1e-7)))
    assert beyond["stop_time"] == pytest.approx((turns + 1) * pi / omega, rel=1e-5)
    json.dumps(found.to_dict())
    assert found.plot() is not None


@pytest.mark.one_in(2)
@pytest.mark.parametrize("most", [0.7, 1.9])
def test_the_largest_load_takes_the_fewest_half_cycles(most):
    """With constant friction the time is that of whole half cycles, and the load decides their number alone."""
    omega = 2 * pi * 5
    turns = np.ceil((X0 * omega**2 / (0.1 * most * G) - 1) / 2)
    found = contact_damper(rod(v_c=1e9, f_n=5.0), {"r": (0.3, most)})
    assert found.objective == pytest.approx(turns * pi / omega, rel=1e-9)
    assert X0 <= (2 * turns + 1) * 0.1 * found.values["r"] * G / omega**2 * (1 + 1e-9)
    assert found.check.agrees, str(found.check)


def test_rod_that_never_moves():
    found = contact_damper(rod(), {"f_n": (1.0, 12.0)})
    assert (found.objective, found.active[0]) == (0.0, "the rod sticks where it starts")
    assert contact_damper(rod(), {"f_n": (1.0, 12.0)}, residual=2e-3).objective > 0.1


@pytest.mark.one_in(3)
@pytest.mark.parametrize(
    ("bounds", "options"),
    [
        ({"mu_m": (0.02, 0.08)}, {}),
        ({"mu_m": (0.05, 0.2), "f_n": (5.0, 10.0), "zeta": (0.0, 0.05)}, {"residual": 2e-4}),
        ({"f_n": (5.0, 9.0), "zeta": (0.0, 0.1)}, {"margin": 0.2}),
    ],
)
@pytest.mark.parametrize("number", longer([200, 600], [600]))
def test_no_point_of_a_random_search_is_shorter(bounds, options, number):
    found = contact_damper(rod(), bounds, **options)
    assert found.check.agrees, str(found.check)
    draw = np.random.default_rng(7)
    scene = rod().starting({"x": X0, "u": 0.0}).until(4.0).wanting({"t": sf.StopTime(), "end": sf.End()})
    program = sf.prepare(scene.where({"zeta": 0.01}), 1e-9)
    shortest = np.inf
    for _ in range(number):
        values = {"zeta": 0.0} | {k: draw.uniform(*b) for k, b in bounds.items()}
        run = program.run(values=values)
        limit = values.get("mu_m", 0.1) * G / (2 * pi * values.get("f_n", 3.5)) ** 2
        good = abs(run.final[0]) <= min(options.get("residual", 1.0), limit * (1 - options.get("margin", 0.0)))
        if good and run["t"] < shortest:
            shortest = run["t"]
    assert found.objective <= shortest * (1 + 1e-8)
    assert found.objective > 0.8 * shortest


def test_start_with_a_velocity():
    found = contact_damper(rod(x0=0.0, v0=0.2), {"mu_m": (0.02, 0.1)})
    assert found.check.agrees, str(found.check)
    assert found.check["half cycles"].computed >= 1


@pytest.mark.long(beside="test_rod_that_never_moves")
def test_what_cannot_be_met_is_named():
    with pytest.raises(sf.NotFound, match=r"comes closest: it stays at .* m beyond the residual allowed") as told:
        contact_damper(rod(), {"mu_m": (0.055, 0.06)}, residual=1e-6)
    stays, beyond = re.search(r"stays at (\S+) m, (\S+) m beyond", str(told.value)).groups()
    assert abs(float(stays)) - float(beyond) == pytest.approx(1e-6, abs=1e-8)
    with pytest.raises(sf.NotFound, match="no values within the bounds bring the rod to rest"):
        contact_damper(rod(mu_m=0.0), {"f_n": (3.0, 4.0)})


@pytest.mark.parametrize(
    ("bounds", "options", "words"),
    [
        ({}, {}, "bounds is empty"),
        ({"x0": (0, 1)}, {}, "no parameter that contact_damper varies"),
        ({"f_n": (0, 1)}, {}, "bounds of f_n"),
        ({"mu_m": (0.2, 0.1)}, {}, "the lower one first"),
        ({"mu_m": (0.1, 0.2)}, {"residual": 0}, "residual is 0"),
        ({"mu_m": (0.1, 0.2)}, {"margin": 1}, "margin is 1"),
    ],
)
def test_bad_arguments(bounds, options, words):
    with pytest.raises(sf.SceneError, match=words):
        contact_damper(rod(), bounds, **options)
