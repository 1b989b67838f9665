"""Contacts whose slips depend on each other: the time of release in closed form, by the reference and by the routes."""

import math

import pytest
import sympy as sp

import symfric as sf
from symfric.bench.event_reference import ReferenceSimulator

X, U, Y, W = sp.symbols("x u y w", real=True)
T = sf.TIME
pytestmark = pytest.mark.filterwarnings("ignore:redundant contacts")


def contact(name, slip, bound):
    return sf.Contact(name, slip, 2 * bound, sf.laws.coulomb(0.5))


def end(scene, route):
    if route is None:
        return ReferenceSimulator(scene, 1e-11).run().x[:, -1]
    return sf.simulate(scene, 1e-10, route).checked().final


def release(scene, route, body):
    """Return when the velocity of a body leaves zero."""
    if route is None:
        found = ReferenceSimulator(scene, 1e-11).run()
        assert found.reason == ""
        assert not found.alternatives
        times, final = [t for t, _ in found.events], found.x[:, -1]
    else:
        run = sf.simulate(scene, 1e-10, route).checked()
        times, final = [e.t for e in run.events], run.final
    left = [t for t in times if t > 0]
    # a unit mass that a force pushes as it grows with time: u = (t - release)^2 / 2
    started = scene.horizon - math.sqrt(2 * final[body]) if final[body] > 1e-12 else None
    assert started is None or any(t == pytest.approx(started, abs=1e-5) for t in left)
    return started


ROUTES = pytest.mark.parametrize("route", [None, "exact", "taylor"])


@ROUTES
@pytest.mark.parametrize("apart", [0.0, 1e-6, 1e-8, 1e-9, 1e-10, 1e-12])
@pytest.mark.parametrize("bounds", [(0.3, 0.2, 0.1), (0.3, 0.0, 0.1), (0.0, 0.3, 0.0), (0.0, 0.0, 0.0)], ids=str)
def test_contacts_side_by_side_hold_the_sum_of_their_bounds(bounds, apart, route):
    e = sp.Symbol("e", positive=True)
    slips = [U, U * (1 + e), -U]
    contacts = [contact(f"c{i}", slip, b) for i, (slip, b) in enumerate(zip(slips, bounds, strict=True))]
    system = sf.System(q=[X], u=[U], mass=[[1]], force=[T])
    scene = sf.Scene(system, contacts, {e: apart}, {X: 0.0, U: 0.0}, 1.0)
    total = bounds[0] + (1 + apart) * bounds[1] + bounds[2]
    if total == 0:
        assert end(scene, route) == pytest.approx([1 / 6, 1 / 2], abs=1e-8)
        return
    assert release(scene, route, 1) == pytest.approx(total, abs=1e-8)


@ROUTES
@pytest.mark.parametrize("apart", [1e-6, 1e-9, 1e-12])
@pytest.mark.parametrize("way", [1, -1])
def test_a_slip_of_a_billionth_has_the_whole_friction(way, apart, route):
    # the second contact slips with w/1e9 while the first holds u = 0: its friction is not a billionth of itself. Where
    # it pushes, u creeps as fast as that slip until the second contact sticks; both together are released alike.
    system = sf.System(q=[X, Y], u=[U, W], mass=sp.eye(2), force=[T, 0])
    e = sp.Symbol("e", positive=True)
    contacts = [contact("one", U, 0.4), contact("two", U + e * W, 0.15)]
    scene = sf.Scene(system, contacts, {e: apart}, {X: 0.0, Y: 0.0, U: 0.0, W: 0.5 * way}, 1.0)
    assert release(scene, route, 2) == pytest.approx(0.55, abs=2 * apart + 1e-7)


@ROUTES
@pytest.mark.parametrize("loads", [(0.2, 0.1, 1.0), (0.2, 0.3, 0.1), (0.0, 0.1, 1.0), (0.2, 0.0, 1.0), (0.2, 0.3, 0.0)])
def test_two_masses_in_a_loop_with_the_ground(loads, route):
    # the pushed mass is held by the ground, and by as much as the joint and the ground below the other mass carry both
    ground, other, joint = loads
    system = sf.System(q=[X, Y], u=[U, W], mass=sp.eye(2), force=[T, 0])
    contacts = [contact("ground", U, ground), contact("other", W, other), contact("joint", U - W, joint)]
    scene = sf.Scene(system, contacts, {}, dict.fromkeys((X, Y, U, W), 0.0), 1.0)
    held = ground + min(other, joint)
    if other < joint:  # both slide: (t - held)/2 pushes each
        assert end(scene, route)[2:] == pytest.approx([(1 - held) ** 2 / 4] * 2, abs=1e-7)
    else:
        assert release(scene, route, 2) == pytest.approx(held, abs=1e-7)


@pytest.mark.parametrize("load", [0.0, 1e-14, 0.2])
def test_a_joint_that_closes_a_loop_changes_nothing_without_load(load):
    # the masses move until friction holds them; a joint of no load between them is redundant there
    system = sf.System(q=[X, Y], u=[U, W], mass=sp.eye(2), force=[-X, -2 * Y])
    contacts = [contact("one", U, 0.1), contact("two", W, 0.1), contact("joint", U - W, load)]
    start = {X: 0.9, Y: -0.8, U: 0.0, W: 0.0}
    with_joint, without = (
        ReferenceSimulator(sf.Scene(system, chosen, {}, start, 12.0), 1e-11).run()
        for chosen in (contacts, contacts[:2])
    )
    assert with_joint.reason == without.reason == ""
    alike = with_joint.x[:, -1] == pytest.approx(without.x[:, -1], abs=1e-8)
    assert alike == (load < 0.1)
