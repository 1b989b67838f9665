"""Functions of time that become states of the route `exact`, inside and outside a Piecewise."""

import pytest
import sympy as sp

import symfric as sf

X, U, Y, W = sp.symbols("x u y w", real=True)
T = sf.TIME
SHAPES = {
    "parabola": sp.Piecewise((0, T < 1), ((T - 1) ** 2 / 4, T < 3), (1, True)),
    "wave": sp.Piecewise((0, T < 1), (sp.sin(3 * (T - 1)), True)),
    "cubic": sp.Piecewise((T**3, T < 1), (1, True)),
}


@pytest.mark.one_in(6)
@pytest.mark.parametrize("shape", SHAPES)
@pytest.mark.parametrize("where", ["load", "force"])
def test_a_continuous_piecewise_of_time_is_taken_by_some_route(shape, where):
    f = SHAPES[shape]
    system = sf.System([X, Y], [U, W], sp.eye(2), [Y - 2 * X + (f if where == "force" else 0), X - 2 * Y])
    load = 1 + f**2 if where == "load" else 1
    contacts = [sf.Contact("a", U - 0.3, load, sf.laws.coulomb(0.2)), sf.Contact("b", W, 1, sf.laws.coulomb(0.1))]
    scene = sf.Scene(system, contacts, {}, {X: 0.5, Y: 0.4, U: 0, W: 0}, 4.0)
    run = sf.simulate(scene, tolerance=1e-11)
    assert run.route == sf.explain(scene).route
    assert run.checked().energy_residual() < 1e-9
    assert run.final == pytest.approx(sf.simulate(scene, 1e-6, "integrators").final, abs=1e-4)
