"""Masses at rest on the edges of friction cells: the way of the possible slip decides which cell holds them."""

from functools import cache
from itertools import product

import numpy as np
import pytest
import sympy as sp
from floor_of_cells import shaken

import symfric as sf

X, U, Y, V = sp.symbols("x u y v_y", real=True)
G = 9.81
EDGES = (-0.02, 0.0, 0.015, 0.04)


def cells(q, edges, values):
    """Return a profile: a value in each interval of q."""
    return sp.Piecewise(*((v, q < e) for v, e in zip(values, edges, strict=False)), (values[-1], True))


def record(seed, n=120):
    """Return accelerations that hold, release and reverse a mass on rolling bearings."""
    rng = np.random.default_rng(seed)
    steps = np.convolve(rng.normal(0, 1, n + 12), np.ones(12) / 12, "valid")[: n + 1]
    return 0.1 * steps * np.minimum(1, np.arange(n + 1) / 10)


@cache
def floor(seed, route):
    """Return the program of a mass on cells under a record; friction and damping of the cells are its parameters."""
    mu, c = sp.symbols(f"mu:{len(EDGES) + 1}", positive=True), sp.Symbol("c", real=True)
    a_g = sp.Symbol("a_g", real=True)
    scene = sf.Scene(
        system=sf.System(q=[X], u=[U], mass=[[1]], force=[-c * U - a_g]),
        contacts=[sf.Contact("floor", slip=U, normal=G, law=sf.laws.coulomb(1), profile=cells(X, EDGES, mu))],
        values={**dict.fromkeys(mu, 0.005), c: 0.1},
        initial={X: 0.0, U: 0.0},
        horizon=1.2,
        inputs={a_g: sf.Signal(record(seed), 0.01)},
        outputs={"peak": sf.Max(sp.Abs(X)), "end": sf.End(), "events": sf.Events()},
    )
    return sf.prepare(scene, 1e-12, route=route)


@pytest.mark.one_in(6)
@pytest.mark.parametrize(("seed", "route"), [*product(range(6), ("exact", "taylor"))])
def test_cells_drawn_at_random_under_records_drawn_at_random(seed, route):
    rng = np.random.default_rng(100 + seed)
    for case in range(10):
        values = rng.choice([0.0, 0.001, 0.002, 0.003, 0.005, 0.008], len(EDGES) + 1)  # equal ones too
        start, c = rng.choice([*EDGES, 0.01]), rng.choice([0.0, 0.3, 5.0])
        named = {**{f"mu{k}": v for k, v in enumerate(values)}, "c": c}
        run = floor(seed, route).run(values=named, initial={"x": start})
        u, w, peak, events = shaken(EDGES, values, record(seed), 0.01, u=start, c=c)
        assert run.status == sf.Status.OK
        seen = [(e.t, e.before, e.after) for e in run.events if e.t > 0]  # a release at the start is none of `taylor`
        events = [e for e in events if e[0] > 0]
        assert [e[1:] for e in seen] == [e[1:] for e in events], case
        assert [e[0] for e in seen] == pytest.approx([e[0] for e in events], abs=1e-9)
        assert run.final == pytest.approx([u, w], abs=1e-10)
        assert run["peak"] == pytest.approx(peak, abs=1e-10)


@pytest.mark.one_in(3)
@pytest.mark.parametrize(("factor", "route"), [*product((-1, -3, 2), ("exact", "taylor"))])
def test_what_a_contact_calls_forwards_may_be_any_way(factor, route):
    """The slip is a multiple of the velocity; `exact` then goes by its matrices."""
    rng = np.random.default_rng(7 + factor)
    a_g, mu = sp.Symbol("a_g", real=True), rng.uniform(0.001, 0.008, 3)
    contact = sf.Contact(
        "floor", factor * U, G / abs(factor), sf.laws.coulomb(1), cells(X, (0.0, 0.004), [sp.Float(m) for m in mu])
    )
    scene = sf.Scene(
        system=sf.System(q=[X], u=[U], mass=[[1]], force=[-a_g]),
        contacts=[contact],
        initial={X: 0.0, U: 0.0},
        horizon=1.2,
        inputs={a_g: sf.Signal(record(3), 0.01)},
        outputs={"events": sf.Events()},
    )
    run = sf.simulate(scene, 1e-10, route=route)
    u, w, _, events = shaken((0.0, 0.004), mu, record(3), 0.01)
    assert run.final == pytest.approx([u, w], abs=1e-8)
    assert [(e.before, e.after) for e in run.events] == [
        (np.sign(factor) * e[1], np.sign(factor) * e[2]) for e in events
    ]


@pytest.mark.one_in(3)
@pytest.mark.parametrize(("way", "route"), [*product((-1, 1), ("exact", "taylor"))])
@pytest.mark.parametrize("values", [(0.005, 0.002), (0.005, 0.009), (0.005, 0.005)])
def test_a_mass_that_comes_to_rest_on_an_edge(way, route, values):
    speed = 0.1
    start = -(speed**2) / (2 * values[0] * G)
    samples = np.concatenate([np.zeros(250), way * np.linspace(0, 0.3, 60)])
    profile = (np.array([-1.0, 0.0, 1.0]), np.array(values))
    motion = sf.motions.Motion(samples, 0.01)
    scene = sf.scenes.rolling_isolator(C=0.0, m=1.0, motion=motion, profile=profile, horizon=3.0)
    run = sf.simulate(scene.starting({"u": start, "w": speed}).wanting({"log": sf.Events()}), 1e-12, route=route)
    u, w, _, events = shaken((0.0,), values, samples[:301], 0.01, u=start, w=speed, near=1e-13)
    assert [(e.before, e.after) for e in run.events] == [e[1:] for e in events]
    assert run.final == pytest.approx([u, w], abs=1e-11)


@pytest.mark.one_in(3)
@pytest.mark.parametrize(("way", "route"), [*product((-1, 1), ("exact", "taylor", "integrators"))])
def test_contacts_on_one_body_add_up_the_cells_on_the_side_of_the_slip(way, route):
    """In the direction of the slip the first carries 1 or 3, the second, whose slip is -2 u, twice .5 or twice .25."""
    edge = sp.Rational(3, 10)
    scene = sf.Scene(
        system=sf.System(q=[X], u=[U], mass=[[2]], force=[way * sf.TIME]),
        contacts=[
            sf.Contact("first", U, 1, sf.laws.coulomb(1), cells(X, [edge], [1, 3])),
            sf.Contact("second", -2 * U, 1, sf.laws.coulomb(1), cells(X, [edge], [sp.Rational(1, 2), 0.25])),
        ],
        initial={X: 0.1 + 0.2, U: 0.0},  # the edge to rounding
        horizon=5.0,
        outputs={"path": sf.Trajectory(), "events": sf.Events()},
    )
    run = sf.simulate(scene, 1e-11, route=route)
    bound = 3.5 if way > 0 else 2.0
    assert {(e.contact, e.after) for e in run.events} == {("first", way), ("second", -way)}
    assert [e.t for e in run.events] == pytest.approx([bound, bound], rel=1e-9)
    late = 5.0 - bound
    assert run.final == pytest.approx([0.3 + way * late**3 / 12, way * late**2 / 4], rel=1e-8)


@pytest.mark.parametrize("route", ["exact", "taylor", "integrators"])
def test_a_belt_carries_a_mass_over_an_edge_and_loses_it(route):
    """Until x = .1 the belt holds it, beyond it carries .05 only and the spring pulls with .1."""
    speed = 0.2
    scene = sf.Scene(
        system=sf.System(q=[X], u=[U], mass=[[1]], force=[-X]),
        contacts=[sf.Contact("belt", U - speed, 1, sf.laws.coulomb(1), cells(X, [0.1], [1, 0.05]))],
        initial={X: -0.3, U: speed},
        horizon=2.5,
        outputs={"events": sf.Events()},
    )
    run = sf.simulate(scene, 1e-12, route=route)
    assert [(e.before, e.after) for e in run.events] == [(0, -1)]
    assert run.events[0].t == pytest.approx(2.0, rel=1e-9)
    late = 0.5
    assert run.final[0] == pytest.approx(0.05 + 0.05 * np.cos(late) + speed * np.sin(late), rel=1e-9)


@pytest.mark.parametrize("route", ["taylor", "integrators"])
def test_a_belt_that_turns_back_at_an_edge_keeps_its_mass(route):
    scene = sf.Scene(
        system=sf.System(q=[X], u=[U], mass=[[1]], force=[-X]),
        contacts=[sf.Contact("belt", U - sp.sin(sf.TIME), 1, sf.laws.coulomb(1), cells(X, [1], [2, 0.01]))],
        initial={X: -1.0, U: 0.0},
        horizon=12.0,
        outputs={"events": sf.Events()},
    )
    run = sf.simulate(scene, 1e-10, route=route)
    assert run.final[0] == pytest.approx(-np.cos(12.0), abs=1e-7)


def corner(seed):
    """Return two masses at rest where the edges of three contacts meet, pulled to and fro."""
    rng = np.random.default_rng(seed)
    mass = np.array([[rng.uniform(1, 2), 0], [0, rng.uniform(1, 2)]])
    mass[0, 1] = mass[1, 0] = rng.uniform(-0.6, 0.6)
    pairs = rng.uniform(0.2, 1.5, (3, 2))
    pull = [a * sp.sin(f * sf.TIME + p) for a, f, p in rng.uniform((0.5, 0.7, 0), (3, 2, 6), (2, 3))]
    sides = [cells(X, [0], pairs[0]), cells(Y, [0], pairs[1])]
    sides.append(sp.Piecewise((pairs[2][0], X < Y), (pairs[2][1], True)))
    slips = [rng.choice([-1, 1, 2]) * U, rng.choice([-1, 1, 2]) * V, rng.choice([-1, 1]) * (U - V)]
    chosen = rng.permutation(3)[: 1 + seed % 3]
    contacts = [sf.Contact("abc"[k], slips[k], 1, sf.laws.coulomb(1), sides[k]) for k in chosen]
    return sf.Scene(
        system=sf.System(q=[X, Y], u=[U, V], mass=mass, force=pull),
        contacts=contacts,
        initial={X: 0.0, Y: 0.0, U: 0.0, V: 0.0},
        horizon=4.0,
        outputs={"path": sf.Trajectory(), "events": sf.Events()},
    )


def stepped(scene, n):
    """Return the states at n equal times, by Moreau's implicit steps; every contact lies on its edge at first.

    Its impulse brings the slip at the end of the step as near to zero as its bounds allow, of which that against a slip
    in one direction belongs to the cell into which it leads.
    """
    dt, inverse = scene.horizon / n, np.linalg.inv(np.array(scene.system.mass.tolist(), dtype=float))
    pull = sp.lambdify(sf.TIME, list(scene.system.force))
    J = np.array([[float(c.slip.diff(s)) for s in scene.system.u] for c in scene.contacts])
    cells_of = [[float(value) for value, _ in c.profile.args] for c in scene.contacts]
    conditions = [c.profile.args[0][1] for c in scene.contacts]
    beyond = np.array([[float((c.lts - c.gts).diff(s)) for s in scene.system.q] for c in conditions])
    A, impulse = J @ inverse @ J.T, np.zeros(len(J))
    q, u, found = np.zeros(2), np.zeros(2), np.zeros((4, n))
    for k in range(n):
        place = beyond @ q
        bounds = np.empty((2, len(J)))
        for i, way in product(range(len(J)), (-1, 1)):
            side = place[i] if abs(place[i]) > 1e-9 else way * (beyond[i] @ J[i])
            bounds[(way + 1) // 2, i] = cells_of[i][int(side > 0)] * dt
        free = u + dt * inverse @ np.array(pull((k + 0.5) * dt))
        slip = J @ free
        for _ in range(500):
            before = impulse.copy()
            for i in range(len(J)):
                wanted = impulse[i] - (slip[i] + A[i] @ impulse) / A[i, i]
                impulse[i] = min(bounds[0, i], max(-bounds[1, i], wanted))
            if np.max(np.abs(impulse - before)) < 1e-16:
                break
        before, u = u, free + inverse @ J.T @ impulse
        q = q + dt * (before + u) / 2
        found[:, k] = *q, *u
    return found


@pytest.mark.one_in(18)
@pytest.mark.parametrize("seed", range(18))
def test_at_a_corner_of_contacts_the_routes_agree_with_small_steps(seed):
    scene, n = corner(seed), 2000
    times = scene.horizon * np.arange(1, n + 1) / n
    run = sf.simulate(scene, 1e-12, route="taylor")
    assert run.status == sf.Status.OK
    assert np.max(np.abs(run(times) - stepped(scene, n))) < 2e-3
    assert abs(run.energy_residual()) < 1e-9
    if len(scene.contacts) < 3:  # three may leave an edge by the third derivative alone, and it looks at two
        other = sf.simulate(scene, 1e-9, route="integrators")
        assert run.final == pytest.approx(other.final, abs=1e-6)


@pytest.mark.one_in(2)
@pytest.mark.parametrize("seed", range(4))
def test_a_floor_of_eighty_cells_has_an_edge_where_the_mass_starts(seed):
    edges, values = sf.patched_floor(0.4, 80, 0.005, 0.002355, 0.004, seed=seed)
    motion = sf.motions.Motion(record(seed), 0.01)
    scene = sf.scenes.rolling_isolator(C=0.3, m=1.0, motion=motion, profile=(edges, values), horizon=1.2)
    u, w, peak, _ = shaken(edges[1:-1], values, record(seed), 0.01, c=0.3)
    run = sf.simulate(scene, route="exact")
    assert run["peak_displacement"] == pytest.approx(peak, rel=1e-9)
    assert run.final == pytest.approx([u, w], abs=1e-11)


@pytest.mark.long(beside="test_a_floor_of_eighty_cells_has_an_edge_where_the_mass_starts")
def test_four_hundred_cells_are_no_deeper_than_ten():
    floor_of = sf.patched_floor(0.4, 400, 0.005, 0.002355, 0.004, seed=1)
    motion = sf.motions.Motion(record(2)[:41], 0.01)
    scene = sf.scenes.rolling_isolator(C=0.3, m=1.0, motion=motion, profile=floor_of, horizon=0.4)
    exact, series = (sf.simulate(scene, 1e-6, route=route) for route in ("exact", "taylor"))
    assert series["peak_displacement"] == pytest.approx(exact["peak_displacement"], rel=1e-5)


def test_derivatives_at_an_edge_are_those_of_the_side_of_the_slip_or_none():
    """Held until .2 t = .1 x + mu1, then slipping forwards; a start moved off the edge has another motion either way."""
    k, start, mu = sp.Symbol("k"), sp.Symbol("x_0"), sp.symbols("mu:2", positive=True)
    scene = sf.Scene(
        system=sf.System(q=[X], u=[U], mass=[[1]], force=[sf.TIME / 5 - k * X]),
        contacts=[sf.Contact("floor", U, 1, sf.laws.coulomb(1), cells(X, [0.3], mu))],
        values={mu[0]: 0.5, mu[1]: 0.2, k: 0.1, start: 0.3},
        initial={X: start, U: 0},
        horizon=4.0,
        outputs={"path": sf.Trajectory()},
    )
    run = sf.simulate(scene, 1e-12, sensitivities=("mu0", "mu1", "k"))
    assert run.sensitivities["mu0"] == pytest.approx([0, 0], abs=1e-12)
    for name in ("mu1", "k"):
        value = scene.values[scene.parameter(name)]
        up, down = (sf.simulate(scene.where({name: value + h}), 1e-12).final for h in (1e-4, -1e-4))
        assert run.sensitivities[name] == pytest.approx((up - down) / 2e-4, rel=1e-6)
    assert np.all(np.isnan(sf.simulate(scene, 1e-12, sensitivities=("x_0",)).sensitivities["x_0"]))
