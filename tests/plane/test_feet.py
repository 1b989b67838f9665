"""Feet of a body that turns: their forces at rest are not unique, the motion is.

Closed forms, the single contact of the summed load, limit surfaces by a minimisation of their own, and regularised motions.
"""

import math
from functools import cache

import numpy as np
import pytest
import sympy as sp
from scipy.optimize import minimize

import symfric as sf
from symfric.solve.facts import warn_of_redundance
from tests.longer import longer
from tests.plane.compiled_regularised import regularised
from tests.plane.plane_scenes import drawn_bodies

q = x, y, theta = sp.symbols("x y theta", real=True)
u = v_x, v_y, omega = sp.symbols("v_x v_y omega", real=True)
t, load = sf.TIME, sp.Symbol("load", positive=True)
MU = sp.Symbol("mu", positive=True)
pytestmark = pytest.mark.filterwarnings("ignore:redundant contacts")


def body(feet, loads, force, *, law=None, m=1.0, J=0.5, start=(0, 0, 0), horizon=3.0, outputs=None, values=None):
    """Return a body on feet at places that turn with it, under forces and a couple about its centre of mass."""
    values = {load: 1.0} | ({MU: 0.3} if law is None else {}) | (values or {})
    law = sf.laws.coulomb(MU) if law is None else law
    c, s = sp.cos(theta), sp.sin(theta)
    contacts = []
    for k, ((a, b), N) in enumerate(zip(feet, loads, strict=True)):
        slip = (v_x - omega * (a * s + b * c), v_y + omega * (a * c - b * s))
        contacts.append(sf.Contact(f"foot {k}", slip, load * N, law))
    initial = dict(zip((*q, *u), (0, 0, 0, *start), strict=True))
    system = sf.System(q, u, sp.diag(m, m, J), list(force))
    asked = outputs or {"path": sf.Trajectory(), "events": sf.Events()}
    return sf.Scene(system, contacts, values, initial, horizon, asked)


def circle(n=3, turn=0.3, radius=1.0):
    return [
        (radius * math.cos(turn + 2 * math.pi * k / n), radius * math.sin(turn + 2 * math.pi * k / n)) for k in range(n)
    ]


PLACES, LOADS = sp.symbols("a:4 b:4", real=True), sp.symbols("N:4", nonnegative=True)
STEADY, RISES, WAVES, RATES = (sp.symbols(f"{name}:3", real=True) for name in ("c", "p", "s", "r"))
MASS, INERTIA, DROPPED = sp.symbols("m J mu_k", positive=True)
PATH = {"path": sf.Trajectory(), "events": sf.Events()}


@cache
def program(n, tolerance=1e-12, drops=False):
    """Return a program of a body on n feet for any places, loads and inertia, under constant, rising and harmonic forces."""
    force = [c + p * t + s * sp.sin(r * t) for c, p, s, r in zip(STEADY, RISES, WAVES, RATES, strict=True)]
    given = (*PLACES[:n], *PLACES[4 : 4 + n], *LOADS[:n], *STEADY, *RISES, *WAVES, *RATES, MASS, INERTIA)
    values = dict.fromkeys(given, 1.0)
    law = sf.laws.coulomb(MU, DROPPED) if drops else sf.laws.coulomb(MU)
    values |= {MU: 0.3} | ({DROPPED: 0.25} if drops else {})
    feet = list(zip(PLACES[:n], PLACES[4 : 4 + n], strict=True))
    scene = body(feet, LOADS[:n], force, law=law, m=MASS, J=INERTIA, values=values, outputs=PATH)
    return sf.prepare(scene, tolerance)


NONE = (0, 0, 0)


def moved(feet, loads, *, steady=NONE, rises=NONE, waves=NONE, rates=(1, 1, 1), m=1.0, J=0.5, start=NONE, of=program):
    """Return the run of such a body."""
    n = len(feet)
    values = dict(zip((*PLACES[:n], *PLACES[4 : 4 + n]), (*(a for a, _ in feet), *(b for _, b in feet)), strict=True))
    values |= dict(
        zip((*LOADS[:n], *STEADY, *RISES, *WAVES, *RATES), (*loads, *steady, *rises, *waves, *rates), strict=True)
    )
    return of(n).run(values=values | {MASS: m, INERTIA: J}, initial=dict(zip(u, start, strict=True))).checked()


def with_a_drop(n):
    return program(n, drops=True)


OF = {"as at rest": program, "less than at rest": with_a_drop}


@pytest.mark.one_in(2)
@pytest.mark.parametrize("friction", longer(OF, ["less than at rest"]))
def test_pushed_through_the_centre_it_is_one_contact(friction):
    law = sf.laws.coulomb(0.3, 0.25) if friction == "less than at rest" else sf.laws.coulomb(0.3)
    run = moved(circle(), (2, 2, 2), waves=(2, 1.2, 0), of=OF[friction])
    point = sf.Scene(
        sf.System([x, y], [v_x, v_y], sp.eye(2), [2 * sp.sin(t), 1.2 * sp.sin(t)]),
        [sf.Contact("point", (v_x, v_y), 6, law)],
        {},
        dict.fromkeys((x, y, v_x, v_y), 0.0),
        3.0,
    )
    one = sf.simulate(point, tolerance=1e-12).checked()
    assert run.final[[0, 1, 3, 4]] == pytest.approx(one.final, abs=1e-9)
    assert run.final[[2, 5]] == pytest.approx([0, 0], abs=1e-9)
    for foot in range(3):
        mine = [e for e in run.events if e.contact == f"foot {foot}"]
        assert [e.kind for e in mine] == [e.kind for e in one.events]
        assert [e.t for e in mine] == pytest.approx([e.t for e in one.events], abs=1e-9)
    assert run.energy_residual() < 1e-11


@pytest.mark.one_in(6)
@pytest.mark.parametrize("friction", longer(OF, ["less than at rest"]))
@pytest.mark.parametrize("place", [0, 1, 2])
def test_a_foot_without_load_changes_nothing(place, friction):
    """It slips from the first instant at which the body moves there, and no force tells it where to."""
    feet, loads, waves, rates = circle(), [1, 1.2], (1.6, 0.9, 0.5), (1, 1.3, 0.7)
    two = moved(feet[:2], loads, waves=waves, rates=rates, of=OF[friction])
    feet.insert(place, feet.pop())
    loads.insert(place, 0)
    three = moved(feet, loads, waves=waves, rates=rates, of=OF[friction])
    assert three.final == pytest.approx(two.final, abs=1e-11)
    mine = [e.t for e in three.events if e.contact != f"foot {place}"]
    assert mine == pytest.approx([e.t for e in two.events], abs=1e-10)


@pytest.mark.long(beside="test_a_foot_without_load_changes_nothing")
def test_a_foot_without_load_in_the_equations_changes_nothing():
    push = [1.6 * sp.sin(t), 0.9 * sp.sin(1.3 * t), 0.5 * sp.sin(0.7 * t)]
    two, three = (sf.simulate(body(circle()[:n], [1, 1.2, 0][:n], push), tolerance=1e-11).checked() for n in (2, 3))
    assert three.final == pytest.approx(two.final, abs=1e-11)


def test_a_couple_turns_it_on_the_spot():
    """The couple of three feet on a circle is mu N r; the angle after the release is that of a couple that rises."""
    run = moved(circle(radius=0.8), (1, 1, 1), rises=(0, 0, 0.6))
    start = 0.3 * 3 * 0.8 / 0.6
    assert [e.t for e in run.events] == pytest.approx([start] * 3, abs=1e-12)
    assert run.final[2] == pytest.approx(0.6 * (3.0 - start) ** 3 / (6 * 0.5), abs=1e-11)
    assert run.final[[0, 1, 3, 4]] == pytest.approx(np.zeros(4), abs=1e-12)


def test_a_spin_ends_on_all_feet_at_once():
    run = moved(circle(radius=0.8), (1, 1, 1), start=(0, 0, 2))
    stop = 0.5 * 2 / (0.3 * 3 * 0.8)
    assert [e.t for e in run.events] == pytest.approx([stop] * 3, abs=1e-12)
    assert run.final == pytest.approx([0, 0, stop, 0, 0, 0], abs=1e-12)


def test_a_bar_turns_about_the_foot_that_carries_more():
    """A couple releases the other foot alone, at mu N L; then the bar turns about the first, which keeps its place."""
    run = moved([(-0.5, 0), (0.5, 0)], (3, 1), rises=(0, 0, 0.3), m=0.2, J=0.1)
    event, later = run.events
    assert (event.contact, event.kind) == ("foot 1", "slip")
    assert event.t == pytest.approx(1.0, abs=1e-12)
    assert (later.contact, later.kind) == ("foot 0", "slip")
    assert later.t > 2.0
    angle = 0.3 / (6 * (0.1 + 0.2 * 0.25))
    assert run(2.0)[2] == pytest.approx(angle, abs=1e-11)
    place = run(2.0)[:2] - 0.5 * np.array([math.cos(angle), math.sin(angle)])
    assert place == pytest.approx([-0.5, 0], abs=1e-11)


def roughly(n):
    return program(n, 1e-8)


@pytest.mark.long(beside="test_a_spin_ends_on_all_feet_at_once")
def test_feet_come_to_rest_together_at_any_tolerance():
    """The speeds of all feet fall to zero as one; an error of the run does not tell which is the first."""
    rng = np.random.default_rng(3)
    for _ in range(15):
        start = rng.normal(size=3)
        one, two = (
            moved(circle(), (2, 2.5, 1.5), steady=(0.5, -0.2, 0.3), start=start, J=0.3, of=of)
            for of in (roughly, program)
        )
        assert one.final == pytest.approx(two.final, abs=1e-7)
        assert two.final[3:] == pytest.approx(np.zeros(3), abs=1e-12)
        assert {e.contact: e.kind for e in two.events} == {f"foot {k}": "stick" for k in range(3)}


def released(feet, loads, force, mu=0.3):
    """Return how much of a force and couple feet at rest bear, and the motion in which they give way.

    The least of ``sum_i mu N_i |v_i| / (force . motion)`` over all motions.
    """
    feet, force = np.array(feet), np.array(force)

    def ratio(xi):
        work = force @ xi
        slips = np.hypot(xi[0] - xi[2] * feet[:, 1], xi[1] + xi[2] * feet[:, 0])
        return mu * np.dot(loads, slips) / work if work > 0 else np.inf

    rng, best = np.random.default_rng(1), None
    for _ in range(6):
        found = minimize(ratio, force + 0.3 * rng.normal(size=3), method="Nelder-Mead")
        for _ in range(4):
            options = {"xatol": 1e-13, "fatol": 1e-15, "maxiter": 4000, "maxfev": 4000}
            found = minimize(ratio, found.x / np.linalg.norm(found.x), method="Nelder-Mead", options=options)
        best = found if best is None or found.fun < best.fun else best
    return best.fun, best.x / np.linalg.norm(best.x)


FOUR = [(1, 0.2), (-0.8, 0.6), (-0.4, -0.9), (0.5, -0.7)]


@pytest.mark.parametrize(
    ("feet", "loads", "force"),
    [
        (circle(), (2, 2.5, 1.5), (2, 1.2, 0.7)),
        pytest.param(FOUR, (1, 0.6, 1.4, 0.8), (0.5, -1.0, 1.5), marks=pytest.mark.long),
        ([(0.7, 0), (-0.7, 0.1)], (1, 2), (0.3, 1.0, 0.1)),
    ],
)
def test_it_gives_way_on_the_limit_surface(feet, loads, force):
    when, motion = released(feet, loads, force)
    run = moved(feet, loads, rises=force)
    assert run.events[0].t == pytest.approx(when, abs=1e-10)
    soon = run(when + 1e-3)[3:]
    assert soon / np.linalg.norm(soon) == pytest.approx(motion, abs=3e-3)


def test_what_is_not_unique_is_said(caplog):
    """The forces of the single feet are one choice of many, those that act on the body together are not."""
    warn_of_redundance.cache_clear()
    total = sum(sf.friction_force(f"foot {k}", 0) for k in range(2))
    outputs = {"low": sf.Min(total + 0.2 * sp.sin(t)), "high": sf.Max(total + 0.2 * sp.sin(t))}
    run = sf.simulate(body(circle(2), (2, 2.5), [0.2 * sp.sin(t), 0, 0.1 * t], outputs=outputs)).checked()
    assert [run["low"], run["high"]] == pytest.approx([0, 0], abs=1e-9)
    assert run.stats["events"] == 0
    assert any("one choice of many" in message for message in caplog.messages)


WORK = {
    "events": sf.Events(),
    "work": sf.Integral(v_x * t + omega),
    "turned": sf.Integral(theta),
    "spent": sf.Integral(omega**2),
}
OTHERS = {"mu": 0.3, "load": 1.0, "v_x": 0.2}
ENDS = [(0.7, 0), (-0.7, 0.1)]


@cache
def derived(n, tolerance=1e-10, names=tuple(OTHERS)):
    """Return a program of a body under forces that rise, with derivatives; of two feet the places are given by values."""
    feet = list(zip(PLACES[:n], PLACES[4 : 4 + n], strict=True))
    values = dict.fromkeys((*PLACES[:n], *PLACES[4 : 4 + n], *LOADS[:n], *RISES), 1.0) | {MU: 0.3}
    scene = body(feet, LOADS[:n], [p * t for p in RISES], horizon=2.0, values=values, outputs=WORK)
    return sf.prepare(scene, tolerance, sensitivities=names)


def rising(program, feet, loads, rises, start=NONE, **others):
    n = len(feet)
    values = dict(zip((*PLACES[:n], *PLACES[4 : 4 + n]), (*(a for a, _ in feet), *(b for _, b in feet)), strict=True))
    values |= dict(zip((*LOADS[:n], *RISES), (*loads, *rises), strict=True))
    start = dict(zip(("v_x", "v_y", "omega"), start, strict=True))
    for name, value in others.items():
        (start if name in start else values)[name] = value
    return program.run(values=values, initial=start).checked()


@pytest.mark.long(beside="test_derivatives_of_common_starts_of_two_feet_are_differences")
@pytest.mark.parametrize("n", longer([2, 3], [3]))
def test_derivatives_of_a_common_start_have_closed_forms(n):
    """A couple c t turns it from mu N r on; the integral moves with the start alone where feet are at rest before."""
    N, c, J, T = 1.0, 0.6, 0.5, 2.0
    run = rising(derived(n), circle(n, radius=0.8), (N,) * n, (0, 0, c))
    later = n * N * 0.8 / c  # of the start, for each unit of mu
    left = T - 0.3 * later
    assert run.sensitivities["mu"][2] == pytest.approx(-later * c * left**2 / (2 * J), abs=1e-8)
    assert run.sensitivities["mu"][5] == pytest.approx(-later * c * left / J, abs=1e-8)
    assert run.sensitivities["mu"][[0, 1, 3, 4]] == pytest.approx(np.zeros(4), abs=1e-8)
    of_outputs = {name: run.output_sensitivities[name]["mu"] for name in ("turned", "spent")}
    assert of_outputs["turned"] == pytest.approx(-later * c * left**3 / (6 * J), abs=1e-8)
    assert of_outputs["spent"] == pytest.approx(-later * (c * left**2 / (2 * J)) ** 2, abs=1e-8)


def assert_differences(run, names, other, size=1e-4):
    """Assert that derivatives of the final state and of an integral are central differences of tight runs."""

    def moved(name, by):
        ran = other(**{name: OTHERS[name] + by})
        return np.append(ran.final, ran["work"])

    for name in names:
        far, near = ((moved(name, h) - moved(name, -h)) / (2 * h) for h in (2 * size, size))
        slope = (4 * near - far) / 3
        mine = np.append(run.sensitivities[name], run.output_sensitivities["work"][name])
        assert mine == pytest.approx(slope, abs=1e-6 * max(1.0, np.max(np.abs(slope)))), name


@pytest.mark.one_in(2)
@pytest.mark.parametrize("start", [NONE, (0.2, 0, 0)])
def test_derivatives_of_common_starts_of_two_feet_are_differences(start):
    """Let go with a speed the body stops before the forces release it."""
    given, tight = (ENDS, (1, 2), (0.3, 1.0, 0.1), start), derived(2, 1e-12, ())
    run = rising(derived(2), *given)
    assert {(e.contact, e.kind) for e in run.events} >= {(f"foot {k}", "slip") for k in (0, 1)}
    assert ("foot 0", "stick") in {(e.contact, e.kind) for e in run.events} or not any(start)
    assert_differences(run, OTHERS if any(start) else ["mu", "load"], lambda **moved: rising(tight, *given, **moved))


SHAKEN = (1.3 * sp.sin(t) - x, sp.cos(1.3 * t) - y, 0.8 * sp.sin(1.7 * t) - 0.5 * theta)
STARTS = {
    "pushed and turned": (circle(), (2, 2.5, 1.5), (1.2 * t, 0.7 * t, 0.5 * t + 0.02 * t**2), sf.laws.coulomb(MU), 1.9),
    "a drop of friction": (circle(), (2, 2.5, 1.5), (1.2 * t, 0.7 * t, 0.5 * t), sf.laws.coulomb(MU, 0.5 * MU), 1.8),
    "a law of speed": (circle(), (2, 2.5, 1.5), (1.2 * t, 0.7 * t, 0.5 * t), sf.laws.stribeck(MU, 0.6 * MU, 0.3), 1.8),
    "stops and starts": (FOUR, (1, 0.6, 1.4, 0.8), SHAKEN, sf.laws.coulomb(MU), 4.0),
}


@pytest.mark.long(beside="test_derivatives_of_common_starts_of_two_feet_are_differences")
@pytest.mark.parametrize("which", STARTS)
def test_derivatives_of_common_starts_are_differences(which):
    feet, loads, force, law, horizon = STARTS[which]
    start = (0.2, 0.1, -0.3) if which == "stops and starts" else NONE
    names = OTHERS if any(start) else ["mu", "load"]
    outputs = {"work": sf.Integral(v_x * t + omega)}
    scene = body(feet, loads, force, law=law, start=start, horizon=horizon, outputs=outputs, values={MU: 0.3})
    run, tight = sf.prepare(scene, 1e-10, sensitivities=names).run().checked(), sf.prepare(scene, 1e-12)

    def other(**moved):
        values, initial = ({k: v for k, v in moved.items() if (k == "v_x") == first} for first in (False, True))
        return tight.run(values=values, initial=initial).checked()

    assert_differences(run, names, other)


# seeds of runs that once stood still: a body turns about a foot, about none, near one that slips little, stops on three
STOOD_STILL = (22, 26, 21, 37, 1)


@pytest.mark.long(beside="test_a_spin_ends_on_all_feet_at_once")
@pytest.mark.parametrize("seed", longer(STOOD_STILL, [22, 26, 37, 1]))
def test_the_last_forces_at_rest_are_found(seed):
    """Near the limit surface forces are well told although its curvature is tiny: the sticking ends."""
    scene = drawn_bodies(seed).scene()
    loose, run = (sf.simulate(scene, tolerance=e).checked() for e in (1e-8, 1e-10))
    assert [(e.contact, e.kind) for e in loose.events] == [(e.contact, e.kind) for e in run.events]
    assert [e.t for e in loose.events] == pytest.approx([e.t for e in run.events], abs=1e-5)
    assert run.energy_residual() < 1e-8


def follows_from_regularised_ones(seed):
    """Assert that a drawn scene is the limit of regularised ones, and the same at two tolerances."""
    drawn = drawn_bodies(seed)
    loose, run = (sf.simulate(drawn.scene(), tolerance=e).checked() for e in (1e-9, 1e-11))
    assert loose.final == pytest.approx(run.final, abs=1e-6), seed
    assert run.energy_residual() < 1e-9, seed
    errors = [np.max(np.abs(regularised(drawn, eps) - run.final)) for eps in (1e-3, 1e-4, 1e-5)]
    assert all(b < max(0.35 * a, 1e-6) for a, b in zip(errors, errors[1:], strict=False)), (seed, errors)


@pytest.mark.long(beside="test_it_gives_way_on_the_limit_surface")
@pytest.mark.parametrize("first", range(0, 200, 10))
def test_random_bodies_are_limits_of_regularised_ones(first):
    for seed in range(first, first + 10):
        follows_from_regularised_ones(seed)
