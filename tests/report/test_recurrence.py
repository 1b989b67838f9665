"""What a study says of a motion after settling: a period only where the motion itself comes back, several times."""

import re

import numpy as np
import pytest
import sympy as sp

import symfric as sf
from symfric.model.excitation import common_rate, later
from symfric.orbits.steady_state import schedule, vibration
from symfric.report.study.page import summary
from symfric.report.study.study import study
from symfric.scenefile import read_scene_text

X, U, A = sp.symbols("x u a", real=True)
T = sf.TIME
PAIR = sp.cos(2.0 * T) + sp.sin(3.0 * T)


def floor(mu, slip=U, normal=1):
    return [sf.Contact("floor", slip=slip, normal=normal, law=sf.laws.coulomb(mu))]


def scene(force, contacts=(), horizon=60.0, inputs=None):
    return sf.Scene(sf.System([X], [U], [[1]], [force]), contacts, {}, {X: 1.0, U: 0.0}, horizon, inputs=inputs or {})


def measured(scene):
    return vibration(scene, "x")


PERIODIC = {
    "two harmonics": (scene(-X - 0.2 * U + PAIR, floor(0.1)), 2 * np.pi),
    "frequencies in tenths": (scene(-X - 0.2 * U + sp.cos(0.1 * T) + sp.cos(0.3 * T), floor(0.1)), 20 * np.pi),
    "a product": (scene(-X - 0.2 * U + sp.cos(0.5 * T) * sp.sin(1.5 * T), floor(0.05)), 2 * np.pi),
    "a square": (scene(-X - 0.2 * U + sp.sin(T) ** 2), np.pi),
    "a phase that swings": (scene(-X - 0.2 * U + sp.sin(1.5 * T + sp.sin(3 * T))), 4 * np.pi / 3),
    "a load": (scene(-X - 0.1 * U, floor(0.3, U - 0.4, 1 + 0.5 * sp.sin(1.3 * T))), 2 * np.pi / 1.3),
    "a stiffness": (scene(-X * (1 + 0.2 * sp.cos(3.1 * T)) - 0.1 * U + 0.2 * sp.cos(3.1 * T)), 2 * np.pi / 3.1),
    "two periods in one": (scene(-0.1 * U - X - X**3 + 30 * sp.cos(5.6 * T), horizon=200.0), None),
    "van der Pol": (scene(-X + (1 - X**2) * U), 6.66328685933),
    "no loss at all": (scene(-X - X**3), 4.76802200),
    "belt": (sf.scenes.mass_on_belt(v_b=0.2), 6.79942144),
}


@pytest.mark.one_in(12)
@pytest.mark.parametrize("name", PERIODIC)
def test_a_period_is_one_of_the_motion(name):
    given, period = PERIODIC[name]
    found = measured(given)
    assert found.settled
    assert period is None or found.period == pytest.approx(period, rel=1e-6)
    plan = schedule(given)
    end = sf.simulate(given.until(plan.settle).wanting({"end": sf.End()})).final
    late = later(given, plan.settle).starting(dict(zip((X, U), end.tolist(), strict=True))).until(5 * found.period)
    run = sf.simulate(late.wanting({"path": sf.Trajectory()}))
    states = run(found.period * np.arange(5) + 1e-9)
    assert np.max(np.abs(states - states[:, :1]) / np.ptp(run.x, axis=1)[:, None]) < 3e-3


SIGNAL = sf.Signal(np.sin(0.3 * np.arange(8000)), 0.3)
NOT_PERIODIC = {
    "two frequencies": (
        scene(-X - 0.05 * U + sp.cos(1.1 * T) + sp.cos(sp.sqrt(2) * T), floor(0.1)),
        "no common period",
    ),
    "a belt and a load": (
        scene(-X - 0.1 * U, floor(0.3, U - 0.4 * (1 + 0.9 * sp.sin(T)), 1 + 0.5 * sp.sin(sp.sqrt(3) * T))),
        "no common period",
    ),
    "a transient": (scene(-X - 0.2 * U + sp.exp(-T / 50) + sp.cos(T)), "outside sines"),
    "a record": (scene(-X - 0.1 * U + A, inputs={A: SIGNAL}), "sampled input"),
    "chaos": (scene(X - X**3 - 0.25 * U + 0.4 * sp.cos(T)), "does not repeat itself"),
    "a torus": (scene(-X + 0.3 * (1 - X**2) * U + 0.3 * sp.cos(1.31 * T)), "does not repeat itself"),
    "growth": (scene(-X + 5e-4 * U), "does not repeat itself|grows"),
    "parametric growth": (scene(-X * (1 + 0.3 * sp.cos(2 * T)) - 0.02 * U, horizon=20.0), "grows"),
    "slow decay": (scene(-X - 1e-5 * U), "does not repeat itself"),
    "slower decay": (scene(-X - 1e-7 * U), "does not repeat itself"),
    "slow decay of a transient": (scene(-X - 3e-5 * U + sp.cos(0.3 * T)), "does not repeat itself"),
}


@pytest.mark.one_in(6)
@pytest.mark.parametrize("name", NOT_PERIODIC)
def test_what_has_not_settled_has_no_period(name):
    given, note = NOT_PERIODIC[name]
    found = measured(given)
    assert not found.settled
    assert np.isnan(found.period)
    assert re.search(note, found.note)
    assert found.smallest < found.largest


@pytest.mark.one_in(2)
@pytest.mark.parametrize(
    "given",
    [
        scene(-X - 0.02 * U),
        scene(-X, floor(0.1)),
        scene(-X - 0.1 * U, floor(0.3, U - 0.4)),
        scene(-X - 0.2 * U + sp.exp(-T) * sp.cos(T)),
    ],
)
def test_rest_is_rest(given):
    found = measured(given)
    assert found.settled
    assert np.isnan(found.period)
    assert found.half_range < 1e-4


def test_rates_that_are_multiples_of_one():
    assert common_rate([2.0, 3.0]) == pytest.approx(1.0, rel=1e-15)
    assert common_rate([0.1, 0.3, 0.7]) == pytest.approx(0.1, rel=1e-14)
    assert common_rate([2.3, -0.2, 0.0]) == pytest.approx(0.1, rel=1e-13)
    assert common_rate([1.0, 2**0.5]) is None
    assert common_rate([1.0, 1.0 + 1e-6]) is None
    assert common_rate([]) is None


def test_orbits_use_the_common_period_of_numbers():
    w, b = sp.symbols("w b", positive=True)
    system = sf.System([X], [U], [[1]], [-X - 0.3 * U + sp.cos(w * T) + sp.cos(b * T)])
    given = sf.Scene(system, floor(0.1), {w: 0.9, b: 0.6}, {X: 0.0, U: 0.0}, 100.0)
    assert sf.limit_cycle(given).period == pytest.approx(2 * np.pi / 0.3, rel=1e-12)
    with pytest.raises(sf.SceneError, match="no common period: b = 0.6, w = 0.91234567"):
        sf.limit_cycle(given.where({w: 0.9123456789}))
    with pytest.raises(sf.SceneError, match="changes some frequencies"):
        sf.continue_cycle(given, "w", (0.8, 1.0))
    with pytest.raises(sf.SceneError, match="outside sines"):
        sf.limit_cycle(scene(-X + sp.sin(X * T)))


STUDY = """
title = "two forcings"
[scene]
coordinates = "x"
velocities = "u"
mass = "1"
force = "-x - 0.1*u + cos(w*t) + cos(b*t)"
initial = { x = 0.0, u = 0.0 }
horizon = 30
[values]
w = 1.3
b = %s
"""


@pytest.mark.one_in(2)
@pytest.mark.parametrize(("b", "settles"), [("2.6", True), ("1.8384776310850235", False)])
def test_the_summary_says_whether_it_settles(b, settles):
    line = summary(study(read_scene_text(STUDY % b)))[-1]
    assert ("settles into forced vibration" in line and "period of 4.8332" in line) == settles
    assert ("has not settled" in line and "lies between" in line and "no common period" in line) == (not settles)
