"""Derivatives where the velocity jumps: across sliders that turn, and kinks of forces and loads."""

import numpy as np
import pytest
import sympy as sp

import symfric as sf

x, u, P = sp.symbols("x u P", real=True)
KICKS = {
    "at a time": lambda to: [sf.Reset(at=[0.5], set={u: to})],
    "at a time that moves": lambda to: [sf.Reset(at=[P / 2], set={u: to})],
    "at a place": lambda to: [sf.Reset(guard=sp.Rational(2, 5) - x, set={u: to})],
}
ENDS = {"turned": -u, "slower and turned": -u / 3, "faster": u + sp.Rational(1, 5)}
RESISTING = {
    "spring": (0, [sf.Contact("c", u, 1, sf.laws.coulomb(0.3), stiffness=10.0)]),
    "sliders": (0, [sf.Contact("c", u, 1, sf.laws.maxwell_slip([10.0, 5.0], [0.2, 0.1]))]),
    "drag": (-sp.Rational(2, 5) * u * sp.Abs(u), [sf.Contact("c", u, 1, sf.laws.coulomb(0.2))]),
    "load with the speed": (0, [sf.Contact("c", u, 1 + sp.Abs(u), sf.laws.coulomb(0.2))]),
}


def check(force, contacts, resets=()):
    """Assert that the derivatives of the final state by P are those of differences."""
    system = sf.System([x], [u], [[1]], [force - P * x])
    scene = sf.Scene(system, contacts, {P: 1.0}, {x: 0.0, u: 1.0}, 1.5, resets=list(resets))
    run = sf.simulate(scene, 1e-13, sensitivities=["P"]).checked()
    program, h = sf.prepare(scene, 1e-13), 1e-5
    differences = (program.run({"P": 1 + h}).final - program.run({"P": 1 - h}).final) / (2 * h)
    assert run.sensitivities["P"] == pytest.approx(differences, abs=1e-8)


@pytest.mark.one_in(6)
@pytest.mark.parametrize("resisting", RESISTING)
@pytest.mark.parametrize("end", ENDS)
@pytest.mark.parametrize("kick", KICKS)
def test_kicks(kick, end, resisting):
    force, contacts = RESISTING[resisting]
    check(force, contacts, KICKS[kick](ENDS[end]))


@pytest.mark.one_in(3)
@pytest.mark.parametrize("resisting", RESISTING)
def test_impacts(resisting):
    force, contacts = RESISTING[resisting]
    check(force, [*contacts, sf.Contact("stop", None, sf.Unilateral(sp.Rational(2, 5) - x, 0.7))])


@pytest.mark.parametrize("resisting", ["spring", "sliders"])
def test_impacts_without_a_rebound(resisting):
    force, contacts = RESISTING[resisting]
    check(force + sp.Rational(1, 2), [*contacts, sf.Contact("stop", None, sf.Unilateral(sp.Rational(2, 5) - x))])


def test_multipliers_of_a_cycle_of_kicks():
    """A mass that a clock turns, between which a slider resists."""
    kick = sf.Reset(every=1.0, set={u: -u + sp.Rational(1, 10)})
    system = sf.System([x], [u], [[1]], [-x - u / 5])
    scene = sf.Scene(system, RESISTING["spring"][1], {}, {x: 0.0, u: 1.0}, 20.0, resets=[kick])
    orbit = sf.limit_cycle(scene, tolerance=1e-13)
    program, start, h = sf.prepare(scene.until(orbit.period), 1e-13), orbit.start, 1e-6
    assert {e.kind for e in orbit.events} >= {"slip", "stick"}

    def image(at):
        return program.run(initial=dict(zip(orbit.run.names, at, strict=True))).final

    slopes = np.column_stack([(image(start + e) - image(start - e)) / (2 * h) for e in h * np.eye(3)])
    assert np.sort(np.abs(orbit.multipliers)) == pytest.approx(np.sort(np.abs(np.linalg.eigvals(slopes))), abs=1e-7)
