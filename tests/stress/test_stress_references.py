"""A dozen motions against steps in multiple precision that know nothing of the solvers."""

import numpy as np
import pytest
import sympy as sp

import symfric as sf
from symfric_evidence.bench.many_digits import many_digits
from symfric_evidence.bench.problems import problems
from tests.longer import longer

X, U, Y, W = sp.symbols("x u y w", real=True)
LAWS = {
    "coulomb with a drop": sf.laws.coulomb(0.4, 0.3),
    "cubic": sf.laws.cubic(0.4, 0.25, 0.5),
    "stribeck": sf.laws.stribeck(0.4, 0.25, 0.3),
    "lorentz": sf.laws.lorentz(0.4, 0.5, b=0.02),
    "gauss": sf.laws.gauss(0.4, 0.5, b=0.02),
    "exponential": sf.laws.exponential(0.4, 0.7),
    "custom": sf.laws.custom(0.2 + 0.1 / (1 + sf.SPEED) ** 2, 0.35),
}


def shaken(law):
    force = [sp.cos(sf.TIME) / 2 - sp.sin(X)]
    system = sf.System(q=[X], u=[U], mass=[[1]], force=force)
    return sf.Scene(system, [sf.Contact("belt", U - 0.2, 1, law)], initial={X: 0.5, U: 0.0}, horizon=2.0)


SPRINGS = (sp.cos(sf.TIME) - 2 * X + Y, X - 2 * Y)


def pair(contacts, *, mass=((1, 0), (0, 1)), force=SPRINGS, start=(0.5, 0.0)):
    system = sf.System(q=[X, Y], u=[U, W], mass=mass, force=force)
    initial = {X: start[0], Y: start[1], U: 0.0, W: 0.0}
    return sf.Scene(system, contacts, initial=initial, horizon=1.0)


def each(first, second):
    return [sf.Contact("one", U - 0.1, 1, first), sf.Contact("two", W, 0.7, second)]


SCENES = {
    **{name: shaken(law) for name, law in LAWS.items()},
    "two masses": pair(each(LAWS["coulomb with a drop"], LAWS["stribeck"])),
    "coupled by mass": pair(each(LAWS["cubic"], LAWS["coulomb with a drop"]), mass=((2, 0.3), (0.3, 1))),
    "on each other": pair([sf.Contact("face", W - U, 0.8, LAWS["stribeck"]), sf.Contact("floor", U, 1, LAWS["gauss"])]),
    "pendulum": pair(
        each(LAWS["lorentz"], LAWS["exponential"]),
        mass=((2, sp.cos(X) / 3), (sp.cos(X) / 3, 1)),
        force=(-X, -3 * sp.sin(Y) + W**2 / 5),
        start=(1.0, 0.5),
    ),
    "loads that vary": pair(
        [
            sf.Contact("one", U - 0.1, 1 + sp.sin(Y) / 4, LAWS["cubic"], 1 + sp.cos(X) / 5),
            sf.Contact("two", W, 0.5 + sp.cos(2 * sf.TIME) / 4, LAWS["coulomb with a drop"]),
        ]
    ),
}


@pytest.mark.one_in(4)
@pytest.mark.parametrize(
    "name",
    longer(
        SCENES,
        ("stribeck", "exponential", "gauss", "lorentz", "two masses", "on each other", "pendulum", "loads that vary"),
    ),
)
def test_motions_agree_with_multiple_precision(name):
    reference = many_digits(SCENES[name], digits=22)
    final = np.array([float(x) for x in reference.final])
    for tolerance in (1e-6, 1e-9, 1e-13):
        run = sf.simulate(SCENES[name], tolerance).checked()
        assert run.stats["events"] == reference.events
        assert np.max(np.abs(run.final - final)) < 10 * tolerance


@pytest.mark.long(beside="test_motions_agree_with_multiple_precision")
def test_the_reference_agrees_with_that_of_the_benchmark():
    problem = problems()["P2"]
    found = many_digits(problem.scene.until(3.0), digits=22)
    run = sf.simulate(problem.scene.until(3.0), 1e-15)
    assert found.events == run.stats["events"]
    assert [float(x) for x in found.final] == pytest.approx(run.final, abs=3e-15)
