"""Feet of a body that turns: their forces at rest are not unique, the motion is.

Closed forms, the single contact of the summed load, limit surfaces by a minimisation of their own, and regularised motions.
"""

import math

import numpy as np
import pytest
import sympy as sp
from scipy.optimize import minimize

import symfric as sf
from symfric.solve.facts import warn_of_redundance
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


@pytest.mark.one_in(2)
@pytest.mark.parametrize("law", [sf.laws.coulomb(0.3, 0.25), sf.laws.coulomb(0.3)])
def test_pushed_through_the_centre_it_is_one_contact(law):
    push = [2 * sp.sin(t), 1.2 * sp.sin(t)]
    run = sf.simulate(body(circle(), (2, 2, 2), [*push, 0], law=law), tolerance=1e-12).checked()
    point = sf.Scene(
        sf.System([x, y], [v_x, v_y], sp.eye(2), push),
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


@pytest.mark.one_in(3)
@pytest.mark.parametrize("law", [None, sf.laws.coulomb(0.3, 0.25)])
@pytest.mark.parametrize("place", [0, 1, 2])
def test_a_foot_without_load_changes_nothing(place, law):
    """It slips from the first instant at which the body moves there, and no force tells it where to."""
    push, feet, loads = [1.6 * sp.sin(t), 0.9 * sp.sin(1.3 * t), 0.5 * sp.sin(0.7 * t)], circle(), [1, 1.2]
    two = sf.simulate(body(feet[:2], loads, push, law=law), tolerance=1e-11).checked()
    feet.insert(place, feet.pop())
    loads.insert(place, 0)
    three = sf.simulate(body(feet, loads, push, law=law), tolerance=1e-11).checked()
    assert three.final == pytest.approx(two.final, abs=1e-11)
    mine = [e.t for e in three.events if e.contact != f"foot {place}"]
    assert mine == pytest.approx([e.t for e in two.events], abs=1e-10)


def test_a_couple_turns_it_on_the_spot():
    """The couple of three feet on a circle is mu N r; the angle after the release is that of a couple that rises."""
    run = sf.simulate(body(circle(radius=0.8), (1, 1, 1), [0, 0, 0.6 * t], horizon=2.0), tolerance=1e-13).checked()
    start = 0.3 * 3 * 0.8 / 0.6
    assert [e.t for e in run.events] == pytest.approx([start] * 3, abs=1e-12)
    assert run.final[2] == pytest.approx(0.6 * (2.0 - start) ** 3 / (6 * 0.5), abs=1e-11)
    assert run.final[[0, 1, 3, 4]] == pytest.approx(np.zeros(4), abs=1e-12)


def test_a_spin_ends_on_all_feet_at_once():
    run = sf.simulate(body(circle(radius=0.8), (1, 1, 1), [0, 0, 0], start=(0, 0, 2)), tolerance=1e-13).checked()
    stop = 0.5 * 2 / (0.3 * 3 * 0.8)
    assert [e.t for e in run.events] == pytest.approx([stop] * 3, abs=1e-12)
    assert run.final == pytest.approx([0, 0, stop, 0, 0, 0], abs=1e-12)


def test_a_bar_turns_about_the_foot_that_carries_more():
    """A couple releases the other foot alone, at mu N L; then the bar turns about the first, which keeps its place."""
    bar = body([(-0.5, 0), (0.5, 0)], (3, 1), [0, 0, 0.3 * t], m=0.2, J=0.1, horizon=2.0)
    run = sf.simulate(bar, tolerance=1e-13).checked()
    (event,) = run.events
    assert (event.contact, event.kind) == ("foot 1", "slip")
    assert event.t == pytest.approx(1.0, abs=1e-12)
    angle = 0.3 / (6 * (0.1 + 0.2 * 0.25))
    assert run.final[2] == pytest.approx(angle, abs=1e-11)
    place = run.final[:2] - 0.5 * np.array([math.cos(angle), math.sin(angle)])
    assert place == pytest.approx([-0.5, 0], abs=1e-11)


def test_feet_come_to_rest_together_at_any_tolerance():
    """The speeds of all feet fall to zero as one; an error of the run does not tell which is the first."""
    outputs = {"events": sf.Events(), "end": sf.End()}
    scene = body(circle(), (2, 2.5, 1.5), (0.5, -0.2, 0.3), J=0.3, horizon=8.0, outputs=outputs)
    rough, fine = (sf.prepare(scene, tolerance=e) for e in (1e-8, 1e-11))
    rng = np.random.default_rng(3)
    for _ in range(15):
        start = dict(zip(("v_x", "v_y", "omega"), rng.normal(size=3), strict=True))
        one, two = (program.run(initial=start).checked() for program in (rough, fine))
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


@pytest.mark.one_in(3)
@pytest.mark.parametrize(
    ("feet", "loads", "force"),
    [
        (circle(), (2, 2.5, 1.5), (2, 1.2, 0.7)),
        ([(1, 0.2), (-0.8, 0.6), (-0.4, -0.9), (0.5, -0.7)], (1, 0.6, 1.4, 0.8), (0.5, -1.0, 1.5)),
        ([(0.7, 0), (-0.7, 0.1)], (1, 2), (0.3, 1.0, 0.1)),
    ],
)
def test_it_gives_way_on_the_limit_surface(feet, loads, force):
    when, motion = released(feet, loads, force)
    scene = body(feet, loads, [f * t for f in force], horizon=when + 1e-3)
    run = sf.simulate(scene, tolerance=1e-11).checked()
    assert run.events[0].t == pytest.approx(when, abs=1e-10)
    assert run.final[3:] / np.linalg.norm(run.final[3:]) == pytest.approx(motion, abs=3e-3)


def test_what_is_not_unique_is_said(caplog):
    """The forces of the single feet are one choice of many, those that act on the body together are not."""
    warn_of_redundance.cache_clear()
    total = sum(sf.friction_force(f"foot {k}", 0) for k in range(3))
    outputs = {"low": sf.Min(total + 0.2 * sp.sin(t)), "high": sf.Max(total + 0.2 * sp.sin(t))}
    run = sf.simulate(body(circle(), (2, 2.5, 1.5), [0.2 * sp.sin(t), 0, 0.1 * t], outputs=outputs)).checked()
    assert [run["low"], run["high"]] == pytest.approx([0, 0], abs=1e-9)
    assert run.stats["events"] == 0
    assert any("one choice of many" in message for message in caplog.messages)


def test_derivatives_of_a_common_start_have_closed_forms():
    """A couple c t turns it from mu N r on; the integral moves with the start alone where feet are at rest before."""
    N, c, J, T = 1.0, 0.6, 0.5, 2.0
    outputs = {"turned": sf.Integral(theta), "spent": sf.Integral(omega**2)}
    turned = body(circle(radius=0.8), (N, N, N), [0, 0, c * t], J=J, horizon=T, outputs=outputs)
    run = sf.simulate(turned, tolerance=1e-11, sensitivities=["mu"]).checked()
    later = 3 * N * 0.8 / c  # of the start, for each unit of mu
    left = T - 0.3 * later
    assert run.sensitivities["mu"][2] == pytest.approx(-later * c * left**2 / (2 * J), abs=1e-8)
    assert run.sensitivities["mu"][5] == pytest.approx(-later * c * left / J, abs=1e-8)
    assert run.sensitivities["mu"][[0, 1, 3, 4]] == pytest.approx(np.zeros(4), abs=1e-8)
    assert run.output_sensitivities["mu"]["turned"] == pytest.approx(-later * c * left**3 / (6 * J), abs=1e-8)
    assert run.output_sensitivities["mu"]["spent"] == pytest.approx(-later * (c * left**2 / (2 * J)) ** 2, abs=1e-8)


OTHERS = {"mu": 0.3, "load": 1.0, "v_x": 0.2}


def differences(scene, names, size=1e-4):
    """Return the derivatives of the final state and of integrals, by central differences of tight runs."""
    program = sf.prepare(scene, tolerance=1e-12)

    def run(name, by):
        moved = {name: OTHERS[name] + by}
        ran = program.run(initial=moved) if name in ("v_x",) else program.run(values=moved)
        return np.append(ran.checked().final, ran["work"])

    slopes = {}
    for name in names:
        far, near = ((run(name, h) - run(name, -h)) / (2 * h) for h in (2 * size, size))
        slopes[name] = (4 * near - far) / 3
    return slopes


FEET4 = [(1, 0.2), (-0.8, 0.6), (-0.4, -0.9), (0.5, -0.7)]
SHAKEN = (1.3 * sp.sin(t) - x, sp.cos(1.3 * t) - y, 0.8 * sp.sin(1.7 * t) - 0.5 * theta)
STARTS = {
    "pushed and turned": (circle(), (2, 2.5, 1.5), (1.2 * t, 0.7 * t, 0.5 * t + 0.02 * t**2), sf.laws.coulomb(MU), 1.9),
    "a drop of friction": (circle(), (2, 2.5, 1.5), (1.2 * t, 0.7 * t, 0.5 * t), sf.laws.coulomb(MU, 0.5 * MU), 1.8),
    "a law of speed": (circle(), (2, 2.5, 1.5), (1.2 * t, 0.7 * t, 0.5 * t), sf.laws.stribeck(MU, 0.6 * MU, 0.3), 1.8),
    "two feet": ([(0.7, 0), (-0.7, 0.1)], (1, 2), (0.3 * t, 1.0 * t, 0.1 * t), sf.laws.coulomb(MU), 1.6),
    "stops and starts": (FEET4, (1, 0.6, 1.4, 0.8), SHAKEN, sf.laws.coulomb(MU), 4.0),
}


@pytest.mark.one_in(5)
@pytest.mark.parametrize("which", STARTS)
def test_derivatives_of_common_starts_are_differences(which):
    feet, loads, force, law, horizon = STARTS[which]
    start = (0.2, 0.1, -0.3) if which == "stops and starts" else (0, 0, 0)
    names = ["mu", "load", "v_x"] if any(start) else ["mu", "load"]
    outputs = {"work": sf.Integral(v_x * t + omega)}
    scene = body(feet, loads, force, law=law, start=start, horizon=horizon, outputs=outputs, values={MU: 0.3})
    run = sf.simulate(scene, tolerance=1e-10, sensitivities=names).checked()
    for name, slope in differences(scene, names).items():
        mine = np.append(run.sensitivities[name], run.output_sensitivities[name]["work"])
        assert mine == pytest.approx(slope, abs=1e-6 * max(1.0, np.max(np.abs(slope)))), name


# seeds of runs that once stood still: a body turns about a foot, about none, near one that slips little, stops on three
STOOD_STILL = (22, 26, 21, 37, 1)


@pytest.mark.one_in(5)
@pytest.mark.parametrize("seed", STOOD_STILL)
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
