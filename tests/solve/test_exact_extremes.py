"""The closed-form oscillator with rates that overflow, and with countless turns before an event: it ends, and rightly."""

import numpy as np
import pytest
import sympy as sp

import symfric as sf

X, U = sp.symbols("x u", real=True)
K, C = sp.symbols("k c", real=True)


def growing(stiffness, damping, horizon, start=1e-3):
    """A mass that slides on a belt at half the speed where the law ends to fall, about its equilibrium."""
    law = sf.laws.piecewise_linear(0.4, [0.0, 1.0], [0.4, 0.4])
    system = sf.System([X], [U], [[1]], [-K * X - C * U])
    contacts = [sf.Contact("belt", U - sp.Rational(1, 2), 1, law)]
    values = {K: stiffness, C: damping}
    return sf.Scene(system, contacts, values, {X: 0.4 / stiffness, U: start}, horizon, {"far": sf.Max(U)})


def test_an_event_after_thousands_of_turns():
    # the amplitude of the velocity grows from .001 to .5, that of sticking, as exp(t/2): 2 log(500) after 3956 half periods
    scene = growing(1e6, -1.0, 13.0)
    exact, taylor = (
        sf.simulate(scene.wanting({"path": sf.Trajectory()}), 1e-12, route) for route in ("exact", "taylor")
    )
    assert exact.events[0].t == pytest.approx(2 * np.log(500), abs=2 * np.pi / 1e3)
    assert exact.events[0].t == pytest.approx(taylor.events[0].t, rel=1e-11)
    assert exact.final == pytest.approx(taylor.final, rel=1e-6)


@pytest.mark.parametrize("damping", [-1e-3, -1e-5, -1e-9])
def test_turns_of_a_motion_that_grows_too_slowly_to_stick(damping):
    run = sf.simulate(growing(1e10, damping, 50.0), route="exact")
    assert run.status == sf.Status.OK
    assert run.stats["steps"] == 1
    assert run["far"] == pytest.approx(1e-3 * np.exp(-damping * 25.0), rel=1e-4)


@pytest.mark.parametrize("stiffness", [1.0, 1e150, 1e300])
@pytest.mark.parametrize("damping", [-1e300, 1e300, -1e160, 1e160])
def test_rates_that_overflow_end_the_run(stiffness, damping):
    run = sf.simulate(growing(stiffness, damping, 1.0).wanting({"path": sf.Trajectory()}), route="exact")
    assert run([0.0, run.t_final]).shape == (2, 2)
    assert np.all(np.isfinite(run.final)) if run.status == sf.Status.OK else run.status == sf.Status.NOT_FINITE
