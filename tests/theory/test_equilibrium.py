"""Steady sliding, and refusals where there is none."""

import numpy as np
import pytest
import sympy as sp

import symfric as sf
from symfric.theory.equilibrium import equilibrium

x, u = sp.symbols("x u", real=True)


def one_mass(force, contacts=(), values=None, start=0.0):
    system = sf.System(q=[x], u=[u], mass=[[1]], force=[force])
    return sf.Scene(system=system, contacts=contacts, values=values or {}, initial={x: start, u: 0.0}, horizon=1.0)


def test_belt_rests_where_friction_balances_the_spring():
    found = equilibrium(sf.scenes.mass_on_belt(v_b=0.2))
    law = sf.laws.cubic(0.4, 0.25, 0.5)
    assert found.x.shape == (2,)
    assert found.x == pytest.approx([law(0.2), 0.0], rel=1e-15)
    assert found.sliding == {"belt": -0.2}
    assert found.to_dict()["x"]["x"] == found.x[0]
    assert "x=0.3148" in repr(found)


def test_many_masses_with_many_contacts_and_first_order_states():
    n = 6
    q, v = sp.symbols(f"q0:{n}", real=True), sp.symbols(f"v0:{n}", real=True)
    z = sp.Symbol("z", real=True)
    force = [-(i + 1) * q[i] - (q[i] - q[i - 1] if i else 0) - (q[i] - q[i + 1] if i < n - 1 else 0) for i in range(n)]
    force[0] += z
    contacts = [
        sf.Contact(f"c{i}", slip=v[i] - (-1) ** i * (0.3 + 0.1 * i), normal=1 + i, law=sf.laws.stribeck(0.4, 0.2, 0.3))
        for i in range(n)
    ]
    scene = sf.Scene(
        system=sf.System(q=q, u=v, mass=sp.eye(n), force=force, z=[z], z_rate=[1 - z - 0.1 * q[0] ** 3]),
        contacts=contacts,
        initial=dict.fromkeys((*q, *v, z), 0.0),
        horizon=1.0,
    )
    found = equilibrium(scene)
    stiffness = np.array([[float(-f.diff(s)) for s in q] for f in force])
    load = np.zeros(n)
    for i in range(n):
        slip = -((-1) ** i) * (0.3 + 0.1 * i)
        assert found.sliding[f"c{i}"] == pytest.approx(slip)
        load[i] = -(1 + i) * sf.laws.stribeck(0.4, 0.2, 0.3)(slip)
    load[0] += found.x[-1]
    assert found.x[:n] == pytest.approx(np.linalg.solve(stiffness, load), rel=1e-12)
    assert found.x[-1] + 0.1 * found.x[0] ** 3 == pytest.approx(1.0, rel=1e-14)


@pytest.mark.parametrize("start", [0.0, 5.0, -5.0])
def test_kinked_forces(start):
    stop = sp.Max(0, x - sp.Rational(1, 2)) * 100 + sp.Abs(x) / 2 + sp.Min(x, 0)
    found = equilibrium(one_mass(10 - x - stop, start=start))
    # 10 - x - 100 (x - 1/2) - x/2 = 0
    assert found.x[0] == pytest.approx(60 / 101.5, rel=1e-14)
    assert found.sliding == {}


def test_position_dependent_belt_speed_turns_round():
    law = sf.laws.coulomb(0.5)
    contact = sf.Contact("disc", slip=u - x, normal=1, law=law)
    found = equilibrium(one_mass(2 - x, [contact], start=1.0))
    assert found.x[0] == pytest.approx(2.5, rel=1e-14)  # slip -x < 0: friction pushes forward


def test_smooth_laws_may_rest():
    for shape in ("linear", "arctan", "tanh"):
        scene = sf.scenes.mass_on_belt(v_b=0.0).regularised(1e-3, shape=shape)
        assert equilibrium(scene).x == pytest.approx([0.0, 0.0], abs=1e-15)


def test_refusals():
    with pytest.raises(sf.SceneError, match="contact 'floor' does not slip"):
        equilibrium(sf.scenes.coulomb_oscillator(0.1))
    with pytest.raises(sf.SceneError, match=r"depends on time; use sf\.separate"):
        equilibrium(sf.scenes.mass_on_belt(v_b=0.2, a=0.01, Omega=50.0))
    with pytest.raises(sf.SceneError, match="no value for v_b"):
        equilibrium(sf.scenes.mass_on_belt(v_b=None))
    with pytest.raises(sf.NotFound, match="no position balances"):
        equilibrium(one_mass(1 + x**2))
    with pytest.raises(sf.NotFound, match="without a spring"):
        equilibrium(one_mass(sp.Integer(1) - u))
    g = sp.Symbol("g")
    system = sf.System(q=[x], u=[u], mass=[[1]], force=[-x - g])
    driven = sf.Scene(system=system, inputs={g: sf.Signal([0.0, 1.0], 0.1)}, initial={x: 0.0, u: 0.0}, horizon=1.0)
    with pytest.raises(sf.SceneError, match="sampled input g"):
        equilibrium(driven)


def test_excitation_of_amplitude_zero_is_no_excitation():
    scene = sf.scenes.mass_on_belt(v_b=0.2, a=0.0, Omega=50.0)
    assert equilibrium(scene).x[0] == pytest.approx(0.3148, rel=1e-14)


def with_load(normal, pull, n=1):
    """Return a mass (or one in the plane) on a belt, whose load depends on where it is."""
    y, w = sp.symbols("y w", real=True)
    slip = u - 1 if n == 1 else (u - 1, w - sp.Rational(1, 5))
    contact = sf.Contact("b", slip, normal, sf.laws.stribeck(0.5, 0.3, 0.5))
    q, rates, force = [x, y][:n], [u, w][:n], [-x - pull - u / 10, -y - 2 - w / 5][:n]
    system = sf.System(q, rates, sp.eye(n), force)
    return sf.Scene(system, [contact], {}, dict.fromkeys([*q, *rates], 0.0), 50.0)


@pytest.mark.parametrize("question", [equilibrium, sf.stability])
def test_where_a_load_is_negative_nothing_slides_steadily(question):
    with pytest.raises(sf.NotFound, match=r"load of contact 'b' is -5\.9.*let go"):
        question(with_load(1 + x, 5))
    with pytest.raises(sf.NotFound, match="load of contact 'b' is -1"):
        question(with_load(1 + sp.Symbol("y", real=True), 0, n=2))


def test_of_several_places_one_with_a_load_is_taken():
    """The forces balance near x = 2 and x = -2; the load is negative at the one that is nearer to the first starts."""
    contact = sf.Contact("b", u - 1, (1 + x) / 100, sf.laws.coulomb(0.5))
    scene = sf.Scene(sf.System([x], [u], [[1]], [4 - x**2 - u]), [contact], {}, {x: 0.0, u: 0.0}, 1.0)
    expected = (0.005 + np.sqrt(0.005**2 + 4 * 4.005)) / 2
    for start in (-0.99, -0.9, 0.5, 5.0):
        assert equilibrium(scene.starting({"x": start})).x[0] == pytest.approx(expected, rel=1e-12)


def test_a_load_that_is_zero_there_is_one():
    assert equilibrium(with_load(1 + x / 5, 5)).x[0] == pytest.approx(-5.0, abs=1e-9)
