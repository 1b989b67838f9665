"""A contact with an infinite slope of its law at rest passes zero slip while another sticks; both in closed form."""

import math

import numpy as np
import pytest
import sympy as sp
from scipy.optimize import brentq

import symfric as sf

X, U, Y, W = sp.symbols("x u y w", real=True)
START, PULL, DRY, HORIZON = 0.8, 1.5, 0.6, 1.4
HOLDS, FAILS = 1.5, 0.7  # bounds of the joint: the reversal of the ground's friction takes its force from 0.45 to 1.05


def pair(bound, alpha):
    """Two masses held together by a joint, the pulled one moves the other over the ground."""
    system = sf.System(q=[X, Y], u=[U, W], mass=sp.eye(2), force=[-PULL, 0])
    ground = sf.Contact("ground", W, 1, sf.laws.square_root(DRY, alpha))
    joint = sf.Contact("joint", U - W, 1, sf.laws.coulomb(bound))
    return sf.Scene(system, [ground, joint], {}, {X: 0.0, Y: 0.0, U: START, W: START}, HORIZON, {"end": sf.End()})


def time_of(speed, c, alpha):
    """Return the time from rest to a speed v under v' = c + alpha sqrt(v)."""
    s = math.sqrt(speed)
    return 2 * (s / alpha - c / alpha**2 * math.log1p(alpha * s / c))


def speeds(bound, alpha):
    """Return both velocities at the end."""
    left = HORIZON - 2 * time_of(START, PULL + DRY, alpha)  # from the time of rest
    assert left > 0.3
    if bound == HOLDS:
        together = -brentq(lambda v: 2 * time_of(v, PULL - DRY, -alpha) - left, 1e-12, 0.9, xtol=1e-15)
        return together, together
    return -(PULL - FAILS) * left, -brentq(lambda v: time_of(v, FAILS - DRY, -alpha) - left, 1e-12, 0.9, xtol=1e-15)


@pytest.mark.one_in(6)
@pytest.mark.parametrize("alpha", [-0.2, -0.02, 0.1])
@pytest.mark.parametrize("bound", [HOLDS, FAILS])
def test_a_joint_holds_over_a_reversal_only_if_its_bound_bears_the_new_friction(bound, alpha):
    scene = pair(bound, alpha)
    for tolerance in (1e-6, 1e-8, 1e-10, 1e-12):
        run = sf.simulate(scene, tolerance).checked()
        assert run.final[2:] == pytest.approx(speeds(bound, alpha), abs=max(100 * tolerance, 1e-10))


@pytest.mark.one_in(2)
@pytest.mark.parametrize("bound", [HOLDS, FAILS])
def test_a_run_with_derivatives_ends_well_and_says_that_it_has_none(bound):
    run = sf.prepare(pair(bound, -0.1), 1e-10, "taylor", ["u"]).run()
    assert run.status == sf.Status.NO_DERIVATIVE
    assert run.final[2:] == pytest.approx(speeds(bound, -0.1), abs=1e-8)
    assert np.all(np.isnan(run.sensitivities["u"]))
