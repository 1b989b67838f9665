"""Cycles of bodies that creep on a shaken table, a little less in every period, until friction holds them for good."""

import numpy as np
import pytest
import sympy as sp

import symfric as sf
from tests.plane.test_cycles_on_feet import MU, body, t

x, v = sp.symbols("x v", real=True)
SHAKEN = 1.2 * sp.sin(1.3 * t)


def mass(stiffness, mu, steady=0.0):
    """Return a mass on a table whose velocity is 0.5 sin(1.3 t); a spring pulls it to x = 0."""
    system = sf.System([x], [v], [[1]], [steady - stiffness * x - 0.02 * v])
    table = sf.Contact("table", v - 0.5 * sp.sin(1.3 * t), 1, sf.laws.coulomb(MU))
    return sf.Scene(system, [table], {MU: mu}, {x: 0.5, v: 0}, 40.0)


@pytest.mark.one_in(6)
@pytest.mark.parametrize("mu", [0.7, 0.8, 0.9])
@pytest.mark.parametrize("stiffness", [0.6, 1.0, 1.7])
@pytest.mark.parametrize("steady", [0.0, 0.1])
def test_a_mass_rests_where_its_creep_ends(stiffness, mu, steady):
    """What it moves in a period is the square of the way that is left: Newton's method comes to a double root."""
    scene = mass(stiffness, mu, steady)
    orbit = sf.limit_cycle(scene, tolerance=1e-11)
    assert orbit.stick_fraction == pytest.approx(1.0, abs=1e-9)
    times = np.linspace(0, orbit.period, 4001)
    place = orbit.start[0] + 0.5 / 1.3 * (1 - np.cos(1.3 * times))
    force = 0.65 * np.cos(1.3 * times) + stiffness * place - steady + 0.01 * np.sin(1.3 * times)
    assert np.max(np.abs(force)) <= mu * (1 + 1e-9)
    late = sf.simulate(scene.until(4000.0), tolerance=1e-11).checked()
    assert orbit.start[0] == pytest.approx(late(800 * orbit.period)[0], abs=5e-3)


FEET = {"two": (2, 0.3), "three": (3, 0.3), "four": (4, 0.3)}


@pytest.mark.filterwarnings("ignore:redundant contacts")
@pytest.mark.long(beside="test_a_mass_rests_where_its_creep_ends")
@pytest.mark.parametrize("which", FEET)
def test_feet_rest_where_their_creep_ends(which):
    """The slower they creep, the stiffer is their motion: it takes 80 steps, or twice as many in every iteration."""
    n, mu = FEET[which]
    orbit = sf.limit_cycle(body(n, spin=SHAKEN, values={MU: mu}), tolerance=1e-9)
    assert orbit.stick_fraction == pytest.approx(1.0, abs=1e-9)
    assert orbit.stable
