"""Optimal control of a block on a rough floor, whose times and energies have closed forms."""

import json
from itertools import product
from math import sqrt

import numpy as np
import pytest
import sympy as sp

import symfric as sf
from symfric.design.optimal_control.collocation import collocation
from tests.longer import longer

M, F, D, U = 2.0, 0.3, 1.5, 1.0
x, u, w = sp.symbols("x u w", real=True)
m, load = sp.symbols("m N", positive=True)


def block(u0=0.0, law=None):
    """A block on a rough floor, pushed by the force w."""
    return sf.Scene(
        system=sf.System(q=[x], u=[u], mass=[[m]], force=[w]),
        contacts=[sf.Contact("floor", slip=u, normal=load, law=law or sf.laws.coulomb(1))],
        values={m: M, load: F, w: 0.0},
        initial={x: 0.0, u: u0},
        horizon=1.0,
    )


def fastest(distance):
    """Accelerate by (U - F)/m, brake by (U + F)/m: T = 2 sqrt(m D U/(U^2 - F^2))."""
    return 2 * sqrt(M * distance * U / (U**2 - F**2))


def test_fastest_move():
    found = collocation(block(), {"w": (-U, U)}, {"x": D, "u": 0.0}, time=(0.1, 20.0))
    assert found.time == pytest.approx(fastest(D), rel=1e-8)
    assert found.objective == found.time
    assert np.all(found.mode == 1)
    # it pushes until the block has its largest speed, and brakes then
    switch = found.t[:-1][found.controls["w"][:, 0] < 0][0]
    assert switch == pytest.approx(fastest(D) * (U + F) / (2 * U), rel=1e-5)
    assert found.check.agrees, str(found.check)
    json.dumps(found.to_dict())
    assert found.plot() is not None
    # no other pair of forces, or triple with a coast between, is faster
    draw = np.random.default_rng(0)
    push, brake, coast = draw.uniform(F, U, 20000), draw.uniform(-U, F, 20000), draw.uniform(0, 1, 20000)
    a, b, c = (push - F) / M, (F - brake) / M, F / M
    # speed v, after coasting (1 - s) v: v^2/2 (1/a + (1 - (1-s)^2)/c + (1-s)^2/b) = D
    s = coast * draw.integers(0, 2, 20000)
    v = np.sqrt(2 * D / (1 / a + (1 - (1 - s) ** 2) / c + (1 - s) ** 2 / b))
    assert np.min(v / a + s * v / c + (1 - s) * v / b) >= found.time * (1 - 1e-9)


@pytest.mark.long(beside="test_fastest_move")
def test_a_block_that_moves_away_at_first():
    # friction helps to stop it: t = m v/(U + F), after m v^2/2/(U + F) in the wrong direction
    found = collocation(block(u0=-0.4), {"w": (-U, U)}, {"x": D, "u": 0.0}, time=(0.1, 20.0))
    first, back = M * 0.4 / (U + F), M * 0.4**2 / 2 / (U + F)
    assert found.time == pytest.approx(first + fastest(D + back), rel=1e-8)
    assert (found.mode[0, 0], found.mode[0, -1]) == (-1, 1)
    assert found.check.agrees, str(found.check)


@pytest.mark.parametrize("duration", longer([3.0, 12.0], (12.0,)))
def test_least_energy(duration):
    # w = F + m a, and a linear in time is best: F^2 T + 12 m^2 D^2/T^3; beyond T = sqrt(6 m D/F) waiting costs nothing
    found = collocation(block(), {"w": (-9, 9)}, {"x": D, "u": 0.0}, time=(duration, duration), minimise=w**2, degree=1)
    moving = min(duration, sqrt(6 * M * D / F))
    assert found.objective == pytest.approx(F**2 * moving + 12 * M**2 * D**2 / moving**3, rel=1e-8)
    assert found.time == pytest.approx(duration, rel=1e-12)
    assert (0 in found.mode) == (moving < duration)
    assert found.check.agrees, str(found.check)


PAUSES = [*product((1.0, 3e-3, 410.0), repeat=3), (410.0, 79.0, 1e-3), (410.0, 1.0, 1.0)]


@pytest.mark.long(beside="test_fastest_move")
@pytest.mark.parametrize("units", longer(PAUSES, [*PAUSES[:-2], PAUSES[-1]]))
def test_a_move_with_a_pause_in_other_units(units):
    """The body rests at both ends of the element in which it moves: its speed counts there, not at the ends."""
    mass, length, time = units
    friction = 0.3 * mass * length / time**2
    scene = sf.Scene(
        system=sf.System(q=[x], u=[u], mass=[[mass]], force=[w]),
        contacts=[sf.Contact("floor", slip=u, normal=friction, law=sf.laws.coulomb(1))],
        values={w: 0.0},
        initial={x: 0.0, u: 0.0},
        horizon=1.0,
    )
    bounds, ends = {"w": (-60 * friction, 60 * friction)}, (10 * time, 10 * time)
    found = collocation(scene, bounds, {"x": length, "u": 0.0}, time=ends, minimise=w**2, degree=1)
    moving = sqrt(6 * mass * length / friction)
    least = friction**2 * moving + 12 * (mass * length) ** 2 / moving**3
    assert found.objective == pytest.approx(least, rel=1e-8)
    assert found.status == "optimal", found.doubts


@pytest.mark.long(beside="test_a_steep_law_is_resolved")
def test_friction_that_falls_with_the_speed():
    found = collocation(
        block(law=sf.laws.exponential(1, 2.0)), {"w": (-U, U)}, {"x": D, "u": 0.0}, time=(0.1, 20.0), elements=8
    )
    assert sqrt(4 * M * D / U) < found.time < fastest(D)
    assert found.check.agrees, str(found.check)


def test_what_cannot_be_reached_is_named():
    with pytest.raises(sf.NotFound, match=r"the nearest has x = .* instead of 1\.5, u = .* instead of 0"):
        collocation(block(), {"w": (-U, U)}, {"x": D, "u": 0.0}, time=(0.1, 0.9 * fastest(D)), elements=1)


@pytest.mark.parametrize(
    ("scene", "options", "words"),
    [
        (block(law=sf.laws.coulomb(1.2, 1.0)), {}, "static friction above the kinetic one"),
        (block(), {"end": {"y": 1.0}}, "end names y"),
        (block(), {"controls": {"w": (1, -1)}}, "smallest, largest"),
        (block(), {"time": (3, 1)}, "the shortest and the longest"),
        (block(), {"degree": 2}, "degree is 2; give a whole number from 0 to 1"),
    ],
)
def test_bad_arguments(scene, options, words):
    given = {"controls": {"w": (-U, U)}, "end": {"x": D, "u": 0.0}, "time": (0.1, 20.0)} | options
    with pytest.raises(sf.SceneError, match=words):
        collocation(scene, **given)


UNITS = [(410.0, 79.0, 0.001), (0.0013, 76.0, 300.0), (140.0, 0.0016, 24.0)]


@pytest.mark.one_in(3)
@pytest.mark.parametrize("units", longer(UNITS, UNITS[1:]))
def test_units_do_not_matter(units):
    """The same move in other units of mass, length and time, with a spring and a law that falls: one number."""

    def move(mass, length, time):
        force = mass * length / time**2
        scene = sf.Scene(
            system=sf.System(q=[x], u=[u], mass=[[mass]], force=[w - 0.5 * mass / time**2 * x]),
            contacts=[sf.Contact("floor", slip=u, normal=0.3 * force, law=sf.laws.exponential(1, 2 * length / time))],
            values={w: 0.0},
            initial={x: 0.0, u: 0.0},
            horizon=1.0,
        )
        bounds = {"w": (-force, force)}
        return collocation(scene, bounds, {"x": length, "u": 0.0}, time=(0.1 * time, 10 * time))

    one, other = move(1.0, 1.0, 1.0), move(*units)
    assert other.time / units[2] == pytest.approx(one.time, rel=1e-8)
    assert one.time == pytest.approx(2.0207425, rel=1e-7)
    assert (one.status, other.status) == ("optimal", "optimal"), (one.doubts, other.doubts)


@pytest.mark.parametrize("v_c", longer([0.3, 0.1, 0.05], [0.3, 0.05]))
def test_a_steep_law_is_resolved(v_c):
    """Elements are divided until the event-driven model ends where it should."""
    found = collocation(block(law=sf.laws.exponential(1, v_c)), {"w": (-U, U)}, {"x": D, "u": 0.0}, time=(0.1, 20.0))
    assert found.check.agrees, str(found.check)
    assert found.status == "optimal", found.doubts
    assert sqrt(4 * M * D / U) < found.time < fastest(D)
