"""Steady sliding and rest with every law with memory: the linearised motion against the motion itself."""

import numpy as np
import pytest
import scipy.linalg
import sympy as sp

import symfric as sf

X, U = sp.symbols("x u", real=True)
V, C = sp.symbols("v_b c", real=True)
LAWS = {
    "Dahl": sf.laws.dahl(0.3, 20.0),
    "LuGre": sf.laws.lugre(0.4, 0.25, 0.1, 50.0, 1.0, 0.02),
    "elasto-plastic": sf.laws.elasto_plastic(0.4, 0.25, 0.1, 50.0, 1.0, z_ba=1e-3),
    "Bouc-Wen": sf.laws.bouc_wen(10.0, 40.0, 20.0, 1),
    "Bouc-Wen, sharp": sf.laws.bouc_wen(10.0, 50.0, 50.0, 2),
    "Maxwell slip": sf.laws.maxwell_slip([10, 5], [0.1, 0.2], b=0.01),
    "Iwan": sf.laws.iwan(1.0, -0.5, 0.1, elements=4),
    "rate and state": sf.laws.rate_and_state(0.3, 0.01, 0.015, 1e-1, 1e-2),
    "behind a spring": 10.0,
}
SLIPPING = [*LAWS]
RESTING = [n for n in LAWS if n != "rate and state"]


def belt(name, speed, **start):
    law = LAWS[name]
    spring = None if isinstance(law, sf.laws.Law) else law
    load = sp.Max(0, 2 + X / 10)
    contact = sf.Contact("belt", U - V, load, sf.laws.coulomb(0.3) if spring else law, stiffness=spring)
    return sf.Scene(sf.System([X], [U], [[1]], [-X - U / 10]), [contact], {V: speed}, {X: 0.0, U: 0.0, **start}, 10.0)


@pytest.mark.one_in(18)
@pytest.mark.parametrize("speed", [0.2, -0.3])
@pytest.mark.parametrize("name", SLIPPING)
def test_small_motions_about_steady_sliding_are_the_linear_ones(name, speed):
    scene = belt(name, speed)
    found, linear = sf.equilibrium(scene), sf.stability(scene)
    assert found.names == tuple(s.name for s in scene.system.states)
    assert found.sliding == {"belt": pytest.approx(-speed)}
    _same_motion(scene, found, linear)


@pytest.mark.one_in(8)
@pytest.mark.parametrize("name", RESTING)
def test_small_motions_about_rest_are_those_of_the_springs(name):
    scene = belt(name, 0.0)
    found, linear = sf.equilibrium(scene), sf.stability(scene)
    assert found.sliding == {"belt": 0.0}
    _same_motion(scene, found, linear)


def _same_motion(scene, found, linear, size=1e-6, time=4.0):
    rest = sf.simulate(scene.starting(dict(zip(scene.system.states, found.x, strict=True))).until(time), 1e-12)
    assert rest.final == pytest.approx(found.x, abs=1e-9)
    push = np.zeros(len(linear.names))
    push[0], push[1] = size, -size / 2
    start = dict(zip(found.names, found.x, strict=True))
    for name, more in zip(linear.names, push, strict=True):
        start[name] += more
    run = sf.simulate(scene.starting({s: start[s.name] for s in scene.system.states}).until(time), 1e-13)
    at = [found.names.index(n) for n in linear.names]
    expected = scipy.linalg.expm(linear.state_matrix * time) @ push
    assert (run.final - found.x)[at] == pytest.approx(expected, abs=1e-3 * size)


def test_springs_with_sliders_slide_at_their_limits_with_the_steady_law():
    scene = belt("Maxwell slip", 0.2)
    found, linear = sf.equilibrium(scene), sf.stability(scene)
    assert found.x[2:] == pytest.approx([-0.01, -0.04])
    load = 2 + found.x[0] / 10
    assert found.x[0] == pytest.approx((0.3 + 0.01 * 0.2) * load)
    assert linear.names == ("x", "u")
    assert linear.B[0, 0] == pytest.approx(0.1 + 0.01 * load)
    assert linear.K[0, 0] == pytest.approx(1 - 0.302 / 10)


def test_the_onset_of_vibration_with_maxwell_slip_is_where_its_viscous_part_is_used_up():
    system = sf.System([X], [U], [[1]], [-X + C * U])
    scene = sf.Scene(system, [sf.Contact("belt", U - V, 2, LAWS["Maxwell slip"])], {V: 0.2, C: 0.0}, {X: 0, U: 0}, 1.0)
    point = sf.hopf(scene, "c", (-0.1, 0.1))
    assert point.value == pytest.approx(0.02, rel=1e-9)
    assert point.kind == "degenerate"


@pytest.mark.parametrize("name", ["Maxwell slip", "Iwan", "behind a spring"])
def test_a_slider_at_its_limit_at_rest_is_refused_with_the_way_out(name):
    scene = belt(name, 0.0)
    state = scene.system.z[0]
    most = {"Maxwell slip": 0.01, "Iwan": (0.1 / 16) / 3, "behind a spring": 0.06}[name]
    assert sf.equilibrium(scene.starting({state: 0.9 * most})).sliding == {"belt": 0.0}
    with pytest.raises(sf.SceneError, match="at the limit"):
        sf.equilibrium(scene.starting({state: 1.5 * most}))


@pytest.mark.parametrize("name", ["Dahl", "LuGre", "Bouc-Wen"])
def test_bent_bristles_at_rest_have_two_slopes_and_no_linearisation(name):
    scene = belt(name, 0.0, **{"belt.z": 0.003})
    assert sf.equilibrium(scene).x[2] != 0
    with pytest.raises(sf.SceneError, match="no linearisation holds"):
        sf.stability(scene)


def test_rate_and_state_has_no_steady_state_at_rest():
    with pytest.raises(sf.SceneError, match="does not slip"):
        sf.equilibrium(belt("rate and state", 0.0))
