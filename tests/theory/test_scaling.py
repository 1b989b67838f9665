"""Scale factors against the printed tables; similarity against simulated isolators on a shaken ground."""

import numpy as np
import pytest
import sympy as sp
from hypothesis import given, settings
from hypothesis import strategies as st

import symfric as sf
from symfric.theory import scaling

SCALES = (4, 7, 10, 13, 16, 19)
X, W = sp.symbols("x w", real=True)
POSITIVE = st.floats(0.05, 50)
UNHURRIED = settings(max_examples=40, deadline=None)


def isolator(factors, gravity, *, slope=0.0, mu=0.05):
    """Rolling isolator with friction mu + slope |u| under a sine, every quantity scaled; extremes and end of u, then of its rate."""
    pull = 3.0 * factors.acceleration * sp.sin(4 / factors.time * sf.TIME)
    damper = 100.0 * factors.damping / (300.0 * factors.mass)
    friction = 1 + slope / mu * factors.friction_increment * sp.Abs(X)
    scene = sf.Scene(
        system=sf.System(q=[X], u=[W], mass=[[1]], force=[-damper * W - pull]),
        contacts=[sf.Contact("roller", slip=W, normal=9.81 * gravity, law=sf.laws.coulomb(mu), profile=friction)],
        initial={X: 0.05 * factors.length, W: 0.0},
        horizon=7.3 * factors.time,
        outputs={"reach": sf.Min(X), "speed": sf.Max(W)},
    )
    run = sf.simulate(scene, tolerance=1e-11).checked()
    return np.array([run.outputs["reach"], run.final[0], run.outputs["speed"], run.final[1]])


def ratios(model, prototype, factors):
    return scaling.returned_ratio(model, prototype, np.repeat([factors.length, factors.velocity], 2))


@pytest.mark.one_in(2)
@pytest.mark.parametrize("data", [{"L": 7}, {"L": 16, "mass": 0.008163}, {"L": 4, "D": 0.3}])
def test_scaled_gravity_and_positions_return_the_prototype(data):
    prototype = isolator(scaling.factors(1), 1.0, slope=0.08)
    factors = scaling.factors(**data)
    found = ratios(isolator(factors, factors.gravity_1, slope=0.08), prototype, factors)
    np.testing.assert_allclose(found, 1.0, rtol=1e-8)


def test_unscaled_gravity_is_another_friction():
    factors = scaling.factors(7)
    model = isolator(factors, factors.gravity_2)
    assert np.max(np.abs(ratios(model, isolator(scaling.factors(1), 1.0), factors) - 1)) > 0.1
    twin = isolator(scaling.factors(1), 1.0, mu=0.05 * factors.friction_distortion)
    np.testing.assert_allclose(ratios(model, twin, factors), 1.0, rtol=1e-8)


@pytest.mark.parametrize("L", SCALES)
def test_tables(L):
    first, second = scaling.factors(L), scaling.factors(L, mass=0.008163)
    assert first.acceleration == first.gravity_1 == first.friction_increment == L
    assert first.time == first.length == 1 / L
    assert first.velocity == first.density == first.gravity_2 == 1
    assert first.force == first.damping == pytest.approx(1 / L**2)
    assert first.mass == pytest.approx(1 / L**3)
    assert second.mass == pytest.approx(0.008163, rel=1e-15)
    assert second.density == pytest.approx(
        dict(zip(SCALES, (0.522, 2.800, 8.163, 17.934, 33.436, 55.990), strict=True))[L], abs=5e-4
    )


@UNHURRIED
@given(L=POSITIVE, D=POSITIVE)
def test_factors_are_those_of_one_set_of_units(L, D):
    f = scaling.factors(L, D)
    assert f.mass == pytest.approx(f.density * f.length**3)
    assert f.velocity == pytest.approx(f.length / f.time)
    assert f.acceleration == pytest.approx(f.velocity / f.time)
    assert f.force == pytest.approx(f.mass * f.acceleration)
    assert f.force == pytest.approx(f.stress * f.length**2)
    assert f.damping == pytest.approx(f.force / f.velocity)
    assert f.friction_distortion == pytest.approx(D / L)


@UNHURRIED
@given(L=POSITIVE, D=POSITIVE)
def test_formulas_give_the_numbers(L, D):
    numbers, formulas = scaling.factors(L, D).to_dict(), scaling.factors(symbolic=True).to_dict()
    for name, formula in formulas.items():
        assert float(formula.subs(dict(zip(scaling.SYMBOLS, (L, D), strict=True)))) == numbers[name]


def test_returned_ratio_of_arrays_symbols_and_zeros():
    assert scaling.returned_ratio(2.0, 4.0, 0.25) == 2.0
    assert np.isinf(scaling.returned_ratio(1.0, 0.0, 2.0))
    assert np.isnan(scaling.returned_ratio(0.0, 0.0, 2.0))
    np.testing.assert_allclose(scaling.returned_ratio([1.0, 2.0], [4.0, 4.0], 0.5), [0.5, 1.0])
    model, prototype, factor = sp.symbols("model prototype factor")
    assert scaling.returned_ratio(model, prototype, factor) == model / (factor * prototype)


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({}, "no L"),
        ({"L": 0}, "L is 0"),
        ({"L": 4, "D": -1}, "D is -1"),
        ({"L": 4, "mass": 0}, "mass is 0"),
        ({"L": 4, "D": 1, "mass": 1}, "both given"),
        ({"L": "4"}, "L is '4'"),
    ],
)
def test_wrong_input_is_refused_by_name(arguments, message):
    with pytest.raises(sf.SceneError, match=message):
        scaling.factors(**arguments)
