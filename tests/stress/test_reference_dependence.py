"""Contacts whose slips depend on each other: the time of release in closed form, by the reference and by the routes."""

import math

import pytest
import sympy as sp

import symfric as sf
from symfric_evidence.event_reference import ReferenceSimulator

X, U, Y, W = sp.symbols("x u y w", real=True)
N1, N2, N3, E = sp.symbols("N1 N2 N3 e", positive=True)
T = sf.TIME
PAIR = {"q": [X, Y], "u": [U, W], "mass": sp.eye(2)}
AT_REST = dict.fromkeys((X, Y, U, W), 0.0)
ROUTES = pytest.mark.parametrize("route", ["reference", "exact", "taylor"])
pytestmark = pytest.mark.filterwarnings("ignore:redundant contacts")


def contacts(**slips):
    law = sf.laws.coulomb(0.5)
    return [sf.Contact(name, slip, 2 * n, law) for (name, slip), n in zip(slips.items(), (N1, N2, N3), strict=False)]


def runner(scene, route):
    """Return a function of bounds and starts: final state and times of events."""
    if route == "reference":
        simulator = ReferenceSimulator(scene, 1e-11)
    else:
        program = sf.prepare(scene, 1e-10, route)

    def run(values, initial=None):
        if route == "reference":
            found = simulator.run(values, initial or {})
            assert found.reason == ""
            return found.x[:, -1], [t for t, _ in found.events]
        found = program.run(values, initial or {}).checked()
        return found.final, [0.0, *(e.t for e in found.events)]

    return run


def bounds(*values):
    return {f"N{i + 1}": value for i, value in enumerate(values)}


@pytest.mark.long(beside="test_no_force_on_contacts_without_load_is_no_tie")
@ROUTES
def test_contacts_side_by_side_hold_the_sum_of_their_bounds(route):
    system = sf.System(q=[X], u=[U], mass=[[1]], force=[T])
    side_by_side = contacts(one=U, two=U * (1 + E), back=-U)
    scene = sf.Scene(system, side_by_side, {E: 1e-9, **bounds(0.3, 0.2, 0.1)}, {X: 0.0, U: 0.0}, 1.0)
    run = runner(scene, route)
    loads = ((0.3, 0.2, 0.1), (0.3, 0.0, 0.1), (0.0, 0.3, 0.0), (0.3, 0.0, 0.0), (0.3, 1e-20, 0.0), (0.0, 0.0, 0.0))
    for k, apart in enumerate((1e-6, 1e-8, 1e-9, 1e-10, 1e-12)):
        for found in loads[k % 3 :: 3] if route == "reference" else loads:  # by the slow one a third each
            final, times = run({"e": apart, **bounds(*found)})
            held = found[0] + (1 + apart) * found[1] + found[2]
            assert final == pytest.approx([(1 - held) ** 3 / 6, (1 - held) ** 2 / 2], abs=1e-8)
            assert any(t == pytest.approx(held, abs=1e-7) for t in times)


@ROUTES
def test_a_slip_of_a_billionth_has_the_whole_friction(route):
    # the second contact slips with w/1e9 while the first holds u = 0: its friction is not a billionth of itself. Where
    # it pushes, u creeps as fast as that slip until the second contact sticks; both together are released alike.
    nearly = contacts(one=U, two=U + E * W)
    scene = sf.Scene(sf.System(**PAIR, force=[T, 0]), nearly, {E: 1e-9, **bounds(0.4, 0.15)}, AT_REST, 1.0)
    run = runner(scene, route)
    for apart in (1e-6, 1e-9, 1e-12):
        for way in (1, -1):
            final, times = run({"e": apart}, {"w": 0.5 * way})
            assert final[2] == pytest.approx(0.45**2 / 2, abs=2 * apart + 1e-8)
            assert any(t == pytest.approx(0.55, abs=2 * apart + 1e-7) for t in times)


@pytest.mark.long(beside="test_a_joint_without_load_that_closes_a_loop_changes_nothing")
@ROUTES
def test_two_masses_in_a_loop_with_the_ground(route):
    # the pushed mass is held by the ground, and by as much as the joint and the ground below the other mass carry both
    loop = contacts(ground=U, other=W, joint=U - W)
    scene = sf.Scene(sf.System(**PAIR, force=[T, 0]), loop, bounds(0.2, 0.1, 1.0), AT_REST, 1.0)
    run = runner(scene, route)
    for ground, other, joint in ((0.2, 0.1, 1.0), (0.2, 0.3, 0.1), (0.0, 0.1, 1.0), (0.2, 0.0, 1.0), (0.2, 0.3, 0.0)):
        held = ground + min(other, joint)
        final, times = run(bounds(ground, other, joint))
        assert any(t == pytest.approx(held, abs=1e-7) for t in times)
        speeds = [(1 - held) ** 2 / 4] * 2 if other < joint else [(1 - held) ** 2 / 2, 0]
        assert final[2:] == pytest.approx(speeds, abs=1e-8)


@ROUTES
def test_no_force_on_contacts_without_load_is_no_tie(route):
    # force and bound are both zero at the start, and the force grows: it leaves at once, not after a step
    alone = sf.Scene(sf.System([X], [U], [[1]], [T]), contacts(one=U), bounds(0.0), {X: 0.0, U: 0.0}, 1.0)
    final, _ = runner(alone, route)({})
    assert final == pytest.approx([1 / 6, 1 / 2], abs=1e-8)


def test_a_joint_without_load_that_closes_a_loop_changes_nothing():
    # the masses swing until friction holds them; a joint between them is redundant there
    system = sf.System(**PAIR, force=[-X, -2 * Y])
    start = {X: 0.9, Y: -0.8, U: 0.0, W: 0.0}
    loop = contacts(one=U, two=W, joint=U - W)
    with_joint = sf.Scene(system, loop, bounds(0.2, 0.2, 0.1), start, 12.0)
    without = sf.Scene(system, loop[:2], bounds(0.2, 0.2), start, 12.0)
    expected, _ = runner(without, "reference")({})
    assert math.hypot(*expected[2:]) < 1e-9
    run = runner(with_joint, "reference")
    for load in (0.0, 1e-14):
        assert run({"N3": load})[0] == pytest.approx(expected, abs=1e-8)
    assert run({"N3": 0.1})[0] != pytest.approx(expected, abs=1e-2)
