"""The reference simulator against closed forms, against quadrature, and against the package where that is known right."""

import ast
import math
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest
import sympy as sp
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.integrate import quad, solve_ivp
from scipy.optimize import linprog

import symfric as sf
from symfric_evidence import event_reference
from symfric_evidence.event_reference import ReferenceSimulator
from symfric_evidence.event_reference.equations import features
from symfric_evidence.event_reference.modes import least_excess
from symfric_evidence.stress.random_scenes import Dice, structure
from tests.longer import longer

X, U, Y, W, Z = sp.symbols("x u y w z", real=True)
T = sf.TIME


def one_mass(force, contacts=(), *, x=0.0, u=0.0, horizon=5.0, **options):
    system = sf.System(q=[X], u=[U], mass=[[1]], force=[force])
    return sf.Scene(system, contacts, {}, {X: x, U: u}, horizon, **options)


def final(scene, tolerance=1e-11):
    found = ReferenceSimulator(scene, tolerance).run()
    assert found.reason == ""
    return found.x[:, -1]


def events(scene):
    return ReferenceSimulator(scene, 1e-11).run().events[1:]


def test_it_imports_nothing_of_the_package_but_the_scene():
    allowed = {"symfric.model.symbols", "symfric.model.scene", "symfric.model.contact_states"}
    for path in Path(event_reference.__file__).parent.glob("*.py"):
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
            if isinstance(node, ast.ImportFrom) and node.module.startswith("symfric"):
                assert node.module in allowed or node.module.startswith("symfric_evidence.event_reference")
            if isinstance(node, ast.Import):
                assert all(a.name.split(".")[0] not in ("symfric", "casadi", "numba", "llvmlite") for a in node.names)


@pytest.mark.one_in(4)
@pytest.mark.parametrize("delta", [0.03, 0.14, 0.21, 0.31, 0.49, 0.5, 0.7])
def test_a_coulomb_oscillator_stops_where_its_half_cycles_end(delta):
    scene = sf.scenes.coulomb_oscillator(delta).until(60.0)
    x, stops = 1.0, 0
    while abs(x) > delta * (1 + 1e-12):
        x, stops = -x + 2 * delta * math.copysign(1, x), stops + 1
    assert final(scene) == pytest.approx([x, 0], abs=1e-9)
    if stops:
        assert events(scene)[-1] == (pytest.approx(stops * math.pi), (0,))


def test_stick_slip_on_a_belt_has_its_period():
    speed, mu_s, mu_k = 0.5, 0.4, 0.3
    drop = mu_s - mu_k
    scene = one_mass(-X, [sf.Contact("belt", U - speed, 1, sf.laws.coulomb(mu_s, mu_k))], u=speed, horizon=30.0)
    releases = [t for t, modes in events(scene) if modes != (0,)]
    assert releases[0] == pytest.approx(mu_s / speed)
    period = 2 * drop / speed + 2 * (math.pi - math.atan(drop / speed))
    assert np.diff(releases) == pytest.approx(period)
    assert len(releases) == 5


@pytest.mark.one_in(3)
@pytest.mark.parametrize("width", [0.2, 0.02, 0.002])
@pytest.mark.parametrize("shape", [lambda s: sp.exp(-(s**2)), lambda s: sp.sech(s), lambda s: 1 / (1 + s**4)])
def test_a_blow_is_the_integral_of_its_impulse(shape, width):
    s = sp.Symbol("s", real=True)
    force = sp.lambdify(s, shape(s), [{"sech": lambda x: 2 / (math.exp(min(abs(x), 700)) + math.exp(-abs(x)))}, "math"])
    near = [3 - 20 * width, 3, 3 + 20 * width]

    def swing(part):
        blow = lambda t: force((t - 3) / width) / width * part(6 - t)  # noqa: E731
        return sum(quad(blow, a, b, limit=200, epsabs=1e-13)[0] for a, b in pairwise([0, *near, 6]))

    expected = [math.cos(6) + swing(math.sin), -math.sin(6) + swing(math.cos)]
    assert final(one_mass(-X + shape((T - 3) / width) / width, x=1.0, horizon=6.0)) == pytest.approx(expected, abs=1e-8)


@pytest.mark.parametrize(("place", "passes"), [(0.5, True), (0.5, False)])
def test_a_narrow_barrier_is_passed_or_reflects(place, passes):
    width, speed = 0.004, 1.0
    height = 0.5 * speed**2 / math.sqrt(math.pi) / width * (0.5 if passes else 2.5)
    # the energy of the barrier is that of an error function: whoever passes leaves with its speed
    potential = height * width * sp.sqrt(sp.pi) / 2 * (1 + sp.erf((X - place) / width))
    scene = one_mass(-potential.diff(X), u=speed, horizon=1.5)
    found = final(scene)
    left = 0.5 * speed**2 - height * width * math.sqrt(math.pi)
    assert found[1] == pytest.approx(math.sqrt(2 * left) if passes else -speed, abs=1e-8)


def test_weak_contacts_hold_nothing():
    for load in (1e-10, 1e-14, 1e-20):
        scene = one_mass(-X, [sf.Contact("weak", U, load, sf.laws.coulomb(0.5))], x=1.0, horizon=10.0)
        assert final(scene) == pytest.approx([math.cos(10), -math.sin(10)], abs=1e-8)


@pytest.mark.one_in(3)
@pytest.mark.parametrize(
    ("load", "friction"),
    [(U**2, lambda u: u * abs(u)), (sp.Abs(U), lambda u: u), (U**4, lambda u: u**3 * abs(u))],
    ids=["u^2", "|u|", "u^4"],
)
@pytest.mark.parametrize("start", [0.3, 0.0])
def test_loads_that_vanish_with_the_slip_are_damping(load, friction, start):
    scene = one_mass(-X, [sf.Contact("f", U, load, sf.laws.coulomb(0.6))], x=1.0, u=start, horizon=10.0)
    smooth = solve_ivp(lambda t, y: [y[1], -y[0] - 0.6 * friction(y[1])], (0, 10), [1.0, start], rtol=1e-12, atol=1e-13)
    assert final(scene) == pytest.approx(smooth.y[:, -1], abs=1e-8)


@pytest.mark.one_in(2)
@pytest.mark.parametrize("way", [1, -1])
def test_an_edge_of_cells_holds_with_the_cell_on_the_side_of_the_push(way):
    cells = sp.Piecewise((0.6, X < 0), (0.3, True))
    scene = one_mass(way * T / 2, [sf.Contact("floor", U, 1, sf.laws.coulomb(1), cells)], horizon=3.0)
    bound = 0.3 if way > 0 else 0.6
    release = 2 * bound
    time, modes = events(scene)[0]
    assert (time, modes) == (pytest.approx(release), (way,))
    left = 3 - release
    assert final(scene) == pytest.approx([way * left**3 / 12, way * left**2 / 4], abs=1e-9)


def test_a_push_that_turns_at_an_edge_meets_the_other_cell():
    cells = sp.Piecewise((0.6, X < 0), (0.3, True))
    force = sp.sin(T) * 0.29 - sp.Rational(7, 10) * sp.Max(T - 4, 0)
    scene = one_mass(force, [sf.Contact("floor", U, 1, sf.laws.coulomb(1), cells)], horizon=6.0)
    released = next(t for t, modes in events(scene) if modes == (-1,))
    assert -(0.29 * math.sin(released) - 0.7 * (released - 4)) == pytest.approx(0.6)


def test_a_belt_that_swings_carries_a_mass_until_it_is_too_fast():
    contact = sf.Contact("belt", U - sp.sin(T), 1, sf.laws.coulomb(0.5))
    scene = one_mass(0, [contact], horizon=3.0)
    assert ReferenceSimulator(scene).run().events[0][1] == (-1,)  # at first it accelerates more than friction can
    caught = next(t for t, modes in events(scene) if modes == (0,))
    assert math.sin(caught) == pytest.approx(0.5 * caught)


def test_parallel_contacts_share_what_they_hold():
    contacts = [sf.Contact(f"c{i}", U * (1 + i), 0.2, sf.laws.coulomb(0.5)) for i in range(3)]
    scene = one_mass(T, contacts, horizon=1.0)
    assert events(scene)[0] == (pytest.approx(0.1 * (1 + 2 + 3)), (1, 1, 1))


@pytest.mark.one_in(2)
@pytest.mark.parametrize("weak", [1e-20, 1e-12, 1e-6, 0.0])
def test_a_weak_contact_does_not_hide_when_the_others_reach_their_bounds(weak):
    contacts = [
        sf.Contact("weak", U, weak, sf.laws.coulomb(0.5)),
        sf.Contact("floor", 2 * U, 0.2, sf.laws.coulomb(0.5)),
    ]
    scene = one_mass(T**2, contacts, horizon=1.0)
    assert events(scene)[0] == (pytest.approx(math.sqrt(0.2 + 0.5 * weak), rel=1e-12), (1, 1))


@pytest.mark.one_in(2)
@pytest.mark.parametrize("between", [0.35, 0.15])
def test_of_contacts_that_share_what_they_hold_those_at_their_bounds_slip(between):
    """A pull on the first of two masses, each on the floor, with friction between them; all of it drops to one half."""
    law = sf.laws.coulomb(1.0, 0.5)
    system = sf.System([X, Y], [U, W], sp.eye(2), [T, 0])
    floor = [sf.Contact("a", U, 0.2, law), sf.Contact("b", W, 0.1, law), sf.Contact("c", 2 * W, 0.05, law)]
    contacts = [*floor, sf.Contact("d", U - W, between, law)]
    scene = sf.Scene(system, contacts, {}, dict.fromkeys((X, Y, U, W), 0.0), 0.6)
    first = (
        (0.4, (1, 1, 1, 0)) if between > 0.2 else (0.2 + between, (1, 0, 0, 1))
    )  # both masses at once, or the first alone
    assert events(scene)[0] == (pytest.approx(first[0]), first[1])


def test_the_least_excess_of_dependent_contacts():
    rows = np.array([[1.0, 0.0], [0.0, 1.0], [1.0, 1.0]])
    # 1 and 1 carried by three: the third 0.8 for both, and all are at 0.8 of their bounds
    assert least_excess(rows, np.array([1.0, 1.0]), np.array([0.25, 0.25, 1.0])) == pytest.approx(0.8 * 1.5 - 1.5)
    assert least_excess(np.ones((2, 1)), np.array([3.0]), np.array([1.0, 1.0])) == pytest.approx(3.0 - 2.0)


@settings(derandomize=True, deadline=None, max_examples=40)
@given(seed=st.integers(0, 10**6))
def test_the_sign_of_the_excess_is_that_of_a_linear_programme(seed):
    rng = np.random.default_rng(seed)
    n = int(rng.integers(1, 4))
    rows, bounds = rng.integers(-2, 3, (n + int(rng.integers(1, 3)), n)).astype(float), rng.random(n + 2)
    rows[:n] += np.eye(n) * 5
    bounds = bounds[: len(rows)]
    force = rng.normal(size=n) * 4
    # the least common factor of all bounds with which forces within them have this sum
    equal = np.hstack([rows.T, np.zeros((n, 1))])
    below = np.vstack([np.hstack([way * np.eye(len(rows)), -bounds[:, None]]) for way in (1, -1)])
    free = [(None, None)] * (len(rows) + 1)
    cost = [0.0] * len(rows) + [1.0]
    factor = linprog(cost, below, np.zeros(2 * len(rows)), equal, force, bounds=free).x[-1]
    assert np.sign(least_excess(rows, force, bounds)) == np.sign(factor - 1)


def test_a_pendulum_with_a_sliding_support_keeps_its_energy():
    mass = sp.Matrix([[2, sp.cos(Y)], [sp.cos(Y), 1]])
    system = sf.System([X, Y], [U, W], mass, [W**2 * sp.sin(Y), -sp.sin(Y)])
    scene = sf.Scene(system, (), {}, {X: 0.0, Y: 1.0, U: 0.2, W: 0.5}, 10.0)
    energy = lambda x: (  # noqa: E731
        x[2] ** 2 + math.cos(x[1]) * x[2] * x[3] + x[3] ** 2 / 2 - math.cos(x[1])
    )
    assert energy(final(scene)) == pytest.approx(energy([0.0, 1.0, 0.2, 0.5]), abs=1e-9)


@pytest.mark.one_in(6)
@pytest.mark.parametrize("start", [0.5, 1.0, 1.5])
@pytest.mark.parametrize("pull", [-0.4, 0.4])
@pytest.mark.parametrize("limit", [sp.Min, sp.Max])
def test_a_state_that_settles_on_a_kink_may_leave_it_again(start, pull, limit):
    # z goes to its limit 1 to the last digit, and is pulled off it from t = 3 on
    system = sf.System([X], [U], [[1]], [limit(Z, 1)], z=[Z], z_rate=[20 * (1 - Z) - pull * sp.Max(T - 3, 0)])
    scene = sf.Scene(system, [], {}, {X: 0.0, U: 0.0, Z: start}, 5.0)
    below = limit is sp.Min
    speed = 5.0 + ((start - 1) / 20 if (start < 1) == below else 0.0)
    if (pull > 0) == below:
        speed -= pull * (4 / 40 - 2 / 400 + (1 - math.exp(-40)) / 8000)
    for preference in (0, 1):
        found = ReferenceSimulator(scene, 1e-11).run(preference=preference)
        assert (found.reason, found.x[1, -1]) == ("", pytest.approx(speed, abs=1e-9))


@pytest.mark.parametrize("wave", [sp.sin, sp.cos, sp.tan])
def test_functions_of_what_overflows_in_a_trial_step_are_not_numbers(wave):
    equations = ReferenceSimulator(one_mass(-X + wave(X))).equations
    assert math.isnan(equations.core(0.0, math.inf, 0.0)[1])


def test_sampled_inputs_are_lines_between_samples():
    a = sp.Symbol("a", real=True)
    signal = sf.Signal([0.0, 1.0, -1.0], 1.0)
    scene = one_mass(a, [], inputs={a: signal}, horizon=4.0)
    # the velocity is the area: 1/2, then 0 on the way from 1 to -1; nothing after the last sample
    assert final(scene) == pytest.approx([1 / 6 + 1 / 2 + 1 / 2 - 1 / 3 + 0.5 * 2, 0.5], abs=1e-9)


def test_a_saturated_controller_follows_its_branches():
    system = sf.System([X], [U], [[1]], [0], z=[Z], z_rate=[sp.Max(sp.Min(2 - Z, 1), -1)])
    scene = sf.Scene(system, (), {}, {X: 0.0, U: 0.0, Z: 0.0}, 3.0)
    assert final(scene)[2] == pytest.approx(2 - math.exp(-2))  # the rate is one until z = 1


def test_several_admissible_modes_are_noticed():
    # the stuck joint or the stuck belt may give way where friction drops after rest
    found = [ReferenceSimulator(structure(40)).run(d.values, d.initial) for d in [Dice(structure(40)).draw(40, 165)]]
    assert found[0].reason == ""


def test_what_a_step_must_not_leap_over():
    w = sp.Symbol("w", positive=True)
    assert features([sp.exp(-(((X - 1) / w) ** 2))]) == [(X - 1) / w]
    assert features([1 / (1 + X**4)]) == [sp.log(1 + X**4)]
    assert features([X**2 * U + 3]) == []


def test_it_says_why_it_gave_up():
    found = ReferenceSimulator(one_mass(2 * X**3, x=1.0, u=1.0), max_steps=300).run()  # x = 1/(1 - t)
    assert found.reason
    assert np.isnan(found.x).all()


@pytest.mark.one_in(8)
@pytest.mark.parametrize("number", [0, 2, 3, 5])  # moderate numbers, starts on a surface
@pytest.mark.parametrize("seed", longer((3, 8, 13, 26), (8, 26)))
def test_it_agrees_with_the_package_where_that_is_known_right(seed, number):
    scene = structure(seed)
    draw = Dice(scene).draw(seed, 8 * 5 + number)
    run = sf.simulate(scene.where(draw.values).starting(draw.initial), 1e-11).checked()
    found = ReferenceSimulator(scene).run(draw.values, draw.initial, times=[1.0, 2.5, 4.0], tolerance=1e-11)
    assert found.reason == ""
    assert found.x == pytest.approx(run([1.0, 2.5, 4.0]), abs=1e-6)


def test_a_kink_that_is_left_slowly_is_met_again():
    # from rest at x = 0 the force begins with no value; x = t^3/6 - t^4/6 is positive until t = 1, and meets a spring
    scene = one_mass(T - 2 * T**2 + 50 * sp.Max(-X, 0), horizon=1.5)
    rate = lambda t, y: [y[1], t - 2 * t**2 - 50 * min(y[0], 0)]  # noqa: E731
    expected = solve_ivp(rate, (1.0, 1.5), [0.0, 0.5 - 2 / 3], rtol=1e-12, atol=1e-13, method="DOP853").y[:, -1]
    assert final(scene) == pytest.approx(expected, abs=1e-8)


def test_between_its_steps_the_reference_holds_its_tolerance():
    """At a time inside a step as at the end of a run, beside a bristle faster than the motion."""
    scene = one_mass(-X - U / 10, [sf.Contact("c", U, 1, sf.laws.dahl(0.05, 20))], x=-0.7, u=-0.1, horizon=4.0)
    times, sizes = np.linspace(0.1, 3.9, 39), np.array([1.0, 1.0, 0.05 / 20])
    found = ReferenceSimulator(scene, 1e-10).run(times=times, sizes=sizes).x
    for t, x in zip(times[::3], found.T[::3], strict=True):
        ended = ReferenceSimulator(scene.until(t), 1e-12).run(sizes=sizes).x[:, -1]
        assert np.max(np.abs(x - ended) / sizes) < 1e-8
