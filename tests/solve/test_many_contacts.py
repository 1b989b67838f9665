"""Linear systems with many Coulomb contacts over long times: energies, simultaneous events, redundant sticks."""

import numpy as np
import pytest
import sympy as sp

import symfric as sf

X, U = sp.symbols("x u", real=True)
LAW = sf.laws.coulomb(0.5, 0.3)


def chain(n=10, speed=0.2, horizon=100.0):
    """Masses on one belt, each held by a spring and tied to its neighbours; the loads are parameters."""
    q, u, loads = (sp.symbols(f"{letter}:{n}", real=True) for letter in ("q", "u", "load"))
    force = [-q[i] / 2 - sp.Rational(1, 20) * u[i] for i in range(n)]
    for i in range(n - 1):
        force[i] += q[i + 1] - q[i]
        force[i + 1] += q[i] - q[i + 1]
    contacts = [sf.Contact(f"c{i}", slip=u[i] - speed, normal=loads[i], law=LAW) for i in range(n)]
    system = sf.System(q=q, u=u, mass=sp.eye(n), force=force)
    start = dict.fromkeys([*q, *u], 0.0)
    return sf.Scene(system, contacts, values=dict.fromkeys(loads, 1.0), initial=start, horizon=horizon)


def block(*contacts, horizon=60.0, **wanted):
    system = sf.System(q=[X], u=[U], mass=[[1]], force=[-X - U / 10])
    return sf.Scene(system, contacts, initial={X: 0, U: 0}, horizon=horizon, outputs=wanted or None)


def test_ten_masses_with_ten_contacts_over_a_hundred_units():
    program = sf.prepare(chain())
    graded = program.run({f"load{i}": 1 + 0.05 * i for i in range(10)}).checked()
    assert graded.energy_residual() < 1e-8
    assert len({(e.contact, e.kind) for e in graded.events}) == 20
    assert len(graded.events) > 100
    equal = program.run().checked()
    assert equal.energy_residual() < 1e-8
    assert np.ptp(equal.final[:10]) < 1e-9  # they move as one
    times = np.array([e.t for e in equal.events]).reshape(-1, 10)
    assert len(times) > 10
    assert np.max(np.ptp(times, axis=1)) < 1e-9  # all ten at once


def test_a_block_between_two_belts_follows_the_stronger_one():
    belts = [sf.Contact("lower", U - 0.3, 2.0, LAW), sf.Contact("upper", U + 0.1, 0.5, LAW)]
    run = sf.simulate(block(*belts), 1e-12).checked()
    assert run.energy_residual() < 1e-11
    modes = np.unique(run.mode, axis=1).T.tolist()
    assert [0, 1] in modes  # carried by the lower belt, sliding on the upper one
    assert [0, 0] not in modes
    slip = [e for e in run.events if e.contact == "lower" and e.kind == "slip"][-1]
    # the bound of the lower belt carries the spring, the damper and the upper belt's kinetic friction
    assert run(slip.t)[0] == pytest.approx(0.5 * 2.0 - 0.3 * 0.5 - 0.3 / 10, abs=1e-10)


def test_redundant_sticks_share_the_force_and_leave_the_motion_alone():
    slip = U - 0.2
    wanted = {name: sf.Integral(sf.friction_force(name)) for name in "abc"}
    t = np.linspace(0, 20, 100)
    three = [sf.Contact("a", slip, 1.0, LAW), sf.Contact("b", 2 * slip, 0.5, LAW), sf.Contact("c", -slip, 1.0, LAW)]
    run = sf.simulate(block(*three, horizon=20.0, path=sf.Trajectory(), **wanted), 1e-12).checked()
    one = sf.simulate(
        block(sf.Contact("a", slip, 3.0, LAW), horizon=20.0, path=sf.Trajectory(), a=wanted["a"]), 1e-12
    ).checked()
    assert np.max(np.abs(run(t) - one(t))) < 1e-9
    assert run["a"] + 2 * run["b"] - run["c"] == pytest.approx(one["a"], rel=1e-9)
    assert run["a"] == pytest.approx(-run["c"], rel=1e-9)
    assert run.energy_residual() < 1e-11


def test_a_stack_that_sticks_as_a_whole_releases_where_its_weakest_face_gives_way():
    # three blocks of mass 1 on a table that pulls the lowest; the faces carry what accelerates the blocks above
    q, u = sp.symbols("q1:4", real=True), sp.symbols("u1:4", real=True)
    faces = [sf.Contact("low", u[1] - u[0], 2.0, LAW), sf.Contact("high", u[2] - u[1], 0.8, LAW)]
    system = sf.System(q=q, u=u, mass=sp.eye(3), force=[sf.TIME, 0, 0])
    scene = sf.Scene(system, faces, initial=dict.fromkeys([*q, *u], 0.0), horizon=1.5)
    run = sf.simulate(scene, 1e-12).checked()
    assert [(e.contact, e.kind) for e in run.events] == [("high", "slip")]
    assert run.events[0].t == pytest.approx(3 * 0.5 * 0.8, rel=1e-12)  # acceleration t/3, force on the highest t/3
    assert run.mode[:, -1].tolist() == [0, -1]


def test_redundant_contacts_are_named_once(caplog):
    x, u = sp.symbols("x u", real=True)
    law = sf.laws.coulomb(0.3)
    contacts = [sf.Contact("front", u, 1.0, law), sf.Contact("twin of front", 2 * u, 1.0, law)]
    scene = sf.Scene(sf.System([x], [u], [[1]], [-x]), contacts, initial={x: 1.0, u: 0.0}, horizon=5.0)
    for _ in range(2):
        sf.simulate(scene)
    said = [r.message for r in caplog.records if "twin of front" in r.message]
    assert len(said) == 1
    assert "the motion is unique" in said[0]
    assert sf.explain(scene).facts.redundant == ("twin of front",)


@pytest.mark.parametrize(
    ("second", "named"),
    [("2*u - 2*v", True), ("2*u - v", False), ("u - v - a*x", False), ("u - v - a*sin(t)", False), ("-u + v", True)],
)
def test_contacts_on_surfaces_that_move_apart_are_not_redundant(second, named):
    x, u, v, a = sp.symbols("x u v a", real=True)
    slip = sp.sympify(second, {"x": x, "u": u, "v": v, "a": a, "t": sf.TIME})
    law = sf.laws.coulomb(0.3)
    contacts = [sf.Contact("front", u - v, 1.0, law), sf.Contact("back", slip, 1.0, law)]
    values = {v: 0.3} | ({a: 0.2} if slip.has(a) else {})
    scene = sf.Scene(sf.System([x], [u], [[1]], [-x]), contacts, values, {x: 0.0, u: 0.0}, 5.0)
    assert sf.explain(scene).facts.redundant == (("back",) if named else ())


@pytest.mark.parametrize("order", [8, 9])
def test_bodies_that_move_late_do_not_hold_up_the_first_steps(order):
    q, u = sp.symbols("q:7", real=True), sp.symbols("u:7", real=True)
    force = [(q[i - 1] if i else 0) - 2 * q[i] + (q[i + 1] if i < 6 else 0) for i in range(7)]
    system = sf.System(q=q, u=u, mass=sp.eye(7), force=force)
    contact = sf.Contact("first", slip=u[0] - sp.Rational(1, 5), normal=1, law=LAW)
    scene = sf.Scene(system, [contact], initial=dict.fromkeys([*q, *u], 0.0), horizon=10.0)
    run = sf.simulate(scene, 1e-6, route=sf.Taylor(order=order)).checked()
    assert run.final == pytest.approx(sf.simulate(scene, route="exact").checked().final, abs=1e-6)
    assert run.stats["steps"] < 200
