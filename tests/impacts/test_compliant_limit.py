"""A compliant contact tends to the rigid one as its stiffness grows.

Where it bounces the error is that of the time of contact, ``k^(-1/2)``; where it rests, that of the depth, ``1/k``.
"""

import math

import numpy as np
import pytest
import sympy as sp

import symfric as sf

x, y, u, v = sp.symbols("x y u v", real=True)
k, c, e, mu = sp.symbols("k c e mu", nonnegative=True)
G = 9.81
HORIZON = 1.0
START = {x: 0.0, y: 0.5, u: 2.0, v: 0.0}
TABLE = sp.Rational(1, 50) * sp.sin(9 * sf.TIME)


def restitution(damping):
    """Return the restitution of ``y'' + 2 damping y' + y = 0`` until the force of spring and damper is zero."""
    w = math.sqrt(1 - damping**2)
    return math.exp(-damping / w * math.atan2(2 * damping * w, 2 * damping**2 - 1))


def rigid(damping, friction):
    """Return the final state over a floor that moves up and down."""
    floor = sf.Contact("floor", u, sf.Unilateral(y - TABLE, e), sf.laws.coulomb(mu))
    values = {e: restitution(damping) if damping else 1.0, mu: friction}
    return sf.simulate(scene([0, -G], floor, values)).checked().final


def compliant(stiffness, damping, friction):
    """Return the same over a spring and a damper that push only."""
    pushed = sp.Max(0, -k * (y - TABLE) - c * (v - TABLE.diff(sf.TIME)))
    load = sp.Piecewise((pushed, y - TABLE < 0), (0, True))
    floor = sf.Contact("floor", u, load, sf.laws.coulomb(mu))
    values = {k: stiffness, c: 2 * damping * math.sqrt(stiffness), mu: friction}
    return sf.simulate(scene([0, load - G], floor, values), tolerance=1e-10).checked().final


def scene(force, floor, values):
    return sf.Scene(sf.System([x, y], [u, v], sp.eye(2), force), [floor], values, START, HORIZON)


@pytest.mark.one_in(4)
@pytest.mark.parametrize(("damping", "friction"), [(0.0, 0.0), (0.0, 0.1), (0.1, 0.05), (0.2, 0.05)])
def test_the_error_of_bounces_falls_with_the_root_of_the_stiffness(damping, friction):
    coarse, fine, finest = away(damping, friction)
    moved = [y, v] if friction == 0 else [x, y, u, v]
    places = [i for i, state in enumerate((x, y, u, v)) if state in moved]
    assert fine[places] / coarse[places] == pytest.approx([0.1] * len(places), rel=0.02)
    assert finest[places] / fine[places] == pytest.approx([0.1] * len(places), rel=0.02)


def test_the_error_of_a_body_that_rests_on_the_floor_falls_with_the_stiffness():
    coarse, fine, _ = away(0.5, 0.02)
    assert fine / coarse == pytest.approx([0.01] * 4, rel=0.1)


def away(damping, friction):
    """Return how far final states are from the rigid one, for stiffnesses a hundred times apart."""
    right = rigid(damping, friction)
    return [np.abs(compliant(stiffness, damping, friction) - right) for stiffness in (1e8, 1e10, 1e12)]
