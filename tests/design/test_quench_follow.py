"""Excitation that follows the measured belt speed, a Omega = k v_b, against closed forms and runs of the full model."""

import numpy as np
import pytest
import sympy as sp

import symfric as sf
from symfric.design import quench
from symfric.theory import belt
from tests.design.test_quench import LAWS, SHARES, scene

BOUNDS = {"Omega": (50.0, 60.0), "a": (0.0, 0.02)}


def least_damping(name, speeds, k, beta=0.05):
    """Least damping over the belt speeds by the midpoint rule."""
    _, _, slope = LAWS[name]
    v = np.linspace(*speeds, 400)
    split = np.arccos(min(1 / k, 1.0))
    found = 2 * beta
    for low, width in ((0.0, split), (split, np.pi - split)):
        w = v[:, None] * (1 - k * np.cos(low + width * SHARES))
        found = found + width / np.pi * slope(abs(w)).mean(axis=1)
    jump = 2 * LAWS[name][1](0.0) / (np.pi * v * np.sqrt(k**2 - 1)) if k > 1 else 0.0
    return (found + jump).min()


@pytest.mark.one_in(3)
@pytest.mark.parametrize("low", [0.385, 0.4, 0.43])
def test_the_least_ratio_on_fast_belts_is_that_of_thomsen_55(low):
    found = quench(scene(), (low, 0.44), **BOUNDS, follow=True)
    k = np.sqrt(2 * ((belt.onset_speed(scene()) / low) ** 2 - 1))
    assert found.values["k"] == pytest.approx(k, rel=1e-8)
    assert found.objective == pytest.approx(k * 0.44, rel=1e-8)
    assert found.status == "optimal"
    assert found.check.agrees


@pytest.mark.one_in(3)
@pytest.mark.parametrize("speeds", [(0.2, 0.2), (0.05, 0.43), (0.0, 0.3)])
def test_on_slow_belts_any_ratio_above_one_does_it(speeds):
    found = quench(scene(), speeds, **BOUNDS, follow=True)
    assert found.status == "infimum"
    assert found.values["k"] == 1.0
    assert belt.onset_speed(scene()) > speeds[0] * np.sqrt(1.5)  # below this speed k = 1 is not enough


def test_it_leaves_the_friction_that_a_fixed_intensity_takes():
    found = quench(scene(), (0.2, 0.2), **BOUNDS, follow=True, k=(1.05, 2.0), limits={"friction": 0.5, "power": 0.1})
    share, power, running = found.check.limits
    fixed = belt.quench_intensity(scene())
    values = []
    for q in (0.21, fixed):
        shaken = scene(a=q / 50, Omega=50.0)
        values += [belt.effective_friction(shaken)(0.2) / LAWS["cubic"][1](0.2), belt.mean_power(shaken)]
    assert (share.predicted, power.predicted) == pytest.approx(values[:2], rel=1e-9)
    assert values == pytest.approx([0.7745766, 0.01061310, 0.2798901, 0.06199937], rel=1e-6)
    assert found.check.agrees
    assert share.computed == pytest.approx(share.predicted, rel=0.01)
    assert running.computed == pytest.approx(running.predicted, rel=0.02)


@pytest.mark.long(beside="test_the_least_ratio_on_fast_belts_is_that_of_thomsen_55")
@pytest.mark.parametrize(("name", "speeds"), [("cubic", (0.3, 0.5)), ("stribeck", (0.22, 0.6)), ("gauss", (0.2, 0.5)), ("linear pieces", (0.35, 0.7)), ("lorentz", (0.25, 0.6)), ("exponential", (0.4, 0.8))])  # fmt: skip
def test_ratio_for_other_laws_against_a_dense_grid(name, speeds):
    k = np.linspace(0.02, 1.6, 159)
    feasible = k[[least_damping(name, speeds, e) >= 0 for e in k]]
    try:
        found = quench(scene(name), speeds, Omega=(50.0, 50.0), a=(0.0, 1.6 * speeds[1] / 50), follow=True)
    except sf.NotFound:
        assert not feasible.size
        return
    assert found.values["k"] <= feasible[0] + 1e-9
    assert found.values["k"] > feasible[0] - 0.0101
    assert found.check.agrees


@pytest.mark.long(beside="test_the_least_ratio_on_fast_belts_is_that_of_thomsen_55")
def test_the_error_of_averaging_falls_with_the_square_of_the_frequency():
    limits = {"friction": 0.1}
    errors = []
    for Omega in (100.0, 200.0, 400.0):
        bounds = {"Omega": (Omega, Omega), "a": (0.0, 0.1)}
        found = quench(scene(), (0.1, 0.1), **bounds, follow=True, k=(1.2, 2.0), limits=limits)
        share = found.check.limits[0]
        errors.append(abs(share.computed - share.predicted))
    assert 3.5 < errors[0] / errors[1] < 4.5
    assert 3.5 < errors[1] / errors[2] < 4.5


def test_the_scene_of_the_design_follows_a_belt_that_changes_its_speed():
    found = quench(scene(), (0.05, 0.4), **BOUNDS, follow=True, k=(1.05, 2.0))
    slow = {}
    for k in (1.05, 0.0):
        given = found.scene.where({"k": k, "Omega": 50.0})
        for v in (0.1, 0.2, 0.3):
            run = sf.simulate(given.where({"v_b": v}).until(60 * np.pi))
            x = run(np.arange(1200, 1500) * 2 * np.pi / 50)[0]  # once a period of the excitation
            slow[k, v] = np.ptp(x) / v
    assert max(slow[1.05, v] for v in (0.1, 0.2, 0.3)) < 1e-4
    assert min(slow[0.0, v] for v in (0.1, 0.2, 0.3)) > 1


def ramped(k):
    """A belt that runs from .4 down to .05 and back while a sensor with a lag of .05 measures it."""
    x, u, seen = sp.symbols("x u seen", real=True)
    v_b = 0.225 + 0.175 * sp.cos(sf.TIME / 20)
    force = -x - u / 10 + k * seen * 50 * sp.sin(50 * sf.TIME)
    system = sf.System(q=[x], u=[u], mass=[[1]], force=[force], z=[seen], z_rate=[20 * (v_b - seen)])
    contact = sf.Contact("belt", slip=u - v_b, normal=1, law=LAWS["cubic"][0])
    return sf.Scene(system, [contact], {}, {x: 0.24, u: 0.0, seen: 0.4}, 40 * np.pi)


def test_a_sensor_drives_the_excitation_on_a_belt_that_changes_its_speed():
    largest = {}
    for k in (0, 1.05):
        run = sf.simulate(ramped(k)).checked()
        t = np.arange(300, 1000) * 2 * np.pi / 50
        x = run(t)[0]
        largest[k] = np.max(np.abs(np.diff(x))) / (2 * np.pi / 50)  # slow velocity
    assert largest[0] > 0.3  # the mass sticks and slips
    assert largest[1.05] < 0.02  # position follows the friction of the belt's speed


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"k": (1.0, 2.0)}, "it belongs to follow=True"),
        ({"follow": True, "k": (2.0, 1.0)}, "the lower bound comes first"),
        ({"follow": True, "k": 1.05}, "k is"),
        ({"follow": True, "a": (0.001, 0.02)}, "so give 0"),
        ({"follow": True, "k": (9.0, 10.0)}, "reach only"),
        ({"follow": 1.05}, "give True or False"),
    ],
)
def test_bad_arguments(options, message):
    with pytest.raises(sf.SceneError, match=message):
        quench(scene(), (0.1, 0.3), **{**BOUNDS, **options})


def test_limits_that_cannot_be_met_are_named():
    with pytest.raises(sf.NotFound, match=r"k = 1.05 and Omega = 50 comes closest; it leaves 0\.77\d+ of the friction"):
        quench(scene(), (0.1, 0.3), **BOUNDS, follow=True, k=(1.05, 2.0), limits={"friction": 0.9})


@pytest.mark.long(beside="test_the_scene_of_the_design_follows_a_belt_that_changes_its_speed")
def test_a_scene_with_a_k_of_its_own_keeps_it():
    x, u = sp.symbols("x u", real=True)
    k, v_b, a, Omega = sp.symbols("k v_b a Omega", positive=True)
    system = sf.System(q=[x], u=[u], mass=[[1]], force=[-k * x - u / 10 + a * Omega**2 * sp.sin(Omega * sf.TIME)])
    contact = sf.Contact("belt", slip=u - v_b, normal=1, law=LAWS["cubic"][0])
    power = sf.Integral(a * Omega**2 * sp.sin(Omega * sf.TIME) * u)
    values = {k: 1.0, v_b: None, a: 0.0, Omega: 0.0}
    own = sf.Scene(system, [contact], values, {x: 0.0, u: 0.0}, 60.0, {"power": power})
    found, same = (quench(s, (0.1, 0.3), **BOUNDS, follow=True, k=(1.05, 2.0)) for s in (own, scene()))
    assert found.values == {"k_v": same.values["k"], "Omega": 50.0}
    assert found.status == same.status == "optimal"
    run = sf.simulate(found.scene.where({"v_b": 0.2, **found.values}))
    fixed = sf.simulate(own.where({"v_b": 0.2, "a": 1.05 * 0.2 / 50, "Omega": 50.0}))
    assert run["power"] == pytest.approx(fixed["power"], rel=1e-6)
