"""Belts that accelerate apart: a body sticks to one of them, whatever the slip on the others; several may touch zero."""

import numpy as np
import pytest
import sympy as sp

import symfric as sf
from tests.longer import longer

X, U, Y, W = sp.symbols("x u y w", real=True)


def belts(seed):
    """One or two bodies, each pulled by one to three belts whose speeds vary with time and cross each other."""
    rng = np.random.default_rng([23, seed])
    n = int(rng.integers(1, 3))
    contacts = []
    for k in range(int(rng.integers(2, 4))):
        load, mu, size, Omega = rng.uniform([0.5, 0.15, 0.1, 0.8], [1.5, 0.5, 0.4, 5.0])
        way = [sp.sin(Omega * sf.TIME) ** 3, sp.sin(Omega * sf.TIME), 1 - sp.cos(Omega * sf.TIME)][int(rng.integers(3))]
        body = U if n == 1 or rng.random() < 0.6 else W
        law = sf.laws.coulomb(mu * rng.choice([1.0, 1.2]), mu)
        contacts.append(sf.Contact(f"c{k}", rng.choice([-1, 1]) * (body - size * way), load, law))
    damping, stiffness = rng.uniform([0.03, 1.0], [0.2, 4.0])
    force = [-damping * U - stiffness * X - (X - Y) * (n - 1), -Y + (X - Y)][:n]
    system = sf.System([X, Y][:n], [U, W][:n], sp.eye(n), force)
    start = {X: rng.uniform(-0.6, 0.6), U: rng.choice([0.0, rng.uniform(-0.3, 0.3)])}
    start |= {Y: 0.1, W: 0.0} if n == 2 else {}
    return sf.Scene(system, contacts, {}, start, 5.0)


@pytest.mark.one_in(9)
@pytest.mark.parametrize("seed", longer(range(24), range(8, 24)))
def test_a_body_follows_the_belt_it_sticks_to(seed):
    scene = belts(seed)
    run = sf.simulate(scene, 1e-11, "taylor").checked()
    assert run.energy_residual() < 1e-10
    times = np.linspace(0, 5, 2001)
    modes = run.mode[:, np.clip(np.searchsorted(run.t, times, side="right") - 1, 0, run.mode.shape[1] - 1)]
    x = run(times)
    for c, mode in zip(scene.contacts, modes, strict=True):
        slip = sp.lambdify([sf.TIME, *scene.system.states], c.slip)(times, *x)
        assert np.max(np.abs(slip[mode == 0]), initial=0.0) < 1e-10
    other = sf.simulate(scene, 1e-9, "integrators").checked()
    assert other.final == pytest.approx(run.final, abs=1e-7)


@pytest.mark.one_in(2)
@pytest.mark.parametrize("route", ["taylor", "integrators"])
def test_a_belt_that_starts_to_move_without_acceleration_leaves_what_rests(route):
    belt = sf.Contact("belt", U - sp.sin(sf.TIME) ** 3, 0.5, sf.laws.coulomb(0.4))
    floor = sf.Contact("floor", U, 1.0, sf.laws.coulomb(0.5))
    for contacts in ([floor, belt], [belt, floor]):
        scene = sf.Scene(sf.System([X], [U], [[1]], [-X]), contacts, {}, {X: 0.1, U: 0}, 3.0)
        run = sf.simulate(scene, 1e-10, route).checked()
        assert run.final == pytest.approx([0.1, 0.0], abs=1e-12)
        slipping = [c.name for c in contacts].index("belt")
        assert run.mode[slipping][-1] == -1


@pytest.mark.one_in(4)
@pytest.mark.parametrize("route", ["taylor", "exact", "integrators"])
def test_slips_that_are_a_parameter_times_another_share_their_force(route):
    """Contacts rest together whatever the ratio of their slips; it needs no number for that."""
    e = sp.Symbol("e", positive=True)
    law = sf.laws.coulomb(0.5, 0.3)
    system = sf.System([X], [U], [[1]], [-X])

    def final(*contacts, **values):
        scene = sf.Scene(system, contacts, values, {X: 1.4, U: 0.0}, 12.0)
        return sf.simulate(scene, 1e-9, route).checked().final

    one = final(sf.Contact("a", U - 0.1, 1.0, law))
    for value in (3e-10, 0.5, 20.0):
        pair = sf.Contact("a", U - 0.1, 0.6, law), sf.Contact("b", (1 + e) * (U - 0.1), 0.4 / (1 + value), law)
        assert final(*pair, e=value) == pytest.approx(one, abs=1e-7)
