"""Grazes swept through, chatter, contacts that share a slip, and starts that hardly slip: closed forms or a second route."""

import math

import numpy as np
import pytest
import sympy as sp

import symfric as sf

X, U = sp.symbols("x u", real=True)
N, M, C, V = sp.symbols("N M c v", real=True)
BOUNDED = sf.Taylor(max_steps=200_000, max_events=20_000)
SPEED, MU, HORIZON = 0.2, 0.3, 8.0


def one_mass(force, contacts, *, values, x=0.0, u=0.0, horizon=HORIZON):
    system = sf.System(q=[X], u=[U], mass=[[1]], force=[force])
    return sf.Scene(system, contacts, values, {X: x, U: u}, horizon)


BELT = one_mass(-X, [sf.Contact("belt", U - SPEED, 1, sf.laws.coulomb(MU))], values={})
WAYS = [("exact", 1e-9), ("taylor", 1e-6), ("taylor", 1e-9), ("taylor", 1e-12)]


def circling(amplitude):
    """Final state from (mu + amplitude, 0): a circle about mu; one larger than the belt's speed is caught once."""
    if amplitude <= SPEED:
        return MU + amplitude * math.cos(HORIZON), -amplitude * math.sin(HORIZON)
    ahead = math.sqrt((amplitude - SPEED) * (amplitude + SPEED))
    caught = math.pi + math.atan2(SPEED, ahead)
    left = HORIZON - caught - ahead / SPEED
    return MU + SPEED * math.sin(left), SPEED * math.cos(left)


@pytest.mark.parametrize("way", WAYS, ids=str)
def test_a_graze_swept_through_to_1e_12_on_both_sides(way):
    program = sf.prepare(BELT, way[1], way[0])
    allowed = 1e-12 if way[0] == "exact" else 10 * way[1]
    for beyond in [0.0, *(side * 10.0**-k for k in range(1, 13) for side in (-1, 1))]:
        amplitude = SPEED * (1 + beyond)
        run = program.run(initial={"x": MU + amplitude}).checked()
        # the circle is left by the root of what it is larger by: so far can a run be that does not see it
        blind = SPEED * beyond if 0 < beyond < 10 * allowed else 0.0
        assert run.final == pytest.approx(circling(amplitude), abs=allowed + blind), beyond
        if abs(beyond) > 10 * allowed:
            assert any(e.after == 0 for e in run.events) == (beyond > 0)


@pytest.mark.parametrize("route", ["exact", "taylor"])
@pytest.mark.parametrize("speed", [0.3, -0.3])
def test_a_start_hardly_above_the_bound_is_caught_again(route, speed):
    # with the belt the spring unloads: a slip that begins at 0.4 (1 + excess) ends after 0.8 excess / speed
    scene = one_mass(C - X, [sf.Contact("belt", U - V, 1, sf.laws.coulomb(0.4))], values={C: 0.4, V: speed}, u=speed)
    program = sf.prepare(scene, 1e-10, route)
    side = 1 if speed > 0 else -1
    released = program.run({"c": 0.4 * side}).checked()
    for power in range(-17, -4):
        run = program.run({"c": 0.4 * side * (1 + 10.0**power)}).checked()
        assert run.final == pytest.approx(released.final, abs=10.0 ** (power + 1) + 1e-9)
        assert run.mode[0, -1] == released.mode[0, -1]


@pytest.mark.one_in(4)
@pytest.mark.parametrize("route", ["exact", "taylor", "integrators"])
@pytest.mark.parametrize("order", [1, -1])
def test_a_contact_without_load_holds_nothing(route, order):
    law = sf.laws.coulomb(0.4, 0.3)
    loaded, alone = sf.Contact("loaded", U, N, law), sf.Contact("empty", U, M, law)
    scene = one_mass(C * sf.TIME - X, [loaded, alone][::order], values={N: 1.0, M: 1.0, C: 0.3}, x=0.3, horizon=5.0)
    run = sf.prepare(scene, 1e-9, route).run({"M": 0.0}).checked()
    single = sf.simulate(one_mass(C * sf.TIME - X, [loaded], values={N: 1.0, C: 0.3}, x=0.3, horizon=5.0), 1e-12)
    assert single.events[0].t == pytest.approx(0.7 / 0.3)
    assert run.final == pytest.approx(single.final, abs=1e-8)


def test_what_static_friction_holds_stays_at_rest_when_another_lets_go():
    # body 2 drags body 1 to a stop; both are released in search of the mode, but the ground can hold body 1
    y, w = sp.symbols("y w", real=True)
    system = sf.System(q=[X, y], u=[U, w], mass=sp.eye(2), force=[-X, 3 - y])
    contacts = [
        sf.Contact("between", w - U, 1.0, sf.laws.coulomb(0.5)),
        sf.Contact("ground", U, 1.0, sf.laws.coulomb(0.9, 0.3)),
    ]
    scene = sf.Scene(system, contacts, initial={X: 0.2, y: 0.0, U: 0.0, w: 0.0}, horizon=1.0)
    runs = [sf.simulate(scene, 1e-9, route).checked() for route in ("exact", "taylor", "integrators")]
    for run in runs:
        assert run.mode[:, 0].tolist() == [1, 0]
        assert run.final[[0, 2]].tolist() == [0.2, 0.0]


@pytest.mark.one_in(2)
@pytest.mark.parametrize("n", [2, 4])
def test_equal_masses_with_equal_contacts_move_as_one(n):
    q, u = sp.symbols(f"q:{n}", real=True), sp.symbols(f"u:{n}", real=True)
    force = [-q[i] + sum(q[j] - q[i] for j in (i - 1, i + 1) if 0 <= j < n) for i in range(n)]
    law = sf.laws.stribeck(0.4, 0.25, 0.3)
    contacts = [sf.Contact(f"c{i}", u[i] - 0.2, 1, law) for i in range(n)]
    scene = sf.Scene(sf.System(q, u, sp.eye(n), force), contacts, initial=dict.fromkeys([*q, *u], 0.0), horizon=20.0)
    one = sf.simulate(one_mass(-X, [sf.Contact("c", U - 0.2, 1, law)], values={}, horizon=20.0), 1e-12)
    run = sf.simulate(scene, 1e-10).checked()
    assert run.stats["events"] == n * one.stats["events"] > 0
    assert run.final == pytest.approx(np.repeat(one.final, n), abs=1e-9)


@pytest.mark.one_in(2)
@pytest.mark.parametrize("tolerance", [1e-6, 1e-12])
def test_reversals_that_accumulate_end_with_a_status(tolerance):
    # the ground swings ever faster before t = 1, infinitely often: the slip has no last reversal
    rest = 1 - sf.TIME
    ground = sf.Contact("ground", U - rest**2 * sp.sin(1 / rest), 1, sf.laws.coulomb(1e-3))
    run = sf.simulate(one_mass(-X, [ground], values={}, horizon=2.0), tolerance, BOUNDED)
    assert run.status != sf.Status.OK
    assert run.advice
    assert run.t_final == pytest.approx(1, abs=1e-2)
