"""Numbers that leave no positive definite mass: refused in words by a run, a status among many cases."""

import numpy as np
import pytest
import sympy as sp

import symfric as sf

X, Y, U, W = sp.symbols("x y u w", real=True)
M, J, C = sp.symbols("m j c", real=True)
RUB = sf.Contact("rub", U - sp.Rational(1, 10), 1, sf.laws.coulomb(0.1))


def scene(mass, force, values, law=None, **starts):
    size = len(force)
    contact = RUB if law is None else sf.Contact("rub", U - sp.Rational(1, 10), 1, law)
    initial = dict.fromkeys((X, Y)[:size], 0.3) | dict.fromkeys((U, W)[:size], 0.0) | starts
    system = sf.System([X, Y][:size], [U, W][:size], mass, force)
    return sf.Scene(system, [contact], values, initial, 1.0, {"far": sf.Max(X)})


# mass that depends on one value, on several together, on a value that is zero, on where the motion starts
SCENES = {
    "exact": (scene([[M]], [-X], {M: 1.0}), {"m": -1.0}, "with m = -1"),
    "zero": (scene([[M]], [-X], {M: 1.0}), {"m": 0.0}, "with m = 0"),
    "taylor": (scene([[M]], [-sp.sin(X)], {M: 1.0}, sf.laws.cubic(0.4, 0.25, 0.5)), {"m": -1e300}, "with m = -1e"),
    "coupled": (scene([[M, C], [C, J]], [-X, -Y], {M: 1.0, J: 2.0, C: 0.0}), {"c": 1.5}, "with c = 1.5"),
    "added to": (scene([[1 + M]], [-sp.sin(X)], {M: 0.0}), {"m": -1.0}, "with m = -1"),
}


@pytest.mark.one_in(3)
@pytest.mark.parametrize("name", SCENES)
def test_a_run_refuses_it_and_a_case_among_many_has_a_status(name):
    made, bad, words = SCENES[name]
    program = sf.prepare(made)
    with pytest.raises(sf.SceneError, match=f"mass matrix is not positive definite at the start, {words}"):
        program.run(bad)
    ((value, number),) = bad.items()
    good = dict(made.parameter_values())[sp.Symbol(value, real=True)] + 0.25
    batch = program.map({value: np.array([good, number, good])})
    assert batch.status.tolist() == [sf.Status.OK, sf.Status.NOT_FINITE, sf.Status.OK]
    assert np.isnan(batch["far"][1])
    assert batch.final[:, 0].tobytes() == batch.final[:, 2].tobytes() == program.run({value: good}).final.tobytes()


def test_a_start_where_the_mass_vanishes():
    program = sf.prepare(scene([[2 + X]], [-X], {}))
    assert program.run(initial={"x": -1.5}).status == sf.Status.OK
    with pytest.raises(sf.SceneError, match="not positive definite at the start$"):
        program.run(initial={"x": -2.0})
    assert program.map(initial={"x": np.array([-2.5, 0.3])}).status.tolist() == [sf.Status.NOT_FINITE, sf.Status.OK]


def test_a_start_that_follows_a_value_to_where_the_mass_vanishes():
    program = sf.prepare(scene([[2 + X]], [-X], {C: 0.3}, x=C))
    assert program.run({"c": 0.5}).status == sf.Status.OK
    with pytest.raises(sf.SceneError, match="not positive definite at the start"):
        program.run({"c": -3.0})
    assert program.map({"c": np.array([-3.0, 0.5])}).status.tolist() == [sf.Status.NOT_FINITE, sf.Status.OK]


def test_masses_of_many_cases_have_derivatives_beside_one_that_fails():
    program = sf.prepare(scene([[M]], [-X], {M: 1.0}), sensitivities=["m"])
    batch = program.map({"m": np.array([1.5, -1.0])})
    assert batch.status.tolist() == [sf.Status.OK, sf.Status.NOT_FINITE]
    assert np.isfinite(batch.sensitivities["m"][0, 0])
    assert np.isnan(batch.sensitivities["m"][0, 1])
