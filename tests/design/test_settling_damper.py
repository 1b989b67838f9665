"""The damper that ends a motion in time: the oscillator with Coulomb and viscous friction in closed form."""

import numpy as np
import pytest
import sympy as sp
from scipy.optimize import brentq

import symfric as sf
from symfric.design import damper

X, U = sp.symbols("x u", real=True)
ZETA, DELTA, V_B = sp.symbols("zeta delta v_b", positive=True)
START = 1.0


def oscillator(law, v_b=None, horizon=60.0):
    """x'' + 2 zeta x' + x and friction of the law, from x = 1 at rest; on a belt if there is a speed."""
    values = {ZETA: 0.1, DELTA: 0.06} | ({} if v_b is None else {V_B: v_b})
    contact = sf.Contact("ground", U - (0 if v_b is None else V_B), DELTA, law)
    system = sf.System([X], [U], [[1]], [-X - 2 * ZETA * U])
    return sf.Scene(system, [contact], values, {X: START, U: 0.0}, horizon)


def turning_point(zeta, n, delta=0.06):
    """Distance of the n-th turning point: each half cycle multiplies the distance from the shifted middle."""
    distance = START
    for _ in range(n):
        distance = (distance - delta) * np.exp(-np.pi * zeta / np.sqrt(1 - zeta**2)) - delta
    return distance


def rest(zeta, stick, delta=0.06):
    """Time of rest: that of the first turning point that friction of `stick` times delta holds."""
    n = next(k for k in range(100) if turning_point(zeta, k, delta) <= stick * delta)
    return n * np.pi / np.sqrt(1 - zeta**2)


@pytest.mark.one_in(3)
@pytest.mark.parametrize("stick", [1.0, 1.5])
@pytest.mark.parametrize("settle", [7.0, 10.0, 13.5])
def test_rest_in_time_lies_on_a_jump(stick, settle):
    """The least damping with which one of the turning points before that time just sticks."""
    found = damper(oscillator(sf.laws.coulomb(stick, 1.0)), "zeta", (0.0, 0.9), settle=settle)
    n = int(settle / np.pi)
    edge = brentq(lambda z: turning_point(z, n) - stick * 0.06, 0, 0.9, xtol=1e-15)
    assert n * np.pi / np.sqrt(1 - edge**2) <= settle  # else the jump before that decides
    assert found.values["zeta"] == pytest.approx(edge, abs=1e-9)
    grid = np.linspace(1e-4, 0.9, 4000)
    assert all(rest(z, stick) > settle for z in grid[grid < found.objective])
    assert found.check.agrees
    more, less = (row.computed for row in found.check.rows)
    assert more == pytest.approx(rest(edge * (1 + 1e-6), stick), rel=1e-9)
    assert less == pytest.approx(rest(edge * (1 - 1e-6), stick), rel=1e-9)
    assert more <= settle < less
    assert float(found.active[0].rsplit(" ", 1)[1]) == pytest.approx(less, rel=1e-8)
    assert found.scene.values[ZETA] == found.objective


def test_a_time_just_missed_by_the_slower_half_cycles():
    """With damping the half cycles last longer: the third turning point sticks too late, and the second must."""
    edge = brentq(lambda z: turning_point(z, 3) - 0.06, 0, 0.9)
    settle = 3 * np.pi / np.sqrt(1 - edge**2) * (1 - 1e-6)
    found = damper(oscillator(sf.laws.coulomb(1.0)), "zeta", (0.0, 0.9), settle=settle)
    two = brentq(lambda z: turning_point(z, 2) - 0.06, 0, 0.9, xtol=1e-15)
    assert found.objective == pytest.approx(two, abs=1e-9)
    just = damper(oscillator(sf.laws.coulomb(1.0)), "zeta", (0.0, 0.9), settle=settle * (1 + 2e-6))
    assert just.objective == pytest.approx(edge, abs=1e-9)


def test_friction_may_be_the_damper():
    """Friction alone: half cycles of pi, each 2 delta shorter; rest after two asks for 1 - 4 delta <= delta."""
    found = damper(oscillator(sf.laws.coulomb(1.0)).where({"zeta": 0.0}), "delta", (0.01, 0.5), settle=7.0)
    assert found.objective == pytest.approx(0.2, abs=1e-9)
    assert found.check.agrees


def tail(zeta, settle):
    """Half range after a time of the damped free vibration about delta, on a fine grid."""
    rate = np.sqrt(1 - zeta**2)
    t = np.concatenate([[settle], np.pi / rate * (np.ceil(settle * rate / np.pi) + np.arange(4))])
    x = (START - 0.06) * np.exp(-zeta * t) * (np.cos(rate * t) + zeta / rate * np.sin(rate * t))
    return 0.5 * (x.max() - x.min())


@pytest.mark.one_in(2)
@pytest.mark.parametrize("limit", [0.05, 0.01])
def test_a_sliding_system_decays_to_a_half_range(limit):
    """A belt faster than the mass: constant friction only shifts the middle, and extrema are half cycles apart."""
    found = damper(oscillator(sf.laws.coulomb(1.0), v_b=2.0), "zeta", (0.01, 0.9), half_range=limit, settle=12.0)
    grid = np.linspace(0.01, 0.9, 4000)
    first = int(np.flatnonzero([tail(z, 12.0) <= limit for z in grid])[0])
    edge = brentq(lambda z: tail(z, 12.0) - limit, grid[first - 1], grid[first], xtol=1e-15)
    assert found.objective == pytest.approx(edge, abs=1e-9)
    assert found.check.agrees
    more, less = (row.computed for row in found.check.rows)
    assert more < limit < less
    assert found.active == (f"half range {limit:g} after t = 12",)


def test_the_worst_of_several_speeds():
    """Friction falls beyond a slip of 2, which takes from the damping while the mass slips so fast."""
    law = sf.laws.piecewise_linear(1.0, [0, 2.0, 3.0], [1.0, 1.0, 1.0 - 0.1 / 0.06])
    scene = oscillator(law, v_b=2.5)
    found = damper(scene, "zeta", (0.01, 0.9), (1.6, 1.8), half_range=0.02, settle=12.0)
    assert found.check.agrees
    worst = found.scene.values[V_B]
    for v in np.linspace(1.6, 1.8, 5):
        one = damper(scene.where({"v_b": v}), "zeta", (0.01, 0.9), half_range=0.02, settle=12.0)
        assert one.objective <= found.objective * (1 + 1e-9)
    alone = damper(scene.where({"v_b": worst}), "zeta", (0.01, 0.9), half_range=0.02, settle=12.0)
    assert alone.objective == pytest.approx(found.objective, rel=1e-7)


def test_enough_at_once_or_never_enough():
    coulomb = oscillator(sf.laws.coulomb(1.0))
    found = damper(coulomb, "zeta", (0.4, 0.9), settle=20.0)
    assert (found.objective, found.active) == (0.4, ("zeta at its lower bound",))
    assert len(found.check.rows) == 1
    soonest = min(rest(z, 1.0) for z in np.linspace(0.0, 0.05, 5000))
    with pytest.raises(sf.NotFound, match="is at rest at t = .*, later than 7 by") as error:
        damper(coulomb, "zeta", (0.0, 0.05), settle=7.0)
    assert float(str(error.value).rsplit(" ", 1)[1]) == pytest.approx(soonest - 7.0, abs=1e-5)
    with pytest.raises(sf.NotFound, match="if it slides for good, give half_range"):
        damper(oscillator(sf.laws.coulomb(1.0), v_b=2.0), "zeta", (0.0, 0.5), settle=7.0)
    with pytest.raises(sf.NotFound, match=r"leaves a half range of .*, above 1e-05 by"):
        damper(oscillator(sf.laws.coulomb(1.0), v_b=2.0), "zeta", (0.0, 0.5), half_range=1e-5, settle=12.0)


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({}, "give the speeds .*, or settle"),
        ({"settle": -1.0}, "settle is -1; it is a time"),
        ({"settle": 5.0, "sticking": False}, "is a condition on limit cycles"),
        ({"settle": 70.0, "half_range": 0.1}, "horizon 60 ends before settle = 70"),
        ({"settle": 5.0, "speeds": (0.1, 0.2)}, "a system that keeps sliding never rests; give half_range"),
    ],
)
def test_bad_arguments(change, message):
    with pytest.raises(sf.SceneError, match=message):
        damper(oscillator(sf.laws.coulomb(1.0), v_b=0.1), "zeta", (0.0, 0.5), **change)
