"""Stops, normal forces in equations, and what goes with contacts that open in a scene."""

import numpy as np
import pytest
import sympy as sp

import symfric as sf
from symfric.ensemble.grid import fingerprint
from symfric.model.excitation import excitation_of, later
from symfric.theory.separation import separate

X, U, Y, V = sp.symbols("x u y v", real=True)
E, B = sp.symbols("e b", positive=True)
T = sf.TIME


@pytest.mark.parametrize("e", [0.0, 0.4, 1.0])
def test_a_body_between_stops_loses_what_newton_says(e):
    scene = sf.Scene(
        system=sf.System(q=[X], u=[U], mass=[[3]], force=[0]),
        contacts=sf.stops(X, -B, 2 * B, E, name="end"),
        values={E: e, B: 0.5},
        initial={X: 0.0, U: 1.0},
        horizon=6.0,
    )
    run = sf.simulate(scene, tolerance=1e-12)
    t, u, ends = 1.0, 1.0, []  # the first way is 1, those after it 1.5
    while t < 6 and u > 0:
        ends.append(t)
        u *= e
        t = t + 1.5 / u if u else np.inf
    assert [event.t for event in run.events] == pytest.approx(ends, abs=1e-11)
    names = [f"end_{('high', 'low')[k % 2]}" for k in range(len(ends))]
    assert [event.contact for event in run.events] == names
    assert run.energy_residual() < 1e-10


def test_backlash_passes_momentum_on():
    """Two bodies with play between: momentum stays, the relative velocity turns round with the restitution."""
    scene = sf.Scene(
        system=sf.System(q=[X, Y], u=[U, V], mass=sp.diag(2, 1), force=[0, 0]),
        contacts=sf.stops(Y - X, -B, B, E, name="play"),
        values={E: 0.6, B: 0.1},
        initial={X: 0.0, Y: 0.0, U: 1.0, V: 0.0},
        horizon=1.0,
    )
    run = sf.simulate(scene, tolerance=1e-12)
    assert len(run.events) >= 3
    relative = [1.0]
    for event in run.events:
        u, v = run(event.t)[2:]
        assert 2 * u + v == pytest.approx(2.0, abs=1e-12)
        relative.append(u - v)
    assert relative[1:] == pytest.approx([-0.6 * w for w in relative[:-1]], abs=1e-11)


@pytest.mark.parametrize(
    ("make", "said"),
    [
        (lambda: sf.stops(X, 1, -1), "the lower one comes first"),
        (lambda: sf.stops(X, 1, 1), "the lower one comes first"),
        (lambda: sf.stops(X, -1, 1, 1.5), "between 0 and 1"),
        (lambda: sf.stops("x", -1, 1), "give a SymPy expression"),
        (lambda: sf.stops(X, -1, 1, name=""), "name"),
    ],
)
def test_bad_stops_are_one_line(make, said):
    with pytest.raises(sf.SceneError, match=said):
        make()


def gear(torque, load, values=None):
    """A pinion that presses on a wheel, whose bearing rubs under the force of the teeth."""
    a, b, p, q = sp.symbols("a b p q", real=True)
    names = J1, J2, r1, r2, r_b, mu, M, L = sp.symbols("J1 J2 r1 r2 r_b mu M L", positive=True)
    numbers = dict(zip(names, (0.02, 0.3, 0.05, 0.2, 0.04, 0.1, torque, load), strict=True)) | (values or {})
    return sf.Scene(
        system=sf.System(q=[a, b], u=[p, q], mass=sp.diag(J1, J2), force=[M, -L]),
        contacts=[
            sf.Contact("tooth", slip=None, normal=sf.Unilateral(r2 * b - r1 * a)),
            sf.Contact("bearing", slip=r_b * q, normal=sf.normal_force("tooth"), law=sf.laws.coulomb(mu)),
        ],
        values=numbers,
        initial={a: 0.0, b: 0.0, p: 0.0, q: 0.0},
        horizon=1.0,
        outputs={"N": sf.Max(sf.normal_force("tooth")), "F": sf.Min(sf.friction_force("bearing")), "end": sf.End()},
    )


@pytest.mark.parametrize(("torque", "load"), [(2.0, 5.0), (1.4, 5.0), (5.0, 1.0)])
def test_friction_of_a_gear_follows_the_force_of_its_teeth(torque, load):
    run = sf.simulate(gear(torque, load))
    J1, J2, r1, r2, r_b, mu = 0.02, 0.3, 0.05, 0.2, 0.04, 0.1
    # J1 a = M - r1 N,  J2 b = r2 N - L - r_b mu N,  r1 a = r2 b
    ratio = r1 / r2
    N = (torque / J1 * ratio + load / J2) / (r1 / J1 * ratio + (r2 - r_b * mu) / J2)
    assert run["N"] == pytest.approx(N, rel=1e-12)
    assert run["F"] == pytest.approx(-mu * N, rel=1e-12)
    assert run["end"][2] == pytest.approx((torque - r1 * N) / J1, rel=1e-11)


def test_a_gear_whose_torque_the_bearing_holds_stands_still():
    run = sf.simulate(gear(1.26, 5.0))  # N = 25.2: 0.04 N m of 0.1 N m that the bearing could hold
    assert np.max(np.abs(run["end"])) < 1e-12
    assert run["N"] == pytest.approx(1.26 / 0.05, rel=1e-12)


def test_teeth_that_lift_leave_the_bearing_without_load():
    run = sf.simulate(gear(1.0, -5.0))
    assert run["end"][3] == pytest.approx(5.0 / 0.3, rel=1e-12)
    assert run["N"] == pytest.approx(0.0, abs=1e-12)


@pytest.mark.parametrize(
    ("law", "stiffness"),
    [
        (sf.laws.coulomb(0.2), None),
        (sf.laws.coulomb(0.2), 50.0),
        (sf.laws.dahl(0.2, 100.0), None),
        (sf.laws.iwan(2.0, -0.3, 0.4, elements=2), None),
        (sf.laws.maxwell_slip([10.0, 20.0], [0.1, 0.1]), None),
    ],
)
def test_a_given_load_is_the_normal_force_of_every_contact(law, stiffness):
    wall = sf.Contact("wall", slip=U, normal=2 + X**2, law=law, stiffness=stiffness)
    outputs = {"force": sf.Max(sf.normal_force("wall")), "load": sf.Max(2 + X**2)}
    system = sf.System([X], [U], [[1]], [-4 * X])
    run = sf.simulate(sf.Scene(system, [wall], {}, {X: 1.0, U: 0.0}, 3.0, outputs))
    assert run["force"] == pytest.approx(run["load"], rel=1e-12)


def pressed(side, law, extra=0):
    """A mass on a spring that rubs on a wall pressed by another body, or under a given load."""
    N, given = sf.normal_force("floor"), 9.81 - sp.sin(3 * T)
    load = N if side else given
    q, u = ([X, Y], [U, V]) if side else ([X], [U])
    force = [-4 * X + extra * load, *([-given] if side else [])]
    contacts = [sf.Contact("wall", slip=U, normal=load / 2, law=law)]
    contacts += [sf.Contact("floor", slip=None, normal=sf.Unilateral(Y))] if side else []
    initial = {X: 1.0, U: 0.0, **({Y: 0.0, V: 0.0} if side else {})}
    return sf.Scene(sf.System(q, u, sp.eye(len(q)), force), contacts, {}, initial, 3.0)


@pytest.mark.one_in(6)
@pytest.mark.parametrize("extra", [0, sp.Rational(1, 10)])
@pytest.mark.parametrize("law", [sf.laws.coulomb(0.2), sf.laws.stribeck(0.3, 0.2, 0.5), sf.laws.dahl(0.2, 100.0)])
def test_a_normal_force_serves_as_load_and_in_forces(law, extra):
    one, other = (sf.simulate(pressed(side, law, extra), tolerance=1e-11) for side in (True, False))
    assert one.final[[0, 2]] == pytest.approx(other.final[:2], abs=1e-8)
    assert one.energy_residual() < 1e-8


@pytest.mark.parametrize(
    "behind", [{"law": sf.laws.coulomb(0.3), "stiffness": 100}, {"law": sf.laws.iwan(5, -0.5, 0.1)}]
)
def test_a_contact_behind_a_spring_refuses_a_load_that_jumps(behind):
    side = sf.Contact("side", slip=U, normal=sf.normal_force("floor"), **behind)
    floor = sf.Contact("floor", slip=None, normal=sf.Unilateral(Y))
    with pytest.raises(sf.SceneError, match="jumps where that contact opens"):
        sf.Scene(sf.System([X, Y], [U, V], sp.eye(2), [0, -9.81]), [side, floor], {}, {X: 0, Y: 0, U: 0, V: 0}, 1.0)


def oscillator(gap=1.0, e=0.5):
    force = -X + sp.cos(2 * T)
    stop = sf.Contact("stop", slip=None, normal=sf.Unilateral(B - X + sp.sin(3 * T) / 100, E))
    return sf.Scene(sf.System([X], [U], [[1]], [force]), [stop], {B: gap, E: e}, {X: 0.0, U: 0.0}, 10.0)


def test_two_scenes_that_differ_in_gap_or_restitution_are_two():
    prints = {fingerprint(s) for s in (oscillator(), oscillator(gap=1.1), oscillator(e=0.6))}
    fixed = sf.Contact("stop", slip=None, normal=sf.Unilateral(2 - X))
    prints.add(fingerprint(sf.Scene(sf.System([X], [U], [[1]], [-X]), [fixed], {}, {X: 0, U: 0}, 1.0)))
    fixed = sf.Contact("stop", slip=None, normal=sf.Unilateral(3 - X))
    prints.add(fingerprint(sf.Scene(sf.System([X], [U], [[1]], [-X]), [fixed], {}, {X: 0, U: 0}, 1.0)))
    assert len(prints) == 5


def test_time_in_a_gap_is_an_excitation_and_shifts_with_it():
    scene = oscillator()
    assert excitation_of(scene).period({"b": 1.0, "e": 0.5}) == pytest.approx(2 * np.pi)
    moved = later(scene, 0.7)
    gap = [s.contacts[0].unilateral.gap.subs({T: t, B: 1, X: 0}) for s, t in ((scene, 1.2), (moved, 0.5))]
    assert float(gap[0]) == pytest.approx(float(gap[1]), abs=1e-15)


def test_a_run_goes_on_from_its_end():
    """A ball that rides on a table stays on it when the run is continued: the gap is zero up to rounding only."""
    gap = X - sp.sin(5 * T) / 100
    table = sf.Contact("table", slip=None, normal=sf.Unilateral(gap, 0.3))
    scene = sf.Scene(sf.System([X], [U], [[1]], [-9.81]), [table], {}, {X: 0.05, U: 0.0}, 2 * np.pi / 5)
    first = sf.simulate(scene)
    again = sf.simulate(later(scene.starting(dict(zip(first.names, first.final, strict=True))), first.t_final))
    assert again.final == pytest.approx(sf.simulate(scene.until(2 * scene.horizon)).final, abs=1e-8)
    assert again.mode[:, -1].tolist() == [0]


def test_units_of_gap_restitution_and_normal_force():
    m, g, a = sp.symbols("m g a", positive=True)
    floor = sf.Contact("floor", slip=None, normal=sf.Unilateral(Y - a, E))
    units = {"y": "m", "t": "s", "m": "kg", "g": "m/s²"}
    values = {m: 2.0, g: 9.81, a: 0.1, E: 0.3}
    system = sf.System([Y], [V], [[m]], [-m * g])
    scene = sf.Scene(system, [floor], values, {Y: 1.0, V: 0.0}, 1.0, units=units)
    assert (scene.units["a"], scene.units["e"]) == ("m", "")
    assert scene.units.of(sf.normal_force("floor")) in ("N", "kg m/s²")
    with pytest.raises(sf.SceneError, match="plain number"):
        sf.Scene(system, [floor], values, {Y: 1.0, V: 0.0}, 1.0, units={**units, "e": "m"})
    with pytest.raises(sf.SceneError, match="gap"):
        sf.Scene(system, [floor], values, {Y: 1.0, V: 0.0}, 1.0, units={**units, "a": "kg"})


def test_equations_show_the_normal_force_and_its_law():
    scene = oscillator()
    assert "N_stop" in str(scene.equations()[1])
    assert r"\perp" in scene._repr_latex_()
    assert "normal_force" not in scene._repr_latex_()


def test_what_needs_given_loads_says_which_contact_opens():
    for ask in (sf.equilibrium, sf.stability, sf.average, separate, lambda s: sf.hopf(s, "b", (0.5, 1.5))):
        with pytest.raises(sf.SceneError, match="takes given normal loads, and contact 'stop' opens"):
            ask(oscillator())
