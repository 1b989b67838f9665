"""Derivatives over slow and sudden starts in the plane, and through slips that turn round about a foot that sticks."""

import numpy as np
import pytest
import sympy as sp

import symfric as sf
from tests.longer import longer
from tests.plane.test_feet import ENDS, OTHERS, derived, rising

x, y, u, w = sp.symbols("x y u w", real=True)
MU, PUSH = sp.symbols("mu F", positive=True)
t = sf.TIME
GIVEN = ENDS, (1, 2), (0.3, 1.0, 0.1)
WAVES = PUSH * sp.sin(t) - x / 2, PUSH * sp.cos(sp.Rational(13, 10) * t) / 2 - y
LAWS = {
    "coulomb": sf.laws.coulomb(MU),
    "a drop of friction": sf.laws.coulomb(MU, 0.7 * MU),
    "stribeck": sf.laws.stribeck(MU, 0.6 * MU, 0.2),
}


def puck(law, **options):
    """Return a mass on a table under two waves: it starts and stops several times."""
    contact = sf.Contact("table", (u, w), 1, law, **options)
    outputs = {
        "heat": sf.Integral(u**2 + w),
        "highest": sf.Max(x),
        "events": sf.Events(),
    }
    values, start = {MU: 0.5, PUSH: 0.55}, dict.fromkeys((x, y, u, w), 0.0)
    return sf.Scene(sf.System([x, y], [u, w], sp.eye(2), list(WAVES)), [contact], values, start, 9.0, outputs)


def differences(scene, name, value, size=1e-4):
    """Return derivatives of final state and outputs by central differences of tight runs, without their second order."""
    program = sf.prepare(scene, 1e-13)

    def moved(by):
        run = program.run(values={name: value + by}).checked()
        return np.array([*run.final, run["heat"], run["highest"]])

    far, near = ((moved(h) - moved(-h)) / (2 * h) for h in (2 * size, size))
    return (4 * near - far) / 3


CASES = [(law, tolerance) for law in LAWS for tolerance in (1e-6, 1e-9, 1e-12)]


@pytest.mark.parametrize("case", longer(CASES, [c for c in CASES if c != ("coulomb", 1e-6)]))
def test_derivatives_have_the_error_of_the_run(case):
    """They once had the root of its tolerance, and took ten times its steps."""
    law, tolerance = case
    scene = puck(LAWS[law])
    plain = sf.prepare(scene, tolerance).run().checked()
    run = sf.prepare(scene, tolerance, sensitivities=["mu", "F"]).run().checked()
    assert sum(e.kind == "slip" for e in run.events) >= 2
    assert run.stats["steps"] <= 2 * plain.stats["steps"]
    for name, value in (("mu", 0.5), ("F", 0.55)):
        own = np.append(run.sensitivities[name], [run.output_sensitivities[k][name] for k in ("heat", "highest")])
        slope = differences(scene, name, value)
        assert own == pytest.approx(slope, abs=max(300 * tolerance, 1e-8) * np.max(np.abs(slope)))


@pytest.mark.long(beside="test_derivatives_have_the_error_of_the_run")
def test_derivatives_of_an_ellipse_are_those_of_differences():
    scene = puck(LAWS["coulomb"], ellipse=(1, sp.Rational(7, 5)))
    run = sf.prepare(scene, 1e-10, sensitivities=["mu"]).run().checked()
    own = np.append(run.sensitivities["mu"], [run.output_sensitivities[k]["mu"] for k in ("heat", "highest")])
    assert own == pytest.approx(differences(scene, "mu", 0.5), rel=1e-6, abs=1e-7)


# starts of a body on two feet: it swings through zero about a foot; a stop was found as a root, from a slip of rounding
SWINGS = (-0.39, -0.3, -0.22), (0.33, -0.44, -0.41), (0.2, 0.1, -0.3)


@pytest.mark.long(beside="test_derivatives_have_the_error_of_the_run")
@pytest.mark.parametrize("start", longer(SWINGS, [SWINGS[1]]))
def test_a_foot_that_swings_through_zero_about_another_has_derivatives(start):
    run = rising(derived(2), *GIVEN, start)
    tight = derived(2, 1e-12, ())
    for name in ("mu", "load"):
        ends = [rising(tight, *GIVEN, start, **{name: OTHERS[name] + h}).final for h in (1e-5, -1e-5)]
        assert run.sensitivities[name] == pytest.approx((ends[0] - ends[1]) / 2e-5, abs=1e-7)


@pytest.mark.long(beside="test_derivatives_have_the_error_of_the_run")
def test_random_starts_of_two_feet_have_derivatives():
    """Of these 300 once 12 had none."""
    rng, tight = np.random.default_rng(1), derived(2, 1e-12, ())
    for k in range(300):
        start = (
            np.array([0.2, 0.1, -0.3]) + rng.uniform(-0.15, 0.15, 3) if k % 2 else rng.uniform(-0.5, 0.5, 3).round(2)
        )
        run = rising(derived(2), *GIVEN, start)
        ends = [rising(tight, *GIVEN, start, mu=0.3 + h).final for h in (1e-5, -1e-5)]
        assert run.sensitivities["mu"] == pytest.approx((ends[0] - ends[1]) / 2e-5, abs=3e-7, rel=1e-6), start


@pytest.mark.long(beside="test_derivatives_have_the_error_of_the_run")
def test_second_derivatives_leave_the_first_ones_alone():
    """Their columns, of products of the first ones, have no part in the derivatives over a start."""
    curved = [force - x**3 * (1 + y) - y**2 for force in WAVES]
    scene = puck(LAWS["coulomb"])
    scene = sf.Scene(sf.System([x, y], [u, w], sp.eye(2), curved), scene.contacts, scene.values, scene.initial, 9.0)
    first, both = (sf.prepare(scene, 1e-10, sensitivities=["mu"], order=n).run() for n in (1, 2))
    assert first.status == both.status == sf.Status.OK
    assert both.sensitivities["mu"] == pytest.approx(first.sensitivities["mu"], rel=1e-9)


@pytest.mark.long(beside="test_derivatives_have_the_error_of_the_run")
@pytest.mark.parametrize("load", [1e-16, 1e-20])
def test_a_start_that_another_event_ends_at_once_has_derivatives(load):
    """A weak load lets a second mass go at once: high powers of that time are zero, which a run once divided by."""
    z, v = sp.symbols("z v", real=True)
    system = sf.System([x, y, z], [u, w, v], sp.eye(3), [1, 0, t])
    contacts = [sf.Contact("table", (u, w), 1, LAWS["coulomb"]), sf.Contact("rail", v, load, LAWS["coulomb"])]
    scene = sf.Scene(system, contacts, {MU: 0.5}, dict.fromkeys((x, y, z, u, w, v), 0.0), 2.0)
    run = sf.prepare(scene, 1e-10, sensitivities=["mu"]).run().checked()
    assert run.final[[0, 3]] == pytest.approx([1.0, 1.0], rel=1e-12)  # of (1 - mu) t^2/2 and its rate
    assert run.sensitivities["mu"][[0, 3]] == pytest.approx([-2.0, -2.0], rel=1e-9)
