"""Cycles and branches beside states that stay the same, or move by rounding alone: they change neither period nor branch."""

import warnings

import numpy as np
import pytest
import sympy as sp

import symfric as sf

x, u, y, w, z = sp.symbols("x u y w z", real=True)
v_b, A = sp.symbols("v_b A", positive=True)
OMEGA = 1.3
T = 2 * np.pi / OMEGA


def shaken(a=0.1):
    """A mass on a belt that always slips one way, under a bristle that stays at its limit."""
    belt = sf.Contact("belt", u - 0.2, 1 + x**2 / 10, sf.laws.dahl(0.3, 10))
    system = sf.System([x], [u], [[1]], [-x - 0.02 * u + A * sp.cos(OMEGA * sf.TIME)])
    return sf.Scene(system, [belt], {A: a}, {x: 0.1, u: 0}, 200.0)


def beside(damping):
    """A rubbed and shaken mass, and another that comes to rest and has nothing to do with it."""
    force = [-x - 0.02 * u + 0.3 * sp.cos(OMEGA * sf.TIME), -y - damping * w]
    system, ground = sf.System([x, y], [u, w], sp.eye(2), force), sf.Contact("ground", u, 1, sf.laws.coulomb(0.05))
    return sf.Scene(system, [ground], {}, {x: 0.1, u: 0, y: 1, w: 0}, 200.0)


@pytest.mark.one_in(2)
@pytest.mark.parametrize(("a", "tolerance"), [(0.1, 1e-9), (0.1, 1e-13), (0.05, 1e-9), (0.05, 1e-13)])
def test_the_least_period_beside_a_friction_at_its_limit(a, tolerance):
    orbit = sf.limit_cycle(shaken(a), tolerance=tolerance)
    assert orbit.period == pytest.approx(T)
    again = sf.limit_cycle(shaken(a), guess=(orbit.start, T), tolerance=tolerance)
    assert np.sort(np.abs(orbit.multipliers)) == pytest.approx(np.sort(np.abs(again.multipliers)), abs=1e-6)


@pytest.mark.one_in(2)
@pytest.mark.parametrize("damping", [0.05, 0.3])
def test_the_least_period_beside_a_body_that_has_come_to_rest(damping):
    orbit = sf.limit_cycle(beside(damping))
    assert orbit.period == pytest.approx(T)
    decay = np.exp(-0.5 * damping * T)  # of the body at rest, a pair of multipliers
    assert np.sum(np.isclose(np.abs(orbit.multipliers), decay, rtol=1e-6)) == 2


def on_belt(law=None):
    belt = sf.Contact("belt", u - v_b, 1, sf.laws.stribeck(0.4, 0.2, 0.3))
    drum = [] if law is None else [sf.Contact("drum", u - 9, sp.Rational(1, 20), law)]
    system = sf.System([x], [u], [[1]], [-x - 0.02 * u])
    return sf.Scene(system, [belt, *drum], {v_b: 0.2}, {x: 0.1, u: 0}, 150.0)


def with_a_state_at_rest():
    system = sf.System([x], [u], [[1]], [-x - 0.02 * u], z=[z], z_rate=[-z])
    return sf.Scene(system, on_belt().contacts, {v_b: 0.2}, {x: 0.1, u: 0, z: 0}, 150.0)


STILL = {
    "bouc-wen": lambda: on_belt(sf.laws.bouc_wen(1.0, 5, 3, 1)),
    "bouc-wen, sharp": lambda: on_belt(sf.laws.bouc_wen(1.0, 5, 3, 2)),
    "dahl": lambda: on_belt(sf.laws.dahl(0.05, 10)),
    "at rest": with_a_state_at_rest,
}


@pytest.mark.one_in(4)
@pytest.mark.parametrize("name", STILL)
def test_a_branch_goes_on_beside_a_state_that_stays_the_same(name):
    scene = STILL[name]()
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        branch = sf.continue_cycle(scene, "v_b", (0.15, 0.25))
    assert np.min(branch.values) == pytest.approx(0.15)
    assert np.max(branch.values) == pytest.approx(0.25)
    ends = [branch.orbits[int(np.argmin(np.abs(branch.values - v)))] for v in (0.15, 0.25)]
    for v, orbit in zip((0.15, 0.25), ends, strict=True):
        assert orbit.period == pytest.approx(sf.limit_cycle(scene.where({"v_b": v})).period, rel=1e-7)


@pytest.mark.one_in(3)
@pytest.mark.parametrize("a", [0.2, 0.3, 0.4])
def test_the_time_of_sticking_in_the_plane_is_that_of_the_slip(a):
    belt = sf.Contact("belt", (u - v_b, w), 1 + x**2 / 10, sf.laws.stribeck(0.4, 0.2, 0.3))
    force = [-x - 0.02 * u + A * sp.cos(OMEGA * sf.TIME), -1.7 * y - 0.02 * w]
    system = sf.System([x, y], [u, w], sp.eye(2), force)
    scene = sf.Scene(system, [belt], {v_b: 0.2, A: a}, {x: 0.1, u: 0, y: 0.3, w: 0.1}, 200.0)
    orbit = sf.limit_cycle(scene)
    states = orbit.run(np.linspace(0, orbit.period, 40_001))
    still = np.mean(np.hypot(states[2] - 0.2, states[3]) < 1e-9)
    assert orbit.stick_fraction == pytest.approx(still, abs=1e-3)
    assert orbit.stick_time == pytest.approx(orbit.stick_fraction * orbit.period)
