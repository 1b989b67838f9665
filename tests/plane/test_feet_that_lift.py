"""Feet of a body that may lift, and feet beside contacts that open: closed forms, given loads, time stepping, derivatives.

A table slides, turns and tilts a little on feet, its centre of mass at the height h above the floor.
"""

import math

import numpy as np
import pytest
import sympy as sp

import symfric as sf
from symfric.solve.status import Status
from tests.longer import longer
from tests.plane.lifting_reference import Sliding, Stepping
from tests.plane.test_feet import circle

q = x, y, theta, z, phi, psi = sp.symbols("x y theta z phi psi", real=True)
u = v_x, v_y, omega, w, p, r = sp.symbols("v_x v_y omega w p r", real=True)
t, MU, H, RATE = sf.TIME, sp.Symbol("mu", positive=True), sp.Symbol("h", real=True), sp.Symbol("rate", positive=True)
INERTIA = np.diag([1.0, 1.0, 0.5, 1.0, 0.3, 0.35])
OUT = {"path": sf.Trajectory(), "events": sf.Events()}
pytestmark = pytest.mark.filterwarnings("ignore:redundant contacts")


def table(feet, force, *, law=None, e=0, start=None, horizon=3.0, values=None, beside=(), outputs=None):
    """Return a table of weight 1 on feet at places (X, Y), under forces and couples about its centre of mass."""
    law = law or sf.laws.coulomb(MU)
    contacts = [
        sf.Contact(
            f"foot {k}",
            (v_x - Y * omega - H * r, v_y + X * omega + H * p),
            sf.Unilateral(z + Y * phi - X * psi, e),
            law,
        )
        for k, (X, Y) in enumerate(feet)
    ]
    values = {MU: 0.3, H: 0.4} | (values or {})
    used = set().union(*(sp.sympify(f).free_symbols for f in force)) | {H, MU}
    states = dict(zip((*q, *u), (0.0,) * 12 if start is None else start, strict=True))
    system = sf.System(q, u, sp.Matrix(INERTIA), [f - 1 if k == 3 else f for k, f in enumerate(force)])
    known = {s: v for s, v in values.items() if s in used}
    return sf.Scene(system, [*contacts, *beside], known, states, horizon, outputs=outputs or OUT)


def test_a_table_stands():
    """Steps do not get shorter, and its friction balances the forces."""
    shaken = (0.2 * sp.sin(1.3 * t), 0.1 * sp.cos(t), 0.05 * sp.sin(2 * t), 0, 0, 0)
    run = sf.simulate(table(circle(), shaken, horizon=200.0)).checked()
    assert not run.events
    assert np.all(run.final == 0.0)
    assert len(run.t) < 1000


@pytest.mark.one_in(9)
@pytest.mark.parametrize("turn", [0.0, 0.3, 1.1])
@pytest.mark.parametrize("height", [-0.2, 0.0, 0.4])
def test_pushed_at_its_centre_of_mass_it_slips_at_mu_m_g(turn, height):
    """The push shifts load between the feet, but friction along it keeps no moment about the vertical."""
    c, s = math.cos(0.5), math.sin(0.5)
    scene = table(circle(3, turn), (c * RATE * t, s * RATE * t, 0, 0, 0, 0), values={RATE: 0.2, H: height}, horizon=2.5)
    run = sf.simulate(scene, tolerance=1e-13).checked()
    begin = 0.3 / 0.2
    assert [(e.kind, e.t) for e in run.events] == [("slip", pytest.approx(begin, abs=1e-12))] * 3
    gone = 0.2 * (2.5 - begin) ** 3 / 6
    assert run.final[:3] == pytest.approx([c * gone, s * gone, 0], abs=1e-12)


@pytest.mark.long(beside="test_pushed_at_its_centre_of_mass_it_slips_at_mu_m_g")
@pytest.mark.parametrize("height", [0.0, 0.4])
def test_a_couple_turns_it_at_mu_m_g_r(height):
    scene = table(circle(3), (0, 0, RATE * t, 0, 0, 0), values={RATE: 0.2, H: height}, horizon=2.0)
    run = sf.simulate(scene, tolerance=1e-13).checked()
    assert [(e.kind, e.t) for e in run.events] == [("slip", pytest.approx(1.5, abs=1e-12))] * 3
    assert run.final[:3] == pytest.approx([0, 0, 0.2 * 0.5**3 / 6 / 0.5], abs=1e-12)


def test_a_high_push_lifts_a_foot_first():
    """Under a push F along x at the height h a foot at X carries ``m g/3 + 2 h F X/(3 R^2)``, one at -R nothing at last."""
    scene = table(circle(3, math.pi), (RATE * t, 0, 0, 0, 0, 0), values={RATE: 0.1, H: 1.0, MU: 0.9}, horizon=5.2)
    run = sf.simulate(scene, tolerance=1e-13).checked()
    assert [(e.contact, e.kind, e.t) for e in run.events] == [("foot 0", "open", pytest.approx(5.0, abs=1e-11))]
    assert run.final[3] > 0.0


@pytest.mark.long(beside="test_a_high_push_lifts_a_foot_first")
def test_derivatives_pass_the_release():
    c, s = math.cos(0.5), math.sin(0.5)
    scene = table(circle(3), (c * RATE * t, s * RATE * t, 0, 0, 0, 0), values={RATE: 0.2}, horizon=2.5)
    run = sf.simulate(scene, tolerance=1e-13, sensitivities=[MU, RATE, H]).checked()
    left, begin = 2.5 - 1.5, 1.5
    along = np.array([c, s])
    by_mu = -0.5 * 0.2 * left**2 / 0.2
    by_rate = left**3 / 6 + 0.5 * 0.2 * left**2 * begin / 0.2
    assert run.sensitivities["mu"][:2] == pytest.approx(by_mu * along, rel=1e-9)
    assert run.sensitivities["rate"][:2] == pytest.approx(by_rate * along, rel=1e-9)
    assert run.sensitivities["h"][:2] == pytest.approx([0, 0], abs=1e-9)


def driven(seed):
    rng = np.random.default_rng(seed)
    places = [(rng.uniform(0.7, 1.2) * math.cos(a), rng.uniform(0.7, 1.2) * math.sin(a)) for a in (0.3, 2.4, 4.5)]
    sizes, rates, phases = rng.uniform(0.1, 0.5, 3) * (1, 1, 0.3), rng.uniform(0.7, 2.0, 3), rng.uniform(0, 6, 3)
    force = [a * sp.sin(b * t + c) for a, b, c in zip(sizes, rates, phases, strict=True)]
    return places, [*force, 0, 0, 0], (sizes, rates, phases)


@pytest.mark.parametrize("seed", longer(range(30), range(1, 30)))
def test_without_height_it_is_a_body_with_given_loads(seed):
    """Three feet share a weight as levers do; the motion is that of feet with these loads, of which there is a solver."""
    places, force, _ = driven(seed)
    A = np.array([[1.0] * 3, [X for X, _ in places], [Y for _, Y in places]])
    loads = np.linalg.solve(A, [1.0, 0.0, 0.0])
    free = sf.simulate(table(places, force, values={H: 0.0}, horizon=10.0), tolerance=1e-12).checked()
    contacts = [
        sf.Contact(f"foot {k}", (v_x - Y * omega, v_y + X * omega), float(N), sf.laws.coulomb(MU))
        for k, ((X, Y), N) in enumerate(zip(places, loads, strict=True))
    ]
    states = dict.fromkeys((*q[:3], *u[:3]), 0.0)
    system = sf.System(q[:3], u[:3], sp.Matrix(INERTIA[:3, :3]), force[:3])
    given = sf.simulate(sf.Scene(system, contacts, {MU: 0.3}, states, 10.0, outputs=OUT), tolerance=1e-12).checked()
    assert free.final[[0, 1, 2, 6, 7, 8]] == pytest.approx(given.final, abs=2e-10)
    assert [(e.contact, e.kind) for e in free.events] == [(e.contact, e.kind) for e in given.events]
    assert [e.t for e in free.events] == pytest.approx([e.t for e in given.events], abs=1e-9)


def stepped(seed, steps):
    """Return the coordinates of a dropped table at eight times, by time stepping."""
    places, _, (sizes, rates, phases) = driven(seed)
    weight = np.array([0, 0, 0, -1.0, 0, 0])

    def force(t, q, u):
        return weight + np.append(sizes * np.sin(rates * t + phases), [0, 0, 0])

    contacts = [
        Sliding(np.array([[1, 0, -Y, 0, 0, -0.4], [0, 1, X, 0, 0.4, 0]]), 0.3, 0.3, np.array([0, 0, 0, 1, Y, -X]))
        for X, Y in places
    ]
    return Stepping(INERTIA, force, contacts).run(DROPPED, 4.0, steps, 8)


@pytest.mark.long(beside="test_dropped_and_shaken_its_friction_stays_within_its_bounds")
@pytest.mark.parametrize("seed", [0, 3, 7, *range(8, 20)])
def test_where_friction_drops_feet_are_not_held_again_by_what_they_pressed_at_rest(seed):
    """Feet that start to slip press otherwise than at rest: a static bound by that would hold them again, and again not."""
    places, force, _ = driven(seed)
    height = float(np.random.default_rng(seed).uniform(-0.3, 0.8))
    scene = table(places, force, law=sf.laws.coulomb(MU + 0.05, MU - 0.05), values={H: height}, horizon=4.0)
    loose, run = (sf.simulate(scene, tolerance=e).checked() for e in (1e-8, 1e-11))
    assert loose.final == pytest.approx(run.final, abs=1e-6)
    assert [(e.contact, e.kind) for e in loose.events] == [(e.contact, e.kind) for e in run.events]
    assert run.energy_residual() < 1e-9


DROPPED = (0, 0, 0, 0.05, 0.01, -0.02, *[0] * 6)


def dropped(seed):
    """Return a table that lands, bounces, comes to rest on its feet, slides, turns and tips; and its rooms of friction."""
    places, force, _ = driven(seed)
    asked = {
        f"room {k}": sf.Max(
            sp.sqrt(sf.friction_force(f"foot {k}", 0) ** 2 + sf.friction_force(f"foot {k}", 1) ** 2)
            - MU * sf.normal_force(f"foot {k}")
        )
        for k in range(3)
    }
    return table(places, force, start=DROPPED, horizon=4.0, e=0.3, outputs={**asked, **OUT}), asked


@pytest.mark.parametrize("seed", longer(range(30), range(1, 30)))
def test_dropped_and_shaken_its_friction_stays_within_its_bounds(seed):
    scene, asked = dropped(seed)
    run = sf.simulate(scene, tolerance=1e-11).checked()
    assert run.energy_residual() < 1e-9
    assert all(run[name] < 1e-9 for name in asked)


@pytest.mark.long(beside="test_dropped_and_shaken_its_friction_stays_within_its_bounds")
@pytest.mark.parametrize("seed", range(30))
def test_dropped_and_shaken_it_moves_the_same_at_any_tolerance(seed):
    loose, run = (sf.simulate(dropped(seed)[0], tolerance=e).checked() for e in (1e-8, 1e-11))
    assert loose.final == pytest.approx(run.final, abs=1e-6)


@pytest.mark.long(beside="test_dropped_and_shaken_its_friction_stays_within_its_bounds")
@pytest.mark.parametrize("seed", range(6))
def test_dropped_and_shaken_it_is_the_limit_of_time_steps(seed):
    """It lands without bounces, which steps would have to resolve one by one."""
    places, force, _ = driven(seed)
    run = sf.simulate(table(places, force, start=DROPPED, horizon=4.0), tolerance=1e-11).checked()
    path = np.array([run(0.5 * (k + 1))[:6] for k in range(8)])
    errors = [np.max(np.abs(stepped(seed, 8 * n) - path)) for n in (25, 100)]
    assert errors[1] < 0.35 * errors[0] < 2e-3


@pytest.mark.one_in(3)
@pytest.mark.parametrize("n", [2, 3, 4])
def test_beside_a_ball_feet_move_as_without_it(n):
    b, v_b = sp.symbols("b v_b", real=True)
    ball = sf.Contact("ball", 0, sf.Unilateral(b, 0.6))

    def scene(beside):
        contacts = [
            sf.Contact(f"foot {k}", (v_x - Y * omega, v_y + X * omega), (1 + 0.2 * k) / n, sf.laws.coulomb(0.3))
            for k, (X, Y) in enumerate(circle(n))
        ]
        force = [0.5 * sp.sin(1.3 * t), 0.3 * sp.cos(t), 0.1 * sp.sin(2 * t)]
        own = [(b, v_b, 1.0, -1.0, 0.5)] if beside else []
        system = sf.System(
            [*q[:3], *(o[0] for o in own)],
            [*u[:3], *(o[1] for o in own)],
            sp.diag(1, 1, 0.5, *(o[2] for o in own)),
            [*force, *(o[3] for o in own)],
        )
        states = dict.fromkeys((*q[:3], *u[:3]), 0.0) | {o[0]: o[4] for o in own} | {o[1]: 0.0 for o in own}
        return sf.Scene(system, [*contacts, ball] if beside else contacts, {}, states, 8.0, outputs=OUT)

    with_ball, alone = (sf.simulate(scene(k), tolerance=1e-12).checked() for k in (True, False))
    assert with_ball.final[[0, 1, 2, 4, 5, 6]] == pytest.approx(alone.final, abs=1e-10)
    feet = [(e.contact, e.kind, pytest.approx(e.t, abs=1e-9)) for e in alone.events]
    assert [(e.contact, e.kind, e.t) for e in with_ball.events if e.contact != "ball"] == feet
    assert [e.t for e in with_ball.events if e.contact == "ball"][-1] == pytest.approx(4.0, abs=1e-9)  # it rests


def test_four_feet_share_a_weight_in_no_single_way():
    places = [(1, 1), (-1, 1), (-1, -1), (1, -1)]
    run = sf.simulate(table(places, (0.1 * sp.sin(t), 0, 0, 0, 0, 0)))
    assert run.status is Status.UNDECIDED


@pytest.mark.long(beside="test_beside_a_ball_feet_move_as_without_it")
def test_contacts_with_one_slip_share_their_force_beside_a_ball():
    b, v_b = sp.symbols("b v_b", real=True)
    law, ball = sf.laws.coulomb(0.3), sf.Contact("ball", 0, sf.Unilateral(b, 0.6))

    def scene(loads):
        contacts = [sf.Contact(f"block {k}", (v_x, v_y), N, law) for k, N in enumerate(loads)]
        force = [0.5 * sp.sin(1.3 * t), 0.2 * sp.cos(t), -1.0]
        system = sf.System([x, y, b], [v_x, v_y, v_b], sp.eye(3), force)
        states = {x: 0, y: 0, b: 0.5, v_x: 0, v_y: 0, v_b: 0}
        return sf.Scene(system, [*contacts, ball], {}, states, 8.0, outputs=OUT)

    one, two = (sf.simulate(scene(loads), tolerance=1e-12).checked() for loads in ((1.0,), (0.3, 0.7)))
    assert two.final == pytest.approx(one.final, abs=1e-12)
    alone = [(e.kind, pytest.approx(e.t, abs=1e-11)) for e in one.events if e.contact == "block 0"]
    for name in ("block 0", "block 1"):
        assert [(e.kind, e.t) for e in two.events if e.contact == name] == alone != []
